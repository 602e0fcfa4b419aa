//! How far the surface is.

use crate::zoom::{
    address::{Cell, Place},
    height::{AMPLITUDE, Corners, Patch, REACH, Spine, Surface},
    tree::Eye,
};
use std::{cmp::Reverse, collections::BinaryHeap};

/// A length at any depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// The first level whose cells are not longer; 0 for all that is longer than a cell of level 0.
    pub level: u32,
    /// The length in cells of that level: 1 to 2, at level 0 more.
    pub cells: f64,
}

/// Where the surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Nothing of the surface is nearer, whatever octaves are to come.
    pub distance: Distance,
    /// The place is above the surface, and not below.
    pub is_above: bool,
}

impl Distance {
    /// A length of more than 0 cells of a level.
    pub fn new(mut cells: f64, mut level: u32) -> Distance {
        while cells < 1.0 {
            (cells, level) = (cells * 2.0, level + 1);
        }
        while cells >= 2.0 && level > 0 {
            (cells, level) = (cells / 2.0, level - 1);
        }
        Distance { level, cells }
    }

    /// −log₂ of the length in cells of level 0.
    pub fn depth(self) -> f64 {
        f64::from(self.level) - libm::log2(self.cells)
    }
}

/// The distance may be less than it is by this share.
const SLACK: f64 = 1.0 / 16.0;

/// Levels below the first that boxes are halved. The nearest box is then so small that its distance is far beyond the digits of a double.
const MOST_HALVINGS: u32 = 60;

/// Boxes that are looked at before the answer is taken as it is: a bound still, but not as near.
const MOST_BOXES: usize = 100_000;

/// How far the surface is from a place, at most 1/16 too little. The answer depends on the place alone; a `hint` near its level (that of
/// the last frame, or of a location code) makes it come sooner. `None` if the place is on the surface as far as its digits tell.
///
/// Boxes of a finer level lie in those of the coarser one, and all that is off a level's patch is more than [`REACH`] cells away. So if a patch
/// has nothing within its reach, finer ones have not either: there is one finest level that has, and the nearest box of
/// it leads to the surface, by halving the nearest of all boxes until the surface in it is known well enough.
pub fn clearance(spine: &mut Spine, place: &Place, hint: u32) -> Option<Clearance> {
    let surface = *spine.surface();
    let limit = place.digits() + 64;
    // A patch reaches seven cells: its level is two or three beyond that of the distance.
    let first = hint.saturating_add(2).min(limit);
    let Some(level) = last(first, limit, |level| nearest(spine, place, level) <= reach()) else {
        return Some(from_afar(&surface, place, nearest(spine, place, 0).sqrt()));
    };
    if level == limit {
        return None;
    }
    let patch = spine.patch(place, level);
    let cells = search(&surface, place, patch)?.min(REACH as f64);
    let is_above = side(&surface, place, patch)?;
    Some(Clearance { distance: Distance::new(cells, level), is_above })
}

/// The last level up to a limit that is one of `those`, as all levels before it are. Steps away from the first that is looked at double, then halve, since a
/// hint may be far off. `None` if not even level 0 is one.
fn last(first: u32, limit: u32, mut those: impl FnMut(u32) -> bool) -> Option<u32> {
    let (mut is, mut is_not) = (first, first);
    let mut step = 1u32;
    if those(first) {
        loop {
            if is == limit {
                return Some(limit);
            }
            is_not = is.saturating_add(step).min(limit);
            if !those(is_not) {
                break;
            }
            (is, step) = (is_not, step.saturating_mul(2));
        }
    } else {
        loop {
            if is_not == 0 {
                return None;
            }
            is = is_not.saturating_sub(step);
            if those(is) {
                break;
            }
            (is_not, step) = (is, step.saturating_mul(2));
        }
    }
    while is_not - is > 1 {
        let middle = is.midpoint(is_not);
        if those(middle) { is = middle } else { is_not = middle }
    }
    Some(is)
}

/// Square of [`REACH`].
fn reach() -> f64 {
    (REACH * REACH) as f64
}

/// The square of the distance to the nearest box on a patch, cells².
fn nearest(spine: &mut Spine, place: &Place, level: u32) -> f64 {
    let eye = Eye::new(spine.surface(), place, level);
    let patch = spine.patch(place, level);
    let boxes = cells(patch).map(|(cell, corners)| eye.square_to(cell.x, cell.z, corners));
    boxes.fold(f64::INFINITY, f64::min)
}

fn cells(patch: &Patch) -> impl Iterator<Item = (Cell, Corners)> + '_ {
    let side = 0..patch.size - 1;
    let row =
        move |row| side.clone().map(move |column| (patch.cell(column, row), patch.corners(column, row)));
    (0..patch.size - 1).flat_map(row)
}

/// Above everything: all octaves together sum to two amplitudes of the first. `on_patch` is how far the boxes below are.
fn from_afar(surface: &Surface, place: &Place, on_patch: f64) -> Clearance {
    let eye = Eye::new(surface, place, 0);
    let [_, to_top, _] = eye.to(0, 2 * AMPLITUDE, 0);
    let [_, to_bottom, _] = eye.to(0, -2 * AMPLITUDE, 0);
    let vertical = (-to_top).max(to_bottom);
    let cells = on_patch.min(vertical.max(REACH as f64));
    Clearance { distance: Distance::new(cells, 0), is_above: to_top < 0.0 }
}

/// A box, first that which is nearest. Distances are not negative, and then order as their bits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    square: u64,
    depth: u32,
    cell: Cell,
    corners: Corners,
}

/// Halves the nearest box until the surface is not much farther than it, cells of the patch.
fn search(surface: &Surface, place: &Place, patch: &Patch) -> Option<f64> {
    let eyes: Vec<Eye> =
        (0..=MOST_HALVINGS).map(|depth| Eye::new(surface, place, patch.level() + depth)).collect();
    let mut nearest_known = f64::INFINITY;
    let mut boxes = BinaryHeap::new();
    let mut look_at = |boxes: &mut BinaryHeap<_>, depth: u32, cell: Cell, corners: Corners| {
        let eye = &eyes[depth as usize];
        let scale = 0.25f64.powi(depth as i32);
        nearest_known = nearest_known.min(farthest(eye, cell, corners) * scale);
        let square = (eye.square_to(cell.x, cell.z, corners) * scale).to_bits();
        boxes.push(Reverse(Candidate { square, depth, cell, corners }));
        nearest_known
    };
    cells(patch).for_each(|(cell, corners)| {
        look_at(&mut boxes, 0, cell, corners);
    });
    let mut known = f64::INFINITY;
    for count in 0.. {
        let Reverse(Candidate { square, depth, cell, corners }) = boxes.pop()?;
        let square = f64::from_bits(square);
        let is_near_enough = known <= square * ((1.0 + SLACK) * (1.0 + SLACK));
        if is_near_enough || (square > 0.0 && (count > MOST_BOXES || depth == MOST_HALVINGS)) {
            return Some(square.sqrt());
        }
        if depth == MOST_HALVINGS {
            return None;
        }
        let children = corners.children(surface, cell);
        for (quarter, corners) in (0..).zip(children) {
            known = look_at(&mut boxes, depth + 1, cell.child([quarter % 2, quarter / 2]), corners);
        }
    }
    None
}

/// The square of a distance within which there is some of the surface of a cell: its corners move by an amplitude at most.
fn farthest(eye: &Eye, cell: Cell, corners: Corners) -> f64 {
    let square = |(index, height): (u64, i64)| {
        let [x, z] = [cell.x.wrapping_add(index % 2), cell.z.wrapping_add(index / 2)];
        let [east, low, south] = eye.to(x, height.wrapping_sub(AMPLITUDE), z);
        let [_, high, _] = eye.to(x, height.wrapping_add(AMPLITUDE), z);
        let vertical = high.max(-low);
        east * east + vertical * vertical + south * south
    };
    (0..).zip(corners.0).map(square).fold(f64::INFINITY, f64::min)
}

/// Whether a place is above the surface: halves the cell below it until the place is out of the box.
fn side(surface: &Surface, place: &Place, patch: &Patch) -> Option<bool> {
    let middle = REACH as usize;
    let (mut cell, mut corners) = (patch.cell(middle, middle), patch.corners(middle, middle));
    for _ in 0..MOST_HALVINGS {
        let [[_, low, _], [_, high, _]] =
            Eye::new(surface, place, cell.level).bounds(cell.x, cell.z, corners);
        if high < 0.0 || low > 0.0 {
            return Some(high < 0.0);
        }
        let next = place.cell(cell.level + 1);
        let quarter = (next.x & 1) + 2 * (next.z & 1);
        corners = corners.children(surface, cell)[quarter as usize];
        cell = next;
    }
    None
}
