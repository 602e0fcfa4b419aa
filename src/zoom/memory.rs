//! Memory of pictures, before any device is asked.

use super::{background, tiles::Tiles, view::Settings};
use crate::core::memory::Memory;
use crate::scene::{Film, Sky, panorama_memory};
use crate::shaders::TileView;

/// What a [`Renderer`](super::view::Renderer) keeps on the device.
pub fn tiles(settings: &Settings) -> Memory {
    Memory { name: "tiles", bytes: u64::from(settings.slots) * Tiles::slot_bytes(settings.bits) }
}

/// The longest piece of that.
pub fn piece(settings: &Settings) -> Memory {
    Memory { name: "heights of tiles", bytes: tiles(settings).bytes / 3 }
}

/// What lies behind pictures.
pub fn background(settings: &Settings) -> Memory {
    let texels = match settings.layers {
        None | Some(0) => 0,
        // Those that are kept, of 8 bytes a texel, and the face that is drawn.
        Some(_) => u64::from(settings.face + 2).pow(2) * (background::KEPT as u64 * 6 * 8 + 16 + 4),
    };
    Memory { name: "backgrounds", bytes: texels }
}

/// What a picture takes beside them.
pub fn picture(settings: &Settings, film: &Film, sky: &Sky) -> Vec<Memory> {
    let pixels = u64::from(film.width) * u64::from(film.height);
    let samples = pixels * u64::from(settings.samples.pow(2));
    vec![
        // Radiance and distance, and depth.
        Memory { name: "samples", bytes: samples * (16 + 4) },
        // And their copy for the host.
        Memory { name: "pixels", bytes: pixels * 2 * 16 },
        // And their copy on its way; less than half of all tiles are.
        Memory { name: "tiles in view", bytes: u64::from(settings.slots) * size_of::<TileView>() as u64 },
        // On their way, too: jobs, seeds, indices.
        Memory { name: "tiles in the making", bytes: 1 << 22 },
        panorama_memory(sky),
    ]
}
