//! Exact distances on a raster (Felzenszwalb & Huttenlocher 2012, "Distance Transforms of Sampled Functions").

use rayon::prelude::*;

/// In place of a distance where there is nothing to be near to, metres.
pub const FAR: f32 = 1e9;

/// Distance from every sample of a square raster to the nearest sample that `is_target`, metres. Samples are `cell`
/// metres apart and numbered row by row.
pub fn distances(side: usize, cell: f32, is_target: impl Fn(usize) -> bool + Sync) -> Vec<f32> {
    let mut along_rows = vec![NOTHING; side * side];
    along_rows.par_chunks_exact_mut(side).enumerate().for_each(|(row, distances)| {
        sweep(distances, |column| is_target(row * side + column));
    });
    let columns: Vec<Vec<f32>> = (0..side)
        .into_par_iter()
        .map(|column| {
            let squares = (0..side).map(|row| {
                let across = along_rows[row * side + column];
                (across != NOTHING).then(|| i64::from(across) * i64::from(across))
            });
            let metres = |square: i64| (square as f64).sqrt() as f32 * cell;
            lower_envelope(squares).into_iter().map(|square| square.map_or(FAR, metres)).collect()
        })
        .collect();
    let mut distances = vec![0.0; side * side];
    distances.par_chunks_exact_mut(side).enumerate().for_each(|(row, distances)| {
        for (distance, column) in distances.iter_mut().zip(&columns) {
            *distance = column[row];
        }
    });
    distances
}

/// In place of a number of samples.
const NOTHING: u32 = u32::MAX;

/// Samples to the nearest target of the same row: once forwards, once backwards.
fn sweep(distances: &mut [u32], is_target: impl Fn(usize) -> bool) {
    let mut nearest = NOTHING;
    for (column, distance) in distances.iter_mut().enumerate() {
        nearest = if is_target(column) { 0 } else { nearest.saturating_add(1) };
        *distance = nearest;
    }
    nearest = NOTHING;
    for distance in distances.iter_mut().rev() {
        nearest = if *distance == 0 { 0 } else { nearest.saturating_add(1) };
        *distance = nearest.min(*distance);
    }
}

/// For each place `p` of a line the least of `f(q) + (p − q)²`: the lower envelope of parabolas. `None` is a place without a
/// parabola, or under none. Whole numbers keep it exact.
fn lower_envelope(values: impl Iterator<Item = Option<i64>>) -> Vec<Option<i64>> {
    let mut least = Vec::new();
    // Parabolas of the envelope, and the first place at which each is the lowest.
    let mut envelope: Vec<(i64, i64, i64)> = Vec::new();
    for (place, value) in (0_i64..).zip(values) {
        least.push(None);
        let Some(value) = value else { continue };
        loop {
            let Some(&(vertex, height, from)) = envelope.last() else {
                envelope.push((place, value, 0));
                break;
            };
            // Where the new one passes below the last one (their equation 1), rounded up to a place.
            let above = (value + place * place) - (height + vertex * vertex);
            let crossing = above.div_euclid(2 * (place - vertex)) + 1;
            if crossing > from {
                envelope.push((place, value, crossing));
                break;
            }
            envelope.pop();
        }
    }
    let mut current = 0;
    for (place, least) in (0_i64..).zip(&mut least) {
        while envelope.get(current + 1).is_some_and(|(_, _, from)| *from <= place) {
            current += 1;
        }
        *least = envelope.get(current).map(|(vertex, height, _)| height + (place - vertex).pow(2));
    }
    least
}
