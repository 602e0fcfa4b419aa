//! Where the sky is bright: the table that `glsl/lib/dome.glsl` looks for light by.

use crate::scene::{Sky, dome};
use glam::DVec3;
use std::f64::consts::PI;

/// The twins of `DOME_ROWS` and `DOME_COLUMNS`.
const ROWS: usize = 128;
const COLUMNS: usize = 128;

/// Samples along each side of a cell.
const FINE: usize = 2;

/// How much of the light comes from above the end of each row, and within each row from before the end of each cell. Nothing
/// is looked for below the horizon, where paths find light by themselves.
pub fn table(sky: &Sky) -> Vec<f32> {
    let cell = |row: usize, column: usize| {
        let fine = |index: usize| (index as f64 + 0.5) / FINE as f64;
        let samples = (0..FINE * FINE).map(|index| {
            let y = 1.0 - 2.0 * (row as f64 + fine(index / FINE)) / ROWS as f64;
            let azimuth = 2.0 * PI * ((column as f64 + fine(index % FINE)) / COLUMNS as f64 - 0.5);
            let level = (1.0 - y * y).sqrt();
            let [red, green, blue] =
                dome::radiance(sky, DVec3::new(level * azimuth.cos(), y, level * azimuth.sin()));
            if y < 0.0 { 0.0 } else { 0.2126 * red + 0.7152 * green + 0.0722 * blue }
        });
        samples.sum::<f64>()
    };
    let mut rows = Vec::with_capacity(ROWS);
    let mut columns = Vec::with_capacity(ROWS * COLUMNS);
    for row in 0..ROWS {
        let cells: Vec<f64> = (0..COLUMNS).map(|column| cell(row, column)).collect();
        rows.push(cells.iter().sum());
        columns.extend(running_shares(&cells));
    }
    let mut table = running_shares(&rows);
    table.extend(columns);
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
