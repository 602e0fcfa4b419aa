//! Makes light: Preetham, Shirley & Smits's daylight ("A Practical Analytic Model for Daylight", SIGGRAPH 1999)
//! and the sun that belongs to it. All in f64; renderers get coefficients and evaluate them.

pub mod air;
pub mod preetham;
pub mod sun;
