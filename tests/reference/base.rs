//! Base terrain: layers, each combined with what the ones before it made.

use super::lattice::Lattice;
use super::noise;
use terrane::terrain::Map;
use terrane::terrain::layers::{Combine, Generator, Layer};

pub fn height(lattice: Lattice, layers: &[Layer]) -> Vec<f64> {
    layers.iter().fold(vec![0.0; lattice.len()], |h, layer| match layer {
        Layer::Generate { generator, combine } => {
            let v = generate(lattice, generator);
            h.iter().zip(&v).map(|(&h, &v)| join(h, v, *combine)).collect()
        }
        Layer::Crater { level } => h.iter().map(|&h| crater(h, f64::from(*level))).collect(),
    })
}

/// Catmull–Rom interpolation of a raster stretched over the grid; samples are vertices.
pub fn bicubic(
    lattice: Lattice,
    width: usize,
    height: usize,
    values: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<f64> {
    lattice.map(|i, j| {
        let (column, wx) = catmull_rom(i as f64 / (lattice.n - 1) as f64 * (width - 1) as f64);
        let (row, wz) = catmull_rom(j as f64 / (lattice.n - 1) as f64 * (height - 1) as f64);
        let clamp = |at: isize, size: usize| at.clamp(0, size as isize - 1) as usize;
        let along = |row: usize| -> f64 {
            (0..4).map(|k| wx[k] * values(clamp(column + k as isize - 1, width), row)).sum()
        };
        (0..4).map(|k| wz[k] * along(clamp(row + k as isize - 1, height))).sum()
    })
}

/// Bilinear interpolation with the same mapping.
pub fn bilinear(lattice: Lattice, map: &Map) -> Vec<f64> {
    let value = |i: usize, j: usize| {
        let (i, j) = (i.min(map.width as usize - 1), j.min(map.height as usize - 1));
        f64::from(map.values[j * map.width as usize + i])
    };
    lattice.map(|i, j| {
        let u = i as f64 / (lattice.n - 1) as f64 * f64::from(map.width - 1);
        let v = j as f64 / (lattice.n - 1) as f64 * f64::from(map.height - 1);
        let (i, j, fu, fv) = (u as usize, v as usize, u.fract(), v.fract());
        let along = |j| value(i, j) * (1.0 - fu) + value(i + 1, j) * fu;
        along(j) * (1.0 - fv) + along(j + 1) * fv
    })
}

fn generate(lattice: Lattice, generator: &Generator) -> Vec<f64> {
    match *generator {
        Generator::Cone { height, radius, exponent, center } => lattice.map(|i, j| {
            let [x, z] = lattice.position(i, j);
            let r = (x - f64::from(center[0])).hypot(z - f64::from(center[1])); // (2)
            let share = r / f64::from(radius);
            if share < 1.0 { f64::from(height) * (1.0 - share.powf(f64::from(exponent))) } else { 0.0 } // (1)
        }),
        Generator::Simplex { amplitude, offset, wavelength, octaves, warp, seed } => lattice.map(|i, j| {
            let [x, z] = lattice.position(i, j);
            let noise = noise::warped(x, z, seed, f64::from(wavelength), octaves, f64::from(warp)); // (3)
            f64::from(offset) + f64::from(amplitude) * noise
        }),
        Generator::DiamondSquare { n, init_height, spread, reduction, seed } => {
            let last = 1usize << n;
            let corner = |row, column| f64::from(init_height) * noise::random(seed, row, column);
            let corners = [corner(0, 0), corner(0, last), corner(last, 0), corner(last, last)];
            let random = |row, column| noise::random(seed, row, column);
            let h = noise::diamond_square(n, corners, f64::from(spread), f64::from(reduction), random);
            bicubic(lattice, last + 1, last + 1, |i, j| h[j * (last + 1) + i])
        }
        Generator::Heightmap { ref map } => {
            let width = map.width as usize;
            bicubic(lattice, width, map.height as usize, |i, j| f64::from(map.values[j * width + i]))
        }
    }
}

fn join(h: f64, v: f64, combine: Combine) -> f64 {
    match combine {
        Combine::Add => h + v,
        Combine::Multiply => h * v,
        Combine::Power { .. } if h <= 0.0 => 0.0,
        Combine::Power { reference } => {
            let reference = f64::from(reference);
            reference * (h / reference).powf((1.0 + v).max(0.05)) // (4) on normalised height
        }
        Combine::Max => h.max(v),
        Combine::Min => h.min(v),
    }
}

/// (5)
fn crater(h: f64, level: f64) -> f64 {
    if h > level { 2.0 * level - h } else { h }
}

/// The sample before `u` and the weights of the four round it (Catmull & Rom 1974).
fn catmull_rom(u: f64) -> (isize, [f64; 4]) {
    let f = u.fract();
    let weights = [
        ((-0.5 * f + 1.0) * f - 0.5) * f,
        (1.5 * f - 2.5) * f * f + 1.0,
        ((-1.5 * f + 2.0) * f + 0.5) * f,
        (0.5 * f - 0.5) * f * f,
    ];
    (u as isize, weights)
}
