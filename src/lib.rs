//! terrane: whole landscapes from one text file, made and shown with Vulkan.

pub mod core;
pub mod formats;
pub mod scene;
pub mod sky;
pub mod terrain;
