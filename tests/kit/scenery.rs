//! Scenes to draw: plain ground, and an island in the light of an afternoon.

use super::stage::{self, upload};
use glam::Vec3;
use terrane::core::grid::Grid;
use terrane::gpu::Gpu;
use terrane::scene::{Camera, Light, Scene, Surface, View};
use terrane::sky::{air, preetham, sun};

pub const SAND: [f32; 3] = [0.5, 0.4, 0.3];

/// Ground from a function of world x and z, in a world whose materials have no texture and whose sea is far below:
/// dry sand everywhere.
pub fn sandbox(gpu: &Gpu, grid: Grid, height: impl Fn(f32, f32) -> f32) -> Scene {
    let mut heights = Vec::with_capacity(grid.samples());
    for row in 0..grid.cells {
        heights.extend((0..grid.cells).map(|column| {
            let [x, z] = grid.position(column, row);
            height(x, z)
        }));
    }
    let mut scene = stage::on(stage::empty(gpu), gpu, grid, &heights);
    scene.ground.sea_level = -1e5;
    scene.surface = Surface {
        grass: [0.1, 0.15, 0.03],
        dry_grass: [0.25, 0.25, 0.1],
        rock: [0.13, 0.11, 0.1],
        sand: SAND,
        sea_floor: SAND,
        reef: [0.2, 0.15, 0.1],
        dry_height: [500.0, 900.0],
        crowns: 1.0,
        by_height: None,
        ..scene.surface
    };
    scene.camera = Camera { view: straight_down(1000.0), fov: 0.2 };
    scene
}

/// The island of the kit in the light of an afternoon.
pub fn island(gpu: &Gpu, cells: u32) -> Scene {
    let grid = Grid { cells, extent: 8000.0 };
    let island = super::island::island(grid);
    let position = sun::Position { zenith: 45f64.to_radians(), azimuth: 250f64.to_radians() };
    let mut scene = sandbox(gpu, grid, |_, _| 0.0);
    scene.ground.height = upload(gpu, "height", &island.height);
    scene.ground.wetness = upload(gpu, "wetness", &island.wetness);
    scene.ground.reef = upload(gpu, "reef", &island.reef);
    scene.ground.sea_level = 0.0;
    scene.light = Light {
        sky: preetham::sky(2.2, position.direction()),
        sun: sun::sun(position, 2.2),
        air: Some(air::air(2.2)),
        clouds: 0.5,
    };
    scene.sea.deep_colour = [0.003, 0.018, 0.05];
    scene.sea.roughness = 0.12;
    scene.surface.rock_slope = [0.66, 0.87];
    scene.surface.beach_height = 4.0;
    scene.surface.beach_slope = 0.25;
    scene.surface.patch_size = 450.0;
    let view =
        View::FrameIsland { azimuth: 170f32.to_radians(), elevation: 14f32.to_radians(), distance: 1.1 };
    scene.camera = Camera { view, fov: 35f32.to_radians() };
    scene
}

pub fn straight_down(height: f32) -> View {
    View::LookAt { position: Vec3::new(0.0, height, 0.0), target: Vec3::ZERO, roll: 0.0 }
}
