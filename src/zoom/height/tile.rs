//! The heights of a tile as the device makes and keeps them: 32-bit differences to the tile's base.

use super::{AMPLITUDE, Corners, FRACTION_BITS, Gradient, Shaded, Surface, rises, shading, twice};
use crate::zoom::address::Cell;
use std::num::Wrapping;

/// A tile: N × N quads over one cell of its level, with a ring of one more vertex around for normals at its borders. Its vertices are of the
/// level `cell.level` + log₂ N.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    pub cell: Cell,
    /// log₂ N.
    pub bits: u32,
    /// What heights are differences to, modulo 2⁶⁴.
    pub base: i64,
    /// N + 3 rows of N + 3; the first of both is one step outside.
    heights: Vec<Wrapping<i32>>,
    /// As many; 0 outside.
    gradients: Vec<Gradient>,
}

/// Vertices along a side, with the ring.
fn side(bits: u32) -> usize {
    (1 << bits) + 3
}

/// The base of a tile, from the heights of its cell's corners: the middle between the lowest and the highest of them, as a whole number of amplitudes, in
/// the unit of the tile's vertices. Any number would do, since every step of the recurrence commutes with adding whole numbers, and so
/// neighbours with different bases agree; this one keeps differences small.
pub fn base(corners: Corners, bits: u32) -> i64 {
    let [least, most] = corners.extremes();
    let middle = least.wrapping_add(most.wrapping_sub(least) / 2);
    (middle >> FRACTION_BITS).wrapping_mul(AMPLITUDE << bits)
}

impl Tile {
    /// Comes from four vertices of the cell's own level and those around them: refines the ring and all within it. `None` if the patch is of another level
    /// or lacks some of these.
    pub fn from_patch(surface: &Surface, patch: &Shaded, cell: Cell, bits: u32) -> Option<Tile> {
        patch.patch().find(cell)?;
        let mut block = patch.part(cell.x.wrapping_sub(1), cell.z.wrapping_sub(1), 4)?;
        let base = base(block.patch().corners(1, 1), bits);
        for level in 1..=bits {
            let first = |coordinate: u64| (coordinate << level).wrapping_sub(1);
            block = block.refine(surface, first(cell.x), first(cell.z), side(level))?;
        }
        let heights = block.patch().heights().map(|height| Wrapping(height.wrapping_sub(base) as i32));
        Some(Tile { cell, bits, base, heights: heights.collect(), gradients: block.gradients().to_vec() })
    }

    /// One of its four quarters (see [`Cell::child`]), from nothing but itself, in 32 bits: what `zoom/height.comp` does.
    pub fn child(&self, surface: &Surface, quarter: [u32; 2], base: i64) -> Tile {
        let cell = self.cell.child(quarter);
        let side = self.side();
        // The ring keeps itself up: vertex −1 of a child hangs on −1 and 0 of its parent.
        let first = quarter.map(|upper| 1 + ((upper as usize) << self.bits));
        let outside = |of: Cell| [of.x, of.z].map(|coordinate| (coordinate << self.bits).wrapping_sub(1));
        let [parent_x, parent_z] = outside(self.cell);
        let rises = |column: usize, row: usize| {
            rises(parent_x.wrapping_add(column as u64), parent_z.wrapping_add(row as u64))
        };
        let [x, z] = outside(cell);
        let noise = surface.octave(cell.level + self.bits).square(x, z, side);
        let shift = Wrapping(base.wrapping_sub(self.base.wrapping_mul(2)) as i32);
        let mut heights = Vec::with_capacity(side * side);
        for (fine_z, noise) in (first[1]..).zip(noise.chunks_exact(side)) {
            let (row, odd_z) = (fine_z / 2, fine_z % 2 == 1);
            for (fine_x, noise) in (first[0]..).zip(noise) {
                let (column, odd_x) = (fine_x / 2, fine_x % 2 == 1);
                let at = |right, down| self.heights[(row + down) * side + column + right];
                let coarse = twice(surface.refinement, [odd_x, odd_z], rises(column, row), at);
                heights.push(coarse + Wrapping(*noise) - shift);
            }
        }
        let settled = |column, row| {
            let index = row * side + column;
            let slope = shading::central(&self.heights, side, index).map(|rise| rise.0);
            shading::settled(self.gradients[index], slope)
        };
        let gradients = shading::finer(first, &noise, side, rises, settled);
        Tile { cell, bits: self.bits, base, heights, gradients }
    }

    /// Vertices along a side, with the ring.
    pub fn side(&self) -> usize {
        side(self.bits)
    }

    /// Differences to the base, rows of x.
    pub fn heights(&self) -> impl Iterator<Item = i32> + '_ {
        self.heights.iter().map(|height| height.0)
    }

    /// A height modulo 2⁶⁴. The first column and row are outside the tile, the second its border.
    pub fn height(&self, column: usize, row: usize) -> i64 {
        self.base.wrapping_add(self.heights[row * self.side() + column].0.into())
    }

    /// What it is shaded by, rows of x; 0 in the ring.
    pub fn gradients(&self) -> &[Gradient] {
        &self.gradients
    }
}
