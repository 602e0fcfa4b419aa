//! What samples have gathered: exact sums, whatever their order.

use crate::scene::{Film, Picture};
use crate::shaders::Pixel;
use std::ops::Range;

/// Sums of all samples of a picture so far.
#[derive(Clone, Debug)]
pub struct Sums {
    width: u32,
    height: u32,
    pixels: Vec<Pixel>,
    blocks: Vec<Block>,
    /// The block that comes next.
    turn: usize,
}

/// Part of a picture and samples of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// First pixel.
    pub origin: [u32; 2],
    pub size: [u32; 2],
    /// Of every pixel. In a list of blocks: those that are done.
    pub samples: Range<u32>,
}

/// Steps in 1: the twin of `STEPS` in `glsl/lib/film.glsl`.
const STEPS: f64 = 16_777_216.0;

/// Most samples that a block gets before others have their turn.
const MOST_SAMPLES: u32 = 16;

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
    pub fn new(width: u32, height: u32) -> Self {
        let mut blocks = Vec::new();
        for top in (0..height).step_by(SIDE as usize) {
            for left in (0..width).step_by(SIDE as usize) {
                let size = [SIDE.min(width - left), SIDE.min(height - top)];
                blocks.push(Block { origin: [left, top], size, samples: 0..0 });
            }
        }
        let pixels = vec![Pixel::default(); width as usize * height as usize];
        Sums { width, height, pixels, blocks, turn: 0 }
    }

    /// What to trace next, towards `samples` of every pixel: each block in turn gets as many as it has.
    pub(super) fn next(&mut self, samples: u32) -> Option<Block> {
        let least = self.blocks.iter().map(|block| block.samples.end).min()?;
        if least >= samples {
            return None;
        }
        let index = self.blocks.iter().position(|block| block.samples.end == least)?;
        self.turn = index;
        let more = least.clamp(1, MOST_SAMPLES).min(samples - least);
        let block = &self.blocks[index];
        Some(Block { samples: least..least + more, ..block.clone() })
    }

    /// Adds what `block`'s samples have gathered.
    pub(super) fn add(&mut self, block: &Block, gathered: &[Pixel]) {
        let columns = block.size[0] as usize;
        for (row, gathered) in gathered.chunks(columns).enumerate() {
            let first = (block.origin[1] as usize + row) * self.width as usize + block.origin[0] as usize;
            for (pixel, gathered) in self.pixels[first..first + columns].iter_mut().zip(gathered) {
                add(pixel, gathered, block.samples.start == 0);
            }
        }
        self.blocks[self.turn].samples.end = block.samples.end;
    }

    /// Samples that every pixel has at least.
    pub fn samples(&self) -> u32 {
        self.blocks.iter().map(|block| block.samples.end).min().unwrap_or(0)
    }

    /// Samples that pixels have on average, and those of all pixels.
    pub fn progress(&self) -> (f64, u64) {
        let all: u64 =
            self.blocks.iter().map(|block| u64::from(block.pixels()) * u64::from(block.samples.end)).sum();
        (all as f64 / self.pixels.len() as f64, all)
    }

    /// The mean of every pixel's samples.
    pub fn picture(&self) -> Picture {
        let mut picture = Picture::new(self.width, self.height);
        self.for_each(|index, pixel, samples| {
            picture.pixels[index] = pixel.radiance.map(|sum| mean(sum, samples));
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
            let luminance = f64::from(luminance(pixel.radiance.map(|sum| mean(sum, samples))));
            let variance = f64::from(luminance_variance(pixel, samples));
            sum += variance / luminance.max(NEARLY_BLACK).powi(2);
        });
        Some((sum / self.pixels.len() as f64).sqrt())
    }

    /// All that is known of the picture, as channels of an EXR: radiance times exposure, albedo, normal, position (m), distance
    /// from the eye (m), number of the instance (1 is the first; 0 is land, sea and sky), samples and the variance of the mean.
    /// What belongs to a surface is the mean over those samples that met one.
    pub fn channels(&self) -> Vec<(String, Vec<f32>)> {
        let mut planes = vec![vec![0.0; self.pixels.len()]; NAMES.len()];
        self.for_each(|index, pixel, samples| {
            let covered = pixel.covered;
            let [r, g, b] = pixel.radiance.map(|sum| mean(sum, samples));
            let [albedo_r, albedo_g, albedo_b] = pixel.albedo.map(|sum| mean(sum, samples));
            let [nx, ny, nz] = pixel.normal.map(|sum| mean(sum, covered));
            let [px, py, pz] = pixel.position.map(|sum| mean(sum, covered));
            let [vr, vg, vb] = variance(pixel, samples);
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
                mean(pixel.depth, covered),
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

    /// Every pixel with its place and how many samples it has.
    fn for_each(&self, mut look: impl FnMut(usize, &Pixel, u32)) {
        for block in &self.blocks {
            for row in block.origin[1]..block.origin[1] + block.size[1] {
                let first = row as usize * self.width as usize + block.origin[0] as usize;
                for index in first..first + block.size[0] as usize {
                    look(index, &self.pixels[index], block.samples.end);
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

fn luminance([red, green, blue]: [f32; 3]) -> f32 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Half of how far the means of even and of odd samples differ: about the standard error of the mean of all.
fn half_difference(pixel: &Pixel, samples: u32) -> [f32; 3] {
    let odd = samples / 2;
    std::array::from_fn(|channel| {
        let (all, of_odd) = (pixel.radiance[channel], pixel.odd[channel]);
        (mean(all - of_odd, samples - odd) - mean(of_odd, odd)) / 2.0
    })
}

/// Of the mean, by channel.
fn variance(pixel: &Pixel, samples: u32) -> [f32; 3] {
    half_difference(pixel, samples).map(|difference| difference * difference)
}

fn luminance_variance(pixel: &Pixel, samples: u32) -> f32 {
    luminance(half_difference(pixel, samples)).powi(2)
}

fn add(pixel: &mut Pixel, gathered: &Pixel, first: bool) {
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
    pixel.covered += gathered.covered;
    if first {
        pixel.object = gathered.object;
    }
}
