//! What programs are tested against, written from the formulas alone: L-systems, the surface of a zoom, and the island model
//! in f64.
//!
//! Equation numbers are those of Korošec & Lebar Bajec, "Procedural generation of a tropical island and coral
//! reef". Every process is a function from rasters to rasters; `island::run` strings them together.

#![allow(dead_code)] // Each test file uses its share.

pub mod base;
pub mod hydraulic;
pub mod island;
pub mod lattice;
pub mod lsystem;
pub mod noise;
pub mod reef;
pub mod seabed;
pub mod statistics;
pub mod thermal;
pub mod zoom;
