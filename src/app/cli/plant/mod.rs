//! `terrane plant`: one plant of a species, its figures, its model, its picture.

mod portrait;
mod stats;

use super::options::{DeviceOptions, OutputOptions, Size, size};
use super::output::{check_extension, print};
use crate::app::report::Details;
use crate::app::{Error, Session, growth, interrupt};
use crate::formats::{self, file, gltf, obj, ply};
use crate::plants::species::Seen;
use crate::scene::Model;
use crate::world::species::{self, Loaded};
use clap::{Args, ValueHint};
use stats::Stats;
use std::path::PathBuf;

/// Grow a plant of a species: its figures, its model, a picture of it
///
/// A model as .glb has all levels of detail, as .obj and .ply the finest one. A .png is a picture of the plant alone; of
/// several species it is a sheet of them all, in the order of the arguments.
#[derive(Args)]
pub struct Arguments {
    /// Species file (TOML); for a .png there may be several
    #[arg(required = true, value_hint = ValueHint::FilePath)]
    species: Vec<PathBuf>,

    /// File to write, .glb, .obj, .ply or .png; may be left out with --stats
    #[arg(short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,

    /// Which of the species' variants, from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    variant: u32,

    /// Seed of the world that it grows in, from 0 to 4294967295
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,

    /// Print what it is made of: modules after each step, size, triangles
    #[arg(long)]
    stats: bool,

    /// Size in pixels of a picture; on a sheet, of each of its pictures [default: 768x768, on a sheet 320x384]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

const EXTENSIONS: [&str; 4] = ["glb", "obj", "ply", "png"];

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    check(arguments)?;
    interrupt::listen();
    session.report.seed = Some(arguments.seed);
    let mut models = Vec::new();
    for path in &arguments.species {
        interrupt::check(&session.report)?;
        let loaded = species::load(path)?;
        loaded.warnings.iter().for_each(|warning| session.warn(warning.clone()));
        models.push(grow(&loaded, arguments, session)?);
    }
    let Some(path) = &arguments.out else { return Ok(()) };
    let written = match (formats::extension(path).as_str(), models.as_slice()) {
        ("glb", [model]) => vec![gltf::write_model(path, model)?],
        ("obj", [model]) => obj::write_model(path, model)?,
        ("ply", [model]) => vec![ply::write_model(path, model)?],
        _ => vec![portrait::write(path, models, arguments.size, &arguments.device, session)?],
    };
    for file in &written {
        session.progress.say(&format!("wrote {}", file.path.display()));
        session.report.wrote(file);
    }
    Ok(())
}

/// Finds what is wrong with the arguments before anything grows.
fn check(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { species, out, stats, size, .. } = arguments;
    let refuse = |message: &str| Err(Error::Usage(message.into()));
    let Some(path) = out else {
        return if *stats {
            check_one(species, "--stats")
        } else {
            refuse("name a file with -o, or ask for --stats")
        };
    };
    check_extension(path, &EXTENSIONS)?;
    if formats::extension(path) != "png" {
        check_one(species, "a model")?;
        if size.is_some() {
            return refuse("--size is the size of a picture: -o must end in .png");
        }
    }
    if *stats {
        check_one(species, "--stats")?;
    }
    Ok(file::check_writable(path)?)
}

fn check_one(species: &[PathBuf], what: &str) -> Result<(), Error> {
    match species {
        [_] => Ok(()),
        _ => Err(Error::Usage(format!("{what} is of one species, and {} are named", species.len()))),
    }
}

/// The model of the variant; its figures go to the report and to standard output.
fn grow(loaded: &Loaded, arguments: &Arguments, session: &mut Session) -> Result<Model, Error> {
    let Loaded { species, source, .. } = loaded;
    let name = &species.name;
    if arguments.variant >= species.variants {
        let variants = match species.variants {
            1 => "one variant: --variant 0".into(),
            many => format!("{many} variants: --variant 0 to {}", many - 1),
        };
        return Err(Error::Usage(format!("{name} has {variants}")));
    }
    // As in a world that calls the species by this name.
    let seed = species::seed(arguments.seed, name);
    let grown = growth::side_by_side(1, session, |_, limits| {
        let grow = || {
            let mut stats = arguments.stats.then(|| Stats::of(species, arguments.variant));
            let see = |seen: Seen| stats.iter_mut().for_each(|stats| stats.see(&seen));
            let body = species.body_seen(seed, arguments.variant, limits, see)?;
            let model = species.model(&body, limits.watch)?;
            stats.iter_mut().for_each(|stats| stats.end(&body, &model));
            Ok((model, stats, species.unfinished(seed, limits)))
        };
        grow().map_err(|error| source.blame(&error).into())
    })?;
    let Some((model, stats, unfinished)) = grown.into_iter().next() else {
        return Err(Error::Interrupted { written: 0, kept: None });
    };
    unfinished.iter().for_each(|unfinished| session.warn(source.warn(unfinished)));
    if let Some(stats) = stats {
        if !arguments.output.json {
            print(stats.to_string().as_bytes())?;
        }
        session.report.details = Some(Details::Plant(stats.object()));
    }
    Ok(model)
}
