//! What is written and read: pictures, rasters, meshes and models, sound, forged and damaged.

#[path = "../kit/mod.rs"]
mod kit;

mod files;
#[cfg(target_os = "linux")]
mod forged;
#[cfg(target_os = "linux")]
mod fuzz;
mod mesh;
mod mitsuba;
mod models;
mod readers;
mod resample;
