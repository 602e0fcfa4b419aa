//! A stage for single things: black level ground far below, no sea, no air, and no light but what a test sets.

use glam::{Quat, Vec3};
use std::sync::Arc;
use terrane::core::{grid::Grid, mesh::Mesh};
use terrane::gpu::{Gpu, Image, Recorder, format::R32f};
use terrane::scene::{
    ByHeight, Camera, Ground, Instance, Level, Light, Material, Mixture, Model, Part, Population, Scene, Sea,
    Sky, Surface, View,
};

/// Height of the ground, metres.
pub const FLOOR: f32 = -1e4;

pub fn empty(gpu: &Gpu) -> Scene {
    let grid = Grid { cells: 17, extent: 1000.0 };
    Scene {
        ground: ground(gpu, grid, &vec![FLOOR; grid.samples()], -1e9),
        light: Light { sky: Sky::None, sun: None, air: None, clouds: 0.0 },
        sea: Sea { level: -1e9, attenuation: [0.3, 0.06, 0.03], deep_colour: [0.0; 3], roughness: 0.0 },
        surface: Surface {
            grass: [0.0; 3],
            dry_grass: [0.0; 3],
            rock: [0.0; 3],
            sand: [0.0; 3],
            sea_floor: [0.0; 3],
            reef: [0.0; 3],
            rock_slope: [1.5, 1.55],
            dry_height: [1e6, 2e6],
            beach_height: 1e7,
            beach_slope: 10.0,
            patch_size: 1e-4,
            crowns: 0.0,
            snow: None,
            by_height: one_colour(0.0),
        },
        population: Population::default(),
        camera: Camera { view: View::LookAt { position: Vec3::Y, target: Vec3::ZERO, roll: 0.0 }, fov: 1.0 },
    }
}

/// Puts things on the stage, each a mesh of one material, where they are.
pub fn with(mut scene: Scene, things: Vec<(Mesh, Material)>) -> Scene {
    let count = things.len() as u32;
    let model = |(mesh, material): (Mesh, Material)| {
        let level = Level { detail: 0.0, parts: vec![Part { material: 0, mesh }] };
        Arc::new(Model { name: "thing".into(), materials: vec![material], levels: vec![level] })
    };
    let instance =
        |model| Instance { model, random: 0, position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };
    scene.population = Population {
        models: things.into_iter().map(model).collect(),
        instances: (0..count).map(instance).collect(),
    };
    scene
}

/// Other ground under what is on the stage.
pub fn on(mut scene: Scene, gpu: &Gpu, grid: Grid, heights: &[f32]) -> Scene {
    scene.ground = ground(gpu, grid, heights, scene.ground.sea_level);
    scene
}

fn ground(gpu: &Gpu, grid: Grid, heights: &[f32], sea_level: f32) -> Ground {
    let zeros = vec![0.0; grid.samples()];
    let [height, water] = [("height", heights), ("water", &zeros)].map(|(name, it)| upload(gpu, name, it));
    let [wetness, reef] = ["wetness", "reef"].map(|name| upload(gpu, name, &zeros));
    Ground { grid, height, water, wetness, reef, sea_level }
}

/// Ground of one grey, without texture.
pub fn one_colour(reflectance: f32) -> Option<ByHeight> {
    let [reflectance, second_reflectance] = [[reflectance; 3]; 2];
    let grey = Mixture { reflectance, second_reflectance, position_factor: 0.0, value_factor: 0.0 };
    Some(ByHeight { ground: grey, rock: grey, rock_start: 1e5, ground_end: 2e5 })
}

pub fn grey(reflectance: f32) -> Material {
    Material { reflectance: [[reflectance; 3]; 2], ..Material::default() }
}

/// A parallelogram with one corner at `corner`; its normal is along × up.
pub fn sheet(corner: Vec3, along: Vec3, up: Vec3) -> Mesh {
    let corners = [corner, corner + along, corner + along + up, corner + up];
    let normal = along.cross(up).normalize().to_array();
    Mesh {
        positions: corners.map(|corner| corner.to_array()).to_vec(),
        normals: vec![normal; 4],
        uvs: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Part of the unit sphere round `centre` from the pole at −y to the height `top` (−1…1), with normals towards the middle, or
/// away from it.
pub fn ball(centre: Vec3, radius: f32, top: f32, segments: u32, inward: bool) -> Mesh {
    let rows = segments / 2;
    let lowest = std::f32::consts::PI;
    let highest = top.acos();
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        let angle = lowest + (highest - lowest) * row as f32 / rows as f32;
        for column in 0..segments {
            let azimuth = std::f32::consts::TAU * column as f32 / segments as f32;
            let (sine, cosine) = angle.sin_cos();
            let outward = Vec3::new(sine * azimuth.cos(), cosine, sine * azimuth.sin());
            mesh.positions.push((centre + radius * outward).to_array());
            mesh.normals.push(if inward { -outward } else { outward }.to_array());
        }
    }
    for row in 0..rows {
        for column in 0..segments {
            let at = |row: u32, column: u32| row * segments + column % segments;
            let (a, b) = (at(row, column), at(row, column + 1));
            let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
            mesh.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    mesh
}

/// A square of values.
pub fn upload(gpu: &Gpu, name: &str, values: &[f32]) -> Image<R32f> {
    let side = (values.len() as f64).sqrt() as u32;
    let image = Image::new(gpu, name, [side; 2]).expect("an image");
    let mut rec = Recorder::new(gpu);
    rec.upload(&image, values);
    rec.submit().expect("submitted").wait().expect("finished");
    image
}
