//! Damage to sound files: bits, numbers, words, chunks, and what one file has in another.

use super::Files;

/// Longest file that damage makes.
const LONGEST: usize = 64 << 10;

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Below `count`; 0 where that is 0.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    pub fn one<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}

/// Damages a file or two out of several. Mostly files that are `main`, the first one's kind.
pub fn damage(random: &mut Random, files: &Files, corpus: &[Files], words: &[&str]) -> Files {
    let mut damaged = files.clone();
    for _ in 0..1 + random.below(2) {
        let which = if random.below(3) == 0 { random.below(damaged.len()) } else { 0 };
        match random.below(60) {
            0 if damaged.len() > 1 => {
                damaged.remove(which);
                continue;
            }
            1 => {
                let mut name = damaged[which].0.clone().into_bytes();
                damage_bytes(random, &mut name, b"/.", words);
                // A name stays one, in the same folder or below.
                let name: String = String::from_utf8_lossy(&name).replace("..", "").replace('\0', "");
                if !name.trim_matches('/').is_empty() && name.len() < 100 && damaged.len() > 1 {
                    damaged[which].0 = name.trim_matches('/').into();
                }
                continue;
            }
            _ => {}
        }
        let other = random.one(corpus);
        let other = other.get(which).map_or(&[][..], |(_, bytes)| bytes);
        for _ in 0..1 + random.below(4) {
            damage_bytes(random, &mut damaged[which].1, other, words);
        }
    }
    damaged
}

/// One piece of damage; `other` is a file of the same kind.
fn damage_bytes(random: &mut Random, bytes: &mut Vec<u8>, other: &[u8], words: &[&str]) {
    let length = bytes.len();
    let place = random.below(length + 1);
    match random.below(14) {
        0 if length > 0 => bytes[place % length] ^= 1 << random.below(8),
        1 if length > 0 => bytes[place % length] = random.next() as u8,
        2 => {
            let end = (place + 1 + random.below(40)).min(length);
            bytes.drain(place..end);
        }
        3 => bytes.truncate(place),
        4 => {
            // A chunk once more, here or elsewhere.
            let end = (place + 1 + random.below(200)).min(length);
            let chunk = bytes[place..end].repeat(1 + random.below(3));
            let to = random.below(length + 1);
            bytes.splice(to..to, chunk);
        }
        5 => {
            let from = random.below(other.len() + 1);
            let end = (from + 1 + random.below(300)).min(other.len());
            let over = (place + random.below(300)).min(length);
            bytes.splice(place..over, other[from..end].iter().copied());
        }
        6 => {
            // The beginning of one and the end of the other.
            let from = random.below(other.len() + 1);
            bytes.splice(place.., other[from..].iter().copied());
        }
        7 | 8 => replace_number(random, bytes, place),
        9 => {
            // A field of a binary file.
            const FIELDS: [u64; 12] =
                [0, 1, 2, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 0x7f80_0000, u64::MAX];
            let field = random.one(&FIELDS).wrapping_add(random.below(3) as u64).wrapping_sub(1);
            let width = *random.one(&[1, 2, 4, 8]);
            let field = if random.below(2) == 0 {
                field.to_le_bytes()
            } else {
                field.rotate_right(8 * width as u32).to_be_bytes()
            };
            for (byte, value) in bytes.iter_mut().skip(place).zip(&field[..width]) {
                *byte = *value;
            }
        }
        10 | 11 if !words.is_empty() => {
            let word = random.one(words).as_bytes();
            let over = if random.below(2) == 0 { place } else { (place + word.len()).min(length) };
            bytes.splice(place..over, word.iter().copied());
        }
        12 => swap_lines(random, bytes),
        _ => {
            let word = word_at(bytes, place);
            if !word.is_empty() {
                let with: Vec<u8> = match (random.below(3), words.is_empty()) {
                    (0, false) => random.one(words).as_bytes().to_vec(),
                    (1, _) => bytes[word.clone()].repeat(2),
                    _ => Vec::new(),
                };
                bytes.splice(word, with);
            }
        }
    }
    bytes.truncate(LONGEST);
}

/// Writes an extreme in place of the number that begins at `place` or behind it.
fn replace_number(random: &mut Random, bytes: &mut Vec<u8>, place: usize) {
    const NUMBERS: [&str; 24] = [
        "0",
        "-0",
        "1",
        "-1",
        "2",
        "0.5",
        "1e-300",
        "-1e300",
        "1e400",
        "nan",
        "inf",
        "-inf",
        "127",
        "255",
        "256",
        "65535",
        "65536",
        "2147483647",
        "2147483648",
        "4294967295",
        "4294967296",
        "9223372036854775807",
        "18446744073709551616",
        "1000000",
    ];
    let digit = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-');
    let Some(start) = bytes[place..].iter().position(|byte| byte.is_ascii_digit()) else { return };
    let start = place + start;
    let end = bytes[start..].iter().position(|byte| !digit(byte)).map_or(bytes.len(), |end| start + end);
    bytes.splice(start..end, random.one(&NUMBERS).bytes());
}

fn swap_lines(random: &mut Random, bytes: &mut Vec<u8>) {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    if lines.len() > 1 {
        let (one, other) = (random.below(lines.len()), random.below(lines.len()));
        lines.swap(one, other);
        *bytes = lines.concat();
    }
}

fn word_at(bytes: &[u8], place: usize) -> std::ops::Range<usize> {
    let letter = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let start = bytes[..place].iter().rposition(|byte| !letter(byte)).map_or(0, |at| at + 1);
    let end = bytes[place..].iter().position(|byte| !letter(byte)).map_or(bytes.len(), |at| place + at);
    start..end
}

/// Makes checksums and lengths of a damaged file right again, so that the damage gets past them.
pub fn seal(name: &str, bytes: &mut [u8]) {
    if name.ends_with(".png") {
        seal_png(bytes);
    } else if name.ends_with(".glb") {
        seal_glb(bytes);
    }
}

fn seal_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = bytes.get(at..at + 4) {
        let length = u32::from_be_bytes(length.try_into().unwrap_or_default()) as usize;
        let Some(chunk) = bytes.get(at + 4..at.saturating_add(8).saturating_add(length)) else { return };
        let checksum = super::crc32(chunk).to_be_bytes();
        let Some(place) = bytes.get_mut(at + 8 + length..at + 12 + length) else { return };
        place.copy_from_slice(&checksum);
        at += 12 + length;
    }
}

/// The JSON goes up to the binary chunk, or to the end.
fn seal_glb(bytes: &mut [u8]) {
    if bytes.len() < 20 {
        return;
    }
    let binary = bytes.windows(4).rposition(|window| window == b"BIN\0").map_or(bytes.len(), |at| at - 4);
    let Some(length) = binary.checked_sub(20) else { return };
    bytes[12..16].copy_from_slice(&(length as u32).to_le_bytes());
    if let Some(rest) = (bytes.len()).checked_sub(binary + 8)
        && let Some(place) = bytes.get_mut(binary..binary + 4)
    {
        place.copy_from_slice(&(rest as u32).to_le_bytes());
    }
    let whole = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&whole.to_le_bytes());
}
