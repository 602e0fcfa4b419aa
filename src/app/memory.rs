//! Memory that a run takes, known and refused before it begins.

use super::Error;
use crate::core::grid::Grid;
use crate::core::memory::{Memory, mebibytes, total};
use crate::gpu::{self, DeviceKind, Gpu};
use crate::raster::{self, Quality};
use crate::scene::{Film, Sky};
use crate::terrain::Plan;
use crate::trace;
use crate::world::Renderer;
use crate::zoom::{self, tiles::Tiles, view::Settings};
use std::fmt::{self, Display, Formatter};

/// What a run makes of the land.
#[derive(Clone, Copy)]
pub enum Goal<'a> {
    Picture {
        film: Film,
        sky: &'a Sky,
        /// Whether plants are in it.
        planted: bool,
        /// Memory of their models, as far as it is known: it shows when they have grown, bytes.
        models: u64,
        renderer: Renderer,
    },
    Layers(Layers<'a>),
}

/// What layers take beside the simulation.
#[derive(Clone, Copy)]
pub struct Layers<'a> {
    pub source: Source<'a>,
    /// Host memory of the largest file while it is made, bytes.
    pub file: u64,
}

/// Where layers come from.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// The simulation alone.
    Simulation,
    /// The renderer draws some, under this sky.
    Renderer(&'a Sky),
}

/// Memory of a run by what it holds. On the device it goes in phases: the picture is drawn when the simulation is gone.
pub struct Needs {
    pub land: Vec<Memory>,
    pub picture: Vec<Memory>,
    pub host: Vec<Memory>,
}

/// The memory there is, in bytes; `None` where nothing is known.
#[derive(Clone, Copy, Default)]
pub struct Limits {
    /// Of the device, in all.
    pub device: Option<u64>,
    /// Of the device, in one piece.
    piece: Option<u64>,
    /// Of the device, in one buffer.
    buffer: Option<u64>,
    /// Samples along a side of an image.
    side: Option<u32>,
    /// Of the host, for the device too where that is the CPU.
    host: Option<u64>,
    shared: bool,
}

impl Limits {
    /// Of `--memory-limit` alone, where no device is asked.
    pub fn of_option(device: Option<u64>) -> Self {
        Limits { device, ..Limits::default() }
    }

    pub fn of(gpu: &Gpu) -> Self {
        let info = gpu.info();
        let shared = info.kind == DeviceKind::Cpu;
        let limit = gpu.memory().limit;
        Limits {
            // The heap of a driver in software bounds nothing; the host's memory does.
            device: Some(if shared { limit } else { limit.min(info.memory) }),
            piece: Some(info.max_allocation),
            buffer: Some(info.max_buffer),
            side: Some(info.max_image),
            host: gpu::free_ram(),
            shared,
        }
    }
}

impl Goal<'_> {
    /// Memory of the host that maps and the picture of the sky take since the world was read, bytes.
    fn read(&self, plan: &Plan) -> u64 {
        let sky = match self {
            Goal::Picture { sky, .. } | Goal::Layers(Layers { source: Source::Renderer(sky), .. }) => {
                sky.bytes()
            }
            Goal::Layers(Layers { source: Source::Simulation, .. }) => 0,
        };
        plan.map_bytes() + sky
    }
}

impl Needs {
    pub fn of(plan: &Plan, goal: &Goal) -> Self {
        let samples = plan.grid.samples() as u64;
        let mut land = plan.memory();
        let mut picture = Vec::new();
        // The widest image on its way: controls to the device, what is kept for later runs from it.
        let mut host = vec![Memory { name: "copies", bytes: 16 * samples }];
        match goal {
            Goal::Picture { film, sky, planted, models, renderer: Renderer::Trace } => {
                picture.push(plan.land_memory());
                picture.extend(trace::memory::picture(plan.grid, film, sky));
                if *planted && *models > 0 {
                    picture.push(Memory { name: "models", bytes: *models });
                }
                host.extend(trace::memory::host(plan.grid, film));
            }
            Goal::Picture { film, sky, planted, models, renderer: Renderer::Raster } => {
                picture.push(plan.land_memory());
                picture.extend(raster::memory::picture(plan.grid, film, sky, Quality::default()));
                if *planted {
                    picture.extend(raster::memory::plants(plan.grid, film, Quality::default()));
                    if *models > 0 {
                        picture.push(Memory { name: "models", bytes: *models });
                    }
                }
                host.push(Memory { name: "picture", bytes: picture_bytes(film) });
            }
            Goal::Layers(Layers { source, file }) => {
                if let Source::Renderer(sky) = source {
                    land.extend(raster::memory::maps(plan.grid, sky));
                }
                host.push(Memory { name: "file", bytes: *file });
            }
        }
        host.push(Memory { name: "maps", bytes: goal.read(plan) });
        for parts in [&mut picture, &mut host] {
            parts.retain(|part| part.bytes > 0);
        }
        Self { land, picture, host }
    }
}

/// Refuses a run that needs more than there is: with what it needs it for, and the largest grid that would do.
pub fn check<'a>(plan: &Plan, goal: impl Fn(&Plan) -> Goal<'a>, limits: &Limits) -> Result<(), Error> {
    let cells = plan.grid.cells;
    if let Some(most) = limits.side.filter(|most| cells > *most) {
        let reason = format!("terrain.cells is {cells}, and its images have at most {most} samples a side");
        return Err(gpu::Error::Unsupported(reason).into());
    }
    let Some(excess) = excess(plan, &goal(plan), limits) else { return Ok(()) };
    let fewer = match largest_grid(plan, goal, limits) {
        Some(cells) => format!("lower terrain.cells: {cells} would do"),
        None => "fewer terrain.cells alone are not enough".into(),
    };
    Err(Error::Memory(format!("{excess}; {fewer}{}", excess.remedy)))
}

/// Memory of a zoom on the device: what stays, and all of a picture.
pub fn of_zoom(settings: &Settings, film: &Film, sky: &Sky) -> Vec<Memory> {
    let mut parts = vec![zoom::memory::tiles(settings), zoom::memory::background(settings)];
    parts.extend(zoom::memory::picture(settings, film, sky));
    parts.retain(|part| part.bytes > 0);
    parts
}

/// Refuses a zoom that needs more than there is: with what it needs it for, and how many tiles would do. `film` is what is drawn at once.
pub fn check_zoom(settings: &Settings, film: &Film, sky: &Sky, limits: &Limits) -> Result<(), Error> {
    let side = film.width.max(film.height).saturating_mul(settings.samples);
    if let Some(most) = limits.side.filter(|most| side > *most) {
        return Err(Error::Memory(format!(
            "a picture of {} × {} pixels is drawn as {side} samples along a side, and images here have at most {most}; \
             make it smaller with --size or render.size",
            film.width, film.height
        )));
    }
    let parts = of_zoom(settings, film, sky);
    let others = total(&parts) - zoom::memory::tiles(settings).bytes;
    let host = limits.host.filter(|_| limits.shared);
    // What there is, what of it is not for tiles, and how much of a tile is in it: heights, which are one buffer, are a third.
    let rows = [
        ("device memory", parts.clone(), limits.device, others, 1, ", or raise --memory-limit"),
        ("the computer's memory", parts, host, others, 1, ", or end other programs"),
        ("device memory in one buffer", vec![zoom::memory::piece(settings)], limits.buffer, 0, 3, ""),
    ];
    let slot = Tiles::slot_bytes(settings.bits);
    let fit = rows.iter().filter_map(|(_, _, limit, others, share, _)| {
        Some(limit.as_ref()?.saturating_sub(*others).saturating_mul(*share) / slot)
    });
    let fit = fit.min().unwrap_or(u64::MAX);
    let advice = match fit {
        0..FEWEST_TILES => {
            "lower zoom.tile, zoom.visibility (below 13 there is no background) or the picture's size".into()
        }
        _ => format!("lower zoom.tiles: {fit} would fit"),
    };
    let excess = rows.into_iter().find_map(|(of, parts, limit, _, _, remedy)| {
        let limit = limit.filter(|limit| total(&parts) > *limit)?;
        let (needed, may, parts) = (mebibytes(total(&parts)), mebibytes(limit), by_name(&parts));
        Some(format!("the zoom needs {needed} of {of} and {may} may be used ({parts}); {advice}{remedy}"))
    });
    excess.map_or(Ok(()), |excess| Err(Error::Memory(excess)))
}

/// The least that `zoom.tiles` can be.
const FEWEST_TILES: u64 = 1000;

/// Most cells that the world could have within the limits.
pub fn largest_grid<'a>(plan: &Plan, goal: impl Fn(&Plan) -> Goal<'a>, limits: &Limits) -> Option<u32> {
    const FEWEST: u32 = 64;
    const MOST: u32 = 8192;

    let fits = |cells: u32| {
        let plan = Plan { grid: Grid { cells, ..plan.grid }, ..plan.clone() };
        limits.side.is_none_or(|most| cells <= most) && excess(&plan, &goal(&plan), limits).is_none()
    };
    if !fits(FEWEST) {
        return None;
    }
    let (mut fit, mut too_many) = (FEWEST, MOST + 1);
    while too_many - fit > 1 {
        let middle = fit.midpoint(too_many);
        if fits(middle) { fit = middle } else { too_many = middle }
    }
    Some(fit)
}

/// More than there is, of one kind of memory.
struct Excess {
    what: &'static str,
    of: &'static str,
    parts: Vec<Memory>,
    limit: u64,
    /// What else would help than fewer cells.
    remedy: &'static str,
}

fn excess(plan: &Plan, goal: &Goal, limits: &Limits) -> Option<Excess> {
    let Needs { land, picture, mut host } = Needs::of(plan, goal);
    // The widest image has four floats a sample.
    let image = vec![Memory { name: "flow", bytes: 16 * plan.grid.samples() as u64 }];
    if limits.shared {
        host.push(Memory { name: "device", bytes: total(&land).max(total(&picture)) });
    }
    // They have been read: what is free doesn't count them.
    let free = limits.host.map(|free| free.saturating_add(goal.read(plan)));
    let raise = ", or raise --memory-limit";
    let smaller = " or the picture's size, or raise --memory-limit";
    let rows = [
        ("an image of the land", "device memory in one piece", image, limits.piece, ""),
        ("the land", "device memory", land, limits.device, raise),
        ("the picture", "device memory", picture, limits.device, smaller),
        ("the run", "the computer's memory", host, free, ", or end other programs"),
    ];
    rows.into_iter().find_map(|(what, of, parts, limit, remedy)| {
        let limit = limit.filter(|limit| total(&parts) > *limit)?;
        Some(Excess { what, of, parts, limit, remedy })
    })
}

impl Display for Excess {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Excess { what, of, parts, limit, .. } = self;
        let mut parts = parts.clone();
        parts.sort_by_key(|part| std::cmp::Reverse(part.bytes));
        write!(
            out,
            "{what} needs {} of {of} and {} may be used ({})",
            mebibytes(total(&parts)),
            mebibytes(*limit),
            by_name(&parts)
        )
    }
}

/// What each part takes.
pub fn by_name(parts: &[Memory]) -> String {
    let parts = parts.iter().map(|part| format!("{} {}", part.name, mebibytes(part.bytes)));
    parts.collect::<Vec<_>>().join(", ")
}

/// Refuses a picture that would take more than [`MOST_PICTURE`].
pub fn check_picture(film: &Film) -> Result<(), Error> {
    let needed = picture_bytes(film);
    if needed <= MOST_PICTURE {
        return Ok(());
    }
    Err(Error::Memory(format!(
        "a picture of {} × {} pixels takes {} of memory, and may take {}; make it smaller with --size or render.size",
        film.width,
        film.height,
        mebibytes(needed),
        mebibytes(MOST_PICTURE)
    )))
}

/// Most memory of the host, bytes, that a picture may take: some 178 million pixels.
const MOST_PICTURE: u64 = 3 << 30;

/// Floats, the screen's bytes, and these again while they are compressed.
fn picture_bytes(film: &Film) -> u64 {
    u64::from(film.width) * u64::from(film.height) * (12 + 3 + 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SkyMap, ToneMap};
    use crate::world::{self, Overrides};
    use std::path::Path;
    use std::sync::Arc;

    fn plan(cells: u32) -> Plan {
        let text = format!("format = 1\nterrain.cells = {cells}");
        world::parse("test.toml", text.as_bytes(), Path::new(""), &Overrides::default()).unwrap().plan
    }

    fn picture(_: &Plan) -> Goal<'static> {
        under(&Sky::None)
    }

    fn under(sky: &Sky) -> Goal<'_> {
        let film = Film { width: 1280, height: 720, exposure: 1.0, tone_map: ToneMap::None };
        Goal::Picture { film, sky, planted: false, models: 0, renderer: Renderer::Raster }
    }

    fn refusal(plan: &Plan, limits: Limits) -> Option<String> {
        check(plan, picture, &limits).err().map(|error| error.to_string())
    }

    #[test]
    fn the_host_is_asked_too() {
        let gibibyte = Some(1 << 30);
        let own = Limits { host: gibibyte, ..Limits::default() };
        assert_eq!(refusal(&plan(4096), own), None);
        // A device that is the CPU takes from the same memory.
        let message = refusal(&plan(4096), Limits { shared: true, ..own }).unwrap();
        for part in ["the run needs", "the computer's memory and 1024.0 MiB", "device 2432.0 MiB", "would do"]
        {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn an_image_fits_one_allocation_and_the_device() {
        let limits = Limits { piece: Some(16 * 2000 * 2000), ..Limits::default() };
        assert_eq!(refusal(&plan(2000), limits), None);
        let message = refusal(&plan(2001), limits).unwrap();
        assert!(message.contains("in one piece") && message.contains("2000 would do"), "{message}");

        let limits = Limits { side: Some(4096), ..Limits::default() };
        assert_eq!(refusal(&plan(4096), limits), None);
        let message = refusal(&plan(4097), limits).unwrap();
        assert!(message.contains("at most 4096 samples a side"), "{message}");
        assert_eq!(largest_grid(&plan(64), picture, &limits), Some(4096));
    }

    #[test]
    fn a_picture_of_the_sky_counts() {
        let texels = vec![[1.0; 3]; 1 << 21];
        let sky = Sky::Map(Arc::new(SkyMap { width: 2048, height: 1024, texels, rotation: 0.0 }));
        for renderer in [Renderer::Raster, Renderer::Trace] {
            let needed = |sky| {
                let Goal::Picture { film, planted, models, .. } = under(sky) else { unreachable!() };
                let goal = Goal::Picture { film, sky, planted, models, renderer };
                let Needs { picture, host, .. } = Needs::of(&plan(256), &goal);
                [total(&picture), total(&host)]
            };
            let [device, host] = [0, 1].map(|kind| needed(&sky)[kind] - needed(&Sky::None)[kind]);
            assert!(device >= 24 << 20 && host == 24 << 20, "{device} {host}");
        }
    }

    #[test]
    fn what_nothing_is_known_of_is_no_limit() {
        assert_eq!(refusal(&plan(8192), Limits::default()), None);
        assert_eq!(largest_grid(&plan(64), picture, &Limits::default()), Some(8192));
    }
}
