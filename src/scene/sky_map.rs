//! A picture of the whole sky.

use glam::DVec3;
use std::f64::consts::PI;
use std::fmt::{self, Debug, Formatter};

/// Radiance from everywhere by latitude and longitude: the first row straight up, the last straight down, columns clockwise.
#[derive(Clone, PartialEq)]
pub struct SkyMap {
    /// Texels along a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear Rec.709, cd/m², row by row from above.
    pub texels: Vec<[f32; 3]>,
    /// Where the left edge lies, clockwise from north, radians.
    pub rotation: f64,
}

/// Without its millions of texels.
impl Debug for SkyMap {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let SkyMap { width, height, texels: _, rotation } = self;
        write!(out, "SkyMap {{ {width} × {height}, rotation {rotation:?} }}")
    }
}

impl SkyMap {
    /// Most texels that renderers get: 96 MiB of them. Larger pictures are made smaller, see [`SkyMap::reduced`].
    pub const MOST: [u32; 2] = [4096, 2048];

    /// From the unit vector `view`, bilinear between the middles of texels.
    pub fn radiance(&self, view: DVec3) -> [f64; 3] {
        let [across, down] = self.place(view);
        let (column, row) = (across.floor(), down.floor());
        let (right, below) = (across - column, down - row);
        let texel = |column: f64, row: f64| {
            let column = column.rem_euclid(f64::from(self.width)) as usize;
            let row = row.clamp(0.0, f64::from(self.height - 1)) as usize;
            self.texels[row * self.width as usize + column].map(f64::from)
        };
        let [nw, ne] = [texel(column, row), texel(column + 1.0, row)];
        let [sw, se] = [texel(column, row + 1.0), texel(column + 1.0, row + 1.0)];
        std::array::from_fn(|channel| {
            let north = nw[channel] + (ne[channel] - nw[channel]) * right;
            let south = sw[channel] + (se[channel] - sw[channel]) * right;
            north + (south - north) * below
        })
    }

    /// In texels, from the middle of the first one.
    fn place(&self, view: DVec3) -> [f64; 2] {
        let turn = ((view.x.atan2(-view.z) - self.rotation) / (2.0 * PI)).rem_euclid(1.0);
        let zenith = view.y.clamp(-1.0, 1.0).acos() / PI;
        [turn * f64::from(self.width) - 0.5, zenith * f64::from(self.height) - 0.5]
    }

    /// The direction at this many texels from the upper left corner.
    pub fn direction(&self, across: f64, down: f64) -> DVec3 {
        let azimuth = self.rotation + 2.0 * PI * across / f64::from(self.width);
        let zenith = PI * down / f64::from(self.height);
        DVec3::new(zenith.sin() * azimuth.sin(), zenith.cos(), -zenith.sin() * azimuth.cos())
    }

    /// Solid angle of the texels of a row, sr.
    pub fn solid_angle(&self, row: u32) -> f64 {
        let edge = |row: u32| (PI * f64::from(row) / f64::from(self.height)).cos();
        2.0 * PI / f64::from(self.width) * (edge(row) - edge(row + 1))
    }

    /// The same sky with no more than [`SkyMap::MOST`] texels: each the mean of a block, by solid angle.
    pub fn reduced(self) -> SkyMap {
        let [most_across, most_down] = SkyMap::MOST;
        let block = self.width.div_ceil(most_across).max(self.height.div_ceil(most_down));
        if block <= 1 {
            return self;
        }
        let (width, height) = (self.width.div_ceil(block), self.height.div_ceil(block));
        let mean = |index: u32| {
            let (column, row) = (index % width, index / width);
            let mut sum = [0.0; 3];
            let mut whole = 0.0;
            for row in row * block..((row + 1) * block).min(self.height) {
                let weight = self.solid_angle(row);
                for column in column * block..((column + 1) * block).min(self.width) {
                    let texel = self.texels[(row * self.width + column) as usize];
                    sum = std::array::from_fn(|channel| sum[channel] + weight * f64::from(texel[channel]));
                    whole += weight;
                }
            }
            sum.map(|channel| (channel / whole) as f32)
        };
        SkyMap { width, height, texels: (0..width * height).map(mean).collect(), ..self }
    }
}
