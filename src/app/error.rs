//! Everything that ends a run, and what the process exits with.

use crate::{bench, formats, gpu, terrain, world};

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
    /// More memory than was allowed.
    #[error("{0}")]
    Memory(String),
    #[error(transparent)]
    World(#[from] world::Error),
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    #[error(transparent)]
    File(#[from] formats::Error),
    #[error("{0}")]
    Bench(String),
    /// Vulkan was used wrongly.
    #[error("the Vulkan validation layer complains:\n{}", .0.join("\n"))]
    Validation(Vec<String>),
    #[error("interrupted; {}", match written {
        0 => "no file was written".into(),
        written => format!("{written} files had been written, and are whole"),
    })]
    Interrupted { written: usize },
}

impl Error {
    /// 1 other · 2 usage · 3 something the user wrote is wrong · 4 no such device, no driver · 5 device lost · 6 memory ·
    /// 7 input and output · 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            Error::Missing(_) | Error::Ground { .. } => 3,
            Error::Memory(_) => 6,
            Error::World(error) => error.exit_code(),
            Error::Gpu(error) => match error {
                gpu::Error::Loader { .. } | gpu::Error::NoDevice(_) | gpu::Error::Unsupported(_) => 4,
                gpu::Error::Lost { .. } => 5,
                gpu::Error::MemoryLimit { .. } | gpu::Error::OutOfMemory { .. } => 6,
                gpu::Error::Vk { .. } => 1,
            },
            Error::File(_) => 7,
            Error::Bench(_) | Error::Validation(_) => 1,
            Error::Interrupted { .. } => 130,
        }
    }
}

impl From<bench::Error> for Error {
    fn from(error: bench::Error) -> Error {
        match error {
            bench::Error::Gpu(error) => Error::Gpu(error),
            bench::Error::World(error) => Error::World(error),
            bench::Error::NotCovered => Error::Bench(error.to_string()),
        }
    }
}
