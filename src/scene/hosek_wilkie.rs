//! Hosek & Wilkie's distribution of a clear sky's light over the dome, as makers hand it to renderers.

use glam::DVec3;

/// Linear Rec.709 radiance over the dome, each channel with numbers of its own: `radiance · (1 + A e^{B/(cos θ + 0.01)}) (C +
/// D e^{Eγ} + F cos²γ + G χ(H, γ) + I √cos θ)`, `χ(H, γ) = (1 + cos²γ) / (1 + H² − 2H cos γ)^{3/2}` (Hosek & Wilkie 2012, "An
/// Analytic Model for Full Spectral Sky-Dome Radiance", equation 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HosekWilkie {
    /// Unit vector towards the sun, world axes, at or above the horizon.
    pub sun: DVec3,
    /// A, B, C, D, E, F, G, I, H, in the order of the authors' program, for red, green and blue.
    pub distribution: [[f64; 9]; 3],
    /// What the distribution is multiplied by, cd/m².
    pub radiance: [f64; 3],
}

impl HosekWilkie {
    /// From the unit vector `view`, at or above the horizon, cd/m².
    pub fn radiance(&self, view: DVec3) -> [f64; 3] {
        let cos_theta = view.y.max(0.0);
        let cos_gamma = view.dot(self.sun);
        // acos loses half the digits near the sun; the chord does not.
        let gamma = 2.0 * (0.5 * view.distance(self.sun)).min(1.0).asin();
        let ray = cos_gamma * cos_gamma;
        std::array::from_fn(|channel| {
            let [a, b, c, d, e, f, g, i, h] = self.distribution[channel];
            let haze = (1.0 + ray) / (1.0 + h * h - 2.0 * h * cos_gamma).powf(1.5);
            let gradient = 1.0 + a * (b / (cos_theta + 0.01)).exp();
            let glow = c + d * (e * gamma).exp() + f * ray + g * haze + i * cos_theta.sqrt();
            self.radiance[channel] * gradient * glow
        })
    }
}
