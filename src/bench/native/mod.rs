//! The measure of the kernels: the same steps in plain Rust, in 32-bit floats, on all cores.
//!
//! Straightforward on purpose: arrays, loops along rows, rows shared out by rayon, two sets of arrays that change
//! places. Each loop is a function of slices of one length, which is what a compiler needs to leave out bounds checks
//! and to use vectors. Nothing is shared with the kernels or their references but the formulas (docs/model.md).

mod base;
mod hydraulic;
mod planes;
mod reef;
mod thermal;

use crate::terrain::{Boundary, Plan};
use hydraulic::Hydraulic;
use planes::Planes;
use reef::Reef;
use thermal::Thermal;

/// The land of a plan, and each process at work on it.
pub struct Land {
    plan: Plan,
    ground: Ground,
    hydraulic: Option<Hydraulic>,
    thermal: Option<Thermal>,
    reef: Option<Reef>,
}

impl Land {
    /// Flat land at the datum; `None` where the plan asks for what this version leaves out: layers that sample a raster,
    /// control maps, an open rim, several sweeps of sediment diffusion.
    pub fn new(plan: &Plan) -> Option<Land> {
        let sweeps = plan.hydraulic.map_or(1, |params| params.sediment_sweeps(plan.grid));
        if plan.controls.any() || plan.boundary == Boundary::Open || sweeps > 1 || !base::covers(&plan.layers)
        {
            return None;
        }
        Some(Land {
            plan: plan.clone(),
            ground: Ground::new(plan.grid.cells as usize),
            hydraulic: plan.hydraulic.map(|params| Hydraulic::new(plan, &params)),
            thermal: plan.thermal.map(|params| Thermal::new(plan, &params)),
            reef: plan.reef.as_ref().map(|params| Reef::new(plan, params)),
        })
    }

    /// Makes the base terrain, layer by layer.
    pub fn base(&mut self) {
        base::make(self.plan.grid, &self.plan.layers, &mut self.ground);
    }

    /// One iteration of hydraulic erosion.
    pub fn hydraulic(&mut self) {
        if let Some(hydraulic) = &mut self.hydraulic {
            hydraulic.step(&mut self.ground);
        }
    }

    /// One pass of thermal erosion, as where it runs on its own.
    pub fn thermal(&mut self) {
        if let Some(thermal) = &mut self.thermal {
            thermal.step(&mut self.ground);
        }
    }

    /// One reef step at the sea level of `plan`, without rubble.
    pub fn reef(&mut self) {
        if let Some(reef) = &mut self.reef {
            reef.step(&mut self.ground);
        }
    }

    /// One sweep of the diffusion of carbon.
    pub fn reef_sweep(&mut self) {
        if let Some(reef) = &mut self.reef {
            reef.sweep(&self.ground);
        }
    }

    /// Ground above the datum, m, row by row.
    pub fn height(&self) -> Vec<f32> {
        self.ground.now.plane(HEIGHT)
    }

    /// What erosion did, m.
    pub fn change(&self) -> Vec<f32> {
        self.ground.now.plane(CHANGE)
    }

    /// Depth of the water, m.
    pub fn water(&self) -> Vec<f32> {
        self.hydraulic.as_ref().map(Hydraulic::depth).unwrap_or_default()
    }

    /// Suspended sediment, m of ground.
    pub fn sediment(&self) -> Vec<f32> {
        self.hydraulic.as_ref().map(Hydraulic::sediment).unwrap_or_default()
    }

    /// Sum of the outflows, m³/s.
    pub fn flow(&self) -> Vec<f32> {
        self.hydraulic.as_ref().map(Hydraulic::flow).unwrap_or_default()
    }

    /// Thickness that the reef has gained, m.
    pub fn thickness(&self) -> Vec<f32> {
        self.reef.as_ref().map(Reef::thickness).unwrap_or_default()
    }
}

/// Ground: what it was when changes began to count, and as it is.
struct Ground {
    start: Planes,
    now: Planes,
    next: Planes,
}

// Planes of the ground as it is: above the datum, and since the start.
const HEIGHT: usize = 0;
const CHANGE: usize = 1;

impl Ground {
    fn new(cells: usize) -> Ground {
        Ground { start: Planes::new(cells, 1), now: Planes::new(cells, 2), next: Planes::new(cells, 2) }
    }

    fn swap(&mut self) {
        std::mem::swap(&mut self.now, &mut self.next);
    }
}
