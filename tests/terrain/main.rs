//! The island's simulation: kernels against f64 references, and the references against closed forms.

#[path = "../kit/mod.rs"]
mod kit;
#[path = "../reference/mod.rs"]
mod reference;

mod bench;
mod closed_forms;
mod islands;
mod kernels;
mod laws;
mod live;
