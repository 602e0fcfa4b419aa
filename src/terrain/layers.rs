//! Base terrain: a list of layers, each combined with what the ones before it made.

use super::Map;
use std::sync::Arc;

#[derive(Clone, Debug, PartialEq)]
pub enum Layer {
    /// A generator's field, combined with the height so far.
    Generate { generator: Generator, combine: Combine },
    /// Mirrors everything above `level` (m) down: `h = 2C − h` (Korošec & Lebar Bajec (5)).
    Crater { level: f32 },
}

#[derive(Clone, Debug, PartialEq)]
pub enum Generator {
    /// `height · (1 − (r/radius)^exponent)` inside `radius`, else 0 (1, 2). `center` is world x, z in metres.
    Cone { height: f32, radius: f32, exponent: f32, center: [f32; 2] },
    /// `offset + amplitude · Σ η(p·2^i/wavelength) / 2^i` (3) with p displaced by `warp` metres of three-octave noise
    /// of the same wavelength.
    Simplex { amplitude: f32, offset: f32, wavelength: f32, octaves: u32, warp: f32, seed: u32 },
    /// Diamond–square on (2^n + 1)², sampled bicubically (`spec` of forests §2): corners from
    /// U(−init_height, init_height), offsets from U(−spread, spread), spread times `reduction` after each level.
    DiamondSquare { n: u32, init_height: f32, spread: f32, reduction: f32, seed: u32 },
    /// Heights in metres from a file.
    Heightmap { map: Arc<Map> },
}

/// How a generator's field `v` joins the height `h`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Combine {
    Add,
    Multiply,
    /// `H·(h/H)^max(0.05, 1 + v)`, 0 where h ≤ 0; H = `reference` metres (4).
    Power {
        reference: f32,
    },
    Max,
    Min,
}
