//! How fast land is made here: each process on the device, beside the same steps in plain Rust ([`native`]); and how fast a
//! large forest is ([`mod@forest`]),
//! how many rays a second are traced ([`trace`]), and how fast that makes a clean picture ([`mod@picture`]); what an endless flight costs
//! ([`mod@zoom`]).
//!
//! What is compared is work, not waiting: on a CPU device the time that the threads of this process were busy, over the
//! cores; on a GPU its own timestamps. Device and native version take turns in batches, so that whatever slows the
//! machine down slows both; and since other work on the machine can only add, the shortest batch is what counts. The
//! median beside it says how calm the machine was.

mod clock;
mod estimate;
pub mod forest;
mod memory;
pub mod native;
pub mod picture;
pub mod trace;
pub mod zoom;

pub use estimate::estimate;
pub use forest::{Forest, forest};
pub use picture::{Picture, picture};
pub use trace::{Rays, rays};
pub use zoom::{Zoom, zoom};

use crate::{
    core::grid::Grid,
    gpu::{self, DeviceKind, Gpu, Image, Recorder, format::Rgba32f},
    plants,
    terrain::{
        Fields, Plan, Process,
        hydraulic::Hydraulic,
        layers::Base,
        reef::{self, Reef},
        thermal::Thermal,
    },
    world::{self, Overrides},
};
use clock::Stopwatch;
use native::Land;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::time::{Duration, Instant};

#[derive(Clone, Debug)]
pub struct Options {
    /// Cells along a side, one after the other.
    pub cells: Vec<u32>,
    /// Time for each row on the device, and as much for the native version.
    pub time: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Options { cells: vec![512, 2048], time: Duration::from_secs(1) }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    #[error(transparent)]
    World(#[from] world::Error),
    #[error(transparent)]
    Planting(#[from] plants::planting::Error),
    #[error(transparent)]
    Zoom(crate::zoom::view::Error),
    #[error("the world of the bench is no document: {0}")]
    Document(String),
    #[error("the native version leaves out what the world of the bench has")]
    NotCovered,
    #[error("stopped before everything was measured")]
    Stopped,
}

/// What was measured, and on what.
#[derive(Clone, Debug, Serialize)]
pub struct Bench {
    #[serde(skip)]
    pub device: String,
    pub driver: String,
    /// Cores that the times of a CPU are divided by.
    pub cores: usize,
    /// Of a copy from image to image, read and written, bytes a second.
    pub copy_bandwidth: f64,
    pub rows: Vec<Row>,
}

/// A process at one size. Times are nanoseconds for each cell in one iteration: of work over the cores on a CPU device
/// and natively, by timestamps on a GPU; the shortest of the batches.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub name: &'static str,
    /// Cells along a side.
    pub size: u32,
    pub ns_per_cell: f64,
    /// The same in the median batch.
    pub median_ns_per_cell: f64,
    /// The same by the wall's clock.
    pub wall_ns_per_cell: f64,
    /// Bytes that the passes of one iteration must move at least for each cell: every image that a pass reads or writes, once.
    pub bytes_per_cell: f64,
    /// Of the device's bandwidth in a copy.
    pub bandwidth_share: f64,
    pub native_ns_per_cell: f64,
    pub native_median_ns_per_cell: f64,
    pub native_wall_ns_per_cell: f64,
    /// `ns_per_cell` over `native_ns_per_cell`.
    pub ratio: f64,
}

impl Bench {
    /// Measures what the device copies; there are no rows yet.
    ///
    /// # Errors
    /// No memory for the images that are copied.
    pub fn new(gpu: &Gpu) -> gpu::Result<Bench> {
        let info = gpu.info();
        Ok(Bench {
            device: info.name.clone(),
            driver: info.driver.clone(),
            cores: clock::cores(),
            copy_bandwidth: copy_bandwidth(gpu)?,
            rows: Vec::new(),
        })
    }

    /// Measures every process of the island at every size; `done` is told each row. Between two batches `stops` is asked
    /// whether to end.
    ///
    /// # Errors
    /// A size that the device, its memory or the processes can't take; [`Error::Stopped`]. The rows until then are there.
    pub fn terrain(
        &mut self,
        gpu: &Gpu,
        options: &Options,
        stops: impl Fn() -> bool,
        mut done: impl FnMut(&Row),
    ) -> Result<(), Error> {
        for &cells in &options.cells {
            for subject in Subject::ALL {
                let row = measure(gpu, subject, cells, options.time, self.copy_bandwidth, &stops)?;
                done(&row);
                self.rows.push(row);
            }
        }
        Ok(())
    }
}

/// Batches of a row; where one takes long, fewer, but these.
const BATCHES: u32 = 11;
const FEWEST_BATCHES: u32 = 3;
/// Iterations before the first batch. The first one compiles; after these, water runs on all slopes and coral grows.
const WARM_UP: u32 = 32;

fn measure(
    gpu: &Gpu,
    subject: Subject,
    cells: u32,
    time: Duration,
    copy_bandwidth: f64,
    stops: &impl Fn() -> bool,
) -> Result<Row, Error> {
    let go_on = || if stops() { Err(Error::Stopped) } else { Ok(()) };
    go_on()?;
    let plan = subject.plan(cells)?;
    let mut device = Device::new(gpu, subject, &plan)?;
    let mut native = Native::new(subject, &plan)?;
    // Base terrain is made anew each time: there is nothing to wait for.
    let warm_up = if subject == Subject::Base { 1 } else { WARM_UP };
    for _ in 0..warm_up {
        go_on()?;
        device.run(1)?;
        native.run(1);
    }

    let batch = time / BATCHES;
    let device_iterations = iterations(batch, device.run(1)?.wall);
    let native_iterations = iterations(batch, native.run(1).wall);
    let (mut on_device, mut natively) = (Batches::default(), Batches::default());
    let start = Instant::now();
    for batch in 0..BATCHES {
        if batch >= FEWEST_BATCHES && start.elapsed() > 4 * time {
            break;
        }
        go_on()?;
        on_device.add(device.run(device_iterations)?, device_iterations, plan.grid);
        natively.add(native.run(native_iterations), native_iterations, plan.grid);
    }

    let (shortest, shortest_native) = (on_device.shortest(), natively.shortest());
    let bytes_per_cell = device.traffic()? as f64 / plan.grid.samples() as f64;
    Ok(Row {
        name: subject.name(),
        size: cells,
        ns_per_cell: shortest.work,
        median_ns_per_cell: on_device.median(),
        wall_ns_per_cell: shortest.wall,
        bytes_per_cell,
        bandwidth_share: bytes_per_cell / (shortest.work * 1e-9) / copy_bandwidth,
        native_ns_per_cell: shortest_native.work,
        native_median_ns_per_cell: natively.median(),
        native_wall_ns_per_cell: shortest_native.wall,
        ratio: shortest.work / shortest_native.work,
    })
}

fn iterations(batch: Duration, one: Duration) -> u32 {
    let fit = batch.as_secs_f64() / one.as_secs_f64().max(1e-9);
    (fit as u32).clamp(1, 256)
}

/// What is measured.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Subject {
    /// The layer list of the volcano.
    Base,
    /// Eight pipes, the island's own model.
    Hydraulic,
    /// Four pipes, as the paper prints it.
    HydraulicPaper,
    /// One pass.
    Thermal,
    /// Growth and one sweep of carbon.
    Reef,
    /// One sweep more.
    ReefSweep,
}

impl Subject {
    const ALL: [Subject; 6] = [
        Subject::Base,
        Subject::Hydraulic,
        Subject::HydraulicPaper,
        Subject::Thermal,
        Subject::Reef,
        Subject::ReefSweep,
    ];

    fn name(self) -> &'static str {
        match self {
            Subject::Base => "base",
            Subject::Hydraulic => "hydraulic",
            Subject::HydraulicPaper => "hydraulic_paper",
            Subject::Thermal => "thermal",
            Subject::Reef => "reef",
            Subject::ReefSweep => "reef_sweep",
        }
    }

    /// The volcano with this process alone, so that nothing else takes memory.
    fn plan(self, cells: u32) -> Result<Plan, Error> {
        const VOLCANO: &str = include_str!("../../configs/island/volcano.toml");
        const PAPER: &str = "format = 1\nerosion.hydraulic.preset = \"paper\"";
        let volcano = plan(VOLCANO)?;
        let grid = Grid { cells, ..volcano.grid };
        let bare = Plan {
            grid,
            hydraulic: None,
            thermal: None,
            seabed_smoothing: 0.0,
            reef: None,
            ..volcano.clone()
        };
        let cell = f64::from(grid.cell_size());
        Ok(match self {
            Subject::Base => bare,
            Subject::Hydraulic | Subject::HydraulicPaper => {
                let printed = if self == Subject::HydraulicPaper { plan(PAPER)?.hydraulic } else { None };
                let hydraulic = printed.or(volcano.hydraulic).map(|mut params| {
                    params.rain = CLOUDBURST;
                    // What one sweep of the sediment's diffusion can do, however fine the grid.
                    let step = params.steps(grid).step;
                    let most = 0.99 * cell * cell / (8.0 * step);
                    params.sediment_diffusivity = params.sediment_diffusivity.min(most as f32);
                    params
                });
                Plan { hydraulic, ..bare }
            }
            Subject::Thermal => Plan { thermal: volcano.thermal, ..bare },
            Subject::Reef | Subject::ReefSweep => {
                // What one sweep of the carbon's diffusion can do, or two.
                let mixing = if self == Subject::Reef { 0.6 } else { 1.2 };
                let reef = volcano.reef.map(|params| reef::Params {
                    stages: vec![reef::Stage { duration: params.step * 1e6, rise: 0.0 }],
                    diffusivity: (mixing * cell * cell / (4.0 * f64::from(params.step))) as f32,
                    rubble: None,
                    ..params
                });
                Plan { reef, ..bare }
            }
        })
    }
}

/// Rain, m/s, that fills the brooks in the few iterations there are: a metre an hour.
const CLOUDBURST: f32 = 1.0 / 3600.0;

fn plan(text: &str) -> Result<Plan, Error> {
    Ok(world::parse("the world of the bench", text.as_bytes(), Path::new(""), &Overrides::default())?.plan)
}

/// Time of one run, and in [`Batches`] nanoseconds a cell and iteration.
#[derive(Clone, Copy)]
struct Time<T> {
    work: T,
    wall: T,
}

/// A process on the device.
struct Device<'a> {
    gpu: &'a Gpu,
    subject: Subject,
    fields: Fields,
    process: Box<dyn Process>,
    layers: u32,
    done: u32,
}

impl<'a> Device<'a> {
    fn new(gpu: &'a Gpu, subject: Subject, plan: &Plan) -> Result<Self, Error> {
        let mut fields = Fields::new(gpu, plan)?;
        let mut base = Base::new(gpu, plan)?;
        let layers = plan.layers.len() as u32;
        let mut rec = Recorder::new(gpu);
        (1..=layers).for_each(|layer| base.step(&mut rec, &mut fields, layer));
        rec.submit()?.wait()?;
        let process: Option<gpu::Result<Box<dyn Process>>> = match subject {
            Subject::Base => None,
            Subject::Hydraulic | Subject::HydraulicPaper => {
                plan.hydraulic.map(|params| Ok(Box::new(Hydraulic::new(gpu, plan, &params)?) as _))
            }
            Subject::Thermal => {
                plan.thermal.map(|params| Ok(Box::new(Thermal::alone(gpu, plan, &params)?) as _))
            }
            Subject::Reef | Subject::ReefSweep => {
                plan.reef.as_ref().map(|params| Ok(Box::new(Reef::new(gpu, plan, params)?) as _))
            }
        };
        let process = process.unwrap_or_else(|| Ok(Box::new(base)))?;
        let mut device = Device { gpu, subject, fields, process, layers, done: 0 };
        if subject == Subject::ReefSweep {
            // The sweeps that are measured need a beginning.
            let mut rec = Recorder::new(gpu);
            device.process.step(&mut rec, &mut device.fields, 1);
            rec.submit()?.wait()?;
        }
        Ok(device)
    }

    /// Runs some iterations in one submission.
    fn run(&mut self, iterations: u32) -> gpu::Result<Time<Duration>> {
        let cpu = self.gpu.info().kind == DeviceKind::Cpu;
        let passes = if cpu { 0 } else { iterations * (self.passes() + 3) };
        let mut rec = Recorder::timed(self.gpu, passes);
        (0..iterations).for_each(|_| self.record(&mut rec));
        let watch = Stopwatch::start();
        let finished = rec.submit()?.wait()?;
        let spent = watch.stop();
        let work = if cpu {
            spent.work / clock::cores() as u32
        } else if finished.timings.is_empty() {
            spent.wall
        } else {
            finished.timings.iter().map(|timing| timing.duration).sum()
        };
        Ok(Time { work, wall: spent.wall })
    }

    /// Bytes that the passes of one iteration move at least.
    fn traffic(&mut self) -> gpu::Result<u64> {
        let mut rec = Recorder::new(self.gpu);
        self.record(&mut rec);
        let traffic = rec.traffic();
        rec.submit()?.wait()?;
        Ok(traffic)
    }

    fn passes(&self) -> u32 {
        if self.subject == Subject::Base { self.layers } else { self.process.passes(self.done + 1) }
    }

    fn record(&mut self, rec: &mut Recorder) {
        self.done += 1;
        match self.subject {
            Subject::Base => {
                rec.clear(self.fields.height.src());
                (1..=self.layers).for_each(|layer| self.process.step(rec, &mut self.fields, layer));
            }
            Subject::ReefSweep => {
                let last = self.process.passes(self.done) - 1;
                self.process.pass(rec, &mut self.fields, self.done, last);
            }
            _ => self.process.step(rec, &mut self.fields, self.done),
        }
    }
}

/// The same process in plain Rust.
struct Native {
    land: Land,
    step: fn(&mut Land),
}

impl Native {
    fn new(subject: Subject, plan: &Plan) -> Result<Native, Error> {
        let mut land = Land::new(plan).ok_or(Error::NotCovered)?;
        land.base();
        let step = match subject {
            Subject::Base => Land::base,
            Subject::Hydraulic | Subject::HydraulicPaper => Land::hydraulic,
            Subject::Thermal => Land::thermal,
            Subject::Reef => Land::reef,
            Subject::ReefSweep => {
                land.reef();
                Land::reef_sweep
            }
        };
        Ok(Native { land, step })
    }

    fn run(&mut self, iterations: u32) -> Time<Duration> {
        let watch = Stopwatch::start();
        (0..iterations).for_each(|_| (self.step)(&mut self.land));
        let spent = watch.stop();
        Time { work: spent.work / clock::cores() as u32, wall: spent.wall }
    }
}

/// Times of the batches of one side.
#[derive(Default)]
struct Batches(Vec<Time<f64>>);

impl Batches {
    fn add(&mut self, time: Time<Duration>, iterations: u32, grid: Grid) {
        let each = |time: Duration| time.as_secs_f64() * 1e9 / f64::from(iterations) / grid.samples() as f64;
        self.0.push(Time { work: each(time.work), wall: each(time.wall) });
        self.0.sort_by(|a, b| a.work.total_cmp(&b.work));
    }

    fn shortest(&self) -> Time<f64> {
        self.0.first().copied().unwrap_or(Time { work: f64::NAN, wall: f64::NAN })
    }

    fn median(&self) -> f64 {
        self.0.get(self.0.len() / 2).map_or(f64::NAN, |time| time.work)
    }
}

/// Bytes a second, read and written, of the fastest of some copies between images that no cache holds. A CPU device
/// copies with one core: there the wall's clock tells.
fn copy_bandwidth(gpu: &Gpu) -> gpu::Result<f64> {
    const LARGEST: u64 = 128 << 20;
    const WIDTH: u32 = 1024;
    let bytes_per_row = u64::from(WIDTH) * 16;
    let rows = (LARGEST.min(gpu.memory().limit / 4) / bytes_per_row).clamp(1, LARGEST / bytes_per_row);
    let size = [WIDTH, rows as u32];
    let (from, to) = (Image::<Rgba32f>::new(gpu, "copied", size)?, Image::<Rgba32f>::new(gpu, "copy", size)?);
    let mut fastest = f64::INFINITY;
    for _ in 0..5 {
        let mut rec = Recorder::timed(gpu, 1);
        rec.copy(&from, &to);
        let watch = Stopwatch::start();
        let finished = rec.submit()?.wait()?;
        let wall = watch.stop().wall;
        let time = match finished.timings.as_slice() {
            [timing] if gpu.info().kind != DeviceKind::Cpu => timing.duration,
            _ => wall,
        };
        fastest = fastest.min(time.as_secs_f64());
    }
    Ok((2 * rows * bytes_per_row) as f64 / fastest)
}

/// A table, in Markdown.
impl Display for Bench {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        writeln!(
            out,
            "{}, {}; {} cores; copies {:.1} GB/s\n",
            self.device,
            self.driver,
            self.cores,
            self.copy_bandwidth * 1e-9
        )?;
        writeln!(out, "{HEADING}")?;
        self.rows.iter().try_for_each(|row| writeln!(out, "{row}"))
    }
}

const HEADING: &str = "\
| process | size | ns | median | wall | bytes | of bandwidth | native ns | median | wall | ratio |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|";

impl Display for Row {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        write!(
            out,
            "| `{}` | {} | {:.2} | {:.2} | {:.2} | {:.0} | {:.0} % | {:.2} | {:.2} | {:.2} | {:.1} |",
            self.name,
            self.size,
            self.ns_per_cell,
            self.median_ns_per_cell,
            self.wall_ns_per_cell,
            self.bytes_per_cell,
            100.0 * self.bandwidth_share,
            self.native_ns_per_cell,
            self.native_median_ns_per_cell,
            self.native_wall_ns_per_cell,
            self.ratio
        )
    }
}
