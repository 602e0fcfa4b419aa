//! The command line, in processes of its own: what it writes, keeps, refuses, and survives.

#[path = "../kit/mod.rs"]
mod kit;

mod cache;
mod checkpoint;
mod cli;
mod compare;
#[cfg(unix)]
mod denoise;
mod export;
#[cfg(target_os = "linux")]
mod faults;
mod manual;
mod shipped;
