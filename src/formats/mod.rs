//! Bytes in and out: pictures, rasters of the land and what is said beside them. One file a format, reading and writing.
//! Sizes are checked before memory is taken, and a file is written whole or not at all.

pub mod exr;
pub mod file;
pub mod gltf;
pub mod layers;
pub mod model;
pub mod obj;
pub mod ply;
pub mod png;
pub mod raw;
pub mod sealed;
pub mod sidecar;
pub mod tiff;
mod window;

pub use window::{FirstRow, Window};

use raw::ByteOrder;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Longest side of an image that is read, in samples.
pub const MAX_SIDE: u32 = 16_384;

/// Most memory that the values of one raster take, bytes.
const MAX_BYTES: u64 = 480 << 20;

/// Why a file could not be read or written. Every message names the file and says what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("cannot read {}: {source}{}", path.display(), reading_advice(source))]
    Read { path: PathBuf, source: io::Error },

    #[error("cannot read {}: it is a pipe, a socket or a device; name a regular file", path.display())]
    NoFile { path: PathBuf },

    #[error(
        "{} is taken for the sidecar of {} and is none of terrane (line {line}, column {column}); rename it, or export \
         the map again",
        sidecar::path(map).display(), map.display()
    )]
    ForeignSidecar { map: PathBuf, line: usize, column: usize },

    #[error("cannot write {}: {source}{}", path.display(), writing_advice(source))]
    Write { path: PathBuf, source: io::Error },

    #[error("cannot write {}: {reason}", path.display())]
    Target { path: PathBuf, reason: &'static str },

    #[error("{} is not a readable {format} file: {reason}; write it again with the program that made it", path.display())]
    Corrupt { path: PathBuf, format: &'static str, reason: String },

    #[error("{} can't be used as a map: {reason}", path.display())]
    Unsuitable { path: PathBuf, reason: String },

    #[error("{} can't be read as a picture: {reason}", path.display())]
    NoPicture { path: PathBuf, reason: String },

    #[error("{} can't be used as a model: {reason}", path.display())]
    NoModel { path: PathBuf, reason: String },

    #[error("{} can't be read: {reason}", path.display())]
    LargeModel { path: PathBuf, reason: String },

    #[error(
        "{} is {width} × {height}; at most {MAX_SIDE} samples a side and {} in all can be read: scale it down first",
        path.display(), MAX_BYTES / 4
    )]
    TooLarge { path: PathBuf, width: u64, height: u64 },

    #[error(
        "{} holds shares from 0 to 1 and nothing says which heights they stand for; \
         give `min` and `max` in metres, or put its sidecar {} beside it",
        path.display(), sidecar::path(path).display()
    )]
    NoRange { path: PathBuf },
}

/// A raster of numbers as a file holds them.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Where it was read from.
    pub path: PathBuf,
    /// Samples along a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row-major, the north edge first; all finite.
    pub values: Vec<f32>,
    pub scale: Scale,
    /// Least and greatest height that the sidecar names, in metres.
    pub range: Option<[f32; 2]>,
    /// Length of one side of the land that the sidecar names, metres.
    pub extent: Option<f32>,
    /// Which part of that land the file is; all of it without.
    pub tile: Option<sidecar::Tile>,
}

/// What the numbers of a map mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Shares of a range: 0 is its lower end, 1 its upper one (the integers of a PNG or RAW).
    Share,
    /// The quantity itself (the floats of an EXR or TIFF).
    Absolute,
}

impl Map {
    /// The values in metres. `range` names the heights that the ends of the scale stand for; without it the
    /// sidecar's count, and an EXR or TIFF of floats holds metres already. Stretched to a `range`, these have their
    /// least value at the range's start and their greatest at its end.
    ///
    /// # Errors
    /// [`Error::NoRange`] when nothing says what shares stand for.
    pub fn into_metres(mut self, range: Option<[f32; 2]>) -> Result<Self, Error> {
        let (from, to) = match (self.scale, range) {
            (Scale::Absolute, None) => return Ok(self),
            (Scale::Absolute, Some(range)) => (extremes(&self.values), range),
            (Scale::Share, range) => {
                let Some(range) = range.or(self.range) else {
                    return Err(Error::NoRange { path: self.path });
                };
                ([0.0, 1.0], range)
            }
        };
        let span = f64::from(from[1]) - f64::from(from[0]);
        for value in &mut self.values {
            let share = if span > 0.0 { (f64::from(*value) - f64::from(from[0])) / span } else { 0.0 };
            *value = (f64::from(to[0]) + share * (f64::from(to[1]) - f64::from(to[0]))) as f32;
        }
        self.scale = Scale::Absolute;
        Ok(self)
    }
}

/// What a file doesn't say of itself; `None` is what its sidecar says, and without one the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hints {
    /// Of a RAW file.
    pub byte_order: Option<ByteOrder>,
    pub first_row: Option<FirstRow>,
}

/// Reads one channel of numbers from a grey PNG (8 or 16 bits), an EXR, a TIFF or a RAW file, and the range in its
/// sidecar.
///
/// # Errors
/// When the file can't be read, is damaged, too large, or holds something other than one channel of finite numbers.
pub fn read_map(path: &Path, hints: Hints) -> Result<Map, Error> {
    let notes = sidecar::read(path)?;
    let of_scale = |(width, height, values), scale| (width, height, values, scale);
    let (width, height, mut values, scale) = match extension(path).as_str() {
        "png" => of_scale(png::read_grey(path)?, Scale::Share),
        "exr" => of_scale(exr::read_channel(path)?, Scale::Absolute),
        "tif" | "tiff" => tiff::read(path)?,
        "raw" | "r16" => {
            let order = hints.byte_order.or(notes.byte_order).unwrap_or_default();
            of_scale(raw::read(path, notes.samples, order)?, Scale::Share)
        }
        _ => {
            let reason = "its name must end in .png, .exr, .tif, .tiff, .raw or .r16".to_string();
            return Err(Error::Unsuitable { path: path.into(), reason });
        }
    };
    if hints.first_row.or(notes.first_row) == Some(FirstRow::South) {
        turn_over(&mut values, width as usize);
    }
    let sidecar::Notes { range, extent, tile, .. } = notes;
    Ok(Map { path: path.into(), width, height, values, scale, range, extent, tile })
}

/// Least and greatest of the values; zeros where there are none.
pub fn extremes(values: &[f32]) -> [f32; 2] {
    let (Some(&first), rest) = (values.first(), values) else { return [0.0; 2] };
    rest.iter().fold([first; 2], |[min, max], &value| [min.min(value), max.max(value)])
}

/// The part of a file's name after its last dot, in small letters; empty without one.
pub fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Where `value` stands in a range, from 0 to 1.
fn share(value: f32, range: [f32; 2]) -> f64 {
    let [min, max] = range.map(f64::from);
    let share = if max > min { (f64::from(value) - min) / (max - min) } else { 0.0 };
    share.clamp(0.0, 1.0)
}

/// Room for the values of a map, if there is that much memory.
fn collect(path: &Path, [width, height]: [u64; 2]) -> Result<Vec<f32>, Error> {
    let mut values = Vec::new();
    match values.try_reserve_exact((width * height) as usize) {
        Ok(()) => Ok(values),
        Err(_) => Err(Error::TooLarge { path: path.into(), width, height }),
    }
}

/// Reverses the order of the rows.
fn turn_over(values: &mut [f32], width: usize) {
    let mut rows = values.chunks_exact_mut(width);
    while let (Some(first), Some(last)) = (rows.next(), rows.next_back()) {
        first.swap_with_slice(last);
    }
}

/// Opens a file that is to be read, together with its length in bytes. What else bears a name is refused before:
/// opening a pipe waits for somebody to write into it, opening a directory succeeds and only reading it fails.
fn open(path: &Path) -> Result<(std::fs::File, u64), Error> {
    let failed = |source| Error::Read { path: path.into(), source };
    let kind = std::fs::metadata(path).map_err(failed)?.file_type();
    if kind.is_dir() {
        return Err(failed(io::ErrorKind::IsADirectory.into()));
    }
    if !kind.is_file() {
        return Err(Error::NoFile { path: path.into() });
    }
    let file = std::fs::File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    Ok((file, length))
}

/// Reads a whole file. Of one that is longer than `most` bytes come `most + 1`, which is enough to refuse it.
///
/// # Errors
/// When it can't be read, or is no regular file.
pub fn read_bytes(path: &Path, most: usize) -> Result<Vec<u8>, Error> {
    let (file, _) = open(path)?;
    let mut bytes = Vec::new();
    let read = file.take(most as u64 + 1).read_to_end(&mut bytes);
    read.map_err(|source| Error::Read { path: path.into(), source })?;
    Ok(bytes)
}

/// Refuses an image whose header asks for more than may be read, or for more than the file can hold: a forged header
/// costs no memory.
fn check_size(
    path: &Path,
    format: &'static str,
    size: [u64; 2],
    sample_bytes: u64,
    file_bytes: u64,
) -> Result<(), Error> {
    /// No compression shrinks data more than this (deflate 1032 times, LZW some 2700).
    const BEST_COMPRESSION: u64 = 4096;

    let [width, height] = size;
    let most = u64::from(MAX_SIDE);
    if width > most || height > most || width * height > MAX_BYTES / 4 {
        return Err(Error::TooLarge { path: path.into(), width, height });
    }
    if width * height * sample_bytes > file_bytes.saturating_mul(BEST_COMPRESSION) {
        let reason =
            format!("its header promises {width} × {height} samples and {file_bytes} bytes can't hold them");
        return Err(Error::Corrupt { path: path.into(), format, reason });
    }
    Ok(())
}

fn reading_advice(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::NotFound => "; check the spelling of the path",
        io::ErrorKind::PermissionDenied => "; check who may read it",
        io::ErrorKind::IsADirectory => "; name a file in it",
        _ => "",
    }
}

fn writing_advice(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
            "; make its folder first, or choose another with -o"
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "; choose a folder you may write to with -o"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            "; free some space, or choose another folder with -o"
        }
        _ => "",
    }
}
