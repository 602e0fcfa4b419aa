//! What the world places one by one.

use super::random::Random;
use super::stand::{stand, turn_by};
use super::{Plant, Planter, Rule};
use glam::Vec2;

/// A place that is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// East and south of the middle of the terrain, metres.
    pub at: Vec2,
    /// Clockwise from above, radians.
    pub turn: f32,
    pub scale: f32,
}

/// One of the rule's first kind at every spot, whatever the site and whoever stands there.
pub fn plant(rule: &Rule, spots: &[Spot], planter: &Planter) -> Vec<Plant> {
    let Some((kind, _)) = rule.kinds.first() else { return Vec::new() };
    let kind = &planter.kinds[*kind];
    let plant = |(index, spot): (i32, &Spot)| {
        let mut random = Random::of_cell(rule.seed, SPOTS, [index, 0]);
        stand(rule, kind, planter.ground, spot.at, spot.scale, turn_by(-spot.turn), &mut random)
    };
    (0..).zip(spots).map(plant).collect()
}

/// Purpose of random numbers.
const SPOTS: u32 = 0x7370;
