//! Coral reef growth (after Nakamura & Nakamori 2007, 2011).

use super::{Fields, Plan, Process, thermal::Slide};
use crate::{
    gpu::{self, Compute, Gpu, Recorder},
    shaders::terrain::{reef_carbon, reef_growth},
};

#[derive(Clone, Debug, PartialEq)]
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    pub duration: f32,
    pub rise: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
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
        self.stages.iter().map(|stage| self.steps_of(stage)).sum()
    }

    fn steps_of(&self, stage: &Stage) -> u32 {
        (f64::from(stage.duration) / f64::from(self.step)).round() as u32
    }

    /// The sea at each step, metres above the datum, from `start`. A stage shorter than a step moves it at once.
    fn sea_levels(&self, start: f32) -> Vec<f32> {
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
        let (step, cell) = (f64::from(params.step), f64::from(plan.grid.cell_size()));
        let mixing = 4.0 * f64::from(params.diffusivity) * step / (cell * cell);
        let sweeps = (mixing / LARGEST_MIXING).ceil();
        Ok(Reef {
            growth: Compute::new(gpu, ())?,
            carbon: Compute::new(gpu, ())?,
            rubble,
            growth_push: reef_growth::Push {
                sea_level: plan.sea_level,
                growth: (f64::from(params.growth) * step) as f32,
                light_decay: params.light_decay,
                max_depth: params.max_depth,
                uptake: params.uptake,
                keep: params.keep,
                ocean_carbon: params.ocean_carbon,
                ocean_depth: params.ocean_depth,
            },
            mixing: if sweeps > 0.0 { (mixing / 4.0 / sweeps) as f32 } else { 0.0 },
            sweeps: sweeps as u32,
            sea_levels: params.sea_levels(plan.sea_level),
            first_level: plan.sea_level,
        })
    }

    /// The bed is what there is; carbon is that of the ocean wherever there is water.
    fn begin(&self, rec: &mut Recorder, fields: &mut Fields) {
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

    fn grow(&self, rec: &mut Recorder, fields: &Fields, push: reef_growth::Push) {
        let bindings = reef_growth::Bindings {
            reef: &fields.reef,
            carbon: fields.carbon.src(),
            height: fields.height.src(),
            bed: &fields.start,
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
        rec.dispatch(&self.carbon, fields.reef.size(), push, bindings);
        fields.carbon.swap();
    }
}

impl Process for Reef {
    fn step(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32) {
        if iteration == 1 {
            self.begin(rec, fields);
        }
        let Some(sea_level) = self.sea_levels.get(iteration as usize - 1).copied() else { return };
        self.grow(rec, fields, reef_growth::Push { sea_level, ..self.growth_push });
        (0..self.sweeps).for_each(|_| self.diffuse(rec, fields, sea_level));
        let Some((slide, rubble)) = &mut self.rubble else { return };
        if iteration.is_multiple_of(rubble.every.max(1)) {
            slide.push.top = sea_level + RUBBLE_TOP;
            let reef = fields.reef.clone();
            (0..rubble.passes).for_each(|_| slide.pass(rec, fields, &reef));
        }
    }
}
