//! Draws, cut so that no submission is long.

use super::shapes::{Shape, Shapes};
use super::view::Seen;
use crate::gpu::IndexedDraw;
use crate::scene::Population;
use crate::shaders::Instance;
use std::sync::Arc;

/// What one submission draws.
#[derive(Default)]
pub struct Batch {
    pub instances: Vec<Instance>,
    /// Each with instances of its own.
    pub draws: Vec<(Arc<Shape>, IndexedDraw)>,
    pub triangles: u32,
}

/// Where drawing has come to: so many of those who are seen are there, and so many triangles of the next one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cut {
    seen: usize,
    triangles: u32,
}

/// The next draws of all that is `seen`, in that order, with at most so many triangles; `None` once all are there.
pub fn next(
    population: &Population,
    shapes: &Shapes,
    seen: &[Seen],
    cut: &mut Cut,
    most: u32,
) -> Option<Batch> {
    let most = most.max(1);
    let mut batch = Batch::default();
    while let Some(first) = seen.get(cut.seen).filter(|_| batch.triangles < most) {
        let shape = shapes.get(first.model, first.level);
        let Some(shape) = shape.filter(|shape| shape.indices.len() >= 3) else {
            cut.seen += 1;
            continue;
        };
        let triangles = shape.indices.len() as u32 / 3;
        let room = most - batch.triangles;
        let begun = batch.instances.len() as u32;
        let range = if cut.triangles > 0 || triangles > room {
            // A part of one.
            batch.instances.push(instance(population, first));
            let end = triangles.min(cut.triangles.saturating_add(room));
            let range = cut.triangles..end;
            *cut = if end < triangles {
                Cut { triangles: end, ..*cut }
            } else {
                Cut { seen: cut.seen + 1, triangles: 0 }
            };
            range
        } else {
            let like_it = |seen: &&Seen| (seen.model, seen.level) == (first.model, first.level);
            let rest = seen.get(cut.seen..).unwrap_or_default();
            let group = rest.iter().take((room / triangles) as usize).take_while(like_it);
            batch.instances.extend(group.map(|seen| instance(population, seen)));
            cut.seen += batch.instances.len() - begun as usize;
            0..triangles
        };
        let instances = begun..batch.instances.len() as u32;
        batch.triangles += range.len() as u32 * instances.len() as u32;
        let indices = 3 * range.start..3 * range.end;
        batch.draws.push((shape.clone(), IndexedDraw { indices, first_vertex: 0, instances }));
    }
    (!batch.draws.is_empty()).then_some(batch)
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
