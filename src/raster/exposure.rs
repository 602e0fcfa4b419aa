//! What reaches each place on the ground: the sun, the sky, the waves of the open sea.

use super::patches::Prepared;
use crate::core::grid::Grid;
use crate::gpu::{
    self, Compute, Gpu, Image, Recorder,
    format::{R32f, Rg32f, Rgba32f},
};
use crate::scene::Scene;
use crate::shaders::raster::{glow, openness, shadow, surf};

/// Images over the ground, as fine as its grid or coarser.
pub struct Exposure {
    /// Height at which the sun comes out (m above the datum), and how far away what hides it is (m).
    pub shadow: Image<Rg32f>,
    /// Share of the sky's light that arrives, 0…1.
    pub openness: Image<R32f>,
    /// How much of the open sea's waves arrives, 0…1.
    pub surf: Image<R32f>,
    /// Radiance that leaves the ground, cd/m².
    pub glow: Image<Rgba32f>,
}

/// Most samples a side. What the images hold varies smoothly, so that more would cost much and show nothing.
const FINEST: u32 = 1024;

/// Samples a side over this grid.
pub(super) fn side(grid: Grid) -> u32 {
    grid.cells.min(FINEST)
}

pub(super) struct Passes {
    shadow: Compute<shadow::Shader>,
    openness: Compute<openness::Shader>,
    surf: Compute<surf::Shader>,
    glow: Compute<glow::Shader>,
}

impl Passes {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        Ok(Passes {
            shadow: Compute::new(gpu, ())?,
            openness: Compute::new(gpu, ())?,
            surf: Compute::new(gpu, ())?,
            glow: Compute::new(gpu, ())?,
        })
    }

    pub fn measure(&self, gpu: &Gpu, scene: &Scene, prepared: &Prepared) -> gpu::Result<Exposure> {
        let ground = &scene.ground;
        let cells = side(ground.grid);
        let size = [cells; 2];
        let exposure = Exposure {
            shadow: Image::new(gpu, "shadow", size)?,
            openness: Image::new(gpu, "openness", size)?,
            surf: Image::new(gpu, "surf", size)?,
            glow: Image::new(gpu, "glow", size)?,
        };
        let (frame, panorama, height) = (&prepared.frame, &prepared.panorama, &ground.height);
        let mut rec = Recorder::new(gpu);
        rec.concurrent(|rec| {
            let shadow = shadow::Bindings { frame, panorama, height, shadow: &exposure.shadow };
            rec.dispatch(&self.shadow, size, shadow::Push { cells: cells as i32 }, shadow);
            let openness = openness::Bindings { frame, height, openness: &exposure.openness };
            rec.dispatch(&self.openness, size, openness::Push { cells: cells as i32 }, openness);
            let surf = surf::Bindings { frame, height, surf: &exposure.surf };
            rec.dispatch(&self.surf, size, surf::Push { cells: cells as i32 }, surf);
        });
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
                openness: &exposure.openness,
                shadow: &exposure.shadow,
                glow: &exposure.glow,
            },
        );
        rec.submit()?.wait()?;
        Ok(exposure)
    }
}
