//! What is planted, as far as planting has to know it.

use crate::scene::Model;
use std::ops::Range;
use std::sync::Arc;

/// A kind of plant, or of anything else that stands on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    pub name: String,
    /// Its models in the population, one a variant.
    pub models: Range<u32>,
    /// Largest distance of anything above the ground from the axis, metres, at scale 1.
    pub crown: f32,
    /// Radius of what stands on the ground, metres, at scale 1.
    pub foot: f32,
    /// Metres, at scale 1.
    pub height: f32,
}

/// What reaches no further above the ground belongs to the foot, as a share of the height.
const FOOT_HEIGHT: f32 = 0.02;
/// The foot's largest share of the crown: low leaves are no trunk.
const FOOT_SHARE: f32 = 0.3;

impl Kind {
    /// The kind of a model from a file with that index in the population. All of it that is near the ground is its foot: a
    /// house has no part that hangs in the air.
    pub fn of_solid(index: u32, model: &Arc<Model>) -> Kind {
        let name = model.name.clone();
        Kind { name, ..Self::with_foot(index, std::slice::from_ref(model), 1.0) }
    }

    /// The kind whose variants are `models`, the first of them with the index `first` in the population.
    pub fn of_models(name: &str, first: u32, models: &[Arc<Model>]) -> Kind {
        Kind { name: name.into(), ..Self::with_foot(first, models, FOOT_SHARE) }
    }

    /// Without a name. The foot has at most that share of the crown.
    fn with_foot(first: u32, models: &[Arc<Model>], share: f32) -> Kind {
        let [mut crown, mut foot, mut height] = [0.0_f32; 3];
        for model in models {
            let top = model.bounds()[1].y.max(0.0);
            height = height.max(top);
            let parts = model.levels.first().into_iter().flat_map(|level| &level.parts);
            for [x, y, z] in parts.flat_map(|part| &part.mesh.positions) {
                let radius = libm::hypotf(*x, *z);
                crown = crown.max(radius);
                if *y <= FOOT_HEIGHT * top {
                    foot = foot.max(radius);
                }
            }
        }
        let models = first..first + models.len() as u32;
        Kind { name: String::new(), models, crown, foot: foot.min(share * crown), height }
    }
}
