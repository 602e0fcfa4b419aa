//! What the keys of a zoom mean to those who draw it.

use super::Zoom;
use crate::core::hash::derive_seed;
use crate::zoom::{height::Surface, tree::Detail, view::Settings};

/// Side of the square of samples in a pixel.
const SAMPLES: u32 = 2;

impl Zoom {
    /// The surface of a world with this seed.
    pub fn surface(&self, seed: u32) -> Surface {
        Surface { seed: derive_seed(seed, "zoom"), refinement: self.refinement, roughness: self.roughness }
    }

    /// How it is shown.
    pub fn settings(&self) -> Settings {
        Settings {
            bits: self.tile,
            detail: Detail::new(self.detail.into()),
            octaves: self.visibility,
            slots: self.tiles,
            samples: SAMPLES,
        }
    }
}
