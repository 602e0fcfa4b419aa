//! Models and scenes that leave as files and come back, and files of other makes.

use glam::{Quat, Vec3};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use terrane::core::mesh::Mesh;
use terrane::formats::model::{self, Import};
use terrane::scene::{Instance, Level, Material, Model, Part, Population};

// A model, out and in.

#[test]
fn a_model_comes_back_from_gltf_exactly_as_it_was() {
    let folder = folder();
    let path = folder.path().join("tree.glb");
    let tree = tree();
    let written = model::write(&path, &tree).unwrap();
    let import = model::read(&path).unwrap();
    assert_eq!(import.warnings, [""; 0]);
    assert_eq!(*import.population.models, [Arc::new(tree.clone())]);
    assert_eq!(import.merged(&path).unwrap(), import.population.models[0]);
    let [only] = &import.population.instances[..] else { panic!() };
    assert_eq!((only.model, only.position, only.rotation, only.scale), (0, Vec3::ZERO, Quat::IDENTITY, 1.0));

    let again = model::write(&folder.path().join("again.glb"), &tree).unwrap();
    assert_eq!(written[0].sha256, again[0].sha256);
}

#[test]
fn a_model_comes_back_from_obj_and_ply_as_its_finest_level() {
    let folder = folder();
    let tree = tree();
    let finest = &tree.levels[0];
    for name in ["tree.obj", "tree.ply"] {
        let path = folder.path().join(name);
        model::write(&path, &tree).unwrap();
        let Import { population, warnings } = model::read(&path).unwrap();
        assert_eq!(warnings, [""; 0]);
        let [back] = &population.models[..] else { panic!() };
        assert_eq!((back.levels.len(), &*back.name), (1, "tree"));
        let parts = &back.levels[0].parts;
        assert_eq!(parts.len(), finest.parts.len());
        for (part, from) in parts.iter().zip(&finest.parts) {
            assert_same(&part.mesh, &from.mesh);
            let [got, want] = [(back, part), (&Arc::new(tree.clone()), from)]
                .map(|(model, part)| model.materials[part.material].mean_reflectance());
            // Colours of PLY have 8 bits.
            let within = if name == "tree.ply" { 0.005 } else { 1e-6 };
            assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() < within), "{got:?} {want:?}");
        }
    }
}

/// The same triangles, corner by corner.
#[track_caller]
fn assert_same(got: &Mesh, want: &Mesh) {
    assert_eq!(got.triangles.len(), want.triangles.len());
    let corners = got.triangles.as_flattened().iter().zip(want.triangles.as_flattened());
    for (got_corner, want_corner) in corners.map(|(got, want)| (*got as usize, *want as usize)) {
        assert_eq!(got.positions[got_corner], want.positions[want_corner]);
        assert_eq!(got.normals[got_corner], want.normals[want_corner]);
        let [got, want] = [got.uvs[got_corner], want.uvs[want_corner]];
        assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() <= 1e-6), "{got:?} {want:?}");
    }
}

// Made-up models.

/// A trunk with leaves, in two levels.
fn tree() -> Model {
    let bark = Material {
        name: "bark".into(),
        reflectance: [[0.12, 0.08, 0.05], [0.31, 0.22, 0.17]],
        position_factor: 7.5,
        value_factor: 0.8,
        roughness: 0.9,
        ..Material::default()
    };
    let leaf = Material {
        name: "leaf".into(),
        reflectance: [[0.05, 0.1, 0.02]; 2],
        transmittance: [0.04, 0.09, 0.01],
        refractive_index: 1.4,
        roughness: 0.35,
        ..Material::default()
    };
    let level = |detail, sides: u32| {
        let trunk = cylinder(sides, 0.2, 3.0);
        let leaves = quad(Vec3::new(0.0, 3.0, 0.0), 1.5);
        let parts = vec![Part { material: 0, mesh: trunk }, Part { material: 1, mesh: leaves }];
        Level { detail, parts }
    };
    Model { name: "tree".into(), materials: vec![bark, leaf], levels: vec![level(0.0, 9), level(0.3, 4)] }
}

/// An upright tube without ends.
fn cylinder(sides: u32, radius: f32, height: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for side in 0..=sides {
        let share = side as f32 / sides as f32;
        let (sin, cos) = (share * std::f32::consts::TAU).sin_cos();
        for (row, v) in [(0.0, 1.0), (height, 0.0)] {
            mesh.positions.push([radius * cos, row, -radius * sin]);
            mesh.normals.push([cos, 0.0, -sin]);
            mesh.uvs.push([share, v]);
        }
    }
    for side in 0..sides {
        let at = 2 * side;
        mesh.triangles.extend([[at, at + 2, at + 1], [at + 1, at + 2, at + 3]]);
    }
    mesh
}

/// A level square that looks up.
fn quad(middle: Vec3, size: f32) -> Mesh {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let place = |[u, v]: [f32; 2]| (middle + size * Vec3::new(u - 0.5, 0.0, v - 0.5)).into();
    Mesh {
        positions: corners.map(place).into(),
        normals: vec![[0.0, 1.0, 0.0]; 4],
        uvs: corners.into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}
