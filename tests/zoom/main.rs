//! The zoom: its surface, tiles and trees, its pictures and backgrounds, how one moves in it, and its commands.

#[path = "../kit/mod.rs"]
mod kit;
#[path = "../reference/mod.rs"]
mod reference;

mod background;
mod frame;
mod motion;
mod program;
mod surface;
mod tiles;
mod tree;
