//! Shadows that plants cast: maps drawn from the sun, each of a part of the view's depth (Dimitrov 2007, "Cascaded Shadow
//! Maps").

use super::batch;
use super::shapes::{self, Shapes};
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
    pub casts: Buffer<shaders::Cast>,
    /// Of all maps; a single texel if there is none.
    pub maps: Image<R32f>,
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

    /// Draws the maps; none is a picture without such shadows.
    pub fn draw(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        prepared: &Prepared,
        shapes: Option<&Shapes>,
        maps: &[Map],
    ) -> gpu::Result<Casts> {
        let mut casts = [shaders::Cast::default(); MAPS];
        for (cast, map) in casts.iter_mut().zip(maps) {
            *cast = map.cast;
        }
        let casts = shapes::upload(gpu, "casts", &casts)?;
        let Some(shapes) = shapes.filter(|_| !maps.is_empty()) else {
            return Ok(Casts { casts, maps: Image::new(gpu, "shadow maps", [1; 2])? });
        };
        let image = Image::new(gpu, "shadow maps", [IMAGE_SIDE; 2])?;
        let depth = Image::<D32f>::new(gpu, "depth of shadow maps", [IMAGE_SIDE; 2])?;
        let mut rec = Recorder::new(gpu);
        let nothing = Targets { color: &[&image], depth: Some(&depth), load: Load::Clear([-1e30; 4]) };
        rec.render(&nothing, |_| {});
        rec.submit()?.wait()?;
        for (index, map) in maps.iter().enumerate() {
            for batch in batch::batches(&scene.population, shapes, &map.seen) {
                let instances = shapes::upload(gpu, "instances", &batch.instances)?;
                let mut rec = Recorder::new(gpu);
                let targets = Targets { color: &[&image], depth: Some(&depth), load: Load::Keep };
                rec.render(&targets, |draws| {
                    for (pool, draw) in &batch.draws {
                        let pool = &shapes.pools[*pool];
                        let bindings = cast::Bindings {
                            frame: &prepared.frame,
                            instances: &instances,
                            vertices: &pool.vertices,
                            casts: &casts,
                        };
                        let push = cast::Push { map: index as i32 };
                        draws.draw_indexed(&self.0, &pool.indices, draw, push, bindings);
                    }
                });
                rec.submit()?.wait()?;
            }
        }
        Ok(Casts { casts, maps: image })
    }
}

/// The maps of a picture that shows `shown`, and whose shadows are in them. None without a sun.
pub fn maps(
    population: &Population,
    bounds: &[Sphere],
    scene: &Scene,
    camera: &Pinhole,
    shown: &[Seen],
) -> Vec<Map> {
    let Some(sun) = scene.light.sun.map(|sun| sun.direction).filter(|sun| sun.y > 0.0) else {
        return Vec::new();
    };
    if population.instances.is_empty() {
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
            let slice = slice(camera, from, depth(index + 1));
            map(population, bounds, camera.eye, sun, slice, depth(index + 1))
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

fn map(population: &Population, bounds: &[Sphere], eye: Vec3, sun: Vec3, slice: Sphere, depth: f32) -> Map {
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
    Map { cast, seen }
}
