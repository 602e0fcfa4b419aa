//! Figures that describe a land.

use super::island::Land;
use super::lattice::{Lattice, OFFSETS};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    /// km².
    pub land_area: f64,
    /// Above the sea, m.
    pub peak: f64,
    pub hypsometric_integral: f64,
    /// Degrees.
    pub slope_median: f64,
    pub slope_p99: f64,
    pub slope_max: f64,
    /// Erosion, 10⁶ m³.
    pub lowered: f64,
    pub raised: f64,
    /// m.
    pub deepest_cut: f64,
    pub slope_area_exponent: f64,
    /// Undrained share of the land, %.
    pub pits: f64,
    /// Reef, 10⁶ m³ and m.
    pub reef_volume: f64,
    pub reef_thickness: f64,
    /// Reef 0–3 m below the sea, km².
    pub reef_flat: f64,
    /// Water deeper than 3 m that shallows part from the ocean, km², its median depth, m.
    pub lagoon_area: f64,
    pub lagoon_depth: f64,
}

pub fn measure(land: &Land) -> Statistics {
    let lattice = land.lattice;
    let area = lattice.cell * lattice.cell / 1e6;
    let y: Vec<f64> = land.height.iter().map(|h| h - land.sea_level).collect();
    let dry: Vec<f64> = y.iter().copied().filter(|&y| y > 0.0).collect();
    let peak = dry.iter().copied().fold(0.0, f64::max);
    let mut slopes: Vec<f64> = interior(lattice)
        .filter(|&(i, j)| y[lattice.index(i, j)] > 0.0)
        .map(|(i, j)| {
            let [x, z] = lattice.gradient(i, j, |at| y[at]);
            x.hypot(z).atan().to_degrees()
        })
        .collect();
    slopes.sort_by(f64::total_cmp);
    let filled = fill_depressions(lattice, &y);
    let pits = (0..lattice.len()).filter(|&at| y[at] > 0.0 && filled[at] > y[at] + 0.01).count();
    let (lagoon_area, lagoon_depth) = lagoon(lattice, &y);
    let volume = |change: &[f64], sign: f64| area * change.iter().map(|c| (sign * c).max(0.0)).sum::<f64>();
    Statistics {
        land_area: area * dry.len() as f64,
        peak,
        hypsometric_integral: dry.iter().sum::<f64>() / dry.len() as f64 / peak,
        slope_median: quantile(&slopes, 0.5),
        slope_p99: quantile(&slopes, 0.99),
        slope_max: quantile(&slopes, 1.0),
        lowered: volume(&land.e, -1.0),
        raised: volume(&land.e, 1.0),
        deepest_cut: land.e.iter().fold(0.0, |deepest, e| f64::max(deepest, -e)),
        slope_area_exponent: slope_area_exponent(lattice, &y, &filled),
        pits: 100.0 * pits as f64 / dry.len() as f64,
        reef_volume: volume(&land.b, 1.0),
        reef_thickness: land.b.iter().copied().fold(0.0, f64::max),
        reef_flat: area
            * (0..lattice.len()).filter(|&at| land.b[at] > 0.5 && (-3.0..=0.0).contains(&y[at])).count()
                as f64,
        lagoon_area,
        lagoon_depth,
    }
}

/// −d log slope / d log drainage area over the land.
pub fn slope_area_exponent(lattice: Lattice, y: &[f64], filled: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..lattice.len()).filter(|&at| y[at] > 0.0).collect();
    let land = order.len() as f64;
    order.sort_by(|&p, &q| filled[q].total_cmp(&filled[p]));
    let mut drained = vec![1.0f64; lattice.len()];
    let mut bins = std::collections::BTreeMap::<i64, (f64, f64, f64)>::new();
    for at in order {
        let (i, j) = (at % lattice.n, at / lattice.n);
        let steepest = (0..8)
            .filter_map(|k| {
                let n = lattice.neighbour(i, j, k)?;
                Some(((filled[at] - filled[n]) / lattice.distance(k), n))
            })
            .max_by(|p, q| p.0.total_cmp(&q.0));
        let Some((slope, to)) = steepest else { continue };
        if slope > 0.0 {
            drained[to] += drained[at];
        }
        if slope > 1e-4 && (10.0..land / 10.0).contains(&drained[at]) {
            let bin = bins.entry((drained[at].log10() * 5.0).floor() as i64).or_default();
            *bin = (bin.0 + 1.0, bin.1 + drained[at].log10(), bin.2 + slope.log10());
        }
    }
    let points: Vec<(f64, f64)> =
        bins.values().filter(|bin| bin.0 >= 20.0).map(|bin| (bin.1 / bin.0, bin.2 / bin.0)).collect();
    let count = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |mean, p| (mean.0 + p.0 / count, mean.1 + p.1 / count));
    let covariance: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let variance: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    -covariance / variance
}

/// The lowest surface that drains to the sea or the rim, by a micrometre a cell (Barnes, Lehman & Mulla 2014).
pub fn fill_depressions(lattice: Lattice, y: &[f64]) -> Vec<f64> {
    let mut filled = vec![f64::INFINITY; lattice.len()];
    let mut queue = BinaryHeap::new();
    for at in 0..lattice.len() {
        if y[at] <= 0.0 || lattice.is_rim(at % lattice.n, at / lattice.n) {
            filled[at] = y[at];
            queue.push(Level(y[at], at));
        }
    }
    while let Some(Level(level, at)) = queue.pop() {
        for k in 0..8 {
            let Some(n) = lattice.neighbour(at % lattice.n, at / lattice.n, k) else { continue };
            if filled[n].is_infinite() {
                filled[n] = y[n].max(level + 1e-6);
                queue.push(Level(filled[n], n));
            }
        }
    }
    filled
}

/// Area, km², and median depth of the water deeper than 3 m that is not joined to the rim through such water.
fn lagoon(lattice: Lattice, y: &[f64]) -> (f64, f64) {
    let deep = |at: usize| y[at] < -3.0;
    let mut ocean = vec![false; lattice.len()];
    let mut stack: Vec<usize> =
        (0..lattice.len()).filter(|&at| lattice.is_rim(at % lattice.n, at / lattice.n) && deep(at)).collect();
    stack.iter().for_each(|&at| ocean[at] = true);
    while let Some(at) = stack.pop() {
        for k in 0..OFFSETS.len() / 2 {
            let Some(n) = lattice.neighbour(at % lattice.n, at / lattice.n, k) else { continue };
            if deep(n) && !ocean[n] {
                ocean[n] = true;
                stack.push(n);
            }
        }
    }
    let mut depths: Vec<f64> =
        (0..lattice.len()).filter(|&at| deep(at) && !ocean[at]).map(|at| -y[at]).collect();
    depths.sort_by(f64::total_cmp);
    (depths.len() as f64 * lattice.cell * lattice.cell / 1e6, quantile(&depths, 0.5))
}

fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    sorted[(q * last as f64).round() as usize]
}

fn interior(lattice: Lattice) -> impl Iterator<Item = (usize, usize)> {
    (1..lattice.n - 1).flat_map(move |j| (1..lattice.n - 1).map(move |i| (i, j)))
}

/// Ordered so that the heap gives the lowest first.
struct Level(f64, usize);

impl Ord for Level {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl PartialOrd for Level {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Level {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Level {}
