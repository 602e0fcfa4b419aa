//! Pictures compared as an eye sees them.

use image::RgbImage;
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool};

/// Mean FLIP difference (Andersson et al. 2020) of two pictures of one size.
pub fn flip(reference: &RgbImage, found: &RgbImage) -> f32 {
    assert_eq!(reference.dimensions(), found.dimensions());
    let image = |it: &RgbImage| FlipImageRgb8::with_data(it.width(), it.height(), it);
    let errors = nv_flip::flip(image(reference), image(found), DEFAULT_PIXELS_PER_DEGREE);
    FlipPool::from_image(&errors).mean()
}
