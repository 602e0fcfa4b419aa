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

/// Stands a plant of `kind` on the ground, after a `turn` about the vertical.
pub fn stand(
    rule: &Rule,
    kind: &Kind,
    ground: &Ground,
    at: Vec2,
    scale: f32,
    turn: Quat,
    random: &mut Random,
) -> Plant {
    let gradient = ground.gradient(at);
    let upright = Vec3::Y.lerp(Ground::normal(gradient), rule.lean).normalize();
    let variant = pick(random, kind.models.len());
    let (foot, height) = (kind.foot * scale, kind.height * scale);
    // The lower rim of the foot is in the ground, too.
    let drop = foot * gradient.length() * (1.0 - rule.lean);
    let depth = DEPTH.min(DEPTH_SHARE * height);
    let instance = Instance {
        model: kind.models.start + variant,
        random: random.bits(),
        position: Vec3::new(at.x, ground.height_at(at) - drop - depth, at.y),
        rotation: Quat::from_rotation_arc(Vec3::Y, upright) * turn,
        scale,
    };
    let circle = Circle { center: at, crown: kind.crown * scale, foot };
    Plant { instance, circle, height, tolerance: random.share() }
}

/// One of so many.
fn pick(random: &mut Random, count: usize) -> u32 {
    ((u64::from(random.bits()) * count as u64) >> 32) as u32
}

/// Any direction.
pub fn turn(random: &mut Random) -> Quat {
    turn_by(std::f32::consts::TAU * random.share())
}

/// A turn about the vertical, counter-clockwise from above, by functions that are the same everywhere.
pub fn turn_by(angle: f32) -> Quat {
    let (sine, cosine) = libm::sincosf(angle / 2.0);
    Quat::from_xyzw(0.0, sine, 0.0, cosine)
}
