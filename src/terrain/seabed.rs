//! Sea-bed smoothing: waves and currents level what lies under water (Korošec & Lebar Bajec (23)).

use super::{Fields, Plan, Process};
use crate::{
    core::grid::Grid,
    gpu::{self, Compute, Gpu, Recorder},
    shaders::terrain::seabed::{Bindings, Constants, Push, Shader},
};

/// Sweeps of the four-neighbour mean that smooth over a length σ, m: each adds ℓ²/2 to the variance of its kernel.
pub fn sweeps(smoothing: f32, grid: Grid) -> u32 {
    let (sigma, cell) = (f64::from(smoothing), f64::from(grid.cell_size()));
    if sigma > 0.0 { ((2.0 * sigma * sigma / (cell * cell)).round() as u32).max(1) } else { 0 }
}

pub struct Seabed {
    pass: Compute<Shader>,
    constants: Constants,
    sea_level: f32,
}

impl Seabed {
    pub fn new(gpu: &Gpu, plan: &Plan) -> gpu::Result<Seabed> {
        let constants = Constants { controls: plan.controls.any() };
        Ok(Seabed { pass: Compute::new(gpu, constants)?, constants, sea_level: plan.sea_level })
    }
}

impl Process for Seabed {
    fn pass(&mut self, rec: &mut Recorder, fields: &mut Fields, _iteration: u32, _pass: u32) {
        let height = &mut fields.height;
        rec.dispatch(
            &self.pass,
            height.src().size(),
            Push { sea_level: self.sea_level },
            Bindings {
                height_in: height.src(),
                height_out: height.dst(),
                change: &fields.change,
                controls: &fields.controls,
            },
        );
        height.swap();
    }

    fn retune(&mut self, gpu: &Gpu, plan: &Plan) -> gpu::Result<()> {
        if self.constants.controls != plan.controls.any() {
            *self = Seabed::new(gpu, plan)?;
        }
        Ok(())
    }
}
