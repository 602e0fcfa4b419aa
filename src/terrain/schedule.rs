//! What a plan comes to, before any device is asked: stages, steps, memory.

use super::{Plan, fields::Images, layers};
use crate::core::memory::Memory;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The parts of a run, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Stage {
    Base,
    Settle,
    Hydraulic,
    Thermal,
    Seabed,
    Reef,
}

impl Stage {
    pub fn name(self) -> &'static str {
        match self {
            Stage::Base => "base terrain",
            Stage::Settle => "settling",
            Stage::Hydraulic => "erosion",
            Stage::Thermal => "thermal erosion",
            Stage::Seabed => "sea bed",
            Stage::Reef => "reef",
        }
    }
}

/// The steps of a process: how many, and how long each is, in its own unit of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    pub count: u32,
    pub step: f64,
}

impl Plan {
    /// The stages that have anything to do, and their iterations.
    pub fn stages(&self) -> Vec<(Stage, u32)> {
        let grid = self.grid;
        let settle = self.thermal.and_then(|thermal| thermal.settle);
        let thermal = self.thermal.filter(|_| self.hydraulic.is_none());
        [
            (Stage::Base, self.layers.len() as u32),
            (Stage::Settle, settle.map_or(0, |settle| settle.passes(grid))),
            (Stage::Hydraulic, self.hydraulic.map_or(0, |hydraulic| hydraulic.steps(grid).count)),
            (Stage::Thermal, thermal.map_or(0, |thermal| thermal.passes(grid, f64::from(thermal.duration)))),
            (Stage::Seabed, super::seabed::sweeps(self.seabed_smoothing, grid)),
            (Stage::Reef, self.reef.as_ref().map_or(0, |reef| reef.steps())),
        ]
        .into_iter()
        .filter(|(_, iterations)| *iterations > 0)
        .collect()
    }

    /// A digest behind each stage of all in the plan that determines the land there, in the order of [`Plan::stages`]: plans
    /// that agree up to a stage have the same digest there, whatever they do later.
    ///
    /// # Errors
    /// None is known: serde could refuse a type that the plan does not have.
    pub fn digests(&self) -> serde_json::Result<Vec<[u8; 32]>> {
        // Without `..`, so that a field that is added finds its stage here; what is in the fields is derived.
        let Plan { grid, layers, sea_level, boundary, controls, hydraulic, thermal, seabed_smoothing, reef } =
            self;
        let mut digest = Sha256::new();
        let mut behind = |(stage, iterations): (Stage, u32)| {
            let parameters = match stage {
                Stage::Base => serde_json::to_vec(&(grid, layers, sea_level, boundary, controls)),
                Stage::Settle => serde_json::to_vec(&thermal.map(|thermal| thermal.settle)),
                Stage::Hydraulic => serde_json::to_vec(&(hydraulic, thermal)),
                Stage::Thermal => serde_json::to_vec(thermal),
                Stage::Seabed => serde_json::to_vec(seabed_smoothing),
                Stage::Reef => serde_json::to_vec(reef),
            };
            digest.update(serde_json::to_vec(&(stage, iterations))?);
            digest.update(parameters?);
            Ok(digest.clone().finalize().into())
        };
        self.stages().into_iter().map(&mut behind).collect()
    }

    /// The step of hydraulic erosion, model seconds.
    pub fn time_step(&self) -> Option<f64> {
        self.hydraulic.map(|hydraulic| hydraulic.steps(self.grid).step)
    }

    /// Height of the sea above the datum when all is done, metres.
    pub fn final_sea_level(&self) -> f32 {
        let rise: f64 =
            self.reef.iter().flat_map(|reef| &reef.stages).map(|stage| f64::from(stage.rise)).sum();
        (f64::from(self.sea_level) + rise) as f32
    }

    /// Device memory that the simulation needs, with the copies that are made at its beginning or its end.
    pub fn memory(&self) -> Vec<Memory> {
        let images = Images::of(self);
        let cells = self.grid.samples() as u64;
        let rasters: u64 = self.layers.iter().map(layers::Layer::raster_bytes).sum();
        let maps: usize = self.controls.channels().into_iter().flatten().map(|map| map.values.len()).sum();
        // What files hold on its way to the device, or the land that a renderer is given.
        let copies = rasters.max(self.land_memory().bytes + 8 * maps as u64);
        let kept = |used: bool, bytes_per_cell: u64| if used { cells * bytes_per_cell } else { 0 };
        [
            ("ground", kept(true, 4 * 4)),
            ("water", kept(images.hydraulic, 2 * 16)),
            ("flow", kept(images.hydraulic, 2 * 16) + kept(images.diagonal, 2 * 16)),
            ("sediment", kept(images.hydraulic, 2 * 4)),
            ("slope", kept(images.slope, 4)),
            ("reef", kept(images.reef, 3 * 4)),
            ("controls", kept(images.controls, 16)),
            ("rasters", rasters),
            ("copies", copies),
        ]
        .into_iter()
        .filter(|(_, bytes)| *bytes > 0)
        .map(|(name, bytes)| Memory { name, bytes })
        .collect()
    }

    /// Device memory of what [`super::Simulation::land`] gives to a renderer.
    pub fn land_memory(&self) -> Memory {
        Memory { name: "land", bytes: self.grid.samples() as u64 * 4 * 4 }
    }
}
