//! A finished picture.

use crate::core::color::{filmic, srgb8_from_linear};
use crate::scene::ToneMap;
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

    /// 8-bit sRGB, three bytes a pixel.
    pub fn developed(&self, tone_map: ToneMap) -> Vec<u8> {
        let develop = |pixel: &[f32; 3]| match tone_map {
            ToneMap::None => pixel.map(srgb8_from_linear),
            ToneMap::Filmic => filmic(*pixel).map(srgb8_from_linear),
        };
        self.pixels.par_iter().map(develop).collect::<Vec<_>>().into_flattened()
    }

    /// Copies a tile, `width` pixels wide, to where its upper left corner belongs.
    pub(super) fn place(&mut self, [left, top]: [u32; 2], width: u32, tile: &[[f32; 4]]) {
        for (row, texels) in tile.chunks(width as usize).enumerate() {
            let start = (top as usize + row) * self.width as usize + left as usize;
            for (pixel, [r, g, b, _]) in self.pixels[start..].iter_mut().zip(texels) {
                *pixel = [*r, *g, *b];
            }
        }
    }
}
