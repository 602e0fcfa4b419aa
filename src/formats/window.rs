//! What writers of rasters take: a rectangle of one that is in memory, row by row.

use serde::{Deserialize, Serialize};

/// A rectangle of a raster. Samples of several channels lie together: red, green, blue, red, …
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    values: &'a [f32],
    channels: usize,
    /// Samples in a row of the whole raster.
    stride: usize,
    /// Column and row of the rectangle's first sample.
    origin: [usize; 2],
    size: [u32; 2],
    first_row: FirstRow,
}

/// Which edge of the land the first row of a file is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FirstRow {
    #[default]
    North,
    /// As Unity wants it, whose z axis points north.
    South,
}

impl<'a> Window<'a> {
    /// All of a raster of `size` = [width, height] samples with so many values each, the northern row first.
    pub fn whole(values: &'a [f32], size: [u32; 2], channels: usize) -> Self {
        let first_row = FirstRow::North;
        Window { values, channels, stride: size[0] as usize, origin: [0, 0], size, first_row }
    }

    /// The rectangle of `size` that begins at `origin` = [column, row].
    pub fn part(self, origin: [u32; 2], size: [u32; 2]) -> Self {
        Window { origin: origin.map(|at| at as usize), size, ..self }
    }

    /// The same rectangle with its rows in that order.
    pub fn ordered(self, first_row: FirstRow) -> Self {
        Window { first_row, ..self }
    }

    /// Width and height, samples.
    pub fn size(self) -> [u32; 2] {
        self.size
    }

    /// Values a sample.
    pub fn channels(self) -> usize {
        self.channels
    }

    /// The rows, in the order that was asked for.
    pub fn rows(self) -> impl Iterator<Item = &'a [f32]> {
        let [width, height] = self.size.map(|side| side as usize);
        (0..height).map(move |row| {
            let row = match self.first_row {
                FirstRow::North => row,
                FirstRow::South => height - 1 - row,
            };
            let start = ((self.origin[1] + row) * self.stride + self.origin[0]) * self.channels;
            &self.values[start..start + width * self.channels]
        })
    }

    /// The values as they lie in memory, if the window is all of the raster.
    pub fn contiguous(self) -> Option<&'a [f32]> {
        let samples = self.size[0] as usize * self.size[1] as usize;
        let whole = samples * self.channels == self.values.len() && self.first_row == FirstRow::North;
        whole.then_some(self.values)
    }

    /// The values of one channel.
    pub fn plane(self, channel: usize) -> Vec<f32> {
        self.rows().flat_map(|row| row.iter().skip(channel).step_by(self.channels).copied()).collect()
    }
}
