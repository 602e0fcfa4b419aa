//! `terrane render`: a picture of a world.

mod trace;

use super::options::{DeviceOptions, OutputOptions, Size, WorldOptions, size};
use super::output::{Place, check_extension};
use crate::app::memory::{self, Goal, Limits, check_picture};
use crate::app::{Error, Session, interrupt, land, population};
use crate::formats;
use crate::gpu::Gpu;
use crate::raster::{self, Quality};
use crate::scene::{Film, Picture, Scene};
use crate::terrain::Plan;
use crate::trace::Traversal;
use crate::world::{Renderer, World};
use clap::{Args, ValueHint};
use std::path::{Path, PathBuf};
use trace::Shot;

/// Render a picture of a world
#[derive(Args)]
pub struct Arguments {
    /// Picture to write, .png or .exr, or a folder for it [default: ./<world>.png, or what a folder of settings says]
    #[arg(short, value_name = "OUT", value_hint = ValueHint::AnyPath)]
    out: Option<PathBuf>,

    /// Size of the picture in pixels [default: the world's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    /// How the picture is made: raster, or trace for path tracing [default: the world's]
    #[arg(long, value_name = "NAME", value_parser = method)]
    renderer: Option<Renderer>,

    /// What traced rays go through: query (what the device itself has for that), bvh (our own trees), or auto, the first
    /// where there is one
    #[arg(long, value_name = "NAME", value_parser = traversal, default_value = "auto")]
    traversal: Choice,

    #[command(flatten)]
    limits: trace::Limits,

    #[command(flatten)]
    world: WorldOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

/// Of what rays go through; `None` leaves it to the device.
#[derive(Clone, Copy)]
struct Choice(Option<Traversal>);

const EXTENSIONS: [&str; 2] = ["png", "exr"];

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let place = arguments.out.as_deref().map(Place::of);
    if let Some(Place::File(path)) = &place {
        check_extension(path, &EXTENSIONS)?;
    }
    let world = land::load(&arguments.world, session)?;
    let (place, name) = match place {
        Some(place) => (place, format!("{}.png", world.name)),
        None => unasked(&world),
    };
    let renderer = arguments.renderer.unwrap_or(world.renderer);
    let mut film = world.film;
    if let Some(Size { width, height }) = arguments.size {
        film = Film { width, height, ..film };
    }
    check_picture(&film)?;
    place.prepare([name.as_str()])?;

    interrupt::listen();
    let gpu = land::open(&arguments.device, session)?;
    let traversal = arguments.traversal.0.unwrap_or_else(|| Traversal::best(&gpu));
    traversal.check(&gpu)?;
    let planted = !world.plants.rules.is_empty();
    memory::check(&world.plan, |_| Goal::Picture { film, planted, models: 0, renderer }, &Limits::of(&gpu))?;
    let simulation = land::simulate(&gpu, &world, session)?;
    let camera = land::camera(&gpu, &world, &simulation)?;
    let population = population::populate(&gpu, &world, &simulation, &camera, &film, session)?;
    if renderer == Renderer::Trace {
        let models = crate::trace::memory::population(&population).bytes;
        let goal = |_: &Plan| Goal::Picture { film, planted: models > 0, models, renderer };
        memory::check(&world.plan, goal, &Limits::of(&gpu))?;
    }
    let pinhole = population::seen_from(&gpu, &simulation, &camera, &film)?;
    let scene = land::scene(&world, simulation.land()?, camera, population);
    drop(simulation);
    let path = place.file(&name);
    match renderer {
        Renderer::Raster => {
            let picture = raster(&gpu, &scene, &film, session)?;
            place.make()?;
            write(&path, &picture, &film, session)
        }
        Renderer::Trace => {
            let shot =
                Shot { world: &world, scene: &scene, film, camera: pinhole, traversal, path, place: &place };
            trace::run(&gpu, &shot, &arguments.limits, session)
        }
    }
}

fn raster(gpu: &Gpu, scene: &Scene, film: &Film, session: &mut Session) -> Result<Picture, Error> {
    let renderer = raster::Renderer::new(gpu)?;
    let mut drawing = renderer.begin(scene, film, Quality::default())?;
    loop {
        let (done, of) = drawing.progress();
        session.progress.show("picture", done as u64, of as u64);
        interrupt::check(&session.report)?;
        if !drawing.step()? {
            break;
        }
    }
    session.progress.end();
    Ok(drawing.into_picture())
}

/// Where a picture goes when nobody says it, and its name.
fn unasked(world: &World) -> (Place, String) {
    let photo = world.photo.as_deref().and_then(|photo| Some((photo.parent()?, photo.file_name()?)));
    match photo {
        Some((folder, name)) => (Place::Folder(folder.into()), name.to_string_lossy().into_owned()),
        None => (Place::of(Path::new("./")), format!("{}.png", world.name)),
    }
}

fn write(path: &Path, picture: &Picture, film: &Film, session: &mut Session) -> Result<(), Error> {
    let size = [picture.width, picture.height];
    let written = match formats::extension(path).as_str() {
        "exr" => formats::exr::write_picture(path, size, &picture.pixels, 1.0 / film.exposure)?,
        _ => formats::png::write_picture(path, size, &picture.developed(film.tone_map))?,
    };
    session.progress.say(&format!("wrote {}, {} × {} pixels", path.display(), picture.width, picture.height));
    session.report.wrote(&written);
    Ok(())
}

fn traversal(name: &str) -> Result<Choice, String> {
    match name {
        "auto" => Ok(Choice(None)),
        "query" => Ok(Choice(Some(Traversal::Query))),
        "bvh" => Ok(Choice(Some(Traversal::Bvh))),
        _ => Err("use auto, query or bvh".into()),
    }
}

fn method(name: &str) -> Result<Renderer, String> {
    match name {
        "raster" => Ok(Renderer::Raster),
        "trace" => Ok(Renderer::Trace),
        _ => Err("use raster or trace".into()),
    }
}
