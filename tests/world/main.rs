//! World files: their keys, their schema, the thesis's folders.

#[path = "../kit/mod.rs"]
mod kit;

mod files;
mod schema;
mod thesis;
