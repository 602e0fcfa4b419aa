//! The whole scene as a folder for Mitsuba 3, to compare pictures with.

use super::files::{self, Land};
use crate::app::{Error, Session, interrupt, land, population};
use crate::formats::mitsuba::{self, Contents};
use crate::formats::sidecar::Values;
use crate::gpu::{Gpu, Recorder};
use crate::scene::Population;
use crate::terrain::Simulation;
use crate::trace::mesh;
use std::path::Path;

/// Plants what grows on the finished land, and writes it as the world's own picture has it.
pub fn write(
    folder: &Path,
    gpu: &Gpu,
    simulation: &Simulation,
    of_run: &Land,
    session: &mut Session,
) -> Result<(), Error> {
    let world = of_run.world;
    let film = &world.film;
    let camera = land::camera(gpu, world, simulation)?;
    let population = population::populate(gpu, world, simulation, &camera, film, session)?;
    let pinhole = population::seen_from(gpu, simulation, &camera, film)?;
    let scene = land::scene(world, simulation.land()?, camera, population);
    interrupt::check(&session.report)?;

    let level = scene.ground.sea_level;
    let mut rec = Recorder::new(gpu);
    let heights = rec.download(&scene.ground.height);
    let heights = heights.take(&rec.submit()?.wait()?);
    let land = mesh::mesh(scene.ground.grid, &heights, level);
    let sea = heights.iter().any(|height| *height < level);
    drop(heights);
    let corners = mesh::corners(gpu, &scene, &land.corners)?;

    let contents = Contents {
        land: mitsuba::Land { corners, triangles: land.triangles },
        population: &scene.population,
        light: &scene.light,
        camera: &pinhole,
        film,
        lens: [world.tracing.aperture, world.tracing.focus],
        bounces: world.tracing.bounces,
        samples: world.samples,
    };
    mitsuba::losses(&contents, sea).into_iter().for_each(|loss| session.warn(loss));
    interrupt::check(&session.report)?;
    let written = mitsuba::write(folder, &contents)?;
    let sidecar = of_run.sidecar(values(&scene.population, contents.land.triangles.len()), None);
    for file in &written {
        if file.path.ends_with("scene.xml") {
            files::report(file, &sidecar, session)?;
        } else {
            session.report.wrote(file);
        }
    }
    Ok(())
}

fn values(population: &Population, land: usize) -> Values {
    let levels = population.models.iter().filter_map(|model| model.levels.first());
    Values::Scene {
        plants: population.instances.len() as u64,
        models: population.models.len() as u64,
        triangles: (land + levels.map(|level| level.triangles()).sum::<usize>()) as u64,
    }
}
