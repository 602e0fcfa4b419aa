//! Coral reef growth (after Nakamura & Nakamori 2007, 2011).

#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// Step, years.
    pub step: f32,
    /// Sea-level history, in order.
    pub stages: Vec<Stage>,
    /// K_B: growth at the surface where carbon is 1, m/yr.
    pub growth: f32,
    /// K_A: decay of light, 1/m.
    pub light_decay: f32,
    /// G: deepest growth, m.
    pub max_depth: f32,
    /// K_U: carbon used per metre grown and metre of water, 1.
    pub uptake: f32,
    /// D_O: diffusivity of carbon, m²/yr.
    pub diffusivity: f32,
    /// O0: carbon of the open ocean, 1.
    pub ocean_carbon: f32,
    /// Cells deeper than this are open ocean, m.
    pub ocean_depth: f32,
    /// Growth stops this far below the surface, m.
    pub keep: f32,
    /// Rubble that slides under water.
    pub rubble: Option<Rubble>,
}

/// The sea rises evenly by `rise` metres (falls where negative) over `duration` years.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    pub duration: f32,
    pub rise: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rubble {
    /// Angle of repose, radians.
    pub repose: f32,
    /// Runs every this many reef steps …
    pub every: u32,
    /// … this many passes.
    pub passes: u32,
}
