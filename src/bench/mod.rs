//! How fast land is made here: each process on the device, beside the same steps in plain Rust.

pub mod native;
