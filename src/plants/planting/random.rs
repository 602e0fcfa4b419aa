//! Random numbers that depend on nothing but a seed and a place.

use crate::core::hash::mix;

/// A stream of random numbers (the counter goes through [`mix`]).
#[derive(Clone, Copy, Debug)]
pub struct Random {
    state: u32,
}

impl Random {
    /// The stream of a cell of the plane, one of many by `purpose`.
    pub fn of_cell(seed: u32, purpose: u32, [column, row]: [i32; 2]) -> Self {
        let seed = mix(seed.wrapping_add(purpose.wrapping_mul(0x9e37_79b9)));
        let column = mix(seed ^ column.cast_unsigned());
        Random { state: mix(column.wrapping_add(row.cast_unsigned().wrapping_mul(0x85eb_ca6b))) }
    }

    pub fn bits(&mut self) -> u32 {
        self.state = self.state.wrapping_add(0x9e37_79b9);
        mix(self.state)
    }

    /// In 0…1, without 1.
    pub fn share(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    pub fn between(&mut self, [least, most]: [f32; 2]) -> f32 {
        least + (most - least) * self.share()
    }
}
