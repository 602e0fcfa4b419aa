//! Layers of the land in false colours, over a picture.

use crate::gpu::{
    self, Buffer, Compute, Gpu, Image, Recorder,
    format::{R32f, Rgba8, Rgba32f},
};
use crate::shaders::{Frame, raster::overlay};
use std::ops::Range;

/// What is laid over a picture.
#[derive(Clone, Debug)]
pub struct Overlay {
    pub shown: Shown,
    /// 0 shows the picture alone, 1 the colours alone.
    pub opacity: f32,
}

/// A layer of the land, one texel a sample of the grid.
#[derive(Clone, Debug)]
pub enum Shown {
    /// Values in the colours of [`COLOURS`], of which the first stands for the first bound and all below, and the last for the second
    /// one and all above.
    Values { image: Image<R32f>, bounds: [f32; 2], scale: Scale },
    /// Shares of the [`MATERIALS`]; they sum to 1.
    Materials(Image<Rgba32f>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// For values that run through powers of ten. Bounds are greater than 0.
    Logarithmic,
}

/// Ten colours at equal distances along viridis, sRGB (van der Walt & Smith 2015, "A Better Default Colormap for Matplotlib": its lightness
/// rises evenly, to eyes that do not tell red from green, too). Between them colours are mixed as encoded.
pub const COLOURS: [[u8; 3]; 10] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x28, 0x78],
    [0x3e, 0x4a, 0x89],
    [0x31, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6d, 0xcd, 0x59],
    [0xb4, 0xde, 0x2c],
    [0xfd, 0xe7, 0x25],
];

/// Materials of the ground and their colours, sRGB (Okabe & Ito 2008, "Color Universal Design": told apart by eyes that do not tell red from
/// green, too).
pub const MATERIALS: [(&str, [u8; 3]); 4] = [
    ("grass", [0x00, 0x9e, 0x73]),
    ("rock", [0xd5, 0x5e, 0x00]),
    ("sand", [0xf0, 0xe4, 0x42]),
    ("sea floor", [0x56, 0xb4, 0xe9]),
];

impl Shown {
    /// The colour of a value, sRGB; of the materials the one of this number.
    pub fn colour(&self, value: f32) -> [u8; 3] {
        match self {
            Shown::Values { bounds, scale, .. } => colour(scale.share(*bounds, value)),
            Shown::Materials(_) => MATERIALS[(value.max(0.0) as usize).min(MATERIALS.len() - 1)].1,
        }
    }
}

impl Scale {
    /// How far between two bounds a value lies, 0…1.
    pub fn share(self, bounds: [f32; 2], value: f32) -> f32 {
        let [low, high, value] = match self {
            Scale::Linear => [bounds[0], bounds[1], value],
            Scale::Logarithmic => [bounds[0], bounds[1], value.max(bounds[0])].map(f32::ln),
        };
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }
}

/// The colour of a share of the way along [`COLOURS`], sRGB: for legends.
pub fn colour(share: f32) -> [u8; 3] {
    // What is no number is the least.
    let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
    let at = share * (COLOURS.len() - 1) as f32;
    let below = (at as usize).min(COLOURS.len() - 2);
    let mix = |channel: usize| {
        let [from, to] = [below, below + 1].map(|index| f32::from(COLOURS[index][channel]));
        (from + (to - from) * (at - below as f32)).round() as u8
    };
    [0, 1, 2].map(mix)
}

pub(super) struct Pass {
    pass: Compute<overlay::Shader>,
    colours: Buffer<[f32; 3]>,
    materials: Buffer<[f32; 3]>,
    /// In place of what a layer is not.
    no_values: Image<R32f>,
    no_weights: Image<Rgba32f>,
}

impl Pass {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        let encoded = |colours: &[[u8; 3]]| -> Vec<[f32; 3]> {
            colours.iter().map(|colour| colour.map(|channel| f32::from(channel) / 255.0)).collect()
        };
        Ok(Pass {
            pass: Compute::new(gpu, ())?,
            colours: super::population::shapes::upload(gpu, "colours", &encoded(&COLOURS))?,
            materials: super::population::shapes::upload(
                gpu,
                "colours",
                &encoded(&MATERIALS.map(|(_, colour)| colour)),
            )?,
            no_values: Image::new(gpu, "no layer", [1; 2])?,
            no_weights: Image::new(gpu, "no layer", [1; 2])?,
        })
    }

    /// Lays it over some rows of pixels of `picture`, each of a square of samples of `range`.
    pub fn record(
        &self,
        rec: &mut Recorder,
        overlay: &Overlay,
        (frame, range): (&Buffer<Frame>, &Image<R32f>),
        picture: &Image<Rgba8>,
        rows: Range<u32>,
    ) {
        // As the shader numbers scales.
        let (values, weights, colours, bounds, scale) = match &overlay.shown {
            Shown::Values { image, bounds, scale } => {
                let number = match scale {
                    Scale::Linear => 0,
                    Scale::Logarithmic => 1,
                };
                (image, &self.no_weights, &self.colours, *bounds, number)
            }
            Shown::Materials(weights) => (&self.no_values, weights, &self.materials, [0.0, 1.0], 2),
        };
        rec.dispatch(
            &self.pass,
            [picture.size()[0], rows.len() as u32],
            overlay::Push {
                bounds,
                opacity: overlay.opacity.clamp(0.0, 1.0),
                scale,
                first: rows.start as i32,
            },
            overlay::Bindings { frame, range, values, weights, colours, picture },
        );
    }
}
