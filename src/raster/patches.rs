//! Bounds of the ground's patches, and the frame that is built on them.

use glam::Vec3;

use super::Quality;
use crate::core::camera::{Pinhole, direction};
use crate::core::grid::Grid;
use crate::gpu::{self, Buffer, Compute, Gpu, Recorder};
use crate::scene::{self, Film, Ground, Scene, View};
use crate::shaders::{Frame, Patch, raster::patches};

/// What a picture's passes share.
pub(super) struct Prepared {
    pub camera: Pinhole,
    /// Radians between neighbouring samples at the picture's centre.
    pub sample_angle: f32,
    pub frame: Buffer<Frame>,
    pub panorama: Buffer<[f32; 3]>,
    pub patches: Buffer<Patch>,
    pub patches_per_side: u32,
}

pub(super) struct Pass(Compute<patches::Shader>);

impl Pass {
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        Ok(Pass(Compute::new(gpu, ())?))
    }

    /// Bounds the ground, places the camera and uploads what every other pass needs to know.
    pub fn prepare(&self, gpu: &Gpu, scene: &Scene, film: &Film, quality: Quality) -> gpu::Result<Prepared> {
        let side = side(scene.ground.grid);
        let patches = Buffer::<Patch>::new(gpu, "patches", (side * side) as usize)?;
        let bounds = self.bound(gpu, &scene.ground, &patches)?;
        let camera = camera(scene, film, &bounds);
        let values = values(scene, film, quality.samples, &camera, top(&bounds));
        let frame = Buffer::new(gpu, "frame", 1)?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&frame, &[values]);
        rec.submit()?.wait()?;
        let panorama = scene::panorama(gpu, &scene.light.sky)?;
        let sample_angle = values.sample_angle;
        Ok(Prepared { camera, sample_angle, frame, panorama, patches, patches_per_side: side })
    }

    /// Bounds every patch of the ground.
    pub fn bound(&self, gpu: &Gpu, ground: &Ground, patches: &Buffer<Patch>) -> gpu::Result<Vec<Patch>> {
        let side = side(ground.grid);
        let mut rec = Recorder::new(gpu);
        rec.dispatch(
            &self.0,
            [side, side],
            patches::Push { cells: ground.grid.cells as i32, patches_per_side: side as i32 },
            patches::Bindings { height: &ground.height, patches },
        );
        let download = rec.download(patches);
        let finished = rec.submit()?.wait()?;
        Ok(download.take(&finished))
    }
}

/// The highest ground.
pub(super) fn top(bounds: &[Patch]) -> f32 {
    bounds.iter().map(|patch| patch.greatest).fold(f32::NEG_INFINITY, f32::max)
}

/// What [`Prepared::frame`] holds.
pub(super) fn values(scene: &Scene, film: &Film, samples: u32, camera: &Pinhole, top: f32) -> Frame {
    Frame { patches: side(scene.ground.grid) as i32, top, ..scene::frame(scene, film, samples, camera) }
}

/// Patches along one side of this grid.
pub(super) fn side(grid: Grid) -> u32 {
    // Eight cells to a patch can be divided far below a cell; more patches would only cost.
    ((grid.cells - 1) / 8).clamp(16, 256)
}

/// The scene's own camera, on ground with these bounds.
pub(super) fn camera(scene: &Scene, film: &Film, bounds: &[Patch]) -> Pinhole {
    let aspect = film.width as f32 / film.height as f32;
    let fov = scene.camera.fov;
    match scene.camera.view {
        View::LookAt { position, target, roll } => {
            Pinhole::look_at(position, target, fov, aspect).rolled(roll)
        }
        View::FrameIsland { azimuth, elevation, distance } => {
            let boxes = land(scene, bounds, side(scene.ground.grid));
            Pinhole::frame(&boxes, -direction(azimuth, elevation), distance, fov, aspect)
        }
    }
}

/// Boxes round the land above the sea, one a patch; where there is none, the sea above all of the ground.
fn land(scene: &Scene, bounds: &[Patch], side: u32) -> Vec<[Vec3; 2]> {
    let sea_level = scene.ground.sea_level;
    let extent = scene.ground.grid.extent;
    let patch_size = extent / side as f32;
    let drowned = bounds.iter().all(|patch| patch.greatest <= sea_level);
    let shown = bounds.iter().enumerate().filter(|(_, patch)| drowned || patch.greatest > sea_level);
    shown
        .map(|(index, patch)| {
            let x = (index as u32 % side) as f32 * patch_size - extent / 2.0;
            let z = (index as u32 / side) as f32 * patch_size - extent / 2.0;
            let [least, greatest] = [patch.least, patch.greatest].map(|height| height.max(sea_level));
            [Vec3::new(x, least, z), Vec3::new(x + patch_size, greatest, z + patch_size)]
        })
        .collect()
}
