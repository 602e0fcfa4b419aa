//! Hosek & Wilkie's sky ("An Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012), whose fitted numbers come from
//! the crate `hw-skymodel`: those of the authors' RGB version, in linear Rec.709.

use crate::scene::{HosekWilkie, Sky};
use glam::DVec3;
use hw_skymodel::rgb::{SkyParams, SkyState};

/// What the authors fitted.
pub const TURBIDITY: [f64; 2] = [1.0, 10.0];

/// Lumens of a watt of the eye's best colour: the fit is of radiances in W m⁻² sr⁻¹ weighted with the colour matching functions.
const LUMENS_PER_WATT: f64 = 683.0;

/// The sky of `turbidity` over ground that scatters back the share `albedo`, with the sun in direction `sun` (unit, world axes); a
/// sun below the horizon lights the sky as from the horizon. No sky for what lies outside the fit.
pub fn sky(turbidity: f64, albedo: f64, sun: DVec3) -> Sky {
    let level = DVec3::new(sun.x, 0.0, sun.z).try_normalize().unwrap_or(DVec3::X);
    let sun = if sun.y < 0.0 { level } else { sun };
    let parameters = SkyParams {
        elevation: (sun.y.clamp(0.0, 1.0).asin() as f32).min(std::f32::consts::FRAC_PI_2),
        turbidity: turbidity as f32,
        albedo: [albedo as f32; 3],
    };
    let Ok(state) = SkyState::new(&parameters) else { return Sky::None };
    let (distribution, radiance) = state.raw();
    let channel = |channel: usize| std::array::from_fn(|index| f64::from(distribution[9 * channel + index]));
    Sky::HosekWilkie(HosekWilkie {
        sun,
        distribution: std::array::from_fn(channel),
        radiance: radiance.map(|channel| LUMENS_PER_WATT * f64::from(channel)),
    })
}
