//! Numbers modulo the prime 2⁶¹ − 1.

/// What is left of a whole number: 0 to 2⁶¹ − 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Residue(u64);

const BITS: u32 = 61;
const PRIME: u64 = (1 << BITS) - 1;

impl From<i64> for Residue {
    fn from(whole: i64) -> Residue {
        Residue(whole.rem_euclid(PRIME as i64) as u64)
    }
}

impl Residue {
    pub fn plus(self, number: i64) -> Residue {
        Residue::folded(self.0 + Residue::from(number).0)
    }

    /// Doubled this many times: 2⁶¹ is 1, so bits go round.
    pub fn doubled(self, times: u32) -> Residue {
        let times = times % BITS;
        let wide = u128::from(self.0) << times;
        Residue::folded((wide >> BITS) as u64 + (wide as u64 & PRIME))
    }

    /// Of half the number, less 1 if it is `odd` (1, else 0). 2⁶⁰ is a half.
    pub fn halved(self, odd: u64) -> Residue {
        self.plus(-(odd as i64)).doubled(BITS - 1)
    }

    /// 2⁶⁴ times as much, and a limb.
    pub fn then(self, limb: u64) -> Residue {
        // 2⁶⁴ is 8.
        let wide = (u128::from(self.0) << 3) + u128::from(limb);
        Residue::folded((wide >> BITS) as u64 + (wide as u64 & PRIME))
    }

    /// Of less than twice the prime.
    fn folded(number: u64) -> Residue {
        Residue(if number >= PRIME { number - PRIME } else { number })
    }
}
