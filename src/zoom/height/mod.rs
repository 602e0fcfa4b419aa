//! The surface: whole numbers at the vertices of lattices, each level twice as fine as the one before.
//!
//! H(m, x, z) is the height of a vertex of level m, in units of 2⁻⁸ amplitudes of that level's octave; amplitudes halve from level to level as
//! cells do. A vertex is twice what the surface of the coarser level is there (its unit is twice as large), and a random number:
//!
//! ```text
//! H(0, x, z) = u(0, x, z)
//! H(m + 1, x, z) = twice(H(m, …), x, z) + u(m + 1, x, z)
//! ```
//!
//! With [`Refinement::Triangles`] the coarser surface is the triangles that are drawn, so refining moves nothing and rounds nothing.
//! Heights grow without end, by a digit a level, and are held modulo 2⁶⁴ here and as differences to a tile's base in 32 bits on the device
//! ([`Tile`]): sums wrap and come back. `glsl/lib/zoom_height.glsl` has the twin; both are additions, a shift and a hash of 32-bit words, which
//! every device does alike.
//!
//! # Slopes
//! Amplitude and spacing both halve, so each octave adds as much to the gradient as any other: at a random place slopes
//! grow as the square root of the depth, the variance along an axis by 2/3 (amplitudes a cell)² a level with triangles and 4/9 with bilinear cells. No other noise
//! would cure it: a surface of bounded slope is differentiable almost everywhere (Rademacher), that is, flat to who comes near. There are always places of
//! bounded slope, though, and [`motion`](super::motion) leads to them.

mod shading;
mod spine;
mod tile;

pub use shading::{Gradient, Shaded};
pub use spine::{REACH, Spine};
pub use tile::{Tile, base};

use super::address::Cell;
use std::{
    array::from_fn,
    num::Wrapping,
    ops::{Add, Shr, Sub},
};

/// Binary digits of an amplitude.
pub const FRACTION_BITS: u32 = 8;

/// One amplitude, in units of height.
pub const AMPLITUDE: i64 = 1 << FRACTION_BITS;

/// What decides a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Surface {
    pub seed: u32,
    pub refinement: Refinement,
    pub roughness: Roughness,
}

/// What is between the vertices of a coarser level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Refinement {
    /// Two triangles a cell, their diagonals in a checkerboard: [`rises`].
    #[default]
    Triangles,
    /// The bilinear patch through the corners, rounded down (the thesis).
    Bilinear,
}

/// The amplitude of an octave over the side of its cells. Powers of two, so that heights and cells have common digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Roughness {
    Whole,
    #[default]
    Half,
    Quarter,
}

impl Roughness {
    /// How often a cell is halved to be an amplitude.
    pub fn halvings(self) -> u32 {
        self as u32
    }

    /// Cells in an amplitude.
    pub fn cells(self) -> f64 {
        1.0 / f64::from(1u32 << self.halvings())
    }
}

/// Whether the diagonal of the cell with the lower corner (x, z) goes from there to the upper corner. The triangles of a cell's children then lie
/// in its own: two of them keep to its diagonal, two lie across, beside it.
pub fn rises(x: u64, z: u64) -> bool {
    (x ^ z) & 1 == 0
}

/// The random numbers of one level.
#[derive(Clone, Copy, Debug)]
pub struct Octave {
    key: u32,
}

impl Surface {
    /// The octave of a level. The level is part of the key, so that going into the same quarter for ever does not repeat anything.
    pub fn octave(&self, level: u32) -> Octave {
        // The outer mix takes the upper half of a 64-bit level, which is 0.
        Octave { key: mix(mix(self.seed ^ level.wrapping_mul(0x9e37_79b9))) }
    }
}

impl Octave {
    /// The word that a tile's random numbers are made from on the device.
    pub fn key(self) -> u32 {
        self.key
    }

    /// An odd number in ±(2⁸ − 1), all equally likely: mean 0, variance (4⁸ − 1) / 3. It depends on the vertex and on nothing else, not on the
    /// tile that asks, so what two tiles share is the same in both.
    pub fn at(self, x: u64, z: u64) -> i32 {
        Octave::in_column(self.column(x), z)
    }

    /// Those of a square of vertices, rows of x.
    fn square(self, x: u64, z: u64, size: usize) -> Vec<i32> {
        let columns: Vec<u32> = (0..size as u64).map(|i| self.column(x.wrapping_add(i))).collect();
        let row = |j| columns.iter().map(move |column| Octave::in_column(*column, z.wrapping_add(j)));
        let mut square = Vec::with_capacity(size * size);
        (0..size as u64).for_each(|j| square.extend(row(j)));
        square
    }

    /// The hash of a column.
    fn column(self, x: u64) -> u32 {
        let hash = mix(self.key ^ x as u32);
        mix(hash ^ ((x >> 32) as u32).wrapping_add(0x68bc_21eb))
    }

    fn in_column(column: u32, z: u64) -> i32 {
        let hash = mix(column ^ z as u32);
        let hash = mix(hash ^ ((z >> 32) as u32).wrapping_add(0x02e5_be93));
        2 * (hash >> (32 - FRACTION_BITS)) as i32 + 1 - AMPLITUDE as i32
    }
}

/// A bijection of the 32-bit integers with little bias (Wellons 2018, "Prospecting for hash functions": lowbias32). [`core::hash`](crate::core::hash)
/// has another; this one is part of what a location code means.
fn mix(value: u32) -> u32 {
    let value = (value ^ value >> 16).wrapping_mul(0x7feb_352d);
    let value = (value ^ value >> 15).wrapping_mul(0x846c_a68b);
    value ^ value >> 16
}

/// Numbers modulo a power of two, signed: `Wrapping<i32>` and `Wrapping<i64>`.
trait Integer: Copy + Add<Output = Self> + Sub<Output = Self> + Shr<usize, Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Shr<usize, Output = T>> Integer for T {}

/// What a vertex of the next level lies between: the ends of the coarse edge or diagonal that it is the middle of, as corners of the coarse cell by 0 or 1
/// along x and z, or twice the coarse vertex that it is.
fn ends(odd: [bool; 2], rises: bool) -> [[usize; 2]; 2] {
    match odd {
        [true, true] if !rises => [[1, 0], [0, 1]],
        [odd_x, odd_z] => [[0, 0], [odd_x.into(), odd_z.into()]],
    }
}

/// Twice the height of a coarser surface at a vertex of the next level: a coarse vertex if both coordinates are even, else the middle of a coarse edge
/// or cell. `at` gives the corners of the coarse cell, by 0 or 1 along x and z; those that are not needed are not asked for.
fn twice<T: Integer>(
    refinement: Refinement,
    odd: [bool; 2],
    rises: bool,
    at: impl Fn(usize, usize) -> T,
) -> T {
    if refinement == Refinement::Bilinear && odd == [true, true] {
        let a = at(0, 0);
        // Differences, because halves of numbers that have wrapped are wrong.
        return a + a + ((at(1, 0) - a + (at(0, 1) - a) + (at(1, 1) - a)) >> 1);
    }
    let [first, second] = ends(odd, rises).map(|[right, down]| at(right, down));
    first + second
}

/// A square of vertices of one level, and their heights modulo 2⁶⁴.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Patch {
    /// The vertex with the lowest coordinates.
    pub first: Cell,
    /// Vertices along a side.
    pub size: usize,
    /// Rows of x, one for each z.
    heights: Vec<Wrapping<i64>>,
}

impl Patch {
    /// Vertices of level 0.
    pub fn start(surface: &Surface, x: i64, z: i64, size: usize) -> Patch {
        let first = Cell::whole(x, z);
        let noise = surface.octave(0).square(first.x, first.z, size);
        Patch { first, size, heights: noise.into_iter().map(|noise| Wrapping(noise.into())).collect() }
    }

    /// Vertices of the next level, from `x` and `z` on. `None` if some of them hang on vertices that are not here.
    pub fn refine(&self, surface: &Surface, x: u64, z: u64, size: usize) -> Option<Patch> {
        let first = self.offset(x, z, size, 0)?;
        Some(self.finer(surface, first, &surface.octave(self.level() + 1).square(x, z, size), size))
    }

    /// Where a square of the next level begins, counted from the first vertex here. `None` if some of it is less than `margin` of its vertices from the edge of
    /// this square.
    fn offset(&self, x: u64, z: u64, size: usize, margin: u64) -> Option<[usize; 2]> {
        // Counted from the first vertex here, which coordinates modulo 2⁶⁴ can be.
        let first =
            [(x, self.first.x), (z, self.first.z)].map(|(fine, own)| fine.wrapping_sub(own.wrapping_mul(2)));
        let most = (2 * self.size as u64).checked_sub(1 + margin)?;
        let is_inside =
            |first: &u64| *first >= margin && first.checked_add(size as u64).is_some_and(|end| end <= most);
        (size > 0 && first.iter().all(is_inside)).then(|| first.map(|first| first as usize))
    }

    /// A square of the next level that is all inside, from its random numbers.
    fn finer(&self, surface: &Surface, first: [usize; 2], noise: &[i32], size: usize) -> Patch {
        let mut heights = Vec::with_capacity(size * size);
        for (fine_z, noise) in (first[1]..).zip(noise.chunks_exact(size)) {
            let (row, odd_z) = (fine_z / 2, fine_z % 2 == 1);
            for (fine_x, noise) in (first[0]..).zip(noise) {
                let (column, odd_x) = (fine_x / 2, fine_x % 2 == 1);
                let at = |right, down| self.heights[(row + down) * self.size + column + right];
                let coarse = twice(surface.refinement, [odd_x, odd_z], self.rises(column, row), at);
                heights.push(coarse + Wrapping((*noise).into()));
            }
        }
        Patch { first: self.first.descendant(1, first.map(|first| first as u64)), size, heights }
    }

    /// Whether the diagonal of a cell [`rises`], the cell counted from the first vertex.
    fn rises(&self, column: usize, row: usize) -> bool {
        rises(self.first.x.wrapping_add(column as u64), self.first.z.wrapping_add(row as u64))
    }

    /// A part of the same level, `None` if it reaches beyond.
    pub fn part(&self, x: u64, z: u64, size: usize) -> Option<Patch> {
        let first = [x.wrapping_sub(self.first.x), z.wrapping_sub(self.first.z)];
        if first.iter().any(|first| first.checked_add(size as u64).is_none_or(|end| end > self.size as u64)) {
            return None;
        }
        let [column, row] = first.map(|first| first as usize);
        let heights = part(&self.heights, self.size, [column, row], size);
        Some(Patch { first: self.cell(column, row), size, heights })
    }

    /// The height of the vertex `column` and `row` from the first, which is inside.
    pub fn height(&self, column: usize, row: usize) -> i64 {
        self.heights[row * self.size + column].0
    }

    /// Heights, rows of x.
    pub fn heights(&self) -> impl Iterator<Item = i64> + '_ {
        self.heights.iter().map(|height| height.0)
    }

    /// The heights of a cell's corners 00, 10, 01, 11 (x, z), the cell counted from the first vertex, which is inside.
    pub fn corners(&self, column: usize, row: usize) -> Corners {
        let height = |right, down| self.height(column + right, row + down);
        Corners([height(0, 0), height(1, 0), height(0, 1), height(1, 1)])
    }

    /// Column and row of a cell. `None` if it is not here.
    pub fn find(&self, cell: Cell) -> Option<[usize; 2]> {
        let at = [cell.x.wrapping_sub(self.first.x), cell.z.wrapping_sub(self.first.z)];
        if at.iter().any(|index| *index >= self.size as u64 - 1) {
            return None;
        }
        let [column, row] = at.map(|index| index as usize);
        (self.cell(column, row) == cell).then_some([column, row])
    }

    /// The cell with this corner, counted from the first vertex.
    pub fn cell(&self, column: usize, row: usize) -> Cell {
        self.first.beside(column as i64, row as i64)
    }

    pub fn level(&self) -> u32 {
        self.first.level
    }
}

/// A part of a square of values that is all inside.
fn part<T: Copy>(values: &[T], side: usize, [column, row]: [usize; 2], size: usize) -> Vec<T> {
    let rows = values.chunks_exact(side).skip(row).take(size);
    rows.flat_map(|row| row[column..column + size].iter().copied()).collect()
}

/// Heights at the corners 00, 10, 01, 11 (x, z) of a cell, modulo 2⁶⁴. Differences between them are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Corners(pub [i64; 4]);

impl Corners {
    /// The corners of the children of `cell`, in the order 00, 10, 01, 11: all that the vertices between hang on are the corners.
    pub fn children(self, surface: &Surface, cell: Cell) -> [Corners; 4] {
        let [x, z] = [cell.x, cell.z].map(|coordinate| coordinate.wrapping_mul(2));
        let octave = surface.octave(cell.level + 1);
        let rises = rises(cell.x, cell.z);
        let fine = |column: usize, row: usize| {
            let corner = |right, down| Wrapping(self.0[column / 2 + right + 2 * (row / 2 + down)]);
            let coarse = twice(surface.refinement, [column % 2 == 1, row % 2 == 1], rises, corner);
            (coarse + Wrapping(octave.at(x.wrapping_add(column as u64), z.wrapping_add(row as u64)).into())).0
        };
        let fine: [[i64; 3]; 3] = from_fn(|row| from_fn(|column| fine(column, row)));
        from_fn(|quarter| {
            let [column, row] = [quarter % 2, quarter / 2];
            Corners(from_fn(|corner| fine[row + corner / 2][column + corner % 2]))
        })
    }

    /// The lowest and the highest that the surface comes in the cell, modulo 2⁶⁴, whatever its octaves to come are: these sum to half an amplitude, a
    /// quarter, and so on. Boxes of children lie in those of their parents. Rounding down needs no room: a mean of whole numbers that are at least
    /// n is at least n when it is rounded.
    pub fn bounds(self) -> [i64; 2] {
        let [least, most] = self.extremes();
        [least.wrapping_sub(AMPLITUDE), most.wrapping_add(AMPLITUDE)]
    }

    /// The lowest and the highest corner, told by differences, since heights have wrapped.
    pub fn extremes(self) -> [i64; 2] {
        let [first, others @ ..] = self.0;
        let [low, high] = others.iter().fold([0, 0], |[low, high]: [i64; 2], other| {
            let rise = other.wrapping_sub(first);
            [low.min(rise), high.max(rise)]
        });
        [first.wrapping_add(low), first.wrapping_add(high)]
    }

    /// The gradients (along x and z, units of height a cell) of the two triangles of the cell. The one that is lower in x comes first.
    pub fn gradients(self, cell: Cell) -> [[i64; 2]; 2] {
        let [a, b, c, d] = self.0;
        let [bottom, top] = [b.wrapping_sub(a), d.wrapping_sub(c)];
        let [left, right] = [c.wrapping_sub(a), d.wrapping_sub(b)];
        match rises(cell.x, cell.z) {
            true => [[top, left], [bottom, right]],
            false => [[bottom, left], [top, right]],
        }
    }

    /// The square of the steeper of the two gradients, (units of height a cell)².
    pub fn steepness(self, cell: Cell) -> i128 {
        let [first, second] = self.gradients(cell).map(|gradient| {
            let [x, z] = gradient.map(i128::from);
            x * x + z * z
        });
        first.max(second)
    }
}
