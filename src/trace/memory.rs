//! Memory of a traced picture, before any device is asked.

use super::{film::Block, sky};
use crate::core::{grid::Grid, memory::Memory};
use crate::scene::{Film, Model, Population, Shelter, Sky, panorama_memory};
use crate::shaders::{Feature, Hit, Look, Path, Pixel};
use std::sync::Arc;

/// What [`super::Tracer::begin`] and [`super::Tracing::step`] need on the device beside the ground itself and what stands on it.
pub fn picture(grid: Grid, film: &Film, sky: &Sky) -> Vec<Memory> {
    let pixels = u64::from(Block::most_pixels(film));
    // Six queues beside them.
    let path =
        (size_of::<Path>() + size_of::<Hit>() + size_of::<Look>() + size_of::<Feature>() + 6 * 4) as u64;
    vec![
        Memory { name: "paths", bytes: pixels * path },
        // And its copy for the host.
        Memory { name: "film", bytes: pixels * 2 * size_of::<Pixel>() as u64 },
        Memory { name: "land to trace", bytes: ground(grid) },
        Memory { name: "light", bytes: Shelter::bytes(grid) },
        Memory { name: "sky", bytes: panorama_memory(sky).bytes + sky::bytes(sky) },
    ]
}

/// What stands on the ground, on the device: its finest level is traced, whatever its distance.
pub fn population(population: &Population) -> Memory {
    let of = |model: &Arc<Model>| {
        let parts = model.levels.first().into_iter().flat_map(|level| &level.parts);
        parts.map(|part| part.mesh.triangles.len() as u64).sum::<u64>()
    };
    let triangles: u64 = population.models.iter().map(of).sum();
    Memory { name: "models", bytes: TRIANGLE * triangles + INSTANCE * population.instances.len() as u64 }
}

/// A triangle with its normals and material, and its share of nodes of 80 bytes: measured trees have one for 4 to 7 triangles.
const TRIANGLE: u64 = 48 + 4 + 80 / 4;

/// A placement and its share of nodes.
const INSTANCE: u64 = 48 + 80 / 4;

/// What it needs of the host: sums of all pixels and their planes in a file; the land's heights and its tree.
pub fn host(grid: Grid, film: &Film) -> Vec<Memory> {
    let pixels = u64::from(film.width) * u64::from(film.height);
    vec![
        Memory { name: "sums", bytes: pixels * (size_of::<Pixel>() as u64 + 2 * 19 * 4) },
        // The tree twice; of every sample its height, the spread of half a leaf, and what is on its way.
        Memory { name: "tree", bytes: 2 * ground(grid) + grid.samples() as u64 * (4 + 4 + 4) },
    ]
}

/// Of the tree over the land: a node of 80 bytes for 16 cells, and an eighth of that for those above.
fn ground(grid: Grid) -> u64 {
    grid.samples() as u64 * 80 * 8 / (16 * 7) + NODES_AT_LEAST
}

/// Small grids don't fill their nodes.
const NODES_AT_LEAST: u64 = 64 << 10;
