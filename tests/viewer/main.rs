//! The viewer: real windows under a real window manager, driven by X events.

#![cfg(feature = "viewer")]

#[path = "../kit/mod.rs"]
mod kit;

#[cfg(feature = "reload")]
mod reload;
mod window;
