//! The ground that plants stand on, as rasters on the host.

use super::distance::{FAR, distances};
use crate::core::grid::Grid;
use glam::{Vec2, Vec3};

/// What is known of the ground. Rasters have one value a sample of the grid, row by row from the north; an empty one is 0
/// everywhere.
#[derive(Clone, Debug)]
pub struct Ground {
    pub grid: Grid,
    /// Above the datum, metres.
    pub sea_level: f32,
    /// Above the datum, metres.
    pub height: Vec<f32>,
    /// Depth of rivers and lakes, metres; 0 in the sea.
    pub water: Vec<f32>,
    /// How lately water ran here, 0…1.
    pub wetness: Vec<f32>,
    /// Sum of the outflows, m³/s.
    pub flow: Vec<f32>,
    /// To the sea, and to any water, metres; empty until [`Ground::measure`] has been asked for them.
    to_sea: Vec<f32>,
    to_water: Vec<f32>,
}

/// What of the ground has to be known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    pub wetness: bool,
    pub flow: bool,
    /// Distance to the sea.
    pub sea: bool,
    /// Distance to any water.
    pub water: bool,
}

/// Rivers and lakes at least so deep are water that nothing grows in, metres; less is the rain of the last minutes on its
/// way.
pub const RIVER: f32 = 0.05;

impl Needs {
    pub fn or(self, other: Needs) -> Needs {
        Needs {
            wetness: self.wetness || other.wetness,
            flow: self.flow || other.flow,
            sea: self.sea || other.sea,
            water: self.water || other.water,
        }
    }
}

impl Ground {
    pub fn new(grid: Grid, sea_level: f32, height: Vec<f32>) -> Self {
        let [water, wetness, flow, to_sea, to_water] = [const { Vec::new() }; 5];
        Ground { grid, sea_level, height, water, wetness, flow, to_sea, to_water }
    }

    /// Memory that [`Ground`] takes, and what making it takes beside it, bytes.
    pub fn bytes(grid: Grid, needs: Needs) -> u64 {
        let Needs { wetness, flow, sea, water } = needs;
        let kept = 2 + [wetness, flow, sea, water].into_iter().filter(|need| *need).count();
        // Two rasters more while distances are measured.
        let passing = if sea || water { 2 } else { 0 };
        4 * grid.samples() as u64 * (kept + passing) as u64
    }

    /// Measures the distances that are needed.
    pub fn measure(&mut self, needs: Needs) {
        let (side, cell) = (self.grid.cells as usize, self.grid.cell_size());
        let is_sea = |sample: usize| self.height[sample] <= self.sea_level;
        let is_river = |sample: usize| self.water.get(sample).is_some_and(|depth| *depth >= RIVER);
        if needs.sea {
            self.to_sea = distances(side, cell, is_sea);
        }
        if needs.water {
            self.to_water = distances(side, cell, |sample| is_sea(sample) || is_river(sample));
        }
    }

    /// Boxes round the land above the sea; round the sea above all of the ground where there is none.
    pub fn land(&self) -> Vec<[Vec3; 2]> {
        const SIDE: usize = 64;
        let step = self.grid.extent / SIDE as f32;
        let boxes = |sea_only: bool| -> Vec<[Vec3; 2]> {
            let boxes = (0..SIDE * SIDE).filter_map(|index| {
                let west_north =
                    Vec2::new((index % SIDE) as f32, (index / SIDE) as f32) * step - self.grid.extent / 2.0;
                let range = self.height_range(west_north + step / 2.0, step / 2.0);
                let [least, greatest] = range.map(|height| height.max(self.sea_level));
                let shown = sea_only || range[1] > self.sea_level;
                let corner = |at: Vec2, height: f32| Vec3::new(at.x, height, at.y);
                shown.then(|| [corner(west_north, least), corner(west_north + step, greatest)])
            });
            boxes.collect()
        };
        let land = boxes(false);
        if land.is_empty() { boxes(true) } else { land }
    }

    /// Whether a place lies on the terrain.
    pub fn contains(&self, at: Vec2) -> bool {
        at.abs().max_element() <= self.grid.extent / 2.0
    }

    /// Height of the ground above the datum as renderers draw it (`height_cubic` in `glsl/lib/heightfield.glsl`), metres: a
    /// cubic through all samples (Catmull & Rom 1974) that overshoots them by little.
    pub fn height_at(&self, at: Vec2) -> f32 {
        let (cell, fraction) = self.cell(at);
        let across = catmull_rom(fraction.x);
        let rows = [-1, 0, 1, 2].map(|row| limited(across, self.row(cell, row)));
        limited(catmull_rom(fraction.y), rows)
    }

    /// Least and greatest height of the samples round the square `at ± reach`.
    pub fn height_range(&self, at: Vec2, reach: f32) -> [f32; 2] {
        let side = self.grid.cells as usize;
        let [[west, north], [east, south]] = [at - reach, at + reach].map(|corner| self.cell(corner).0);
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for row in north as usize..(south as usize + 2).min(side) {
            for height in &self.height[row * side..][west as usize..(east as usize + 2).min(side)] {
                range = [range[0].min(*height), range[1].max(*height)];
            }
        }
        range
    }

    /// Slope (dh/dx, dh/dz) of the B-spline through the samples, from which renderers shade (`height_slope` there).
    pub fn gradient(&self, at: Vec2) -> Vec2 {
        let (cell, fraction) = self.cell(at);
        let [across, across_derivative] = [b_spline(fraction.x), b_spline_derivative(fraction.x)];
        let [down, down_derivative] = [b_spline(fraction.y), b_spline_derivative(fraction.y)];
        let mut slope = Vec2::ZERO;
        for row in 0..4 {
            let samples = self.row(cell, row as i64 - 1);
            slope += Vec2::new(
                down[row] * dot(across_derivative, samples),
                down_derivative[row] * dot(across, samples),
            );
        }
        slope / self.grid.cell_size()
    }

    /// Unit vector that points away from the ground.
    pub fn normal(gradient: Vec2) -> Vec3 {
        Vec3::new(-gradient.x, 1.0, -gradient.y).normalize()
    }

    /// Whether a place at this height is above the sea and out of rivers and lakes.
    pub fn is_dry(&self, at: Vec2, height: f32) -> bool {
        height > self.sea_level && self.bilinear(&self.water, at, 0.0) < RIVER
    }

    pub fn wetness_at(&self, at: Vec2) -> f32 {
        self.bilinear(&self.wetness, at, 0.0)
    }

    pub fn flow_at(&self, at: Vec2) -> f32 {
        self.bilinear(&self.flow, at, 0.0)
    }

    /// Distance to the sea, metres.
    pub fn to_sea_at(&self, at: Vec2) -> f32 {
        self.bilinear(&self.to_sea, at, FAR)
    }

    /// Distance to the next river, lake or sea, metres.
    pub fn to_water_at(&self, at: Vec2) -> f32 {
        self.bilinear(&self.to_water, at, FAR)
    }

    fn bilinear(&self, raster: &[f32], at: Vec2, empty: f32) -> f32 {
        if raster.is_empty() {
            return empty;
        }
        let ([column, row], fraction) = self.cell(at);
        let side = self.grid.cells as usize;
        let line = |row: i64| {
            let start = row.min(side as i64 - 1) as usize * side;
            let west = raster[start + column as usize];
            let east = raster[start + (column as usize + 1).min(side - 1)];
            west + (east - west) * fraction.x
        };
        let (north, south) = (line(row), line(row + 1));
        north + (south - north) * fraction.y
    }

    /// Column and row of the sample north-west of a place, and how far on the way to the next ones it lies.
    fn cell(&self, at: Vec2) -> ([i64; 2], Vec2) {
        let last = (self.grid.cells - 1) as f32;
        let place =
            ((at + self.grid.extent / 2.0) / self.grid.cell_size()).clamp(Vec2::ZERO, Vec2::splat(last));
        let cell = place.floor();
        ([cell.x as i64, cell.y as i64], place - cell)
    }

    /// Four samples of a row, from the one west of the cell; at the edge they repeat.
    fn row(&self, [column, row]: [i64; 2], down: i64) -> [f32; 4] {
        let last = i64::from(self.grid.cells) - 1;
        let start = (row + down).clamp(0, last) as usize * self.grid.cells as usize;
        [-1, 0, 1, 2].map(|across| self.height[start + (column + across).clamp(0, last) as usize])
    }
}

fn dot(weights: [f32; 4], samples: [f32; 4]) -> f32 {
    weights.iter().zip(samples).map(|(weight, sample)| weight * sample).sum()
}

/// The cubic between the middle two samples, which passes them by at most 15 % of their difference.
fn limited(weights: [f32; 4], samples: [f32; 4]) -> f32 {
    let (least, greatest) = (samples[1].min(samples[2]), samples[1].max(samples[2]));
    let margin = OVERSHOOT * (greatest - least);
    dot(weights, samples).clamp(least - margin, greatest + margin)
}

/// Share of the difference between two samples by which the ground may pass them.
pub const OVERSHOOT: f32 = 0.15;

fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2]
        .map(|weight| 0.5 * weight)
}

fn b_spline(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 4.0 - 6.0 * t * t + 3.0 * t * t * t, 4.0 - 6.0 * s * s + 3.0 * s * s * s, t * t * t]
        .map(|weight| weight / 6.0)
}

fn b_spline_derivative(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-s * s, 3.0 * t * t - 4.0 * t, 3.0 * t - 3.0 * t * t + s, t * t].map(|weight| 0.5 * weight)
}
