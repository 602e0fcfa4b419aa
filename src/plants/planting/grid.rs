//! Plants in the cells of a grid that the camera carries along (Rudzki 2020, §4.3.10).

use super::random::Random;
use super::{Plant, Planter, Rule};
use glam::Vec2;
use rayon::prelude::*;
use std::ops::Range;

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
    /// How many plants there are on a terrain of this side, metres, at most about.
    pub fn predict(&self, extent: f32) -> f64 {
        let across = f64::from(extent) / f64::from(self.cell_size) + 1.0;
        self.cells.into_iter().map(|cells| across.min(cells.into())).product::<f64>()
            * f64::from(self.probability)
    }

    /// Of so many cells along an axis those that reach into `±half`. The middle of all of them lies at `middle`, metres.
    fn within(&self, cells: u32, middle: f32, half: f32) -> Range<u32> {
        // All of them are one place.
        if self.cell_size == 0.0 {
            return 0..cells;
        }
        let begin = f64::from(cells) / 2.0 - f64::from(middle) / f64::from(self.cell_size);
        // Places are rounded to floats.
        let reach = f64::from(half) * (1.0 + 1e-6) / f64::from(self.cell_size);
        let first = (begin - reach).floor();
        let end = (begin + reach).floor() + 1.0;
        (first as u32).min(cells)..(end as u32).min(cells)
    }
}

pub fn plant(rule: &Rule, grid: &Grid, planter: &Planter) -> Vec<Plant> {
    let [columns, rows] = grid.cells;
    let eye = planter.camera.eye;
    let middle = Vec2::new(eye.x, eye.z) + grid.offset;
    let half = planter.ground.grid.extent / 2.0;
    let columns = grid.within(columns, middle.x, half);
    let plant = |cell: [u32; 2]| {
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
    };
    let row = |row: u32| columns.clone().filter_map(|column| plant([column, row])).collect::<Vec<_>>();
    grid.within(rows, middle.y, half).into_par_iter().map(row).collect::<Vec<_>>().concat()
}

/// Purpose of random numbers.
const PLANTS: u32 = 0x6772;
