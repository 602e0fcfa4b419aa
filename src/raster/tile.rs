//! Tiles: pictures are drawn in parts, so that any size fits any device.

use super::Quality;
use crate::scene::Film;

/// A part of the picture.
#[derive(Clone, Copy)]
pub(super) struct Tile {
    /// Left and top, pixels.
    pub origin: [u32; 2],
    /// Pixels.
    pub size: [u32; 2],
    /// Side of the square of samples in a pixel.
    pub samples: u32,
}

impl Tile {
    /// The tiles of a picture, row by row.
    pub fn cut(film: &Film, quality: Quality) -> Vec<Tile> {
        let starts = |whole: u32| (0..whole).step_by(quality.tile as usize);
        starts(film.height)
            .flat_map(|top| starts(film.width).map(move |left| [left, top]))
            .map(|origin| {
                let [left, top] = origin;
                let size = [quality.tile.min(film.width - left), quality.tile.min(film.height - top)];
                Tile { origin, size, samples: quality.samples }
            })
            .collect()
    }

    pub fn sample_size(self) -> [u32; 2] {
        self.size.map(|side| side * self.samples)
    }

    /// Scale and offset from the whole picture's clip coordinates to the tile's.
    pub fn clip(self, film: &Film) -> [[f32; 2]; 2] {
        let axis = |origin: u32, size: u32, whole: u32| {
            let (origin, size, whole) = (f64::from(origin), f64::from(size), f64::from(whole));
            (whole / size, (whole - 2.0 * origin - size) / size)
        };
        let (scale_x, offset_x) = axis(self.origin[0], self.size[0], film.width);
        // Clip coordinates point up, rows count down.
        let (scale_y, offset_y) = axis(self.origin[1], self.size[1], film.height);
        [[scale_x as f32, scale_y as f32], [offset_x as f32, -offset_y as f32]]
    }
}
