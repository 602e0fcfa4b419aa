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

    /// The mean of every pixel's samples.
    pub fn picture(&self) -> Picture {
        let mut picture = Picture::new(self.width, self.height);
        for block in &self.blocks {
            let scale = 1.0 / (STEPS * f64::from(block.samples.end.max(1)));
            for row in block.origin[1]..block.origin[1] + block.size[1] {
                let first = row as usize * self.width as usize + block.origin[0] as usize;
                for index in first..first + block.size[0] as usize {
                    picture.pixels[index] = self.pixels[index].radiance.map(|sum| (sum as f64 * scale) as f32);
                }
            }
        }
        picture
    }
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
