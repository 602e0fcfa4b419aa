//! Moving over the surface: as fast as it is far, and never through it.

mod approach;
mod autopilot;
mod clearance;
mod flight;

pub use approach::{Approach, Depth};
pub use autopilot::{Autopilot, Pose};
pub use clearance::{Clearance, Distance, clearance};
pub use flight::{Buried, Flight, LEVEL_A_SECOND, moved};
