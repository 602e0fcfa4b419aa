//! Places at a given depth over a target, in whole numbers: the same on every machine, on the way in and on the way out.

use crate::zoom::{
    address::{DEEPEST, Place},
    height::Roughness,
};

/// −log₂ of a distance in cells of level 0, in 2⁻¹⁶.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Depth(pub u64);

/// Binary digits of numbers between 0 and 1.
const DIGITS: u32 = 32;

/// 2 to the power of −1/2, −1/4, −1/8 and so on, in 2⁻³².
const ROOTS: [u64; 16] = {
    let mut roots = [0; 16];
    let mut root = 1u64 << (DIGITS - 1);
    let mut index = 0;
    while index < roots.len() {
        root = (root << DIGITS).isqrt();
        roots[index] = root;
        index += 1;
    }
    roots
};

/// Cosine and sine of a half, a quarter, an eighth of a turn and so on, in 2⁻³⁰, by the formulas of half angles.
const TURNS: [[i64; 2]; 16] = {
    const ONE: i64 = 1 << 30;
    let mut turns = [[-ONE, 0]; 16];
    turns[1] = [0, ONE];
    let mut index = 2;
    while index < turns.len() {
        let [cos, sin] = turns[index - 1];
        let half = ((ONE + cos) << 29).isqrt();
        turns[index] = [half, (sin << 29) / half];
        index += 1;
    }
    turns
};

impl Depth {
    pub fn level(level: u32) -> Depth {
        Depth(u64::from(level) << 16)
    }

    /// The depth of a frame, when `levels` are passed in `frames` frames. Both at most 2³².
    pub fn of_frame(frame: u64, levels: u32, frames: u32) -> Depth {
        let steps = u128::from(frame) * u128::from(levels) * 65_536 / u128::from(frames.max(1));
        Depth(u64::try_from(steps).unwrap_or(u64::MAX))
    }

    /// Whole levels, at most [`DEEPEST`].
    pub fn whole(self) -> u32 {
        u32::try_from(self.0 >> 16).map_or(DEEPEST, |whole| whole.min(DEEPEST))
    }

    /// What is left, in 2⁻¹⁶.
    pub fn part(self) -> u16 {
        self.0 as u16
    }

    /// 2^−part, in 2⁻³²: ½ to 1. A product over the digits of the part.
    fn mantissa(self) -> u64 {
        let factors = ROOTS.iter().enumerate().filter(|(index, _)| self.part() >> (15 - index) & 1 == 1);
        factors.fold(1 << DIGITS, |product, (_, root)| (product * root) >> DIGITS)
    }
}

/// Cosine and sine of an angle in 2⁻¹⁶ of a turn, in 2⁻³⁰. A product of complex numbers over the digits of the angle.
pub(super) fn turn(angle: u16) -> [i64; 2] {
    let factors = TURNS.iter().enumerate().filter(|(index, _)| angle >> (15 - index) & 1 == 1);
    factors.fold([1 << 30, 0], |[x, y], (_, [cos, sin])| {
        let rounded = |product: i64| (product + (1 << 29)) >> 30;
        [rounded(x * cos - y * sin), rounded(x * sin + y * cos)]
    })
}

/// A target, and how places near it lie to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Approach {
    pub target: Place,
    /// From the target to the place at depth 0: east, up, south, in 2⁻¹⁶ cells of level 0. At depth d it is 2^−d as far.
    pub offset: [i64; 3],
}

impl Approach {
    /// The place at a depth. Exact to 2⁻³² of its distance to the target.
    pub fn at(&self, depth: Depth, roughness: Roughness) -> Place {
        let mut place = self.target.clone();
        let level = depth.whole() + DIGITS;
        let mantissa = i128::from(depth.mantissa());
        let [east, up, south] = self.offset.map(|offset| ((i128::from(offset) * mantissa) >> 16) as i64);
        place.x.add(east, level);
        place.y.add(up, level - roughness.halvings());
        place.z.add(south, level);
        place
    }
}
