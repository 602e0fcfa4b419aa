//! Things that stand on the ground, plants above all: drawn many times, kept once.

use super::Material;
use crate::core::mesh::Mesh;
use glam::{Quat, Vec3};
use std::sync::Arc;

/// All that stands on the ground.
#[derive(Clone, Debug, Default)]
pub struct Population {
    pub models: Vec<Arc<Model>>,
    pub instances: Arc<[Instance]>,
}

/// A shape with its materials, in levels of detail. Its foot is the origin and it grows along +Y.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    pub name: String,
    pub materials: Vec<Material>,
    /// From the finest to the coarsest; at least one.
    pub levels: Vec<Level>,
}

/// A model as it is seen from some distance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Level {
    /// Size of the largest detail that is left out or merged, metres: the level serves where that is less than a
    /// pixel. 0 for the finest.
    pub detail: f32,
    pub parts: Vec<Part>,
}

/// The triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Index into [`Model::materials`].
    pub material: usize,
    pub mesh: Mesh,
}

/// One of the things that stand on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`Population::models`].
    pub model: u32,
    /// A random number of its own, from which its colour varies.
    pub random: u32,
    /// Where the model's origin lies, metres.
    pub position: Vec3,
    pub rotation: Quat,
    pub scale: f32,
}

impl Model {
    /// Whether nothing is seen of it.
    pub fn is_empty(&self) -> bool {
        self.levels.iter().all(|level| level.triangles() == 0)
    }

    /// Least and greatest coordinates of the finest level.
    pub fn bounds(&self) -> [Vec3; 2] {
        let parts = self.levels.first().into_iter().flat_map(|level| &level.parts);
        let filled = parts.filter(|part| !part.mesh.positions.is_empty());
        let bounds = filled.map(|part| part.mesh.bounds().map(Vec3::from));
        bounds.reduce(|all, part| [all[0].min(part[0]), all[1].max(part[1])]).unwrap_or_default()
    }
}

impl Level {
    pub fn triangles(&self) -> usize {
        self.parts.iter().map(|part| part.mesh.triangles.len()).sum()
    }
}
