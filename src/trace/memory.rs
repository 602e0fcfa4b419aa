//! Memory of a traced picture, before any device is asked.

use super::film::Block;
use crate::core::{grid::Grid, memory::Memory};
use crate::scene::Film;
use crate::shaders::{Facet, Feature, Hit, Look, Node, Path, Pixel, Triangle};

/// What [`super::Tracer::begin`] and [`super::Tracing::step`] need on the device beside the ground itself and what stands on it.
pub fn picture(grid: Grid, film: &Film) -> Vec<Memory> {
    let pixels = u64::from(Block::most_pixels(film));
    // Six queues beside them.
    let path =
        (size_of::<Path>() + size_of::<Hit>() + size_of::<Look>() + size_of::<Feature>() + 6 * 4) as u64;
    vec![
        Memory { name: "paths", bytes: pixels * path },
        // And its copy for the host.
        Memory { name: "film", bytes: pixels * 2 * size_of::<Pixel>() as u64 },
        Memory { name: "land to trace", bytes: 2 * grid.samples() as u64 * TRIANGLE },
    ]
}

/// What it needs of the host: sums of all pixels and their planes in a file; the land's triangles while their tree is built.
pub fn host(grid: Grid, film: &Film) -> Vec<Memory> {
    let pixels = u64::from(film.width) * u64::from(film.height);
    vec![
        Memory { name: "sums", bytes: pixels * (size_of::<Pixel>() as u64 + 2 * 19 * 4) },
        // Corners thrice, boxes, and a binary tree of 32 bytes a node.
        Memory { name: "tree", bytes: 2 * grid.samples() as u64 * (TRIANGLE + 3 * 48 + 32 + 2 * 32) },
    ]
}

/// On the device, with its share of nodes: measured trees have a node for 4 to 7 triangles.
const TRIANGLE: u64 = (size_of::<Triangle>() + size_of::<Facet>() + size_of::<Node>() / 4) as u64;
