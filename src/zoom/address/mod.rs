//! Where something is, at any depth: places of as many digits as they need, lattice cells, and codes to write places down.

mod fixed;
mod location;
mod residue;

pub use fixed::{Coordinate, Fixed};
pub use location::{Attitude, CodeError, Location, MOST_LETTERS};

use residue::Residue;

/// The deepest level. A place so deep is 400 KB.
pub const DEEPEST: u32 = 1 << 20;

/// A point in space.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Place {
    /// East, cells of level 0.
    pub x: Fixed,
    /// Up, amplitudes of octave 0.
    pub y: Fixed,
    /// South, cells of level 0.
    pub z: Fixed,
}

/// A cell of the lattice of one level, by its lower corner, and also the tile that covers it.
///
/// Coordinates are modulo 2⁶⁴, which is all that heights depend on beside those of the level before. What is kept of one place must not be taken
/// for that of another, though, that has the same last 64 digits; so cells also have their coordinates modulo the prime 2⁶¹ − 1. Two are told
/// apart unless they are a multiple of 2⁶⁴ (2⁶¹ − 1) cells apart. k · 2ⁿ cells are never that, for any n, if k is less than the prime: digits
/// that one move leaves as they are don't matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    pub level: u32,
    pub x: u64,
    pub z: u64,
    /// x and z modulo 2⁶¹ − 1.
    residues: [Residue; 2],
}

impl Cell {
    /// The cell of level 0 with these coordinates.
    pub fn whole(x: i64, z: i64) -> Cell {
        Cell { level: 0, x: x as u64, z: z as u64, residues: [x, z].map(Residue::from) }
    }

    /// The quarter with the lower or upper (0 or 1) half of x and of z.
    pub fn child(self, quarter: [u32; 2]) -> Cell {
        self.descendant(1, quarter.map(u64::from))
    }

    /// The cell this many levels below, east and south of the first one there.
    pub fn descendant(self, levels: u32, [east, south]: [u64; 2]) -> Cell {
        let scale = |of: u64| if levels < 64 { of << levels } else { 0 };
        let first = Cell {
            level: self.level + levels,
            x: scale(self.x),
            z: scale(self.z),
            residues: self.residues.map(|of| of.doubled(levels)),
        };
        first.beside(east as i64, south as i64)
    }

    /// The cell this far to the east and south.
    pub fn beside(self, east: i64, south: i64) -> Cell {
        let [x, z] = self.residues;
        Cell {
            x: self.x.wrapping_add_signed(east),
            z: self.z.wrapping_add_signed(south),
            residues: [x.plus(east), z.plus(south)],
            ..self
        }
    }
}

impl Place {
    /// The cell of a level above or below which the place is.
    pub fn cell(&self, level: u32) -> Cell {
        let [x, z] = [&self.x, &self.z].map(|number| (number.slice(level), number.residue(level)));
        Cell { level, x: x.0, z: z.0, residues: [x.1, z.1] }
    }

    /// The cell of the level before that a cell is a quarter of, if the cell is less than 2⁶² cells from here. `None` at level 0.
    pub fn parent(&self, cell: Cell) -> Option<Cell> {
        let level = cell.level.checked_sub(1)?;
        // Which of the two numbers that are half of one modulo 2⁶⁴ is told by what is near.
        let half = |fine: u64, number: &Fixed| {
            let near = number.slice(level);
            near.wrapping_add_signed(fine.wrapping_sub(near.wrapping_mul(2)) as i64 >> 1)
        };
        let (x, z) = (half(cell.x, &self.x), half(cell.z, &self.z));
        let [east, south] = cell.residues;
        Some(Cell { level, x, z, residues: [east.halved(cell.x & 1), south.halved(cell.z & 1)] })
    }

    /// Digits behind the point in the longest of the three numbers.
    pub fn digits(&self) -> u32 {
        self.x.digits().max(self.y.digits()).max(self.z.digits())
    }
}
