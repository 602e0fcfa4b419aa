//! Down for ever, to a spot where slopes stay bounded, and back on the same path.

use super::{Approach, Depth, approach::turn};
use crate::zoom::{
    address::{Attitude, Place},
    height::{FRACTION_BITS, Patch, Spine, Surface},
    tree::Eye,
};
use std::collections::{BTreeMap, VecDeque};

/// A place, and where it looks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pose {
    pub place: Place,
    pub attitude: Attitude,
}

/// Levels of the target beyond that of the view: it moves by less than 2⁻²⁰ of its distance when more of them are known.
const AHEAD: u32 = 24;

/// Levels in which the heading turns once.
const PERIOD: u64 = 40;

/// The place lies beside its target by this much, in 2⁻¹⁶ of the distance,
const BESIDE: i64 = 3 << 14;
/// and above it by at least this,
const ABOVE: i64 = 5 << 13;
/// and above all that the surface can be below by this.
const MARGIN: i64 = 1 << 14;

/// The view looks this much higher than at its target, 2⁻¹⁶ of a turn: to see the horizon, too.
const LIFT: i16 = 4000;

/// What the target is at one level, and a way to any other.
#[derive(Clone, Debug)]
struct Descent {
    surface: Surface,
    /// Where each segment begins: 0.8 bytes a level.
    starts: Vec<Patch>,
    /// The steps of one segment, and which one it is.
    steps: Vec<Step>,
    segment: usize,
    /// The target is the lower corner of a cell of this level.
    level: u32,
    target: Place,
}

/// Levels of a segment.
const SEGMENT: u32 = 256;

/// From the target of a level to that of the next, in units of the latter.
#[derive(Clone, Copy, Debug)]
struct Step {
    east: i64,
    rise: i64,
    south: i64,
}

impl Descent {
    fn new(surface: Surface) -> Descent {
        let start = Patch::start(&surface, -1, -1, 4);
        let mut target = Place::default();
        target.y.add(start.height(1, 1), FRACTION_BITS);
        Descent { surface, starts: vec![start], steps: Vec::new(), segment: 0, level: 0, target }
    }

    /// The target of a level.
    fn seek(&mut self, level: u32) -> &Place {
        while self.level < level {
            let step = self.step(self.level);
            self.level += 1;
            self.add(step);
        }
        while self.level > level {
            let Step { east, rise, south } = self.step(self.level - 1);
            self.add(Step { east: -east, rise: -rise, south: -south });
            self.level -= 1;
        }
        &self.target
    }

    fn add(&mut self, step: Step) {
        self.target.x.add(step.east, self.level);
        self.target.y.add(step.rise, self.level + FRACTION_BITS);
        self.target.z.add(step.south, self.level);
    }

    /// The step from a level.
    fn step(&mut self, level: u32) -> Step {
        let segment = (level / SEGMENT) as usize;
        if self.segment != segment || self.steps.is_empty() {
            // One segment after the other: the start of this one is known.
            let mut patch = self.starts[segment].clone();
            self.steps.clear();
            for _ in 0..SEGMENT {
                let (next, step) = gentlest(&self.surface, &patch);
                self.steps.push(step);
                patch = next;
            }
            self.segment = segment;
            if self.starts.len() == segment + 1 {
                self.starts.push(patch);
            }
        }
        self.steps[(level % SEGMENT) as usize]
    }
}

/// From a cell (the middle one of nine) to the gentlest of the sixteen of the next level that are its children or touch them. The steeper triangle of a
/// cell counts: by the mean of both, the way would follow creases whose sides get steeper and steeper. Gradients are a walk that branches at each level, so
/// there always is a branch that stays near 0.
fn gentlest(surface: &Surface, patch: &Patch) -> (Patch, Step) {
    let [x, z] = [patch.first.x, patch.first.z].map(|first| first.wrapping_mul(2));
    let fine = patch.refine(surface, x, z, 7).expect("seven vertices lie on four");
    let cells = (1..5).flat_map(|row| (1..5).map(move |column| (column, row)));
    let steepness =
        |(column, row): (usize, usize)| fine.corners(column, row).steepness(fine.cell(column, row));
    let (column, row) = cells.min_by_key(|cell| steepness(*cell)).expect("sixteen cells");
    let first = fine.cell(column - 1, row - 1);
    let next = fine.part(first.x, first.z, 4).expect("they have cells around");
    // The children of the middle cell begin at vertex 2.
    let step = Step {
        east: column as i64 - 2,
        rise: fine.height(column, row).wrapping_sub(patch.height(1, 1).wrapping_mul(2)),
        south: row as i64 - 2,
    };
    (next, step)
}

/// Flies down to a target for ever, around it slowly, and up again. Where it is at a depth depends on the surface and the depth alone, all of it by
/// whole numbers: the way back is the way in.
#[derive(Clone, Debug)]
pub struct Autopilot {
    descent: Descent,
    /// How far above the target the place must be in each octave of depth, in 2⁻¹⁶ of the distance: those that were asked for last.
    needs: BTreeMap<u32, i64>,
    asked: VecDeque<u32>,
}

/// Needs that are kept.
const KEPT: usize = 64;

/// Parts that an octave is looked at in.
const PARTS: u16 = 8;

impl Autopilot {
    pub fn new(surface: Surface) -> Autopilot {
        Autopilot { descent: Descent::new(surface), needs: BTreeMap::new(), asked: VecDeque::new() }
    }

    /// Where it is at a depth. The spine is one of its surface.
    pub fn at(&mut self, spine: &mut Spine, depth: Depth) -> Pose {
        let above = self.above(spine, depth);
        let place = self.place(depth, above);
        // Back to the target, and up a bit.
        let yaw = heading(depth).wrapping_add(1 << 15);
        let down = libm::atan2(above as f64, BESIDE as f64) / std::f64::consts::TAU * 65_536.0;
        let pitch = LIFT - libm::round(down) as i16;
        Pose { place, attitude: Attitude { yaw, pitch: pitch as u16, roll: 0 } }
    }

    /// Bytes of what is kept.
    pub fn bytes(&self) -> usize {
        let Descent { starts, steps, target, .. } = &self.descent;
        let start = size_of::<Patch>() + 16 * size_of::<i64>();
        let target = target.x.bytes() + target.y.bytes() + target.z.bytes();
        starts.capacity() * start + steps.capacity() * size_of::<Step>() + target
    }

    /// The spot that it flies to, as of a level: the lower corner of a cell.
    pub fn target(&mut self, level: u32) -> &Place {
        self.descent.seek(level)
    }

    fn place(&mut self, depth: Depth, above: i64) -> Place {
        let roughness = self.descent.surface.roughness;
        let [north, east] = turn(heading(depth)).map(|of| (of * BESIDE) >> 30);
        let target = self.descent.seek(depth.whole() + AHEAD).clone();
        Approach { target, offset: [east, above, -north] }.at(depth, roughness)
    }

    /// How far above its target the place is, in 2⁻¹⁶ of the distance. As much as each octave around needs, and smoothly from one to the next.
    fn above(&mut self, spine: &mut Spine, depth: Depth) -> i64 {
        let level = depth.whole();
        let [before, own, next, after] =
            [level.saturating_sub(1), level, level + 1, level + 2].map(|level| self.need(spine, level));
        let (from, to) = (before.max(own).max(next), own.max(next).max(after));
        // Smoothstep.
        let part = i64::from(depth.part());
        let share = (part * part * (3 * 65_536 - 2 * part)) >> 32;
        from + (((to - from) * share) >> 16)
    }

    fn need(&mut self, spine: &mut Spine, level: u32) -> i64 {
        if let Some(need) = self.needs.get(&level) {
            return *need;
        }
        let steps =
            (0..PARTS).map(|part| Depth(Depth::level(level).0 + u64::from(part) * 65_536 / u64::from(PARTS)));
        let need = steps.map(|depth| self.need_at(spine, depth)).max().unwrap_or(ABOVE);
        self.needs.insert(level, need);
        self.asked.push_back(level);
        if self.asked.len() > KEPT
            && let Some(oldest) = self.asked.pop_front()
        {
            self.needs.remove(&oldest);
        }
        need
    }

    /// What is needed from a depth to the next part of an octave: the highest that the surface can be in the cells around, an eighth of the distance
    /// large, and then some.
    fn need_at(&mut self, spine: &mut Spine, depth: Depth) -> i64 {
        let level = depth.whole() + 3;
        let surface = self.descent.surface;
        let target = self.descent.seek(depth.whole() + AHEAD).clone();
        let place = self.place(depth, 0);
        let [from_target, eye] = [&target, &place].map(|place| Eye::new(&surface, place, level));
        let patch = spine.patch(&place, level);
        // In the next eighth of an octave the place moves by less than a cell: 8 cells · ¾ · (1 − 2^(−1/8) + τ / 8 / 40) = 0.62.
        let mut highest = f64::NEG_INFINITY;
        for row in 0..patch.size - 1 {
            for column in 0..patch.size - 1 {
                let cell = patch.cell(column, row);
                let corners = patch.corners(column, row);
                let [[west, _, north], [east, _, south]] = eye.bounds(cell.x, cell.z, corners);
                if west < 1.0 && east > -1.0 && north < 1.0 && south > -1.0 {
                    let [_, [_, high, _]] = from_target.bounds(cell.x, cell.z, corners);
                    highest = highest.max(high);
                }
            }
        }
        // In distances as they are at the end of the part: 8 cells · 2^−(part + 1/8).
        let shrinks = libm::exp2((f64::from(depth.part()) + 65_536.0 / f64::from(PARTS)) / 65_536.0);
        let rise = (highest.max(0.0) / 8.0 * shrinks * 65_536.0).min(1e12) as i64;
        (rise + MARGIN).max(ABOVE)
    }
}

/// Where the place lies from its target, in 2⁻¹⁶ of a turn from north.
fn heading(depth: Depth) -> u16 {
    (depth.0 / PERIOD) as u16
}
