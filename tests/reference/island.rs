//! A whole island: base terrain, settling, erosion, sea bed, reef.

use super::hydraulic::{self, Cell, Erosion, Flow};
use super::lattice::Lattice;
use super::reef::Reef;
use super::{base, seabed, thermal};
use terrane::terrain::thermal::Law;
use terrane::terrain::{Boundary, Map, Plan};

pub struct Land {
    pub lattice: Lattice,
    /// Ground at the start, m.
    pub h0: Vec<f64>,
    /// Change by erosion, before the sea bed is smoothed, m.
    pub e: Vec<f64>,
    /// Change in the reef stage, m.
    pub b: Vec<f64>,
    /// The ground in the end, m.
    pub height: Vec<f64>,
    /// Where the sea stood while the land eroded, and in the end.
    pub sea_level_at_erosion: f64,
    pub sea_level: f64,
    /// The state of the water in the end.
    pub cells: Vec<Cell>,
}

pub fn run(plan: &Plan) -> Land {
    let lattice = Lattice::new(plan.grid);
    let sea_level = f64::from(plan.sea_level);
    let h0 = settled(plan, base::height(lattice, &plan.layers));
    let cells = erode(plan, &h0);
    let e: Vec<f64> = cells.iter().map(|cell| cell.e).collect();
    let mut height: Vec<f64> = h0.iter().zip(&e).map(|(h0, e)| h0 + e).collect();
    let mask = control(lattice, plan.controls.mask.as_deref());
    seabed::smooth(lattice, &mut height, sea_level, f64::from(plan.seabed_smoothing), &mask);
    let Some(params) = plan.reef.clone() else {
        let b = vec![0.0; lattice.len()];
        return Land { lattice, h0, e, b, height, sea_level_at_erosion: sea_level, sea_level, cells };
    };
    let mut reef = Reef { mask, ..Reef::new(lattice, params, height, sea_level) };
    reef.run();
    let height = (0..lattice.len()).map(|at| reef.height(at)).collect();
    Land {
        lattice,
        h0,
        e,
        b: reef.b,
        height,
        sea_level_at_erosion: sea_level,
        sea_level: reef.sea_level,
        cells,
    }
}

/// The base terrain after its steepest slopes have collapsed.
pub fn settled(plan: &Plan, mut h: Vec<f64>) -> Vec<f64> {
    let lattice = Lattice::new(plan.grid);
    let Some(settle) = plan.thermal.and_then(|thermal| thermal.settle) else { return h };
    let tangent = f64::from(settle.repose).tan();
    let mask = control(lattice, plan.controls.mask.as_deref());
    for _ in 0..thermal::settling_passes(f64::from(settle.length), lattice.cell) {
        let repose = |_| Some(tangent);
        let change = thermal::pass(lattice, Law::Excess, thermal::LARGEST_SHARE, &h, repose, |at| mask[at]);
        h.iter_mut().zip(change).for_each(|(h, change)| *h += change);
    }
    h
}

/// Hydraulic and thermal erosion together, or either of them.
pub fn erode(plan: &Plan, h0: &[f64]) -> Vec<Cell> {
    let lattice = Lattice::new(plan.grid);
    let mask = control(lattice, plan.controls.mask.as_deref());
    let Some(params) = plan.hydraulic else {
        let mut cells = vec![Cell::default(); lattice.len()];
        if let Some(thermal) = plan.thermal {
            slide(plan, h0, &mask, &mut cells, f64::from(thermal.duration));
        }
        return cells;
    };
    let mut erosion = Erosion::new(lattice, params, plan.boundary, f64::from(plan.sea_level), h0.to_vec());
    erosion.rain = control(lattice, plan.controls.rain.as_deref());
    erosion.erodibility = control(lattice, plan.controls.erodibility.as_deref());
    erosion.mask = mask;
    let (mut cells, mut flow, mut next) = (erosion.start(), Flow::default(), Vec::new());
    for iteration in 1..=hydraulic::iterations(&params, lattice.cell) {
        erosion.iterate(&mut cells, &mut flow, &mut next);
        if let Some(thermal) = plan.thermal
            && iteration.is_multiple_of(thermal.every as usize)
        {
            slide(plan, h0, &erosion.mask, &mut cells, erosion.step * f64::from(thermal.every));
        }
    }
    cells
}

/// Thermal erosion of a time, in as many passes as it takes.
fn slide(plan: &Plan, h0: &[f64], mask: &[f64], cells: &mut [Cell], time: f64) {
    let Some(params) = plan.thermal else { return };
    let lattice = Lattice::new(plan.grid);
    let (land, water) = (f64::from(params.repose).tan(), f64::from(params.repose_under_water).tan());
    let (passes, share) = thermal::passes(f64::from(params.diffusivity), time, lattice.cell);
    for _ in 0..passes {
        let h: Vec<f64> = h0.iter().zip(cells.iter()).map(|(h0, cell)| h0 + cell.e).collect();
        let repose = |at: usize| {
            let under_water = plan.boundary == Boundary::Sea && h[at] < f64::from(plan.sea_level);
            Some(if under_water { water } else { land })
        };
        let change = thermal::pass(lattice, params.law, share, &h, repose, |at| mask[at]);
        cells.iter_mut().zip(change).for_each(|(cell, change)| cell.e += change);
    }
}

fn control(lattice: Lattice, map: Option<&Map>) -> Vec<f64> {
    map.map_or_else(|| vec![1.0; lattice.len()], |map| base::bilinear(lattice, map))
}
