//! Triangles of models on the device: each once.

use super::occlusion::Occlusion;
use crate::core::mesh::Mesh;
use crate::core::octahedron::packed_direction;
use crate::gpu::{self, Buffer, Gpu, Recorder};
use crate::scene::{Level, Material, Model, Part, Population};
use crate::shaders::{self, Vertex};
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Levels of models that pictures show.
#[derive(Clone)]
pub struct Shapes {
    pub materials: Arc<Buffer<shaders::Material>>,
    /// Where those of each model begin.
    first_materials: Vec<u32>,
    /// By model, once a level of it is there.
    occlusions: Vec<Option<Arc<Occlusion>>>,
    /// By model and level; `None` until it is added.
    shapes: Vec<Vec<Option<Arc<Shape>>>>,
}

/// Triangles of a level.
pub struct Shape {
    pub vertices: Buffer<Vertex>,
    pub indices: Buffer<u32>,
}

impl Shapes {
    /// Of a population, none of whose levels is there yet.
    ///
    /// # Errors
    /// No memory.
    pub fn new(gpu: &Gpu, population: &Population) -> gpu::Result<Shapes> {
        let models = &population.models;
        let mut count = 0;
        let first = |model: &Arc<Model>| {
            let first = count;
            count += model.materials.len() as u32;
            first
        };
        let first_materials = models.iter().map(first).collect();
        let mut materials: Vec<_> =
            models.iter().flat_map(|model| &model.materials).map(shaders::Material::from).collect();
        if materials.is_empty() {
            // Nothing has one, but a buffer holds something.
            materials.push((&Material::default()).into());
        }
        Ok(Shapes {
            materials: Arc::new(upload(gpu, "materials", &materials)?),
            first_materials,
            occlusions: vec![None; models.len()],
            shapes: models.iter().map(|model| vec![None; model.levels.len()]).collect(),
        })
    }

    /// Whether a level is there, or has nothing to show.
    pub fn has(&self, population: &Population, [model, level]: [u32; 2]) -> bool {
        let levels = population.models.get(model as usize).map(|model| &model.levels);
        let is_empty =
            levels.and_then(|levels| levels.get(level as usize)).is_none_or(|it| it.triangles() == 0);
        is_empty || self.get(model, level).is_some()
    }

    /// Brings a level to the device.
    ///
    /// # Errors
    /// No memory, or a level beyond what a binding holds.
    pub fn add(&mut self, gpu: &Gpu, population: &Population, [model, level]: [u32; 2]) -> gpu::Result<()> {
        let index = model as usize;
        let found =
            population.models.get(index).and_then(|model| Some((model, model.levels.get(level as usize)?)));
        let (Some((model, of)), Some(first), Some(occlusion)) =
            (found, self.first_materials.get(index), self.occlusions.get_mut(index))
        else {
            return Ok(());
        };
        let occlusion = occlusion.get_or_insert_with(|| Arc::new(Occlusion::of(model)));
        let shape = Shape::new(gpu, of, *first, occlusion)?;
        if let Some(place) = self.shapes.get_mut(index).and_then(|levels| levels.get_mut(level as usize)) {
            *place = Some(Arc::new(shape));
        }
        Ok(())
    }

    pub fn get(&self, model: u32, level: u32) -> Option<&Arc<Shape>> {
        self.shapes.get(model as usize)?.get(level as usize)?.as_ref()
    }
}

impl Shape {
    fn new(gpu: &Gpu, level: &Level, first_material: u32, occlusion: &Occlusion) -> gpu::Result<Shape> {
        let mut vertices = Vec::new();
        let mut indices = Vec::new();
        for part in &level.parts {
            let mesh = &part.mesh;
            let first = vertices.len() as u32;
            let material = first_material + part.material as u32;
            let corners = mesh.positions.par_iter().zip(&mesh.normals);
            vertices.par_extend(corners.map(|(&position, &normal)| Vertex {
                position,
                normal: packed_direction(normal.into()),
                openness: packed_shares(occlusion.at(position.into())),
                material,
            }));
            indices.extend(mesh.triangles.as_flattened().iter().map(|index| first + index));
        }
        Ok(Shape {
            vertices: upload(gpu, "vertices", &vertices)?,
            indices: upload(gpu, "indices", &indices)?,
        })
    }
}

/// Area of a level's leaves, one-sided, or of leaves that hide as much, m².
pub fn density_area(model: &Model, level: &Level) -> f32 {
    let part = |part: &Part| {
        let corner = |index: u32| Vec3::from(part.mesh.positions[index as usize]);
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(corner);
            (b - a).cross(c - a).length() / 2.0
        };
        2.0 * projected(model, part.material) * part.mesh.triangles.iter().map(area).sum::<f32>()
    };
    level.parts.iter().map(part).sum()
}

/// Share of a surface's area that is in the way of light, on average over all directions: half of a leaf, and a quarter of
/// what is closed, of which only the front counts (Cauchy). What lets light through is a leaf.
pub fn projected(model: &Model, material: usize) -> f32 {
    let leaf = model.materials.get(material).is_some_and(|material| material.transmittance != [0.0; 3]);
    if leaf { 0.5 } else { 0.25 }
}

/// Bytes that a level takes on the device.
pub fn bytes(level: &Level) -> u64 {
    let part = |mesh: &Mesh| mesh.positions.len() * size_of::<Vertex>() + mesh.triangles.len() * 12;
    level.parts.iter().map(|it| part(&it.mesh) as u64).sum()
}

pub fn upload<T: bytemuck::Pod>(gpu: &Gpu, name: &str, values: &[T]) -> gpu::Result<Buffer<T>> {
    let buffer = Buffer::new(gpu, name, values.len())?;
    let mut rec = Recorder::new(gpu);
    rec.upload(&buffer, values);
    rec.submit()?.wait()?;
    Ok(buffer)
}

/// The twin of `packUnorm2x16`.
fn packed_shares(shares: [f32; 2]) -> u32 {
    let [low, high] = shares.map(|share| (share.clamp(0.0, 1.0) * 65535.0).round() as u32);
    high << 16 | low
}
