//! The island model in f64, written from the formulas alone: what the kernels are tested against.
//!
//! Equation numbers are those of Korošec & Lebar Bajec, "Procedural generation of a tropical island and coral
//! reef". Every process is a function from rasters to rasters; `island::run` strings them together.

#![allow(dead_code)] // Each test file uses its share.

pub mod base;
pub mod hydraulic;
pub mod island;
pub mod lattice;
pub mod noise;
pub mod reef;
pub mod seabed;
pub mod statistics;
pub mod thermal;
