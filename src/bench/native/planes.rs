//! Fields over the grid in rows, with a margin of one cell so that no loop asks whether a cell has a neighbour.

use rayon::prelude::*;

/// Some fields of one grid. A row of the grid holds a row of each, one behind the other, so that rows can be written by
/// several threads.
pub struct Planes {
    cells: usize,
    planes: usize,
    data: Vec<f32>,
}

/// A row of a field and the same row of its neighbours L, R, T, B, TL, TR, BL, BR.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    pub here: &'a [f32],
    pub beside: [&'a [f32]; 8],
}

/// From a neighbour back to the cell.
pub const OPPOSITE: [usize; 8] = [1, 0, 3, 2, 7, 6, 5, 4];

/// What lies in the margin.
#[derive(Clone, Copy)]
pub enum Margin {
    /// The rim again.
    Rim,
    /// One value.
    Value(f32),
}

impl Planes {
    /// Fields of `cells` × `cells`, zero, with a margin of zero.
    pub fn new(cells: usize, planes: usize) -> Planes {
        Planes { cells, planes, data: vec![0.0; (cells + 2) * planes * (cells + 2)] }
    }

    /// Along a side of the grid.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// How many fields there are.
    pub fn planes(&self) -> usize {
        self.planes
    }

    /// Row `y` of field `plane`.
    pub fn row(&self, y: usize, plane: usize) -> &[f32] {
        &self.padded(y + 1, plane)[1..=self.cells]
    }

    /// Row `y` of field `plane` and its neighbours.
    pub fn around(&self, y: usize, plane: usize) -> Around<'_> {
        Around::of([y, y + 1, y + 2].map(|y| self.padded(y, plane)))
    }

    /// A whole field, row by row.
    pub fn plane(&self, plane: usize) -> Vec<f32> {
        (0..self.cells).flat_map(|y| self.row(y, plane)).copied().collect()
    }

    /// Rows to write, of all fields; [`split`] parts them.
    pub fn rows_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [f32]> {
        let row = self.planes * (self.cells + 2);
        self.data[row..row * (self.cells + 1)].par_chunks_exact_mut(row)
    }

    /// Fills the margin of every field.
    pub fn surround(&mut self, margin: Margin) {
        let width = self.cells + 2;
        let row = self.planes * width;
        for cells in self.data.chunks_exact_mut(width) {
            match margin {
                Margin::Rim => (cells[0], cells[width - 1]) = (cells[1], cells[width - 2]),
                Margin::Value(value) => (cells[0], cells[width - 1]) = (value, value),
            }
        }
        let last = row * (self.cells + 1);
        match margin {
            Margin::Rim => {
                self.data.copy_within(row..2 * row, 0);
                self.data.copy_within(last - row..last, last);
            }
            Margin::Value(value) => {
                self.data[..row].fill(value);
                self.data[last..].fill(value);
            }
        }
    }

    /// Row `y`, counted with the margin, with its margin.
    pub fn padded(&self, y: usize, plane: usize) -> &[f32] {
        let width = self.cells + 2;
        let start = (y * self.planes + plane) * width;
        &self.data[start..start + width]
    }
}

impl<'a> Around<'a> {
    /// Of three rows with their margins, from north to south.
    pub fn of(rows: [&'a [f32]; 3]) -> Around<'a> {
        let [north, here, south] = rows.map(|row| {
            let cells = row.len() - 2;
            [&row[..cells], &row[1..=cells], &row[2..]]
        });
        let [tl, t, tr] = north;
        let [l, here, r] = here;
        let [bl, b, br] = south;
        Around { here, beside: [l, r, t, b, tl, tr, bl, br] }
    }
}

/// The first `N` fields of a row of `planes` fields, without their margins.
pub fn split<const N: usize>(row: &mut [f32], planes: usize) -> [&mut [f32]; N] {
    let width = row.len() / planes;
    let mut fields = row.chunks_exact_mut(width).map(|field| &mut field[1..width - 1]);
    std::array::from_fn(|_| fields.next().unwrap_or_default())
}
