//! How far two pictures lie apart: in numbers, and as an eye sees it.

use crate::core::color::{luminance, srgb8_from_linear};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageFloat, FlipImageRgb8};

/// What one channel differs by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Largest absolute difference; infinite where one value is not a number, or infinite, and the other is not the same.
    pub max: f64,
    /// Index of the value that has it.
    pub at: usize,
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean of the squared difference over the squared reference, which is kept from zero by [`NEAR_ZERO`].
    pub relmse: f64,
}

/// Added to squares of the reference (Rousselle, Knaus & Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", §5).
pub const NEAR_ZERO: f64 = 0.01;

impl Difference {
    /// Between a channel of the reference and the same channel of another picture: as many values each.
    pub fn of(reference: &[f32], other: &[f32]) -> Difference {
        let mut found = Difference { max: 0.0, at: 0, rmse: 0.0, relmse: 0.0 };
        let (mut squares, mut relative) = (0.0, 0.0);
        for (index, (&reference, &other)) in reference.iter().zip(other).enumerate() {
            let difference = distance(reference, other);
            if difference > found.max {
                (found.max, found.at) = (difference, index);
            }
            if difference > 0.0 {
                let square = difference * difference;
                squares += square;
                relative += square / (f64::from(reference).powi(2) + NEAR_ZERO);
            }
        }
        let count = reference.len().max(1) as f64;
        let infinite = found.max.is_infinite();
        found.rmse = (squares / count).sqrt();
        // Infinity over infinity is not a number.
        found.relmse = if infinite { f64::INFINITY } else { relative / count };
        found
    }
}

fn distance(reference: f32, other: f32) -> f64 {
    let (reference, other) = (f64::from(reference), f64::from(other));
    if reference == other || reference.is_nan() && other.is_nan() {
        return 0.0;
    }
    let distance = (reference - other).abs();
    if distance.is_nan() { f64::INFINITY } else { distance }
}

/// A colour picture whose differences an eye judges.
pub enum Seen<'a> {
    /// sRGB-encoded, from 0 to 1: as it is on a screen.
    Encoded(&'a [[f32; 3]]),
    /// Scene-linear Rec.709, of any exposure.
    Linear(&'a [[f32; 3]]),
}

/// What FLIP (Andersson et al. 2020) says of two pictures.
pub struct Flip {
    /// From 0 for no difference that is seen to 1.
    pub mean: f64,
    size: [u32; 2],
    errors: Vec<f32>,
}

impl Flip {
    /// Compares two pictures of `size` = [width, height] pixels of the same kind. Linear ones are compared at several exposures, from one at
    /// which the reference's brightest spot is just below white to one at which its median is, and the largest error counts
    /// (Andersson, Nilsson, Shirley & Akenine-Möller 2021, "Visualizing Errors in Rendered High Dynamic Range Images").
    pub fn of(size: [u32; 2], reference: &Seen, other: &Seen) -> Flip {
        let mut errors = vec![0.0f32; size[0] as usize * size[1] as usize];
        for exposure in exposures(reference) {
            let found = flip(size, reference.developed(exposure), other.developed(exposure));
            for (error, found) in errors.iter_mut().zip(found.to_vec()) {
                *error = error.max(found);
            }
        }
        let mean = errors.iter().map(|&error| f64::from(error)).sum::<f64>() / errors.len().max(1) as f64;
        Flip { mean, size, errors }
    }

    /// The error at every pixel as a colour from black over purple to pale yellow: three bytes a pixel, sRGB.
    pub fn picture(&self) -> Vec<u8> {
        let [width, height] = self.size;
        FlipImageFloat::with_data(width, height, &self.errors).apply_color_lut(&nv_flip::magma_lut()).to_vec()
    }
}

fn flip([width, height]: [u32; 2], reference: Vec<u8>, other: Vec<u8>) -> FlipImageFloat {
    let image = |bytes: Vec<u8>| FlipImageRgb8::with_data(width, height, &bytes);
    nv_flip::flip(image(reference), image(other), DEFAULT_PIXELS_PER_DEGREE)
}

impl Seen<'_> {
    fn developed(&self, exposure: f32) -> Vec<u8> {
        let encode = |share: f32| (255.0 * share.clamp(0.0, 1.0) + 0.5) as u8;
        let screen = |linear: f32| srgb8_from_linear(film(exposure * linear.max(0.0)), 0.5);
        match self {
            Seen::Encoded(pixels) => pixels.iter().flat_map(|pixel| pixel.map(encode)).collect(),
            Seen::Linear(pixels) => pixels.iter().flat_map(|pixel| pixel.map(screen)).collect(),
        }
    }
}

/// A ratio of two squares: `(a x² + b x) / (c x² + d x + e)` with `[a, b, c, d, e]`. This one is Narkowicz's fit to the curve of ACES,
/// with its factor of 0.6, as HDR-FLIP has it.
const CURVE: [f32; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];

fn film(linear: f32) -> f32 {
    let [a, b, c, d, e] = CURVE;
    // Where its square would be infinite the curve has long ended.
    let x = linear.min(1e6);
    (x * (a * x + b) / (x * (c * x + d) + e)).clamp(0.0, 1.0)
}

/// Factors to look at the reference with.
fn exposures(reference: &Seen) -> Vec<f32> {
    /// What is just below white.
    const BRIGHT: f32 = 0.85;
    /// Beyond these, differences drown in 8 bits, and a picture with one bright spot would be looked at for ever.
    const MOST: usize = 16;
    let Seen::Linear(pixels) = reference else { return vec![1.0] };
    let mut values: Vec<f32> = pixels
        .iter()
        .map(|&pixel| luminance(pixel))
        .filter(|value| value.is_finite() && *value > 0.0)
        .collect();
    if values.is_empty() {
        return vec![1.0];
    }
    let middle = values.len() / 2;
    let (_, &mut median, brighter) = values.select_nth_unstable_by(middle, f32::total_cmp);
    let brightest = brighter.iter().fold(median, |most, &value| most.max(value));
    // Where the curve is BRIGHT.
    let [a, b, c, d, e] = CURVE;
    let (a, b, c) = (a - BRIGHT * c, b - BRIGHT * d, -BRIGHT * e);
    let bright = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let (start, end) = ((bright / brightest).log2(), (bright / median).log2());
    let count = ((end - start).ceil() as usize).clamp(2, MOST);
    (0..count).map(|step| (start + (end - start) * step as f32 / (count - 1) as f32).exp2()).collect()
}
