//! OpenEXR: scene-linear pictures, and layers of the land as named channels, all in 32-bit floats.

use super::file::{self, Written};
use super::{Error, check_size, collect, open};
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{Chromaticities, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{Blocks, Compression, WritableImage, f16};
use std::fs::File;
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

/// A picture with layers of what it shows, or a part of one, scene-linear.
pub struct Layered {
    /// Width and height of what the channels hold, pixels.
    pub size: [u32; 2],
    /// Its upper left corner in all of the picture.
    pub origin: [u32; 2],
    /// Width and height of all of the picture.
    pub whole: [u32; 2],
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
    let Layered { size, origin, whole, white_luminance, comments, channels } = picture;
    let mut clamped = 0;
    let channels = channels.into_iter().map(|(name, values)| {
        // Numbers, lengths and places need more digits than light does.
        let exact =
            ["depth.", "object.", "position.", "samples."].iter().any(|layer| name.starts_with(layer));
        let samples = match half && !exact {
            true => FlatSamples::F16(halved(&values, &mut clamped)),
            false => FlatSamples::F32(values),
        };
        AnyChannel::new(name.as_str(), samples)
    });
    let channels = AnyChannels::sort(channels.collect());
    let attributes = LayerAttributes {
        white_luminance: Some(white_luminance),
        software_name: Text::new_or_none(concat!("terrane ", env!("CARGO_PKG_VERSION"))),
        // The order of attributes that the format does not know is not kept, so that all of ours are one.
        comments: Text::new_or_none(latin(&comments)),
        layer_position: Vec2(origin[0] as i32, origin[1] as i32),
        ..LayerAttributes::default()
    };
    let mut image = Image::from_layer(Layer::new(extent(size), attributes, lossless(), channels));
    image.attributes.chromaticities = Some(REC_709);
    // What the channels hold is the data window in it.
    image.attributes.display_window = IntegerBounds::from_dimensions(extent(whole));
    let written = file::write(path, |writer| image.write().to_buffered(writer).map_err(plain))?;
    Ok((written, clamped))
}

/// Texts of the format are in Latin-1.
fn latin(text: &str) -> String {
    text.chars().map(|letter| if u32::from(letter) < 256 { letter } else { '?' }).collect()
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
    let (reader, _) = open_checked(path)?;
    let ([width, height], values) = read_finite(path, reader, |header| Ok([map_channel(header)?]))?;
    Ok((width, height, values.into_flattened()))
}

/// Reads R, G and B of a picture, or its only channel thrice; gives its width and height, too.
///
/// # Errors
/// Those of [`read_channel`].
pub fn read_picture(path: &Path) -> Result<([u32; 2], Vec<[f32; 3]>), Error> {
    let (reader, file_bytes) = open_checked(path)?;
    super::check_picture_size(path, "EXR", size_of(&reader.headers()[0]), file_bytes)?;
    read_finite(path, reader, color_channels)
}

/// Width and height of a picture, and the names of its channels.
///
/// # Errors
/// When the file can't be read, is damaged, too large, or has several parts.
pub fn channels(path: &Path) -> Result<([u32; 2], Vec<String>), Error> {
    let (reader, _) = open_checked(path)?;
    let header = only_part(path, &reader)?;
    Ok((size_of(header), header.channels.list.iter().map(|channel| channel.name.to_string()).collect()))
}

/// Values of the channels of these names, row by row from the top; not a number where the file holds none.
///
/// # Errors
/// When the file can't be read, is damaged, too large, has several parts or no such channel.
pub fn read_channels(path: &Path, names: &[String]) -> Result<Vec<Vec<f32>>, Error> {
    let (reader, _) = open_checked(path)?;
    let header = only_part(path, &reader)?;
    let index = |name: &String| {
        let missing = || Error::NoPicture { path: path.into(), reason: format!("it has no channel {name}") };
        header.channels.list.iter().position(|channel| channel.name.eq(name.as_str())).ok_or_else(missing)
    };
    let wanted = names.iter().map(index).collect::<Result<Vec<usize>, Error>>()?;
    let size = size_of(header);
    let plane = |_: &usize| missing_values(path, size, f32::NAN);
    let mut planes = wanted.iter().map(plane).collect::<Result<Vec<_>, _>>()?;
    decode(path, reader, |channel, pixel, value| {
        for (plane, _) in planes.iter_mut().zip(&wanted).filter(|(_, wanted)| **wanted == channel) {
            plane[pixel] = value;
        }
    })?;
    Ok(planes)
}

type ChunkReader = block::reader::Reader<BufReader<File>>;

/// Opens a file whose sizes can be believed, and says how many bytes it has: a forged header may ask for any amount of memory.
fn open_checked(path: &Path) -> Result<(ChunkReader, u64), Error> {
    let (file, file_bytes) = open(path)?;
    let reader = block::read(BufReader::new(file), false).map_err(|error| corrupt(path, error))?;
    for header in reader.headers() {
        let pixel_bytes = header.channels.bytes_per_pixel as u64;
        check_size(path, "EXR", size_of(header).map(u64::from), pixel_bytes, file_bytes)?;
        check_blocks(header, file_bytes).map_err(|reason| Error::Corrupt {
            path: path.into(),
            format: "EXR",
            reason,
        })?;
    }
    Ok((reader, file_bytes))
}

fn size_of(header: &Header) -> [u32; 2] {
    [header.layer_size.width() as u32, header.layer_size.height() as u32]
}

fn only_part<'a>(path: &Path, reader: &'a ChunkReader) -> Result<&'a Header, Error> {
    let no_picture = |reason: String| Error::NoPicture { path: path.into(), reason };
    let [header] = reader.headers() else {
        return Err(no_picture("it has several parts; save each as a file".into()));
    };
    check_sampling(header).map_err(no_picture)?;
    Ok(header)
}

/// Values of `N` channels of the first part, pixel by pixel: all there, and finite.
fn read_finite<const N: usize>(
    path: &Path,
    reader: ChunkReader,
    choose: impl Fn(&Header) -> Result<[usize; N], String>,
) -> Result<([u32; 2], Vec<[f32; N]>), Error> {
    let unsuitable = |reason: String| Error::Unsuitable { path: path.into(), reason };
    let header = &reader.headers()[0];
    check_sampling(header).map_err(unsuitable)?;
    let chosen = choose(header).map_err(unsuitable)?;
    let size = size_of(header);
    let mut pixels = missing_values(path, size, [f32::NAN; N])?;
    decode(path, reader, |channel, pixel, value| {
        for (place, _) in pixels[pixel].iter_mut().zip(&chosen).filter(|(_, chosen)| **chosen == channel) {
            *place = value;
        }
    })?;
    if let Some(index) = pixels.iter().position(|values| values.iter().any(|value| !value.is_finite())) {
        let width = size[0] as usize;
        let (column, row) = (index % width, index / width);
        return Err(unsuitable(format!("its value in column {column}, row {row} is missing or not finite")));
    }
    Ok((size, pixels))
}

fn missing_values<T: Copy>(path: &Path, size: [u32; 2], missing: T) -> Result<Vec<T>, Error> {
    let mut values = collect(path, size.map(u64::from))?;
    values.resize(size[0] as usize * size[1] as usize, missing);
    Ok(values)
}

/// Gives `put` every value of the first part: the channel's place in the list, the pixel's place in the picture, and the value.
fn decode(path: &Path, reader: ChunkReader, mut put: impl FnMut(usize, usize, f32)) -> Result<(), Error> {
    let header = &reader.headers()[0];
    let (size, channels) = (header.layer_size, header.channels.clone());
    let mut put_block = |block: &UncompressedBlock| {
        for line in block.lines(&channels) {
            let place = line.location;
            let Some(channel) = channels.list.get(place.channel) else { continue };
            if block.index.layer != 0 || place.level != Vec2(0, 0) {
                continue;
            }
            let start = place.position.y() * size.width() + place.position.x();
            if start + place.sample_count > size.area() {
                return Err(exr::error::Error::Invalid("a block lies outside the image".into()));
            }
            for index in 0..place.sample_count {
                put(place.channel, start + index, sample(line.value, channel.sample_type, index));
            }
        }
        Ok(())
    };
    reader
        .all_chunks(false)
        .and_then(|chunks| chunks.decompress_sequential(false, |_, block| put_block(&block)))
        .map_err(|error| corrupt(path, error))
}

fn check_sampling(header: &Header) -> Result<(), String> {
    if header.channels.list.iter().all(|channel| channel.sampling == Vec2(1, 1)) {
        return Ok(());
    }
    Err("its channels are subsampled; save it with every channel at full size".into())
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
    Ok(index)
}

/// Where a picture's colours are, or why there are none.
fn color_channels(header: &Header) -> Result<[usize; 3], String> {
    let channels = &header.channels.list;
    let named = |name: &str| channels.iter().position(|channel| channel.name.eq(name));
    match ([named("R"), named("G"), named("B")], channels.len()) {
        ([Some(red), Some(green), Some(blue)], _) => Ok([red, green, blue]),
        (_, 1) => Ok([0; 3]),
        _ => {
            let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
            Err(format!("its channels are {}; it must have R, G and B", names.join(", ")))
        }
    }
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
