//! The land as a renderer sees it: images over the grid.

use crate::core::grid::Grid;
use crate::gpu::{Image, format::R32f};

/// One texel a sample of `grid`, row 0 north.
#[derive(Clone, Debug)]
pub struct Ground {
    pub grid: Grid,
    /// Metres above the datum.
    pub height: Image<R32f>,
    /// Depth of rivers and lakes, metres; 0 in the sea.
    pub water: Image<R32f>,
    /// How long water has stood or run here of late, 0…1; 1 in the sea.
    pub wetness: Image<R32f>,
    /// Thickness of the coral that grew, metres.
    pub reef: Image<R32f>,
    /// Height of the sea above the datum after all that happened, metres.
    pub sea_level: f32,
}
