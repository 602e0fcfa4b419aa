//! terrane: whole landscapes from one text file, made and shown with Vulkan.

pub mod app;
pub mod bench;
pub mod core;
pub mod formats;
pub mod gpu;
pub mod plants;
pub mod raster;
pub mod scene;
pub mod sky;
pub mod terrain;
pub mod trace;
pub mod world;
pub mod zoom;

/// The Rust side of every shader under `glsl/`, written by build.rs.
#[rustfmt::skip]
#[allow(clippy::derivable_impls, clippy::useless_conversion)] // One way of writing for every type.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
