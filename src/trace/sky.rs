//! Where the sky is bright: the table that `glsl/lib/dome.glsl` looks for light by.

use crate::scene::{Sky, dome};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Columns and rows for skies without a small sun in them.
const SMOOTH: [u32; 2] = [128, 128];

/// Most columns and rows.
const FINEST: [u32; 2] = [2048, 1024];

/// How much less often light from below the horizon is looked for: most of it does not arrive anywhere.
const BELOW: f64 = 0.25;

/// Columns and rows of the table: a multiple of a picture's, for its light changes within a texel, or a whole part of them.
pub fn size(sky: &Sky) -> [u32; 2] {
    const MOST_TIMES: u32 = 4;
    let Sky::Map(map) = sky else { return SMOOTH };
    let part = map.width.div_ceil(FINEST[0]).max(map.height.div_ceil(FINEST[1])).max(1);
    let times = (FINEST[0] / map.width.max(1)).min(FINEST[1] / map.height.max(1)).clamp(1, MOST_TIMES);
    [map.width, map.height].map(|count| (count * times).div_ceil(part).max(1))
}

/// Of the table, bytes.
pub fn bytes(sky: &Sky) -> u64 {
    let [columns, rows] = size(sky).map(u64::from);
    4 * (rows + rows * columns)
}

/// How much of the light comes from above the end of each row, and within each row from before the end of each cell. Below the
/// horizon of skies that are none of a picture nothing is looked for: paths find light there by themselves.
pub fn table(sky: &Sky) -> Vec<f32> {
    let [columns, rows] = size(sky).map(|count| count as usize);
    // Parts of each side of a cell, at whose ends we look. Looking at its rim, too, finds light that barely reaches into it: what
    // has no share is only met by chance.
    let (fine, below) = match sky {
        Sky::Map(map) => (map.width.div_ceil(columns as u32) as usize, BELOW),
        _ => (2, 0.0),
    };
    let cell = |row: usize, column: usize| {
        let at = |index: usize, sample: usize| index as f64 + sample as f64 / fine as f64;
        let ends = fine + 1;
        let samples = (0..ends * ends).map(|index| {
            let zenith = PI * at(row, index / ends) / rows as f64;
            let azimuth = 2.0 * PI * at(column, index % ends) / columns as f64;
            let view = DVec3::new(zenith.sin() * azimuth.sin(), zenith.cos(), -zenith.sin() * azimuth.cos());
            let [red, green, blue] = dome::radiance(sky, view);
            let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
            luminance * zenith.sin() * if view.y < 0.0 { below } else { 1.0 }
        });
        samples.sum::<f64>()
    };
    let row = |row: usize| (0..columns).map(|column| cell(row, column)).collect::<Vec<f64>>();
    let cells: Vec<Vec<f64>> = (0..rows).into_par_iter().map(row).collect();
    let sums: Vec<f64> = cells.iter().map(|cells| cells.iter().sum()).collect();
    let mut table = running_shares(&sums);
    cells.iter().for_each(|cells| table.extend(running_shares(cells)));
    table
}

/// The share of the sum that each value and those before it make; evenly if all are 0.
fn running_shares(values: &[f64]) -> Vec<f32> {
    let whole: f64 = values.iter().sum();
    let mut sum = 0.0;
    let share = |(index, value): (usize, &f64)| {
        sum += value;
        if whole > 0.0 { (sum / whole) as f32 } else { (index + 1) as f32 / values.len() as f32 }
    };
    values.iter().enumerate().map(share).collect()
}
