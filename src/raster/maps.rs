//! The ground as maps for other programs.

use super::{Exposure, patches::Prepared};
use crate::gpu::{
    self, Compute, Gpu, Image, Recorder,
    format::{R32f, Rgba8, Rgba32f},
};
use crate::scene::Scene;
use crate::shaders::raster::maps;

/// Images as large as the ground's grid.
pub struct Maps {
    /// Degrees.
    pub slope: Image<R32f>,
    /// World (x, −z, y)·½ + ½, and 1.
    pub normal: Image<Rgba32f>,
    /// Weights of grass, rock, sand and sea floor; they sum to 1.
    pub splat: Image<Rgba32f>,
    /// What light the ground scatters back, sRGB, and 1.
    pub albedo: Image<Rgba8>,
}

pub(super) struct Pass(Compute<maps::Shader>);

impl Pass {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        Ok(Pass(Compute::new(gpu, ())?))
    }

    pub fn draw(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        prepared: &Prepared,
        exposure: &Exposure,
    ) -> gpu::Result<Maps> {
        let ground = &scene.ground;
        let size = ground.height.size();
        let maps = Maps {
            slope: Image::new(gpu, "slope", size)?,
            normal: Image::new(gpu, "normal", size)?,
            splat: Image::new(gpu, "splat", size)?,
            albedo: Image::new(gpu, "albedo", size)?,
        };
        let mut rec = Recorder::new(gpu);
        rec.dispatch(
            &self.0,
            size,
            (),
            maps::Bindings {
                frame: &prepared.frame,
                height: &ground.height,
                wetness: &ground.wetness,
                reef: &ground.reef,
                openness: &exposure.shelter.openness,
                slope_map: &maps.slope,
                normal_map: &maps.normal,
                splat_map: &maps.splat,
                albedo_map: &maps.albedo,
            },
        );
        rec.submit()?.wait()?;
        Ok(maps)
    }
}
