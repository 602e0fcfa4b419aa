//! What pictures of a scene have in common wherever the camera is, and whichever plants it sees: land, models and sky.

use super::tree::Parts;
use super::{Tracer, sky, upload};
use crate::core::camera::Pinhole;
use crate::gpu::{self, Buffer, Recorder};
use crate::scene::{self, Film, Scene, Shelter, ToneMap};
use crate::shaders::Frame;
use glam::Vec3;

/// On the device, made once for all frames of a film.
pub struct Assets {
    pub(super) parts: Parts,
    pub(super) panorama: Buffer<[f32; 3]>,
    /// What `glsl/lib/dome.glsl` looks for light by.
    pub(super) dome: Buffer<f32>,
    pub(super) shelter: Shelter,
}

impl Assets {
    pub(super) fn new(tracer: &Tracer, scene: &Scene) -> gpu::Result<Assets> {
        let gpu = &tracer.gpu;
        let (ground, sky) = (&scene.ground, &scene.light.sky);
        let mut rec = Recorder::new(gpu);
        let heights = rec.download(&ground.height);
        let heights = heights.take(&rec.submit()?.wait()?);
        let frame = upload(gpu, "frame", &[unseen(scene)])?;
        Ok(Assets {
            parts: Parts::new(gpu, scene, &heights, tracer.rays.traversal())?,
            panorama: scene::panorama(gpu, sky)?,
            dome: upload(gpu, "dome", &sky::table(sky))?,
            shelter: tracer.shelter.measure(gpu, ground, &frame)?,
        })
    }
}

/// The frame of a scene for what neither film nor camera matter to.
pub(super) fn unseen(scene: &Scene) -> Frame {
    let film = Film { width: 1, height: 1, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_along(Vec3::ZERO, Vec3::NEG_Z, 1.0, 1.0);
    scene::frame(scene, &film, 1, &camera)
}
