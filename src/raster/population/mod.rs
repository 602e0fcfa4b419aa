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

use super::patches::Prepared;
use crate::gpu::{
    self, Blend, Buffer, Cull, Depth, Gpu, Image, Load, Raster, RasterState, Recorder, Targets, Topology,
    format::{D32f, Format, R32f, Rgba32f, Rgba32ui},
};
use crate::scene::{Population, Scene};
use crate::shaders::{self, raster::plant};

use cast::Casts;
use shapes::Shapes;
use std::sync::Arc;
use view::{Frustum, Resolution, Seen};

pub(super) struct Passes {
    plant: Raster<plant::Shader>,
    cast: cast::Pass,
}

/// A population on the device, as far as a picture needs it.
pub(super) struct Crowd {
    /// `None` if nobody is seen.
    shapes: Option<Arc<Shapes>>,
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
        self.look(gpu, scene, prepared, &mut Kept::default(), Care::Full)
    }

    /// The same, where `kept` has what earlier pictures of this population needed; this one adds to it.
    pub fn look(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        prepared: &Prepared,
        kept: &mut Kept,
        care: Care,
    ) -> gpu::Result<Crowd> {
        let population = &scene.population;
        let camera = &prepared.camera;
        let frustum = Frustum::of(camera, [-1.0, 1.0], [-1.0, 1.0]);
        let sample_angle = care.coarser() * prepared.sample_angle;
        let resolution = Resolution::Perspective { eye: camera.eye, sample_angle };
        let bounds = kept.bounds.get_or_insert_with(|| view::bounds(population));
        let seen = view::seen(population, bounds, |sphere| frustum.meets(sphere), resolution);
        let maps = match care {
            Care::Full => cast::maps(population, bounds, scene, camera, &seen),
            Care::Swift => Vec::new(),
        };
        let everybody = maps.iter().map(|map| &map.seen).chain([&seen]).flatten();
        let shapes = kept.shapes(gpu, population, everybody)?;
        let casts = match &kept.no_casts {
            Some(none) if maps.is_empty() => none.clone(),
            _ => self.cast.draw(gpu, scene, prepared, shapes.as_deref(), &maps)?,
        };
        if maps.is_empty() {
            kept.no_casts = Some(casts.clone());
        }
        let canopy = match &kept.canopy {
            Some(canopy) => canopy.clone(),
            None => kept.canopy.insert(canopy::canopy(gpu, population, scene.ground.grid)?).clone(),
        };
        Ok(Crowd { shapes, seen, casts, canopy })
    }

    /// Draws whoever is in the tile over the ground's range: theirs is negative. The image `plant` says what is seen of
    /// them. `clip` is the tile's scale and offset.
    pub fn draw(
        &self,
        gpu: &Gpu,
        crowd: &Crowd,
        (scene, prepared): (&Scene, &Prepared),
        [scale, offset]: [[f32; 2]; 2],
        (range, plant, depth): (&Image<R32f>, &Image<Rgba32ui>, &Image<D32f>),
    ) -> gpu::Result<()> {
        let Some(shapes) = &crowd.shapes else { return Ok(()) };
        // Clip coordinates of the tile are those of the whole picture times `scale` plus `offset`.
        let [across, upward] = [0, 1].map(|axis| [-1.0, 1.0].map(|side| (side - offset[axis]) / scale[axis]));
        let frustum = Frustum::of(&prepared.camera, across, upward);
        let seen: Vec<Seen> = crowd.seen.iter().filter(|seen| frustum.meets(seen.bounds)).copied().collect();
        for batch in batch::batches(&scene.population, shapes, &seen) {
            let instances = shapes::upload(gpu, "instances", &batch.instances)?;
            let mut rec = Recorder::new(gpu);
            let targets = Targets { color: &[range, plant], depth: Some(depth), load: Load::Keep };
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
        Ok(())
    }
}

/// How carefully plants are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Care {
    Full,
    /// In coarser levels of detail, and without shadows of their own.
    Swift,
}

impl Care {
    /// How many times as far apart samples may lie as they do.
    fn coarser(self) -> f32 {
        match self {
            Care::Full => 1.0,
            Care::Swift => 3.0,
        }
    }
}

/// What pictures of one population have in common.
#[derive(Default)]
pub(super) struct Kept {
    bounds: Option<Vec<view::Sphere>>,
    shapes: Option<Arc<Shapes>>,
    /// Levels that `shapes` has, by model.
    shown: Vec<Vec<bool>>,
    no_casts: Option<Casts>,
    canopy: Option<Image<Rgba32f>>,
}

impl Kept {
    /// The models of those who are seen; `None` if nobody is and nobody was. Levels that are new to it are uploaded with all that were
    /// there before.
    fn shapes<'a>(
        &mut self,
        gpu: &Gpu,
        population: &Population,
        seen: impl Iterator<Item = &'a Seen>,
    ) -> gpu::Result<Option<Arc<Shapes>>> {
        if self.shown.is_empty() {
            self.shown = shown(population);
        }
        let mut grown = false;
        for seen in seen {
            if let Some(level) = self.shown[seen.model as usize].get_mut(seen.level as usize) {
                grown |= !*level;
                *level = true;
            }
        }
        if grown {
            self.shapes = None;
            self.shapes = Some(Arc::new(Shapes::new(gpu, population, &self.shown)?));
        }
        Ok(self.shapes.clone())
    }
}

impl Kept {
    /// The level in which an instance is drawn in a full picture.
    pub fn level_of(&self, population: &Population, instance: usize, prepared: &Prepared) -> Option<u32> {
        let Prepared { camera, sample_angle, .. } = prepared;
        let resolution = Resolution::Perspective { eye: camera.eye, sample_angle: *sample_angle };
        view::level_of(population, self.bounds.as_ref()?, instance, resolution)
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
