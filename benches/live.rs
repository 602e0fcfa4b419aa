//! `cargo bench --bench live`: what it takes to watch an island, on the device that is found first. With the name of a PNG as its argument
//! it writes the pictures that it draws, too.

mod kit;

use std::error::Error;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};
use terrane::formats::png;
use terrane::gpu::{Gpu, Image, Recorder, format::Rgba8};
use terrane::raster::{Detail, Live, Renderer, View};
use terrane::scene::{Camera, Film, Population, Scene, Viewpoint};
use terrane::terrain::Simulation;
use terrane::world::{self, Overrides};

/// What was done, how long it took, ms, and how much of that was which pass.
struct Row(String, f64, String);

struct Table(String, Vec<Row>);

fn main() -> ExitCode {
    let file = std::env::args().skip(1).find(|argument| argument.ends_with(".png"));
    kit::print(|gpu| measure(gpu, file.as_deref()))
}

fn measure(gpu: &Gpu, file: Option<&str>) -> Result<Table, Box<dyn Error>> {
    let overrides = Overrides { set: vec!["erosion.hydraulic.duration=100".into()], seed: None };
    let world = world::load(Path::new("configs/island/volcano.toml"), &overrides)?;
    let mut plan = world.plan.clone();
    plan.reef = None;
    let mut simulation = Simulation::new(gpu, &plan)?;
    simulation.finish()?;
    let view = match world.viewpoint {
        Viewpoint::Fixed(view) => view,
        Viewpoint::Stand(_) => return Err("a view of the whole island".into()),
    };
    let camera = Camera { view, fov: world.fov };
    let scene = Scene {
        ground: simulation.land()?,
        light: world.light.clone(),
        sea: world.sea,
        surface: world.surface.clone(),
        population: Population::default(),
        camera,
    };
    let mut rows = Vec::new();
    let renderer = Arc::new(timed(&mut rows, "programs", || Renderer::new(gpu))?);
    let mut live = timed(&mut rows, "a scene taken over", || Live::new(gpu, renderer, scene))?;
    for run in ["light, for the first time", "light"] {
        live.ground_changed()?;
        timed(&mut rows, run, || {
            while live.relight(Duration::MAX)? {}
            Ok(())
        })?;
        note(&mut rows, &live);
    }
    timed(&mut rows, "bounds", || live.ground_changed())?;
    for (detail, size, runs) in [
        (Detail::Swift, [960, 540], 3),
        (Detail::Swift, [480, 270], 3),
        (Detail::Full, [960, 540], 2),
        (Detail::Full, [480, 270], 2),
    ] {
        let film = Film { width: size[0], height: size[1], ..world.film };
        let target = Image::<Rgba8>::new(gpu, "target", size)?;
        let view = View { camera: live.stand(camera, &film), film, samples: 1, detail, overlay: None };
        for run in 0..runs {
            let name = format!("{detail:?}, {} × {}, picture {}", size[0], size[1], run + 1);
            timed(&mut rows, &name, || live.draw(&view, &target))?;
            note(&mut rows, &live);
        }
        if let Some(file) = file {
            let mut rec = Recorder::new(gpu);
            let download = rec.download(&target);
            let pixels = download.take(&rec.submit()?.wait()?);
            let pixels: Vec<u8> = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            let name = file.replace(".png", &format!("_{detail:?}_{}.png", size[0]));
            png::write_picture(Path::new(&name), size, &pixels)?;
        }
    }
    Ok(Table(format!("{}, {}", gpu.info().name, gpu.info().driver), rows))
}

fn timed<T>(
    rows: &mut Vec<Row>,
    name: &str,
    work: impl FnOnce() -> terrane::gpu::Result<T>,
) -> terrane::gpu::Result<T> {
    let start = Instant::now();
    let done = work()?;
    rows.push(Row(name.into(), start.elapsed().as_secs_f64() * 1e3, String::new()));
    Ok(done)
}

/// What the passes of the last row took.
fn note(rows: &mut [Row], live: &Live) {
    let pass = |timing: &terrane::gpu::Timing| {
        let name = timing.name.rsplit('/').next().unwrap_or_default();
        format!("{name} {:.1}", timing.duration.as_secs_f64() * 1e3)
    };
    if let Some(row) = rows.last_mut() {
        row.2 = live.timings().iter().map(pass).collect::<Vec<_>>().join(", ");
    }
}

impl Display for Table {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Table(device, rows) = self;
        writeln!(out, "{device}; volcano, 512 cells a side\n\n| what | ms | passes, ms |\n|---|--:|---|")?;
        rows.iter().try_for_each(|Row(name, time, passes)| writeln!(out, "| {name} | {time:.1} | {passes} |"))
    }
}
