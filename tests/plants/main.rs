//! Plants: their language, their triangles, and where they stand.

#[path = "../kit/mod.rs"]
mod kit;
#[path = "../reference/mod.rs"]
mod reference;

mod language;
#[cfg(target_os = "linux")]
mod mistakes;
mod models;
mod planting;
mod species;
