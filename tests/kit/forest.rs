//! Made-up plants: trunks with crowns of leaves, in levels of detail that keep the leaves' area.

use glam::{Quat, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;
use terrane::core::hash::mix;
use terrane::core::mesh::Mesh;
use terrane::scene::{Instance, Level, Material, Model, Part, Population};

/// Uniform numbers in 0…1, one after another.
pub struct Random(pub u32);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (mix(self.0) >> 8) as f32 / (1 << 24) as f32
    }

    pub fn between(&mut self, least: f32, greatest: f32) -> f32 {
        least + (greatest - least) * self.unit()
    }

    pub fn direction(&mut self) -> Vec3 {
        let y = self.between(-1.0, 1.0);
        let level = (1.0 - y * y).sqrt();
        let azimuth = TAU * self.unit();
        Vec3::new(level * azimuth.cos(), y, level * azimuth.sin())
    }
}

pub fn bark() -> Material {
    Material {
        name: "bark".into(),
        reflectance: [[0.10, 0.075, 0.05], [0.2, 0.17, 0.13]],
        position_factor: 4.0,
        ..Material::default()
    }
}

pub fn leaf() -> Material {
    Material {
        name: "leaf".into(),
        reflectance: [[0.04, 0.075, 0.02], [0.06, 0.10, 0.025]],
        position_factor: 1.0,
        transmittance: [0.045, 0.09, 0.012],
        refractive_index: 1.45,
        roughness: 0.4,
        ..Material::default()
    }
}

/// A tree of one metre for every metre of `height`, whose crown fills its upper two thirds.
pub fn tree(seed: u32, height: f32, leaves: usize) -> Model {
    let mut random = Random(mix(seed));
    let centre = Vec3::Y * (0.64 * height);
    let half = Vec3::new(0.27, 0.36, 0.27) * height;
    let places: Vec<[Vec3; 3]> = (0..leaves)
        .map(|_| {
            // Clumps, and more leaves outside than in.
            let out = random.direction() * random.unit().powf(0.3);
            let place = centre + half * (out + 0.15 * random.direction());
            [place, random.direction(), random.direction()]
        })
        .collect();
    let size = (1.6 * 4.0 * half.x * half.x / leaves as f32).sqrt();
    let level = |every: usize, sides: u32| {
        let mut crown = Mesh::default();
        let size = size * (every as f32).sqrt();
        for [place, normal, along] in places.iter().step_by(every) {
            quad(&mut crown, *place, *normal, *along, size);
        }
        let parts = vec![
            Part { material: 0, mesh: pole(0.02 * height, 0.6 * height, sides) },
            Part { material: 1, mesh: crown },
        ];
        Level { detail: if every == 1 { 0.0 } else { size }, parts }
    };
    Model {
        name: format!("tree {seed}"),
        materials: vec![bark(), leaf()],
        levels: vec![level(1, 9), level(4, 5), level(16, 3), level(64, 3)],
    }
}

/// A tuft of upright blades.
pub fn tuft(seed: u32, height: f32, blades: usize) -> Model {
    let mut random = Random(mix(seed));
    let mut mesh = Mesh::default();
    for _ in 0..blades {
        let lean = random.direction() * 0.6;
        let foot = Vec3::new(random.between(-0.3, 0.3), 0.0, random.between(-0.3, 0.3)) * height;
        let tip = foot + height * random.between(0.5, 1.0) * Vec3::new(lean.x, 1.0, lean.z).normalize();
        let across = 0.012 * height * random.direction().cross(tip - foot).normalize_or(Vec3::X);
        let normal = (tip - foot).cross(across).normalize_or(Vec3::Z);
        triangle(&mut mesh, [foot - across, foot + across, tip], normal);
    }
    Model {
        name: format!("tuft {seed}"),
        materials: vec![leaf()],
        levels: vec![Level { detail: 0.0, parts: vec![Part { material: 0, mesh }] }],
    }
}

/// A prism along +Y.
pub fn pole(radius: f32, height: f32, sides: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for index in 0..=sides {
        let (sine, cosine) = (TAU * index as f32 / sides as f32).sin_cos();
        for y in [0.0, height] {
            mesh.positions.push([radius * cosine, y, radius * sine]);
            mesh.normals.push([cosine, 0.0, sine]);
            mesh.uvs.push([index as f32 / sides as f32, y]);
        }
    }
    for side in 0..sides {
        let first = 2 * side;
        mesh.triangles.extend([[first, first + 1, first + 2], [first + 2, first + 1, first + 3]]);
    }
    mesh
}

pub fn quad(mesh: &mut Mesh, centre: Vec3, normal: Vec3, along: Vec3, size: f32) {
    let across = normal.cross(along).normalize_or(Vec3::X) * (size / 2.0);
    let along = across.cross(normal).normalize_or(Vec3::Z) * (size / 2.0);
    let first = mesh.positions.len() as u32;
    for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        mesh.positions.push((centre + u * across + v * along).to_array());
        mesh.normals.push(normal.to_array());
        mesh.uvs.push([u, v]);
    }
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

fn triangle(mesh: &mut Mesh, corners: [Vec3; 3], normal: Vec3) {
    let first = mesh.positions.len() as u32;
    for corner in corners {
        mesh.positions.push(corner.to_array());
        mesh.normals.push(normal.to_array());
        mesh.uvs.push([0.0, 0.0]);
    }
    mesh.triangles.push([first, first + 1, first + 2]);
}

/// One model, and where it stands, upright and as it is.
pub fn standing(model: Model, places: impl IntoIterator<Item = Vec3>) -> Population {
    let instances = places.into_iter().map(|position| Instance {
        model: 0,
        random: 0,
        position,
        rotation: Quat::IDENTITY,
        scale: 1.0,
    });
    Population { models: vec![Arc::new(model)], instances: instances.collect() }
}

/// A forest of `count` trees and ten times as many tufts over a square of `extent` metres.
pub fn forest(count: usize, extent: f32, height: impl Fn(f32, f32) -> f32) -> Population {
    let trees = (0..4).map(|seed| tree(seed, 9.0 + 2.0 * seed as f32, 6000));
    let tufts = (0..4).map(|seed| tuft(100 + seed, 0.35, 40));
    let models: Vec<_> = trees.chain(tufts).map(Arc::new).collect();
    let mut random = Random(7);
    let instances = (0..11 * count).map(|index| {
        let [x, z] = [0, 1].map(|_| random.between(-0.5, 0.5) * extent);
        Instance {
            model: (random.unit() * 4.0) as u32 + if index < count { 0 } else { 4 },
            random: mix(index as u32),
            position: Vec3::new(x, height(x, z), z),
            rotation: Quat::from_rotation_y(TAU * random.unit()),
            scale: random.between(0.7, 1.3),
        }
    });
    let instances = instances.collect();
    Population { models, instances }
}
