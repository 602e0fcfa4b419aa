//! Numbers with as many binary digits behind the point as a place needs.

use super::residue::Residue;
use num_bigint::BigInt;

/// A multiple of some 2⁻ⁿ, in two's complement: a whole part modulo 2⁶⁴ and digits behind the point, as many as there are.
///
/// One number that is exact, and small differences to it ([`Coordinate::to`]) in machine numbers: the cure of deep zooms
/// into the Mandelbrot set. Digits are windows of 64 bits, so nothing is carried from level to level and nothing can drift.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Fixed {
    /// The largest whole number that is not above.
    whole: i64,
    /// Digits behind the point, 64 a limb, the first limb first. The last limb is not 0: equal numbers have equal limbs.
    limbs: Vec<u64>,
}

impl From<i64> for Fixed {
    fn from(whole: i64) -> Fixed {
        Fixed { whole, limbs: Vec::new() }
    }
}

impl Fixed {
    /// The largest whole number that is not above.
    pub fn whole(&self) -> i64 {
        self.whole
    }

    /// Digits behind the point, up to the last 1.
    pub fn digits(&self) -> u32 {
        self.limbs.last().map_or(0, |last| self.limbs.len() as u32 * 64 - last.trailing_zeros())
    }

    /// Bytes that its digits take.
    pub fn bytes(&self) -> usize {
        self.limbs.capacity() * size_of::<u64>()
    }

    /// ⌊self · 2^`level`⌋ modulo 2⁶⁴: the cell of that level, or for `level` = n + 64 the 64 digits behind the nth.
    pub fn slice(&self, level: u32) -> u64 {
        let (word, shift) = (level as usize / 64, level % 64);
        match shift {
            0 => self.word(word),
            _ => self.word(word) << shift | self.word(word + 1) >> (64 - shift),
        }
    }

    /// ⌊self · 2^`level`⌋ modulo 2⁶¹ − 1.
    pub(super) fn residue(&self, level: u32) -> Residue {
        let (words, shift) = (level as usize / 64, level % 64);
        let whole =
            (1..=words).fold(Residue::from(self.whole), |residue, word| residue.then(self.word(word)));
        match shift {
            0 => whole,
            _ => whole.doubled(shift).plus((self.word(words + 1) >> (64 - shift)) as i64),
        }
    }

    /// The number as seen from the lattice of a level.
    pub fn at(&self, level: u32) -> Coordinate {
        Coordinate { whole: self.slice(level), behind: self.slice(level + 64) }
    }

    /// The whole number that is `wrapped` modulo 2⁶⁴ and less than 2⁶³ from self · 2^`level`.
    pub fn without_wrapping(&self, wrapped: u64, level: u32) -> BigInt {
        let (words, rest) = (level.div_ceil(64), level.div_ceil(64) * 64 - level);
        let bytes: Vec<u8> = (0..=words as usize).flat_map(|word| self.word(word).to_be_bytes()).collect();
        // Shifted down, negative numbers are rounded down.
        let own = BigInt::from_signed_bytes_be(&bytes) >> rest;
        own + wrapped.wrapping_sub(self.slice(level)) as i64
    }

    /// Adds `amount` · 2^−`level`.
    pub fn add(&mut self, amount: i64, level: u32) {
        // The limb that ends at or behind the digit `level`, and the amount in its units.
        let word = level.div_ceil(64) as usize;
        let value = i128::from(amount) << (word as u32 * 64 - level);
        if self.limbs.len() < word {
            self.limbs.resize(word, 0);
        }
        // Carries run towards the point; what is left of the value beyond this limb is 0 or −1 soon.
        let mut carry = value;
        for limb in self.limbs[..word].iter_mut().rev() {
            if carry == 0 {
                break;
            }
            let sum = i128::from(*limb) + (carry & i128::from(u64::MAX));
            *limb = sum as u64;
            carry = (carry >> 64) + (sum >> 64);
        }
        self.whole = self.whole.wrapping_add(carry as i64);
        self.trim();
    }

    /// The largest multiple of 2^−`level` that is not above.
    pub fn floor(&self, level: u32) -> Fixed {
        let mut floor = self.clone();
        let (whole, rest) = (level as usize / 64, level % 64);
        floor.limbs.truncate(level.div_ceil(64) as usize);
        if rest > 0
            && let Some(last) = floor.limbs.get_mut(whole)
        {
            *last &= u64::MAX << (64 - rest);
        }
        floor.trim();
        floor
    }

    /// The number with these digits behind the point; those behind the last limb are 0.
    pub(super) fn of(whole: i64, limbs: Vec<u64>) -> Fixed {
        let mut fixed = Fixed { whole, limbs };
        fixed.trim();
        fixed
    }

    /// The whole part, then the limbs, then zeros.
    fn word(&self, index: usize) -> u64 {
        match index.checked_sub(1) {
            None => self.whole as u64,
            Some(limb) => self.limbs.get(limb).copied().unwrap_or(0),
        }
    }

    fn trim(&mut self) {
        while self.limbs.last() == Some(&0) {
            self.limbs.pop();
        }
    }
}

/// A number in cells of one level: the cell modulo 2⁶⁴, and 64 digits of how far into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coordinate {
    pub whole: u64,
    pub behind: u64,
}

impl Coordinate {
    /// From here to a lattice point (modulo 2⁶⁴, less than 2⁶³ cells away), cells. Rounded once.
    pub fn to(self, lattice: u64) -> f64 {
        const UNIT: f64 = 1.0 / (1u128 << 64) as f64;
        let whole = i128::from(lattice.wrapping_sub(self.whole) as i64);
        (whole << 64).saturating_sub(self.behind.into()) as f64 * UNIT
    }
}
