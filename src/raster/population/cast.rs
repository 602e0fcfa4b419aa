//! Shadows that plants cast: maps drawn from the sun, each of a part of the view's depth (Dimitrov 2007, "Cascaded Shadow
//! Maps").

use super::batch::Batch;
use super::shapes;
use super::view::{Resolution, Seen, Sphere, seen};
use crate::core::camera::Pinhole;
use crate::gpu::{
    self, Blend, Buffer, Cull, Depth, Gpu, Image, Load, Raster, RasterState, Recorder, Targets, Topology,
    format::{D32f, Format, R32f},
};
use crate::raster::patches::Prepared;
use crate::scene::{Population, Scene};
use crate::shaders::{self, raster::cast};
use glam::{DVec2, DVec3, Vec3};
use std::sync::Arc;

/// Maps of a picture.
const MAPS: usize = 4;
/// Texels along a side of a map.
const SIDE: u32 = 1536;
/// Texels along a side of the image that holds them all: two beside two.
pub const IMAGE_SIDE: u32 = 2 * SIDE;
/// Beyond this distance nobody casts a shadow of their own, metres: a texel would be larger than a crown.
const FARTHEST: f32 = 2048.0;
/// Up to this distance there are shadows in any case, metres.
const NEAR_BY: f32 = 64.0;
/// How far along the sun's direction things may lie, metres.
const REACH: f32 = 1e5;

/// Shadow maps on the device, and what says where they lie.
#[derive(Clone)]
pub struct Casts {
    pub casts: Arc<Buffer<shaders::Cast>>,
    /// Of all maps; a single texel if there is none.
    pub maps: Image<R32f>,
}

/// Images that maps are drawn into, one picture after the other.
pub struct Sheets {
    maps: Image<R32f>,
    depth: Image<D32f>,
}

/// A part of the view: what it lies in, and how deep it reaches.
pub struct Slice {
    bounds: Sphere,
    depth: f32,
}

/// A map before it is drawn: whose shadows fall into its part of the view.
pub struct Map {
    cast: shaders::Cast,
    pub seen: Vec<Seen>,
}

pub struct Pass(Raster<cast::Shader>);

impl Pass {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        let state = RasterState {
            color: &[R32f::VK],
            depth: Depth::TestWrite,
            topology: Topology::Triangles,
            cull: Cull::None,
            blend: Blend::None,
        };
        Ok(Pass(Raster::new(gpu, (), &state)?))
    }

    /// Maps in which nobody casts a shadow yet; none is a picture without such shadows. `kept` has the images of earlier ones.
    pub fn begin(&self, gpu: &Gpu, maps: &[Map], kept: &mut Option<Sheets>) -> gpu::Result<Casts> {
        let mut casts = [shaders::Cast::default(); MAPS];
        for (cast, map) in casts.iter_mut().zip(maps) {
            *cast = map.cast;
        }
        let casts = Arc::new(shapes::upload(gpu, "casts", &casts)?);
        if maps.is_empty() {
            return Ok(Casts { casts, maps: Image::new(gpu, "shadow maps", [1; 2])? });
        }
        let Sheets { maps, depth } = match kept.take() {
            Some(sheets) => sheets,
            None => Sheets::new(gpu)?,
        };
        let mut rec = Recorder::new(gpu);
        let nothing = Targets { color: &[&maps], depth: Some(&depth), load: Load::Clear([-1e30; 4]) };
        rec.render(&nothing, |_| {});
        rec.submit()?.wait()?;
        *kept = Some(Sheets { maps: maps.clone(), depth });
        Ok(Casts { casts, maps })
    }

    /// Draws some of those whose shadows fall into a map.
    pub fn draw(
        &self,
        gpu: &Gpu,
        prepared: &Prepared,
        casts: &Casts,
        sheets: &Sheets,
        (map, batch): (usize, &Batch),
    ) -> gpu::Result<()> {
        let instances = Buffer::new(gpu, "instances", batch.instances.len())?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&instances, &batch.instances);
        let targets = Targets { color: &[&sheets.maps], depth: Some(&sheets.depth), load: Load::Keep };
        rec.render(&targets, |draws| {
            for (shape, draw) in &batch.draws {
                let bindings = cast::Bindings {
                    frame: &prepared.frame,
                    instances: &instances,
                    vertices: &shape.vertices,
                    casts: &casts.casts,
                };
                draws.draw_indexed(&self.0, &shape.indices, draw, cast::Push { map: map as i32 }, bindings);
            }
        });
        rec.submit()?.wait()?;
        Ok(())
    }
}

impl Sheets {
    fn new(gpu: &Gpu) -> gpu::Result<Sheets> {
        Ok(Sheets {
            maps: Image::new(gpu, "shadow maps", [IMAGE_SIDE; 2])?,
            depth: Image::new(gpu, "depth of shadow maps", [IMAGE_SIDE; 2])?,
        })
    }
}

/// The parts of the view that have maps of their own, in a picture that shows `shown`. None without a sun.
pub fn slices(population: &Population, scene: &Scene, camera: &Pinhole, shown: &[Seen]) -> Vec<Slice> {
    let has_sun = scene.light.sun.is_some_and(|sun| sun.direction.y > 0.0);
    if !has_sun || population.instances.is_empty() {
        return Vec::new();
    }
    // Who stands behind the eye may cast a shadow before it.
    let nearest = shown.iter().map(|seen| seen.distance).reduce(f32::min).unwrap_or(1.0);
    let farthest = shown.iter().map(|seen| seen.distance + 2.0 * seen.bounds.radius).fold(NEAR_BY, f32::max);
    // Powers of two, so that maps seldom change their size while the eye moves.
    let power = |distance: f32| distance.clamp(1.0, FARTHEST).log2();
    let (begin, end) = (power(nearest).floor(), power(farthest).ceil().max(power(nearest).floor() + 1.0));
    let depth = |index: usize| (begin + (end - begin) * index as f32 / MAPS as f32).exp2();
    (0..MAPS)
        .map(|index| {
            let from = if index == 0 { 0.0 } else { depth(index) };
            Slice { bounds: slice(camera, from, depth(index + 1)), depth: depth(index + 1) }
        })
        .collect()
}

/// The smallest sphere round what the camera sees between two depths, its centre on the axis.
fn slice(camera: &Pinhole, from: f32, to: f32) -> Sphere {
    let [tan_x, tan_y] = camera.tangent;
    let square = tan_x * tan_x + tan_y * tan_y;
    // As far from the near corners as from the far ones, but not behind the far plane.
    let middle = (0.5 * (from + to) * (1.0 + square)).min(to);
    let corner = |depth: f32| ((depth - middle).powi(2) + square * depth * depth).sqrt();
    Sphere { centre: camera.eye + middle * camera.forward, radius: corner(from).max(corner(to)) }
}

/// The map of a part of the view, and whose shadows are in it. None without a sun.
pub fn map(
    population: &Population,
    bounds: &[Sphere],
    scene: &Scene,
    eye: Vec3,
    &Slice { bounds: slice, depth }: &Slice,
) -> Option<Map> {
    let sun = scene.light.sun?.direction;
    let toward = sun.as_dvec3();
    let right = DVec3::Y.cross(toward).try_normalize().unwrap_or(DVec3::X);
    let up = toward.cross(right);
    let across = |point: Vec3| DVec2::new(right.dot(point.as_dvec3()), up.dot(point.as_dvec3()));
    // A texel of room at the rim. Texels stay where they are in the world while the eye moves.
    let texel = 2.0 * f64::from(slice.radius) / f64::from(SIDE - 2);
    let half_size = 0.5 * texel * f64::from(SIDE);
    let centre = (across(slice.centre) / texel).round() * texel;

    let texel = texel as f32;
    let lowest = sun.dot(slice.centre) - slice.radius;
    let meets = |sphere: Sphere| {
        let offset = (across(sphere.centre) - centre).abs().max_element() as f32;
        offset <= half_size as f32 + sphere.radius
            && sun.dot(sphere.centre) + sphere.radius >= lowest
            // What is smaller than a texel casts no shadow that this map could show.
            && sphere.radius > texel
    };
    let seen = seen(population, bounds, meets, Resolution::Parallel { eye, texel });
    let cast = shaders::Cast {
        right: right.as_vec3().to_array(),
        up: up.as_vec3().to_array(),
        centre: (centre - across(eye)).as_vec2().to_array(),
        half_size: half_size as f32,
        reach: REACH,
        depth,
    };
    Some(Map { cast, seen })
}
