//! GeoTIFF: 32-bit floats with their place in metres. Any grey TIFF is read.

use super::file::{self, Written};
use super::{Error, Scale, Window, check_size, collect, open};
use std::io::{self, BufReader, Seek, Write};
use std::path::Path;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::encoder::colortype::Gray32Float;
use tiff::encoder::compression::DeflateLevel;
use tiff::encoder::{Compression, TiffEncoder, TiffKind, TiffKindBig, TiffKindStandard};
use tiff::tags::{ExtraSamples, PhotometricInterpretation, SampleFormat, Tag};
use tiff::{TiffError, TiffResult};

/// Where a raster lies, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Georeference {
    /// Of the first sample: east and north of the land's middle.
    pub origin: [f64; 2],
    /// Distance between neighbouring samples.
    pub cell_size: f64,
}

/// Writes a window, its rows from north to south, one band a channel. Samples are points, and the coordinates are
/// metres of a local system.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write(path: &Path, window: Window, place: Georeference) -> Result<Written, Error> {
    /// Offsets in a plain TIFF have 32 bits; some room is left for the directory.
    const MOST_BYTES: u64 = (1 << 32) - (1 << 20);

    let [width, height] = window.size().map(u64::from);
    let large = width * height * window.channels() as u64 * 4 > MOST_BYTES;
    file::write(path, |writer| {
        let written = if large {
            encode::<TiffKindBig>(writer, window, place)
        } else {
            encode::<TiffKindStandard>(writer, window, place)
        };
        written.map_err(plain)
    })
}

/// Reads a grey TIFF of any number format as (width, height, values, what they are). Unsigned integers are shares of the largest one,
/// except where the file is a map of places and has more than 8 bits: then they are metres, as all other numbers are.
///
/// # Errors
/// When the file can't be read, is damaged, too large, has several bands, or misses data.
pub fn read(path: &Path) -> Result<(u32, u32, Vec<f32>, Scale), Error> {
    /// What directories and strips may take besides the values.
    const MOST_DECODED: usize = 256 << 20;
    /// Tiles are 128 to 1024 samples wide in practice.
    const LONGEST_TILE_SIDE: u32 = 4096;

    let corrupt = |error: TiffError| match error {
        TiffError::IoError(source) if source.kind() != io::ErrorKind::UnexpectedEof => {
            Error::Read { path: path.into(), source }
        }
        error => Error::Corrupt { path: path.into(), format: "TIFF", reason: error.to_string() },
    };
    let unsuitable = |reason: String| Error::Unsuitable { path: path.into(), reason };

    let (file, file_bytes) = open(path)?;
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(corrupt)?;
    let (width, height) = decoder.dimensions().map_err(corrupt)?;
    let kind = Numbers::of(&mut decoder).map_err(corrupt)?;
    if kind.bands != 1 || !kind.grey {
        let reason = match kind.bands {
            1 => "its colours are not grey; save it as greyscale".into(),
            bands => format!("it holds {bands} bands; save the one with the heights by itself"),
        };
        return Err(unsuitable(reason));
    }
    check_size(path, "TIFF", [width.into(), height.into()], u64::from(kind.bits).div_ceil(8), file_bytes)?;
    let (columns, rows) = decoder.chunk_dimensions();
    if decoder.get_chunk_type() == ChunkType::Tile && columns.max(rows) > LONGEST_TILE_SIDE {
        let reason =
            format!("its tiles are {columns} × {rows}; at most {LONGEST_TILE_SIDE} a side can be read");
        return Err(Error::Corrupt { path: path.into(), format: "TIFF", reason });
    }
    let chunk = u64::from(columns.min(width)) * u64::from(rows.min(height));
    let decoded = chunk * u64::from(kind.bits).div_ceil(8);
    if decoded + u64::from(width) * u64::from(height) * 4 > super::MAX_BYTES {
        return Err(unsuitable(format!(
            "it is too large to be read in a single strip of {rows} rows; save it with smaller strips, or in tiles"
        )));
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MOST_DECODED;
    limits.intermediate_buffer_size = MOST_DECODED;
    decoder = decoder.with_limits(limits);

    let mut values: Vec<f32> = collect(path, [width.into(), height.into()])?;
    values.resize(width as usize * height as usize, f32::NAN);
    let across = width.div_ceil(columns);
    let count = across * height.div_ceil(rows);
    for index in 0..count {
        let [left, top] = [index % across * columns, index / across * rows];
        let length = columns.min(width - left) as usize;
        let chunk = kind.values(decoder.read_chunk(index).map_err(corrupt)?);
        for (row, line) in (top..height).zip(chunk.chunks_exact(length)) {
            let start = row as usize * width as usize + left as usize;
            values[start..start + length].copy_from_slice(line);
        }
    }
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        let (column, row) = (index % width as usize, index / width as usize);
        let missing = values.iter().filter(|value| !value.is_finite()).count();
        return Err(unsuitable(format!(
            "{missing} of its values are missing, the first in column {column}, row {row}; fill them first, for example \
             with gdal_fillnodata"
        )));
    }
    Ok((width, height, values, kind.scale))
}

fn encode<K: TiffKind>(writer: impl Write + Seek, window: Window, place: Georeference) -> TiffResult<()> {
    let [width, height] = window.size();
    let mut encoder = TiffEncoder::<_, K>::new_generic(writer)?
        .with_compression(Compression::Deflate(DeflateLevel::Balanced));
    let mut image = encoder.new_image::<Gray32Float>(width, height)?;
    let extra = vec![ExtraSamples::Unspecified; window.channels() - 1];
    if !extra.is_empty() {
        image.extra_samples(&extra)?;
    }
    georeference(image.encoder(), place)?;
    match window.contiguous() {
        Some(values) => image.write_data(values),
        None => image.write_data(&window.rows().flatten().copied().collect::<Vec<f32>>()),
    }
}

/// OGC GeoTIFF 1.1: samples are points (clause 7.1.2.2), the first lies at `origin`, x grows east and y north, in metres
/// of a system of the file's own (a model of type 32767, "user defined").
fn georeference<W: Write + Seek, K: TiffKind>(
    directory: &mut tiff::encoder::DirectoryEncoder<'_, W, K>,
    place: Georeference,
) -> TiffResult<()> {
    const CITATION: &str = "terrane: metres east and north of the middle|";
    /// Key, place of the value (0: here; else a tag), count, value or index.
    const KEYS: [[u16; 4]; 6] = [
        // Version 1.1.0 of the directory, and how many keys follow.
        [1, 1, 0, 5],
        // GTModelType: user defined.
        [1024, 0, 1, 32767],
        // GTRasterType: RasterPixelIsPoint.
        [1025, 0, 1, 2],
        // GTCitation, in GeoAsciiParams.
        [1026, 34737, CITATION.len() as u16, 0],
        // ProjLinearUnits: EPSG 9001, metre.
        [3076, 0, 1, 9001],
        // VerticalUnits: the same.
        [4099, 0, 1, 9001],
    ];
    let Georeference { origin: [east, north], cell_size } = place;
    directory.write_tag(Tag::ModelPixelScaleTag, &[cell_size, cell_size, 0.0][..])?;
    directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, east, north, 0.0][..])?;
    directory.write_tag(Tag::GeoKeyDirectoryTag, KEYS.as_flattened())?;
    directory.write_tag(Tag::GeoAsciiParamsTag, CITATION)?;
    // No sample is missing, and none that is there can be taken for it.
    directory.write_tag(Tag::GdalNodata, "nan")
}

/// What the numbers of a file are.
struct Numbers {
    bands: u16,
    grey: bool,
    bits: u16,
    scale: Scale,
    /// What stands for missing ones (GDAL_NODATA, or the customary void of 16-bit elevations).
    missing: Option<f64>,
}

impl Numbers {
    fn of<R: io::Read + Seek>(decoder: &mut Decoder<R>) -> TiffResult<Self> {
        let bands = decoder.find_tag_unsigned(Tag::SamplesPerPixel)?.unwrap_or(1);
        let bits = decoder.find_tag_unsigned_vec(Tag::BitsPerSample)?;
        let bits = bits.and_then(|bits: Vec<u16>| bits.first().copied()).unwrap_or(1);
        let photometric = decoder.find_tag_unsigned(Tag::PhotometricInterpretation)?;
        let photometric = photometric.and_then(PhotometricInterpretation::from_u16);
        let format = decoder.find_tag_unsigned_vec(Tag::SampleFormat)?;
        let format = format.and_then(|format: Vec<u16>| format.first().copied());
        let signed = format.is_some_and(|format| format != SampleFormat::Uint.to_u16());
        let mut placed = false;
        for tag in [Tag::ModelPixelScaleTag, Tag::ModelTransformationTag] {
            placed |= decoder.find_tag(tag)?.is_some();
        }
        let declared = decoder.find_tag(Tag::GdalNodata)?.and_then(|value| value.into_string().ok());
        let declared = declared.and_then(|text| text.trim_matches(['\0', ' ', '\n']).parse().ok());
        let void = (format == Some(SampleFormat::Int.to_u16()) && bits == 16).then_some(f64::from(i16::MIN));
        Ok(Numbers {
            bands,
            grey: photometric == Some(PhotometricInterpretation::BlackIsZero)
                || photometric == Some(PhotometricInterpretation::WhiteIsZero),
            bits,
            scale: if signed || placed && bits > 8 { Scale::Absolute } else { Scale::Share },
            missing: declared.or(void),
        })
    }

    /// The numbers of a strip or tile; NaN where they are missing.
    fn values(&self, decoded: DecodingResult) -> Vec<f32> {
        match decoded {
            DecodingResult::U8(values) => self.convert(&values, u8::MAX.into()),
            DecodingResult::U16(values) => self.convert(&values, u16::MAX.into()),
            DecodingResult::U32(values) => self.convert(&values, u32::MAX.into()),
            DecodingResult::U64(values) => {
                let values: Vec<f64> = values.into_iter().map(|value| value as f64).collect();
                self.convert(&values, u64::MAX as f64)
            }
            DecodingResult::I8(values) => self.convert(&values, 1.0),
            DecodingResult::I16(values) => self.convert(&values, 1.0),
            DecodingResult::I32(values) => self.convert(&values, 1.0),
            DecodingResult::I64(values) => {
                let values: Vec<f64> = values.into_iter().map(|value| value as f64).collect();
                self.convert(&values, 1.0)
            }
            DecodingResult::F16(values) => {
                let values: Vec<f32> = values.into_iter().map(f32::from).collect();
                self.convert(&values, 1.0)
            }
            DecodingResult::F32(values) => self.convert(&values, 1.0),
            DecodingResult::F64(values) => self.convert(&values, 1.0),
        }
    }

    fn convert<T: Copy + Into<f64>>(&self, values: &[T], largest: f64) -> Vec<f32> {
        let largest = if self.scale == Scale::Share { largest } else { 1.0 };
        let convert = |&value: &T| {
            let value = value.into();
            // Programs declare the missing value of 32-bit floats with more or fewer digits than these have.
            let missing = self.missing.is_some_and(|missing| missing as f32 == value as f32);
            if missing { f32::NAN } else { (value / largest) as f32 }
        };
        values.iter().map(convert).collect()
    }
}

fn plain(error: TiffError) -> io::Error {
    match error {
        TiffError::IoError(error) => error,
        error => io::Error::other(error.to_string()),
    }
}
