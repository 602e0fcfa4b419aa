//! Standing on the ground: where the eye is follows from the land.

use super::View;
use crate::core::grid::Grid;
use glam::{Vec2, Vec3};

/// Where a picture is seen from, before the land is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewpoint {
    /// As it is, whatever the land.
    Fixed(View),
    Stand(Stand),
}

/// Somebody who stands on the ground and looks ahead: uphill where the ground rises, downhill where it falls (Rudzki
/// 2020, §3.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    pub place: Place,
    /// Of the eye above the ground, metres.
    pub height: f32,
    /// Where it looks, clockwise from north, radians.
    pub azimuth: f32,
    /// How far ahead the ground lies above which it looks, metres: by its height the eye is raised or lowered.
    pub distance: f32,
}

/// Where somebody stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// East and south of the middle of the terrain, metres.
    At(Vec2),
    /// On the sample of the grid whose height is nearest to `expected` (metres above the datum) among those at least
    /// `edge_offset` metres from the edge: the first of them from the north, and from the west. In the middle if there
    /// is none.
    Height { expected: f32, edge_offset: f32 },
}

impl Stand {
    /// Eye and target on this land: the heights of its samples, row by row from the north, and between them.
    pub fn view(&self, grid: Grid, heights: &[f32], height_at: impl Fn(Vec2) -> f32) -> View {
        let foot = match self.place {
            Place::At(at) => at,
            Place::Height { expected, edge_offset } => nearest(grid, heights, expected, edge_offset),
        };
        let ahead = foot + self.distance * Vec2::new(libm::sinf(self.azimuth), -libm::cosf(self.azimuth));
        let above = |at: Vec2| Vec3::new(at.x, height_at(at) + self.height, at.y);
        View::LookAt { position: above(foot), target: above(ahead), roll: 0.0 }
    }
}

fn nearest(grid: Grid, heights: &[f32], expected: f32, edge_offset: f32) -> Vec2 {
    let reach = grid.extent / 2.0 - edge_offset;
    let mut best = (f32::INFINITY, Vec2::ZERO);
    for (row, heights) in (0..grid.cells).zip(heights.chunks_exact(grid.cells as usize)) {
        for (column, height) in (0..grid.cells).zip(heights) {
            let at = Vec2::from(grid.position(column, row));
            let difference = (height - expected).abs();
            if difference < best.0 && at.abs().max_element() <= reach {
                best = (difference, at);
            }
        }
    }
    best.1
}
