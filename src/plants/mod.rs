//! Plants, from the rules of their growth to models, and where they stand.
//!
//! text → [`grammar`] → [`mod@derive`]: a word → [`turtle`]: axes, polygons, places of sub-models → [`mesh`]: triangles in
//! levels of detail. [`species`] is all of it for one kind of plant; [`planting`] puts plants on the ground.

pub mod derive;
pub mod grammar;
pub mod mesh;
pub mod planting;
pub mod species;
pub mod turtle;
pub mod watch;
