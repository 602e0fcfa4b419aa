//! Thermal erosion: debris slides to lower neighbours past the angle of repose (Jákó & Tóth 2011, simplified).

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    pub law: Law,
    /// Angle of repose on land, radians.
    pub repose: f32,
    /// Angle of repose under water, radians.
    pub repose_under_water: f32,
    /// Speed D_th, m²/s: the share moved in a time t is 4·D_th·t/ℓ².
    pub diffusivity: f32,
    /// Runs every this many hydraulic iterations, with the time of all of them.
    pub every: u32,
    /// Model seconds, for worlds without hydraulic erosion.
    pub duration: f32,
    /// Before anything else: collapse of slopes that are too steep.
    pub settle: Option<Settle>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Half of the excess over the repose slope moves: no overshoot, no terraces.
    Excess,
    /// Half of the whole drop moves (the paper).
    Drop,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settle {
    /// Radians.
    pub repose: f32,
    /// Length σ over which material slides, m: 2σ²/ℓ² passes.
    pub length: f32,
}
