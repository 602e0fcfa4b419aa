//! What is shown beside the picture. A panel draws what it is given and returns what the user wants; it changes nothing itself.

pub mod export;
pub mod files;
pub mod help;
pub mod land;
pub mod parameters;
pub mod picture;
pub mod plants;
pub mod timings;
pub mod welcome;
pub mod zoom;
