//! The land as triangles.

use crate::core::grid::Grid;
use glam::Vec3;

/// Corners of the land's triangles: two a cell of its grid, and what the sea covers beyond.
pub fn triangles(grid: Grid, heights: &[f32], sea_level: f32) -> Vec<[Vec3; 3]> {
    let cells = grid.cells;
    let corner = |column: u32, row: u32| {
        let [x, z] = grid.position(column, row);
        Vec3::new(x, heights[(row * cells + column) as usize], z)
    };
    let mut triangles = Vec::with_capacity(2 * grid.samples());
    for row in 0..cells - 1 {
        for column in 0..cells - 1 {
            let [nw, ne] = [corner(column, row), corner(column + 1, row)];
            let [sw, se] = [corner(column, row + 1), corner(column + 1, row + 1)];
            triangles.extend([[nw, sw, ne], [ne, sw, se]]);
        }
    }
    if heights.iter().any(|height| *height < sea_level) {
        skirt(&mut triangles, grid, corner);
    }
    triangles
}

/// How far the bottom of the sea goes on beyond the grid, in extents of it.
const REACH: f32 = 4.0;

/// Beyond the grid the bottom falls away by half the distance (`height_bilinear` in `glsl/lib/heightfield.glsl`).
fn skirt(triangles: &mut Vec<[Vec3; 3]>, grid: Grid, corner: impl Fn(u32, u32) -> Vec3) {
    let last = grid.cells - 1;
    let out = REACH * grid.extent;
    let rim = (0..last)
        .map(|at| [at, 0])
        .chain((0..last).map(|at| [last, at]))
        .chain((0..last).map(|at| [last - at, last]))
        .chain((0..last).map(|at| [0, last - at]));
    let rim: Vec<Vec3> = rim.map(|[column, row]| corner(column, row)).collect();
    let pushed = |at: Vec3| {
        let away = Vec3::new(at.x, 0.0, at.z).normalize_or_zero();
        at + out * away - Vec3::Y * (0.5 * out)
    };
    for (index, &here) in rim.iter().enumerate() {
        let next = rim[(index + 1) % rim.len()];
        triangles.extend([[here, next, pushed(here)], [next, pushed(next), pushed(here)]]);
    }
}
