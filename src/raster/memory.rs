//! Device memory of a picture, before any device is asked.

use super::population::{canopy, cast, shapes};
use super::{Quality, patches};
use crate::core::{grid::Grid, memory::Memory};
use crate::scene::{Film, Population, Shelter, Sky, panorama_memory, shelter};
use crate::shaders::Patch;

/// What [`super::Renderer::begin`] and [`super::Drawing::step`] need beside the ground itself.
pub fn picture(grid: Grid, film: &Film, sky: &Sky, quality: Quality) -> Vec<Memory> {
    let [width, height] = [film.width, film.height].map(|side| u64::from(side.min(quality.tile)));
    let pixels = width * height;
    let samples = pixels * u64::from(quality.samples).pow(2);
    let mut parts = light(grid, sky);
    // Distance and radiance of every sample; every pixel, and its copy for the host.
    parts.push(Memory { name: "tile", bytes: samples * (4 + 16) + pixels * 2 * 16 });
    parts
}

/// What plants take beside that, whatever they are; their [`models`] come on top.
pub fn plants(grid: Grid, film: &Film, quality: Quality) -> Vec<Memory> {
    let [width, height] = [film.width, film.height].map(|side| u64::from(side.min(quality.tile)));
    let samples = width * height * u64::from(quality.samples).pow(2);
    let texels = u64::from(cast::IMAGE_SIDE).pow(2);
    vec![
        // What every sample sees of a plant, and the depth that it has there.
        Memory { name: "plants", bytes: samples * (16 + 4) },
        // And their depth.
        Memory { name: "shadow maps", bytes: texels * (4 + 4) },
        Memory { name: "canopy", bytes: u64::from(canopy::side(grid)).pow(2) * 16 },
    ]
}

/// What [`super::Live`] needs beside the ground itself, for pictures of this size with `samples` × `samples` samples in a pixel: without
/// plants.
pub fn live(grid: Grid, film: &Film, sky: &Sky, samples: u32) -> Vec<Memory> {
    let pixels = u64::from(film.width) * u64::from(film.height) * u64::from(samples).pow(2);
    let texels = u64::from(shelter::side(grid)).pow(2);
    let mut parts = light(grid, sky);
    parts.push(Memory { name: "coat", bytes: texels * (16 + 8) });
    // Distance, depth and radiance of every sample.
    parts.push(Memory { name: "canvas", bytes: pixels * (4 + 4 + 16) });
    parts
}

/// What the models of a population take at most, in all of their levels.
pub fn models(population: &Population) -> Memory {
    let levels = population.models.iter().flat_map(|model| &model.levels);
    Memory { name: "models", bytes: levels.map(shapes::bytes).sum() }
}

/// What [`super::Renderer::maps`] needs beside the ground itself.
pub fn maps(grid: Grid, sky: &Sky) -> Vec<Memory> {
    let mut parts = light(grid, sky);
    parts.push(Memory { name: "maps", bytes: grid.samples() as u64 * (4 + 16 + 16 + 4) });
    parts
}

fn light(grid: Grid, sky: &Sky) -> Vec<Memory> {
    let texels = u64::from(shelter::side(grid)).pow(2);
    let patches = u64::from(patches::side(grid)).pow(2);
    vec![
        // Shadow and glow.
        Memory { name: "light", bytes: Shelter::bytes(grid) + texels * (8 + 16) },
        panorama_memory(sky),
        Memory { name: "patches", bytes: patches * size_of::<Patch>() as u64 },
    ]
}
