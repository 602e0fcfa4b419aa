//! Radiance's HDR (Ward 1991, "Real Pixels"): pictures of eight bits a channel with a common exponent.

use super::{Error, check_picture_size, collect, open};
use image::{ImageDecoder, codecs::hdr::HdrDecoder, error::ImageError};
use std::io::BufReader;
use std::path::Path;

/// Reads a picture; gives its width and height, too.
///
/// # Errors
/// When the file can't be read, is damaged or too large.
pub fn read_picture(path: &Path) -> Result<([u32; 2], Vec<[f32; 3]>), Error> {
    let failed = |error: ImageError| match error {
        ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            Error::Read { path: path.into(), source }
        }
        error => Error::Corrupt { path: path.into(), format: "Radiance HDR", reason: error.to_string() },
    };
    let (file, bytes) = open(path)?;
    let decoder = HdrDecoder::new(BufReader::new(file)).map_err(failed)?;
    let (width, height) = decoder.dimensions();
    // Runs are of at most 127 values, in two bytes.
    check_picture_size(path, "Radiance HDR", [width, height], bytes)?;
    let mut pixels = collect(path, [width.into(), height.into()])?;
    pixels.resize(width as usize * height as usize, [0.0; 3]);
    decoder.read_image(bytemuck::cast_slice_mut(&mut pixels)).map_err(failed)?;
    Ok(([width, height], pixels))
}
