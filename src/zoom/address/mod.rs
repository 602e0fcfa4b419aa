//! Where something is, at any depth: places of as many digits as they need, lattice cells, and codes to write places down.

mod fixed;
mod location;

pub use fixed::{Coordinate, Fixed};
pub use location::{Attitude, CodeError, Location, MOST_LETTERS};

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

/// A cell of the lattice of one level, by its lower corner, and also the tile that covers it. Coordinates are modulo 2⁶⁴: the world
/// repeats after 2⁶⁴ cells of any level, and no view is wider than 2¹⁶ of them, so two cells of one view are never mixed up. The
/// parent is not known from this alone (its coordinates' highest bits are gone), children and neighbours are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    pub level: u32,
    pub x: u64,
    pub z: u64,
}

impl Cell {
    /// The quarter with the lower or upper (0 or 1) half of x and of z.
    pub fn child(self, [x, z]: [u32; 2]) -> Cell {
        let half = |of: u64, upper: u32| of.wrapping_mul(2).wrapping_add(upper.into());
        Cell { level: self.level + 1, x: half(self.x, x), z: half(self.z, z) }
    }
}

impl Place {
    /// The cell of a level above or below which the place is.
    pub fn cell(&self, level: u32) -> Cell {
        Cell { level, x: self.x.slice(level), z: self.z.slice(level) }
    }

    /// The cell of the level before that a cell is a quarter of: the one near this place of those that it could be. `None` at level 0.
    pub fn parent(&self, cell: Cell) -> Option<Cell> {
        let near = self.cell(cell.level.checked_sub(1)?);
        let half = |coordinate: u64, near: u64| {
            let from = coordinate.wrapping_sub(near.wrapping_mul(2)) as i64;
            near.wrapping_add((from >> 1) as u64)
        };
        Some(Cell { level: near.level, x: half(cell.x, near.x), z: half(cell.z, near.z) })
    }

    /// Digits behind the point in the longest of the three numbers.
    pub fn digits(&self) -> u32 {
        self.x.digits().max(self.y.digits()).max(self.z.digits())
    }
}
