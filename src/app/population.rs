//! From a world and its finished land to all that stands on it.

use super::{Error, Session, growth, interrupt};
use crate::core::camera::{Pinhole, direction};
use crate::core::memory::mebibytes;
use crate::gpu::{self, Gpu, Image, Recorder, format::R32f};
use crate::plants::derive::Limits;
use crate::plants::planting::{Ground, Kind, MOST_PLANTS, PLANT_BYTES, Planter, Standing};
use crate::scene::{Camera, Film, Instance, Model, Population, View};
use crate::terrain::{Layer, Simulation};
use crate::world::World;
use glam::Vec3;
use std::sync::Arc;

/// What of a world's plants does not depend on the camera: they have grown, and the ground for them is known.
pub struct Garden<'a> {
    world: &'a World,
    kinds: Vec<Kind>,
    models: Vec<Arc<Model>>,
    ground: Ground,
    /// What stands wherever the camera is, once that is [kept](Garden::keep).
    standing: Standing,
}

/// Where ground cover is planted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// Where this camera sees it: so does the picture that `terrane render` makes.
    Picture(Pinhole),
    /// On all sides of this place, as its pictures would have it.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "only a window looks all round"))]
    Round(Vec3),
}

impl<'a> Garden<'a> {
    /// Grows the plants of a world, and measures its finished land.
    pub fn new(
        gpu: &Gpu,
        world: &'a World,
        simulation: &Simulation,
        session: &mut Session,
    ) -> Result<Self, Error> {
        let (kinds, models) = grow(world, session)?;
        let ground = measured(ground(gpu, world, simulation)?, world);
        Ok(Garden { world, kinds, models, ground, standing: Standing::default() })
    }

    /// The same on ground that has been downloaded: needs no device.
    #[cfg(feature = "viewer")]
    pub fn on(ground: Ground, world: &'a World, session: &mut Session) -> Result<Self, Error> {
        let (kinds, models) = grow(world, session)?;
        Ok(Garden { world, kinds, models, ground: measured(ground, world), standing: Standing::default() })
    }

    /// Plants what comes before the first ground cover, and keeps it for all cameras.
    #[cfg(feature = "viewer")]
    pub fn keep(&mut self, session: &mut Session) -> Result<(), Error> {
        let nowhere = Pinhole::look_along(Vec3::ZERO, Vec3::NEG_Z, 1.0, 1.0);
        let mut planter = self.planter(&nowhere);
        while !planter.asks_camera() && step(&mut planter, session)? {}
        self.standing = planter.into_standing();
        Ok(())
    }

    /// Plants, as many of them as a picture of this size may show: ground cover is planted where the camera sees it.
    pub fn populate(&self, camera: &Camera, film: &Film, session: &mut Session) -> Result<Population, Error> {
        self.plant(Sight::Picture(self.pinhole(camera, film)), session)
    }

    /// The same, for any sight.
    pub fn plant(&self, sight: Sight, session: &mut Session) -> Result<Population, Error> {
        let plants = &self.world.plants;
        if plants.rules.is_empty() && plants.standing.is_empty() {
            return Ok(Population::default());
        }
        let camera = match sight {
            Sight::Picture(camera) => camera,
            Sight::Round(eye) => Pinhole::look_along(eye, Vec3::NEG_Z, 1.0, 1.0),
        };
        let mut planter = self.planter(&camera).after(self.standing.clone());
        if matches!(sight, Sight::Round(_)) {
            planter = planter.all_round();
        }
        while step(&mut planter, session)? {}
        session.progress.end();
        let mut models = self.models.clone();
        let mut instances = planter.into_instances();
        for Population { models: more, instances: others } in &plants.standing {
            let first = models.len() as u32;
            models.extend(more.iter().cloned());
            instances.extend(others.iter().map(|other| Instance { model: first + other.model, ..*other }));
        }
        let instances: Arc<[_]> = instances.into();
        session.progress.say(&told(&instances, &models));
        Ok(Population { models, instances })
    }

    fn planter<'b>(&'b self, camera: &'b Pinhole) -> Planter<'b> {
        let Garden { world, kinds, ground, .. } = self;
        // No more than this machine has room for.
        let room = gpu::free_ram().map_or(u64::MAX, |bytes| bytes / PLANT_BYTES);
        let planter = Planter::new(&world.plants.rules, kinds, ground, camera);
        planter.beside(world.plants.standing()).at_most(room.min(MOST_PLANTS))
    }

    /// The camera of a picture of this size.
    pub fn pinhole(&self, camera: &Camera, film: &Film) -> Pinhole {
        pinhole(camera, film, &self.ground)
    }
}

/// Follows the next rule; false if there was none left.
fn step(planter: &mut Planter<'_>, session: &mut Session) -> Result<bool, Error> {
    let (done, of) = planter.progress();
    session.progress.show("planting", done as u64, of as u64);
    interrupt::check(&session.report)?;
    Ok(planter.step()?)
}

/// Plants of a world on its finished land, as one camera sees them.
pub fn populate(
    gpu: &Gpu,
    world: &World,
    simulation: &Simulation,
    camera: &Camera,
    film: &Film,
    session: &mut Session,
) -> Result<Population, Error> {
    Garden::new(gpu, world, simulation, session)?.populate(camera, film, session)
}

fn told(instances: &[Instance], models: &[Arc<Model>]) -> String {
    let triangles = |model: &Arc<Model>| model.levels.first().map_or(0, |level| level.triangles() as u64);
    let each: Vec<u64> = models.iter().map(triangles).collect();
    let shown: u64 = instances.iter().map(|instance| each[instance.model as usize]).sum();
    format!(
        "{} plants of {} models, {} triangles if all were kept ({})",
        instances.len(),
        models.len(),
        shown,
        mebibytes(std::mem::size_of_val(instances) as u64)
    )
}

/// The kinds that rules name, and the models of those that any of them plants.
fn grow(world: &World, session: &mut Session) -> Result<(Vec<Kind>, Vec<Arc<Model>>), Error> {
    if world.plants.rules.is_empty() && world.plants.standing.is_empty() {
        return Ok(Default::default());
    }
    let mut models = self::models(world, session)?;
    models.extend(world.plants.models.iter().cloned());
    Ok((world.plants.kinds(&models), models))
}

/// All variants of the species that rules plant, see [`Plan::variants`](crate::plants::planting::Plan::variants). Warns of
/// growth that is cut short.
pub fn models(world: &World, session: &mut Session) -> Result<Vec<Arc<Model>>, Error> {
    let variants = world.plants.variants();
    let grow = |index, limits: &Limits| {
        let (species, variant): (usize, u32) = variants[index];
        world.grow(species, variant, limits).map(Arc::new)
    };
    let blame = |index, error: &_| {
        let (species, _) = variants[index];
        world.blame(species, error).into()
    };
    let models = growth::side_by_side(variants.len(), session, grow, blame)?;
    for (&(species, _), model) in variants.iter().zip(&models).filter(|((_, variant), _)| *variant == 0) {
        interrupt::check(&session.report)?;
        let unfinished = world.unfinished(species, &Limits::default());
        let empty = model.is_empty().then(|| world.warn_empty(species));
        unfinished.into_iter().chain(empty).for_each(|warning| session.warn(warning));
    }
    Ok(models)
}

/// What the rules of a world have to know of its land, as it comes from the device.
pub fn ground(gpu: &Gpu, world: &World, simulation: &Simulation) -> Result<Ground, Error> {
    let layer = |layer: Layer, needed: bool| -> Result<Vec<f32>, Error> {
        let exists = needed && layer.exists_in(simulation.plan());
        Ok(if exists { download(gpu, &simulation.layer(layer)?)? } else { Vec::new() })
    };
    let needs = world.plants.needs();
    let mut ground = Ground::new(simulation.plan().grid, simulation.sea_level(), layer(Layer::Height, true)?);
    ground.water = layer(Layer::Water, true)?;
    ground.wetness = layer(Layer::Wetness, needs.wetness)?;
    ground.flow = layer(Layer::Flow, needs.flow)?;
    Ok(ground)
}

fn measured(mut ground: Ground, world: &World) -> Ground {
    ground.measure(world.plants.needs());
    ground
}

fn download(gpu: &Gpu, image: &Image<R32f>) -> gpu::Result<Vec<f32>> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    Ok(download.take(&finished))
}

/// The world's camera, as the world's own picture has it.
pub fn seen_from(gpu: &Gpu, simulation: &Simulation, camera: &Camera, film: &Film) -> Result<Pinhole, Error> {
    let heights = download(gpu, &simulation.layer(Layer::Height)?)?;
    let ground = Ground::new(simulation.plan().grid, simulation.sea_level(), heights);
    Ok(pinhole(camera, film, &ground))
}

/// The camera of a picture of this size.
fn pinhole(camera: &Camera, film: &Film, ground: &Ground) -> Pinhole {
    let aspect = film.width as f32 / film.height as f32;
    match camera.view {
        View::LookAt { position, target, roll } => {
            Pinhole::look_at(position, target, camera.fov, aspect).rolled(roll)
        }
        View::FrameIsland { azimuth, elevation, distance } => {
            Pinhole::frame(&ground.land(), -direction(azimuth, elevation), distance, camera.fov, aspect)
        }
    }
}
