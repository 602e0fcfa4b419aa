//! A square raster and the neighbours of its cells.

use rayon::prelude::*;
use terrane::core::grid::Grid;

/// Columns and rows to the neighbours: L, R, T, B, TL, TR, BL, BR.
pub const OFFSETS: [(isize, isize); 8] =
    [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];

/// From a neighbour back to the cell.
pub const OPPOSITE: [usize; 8] = [1, 0, 3, 2, 7, 6, 5, 4];

#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    pub n: usize,
    /// Distance between neighbouring samples ℓ, m.
    pub cell: f64,
}

impl Lattice {
    pub fn new(grid: Grid) -> Self {
        Self { n: grid.cells as usize, cell: f64::from(grid.extent) / f64::from(grid.cells - 1) }
    }

    pub fn len(self) -> usize {
        self.n * self.n
    }

    pub fn index(self, i: usize, j: usize) -> usize {
        j * self.n + i
    }

    /// World x (east) and z (south) of column `i`, row `j`, m.
    pub fn position(self, i: usize, j: usize) -> [f64; 2] {
        let half = self.cell * (self.n - 1) as f64 / 2.0;
        [i as f64 * self.cell - half, j as f64 * self.cell - half]
    }

    /// The cell across side `k`, if it is on the grid.
    #[inline]
    pub fn neighbour(self, i: usize, j: usize, k: usize) -> Option<usize> {
        let (x, y) = OFFSETS[k];
        let (i, j) = (i as isize + x, j as isize + y);
        let n = self.n as isize;
        (i >= 0 && j >= 0 && i < n && j < n).then_some((j * n + i) as usize)
    }

    /// The cell across side `k`, or the cell itself where there is none.
    pub fn clamped(self, i: usize, j: usize, k: usize) -> usize {
        self.neighbour(i, j, k).unwrap_or(self.index(i, j))
    }

    /// Distance to neighbour `k`, m.
    pub fn distance(self, k: usize) -> f64 {
        if k < 4 { self.cell } else { std::f64::consts::SQRT_2 * self.cell }
    }

    pub fn is_rim(self, i: usize, j: usize) -> bool {
        i == 0 || j == 0 || i == self.n - 1 || j == self.n - 1
    }

    /// A raster whose value at column i, row j is `value(i, j)`.
    pub fn map<T: Send + Default + Clone>(self, value: impl Fn(usize, usize) -> T + Sync) -> Vec<T> {
        let mut raster = Vec::new();
        self.fill(&mut raster, value);
        raster
    }

    /// The same in a raster's memory.
    pub fn fill<T: Send + Default + Clone>(
        self,
        raster: &mut Vec<T>,
        value: impl Fn(usize, usize) -> T + Sync,
    ) {
        raster.resize(self.len(), T::default());
        raster.par_chunks_mut(self.n).enumerate().for_each(|(j, row)| {
            row.iter_mut().enumerate().for_each(|(i, cell)| *cell = value(i, j));
        });
    }

    /// Gradient by central differences; beyond the rim lies the cell's own value.
    pub fn gradient(self, i: usize, j: usize, value: impl Fn(usize) -> f64) -> [f64; 2] {
        let at = |k| value(self.clamped(i, j, k));
        [(at(1) - at(0)) / (2.0 * self.cell), (at(3) - at(2)) / (2.0 * self.cell)]
    }
}

/// Sum over the eight neighbours in an order that flips and quarter turns leave alone.
pub fn sum(a: &[f64; 8]) -> f64 {
    ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[7]) + (a[5] + a[6]))
}

/// One value for each neighbour; unrolled, since whole islands are made of it.
#[inline(always)]
pub fn each<T>(value: impl Fn(usize) -> T) -> [T; 8] {
    [value(0), value(1), value(2), value(3), value(4), value(5), value(6), value(7)]
}
