//! Triangles of plants: generalised cylinders along whole axes, leaves, and levels of detail.

mod blade;
mod body;
mod cylinder;
mod levels;
mod polygon;

pub use blade::{Blade, Shape};
pub use body::{Body, Leaf, REACH, Stem};
pub use cylinder::Cylinder;
pub use levels::levels;
pub use polygon::{MAX_VERTICES, triangulate};

use crate::core::text::brief;

/// Why a drawing does not become triangles.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    #[error(
        "its model would take {} MiB of memory and {} are allowed: take fewer steps, or smaller organs",
        bytes >> 20,
        limit >> 20
    )]
    TooLarge { bytes: u64, limit: u64 },
    #[error(
        "it reaches {} m from its foot, and {REACH} m at most are drawn: mind the units, lengths are metres",
        brief(*reach)
    )]
    Reach { reach: f64 },
    #[error(
        "it has no height that could be scaled to {height} m: leave `height` out, or let it grow upwards"
    )]
    Flat { height: f64 },
    #[error("a polygon has {vertices} vertices, and {MAX_VERTICES} are allowed: make it of several")]
    Polygon { vertices: usize },
}
