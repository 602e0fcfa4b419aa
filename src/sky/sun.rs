//! The sun: where it stands and what it gives.

use glam::{DVec3, Vec3};
use std::f64::consts::PI;

use crate::core::color::rec709_from_xyz;
use crate::scene;

/// A place on Earth and a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// North-positive, radians.
    pub latitude: f64,
    /// East-positive, radians.
    pub longitude: f64,
    /// Hours that the clock is ahead of UTC.
    pub utc_offset: f64,
    /// Day of the year, 1…365.
    pub day: f64,
    /// Clock time, hours; no summer time.
    pub time: f64,
}

/// Where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Angle from the zenith, radians; more than π/2 at night.
    pub zenith: f64,
    /// Clockwise from north, radians, 0…2π.
    pub azimuth: f64,
}

impl Position {
    /// The sun's place in the sky (Preetham et al. 1999, appendix A.6, in its authors' coded form: the sign of
    /// `sin l cos δ` in the azimuth is often misprinted). Agrees with an almanac to about 1°.
    pub fn at(place: &Place) -> Self {
        let Place { latitude, longitude, utc_offset, day, time } = *place;
        let equation_of_time =
            0.170 * (4.0 * PI * (day - 80.0) / 373.0).sin() - 0.129 * (2.0 * PI * (day - 8.0) / 355.0).sin();
        let solar_time = time + equation_of_time - utc_offset + longitude.to_degrees() / 15.0;
        let declination = 0.4093 * (2.0 * PI * (day - 81.0) / 368.0).sin();
        let (sin_hour, cos_hour) = (PI * solar_time / 12.0).sin_cos();
        let (sin_latitude, cos_latitude) = latitude.sin_cos();
        let (sin_declination, cos_declination) = declination.sin_cos();
        let height = sin_latitude * sin_declination - cos_latitude * cos_declination * cos_hour;
        let from_south = (-cos_declination * sin_hour)
            .atan2(-(cos_latitude * sin_declination + sin_latitude * cos_declination * cos_hour));
        Position {
            zenith: PI / 2.0 - height.clamp(-1.0, 1.0).asin(),
            azimuth: (from_south + PI).rem_euclid(2.0 * PI),
        }
    }

    /// Unit vector towards the sun, world axes (x east, y up, z south).
    pub fn direction(self) -> DVec3 {
        let (sin_zenith, cos_zenith) = self.zenith.sin_cos();
        let (sin_azimuth, cos_azimuth) = self.azimuth.sin_cos();
        DVec3::new(sin_azimuth * sin_zenith, cos_zenith, -cos_azimuth * sin_zenith)
    }
}

/// The sun of `position` through air of `turbidity`; `None` at or below the horizon.
pub fn sun(position: Position, turbidity: f64) -> Option<scene::Sun> {
    if position.zenith >= PI / 2.0 {
        return None;
    }
    let radiance = rec709_from_xyz(disc_radiance_xyz(turbidity, position.zenith));
    let direction = position.direction();
    Some(scene::Sun {
        direction: Vec3::new(direction.x as f32, direction.y as f32, direction.z as f32),
        // A red sun's blue lies outside Rec.709.
        irradiance: radiance.map(|channel| (channel * SOLID_ANGLE).max(0.0) as f32),
        diameter: DIAMETER as f32,
    })
}

/// Angle under which the disc is seen, radians: its diameter over its distance, 10⁹ m.
pub const DIAMETER: f64 = 1.39 / 150.0;

/// Solid angle of the disc, sr.
pub const SOLID_ANGLE: f64 = 0.25 * PI * DIAMETER * DIAMETER;

/// Luminous radiance of the disc as CIE XYZ (Y in cd/m²), summed over 380…750 nm in steps of 1 nm with the
/// analytic colour matching functions of Wyman, Sloan & Shirley (JCGT 2013).
pub fn disc_radiance_xyz(turbidity: f64, zenith: f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for nanometre in 380..=750 {
        let wavelength = f64::from(nanometre);
        let radiance = disc_spectral_radiance(turbidity, zenith, wavelength);
        for (sum, matching) in xyz.iter_mut().zip(color_matching(wavelength)) {
            *sum += LUMENS_PER_WATT * radiance * matching;
        }
    }
    xyz
}

/// Radiance of the disc at `wavelength` (nm), W m⁻² nm⁻¹ sr⁻¹, behind molecules, haze, ozone, mixed gases and
/// water vapour (Preetham et al. 1999, appendix A.1, after Iqbal 1983).
pub fn disc_spectral_radiance(turbidity: f64, zenith: f64, wavelength: f64) -> f64 {
    let m = optical_mass(zenith);
    let micrometres = wavelength / 1000.0;
    let beta = 0.046_083_658_220_50 * turbidity - 0.045_860_259_285_22;
    let rayleigh = 0.008735 * m * micrometres.powf(-4.08);
    let aerosol = beta * m * micrometres.powf(-1.3);
    let ozone = OZONE * interpolate(&OZONE_ABSORPTION, wavelength) * m;
    let kg = interpolate(&GAS_ABSORPTION, wavelength) * m;
    let gases = 1.41 * kg / (1.0 + 118.93 * kg).powf(0.45);
    let kw = interpolate(&VAPOUR_ABSORPTION, wavelength) * WATER * m;
    let vapour = 0.2385 * kw / (1.0 + 20.07 * kw).powf(0.45);
    100.0 * solar_radiance(wavelength) * (-(rayleigh + aerosol + ozone + gases + vapour)).exp()
}

/// Length of the sun's path through the air, 1 at the zenith (Kasten 1966).
pub fn optical_mass(zenith: f64) -> f64 {
    1.0 / (zenith.cos() + 0.15 * (93.885 - zenith.to_degrees()).powf(-1.253))
}

/// Ozone in a vertical column, cm.
const OZONE: f64 = 0.35;
/// Precipitable water in a vertical column, cm.
const WATER: f64 = 2.0;
const LUMENS_PER_WATT: f64 = 683.0;

fn color_matching(wavelength: f64) -> [f64; 3] {
    let lobe = |centre: f64, left: f64, right: f64| {
        let t = (wavelength - centre) / if wavelength < centre { left } else { right };
        (-0.5 * t * t).exp()
    };
    [
        1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
        0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
        1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
    ]
}

/// Piecewise linear in a table of (nm, value); 0 outside.
fn interpolate(table: &[[f64; 2]], wavelength: f64) -> f64 {
    table
        .windows(2)
        .find(|pair| (pair[0][0]..=pair[1][0]).contains(&wavelength))
        .map_or(0.0, |pair| lerp(pair[0], pair[1], wavelength))
}

fn lerp([x0, y0]: [f64; 2], [x1, y1]: [f64; 2], x: f64) -> f64 {
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

/// The sun above the air, hundreds of W m⁻² nm⁻¹ sr⁻¹.
fn solar_radiance(wavelength: f64) -> f64 {
    let position = (wavelength - 380.0) / 10.0;
    let index = position.floor().clamp(0.0, (SOLAR.len() - 2) as f64) as usize;
    SOLAR[index] + (SOLAR[index + 1] - SOLAR[index]) * (position - index as f64)
}

/// 380…750 nm in steps of 10 nm: the table of the authors' code, from Iqbal, "An Introduction to Solar Radiation"
/// (1983), as are the three absorption spectra below, (nm, 1/cm).
const SOLAR: [f64; 38] = [
    165.5, 162.3, 211.2, 258.8, 258.2, 242.3, 267.6, 296.6, 305.4, 300.6, 306.6, 288.3, 287.1, 278.2, 271.0,
    272.3, 263.6, 255.0, 250.6, 253.1, 253.5, 251.3, 246.3, 241.7, 236.8, 232.1, 228.2, 223.4, 219.7, 215.3,
    211.0, 207.3, 202.4, 198.7, 194.3, 190.7, 186.3, 182.6,
];

/// Ozone.
const OZONE_ABSORPTION: [[f64; 2]; 64] = [
    [300.0, 10.0],
    [305.0, 4.8],
    [310.0, 2.7],
    [315.0, 1.35],
    [320.0, 0.8],
    [325.0, 0.38],
    [330.0, 0.16],
    [335.0, 0.075],
    [340.0, 0.04],
    [345.0, 0.019],
    [350.0, 0.007],
    [355.0, 0.0],
    [445.0, 0.003],
    [450.0, 0.003],
    [455.0, 0.004],
    [460.0, 0.006],
    [465.0, 0.008],
    [470.0, 0.009],
    [475.0, 0.012],
    [480.0, 0.014],
    [485.0, 0.017],
    [490.0, 0.021],
    [495.0, 0.025],
    [500.0, 0.03],
    [505.0, 0.035],
    [510.0, 0.04],
    [515.0, 0.045],
    [520.0, 0.048],
    [525.0, 0.057],
    [530.0, 0.063],
    [535.0, 0.07],
    [540.0, 0.075],
    [545.0, 0.08],
    [550.0, 0.085],
    [555.0, 0.095],
    [560.0, 0.103],
    [565.0, 0.11],
    [570.0, 0.12],
    [575.0, 0.122],
    [580.0, 0.12],
    [585.0, 0.118],
    [590.0, 0.115],
    [595.0, 0.12],
    [600.0, 0.125],
    [605.0, 0.13],
    [610.0, 0.12],
    [620.0, 0.105],
    [630.0, 0.09],
    [640.0, 0.079],
    [650.0, 0.067],
    [660.0, 0.057],
    [670.0, 0.048],
    [680.0, 0.036],
    [690.0, 0.028],
    [700.0, 0.023],
    [710.0, 0.018],
    [720.0, 0.014],
    [730.0, 0.011],
    [740.0, 0.01],
    [750.0, 0.009],
    [760.0, 0.007],
    [770.0, 0.004],
    [780.0, 0.0],
    [790.0, 0.0],
];

/// Uniformly mixed gases.
const GAS_ABSORPTION: [[f64; 2]; 4] = [[759.0, 0.0], [760.0, 3.0], [770.0, 0.21], [771.0, 0.0]];

/// Water vapour.
const VAPOUR_ABSORPTION: [[f64; 2]; 13] = [
    [689.0, 0.0],
    [690.0, 0.016],
    [700.0, 0.024],
    [710.0, 0.0125],
    [720.0, 1.0],
    [730.0, 0.87],
    [740.0, 0.061],
    [750.0, 0.001],
    [760.0, 1e-05],
    [770.0, 1e-05],
    [780.0, 0.0006],
    [790.0, 0.0175],
    [800.0, 0.036],
];
