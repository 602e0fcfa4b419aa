//! What samples have gathered: exact sums, whatever their order.

use crate::core::color::luminance;
use crate::scene::{Film, Picture};
use crate::shaders::Pixel;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Sums of some samples of a picture, or of a part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    crop: Crop,
    /// Number of the first sample.
    first: u32,
    /// Those of the crop, row by row.
    pixels: Vec<Pixel>,
    blocks: Vec<Block>,
    flaws: Flaws,
}

/// A part of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crop {
    /// Its upper left corner, from the picture's.
    pub origin: [u32; 2],
    pub size: [u32; 2],
}

/// How many samples were not what they should have been.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flaws {
    /// Not a number, or infinite: they count as black.
    pub not_finite: u64,
    /// Brighter than sums can hold, and cut off there.
    pub cut_off: u64,
}

/// Part of a picture and samples of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// First pixel, in all of the picture.
    pub origin: [u32; 2],
    pub size: [u32; 2],
    /// Of every pixel. In a list of blocks: those that are done.
    pub samples: Range<u32>,
}

/// Most samples that a pixel may have: so many fit into its sums.
pub const MOST_SAMPLES: u32 = 1 << 20;

/// Steps in 1: the twin of `STEPS` in `glsl/lib/film.glsl`.
const STEPS: f64 = 16_777_216.0;
/// Of lengths, in a metre: the twin of `STEPS_IN_METRE`.
const STEPS_IN_METRE: f64 = 4096.0;

/// Most samples that a block gets before others have their turn. A power of two.
const TURN: u32 = 16;

impl Crop {
    /// All of a picture.
    pub fn whole(width: u32, height: u32) -> Self {
        Crop { origin: [0; 2], size: [width, height] }
    }

    pub fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// The pixel behind its last one, on both axes.
    pub fn end(&self) -> [u64; 2] {
        [0, 1].map(|axis| u64::from(self.origin[axis]) + u64::from(self.size[axis]))
    }

    /// Whether it has pixels in common with another.
    pub fn overlaps(&self, other: &Crop) -> bool {
        let along = |axis: usize| {
            u64::from(self.origin[axis]) < other.end()[axis]
                && u64::from(other.origin[axis]) < self.end()[axis]
        };
        along(0) && along(1)
    }

    /// Whether it lies in another.
    pub fn within(&self, other: &Crop) -> bool {
        let along =
            |axis: usize| other.origin[axis] <= self.origin[axis] && self.end()[axis] <= other.end()[axis];
        along(0) && along(1)
    }

    /// The blocks that it is traced in, without samples before `first`.
    fn blocks(&self, first: u32) -> Vec<Block> {
        let mut blocks = Vec::new();
        let [width, height] = self.size;
        for top in (0..height).step_by(SIDE as usize) {
            for left in (0..width).step_by(SIDE as usize) {
                let origin = [self.origin[0] + left, self.origin[1] + top];
                let size = [SIDE.min(width - left), SIDE.min(height - top)];
                blocks.push(Block { origin, size, samples: first..first });
            }
        }
        blocks
    }
}

impl Flaws {
    fn add(&mut self, other: Flaws) {
        self.not_finite = self.not_finite.saturating_add(other.not_finite);
        self.cut_off = self.cut_off.saturating_add(other.cut_off);
    }
}

impl Block {
    pub const MOST_PIXELS: u32 = SIDE * SIDE;

    pub fn pixels(&self) -> u32 {
        self.size[0] * self.size[1]
    }

    /// Of the largest block of a picture.
    pub fn most_pixels(film: &Film) -> u32 {
        film.width.min(SIDE) * film.height.min(SIDE)
    }
}

/// Of blocks, pixels.
const SIDE: u32 = 512;

impl Sums {
    /// Nothing yet, of a whole picture.
    pub fn new(width: u32, height: u32) -> Self {
        Sums::of(Crop::whole(width, height), 0)
    }

    /// Nothing yet, of the pixels of `crop` and their samples from number `first` on.
    pub fn of(crop: Crop, first: u32) -> Self {
        let pixels = vec![Pixel::default(); crop.pixels() as usize];
        Sums { crop, first, pixels, blocks: crop.blocks(first), flaws: Flaws::default() }
    }

    /// How many blocks a crop has.
    pub fn blocks_of(crop: &Crop) -> u64 {
        crop.size.iter().map(|side| u64::from(side.div_ceil(SIDE))).product()
    }

    /// What [`Sums::parts`] has taken apart. `None` if these are not as many blocks and pixels as the crop has, or a block has samples
    /// that no pixel may have.
    pub fn from_parts(
        crop: Crop,
        first: u32,
        ends: &[u32],
        pixels: Vec<Pixel>,
        flaws: Flaws,
    ) -> Option<Self> {
        if ends.len() as u64 != Sums::blocks_of(&crop) || pixels.len() as u64 != crop.pixels() {
            return None;
        }
        let mut blocks = crop.blocks(first);
        for (block, end) in blocks.iter_mut().zip(ends) {
            if !(first..=MOST_SAMPLES).contains(end) {
                return None;
            }
            block.samples.end = *end;
        }
        Some(Sums { crop, first, pixels, blocks, flaws })
    }

    /// For every block the number of the sample that comes next; and the pixels' sums.
    pub fn parts(&self) -> (Vec<u32>, &[Pixel]) {
        (self.blocks.iter().map(|block| block.samples.end).collect(), &self.pixels)
    }

    pub fn crop(&self) -> Crop {
        self.crop
    }

    /// Number of the first sample.
    pub fn first(&self) -> u32 {
        self.first
    }

    pub fn flaws(&self) -> Flaws {
        self.flaws
    }

    /// Numbers of the samples that every pixel has; `None` if some pixels have more than others.
    pub fn range(&self) -> Option<Range<u32>> {
        let end = self.blocks.first()?.samples.end;
        self.blocks.iter().all(|block| block.samples.end == end).then_some(self.first..end)
    }

    /// What to trace next, up to the sample with the number `end`: each block in turn gets as many as it has, and all wait for each
    /// other at every power of two, wherever they began.
    pub(super) fn next(&self, end: u32) -> Option<Block> {
        let block = self.blocks.iter().min_by_key(|block| block.samples.end)?;
        let from = block.samples.end;
        if from >= end {
            return None;
        }
        let more = TURN.min((from + 1).next_power_of_two());
        let to = (from / more + 1).saturating_mul(more).min(end);
        Some(Block { samples: from..to, ..block.clone() })
    }

    /// Adds what `block`'s samples have gathered.
    pub(super) fn add(&mut self, block: &Block, gathered: &[Pixel], flaws: Flaws) {
        self.add_rows(&Crop { origin: block.origin, size: block.size }, gathered);
        self.flaws.add(flaws);
        if let Some(own) = self.blocks.iter_mut().find(|own| own.origin == block.origin) {
            own.samples.end = block.samples.end;
        }
    }

    /// Adds samples of a part of the picture that are not in it yet. [`Sums::complete`] says when none are missing.
    pub fn absorb(&mut self, part: &Sums) {
        if part.crop.within(&self.crop) {
            self.add_rows(&part.crop, &part.pixels);
            self.flaws.add(part.flaws);
        }
    }

    /// Says that by now all samples up to number `end` are in it.
    pub fn complete(&mut self, end: u32) {
        self.blocks.iter_mut().for_each(|block| block.samples.end = end);
    }

    fn add_rows(&mut self, crop: &Crop, gathered: &[Pixel]) {
        let (width, columns) = (self.crop.size[0] as usize, crop.size[0] as usize);
        let [left, top] = [0, 1].map(|axis| (crop.origin[axis] - self.crop.origin[axis]) as usize);
        for (row, gathered) in gathered.chunks(columns).enumerate() {
            let first = (top + row) * width + left;
            for (pixel, gathered) in self.pixels[first..first + columns].iter_mut().zip(gathered) {
                add(pixel, gathered);
            }
        }
    }

    /// Samples that every pixel has at least.
    pub fn samples(&self) -> u32 {
        self.blocks.iter().map(|block| block.samples.len() as u32).min().unwrap_or(0)
    }

    /// Samples that pixels have on average, and those of all pixels.
    pub fn progress(&self) -> (f64, u64) {
        let all: u64 =
            self.blocks.iter().map(|block| u64::from(block.pixels()) * block.samples.len() as u64).sum();
        (all as f64 / self.pixels.len() as f64, all)
    }

    /// The mean of every pixel's samples.
    pub fn picture(&self) -> Picture {
        let mut picture = Picture::new(self.crop.size[0], self.crop.size[1]);
        self.for_each(|index, pixel, samples| {
            picture.pixels[index] = pixel.radiance.map(|sum| mean(sum, samples.len() as u32));
        });
        picture
    }

    /// Estimated error of the picture: the root of the mean square of every pixel's standard error over its luminance, or over
    /// what is hardly more than black if that is more. `None` before there are two samples.
    pub fn noise(&self) -> Option<f64> {
        if self.samples() < 2 {
            return None;
        }
        let mut sum = 0.0;
        self.for_each(|_, pixel, samples| {
            let mean = pixel.radiance.map(|sum| mean(sum, samples.len() as u32));
            let luminance = f64::from(luminance(mean));
            let variance = f64::from(luminance_variance(pixel, samples));
            sum += variance / luminance.max(NEARLY_BLACK).powi(2);
        });
        Some((sum / self.pixels.len() as f64).sqrt())
    }

    /// All that is known of the picture, as channels of an EXR: radiance times exposure, albedo, normal, position (m), distance
    /// from the eye (m), number of the instance (1 is the first; 0 is land, sea and sky), samples and the variance of the mean.
    /// Normal, position and distance are means over those samples that met a surface, the others over all.
    pub fn channels(&self) -> Vec<(String, Vec<f32>)> {
        let mut planes = vec![vec![0.0; self.pixels.len()]; NAMES.len()];
        self.for_each(|index, pixel, range| {
            let (covered, samples) = (pixel.covered, range.len() as u32);
            let [r, g, b] = pixel.radiance.map(|sum| mean(sum, samples));
            let [albedo_r, albedo_g, albedo_b] = pixel.albedo.map(|sum| mean(sum, samples));
            let [nx, ny, nz] = pixel.normal.map(|sum| mean(sum, covered));
            let [px, py, pz] = pixel.position.map(|sum| mean_length(sum, covered));
            let [vr, vg, vb] = variance(pixel, range);
            let values = [
                r,
                g,
                b,
                1.0,
                albedo_r,
                albedo_g,
                albedo_b,
                nx,
                ny,
                nz,
                px,
                py,
                pz,
                mean_length(pixel.depth, covered),
                pixel.object as f32,
                samples as f32,
                vr,
                vg,
                vb,
            ];
            for (plane, value) in planes.iter_mut().zip(values) {
                plane[index] = value;
            }
        });
        NAMES.iter().map(|name| name.to_string()).zip(planes).collect()
    }

    /// Every pixel with its place in the crop and the samples that it has.
    fn for_each(&self, mut look: impl FnMut(usize, &Pixel, Range<u32>)) {
        let [left, top] = self.crop.origin;
        for block in &self.blocks {
            for row in block.origin[1] - top..block.origin[1] - top + block.size[1] {
                let first = row as usize * self.crop.size[0] as usize + (block.origin[0] - left) as usize;
                for index in first..first + block.size[0] as usize {
                    look(index, &self.pixels[index], block.samples.clone());
                }
            }
        }
    }
}

const NAMES: [&str; 19] = [
    "R",
    "G",
    "B",
    "A",
    "albedo.R",
    "albedo.G",
    "albedo.B",
    "normal.X",
    "normal.Y",
    "normal.Z",
    "position.X",
    "position.Y",
    "position.Z",
    "depth.Z",
    "object.Y",
    "samples.Y",
    "variance.R",
    "variance.G",
    "variance.B",
];

/// Luminance below which an error is no longer seen in proportion to it, where white is 1.
const NEARLY_BLACK: f64 = 0.01;

fn mean(sum: i64, samples: u32) -> f32 {
    (sum as f64 / (STEPS * f64::from(samples.max(1)))) as f32
}

fn mean_length(sum: i64, samples: u32) -> f32 {
    (sum as f64 / (STEPS_IN_METRE * f64::from(samples.max(1)))) as f32
}

/// Half of how far the means of even and of odd samples differ: about the standard error of the mean of all.
fn half_difference(pixel: &Pixel, range: Range<u32>) -> [f32; 3] {
    let (odd, samples) = (range.end / 2 - range.start / 2, range.len() as u32);
    std::array::from_fn(|channel| {
        let (all, of_odd) = (pixel.radiance[channel], pixel.odd[channel]);
        (mean(all - of_odd, samples - odd) - mean(of_odd, odd)) / 2.0
    })
}

/// Of the mean, by channel.
fn variance(pixel: &Pixel, samples: Range<u32>) -> [f32; 3] {
    half_difference(pixel, samples).map(|difference| difference * difference)
}

fn luminance_variance(pixel: &Pixel, samples: Range<u32>) -> f32 {
    luminance(half_difference(pixel, samples)).powi(2)
}

fn add(pixel: &mut Pixel, gathered: &Pixel) {
    let sum = |sums: &mut [i64; 3], more: [i64; 3]| {
        for (sum, more) in sums.iter_mut().zip(more) {
            *sum = sum.saturating_add(more);
        }
    };
    sum(&mut pixel.radiance, gathered.radiance);
    sum(&mut pixel.odd, gathered.odd);
    sum(&mut pixel.albedo, gathered.albedo);
    sum(&mut pixel.normal, gathered.normal);
    sum(&mut pixel.position, gathered.position);
    pixel.depth = pixel.depth.saturating_add(gathered.depth);
    pixel.covered = pixel.covered.saturating_add(gathered.covered);
    // Sample 0 alone has one.
    pixel.object |= gathered.object;
}
