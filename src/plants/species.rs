//! A species: how a kind of plant grows and what it is made of, and its models.

use super::{
    derive::{self, Limits, Steps},
    grammar::Grammar,
    mesh::{self, Blade, Body, Stem},
    turtle::{self, Interpretation, Placement},
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
    #[error("material {index} of {count}")]
    Material { index: usize, count: usize },
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
        Ok(self.model(&self.body(seed, variant, limits)?))
    }

    /// A variant's branches and leaves, scaled to the height that the species has.
    ///
    /// # Errors
    /// As [`derive::derive`] and [`turtle::draw`]; where it would take more memory than `limits` allow, before it does; where
    /// it is no shape.
    pub fn body(&self, seed: u32, variant: u32, limits: &Limits) -> Result<Body, Error> {
        let mut body = self.form.body(variant_seed(seed, variant), limits, MAX_DEPTH)?;
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

    /// The triangles of a body of this species.
    pub fn model(&self, body: &Body) -> Model {
        let mut levels = mesh::levels(body);
        let used =
            |index: &usize| levels.iter().flat_map(|level| &level.parts).any(|part| part.material == *index);
        let used: Vec<usize> = (0..self.materials.len()).filter(used).collect();
        for part in levels.iter_mut().flat_map(|level| &mut level.parts) {
            part.material = used.partition_point(|&index| index < part.material);
        }
        let materials = used.iter().map(|&index| self.materials[index].clone()).collect();
        Model { name: self.name.clone(), materials, levels }
    }
}

impl Form {
    /// Derives and draws it, and bears its organs: each has grown once, and is then placed as often as it is named.
    fn body(&self, seed: u32, limits: &Limits, depth: u32) -> Result<Body, Error> {
        let word = derive::derive(&self.grammar, self.steps, seed, limits)?;
        let drawing = turtle::draw(&word, &self.turtle)?;
        let mut body = Body::default();
        for axis in drawing.axes {
            body.stems.push(Stem { material: self.wood, nodes: axis.nodes });
        }
        for polygon in drawing.polygons {
            let Some(&first) = polygon.vertices.first() else { continue };
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
            body.place(&part, &places);
        }
        Ok(body)
    }
}

/// From where a turtle starts, heading along y and with −x to its left, to coordinates along its heading, left and up.
const FROM_TURTLE: DMat3 = DMat3::from_cols(DVec3::NEG_Y, DVec3::X, DVec3::Z);

impl Organ {
    /// In coordinates along the turtle's heading, left and up.
    fn body(&self, seed: u32, limits: &Limits, depth: u32) -> Result<Body, Error> {
        let outlines = match &self.shape {
            Shape::Polygons(outlines) => outlines,
            Shape::Grown(_) if depth == 0 => return Err(Error::Depth),
            Shape::Grown(form) => {
                let grown =
                    form.body(derive_seed(seed, &format!("organ.{}", self.symbol)), limits, depth - 1)?;
                let mut body = Body::default();
                body.place(&grown, &[DAffine3::from_mat3(FROM_TURTLE)]);
                return Ok(body);
            }
        };
        let mut body = Body::default();
        for outline in outlines {
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
