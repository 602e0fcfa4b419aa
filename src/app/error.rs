//! Everything that ends a run, and what the process exits with.

use crate::plants::planting;
use crate::{bench, formats, gpu, terrain, world};
use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The arguments don't go together.
    #[error("{0}")]
    Usage(String),
    /// What was asked for is not in the world.
    #[error("{0}")]
    Missing(String),
    /// The world asks for ground that is none.
    #[error(
        "`terrain.layers` make ground from {lowest} m to {highest} m: it must lie within {} m of the datum; give layers \
         less height, and layers that multiply a smaller `amplitude` or `offset`",
        terrain::FARTHEST_GROUND
    )]
    Ground { lowest: f32, highest: f32 },
    #[error(transparent)]
    Planting(#[from] planting::Error),
    /// More memory than was allowed.
    #[error("{0}")]
    Memory(String),
    #[error(transparent)]
    World(#[from] world::Error),
    #[error("the cache is no use: {0}")]
    Cache(#[from] world::cache::Error),
    #[error("{error}{}", advice(.0), error = .0)]
    Gpu(#[from] gpu::Error),
    #[error(transparent)]
    File(#[from] formats::Error),
    #[error("{0}")]
    Bench(String),
    /// A picture keeps its noise.
    #[error("{0}")]
    Denoiser(String),
    /// There is no window.
    #[cfg(feature = "viewer")]
    #[error("no window: {0}")]
    Window(String),
    /// Two pictures are not the same.
    #[error("{0}")]
    Differs(String),
    /// A checkpoint belongs to another picture.
    #[error(
        "{} is the checkpoint of another picture: {}; make that one, or this one without --resume, which replaces it",
        path.display(), differences.join("; ")
    )]
    OtherPicture { path: PathBuf, differences: Vec<String> },
    /// Shards that are not the parts of one picture.
    #[error("these shards don't make a picture: {0}")]
    Shards(String),
    /// Vulkan was used wrongly.
    #[error("the Vulkan validation layer complains:\n{}", .0.join("\n"))]
    Validation(Vec<String>),
    #[error("interrupted; {}{}", match written {
        0 => "no file was written".into(),
        1 => "one file had been written, and is whole".into(),
        written => format!("{written} files had been written, and are whole"),
    }, match kept {
        Some(Kept::Land) => "; the land so far is kept, and the same command goes on from there".into(),
        Some(Kept::Samples(path)) => {
            format!("; the samples so far are in {}, and the same command with --resume goes on from there", path.display())
        }
        None => String::new(),
    })]
    Interrupted { written: usize, kept: Option<Kept> },
}

/// What an interrupted run leaves to go on from.
#[derive(Clone, Debug)]
pub enum Kept {
    /// The state of an unfinished simulation is in the cache.
    Land,
    /// What has been traced is in this checkpoint.
    Samples(PathBuf),
}

/// What the process exits with, and why.
pub const EXIT_CODES: &[(u8, &str)] = &[
    (0, "all went well"),
    (1, "something else failed; also shards that don't fit together"),
    (2, "the arguments make no sense"),
    (3, "something in the world file or an option is wrong"),
    (4, "no such device, or no driver"),
    (5, "the device was lost"),
    (6, "not enough memory"),
    (7, "a file can't be read or written, or is damaged"),
    (9, "`compare` found a difference"),
    (130, "interrupted; files that had been written are whole"),
];

impl Error {
    /// One of [`EXIT_CODES`].
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            Error::Missing(_) | Error::Ground { .. } | Error::Planting(_) => 3,
            Error::Memory(_) => 6,
            Error::World(error) => error.exit_code(),
            Error::Gpu(error) => match error {
                gpu::Error::Loader { .. } | gpu::Error::NoDevice(_) | gpu::Error::Unsupported(_) => 4,
                gpu::Error::Lost { .. } => 5,
                gpu::Error::MemoryLimit { .. } | gpu::Error::OutOfMemory { .. } => 6,
                gpu::Error::Vk { .. } => 1,
            },
            Error::File(_) | Error::Cache(_) => 7,
            // Another picture was asked for than the file is of: that's no damage.
            Error::Bench(_) | Error::Validation(_) | Error::OtherPicture { .. } | Error::Shards(_) => 1,
            Error::Denoiser(_) => 1,
            #[cfg(feature = "viewer")]
            Error::Window(_) => 1,
            Error::Differs(_) => 9,
            Error::Interrupted { .. } => 130,
        }
    }
}

impl From<bench::Error> for Error {
    fn from(error: bench::Error) -> Error {
        match error {
            bench::Error::Gpu(error) if out_of_memory(&error) => {
                Error::Memory(format!("{error}; give --cells less, or raise --memory-limit"))
            }
            bench::Error::Gpu(error) => Error::Gpu(error),
            bench::Error::World(error) => Error::World(error),
            bench::Error::Stopped => Error::Interrupted { written: 0, kept: None },
            bench::Error::Planting(error) => Error::Planting(error),
            bench::Error::Zoom(error) => error.into(),
            bench::Error::NotCovered | bench::Error::Document(_) => Error::Bench(error.to_string()),
        }
    }
}

/// What each verb has its own advice for.
fn out_of_memory(error: &gpu::Error) -> bool {
    matches!(error, gpu::Error::MemoryLimit { .. } | gpu::Error::OutOfMemory { .. })
}

fn advice(error: &gpu::Error) -> &'static str {
    if out_of_memory(error) {
        "; lower terrain.cells or the picture's size, or raise --memory-limit"
    } else {
        ""
    }
}
