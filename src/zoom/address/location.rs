//! Location codes: a surface, a place on it and a view from there, as letters that can be passed on.

use super::{DEEPEST, Fixed, Place};
use crate::zoom::height::{Refinement, Roughness, Surface};
use glam::DVec3;
use sha2::{Digest, Sha256};

/// All that decides a picture of a surface, apart from how it is coloured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    pub surface: Surface,
    /// The level whose cells are about as large as the surface is far: where to begin to look for it.
    pub level: u32,
    pub place: Place,
    pub attitude: Attitude,
    /// Vertical field of view, in 2⁻¹⁶ of a full turn.
    pub fov: u16,
}

/// Where a view goes, in 2⁻¹⁶ of a full turn (a tenth of a pixel of 1440 rows): what is flown is what a code says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Attitude {
    /// Azimuth, clockwise from north.
    pub yaw: u16,
    /// Elevation, two's complement.
    pub pitch: u16,
    /// The horizon's, two's complement; the camera's right side goes down.
    pub roll: u16,
}

impl Attitude {
    /// Right, up and forward: unit vectors, east, up, south. The same on every machine.
    pub fn axes(self) -> [DVec3; 3] {
        let radians = |angle: u16| f64::from(angle as i16) / 65_536.0 * std::f64::consts::TAU;
        let [(sin_yaw, cos_yaw), (sin_pitch, cos_pitch), (sin_roll, cos_roll)] =
            [self.yaw, self.pitch, self.roll].map(|angle| libm::sincos(radians(angle)));
        let forward = DVec3::new(sin_yaw * cos_pitch, sin_pitch, -cos_yaw * cos_pitch);
        let level = DVec3::new(cos_yaw, 0.0, sin_yaw);
        let up = level.cross(forward);
        [level * cos_roll - up * sin_roll, up * cos_roll + level * sin_roll, forward]
    }
}

/// What is wrong with a location code.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodeError {
    #[error("the location code is empty")]
    Empty,
    #[error("{found:?}, character {position} of the location code, is none of A-Z, a-z, 0-9, - and _")]
    Letter { found: char, position: usize },
    #[error("the location code has {letters} letters; the deepest place that there is has {most}")]
    TooLong { letters: usize, most: usize },
    #[error("the location code ends too early; was all of it copied?")]
    Cut,
    #[error("the location code's checksum is wrong: a letter differs from what it was, or is missing")]
    Checksum,
    #[error("the location code is of version {found}; this program reads version {known}")]
    Version { found: u64, known: u64 },
    /// Only forged codes have right checksums and such faults.
    #[error("the location code says something impossible: {0}")]
    Impossible(&'static str),
}

const VERSION: u64 = 1;

/// base64url (RFC 4648, table 2), six bits a letter.
const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

/// Letters of the checksum.
const CHECK: usize = 5;

/// Bits of a level or a count of digits.
const LEVEL_BITS: u32 = 24;

/// Bits of the length of a whole part.
const WHOLE_BITS: u32 = 7;

/// Digits that a place may have: those of the deepest level, and some of a view there.
const MOST_DIGITS: u32 = DEEPEST + 128;

/// Letters of the longest code: 3 bits a level, and less than 600 bits besides.
pub const MOST_LETTERS: usize = MOST_DIGITS as usize * 3 / 6 + 100;

/// Bits of the whole part of the farthest place: beyond, differences to it would not have room in 64 bits.
const FARTHEST_BITS: u32 = 41;

/// Least and greatest field of view: 1° and 179°.
const FOV: std::ops::RangeInclusive<u16> = 183..=32585;

impl Location {
    /// A field of view as codes can have it, from radians.
    pub fn nearest_fov(radians: f32) -> u16 {
        let parts = libm::round(f64::from(radians) / std::f64::consts::TAU * 65_536.0);
        (parts as u16).clamp(*FOV.start(), *FOV.end())
    }

    /// The field of view, radians.
    pub fn fov_radians(&self) -> f32 {
        Self::radians(self.fov)
    }

    /// 2⁻¹⁶ of full turns in radians.
    pub fn radians(fov: u16) -> f32 {
        (f64::from(fov) / 65_536.0 * std::f64::consts::TAU) as f32
    }

    /// The code. It has three bits a level: a place at level 1000 takes about 560 letters.
    pub fn code(&self) -> String {
        let mut bits = BitWriter::default();
        bits.push(VERSION, 6);
        bits.push(self.surface.seed.into(), 32);
        bits.push((self.surface.refinement == Refinement::Bilinear).into(), 1);
        bits.push(self.surface.roughness.halvings().into(), 2);
        bits.push(self.level.into(), LEVEL_BITS);
        let Attitude { yaw, pitch, roll } = self.attitude;
        [yaw, pitch, roll, self.fov].iter().for_each(|angle| bits.push((*angle).into(), 16));
        let digits = self.place.digits();
        bits.push(digits.into(), LEVEL_BITS);
        for number in [&self.place.x, &self.place.y, &self.place.z] {
            let length = whole_length(number.whole());
            bits.push(length.into(), WHOLE_BITS);
            bits.push(number.whole() as u64, length);
            for (place, length) in limbs(digits) {
                bits.push(number.slice(place + 64) >> (64 - length), length);
            }
        }
        let mut code = bits.letters();
        code.push_str(&checksum(&code));
        code
    }

    /// Reads a code. White space in it doesn't count: long ones come in lines.
    pub fn parse(text: &str) -> Result<Location, CodeError> {
        let mut code = String::new();
        for (index, found) in text.chars().enumerate() {
            match found {
                _ if found.is_ascii_whitespace() => continue,
                _ if found.is_ascii_alphanumeric() || "-_".contains(found) => code.push(found),
                _ => return Err(CodeError::Letter { found, position: index + 1 }),
            }
            if code.len() > MOST_LETTERS {
                let letters = text.chars().filter(|letter| !letter.is_ascii_whitespace()).count();
                return Err(CodeError::TooLong { letters, most: MOST_LETTERS });
            }
        }
        if code.is_empty() {
            return Err(CodeError::Empty);
        }
        let (content, check) = code.split_at(code.len().checked_sub(CHECK).ok_or(CodeError::Cut)?);
        let mut bits = BitReader::new(content);
        match bits.take(6)? {
            VERSION => {}
            found => return Err(CodeError::Version { found, known: VERSION }),
        }
        if checksum(content) != check {
            return Err(CodeError::Checksum);
        }
        let location = Self::read(&mut bits)?;
        // One place, one code: numbers have no useless digits, and nothing follows.
        match location.code() == code {
            true => Ok(location),
            false => Err(CodeError::Impossible("a number is written longer than it is")),
        }
    }

    fn read(bits: &mut BitReader) -> Result<Location, CodeError> {
        let seed = bits.take(32)? as u32;
        let refinement = if bits.take(1)? == 1 { Refinement::Bilinear } else { Refinement::Triangles };
        let roughness = match bits.take(2)? {
            0 => Roughness::Whole,
            1 => Roughness::Half,
            2 => Roughness::Quarter,
            _ => return Err(CodeError::Impossible("an unknown roughness")),
        };
        let level = bits.take(LEVEL_BITS)? as u32;
        let mut angle = || bits.take(16).map(|angle| angle as u16);
        let attitude = Attitude { yaw: angle()?, pitch: angle()?, roll: angle()? };
        let fov = angle()?;
        let digits = bits.take(LEVEL_BITS)? as u32;
        if level > DEEPEST || digits > MOST_DIGITS {
            return Err(CodeError::Impossible("a place deeper than the deepest"));
        }
        if !FOV.contains(&fov) {
            return Err(CodeError::Impossible("a field of view beyond 1 to 179 degrees"));
        }
        let mut number = || -> Result<Fixed, CodeError> {
            let length = bits.take(WHOLE_BITS)? as u32;
            if length > FARTHEST_BITS {
                return Err(CodeError::Impossible("a place beyond the world's end"));
            }
            let whole = extend_sign(bits.take(length)?, length);
            let limb = |(_, length)| Ok(bits.take(length)? << (64 - length));
            Ok(Fixed::of(whole, limbs(digits).map(limb).collect::<Result<_, CodeError>>()?))
        };
        let place = Place { x: number()?, y: number()?, z: number()? };
        let surface = Surface { seed, refinement, roughness };
        Ok(Location { surface, level, place, attitude, fov })
    }
}

/// Digits behind the point in pieces of 64 and a rest: where each begins, and its length.
fn limbs(digits: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..digits).step_by(64).map(move |place| (place, (digits - place).min(64)))
}

/// Bits of the shortest two's complement; none for 0.
fn whole_length(whole: i64) -> u32 {
    match whole {
        0 => 0,
        _ => 65 - (whole ^ whole >> 63).leading_zeros(),
    }
}

fn extend_sign(bits: u64, length: u32) -> i64 {
    match 64 - length {
        64 => 0,
        unused => (bits << unused) as i64 >> unused,
    }
}

/// The first bits of the SHA-256 of what stands before.
fn checksum(content: &str) -> String {
    Sha256::digest(content)
        .iter()
        .take(CHECK)
        .map(|byte| char::from(LETTERS[usize::from(byte >> 2)]))
        .collect()
}

/// Bits, the highest of a number first, as letters.
#[derive(Default)]
struct BitWriter {
    letters: String,
    pending: u32,
    count: u32,
}

impl BitWriter {
    fn push(&mut self, value: u64, bits: u32) {
        for bit in (0..bits).rev() {
            self.pending = self.pending << 1 | (value >> bit & 1) as u32;
            self.count += 1;
            if self.count == 6 {
                self.letters.push(char::from(LETTERS[self.pending as usize]));
                (self.pending, self.count) = (0, 0);
            }
        }
    }

    /// The last letter is filled with zeros.
    fn letters(mut self) -> String {
        self.push(0, (6 - self.count) % 6);
        self.letters
    }
}

struct BitReader<'code> {
    letters: std::str::Bytes<'code>,
    pending: u64,
    count: u32,
}

impl<'code> BitReader<'code> {
    fn new(code: &'code str) -> Self {
        BitReader { letters: code.bytes(), pending: 0, count: 0 }
    }

    fn take(&mut self, bits: u32) -> Result<u64, CodeError> {
        let mut value = 0;
        for _ in 0..bits {
            if self.count == 0 {
                let letter = self.letters.next().ok_or(CodeError::Cut)?;
                self.pending =
                    LETTERS.iter().position(|known| *known == letter).ok_or(CodeError::Checksum)? as u64;
                self.count = 6;
            }
            self.count -= 1;
            value = value << 1 | self.pending >> self.count & 1;
        }
        Ok(value)
    }
}
