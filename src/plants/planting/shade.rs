//! Plants that shade each other out: a smaller one dies within the reach of a larger one (Deussen et al. 1998, "Realistic
//! modeling and rendering of plant ecosystems", section 4: circles of competition).

use glam::Vec2;

/// A plant as others feel it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    pub center: Vec2,
    /// Of the crown, metres.
    pub crown: f32,
    /// Of the foot, metres.
    pub foot: f32,
}

/// How a place is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    Open,
    /// Under a crown.
    Shaded,
    /// Where a trunk stands.
    Taken,
}

/// Circles in the cells of a grid, so that those round a place are found at once.
pub struct Crowns {
    /// Side of a cell, metres: no circle reaches further than the next one.
    side: f32,
    half: f32,
    /// Cells along a side.
    count: usize,
    /// Where the circles of each cell begin; one more behind the last.
    starts: Vec<u32>,
    circles: Vec<Circle>,
    /// Which of those given they are.
    indices: Vec<u32>,
}

/// Most cells along a side.
const FINEST: f32 = 2048.0;

impl Crowns {
    /// Of plants in the square `±half`.
    pub fn new(half: f32, all: &[Circle]) -> Crowns {
        let largest = all.iter().map(|circle| circle.crown.max(2.0 * circle.foot)).fold(0.0, f32::max);
        let side = largest.max(2.0 * half / FINEST).max(f32::MIN_POSITIVE);
        let count = (2.0 * half / side) as usize + 1;
        let mut crowns = Crowns {
            side,
            half,
            count,
            starts: vec![0; count * count + 1],
            circles: Vec::new(),
            indices: Vec::new(),
        };
        let mut cells: Vec<(u32, u32)> =
            (0..).zip(all).map(|(index, circle)| (crowns.index(circle.center), index)).collect();
        cells.sort_unstable();
        for (cell, _) in &cells {
            crowns.starts[*cell as usize + 1] += 1;
        }
        for cell in 0..count * count {
            crowns.starts[cell + 1] += crowns.starts[cell];
        }
        crowns.circles = cells.iter().map(|(_, index)| all[*index as usize]).collect();
        crowns.indices = cells.into_iter().map(|(_, index)| index).collect();
        crowns
    }

    /// How the place is lit for a plant with such a foot.
    pub fn place(&self, at: Vec2, foot: f32) -> Place {
        self.around(at).map(|(_, circle)| circle.place(at, foot)).max().unwrap_or(Place::Open)
    }

    /// The circles in the cells round a place, each with its index.
    fn around(&self, at: Vec2) -> impl Iterator<Item = (usize, &Circle)> + '_ {
        let [column, row] = self.cell(at);
        let last = self.count - 1;
        (row.saturating_sub(1)..=(row + 1).min(last)).flat_map(move |row| {
            let start = row * self.count;
            let first = self.starts[start + column.saturating_sub(1)] as usize;
            let end = self.starts[start + (column + 1).min(last) + 1] as usize;
            (first..end).map(|at| (self.indices[at] as usize, &self.circles[at]))
        })
    }

    fn cell(&self, at: Vec2) -> [usize; 2] {
        ((at + self.half) / self.side).to_array().map(|cell| (cell.max(0.0) as usize).min(self.count - 1))
    }

    fn index(&self, at: Vec2) -> u32 {
        let [column, row] = self.cell(at);
        (row * self.count + column) as u32
    }
}

impl Circle {
    fn place(&self, at: Vec2, foot: f32) -> Place {
        let square = self.center.distance_squared(at);
        if square < (self.foot + foot.min(self.foot)).powi(2) {
            Place::Taken
        } else if square < self.crown.powi(2) {
            Place::Shaded
        } else {
            Place::Open
        }
    }
}

/// Which of these plants of a kind live on: from the largest to the smallest, each that stands under no larger one that
/// lives, or that `survives` all the same, by its index. Of two that are alike the first wins.
pub fn thin(half: f32, all: &[Circle], survives: impl Fn(usize) -> bool) -> Vec<bool> {
    let crowns = Crowns::new(half, all);
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|a, b| all[*b].crown.total_cmp(&all[*a].crown).then(a.cmp(b)));
    let mut lives = vec![false; all.len()];
    for index in order {
        let Circle { center, foot, .. } = all[index];
        // Only larger ones have been decided on.
        let living = crowns.around(center).filter(|(other, _)| lives[*other]);
        lives[index] = match living.map(|(_, circle)| circle.place(center, foot)).max() {
            None | Some(Place::Open) => true,
            Some(Place::Shaded) => survives(index),
            Some(Place::Taken) => false,
        };
    }
    lives
}
