//! TIFF 6.0 files byte by byte, sound and forged: another make than the one under test.

/// A file with one directory.
#[derive(Clone)]
pub struct Tiff {
    pub big_endian: bool,
    pub tags: Vec<(u16, Value)>,
    /// Strips or tiles, as they lie in the file.
    pub chunks: Vec<Vec<u8>>,
}

#[derive(Clone)]
pub enum Value {
    Short(Vec<u16>),
    Long(Vec<u32>),
    Double(Vec<f64>),
    Ascii(String),
    /// Where the chunks lie.
    Offsets,
    /// How long they are.
    Lengths,
}

pub const WIDTH: u16 = 256;
pub const HEIGHT: u16 = 257;
pub const BITS: u16 = 258;
pub const COMPRESSION: u16 = 259;
pub const PHOTOMETRIC: u16 = 262;
pub const STRIP_OFFSETS: u16 = 273;
pub const SAMPLES: u16 = 277;
pub const ROWS_PER_STRIP: u16 = 278;
pub const STRIP_LENGTHS: u16 = 279;
pub const TILE_WIDTH: u16 = 322;
pub const TILE_HEIGHT: u16 = 323;
pub const TILE_OFFSETS: u16 = 324;
pub const TILE_LENGTHS: u16 = 325;
pub const SAMPLE_FORMAT: u16 = 339;
pub const PIXEL_SCALE: u16 = 33550;
pub const TIEPOINT: u16 = 33922;
pub const GEO_KEYS: u16 = 34735;
pub const NO_DATA: u16 = 42113;

impl Tiff {
    /// Grey and uncompressed, in strips of `rows` rows. `format` is 1 for unsigned, 2 for signed integers, 3 for floats.
    pub fn strips(size: [u32; 2], bits: u16, format: u16, rows: u32, chunks: Vec<Vec<u8>>) -> Self {
        let tags = vec![
            (WIDTH, Value::Long(vec![size[0]])),
            (HEIGHT, Value::Long(vec![size[1]])),
            (BITS, Value::Short(vec![bits])),
            (COMPRESSION, Value::Short(vec![1])),
            (PHOTOMETRIC, Value::Short(vec![1])),
            (STRIP_OFFSETS, Value::Offsets),
            (SAMPLES, Value::Short(vec![1])),
            (ROWS_PER_STRIP, Value::Long(vec![rows])),
            (STRIP_LENGTHS, Value::Lengths),
            (SAMPLE_FORMAT, Value::Short(vec![format])),
        ];
        Tiff { big_endian: false, tags, chunks }
    }

    /// The same in tiles.
    pub fn tiles(size: [u32; 2], bits: u16, format: u16, tile: [u32; 2], chunks: Vec<Vec<u8>>) -> Self {
        let strips = Tiff::strips(size, bits, format, size[1], chunks);
        strips
            .without(&[STRIP_OFFSETS, ROWS_PER_STRIP, STRIP_LENGTHS])
            .with(TILE_WIDTH, Value::Long(vec![tile[0]]))
            .with(TILE_HEIGHT, Value::Long(vec![tile[1]]))
            .with(TILE_OFFSETS, Value::Offsets)
            .with(TILE_LENGTHS, Value::Lengths)
    }

    /// With a tag added or changed.
    pub fn with(mut self, tag: u16, value: Value) -> Self {
        self.tags.retain(|(other, _)| *other != tag);
        self.tags.push((tag, value));
        self.tags.sort_by_key(|(tag, _)| *tag);
        self
    }

    pub fn without(mut self, tags: &[u16]) -> Self {
        self.tags.retain(|(tag, _)| !tags.contains(tag));
        self
    }

    /// Header, chunks, what does not fit the directory, directory.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 8];
        let mut offsets = Vec::new();
        for chunk in &self.chunks {
            offsets.push(bytes.len() as u32);
            bytes.extend(chunk);
        }
        let lengths = self.chunks.iter().map(|chunk| chunk.len() as u32).collect();
        let mut entries = Vec::new();
        for (tag, value) in &self.tags {
            let (kind, count, mut value) = self.encode(value, &offsets, &lengths);
            if value.len() > 4 {
                let offset = bytes.len() as u32;
                bytes.append(&mut value);
                value = self.long(offset).into();
            }
            value.resize(4, 0);
            entries.extend([self.short(*tag), self.short(kind)].concat());
            entries.extend(self.long(count));
            entries.extend(value);
        }
        let directory = bytes.len() as u32;
        bytes.extend(self.short(self.tags.len() as u16));
        bytes.extend(entries);
        bytes.extend([0; 4]);
        bytes[..2].copy_from_slice(if self.big_endian { b"MM" } else { b"II" });
        bytes[2..4].copy_from_slice(&self.short(42));
        bytes[4..8].copy_from_slice(&self.long(directory));
        bytes
    }

    /// Type, count and bytes of a value.
    fn encode(&self, value: &Value, offsets: &Vec<u32>, lengths: &Vec<u32>) -> (u16, u32, Vec<u8>) {
        match value {
            Value::Short(values) => {
                (3, values.len() as u32, values.iter().flat_map(|value| self.short(*value)).collect())
            }
            Value::Long(values) => {
                (4, values.len() as u32, values.iter().flat_map(|value| self.long(*value)).collect())
            }
            Value::Double(values) => {
                let bytes = values.iter().flat_map(|value| match self.big_endian {
                    true => value.to_be_bytes(),
                    false => value.to_le_bytes(),
                });
                (12, values.len() as u32, bytes.collect())
            }
            Value::Ascii(text) => (2, text.len() as u32 + 1, [text.as_bytes(), b"\0"].concat()),
            Value::Offsets => self.encode(&Value::Long(offsets.clone()), offsets, lengths),
            Value::Lengths => self.encode(&Value::Long(lengths.clone()), offsets, lengths),
        }
    }

    fn short(&self, value: u16) -> [u8; 2] {
        if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn long(&self, value: u32) -> [u8; 4] {
        if self.big_endian { value.to_be_bytes() } else { value.to_le_bytes() }
    }
}

/// Type and raw bytes of a tag in the first directory of a little-endian file.
pub fn find(bytes: &[u8], wanted: u16) -> Option<(u16, Vec<u8>)> {
    let short = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let long = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..2], short(2)), (&b"II"[..], 42));
    let directory = long(4);
    (0..short(directory) as usize)
        .map(|index| directory + 2 + 12 * index)
        .find(|at| short(*at) == wanted)
        .map(|at| {
            let (kind, count) = (short(at + 2), long(at + 4));
            let size = count * [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8][kind as usize];
            let start = if size > 4 { long(at + 8) } else { at + 8 };
            (kind, bytes[start..start + size].to_vec())
        })
}
