//! How a plant stands: turned, leaning, its foot in the ground.

use super::{Ground, Kind, Rule, random::Random, shade::Circle};
use crate::scene::Instance;
use glam::{Quat, Vec2, Vec3};

/// A plant with what its neighbours feel of it.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    pub instance: Instance,
    pub circle: Circle,
    /// Metres.
    pub height: f32,
    /// At random in 0…1: it lives in the shade where its rule has more than this for `shade`.
    pub tolerance: f32,
}

/// The foot of a plant on level ground lies this deep, metres, …
const DEPTH: f32 = 0.05;
/// … or this share of its height, if that is less.
const DEPTH_SHARE: f32 = 0.02;

/// Stands a plant of `kind` on the ground.
pub fn stand(rule: &Rule, kind: &Kind, ground: &Ground, at: Vec2, scale: f32, random: &mut Random) -> Plant {
    let gradient = ground.gradient(at);
    let upright = Vec3::Y.lerp(Ground::normal(gradient), rule.lean).normalize();
    let yaw = yaw(random);
    let variant = pick(random, kind.models.len());
    let (foot, height) = (kind.foot * scale, kind.height * scale);
    // The lower rim of the foot is in the ground, too.
    let drop = foot * gradient.length() * (1.0 - rule.lean);
    let depth = DEPTH.min(DEPTH_SHARE * height);
    let instance = Instance {
        model: kind.models.start + variant,
        random: random.bits(),
        position: Vec3::new(at.x, ground.height_at(at) - drop - depth, at.y),
        rotation: Quat::from_rotation_arc(Vec3::Y, upright) * yaw,
        scale,
    };
    let circle = Circle { center: at, crown: kind.crown * scale, foot };
    Plant { instance, circle, height, tolerance: random.share() }
}

/// One of so many.
fn pick(random: &mut Random, count: usize) -> u32 {
    ((u64::from(random.bits()) * count as u64) >> 32) as u32
}

/// Any direction, by a function that is the same everywhere.
fn yaw(random: &mut Random) -> Quat {
    let (sine, cosine) = libm::sincosf(std::f32::consts::PI * random.share());
    Quat::from_xyzw(0.0, sine, 0.0, cosine)
}
