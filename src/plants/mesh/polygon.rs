//! Polygons in space as triangles.

use crate::plants::turtle::vector_area;
use glam::{DVec2, DVec3};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Most vertices of a polygon: time grows with their square.
pub const MAX_VERTICES: usize = 1000;

/// Cuts a polygon into `n − 2` triangles that run around like its outline does.
///
/// Ears are clipped in the plane across [`vector_area`], always the one with the shortest diagonal: a long leaf that is
/// bent out of its plane becomes a strip of rungs, where a fan would cut across the bend. What crosses or touches
/// itself gets triangles too, if not those that one would choose. Time grows with the square of the number of vertices.
pub fn triangulate(vertices: &[DVec3]) -> Vec<[u32; 3]> {
    if vertices.len() < 3 {
        return Vec::new();
    }
    let mut outline = Outline::new(vertices);
    let mut ears: BinaryHeap<Reverse<Ear>> =
        (0..vertices.len()).filter_map(|corner| outline.ear(corner)).map(Reverse).collect();
    let mut triangles = Vec::with_capacity(vertices.len() - 2);
    let mut last = 0;
    while triangles.len() < vertices.len() - 2 {
        let ear = match ears.pop() {
            Some(Reverse(ear)) if outline.has(&ear) => ear,
            Some(_) => continue,
            None => outline.shortest(last),
        };
        triangles.push([ear.before, ear.corner, ear.after].map(|corner| corner as u32));
        outline.clip(&ear);
        ears.extend(
            [ear.before, ear.after].into_iter().filter_map(|corner| outline.ear(corner)).map(Reverse),
        );
        last = ear.after;
    }
    triangles
}

/// A corner that can be cut off. The one with the shortest diagonal comes first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Ear {
    /// Bits of the diagonal's square: floats that are not negative have the order of their bits.
    diagonal: u64,
    corner: usize,
    before: usize,
    after: usize,
}

/// What is left of a polygon.
struct Outline<'a> {
    vertices: &'a [DVec3],
    /// In the polygon's plane, counter-clockwise.
    flat: Vec<DVec2>,
    /// The neighbours of every corner; those of a corner that is gone are itself.
    before: Vec<usize>,
    after: Vec<usize>,
    convex: Vec<bool>,
    /// Twice the area of a triangle that counts as none.
    nothing: f64,
}

impl<'a> Outline<'a> {
    fn new(vertices: &'a [DVec3]) -> Self {
        let count = vertices.len();
        let area = vector_area(vertices);
        let east = area.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_vector();
        let north = area.try_normalize().unwrap_or(DVec3::Z).cross(east);
        let flatten = |&vertex: &DVec3| {
            let offset = vertex - vertices[0];
            DVec2::new(offset.dot(east), offset.dot(north))
        };
        let mut outline = Outline {
            vertices,
            flat: vertices.iter().map(flatten).collect(),
            before: (0..count).map(|corner| (corner + count - 1) % count).collect(),
            after: (0..count).map(|corner| (corner + 1) % count).collect(),
            convex: vec![false; count],
            nothing: 1e-12 * area.length(),
        };
        for corner in 0..count {
            outline.convex[corner] = outline.is_convex(corner);
        }
        outline
    }

    /// The ear at a corner, if it is one: it is convex, and nothing of the outline lies within it. Only corners that are
    /// not convex can lie there alone.
    fn ear(&self, corner: usize) -> Option<Ear> {
        if !self.convex[corner] {
            return None;
        }
        let ear = self.triangle(corner);
        let [a, b, c] = [ear.before, corner, ear.after].map(|corner| self.flat[corner]);
        let mut other = self.after[ear.after];
        while other != ear.before {
            let point = self.flat[other];
            if !self.convex[other] && ![a, b, c].contains(&point) && holds([a, b, c], point) {
                return None;
            }
            other = self.after[other];
        }
        Some(ear)
    }

    fn has(&self, ear: &Ear) -> bool {
        self.before[ear.corner] == ear.before && self.after[ear.corner] == ear.after
    }

    /// The corner with the shortest diagonal, whether an ear or not: where an outline crosses itself there may be none.
    fn shortest(&self, start: usize) -> Ear {
        let around = std::iter::successors(Some(start), |&corner| {
            Some(self.after[corner]).filter(|&next| next != start)
        });
        around.map(|corner| self.triangle(corner)).min().unwrap_or_else(|| self.triangle(start))
    }

    fn clip(&mut self, ear: &Ear) {
        self.after[ear.before] = ear.after;
        self.before[ear.after] = ear.before;
        self.before[ear.corner] = ear.corner;
        self.after[ear.corner] = ear.corner;
        for corner in [ear.before, ear.after] {
            self.convex[corner] = self.is_convex(corner);
        }
    }

    fn triangle(&self, corner: usize) -> Ear {
        let [before, after] = [self.before[corner], self.after[corner]];
        let diagonal = (self.vertices[after] - self.vertices[before]).length_squared().to_bits();
        Ear { diagonal, corner, before, after }
    }

    fn is_convex(&self, corner: usize) -> bool {
        turn(self.flat[self.before[corner]], self.flat[corner], self.flat[self.after[corner]]) > self.nothing
    }
}

/// Whether a point lies within a counter-clockwise triangle or on its rim.
fn holds([a, b, c]: [DVec2; 3], point: DVec2) -> bool {
    turn(a, b, point) >= 0.0 && turn(b, c, point) >= 0.0 && turn(c, a, point) >= 0.0
}

/// Twice the area of a triangle: above zero where it runs counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}
