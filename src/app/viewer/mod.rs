//! The native viewer: `terrane view`.

pub mod document;
pub mod keys;
pub mod panels;
pub mod recovery;
pub mod state;
pub mod theme;
