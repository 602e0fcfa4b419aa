//! Pure values and functions shared by every room: no Vulkan, no clock, no files.

pub mod camera;
pub mod color;
pub mod grid;
pub mod hash;
pub mod map;
pub mod memory;
pub mod mesh;
pub mod octahedron;
pub mod pace;
pub mod resample;
pub mod text;
pub mod triangulation;
