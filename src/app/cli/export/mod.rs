//! `terrane export`: layers of the land, and the whole scene, as files for other programs.

mod files;
mod layers;
mod mesh;
mod mitsuba;
mod preset;
mod request;
mod scene;
mod tiles;
mod zoom;

use super::options::{DeviceOptions, OutputOptions, Size, WorldOptions, size};
use crate::app::memory::{self, Goal, Limits};
use crate::app::way;
use crate::app::{Error, Session, interrupt, land};
use crate::formats::raw::ByteOrder;
use crate::scene::Sky;
use crate::terrain::{Layer as Simulated, Plan};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum, ValueHint};
use files::Land;
use layers::{Layer, Source};
use preset::Preset;
use request::{Content, Request};
use scene::What;
use std::path::PathBuf;
use tiles::Tiles;

/// Most samples along a side of what is written: four by four of Unity's largest tiles.
const MAX_CELLS: u32 = (1 << 14) + 1;

/// Write layers of the finished land: height, water, slope, …; or what stands on it
#[derive(Args)]
pub struct Arguments {
    /// Layers to write, `all` that the world has, `mesh`, `plants`, `scene` or `mitsuba` [default: height, or mesh where OUT is
    /// one]
    ///
    /// height, water, sediment, wear, deposit and reef in m, flow in m³/s, slope in degrees, normal = world (x, −z, y)·½ + ½,
    /// splat = weights of grass, rock, sand and sea floor, wetness from 0 to 1. The mesh is the height as triangles. Plants
    /// are all that stands on the land, each model once with the places of its instances; the scene is these, the mesh in the
    /// ground's colours, the sea, the sun and the camera. For Mitsuba 3 the folder gets a scene.xml, its meshes and its sky.
    /// A zoom has two layers, of what is in view: the mesh, in cells of the level of the altitude from the eye, .glb or .ply, and
    /// tiles, a folder of heights with exact addresses in tiles.json; both is what it gets without --layer.
    #[arg(long = "layer", value_name = "NAME", num_args = 1.., value_delimiter = ',')]
    #[arg(value_parser = choice())]
    layers: Vec<Choice>,

    /// File to write, or a folder for one file a layer [default: ./<world>/]
    ///
    /// .exr for any number of layers; .png, .tif, .tiff, .r16 or .raw for one; .glb, .ply or .obj for the mesh, .glb for
    /// plants and scene. In a folder these are terrain.glb, plants.glb and scene.glb.
    #[arg(short, value_name = "OUT", value_hint = ValueHint::AnyPath)]
    out: Option<PathBuf>,

    /// Kind of the files in a folder [default: exr]
    #[arg(long)]
    format: Option<Format>,

    /// Sizes, formats and order of rows as an engine imports them
    #[arg(long)]
    preset: Option<Preset>,

    /// Resample to so many samples along each side [default: as many as the world has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=i64::from(MAX_CELLS)))]
    cells: Option<u32>,

    /// Cut the land into tiles, so many across and down, that share the samples of their edges
    #[arg(long, value_name = "NxM", value_parser = tiles::tiles)]
    tiles: Option<Tiles>,

    /// Byte order of RAW files [default: little]
    #[arg(long, value_name = "ORDER", value_parser = byte_order())]
    byte_order: Option<ByteOrder>,

    /// The farthest that a sample may lie above or below the mesh, m; 0 keeps every sample [default: a tenth of the distance
    /// between samples]
    #[arg(long, value_name = "M", value_parser = largest_error, allow_negative_numbers = true)]
    mesh_error: Option<f32>,

    /// How plants and scene tell the places of instances [default: on]
    #[arg(long, value_enum)]
    instancing: Option<Instancing>,

    /// The finest level of detail of plants and scene, 0 to 3 [default: 0, which is all there is]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=3))]
    lod: Option<u8>,

    /// Write the south edge first, in PNG and RAW files
    ///
    /// The rows of a tile are turned within it; tiles are counted from the north as ever.
    #[arg(long)]
    flip: bool,

    /// With a zoom: width and height of the picture that shows what is written [default: the world's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    #[command(flatten)]
    from: way::From,

    #[command(flatten)]
    world: WorldOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// 32-bit floats, channels by name
    Exr,
    /// 16-bit integers from the least to the greatest value
    Png16,
    /// The same integers without a header
    R16,
    /// GeoTIFF: 32-bit floats with their place in metres
    Tif,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Instancing {
    /// As lists (EXT_mesh_gpu_instancing)
    On,
    /// As one node each, for programs without that extension: at most 100,000, of one level of detail
    Off,
}

/// What `--layer` takes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Choice {
    All,
    Mesh,
    Mitsuba,
    /// Of a zoom.
    Tiles,
    Scene(scene::What),
    One(Layer),
}

impl Arguments {
    /// Refuses what only a zoom has.
    fn check_land(&self) -> Result<(), Error> {
        let given = [
            ("--size", self.size.is_some()),
            ("--from", self.from.is_given()),
            ("--layer tiles", self.layers.contains(&Choice::Tiles)),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((option, _)) => Err(Error::Missing(format!("{option}: the world has no `zoom`"))),
        }
    }
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let world = land::load(&arguments.world, session)?;
    if let Some(zoom) = &world.zoom {
        return zoom::export(arguments, &world, zoom, session);
    }
    arguments.check_land()?;
    let request = Request::new(arguments, &world)?;
    for note in &request.notes {
        session.progress.say(note);
    }

    interrupt::listen();
    let gpu = land::open(&arguments.device, session)?;
    // Without another number of samples, files have those of the land.
    let written = |plan: &Plan| match request.cells {
        cells if cells == world.plan.grid.cells => plan.grid.cells,
        cells => cells,
    };
    memory::check(
        &world.plan,
        |plan| goal(plan, &world.light.sky, &request, written(plan)),
        &Limits::of(&gpu),
    )?;
    let simulation = land::simulate(&gpu, &world, session)?;
    let Request { cells, tiles, preset, .. } = request;
    let land = Land::new(&arguments.world, &world, &simulation, cells, tiles, preset);
    let mut source = Source::new(&gpu, &world, &simulation, cells);
    for content in &request.contents {
        interrupt::check(&session.report)?;
        match content {
            Content::Layers(file) => {
                let rasters =
                    file.layers.iter().map(|&layer| source.raster(layer)).collect::<Result<Vec<_>, _>>()?;
                request.place.make()?;
                files::write(file, &rasters, &land, session)?;
            }
            Content::Mesh(file) => {
                let height = source.raster(Layer::Simulated(Simulated::Height))?;
                request.place.make()?;
                mesh::write(file, &height, &land, session)?;
            }
            Content::Scene(file) => {
                request.place.make()?;
                scene::write(file, &gpu, &simulation, &mut source, &land, session)?;
            }
            Content::Mitsuba(folder) => {
                request.place.make()?;
                mitsuba::write(folder, &gpu, &simulation, &land, session)?;
            }
        }
    }
    Ok(())
}

/// What the layers, of `cells` samples along a side, take of memory beside the simulation, which stays to the end.
fn goal<'a>(plan: &Plan, sky: &'a Sky, request: &Request, cells: u32) -> Goal<'a> {
    let colored = |content: &Content| matches!(content, Content::Scene(file) if file.what == What::Scene);
    let drawn = request.layers().any(|layer| !layer.is_simulated()) || request.contents.iter().any(colored);
    let source = if drawn { memory::Source::Renderer(sky) } else { memory::Source::Simulation };
    let files =
        request.contents.iter().map(|content| host_bytes(content, request.tiles, plan.grid.cells, cells));
    let file = files.max().unwrap_or(0);
    Goal::Layers(memory::Layers { source, file })
}

/// Memory of the host while a file of `to` samples along a side of all tiles is made from a land of `from`.
fn host_bytes(content: &Content, tiles: Tiles, from: u32, to: u32) -> u64 {
    let [width, height] = tiles.size(to).map(u64::from);
    let [from, to] = [from, to].map(u64::from);
    let channels: u64 = match content {
        Content::Layers(file) => file.layers.iter().map(|layer| layer.channels().len() as u64).sum(),
        // The height; how many triangles it takes is known when they are made, and bounded then.
        Content::Mesh(_) => 1,
        // What rules ask of the ground: height, water, wetness, flow and two distances. The height and the colours of the
        // land's mesh come when that is gone. How many plants there are is known when they are planted, and bounded then.
        Content::Scene(_) => 6,
        // The land's corners with normals and colours, and its triangles.
        Content::Mitsuba(_) => 9 + 3 + 6,
    };
    // All channels of the land, those of a tile in planes, and one layer half resampled.
    let resampled = if to == from { 0 } else { 16 * from * to };
    4 * channels * (to * to + width * height) + resampled
}

/// Reads the name of a layer, or of what is made of them.
fn choice() -> impl TypedValueParser<Value = Choice> {
    let names =
        Layer::ALL.map(Layer::name).into_iter().chain(["all", "mesh", "plants", "scene", "mitsuba", "tiles"]);
    PossibleValuesParser::new(names).map(|name| {
        match (Layer::ALL.into_iter().find(|layer| layer.name() == name), name.as_str()) {
            (Some(layer), _) => Choice::One(layer),
            (None, "mesh") => Choice::Mesh,
            (None, "mitsuba") => Choice::Mitsuba,
            (None, "tiles") => Choice::Tiles,
            (None, "plants") => Choice::Scene(What::Plants),
            (None, "scene") => Choice::Scene(What::Scene),
            (None, _) => Choice::All,
        }
    })
}

/// Reads a length that is not negative, metres.
fn largest_error(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(error) if error >= 0.0 && error.is_finite() => Ok(error),
        _ => Err("it must be a number of metres, 0 or more, for example 0.5".into()),
    }
}

fn byte_order() -> impl TypedValueParser<Value = ByteOrder> {
    PossibleValuesParser::new(["little", "big"]).map(|name| match name.as_str() {
        "big" => ByteOrder::Big,
        _ => ByteOrder::Little,
    })
}
