//! Thermal erosion (docs/model.md, section 3).

use super::{
    CHANGE, Ground, HEIGHT,
    planes::{Around, Margin, Planes, split},
};
use crate::terrain::{
    Plan,
    thermal::{LARGEST_RATE, Law, Params},
};
use rayon::prelude::*;
use std::f32::consts::SQRT_2;

pub struct Thermal {
    law: Law,
    half_rate: f32,
    /// Of the repose slope over one cell: on land, under water.
    rise: [f32; 2],
    sea_level: f32,
    /// What a cell gives for each metre of drop to a steeper neighbour.
    rate: Planes,
}

/// Higher than any ground: nothing slides off the grid.
const NOWHERE: f32 = 1e30;

impl Thermal {
    pub fn new(plan: &Plan, params: &Params) -> Thermal {
        let cell = f64::from(plan.grid.extent) / f64::from(plan.grid.cells - 1);
        let all = 4.0 * f64::from(params.diffusivity) * f64::from(params.duration) / (cell * cell);
        let passes = (all / LARGEST_RATE).ceil().max(1.0);
        let rise = |repose: f32| (f64::from(repose).tan() * cell) as f32;
        Thermal {
            law: params.law,
            half_rate: (0.5 * all / passes) as f32,
            rise: [rise(params.repose), rise(params.repose_under_water)],
            sea_level: plan.acting_sea_level(),
            rate: Planes::new(plan.grid.cells as usize, 1),
        }
    }

    pub fn step(&mut self, ground: &mut Ground) {
        let Thermal { law, half_rate, rise, sea_level, ref mut rate } = *self;
        ground.now.surround(Margin::Value(NOWHERE));
        let (now, start) = (&ground.now, &ground.start);
        rate.rows_mut().enumerate().for_each(|(y, row)| {
            let [rate] = split(row, 1);
            give(rate, now.around(y, HEIGHT), law, half_rate, rise, sea_level);
        });
        let rate = &*rate;
        ground.next.rows_mut().enumerate().for_each(|(y, row)| {
            let [height, change] = split(row, 2);
            change.copy_from_slice(now.row(y, CHANGE));
            let (h, given) = (now.around(y, HEIGHT), rate.around(y, 0));
            for k in 0..8 {
                let length = if k < 4 { 1.0 } else { SQRT_2 };
                let neighbour = (h.beside[k], given.beside[k]);
                slide(change, (h.here, given.here), neighbour, rise.map(|rise| rise * length), sea_level);
            }
            add(height, start.row(y, 0), change);
        });
        ground.swap();
    }
}

fn give(rate: &mut [f32], h: Around, law: Law, half_rate: f32, rise: [f32; 2], sea_level: f32) {
    let n = rate.len();
    let (here, beside) = (&h.here[..n], h.beside.map(|row| &row[..n]));
    for x in 0..n {
        let own = here[x];
        let rise = if own < sea_level { rise[1] } else { rise[0] };
        let (mut excess, mut most, mut steep) = (0.0_f32, 0.0_f32, 0.0);
        for (k, row) in beside.iter().enumerate() {
            let drop = own - row[x];
            let over = drop - if k < 4 { rise } else { SQRT_2 * rise };
            excess = excess.max(over);
            most = most.max(drop);
            steep += if over > 0.0 { drop } else { 0.0 };
        }
        let moved = if law == Law::Excess { excess } else { most };
        rate[x] = if steep > 0.0 { half_rate * moved / steep } else { 0.0 };
    }
}

/// What slides between a row and the row of one neighbour; each comes with what it gives.
fn slide(change: &mut [f32], own: (&[f32], &[f32]), other: (&[f32], &[f32]), rise: [f32; 2], sea_level: f32) {
    let n = change.len();
    let (h, rate) = (&own.0[..n], &own.1[..n]);
    let (h_n, rate_n) = (&other.0[..n], &other.1[..n]);
    let rise = |h: f32| if h < sea_level { rise[1] } else { rise[0] };
    for x in 0..n {
        let drop = h[x] - h_n[x];
        let (given, taken) = (rate[x] * drop, rate_n[x] * -drop);
        let given = if drop > rise(h[x]) { given } else { 0.0 };
        let taken = if -drop > rise(h_n[x]) { taken } else { 0.0 };
        change[x] += taken - given;
    }
}

fn add(sum: &mut [f32], first: &[f32], second: &[f32]) {
    for ((sum, first), second) in sum.iter_mut().zip(first).zip(second) {
        *sum = first + second;
    }
}
