//! Who is seen, and in which level of detail.

use crate::core::{camera::Pinhole, hash::mix};
use crate::scene::{Instance, Model, Population};
use glam::Vec3;
use rayon::prelude::*;

/// An instance that is seen.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Index into [`Population::instances`].
    pub instance: u32,
    pub model: u32,
    pub level: u32,
    /// Nearest distance of what bounds it, metres.
    pub distance: f32,
    pub bounds: Sphere,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Sphere {
    pub centre: Vec3,
    pub radius: f32,
}

/// Half spaces that a view lies in, as inward unit normals and distances from the origin.
#[derive(Clone, Debug)]
pub struct Frustum(Vec<(Vec3, f32)>);

impl Frustum {
    /// What `camera` sees between these parts of its picture, in clip coordinates: left and right, bottom and top.
    pub fn of(camera: &Pinhole, across: [f32; 2], upward: [f32; 2]) -> Frustum {
        let [tan_x, tan_y] = camera.tangent;
        let forward = camera.forward;
        let normals = [
            camera.right - forward * (across[0] * tan_x),
            forward * (across[1] * tan_x) - camera.right,
            camera.up - forward * (upward[0] * tan_y),
            forward * (upward[1] * tan_y) - camera.up,
            forward,
        ];
        let plane = |normal: Vec3| {
            let normal = normal.normalize_or_zero();
            (normal, normal.dot(camera.eye))
        };
        Frustum(normals.map(plane).into())
    }

    pub fn meets(&self, sphere: Sphere) -> bool {
        self.0.iter().all(|(normal, offset)| normal.dot(sphere.centre) - offset >= -sphere.radius)
    }
}

/// What a level has to resolve.
#[derive(Clone, Copy, Debug)]
pub enum Resolution {
    /// Samples this many radians apart, seen from the eye.
    Perspective { eye: Vec3, sample_angle: f32 },
    /// Samples this many metres apart.
    Parallel { eye: Vec3, texel: f32 },
}

/// The level in which an instance is shown.
pub fn level_of(
    population: &Population,
    bounds: &[Sphere],
    instance: usize,
    resolution: Resolution,
) -> Option<u32> {
    let instance = population.instances.get(instance)?;
    let sphere = placed(instance, *bounds.get(instance.model as usize)?);
    let model = population.models.get(instance.model as usize)?;
    Some(level(model, instance, resolution.metres(distance(sphere, resolution.eye()))))
}

/// Everyone within `frustum`, by level, model and distance: what is near and hides others comes first.
pub fn seen(
    population: &Population,
    bounds: &[Sphere],
    meets: impl Fn(Sphere) -> bool + Sync,
    resolution: Resolution,
) -> Vec<Seen> {
    let mut seen: Vec<Seen> = population
        .instances
        .par_iter()
        .enumerate()
        .filter_map(|(index, instance)| {
            let model = population.models.get(instance.model as usize)?;
            let sphere = placed(instance, *bounds.get(instance.model as usize)?);
            if !meets(sphere) {
                return None;
            }
            let distance = distance(sphere, resolution.eye());
            let level = level(model, instance, resolution.metres(distance));
            let index = u32::try_from(index).ok()?;
            Some(Seen { instance: index, model: instance.model, level, distance, bounds: sphere })
        })
        .collect();
    seen.par_sort_unstable_by(|one, other| {
        let key = |seen: &Seen| (seen.level, seen.model);
        key(one)
            .cmp(&key(other))
            .then(one.distance.total_cmp(&other.distance))
            .then(one.instance.cmp(&other.instance))
    });
    seen
}

impl Resolution {
    fn eye(self) -> Vec3 {
        match self {
            Resolution::Perspective { eye, .. } | Resolution::Parallel { eye, .. } => eye,
        }
    }

    /// Distance between neighbouring samples on what is this far away.
    fn metres(self, distance: f32) -> f32 {
        match self {
            Resolution::Perspective { sample_angle, .. } => distance * sample_angle,
            Resolution::Parallel { texel, .. } => texel,
        }
    }
}

/// A sphere round every model.
pub fn bounds(population: &Population) -> Vec<Sphere> {
    let sphere = |model: &std::sync::Arc<Model>| {
        let [least, greatest] = model.bounds();
        Sphere { centre: (least + greatest) / 2.0, radius: least.distance(greatest) / 2.0 }
    };
    population.models.par_iter().map(sphere).collect()
}

/// To the nearest point of a sphere.
fn distance(Sphere { centre, radius }: Sphere, eye: Vec3) -> f32 {
    (centre.distance(eye) - radius).max(0.0)
}

fn placed(instance: &Instance, Sphere { centre, radius }: Sphere) -> Sphere {
    let centre = instance.position + instance.rotation * (centre * instance.scale);
    Sphere { centre, radius: radius * instance.scale }
}

/// The coarsest level that leaves out nothing larger than `metres`. Every plant changes a little nearer or farther than
/// others, so that no line shows where they do.
fn level(model: &Model, instance: &Instance, metres: f32) -> u32 {
    let unit = mix(instance.random) as f32 / u32::MAX as f32;
    let most = metres * (0.85 + 0.3 * unit) / instance.scale.max(f32::MIN_POSITIVE);
    model.levels.iter().rposition(|level| level.detail <= most).unwrap_or(0) as u32
}
