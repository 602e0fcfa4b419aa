//! Preetham's sky: zenith values and Perez coefficients from the turbidity and the sun's height.
//!
//! The numbers are those of the authors' published code. The paper prints them rounded, and most
//! shaders copy that print; the two skies differ by up to 0.03 % in luminance and 0.004 in chromaticity.

use glam::DVec3;

use crate::scene::{Perez, Sky};

/// Below this the model has no sensible values: `1 + A e^B` of the luminance is 0 at 1.6431 and the
/// dome turns negative.
pub const LEAST_TURBIDITY: f64 = 1.7;

/// Where the model is trusted: below it the horizon brightens without bound, above it the gradient reverses.
pub const TRUSTED_TURBIDITY: [f64; 2] = [2.0, 8.0];

/// Farthest from the zenith that the sun may stand for the model to be trusted: 87°.
pub const TRUSTED_SUN_ZENITH: f64 = 87.0 / 180.0 * std::f64::consts::PI;

/// The sky of `turbidity` with the sun in direction `sun` (unit, world axes). A sun below the horizon
/// lights the sky as from the horizon, for the model knows no night.
pub fn sky(turbidity: f64, sun: DVec3) -> Sky {
    Sky::Preetham(perez(turbidity, sun))
}

/// The same as plain coefficients.
pub fn perez(turbidity: f64, sun: DVec3) -> Perez {
    let t = turbidity;
    let level = DVec3::new(sun.x, 0.0, sun.z).try_normalize().unwrap_or(DVec3::X);
    let sun = if sun.y < 0.0 { level } else { sun };
    let sun_angle = sun.y.clamp(-1.0, 1.0).acos();
    Perez {
        sun,
        zenith: [
            zenith_luminance(t, sun_angle),
            zenith_chromaticity(&ZENITH_X, t, sun_angle),
            zenith_chromaticity(&ZENITH_Y, t, sun_angle),
        ],
        coefficients: PEREZ.map(|rows| rows.map(|[slope, intercept]| slope * t + intercept)),
    }
}

/// Luminance at the zenith, cd/m² (Preetham et al. 1999, appendix A.2).
fn zenith_luminance(turbidity: f64, sun_angle: f64) -> f64 {
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (std::f64::consts::PI - 2.0 * sun_angle);
    1000.0 * ((4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192)
}

/// Chromaticity at the zenith: a cubic in the sun's angle whose coefficients are quadratic in the turbidity.
fn zenith_chromaticity(rows: &[[f64; 4]; 3], turbidity: f64, sun_angle: f64) -> f64 {
    let [square, linear, constant] =
        rows.map(|[a, b, c, d]| ((a * sun_angle + b) * sun_angle + c) * sun_angle + d);
    (square * turbidity + linear) * turbidity + constant
}

/// Slope and intercept in the turbidity of A, B, C, D, E, for Y, x and y.
const PEREZ: [[[f64; 2]; 5]; 3] = [
    [[0.17872, -1.46303], [-0.35540, 0.42749], [-0.02266, 5.32505], [0.12064, -2.57705], [-0.06696, 0.37027]],
    [
        [-0.01925, -0.25922],
        [-0.06651, 0.00081],
        [-0.00041, 0.21247],
        [-0.06409, -0.89887],
        [-0.00325, 0.04517],
    ],
    [
        [-0.01669, -0.26078],
        [-0.09495, 0.00921],
        [-0.00792, 0.21023],
        [-0.04405, -1.65369],
        [-0.01092, 0.05291],
    ],
];

const ZENITH_X: [[f64; 4]; 3] = [
    [0.00165, -0.00374, 0.00208, 0.0],
    [-0.02902, 0.06377, -0.03202, 0.00394],
    [0.11693, -0.21196, 0.06052, 0.25885],
];

const ZENITH_Y: [[f64; 4]; 3] = [
    [0.00275, -0.00610, 0.00316, 0.0],
    [-0.04214, 0.08970, -0.04153, 0.00515],
    [0.15346, -0.26756, 0.06669, 0.26688],
];
