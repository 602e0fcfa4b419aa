//! Base terrain (docs/model.md, section 1).

use super::{CHANGE, Ground, HEIGHT, planes::split};
use crate::core::{grid::Grid, hash::mix};
use crate::terrain::layers::{Combine, Generator, Layer};
use rayon::prelude::*;

/// Whether all layers are formulas of the position.
pub fn covers(layers: &[Layer]) -> bool {
    layers.iter().all(|layer| match layer {
        Layer::Crater { .. } => true,
        Layer::Generate { generator, .. } => {
            matches!(generator, Generator::Cone { .. } | Generator::Simplex { .. })
        }
    })
}

pub fn make(grid: Grid, layers: &[Layer], ground: &mut Ground) {
    ground.now.rows_mut().zip(ground.start.rows_mut()).enumerate().for_each(|(y, (now, start))| {
        let [height, change] = split(now, 2);
        let [start] = split(start, 1);
        height.fill(0.0);
        for layer in layers {
            for (x, h) in height.iter_mut().enumerate() {
                *h = layered(layer, grid.position(x as u32, y as u32), *h);
            }
        }
        start.copy_from_slice(height);
        change.fill(0.0);
    });
    const { assert!(HEIGHT == 0 && CHANGE == 1) };
}

fn layered(layer: &Layer, position: [f32; 2], h: f32) -> f32 {
    match layer {
        Layer::Crater { level } => {
            if h > *level {
                2.0 * level - h
            } else {
                h
            }
        }
        Layer::Generate { generator, combine } => combined(*combine, h, value(generator, position)),
    }
}

fn value(generator: &Generator, [x, z]: [f32; 2]) -> f32 {
    match *generator {
        Generator::Cone { height, radius, exponent, center } => {
            let r = (x - center[0]).hypot(z - center[1]);
            if r < radius { height * (1.0 - (r / radius).powf(exponent)) } else { 0.0 }
        }
        Generator::Simplex { amplitude, offset, wavelength, octaves: count, warp, seed } => {
            let (mut p, q) = ([x, z], [x, z]);
            if warp != 0.0 {
                p[0] += warp * octaves(q, wavelength, 3, mix(seed ^ 0x9e37_79b9));
                p[1] += warp * octaves(q, wavelength, 3, mix(seed ^ 0x85eb_ca6b));
            }
            offset + amplitude * octaves(p, wavelength, count, seed)
        }
        Generator::DiamondSquare { .. } | Generator::Heightmap { .. } => 0.0, // not covered
    }
}

fn combined(combine: Combine, h: f32, v: f32) -> f32 {
    match combine {
        Combine::Add => h + v,
        Combine::Multiply => h * v,
        Combine::Power { reference } if h > 0.0 => reference * (h / reference).powf((1.0 + v).max(0.05)),
        Combine::Power { .. } => 0.0,
        Combine::Max => h.max(v),
        Combine::Min => h.min(v),
    }
}

fn octaves([x, z]: [f32; 2], wavelength: f32, count: u32, seed: u32) -> f32 {
    let shift = |bits: u32| (bits >> 8) as f32 / (1 << 20) as f32;
    let mut sum = 0.0;
    for octave in 0..count {
        let seed = mix(seed.wrapping_add(octave));
        let (frequency, weight) = ((1 << octave) as f32 / wavelength, 1.0 / (1 << octave) as f32);
        let east = x * frequency + shift(mix(seed.wrapping_add(0x68bc_21eb)));
        let south = z * frequency + shift(mix(seed.wrapping_add(0x02e5_be93)));
        sum += weight * simplex(east, south, seed);
    }
    sum
}

/// Simplex noise in Gustavson's layout.
fn simplex(x: f32, z: f32, seed: u32) -> f32 {
    const SKEW: f32 = 0.366_025_4; // (√3 − 1)/2
    const UNSKEW: f32 = 0.211_324_87; // (3 − √3)/6
    let t = (x + z) * SKEW;
    let (i, j) = (floor(x + t), floor(z + t));
    let u = (i + j) * UNSKEW;
    let (x0, z0) = (x - (i - u), z - (j - u));
    let (i1, j1) = if x0 > z0 { (1.0, 0.0) } else { (0.0, 1.0) };
    let corner = |di: f32, dj: f32, back: f32| {
        let (x, z) = (x0 - di + back, z0 - dj + back);
        let reach = (0.5 - x * x - z * z).max(0.0);
        let hash =
            mix(((i + di) as i32 as u32).wrapping_add(mix(((j + dj) as i32 as u32).wrapping_add(seed))));
        let [gx, gz] = GRADIENTS[(hash >> 28) as usize];
        reach.powi(4) * (gx * x + gz * z)
    };
    92.07 * (corner(0.0, 0.0, 0.0) + corner(i1, j1, UNSKEW) + corner(1.0, 1.0, 2.0 * UNSKEW))
}

/// The standard one is a call of a function where processors without an instruction for it are served too.
fn floor(value: f32) -> f32 {
    let whole = value as i32 as f32;
    if whole > value { whole - 1.0 } else { whole }
}

/// Unit vectors at odd multiples of π/16.
const GRADIENTS: [[f32; 2]; 16] = {
    const C: [f32; 4] = [0.980_785_25, 0.831_469_6, 0.555_570_24, 0.195_090_32];
    let mut all = [[0.0; 2]; 16];
    let mut k = 0;
    while k < 16 {
        let (c, s) = (C[k % 4], C[3 - k % 4]);
        all[k] = match k / 4 {
            0 => [c, s],
            1 => [-s, c],
            2 => [-c, -s],
            _ => [s, -c],
        };
        k += 1;
    }
    all
};
