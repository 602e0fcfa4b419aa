//! A plant in parts, before it becomes triangles.

use super::{Blade, Error};
use crate::plants::turtle::Node;
use glam::{DAffine3, DMat3, DVec3};

/// How far a plant may reach from its foot, metres: floats of 32 bits still tell a centimetre there.
pub const REACH: f64 = 1e5;

/// Branches and leaves in space, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    pub stems: Vec<Stem>,
    /// Shapes of leaves, each kept once.
    pub blades: Vec<Blade>,
    pub leaves: Vec<Leaf>,
}

/// A branch: an axis and what it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Stem {
    /// Index into the materials of a species.
    pub material: usize,
    pub nodes: Vec<Node>,
}

/// A blade at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Index into [`Body::blades`].
    pub blade: usize,
    /// Turns, moves and scales the same in all directions.
    pub place: DAffine3,
}

impl Body {
    /// Adds a leaf with a blade of its own.
    pub fn add(&mut self, blade: Blade, at: DVec3) {
        self.leaves.push(Leaf { blade: self.blades.len(), place: DAffine3::from_translation(at) });
        self.blades.push(blade);
    }

    /// Adds another body at each of these places.
    pub fn place(&mut self, other: &Body, places: &[DAffine3]) {
        let first = self.blades.len();
        self.blades.extend_from_slice(&other.blades);
        for place in places {
            let leaf = |leaf: &Leaf| Leaf { blade: first + leaf.blade, place: *place * leaf.place };
            self.leaves.extend(other.leaves.iter().map(leaf));
            self.stems.extend(other.stems.iter().map(|stem| stem.transformed(place)));
        }
    }

    /// Nodes of its branches and leaves.
    pub fn size(&self) -> u64 {
        self.stems.iter().map(|stem| stem.nodes.len() as u64).sum::<u64>() + self.leaves.len() as u64
    }

    /// Bytes of memory that `times` of it take, with the triangles of their finest level at most.
    pub fn bytes(&self, times: usize) -> u64 {
        const VERTEX: usize = 32;
        const TRIANGLE: usize = 12;
        // Rings of 16 sides, two where a branch turns back, and a point.
        const NODE: usize = size_of::<Node>() + 2 * 17 * (VERTEX + 2 * TRIANGLE);
        let stems: usize = self.stems.iter().map(|stem| size_of::<Stem>() + NODE * stem.nodes.len()).sum();
        let leaf = |leaf: &Leaf| {
            let triangles = self.blades[leaf.blade].triangles(super::Shape::Whole).len();
            size_of::<Leaf>() + triangles * (3 * VERTEX + TRIANGLE)
        };
        let leaves: usize = self.leaves.iter().map(leaf).sum();
        (stems as u64).saturating_add(leaves as u64).saturating_mul(times as u64)
    }

    /// Least and greatest coordinates, of branches with their thickness; `None` of nothing.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let stems = self.stems.iter().flat_map(Stem::extremes);
        let corners = |leaf: &Leaf| {
            let place = leaf.place;
            let triangles = self.blades[leaf.blade].triangles(super::Shape::Whole);
            triangles.as_flattened().iter().map(move |&corner| place.transform_point3(corner))
        };
        let points = stems.chain(self.leaves.iter().flat_map(corners)).map(|point| [point; 2]);
        points.reduce(|all, point| [all[0].min(point[0]), all[1].max(point[1])])
    }

    /// Scales it so that its vertical extent is `height`.
    ///
    /// # Errors
    /// If it has none.
    pub fn scale_to(&mut self, height: f64) -> Result<(), Error> {
        let Some([least, most]) = self.bounds() else { return Ok(()) };
        let factor = height / (most.y - least.y);
        if !factor.is_finite() {
            return Err(Error::Flat { height });
        }
        let place = DAffine3::from_scale(DVec3::splat(factor));
        for stem in &mut self.stems {
            *stem = stem.transformed(&place);
        }
        for leaf in &mut self.leaves {
            leaf.place = place * leaf.place;
        }
        Ok(())
    }

    /// Of its leaves, one-sided, m².
    pub fn leaf_area(&self) -> f64 {
        // From 0 on: the sum of nothing is −0.
        self.leaves.iter().fold(0.0, |sum, leaf| sum + self.area(leaf))
    }

    pub fn area(&self, leaf: &Leaf) -> f64 {
        leaf.scale().powi(2) * self.blades[leaf.blade].area
    }

    /// # Errors
    /// If something lies farther out than [`REACH`], or nowhere.
    pub fn check(&self) -> Result<(), Error> {
        let Some([least, most]) = self.bounds() else { return Ok(()) };
        let reach = least.abs().max(most.abs()).max_element();
        // Minimum and maximum pass over what is no number.
        let finite = self
            .stems
            .iter()
            .flat_map(|stem| &stem.nodes)
            .all(|node| node.position.is_finite() && node.width.is_finite())
            && self.leaves.iter().all(|leaf| leaf.place.is_finite());
        if finite && reach <= REACH { Ok(()) } else { Err(Error::Reach { reach }) }
    }
}

impl Stem {
    fn transformed(&self, place: &DAffine3) -> Stem {
        let scale = place.matrix3.x_axis.length();
        let node = |node: &Node| Node {
            position: place.transform_point3(node.position),
            width: scale * node.width,
            color: node.color,
        };
        Stem { material: self.material, nodes: self.nodes.iter().map(node).collect() }
    }

    /// Points that bound it: those of a disc about each node, across the axis.
    fn extremes(&self) -> impl Iterator<Item = DVec3> {
        let last = self.nodes.len().saturating_sub(1);
        self.nodes.iter().enumerate().flat_map(move |(index, node)| {
            let [from, to] =
                [index.saturating_sub(1), (index + 1).min(last)].map(|index| self.nodes[index].position);
            let direction = (to - from).normalize_or_zero();
            let reach = node.width.max(0.0) / 2.0
                * (DVec3::ONE - direction * direction).max(DVec3::ZERO).map(f64::sqrt);
            [node.position - reach, node.position + reach]
        })
    }
}

impl Leaf {
    pub fn scale(&self) -> f64 {
        self.place.matrix3.x_axis.length()
    }

    /// Whether it is mirrored, so that triangles run around the other way.
    pub fn is_mirrored(&self) -> bool {
        DMat3::determinant(&self.place.matrix3) < 0.0
    }
}
