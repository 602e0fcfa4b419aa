//! Blue noise: points at random, none nearer to another than a given distance, as densely as they fall.
//!
//! Darts are thrown into the cells of a grid, so small that each holds one point at most, in rounds; a dart too near to a point
//! is lost. Cells of a round that are three apart can't touch each other and are worked on at the same time (Wei 2008,
//! "Parallel Poisson Disk Sampling"). All decisions are taken in whole numbers, and every dart depends on nothing but the seed,
//! its cell and its round: the points are the same on every machine and with any number of threads.

use super::random::Random;
use glam::Vec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// Points in the square `±half`.
pub struct Darts {
    /// Side of a cell, metres: the least distance over √2.
    side: f64,
    /// Column and row of the first cell; cell 0 begins at the origin.
    first: i32,
    /// Cells along a side.
    count: usize,
    /// The place of the point in each cell, in 2⁻¹⁶ of its side, or [`FREE`] or [`CLOSED`].
    cells: Vec<AtomicU32>,
}

const FREE: u32 = u32::MAX;
const CLOSED: u32 = u32::MAX - 1;

/// Steps of a place in a cell.
const STEPS: u32 = 1 << 16;
/// Square of the least distance, in these steps: a cell's side is that distance over √2.
const LEAST_SQUARE: i64 = 2 * (STEPS as i64 * STEPS as i64);

/// Rounds of darts.
const ROUNDS: u32 = 10;

/// Points in a square of one least distance, far from any edge, on average (measured on 10⁷ points; 0.696 would be the
/// most that random darts can reach).
pub const PACKING: f64 = 0.6121;

/// Coordinates are rounded to floats, whose steps are 2⁻²³ of their size; with at most 8192 cells along a side two points come
/// nearer to each other by less than this share of their distance.
const ROUNDING: f64 = 5e-4;

/// Cells along a side of the square `±half` for points at least `distance` apart, metres.
pub fn cells_along(half: f32, distance: f64) -> u64 {
    (2.0 * f64::from(half) / (distance / std::f64::consts::SQRT_2)).ceil() as u64 + 1
}

impl Darts {
    /// Throws darts at the cells for whose middle `is_open` holds. The points are at least `distance` metres apart, in
    /// single precision too.
    pub fn throw(seed: u32, half: f32, distance: f64, is_open: impl Fn(Vec2) -> bool + Sync) -> Darts {
        let side = distance * (1.0 + ROUNDING) / std::f64::consts::SQRT_2;
        // Phases and places begin at the origin, however large the square is.
        let first = -3 * (f64::from(half) / side / 3.0).ceil() as i32;
        let count = (first.unsigned_abs() * 2) as usize;
        let cells: Vec<AtomicU32> = (0..count * count)
            .into_par_iter()
            .map(|index| {
                let [x, z] =
                    [index % count, index / count].map(|at| (at as f64 + 0.5 + f64::from(first)) * side);
                AtomicU32::new(if is_open(Vec2::new(x as f32, z as f32)) { FREE } else { CLOSED })
            })
            .collect();
        let darts = Darts { side, first, count, cells };
        for round in 0..ROUNDS {
            for phase in PHASES {
                darts.round(seed, round, phase);
            }
        }
        darts
    }

    /// Throws one dart into every third cell across and down.
    fn round(&self, seed: u32, round: u32, [column, row]: [usize; 2]) {
        let rows = self.count.saturating_sub(row).div_ceil(3);
        (0..rows).into_par_iter().for_each(|index| {
            let row = row + 3 * index;
            for column in (column..self.count).step_by(3) {
                let cell = &self.cells[row * self.count + column];
                if cell.load(Ordering::Relaxed) != FREE {
                    continue;
                }
                let mut random = Random::of_cell(seed, DARTS + round, self.place_of([column, row]));
                let dart = random.bits();
                if dart < CLOSED && self.is_clear([column, row], dart) {
                    cell.store(dart, Ordering::Relaxed);
                }
            }
        });
    }

    /// Whether no point is nearer to the dart than the least distance.
    fn is_clear(&self, [column, row]: [usize; 2], dart: u32) -> bool {
        let [x, z] = inside(dart);
        let rows = row.saturating_sub(2)..(row + 3).min(self.count);
        rows.into_iter().all(|other_row| {
            let start = column.saturating_sub(2);
            let line = &self.cells[other_row * self.count..][start..(column + 3).min(self.count)];
            line.iter().enumerate().all(|(index, cell)| {
                let point = cell.load(Ordering::Relaxed);
                if point >= CLOSED {
                    return true;
                }
                let [other_x, other_z] = inside(point);
                let step = i64::from(STEPS);
                let across = ((start + index) as i64 - column as i64) * step + other_x - x;
                let down = (other_row as i64 - row as i64) * step + other_z - z;
                across * across + down * down >= LEAST_SQUARE
            })
        })
    }

    /// Rows of cells.
    pub fn rows(&self) -> usize {
        self.count
    }

    /// The points of a row of cells, each with its cell.
    pub fn row(&self, row: usize) -> impl Iterator<Item = ([i32; 2], Vec2)> + '_ {
        let line = &self.cells[row * self.count..][..self.count];
        line.iter().enumerate().filter_map(move |(column, cell)| {
            let point = cell.load(Ordering::Relaxed);
            if point >= CLOSED {
                return None;
            }
            let cell = self.place_of([column, row]);
            let [x, z] = inside(point);
            let metres = |cell: i32, steps: i64| {
                ((f64::from(cell) + steps as f64 / f64::from(STEPS)) * self.side) as f32
            };
            Some((cell, Vec2::new(metres(cell[0], x), metres(cell[1], z))))
        })
    }

    fn place_of(&self, cell: [usize; 2]) -> [i32; 2] {
        cell.map(|at| at as i32 + self.first)
    }
}

/// Column and row of the cells of a phase, in an order without direction.
const PHASES: [[usize; 2]; 9] = [[0, 0], [2, 1], [1, 2], [1, 0], [0, 2], [2, 2], [0, 1], [2, 0], [1, 1]];

fn inside(place: u32) -> [i64; 2] {
    [i64::from(place >> 16), i64::from(place & 0xffff)]
}

/// Purpose of random numbers.
const DARTS: u32 = 0x6461_0000;
