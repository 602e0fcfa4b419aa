//! Hydraulic erosion by virtual pipes (Mei, Decaudin & Hu 2007), mended.

/// One model; the paper's is a special case of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// Simulated time, model seconds.
    pub duration: f32,
    /// Rain, m/s.
    pub rain: f32,
    /// Evaporation K_T: share of the depth that vanishes per second, 1/s.
    pub evaporation: f32,
    /// m/s².
    pub gravity: f32,
    pub pipes: Pipes,
    pub section: Section,
    /// Depth D of a pipe, m: its section with [`Section::Fixed`], the cap on it with [`Section::Depth`].
    pub pipe_depth: f32,
    /// Quadratic bed drag c_f, 1; 0 = frictionless (the paper).
    pub drag: f32,
    /// Capacity K_S, s: metres of terrain carried per m/s of speed and unit of slope.
    pub capacity: f32,
    /// Least sin α in the capacity.
    pub min_slope: f32,
    /// Depth over which the capacity rises from none to all (l_max), m; 0 = no ramp (the paper).
    pub ramp_depth: f32,
    /// Depth at which the ramp begins (d_min), m.
    pub ramp_start: f32,
    pub slope: Slope,
    /// K_E, 1/s.
    pub erosion_rate: f32,
    /// K_D, 1/s.
    pub deposition_rate: f32,
    /// Fastest change of the ground by erosion or deposition, m/s.
    pub rate_limit: f32,
    pub transport: Transport,
    /// Diffusivity D_s of suspended sediment, m²/s.
    pub sediment_diffusivity: f32,
    /// Soil creep: diffusivity of the bed, m²/s.
    pub creep: f32,
    /// Bank diffusion β: extra bed diffusivity per unit of discharge |v|·d, 1.
    pub bank_diffusion: f32,
    /// Depth below the sea over which the capacity fades to nothing (z_max), m; with the sea boundary.
    pub sea_fade: f32,
    /// The step as a share of the stable one.
    pub safety: f32,
    /// The water counter rises where water is deeper than this, m, and falls elsewhere …
    pub wet_depth: f32,
    /// … between 0 and this many seconds.
    pub wet_memory: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pipes {
    Four,
    Eight,
}

/// Cross-section of a pipe of width b.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// b·D.
    Fixed,
    /// b·min(depth of the flow, D).
    Depth,
}

/// The slope in the capacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slope {
    /// Central differences of the ground.
    Central,
    /// Outflow-weighted drop of the water surface.
    Outflow,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// Sediment leaves with the water that carries it; conservative.
    Flux,
    /// Traced back along the velocity; loses mass (the paper).
    SemiLagrangian,
}
