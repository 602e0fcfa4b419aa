//! All that stands on the land, with it or alone, as one glTF file with its sidecar.

use super::files::{self, Land};
use super::layers::{Layer, Source};
use super::{Arguments, Instancing, mesh};
use crate::app::cli::output::Place;
use crate::app::{Error, Session, interrupt, land, population};
use crate::formats::gltf::{self, Contents, Options, Places, Sea};
use crate::formats::sidecar::Values;
use crate::formats::{self, png};
use crate::gpu::Gpu;
use crate::scene::Population;
use crate::terrain::{Layer as Simulated, Simulation};
use std::path::PathBuf;

/// A scene that is asked for.
pub struct SceneFile {
    pub path: PathBuf,
    pub what: What,
    options: Options,
    /// Of the land's mesh, metres.
    largest_error: f32,
}

/// What of the world a scene has.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// All that stands on the land.
    Plants,
    /// That and the land, the sea, the sun and the camera.
    Scene,
}

/// Most pixels along a side of the land's picture, which every graphics card takes.
const MOST_PIXELS: u32 = 2048;

impl SceneFile {
    /// Samples of the land are `cell_size` metres apart.
    pub fn new(arguments: &Arguments, place: &Place, what: What, cell_size: f32) -> Self {
        let places = match arguments.instancing {
            None | Some(Instancing::On) => Places::Lists,
            Some(Instancing::Off) => Places::Nodes,
        };
        let name = match what {
            What::Plants => "plants.glb",
            What::Scene => "scene.glb",
        };
        SceneFile {
            path: place.file(name),
            what,
            options: Options { places, finest: arguments.lod.unwrap_or(0).into() },
            largest_error: arguments.mesh_error.unwrap_or(cell_size / 10.0),
        }
    }
}

/// Plants what grows on the finished land, and writes it. Ground cover is there as far as the world's camera sees it.
pub fn write(
    file: &SceneFile,
    gpu: &Gpu,
    simulation: &Simulation,
    source: &mut Source,
    of_run: &Land,
    session: &mut Session,
) -> Result<(), Error> {
    let world = of_run.world;
    let camera = land::camera(gpu, world, simulation)?;
    let population = population::populate(gpu, world, simulation, &camera, &world.film, session)?;
    let (ground, sea) = match file.what {
        What::Plants => (None, None),
        What::Scene => {
            let (ground, lowest) = ground(file, source, of_run, session)?;
            let level = simulation.sea_level();
            let sea = (lowest < level).then(|| Sea::new(world.plan.grid.extent, level, &world.sea));
            (Some(ground), sea)
        }
    };
    let shown = file.what == What::Scene;
    let camera =
        if shown { Some(population::seen_from(gpu, simulation, &camera, &world.film)?) } else { None };
    interrupt::check(&session.report)?;
    let contents = Contents {
        population: &population,
        land: ground.as_ref(),
        sea: sea.as_ref(),
        sun: world.light.sun.as_ref().filter(|_| shown),
        camera: camera.as_ref(),
    };
    let written = gltf::write_scene(&file.path, &contents, file.options)?;
    let sidecar = of_run.sidecar(values(&population, &contents), None);
    files::report(&written, &sidecar, session)
}

/// The land in its colours, and its lowest height, metres.
fn ground(
    file: &SceneFile,
    source: &mut Source,
    land: &Land,
    session: &mut Session,
) -> Result<(gltf::Land, f32), Error> {
    let height = source.raster(Layer::Simulated(Simulated::Height))?;
    let grid = land.grid();
    let mesh = mesh::of_land(&height, grid, [0, 0], [grid.cells; 2], file.largest_error, session)?;
    let [lowest, _] = height.range;
    drop(height);
    let (size, pixels) = source.albedo(MOST_PIXELS)?;
    let written = |source| formats::Error::Write { path: file.path.clone(), source };
    let picture = png::encode_picture(size, &pixels).map_err(written)?;
    Ok((gltf::Land { mesh, picture }, lowest))
}

/// What is in the file, every model counted once.
fn values(population: &Population, contents: &Contents) -> Values {
    let mut used = vec![false; population.models.len()];
    population.instances.iter().for_each(|instance| used[instance.model as usize] = true);
    let models = population.models.iter().zip(used).filter(|(_, used)| *used).map(|(model, _)| model);
    let levels = models.clone().flat_map(|model| &model.levels);
    let land = contents.land.map_or(0, |land| land.mesh.triangles.len());
    Values::Scene {
        plants: population.instances.len() as u64,
        models: models.count() as u64,
        triangles: (land + levels.map(|level| level.triangles()).sum::<usize>()) as u64,
    }
}
