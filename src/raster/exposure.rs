//! What reaches each place on the ground: the sun, the sky, the waves of the open sea.

use super::patches::Prepared;
use crate::gpu::{
    self, Compute, Gpu, Image, Recorder,
    format::{R32f, Rg32f, Rgba32f},
};
use crate::scene::{
    Scene, Shelter,
    shelter::{self, side},
};
use crate::shaders::raster::{glow, shadow};

/// Images over the ground, as fine as its grid or coarser.
pub struct Exposure {
    /// Height at which the sun comes out (m above the datum), and how far away what hides it is (m).
    pub shadow: Image<Rg32f>,
    /// As [`Shelter`] says.
    pub openness: Image<R32f>,
    pub surf: Image<R32f>,
    /// Radiance that leaves the ground, cd/m².
    pub glow: Image<Rgba32f>,
}

pub(super) struct Passes {
    shelter: shelter::Passes,
    shadow: Compute<shadow::Shader>,
    glow: Compute<glow::Shader>,
}

impl Passes {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        Ok(Passes {
            shelter: shelter::Passes::new(gpu)?,
            shadow: Compute::new(gpu, ())?,
            glow: Compute::new(gpu, ())?,
        })
    }

    pub fn measure(&self, gpu: &Gpu, scene: &Scene, prepared: &Prepared) -> gpu::Result<Exposure> {
        let ground = &scene.ground;
        let cells = side(ground.grid);
        let size = [cells; 2];
        let (frame, panorama, height) = (&prepared.frame, &prepared.panorama, &ground.height);
        let Shelter { openness, surf } = self.shelter.measure(gpu, ground, frame)?;
        let (shadow, glow) = (Image::new(gpu, "shadow", size)?, Image::new(gpu, "glow", size)?);
        let mut rec = Recorder::new(gpu);
        let bindings = shadow::Bindings { frame, panorama, height, shadow: &shadow };
        rec.dispatch(&self.shadow, size, shadow::Push { cells: cells as i32 }, bindings);
        rec.dispatch(
            &self.glow,
            size,
            glow::Push { cells: cells as i32 },
            glow::Bindings {
                frame,
                panorama,
                height,
                wetness: &ground.wetness,
                reef: &ground.reef,
                openness: &openness,
                shadow: &shadow,
                glow: &glow,
            },
        );
        rec.submit()?.wait()?;
        Ok(Exposure { shadow, openness, surf, glow })
    }
}
