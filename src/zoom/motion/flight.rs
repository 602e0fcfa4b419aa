//! Flying by hand: speed is proportional to the distance to the surface.

use super::{Approach, Clearance, Depth, Distance, clearance};
use crate::zoom::{
    address::{DEEPEST, Place},
    height::{AMPLITUDE, FRACTION_BITS, REACH, Roughness, Spine},
    tree::Eye,
};
use glam::DVec3;

/// Distances a second at which one level a second is passed straight down.
pub const LEVEL_A_SECOND: f64 = std::f64::consts::LN_2;

/// The longest step, in distances to the surface. These are lower bounds, so no step of this length reaches it, and nothing else is needed against
/// collisions.
const LONGEST_STEP: f64 = 0.5;

/// The longest way at once, in distances: a second at the highest speed. What is more is cut off, as a frame may have taken long.
const LONGEST_WAY: f64 = 8.0;

/// Digits that a step has behind the level of the distance: it is exact to 2⁻³² of that.
const STEP_DIGITS: u32 = 32;

/// Digits that the spot of a way out has behind the level of the distance.
const TARGET_DIGITS: u32 = 24;

/// Cells of level 0 above which there is nothing to see and no flight goes.
const CEILING: f64 = (1 << 20) as f64;

/// Cells around the place that assistance chooses from.
const AROUND: usize = 2;

/// Something that moves above the surface.
#[derive(Clone, Debug)]
pub struct Flight {
    place: Place,
    clearance: Distance,
}

/// A place beside another: the step (east, up, south) is in distances.
pub fn moved(place: &Place, Distance { level, cells }: Distance, step: DVec3, roughness: Roughness) -> Place {
    let digits = level + STEP_DIGITS;
    let unit = cells * (1u64 << STEP_DIGITS) as f64;
    let [east, up, south] = (step * unit).round().to_array().map(|amount| amount as i64);
    let mut place = place.clone();
    place.x.add(east, digits);
    // Amplitudes are shorter than cells.
    place.y.add(up, digits - roughness.halvings());
    place.z.add(south, digits);
    place
}

/// A place where no flight can begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the place is on or below the surface")]
pub struct Buried;

impl Flight {
    /// Begins at a place. The level is about that of its distance to the surface (see [`clearance`]).
    ///
    /// # Errors
    /// If the place is not above the surface.
    pub fn new(spine: &mut Spine, place: Place, level: u32) -> Result<Flight, Buried> {
        match clearance(spine, &place, level) {
            Some(Clearance { distance, is_above: true }) => Ok(Flight { place, clearance: distance }),
            _ => Err(Buried),
        }
    }

    pub fn place(&self) -> &Place {
        &self.place
    }

    /// How far the surface is, at most 1/16 too little.
    pub fn clearance(&self) -> Distance {
        self.clearance
    }

    /// Moves along a direction (east, up, south; what is longer than 1 counts as 1), `way` times the distance to the surface as it becomes on the
    /// way: speed times seconds.
    pub fn fly(&mut self, spine: &mut Spine, direction: DVec3, way: f64) {
        if !direction.is_finite() || way.is_nan() {
            return;
        }
        // Lengths of long vectors are infinite.
        let longest = direction.abs().max_element().max(1.0);
        let direction = (direction / longest).clamp_length_max(1.0);
        let mut left = way.clamp(0.0, LONGEST_WAY);
        while left > 0.0 {
            let step = left.min(LONGEST_STEP);
            left -= step;
            if !self.step(spine, direction * step) {
                return;
            }
        }
    }

    /// A step in distances to the surface. Not taken if it leads out of the world, deeper than the deepest level or above the ceiling.
    fn step(&mut self, spine: &mut Spine, step: DVec3) -> bool {
        let Distance { level, cells } = self.clearance;
        if cells >= CEILING && step.y > 0.0 {
            return false;
        }
        let place = moved(&self.place, self.clearance, step, spine.surface().roughness);
        match clearance(spine, &place, level) {
            Some(Clearance { distance, is_above: true }) if distance.level <= DEEPEST => {
                *self = Flight { place, clearance: distance };
                true
            }
            _ => false,
        }
    }

    /// The way out, straight up from the spot below, and where on it the flight is (to 2⁻¹⁶ of the distance). The surface is a function of x and z, so
    /// nothing is in the way, and what led out leads back in.
    pub fn way_out(&self, spine: &mut Spine) -> (Approach, Depth) {
        let level = self.clearance.level;
        let fine = level + TARGET_DIGITS;
        let ground = spine.patch(&self.place, fine).height(REACH as usize, REACH as usize);
        // Differences of wrapped heights are exact.
        let fall = ground.wrapping_sub(self.place.y.slice(fine + FRACTION_BITS) as i64);
        let mut target = self.place.clone();
        target.y.add(fall, fine + FRACTION_BITS);
        // Amplitudes of the level, and cells.
        let height = -fall as f64 / (AMPLITUDE << TARGET_DIGITS) as f64;
        let cells = height * spine.surface().roughness.cells();
        let offset = [0, (cells * 65_536.0).round() as i64, 0];
        (Approach { target, offset }, Depth::level(level))
    }

    /// How steep the ground below is, as large as it is far: radians.
    pub fn slope(&self, spine: &mut Spine) -> f64 {
        let patch = spine.patch(&self.place, self.clearance.level);
        let middle = REACH as usize;
        let height = |column: usize, row: usize| patch.height(column, row);
        // Amplitudes a cell.
        let rise = |to: i64, from: i64| to.wrapping_sub(from) as f64 / AMPLITUDE as f64;
        let [east, south] = [
            rise(height(middle + 1, middle), height(middle, middle)),
            rise(height(middle, middle + 1), height(middle, middle)),
        ];
        libm::atan(libm::hypot(east, south) * spine.surface().roughness.cells())
    }

    /// A direction that goes down is bent towards the gentlest slope nearby, so that a descent stays where the surface is not a cliff. `strength` 0 does nothing;
    /// 1 goes sideways as fast as down.
    pub fn assist(&self, spine: &mut Spine, direction: DVec3, strength: f64) -> DVec3 {
        let down = (-direction.y).max(0.0);
        direction + strength * down * self.gentlest(spine)
    }

    /// Towards the middle of the gentlest of the cells around, as large as the surface is far: at most as long as 1.
    fn gentlest(&self, spine: &mut Spine) -> DVec3 {
        let level = self.clearance.level;
        let eye = Eye::new(spine.surface(), &self.place, level);
        let patch = spine.patch(&self.place, level);
        let around = REACH as usize - AROUND..=REACH as usize + AROUND;
        let cells = around.clone().flat_map(|row| around.clone().map(move |column| (column, row)));
        let gentlest = cells.min_by_key(|(column, row)| {
            let (cell, corners) = (patch.cell(*column, *row), patch.corners(*column, *row));
            corners.steepness(cell)
        });
        let Some((column, row)) = gentlest else { return DVec3::ZERO };
        let cell = patch.cell(column, row);
        let [east, _, south] = eye.to(cell.x, 0, cell.z);
        DVec3::new(east + 0.5, 0.0, south + 0.5).clamp_length_max(1.0)
    }
}
