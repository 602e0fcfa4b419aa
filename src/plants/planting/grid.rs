//! Plants in the cells of a grid that the camera carries along (Rudzki 2020, §4.3.10).

use super::random::Random;
use super::{Plant, Planter, Rule};
use glam::Vec2;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// From the camera to the middle of the grid: east and south, metres.
    pub offset: Vec2,
    /// Cells from west to east, and from north to south.
    pub cells: [u32; 2],
    /// Side of a cell, metres.
    pub cell_size: f32,
    /// That a cell is filled.
    pub probability: f32,
    /// Side of the square round a cell's middle in which plants stand, as a share of the cell's.
    pub jitter: f32,
}

impl Grid {
    /// How many plants there are, about.
    pub fn predict(&self) -> f64 {
        self.cells.into_iter().map(f64::from).product::<f64>() * f64::from(self.probability)
    }
}

pub fn plant(rule: &Rule, grid: &Grid, planter: &Planter) -> Vec<Plant> {
    let [columns, rows] = grid.cells;
    let eye = planter.camera.eye;
    let middle = Vec2::new(eye.x, eye.z) + grid.offset;
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
    let plants = cells.filter_map(|cell| {
        let mut random = Random::of_cell(rule.seed, PLANTS, cell.map(u32::cast_signed));
        let filled = random.share() < grid.probability;
        let jitter = Vec2::new(random.share() - 0.5, random.share() - 0.5) * grid.jitter;
        let [east, south] = [0, 1].map(|axis| cell[axis] as f32 - (grid.cells[axis] - 1) as f32 / 2.0);
        let at = middle + (Vec2::new(east, south) + jitter) * grid.cell_size;
        if !filled || random.share() >= rule.site.density(planter.ground, at) {
            return None;
        }
        let scale = random.between(rule.scale);
        planter.grow(rule, at, scale, &mut random)
    });
    plants.collect()
}

/// Purpose of random numbers.
const PLANTS: u32 = 0x6772;
