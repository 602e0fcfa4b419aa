//! Tiles on the device: a pool of slots, filled from coarse to fine, each tile from the one it is a quarter of.
//!
//! A tile is a pure function of the surface and its cell: which ones are kept, and what they are made from, decides nothing but time.

use super::{
    address::{Cell, Place},
    height::{Corners, Refinement, Shaded, Spine, Surface, Tile, base},
};
use crate::{
    gpu::{self, Buffer, Compute, Gpu, Recorder},
    shaders::{
        TileJob,
        zoom::height::{Bindings, Constants, Shader},
    },
};
use std::collections::{BTreeMap, HashMap};

/// Tiles that are made by one upload of jobs.
const JOBS: usize = 256;

/// Tiles that one upload has the vertices of.
const SEEDS: usize = 4;

/// Levels above a tile that missing ancestors are made for. What has none there is made by the CPU at the last of them.
const ANCESTORS: u32 = 4;

/// Vertices of a tile, with the ring.
fn vertices(bits: u32) -> usize {
    ((1 << bits) + 3usize).pow(2)
}

/// Tiles and where they are.
pub struct Tiles {
    surface: Surface,
    /// log₂ of the quads along a side.
    bits: u32,
    pass: Compute<Shader>,
    heights: Buffer<i32>,
    /// To the east and to the south. Two buffers, so that none is longer than that of heights: devices need not read more than 128 MiB as one.
    gradients: [Buffer<i32>; 2],
    seeds: Buffer<i32>,
    jobs: Buffer<TileJob>,
    slots: HashMap<Cell, Slot>,
    free: Vec<u32>,
    /// Counts calls: what was used when.
    call: u64,
}

/// Where a tile is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Heights and gradients begin at this times (N + 3)².
    pub index: u32,
    /// What they are differences to, modulo 2⁶⁴.
    pub base: i64,
    used: u64,
}

/// Heights of a tile, read from the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heights {
    pub cell: Cell,
    /// What they are differences to, modulo 2⁶⁴.
    pub base: i64,
    /// N + 3 rows of N + 3, the first of both one step outside.
    pub differences: Vec<i32>,
}

/// What a call of [`Tiles::make`] has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Made {
    /// Tiles that are new, those that others are made from too.
    pub tiles: usize,
    /// Those that were wanted and are not there: the budget or the slots were too few.
    pub waiting: usize,
}

/// What is to be made in one call.
#[derive(Default)]
struct Plan {
    /// By level, since a tile needs its parent.
    jobs: BTreeMap<u32, Vec<TileJob>>,
    /// Tiles that have no parent.
    seeds: Vec<Tile>,
    count: usize,
}

impl Tiles {
    /// Bytes of a slot: a height and a gradient for each vertex.
    pub fn slot_bytes(bits: u32) -> u64 {
        vertices(bits) as u64 * 3 * size_of::<i32>() as u64
    }

    /// A pool of `slots` tiles of 2^`bits` quads along a side.
    ///
    /// # Errors
    /// If the device has no room for so many.
    pub fn new(gpu: &Gpu, surface: Surface, bits: u32, slots: u32) -> gpu::Result<Tiles> {
        let pool = |name| Buffer::new(gpu, name, vertices(bits) * slots as usize);
        let constants = Constants { bits, bilinear: surface.refinement == Refinement::Bilinear };
        Ok(Tiles {
            surface,
            bits,
            pass: Compute::new(gpu, constants)?,
            heights: pool("tile heights")?,
            gradients: [pool("tile gradients east")?, pool("tile gradients south")?],
            seeds: Buffer::new(gpu, "tile seeds", 3 * vertices(bits) * SEEDS)?,
            jobs: Buffer::new(gpu, "tile jobs", JOBS)?,
            slots: HashMap::new(),
            free: (0..slots).rev().collect(),
            call: 0,
        })
    }

    /// How many tiles there is room for.
    pub fn capacity(&self) -> u32 {
        (self.heights.len() / vertices(self.bits)) as u32
    }

    /// Heights of all slots: (N + 3)² each, rows of x, as [`Tile`] has them.
    pub fn heights(&self) -> &Buffer<i32> {
        &self.heights
    }

    /// What all slots are shaded by, rises to the east and to the south, as heights are.
    pub fn gradients(&self) -> [&Buffer<i32>; 2] {
        self.gradients.each_ref()
    }

    /// Where a tile is, if it is there.
    pub fn slot(&self, cell: Cell) -> Option<Slot> {
        self.slots.get(&cell).copied()
    }

    /// The heights of tiles, of those that are there.
    ///
    /// # Errors
    /// No memory; a lost device.
    pub fn read(&self, gpu: &Gpu, cells: impl IntoIterator<Item = Cell>) -> gpu::Result<Vec<Heights>> {
        let mut rec = Recorder::new(gpu);
        let download = rec.download(&self.heights);
        let all = download.take(&rec.submit()?.wait()?);
        let of = |cell: Cell| {
            let Slot { index, base, .. } = self.slot(cell)?;
            let count = vertices(self.bits);
            let differences = all.get(index as usize * count..)?.get(..count)?.to_vec();
            Some(Heights { cell, base, differences })
        };
        Ok(cells.into_iter().filter_map(of).collect())
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.free.extend(self.slots.drain().map(|(_, slot)| slot.index));
        self.free.sort_unstable_by(|a, b| b.cmp(a));
    }

    /// Records how the wanted tiles (from coarse to fine) are made that are not there, at most `budget` of them. What was wanted least recently goes.
    /// The place is one that they lie around.
    pub fn make(
        &mut self,
        rec: &mut Recorder,
        spine: &mut Spine,
        place: &Place,
        wanted: impl IntoIterator<Item = (Cell, Corners)>,
        budget: usize,
    ) -> Made {
        self.call += 1;
        self.make_also(rec, spine, place, wanted, budget)
    }

    /// The same, without anything going that the last call has wanted.
    pub fn make_also(
        &mut self,
        rec: &mut Recorder,
        spine: &mut Spine,
        place: &Place,
        wanted: impl IntoIterator<Item = (Cell, Corners)>,
        budget: usize,
    ) -> Made {
        let wanted: Vec<_> = wanted.into_iter().filter(|(cell, _)| !self.touch(*cell)).collect();
        let mut plan = Plan::default();
        let mut old = None;
        let mut waiting = 0;
        for (cell, corners) in wanted {
            let known = self.touch(cell);
            if !known && self.add(&mut plan, &mut old, spine, place, (cell, corners, 0), budget).is_none() {
                waiting += 1;
            }
        }
        let made = Made { tiles: plan.count, waiting };
        self.record(rec, plan);
        made
    }

    /// Says that a tile is needed now; whether it is there.
    fn touch(&mut self, cell: Cell) -> bool {
        let call = self.call;
        self.slots.get_mut(&cell).map(|slot| slot.used = call).is_some()
    }

    /// Plans a tile that is not there, and what it needs. `None` if the budget or the slots don't suffice.
    fn add(
        &mut self,
        plan: &mut Plan,
        old: &mut Option<Vec<Cell>>,
        spine: &mut Spine,
        place: &Place,
        (cell, corners, below): (Cell, Corners, u32),
        budget: usize,
    ) -> Option<()> {
        let parent = place.parent(cell).filter(|_| below < ANCESTORS);
        if let Some(parent) = parent
            && !self.touch(parent)
        {
            // Ancestors of what is on a patch are on those of coarser levels. If one is not, the tile has no parent.
            let patch = spine.patch(place, parent.level);
            if let Some([column, row]) = patch.find(parent) {
                let corners = patch.corners(column, row);
                self.add(plan, old, spine, place, (parent, corners, below + 1), budget)?;
            }
        }
        if plan.count >= budget {
            return None;
        }
        let parent = parent.and_then(|parent| Some((parent, self.slot(parent)?)));
        let seed = match parent {
            Some(_) => None,
            None => Some(self.seed(spine, place, cell)?),
        };
        let index = self.take_slot(old)?;
        let base = base(corners, self.bits);
        let first = |coordinate: u64| {
            let first = (coordinate << self.bits).wrapping_sub(1);
            [first as u32, (first >> 32) as u32]
        };
        let (source, shift) = match parent {
            Some((_, slot)) => (slot.index, base.wrapping_sub(slot.base.wrapping_mul(2)) as i32),
            None => (plan.seeds.len() as u32, 0),
        };
        plan.jobs.entry(cell.level).or_default().push(TileJob {
            slot: index,
            source,
            seeded: seed.is_some().into(),
            key: self.surface.octave(cell.level + self.bits).key(),
            quarter: [cell.x, cell.z].map(|coordinate| (coordinate & 1) as u32),
            x: first(cell.x),
            z: first(cell.z),
            shift,
        });
        plan.seeds.extend(seed);
        plan.count += 1;
        self.slots.insert(cell, Slot { index, base, used: self.call });
        Some(())
    }

    /// A tile without its parent. Those of level 0 come from nothing, others from a patch, which has them if they are not at its edge.
    fn seed(&self, spine: &mut Spine, place: &Place, cell: Cell) -> Option<Tile> {
        let start;
        let patch = if cell.level == 0 {
            let [x, z] = [cell.x, cell.z].map(|first| (first as i64).wrapping_sub(1));
            start = Shaded::start(&self.surface, x, z, 4);
            &start
        } else {
            spine.shaded(place, cell.level)
        };
        Tile::from_patch(&self.surface, patch, cell, self.bits)
    }

    /// A slot that is free, or that of the tile that was not needed for longest.
    fn take_slot(&mut self, old: &mut Option<Vec<Cell>>) -> Option<u32> {
        if let Some(index) = self.free.pop() {
            return Some(index);
        }
        let old = old.get_or_insert_with(|| {
            let unused = self.slots.iter().filter(|(_, slot)| slot.used < self.call);
            let mut unused: Vec<(u64, Cell)> = unused.map(|(cell, slot)| (slot.used, *cell)).collect();
            unused.sort_unstable_by(|a, b| b.cmp(a));
            unused.into_iter().map(|(_, cell)| cell).collect()
        });
        // Some of these may have been needed since.
        while let Some(cell) = old.pop() {
            if self.slots.get(&cell).is_some_and(|slot| slot.used < self.call) {
                return self.slots.remove(&cell).map(|slot| slot.index);
            }
        }
        None
    }

    /// One level after the other.
    fn record(&self, rec: &mut Recorder, plan: Plan) {
        for jobs in plan.jobs.into_values() {
            let (seeded, others): (Vec<_>, Vec<_>) = jobs.into_iter().partition(|job| job.seeded == 1);
            for batch in seeded.chunks(SEEDS) {
                let mut values = Vec::with_capacity(self.seeds.len());
                let mut batch = batch.to_vec();
                for (source, job) in (0..).zip(&mut batch) {
                    let seed = &plan.seeds[job.source as usize];
                    values.extend(seed.heights());
                    for axis in 0..2 {
                        values.extend(seed.gradients().iter().map(|gradient| gradient[axis]));
                    }
                    job.source = source;
                }
                values.resize(self.seeds.len(), 0);
                rec.upload(&self.seeds, &values);
                self.dispatch(rec, &batch);
            }
            others.chunks(JOBS).for_each(|batch| self.dispatch(rec, batch));
        }
    }

    fn dispatch(&self, rec: &mut Recorder, batch: &[TileJob]) {
        let mut jobs = batch.to_vec();
        jobs.resize(JOBS, TileJob::default());
        rec.upload(&self.jobs, &jobs);
        let [east, south] = self.gradients();
        let bindings = Bindings { heights: &self.heights, east, south, seeds: &self.seeds, jobs: &self.jobs };
        let work = [vertices(self.bits) as u32, batch.len() as u32];
        rec.dispatch(&self.pass, work, (), bindings);
    }
}
