//! Plants of the land on the stage: they grow on a thread of their own, are counted, and found by a click.

use crate::app::population::{self, Garden, Sight};
use crate::app::progress::{Progress, Watch};
use crate::app::report::Report;
use crate::app::{Error, Session, interrupt};
use crate::core::camera::Pinhole;
use crate::gpu::Gpu;
use crate::plants::planting::Ground;
use crate::scene::{Film, Instance, Model, Population};
use crate::terrain::Simulation;
use crate::world::World;
use glam::Vec3;
use std::collections::HashMap;
use std::f32::consts::TAU;
use std::panic::resume_unwind;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

/// What stands on the ground, with what is known of it.
#[derive(Default)]
pub struct Plants {
    pub population: Population,
    /// Of every model.
    pub census: Arc<[Census]>,
    bounds: Vec<[Vec3; 2]>,
}

/// How many there are of a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Census {
    pub species: String,
    /// From 1; 0 where the species has one model only.
    pub variant: u32,
    pub plants: u64,
    /// Of one plant, in the finest level of detail.
    pub triangles: u64,
}

/// A plant that was clicked.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected {
    pub instance: usize,
    pub species: String,
    pub variant: u32,
    /// Of its foot, metres.
    pub position: Vec3,
    /// Metres.
    pub height: f32,
    /// Of every level of detail, from the finest.
    pub levels: Vec<u64>,
    /// Corners of its coarsest level, in the world: what an outline goes round.
    pub shape: Arc<[Vec3]>,
}

/// Where a plant is looked for, pixels from the mouse: leaves are small, and there are gaps between them.
fn aims() -> impl Iterator<Item = [f32; 2]> {
    const WAYS: u8 = 8;
    let ring = |radius: f32| {
        (0..WAYS)
            .map(move |way| (TAU * f32::from(way) / f32::from(WAYS)).sin_cos())
            .map(move |(x, y)| [radius * x, radius * y])
    };
    [[0.0; 2]].into_iter().chain(ring(3.0)).chain(ring(6.0))
}

impl Plants {
    pub fn new(population: Population) -> Plants {
        Plants { census: census(&population).into(), bounds: population.bounds(), population }
    }

    /// The plant that is seen at a place of a picture, which goes from 0 to 1 to the right and down, or a few pixels beside it.
    /// `ground` tells how far along a unit vector the ground is.
    pub fn seen_at(
        &self,
        [right, down]: [f32; 2],
        camera: &Pinhole,
        film: &Film,
        ground: impl Fn(Vec3) -> f32,
    ) -> Option<usize> {
        aims().find_map(|[x, y]| {
            let ray = camera.ray(right + x / film.width as f32, down + y / film.height as f32);
            let met = self.population.met(&self.bounds, camera.eye, ray, ground(ray))?;
            Some(met.instance)
        })
    }

    /// What there is to tell of a plant.
    pub fn tell(&self, index: usize) -> Option<Selected> {
        let instance = self.population.instances.get(index)?;
        let model = self.population.models.get(instance.model as usize)?;
        let census = self.census.get(instance.model as usize)?;
        let [least, greatest] = self.bounds.get(instance.model as usize)?;
        Some(Selected {
            instance: index,
            species: census.species.clone(),
            variant: census.variant,
            position: instance.position,
            height: (greatest.y - least.y) * instance.scale,
            levels: model.levels.iter().map(|level| level.triangles() as u64).collect(),
            shape: shape(model, instance),
        })
    }

    /// The same plant among others; none if it is not there.
    pub fn find(&self, other: &Selected) -> Option<Selected> {
        let is_there = |instance: &Instance| instance.position == other.position;
        let at = |index: &usize| self.population.instances.get(*index).is_some_and(is_there);
        let same = || self.population.instances.iter().position(is_there);
        let found = self.tell(Some(other.instance).filter(at).or_else(same)?)?;
        (found.species == other.species && found.variant == other.variant).then_some(found)
    }

    /// How many there are, and their triangles.
    pub fn counts(&self) -> (usize, u64) {
        let triangles = self.census.iter().map(|census| census.plants * census.triangles).sum();
        (self.population.instances.len(), triangles)
    }
}

fn census(population: &Population) -> Vec<Census> {
    let mut plants = vec![0; population.models.len()];
    for instance in population.instances.iter() {
        if let Some(count) = plants.get_mut(instance.model as usize) {
            *count += 1;
        }
    }
    let mut models: HashMap<&str, u32> = HashMap::new();
    for model in &population.models {
        *models.entry(&model.name).or_default() += 1;
    }
    // Variants of a species have its name, and follow each other.
    let mut variants: HashMap<&str, u32> = HashMap::new();
    let counted = population.models.iter().zip(plants).map(|(model, plants)| {
        let variant = variants.entry(&model.name).or_default();
        *variant += 1;
        let is_alone = models.get(model.name.as_str()) == Some(&1);
        Census {
            species: model.name.clone(),
            variant: if is_alone { 0 } else { *variant },
            plants,
            triangles: model.levels.first().map_or(0, |level| level.triangles() as u64),
        }
    });
    counted.collect()
}

fn shape(model: &Model, instance: &Instance) -> Arc<[Vec3]> {
    let level = model.levels.iter().rev().find(|level| level.triangles() > 0);
    let corners = level.into_iter().flat_map(|level| &level.parts).flat_map(|part| &part.mesh.positions);
    let placed =
        |corner: &[f32; 3]| instance.position + instance.rotation * (Vec3::from(*corner) * instance.scale);
    corners.map(placed).collect()
}

/// Who plants the finished land: a thread, which keeps what has grown, and plants it again for who sees it from elsewhere.
pub struct Gardener {
    /// None once it has been heard.
    thread: Option<JoinHandle<()>>,
    /// None once no more is wanted.
    sights: Option<Sender<Sight>>,
    planted: Receiver<Result<Planted, Error>>,
    watch: Watch,
    /// What is being planted, and since when.
    asked: Option<(Sight, Instant)>,
}

/// What has been planted, and what is to be said of it.
pub struct Planted {
    pub plants: Plants,
    pub warnings: Vec<String>,
}

impl Gardener {
    /// Begins to grow what a world has.
    pub fn begin(gpu: &Gpu, world: &Arc<World>, simulation: &Simulation) -> Result<Gardener, Error> {
        let ground = population::ground(gpu, world, simulation)?;
        let watch = Watch::default();
        let (sights, wanted) = channel();
        let (basket, planted) = channel();
        let (world, progress) = (world.clone(), Progress::watched(watch.clone()));
        let garden = move || {
            let session = Session { report: Report::of("view"), progress, cache: None, validation: None };
            if let Err(error) = tend(ground, &world, session, &wanted, &basket) {
                // Who does not listen has other land by now.
                let _ = basket.send(Err(error));
            }
        };
        let thread = std::thread::Builder::new().name("gardener".into()).spawn(garden);
        let thread = thread.map_err(|error| Error::Memory(format!("no thread to plant on: {error}")))?;
        Ok(Gardener { thread: Some(thread), sights: Some(sights), planted, watch, asked: None })
    }

    /// Asks for plants with the ground cover of a sight, once it is not busy.
    pub fn ask(&mut self, sight: Sight) {
        let Some(sights) = &self.sights else { return };
        // Who has ended has said why.
        if sights.send(sight).is_ok() {
            self.asked = Some((sight, Instant::now()));
        }
    }

    pub fn is_busy(&self) -> bool {
        self.asked.is_some()
    }

    /// What has come of it, once it is over: for what, and begun when.
    pub fn ended(&mut self) -> Option<(Sight, Instant, Result<Planted, Error>)> {
        let (sight, begun) = self.asked?;
        let planted = match self.planted.try_recv() {
            Ok(planted) => planted,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                self.asked = None;
                if let Err(panic) = self.thread.take()?.join() {
                    resume_unwind(panic);
                }
                return None;
            }
        };
        self.asked = None;
        Some((sight, begun, planted))
    }

    /// What it does, how much of it is done, and of how much.
    pub fn work(&self) -> Option<(String, u64, u64)> {
        self.asked?;
        let (stage, done, of) =
            self.watch.lock().unwrap_or_else(PoisonError::into_inner).unwrap_or(("planting", 0, 0));
        Some((stage.into(), done, of))
    }
}

/// What a [`Gardener`] does until nothing more is wanted.
fn tend(
    ground: Ground,
    world: &World,
    mut session: Session,
    wanted: &Receiver<Sight>,
    basket: &Sender<Result<Planted, Error>>,
) -> Result<(), Error> {
    let mut garden = Garden::on(ground, world, &mut session)?;
    garden.keep(&mut session)?;
    for sight in wanted {
        let planted = garden.plant(sight, &mut session).map(|population| Planted {
            plants: Plants::new(population),
            warnings: std::mem::take(&mut session.report.warnings),
        });
        if basket.send(planted).is_err() {
            break;
        }
    }
    Ok(())
}

impl Drop for Gardener {
    /// What it makes is of no use any more.
    fn drop(&mut self) {
        self.sights = None;
        let Some(thread) = self.thread.take() else { return };
        let _ending = interrupt::Ending::new();
        // A panic has been told on standard error.
        let _ = thread.join();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::mesh::Mesh;
    use crate::scene::{Level, Part, ToneMap};
    use glam::Quat;

    /// A board in two levels of detail, one metre wide and two high.
    fn board(name: &str) -> Arc<Model> {
        let positions = vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 2.0, 0.0], [-0.5, 2.0, 0.0]];
        let level = |detail: f32, triangles: Vec<[u32; 3]>| {
            let mesh = Mesh { positions: positions.clone(), triangles, ..Mesh::default() };
            Level { detail, parts: vec![Part { material: 0, mesh }] }
        };
        let levels = vec![level(0.0, vec![[0, 1, 2], [0, 2, 3]]), level(0.1, vec![[0, 1, 2]])];
        Arc::new(Model { name: name.into(), levels, ..Model::default() })
    }

    fn plants() -> Plants {
        let at = |model: u32, x: f32, z: f32, scale: f32| Instance {
            model,
            random: 0,
            position: Vec3::new(x, 0.0, z),
            rotation: Quat::IDENTITY,
            scale,
        };
        let instances = [at(1, 0.0, -10.0, 1.0), at(1, 0.0, -20.0, 3.0), at(2, 50.0, 0.0, 1.0)];
        Plants::new(Population {
            models: ["oak", "oak", "fern"].map(board).into(),
            instances: instances.into(),
        })
    }

    #[test]
    fn plants_are_counted_by_species_and_variant() {
        let count = |species: &str, variant, plants| Census {
            species: species.into(),
            variant,
            plants,
            triangles: 2,
        };
        assert_eq!(*plants().census, [count("oak", 1, 0), count("oak", 2, 2), count("fern", 0, 1)]);
        assert_eq!(plants().counts(), (3, 6));
    }

    #[test]
    fn a_click_finds_the_plant_that_is_seen() {
        let plants = plants();
        let film = Film { width: 400, height: 400, exposure: 1.0, tone_map: ToneMap::None };
        // A metre at 10 m is 20 pixels.
        let camera = Pinhole::look_along(Vec3::ZERO, Vec3::NEG_Z, std::f32::consts::FRAC_PI_2, 1.0);
        let find = |[x, y]: [f32; 2], ground: f32| {
            plants.seen_at([x / 400.0, y / 400.0], &camera, &film, |_| ground)
        };
        assert_eq!(find([200.0, 180.0], 1e9), Some(0));
        assert_eq!(find([212.0, 180.0], 1e9), Some(1), "what is there comes before what is beside");
        assert_eq!(find([200.0, 150.0], 1e9), Some(1), "above the near one");
        assert_eq!(find([217.0, 150.0], 1e9), Some(1), "just beside");
        assert_eq!(find([240.0, 150.0], 1e9), None);
        assert_eq!(find([200.0, 180.0], 5.0), None, "behind a hill");
        let told = plants.tell(1).expect("it is there");
        assert_eq!((told.species.as_str(), told.variant, told.height), ("oak", 2, 6.0));
        assert_eq!((told.levels, told.shape.len()), (vec![2, 1], 4));
    }
}
