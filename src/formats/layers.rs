//! Pictures as named channels of numbers, read a few at a time: a large one need not be in memory whole.

use super::{Error, Scale, exr, extension, png};
use std::path::{Path, PathBuf};

/// A picture with named channels.
pub struct Layers {
    path: PathBuf,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Of the channels, as `albedo.R`, sorted.
    pub names: Vec<String>,
    /// Whether its numbers are encoded shares of white (PNG) or the quantities themselves (EXR).
    pub scale: Scale,
}

impl Layers {
    /// Looks at what is in a PNG or EXR.
    ///
    /// # Errors
    /// When the file can't be read, is damaged, too large, or of another kind.
    pub fn open(path: &Path) -> Result<Layers, Error> {
        let (size, mut names, scale) = match extension(path).as_str() {
            "png" => {
                let (size, names) = png::channels(path)?;
                (size, names, Scale::Share)
            }
            "exr" => {
                let (size, names) = exr::channels(path)?;
                (size, names, Scale::Absolute)
            }
            _ => {
                let reason = "its name must end in .png or .exr".into();
                return Err(Error::NoPicture { path: path.into(), reason });
            }
        };
        names.sort();
        Ok(Layers { path: path.into(), size, names, scale })
    }

    /// Values of these channels, row by row from the top; not a number where the file holds none.
    ///
    /// # Errors
    /// When the file can't be read or is damaged.
    pub fn read(&self, names: &[String]) -> Result<Vec<Vec<f32>>, Error> {
        match self.scale {
            Scale::Share => png::read_channels(&self.path, names),
            Scale::Absolute => exr::read_channels(&self.path, names),
        }
    }
}
