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
use embedded_graphics::mono_font::{MonoTextStyle, ascii::FONT_7X13};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, Drawable, OriginDimensions, Pixel, Point};
use embedded_graphics::text::{Alignment, Baseline, Text};
use glam::{Quat, Vec3};
use std::convert::Infallible;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Where the pictures are taken: level ground under a clear sky, the sun behind the camera's left shoulder.
const STUDIO: &str = include_str!("studio.toml");

/// Of one picture, and of each of a sheet.
const ONE: Size = Size { width: 768, height: 768 };
const OF_SHEET: Size = Size { width: 320, height: 384 };
/// Pixels between the pictures of a sheet, and of the line below each that its name stands in.
const GAP: u32 = 4;
const CAPTION: u32 = 20;
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
    let mut sheet = Sheet::of(models.len() as u32, size);
    check_picture(&Film { width: sheet.width, height: sheet.height, ..film })?;

    let gpu = land::open(device, session)?;
    let renderer = Renderer::new(&gpu)?;
    let ground = ground(&gpu, &world)?;
    sheet.clear();
    let count = models.len() as u64;
    for (index, model) in models.into_iter().enumerate() {
        session.progress.show("picture", index as u64, count);
        interrupt::check(&session.report)?;
        sheet.caption(index as u32, &model.name);
        let scene = scene(&world, ground.clone(), model, size);
        let picture = renderer.render(&scene, &film, QUALITY)?;
        sheet.place(index as u32, &picture.developed(film.tone_map));
    }
    session.progress.show("picture", count, count);
    session.progress.end();
    Ok(png::write_picture(path, [sheet.width, sheet.height], &sheet.pixels)?)
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
        light: world.light.clone(),
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
    let Pinhole { eye, .. } = Pinhole::frame(&boxes(model), forward, ROOM, fov, aspect);
    Camera { view: View::LookAt { position: eye, target: eye + forward, roll: 0.0 }, fov }
}

/// How much farther away the camera stands than the plant needs to fill the picture.
const ROOM: f32 = 1.15;

/// Boxes around all of the model, each of a few triangles that belong together: the corners of one around the whole plant
/// are empty, and would keep the camera away.
fn boxes(model: &Model) -> Vec<[Vec3; 2]> {
    let parts = model.levels.first().map_or(&[][..], |level| &level.parts);
    let around = |corners: &[[f32; 3]]| {
        let corners = || corners.iter().copied().map(Vec3::from);
        Some([corners().reduce(Vec3::min)?, corners().reduce(Vec3::max)?])
    };
    parts.iter().flat_map(|part| part.mesh.positions.chunks(64)).filter_map(around).collect()
}

/// Pictures side by side, row by row, with their names below; a picture alone has none.
struct Sheet {
    columns: u32,
    size: Size,
    caption: u32,
    width: u32,
    height: u32,
    /// Three bytes each, row by row; empty until it is cleared.
    pixels: Vec<u8>,
}

impl Sheet {
    fn of(count: u32, size: Size) -> Sheet {
        let columns = columns(count);
        let rows = count.div_ceil(columns);
        let caption = if count > 1 { CAPTION } else { 0 };
        let across = |count: u32, side: u32| (count * (side + GAP)).saturating_sub(GAP);
        let (width, height) = (across(columns, size.width), across(rows, size.height + caption));
        Sheet { columns, size, caption, width, height, pixels: Vec::new() }
    }

    /// Takes the memory of the sheet: white.
    fn clear(&mut self) {
        self.pixels = vec![u8::MAX; 3 * self.width as usize * self.height as usize];
    }

    /// The upper left corner of a picture.
    fn corner(&self, index: u32) -> [u32; 2] {
        let [column, row] = [index % self.columns, index / self.columns];
        [column * (self.size.width + GAP), row * (self.size.height + self.caption + GAP)]
    }

    /// Copies a picture, three bytes a pixel, to its place.
    fn place(&mut self, index: u32, picture: &[u8]) {
        let [left, top] = self.corner(index);
        for (line, pixels) in picture.chunks_exact(3 * self.size.width as usize).enumerate() {
            let start = 3 * ((top as usize + line) * self.width as usize + left as usize);
            self.pixels[start..start + pixels.len()].copy_from_slice(pixels);
        }
    }

    /// Writes the name of a picture below it.
    fn caption(&mut self, index: u32, name: &str) {
        if self.caption == 0 {
            return;
        }
        let [left, top] = self.corner(index);
        let middle = Point::new(
            (left + self.size.width / 2) as i32,
            (top + self.size.height + self.caption / 2) as i32,
        );
        let style = MonoTextStyle::new(&FONT_7X13, BinaryColor::On);
        let mut text = Text::with_baseline(name, middle, style, Baseline::Middle);
        text.text_style.alignment = Alignment::Center;
        let Ok(_) = text.draw(self);
    }
}

impl OriginDimensions for Sheet {
    fn size(&self) -> embedded_graphics::prelude::Size {
        embedded_graphics::prelude::Size::new(self.width, self.height)
    }
}

/// Black ink.
impl DrawTarget for Sheet {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(place, color) in pixels {
            let (Ok(x), Ok(y)) = (usize::try_from(place.x), usize::try_from(place.y)) else { continue };
            if color.is_off() || x >= self.width as usize || y >= self.height as usize {
                continue;
            }
            self.pixels[3 * (y * self.width as usize + x)..][..3].fill(0);
        }
        Ok(())
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
