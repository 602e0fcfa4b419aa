//! Draws, cut so that no submission is long.

use super::shapes::Shapes;
use super::view::Seen;
use crate::gpu::IndexedDraw;
use crate::scene::Population;
use crate::shaders::Instance;

/// What one submission draws.
#[derive(Default)]
pub struct Batch {
    pub instances: Vec<Instance>,
    /// Each of a pool of [`Shapes`], its instances counted in `instances`.
    pub draws: Vec<(usize, IndexedDraw)>,
    triangles: u64,
}

/// A device that draws in software does some millions a second.
const MOST_TRIANGLES: u64 = 1 << 20;

/// Draws of all that is `seen`, in that order: one for each level of a model where it is not cut.
pub fn batches(population: &Population, shapes: &Shapes, seen: &[Seen]) -> Vec<Batch> {
    let mut batches = Vec::new();
    let mut batch = Batch::default();
    for group in seen.chunk_by(|one, other| (one.model, one.level) == (other.model, other.level)) {
        let Some(place) = shapes.place(group[0].model, group[0].level) else { continue };
        let triangles = place.indices.len() as u64 / 3;
        if triangles == 0 {
            continue;
        }
        let mut rest = group;
        while !rest.is_empty() {
            let room = MOST_TRIANGLES.saturating_sub(batch.triangles) / triangles;
            if room == 0 && batch.triangles > 0 {
                batches.push(std::mem::take(&mut batch));
                continue;
            }
            let (now, later) = rest.split_at(rest.len().min(room.max(1) as usize));
            let first = batch.instances.len() as u32;
            batch.instances.extend(now.iter().map(|seen| instance(population, seen)));
            let draw = IndexedDraw {
                indices: place.indices.clone(),
                first_vertex: place.first_vertex,
                instances: first..batch.instances.len() as u32,
            };
            batch.draws.push((place.pool, draw));
            batch.triangles += triangles * now.len() as u64;
            rest = later;
        }
    }
    if !batch.draws.is_empty() {
        batches.push(batch);
    }
    batches
}

fn instance(population: &Population, seen: &Seen) -> Instance {
    let instance = &population.instances[seen.instance as usize];
    Instance {
        position: instance.position.to_array(),
        scale: instance.scale,
        rotation: instance.rotation.to_array(),
        random: instance.random,
    }
}
