//! Where plants like to grow: a density between 0 and 1 for every place.

use super::ground::{Ground, Needs, OVERSHOOT};
use super::random::Random;
use crate::core::map::Map;
use glam::Vec2;
use std::sync::{Arc, OnceLock};

/// What plants ask of the ground. The density is the product of all that is asked.
#[derive(Clone, Debug, Default)]
pub struct Site {
    /// Over height above the sea, metres.
    pub height: Option<Ramp>,
    /// Over the slope, radians.
    pub slope: Option<Ramp>,
    /// Over the distance to the sea, metres.
    pub sea: Option<Ramp>,
    /// Over the distance to a river, a lake or the sea, metres.
    pub water: Option<Ramp>,
    /// Over wetness, 0…1.
    pub wetness: Option<Ramp>,
    /// Over flow, m³/s.
    pub flow: Option<Ramp>,
    /// Painted: 0 is nothing, 1 is all.
    pub mask: Option<Arc<Map>>,
    pub patches: Option<Patches>,
    pub footing: Footing,
}

/// What plants stand on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Footing {
    /// Above the sea and out of rivers and lakes.
    #[default]
    Land,
    /// On the bed of the sea, of rivers and of lakes.
    Water,
    Anywhere,
}

impl Site {
    /// Share of the best density at a place, 0…1.
    pub fn density(&self, ground: &Ground, at: Vec2) -> f32 {
        let height = ground.height_at(at);
        let dry = ground.is_dry(at, height);
        if !ground.contains(at)
            || dry && self.footing == Footing::Water
            || !dry && self.footing == Footing::Land
        {
            return 0.0;
        }
        let ramp = |ramp: &Option<Ramp>, value: &dyn Fn() -> f32| ramp.map_or(1.0, |ramp| ramp.at(value()));
        // What costs least comes first; nothing is asked any more once it is 0.
        let factors: [&dyn Fn() -> f32; 8] = [
            &|| ramp(&self.height, &|| height - ground.sea_level),
            &|| ramp(&self.wetness, &|| ground.wetness_at(at)),
            &|| ramp(&self.flow, &|| ground.flow_at(at)),
            &|| ramp(&self.sea, &|| ground.to_sea_at(at)),
            &|| ramp(&self.water, &|| ground.to_water_at(at)),
            &|| self.mask.as_ref().map_or(1.0, |mask| mask.at(share_of(ground, at)).clamp(0.0, 1.0)),
            &|| self.patches.as_ref().map_or(1.0, |patches| patches.at(at)),
            &|| ramp(&self.slope, &|| libm::atanf(ground.gradient(at).length())),
        ];
        let mut density = 1.0;
        for factor in factors {
            density *= factor();
            if density == 0.0 {
                break;
            }
        }
        density
    }

    /// Whether plants can stand where the ground's samples lie between these heights.
    pub fn is_possible(&self, ground: &Ground, [least, greatest]: [f32; 2]) -> bool {
        // Along rows first, and then across what these made of it.
        let margin = OVERSHOOT * (2.0 + 2.0 * OVERSHOOT) * (greatest - least);
        let [least, greatest] = [least - margin, greatest + margin].map(|height| height - ground.sea_level);
        // Rivers lie above the sea.
        let under_water = self.footing == Footing::Land && greatest <= 0.0;
        !under_water && self.height.is_none_or(|ramp| ramp.reaches([least, greatest]))
    }

    pub fn needs(&self) -> Needs {
        Needs {
            wetness: self.wetness.is_some(),
            flow: self.flow.is_some(),
            sea: self.sea.is_some(),
            water: self.water.is_some(),
        }
    }
}

fn share_of(ground: &Ground, at: Vec2) -> [f32; 2] {
    (at / ground.grid.extent + 0.5).to_array()
}

/// A density over some quantity: nothing up to the first of four rising values, all from the second to the third, nothing from
/// the fourth on, straight lines between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp([f32; 4]);

impl Ramp {
    /// Of two values the first is where nothing grows and the second where all does; of four, nothing, all, all,
    /// nothing. `None` unless there are two that differ or four that don't fall.
    pub fn new(values: &[f32]) -> Option<Ramp> {
        match *values {
            [none, all] if none < all => Some(Ramp([none, all, f32::INFINITY, f32::INFINITY])),
            [none, all] if none > all => Some(Ramp([f32::NEG_INFINITY, f32::NEG_INFINITY, all, none])),
            [first, second, third, fourth] if values.is_sorted() => {
                Some(Ramp([first, second, third, fourth]))
            }
            _ => None,
        }
    }

    pub fn at(self, value: f32) -> f32 {
        let Ramp([first, second, third, fourth]) = self;
        if value < first || value > fourth {
            0.0
        } else if value < second {
            (value - first) / (second - first)
        } else if value > third {
            (fourth - value) / (fourth - third)
        } else {
            1.0
        }
    }

    /// Whether it is above 0 anywhere between two values.
    fn reaches(self, [least, greatest]: [f32; 2]) -> bool {
        let Ramp([first, _, _, fourth]) = self;
        greatest >= first && least <= fourth
    }
}

/// Patches of plants with bare ground between: smooth noise above a threshold.
#[derive(Clone, Debug)]
pub struct Patches {
    seed: u32,
    /// Metres.
    size: f32,
    cover: f32,
    /// Of the noise, once it is asked for: most of what a world takes to be read would be this.
    threshold: OnceLock<f32>,
}

/// Width of the edge of a patch on either side of its line, in the noise's own measure.
const EDGE: f32 = 0.06;

impl Patches {
    /// Patches about `size` metres wide that cover this share of the ground.
    pub fn new(seed: u32, size: f32, cover: f32) -> Self {
        Patches { seed, size, cover, threshold: OnceLock::new() }
    }

    pub fn at(&self, at: Vec2) -> f32 {
        let threshold = self.threshold.get_or_init(|| self.find_threshold());
        let above = noise(self.seed, at / self.size) - threshold;
        ((above / EDGE + 1.0) / 2.0).clamp(0.0, 1.0)
    }

    /// The noise's own distribution says above which value so much of it lies.
    fn find_threshold(&self) -> f32 {
        const SAMPLES: i32 = 128;
        let places = (0..SAMPLES * SAMPLES).map(|index| [index % SAMPLES, index / SAMPLES]);
        let mut values: Vec<f32> =
            places.map(|[x, y]| noise(self.seed, Vec2::new(x as f32, y as f32) * 0.37)).collect();
        let bare = ((1.0 - self.cover).clamp(0.0, 1.0) * (values.len() - 1) as f32) as usize;
        *values.select_nth_unstable_by(bare, f32::total_cmp).1
    }
}

impl PartialEq for Patches {
    /// Whether they are the same patches, whoever has looked at them.
    fn eq(&self, other: &Patches) -> bool {
        (self.seed, self.size, self.cover) == (other.seed, other.size, other.cover)
    }
}

/// Gradient noise (Perlin 2002, "Improving Noise") in two octaves, about −1…1; hills of the first are about 1 wide.
fn noise(seed: u32, at: Vec2) -> f32 {
    gradient_noise(seed, at) + 0.5 * gradient_noise(!seed, 2.0 * at)
}

fn gradient_noise(seed: u32, at: Vec2) -> f32 {
    let cell = at.floor();
    let inside = at - cell;
    let corner = |east: i32, south: i32| {
        let at_corner = [cell.x as i32 + east, cell.y as i32 + south];
        let mut random = Random::of_cell(seed, PATCHES, at_corner);
        let gradient = Vec2::new(random.between([-1.0, 1.0]), random.between([-1.0, 1.0]));
        gradient.dot(inside - Vec2::new(east as f32, south as f32))
    };
    let fade = inside * inside * inside * (inside * (inside * 6.0 - 15.0) + 10.0);
    let [north_west, south_west] = [corner(0, 0), corner(0, 1)];
    let north = north_west + (corner(1, 0) - north_west) * fade.x;
    let south = south_west + (corner(1, 1) - south_west) * fade.x;
    north + (south - north) * fade.y
}

/// Purpose of random numbers.
const PATCHES: u32 = 0x7061;
