//! Hydraulic erosion by virtual pipes (Mei, Decaudin & Hu 2007), mended.

use super::{Blocks, Boundary, Fields, Plan, Process, schedule::Steps};
use crate::{
    core::grid::Grid,
    gpu::{self, Compute, Gpu, Recorder},
    shaders::terrain::{hydraulic_erode, hydraulic_flow, hydraulic_start, sediment_diffusion},
};
use serde::Serialize;

/// One model; the paper's is a special case of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Params {
    /// Simulated time, model seconds.
    pub duration: f32,
    /// Rain, m/s.
    pub rain: f32,
    /// Evaporation K_T: share of the depth that vanishes per second, 1/s.
    pub evaporation: f32,
    /// m/s².
    pub gravity: f32,
    pub pipes: Pipes,
    pub section: Section,
    /// Depth D of a pipe, m: its section with [`Section::Fixed`], the cap on it with [`Section::Depth`].
    pub pipe_depth: f32,
    /// Quadratic bed drag c_f, 1; 0 = frictionless (the paper).
    pub drag: f32,
    /// Capacity K_S, s: metres of terrain carried per m/s of speed and unit of slope.
    pub capacity: f32,
    /// Least sin α in the capacity.
    pub min_slope: f32,
    /// Depth over which the capacity rises from none to all (l_max), m; 0 = no ramp (the paper).
    pub ramp_depth: f32,
    /// Depth at which the ramp begins (d_min), m.
    pub ramp_start: f32,
    pub slope: Slope,
    /// K_E, 1/s.
    pub erosion_rate: f32,
    /// K_D, 1/s.
    pub deposition_rate: f32,
    /// Fastest change of the ground by erosion or deposition, m/s.
    pub rate_limit: f32,
    pub transport: Transport,
    /// Diffusivity D_s of suspended sediment, m²/s.
    pub sediment_diffusivity: f32,
    /// Soil creep: diffusivity of the bed, m²/s.
    pub creep: f32,
    /// Bank diffusion β: extra bed diffusivity per unit of discharge |v|·d, 1.
    pub bank_diffusion: f32,
    /// Depth below the sea over which the capacity fades to nothing (z_max), m; with the sea boundary.
    pub sea_fade: f32,
    /// The step as a share of the stable one.
    pub safety: f32,
    /// The water counter rises where water is deeper than this, m, and falls elsewhere …
    pub wet_depth: f32,
    /// … between 0 and this many seconds.
    pub wet_memory: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Pipes {
    Four,
    Eight,
}

/// Cross-section of a pipe of width b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Section {
    /// b·D.
    Fixed,
    /// b·min(depth of the flow, D).
    Depth,
}

/// The slope in the capacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Slope {
    /// Central differences of the ground.
    Central,
    /// Outflow-weighted drop of the water surface.
    Outflow,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Transport {
    /// Sediment leaves with the water that carries it; conservative.
    Flux,
    /// Traced back along the velocity; loses mass (the paper).
    SemiLagrangian,
}

impl Params {
    /// The longest stable step is `½·ℓ/√(g·D)`: stricter than in the papers, since both pipes between two cells react.
    pub fn steps(&self, grid: Grid) -> Steps {
        let wave = (f64::from(self.gravity) * f64::from(self.pipe_depth)).sqrt();
        let longest = f64::from(self.safety) * 0.5 * f64::from(grid.cell_size()) / wave;
        let duration = f64::from(self.duration);
        let count = (duration / longest).ceil();
        if count < 1.0 {
            Steps { count: 0, step: 0.0 }
        } else {
            Steps { count: count as u32, step: duration / count }
        }
    }

    /// Sweeps of sediment diffusion in one step: a Jacobi sweep over four neighbours damps every wave if it mixes at
    /// most an eighth with each.
    pub fn sediment_sweeps(&self, grid: Grid) -> u32 {
        let mixing = mixing(self.sediment_diffusivity, self.steps(grid).step, grid);
        (8.0 * mixing).ceil().max(1.0) as u32
    }

    /// Whether water also flows to the diagonal neighbours.
    pub fn flows_diagonally(&self) -> bool {
        self.pipes == Pipes::Eight
    }

    /// Whether sediment is traced back along the velocity.
    pub fn traces_back(&self) -> bool {
        self.transport == Transport::SemiLagrangian
    }
}

/// Water on its way down.
pub struct Hydraulic {
    start: Compute<hydraulic_start::Shader>,
    flow: Compute<hydraulic_flow::Shader>,
    diffusion: Compute<sediment_diffusion::Shader>,
    erode: Compute<hydraulic_erode::Shader>,
    /// What the programs were made with.
    constants: (hydraulic_flow::Constants, hydraulic_erode::Constants),
    blocks: Blocks,
    flow_push: hydraulic_flow::Push,
    erode_push: hydraulic_erode::Push,
    /// Sweeps of sediment diffusion before the one in `erode`.
    extra_sweeps: u32,
}

impl Hydraulic {
    pub fn new(gpu: &Gpu, plan: &Plan, params: &Params) -> gpu::Result<Hydraulic> {
        let constants @ (flow, erode) = constants(gpu, plan, params);
        let (columns, rows) = (flow.columns, flow.rows);
        Ok(Hydraulic {
            start: Compute::new(gpu, ())?,
            flow: Compute::new(gpu, flow)?,
            diffusion: Compute::new(gpu, sediment_diffusion::Constants { columns, rows })?,
            erode: Compute::new(gpu, erode)?,
            constants,
            blocks: Blocks { columns, rows },
            flow_push: flow_push(plan, params),
            erode_push: erode_push(plan, params),
            extra_sweeps: params.sediment_sweeps(plan.grid) - 1,
        })
    }

    fn fill_the_sea(&self, rec: &mut Recorder, fields: &Fields) {
        let push = hydraulic_start::Push { sea_level: fields.sea_level };
        let bindings = hydraulic_start::Bindings { height: fields.height.src(), water: fields.water.src() };
        rec.dispatch(&self.start, fields.height.src().size(), push, bindings);
    }

    fn let_flow(&self, rec: &mut Recorder, fields: &mut Fields) {
        let bindings = hydraulic_flow::Bindings {
            height: fields.height.src(),
            water: fields.water.src(),
            sediment_in: fields.sediment.src(),
            sediment_out: fields.sediment.dst(),
            axis_in: fields.axis.src(),
            axis_out: fields.axis.dst(),
            diagonal_in: fields.diagonal.src(),
            diagonal_out: fields.diagonal.dst(),
            slope: &fields.slope,
            controls: &fields.controls,
        };
        rec.dispatch(&self.flow, self.blocks.over(fields.height.src().size()), self.flow_push, bindings);
        fields.sediment.swap();
        fields.axis.swap();
        fields.diagonal.swap();
    }

    fn diffuse(&self, rec: &mut Recorder, fields: &mut Fields) {
        let push = sediment_diffusion::Push { mixing: self.erode_push.sediment_mixing };
        let bindings = sediment_diffusion::Bindings {
            water: fields.water.src(),
            sediment_in: fields.sediment.src(),
            sediment_out: fields.sediment.dst(),
        };
        rec.dispatch(&self.diffusion, self.blocks.over(fields.height.src().size()), push, bindings);
        fields.sediment.swap();
    }

    fn let_erode(&self, rec: &mut Recorder, fields: &mut Fields) {
        let bindings = hydraulic_erode::Bindings {
            height_in: fields.height.src(),
            height_out: fields.height.dst(),
            start: &fields.start,
            change: &fields.change,
            water_in: fields.water.src(),
            water_out: fields.water.dst(),
            sediment_in: fields.sediment.src(),
            sediment_out: fields.sediment.dst(),
            axis: fields.axis.src(),
            diagonal: fields.diagonal.src(),
            slope: &fields.slope,
            controls: &fields.controls,
        };
        rec.dispatch(&self.erode, self.blocks.over(fields.height.src().size()), self.erode_push, bindings);
        fields.height.swap();
        fields.water.swap();
        fields.sediment.swap();
    }
}

impl Process for Hydraulic {
    fn passes(&self, _iteration: u32) -> u32 {
        self.extra_sweeps + 2
    }

    fn pass(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32, pass: u32) {
        if pass == 0 {
            if iteration == 1 {
                self.begin(rec, fields);
            }
            self.let_flow(rec, fields);
        } else if pass <= self.extra_sweeps {
            self.diffuse(rec, fields);
        } else {
            self.let_erode(rec, fields);
        }
    }

    fn begin(&mut self, rec: &mut Recorder, fields: &mut Fields) {
        self.fill_the_sea(rec, fields);
    }

    fn retune(&mut self, gpu: &Gpu, plan: &Plan) -> gpu::Result<()> {
        let Some(params) = &plan.hydraulic else { return Ok(()) };
        if self.constants != constants(gpu, plan, params) {
            *self = Hydraulic::new(gpu, plan, params)?;
        }
        self.flow_push = flow_push(plan, params);
        self.erode_push = erode_push(plan, params);
        self.extra_sweeps = params.sediment_sweeps(plan.grid) - 1;
        Ok(())
    }
}

/// What programs are made with.
fn constants(
    gpu: &Gpu,
    plan: &Plan,
    params: &Params,
) -> (hydraulic_flow::Constants, hydraulic_erode::Constants) {
    let pipes = if params.flows_diagonally() { 8 } else { 4 };
    let controls = plan.controls.any();
    let outflow_slope = params.slope == Slope::Outflow;
    let semi_lagrangian = params.traces_back();
    // Four pipes leave registers for more cells.
    let Blocks { columns, rows } = Blocks::of(gpu, 2, if pipes == 4 { 4 } else { 2 });
    let flow = hydraulic_flow::Constants {
        pipes,
        controls,
        open: plan.boundary == Boundary::Open,
        fixed_section: params.section == Section::Fixed,
        drag: params.drag > 0.0,
        outflow_slope,
        semi_lagrangian,
        columns,
        rows,
    };
    let erode = hydraulic_erode::Constants {
        pipes,
        controls,
        outflow_slope,
        semi_lagrangian,
        bed_diffusion: params.creep > 0.0 || params.bank_diffusion > 0.0,
        columns,
        rows,
    };
    (flow, erode)
}

fn flow_push(plan: &Plan, params: &Params) -> hydraulic_flow::Push {
    let step = params.steps(plan.grid).step;
    hydraulic_flow::Push {
        cell_size: plan.grid.cell_size(),
        time_step: step as f32,
        sea_level: plan.acting_sea_level(),
        rain: (f64::from(params.rain) * step) as f32,
        gravity: params.gravity,
        pipe_depth: params.pipe_depth,
        drag: params.drag,
    }
}

/// What diffusion exchanges with each neighbour in one step.
fn mixing(diffusivity: f32, step: f64, grid: Grid) -> f64 {
    let cell = f64::from(grid.cell_size());
    f64::from(diffusivity) * step / (cell * cell)
}

fn erode_push(plan: &Plan, params: &Params) -> hydraulic_erode::Push {
    let step = params.steps(plan.grid).step;
    let mixing = |diffusivity: f32| mixing(diffusivity, step, plan.grid);
    // Share that approaches its end in one step at a rate per second.
    let approach = |rate: f32| -(-f64::from(rate) * step).exp_m1();
    let sweeps = f64::from(params.sediment_sweeps(plan.grid));
    let ramped = params.ramp_depth > 0.0;
    hydraulic_erode::Push {
        cell_size: plan.grid.cell_size(),
        time_step: step as f32,
        sea_level: plan.acting_sea_level(),
        rain: (f64::from(params.rain) * step) as f32,
        sediment_mixing: (mixing(params.sediment_diffusivity) / sweeps) as f32,
        creep_mixing: mixing(params.creep) as f32,
        bank_mixing: (0.5 * mixing(params.bank_diffusion)) as f32,
        max_speed: (f64::from(plan.grid.cell_size()) / step) as f32,
        capacity: params.capacity,
        min_slope: params.min_slope,
        // Without a ramp the capacity is whole at any depth.
        ramp_start: if ramped { params.ramp_start } else { -1.0 },
        ramp: if ramped { params.ramp_depth.recip() } else { 1.0 },
        sea_fade: if params.sea_fade > 0.0 { params.sea_fade.recip() } else { f32::MAX },
        erosion: approach(params.erosion_rate) as f32,
        deposition: approach(params.deposition_rate) as f32,
        max_change: (f64::from(params.rate_limit) * step) as f32,
        evaporation: (f64::from(params.evaporation) * step).min(1.0) as f32,
        wet_depth: params.wet_depth,
        wet_memory: params.wet_memory,
    }
}
