//! Thermal erosion: debris slides past the angle of repose (Jákó & Tóth 2011, simplified).

use super::lattice::{Lattice, OPPOSITE, each, sum};
use terrane::terrain::thermal::Law;

/// The largest share one pass may move: eight neighbours fill one pit.
pub const LARGEST_SHARE: f64 = 2.0 / 9.0;

/// Passes and the share of each for a share of `4·D_th·t/ℓ²` in all.
pub fn passes(diffusivity: f64, time: f64, cell: f64) -> (usize, f64) {
    let share = 4.0 * diffusivity * time / (cell * cell);
    let passes = (share / LARGEST_SHARE).ceil().max(1.0);
    (passes as usize, share / passes)
}

/// Passes over which material slides a length σ.
pub fn settling_passes(length: f64, cell: f64) -> usize {
    (2.0 * (length / cell).powi(2)).round() as usize
}

/// The change of the ground in one pass.
///
/// `repose(cell)` is the tangent of the angle of repose of what the cell gives, `None` where it gives nothing;
/// `mask(cell)` scales what passes between two cells by the lesser of theirs.
pub fn pass(
    lattice: Lattice,
    law: Law,
    share: f64,
    h: &[f64],
    repose: impl Fn(usize) -> Option<f64> + Sync,
    mask: impl Fn(usize) -> f64 + Sync,
) -> Vec<f64> {
    // Drop to neighbour `k` where it is steeper than repose (20), else 0.
    let sliding = |i, j, k| -> f64 {
        let at = lattice.index(i, j);
        let (Some(to), Some(repose)) = (lattice.neighbour(i, j, k), repose(at)) else { return 0.0 };
        let drop = h[at] - h[to];
        if drop > repose * lattice.distance(k) { drop } else { 0.0 }
    };
    // What a cell gives per metre of drop: M/Σ_R Δ (21).
    let given = lattice.map(|i, j| {
        let at = lattice.index(i, j);
        let drops: [f64; 8] = each(|k| sliding(i, j, k));
        let total = sum(&drops);
        if total == 0.0 {
            return 0.0;
        }
        let slope = repose(at).unwrap_or(0.0);
        let movable = (0..8)
            .filter_map(|k| {
                let drop = h[at] - h[lattice.neighbour(i, j, k)?];
                match law {
                    Law::Excess if drops[k] > 0.0 => Some(drop - slope * lattice.distance(k)),
                    Law::Excess => None,
                    Law::Drop => Some(drop),
                }
            })
            .fold(0.0, f64::max);
        0.5 * share * movable / total
    });
    lattice.map(|i, j| {
        let at = lattice.index(i, j);
        let out: [f64; 8] = each(|k| {
            let Some(to) = lattice.neighbour(i, j, k) else { return 0.0 };
            given[at] * sliding(i, j, k) * mask(at).min(mask(to))
        });
        let inflow: [f64; 8] = each(|k| {
            let Some(from) = lattice.neighbour(i, j, k) else { return 0.0 };
            let (i, j) = (from % lattice.n, from / lattice.n);
            given[from] * sliding(i, j, OPPOSITE[k]) * mask(at).min(mask(from))
        });
        sum(&inflow) - sum(&out) // (22)
    })
}
