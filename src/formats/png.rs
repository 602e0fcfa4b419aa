//! PNG: 8-bit sRGB pictures, and grey height maps of 16 bits.

use super::file::{self, Written};
use super::{Error, check_size, open};
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, SrgbRenderingIntent};
use std::io::{self, BufReader, Write};
use std::path::Path;

/// Writes a picture of `size` = [width, height] pixels, three bytes each, sRGB-encoded, first row first.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write_picture(path: &Path, size: [u32; 2], pixels: &[u8]) -> Result<Written, Error> {
    file::write(path, |writer| {
        let mut encoder = Encoder::new(writer, size[0], size[1]);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        encoder.set_compression(Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(pixels)?;
        Ok(writer.finish()?)
    })
}

/// Writes `size` = [width, height] values a channel as 16-bit integers, first row first: `range` maps to 0…65535. One
/// channel makes a grey file, three and four make RGB and RGBA.
///
/// # Errors
/// Those of [`file::write()`], and for any other number of channels.
pub fn write_16(
    path: &Path,
    size: [u32; 2],
    channels: &[Vec<f32>],
    range: [f32; 2],
) -> Result<Written, Error> {
    let quantise = |value: f32| {
        let [min, max] = range.map(f64::from);
        let share = if max > min { (f64::from(value) - min) / (max - min) } else { 0.0 };
        (share.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16
    };
    let color = match channels.len() {
        1 => ColorType::Grayscale,
        3 => ColorType::Rgb,
        4 => ColorType::Rgba,
        _ => {
            return Err(Error::Target {
                path: path.into(),
                reason: "a PNG holds one, three or four channels",
            });
        }
    };
    file::write(path, |writer| {
        let mut encoder = Encoder::new(writer, size[0], size[1]);
        encoder.set_color(color);
        encoder.set_depth(BitDepth::Sixteen);
        encoder.set_compression(Compression::Balanced);
        let mut writer = encoder.write_header()?;
        let mut rows = writer.stream_writer()?;
        let mut bytes = Vec::new();
        for row in 0..size[1] as usize {
            bytes.clear();
            for index in row * size[0] as usize..(row + 1) * size[0] as usize {
                bytes.extend(channels.iter().flat_map(|values| quantise(values[index]).to_be_bytes()));
            }
            rows.write_all(&bytes)?;
        }
        rows.finish()?;
        Ok(writer.finish()?)
    })
}

/// Reads a grey PNG of 8 or 16 bits as (width, height, values), the values as shares of the largest integer.
///
/// # Errors
/// When the file can't be read, is damaged, too large, or isn't grey.
pub fn read_grey(path: &Path) -> Result<(u32, u32, Vec<f32>), Error> {
    let corrupt = |error: png::DecodingError| match error {
        png::DecodingError::IoError(source) if source.kind() != io::ErrorKind::UnexpectedEof => {
            Error::Read { path: path.into(), source }
        }
        error => Error::Corrupt { path: path.into(), format: "PNG", reason: error.to_string() },
    };
    let (file, file_bytes) = open(path)?;
    // Text and colour profiles may take little; the rows are counted below.
    let mut decoder = Decoder::new_with_limits(BufReader::new(file), Limits { bytes: 1 << 20 });
    let info = decoder.read_header_info().map_err(corrupt)?;
    let (width, height) = (info.width, info.height);
    let sample_bytes = match (info.color_type, info.bit_depth) {
        (ColorType::Grayscale, BitDepth::Eight) => 1,
        (ColorType::Grayscale, BitDepth::Sixteen) => 2,
        (color, depth) => {
            let reason = format!(
                "it holds {color:?} of {} bits; save it as greyscale of 16 bits (or 8) without alpha",
                depth as u8
            );
            return Err(Error::Unsuitable { path: path.into(), reason });
        }
    };
    check_size(path, "PNG", [width.into(), height.into()], sample_bytes, file_bytes)?;
    decoder.set_limits(Limits { bytes: (1 << 20) + 8 * width as usize });

    let mut reader = decoder.read_info().map_err(corrupt)?;
    let mut bytes = vec![0; (u64::from(width) * u64::from(height) * sample_bytes) as usize];
    reader.next_frame(&mut bytes).map_err(corrupt)?;
    let values = match sample_bytes {
        1 => bytes.iter().map(|&byte| f32::from(byte) / f32::from(u8::MAX)).collect(),
        _ => bytes
            .as_chunks::<2>()
            .0
            .iter()
            .map(|&pair| f32::from(u16::from_be_bytes(pair)) / f32::from(u16::MAX))
            .collect(),
    };
    Ok((width, height, values))
}
