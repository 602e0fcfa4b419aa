//! Flat organs: leaves, petals, needles, and what they look like from afar.

use super::Error;
use super::polygon::{MAX_VERTICES, triangulate};
use crate::plants::turtle::vector_area;
use glam::{DVec2, DVec3};

/// A triangulated polygon, in coordinates of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Blade {
    /// Index into the materials of a species.
    pub material: usize,
    /// Of its triangles, m².
    pub area: f64,
    /// From the vertex or edge nearest to the origin to the vertex farthest from that.
    pub length: f64,
    /// Middle of the blade, about which it grows.
    pub centre: DVec3,
    base: DVec3,
    /// Unit vectors: from the base to the tip, and across in the blade's plane.
    along: DVec3,
    across: DVec3,
    /// Least and greatest coordinates across and along.
    range: [DVec2; 2],
    shapes: [Vec<[DVec3; 3]>; 3],
}

/// How closely a blade is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Whole,
    /// Two triangles as large as the blade and folded like it: they meet in the line from base to tip, or across it in a
    /// blade that is bent over.
    Kite,
    /// One as large as the blade.
    Triangle,
}

impl Blade {
    /// The blade with this outline, whose front is the side of `up`. `None` if it encloses nothing.
    ///
    /// # Errors
    /// An outline of more than [`MAX_VERTICES`] vertices.
    pub fn new(material: usize, mut outline: Vec<DVec3>, up: DVec3) -> Result<Option<Blade>, Error> {
        if outline.len() > MAX_VERTICES {
            return Err(Error::Polygon { vertices: outline.len() });
        }
        if vector_area(&outline).dot(up) < 0.0 {
            outline.reverse();
        }
        let corners = |triangle: [u32; 3]| triangle.map(|corner| outline[corner as usize]);
        let whole: Vec<_> =
            triangulate(&outline).into_iter().map(corners).filter(|&t| area(t) > 0.0).collect();
        let total = whole.iter().map(|&triangle| area(triangle)).sum::<f64>();

        let farthest = |from: DVec3| {
            outline
                .iter()
                .copied()
                .max_by(|a, b| a.distance_squared(from).total_cmp(&b.distance_squared(from)))
        };
        let Some(base) = base(&outline) else { return Ok(None) };
        let Some(tip) = farthest(base) else { return Ok(None) };
        let (Some(along), true) = ((tip - base).try_normalize(), total > 0.0) else { return Ok(None) };
        let Some(across) = vector_area(&outline).cross(along).try_normalize() else { return Ok(None) };

        let mut blade = Blade {
            material,
            area: total,
            length: base.distance(tip),
            centre: whole.iter().map(|&triangle| area(triangle) * middle(triangle)).sum::<DVec3>() / total,
            base,
            along,
            across,
            range: [DVec2::ZERO; 2],
            shapes: [whole, Vec::new(), Vec::new()],
        };
        let places = outline.iter().map(|&vertex| blade.place(vertex));
        blade.range = places
            .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[least, most], at| [least.min(at), most.max(at)]);
        blade.shapes[Shape::Kite as usize] = blade.kite(&outline, tip);
        blade.shapes[Shape::Triangle as usize] = vec![blade.triangle(tip)];
        Ok(Some(blade))
    }

    pub fn triangles(&self, shape: Shape) -> &[[DVec3; 3]] {
        &self.shapes[shape as usize]
    }

    /// Width of a kite as long and as large as the blade.
    pub fn width(&self) -> f64 {
        2.0 * self.area / self.length
    }

    /// Texture coordinates: 0…1 across and from base to tip.
    pub fn uv(&self, vertex: DVec3) -> [f32; 2] {
        let [least, most] = self.range;
        let size = (most - least).max(DVec2::splat(f64::MIN_POSITIVE));
        ((self.place(vertex) - least) / size).clamp(DVec2::ZERO, DVec2::ONE).as_vec2().to_array()
    }

    /// Distance from the base across and along.
    fn place(&self, vertex: DVec3) -> DVec2 {
        DVec2::new((vertex - self.base).dot(self.across), (vertex - self.base).dot(self.along))
    }

    fn kite(&self, outline: &[DVec3], tip: DVec3) -> Vec<[DVec3; 3]> {
        let side = |sign: f64| {
            let reach = |vertex: &&DVec3| sign * self.place(**vertex).x;
            outline.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))).copied().unwrap_or(self.base)
        };
        let from_line = |vertex: DVec3| (vertex - self.base).reject_from_normalized(self.along);
        let [left, right] = [side(1.0), side(-1.0)];
        let kite = if from_line((left + right) / 2.0).length() > left.distance(right) / 2.0 {
            let middle = (left + right) / 2.0;
            let height = |end: DVec3| (end - middle).reject_from_normalized(self.across).length();
            let reach = self.area / (height(self.base) + height(tip)) * self.across;
            let [left, right] = [middle + reach, middle - reach];
            [[self.base, right, left], [left, right, tip]]
        } else {
            let reach = from_line(left).length() + from_line(right).length();
            let widen = |vertex: DVec3| vertex + (self.width() / reach - 1.0) * from_line(vertex);
            [[self.base, widen(right), tip], [self.base, tip, widen(left)]]
        };
        kite.into_iter().filter(|&triangle| area(triangle) > 1e-3 * self.area).collect()
    }

    fn triangle(&self, tip: DVec3) -> [DVec3; 3] {
        let reach = self.width() / 2.0 * self.across;
        [self.base + reach, self.base - reach, tip]
    }

    /// A vertex moved away from the centre by factors along (and the way the blade is bent) and across.
    pub fn stretched(&self, vertex: DVec3, along: f64, across: f64) -> DVec3 {
        let offset = vertex - self.centre;
        self.centre + along * offset + (across - along) * offset.dot(self.across) * self.across
    }
}

/// The vertex nearest to the origin, or the middle of an edge whose ends are the nearest both.
fn base(outline: &[DVec3]) -> Option<DVec3> {
    let least = outline.iter().map(|vertex| vertex.length_squared()).fold(f64::INFINITY, f64::min);
    let near = |index: &usize| outline[*index].length_squared() <= least * (1.0 + 1e-9);
    match (0..outline.len()).filter(near).collect::<Vec<_>>()[..] {
        [one, other] if other - one == 1 || other - one == outline.len() - 1 => {
            Some((outline[one] + outline[other]) / 2.0)
        }
        [one, ..] => Some(outline[one]),
        [] => None,
    }
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length() / 2.0
}

fn middle([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}
