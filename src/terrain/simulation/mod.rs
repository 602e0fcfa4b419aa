//! A run from bare ground to a finished island, cut into submissions of bounded length; [`live`] is what a hand may do to it meanwhile.

mod live;

pub use live::{Brush, BrushKind, Kind, Snapshot};

use super::{
    Fields, Plan, Process,
    hydraulic::Hydraulic,
    layers::Base,
    reef::Reef,
    schedule::Stage,
    seabed::Seabed,
    state::{self, Part, Position},
    thermal::Thermal,
};
use crate::{
    gpu::{self, Compute, DeviceKind, Gpu, Image, Recorder, format::R32f},
    scene::Ground,
    shaders::terrain::layer,
};
use std::time::{Duration, Instant};

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The stage at work, or the last one.
    pub stage: Stage,
    /// Iterations of it that are done …
    pub iteration: u32,
    /// … of so many.
    pub of: u32,
    pub finished: bool,
}

/// What can be taken from the land as a raster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Metres above the datum.
    Height,
    /// Depth of rivers and lakes, m.
    Water,
    /// Suspended in the water, m of ground.
    Sediment,
    /// Lowered, m.
    Wear,
    /// Raised, m.
    Deposit,
    /// Coral grown, m.
    Reef,
    /// Sum of the outflows, m³/s.
    Flow,
    /// The water counter over its cap, 0…1; 1 below the sea.
    Wetness,
}

impl Layer {
    pub const ALL: [Layer; 8] = [
        Layer::Height,
        Layer::Water,
        Layer::Sediment,
        Layer::Wear,
        Layer::Deposit,
        Layer::Reef,
        Layer::Flow,
        Layer::Wetness,
    ];

    /// As files and the command line call it.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Height => "height",
            Layer::Water => "water",
            Layer::Sediment => "sediment",
            Layer::Wear => "wear",
            Layer::Deposit => "deposit",
            Layer::Reef => "reef",
            Layer::Flow => "flow",
            Layer::Wetness => "wetness",
        }
    }

    /// Of its values.
    pub fn unit(self) -> &'static str {
        match self {
            Layer::Height
            | Layer::Water
            | Layer::Sediment
            | Layer::Wear
            | Layer::Deposit
            | Layer::Reef => "m",
            Layer::Flow => "m³/s",
            Layer::Wetness => "",
        }
    }

    /// Whether the processes of `plan` make this layer.
    pub fn exists_in(self, plan: &Plan) -> bool {
        match self {
            Layer::Height => true,
            Layer::Wear | Layer::Deposit => {
                plan.hydraulic.is_some() || plan.thermal.is_some() || plan.seabed_smoothing > 0.0
            }
            Layer::Water | Layer::Sediment | Layer::Flow | Layer::Wetness => plan.hydraulic.is_some(),
            Layer::Reef => plan.reef.is_some(),
        }
    }
}

/// An island in the making.
pub struct Simulation {
    gpu: Gpu,
    plan: Plan,
    fields: Fields,
    stages: Vec<StageWork>,
    /// Index into `stages`.
    current: usize,
    pace: Pace,
    layer: Compute<layer::Shader>,
    /// Processes that are left out.
    off: Vec<Kind>,
    brushes: live::Brushes,
    touched: bool,
}

/// The processes of a stage run in turn in each of its iterations.
struct StageWork {
    stage: Stage,
    iterations: u32,
    processes: Vec<Box<dyn Process>>,
    /// Iterations that are done; of the next one, processes, and of the next one of these, passes.
    done: u32,
    processes_done: usize,
    passes_done: u32,
}

impl StageWork {
    fn new(gpu: &Gpu, plan: &Plan, stage: Stage, iterations: u32) -> gpu::Result<StageWork> {
        let processes = processes(gpu, plan, stage)?;
        Ok(StageWork { stage, iterations, processes, done: 0, processes_done: 0, passes_done: 0 })
    }

    fn position(&self) -> Position {
        let &StageWork { stage, done: iteration, processes_done, passes_done: pass, .. } = self;
        Position { stage, iteration, process: processes_done as u32, pass }
    }

    fn at_start(&self) -> bool {
        (self.done, self.processes_done, self.passes_done) == (0, 0, 0)
    }

    /// Whether a run of this stage can be cut there.
    fn passes_by(&self, Position { stage, iteration, process, pass }: Position) -> bool {
        if stage != self.stage || iteration >= self.iterations {
            return stage == self.stage && (iteration, process, pass) == (self.iterations, 0, 0);
        }
        match self.processes.get(process as usize) {
            Some(process) => pass < process.passes(iteration + 1),
            None => false,
        }
    }

    fn go_to(&mut self, Position { stage: _, iteration, process, pass }: Position) {
        (self.done, self.processes_done, self.passes_done) = (iteration, process as usize, pass);
    }

    /// Records the next passes: `most`, or what is left of the stage up to iteration `last`. Returns how many. A process that is `off`
    /// counts as one pass in each iteration.
    fn record(
        &mut self,
        rec: &mut Recorder,
        fields: &mut Fields,
        (most, last): (u32, u32),
        off: &[Kind],
    ) -> u32 {
        let mut recorded = 0;
        while self.done < self.iterations.min(last) {
            let iteration = self.done + 1;
            let kind = Kind::of(self.stage, self.processes_done);
            match self.processes.get_mut(self.processes_done) {
                Some(process) if self.passes_done == 0 && kind.is_some_and(|kind| off.contains(&kind)) => {
                    if recorded == most {
                        break;
                    }
                    if iteration == 1 {
                        process.begin(rec, fields);
                    }
                    self.processes_done += 1;
                    recorded += 1;
                }
                Some(process) if self.passes_done < process.passes(iteration) => {
                    if recorded == most {
                        break;
                    }
                    process.pass(rec, fields, iteration, self.passes_done);
                    self.passes_done += 1;
                    recorded += 1;
                }
                Some(_) => {
                    self.processes_done += 1;
                    self.passes_done = 0;
                }
                None => {
                    self.done += 1;
                    self.processes_done = 0;
                }
            }
        }
        recorded
    }
}

impl Simulation {
    /// Builds every pipeline and allocates every image of the run.
    ///
    /// # Errors
    /// What does not fit the device, with its name and size.
    pub fn new(gpu: &Gpu, plan: &Plan) -> gpu::Result<Simulation> {
        let fields = Fields::new(gpu, plan)?;
        let stages = plan
            .stages()
            .into_iter()
            .map(|(stage, iterations)| StageWork::new(gpu, plan, stage, iterations))
            .collect::<gpu::Result<_>>()?;
        let layer = Compute::new(gpu, ())?;
        let (gpu, plan, pace) = (gpu.clone(), plan.clone(), Pace::default());
        let (off, brushes, touched) = (Vec::new(), live::Brushes::default(), false);
        Ok(Simulation { gpu, plan, fields, stages, current: 0, pace, layer, off, brushes, touched })
    }

    /// Advances by as many passes of the current stage as fit into `budget` (at least one, and never more than one
    /// submission should hold), and waits for them. The land does not depend on how a run is cut.
    pub fn step(&mut self, budget: Duration) -> gpu::Result<Progress> {
        self.step_to(u32::MAX, budget)
    }

    /// The same, but not beyond iteration `last` of the current stage.
    fn step_to(&mut self, last: u32, budget: Duration) -> gpu::Result<Progress> {
        let Some(work) = self.stages.get_mut(self.current) else { return Ok(self.progress()) };
        let most = self.pace.passes(budget.min(longest_submission(&self.gpu)));

        let start = Instant::now();
        let mut rec = Recorder::new(&self.gpu);
        let mut passes = 0;
        rec.scope(work.stage.name(), |rec| {
            passes = work.record(rec, &mut self.fields, (most, last), &self.off);
        });
        rec.submit()?.wait()?;
        if passes > 0 {
            self.pace.took(passes, start.elapsed());
        }

        self.end_stage();
        Ok(self.progress())
    }

    /// Goes over to the next stage when one is done.
    fn end_stage(&mut self) {
        let done = self.stages.get(self.current).is_some_and(|work| work.done >= work.iterations);
        if done && self.current + 1 < self.stages.len() {
            self.current += 1;
            self.pace = Pace::default();
        }
    }

    /// Where the run is; at the end of a stage rather than at the start of the next one.
    pub fn position(&self) -> Option<Position> {
        let work = self.stages.get(self.current)?;
        let last = self.current.checked_sub(1).and_then(|last| self.stages.get(last));
        Some(last.filter(|_| work.at_start()).unwrap_or(work).position())
    }

    /// The images that make up the state of this run at `position`, in a fixed order; `None` where it does not pass by.
    /// They hold that state while the run is there.
    pub fn parts(&self, position: Position) -> Option<Vec<Part>> {
        let work = self.stages.iter().find(|work| work.passes_by(position))?;
        Some(state::parts(&self.fields, position, work.iterations))
    }

    /// Goes on from `position` once the parts of a new run have been filled with the state there. Does nothing where the
    /// run does not pass by.
    pub fn resume(&mut self, position: Position) {
        let Some(index) = self.stages.iter().position(|work| work.passes_by(position)) else { return };
        self.stages[index].go_to(position);
        self.current = index;
        self.pace = Pace::default();
        self.end_stage();
    }

    /// Runs to the end.
    pub fn finish(&mut self) -> gpu::Result<()> {
        while !self.progress().finished {
            self.step(Duration::MAX)?;
        }
        Ok(())
    }

    pub fn progress(&self) -> Progress {
        match self.stages.get(self.current) {
            Some(&StageWork { stage, iterations: of, done: iteration, .. }) => {
                let finished = self.current + 1 == self.stages.len() && iteration == of;
                Progress { stage, iteration, of, finished }
            }
            None => Progress { stage: Stage::Base, iteration: 0, of: 0, finished: true },
        }
    }

    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The state itself.
    pub fn fields(&self) -> &Fields {
        &self.fields
    }

    /// The sea above the datum when the run is over, m.
    pub fn sea_level(&self) -> f32 {
        self.plan.final_sea_level()
    }

    /// The lowest and the highest ground as it is now, m; infinite where a height is not a number.
    pub fn ground_range(&self) -> gpu::Result<[f32; 2]> {
        let mut rec = Recorder::new(&self.gpu);
        let heights = rec.download(self.fields.height.src());
        let heights = heights.take(&rec.submit()?.wait()?);
        let range = |[low, high]: [f32; 2], h: f32| {
            if h.is_nan() { [f32::NEG_INFINITY, f32::INFINITY] } else { [low.min(h), high.max(h)] }
        };
        Ok(heights.into_iter().fold([f32::INFINITY, f32::NEG_INFINITY], range))
    }

    /// The land as it is now, for a renderer.
    pub fn land(&self) -> gpu::Result<Ground> {
        Ok(Ground {
            grid: self.plan.grid,
            height: self.layer(Layer::Height)?,
            water: self.layer(Layer::Water)?,
            wetness: self.layer(Layer::Wetness)?,
            reef: self.layer(Layer::Reef)?,
            sea_level: self.sea_level(),
        })
    }

    /// A copy of one layer as it is now; 0 where the world has no process that makes it.
    pub fn layer(&self, layer: Layer) -> gpu::Result<Image<R32f>> {
        let image = Image::new(&self.gpu, layer.name(), [self.plan.grid.cells; 2])?;
        let mut rec = Recorder::new(&self.gpu);
        self.record_layer(&mut rec, layer, self.sea_level(), &image);
        rec.submit()?.wait()?;
        Ok(image)
    }

    fn record_layer(&self, rec: &mut Recorder, layer: Layer, sea_level: f32, image: &Image<R32f>) {
        let fields = &self.fields;
        let push = layer::Push {
            layer: layer as u32,
            sea_level,
            sea_of_rivers: self.plan.acting_sea_level(),
            wet_memory: self.plan.hydraulic.map_or(1.0, |params| params.wet_memory.max(f32::MIN_POSITIVE)),
        };
        let bindings = layer::Bindings {
            height: fields.height.src(),
            change: &fields.change,
            water: fields.water.src(),
            sediment: fields.sediment.src(),
            axis: fields.axis.src(),
            diagonal: fields.diagonal.src(),
            reef: &fields.reef,
            layer_out: image,
        };
        rec.dispatch(&self.layer, image.size(), push, bindings);
    }
}

/// The processes of a stage, in the order in which they run in each of its iterations.
///
/// # Errors
/// What does not fit the device.
pub fn processes(gpu: &Gpu, plan: &Plan, stage: Stage) -> gpu::Result<Vec<Box<dyn Process>>> {
    let mut processes: Vec<Box<dyn Process>> = Vec::new();
    match stage {
        Stage::Base => processes.push(Box::new(Base::new(gpu, plan)?)),
        Stage::Settle => {
            if let Some(settle) = plan.thermal.and_then(|thermal| thermal.settle) {
                processes.push(Box::new(Thermal::settling(gpu, plan, &settle)?));
            }
        }
        Stage::Hydraulic => {
            if let Some(params) = &plan.hydraulic {
                processes.push(Box::new(Hydraulic::new(gpu, plan, params)?));
                if let Some(thermal) = &plan.thermal {
                    let step = params.steps(plan.grid).step;
                    processes.push(Box::new(Thermal::beside_water(gpu, plan, thermal, step)?));
                }
            }
        }
        Stage::Thermal => {
            if let Some(thermal) = &plan.thermal {
                processes.push(Box::new(Thermal::alone(gpu, plan, thermal)?));
            }
        }
        Stage::Seabed => processes.push(Box::new(Seabed::new(gpu, plan)?)),
        Stage::Reef => {
            if let Some(reef) = &plan.reef {
                processes.push(Box::new(Reef::new(gpu, plan, reef)?));
            }
        }
    }
    Ok(processes)
}

/// No submission should be longer: a GPU's watchdog and its windows wait for it. A CPU device shows no windows while it
/// works, and fewer submissions cost it less.
fn longest_submission(gpu: &Gpu) -> Duration {
    match gpu.info().kind {
        DeviceKind::Cpu => Duration::from_millis(200),
        _ => Duration::from_millis(40),
    }
}

/// Sizes submissions by the time that the last one took.
#[derive(Default)]
struct Pace(Option<Measured>);

struct Measured {
    passes: u32,
    time: Duration,
}

impl Pace {
    /// One pass where nothing is known; never more than four times the last count, since the first ones also compile.
    fn passes(&self, budget: Duration) -> u32 {
        let Some(Measured { passes, time }) = self.0 else { return 1 };
        let fit = f64::from(passes) * budget.as_secs_f64() / time.as_secs_f64().max(1e-9);
        (fit as u32).clamp(1, passes.saturating_mul(4).max(1))
    }

    fn took(&mut self, passes: u32, time: Duration) {
        self.0 = Some(Measured { passes, time });
    }
}
