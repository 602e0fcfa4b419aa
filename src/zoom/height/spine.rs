//! Heights around a place at every level: what tiles, distances and flights start from.

use super::{FRACTION_BITS, Patch, Shaded, Surface};
use crate::zoom::address::{Fixed, Place};
use std::collections::VecDeque;

/// Vertices along a side of a patch.
const SIZE: usize = 16;

/// Vertices in a patch below the one that the place's cell begins with: the place is in the middle cell, and everything nearer than this many
/// cells is on the patch.
pub const REACH: u64 = 7;

/// The least patch that a patch of [`SIZE`] can be refined from, wherever in its middle cell the place is, and also in the cells beside that: a place
/// that crosses a cell wall finds its checkpoints useful still.
const CHECKPOINT_SIZE: usize = 12;
const CHECKPOINT_REACH: u64 = 5;

/// Levels from one checkpoint to the next: 1.6 bytes a level.
const STRIDE: u32 = 1536;

/// Levels that are kept as whole patches, the deepest ones: 4 KB each.
const KEPT: usize = 640;

/// The patches around a place. They depend on the place and the surface alone; which of them are kept only decides how soon they are there.
#[derive(Clone, Debug)]
pub struct Spine {
    surface: Surface,
    /// Patches of consecutive levels. Each is right for some place that was asked for, not necessarily the last one.
    patches: VecDeque<Shaded>,
    /// Patches of the levels `STRIDE`, 2 `STRIDE`, and so on.
    checkpoints: Vec<Shaded>,
}

/// The level from whose successor on all patches are kept, when those up to a level are made anew.
fn kept_from(level: u32) -> u32 {
    level.saturating_sub(KEPT as u32 / 2)
}

/// Where the patch of a level begins, for a place.
fn first(place: &Place, level: u32, reach: u64) -> [u64; 2] {
    [&place.x, &place.z].map(|number| number.slice(level).wrapping_sub(reach))
}

impl Spine {
    pub fn new(surface: Surface) -> Spine {
        Spine { surface, patches: VecDeque::new(), checkpoints: Vec::new() }
    }

    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Bytes of what is kept.
    pub fn bytes(&self) -> usize {
        let patches = self.patches.iter().chain(&self.checkpoints);
        patches.map(Shaded::bytes).sum()
    }

    /// The patch of a level whose middle cell (the one [`REACH`] from the first) is the place's.
    pub fn patch(&mut self, place: &Place, level: u32) -> &Patch {
        self.shaded(place, level).patch()
    }

    /// The same with what it is shaded by.
    pub fn shaded(&mut self, place: &Place, level: u32) -> &Shaded {
        match self.last_useful(place, level) {
            Some(start) => {
                for level in self.patches[start].patch().level() + 1..=level {
                    self.extend(place, level);
                }
            }
            None => self.restart(place, level),
        }
        &self.patches[(level - self.first_level()) as usize]
    }

    /// The height of the lower corner of the place's cell of a level, without wrapping, in amplitudes of octave 0. Takes the sum over all levels.
    pub fn ground(&mut self, place: &Place, level: u32) -> Fixed {
        let mut ground = Fixed::default();
        let mut last = 0i64;
        for level in 0..=level {
            let height = self.patch(place, level).height(REACH as usize, REACH as usize);
            // Differences of wrapped heights are exact, sums of them too.
            ground.add(height.wrapping_sub(last.wrapping_mul(2)), level + FRACTION_BITS);
            last = height;
        }
        ground
    }

    /// The level of the first patch that is kept.
    fn first_level(&self) -> u32 {
        self.patches.front().map_or(0, |front| front.patch().level())
    }

    /// Which kept patch is the one of this level, or else the last before that the next one can be made from.
    fn last_useful(&self, place: &Place, level: u32) -> Option<usize> {
        let index = level.checked_sub(self.first_level())? as usize;
        let fits = |kept: &Shaded| kept.patch().cell(REACH as usize, REACH as usize) == place.cell(level);
        if self.patches.get(index).is_some_and(fits) {
            return Some(index);
        }
        let before = index.min(self.patches.len());
        // From far away it is sooner there by checkpoints.
        if index - before > KEPT {
            return None;
        }
        (0..before).rev().find(|before| serves(self.patches[*before].patch(), place))
    }

    /// Makes the patch of a level from the one before, which is kept and serves. It then serves, too, its middle being the place's.
    fn extend(&mut self, place: &Place, level: u32) {
        let index = (level - self.first_level()) as usize;
        let [x, z] = first(place, level, REACH);
        let before = &self.patches[index - 1];
        let patch = before.refine(&self.surface, x, z, SIZE).expect("the patch before serves");
        self.keep_checkpoint(place, &patch);
        match self.patches.get_mut(index) {
            Some(kept) => *kept = patch,
            None => self.patches.push_back(patch),
        }
        if self.patches.len() > KEPT {
            self.patches.pop_front();
        }
    }

    /// Comes nearer to a level by as much as takes a few thousandths of a second, for callers that have to look at other things in between. Whether what is
    /// left is no more than that.
    pub fn approach(&mut self, place: &Place, level: u32) -> bool {
        let kept = kept_from(level);
        if self.last_useful(place, level).is_some() {
            return true;
        }
        let start = self.checkpoint(place, kept);
        let next = start.as_ref().map_or(0, |start| start.patch().level()) + STRIDE;
        if next > kept {
            return true;
        }
        self.narrow(place, start, next);
        false
    }

    /// The last checkpoint of a level or before that serves.
    fn checkpoint(&self, place: &Place, level: u32) -> Option<Shaded> {
        let passed = ((level / STRIDE) as usize).min(self.checkpoints.len());
        self.checkpoints[..passed].iter().rfind(|kept| serves(kept.patch(), place)).cloned()
    }

    /// From a checkpoint, or from level 0, to the least patch of a level that the next one can be made from.
    fn narrow(&mut self, place: &Place, start: Option<Shaded>, level: u32) -> Shaded {
        let mut patch = start.unwrap_or_else(|| {
            let [x, z] = first(place, 0, CHECKPOINT_REACH).map(|first| first as i64);
            Shaded::start(&self.surface, x, z, CHECKPOINT_SIZE)
        });
        for level in patch.patch().level() + 1..=level {
            let [x, z] = first(place, level, CHECKPOINT_REACH);
            patch = patch.refine(&self.surface, x, z, CHECKPOINT_SIZE).expect("checkpoints serve");
            self.keep_checkpoint(place, &patch);
        }
        patch
    }

    /// Comes from the last checkpoint that serves, or from level 0.
    fn restart(&mut self, place: &Place, level: u32) {
        self.patches.clear();
        let kept = kept_from(level);
        let patch = if kept == 0 {
            let [x, z] = first(place, 0, REACH).map(|first| first as i64);
            Shaded::start(&self.surface, x, z, SIZE)
        } else {
            let narrow = self.narrow(place, self.checkpoint(place, kept), kept);
            let [x, z] = first(place, kept + 1, REACH);
            let patch = narrow.refine(&self.surface, x, z, SIZE).expect("checkpoints serve");
            self.keep_checkpoint(place, &patch);
            patch
        };
        self.patches.push_back(patch);
        for level in self.first_level() + 1..=level {
            self.extend(place, level);
        }
    }

    /// Keeps the middle of a patch if its level has a checkpoint. Those before are there, or were passed just now.
    fn keep_checkpoint(&mut self, place: &Place, patch: &Shaded) {
        let level = patch.patch().level();
        if level == 0 || !level.is_multiple_of(STRIDE) {
            return;
        }
        let [x, z] = first(place, level, CHECKPOINT_REACH);
        let Some(middle) = patch.part(x, z, CHECKPOINT_SIZE) else { return };
        let index = (level / STRIDE) as usize - 1;
        if index < self.checkpoints.len() {
            self.checkpoints[index] = middle;
        } else {
            self.checkpoints.push(middle);
        }
    }
}

/// Whether the next level's patch around a place can be made from this one, with all its vertices.
fn serves(patch: &Patch, place: &Place) -> bool {
    let Some([column, row]) = patch.find(place.cell(patch.level())) else { return false };
    let next = [&place.x, &place.z].map(|number| (number.slice(patch.level() + 1) & 1) as usize);
    let is_inside = |middle: usize, half: usize| {
        let first = (2 * middle + half).checked_sub(REACH as usize);
        // Not from its outermost vertices, which have no gradients.
        first.is_some_and(|first| first > 0 && first + SIZE < 2 * patch.size - 1)
    };
    is_inside(column, next[0]) && is_inside(row, next[1])
}
