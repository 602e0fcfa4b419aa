//! Reef growth (docs/model.md, section 5), at one height of the sea and without rubble.

use super::{
    Ground, HEIGHT,
    planes::{Around, Planes, split},
};
use crate::terrain::{Plan, reef::Params};
use rayon::prelude::*;

pub struct Reef {
    constants: Constants,
    sweeps: u32,
    bed: Planes,
    /// Thickness and carbon.
    state: Planes,
    carbon: Planes,
    carbon_next: Planes,
    begun: bool,
}

#[derive(Clone, Copy)]
struct Constants {
    sea_level: f32,
    growth: f32,
    light_decay: f32,
    max_depth: f32,
    uptake: f32,
    keep: f32,
    ocean_carbon: f32,
    ocean_depth: f32,
    mixing: f32,
}

/// Carbon of a cell that has no water.
const LAND: f32 = -1.0;

impl Reef {
    pub fn new(plan: &Plan, params: &Params) -> Reef {
        let cells = plan.grid.cells as usize;
        let cell = f64::from(plan.grid.extent) / f64::from(plan.grid.cells - 1);
        let step = f64::from(params.step);
        let sweeps = params.sweeps(plan.grid);
        let mixing = f64::from(params.diffusivity) * step / (cell * cell) / f64::from(sweeps.max(1));
        let constants = Constants {
            sea_level: plan.sea_level,
            growth: (f64::from(params.growth) * step) as f32,
            light_decay: params.light_decay,
            max_depth: params.max_depth,
            uptake: params.uptake,
            keep: params.keep,
            ocean_carbon: params.ocean_carbon,
            ocean_depth: params.ocean_depth,
            mixing: mixing as f32,
        };
        Reef {
            constants,
            sweeps,
            bed: Planes::new(cells, 1),
            state: Planes::new(cells, 1),
            carbon: Planes::new(cells, 1),
            carbon_next: Planes::new(cells, 1),
            begun: false,
        }
    }

    pub fn step(&mut self, ground: &mut Ground) {
        if !self.begun {
            self.begin(ground);
        }
        let (constants, bed) = (self.constants, &self.bed);
        let cells = ground.now.rows_mut().zip(self.state.rows_mut()).zip(self.carbon.rows_mut());
        let last = cells.len() - 1;
        cells.enumerate().for_each(|(y, ((ground, state), carbon))| {
            let [height] = split(ground, 2);
            let [thickness] = split(state, 1);
            let [carbon] = split(carbon, 1);
            grow(height, thickness, carbon, bed.row(y, 0), constants);
            hold_rim(carbon, height, y == 0 || y == last, constants);
        });
        (0..self.sweeps).for_each(|_| self.sweep(ground));
    }

    pub fn sweep(&mut self, ground: &Ground) {
        let (constants, carbon, now) = (self.constants, &self.carbon, &ground.now);
        let rows = self.carbon_next.rows_mut();
        let last = rows.len() - 1;
        rows.enumerate().for_each(|(y, row)| {
            let [next] = split(row, 1);
            let height = now.row(y, HEIGHT);
            diffuse(next, carbon.around(y, 0), height, constants);
            hold_rim(next, height, y == 0 || y == last, constants);
        });
        std::mem::swap(&mut self.carbon, &mut self.carbon_next);
    }

    pub fn thickness(&self) -> Vec<f32> {
        self.state.plane(0)
    }

    /// The bed is what there is; carbon is that of the ocean wherever there is water.
    fn begin(&mut self, ground: &Ground) {
        let Constants { sea_level, ocean_carbon, .. } = self.constants;
        self.bed.rows_mut().zip(self.carbon.rows_mut()).enumerate().for_each(|(y, (bed, carbon))| {
            let ([bed], [carbon]) = (split(bed, 1), split(carbon, 1));
            bed.copy_from_slice(ground.now.row(y, HEIGHT));
            for (carbon, h) in carbon.iter_mut().zip(bed) {
                *carbon = if *h < sea_level { ocean_carbon } else { LAND };
            }
        });
        self.begun = true;
    }
}

fn grow(height: &mut [f32], thickness: &mut [f32], carbon: &mut [f32], bed: &[f32], constants: Constants) {
    let n = height.len();
    let (thickness, carbon, bed) = (&mut thickness[..n], &mut carbon[..n], &bed[..n]);
    for x in 0..n {
        let depth = constants.sea_level - (bed[x] + thickness[x]);
        let concentration = carbon[x].max(0.0);
        let mut calcified = 0.0;
        if depth > 0.0 && depth < constants.max_depth {
            let light = (-constants.light_decay * depth).exp();
            calcified = concentration * concentration * constants.growth * light;
        }
        thickness[x] += calcified.min((depth - constants.keep).max(0.0));
        height[x] = bed[x] + thickness[x];
        let left = (concentration - constants.uptake * calcified / depth.max(0.5)).max(0.0);
        carbon[x] = held(left, constants.sea_level - height[x], constants);
    }
}

fn diffuse(next: &mut [f32], carbon: Around, height: &[f32], constants: Constants) {
    let n = next.len();
    let (here, height) = (&carbon.here[..n], &height[..n]);
    let [l, r, t, b, ..] = carbon.beside.map(|row| &row[..n]);
    for x in 0..n {
        let own = here[x];
        let gain = |other: f32| if other < 0.0 { 0.0 } else { other - own };
        let gained = (gain(l[x]) + gain(r[x])) + (gain(t[x]) + gain(b[x]));
        next[x] = held(own + constants.mixing * gained, constants.sea_level - height[x], constants);
    }
}

fn held(carbon: f32, depth: f32, constants: Constants) -> f32 {
    let wet = if depth > constants.ocean_depth { constants.ocean_carbon } else { carbon };
    if depth <= 0.0 { LAND } else { wet }
}

/// The rim of the grid has the ocean's carbon.
fn hold_rim(carbon: &mut [f32], height: &[f32], whole_row: bool, constants: Constants) {
    let last = carbon.len() - 1;
    let hold = |x: usize| if height[x] < constants.sea_level { constants.ocean_carbon } else { LAND };
    if whole_row {
        (0..=last).for_each(|x| carbon[x] = hold(x));
    } else {
        (carbon[0], carbon[last]) = (hold(0), hold(last));
    }
}
