//! The dome's light on a plane, by the plane's normal.

use glam::DVec3;
use std::f64::consts::PI;

use super::Sky;

/// Coefficients of the irradiance (lux, linear Rec.709) that a plane receives from the sky, as a quadratic in its
/// normal: 1, z, y, x, xz, zy, 3y² − 1, xy, x² − z². The sky's radiance is projected onto spherical harmonics and
/// each band weighted by the cosine's own coefficient (Ramamoorthi & Hanrahan 2001, "An Efficient
/// Representation for Irradiance Environment Maps"). For a constant sky the result is exact.
pub fn sky_irradiance(sky: &Sky) -> [[f32; 3]; 9] {
    let mut sums = [[0.0f64; 3]; 9];
    let mut gather = |view: DVec3, radiance: [f64; 3], solid_angle: f64| {
        for (sum, basis) in sums.iter_mut().zip(basis(view)) {
            for (sum, channel) in sum.iter_mut().zip(radiance) {
                *sum += channel * basis * solid_angle;
            }
        }
    };
    if let Sky::Map(map) = sky {
        // Texel by texel, for the sun in it may be smaller than any sample stands for.
        for (index, texel) in (0..map.width * map.height).zip(&map.texels) {
            let (column, row) = (index % map.width, index / map.width);
            let view = map.direction(f64::from(column) + 0.5, f64::from(row) + 0.5);
            if view.y > 0.0 {
                gather(view, texel.map(f64::from), map.solid_angle(row));
            }
        }
    }
    let rows = if matches!(sky, Sky::Map(_)) { 0 } else { ROWS };
    for row in 0..rows {
        // Uniform in height, so every sample stands for the same solid angle.
        let y = (row as f64 + 0.5) / ROWS as f64;
        let level = (1.0 - y * y).sqrt();
        for column in 0..COLUMNS {
            let azimuth = 2.0 * PI * (column as f64 + 0.5) / COLUMNS as f64;
            let view = DVec3::new(level * azimuth.cos(), y, level * azimuth.sin());
            gather(view, radiance(sky, view), 2.0 * PI / (ROWS * COLUMNS) as f64);
        }
    }
    let mut band = 0;
    sums.map(|sum| {
        let weight = NORMALISATION[band] * NORMALISATION[band] * COSINE[band];
        band += 1;
        sum.map(|channel| (channel * weight) as f32)
    })
}

const ROWS: usize = 256;
const COLUMNS: usize = 256;

/// Linear Rec.709 radiance from the unit vector `view`, cd/m²: the twin of `sky_radiance` in `glsl/lib/sky.glsl`. Clear skies
/// are below the horizon as at it.
pub fn radiance(sky: &Sky, view: DVec3) -> [f64; 3] {
    match sky {
        Sky::None => [0.0; 3],
        Sky::Constant { radiance } => radiance.map(f64::from),
        Sky::Preetham(perez) => perez.radiance(above(view)).map(|channel| channel.max(0.0)),
        Sky::HosekWilkie(model) => model.radiance(above(view)).map(|channel| channel.max(0.0)),
        Sky::Map(map) => map.radiance(view),
    }
}

fn above(view: DVec3) -> DVec3 {
    if view.y < 0.0 { DVec3::new(view.x, 1e-3, view.z).normalize() } else { view }
}

fn basis(DVec3 { x, y, z }: DVec3) -> [f64; 9] {
    [1.0, z, y, x, x * z, z * y, 3.0 * y * y - 1.0, x * y, x * x - z * z]
}

/// Norms of the real spherical harmonics.
const NORMALISATION: [f64; 9] = [
    0.282_094_791_773_878_14,
    0.488_602_511_902_919_9,
    0.488_602_511_902_919_9,
    0.488_602_511_902_919_9,
    1.092_548_430_592_079_2,
    1.092_548_430_592_079_2,
    0.315_391_565_252_520_05,
    1.092_548_430_592_079_2,
    0.546_274_215_296_039_6,
];

/// The clamped cosine's coefficient in each harmonic's band: π, 2π/3, π/4.
const COSINE: [f64; 9] = {
    let (zero, one, two) = (PI, 2.0 * PI / 3.0, PI / 4.0);
    [zero, one, one, one, two, two, two, two, two]
};
