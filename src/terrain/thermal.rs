//! Thermal erosion: debris slides to lower neighbours past the angle of repose (Jákó & Tóth 2011, simplified).

use super::{Blocks, Fields, Plan, Process};
use crate::{
    core::grid::Grid,
    gpu::{self, Compute, Gpu, Image, Recorder, format::R32f},
    shaders::terrain::thermal::{Bindings, Constants, Push, Shader},
};
use serde::Serialize;

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Params {
    pub law: Law,
    /// Angle of repose on land, radians.
    pub repose: f32,
    /// Angle of repose under water, radians.
    pub repose_under_water: f32,
    /// Speed D_th, m²/s: the share moved in a time t is 4·D_th·t/ℓ².
    pub diffusivity: f32,
    /// Runs every this many hydraulic iterations, with the time of all of them.
    pub every: u32,
    /// Model seconds, for worlds without hydraulic erosion.
    pub duration: f32,
    /// Before anything else: collapse of slopes that are too steep.
    pub settle: Option<Settle>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Law {
    /// Half of the excess over the repose slope moves: no overshoot, no terraces.
    Excess,
    /// Half of the whole drop moves (the paper).
    Drop,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settle {
    /// Radians.
    pub repose: f32,
    /// Length σ over which material slides, m: 2σ²/ℓ² passes.
    pub length: f32,
}

/// The most that may move in a pass: eight neighbours can fill one pit, and must not raise it above themselves.
pub const LARGEST_RATE: f64 = 2.0 / 9.0;

/// Above all ground, and below what the kernel finds off the grid, m.
const TOP: f32 = 1e29;

impl Params {
    /// Passes that a time needs, model seconds, and the rate k of each (half of k times the excess moves).
    fn passes_and_rate(&self, grid: Grid, time: f64) -> (u32, f64) {
        let cell = f64::from(grid.cell_size());
        let all = 4.0 * f64::from(self.diffusivity) * time / (cell * cell);
        let passes = (all / LARGEST_RATE).ceil().max(1.0);
        (passes as u32, all / passes)
    }

    /// Passes that `time` needs, model seconds.
    pub fn passes(&self, grid: Grid, time: f64) -> u32 {
        self.passes_and_rate(grid, time).0
    }
}

impl Settle {
    /// Passes that the length needs.
    pub fn passes(&self, grid: Grid) -> u32 {
        let (sigma, cell) = (f64::from(self.length), f64::from(grid.cell_size()));
        (2.0 * sigma * sigma / (cell * cell)).round() as u32
    }
}

/// Debris on the move, on land and under water.
pub struct Thermal {
    slide: Slide,
    schedule: Schedule,
}

/// When passes run.
enum Schedule {
    /// As many, behind each of these iterations.
    Behind { every: u32, passes: u32 },
    /// One an iteration.
    Each,
    /// One an iteration; behind the last, this is the ground that changes are counted from.
    Prepare { last: u32 },
}

impl Schedule {
    fn beside_water(plan: &Plan, params: &Params, step: f64) -> (Schedule, f64) {
        let every = params.every.max(1);
        let (passes, rate) = params.passes_and_rate(plan.grid, f64::from(every) * step);
        (Schedule::Behind { every, passes }, rate)
    }
}

impl Thermal {
    /// Beside hydraulic erosion with steps of `step` model seconds.
    pub fn beside_water(gpu: &Gpu, plan: &Plan, params: &Params, step: f64) -> gpu::Result<Thermal> {
        let (schedule, rate) = Schedule::beside_water(plan, params, step);
        Ok(Thermal { slide: Slide::of(gpu, plan, params, rate)?, schedule })
    }

    /// On its own.
    pub fn alone(gpu: &Gpu, plan: &Plan, params: &Params) -> gpu::Result<Thermal> {
        let (_, rate) = params.passes_and_rate(plan.grid, f64::from(params.duration));
        Ok(Thermal { slide: Slide::of(gpu, plan, params, rate)?, schedule: Schedule::Each })
    }

    /// Before all else.
    pub fn settling(gpu: &Gpu, plan: &Plan, settle: &Settle) -> gpu::Result<Thermal> {
        let slide = Slide::rubble(gpu, plan, settle.repose)?;
        Ok(Thermal { slide, schedule: Schedule::Prepare { last: settle.passes(plan.grid) } })
    }
}

impl Process for Thermal {
    fn passes(&self, iteration: u32) -> u32 {
        match self.schedule {
            Schedule::Behind { every, passes } if iteration.is_multiple_of(every) => passes,
            Schedule::Behind { .. } => 0,
            Schedule::Each | Schedule::Prepare { .. } => 1,
        }
    }

    fn pass(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32, _pass: u32) {
        let change = fields.change.clone();
        self.slide.pass(rec, fields, &change);
        if let Schedule::Prepare { last } = self.schedule
            && iteration == last
        {
            fields.rebase(rec);
        }
    }

    fn retune(&mut self, gpu: &Gpu, plan: &Plan) -> gpu::Result<()> {
        let Some(params) = &plan.thermal else { return Ok(()) };
        let (constants, push) = match (&self.schedule, plan.time_step(), params.settle) {
            (Schedule::Behind { .. }, Some(step), _) => {
                let (schedule, rate) = Schedule::beside_water(plan, params, step);
                self.schedule = schedule;
                Slide::parameters(gpu, plan, params, rate)
            }
            (Schedule::Each, ..) => {
                let (_, rate) = params.passes_and_rate(plan.grid, f64::from(params.duration));
                Slide::parameters(gpu, plan, params, rate)
            }
            (Schedule::Prepare { .. }, _, Some(settle)) => {
                self.schedule = Schedule::Prepare { last: settle.passes(plan.grid) };
                Slide::parameters_of_rubble(gpu, plan, settle.repose)
            }
            _ => return Ok(()),
        };
        self.slide.retune(gpu, constants, push)
    }
}

/// One pass of sliding, for whatever slides.
pub(super) struct Slide {
    pass: Compute<Shader>,
    constants: Constants,
    pub push: Push,
}

impl Slide {
    fn of(gpu: &Gpu, plan: &Plan, params: &Params, rate: f64) -> gpu::Result<Slide> {
        Slide::new(gpu, Slide::parameters(gpu, plan, params, rate))
    }

    /// The excess law at its largest rate and one angle of repose, radians.
    pub fn rubble(gpu: &Gpu, plan: &Plan, repose: f32) -> gpu::Result<Slide> {
        Slide::new(gpu, Slide::parameters_of_rubble(gpu, plan, repose))
    }

    fn new(gpu: &Gpu, (constants, push): (Constants, Push)) -> gpu::Result<Slide> {
        Ok(Slide { pass: Compute::new(gpu, constants)?, constants, push })
    }

    /// Other parameters; the program is made anew only if it has to be.
    pub fn retune(&mut self, gpu: &Gpu, constants: Constants, push: Push) -> gpu::Result<()> {
        if self.constants != constants {
            (self.pass, self.constants) = (Compute::new(gpu, constants)?, constants);
        }
        self.push = push;
        Ok(())
    }

    fn parameters(gpu: &Gpu, plan: &Plan, params: &Params, rate: f64) -> (Constants, Push) {
        let law = match params.law {
            Law::Excess => 0,
            Law::Drop => 1,
        };
        let push = Push {
            half_rate: (0.5 * rate) as f32,
            rise_on_land: rise(params.repose, plan.grid),
            rise_under_water: rise(params.repose_under_water, plan.grid),
            sea_level: plan.acting_sea_level(),
            top: TOP,
        };
        (constants(gpu, plan, law), push)
    }

    pub fn parameters_of_rubble(gpu: &Gpu, plan: &Plan, repose: f32) -> (Constants, Push) {
        let rise = rise(repose, plan.grid);
        let push = Push {
            half_rate: (0.5 * LARGEST_RATE) as f32,
            rise_on_land: rise,
            rise_under_water: rise,
            sea_level: f32::MIN,
            top: TOP,
        };
        (constants(gpu, plan, 0), push)
    }

    fn blocks(&self) -> Blocks {
        let Constants { columns, rows, .. } = self.constants;
        Blocks { columns, rows }
    }

    /// Slides the ground and counts it in `change`, where height is `start + change`.
    pub fn pass(&self, rec: &mut Recorder, fields: &mut Fields, change: &Image<R32f>) {
        let height = &mut fields.height;
        rec.dispatch(
            &self.pass,
            self.blocks().over(height.src().size()),
            self.push,
            Bindings {
                height_in: height.src(),
                height_out: height.dst(),
                change,
                start: &fields.start,
                controls: &fields.controls,
            },
        );
        height.swap();
    }
}

fn constants(gpu: &Gpu, plan: &Plan, law: u32) -> Constants {
    let Blocks { columns, rows } = Blocks::of(gpu, 2, 4);
    Constants { law, controls: plan.controls.any(), columns, rows }
}

/// How far a slope of `repose` radians rises over one cell, m.
fn rise(repose: f32, grid: Grid) -> f32 {
    (f64::from(repose).tan() * f64::from(grid.cell_size())) as f32
}
