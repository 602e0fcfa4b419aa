//! Perez's distribution of a clear sky's light over the dome, as makers hand it to renderers.

use glam::DVec3;

use crate::core::color::{rec709_from_xyz, xyz_from_luminance};

/// Luminance (cd/m²) and chromaticities x and y over the dome: each is its value at the zenith times
/// `F(θ, γ) / F(0, θs)`, `F(θ, γ) = (1 + A e^{B/cos θ}) (1 + C e^{Dγ} + E cos²γ)`
/// (Perez, Seals & Michalsky 1993; Preetham, Shirley & Smits 1999).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perez {
    /// Unit vector towards the sun, world axes, at or above the horizon.
    pub sun: DVec3,
    /// Y (cd/m²), x and y at the zenith.
    pub zenith: [f64; 3],
    /// A, B, C, D, E for each of Y, x and y.
    pub coefficients: [[f64; 5]; 3],
}

impl Perez {
    /// Y (cd/m²), x, y from the unit vector `view`; `None` below the horizon.
    pub fn luminance_and_chromaticity(&self, view: DVec3) -> Option<[f64; 3]> {
        if view.y < 0.0 {
            return None;
        }
        let cos_gamma = view.dot(self.sun);
        // acos loses half the digits near the sun; the chord does not.
        let gamma = 2.0 * (0.5 * view.distance(self.sun)).min(1.0).asin();
        let sun_angle = self.sun.y.clamp(-1.0, 1.0).acos();
        let values = [0, 1, 2].map(|channel| {
            let coefficients = &self.coefficients[channel];
            let here = distribution(coefficients, view.y, gamma, cos_gamma);
            let zenith = distribution(coefficients, 1.0, sun_angle, self.sun.y);
            self.zenith[channel] * here / zenith
        });
        Some(values)
    }

    /// Linear Rec.709 radiance from the unit vector `view`, cd/m²; black below the horizon.
    pub fn radiance(&self, view: DVec3) -> [f64; 3] {
        let Some([luminance, x, y]) = self.luminance_and_chromaticity(view) else { return [0.0; 3] };
        rec709_from_xyz(xyz_from_luminance(luminance, [x, y]))
    }

    /// `F(0, θs)` of Y, x and y: what the distribution is divided by.
    pub fn normalisation(&self) -> [f64; 3] {
        let sun_angle = self.sun.y.clamp(-1.0, 1.0).acos();
        self.coefficients.map(|coefficients| distribution(&coefficients, 1.0, sun_angle, self.sun.y))
    }
}

/// F(θ, γ). The authors' code keeps cos θ at or above 0.001.
fn distribution(&[a, b, c, d, e]: &[f64; 5], cos_theta: f64, gamma: f64, cos_gamma: f64) -> f64 {
    let gradient = 1.0 + a * (b / cos_theta.max(0.001)).exp();
    let glow = 1.0 + c * (d * gamma).exp() + e * cos_gamma * cos_gamma;
    gradient * glow
}
