//! Pictures out of sums, as files: of `render` and of `merge` the same bytes.

use crate::app::Error;
use crate::formats::{self, exr::Layered, file::Written};
use crate::trace::Sums;
use crate::world::shard::Render;
use std::path::Path;

/// Writes what samples have come to, .exr with its layers or .png. Returns how many values were too large for 16-bit floats, too.
pub fn write(path: &Path, render: &Render, sums: &Sums, half: bool) -> Result<(Written, u64), Error> {
    let crop = sums.crop();
    if formats::extension(path) != "exr" {
        let developed = sums.picture().developed_from(crop.origin, render.film().tone_map);
        return Ok((formats::png::write_picture(path, crop.size, &developed)?, 0));
    }
    let picture = Layered {
        size: crop.size,
        origin: crop.origin,
        whole: render.size,
        white_luminance: 1.0 / render.film().exposure,
        comments: render.comments(sums.samples()),
        channels: sums.channels(),
    };
    Ok(formats::exr::write_layered(path, picture, half)?)
}

/// What there is to say about how sums became a picture.
pub fn warnings(sums: &Sums, clamped: u64) -> Vec<String> {
    let flaws = sums.flaws();
    let sentences = [
        (clamped, "values are too large for 16-bit floats, and were cut off"),
        (flaws.not_finite, "samples were not finite, and count as black: that is a mistake of the program"),
        (flaws.cut_off, "samples were too bright for the sums, and were cut off; lower `render.exposure`"),
    ];
    let said = sentences.into_iter().filter(|(count, _)| *count > 0);
    said.map(|(count, sentence)| format!("{count} {sentence}")).collect()
}
