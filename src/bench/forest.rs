//! How fast a forest of a million plants stands: its plants grown, its land made, every plant placed.

use super::clock::{self, Stopwatch};
use super::{Error, memory};
use crate::{
    core::camera::Pinhole,
    gpu::{Gpu, Recorder},
    plants::{
        derive::Limits,
        planting::{Ground, Kind, Planter},
    },
    scene::{Instance, Model, View, Viewpoint},
    terrain::{Layer, Simulation},
    world::{self, Overrides, World},
};
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use toml_edit::{DocumentMut, Item};

/// What was measured, and on what.
#[derive(Clone, Debug, Serialize)]
pub struct Forest {
    #[serde(skip)]
    pub device: String,
    pub driver: String,
    /// Cores that plants are grown and placed on.
    pub cores: usize,
    pub rows: Vec<Row>,
    /// Most memory that this process has had at once, bytes, where the system tells it.
    pub peak_memory: Option<u64>,
}

/// A part of the work.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub name: &'static str,
    /// By the wall's clock.
    pub seconds: f64,
    /// Of all threads together.
    pub work_seconds: f64,
    /// What was made: models, samples of the ground, plants.
    pub count: u64,
    /// Bytes that they take.
    pub bytes: u64,
}

const WORLD: &str = include_str!("../../configs/landscape/million.toml");

/// The species that the world names, as the program carries them.
const SPECIES: [(&str, &str); 10] = [
    ("oak", include_str!("../../configs/species/oak.toml")),
    ("beech", include_str!("../../configs/species/beech.toml")),
    ("spruce", include_str!("../../configs/species/spruce.toml")),
    ("pine", include_str!("../../configs/species/pine.toml")),
    ("palm", include_str!("../../configs/species/palm.toml")),
    ("dead", include_str!("../../configs/species/dead.toml")),
    ("shrub", include_str!("../../configs/species/shrub.toml")),
    ("fern", include_str!("../../configs/species/fern.toml")),
    ("tussock", include_str!("../../configs/species/tussock.toml")),
    ("poppy", include_str!("../../configs/species/poppy.toml")),
];

/// Measures once; between two steps `stops` is asked whether to end, and `done` is told each row.
///
/// # Errors
/// No memory; [`Error::Stopped`].
pub fn forest(gpu: &Gpu, stops: impl Fn() -> bool, mut done: impl FnMut(&Row)) -> Result<Forest, Error> {
    let go_on = || if stops() { Err(Error::Stopped) } else { Ok(()) };
    let info = gpu.info();
    let (device, driver) = (info.name.clone(), info.driver.clone());
    let mut forest = Forest { device, driver, cores: clock::cores(), rows: Vec::new(), peak_memory: None };
    let world = world()?;

    let (models, row) = timed("growing", || grow(&world))?;
    let triangles = models.iter().flat_map(|model| &model.levels).map(|level| level.triangles() as u64);
    forest.tell(Row { count: models.len() as u64, bytes: 84 * triangles.sum::<u64>(), ..row }, &mut done);
    go_on()?;

    let (ground, row) = timed("ground", || ground(gpu, &world))?;
    let samples = ground.grid.samples() as u64;
    forest.tell(
        Row { count: samples, bytes: Ground::bytes(ground.grid, world.plants.needs()), ..row },
        &mut done,
    );
    go_on()?;

    let kinds = world.plants.kinds(&models);
    let (plants, row) = timed("planting", || plant(&world, &kinds, &ground, go_on))?;
    let bytes = size_of_val(plants.as_slice()) as u64;
    forest.tell(Row { count: plants.len() as u64, bytes, ..row }, &mut done);
    forest.peak_memory = memory::peak();
    Ok(forest)
}

impl Forest {
    fn tell(&mut self, row: Row, done: &mut impl FnMut(&Row)) {
        done(&row);
        self.rows.push(row);
    }
}

fn timed<T>(name: &'static str, work: impl FnOnce() -> Result<T, Error>) -> Result<(T, Row), Error> {
    let watch = Stopwatch::start();
    let made = work()?;
    let spent = watch.stop();
    let row = Row {
        name,
        seconds: spent.wall.as_secs_f64(),
        work_seconds: spent.work.as_secs_f64(),
        count: 0,
        bytes: 0,
    };
    Ok((made, row))
}

/// The world with its species written into it.
fn world() -> Result<World, Error> {
    let document =
        |text: &str| text.parse::<DocumentMut>().map_err(|error| Error::Document(error.to_string()));
    let mut world = document(WORLD)?;
    for (name, text) in SPECIES {
        let mut species = document(text)?;
        species.remove("format");
        world["species"][name] = Item::Table(species.as_table().clone());
    }
    let text = world.to_string();
    Ok(world::parse("million.toml", text.as_bytes(), Path::new(""), &Overrides::default())?)
}

fn grow(world: &World) -> Result<Vec<Arc<Model>>, Error> {
    let grow = |(index, variant): (usize, u32)| {
        let grown = world.grow(index, variant, &Limits::default());
        Ok(Arc::new(grown.map_err(|error| world.blame(index, &error))?))
    };
    world.plants.variants().into_par_iter().map(grow).collect()
}

fn ground(gpu: &Gpu, world: &World) -> Result<Ground, Error> {
    let mut simulation = Simulation::new(gpu, &world.plan)?;
    while !simulation.step(Duration::from_millis(100))?.finished {}
    let mut rec = Recorder::new(gpu);
    let heights = rec.download(&simulation.layer(Layer::Height)?);
    let heights = heights.take(&rec.submit()?.wait()?);
    let mut ground = Ground::new(world.plan.grid, simulation.sea_level(), heights);
    ground.measure(world.plants.needs());
    Ok(ground)
}

fn plant(
    world: &World,
    kinds: &[Kind],
    ground: &Ground,
    go_on: impl Fn() -> Result<(), Error>,
) -> Result<Vec<Instance>, Error> {
    let aspect = world.film.width as f32 / world.film.height as f32;
    // Nothing of this world depends on where it is seen from.
    let camera = match world.viewpoint {
        Viewpoint::Fixed(View::LookAt { position, target, .. }) => {
            Pinhole::look_at(position, target, world.fov, aspect)
        }
        _ => Pinhole::look_along(glam::Vec3::ZERO, glam::Vec3::NEG_Z, world.fov, aspect),
    };
    let mut planter = Planter::new(&world.plants.rules, kinds, ground, &camera);
    while planter.step()? {
        go_on()?;
    }
    Ok(planter.into_instances())
}

/// A table, in Markdown.
impl Display for Forest {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        writeln!(out, "{}, {}; {} cores\n", self.device, self.driver, self.cores)?;
        writeln!(out, "{HEADING}")?;
        self.rows.iter().try_for_each(|row| writeln!(out, "{row}"))?;
        let [seconds, work] = self
            .rows
            .iter()
            .fold([0.0; 2], |[wall, work], row| [wall + row.seconds, work + row.work_seconds]);
        let peak = self.peak_memory.map_or_else(|| "?".into(), |peak| format!("{:.0}", mebibytes(peak)));
        writeln!(out, "| all, at its peak | {seconds:.2} | {work:.2} | | {peak} |")
    }
}

const HEADING: &str = "\
| step | s | work s | made | MiB |
|---|--:|--:|--:|--:|";

impl Display for Row {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Row { name, seconds, work_seconds, count, bytes } = self;
        write!(out, "| `{name}` | {seconds:.2} | {work_seconds:.2} | {count} | {:.0} |", mebibytes(*bytes))
    }
}

fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
