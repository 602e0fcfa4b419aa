//! The land as a mesh with normals and colours, for other renderers: the triangles that are traced.

use super::assets::unseen;
use super::{ground, upload};
use crate::core::grid::Grid;
use crate::gpu::{self, Compute, Gpu, Recorder};
use crate::scene::{Scene, shelter};
use crate::shaders::{self, trace::corners};
use glam::Vec3;

/// Two triangles a cell of the land's grid, and what the sea covers beyond.
pub struct Mesh {
    pub corners: Vec<Vec3>,
    /// Counter-clockwise from above.
    pub triangles: Vec<[u32; 3]>,
}

/// The mesh over these heights, row by row from the north.
pub fn mesh(grid: Grid, heights: &[f32], sea_level: f32) -> Mesh {
    let cells = grid.cells;
    let place = |index: usize| grid.position(index as u32 % cells, index as u32 / cells);
    let corner = |(index, height): (usize, &f32)| {
        let [x, z] = place(index);
        Vec3::new(x, *height, z)
    };
    let corners = heights.iter().enumerate().map(corner).collect();
    let mut triangles = Vec::with_capacity(2 * grid.samples());
    for row in 0..cells - 1 {
        for nw in row * cells..row * cells + cells - 1 {
            let [ne, sw, se] = [nw + 1, nw + cells, nw + cells + 1];
            triangles.extend([[nw, sw, ne], [ne, sw, se]]);
        }
    }
    let mut mesh = Mesh { corners, triangles };
    if ground::reaches_under(heights, sea_level) {
        skirt(&mut mesh, grid);
    }
    mesh
}

/// What the sea covers beyond the grid: the same as [`ground::skirt`].
fn skirt(mesh: &mut Mesh, grid: Grid) {
    let rim: Vec<u32> =
        ground::rim(grid).into_iter().map(|[column, row]| row * grid.cells + column).collect();
    let first = mesh.corners.len() as u32;
    let outer: Vec<Vec3> =
        rim.iter().map(|index| ground::pushed(grid, mesh.corners[*index as usize])).collect();
    mesh.corners.extend(outer);
    for (index, &here) in rim.iter().enumerate() {
        let after = (index + 1) % rim.len();
        let [below, below_next] = [index, after].map(|index| first + index as u32);
        mesh.triangles.extend([[here, rim[after], below], [rim[after], below_next, below]]);
    }
}

/// Corners that the device works on at once.
const BATCH: usize = 1 << 20;

/// Normals and colours of the land at these points, as pictures with constant materials have them
/// ([`Settings::plain`](super::Settings::plain)).
///
/// # Errors
/// A lost device, or no memory.
pub fn corners(gpu: &Gpu, scene: &Scene, points: &[Vec3]) -> gpu::Result<Vec<shaders::Corner>> {
    let frame = upload(gpu, "frame", &[unseen(scene)])?;
    let ground = &scene.ground;
    let shelter = shelter::Passes::new(gpu)?.measure(gpu, ground, &frame)?;
    let pass = Compute::<corners::Shader>::new(gpu, ())?;
    let mut all = Vec::with_capacity(points.len());
    for points in points.chunks(BATCH) {
        let corner = |point: &Vec3| shaders::Corner { point: point.to_array(), ..shaders::Corner::default() };
        let corners = upload(gpu, "corners", &points.iter().map(corner).collect::<Vec<_>>())?;
        let mut rec = Recorder::new(gpu);
        let bindings = corners::Bindings {
            frame: &frame,
            corners: &corners,
            height: &ground.height,
            wetness: &ground.wetness,
            reef: &ground.reef,
            openness: &shelter.openness,
        };
        rec.dispatch(&pass, [points.len() as u32, 1], (), bindings);
        let download = rec.download(&corners);
        all.extend(download.take(&rec.submit()?.wait()?));
    }
    Ok(all)
}
