//! Rasters at another size: what is known in closed form comes out, edges stay edges, and averaging is averaging.

use terrane::core::resample::resample;

/// A surface sampled at the vertices of a square.
fn sampled([width, height]: [u32; 2], surface: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let at = |index: u32, count: u32| f64::from(index) / f64::from(count - 1);
    (0..height)
        .flat_map(|row| (0..width).map(move |column| (column, row)))
        .map(|(column, row)| surface(at(column, width), at(row, height)) as f32)
        .collect()
}

fn largest_difference(one: &[f32], other: &[f32]) -> f32 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).fold(0.0, |largest, (one, other)| (one - other).abs().max(largest))
}

#[test]
fn the_same_size_is_the_same_raster() {
    let values = sampled([31, 17], |x, y| 900.0 * (9.0 * x * y).sin());
    assert_eq!(resample(&values, [31, 17], [31, 17], 1), values);
}

/// Both ways, to the edges and corners.
#[test]
fn a_plane_stays_the_same_plane() {
    let plane = |x: f64, y: f64| 300.0 * x - 120.0 * y + 40.0;
    for (from, to) in
        [([33, 33], [129, 70]), ([128, 100], [505, 127]), ([512, 300], [65, 16]), ([64, 64], [63, 65])]
    {
        let resampled = resample(&sampled(from, plane), from, to, 1);
        let difference = largest_difference(&resampled, &sampled(to, plane));
        // Where fewer samples fall unevenly between the old ones, weights that sum to 1 leave this much.
        assert!(difference < 1e-5 * 420.0, "{from:?} {to:?} {difference}");
    }
}

#[test]
fn a_smooth_surface_is_interpolated_to_a_few_parts_in_a_thousand() {
    let surface = |x: f64, y: f64| 100.0 * (7.0 * x).sin() * (5.0 * y + 1.0).cos();
    let resampled = resample(&sampled([64, 64], surface), [64, 64], [505, 505], 1);
    let difference = largest_difference(&resampled, &sampled([505, 505], surface));
    assert!(difference < 0.3, "{difference}");
    // The nearest sample would be off by several metres: the test can fail.
    let nearest: Vec<f32> =
        sampled([505, 505], |x, y| surface((63.0 * x).round() / 63.0, (63.0 * y).round() / 63.0));
    assert!(largest_difference(&nearest, &sampled([505, 505], surface)) > 3.0);
}

#[test]
fn edges_depend_on_nothing_else_and_corners_stay() {
    let values = sampled([97, 97], |x, y| (40.0 * x).sin() + (31.0 * y * x).cos());
    let mut other = values.clone();
    for row in 1..96 {
        for column in 1..96 {
            other[row * 97 + column] += 1e4;
        }
    }
    for side in [17, 49, 193] {
        let [one, two] = [&values, &other].map(|values| resample(values, [97, 97], [side, side], 1));
        let last = side as usize - 1;
        for index in 0..=last {
            for place in [index, last * (last + 1) + index, index * (last + 1), index * (last + 1) + last] {
                assert_eq!(one[place], two[place], "{side} {index}");
            }
        }
        assert_eq!((one[0], one[last]), (values[0], values[96]));
    }
}

/// What fewer samples can't show is averaged, not sampled here and there.
#[test]
fn noise_finer_than_the_samples_vanishes() {
    let stripes = sampled([513, 513], |x, _| (512.0 * x * std::f64::consts::PI).cos());
    let small = resample(&stripes, [513, 513], [33, 33], 1);
    // What lies within two samples of an edge is drawn towards it.
    let inside = small.iter().enumerate().filter(|(index, _)| (2..31).contains(&(index % 33)));
    let largest = inside.fold(0.0_f32, |largest, (_, value)| largest.max(value.abs()));
    assert!(largest < 0.01, "{largest}");
}

#[test]
fn channels_do_not_mix() {
    let planes = [sampled([20, 30], |x, y| x * y), sampled([20, 30], |x, _| (9.0 * x).cos())];
    let together: Vec<f32> = planes[0].iter().zip(&planes[1]).flat_map(|(one, two)| [*one, *two]).collect();
    let resampled = resample(&together, [20, 30], [33, 16], 2);
    for (channel, plane) in planes.iter().enumerate() {
        let channel: Vec<f32> = resampled.iter().skip(channel).step_by(2).copied().collect();
        assert_eq!(channel, resample(plane, [20, 30], [33, 16], 1));
    }
}
