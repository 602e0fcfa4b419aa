//! Numbers over the land, from a file.

use serde::{Serialize, Serializer};
use sha2::{Digest, Sha256};

/// A raster from a file: row-major, row 0 north, stretched over the whole extent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Map {
    pub width: u32,
    pub height: u32,
    #[serde(serialize_with = "digest")]
    pub values: Vec<f32>,
}

impl Map {
    /// Memory of the host that it takes.
    pub fn bytes(&self) -> u64 {
        4 * self.values.len() as u64
    }

    /// The bilinear value at a place of the map, each coordinate in 0…1 from its north-west corner.
    pub fn at(&self, [east, south]: [f32; 2]) -> f32 {
        let split = |share: f32, samples: u32| {
            let place = share.clamp(0.0, 1.0) * (samples - 1) as f32;
            (place as usize, (place as usize + 1).min(samples as usize - 1), place.fract())
        };
        let (west, east, across) = split(east, self.width);
        let (north, south, down) = split(south, self.height);
        let line = |row: usize| {
            let row = &self.values[row * self.width as usize..];
            row[west] + (row[east] - row[west]) * across
        };
        line(north) + (line(south) - line(north)) * down
    }
}

/// Stands for millions of values by their SHA-256.
fn digest<S: Serializer>(values: &[f32], out: S) -> Result<S::Ok, S::Error> {
    Sha256::digest(bytemuck::cast_slice(values)).serialize(out)
}
