//! The land as triangles.

use super::{FINEST_EXPOSURE, upload};
use crate::core::camera::Pinhole;
use crate::core::grid::Grid;
use crate::gpu::{self, Buffer, Compute, Gpu, Image, Recorder, format::R32f};
use crate::scene::{self, Film, Scene, ToneMap};
use crate::shaders::{self, Frame, raster::openness, trace::corners};
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
    if heights.iter().any(|height| *height < sea_level) {
        skirt(&mut mesh, grid);
    }
    mesh
}

/// How far the bottom of the sea goes on beyond the grid, in extents of it.
const REACH: f32 = 4.0;

/// Beyond the grid the bottom falls away by half the distance (`height_bilinear` in `glsl/lib/heightfield.glsl`).
fn skirt(mesh: &mut Mesh, grid: Grid) {
    let last = grid.cells - 1;
    let out = REACH * grid.extent;
    let rim = (0..last)
        .map(|at| [at, 0])
        .chain((0..last).map(|at| [last, at]))
        .chain((0..last).map(|at| [last - at, last]))
        .chain((0..last).map(|at| [0, last - at]));
    let rim: Vec<u32> = rim.map(|[column, row]| row * grid.cells + column).collect();
    let first = mesh.corners.len() as u32;
    let pushed = |at: Vec3| {
        let away = Vec3::new(at.x, 0.0, at.z).normalize_or_zero();
        at + out * away - Vec3::Y * (0.5 * out)
    };
    let outer: Vec<Vec3> = rim.iter().map(|index| pushed(mesh.corners[*index as usize])).collect();
    mesh.corners.extend(outer);
    let count = rim.len();
    for (index, &here) in rim.iter().enumerate() {
        let after = (index + 1) % count;
        let [below, below_next] = [index, after].map(|index| first + index as u32);
        mesh.triangles.extend([[here, rim[after], below], [rim[after], below_next, below]]);
    }
}

impl Mesh {
    /// Corners of each triangle.
    pub fn solid(&self) -> impl Iterator<Item = [Vec3; 3]> {
        self.triangles.iter().map(|triangle| triangle.map(|index| self.corners[index as usize]))
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
    // Neither film nor camera matter.
    let film = Film { width: 1, height: 1, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_along(Vec3::ZERO, Vec3::NEG_Z, 1.0, 1.0);
    let frame = upload(gpu, "frame", &[scene::frame(scene, &film, 1, &camera)])?;
    let openness = openness(gpu, scene, &frame)?;
    let pass = Compute::<corners::Shader>::new(gpu, ())?;
    let ground = &scene.ground;
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
            openness: &openness,
        };
        rec.dispatch(&pass, [points.len() as u32, 1], (), bindings);
        let download = rec.download(&corners);
        all.extend(download.take(&rec.submit()?.wait()?));
    }
    Ok(all)
}

/// How much of the sky each place sees.
fn openness(gpu: &Gpu, scene: &Scene, frame: &Buffer<Frame>) -> gpu::Result<Image<R32f>> {
    let side = scene.ground.grid.cells.min(FINEST_EXPOSURE);
    let openness = Image::new(gpu, "openness", [side; 2])?;
    let pass = Compute::<openness::Shader>::new(gpu, ())?;
    let mut rec = Recorder::new(gpu);
    let bindings = openness::Bindings { frame, height: &scene.ground.height, openness: &openness };
    rec.dispatch(&pass, [side; 2], openness::Push { cells: side as i32 }, bindings);
    rec.submit()?.wait()?;
    Ok(openness)
}
