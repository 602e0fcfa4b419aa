//! Endless approach to a fractal landscape, and the way back.
//!
//! The surface is a pure function of a seed and of whole numbers ([`height`]), and a place on it is as many binary digits as
//! its depth needs ([`address`]). All else follows from these two: which tiles are looked at ([`tree`]), how far the ground is and
//! where a flight leads ([`motion`]), and what is drawn of it and how ([`tiles`], [`view`]). Whatever is kept is kept for speed alone: thrown away, it comes again, bit for bit.
//!
//! After Tunković, "Real time fractal noise rendering using multiresolution square grid", Zagreb 2018, whose heights are floats.
//!
//! Lengths are in cells: a lattice of level m has vertices 2⁻ᵐ apart. X points east, Y up, Z south.

pub mod address;
pub mod background;
pub mod height;
pub mod marks;
pub mod memory;
pub mod mesh;
pub mod motion;
mod paint;
pub mod tiles;
pub mod tree;
pub mod view;
