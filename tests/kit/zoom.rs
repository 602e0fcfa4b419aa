//! Places on the surface of a zoom, and the light that it is seen in.

use terrane::{
    core::camera::direction,
    scene::{Light, Sun},
    sky::preetham,
    zoom::{
        address::Place,
        height::{Refinement, Roughness, Spine, Surface},
    },
};

/// A gentle surface.
pub fn surface(seed: u32) -> Surface {
    Surface { seed, refinement: Refinement::Triangles, roughness: Roughness::Quarter }
}

/// A sunny day.
pub fn light() -> Light {
    let toward = direction(2.0, 0.5);
    let sun = Sun { direction: toward, irradiance: [98_000.0, 92_000.0, 80_000.0], diameter: 0.0093 };
    Light { sky: preetham::sky(2.6, toward.as_dvec3()), sun: Some(sun), air: None, clouds: 0.0 }
}

/// Random words: splitmix64 (Steele, Lea & Flood 2014).
pub struct Words(pub u64);

impl Words {
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let word = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ word >> 31
    }
}

/// A place of random digits down to so many levels, at height 0.
pub fn random_place(words: &mut Words, levels: u32) -> Place {
    let mut place = Place::default();
    for level in (32..=levels).step_by(32) {
        place.x.add((words.word() >> 32) as i64, level);
        place.z.add((words.word() >> 32) as i64, level);
    }
    place
}

/// A random place, `height` times 2⁻¹⁰ cells of a level above the ground below it.
pub fn random_place_above(spine: &mut Spine, words: &mut Words, level: u32, height: i64) -> Place {
    let mut place = random_place(words, level + 63);
    place.y = spine.ground(&place, level + 24);
    // Heights are in amplitudes, which are shorter than cells.
    place.y.add(height, level + 10 - spine.surface().roughness.halvings());
    place
}
