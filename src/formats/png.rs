//! PNG: 8-bit sRGB pictures, and rasters as integers of 8 or 16 bits.

use super::file::{self, Written};
use super::{Error, Window, check_size, collect, open, share};
use crate::core::color::linear_from_srgb;
use png::{BitDepth, ColorType, Compression, Decoder, Encoder, Limits, SrgbRenderingIntent, Transformations};
use std::io::{self, BufReader, Write};
use std::path::Path;

/// Bits of an integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    Eight,
    Sixteen,
}

/// Writes a picture of `size` = [width, height] pixels, three bytes each, sRGB-encoded, first row first.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write_picture(path: &Path, size: [u32; 2], pixels: &[u8]) -> Result<Written, Error> {
    file::write(path, |writer| picture(writer, size, pixels))
}

/// Width and height, and three bytes a pixel, of a picture that comes with the program. `None` for what is none.
#[cfg(feature = "viewer")]
pub fn read_small(bytes: &[u8]) -> Option<([usize; 2], Vec<u8>)> {
    let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().ok()?;
    let mut pixels = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut pixels).ok()?;
    pixels.truncate(info.buffer_size());
    let is_rgb = (info.color_type, info.bit_depth) == (ColorType::Rgb, png::BitDepth::Eight);
    is_rgb.then_some(([info.width as usize, info.height as usize], pixels))
}

/// The bytes of the file that [`write_picture`] writes, for a place inside another file.
///
/// # Errors
/// When there are not as many pixels as the size says.
pub fn encode_picture(size: [u32; 2], pixels: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    picture(&mut bytes, size, pixels)?;
    Ok(bytes)
}

fn picture(writer: impl Write, size: [u32; 2], pixels: &[u8]) -> io::Result<()> {
    let mut encoder = Encoder::new(writer, size[0], size[1]);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Balanced);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    Ok(writer.finish()?)
}

/// Writes integers of that many bits; `range` maps to all of them. One channel makes a grey file, three and four make RGB
/// and RGBA.
///
/// # Errors
/// Those of [`file::write()`], and for any other number of channels.
pub fn write_integers(path: &Path, window: Window, depth: Depth, range: [f32; 2]) -> Result<Written, Error> {
    let color = match window.channels() {
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
    let [width, height] = window.size();
    file::write(path, |writer| {
        let mut encoder = Encoder::new(writer, width, height);
        encoder.set_color(color);
        encoder.set_depth(match depth {
            Depth::Eight => BitDepth::Eight,
            Depth::Sixteen => BitDepth::Sixteen,
        });
        encoder.set_compression(Compression::Balanced);
        let mut writer = encoder.write_header()?;
        let mut rows = writer.stream_writer()?;
        let mut bytes = Vec::new();
        for row in window.rows() {
            bytes.clear();
            for &value in row {
                let share = share(value, range);
                match depth {
                    Depth::Eight => bytes.push((share * f64::from(u8::MAX)).round() as u8),
                    Depth::Sixteen => {
                        bytes.extend(((share * f64::from(u16::MAX)).round() as u16).to_be_bytes());
                    }
                }
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
    let corrupt = |error| corrupt(path, error);
    let (file, file_bytes) = open(path)?;
    // Text and colour profiles may take little; the rows are counted below.
    let mut decoder = Decoder::new_with_limits(BufReader::new(file), Limits { bytes: 1 << 20 });
    let info = decoder.read_header_info().map_err(corrupt)?;
    let (width, height, interlaced) = (info.width, info.height, info.interlaced);
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
    if interlaced {
        let reason = "it is interlaced; save it without".into();
        return Err(Error::Unsuitable { path: path.into(), reason });
    }
    let mut values = collect(path, [width.into(), height.into()])?;
    while let Some(row) = reader.next_row().map_err(corrupt)? {
        let bytes = row.data();
        match sample_bytes {
            1 => values.extend(bytes.iter().map(|&byte| f32::from(byte) / f32::from(u8::MAX))),
            _ => values.extend(
                bytes
                    .as_chunks::<2>()
                    .0
                    .iter()
                    .map(|&pair| f32::from(u16::from_be_bytes(pair)) / f32::from(u16::MAX)),
            ),
        }
    }
    Ok((width, height, values))
}

/// Width and height of a picture, and the names of its channels: Y, or R, G and B, and A if it has one.
///
/// # Errors
/// When the file can't be read, is damaged or too large.
pub fn channels(path: &Path) -> Result<([u32; 2], Vec<String>), Error> {
    let reader = open_picture(path)?;
    let info = reader.info();
    let names = names(reader.output_color_type().0).iter().map(|name| name.to_string());
    Ok(([info.width, info.height], names.collect()))
}

/// Values of the channels of these names as shares of the largest integer, row by row from the top.
///
/// # Errors
/// When the file can't be read, is damaged, too large, or has no such channel.
pub fn read_channels(path: &Path, wanted: &[String]) -> Result<Vec<Vec<f32>>, Error> {
    let mut reader = open_picture(path)?;
    let (color, depth) = reader.output_color_type();
    let names = names(color);
    let place = |name: &String| {
        let missing = || Error::NoPicture { path: path.into(), reason: format!("it has no channel {name}") };
        names.iter().position(|known| known == name).ok_or_else(missing)
    };
    let places = wanted.iter().map(place).collect::<Result<Vec<usize>, Error>>()?;
    let size = [reader.info().width.into(), reader.info().height.into()];
    let mut planes = places.iter().map(|_| collect(path, size)).collect::<Result<Vec<_>, _>>()?;
    while let Some(row) = reader.next_row().map_err(|error| corrupt(path, error))? {
        for (plane, &place) in planes.iter_mut().zip(&places) {
            let bytes = row.data();
            match depth {
                BitDepth::Sixteen => {
                    let samples = bytes.as_chunks::<2>().0.iter().skip(place).step_by(names.len());
                    plane.extend(
                        samples.map(|&pair| f32::from(u16::from_be_bytes(pair)) / f32::from(u16::MAX)),
                    );
                }
                _ => {
                    let samples = bytes.iter().skip(place).step_by(names.len());
                    plane.extend(samples.map(|&byte| f32::from(byte) / f32::from(u8::MAX)));
                }
            }
        }
    }
    Ok(planes)
}

/// A picture of any kind, unpacked to 8 or 16 bits a sample.
fn open_picture(path: &Path) -> Result<png::Reader<BufReader<std::fs::File>>, Error> {
    let (file, file_bytes) = open(path)?;
    let mut decoder = Decoder::new_with_limits(BufReader::new(file), Limits { bytes: 1 << 20 });
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(|error| corrupt(path, error))?;
    let (width, height, interlaced) = (info.width, info.height, info.interlaced);
    check_size(path, "PNG", [width.into(), height.into()], 1, file_bytes)?;
    decoder.set_limits(Limits { bytes: (1 << 20) + 32 * width as usize });
    if interlaced {
        let reason = "it is interlaced; save it without".into();
        return Err(Error::NoPicture { path: path.into(), reason });
    }
    decoder.read_info().map_err(|error| corrupt(path, error))
}

fn names(color: ColorType) -> &'static [&'static str] {
    match color {
        ColorType::Grayscale => &["Y"],
        ColorType::GrayscaleAlpha => &["Y", "A"],
        ColorType::Rgba => &["R", "G", "B", "A"],
        ColorType::Rgb | ColorType::Indexed => &["R", "G", "B"],
    }
}

fn corrupt(path: &Path, error: png::DecodingError) -> Error {
    match error {
        png::DecodingError::IoError(source) if source.kind() != io::ErrorKind::UnexpectedEof => {
            Error::Read { path: path.into(), source }
        }
        error => Error::Corrupt { path: path.into(), format: "PNG", reason: error.to_string() },
    }
}

/// The mean colour of a PNG in sRGB, linear Rec.709, each pixel as much as it covers; `None` if it can't be read, or has more
/// pixels than are left in `most`, which are counted.
pub fn mean_color(bytes: &[u8], most: &mut u64) -> Option<[f32; 3]> {
    let mut decoder = Decoder::new_with_limits(io::Cursor::new(bytes), Limits { bytes: 1 << 20 });
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let info = decoder.read_header_info().ok()?;
    let (width, height) = (info.width, info.height);
    *most = most.checked_sub(u64::from(width) * u64::from(height))?;
    decoder.set_limits(Limits { bytes: (1 << 20) + 32 * width as usize });
    let mut reader = decoder.read_info().ok()?;
    let channels = reader.output_color_type().0.samples();
    let linear: [f64; 256] = std::array::from_fn(|byte| f64::from(linear_from_srgb(byte as f32 / 255.0)));
    let (mut sum, mut covered) = ([0.0; 3], 0.0);
    while let Some(row) = reader.next_row().ok()? {
        for pixel in row.data().chunks_exact(channels) {
            let (color, alpha) = match *pixel {
                [grey] => ([grey; 3], 255),
                [grey, alpha] => ([grey; 3], alpha),
                [red, green, blue] => ([red, green, blue], 255),
                [red, green, blue, alpha, ..] => ([red, green, blue], alpha),
                [] => continue,
            };
            let cover = f64::from(alpha) / 255.0;
            sum = std::array::from_fn(|channel| sum[channel] + cover * linear[usize::from(color[channel])]);
            covered += cover;
        }
    }
    (covered > 0.0).then(|| sum.map(|sum| (sum / covered) as f32))
}
