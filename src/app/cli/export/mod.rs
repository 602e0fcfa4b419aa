//! `terrane export`: layers of the land as files for other programs.

mod files;
mod layers;

use super::options::{DeviceOptions, OutputOptions, WorldOptions};
use super::output::{Place, check_extension};
use crate::app::memory::check_device;
use crate::app::{Error, Session, interrupt, land};
use crate::core::memory::total;
use crate::formats;
use crate::raster;
use crate::world::World;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use files::Land;
use layers::{Layer, Source};
use std::path::PathBuf;

/// Write layers of the finished land: height, water, slope, …
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    world: WorldOptions,

    /// Layers to write, or `all` that the world has
    ///
    /// height, water, sediment, wear, deposit and reef in m, flow in m³/s, slope in degrees, normal = world (x, −z, y)·½ + ½,
    /// splat = weights of grass, rock, sand and sea floor, wetness from 0 to 1.
    #[arg(long = "layer", value_name = "NAME", num_args = 1.., value_delimiter = ',', default_value = "height")]
    #[arg(value_parser = choice())]
    layers: Vec<Choice>,

    /// File to write, .exr (any number of layers) or .png (one layer), or a folder for one file a layer [default: ./<world>/]
    #[arg(short, value_name = "OUT")]
    out: Option<PathBuf>,

    /// Kind of the files in a folder: floats, or 16-bit integers from the least to the greatest value [default: exr]
    #[arg(long)]
    format: Option<Format>,

    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Exr,
    Png16,
}

/// What `--layer` takes.
#[derive(Clone, Copy)]
enum Choice {
    All,
    One(Layer),
}

/// A file that is asked for.
struct Output {
    path: PathBuf,
    content: Content,
}

/// What a file holds.
enum Content {
    Layers(Vec<Layer>),
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let format = file_format(arguments)?;
    let world = land::load(&arguments.world, session)?;
    let layers = choose(&arguments.layers, &world)?;
    let default = PathBuf::from(format!("./{}/", world.name));
    let place = Place::of(arguments.out.as_ref().unwrap_or(&default));
    let outputs = outputs(&place, format, &layers)?;

    interrupt::listen();
    let gpu = land::open(&arguments.device, session)?;
    check_device("the land", bytes_needed(&world, &layers), "terrain.cells", gpu.memory().limit)?;
    let simulation = land::simulate(&gpu, &world, session)?;
    let land = Land::new(&arguments.world, &world, &simulation);
    let mut source = Source::new(&gpu, &world, &simulation);
    for Output { path, content } in outputs {
        interrupt::check(&session.report)?;
        match content {
            Content::Layers(layers) => {
                let rasters =
                    layers.into_iter().map(|layer| source.raster(layer)).collect::<Result<Vec<_>, _>>()?;
                place.make()?;
                files::write(&path, format, rasters, &land, session)?;
            }
        }
    }
    Ok(())
}

/// The format that the name of the output or `--format` asks for.
fn file_format(arguments: &Arguments) -> Result<Format, Error> {
    let Some(Place::File(path)) = arguments.out.as_deref().map(Place::of) else {
        return Ok(arguments.format.unwrap_or(Format::Exr));
    };
    check_extension(&path, &["exr", "png"])?;
    let format = if formats::extension(&path) == "png" { Format::Png16 } else { Format::Exr };
    match arguments.format {
        Some(other) if other != format => Err(Error::Usage(format!(
            "-o {} and --format contradict each other; leave --format out, or name a folder",
            path.display()
        ))),
        _ => Ok(format),
    }
}

/// Device memory: the simulation stays to the end, and what the renderer draws of it is beside it.
fn bytes_needed(world: &World, layers: &[Layer]) -> u64 {
    let drawn = layers.iter().any(|layer| !layer.is_simulated());
    let maps = if drawn { total(&raster::memory::maps(world.plan.grid)) } else { 0 };
    total(&world.plan.memory()) + maps
}

/// The layers that were asked for, once each.
fn choose(choices: &[Choice], world: &World) -> Result<Vec<Layer>, Error> {
    let present: Vec<Layer> = Layer::ALL.into_iter().filter(|layer| layer.exists_in(&world.plan)).collect();
    let mut layers = Vec::new();
    for &choice in choices {
        match choice {
            Choice::All => layers.extend(&present),
            Choice::One(layer) if present.contains(&layer) => layers.push(layer),
            Choice::One(layer) => {
                let names: Vec<&str> = present.iter().map(|layer| layer.name()).collect();
                return Err(Error::Missing(format!(
                    "{} has no layer `{}`, since no process in it makes one; it has {}",
                    world.name,
                    layer.name(),
                    names.join(", ")
                )));
            }
        }
    }
    Ok(Layer::ALL.into_iter().filter(|layer| layers.contains(layer)).collect())
}

/// The files to write, each with its layers. All of them can be written.
fn outputs(place: &Place, format: Format, layers: &[Layer]) -> Result<Vec<Output>, Error> {
    let extension = match format {
        Format::Exr => "exr",
        Format::Png16 => "png",
    };
    let names: Vec<String> = layers.iter().map(|layer| format!("{}.{extension}", layer.name())).collect();
    match place {
        Place::File(path) if format == Format::Png16 && layers.len() > 1 => Err(Error::Usage(format!(
            "{} can hold one layer and {} were asked for; name an .exr file or a folder",
            path.display(),
            layers.len()
        ))),
        Place::File(path) => {
            place.prepare([""])?;
            Ok(vec![Output { path: path.clone(), content: Content::Layers(layers.to_vec()) }])
        }
        Place::Folder(_) => {
            place.prepare(names.iter().map(String::as_str))?;
            let output = |(name, &layer): (&String, _)| Output {
                path: place.file(name),
                content: Content::Layers(vec![layer]),
            };
            Ok(names.iter().zip(layers).map(output).collect())
        }
    }
}

/// Reads the name of a layer, or `all`.
fn choice() -> impl TypedValueParser<Value = Choice> {
    let names = Layer::ALL.map(Layer::name).into_iter().chain(["all"]);
    PossibleValuesParser::new(names).map(|name| {
        Layer::ALL.into_iter().find(|layer| layer.name() == name).map_or(Choice::All, Choice::One)
    })
}
