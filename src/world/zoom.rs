//! What the keys of a zoom mean to those who draw it.

use super::Zoom;
use super::fault::Complaint;
use super::place::KeyPath;
use super::plan::Check;
use crate::core::hash::derive_seed;
use crate::scene::Film;
use crate::zoom::{background, height::Surface, tree::Detail, view::Settings};

/// Side of the square of samples in a pixel.
const SAMPLES: u32 = 2;

impl Zoom {
    /// The surface of a world with this seed.
    pub fn surface(&self, seed: u32) -> Surface {
        Surface { seed: derive_seed(seed, "zoom"), refinement: self.refinement, roughness: self.roughness }
    }

    /// How it is shown in pictures of a size and a vertical field of view (radians).
    pub fn settings(&self, film: &Film, fov: f32) -> Settings {
        Settings {
            bits: self.tile,
            detail: Detail::new(self.detail.into()),
            octaves: self.visibility,
            clear: self.clear,
            layers: Some(background::layers(self.visibility)),
            face: background::side(film, fov),
            slots: self.tiles,
            samples: SAMPLES,
        }
    }
}

impl Check<'_> {
    /// Refuses a place on another surface.
    pub(super) fn zoom(&mut self, zoom: &Zoom, seed: u32) {
        let Some(location) = &zoom.from else { return };
        let key = KeyPath::from("zoom.from");
        if location.surface != zoom.surface(seed) {
            let complaint = Complaint::new(
                "is a place on another surface",
                "`seed`, `zoom.refinement` and `zoom.roughness` say which surface this is",
            )
            .help("take the code of a place on this one, or `from = \"none\"`; `terrane render --from` shows any place");
            self.refuse(&[key, "zoom".into()], complaint);
        }
    }
}
