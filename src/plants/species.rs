//! A species: how a kind of plant grows and what it is made of, and its models.

use super::{
    derive::{self, Change, Derivation, Limits, Steps, Word},
    grammar::Grammar,
    mesh::{self, Blade, Body, Stem},
    turtle::{self, Interpretation, Measure, Placement},
    watch::{Stopped, Watch},
};
use crate::{
    core::hash::derive_seed,
    scene::{Material, Model},
};
use glam::{DAffine3, DMat3, DVec3};

/// A kind of plant.
#[derive(Clone, Debug)]
pub struct Species {
    pub name: String,
    pub form: Form,
    /// What organs are made of.
    pub materials: Vec<Material>,
    /// How many different plants there are of it.
    pub variants: u32,
    /// Vertical extent that plants are scaled to, metres; as they grow without.
    pub height: Option<f32>,
}

/// How something grows: a plant, or a twig that plants bear.
#[derive(Clone, Debug)]
pub struct Form {
    pub grammar: Grammar,
    pub steps: Steps,
    pub turtle: Interpretation,
    /// Index into [`Species::materials`], of axes.
    pub wood: usize,
    /// Indices into [`Species::materials`], of polygons in the word, by how often `'` was met; the last one serves for all
    /// that follow.
    pub leaves: Vec<usize>,
    /// What `~` places.
    pub organs: Vec<Organ>,
}

/// A sub-model.
#[derive(Clone, Debug)]
pub struct Organ {
    pub symbol: char,
    pub shape: Shape,
}

#[derive(Clone, Debug)]
pub enum Shape {
    /// Coordinates along the turtle's heading, left and up, metres.
    Polygons(Vec<Outline>),
    Grown(Box<Form>),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Index into [`Species::materials`].
    pub material: usize,
    pub vertices: Vec<[f64; 3]>,
}

/// Why a species has no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Derive(#[from] derive::Error),
    #[error(transparent)]
    Draw(#[from] turtle::Error),
    #[error(transparent)]
    Mesh(#[from] mesh::Error),
    #[error("organ `{symbol}`: {problem}")]
    Organ { symbol: char, problem: Box<Error> },
    #[error("organs within organs: {MAX_DEPTH} levels at most")]
    Depth,
    #[error("it is made of material number {index}, counted from 0, and the species has {count} in all")]
    Material { index: usize, count: usize },
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// What is seen of a plant while it grows; of its organs nothing.
pub enum Seen<'a> {
    /// The axiom, and what a step made of it.
    Word(&'a Word),
    /// The last word, and the turtle's way along it.
    Way(&'a Word, &'a Measure),
}

/// An L-system whose `steps` end before its growth does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unfinished {
    /// The organ that it is, within others or not; `None` is the plant itself.
    pub organ: Option<char>,
    pub steps: u32,
    /// The first step after which nothing changes.
    pub ends: u32,
}

/// Most levels of organs within organs.
const MAX_DEPTH: u32 = 8;

/// The seed of a variant.
pub fn variant_seed(seed: u32, variant: u32) -> u32 {
    derive_seed(seed, &format!("variant.{variant}"))
}

impl Species {
    /// The model of a variant, in all its levels of detail. Seeds of variants come from `seed`.
    ///
    /// # Errors
    /// As [`Species::body`].
    pub fn grow(&self, seed: u32, variant: u32, limits: &Limits) -> Result<Model, Error> {
        Ok(self.model(&self.body(seed, variant, limits)?, limits.watch)?)
    }

    /// A variant's branches and leaves, scaled to the height that the species has.
    ///
    /// # Errors
    /// As [`derive::derive`] and [`turtle::draw`]; where it would take more memory than `limits` allow, before it does; where
    /// it is no shape.
    pub fn body(&self, seed: u32, variant: u32, limits: &Limits) -> Result<Body, Error> {
        self.body_seen(seed, variant, limits, |_| ())
    }

    /// As [`Species::body`], and shows `see` what it is made from.
    pub fn body_seen(
        &self,
        seed: u32,
        variant: u32,
        limits: &Limits,
        see: impl FnMut(Seen),
    ) -> Result<Body, Error> {
        let mut body = self.form.body(variant_seed(seed, variant), limits, MAX_DEPTH, see)?;
        let stems = body.stems.iter().map(|stem| stem.material);
        let used = stems.chain(body.blades.iter().map(|blade| blade.material)).max();
        if let Some(index) = used.filter(|&index| index >= self.materials.len()) {
            return Err(Error::Material { index, count: self.materials.len() });
        }
        body.check()?;
        if let Some(height) = self.height {
            body.scale_to(height.into())?;
            body.check()?;
        }
        Ok(body)
    }

    /// What of the species is unfinished: its growth would end by itself, and `steps` end it before. Looks at the first
    /// variant, and not much further than its steps go. What can't grow is not looked at.
    pub fn unfinished(&self, seed: u32, limits: &Limits) -> Vec<Unfinished> {
        let mut found = Vec::new();
        self.form.find_unfinished(None, variant_seed(seed, 0), limits, &mut found);
        found
    }

    /// The triangles of a body of this species.
    ///
    /// # Errors
    /// When it is stopped.
    pub fn model(&self, body: &Body, watch: Watch) -> Result<Model, Stopped> {
        let mut levels = mesh::levels(body, watch)?;
        let used =
            |index: &usize| levels.iter().flat_map(|level| &level.parts).any(|part| part.material == *index);
        let used: Vec<usize> = (0..self.materials.len()).filter(used).collect();
        for part in levels.iter_mut().flat_map(|level| &mut level.parts) {
            part.material = used.partition_point(|&index| index < part.material);
        }
        let materials = used.iter().map(|&index| self.materials[index].clone()).collect();
        Ok(Model { name: self.name.clone(), materials, levels })
    }
}

impl Form {
    /// Derives and draws it, and bears its organs: each has grown once, and is then placed as often as it is named.
    fn body(&self, seed: u32, limits: &Limits, depth: u32, mut see: impl FnMut(Seen)) -> Result<Body, Error> {
        let word =
            derive::derive_seen(&self.grammar, self.steps, seed, limits, |word| see(Seen::Word(word)))?;
        let drawing = turtle::draw(&word, &self.turtle, limits.watch)?;
        see(Seen::Way(&word, &drawing.measure));
        drop(word);
        let mut pace = limits.watch.pace();
        let mut body = Body::default();
        for axis in drawing.axes {
            body.stems.push(Stem { material: self.wood, nodes: axis.nodes });
        }
        for polygon in drawing.polygons {
            let Some(&first) = polygon.vertices.first() else { continue };
            pace.count(polygon_work(polygon.vertices.len()))?;
            let color = (polygon.color as usize).min(self.leaves.len().saturating_sub(1));
            let material = *self.leaves.get(color).unwrap_or(&self.wood);
            let outline = polygon.vertices.iter().map(|vertex| vertex - first).collect();
            if let Some(blade) = Blade::new(material, outline, polygon.up)? {
                body.add(blade, first);
            }
        }
        refuse(body.bytes(1), limits)?;
        for organ in &self.organs {
            let of_organ = |placement: &&Placement| placement.symbol == organ.symbol;
            let places: Vec<DAffine3> = drawing.placements.iter().filter(of_organ).map(place).collect();
            if places.is_empty() {
                continue;
            }
            let named = |problem: Error| Error::Organ { symbol: organ.symbol, problem: Box::new(problem) };
            let part = organ.body(seed, limits, depth).map_err(named)?;
            refuse(body.bytes(1).saturating_add(part.bytes(places.len())), limits)?;
            pace.count(part.size().saturating_mul(places.len() as u64))?;
            body.place(&part, &places);
        }
        Ok(body)
    }

    fn find_unfinished(&self, organ: Option<char>, seed: u32, limits: &Limits, found: &mut Vec<Unfinished>) {
        let steps = match self.steps {
            Steps::Fixed(steps) => steps,
            Steps::UntilDone => u32::MAX,
        };
        if let Some(ends) = self.end(seed, limits).filter(|&ends| ends > steps) {
            let unfinished = Unfinished { organ, steps, ends };
            // An organ that stands in several others is met as often.
            if !found.contains(&unfinished) {
                found.push(unfinished);
            }
        }
        for organ in &self.organs {
            if let Shape::Grown(form) = &organ.shape {
                form.find_unfinished(Some(organ.symbol), organ.seed(seed), limits, found);
            }
        }
    }

    /// The step after which nothing changes any more, if it comes soon enough to be looked for.
    fn end(&self, seed: u32, limits: &Limits) -> Option<u32> {
        let Steps::Fixed(steps) = self.steps else { return None };
        let limits = Limits { work: limits.work.min(MOST_WORK_AHEAD), ..*limits };
        let mut derivation = Derivation::new(&self.grammar, seed, &limits).ok()?;
        for step in 0..steps.saturating_add(MOST_STEPS_AHEAD) {
            if derivation.step().ok()? == Change::Done {
                return Some(step);
            }
        }
        None
    }
}

/// How far the end of growth is looked for: as many steps behind the last one, and operations of all steps together.
const MOST_STEPS_AHEAD: u32 = 1000;
const MOST_WORK_AHEAD: u64 = 20_000_000;

/// Operations that a polygon takes about until it is triangles.
fn polygon_work(vertices: usize) -> u64 {
    (vertices as u64).saturating_pow(2) / 4 + 100
}

/// From where a turtle starts, heading along y and with −x to its left, to coordinates along its heading, left and up.
const FROM_TURTLE: DMat3 = DMat3::from_cols(DVec3::NEG_Y, DVec3::X, DVec3::Z);

impl Organ {
    /// The seed of its own growth, within something with this seed.
    fn seed(&self, seed: u32) -> u32 {
        derive_seed(seed, &format!("organ.{}", self.symbol))
    }

    /// In coordinates along the turtle's heading, left and up.
    fn body(&self, seed: u32, limits: &Limits, depth: u32) -> Result<Body, Error> {
        let outlines = match &self.shape {
            Shape::Polygons(outlines) => outlines,
            Shape::Grown(_) if depth == 0 => return Err(Error::Depth),
            Shape::Grown(form) => {
                let grown = form.body(self.seed(seed), limits, depth - 1, |_| ())?;
                let mut body = Body::default();
                body.place(&grown, &[DAffine3::from_mat3(FROM_TURTLE)]);
                return Ok(body);
            }
        };
        let mut pace = limits.watch.pace();
        let mut body = Body::default();
        for outline in outlines {
            pace.count(polygon_work(outline.vertices.len()))?;
            let vertices = outline.vertices.iter().map(|&vertex| DVec3::from(vertex)).collect();
            if let Some(blade) = Blade::new(outline.material, vertices, DVec3::Z)? {
                body.add(blade, DVec3::ZERO);
            }
        }
        Ok(body)
    }
}

fn place(placement: &Placement) -> DAffine3 {
    DAffine3::from_mat3_translation(placement.frame * placement.scale, placement.position)
}

fn refuse(bytes: u64, limits: &Limits) -> Result<(), Error> {
    // Triangles name their corners in 32 bits.
    let limit = limits.bytes.min(u32::MAX.into());
    if bytes > limit { Err(mesh::Error::TooLarge { bytes, limit }.into()) } else { Ok(()) }
}
