//! What reaches each place on the ground: the sun, the sky, the waves of the open sea.

use super::patches::Prepared;
use crate::core::grid::Grid;
use crate::gpu::{
    self, Compute, Gpu, Image, Recorder,
    format::{Rg32f, Rgba32f},
};
use crate::scene::{
    Scene, Shelter,
    shelter::{self, side},
};
use crate::shaders::raster::{glow, shadow};
use std::ops::Range;

/// Images over the ground, as fine as its grid or coarser.
pub struct Exposure {
    /// Height at which the sun comes out (m above the datum), and how far away what hides it is (m).
    pub shadow: Image<Rg32f>,
    pub shelter: Shelter,
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
        let (frame, panorama, height) = (&prepared.frame, &prepared.panorama, &ground.height);
        let exposure = Exposure::new(gpu, ground.grid)?;
        let mut rec = Recorder::new(gpu);
        self.record(&mut rec, scene, prepared, &exposure, 0..cells);
        rec.dispatch(
            &self.glow,
            [cells; 2],
            glow::Push { cells: cells as i32, first: 0 },
            glow::Bindings {
                frame,
                panorama,
                height,
                wetness: &ground.wetness,
                reef: &ground.reef,
                openness: &exposure.shelter.openness,
                shadow: &exposure.shadow,
                glow: &exposure.glow,
            },
        );
        rec.submit()?.wait()?;
        Ok(exposure)
    }

    /// Records the measuring of some rows, of all but the glow.
    pub fn record(
        &self,
        rec: &mut Recorder,
        scene: &Scene,
        prepared: &Prepared,
        exposure: &Exposure,
        rows: Range<u32>,
    ) {
        let ground = &scene.ground;
        let cells = side(ground.grid);
        let (frame, panorama, height) = (&prepared.frame, &prepared.panorama, &ground.height);
        self.shelter.record(rec, ground, frame, &exposure.shelter, rows.clone());
        let push = shadow::Push { cells: cells as i32, first: rows.start as i32 };
        let bindings = shadow::Bindings { frame, panorama, height, shadow: &exposure.shadow };
        rec.dispatch(&self.shadow, [cells, rows.len() as u32], push, bindings);
    }
}

impl Exposure {
    /// Nothing is measured yet: all is 0.
    pub fn new(gpu: &Gpu, grid: Grid) -> gpu::Result<Exposure> {
        let size = [side(grid); 2];
        Ok(Exposure {
            shadow: Image::new(gpu, "shadow", size)?,
            shelter: Shelter::new(gpu, grid)?,
            glow: Image::new(gpu, "glow", size)?,
        })
    }
}
