//! OpenEXR: scene-linear pictures, and layers of the land as named channels, all in 32-bit floats.

use super::file::{self, Written};
use super::{Error, check_size, collect, open};
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{Chromaticities, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{Blocks, Compression, WritableImage, f16};
use std::io::{self, BufReader};
use std::path::Path;

/// Channels that a height map is looked for in, best first; a file with a single channel needs none of these names.
const MAP_CHANNELS: [&str; 4] = ["height", "Y", "Z", "R"];

/// Writes a picture of `size` = [width, height] pixels in linear Rec.709, first row first, and says that the value 1
/// stands for `white_luminance` cd/m².
///
/// # Errors
/// Those of [`file::write()`].
pub fn write_picture(
    path: &Path,
    size: [u32; 2],
    pixels: &[[f32; 3]],
    white_luminance: f32,
) -> Result<Written, Error> {
    let width = size[0] as usize;
    let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
        let [red, green, blue] = pixels[y * width + x];
        (red, green, blue)
    });
    let attributes = LayerAttributes { white_luminance: Some(white_luminance), ..LayerAttributes::default() };
    let mut image = Image::from_layer(Layer::new(extent(size), attributes, lossless(), channels));
    image.attributes.chromaticities = Some(REC_709);
    file::write(path, |writer| image.write().to_buffered(writer).map_err(plain))
}

/// A picture with layers of what it shows, scene-linear.
pub struct Layered {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// What the value 1 of R, G and B stands for, cd/m².
    pub white_luminance: f32,
    /// What it is a picture of and how it was made: no times, no names of machines.
    pub comments: String,
    /// Names as `albedo.R`, and values row by row from the top.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// Writes a picture with layers, in 32-bit floats, or in 16-bit ones if `half`: then the second number is how many values
/// were too large, and are as large as they can be.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write_layered(path: &Path, picture: Layered, half: bool) -> Result<(Written, u64), Error> {
    let Layered { size, white_luminance, comments, channels } = picture;
    let mut clamped = 0;
    let channels = channels.into_iter().map(|(name, values)| {
        let samples =
            if half { FlatSamples::F16(halved(&values, &mut clamped)) } else { FlatSamples::F32(values) };
        AnyChannel::new(name.as_str(), samples)
    });
    let channels = AnyChannels::sort(channels.collect());
    let attributes = LayerAttributes {
        white_luminance: Some(white_luminance),
        software_name: Text::new_or_none(concat!("terrane ", env!("CARGO_PKG_VERSION"))),
        // The order of attributes that the format does not know is not kept, so that all of ours are one.
        comments: Text::new_or_none(&comments),
        ..LayerAttributes::default()
    };
    let mut image = Image::from_layer(Layer::new(extent(size), attributes, lossless(), channels));
    image.attributes.chromaticities = Some(REC_709);
    let written = file::write(path, |writer| image.write().to_buffered(writer).map_err(plain))?;
    Ok((written, clamped))
}

fn halved(values: &[f32], clamped: &mut u64) -> Vec<f16> {
    let half = |value: &f32| {
        let most = f16::MAX.to_f32();
        *clamped += u64::from(value.abs() > most);
        f16::from_f32(value.clamp(-most, most))
    };
    values.iter().map(half).collect()
}

/// Writes rasters of `size` = [width, height] values, first row first, as channels of the given names.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write_channels(
    path: &Path,
    size: [u32; 2],
    channels: Vec<(String, Vec<f32>)>,
) -> Result<Written, Error> {
    let channels = channels
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values)))
        .collect();
    let attributes = ImageAttributes::with_size(extent(size));
    let layer = Layer::new(extent(size), LayerAttributes::default(), lossless(), AnyChannels::sort(channels));
    let image = Image { attributes, layer_data: layer };
    file::write(path, |writer| image.write().to_buffered(writer).map_err(plain))
}

/// Reads one channel as (width, height, values): `height`, `Y`, `Z` or `R`, or the only one there is.
///
/// # Errors
/// When the file can't be read, is damaged, too large, has no such channel or holds numbers that aren't finite.
pub fn read_channel(path: &Path) -> Result<(u32, u32, Vec<f32>), Error> {
    let unsuitable = |reason: String| Error::Unsuitable { path: path.into(), reason };
    let reader = open_checked(path)?;
    let header = &reader.headers()[0];
    let channel = map_channel(header).map_err(unsuitable)?;
    let size = header.layer_size;
    let values = decode(path, reader, &[channel])?.pop().unwrap_or_default();
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        let (column, row) = (index % size.width(), index / size.width());
        return Err(unsuitable(format!("its value in column {column}, row {row} is missing or not finite")));
    }
    Ok((size.width() as u32, size.height() as u32, values))
}

/// Width and height of a picture, and the names of its channels.
///
/// # Errors
/// When the file can't be read, is damaged, too large, or has several parts.
pub fn channels(path: &Path) -> Result<([u32; 2], Vec<String>), Error> {
    let reader = open_checked(path)?;
    let header = one_part(path, &reader)?;
    let size = [header.layer_size.width() as u32, header.layer_size.height() as u32];
    Ok((size, header.channels.list.iter().map(|channel| channel.name.to_string()).collect()))
}

/// Values of the channels of these names, row by row from the top; not a number where the file holds none.
///
/// # Errors
/// When the file can't be read, is damaged, too large, has several parts or no such channel.
pub fn read_channels(path: &Path, names: &[String]) -> Result<Vec<Vec<f32>>, Error> {
    let reader = open_checked(path)?;
    let list = &one_part(path, &reader)?.channels.list;
    let index = |name: &String| {
        let missing = || Error::NoPicture { path: path.into(), reason: format!("it has no channel {name}") };
        list.iter().position(|channel| channel.name.eq(name.as_str())).ok_or_else(missing)
    };
    let channels = names.iter().map(index).collect::<Result<Vec<usize>, Error>>()?;
    decode(path, reader, &channels)
}

type Blocky = block::reader::Reader<BufReader<std::fs::File>>;

/// Opens a file whose sizes can be believed: a forged header may ask for any amount of memory.
fn open_checked(path: &Path) -> Result<Blocky, Error> {
    let (file, file_bytes) = open(path)?;
    let reader = block::read(BufReader::new(file), false).map_err(|error| corrupt(path, error))?;
    for header in reader.headers() {
        let size = header.layer_size;
        let pixel_bytes = header.channels.bytes_per_pixel as u64;
        check_size(path, "EXR", [size.width() as u64, size.height() as u64], pixel_bytes, file_bytes)?;
        check_blocks(header, file_bytes).map_err(|reason| Error::Corrupt {
            path: path.into(),
            format: "EXR",
            reason,
        })?;
    }
    Ok(reader)
}

fn one_part<'a>(path: &Path, reader: &'a Blocky) -> Result<&'a Header, Error> {
    let no_picture = |reason: &str| Error::NoPicture { path: path.into(), reason: reason.into() };
    let [header] = reader.headers() else {
        return Err(no_picture("it has several parts; save each as a file"));
    };
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(no_picture("its channels are subsampled; save it with every channel at full size"));
    }
    Ok(header)
}

/// Values of these channels of the first part, not a number where no block has arrived.
fn decode(path: &Path, reader: Blocky, wanted: &[usize]) -> Result<Vec<Vec<f32>>, Error> {
    let header = &reader.headers()[0];
    let size = header.layer_size;
    let channels = header.channels.clone();
    let mut planes = Vec::new();
    for _ in wanted {
        let mut values = collect(path, [size.width() as u64, size.height() as u64])?;
        values.resize(size.area(), f32::NAN);
        planes.push(values);
    }
    let place_line = |planes: &mut [Vec<f32>], block: &UncompressedBlock| {
        for line in block.lines(&channels) {
            let place = line.location;
            let plane = wanted.iter().position(|&channel| channel == place.channel);
            let (Some(plane), 0, Vec2(0, 0)) = (plane, block.index.layer, place.level) else { continue };
            let start = place.position.y() * size.width() + place.position.x();
            let Some(row) = planes[plane].get_mut(start..start + place.sample_count) else {
                return Err(exr::error::Error::Invalid("a block lies outside the image".into()));
            };
            let sample_type = channels.list[place.channel].sample_type;
            for (index, value) in row.iter_mut().enumerate() {
                *value = sample(line.value, sample_type, index);
            }
        }
        Ok(())
    };
    reader
        .all_chunks(false)
        .and_then(|chunks| {
            chunks.decompress_sequential(false, |_, block: UncompressedBlock| place_line(&mut planes, &block))
        })
        .map_err(|error| corrupt(path, error))?;
    Ok(planes)
}

fn corrupt(path: &Path, error: exr::error::Error) -> Error {
    match error {
        exr::error::Error::Io(source) => Error::Read { path: path.into(), source },
        error => Error::Corrupt { path: path.into(), format: "EXR", reason: error.to_string() },
    }
}

/// Primaries and white point of ITU-R BT.709 with D65.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

fn extent(size: [u32; 2]) -> Vec2<usize> {
    Vec2(size[0] as usize, size[1] as usize)
}

/// Lossless, and the same bytes however many threads compress.
fn lossless() -> Encoding {
    Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing }
}

/// Which channel to read a map from, or why there is none.
fn map_channel(header: &Header) -> Result<usize, String> {
    let channels = &header.channels.list;
    let named =
        MAP_CHANNELS.iter().find_map(|name| channels.iter().position(|channel| channel.name.eq(name)));
    let index = match (named, channels.len()) {
        (Some(index), _) => index,
        (None, 1) => 0,
        (None, _) => {
            let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
            return Err(format!(
                "its channels are {}; one of them must be named {}",
                names.join(", "),
                MAP_CHANNELS.join(" or ")
            ));
        }
    };
    if channels.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err("its channels are subsampled; save it with every channel at full size".into());
    }
    Ok(index)
}

/// Refuses a header that promises more blocks than the file has room for, or blocks that outgrow any image: memory is
/// taken block by block.
fn check_blocks(header: &Header, file_bytes: u64) -> Result<(), String> {
    /// An entry in the table of offsets, and a block's own position and length.
    const LEAST_BLOCK_BYTES: u64 = 16;
    /// Tiles are 32 to 512 samples wide where they help.
    const LONGEST_TILE_SIDE: usize = 4096;
    /// A block is in memory compressed, decompressed, and put in order.
    const MOST_BLOCK_BYTES: u64 = 64 << 20;

    if header.chunk_count as u64 > file_bytes / LEAST_BLOCK_BYTES {
        return Err(format!("its header promises {} blocks in {file_bytes} bytes", header.chunk_count));
    }
    let Vec2(width, height) = header.max_block_pixel_size();
    let block_bytes = width as u64 * height as u64 * header.channels.bytes_per_pixel as u64;
    if block_bytes > MOST_BLOCK_BYTES {
        return Err(format!(
            "a block of it takes {block_bytes} bytes; at most {MOST_BLOCK_BYTES} can be read"
        ));
    }
    if header.blocks.has_tiles() && width.max(height) > LONGEST_TILE_SIDE {
        return Err(format!(
            "its tiles are {width} × {height}; at most {LONGEST_TILE_SIDE} a side can be read"
        ));
    }
    Ok(())
}

/// One number of a line of samples, which are in the machine's byte order.
fn sample(bytes: &[u8], sample_type: SampleType, index: usize) -> f32 {
    let word = |size: usize| bytes.get(index * size..(index + 1) * size);
    let value = match sample_type {
        SampleType::F16 => {
            word(2).and_then(|bytes| bytes.try_into().ok()).map(|bytes| f16::from_ne_bytes(bytes).to_f32())
        }
        SampleType::F32 => word(4).and_then(|bytes| bytes.try_into().ok()).map(f32::from_ne_bytes),
        SampleType::U32 => {
            word(4).and_then(|bytes| bytes.try_into().ok()).map(|bytes| u32::from_ne_bytes(bytes) as f32)
        }
    };
    value.unwrap_or(f32::NAN)
}

fn plain(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(error) => error,
        error => io::Error::other(error.to_string()),
    }
}
