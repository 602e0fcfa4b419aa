//! A finished picture.

use super::ToneMap;
use crate::core::color::{filmic, srgb8_from_linear};
use rayon::prelude::*;

/// Scene radiance times exposure, linear Rec.709, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// A black picture.
    pub fn new(width: u32, height: u32) -> Self {
        Picture { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// The picture that the channels R, G and B hold, of `size` = [width, height] pixels. A channel that isn't there is black.
    pub fn of([width, height]: [u32; 2], channels: &[(String, Vec<f32>)]) -> Self {
        let mut picture = Picture::new(width, height);
        for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
            let values = channels.iter().filter(|(known, _)| known == name).flat_map(|(_, values)| values);
            picture.pixels.iter_mut().zip(values).for_each(|(pixel, value)| pixel[channel] = *value);
        }
        picture
    }

    /// As it is with so many times the exposure.
    pub fn exposed(mut self, times: f32) -> Picture {
        if times != 1.0 {
            self.pixels.par_iter_mut().for_each(|pixel| *pixel = pixel.map(|channel| channel * times));
        }
        self
    }

    /// 8-bit sRGB, three bytes a pixel. Steps of one value are dithered, so that skies show no bands.
    pub fn developed(&self, tone_map: ToneMap) -> Vec<u8> {
        self.developed_from([0; 2], tone_map)
    }

    /// The same of a part of a picture that begins at `origin`: as it looks in the whole.
    pub fn developed_from(&self, [left, top]: [u32; 2], tone_map: ToneMap) -> Vec<u8> {
        let develop = |(index, pixel): (usize, &[f32; 3])| {
            let (column, row) = (index % self.width as usize, index / self.width as usize);
            let dither = dither(left as usize + column, top as usize + row);
            let shown = match tone_map {
                ToneMap::None => *pixel,
                ToneMap::Filmic => filmic(*pixel),
            };
            shown.map(|channel| srgb8_from_linear(channel, dither))
        };
        self.pixels.par_iter().enumerate().map(develop).collect::<Vec<_>>().into_flattened()
    }

    /// The part of it that begins at `origin` and has this size, pixels; it must lie in the picture.
    pub fn cut(self, [left, top]: [u32; 2], [width, height]: [u32; 2]) -> Picture {
        if [width, height] == [self.width, self.height] {
            return self;
        }
        let mut part = Picture::new(width, height);
        for (row, pixels) in part.pixels.chunks_mut(width as usize).enumerate() {
            let start = (top as usize + row) * self.width as usize + left as usize;
            pixels.copy_from_slice(&self.pixels[start..start + width as usize]);
        }
        part
    }

    /// This picture and another of the same height to the right of it.
    pub fn beside(&self, right: &Picture) -> Picture {
        let rows = |picture: &Picture| picture.width as usize;
        let pairs = self.pixels.chunks(rows(self)).zip(right.pixels.chunks(rows(right)));
        let pixels = pairs.flat_map(|(left, right)| [left, right].concat()).collect();
        Picture { width: self.width + right.width, height: self.height, pixels }
    }

    /// Copies a tile, `width` pixels wide, to where its upper left corner belongs.
    pub fn place(&mut self, [left, top]: [u32; 2], width: u32, tile: &[[f32; 4]]) {
        for (row, texels) in tile.chunks(width as usize).enumerate() {
            let start = (top as usize + row) * self.width as usize + left as usize;
            for (pixel, [r, g, b, _]) in self.pixels[start..].iter_mut().zip(texels) {
                *pixel = [*r, *g, *b];
            }
        }
    }
}

/// Evenly spread over 0…1 in every small neighbourhood (Jimenez 2014, "Next Generation Post Processing in Call of
/// Duty: Advanced Warfare": interleaved gradient noise).
fn dither(column: usize, row: usize) -> f32 {
    (52.982_918_9 * (0.067_110_56 * column as f64 + 0.005_837_15 * row as f64).fract()).fract() as f32
}
