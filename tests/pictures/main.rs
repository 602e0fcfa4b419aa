//! Pictures: the Vulkan layer, what is drawn, the sky, and what is traced.

#[path = "../kit/mod.rs"]
mod kit;

mod foliage;
mod forests;
mod gpu;
mod live;
mod raster;
mod sky;
mod trace;
