//! What stands on the ground: instances of models, in levels of detail.
//!
//! [`shapes`] keeps every model's triangles on the device, once; [`view`] chooses who is seen, and in which level;
//! [`batch`] makes draws of them, cut so that no submission is long. What they take from the light: [`occlusion`] within a
//! plant, [`canopy`] under crowns, [`cast`] where the sun is hidden.

mod batch;
pub(super) mod canopy;
pub(super) mod cast;
mod occlusion;
pub(super) mod shapes;
mod view;

use super::Tile;
use super::patches::Prepared;
use crate::gpu::{
    self, Blend, Buffer, Cull, Depth, Gpu, Image, Load, Raster, RasterState, Recorder, Targets, Topology,
    format::{D32f, Format, R32f, Rgba32f, Rgba32ui},
};
use crate::scene::{Film, Population, Scene};
use crate::shaders::{self, raster::plant};

use cast::Casts;
use shapes::Shapes;
use view::{Frustum, Resolution, Seen};

pub(super) struct Passes {
    plant: Raster<plant::Shader>,
    cast: cast::Pass,
}

/// A population on the device, as far as a picture needs it.
pub(super) struct Crowd {
    /// `None` if nobody is seen.
    shapes: Option<Shapes>,
    /// Whoever is in the picture.
    seen: Vec<Seen>,
    pub casts: Casts,
    /// Of leaves over the ground: see [`canopy::canopy`].
    pub canopy: Image<Rgba32f>,
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
        Ok(Passes { plant: Raster::new(gpu, (), &state)?, cast: cast::Pass::new(gpu)? })
    }

    /// Chooses who is seen, uploads their models and draws their shadows.
    pub fn prepare(&self, gpu: &Gpu, scene: &Scene, prepared: &Prepared) -> gpu::Result<Crowd> {
        let population = &scene.population;
        let camera = &prepared.camera;
        let frustum = Frustum::of(camera, [-1.0, 1.0], [-1.0, 1.0]);
        let resolution = Resolution::Perspective { eye: camera.eye, sample_angle: prepared.sample_angle };
        let bounds = view::bounds(population);
        let seen = view::seen(population, &bounds, |sphere| frustum.meets(sphere), resolution);
        let maps = cast::maps(population, &bounds, scene, camera, &seen);
        let mut shown = shown(population);
        for seen in maps.iter().map(|map| &map.seen).chain([&seen]).flatten() {
            if let Some(level) = shown[seen.model as usize].get_mut(seen.level as usize) {
                *level = true;
            }
        }
        let anybody = shown.iter().flatten().any(|shown| *shown);
        let shapes = if anybody { Some(Shapes::new(gpu, population, &shown)?) } else { None };
        let casts = self.cast.draw(gpu, scene, prepared, shapes.as_ref(), &maps)?;
        let canopy = canopy::canopy(gpu, population, scene.ground.grid)?;
        Ok(Crowd { shapes, seen, casts, canopy })
    }

    /// Draws whoever is in the tile over the ground's range: theirs is negative. The image says what is seen of them;
    /// there is none if nobody is in the picture.
    pub fn draw(
        &self,
        gpu: &Gpu,
        crowd: &Crowd,
        view: (&Scene, &Prepared, &Film, Tile),
        range: &Image<R32f>,
        depth: &Image<D32f>,
    ) -> gpu::Result<Option<Image<Rgba32ui>>> {
        let (scene, prepared, film, tile) = view;
        let Some(shapes) = &crowd.shapes else { return Ok(None) };
        let plant = Image::new(gpu, "plant", tile.sample_size())?;
        let [scale, offset] = tile.clip(film);
        // Clip coordinates of the tile are those of the whole picture times `scale` plus `offset`.
        let [across, upward] = [0, 1].map(|axis| [-1.0, 1.0].map(|side| (side - offset[axis]) / scale[axis]));
        let frustum = Frustum::of(&prepared.camera, across, upward);
        let seen: Vec<Seen> = crowd.seen.iter().filter(|seen| frustum.meets(seen.bounds)).copied().collect();
        for batch in batch::batches(&scene.population, shapes, &seen) {
            let instances = shapes::upload(gpu, "instances", &batch.instances)?;
            let mut rec = Recorder::new(gpu);
            let targets = Targets { color: &[range, &plant], depth: Some(depth), load: Load::Keep };
            rec.render(&targets, |draws| {
                for (pool, draw) in &batch.draws {
                    let pool = &shapes.pools[*pool];
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
        Ok(Some(plant))
    }
}

impl Crowd {
    /// `None` if nobody is seen.
    pub fn materials(&self) -> Option<&Buffer<shaders::Material>> {
        self.shapes.as_ref().map(|shapes| &shapes.materials)
    }
}

/// For every level of every model whether it is shown: none yet.
fn shown(population: &Population) -> Vec<Vec<bool>> {
    population.models.iter().map(|model| vec![false; model.levels.len()]).collect()
}
