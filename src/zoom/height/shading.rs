//! What the surface is shaded by.
//!
//! Every edge of a coarse triangle stays a crease of the surface for ever, for octaves that are added do not bend it: by its own slopes the surface
//! shows squares and triangles of all sizes. So the gradients that it is shaded by are kept beside the heights, interpolated where those are, and
//! what an octave adds to them is continuous from triangle to triangle:
//!
//! ```text
//! G(0, x, z) = ∇u(0, x, z)
//! G(m + 1, x, z) = mean of G̃(m, …) at the ends of the edge or diagonal that the vertex splits + ∇u(m + 1, x, z)
//! G̃ = G + (∇H − G) / 16
//! ```
//!
//! ∇ is the central difference, over two cells. Without the third line, gradients would be those of a smoother surface, which goes astray from the true one
//! as the root of the depth; with it, they forget within some 16 levels what they have missed: over 4000 levels they are off by 0.9 amplitudes a cell (root
//! mean square) and never by 4 on the autopilot's way, by 2 and never by 9 at random places, where slopes are 15. The share is a compromise: at 1/8, large
//! triangles can be told in the shading; at 1/32 none can, but it has little to do with the relief, whose slopes over some ten cells it correlates with by 0.5, by
//! 0.7 at 1/16, and by 0.9 at 1/8.
//!
//! Where an octave fades in, a vertex comes from the mean of G itself, which is what the coarser level is drawn with.
//!
//! # What is needed
//! A vertex needs G and ∇H, that is H at four neighbours, at the ends of the coarse edge it splits. If a square of vertices has gradients at all but the
//! outermost, the cell in its middle keeps this up: coarse vertices 0 and 1 of a cell have G, and −1 and 2 have H; the finer vertices 0, 1 and 2 lie between
//! 0 and 1 and so have G, and −1 and 3, which have H, do as well by the ring of heights. So tiles with one ring of heights have gradients at all their
//! vertices, from nothing but the tile they are a quarter of, and two tiles have the same ones at their border: they are a function of the
//! vertex, whatever square they are computed in, and no rounding depends on it.
//!
//! All is whole numbers of 32 bits. Heights differ by at most 2 · 255 a level and cell, so neither gradient exceeds 2¹⁰ a level, 2³⁰ at the deepest.

use super::{Integer, Patch, Surface, ends, part};
use std::array::from_fn;

/// Rise along x and z over two cells, units of height: 2⁻⁹ amplitudes a cell.
pub type Gradient = [i32; 2];

/// log₂ of the levels in which gradients forget what they have missed of the true slope.
const MEMORY_BITS: u32 = 4;

/// A square of vertices with the gradients that it is shaded by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shaded {
    patch: Patch,
    /// Rows of x; 0 at the outermost vertices, which have none.
    gradients: Vec<Gradient>,
}

impl Shaded {
    /// Vertices of level 0.
    pub fn start(surface: &Surface, x: i64, z: i64, size: usize) -> Shaded {
        let patch = Patch::start(surface, x, z, size);
        let gradients = (0..size * size).map(|index| match is_inner(size, index) {
            true => slope(&patch, index),
            false => [0; 2],
        });
        let gradients = gradients.collect();
        Shaded { patch, gradients }
    }

    /// Vertices of the next level, from `x` and `z` on. `None` if some of them hang on vertices that are not here, or have no gradients.
    pub fn refine(&self, surface: &Surface, x: u64, z: u64, size: usize) -> Option<Shaded> {
        let coarse = &self.patch;
        let first = coarse.offset(x, z, size, 1)?;
        let noise = surface.octave(coarse.level() + 1).square(x, z, size);
        let rises = |column, row| coarse.rises(column, row);
        let settled = |column, row| {
            let index = row * coarse.size + column;
            settled(self.gradients[index], slope(coarse, index))
        };
        let gradients = finer(first, &noise, size, rises, settled);
        Some(Shaded { patch: coarse.finer(surface, first, &noise, size), gradients })
    }

    /// A part of the same level, `None` if it reaches beyond.
    pub fn part(&self, x: u64, z: u64, size: usize) -> Option<Shaded> {
        let patch = self.patch.part(x, z, size)?;
        let first = [(x, self.patch.first.x), (z, self.patch.first.z)];
        let first = first.map(|(x, own)| x.wrapping_sub(own) as usize);
        let mut gradients = part(&self.gradients, self.patch.size, first, size);
        let outer = gradients.iter_mut().enumerate().filter(|(index, _)| !is_inner(size, *index));
        outer.for_each(|(_, gradient)| *gradient = [0; 2]);
        Some(Shaded { patch, gradients })
    }

    /// Its heights.
    pub fn patch(&self) -> &Patch {
        &self.patch
    }

    /// The gradient at the vertex `column` and `row` from the first, which is inside. 0 at the outermost.
    pub fn gradient(&self, column: usize, row: usize) -> Gradient {
        self.gradients[row * self.patch.size + column]
    }

    /// Gradients, rows of x.
    pub fn gradients(&self) -> &[Gradient] {
        &self.gradients
    }

    /// Bytes of heights and gradients of a square of this size.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Shaded>() + self.gradients.len() * (size_of::<i64>() + size_of::<Gradient>())
    }
}

/// Whether a vertex of a square is none of the outermost.
fn is_inner(side: usize, index: usize) -> bool {
    [index % side, index / side].iter().all(|at| *at > 0 && *at + 1 < side)
}

/// The true slope at an inner vertex.
fn slope(patch: &Patch, index: usize) -> Gradient {
    // Differences are exact in 32 bits, too.
    central(&patch.heights, patch.size, index).map(|rise| rise.0 as i32)
}

/// The central difference along x and z at an inner index of a square of values.
pub(super) fn central<T: Integer>(values: &[T], side: usize, index: usize) -> [T; 2] {
    [1, side].map(|step| values[index + step] - values[index - step])
}

/// A gradient, a step nearer to the true slope: what finer vertices get theirs from.
pub(super) fn settled(gradient: Gradient, slope: Gradient) -> Gradient {
    const HALF: i32 = 1 << (MEMORY_BITS - 1);
    from_fn(|axis| {
        let missed = slope[axis].wrapping_sub(gradient[axis]);
        gradient[axis].wrapping_add(missed.wrapping_add(HALF) >> MEMORY_BITS)
    })
}

/// Gradients of a finer square, 0 at its outermost vertices, from its random numbers and the coarser gradients. Vertices are counted from the coarser square's
/// first.
pub(super) fn finer(
    first: [usize; 2],
    noise: &[i32],
    size: usize,
    rises: impl Fn(usize, usize) -> bool,
    settled: impl Fn(usize, usize) -> Gradient,
) -> Vec<Gradient> {
    let mut gradients = vec![[0; 2]; size * size];
    let inner = 1..size.saturating_sub(1);
    for j in inner.clone() {
        let (row, odd_z) = ((first[1] + j) / 2, (first[1] + j) % 2 == 1);
        for i in inner.clone() {
            let (column, odd_x) = ((first[0] + i) / 2, (first[0] + i) % 2 == 1);
            let ends = ends([odd_x, odd_z], rises(column, row));
            let [near, far] = ends.map(|[right, down]| settled(column + right, row + down));
            let octave = central(noise, size, j * size + i);
            gradients[j * size + i] = from_fn(|axis| {
                let half = far[axis].wrapping_sub(near[axis]) >> 1;
                near[axis].wrapping_add(half).wrapping_add(octave[axis])
            });
        }
    }
    gradients
}
