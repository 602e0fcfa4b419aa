//! Pictures for screens, made on the device: what [`super::Picture::developed`] makes on the host.

use super::ToneMap;
use crate::gpu::{
    self, Compute, Gpu, Image, Recorder,
    format::{Rgba8, Rgba32f},
};
use crate::shaders::scene::develop;
use std::ops::Range;

/// Makes pixels of samples.
pub struct Developer {
    clamped: Compute<develop::Shader>,
    filmic: Compute<develop::Shader>,
}

/// How samples become pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Factor to linear light, of which 1 is then the film's white.
    pub exposure: f32,
    pub tone_map: ToneMap,
}

impl Developer {
    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        // As glsl/lib/tone_map.glsl numbers them.
        let program = |tone_map| Compute::new(gpu, develop::Constants { tone_map });
        Ok(Developer { clamped: program(0)?, filmic: program(1)? })
    }

    /// Records the development of all of `target`: 8-bit sRGB and 255, of linear Rec.709, of which `light` has a square of
    /// samples for every pixel.
    pub fn develop(
        &self,
        rec: &mut Recorder,
        light: &Image<Rgba32f>,
        target: &Image<Rgba8>,
        development: Development,
    ) {
        self.develop_rows(rec, light, target, development, 0..target.size()[1]);
    }

    /// The same of some rows of pixels.
    pub fn develop_rows(
        &self,
        rec: &mut Recorder,
        light: &Image<Rgba32f>,
        target: &Image<Rgba8>,
        development: Development,
        rows: Range<u32>,
    ) {
        let program = match development.tone_map {
            ToneMap::None => &self.clamped,
            ToneMap::Filmic => &self.filmic,
        };
        let push = develop::Push { exposure: development.exposure, first: rows.start as i32 };
        let size = [target.size()[0], rows.len() as u32];
        rec.dispatch(program, size, push, develop::Bindings { radiance: light, picture: target });
    }
}
