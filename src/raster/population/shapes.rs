//! Triangles of models on the device: each once, in a few large buffers.

use super::occlusion::Occlusion;
use crate::core::mesh::Mesh;
use crate::core::octahedron::packed_direction;
use crate::gpu::{self, Buffer, Gpu, Recorder};
use crate::scene::{Level, Material, Model, Part, Population};
use crate::shaders::{self, Vertex};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// The levels of all models that a picture shows.
pub struct Shapes {
    pub pools: Vec<Pool>,
    pub materials: Buffer<shaders::Material>,
    /// By model and level; `None` where the level is not shown.
    places: Vec<Vec<Option<Place>>>,
}

/// Triangles of several levels.
pub struct Pool {
    pub vertices: Buffer<Vertex>,
    pub indices: Buffer<u32>,
}

/// Where a level lies.
#[derive(Clone, Debug)]
pub struct Place {
    /// Index into [`Shapes::pools`].
    pub pool: usize,
    pub first_vertex: u32,
    pub indices: Range<u32>,
}

/// A binding may be limited to 128 MiB: a pool that has this much is full, and only a level that is larger alone can
/// pass the limit.
const POOL_BYTES: usize = 32 << 20;

impl Shapes {
    /// Uploads the levels that `shown` (by model and level) names.
    ///
    /// # Errors
    /// No memory, or a level beyond what a binding holds.
    pub fn new(gpu: &Gpu, population: &Population, shown: &[Vec<bool>]) -> gpu::Result<Shapes> {
        let mut pools = Vec::new();
        let mut filling = Filling::default();
        let mut places = Vec::new();
        let mut first_material = 0;
        for (model, shown) in population.models.iter().zip(shown) {
            let mut levels = Vec::new();
            let occlusion = shown.contains(&true).then(|| Occlusion::of(model));
            for (level, shown) in model.levels.iter().zip(shown) {
                if filling.bytes() > POOL_BYTES {
                    pools.push(std::mem::take(&mut filling).upload(gpu)?);
                }
                let add = |occlusion| filling.add(level, first_material, occlusion, pools.len());
                levels.push(occlusion.as_ref().filter(|_| *shown).map(add));
            }
            places.push(levels);
            first_material += model.materials.len() as u32;
        }
        if filling.bytes() > 0 {
            pools.push(filling.upload(gpu)?);
        }
        let mut materials: Vec<_> = population
            .models
            .iter()
            .flat_map(|model| &model.materials)
            .map(shaders::Material::from)
            .collect();
        if materials.is_empty() {
            // Nothing has one, but a buffer holds something.
            materials.push((&Material::default()).into());
        }
        Ok(Shapes { pools, places, materials: upload(gpu, "materials", &materials)? })
    }

    pub fn place(&self, model: u32, level: u32) -> Option<&Place> {
        self.places.get(model as usize)?.get(level as usize)?.as_ref()
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

/// A pool before it is uploaded.
#[derive(Default)]
struct Filling {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

impl Filling {
    fn bytes(&self) -> usize {
        self.vertices.len() * size_of::<Vertex>() + self.indices.len() * 4
    }

    fn add(&mut self, level: &Level, first_material: u32, occlusion: &Occlusion, pool: usize) -> Place {
        let (first_vertex, first_index) = (self.vertices.len() as u32, self.indices.len() as u32);
        for part in &level.parts {
            let mesh = &part.mesh;
            let first = self.vertices.len() as u32 - first_vertex;
            let material = first_material + part.material as u32;
            let corners = mesh.positions.par_iter().zip(&mesh.normals);
            self.vertices.par_extend(corners.map(|(&position, &normal)| Vertex {
                position,
                normal: packed_direction(normal.into()),
                openness: packed_shares(occlusion.at(position.into())),
                material,
            }));
            self.indices.extend(mesh.triangles.as_flattened().iter().map(|index| first + index));
        }
        Place { pool, first_vertex, indices: first_index..self.indices.len() as u32 }
    }

    fn upload(self, gpu: &Gpu) -> gpu::Result<Pool> {
        Ok(Pool {
            vertices: upload(gpu, "vertices", &self.vertices)?,
            indices: upload(gpu, "indices", &self.indices)?,
        })
    }
}

/// The twin of `packUnorm2x16`.
fn packed_shares(shares: [f32; 2]) -> u32 {
    let [low, high] = shares.map(|share| (share.clamp(0.0, 1.0) * 65535.0).round() as u32);
    high << 16 | low
}
