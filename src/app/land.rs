//! From a world file to finished land: what every verb that shows or writes land begins with.

use super::cli::options::{DeviceOptions, WorldOptions};
use super::keep::{self, Keeper};
use super::{Error, Session, interrupt};
use crate::gpu::{self, Gpu, Recorder};
use crate::plants::planting;
use crate::scene::{Camera, Ground, Population, Scene, Viewpoint};
use crate::terrain::{FARTHEST_GROUND, Layer, Simulation, Stage};
use crate::world::{self, Overrides, World};
use std::time::Duration;

/// Work between two looks at the clock and at Ctrl-C.
const SLICE: Duration = Duration::from_millis(100);

/// Reads and checks the world.
pub fn load(options: &WorldOptions, session: &mut Session) -> Result<World, Error> {
    session.report.world = Some(options.world.to_string_lossy().into_owned());
    let overrides = Overrides { set: options.set.clone(), seed: options.seed };
    let world = world::load(&options.world, &overrides)?;
    session.report.seed = Some(world.seed);
    session.cache = if options.no_cache { None } else { keep::cache(session)? };
    world.warnings.iter().for_each(|warning| session.warn(warning.clone()));
    Ok(world)
}

/// Opens the device.
pub fn open(options: &DeviceOptions, session: &mut Session) -> Result<Gpu, Error> {
    let options = gpu::Options {
        device: options.device.clone(),
        memory_limit: options.memory_limit,
        validation: session.validation.clone(),
        window_extensions: Vec::new(),
    };
    let gpu = Gpu::new(&options)?;
    session.report.device = Some(gpu.info().name.clone());
    Ok(gpu)
}

/// Runs the simulation from where earlier runs left it to its end, or to an interruption.
pub fn simulate(gpu: &Gpu, world: &World, session: &mut Session) -> Result<Simulation, Error> {
    let mut keeper = Keeper::new(gpu, world, session);
    let mut simulation = keeper.begin(session)?;
    let mut progress = simulation.progress();
    for (stage, of) in world.plan.stages().into_iter().take_while(|(stage, _)| *stage != progress.stage) {
        session.progress.show(stage.name(), of.into(), of.into());
    }
    while !progress.finished {
        if interrupt::requested() {
            let kept = keeper.keep(&simulation, session);
            return Err(Error::Interrupted { written: session.report.written(), kept });
        }
        if interrupt::writing_requested() {
            keeper.keep(&simulation, session);
        }
        session.progress.show(progress.stage.name(), progress.iteration.into(), progress.of.into());
        let before = progress;
        progress = simulation.step(SLICE)?;
        if before.stage == Stage::Base && (progress.stage != Stage::Base || progress.finished) {
            check_ground(&simulation)?;
        }
        if progress.stage != before.stage {
            session.progress.show(before.stage.name(), before.of.into(), before.of.into());
        }
        keeper.watch(&simulation, session);
    }
    session.progress.show(progress.stage.name(), progress.iteration.into(), progress.of.into());
    session.progress.end();
    interrupt::check(&session.report)?;
    Ok(simulation)
}

/// Layers can multiply each other to anything.
fn check_ground(simulation: &Simulation) -> Result<(), Error> {
    let [lowest, highest] = simulation.ground_range()?;
    if lowest < -FARTHEST_GROUND || highest > FARTHEST_GROUND {
        return Err(Error::Ground { lowest, highest });
    }
    Ok(())
}

/// The camera, now that there is land to stand on.
pub fn camera(gpu: &Gpu, world: &World, simulation: &Simulation) -> Result<Camera, Error> {
    let view = match world.viewpoint {
        Viewpoint::Fixed(view) => view,
        Viewpoint::Stand(stand) => {
            let mut rec = Recorder::new(gpu);
            let heights = rec.download(&simulation.layer(Layer::Height)?);
            let heights = heights.take(&rec.submit()?.wait()?);
            let sea_level = simulation.sea_level();
            let land = planting::Ground::new(simulation.plan().grid, sea_level, heights);
            // Nobody stands under water.
            stand.view(land.grid, &land.height, |at| land.height_at(at).max(sea_level))
        }
    };
    Ok(Camera { view, fov: world.fov })
}

/// The scene of a world on its finished land.
pub fn scene(world: &World, ground: Ground, camera: Camera, population: Population) -> Scene {
    Scene {
        ground,
        light: world.light.clone(),
        sea: world.sea,
        surface: world.surface.clone(),
        population,
        camera,
    }
}
