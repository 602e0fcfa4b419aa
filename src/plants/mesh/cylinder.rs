//! Branches: generalised cylinders along whole axes (Bloomenthal 1985, "Modeling the mighty maple").
//!
//! Rings stand on the planes that halve the bends, and are carried from one segment to the next by the smallest turn
//! that leads there (Bishop 1975, "There is more than one way to frame a curve"): they don't twist, and a piece between
//! two bends is a prism.

use crate::{core::mesh::Mesh, plants::turtle::Node};
use glam::{DVec2, DVec3};
use std::{f64::consts::PI, sync::LazyLock};

/// Sides that a ring may have.
const SIDES: [usize; 6] = [3, 4, 6, 8, 12, 16];
/// Branches thicker than this are rounded at their bends, metres.
const SMOOTH_WIDTH: f64 = 0.1;
/// Most pieces that a segment is cut into for that.
const MOST_PIECES: f64 = 8.0;
/// A tip is a point where it is thinner than this, metres, and than this share of the width at the start.
const POINT_WIDTH: f64 = 0.012;
const POINT_SHARE: f64 = 0.6;
/// How far a blunt end bulges, in widths.
const BULGE: f64 = 0.4;

/// For each of [`SIDES`] the corners of a ring. As long around as a circle of radius 1, so that branches look as thick
/// with few sides as with many: the mean width of a convex outline is its length by π (Cauchy).
static RINGS: LazyLock<[Vec<DVec2>; 6]> = LazyLock::new(|| {
    SIDES.map(|sides| {
        let half = PI / sides as f64;
        let radius = half / libm::sin(half);
        let corner = |corner: usize| {
            let angle = 2.0 * half * corner as f64;
            radius * DVec2::new(libm::cos(angle), libm::sin(angle))
        };
        (0..sides).map(corner).collect()
    })
});

/// A branch as it is going to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Cylinder {
    /// At least one, and at least two of a blunt branch; none at the place of the one before.
    rings: Vec<Ring>,
    /// Where the branch ends in a point; else it ends bluntly at the last ring.
    point: Option<DVec3>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Ring {
    centre: DVec3,
    radius: f64,
    /// Index into [`SIDES`].
    sides: usize,
}

impl Cylinder {
    /// All of an axis, its thick bends rounded, with so many sides that none is farther than `tolerance` metres from the
    /// circle. `None` if the axis has no length or no width.
    pub fn whole(axis: &[Node], tolerance: f64) -> Option<Cylinder> {
        let rings = rings(axis)?;
        let [first, .., last] = rings.as_slice() else { return None };
        let pointed = last.radius <= POINT_SHARE * first.radius && 2.0 * last.radius < POINT_WIDTH;
        Some(Cylinder::new(smooth(&rings, tolerance), pointed, tolerance))
    }

    /// The same without what is smaller than `tolerance`.
    pub fn coarse(axis: &[Node], tolerance: f64) -> Option<Cylinder> {
        let rings = simplify(&rings(axis)?, tolerance);
        let [first, .., last] = rings.as_slice() else { return None };
        if first.centre == last.centre {
            return None;
        }
        let pointed = last.radius <= tolerance;
        Some(Cylinder::new(rings, pointed, tolerance))
    }

    fn new(mut rings: Vec<Ring>, pointed: bool, tolerance: f64) -> Cylinder {
        for ring in &mut rings {
            ring.sides = sides(ring.radius, tolerance);
        }
        let point = if pointed { rings.pop().map(|ring| ring.centre) } else { None };
        Cylinder { rings, point }
    }

    /// How many triangles it takes, apart from the rings that are added where it turns back.
    pub fn triangles(&self) -> usize {
        let tube =
            self.rings.windows(2).map(|pair| SIDES[pair[0].sides] + SIDES[pair[1].sides]).sum::<usize>();
        tube + self.rings.last().map_or(0, |ring| SIDES[ring.sides])
    }

    /// How large a leaf is that covers as much as the branch does if it is drawn `widening` times as thick, on average over
    /// all directions, m²: a quarter of its surface is seen (Cauchy), and half of a leaf.
    pub fn area(&self, widening: f64) -> f64 {
        let radius = |ring: &Ring| widening * ring.radius;
        let tube = self.rings.windows(2).map(|pair| {
            let [from, to] = [&pair[0], &pair[1]];
            let lean = apothem(from.sides) * (radius(from) - radius(to));
            slanting(radius(from) + radius(to), from.centre.distance(to.centre), lean)
        });
        let end = self.rings.last().map(|ring| {
            let height = self.point.map_or(BULGE * 2.0 * radius(ring), |point| ring.centre.distance(point));
            slanting(radius(ring), height, apothem(ring.sides) * radius(ring))
        });
        tube.chain(end).sum()
    }

    /// How many times as thick it is that covers as much as a leaf of `area` m².
    pub fn widening(&self, area: f64) -> f64 {
        let mut widening = 1.0;
        // Its area grows with a power of its thickness between 1 (a thin one's) and 2 (its ends'): at the power of 3/2 each
        // step leaves a third of the error, in log space, or less.
        for _ in 0..12 {
            let ratio = area / self.area(widening);
            widening *= libm::cbrt(ratio * ratio);
        }
        widening
    }

    /// Of its thickest place, metres.
    pub fn radius(&self) -> f64 {
        self.rings.iter().map(|ring| ring.radius).fold(0.0, f64::max)
    }

    pub fn moved(&self, shift: DVec3) -> Cylinder {
        let ring = |ring: &Ring| Ring { centre: ring.centre + shift, ..*ring };
        Cylinder {
            rings: self.rings.iter().map(ring).collect(),
            point: self.point.map(|point| point + shift),
        }
    }

    /// Adds it to a mesh, `widening` times as thick. Texture coordinates are 0…1 around and metres along.
    pub fn draw(&self, widening: f64, mesh: &mut Mesh) {
        let centres: Vec<DVec3> = self.rings.iter().map(|ring| ring.centre).chain(self.point).collect();
        let directions: Vec<DVec3> =
            centres.windows(2).map(|pair| (pair[1] - pair[0]).normalize_or(DVec3::Y)).collect();
        let (Some(&first), Some(&last)) = (directions.first(), directions.last()) else { return };

        let slopes = self.slopes(widening);
        let mut pen = Pen { mesh, side: first.any_orthonormal_vector(), along: 0.0, before: None };
        for (index, ring) in self.rings.iter().enumerate() {
            let from = if index == 0 { first } else { directions[index - 1] };
            let to = *directions.get(index).unwrap_or(&last);
            let slope = slopes[index];
            pen.along += if index == 0 { 0.0 } else { ring.centre.distance(centres[index - 1]) };
            // A ring on the plane that halves a sharp bend would reach far out: there the branch turns in two steps.
            if from.dot(to) < 0.0 {
                let between = (from + to).try_normalize().unwrap_or_else(|| from.any_orthonormal_vector());
                pen.ring(ring, widening, slope, from, between);
                pen.ring(ring, widening, slope, between, to);
            } else {
                pen.ring(ring, widening, slope, from, to);
            }
        }
        let Some(ring) = self.rings.last() else { return };
        match self.point {
            Some(point) => {
                let length = ring.centre.distance(point);
                pen.along += length;
                pen.point(point, last, |outward| outward + last * (widening * ring.radius / length));
            }
            None => {
                let length = BULGE * 2.0 * widening * ring.radius;
                pen.repeat(|normal| normal + last);
                pen.along += length;
                pen.point(ring.centre + length * last, last, |_| last);
            }
        }
    }

    /// How fast the radius grows at each ring, for normals: the mean of both sides.
    fn slopes(&self, widening: f64) -> Vec<f64> {
        let end = self.point.map(|point| (point, 0.0));
        let all: Vec<_> =
            self.rings.iter().map(|ring| (ring.centre, widening * ring.radius)).chain(end).collect();
        let at = |index: usize| {
            let (from, to) = (index.saturating_sub(1), (index + 1).min(all.len() - 1));
            let length = all[from..=to].windows(2).map(|pair| pair[0].0.distance(pair[1].0)).sum::<f64>();
            (all[to].1 - all[from].1) / length
        };
        (0..self.rings.len()).map(at).collect()
    }
}

/// Where a cylinder is being drawn.
struct Pen<'a> {
    mesh: &'a mut Mesh,
    /// Where the first corner of a ring lies, seen from its centre.
    side: DVec3,
    /// Length of the axis so far, metres.
    along: f64,
    /// The last ring: its first vertex and how many sides it has.
    before: Option<(u32, usize)>,
}

impl Pen<'_> {
    /// A ring where the axis bends from one direction to another, by a right angle at most.
    fn ring(&mut self, ring: &Ring, widening: f64, slope: f64, from: DVec3, to: DVec3) {
        let axis = (from + to).normalize_or(to);
        self.side = turn(self.side, from, axis);
        let other = axis.cross(self.side);
        // The section of a cylinder by the plane that halves the bend is longer in the direction of the bend.
        let bend = (to - from).normalize_or_zero();
        let excess = 2.0 / (from + to).length() - 1.0;

        let corners = &RINGS[ring.sides];
        let first = self.mesh.positions.len() as u32;
        for corner in 0..=corners.len() {
            let at = corners[corner % corners.len()];
            let outward = at.x * self.side + at.y * other;
            let offset = outward + excess * outward.dot(bend) * bend;
            let normal = outward.normalize_or(self.side) - slope * axis;
            self.vertex(
                ring.centre + widening * ring.radius * offset,
                normal,
                corner as f64 / corners.len() as f64,
            );
        }
        self.join(first, corners.len());
        self.side = turn(self.side, axis, to);
    }

    /// The last ring once more, with other normals: there is an edge.
    fn repeat(&mut self, normal: impl Fn(DVec3) -> DVec3) {
        let Some((before, sides)) = self.before else { return };
        let first = self.mesh.positions.len() as u32;
        for vertex in before as usize..=before as usize + sides {
            self.mesh.positions.push(self.mesh.positions[vertex]);
            self.mesh.uvs.push(self.mesh.uvs[vertex]);
            let normal = normal(DVec3::from(self.mesh.normals[vertex].map(f64::from)));
            self.mesh.normals.push(normal.normalize_or(DVec3::Y).as_vec3().to_array());
        }
        self.before = Some((first, sides));
    }

    /// Triangles from the last ring to a point that lies straight ahead.
    fn point(&mut self, point: DVec3, axis: DVec3, normal: impl Fn(DVec3) -> DVec3) {
        let Some((before, sides)) = self.before else { return };
        let other = axis.cross(self.side);
        for corner in 0..sides {
            let share = (corner as f64 + 0.5) / sides as f64;
            let outward = libm::cos(2.0 * PI * share) * self.side + libm::sin(2.0 * PI * share) * other;
            let tip = self.mesh.positions.len() as u32;
            self.vertex(point, normal(outward), share);
            self.mesh.triangles.push([before + corner as u32, before + corner as u32 + 1, tip]);
        }
    }

    fn vertex(&mut self, position: DVec3, normal: DVec3, around: f64) {
        self.mesh.positions.push(position.as_vec3().to_array());
        self.mesh.normals.push(normal.normalize_or(DVec3::Y).as_vec3().to_array());
        self.mesh.uvs.push([around as f32, self.along as f32]);
    }

    /// Triangles between the last ring and the next, whose numbers of sides may differ: the edge that ends first as one
    /// goes around comes first.
    fn join(&mut self, next: u32, sides: usize) {
        if let Some((before, sides_before)) = self.before {
            let (mut low, mut high) = (0, 0);
            while low < sides_before || high < sides {
                let [lower, upper] = [before + low as u32, next + high as u32];
                if high == sides || (low < sides_before && (low + 1) * sides <= (high + 1) * sides_before) {
                    self.mesh.triangles.push([lower, lower + 1, upper]);
                    low += 1;
                } else {
                    self.mesh.triangles.push([lower, upper + 1, upper]);
                    high += 1;
                }
            }
        }
        self.before = Some((next, sides));
    }
}

/// A vector across `from`, carried by the smallest turn that leads from there to `to`.
fn turn(vector: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let axis = from.cross(to);
    let turned = vector + axis.cross(vector) + axis.cross(axis.cross(vector)) / (1.0 + from.dot(to));
    // What rounding has added up is taken away.
    turned.reject_from_normalized(to).try_normalize().unwrap_or_else(|| to.any_orthonormal_vector())
}

/// What [`Cylinder::area`] says of a piece of a cone or pyramid: half its surface, where `radii` is the sum of both radii,
/// `height` how far they are apart, and `lean` how much nearer to the axis a side's middle gets.
fn slanting(radii: f64, height: f64, lean: f64) -> f64 {
    PI / 2.0 * radii * (height * height + lean * lean).sqrt()
}

/// Distance of a ring's sides from its centre, by its radius. See [`RINGS`].
fn apothem(sides: usize) -> f64 {
    let half = PI / SIDES[sides] as f64;
    half / libm::tan(half)
}

/// The fewest sides that are within `tolerance` of a circle.
fn sides(radius: f64, tolerance: f64) -> usize {
    let sagitta = |sides: usize| radius * (1.0 - libm::cos(PI / sides as f64));
    SIDES.iter().position(|&sides| sagitta(sides) <= tolerance).unwrap_or(SIDES.len() - 1)
}

/// The nodes of an axis where it has length, with radii above zero. Of nodes at one place the last one's width holds.
fn rings(axis: &[Node]) -> Option<Vec<Ring>> {
    let length: f64 = axis.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    let widest = axis.iter().map(|node| node.width).fold(0.0, f64::max);
    let mut rings: Vec<Ring> = Vec::with_capacity(axis.len());
    for node in axis {
        let radius = node.width.max(1e-3 * widest) / 2.0;
        match rings.last_mut() {
            Some(ring) if ring.centre.distance(node.position) <= 1e-6 * length => ring.radius = radius,
            _ => rings.push(Ring { centre: node.position, radius, sides: 0 }),
        }
    }
    (rings.len() > 1 && widest > 0.0).then_some(rings)
}

/// Rings on a smooth curve through those given (Catmull & Rom 1974, by length of chord) where the branch is thick and bends
/// more than `tolerance`. Widths follow a curve too, but don't leave the bounds of their segment.
fn smooth(rings: &[Ring], tolerance: f64) -> Vec<Ring> {
    let chord = |index: usize| rings[index + 1].centre - rings[index].centre;
    let last = rings.len() - 1;
    // Change of place and of radius by length: of a chord …
    let straight = |index: usize| {
        let length = chord(index).length();
        (chord(index) / length, (rings[index + 1].radius - rings[index].radius) / length)
    };
    // … and at a node, from the parabola through it and its neighbours; at an end from that through the three last nodes
    // (Bessel's tangents; de Boor 1978, "A Practical Guide to Splines", chapter IV).
    let inner = |node: usize| {
        let [(from, from_growth), (to, to_growth)] = [straight(node - 1), straight(node)];
        let [before, after] = [node - 1, node].map(|index| chord(index).length());
        let share = before / (before + after);
        (from.lerp(to, share), from_growth + share * (to_growth - from_growth))
    };
    let outer = |(direction, growth): (DVec3, f64), (inner, inner_growth): (DVec3, f64)| {
        (2.0 * direction - inner, 2.0 * growth - inner_growth)
    };
    let tangent = |node: usize| match node {
        _ if last == 1 => straight(0),
        0 => outer(straight(0), inner(1)),
        _ if node == last => outer(straight(last - 1), inner(last - 1)),
        _ => inner(node),
    };
    let mut curve = Vec::with_capacity(rings.len());
    for index in 0..last {
        let (from, to) = (rings[index], rings[index + 1]);
        curve.push(from);
        if 2.0 * from.radius.max(to.radius) < SMOOTH_WIDTH {
            continue;
        }
        let length = chord(index).length();
        let [(start, start_growth), (end, end_growth)] = [tangent(index), tangent(index + 1)];
        let bend = (end - start).length() + (end_growth - start_growth).abs();
        let pieces = (length * bend / (8.0 * tolerance)).sqrt().ceil().clamp(1.0, MOST_PIECES) as usize;
        for piece in 1..pieces {
            let t = piece as f64 / pieces as f64;
            // Hermite's basis.
            let rise = t * t * (3.0 - 2.0 * t);
            let (leave, arrive) = (t * (1.0 - t) * (1.0 - t), t * t * (t - 1.0));
            let radius = from.radius
                + rise * (to.radius - from.radius)
                + length * (leave * start_growth + arrive * end_growth);
            curve.push(Ring {
                centre: from.centre + rise * chord(index) + length * (leave * start + arrive * end),
                radius: radius.clamp(from.radius.min(to.radius), from.radius.max(to.radius)),
                sides: 0,
            });
        }
    }
    curve.push(rings[last]);
    curve
}

/// The rings that it takes to stay within `tolerance` of all, in place and in radius (Douglas & Peucker 1973).
fn simplify(rings: &[Ring], tolerance: f64) -> Vec<Ring> {
    let mut kept = vec![rings[0]];
    // The last is the nearest to the start.
    let mut ends = vec![rings.len() - 1];
    let mut from = 0;
    while let Some(&to) = ends.last() {
        let chord = rings[to].centre - rings[from].centre;
        let error = |ring: &Ring| {
            let offset = ring.centre - rings[from].centre;
            let share = (offset.dot(chord) / chord.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let radius = rings[from].radius + share * (rings[to].radius - rings[from].radius);
            (offset - share * chord).length().max((ring.radius - radius).abs())
        };
        let errors = (from + 1..to).map(|index| (index, error(&rings[index])));
        match errors.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((index, error)) if error > tolerance => ends.push(index),
            _ => {
                kept.push(rings[to]);
                from = to;
                ends.pop();
            }
        }
    }
    kept
}
