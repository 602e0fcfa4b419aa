//! `terrane export`: layers of the land as files for other programs.

use super::options::{DeviceOptions, OutputOptions, WorldOptions};
use super::output::{Place, check_extension};
use crate::app::memory::{self, Goal, Limits};
use crate::app::{Error, Session, interrupt, land};
use crate::formats::file::Written;
use crate::formats::sidecar::{Range, Sidecar, Values};
use crate::formats::{self, extremes, sidecar};
use crate::gpu::{self, Gpu, Image, Recorder, format::R32f, format::Rgba32f};
use crate::raster::{Maps, Renderer};
use crate::terrain::{Layer as Simulated, Plan, Simulation};
use crate::world::World;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, ValueHint};
use std::path::{Path, PathBuf};

/// Write layers of the finished land: height, water, slope, …
#[derive(Args)]
pub struct Arguments {
    /// Layers to write, or `all` that the world has
    ///
    /// height, water, sediment, wear, deposit and reef in m, flow in m³/s, slope in degrees, normal = world (x, −z, y)·½ + ½,
    /// splat = weights of grass, rock, sand and sea floor, wetness from 0 to 1.
    #[arg(long = "layer", value_name = "NAME", num_args = 1.., value_delimiter = ',', default_value = "height")]
    #[arg(value_parser = choice())]
    layers: Vec<Choice>,

    /// File to write, .exr (any number of layers) or .png (one layer), or a folder for one file a layer [default: ./<world>/]
    #[arg(short, value_name = "OUT", value_hint = ValueHint::AnyPath)]
    out: Option<PathBuf>,

    /// Kind of the files in a folder: floats, or 16-bit integers from the least to the greatest value [default: exr]
    #[arg(long)]
    format: Option<Format>,

    #[command(flatten)]
    world: WorldOptions,
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

#[derive(Clone, Copy, PartialEq, Eq)]
enum Layer {
    Simulated(Simulated),
    Slope,
    Normal,
    Splat,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let format = file_format(arguments)?;
    let world = land::load(&arguments.world, session)?;
    let layers = choose(&arguments.layers, &world)?;
    let default = PathBuf::from(format!("./{}/", world.name));
    let place = Place::of(arguments.out.as_ref().unwrap_or(&default));
    let files = files(&place, format, &layers)?;

    interrupt::listen();
    let gpu = land::open(&arguments.device, session)?;
    memory::check(&world.plan, &goal(&world.plan, &files), &Limits::of(&gpu))?;
    let simulation = land::simulate(&gpu, &world, session)?;
    let file = arguments.world.world.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let set = arguments.world.set.clone();
    let land = Land { world: &world, file, set, sea_level: simulation.sea_level() };
    let mut source = Source { gpu: &gpu, world: &world, simulation: &simulation, maps: None };
    for (path, layers) in files {
        interrupt::check(&session.report)?;
        let rasters = layers.into_iter().map(|layer| source.raster(layer)).collect::<Result<Vec<_>, _>>()?;
        place.make()?;
        write(&path, format, rasters, &land, session)?;
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

/// What the files take beside the simulation.
fn goal(plan: &Plan, files: &[(PathBuf, Vec<Layer>)]) -> Goal {
    let layers = || files.iter().flat_map(|(_, layers)| layers);
    let drawn = layers().any(|layer| !matches!(layer, Layer::Simulated(_)));
    let source = if drawn { memory::Source::Renderer } else { memory::Source::Simulation };
    // The values of all channels, and the texels of one layer on their way to them.
    let channels = |layers: &[Layer]| layers.iter().map(|layer| layer.channels()).sum::<u64>();
    let widest = files.iter().map(|(_, layers)| channels(layers)).max().unwrap_or(0);
    Goal::Layers(memory::Layers { source, file: plan.grid.samples() as u64 * (4 * widest + 16) })
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
fn files(place: &Place, format: Format, layers: &[Layer]) -> Result<Vec<(PathBuf, Vec<Layer>)>, Error> {
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
            Ok(vec![(path.clone(), layers.to_vec())])
        }
        Place::Folder(_) => {
            place.prepare(names.iter().map(String::as_str))?;
            Ok(names.iter().zip(layers).map(|(name, &layer)| (place.file(name), vec![layer])).collect())
        }
    }
}

/// One layer on the host.
struct Raster {
    layer: Layer,
    size: [u32; 2],
    /// One list of values a channel.
    channels: Vec<Vec<f32>>,
    /// What a 16-bit file maps to 0…65535.
    range: [f32; 2],
}

/// Where layers come from.
struct Source<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    simulation: &'a Simulation,
    /// Once a layer has needed them.
    maps: Option<Maps>,
}

impl Source<'_> {
    fn raster(&mut self, layer: Layer) -> Result<Raster, Error> {
        let (size, channels) = match layer {
            Layer::Simulated(layer) => scalar(self.gpu, &self.simulation.layer(layer)?)?,
            Layer::Slope => scalar(self.gpu, &self.maps()?.slope)?,
            Layer::Normal => vector(self.gpu, &self.maps()?.normal, 3)?,
            Layer::Splat => vector(self.gpu, &self.maps()?.splat, 4)?,
        };
        let range = if channels.len() == 1 { extremes(&channels[0]) } else { [0.0, 1.0] };
        Ok(Raster { layer, size, channels, range })
    }

    fn maps(&mut self) -> Result<&Maps, Error> {
        let maps = match self.maps.take() {
            Some(maps) => maps,
            None => Renderer::new(self.gpu)?.maps(&land::scene(self.world, self.simulation.land()?))?,
        };
        Ok(self.maps.insert(maps))
    }
}

fn scalar(gpu: &Gpu, image: &Image<R32f>) -> gpu::Result<([u32; 2], Vec<Vec<f32>>)> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    Ok((image.size(), vec![download.take(&finished)]))
}

/// The first `count` channels of an image.
fn vector(gpu: &Gpu, image: &Image<Rgba32f>, count: usize) -> gpu::Result<([u32; 2], Vec<Vec<f32>>)> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    let texels = download.take(&finished);
    let channels = (0..count).map(|channel| texels.iter().map(|texel| texel[channel]).collect()).collect();
    Ok((image.size(), channels))
}

/// What every sidecar of a run says.
struct Land<'a> {
    world: &'a World,
    /// Name of the world file.
    file: String,
    /// What the command line changed in it.
    set: Vec<String>,
    sea_level: f32,
}

impl Land<'_> {
    fn sidecar(&self, rasters: &[Raster]) -> Sidecar {
        let range = |raster: &Raster| {
            let [min, max] = raster.range;
            Range { min, max, unit: raster.layer.unit().into() }
        };
        let values = match rasters {
            [raster] => Values::One(range(raster)),
            rasters => Values::Several {
                channels: rasters.iter().map(|raster| (raster.layer.name().into(), range(raster))).collect(),
            },
        };
        let grid = self.world.plan.grid;
        Sidecar {
            values,
            extent: grid.extent,
            cell_size: grid.cell_size(),
            sea_level: self.sea_level,
            seed: self.world.seed,
            world: self.file.clone(),
            world_sha256: self.world.sha256.clone(),
            set: self.set.clone(),
        }
    }
}

/// Writes a file and its sidecar.
fn write(
    path: &Path,
    format: Format,
    rasters: Vec<Raster>,
    land: &Land,
    session: &mut Session,
) -> Result<(), Error> {
    let sidecar = land.sidecar(&rasters);
    let file = match (format, rasters.as_slice()) {
        (Format::Png16, [raster]) => {
            formats::png::write_16(path, raster.size, &raster.channels, raster.range)?
        }
        _ => write_exr(path, rasters)?,
    };
    session.progress.say(&format!("wrote {}", path.display()));
    session.report.wrote(&file);
    session.report.wrote(&sidecar::write(path, &sidecar)?);
    Ok(())
}

/// Channels bear the layer's name; a layer of several has R, G, B, A, behind its name where other layers share the file.
fn write_exr(path: &Path, rasters: Vec<Raster>) -> Result<Written, Error> {
    let size = rasters.first().map_or([0; 2], |raster| raster.size);
    let shared = rasters.len() > 1;
    let mut channels = Vec::new();
    for Raster { layer, channels: values, .. } in rasters {
        let several = values.len() > 1;
        for (letter, values) in ["R", "G", "B", "A"].into_iter().zip(values) {
            let name = match (several, shared) {
                (false, _) => layer.name().into(),
                (true, false) => letter.into(),
                (true, true) => format!("{}.{letter}", layer.name()),
            };
            channels.push((name, values));
        }
    }
    Ok(formats::exr::write_channels(path, size, channels)?)
}

impl Layer {
    const ALL: [Layer; 11] = [
        Layer::Simulated(Simulated::Height),
        Layer::Simulated(Simulated::Water),
        Layer::Simulated(Simulated::Sediment),
        Layer::Simulated(Simulated::Wear),
        Layer::Simulated(Simulated::Deposit),
        Layer::Simulated(Simulated::Reef),
        Layer::Simulated(Simulated::Flow),
        Layer::Slope,
        Layer::Normal,
        Layer::Splat,
        Layer::Simulated(Simulated::Wetness),
    ];

    fn name(self) -> &'static str {
        match self {
            Layer::Simulated(layer) => layer.name(),
            Layer::Slope => "slope",
            Layer::Normal => "normal",
            Layer::Splat => "splat",
        }
    }

    /// Unit of the values; 1 for shares.
    fn unit(self) -> &'static str {
        match self {
            Layer::Simulated(Simulated::Flow) => "m³/s",
            Layer::Simulated(Simulated::Wetness) | Layer::Normal | Layer::Splat => "1",
            Layer::Simulated(_) => "m",
            Layer::Slope => "degrees",
        }
    }

    fn channels(self) -> u64 {
        match self {
            Layer::Simulated(_) | Layer::Slope => 1,
            Layer::Normal => 3,
            Layer::Splat => 4,
        }
    }

    fn exists_in(self, plan: &Plan) -> bool {
        match self {
            Layer::Simulated(layer) => layer.exists_in(plan),
            Layer::Slope | Layer::Normal | Layer::Splat => true,
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
