//! `terrane bench`: how fast this machine makes land, plants it, traces it, and zooms.

use super::options::{DeviceOptions, OutputOptions, WorldOptions};
use super::output::print;
use crate::app::population::Garden;
use crate::app::report::Details;
use crate::app::{Error, Session, interrupt, land};
use crate::bench::{self, Bench};
use crate::gpu::Gpu;
use crate::scene::Film;
use clap::{Args, ValueEnum, ValueHint, value_parser};
use std::path::PathBuf;
use std::time::Duration;

/// Measure how fast this machine makes land, beside the same steps in plain Rust, plants a forest, traces rays, and zooms
#[derive(Args)]
pub struct Arguments {
    /// What to measure
    #[arg(value_enum, default_value = "terrain")]
    subject: Subject,

    /// With picture: world file
    #[arg(value_hint = ValueHint::AnyPath)]
    world: Option<PathBuf>,

    /// With terrain: samples along a side, from 32 to 4096; several with commas between, for example --cells 512,1024
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "512,2048")]
    #[arg(value_parser = value_parser!(u32).range(32..=4096))]
    cells: Vec<u32>,

    /// With terrain: seconds for each row of the table
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = seconds)]
    time: Duration,

    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Base terrain, erosion, reef
    Terrain,
    /// A million plants of ten species
    Forest,
    /// Rays through a million triangles
    Trace,
    /// Samples and error of a small path traced picture of a world
    Picture,
    /// Frames of a flight into a zoom, and their memory, at different depths
    Zoom,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    interrupt::listen();
    let gpu = land::open(&arguments.device, session)?;
    match arguments.subject {
        Subject::Terrain => terrain(&gpu, arguments, session),
        Subject::Forest => forest(&gpu, arguments, session),
        Subject::Trace => trace(&gpu, arguments, session),
        Subject::Picture => picture(&gpu, arguments, session),
        Subject::Zoom => zoom(&gpu, arguments, session),
    }
}

fn terrain(gpu: &Gpu, arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let options = bench::Options { cells: arguments.cells.clone(), time: arguments.time };
    let mut bench = Bench::new(gpu)?;
    let measured = bench.terrain(gpu, &options, interrupt::requested, |row| {
        let bench::Row { name, size, ns_per_cell, .. } = row;
        session.progress.say(&format!("{name}: {ns_per_cell:.2} ns a cell at {size} × {size}"));
    });
    // The rows that are done count, whatever became of the others.
    if !arguments.output.json && !bench.rows.is_empty() {
        print(bench.to_string().as_bytes())?;
    }
    session.report.details = Some(Details::Bench(bench));
    Ok(measured?)
}

fn forest(gpu: &Gpu, arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let forest = bench::forest(gpu, interrupt::requested, |row| {
        session.progress.say(&format!("{}: {:.2} s", row.name, row.seconds));
    })?;
    if !arguments.output.json {
        print(forest.to_string().as_bytes())?;
    }
    session.report.details = Some(Details::Forest(forest));
    Ok(())
}

fn trace(gpu: &Gpu, arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let rays = bench::rays(gpu, interrupt::requested, |row| {
        session.progress.say(&format!("{}: {:.2} million rays a second", row.name, row.mrays));
    })?;
    if !arguments.output.json {
        print(rays.to_string().as_bytes())?;
    }
    session.report.details = Some(Details::Rays(rays));
    Ok(())
}

fn picture(gpu: &Gpu, arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let Some(path) = &arguments.world else {
        return Err(Error::Usage("bench picture: name a world, for example configs/forest/tiny.toml".into()));
    };
    let options = WorldOptions { world: path.clone(), set: Vec::new(), seed: None, no_cache: false };
    let world = land::load(&options, session)?;
    if world.zoom.is_some() {
        return Err(Error::Missing("bench picture: a zoom is not traced; see `terrane bench zoom`".into()));
    }
    let film = Film { width: WIDTH, height: HEIGHT, ..world.film };
    let simulation = land::simulate(gpu, &world, session)?;
    let camera = land::camera(gpu, &world, &simulation)?;
    let garden = Garden::new(gpu, &world, &simulation, session)?;
    let population = garden.populate(&camera, &film, session)?;
    let pinhole = garden.pinhole(&camera, &film);
    let scene = land::scene(&world, simulation.land()?, camera, population);
    let view = (&scene, &film, &pinhole);
    let picture = bench::picture(gpu, &world.name, view, world.tracing, interrupt::requested, |row| {
        session.progress.say(&format!("{}: {:.0} samples a second", row.numbers, row.samples_per_second));
    })?;
    if !arguments.output.json {
        print(picture.to_string().as_bytes())?;
    }
    session.report.details = Some(Details::Picture(picture));
    Ok(())
}

fn zoom(gpu: &Gpu, arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let zoom = bench::zoom(gpu, interrupt::requested, |row| {
        session.progress.say(&format!("from depth {}: {:.1} ms a frame", row.depth, row.wall.median));
    })?;
    if !arguments.output.json {
        print(zoom.to_string().as_bytes())?;
    }
    session.report.details = Some(Details::Zoom(zoom));
    Ok(())
}

/// Of the picture that is traced, pixels.
const WIDTH: u32 = 160;
const HEIGHT: u32 = 90;

/// Reads a time, up to a minute.
fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.001..=60.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("it must be a number of seconds between 0.001 and 60".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::cli::Cli;
    use clap::CommandFactory;

    #[test]
    fn the_help_shows_the_sizes_as_they_are_typed() {
        let default = Cli::command().get_matches_from(["terrane", "bench"]);
        let cells = default.subcommand_matches("bench").and_then(|bench| bench.get_many::<u32>("cells"));
        assert!(cells.is_some_and(|cells| cells.eq(&bench::Options::default().cells)));
        let mut program = Cli::command();
        let help = program.find_subcommand_mut("bench").map(|bench| bench.render_help().to_string());
        assert!(help.is_some_and(|help| help.contains("[default: 512,2048]")));
    }
}
