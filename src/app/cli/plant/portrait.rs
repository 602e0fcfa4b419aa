//! Pictures of plants by themselves: on level ground, under the sky.

use super::super::options::{DeviceOptions, Size};
use crate::app::memory::check_picture;
use crate::app::{Error, Session, interrupt, land};
use crate::core::camera::Pinhole;
use crate::formats::{file::Written, png};
use crate::gpu::Gpu;
use crate::raster::{Quality, Renderer};
use crate::scene::{Camera, Film, Ground, Instance, Model, Population, Scene, View};
use crate::terrain::Simulation;
use crate::world::{self, Overrides, World};
use glam::{Quat, Vec3};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Where the pictures are taken: level ground under a clear sky, the sun behind the camera's left shoulder.
const STUDIO: &str = include_str!("studio.toml");

/// Of one picture, and of each of a sheet.
const ONE: Size = Size { width: 768, height: 768 };
const OF_SHEET: Size = Size { width: 320, height: 384 };
/// Pixels between the pictures of a sheet.
const GAP: u32 = 4;
/// Work between two looks at the clock.
const SLICE: Duration = Duration::from_millis(100);
/// Twigs and blades are thinner than pixels.
const QUALITY: Quality = Quality { samples: 4, tile: 512 };

/// Writes a picture of the model, or a sheet with one of each.
pub fn write(
    path: &Path,
    models: Vec<Model>,
    size: Option<Size>,
    device: &DeviceOptions,
    session: &mut Session,
) -> Result<Written, Error> {
    let world = world::parse("studio.toml", STUDIO.as_bytes(), Path::new(""), &Overrides::default())?;
    let size = size.unwrap_or(if models.len() == 1 { ONE } else { OF_SHEET });
    let film = Film { width: size.width, height: size.height, ..world.film };
    let sheet = Sheet::of(models.len() as u32, size);
    check_picture(&Film { width: sheet.width, height: sheet.height, ..film })?;

    let gpu = land::open(device, session)?;
    let renderer = Renderer::new(&gpu)?;
    let ground = ground(&gpu, &world)?;
    let mut pixels = vec![u8::MAX; sheet.bytes()];
    let count = models.len() as u64;
    for (index, model) in models.into_iter().enumerate() {
        session.progress.show("picture", index as u64, count);
        interrupt::check(&session.report)?;
        let scene = scene(&world, ground.clone(), model, size);
        let picture = renderer.render(&scene, &film, QUALITY)?;
        sheet.place(&mut pixels, index as u32, &picture.developed(film.tone_map));
    }
    session.progress.show("picture", count, count);
    session.progress.end();
    Ok(png::write_picture(path, [sheet.width, sheet.height], &pixels)?)
}

/// The ground of the studio, to stand on.
fn ground(gpu: &Gpu, world: &World) -> Result<Ground, Error> {
    let mut simulation = Simulation::new(gpu, &world.plan)?;
    while !simulation.step(SLICE)?.finished {}
    Ok(simulation.land()?)
}

fn scene(world: &World, ground: Ground, model: Model, size: Size) -> Scene {
    let camera = camera(&model, world.fov, size);
    let instance =
        Instance { model: 0, random: 0, position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };
    Scene {
        ground,
        light: world.light,
        sea: world.sea,
        surface: world.surface.clone(),
        population: Population { models: vec![Arc::new(model)], instances: [instance].into() },
        camera,
    }
}

/// Looks north at the whole of the model with some room around it: at what is small from above, as people do.
fn camera(model: &Model, fov: f32, size: Size) -> Camera {
    let [least, most] = model.bounds();
    let downwards = 0.35 * (-(most.y - least.y) / 3.0).exp() + 0.06;
    let forward = Vec3::new(0.0, -downwards.sin(), -downwards.cos());
    let aspect = size.width as f32 / size.height as f32;
    let Pinhole { eye, .. } = Pinhole::frame(&[[least, most]], forward, ROOM, fov, aspect);
    Camera { view: View::LookAt { position: eye, target: eye + forward }, fov }
}

/// How much farther away than need be the camera stands.
const ROOM: f32 = 1.12;

/// Pictures side by side, row by row.
struct Sheet {
    columns: u32,
    size: Size,
    width: u32,
    height: u32,
}

impl Sheet {
    fn of(count: u32, size: Size) -> Sheet {
        let columns = columns(count);
        let rows = count.div_ceil(columns);
        let across = |count: u32, side: u32| (count * (side + GAP)).saturating_sub(GAP);
        Sheet { columns, size, width: across(columns, size.width), height: across(rows, size.height) }
    }

    fn bytes(&self) -> usize {
        3 * self.width as usize * self.height as usize
    }

    /// Copies a picture, three bytes a pixel, to its place.
    fn place(&self, sheet: &mut [u8], index: u32, picture: &[u8]) {
        let [column, row] = [index % self.columns, index / self.columns];
        let [left, top] = [column * (self.size.width + GAP), row * (self.size.height + GAP)];
        for (line, pixels) in picture.chunks_exact(3 * self.size.width as usize).enumerate() {
            let start = 3 * ((top as usize + line) * self.width as usize + left as usize);
            sheet[start..start + pixels.len()].copy_from_slice(pixels);
        }
    }
}

/// How many pictures stand in a row: such that the sheet is about 1.6 times as many pictures wide as high, and the last row as
/// full as may be.
fn columns(count: u32) -> u32 {
    let ideal = (1.6 * f64::from(count)).sqrt();
    let cost = |columns: &u32| {
        let empty = columns * count.div_ceil(*columns) - count;
        f64::from(empty) / f64::from(count) + (f64::from(*columns) / ideal).ln().abs()
    };
    (1..=count).min_by(|one, other| cost(one).total_cmp(&cost(other))).unwrap_or(1)
}
