//! Pictures out of sums, as files: of `render` and of `merge` the same bytes.

use crate::app::Error;
use crate::app::denoise::{Denoiser, PROGRAM};
use crate::formats::{self, exr::Layered, file::Written};
use crate::scene::Picture;
use crate::trace::Sums;
use crate::world::shard::Render;
use clap::Args;
use std::path::Path;

/// What becomes of a traced picture when it is written.
#[derive(Args)]
pub struct Finish {
    /// Write 16-bit floats to EXR
    #[arg(long)]
    pub half: bool,

    /// Take the noise out of the finished picture with Intel Open Image Denoise: its program must be there. An EXR keeps the
    /// picture as it was, as noisy.R, noisy.G and noisy.B
    #[arg(long, value_name = "PROGRAM", num_args = 0..=1, require_equals = true, default_missing_value = PROGRAM)]
    pub denoise: Option<String>,
}

impl Finish {
    /// Finds the program that takes noise out, if that is asked for.
    pub fn denoiser(&self) -> Result<Option<Denoiser>, Error> {
        self.denoise.as_deref().map(Denoiser::find).transpose()
    }
}

/// Writes what samples have come to, .exr with its layers or .png. Returns how many values were too large for 16-bit floats, too.
pub fn write(
    path: &Path,
    render: &Render,
    sums: &Sums,
    half: bool,
    denoiser: Option<&Denoiser>,
) -> Result<(Written, u64), Error> {
    let crop = sums.crop();
    let mut channels = None;
    if let Some(denoiser) = denoiser {
        denoiser.clean(crop.size, channels.insert(sums.channels()))?;
    }
    if formats::extension(path) != "exr" {
        let picture = channels.map_or_else(|| sums.picture(), |channels| Picture::of(crop.size, &channels));
        let developed = picture.developed_from(crop.origin, render.film().tone_map);
        return Ok((formats::png::write_picture(path, crop.size, &developed)?, 0));
    }
    let picture = Layered {
        size: crop.size,
        origin: crop.origin,
        whole: render.size,
        white_luminance: 1.0 / render.film().exposure,
        comments: render.comments(sums.samples()),
        channels: channels.unwrap_or_else(|| sums.channels()),
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
