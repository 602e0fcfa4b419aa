//! terrane: whole landscapes from one text file, made and shown with Vulkan.

pub mod core;
pub mod gpu;
pub mod scene;
pub mod terrain;

/// The Rust side of every shader under `glsl/`, written by build.rs.
#[rustfmt::skip]
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
