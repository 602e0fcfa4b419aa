//! The simulation grid: square, samples at vertices, centred on the origin.

use serde::Serialize;

/// A square raster of `cells × cells` height samples over `extent × extent` metres.
///
/// Samples are vertices: column 0 lies on the west edge, column `cells − 1` on the east edge;
/// row 0 is the north edge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Grid {
    /// Samples along one side.
    pub cells: u32,
    /// Length of one side in metres, between the first and the last sample.
    pub extent: f32,
}

impl Grid {
    /// Distance between neighbouring samples, in metres (ℓ).
    pub fn cell_size(self) -> f32 {
        self.extent / (self.cells - 1) as f32
    }

    /// Number of samples.
    pub fn samples(self) -> usize {
        self.cells as usize * self.cells as usize
    }

    /// World x (east) and z (south) of the sample in column `i`, row `j`, in metres.
    pub fn position(self, i: u32, j: u32) -> [f32; 2] {
        let half = self.extent / 2.0;
        let cell = self.cell_size();
        [i as f32 * cell - half, j as f32 * cell - half]
    }
}
