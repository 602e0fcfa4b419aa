//! Rasters at another size.

use rayon::prelude::*;

/// Resamples a raster of `from` = [width, height] samples with so many values each to the size `to`. Samples are vertices:
/// corners stay in the corners, and the first and last row and column stay on the edges and depend on nothing else.
///
/// Both ways by the cubic of Keys 1981 (eq. 4, Catmull–Rom), which passes through the samples and reproduces quadratics;
/// towards fewer samples it widens with their distance, so that what they can't show is averaged. It overshoots at
/// steps: limit the values to what they may be.
pub fn resample(values: &[f32], from: [u32; 2], to: [u32; 2], channels: usize) -> Vec<f32> {
    let [width, height] = from.map(|side| side as usize);
    let [to_width, to_height] = to.map(|side| side as usize);
    let across = taps(width, to_width);
    let mut wide = vec![0.0_f32; height * to_width * channels];
    let rows = wide.par_chunks_exact_mut(to_width * channels).zip(values.par_chunks_exact(width * channels));
    rows.for_each(|(to, from)| {
        for (sample, taps) in to.chunks_exact_mut(channels).zip(&across) {
            for (channel, value) in sample.iter_mut().enumerate() {
                let from = from[taps.first * channels + channel..].iter().step_by(channels);
                let sum: f64 =
                    taps.weights.iter().zip(from).map(|(weight, &value)| weight * f64::from(value)).sum();
                *value = sum as f32;
            }
        }
    });

    let down = taps(height, to_height);
    let row_len = to_width * channels;
    let mut resampled = vec![0.0_f32; to_height * row_len];
    resampled.par_chunks_exact_mut(row_len).zip(&down).for_each(|(to, taps)| {
        let mut sums = vec![0.0_f64; row_len];
        for (weight, from) in taps.weights.iter().zip(wide[taps.first * row_len..].chunks_exact(row_len)) {
            for (sum, &value) in sums.iter_mut().zip(from) {
                *sum += weight * f64::from(value);
            }
        }
        for (value, sum) in to.iter_mut().zip(sums) {
            *value = sum as f32;
        }
    });
    resampled
}

/// What one sample is made of.
struct Taps {
    first: usize,
    weights: Vec<f64>,
}

/// The samples and weights for each of `to` samples along a line of `from`.
fn taps(from: usize, to: usize) -> Vec<Taps> {
    let stretch = ((from - 1) as f64 / (to - 1) as f64).max(1.0);
    let last = from as isize - 1;
    (0..to)
        .map(|index| {
            let center = (index * (from - 1)) as f64 / (to - 1) as f64;
            let [low, high] =
                [(center - 2.0 * stretch).ceil() as isize, (center + 2.0 * stretch).floor() as isize];
            let first = low.max(0);
            let mut weights = vec![0.0; (high.min(last) - first + 1) as usize];
            let mut add = |sample: isize, weight: f64| {
                // Beyond an edge the line goes on as its mirror image about the sample on the edge, upside down as well:
                // slopes go on, and what lies on the edge stays as it is.
                let edge = sample.clamp(0, last);
                let mirrored = (2 * edge - sample).clamp(0, last);
                weights[(mirrored - first) as usize] += if edge == sample { weight } else { -weight };
                if edge != sample {
                    weights[(edge - first) as usize] += 2.0 * weight;
                }
            };
            for sample in low..=high {
                add(sample, cubic((sample as f64 - center) / stretch));
            }
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= sum);
            Taps { first: first as usize, weights }
        })
        .collect()
}

/// Keys 1981, eq. 4 with a = −½.
fn cubic(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (1.5 * x - 2.5) * x * x + 1.0
    } else if x < 2.0 {
        ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    } else {
        0.0
    }
}
