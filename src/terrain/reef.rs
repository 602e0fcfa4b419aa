//! Coral reef growth (after Nakamura & Nakamori 2007, 2011).

use super::{Blocks, Fields, Plan, Process, thermal::Slide};
use crate::{
    core::grid::Grid,
    gpu::{self, Compute, Gpu, Recorder},
    shaders::terrain::{reef_carbon, reef_growth},
};
use serde::Serialize;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Params {
    /// Step, years.
    pub step: f32,
    /// Sea-level history, in order.
    pub stages: Vec<Stage>,
    /// K_B: growth at the surface where carbon is 1, m/yr.
    pub growth: f32,
    /// K_A: decay of light, 1/m.
    pub light_decay: f32,
    /// G: deepest growth, m.
    pub max_depth: f32,
    /// K_U: carbon used per metre grown and metre of water, 1.
    pub uptake: f32,
    /// D_O: diffusivity of carbon, m²/yr.
    pub diffusivity: f32,
    /// O0: carbon of the open ocean, 1.
    pub ocean_carbon: f32,
    /// Cells deeper than this are open ocean, m.
    pub ocean_depth: f32,
    /// Growth stops this far below the surface, m.
    pub keep: f32,
    /// Rubble that slides under water.
    pub rubble: Option<Rubble>,
}

/// The sea rises evenly by `rise` metres (falls where negative) over `duration` years.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stage {
    pub duration: f32,
    pub rise: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rubble {
    /// Angle of repose, radians.
    pub repose: f32,
    /// Runs every this many reef steps …
    pub every: u32,
    /// … this many passes.
    pub passes: u32,
}

/// Rubble comes from below this height above the sea, m: from the crest too, or the reef stays a wall.
const RUBBLE_TOP: f32 = 0.5;
/// The most that a sweep of diffusion mixes over four neighbours.
const LARGEST_MIXING: f64 = 0.9;

impl Params {
    /// Steps of all stages together.
    pub fn steps(&self) -> u32 {
        self.stages.iter().map(|stage| self.steps_of(stage)).fold(0, u32::saturating_add)
    }

    /// Sweeps of diffusion in one step.
    pub fn sweeps(&self, grid: Grid) -> u32 {
        (self.mixing(grid) / LARGEST_MIXING).ceil() as u32
    }

    /// What a step mixes over four neighbours.
    fn mixing(&self, grid: Grid) -> f64 {
        let cell = f64::from(grid.cell_size());
        4.0 * f64::from(self.diffusivity) * f64::from(self.step) / (cell * cell)
    }

    fn steps_of(&self, stage: &Stage) -> u32 {
        (f64::from(stage.duration) / f64::from(self.step)).round() as u32
    }

    /// The sea at each step, metres above the datum, from `start`. A stage shorter than a step moves it at once.
    pub(super) fn sea_levels(&self, start: f32) -> Vec<f32> {
        let mut levels = Vec::new();
        let mut level = f64::from(start);
        for stage in &self.stages {
            let steps = self.steps_of(stage);
            let rise = f64::from(stage.rise);
            levels.extend((0..steps).map(|step| (level + rise * f64::from(step) / f64::from(steps)) as f32));
            level += rise;
        }
        levels
    }
}

/// Coral under way.
pub struct Reef {
    growth: Compute<reef_growth::Shader>,
    carbon: Compute<reef_carbon::Shader>,
    /// Whether `growth` knows of controls.
    controls: bool,
    blocks: Blocks,
    rubble: Option<(Slide, Rubble)>,
    growth_push: reef_growth::Push,
    /// Mixing with each neighbour in one sweep, and the sweeps.
    mixing: f32,
    sweeps: u32,
    sea_levels: Vec<f32>,
    first_level: f32,
}

impl Reef {
    pub fn new(gpu: &Gpu, plan: &Plan, params: &Params) -> gpu::Result<Reef> {
        let rubble = match params.rubble {
            Some(rubble) => Some((Slide::rubble(gpu, plan, rubble.repose)?, rubble)),
            None => None,
        };
        let controls = plan.controls.any();
        let sweeps = params.sweeps(plan.grid);
        let blocks = Blocks::of(gpu, 2, 4);
        let Blocks { columns, rows } = blocks;
        Ok(Reef {
            growth: Compute::new(gpu, reef_growth::Constants { controls })?,
            carbon: Compute::new(gpu, reef_carbon::Constants { columns, rows })?,
            controls,
            blocks,
            rubble,
            growth_push: growth_push(plan, params),
            mixing: mixing(params, plan.grid),
            sweeps,
            sea_levels: params.sea_levels(plan.sea_level),
            first_level: plan.sea_level,
        })
    }

    fn grow(&self, rec: &mut Recorder, fields: &Fields, push: reef_growth::Push) {
        let bindings = reef_growth::Bindings {
            reef: &fields.reef,
            carbon: fields.carbon.src(),
            height: fields.height.src(),
            bed: &fields.start,
            controls: &fields.controls,
        };
        rec.dispatch(&self.growth, fields.reef.size(), push, bindings);
    }

    fn diffuse(&self, rec: &mut Recorder, fields: &mut Fields, sea_level: f32) {
        let reef_growth::Push { ocean_carbon, ocean_depth, .. } = self.growth_push;
        let push = reef_carbon::Push { mixing: self.mixing, sea_level, ocean_carbon, ocean_depth };
        let bindings = reef_carbon::Bindings {
            carbon_in: fields.carbon.src(),
            carbon_out: fields.carbon.dst(),
            height: fields.height.src(),
        };
        rec.dispatch(&self.carbon, self.blocks.over(fields.reef.size()), push, bindings);
        fields.carbon.swap();
    }
}

fn growth_push(plan: &Plan, params: &Params) -> reef_growth::Push {
    reef_growth::Push {
        sea_level: plan.sea_level,
        growth: (f64::from(params.growth) * f64::from(params.step)) as f32,
        light_decay: params.light_decay,
        max_depth: params.max_depth,
        uptake: params.uptake,
        keep: params.keep,
        ocean_carbon: params.ocean_carbon,
        ocean_depth: params.ocean_depth,
    }
}

/// Mixing of carbon with each neighbour in one sweep.
fn mixing(params: &Params, grid: Grid) -> f32 {
    (params.mixing(grid) / 4.0 / f64::from(params.sweeps(grid).max(1))) as f32
}

impl Process for Reef {
    /// The bed is what there is; carbon is that of the ocean wherever there is water.
    fn begin(&mut self, rec: &mut Recorder, fields: &mut Fields) {
        rec.copy(fields.height.src(), &fields.start);
        rec.clear(&fields.reef);
        rec.clear(fields.carbon.src());
        // Nothing grows in this step, but held and unheld cells get their carbon.
        let ocean = reef_growth::Push {
            sea_level: self.first_level,
            growth: 0.0,
            ocean_depth: 0.0,
            ..self.growth_push
        };
        self.grow(rec, fields, ocean);
    }

    fn retune(&mut self, gpu: &Gpu, plan: &Plan) -> gpu::Result<()> {
        let Some(params) = &plan.reef else { return Ok(()) };
        let slides = |rubble: Option<Rubble>| rubble.map(|rubble| rubble.repose);
        let rubble = self.rubble.as_ref().map(|(_, rubble)| *rubble);
        if self.controls != plan.controls.any() || slides(rubble) != slides(params.rubble) {
            *self = Reef::new(gpu, plan, params)?;
        }
        if let (Some((_, own)), Some(rubble)) = (&mut self.rubble, params.rubble) {
            *own = rubble;
        }
        self.growth_push = growth_push(plan, params);
        self.mixing = mixing(params, plan.grid);
        self.sweeps = params.sweeps(plan.grid);
        self.sea_levels = params.sea_levels(plan.sea_level);
        self.first_level = plan.sea_level;
        Ok(())
    }

    /// Growth, the sweeps of diffusion, the passes of rubble.
    fn passes(&self, iteration: u32) -> u32 {
        let sheds = |rubble: &Rubble| iteration.is_multiple_of(rubble.every.max(1));
        let rubble = self.rubble.as_ref().map(|(_, rubble)| rubble).filter(|rubble| sheds(rubble));
        1 + self.sweeps + rubble.map_or(0, |rubble| rubble.passes)
    }

    fn pass(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32, pass: u32) {
        let Some(sea_level) = self.sea_levels.get(iteration as usize - 1).copied() else { return };
        if pass == 0 {
            if iteration == 1 {
                self.begin(rec, fields);
            }
            self.grow(rec, fields, reef_growth::Push { sea_level, ..self.growth_push });
        } else if pass <= self.sweeps {
            self.diffuse(rec, fields, sea_level);
        } else if let Some((slide, _)) = &mut self.rubble {
            slide.push.top = sea_level + RUBBLE_TOP;
            let reef = fields.reef.clone();
            slide.pass(rec, fields, &reef);
        }
    }
}
