//! Sea-bed smoothing (23).

use super::lattice::Lattice;

/// Smooths cells below `sea_level` over a length σ, in place, each by the share in `mask`.
pub fn smooth(lattice: Lattice, h: &mut [f64], sea_level: f64, length: f64, mask: &[f64]) {
    for _ in 0..passes(length, lattice.cell) {
        let settled = pass(lattice, h, sea_level);
        h.iter_mut().zip(settled).zip(mask).for_each(|((h, settled), mask)| *h += mask * (settled - *h));
    }
}

pub fn passes(length: f64, cell: f64) -> usize {
    if length <= 0.0 { 0 } else { (2.0 * (length / cell).powi(2)).round().max(1.0) as usize }
}

/// Jacobi mean of four neighbours below the sea and off the rim (23).
pub fn pass(lattice: Lattice, h: &[f64], sea_level: f64) -> Vec<f64> {
    lattice.map(|i, j| {
        let at = lattice.index(i, j);
        if h[at] >= sea_level || lattice.is_rim(i, j) {
            return h[at];
        }
        ((h[at - 1] + h[at + 1]) + (h[at - lattice.n] + h[at + lattice.n])) / 4.0
    })
}
