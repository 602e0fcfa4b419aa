//! What an endless flight costs at different depths: time of frames, memory, and the first frame at a place that was never flown to.

use super::Error;
use super::clock::{self, Stopwatch};
use crate::gpu::Gpu;
use crate::world::{self, Overrides, World};
use crate::zoom::{
    address::Location,
    height::{Spine, Surface},
    motion::{Autopilot, Depth, Pose},
    view::{self, Ahead, Renderer, Settings, View},
};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::time::Duration;

/// What was measured, and on what.
#[derive(Clone, Debug, Serialize)]
pub struct Zoom {
    #[serde(skip)]
    pub device: String,
    pub driver: String,
    pub cores: usize,
    pub size: [u32; 2],
    /// Quads along a side of a tile.
    pub tile: u32,
    pub rows: Vec<Row>,
    pub memory: Vec<Memory>,
    /// What each level of depth adds to the memory of the host, bytes.
    pub host_bytes_per_level: f64,
    /// Of a picture at the last of these depths from its location code, without a tile to begin with.
    pub first_frame_seconds: f64,
}

/// Frames from one depth on.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub depth: u32,
    pub frames: u32,
    /// By the wall's clock.
    pub wall: Times,
    /// Of all threads of the process together, which other work on the machine adds nothing to; where the device is the processor, its work too.
    pub work: Times,
}

/// Of frames, milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Times {
    pub median: f64,
    /// Of a hundred, one takes longer.
    pub percentile_99: f64,
    pub max: f64,
}

/// After a picture.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Memory {
    pub depth: u32,
    /// Of the device, bytes.
    pub gpu_bytes: u64,
    /// Of the host, for the way and the surface around the place, bytes.
    pub host_bytes: usize,
}

const WORLD: &str = include_str!("../../configs/zoom/tiny.toml");

/// Depths of flights, and of pictures whose memory is looked at.
const FLIGHTS: [u32; 2] = [10, 1000];
const DEPTHS: [u32; 3] = [50, 1000, 10_000];

/// Frames that are measured, and those before them.
const FRAMES: u32 = 200;
const WARM: u32 = 32;

/// Frames in a level.
const FRAMES_A_LEVEL: u32 = 32;

/// How often each flight is flown. Other work on the machine can only add, so the shorter time of a frame counts.
const PASSES: u32 = 5;

/// Flights take turns frame by frame, so that whatever slows the machine down slows all of them. Between two frames `stops` is asked whether to end, and
/// `done` is told each row.
///
/// # Errors
/// No memory; [`Error::Stopped`].
pub fn zoom(gpu: &Gpu, stops: impl Fn() -> bool, mut done: impl FnMut(&Row)) -> Result<Zoom, Error> {
    let info = gpu.info();
    let subject = Subject::new(gpu)?;
    let rows = subject.fly(&stops)?;
    rows.iter().for_each(&mut done);
    let memory = DEPTHS.iter().map(|depth| subject.memory(*depth)).collect::<Result<Vec<_>, Error>>()?;
    let [.., before, last] = memory[..] else { return Err(Error::Stopped) };
    let grown = last.host_bytes as f64 - before.host_bytes as f64;
    Ok(Zoom {
        device: info.name.clone(),
        driver: info.driver.clone(),
        cores: clock::cores(),
        size: [subject.world.film.width, subject.world.film.height],
        tile: 1 << subject.settings.bits,
        rows,
        host_bytes_per_level: grown / f64::from(last.depth - before.depth),
        memory,
        first_frame_seconds: subject.first_frame(last.depth)?.as_secs_f64(),
    })
}

/// A flight, and the times of its frames: the shortest of all passes, wall and work.
struct Flight {
    depth: u32,
    renderer: Renderer,
    autopilot: Autopilot,
    ahead: Ahead,
    times: Vec<[Duration; 2]>,
}

struct Subject<'a> {
    gpu: &'a Gpu,
    world: World,
    surface: Surface,
    settings: Settings,
}

impl Subject<'_> {
    fn new(gpu: &Gpu) -> Result<Subject<'_>, Error> {
        let world = world::parse("tiny.toml", WORLD.as_bytes(), Path::new(""), &Overrides::default())?;
        let zoom = world.zoom.as_ref().ok_or_else(|| Error::Document("it has no `zoom`".into()))?;
        let (surface, settings) = (zoom.surface(world.seed), zoom.settings(&world.film, world.fov));
        Ok(Subject { gpu, world, surface, settings })
    }

    fn renderer(&self) -> Result<Renderer, Error> {
        Ok(Renderer::new(self.gpu, self.surface, self.settings, &self.world.light, &self.world.film)?)
    }

    fn view(&self, autopilot: &mut Autopilot, spine: &mut Spine, depth: Depth) -> View {
        let Pose { place, attitude } = autopilot.at(spine, depth);
        View { place, attitude, fov: self.world.fov, level: depth.whole() }
    }

    /// All flights, each through some levels before those that are measured.
    fn fly(&self, stops: impl Fn() -> bool) -> Result<Vec<Row>, Error> {
        let begin = |depth| {
            let autopilot = Autopilot::new(self.surface);
            let times = vec![[Duration::MAX; 2]; FRAMES as usize];
            Ok(Flight { depth, renderer: self.renderer()?, autopilot, ahead: Ahead::default(), times })
        };
        let mut flights = FLIGHTS.into_iter().map(begin).collect::<Result<Vec<_>, Error>>()?;
        for _ in 0..PASSES {
            for flight in &mut flights {
                flight.renderer.clear();
                flight.ahead = Ahead::default();
            }
            for frame in 0..WARM + FRAMES {
                for flight in &mut flights {
                    if stops() {
                        return Err(Error::Stopped);
                    }
                    self.frame(flight, frame)?;
                }
            }
        }
        let row = |Flight { depth, times, .. }: Flight| {
            let [wall, work] = [0, 1].map(|clock: usize| Times::of(times.iter().map(|time| time[clock])));
            Row { depth, frames: FRAMES, wall, work }
        };
        Ok(flights.into_iter().map(row).collect())
    }

    fn frame(&self, flight: &mut Flight, frame: u32) -> Result<(), Error> {
        let Flight { depth, renderer, autopilot, ahead, times } = flight;
        let mut view = |spine: &mut Spine, frame: u32| {
            let frames = u64::from(*depth * FRAMES_A_LEVEL + frame - WARM);
            self.view(autopilot, spine, Depth::of_frame(frames, 1, FRAMES_A_LEVEL))
        };
        let watch = Stopwatch::start();
        let here = view(renderer.spine(), frame);
        renderer.render(&here)?;
        let window = (Ahead::LEVELS * f64::from(FRAMES_A_LEVEL)) as u32;
        let coming = |spine: &mut Spine, frame| Ok::<_, Error>(view(spine, frame));
        ahead.look(renderer, frame..WARM + FRAMES, window, coming)?;
        let spent = watch.stop();
        if let Some(time) = frame.checked_sub(WARM).and_then(|frame| times.get_mut(frame as usize)) {
            *time = [time[0].min(spent.wall), time[1].min(spent.work)];
        }
        Ok(())
    }

    fn memory(&self, depth: u32) -> Result<Memory, Error> {
        let mut renderer = self.renderer()?;
        let mut autopilot = Autopilot::new(self.surface);
        let view = self.view(&mut autopilot, renderer.spine(), Depth::level(depth));
        renderer.render(&view)?;
        let gpu_bytes = self.gpu.memory().used;
        let place = [&view.place.x, &view.place.y, &view.place.z].map(|number| number.bytes());
        let host_bytes = renderer.spine().bytes() + autopilot.bytes() + place.iter().sum::<usize>();
        Ok(Memory { depth, gpu_bytes, host_bytes })
    }

    fn first_frame(&self, depth: u32) -> Result<Duration, Error> {
        let mut spine = Spine::new(self.surface);
        let depth = Depth::level(depth);
        let View { place, attitude, fov, level } =
            self.view(&mut Autopilot::new(self.surface), &mut spine, depth);
        let fov = Location::nearest_fov(fov);
        let code = Location { surface: self.surface, level, place, attitude, fov }.code();
        let mut renderer = self.renderer()?;
        // Programs are compiled when they first run.
        let near = self.view(&mut Autopilot::new(self.surface), &mut spine, Depth::level(0));
        renderer.render(&near)?;
        renderer.clear();
        let watch = Stopwatch::start();
        let location = Location::parse(&code).map_err(|error| Error::Document(error.to_string()))?;
        renderer.render(&View::of(&location))?;
        Ok(watch.stop().wall)
    }
}

impl Times {
    fn of(times: impl Iterator<Item = Duration>) -> Times {
        let mut times: Vec<Duration> = times.collect();
        times.sort_unstable();
        let at = |share: f64| {
            let index = (share * (times.len().saturating_sub(1)) as f64).round() as usize;
            times.get(index).map_or(0.0, |time| 1e3 * time.as_secs_f64())
        };
        Times { median: at(0.5), percentile_99: at(0.99), max: at(1.0) }
    }
}

impl From<view::Error> for Error {
    fn from(error: view::Error) -> Error {
        match error {
            view::Error::Gpu(error) => Error::Gpu(error),
            error => Error::Zoom(error),
        }
    }
}

/// Tables, in Markdown.
impl Display for Zoom {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Zoom { device, driver, cores, size: [width, height], tile, .. } = self;
        writeln!(
            out,
            "{device}, {driver}; {cores} cores; {width} × {height} pixels, tiles of {tile} × {tile} quads, \
             {FRAMES_A_LEVEL} frames a level\n"
        )?;
        writeln!(out, "| frames | median | 99 % | longest | work: median | 99 % | longest |")?;
        writeln!(out, "|---|--:|--:|--:|--:|--:|--:|")?;
        for Row { depth, frames, wall, work } in &self.rows {
            writeln!(out, "| {frames} from depth {depth} | {wall} | {work} |")?;
        }
        if let [first, .., last] = &self.rows[..] {
            let ratio = |of: fn(&Row) -> Times| of(last).median / of(first).median;
            writeln!(
                out,
                "\nmedian at depth {} over that at depth {}: {:.2}, of work {:.2}",
                last.depth,
                first.depth,
                ratio(|row| row.wall),
                ratio(|row| row.work)
            )?;
        }
        writeln!(out, "\n| depth | device, bytes | host, bytes |\n|--:|--:|--:|")?;
        for Memory { depth, gpu_bytes, host_bytes } in &self.memory {
            writeln!(out, "| {depth} | {gpu_bytes} | {host_bytes} |")?;
        }
        writeln!(
            out,
            "\nhost: {:.2} bytes a level; the first frame at depth {} from its code: {:.2} s",
            self.host_bytes_per_level,
            self.memory.last().map_or(0, |memory| memory.depth),
            self.first_frame_seconds
        )
    }
}

impl Display for Times {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Times { median, percentile_99, max } = self;
        write!(out, "{median:.1} ms | {percentile_99:.1} ms | {max:.1} ms")
    }
}
