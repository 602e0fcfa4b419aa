//! Coral reef growth (after Nakamura & Nakamori 2007, 2011).

use super::lattice::{Lattice, each, sum};
use super::thermal;
use terrane::terrain::reef::{Params, Rubble};
use terrane::terrain::thermal::Law;

/// Rubble slides from cells up to this high above the sea: the crest sheds too, m.
const CREST: f64 = 0.5;

#[derive(Clone, Debug)]
pub struct Reef {
    pub lattice: Lattice,
    pub params: Params,
    /// Ground before the reef, m.
    pub ground: Vec<f64>,
    /// Change since, m.
    pub b: Vec<f64>,
    /// Inorganic carbon.
    pub carbon: Vec<f64>,
    pub sea_level: f64,
    /// Factor of every change of the ground.
    pub mask: Vec<f64>,
}

impl Reef {
    pub fn new(lattice: Lattice, params: Params, ground: Vec<f64>, sea_level: f64) -> Self {
        let carbon = ground
            .iter()
            .map(|&h| if h < sea_level { f64::from(params.ocean_carbon) } else { 0.0 })
            .collect();
        let (b, mask) = (vec![0.0; ground.len()], vec![1.0; ground.len()]);
        Self { lattice, b, carbon, params, ground, sea_level, mask }
    }

    /// The whole history of the sea level (30).
    pub fn run(&mut self) {
        let mut step = 0;
        for stage in self.params.stages.clone() {
            let start = self.sea_level;
            let rise = f64::from(stage.rise);
            let steps = (f64::from(stage.duration) / f64::from(self.params.step)).round() as usize;
            for m in 0..steps {
                self.sea_level = start + rise * m as f64 / steps as f64;
                step += 1;
                self.step(step);
            }
            self.sea_level = start + rise;
        }
    }

    /// Step number `number`, counted from 1, at the present sea level.
    pub fn step(&mut self, number: usize) {
        self.grow();
        self.diffuse();
        if let Some(rubble) = self.params.rubble
            && number.is_multiple_of(rubble.every as usize)
        {
            self.shed(rubble);
        }
    }

    pub fn height(&self, at: usize) -> f64 {
        self.ground[at] + self.b[at]
    }

    /// Growth and uptake (24–26, 29).
    pub fn grow(&mut self) {
        let p = &self.params;
        let years = f64::from(p.step);
        for at in 0..self.lattice.len() {
            let depth = self.sea_level - self.height(at); // (24)
            let lit = depth > 0.0 && depth < f64::from(p.max_depth);
            let light = (-depth * f64::from(p.light_decay)).exp();
            let calcified =
                if lit { self.carbon[at].powi(2) * f64::from(p.growth) * light * years } else { 0.0 }; // (25)
            let calcified = self.mask[at] * calcified;
            self.b[at] += calcified.min((depth - f64::from(p.keep)).max(0.0)); // (29)
            let used = f64::from(p.uptake) * calcified / depth.max(0.5);
            self.carbon[at] = (self.carbon[at] - used).max(0.0); // (26)
        }
        for at in 0..self.lattice.len() {
            self.carbon[at] = self.held(at).unwrap_or(self.carbon[at]);
        }
    }

    /// Diffusion of carbon between cells under water (27, 28), conservative.
    pub fn diffuse(&mut self) {
        let Lattice { cell, .. } = self.lattice;
        let mixing = 4.0 * f64::from(self.params.diffusivity) * f64::from(self.params.step) / (cell * cell);
        let sweeps = (mixing / 0.9).ceil();
        for _ in 0..sweeps as usize {
            self.carbon = self.lattice.map(|i, j| {
                let at = self.lattice.index(i, j);
                if let Some(held) = self.held(at) {
                    return held;
                }
                let exchange: [f64; 8] = each(|k| match self.lattice.neighbour(i, j, k) {
                    Some(n) if k < 4 && self.height(n) < self.sea_level => self.carbon[n] - self.carbon[at],
                    _ => 0.0,
                });
                self.carbon[at] + mixing / 4.0 / sweeps * sum(&exchange)
            });
        }
    }

    /// Rubble slides under water.
    pub fn shed(&mut self, rubble: Rubble) {
        let tangent = f64::from(rubble.repose).tan();
        for _ in 0..rubble.passes {
            let h: Vec<f64> = (0..self.lattice.len()).map(|at| self.height(at)).collect();
            let gives = |at: usize| (h[at] < self.sea_level + CREST).then_some(tangent);
            let mask = |at: usize| self.mask[at];
            let change = thermal::pass(self.lattice, Law::Excess, thermal::LARGEST_SHARE, &h, gives, mask);
            self.b.iter_mut().zip(change).for_each(|(b, change)| *b += change);
        }
    }

    /// Carbon that is given: none on land, the ocean's in the open ocean and at the rim.
    fn held(&self, at: usize) -> Option<f64> {
        let depth = self.sea_level - self.height(at);
        let (i, j) = (at % self.lattice.n, at / self.lattice.n);
        if depth <= 0.0 {
            return Some(0.0);
        }
        let open = depth > f64::from(self.params.ocean_depth) || self.lattice.is_rim(i, j);
        open.then_some(f64::from(self.params.ocean_carbon))
    }
}
