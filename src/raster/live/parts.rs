//! Samples by what they see: twin of `glsl/lib/parts.glsl`.

use crate::gpu::{
    self, Buffer, Compute, ComputeInterface, Gpu, Image, Recorder,
    format::{R32f, R32ui},
};
use crate::shaders::{Frame, raster::sort};
use std::ops::Range;

/// Kinds of things that have a program of their own: clear sky, sky with clouds, sea, ground.
pub const PARTS: u32 = 4;
/// Side of the square tiles that samples are sorted in, which are workgroups of those programs.
pub const TILE: u32 = 8;
/// Tiles of a kind that are dispatched at once: every device takes as many workgroups.
const MOST_TILES: u32 = 32_768;

/// A program for each kind, under one sky.
pub struct Programs<S: ComputeInterface> {
    sky: u32,
    parts: Vec<Compute<S>>,
}

impl<S: ComputeInterface> Programs<S> {
    /// `constants` are those of a kind.
    pub fn new(gpu: &Gpu, sky: u32, constants: impl Fn(u32) -> S::Constants) -> gpu::Result<Self> {
        let parts = (0..PARTS).map(|part| Compute::new(gpu, constants(part)));
        Ok(Programs { sky, parts: parts.collect::<gpu::Result<_>>()? })
    }

    pub fn is_for(&self, sky: u32) -> bool {
        self.sky == sky
    }

    pub fn iter(&self) -> impl Iterator<Item = &Compute<S>> {
        self.parts.iter()
    }
}

/// The tiles of a picture by kind, row by row. A tile that shows several kinds stands in the list of each.
pub struct Tiles {
    size: [u32; 2],
    /// What each tile shows, as bits.
    masks: Image<R32ui>,
    /// Column and row: all of a kind follow each other.
    pub list: Buffer<u32>,
    /// By kind: where the tiles of each row begin in the list, and where the last one ends.
    starts: Vec<Vec<u32>>,
}

impl Tiles {
    /// Of a picture of `samples`.
    pub fn new(gpu: &Gpu, samples: [u32; 2]) -> gpu::Result<Tiles> {
        let size = samples.map(|side| side.div_ceil(TILE));
        let most = (PARTS * size[0] * size[1]) as usize;
        Ok(Tiles {
            size,
            masks: Image::new(gpu, "parts", size)?,
            list: Buffer::new(gpu, "tiles", most)?,
            starts: Vec::new(),
        })
    }

    /// Rows of tiles.
    pub fn rows(&self) -> u32 {
        self.size[1]
    }

    /// Records what tells kinds apart.
    pub fn record(
        &self,
        rec: &mut Recorder,
        pass: &Compute<sort::Shader>,
        frame: &Buffer<Frame>,
        range: &Image<R32f>,
    ) -> gpu::Download<u32> {
        rec.dispatch(pass, self.size, (), sort::Bindings { frame, range, parts: &self.masks });
        rec.download(&self.masks)
    }

    /// Sorts tiles by what was found; returns the list that is to be uploaded.
    pub fn sort(&mut self, masks: &[u32]) -> Vec<u32> {
        let columns = self.size[0] as usize;
        let mut list = Vec::with_capacity(self.list.len());
        self.starts.clear();
        for part in 0..PARTS {
            let mut starts = vec![list.len() as u32];
            for (row, masks) in masks.chunks(columns).enumerate() {
                let own = masks.iter().enumerate().filter(|(_, mask)| *mask >> part & 1 == 1);
                list.extend(own.map(|(column, _)| (row as u32) << 16 | column as u32));
                starts.push(list.len() as u32);
            }
            self.starts.push(starts);
        }
        list.resize(self.list.len(), 0);
        list
    }

    /// The tiles of some rows, by kind, in the list.
    pub fn within(&self, rows: Range<u32>) -> impl Iterator<Item = Range<u32>> {
        self.starts.iter().map(move |starts| {
            let at = |row: u32| starts.get(row as usize).copied().unwrap_or_default();
            at(rows.start)..at(rows.end)
        })
    }

    /// How many rows from `first` on have at most so many tiles, each counted as often as it stands in a list: at least one.
    pub fn rows_of(&self, first: u32, most: u32) -> u32 {
        let fits = |rows: &u32| {
            let counts = self.within(first..first + rows).map(|tiles| tiles.len() as u32);
            let (sum, greatest) = counts.fold((0, 0), |(sum, most), count| (sum + count, count.max(most)));
            sum <= most && greatest <= MOST_TILES
        };
        (1..=self.rows() - first).take_while(fits).last().unwrap_or(1)
    }
}
