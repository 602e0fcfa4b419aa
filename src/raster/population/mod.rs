//! What stands on the ground: instances of models, in levels of detail.
//!
//! [`shapes`] keeps every model's triangles on the device, once; [`view`] chooses who is seen, and in which level;
//! [`batch`] makes draws of them, cut so that no submission is long.

mod batch;
pub(super) mod shapes;
mod view;

use super::Tile;
use super::frame::Prepared;
use crate::gpu::{
    self, Blend, Buffer, Cull, Depth, Gpu, Image, Load, Raster, RasterState, Recorder, Targets, Topology,
    format::{D32f, Format, R32f, Rgba32ui},
};
use crate::scene::{Film, Population, Scene};
use crate::shaders::{self, raster::plant};

use shapes::Shapes;
use view::{Frustum, Resolution, Seen};

pub(super) struct Passes {
    plant: Raster<plant::Shader>,
}

/// A population that a picture shows, on the device.
pub(super) struct Crowd {
    shapes: Shapes,
    /// Whoever is in the picture.
    seen: Vec<Seen>,
}

impl Passes {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        let state = RasterState {
            color: &[R32f::VK, Rgba32ui::VK],
            depth: Depth::TestWrite,
            topology: Topology::Triangles,
            cull: Cull::None,
            blend: Blend::None,
        };
        Ok(Passes { plant: Raster::new(gpu, (), &state)? })
    }

    /// Chooses who is seen and uploads their models; `None` if nobody is.
    pub fn prepare(&self, gpu: &Gpu, scene: &Scene, prepared: &Prepared) -> gpu::Result<Option<Crowd>> {
        let population = &scene.population;
        let camera = &prepared.camera;
        let frustum = Frustum::of(camera, [-1.0, 1.0], [-1.0, 1.0]);
        let resolution = Resolution::Perspective { eye: camera.eye, sample_angle: prepared.sample_angle };
        let bounds = view::bounds(population);
        let seen = view::seen(population, &bounds, |sphere| frustum.meets(sphere), resolution);
        if seen.is_empty() {
            return Ok(None);
        }
        let shapes = Shapes::new(gpu, population, &shown(population, &seen))?;
        Ok(Some(Crowd { shapes, seen }))
    }

    /// Draws whoever is in the tile over the ground's range: theirs is negative. The image says what is seen of them.
    pub fn draw(
        &self,
        gpu: &Gpu,
        crowd: &Crowd,
        view: (&Scene, &Prepared, &Film, Tile),
        range: &Image<R32f>,
        depth: &Image<D32f>,
    ) -> gpu::Result<Image<Rgba32ui>> {
        let (scene, prepared, film, tile) = view;
        let plant = Image::new(gpu, "plant", tile.sample_size())?;
        let [scale, offset] = tile.clip(film);
        // Clip coordinates of the tile are those of the whole picture times `scale` plus `offset`.
        let [across, upward] = [0, 1].map(|axis| [-1.0, 1.0].map(|side| (side - offset[axis]) / scale[axis]));
        let frustum = Frustum::of(&prepared.camera, across, upward);
        let seen: Vec<Seen> = crowd.seen.iter().filter(|seen| frustum.meets(seen.bounds)).copied().collect();
        for batch in batch::batches(&scene.population, &crowd.shapes, &seen) {
            let instances = shapes::upload(gpu, "instances", &batch.instances)?;
            let mut rec = Recorder::new(gpu);
            let targets = Targets { color: &[range, &plant], depth: Some(depth), load: Load::Keep };
            rec.render(&targets, |draws| {
                for (pool, draw) in &batch.draws {
                    let pool = &crowd.shapes.pools[*pool];
                    draws.draw_indexed(
                        &self.plant,
                        &pool.indices,
                        draw,
                        plant::Push { scale, offset },
                        plant::Bindings {
                            frame: &prepared.frame,
                            instances: &instances,
                            vertices: &pool.vertices,
                        },
                    );
                }
            });
            rec.submit()?.wait()?;
        }
        Ok(plant)
    }
}

impl Crowd {
    pub fn materials(&self) -> &Buffer<shaders::Material> {
        &self.shapes.materials
    }
}

/// The levels that somebody is seen in, by model.
fn shown(population: &Population, seen: &[Seen]) -> Vec<Vec<bool>> {
    let mut shown: Vec<Vec<bool>> =
        population.models.iter().map(|model| vec![false; model.levels.len()]).collect();
    for seen in seen {
        if let Some(level) = shown[seen.model as usize].get_mut(seen.level as usize) {
            *level = true;
        }
    }
    shown
}
