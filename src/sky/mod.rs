//! Makes light: the clear skies of Preetham, Shirley & Smits 1999 and of Hosek & Wilkie 2012, and the sun. All in f64; renderers get coefficients and evaluate them.

pub mod air;
pub mod hosek_wilkie;
pub mod preetham;
pub mod sun;
