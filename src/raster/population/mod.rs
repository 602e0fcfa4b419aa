//! What stands on the ground: instances of models, in levels of detail.
//!
//! [`shapes`] keeps every model's triangles on the device, once; [`view`] chooses who is seen, and in which level;
//! [`batch`] makes draws of them, cut so that no submission is long. All of it is done step by step ([`Passes::come`]). What they take from the light: [`occlusion`] within a
//! plant, [`canopy`] under crowns, [`cast`] where the sun is hidden.

pub(super) mod batch;
pub(super) mod canopy;
pub(super) mod cast;
mod occlusion;
pub(super) mod shapes;
mod view;

use super::patches::Prepared;
use crate::core::pace::{Pace, SLICE};
use crate::gpu::{
    self, Blend, Buffer, Cull, Depth, Gpu, Image, Load, Raster, RasterState, Recorder, Targets, Topology,
    format::{D32f, Format, R32f, Rgba32f, Rgba32ui},
};
use crate::scene::{Instance, Model, Population, Scene};
use crate::shaders::{self, raster::plant};

use batch::Cut;
use canopy::Canopy;
use cast::Casts;
use shapes::Shapes;
use std::collections::BTreeSet;
use std::sync::Arc;
use view::{Frustum, Resolution, Seen};

/// Of a submission that no window waits for: a device that draws in software does some millions a second.
const MOST_TRIANGLES: u32 = 1 << 20;

/// Of any: a submission takes some time by itself.
const LEAST_TRIANGLES: u32 = 1 << 16;

fn most(pace: Pace) -> u32 {
    pace.fits(SLICE).max(LEAST_TRIANGLES)
}

pub(super) struct Passes {
    plant: Raster<plant::Shader>,
    cast: cast::Pass,
}

/// A population on the device, as far as a picture needs it.
pub(super) struct Crowd {
    /// `None` if nobody is seen.
    shapes: Option<Arc<Shapes>>,
    /// Whoever is in the picture.
    pub seen: Vec<Seen>,
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
        let mut coming = Coming::new(Care::Full);
        let (kept, pace) = (&mut Kept::default(), &mut Pace::of(MOST_TRIANGLES));
        loop {
            if let Some(crowd) = self.come(gpu, (scene, prepared), kept, &mut coming, pace)? {
                return Ok(crowd);
            }
        }
    }

    /// Does a little of that, for `coming` plants; returns those who came once all are there. `kept` has what earlier pictures of this
    /// population needed; this one adds to it.
    pub fn come(
        &self,
        gpu: &Gpu,
        (scene, prepared): (&Scene, &Prepared),
        kept: &mut Kept,
        coming: &mut Coming,
        pace: &mut Pace,
    ) -> gpu::Result<Option<Crowd>> {
        let population = &scene.population;
        let camera = &prepared.camera;
        let bounds = kept.bounds.get_or_insert_with(|| view::bounds(population));
        match &mut coming.stage {
            Stage::Seen => {
                let frustum = Frustum::of(camera, [-1.0, 1.0], [-1.0, 1.0]);
                let sample_angle = coming.care.coarser() * prepared.sample_angle;
                let resolution = Resolution::Perspective { eye: camera.eye, sample_angle };
                coming.seen = view::seen(population, bounds, |sphere| frustum.meets(sphere), resolution);
                coming.slices = match coming.care {
                    Care::Full => cast::slices(population, scene, camera, &coming.seen),
                    Care::Swift => Vec::new(),
                };
                coming.stage = Stage::Maps;
            }
            Stage::Maps => match coming.slices.get(coming.maps.len()) {
                Some(slice) => coming.maps.extend(cast::map(population, bounds, scene, camera.eye, slice)),
                None => coming.stage = Stage::Shapes(kept.missing(population, coming.everybody())),
            },
            Stage::Shapes(missing) => match missing.pop() {
                Some(level) => kept.add(gpu, population, level)?,
                None => {
                    let casts = match &kept.no_casts {
                        Some(none) if coming.maps.is_empty() => none.clone(),
                        _ => self.cast.begin(gpu, &coming.maps, &mut kept.sheets)?,
                    };
                    if coming.maps.is_empty() {
                        kept.no_casts = Some(casts.clone());
                    }
                    coming.stage = Stage::Casts { casts, map: 0, cut: Cut::default() };
                }
            },
            Stage::Casts { casts, map, cut } => {
                let (Some(seen), Some(shapes), Some(sheets)) =
                    (coming.maps.get(*map).map(|map| &map.seen), &kept.shapes, &kept.sheets)
                else {
                    coming.stage = Stage::Canopy { casts: casts.clone(), canopy: None };
                    return Ok(None);
                };
                match batch::next(population, shapes, seen, cut, most(*pace)) {
                    Some(batch) => pace.time(batch.triangles, || {
                        self.cast.draw(gpu, prepared, casts, sheets, (*map, &batch))
                    })?,
                    None => (*map, *cut) = (*map + 1, Cut::default()),
                }
            }
            Stage::Canopy { casts, canopy } => {
                if kept.canopy.is_none() {
                    let canopy = canopy.get_or_insert_with(|| Canopy::begin(population, scene.ground.grid));
                    if canopy.step(population, SLICE) {
                        return Ok(None);
                    }
                    kept.canopy = Some(canopy.image(gpu)?);
                }
                let Some(canopy) = &kept.canopy else { return Ok(None) };
                return Ok(Some(Crowd {
                    shapes: kept.shapes.clone(),
                    seen: std::mem::take(&mut coming.seen),
                    casts: casts.clone(),
                    canopy: canopy.clone(),
                }));
            }
        }
        Ok(None)
    }

    /// Draws some more of whoever is in the tile over the ground's range, from `cut` on: theirs is negative. The image `plant` says what
    /// is seen of them. `clip` is the tile's scale and offset. False once all are there.
    pub fn draw(
        &self,
        gpu: &Gpu,
        (crowd, seen, cut): (&Crowd, &[Seen], &mut Cut),
        (scene, prepared): (&Scene, &Prepared),
        [scale, offset]: [[f32; 2]; 2],
        (range, plant, depth): (&Image<R32f>, &Image<Rgba32ui>, &Image<D32f>),
        pace: &mut Pace,
    ) -> gpu::Result<bool> {
        let Some(shapes) = &crowd.shapes else { return Ok(false) };
        let Some(batch) = batch::next(&scene.population, shapes, seen, cut, most(*pace)) else {
            return Ok(false);
        };
        pace.time(batch.triangles, || {
            let instances = Buffer::new(gpu, "instances", batch.instances.len())?;
            let mut rec = Recorder::new(gpu);
            rec.upload(&instances, &batch.instances);
            let targets = Targets { color: &[range, plant], depth: Some(depth), load: Load::Keep };
            rec.render(&targets, |draws| {
                for (shape, draw) in &batch.draws {
                    draws.draw_indexed(
                        &self.plant,
                        &shape.indices,
                        draw,
                        plant::Push { scale, offset },
                        plant::Bindings {
                            frame: &prepared.frame,
                            instances: &instances,
                            vertices: &shape.vertices,
                        },
                    );
                }
            });
            rec.submit()?.wait()?;
            Ok(true)
        })
    }

    /// Draws all of them who are in a tile.
    pub fn draw_tile(
        &self,
        gpu: &Gpu,
        crowd: &Crowd,
        seen: (&Scene, &Prepared),
        [scale, offset]: [[f32; 2]; 2],
        targets: (&Image<R32f>, &Image<Rgba32ui>, &Image<D32f>),
    ) -> gpu::Result<()> {
        // Clip coordinates of the tile are those of the whole picture times `scale` plus `offset`.
        let [across, upward] = [0, 1].map(|axis| [-1.0, 1.0].map(|side| (side - offset[axis]) / scale[axis]));
        let frustum = Frustum::of(&seen.1.camera, across, upward);
        let within: Vec<Seen> =
            crowd.seen.iter().filter(|seen| frustum.meets(seen.bounds)).copied().collect();
        let (mut cut, mut pace) = (Cut::default(), Pace::of(MOST_TRIANGLES));
        while self.draw(gpu, (crowd, &within, &mut cut), seen, [scale, offset], targets, &mut pace)? {}
        Ok(())
    }
}

/// Plants on their way into a picture: see [`Passes::come`].
pub(super) struct Coming {
    care: Care,
    seen: Vec<Seen>,
    slices: Vec<cast::Slice>,
    maps: Vec<cast::Map>,
    stage: Stage,
}

/// What is to be done next.
enum Stage {
    Seen,
    Maps,
    /// Levels of models that are to be brought to the device.
    Shapes(Vec<[u32; 2]>),
    Casts {
        casts: Casts,
        map: usize,
        cut: Cut,
    },
    Canopy {
        casts: Casts,
        canopy: Option<Canopy>,
    },
}

impl Coming {
    pub fn new(care: Care) -> Coming {
        Coming { care, seen: Vec::new(), slices: Vec::new(), maps: Vec::new(), stage: Stage::Seen }
    }

    /// Who is in the picture, and whose shadows are.
    fn everybody(&self) -> impl Iterator<Item = &Seen> {
        self.maps.iter().map(|map| &map.seen).chain([&self.seen]).flatten()
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
    no_casts: Option<Casts>,
    sheets: Option<cast::Sheets>,
    canopy: Option<Image<Rgba32f>>,
}

impl Kept {
    /// Levels of those who are seen that are not on the device yet.
    fn missing<'a>(&self, population: &Population, seen: impl Iterator<Item = &'a Seen>) -> Vec<[u32; 2]> {
        // They come sorted.
        let mut last = None;
        let levels = seen.map(|seen| [seen.model, seen.level]);
        let levels: BTreeSet<_> = levels.filter(|level| last.replace(*level) != Some(*level)).collect();
        let is_missing = |level: &[u32; 2]| match &self.shapes {
            Some(shapes) => !shapes.has(population, *level),
            None => true,
        };
        levels.into_iter().filter(is_missing).collect()
    }

    /// Brings a level to the device.
    fn add(&mut self, gpu: &Gpu, population: &Population, level: [u32; 2]) -> gpu::Result<()> {
        let shapes = match self.shapes.take() {
            Some(shapes) => shapes,
            None => Arc::new(Shapes::new(gpu, population)?),
        };
        // A picture that is given up may still have them.
        let shapes = self.shapes.insert(shapes);
        if shapes.has(population, level) { Ok(()) } else { Arc::make_mut(shapes).add(gpu, population, level) }
    }
}

impl Kept {
    /// Others stand there now: what is of models that they have, too, stays, and so does the canopy if all that may shade the ground does.
    pub fn replant(&mut self, before: &Population, now: &Population) {
        let is_same = |(one, other): (&Arc<Model>, &Arc<Model>)| Arc::ptr_eq(one, other);
        let same_number = before.models.len() == now.models.len();
        if !(same_number && before.models.iter().zip(&now.models).all(is_same)) {
            *self = Kept::default();
        }
        let Some(bounds) = &self.bounds else { return };
        let is_high = |instance: &&Instance| {
            let sphere = bounds.get(instance.model as usize).copied().unwrap_or_default();
            instance.scale * (sphere.centre.y + sphere.radius) >= canopy::LOWEST
        };
        if !before.instances.iter().filter(is_high).eq(now.instances.iter().filter(is_high)) {
            self.canopy = None;
        }
    }

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
        self.shapes.as_ref().map(|shapes| &*shapes.materials)
    }
}
