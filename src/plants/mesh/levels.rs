//! Levels of detail: fewer and larger leaves and twigs that together cover as much (Cook, Halstead, Planck & Ryu 2007,
//! "Stochastic simplification of aggregate detail").
//!
//! A level has a number of triangles to spend, and all of them stand for about the same area. What is larger than its
//! triangles' share stays. What is smaller is gathered along a curve that fills space, until it is as large; then one
//! of those that were gathered stands for them all, as large as they are together. So no material loses area and
//! nothing moves far.

use super::{Blade, Body, Cylinder, Leaf, Shape};
use crate::{
    core::{hash::mix, mesh::Mesh},
    plants::watch::{Pace, Stopped, Watch},
    scene::{Level, Part},
};
use glam::{DVec3, UVec3};

/// How many times fewer triangles each level has.
const REDUCTION: f64 = 5.0;
/// Levels that there are in any case …
const LEAST_LEVELS: usize = 3;
/// … and how many triangles further levels have at least: a crown of fewer covers a quarter more than it should.
const FEW: f64 = 48.0;
/// A level may have so many times the triangles that it is to spend; how often it is gathered to keep to that.
const EXCESS: f64 = 2.0;
const ATTEMPTS: usize = 8;
/// How far the finest level is from round: this share of a plant's size, and this many metres at most.
const ROUNDNESS: f64 = 1e-3;
const COARSEST_ROUNDNESS: f64 = 0.004;
/// Coarse branches are drawn within this share of a level's detail.
const TOLERANCE: f64 = 1.0 / 3.0;
/// Leaves become wider before they become longer, until they are this wide for their length: blades of grass stay in their
/// tuft.
const STOUT: f64 = 0.5;

/// Operations that a node of a branch, and a leaf, take about in a level.
const NODE: u64 = 100;
const LEAF: u64 = 50;

/// The levels of detail of a plant, the finest first. Parts name materials as the body does.
///
/// # Errors
/// When it is stopped.
pub fn levels(body: &Body, watch: Watch) -> Result<Vec<Level>, Stopped> {
    let Some([least, most]) = body.bounds() else { return Ok(vec![Level::default()]) };
    let mut pace = watch.pace();
    let roundness = (ROUNDNESS * (most - least).max_element()).min(COARSEST_ROUNDNESS);
    let whole = whole(body, roundness, &mut pace)?;
    let finest = whole.triangles() as f64;

    let elements = elements(body, roundness, least, most, &mut pace)?;
    let area: f64 = elements.iter().map(|element| element.area).sum();
    let mut levels = vec![whole];
    let mut budget = finest / REDUCTION;
    while budget >= FEW || levels.len() < LEAST_LEVELS {
        // Half the side of a square as large as what a triangle stands for.
        let detail = (area / budget).sqrt() / 2.0;
        let shape = if levels.len() == 1 { Shape::Kite } else { Shape::Triangle };
        levels.push(coarse(body, &elements, budget, detail, shape, &mut pace)?);
        budget /= REDUCTION;
    }
    Ok(levels)
}

/// Everything, as it is.
fn whole(body: &Body, roundness: f64, pace: &mut Pace) -> Result<Level, Stopped> {
    let mut meshes = Meshes::default();
    for stem in &body.stems {
        pace.count(NODE * stem.nodes.len() as u64)?;
        if let Some(cylinder) = Cylinder::whole(&stem.nodes, roundness) {
            cylinder.draw(1.0, meshes.of(stem.material));
        }
    }
    for leaf in &body.leaves {
        pace.count(LEAF)?;
        meshes.leaf(leaf, &body.blades[leaf.blade], Shape::Whole, 1.0, DVec3::ZERO);
    }
    Ok(meshes.level(0.0))
}

fn coarse(
    body: &Body,
    elements: &[Element],
    budget: f64,
    detail: f64,
    shape: Shape,
    pace: &mut Pace,
) -> Result<Level, Stopped> {
    let cylinder = |index: usize| Cylinder::coarse(&body.stems[index].nodes, TOLERANCE * detail);
    let mut drawn = Vec::with_capacity(elements.len());
    for element in elements {
        pace.count(element.work(body))?;
        let (cylinder, triangles) = match element.kind {
            Kind::Stem(index) => {
                let Some(cylinder) = cylinder(index) else { continue };
                let triangles = cylinder.triangles();
                (Some(cylinder), triangles)
            }
            Kind::Leaf(index) => (None, body.blades[body.leaves[index].blade].triangles(shape).len()),
        };
        drawn.push(Drawn { element, cylinder, triangles: triangles as f64 });
    }
    let mut meshes = Meshes::default();
    for run in runs(&drawn, budget) {
        let area: f64 = run.iter().map(|drawn| drawn.element.area).sum();
        let centre = run.iter().map(|drawn| drawn.element.area * drawn.element.centre).sum::<DVec3>() / area;
        let Some(Drawn { element, cylinder, .. }) = chosen(&run) else { continue };
        pace.count(element.work(body))?;
        match (element.kind, cylinder) {
            (Kind::Stem(_), Some(cylinder)) => {
                // Towards the middle of those that it stands for, where leaves hide it as they do them, but by half of what
                // it grows at most.
                let widening = cylinder.widening(area);
                let grown = (0.5 * (widening - 1.0) * cylinder.radius()).max(0.0);
                let moved = cylinder.moved((centre - element.centre).clamp_length_max(grown));
                moved.draw(widening, meshes.of(element.material));
            }
            (Kind::Leaf(index), _) => {
                let leaf = &body.leaves[index];
                let shift = centre - element.centre;
                meshes.leaf(leaf, &body.blades[leaf.blade], shape, area / element.area, shift);
            }
            _ => {}
        }
    }
    Ok(meshes.level(detail as f32))
}

/// A branch or a leaf that may be left out.
struct Element {
    kind: Kind,
    material: usize,
    centre: DVec3,
    /// Of a leaf, or of one that covers as much, m².
    area: f64,
    /// Along the curve.
    order: u64,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Stem(usize),
    Leaf(usize),
}

/// An element as a level would draw it.
struct Drawn<'a> {
    element: &'a Element,
    /// `None` of a leaf.
    cylinder: Option<Cylinder>,
    triangles: f64,
}

impl Element {
    /// Only elements of a group stand for each other.
    fn group(&self) -> (usize, bool) {
        (self.material, matches!(self.kind, Kind::Leaf(_)))
    }

    /// Operations that drawing it takes about.
    fn work(&self, body: &Body) -> u64 {
        match self.kind {
            Kind::Stem(index) => NODE * body.stems[index].nodes.len() as u64,
            Kind::Leaf(_) => LEAF,
        }
    }

    fn index(&self) -> u32 {
        let (Kind::Stem(index) | Kind::Leaf(index)) = self.kind;
        index as u32
    }
}

/// All that a body consists of, group by group along the curve.
fn elements(
    body: &Body,
    roundness: f64,
    least: DVec3,
    most: DVec3,
    pace: &mut Pace,
) -> Result<Vec<Element>, Stopped> {
    let cells = f64::from(1 << CURVE_BITS) - 1.0;
    let size = (most - least).max_element().max(f64::MIN_POSITIVE);
    let order = |centre: DVec3| hilbert(((centre - least) / size * cells).as_uvec3());

    let stem = |(index, stem): (usize, &super::Stem)| {
        let area = Cylinder::whole(&stem.nodes, roundness)?.area(1.0);
        let (first, last) = (stem.nodes.first()?.position, stem.nodes.last()?.position);
        Some((Kind::Stem(index), stem.material, (first + last) / 2.0, area))
    };
    let leaf = |(index, leaf): (usize, &Leaf)| {
        let blade = &body.blades[leaf.blade];
        (Kind::Leaf(index), blade.material, leaf.place.transform_point3(blade.centre), body.area(leaf))
    };
    let work = |stem: &super::Stem| NODE * stem.nodes.len() as u64;
    let stems = body.stems.iter().enumerate().map(|indexed| (work(indexed.1), stem(indexed)));
    let leaves = body.leaves.iter().enumerate().map(|indexed| (LEAF, Some(leaf(indexed))));
    let mut elements = Vec::with_capacity(body.stems.len() + body.leaves.len());
    for (work, element) in stems.chain(leaves) {
        pace.count(work)?;
        if let Some((kind, material, centre, area)) = element.filter(|&(.., area)| area > 0.0) {
            elements.push(Element { kind, material, centre, area, order: order(centre) });
        }
    }
    elements.sort_unstable_by_key(|element| (element.group(), element.order, element.kind));
    Ok(elements)
}

/// Gathers all groups, so that what is drawn has about `budget` triangles. The longest of twigs, which stand for the others,
/// have more triangles than most: where that is too many, a triangle stands for more.
fn runs<'a>(drawn: &'a [Drawn<'a>], budget: f64) -> Vec<Vec<&'a Drawn<'a>>> {
    let same = |one: &Drawn, other: &Drawn| one.element.group() == other.element.group();
    let mut share = share(drawn, budget);
    let mut gathered = Vec::new();
    for _ in 0..ATTEMPTS {
        gathered = drawn.chunk_by(same).flat_map(|group| gather(group, share)).collect();
        let triangles: f64 = gathered.iter().filter_map(|run| chosen(run)).map(|drawn| drawn.triangles).sum();
        if triangles <= EXCESS * budget {
            break;
        }
        share *= (triangles / budget).sqrt();
    }
    gathered
}

/// Which element stands for all of a run.
fn chosen<'a>(run: &[&'a Drawn<'a>]) -> Option<&'a Drawn<'a>> {
    let first = run.first()?;
    match first.cylinder {
        // The longest of twigs, for what is far from it is least likely to be missed.
        Some(_) => run.iter().max_by(|one, other| one.element.area.total_cmp(&other.element.area)).copied(),
        None => run.get(mix(first.element.index()) as usize % run.len()).copied(),
    }
}

/// How much area a triangle stands for, so that all of them are about `budget`: each element that is larger than its
/// triangles stand for takes these, and the others take as many as they fill.
fn share(drawn: &[Drawn], budget: f64) -> f64 {
    let mut sizes: Vec<(f64, f64)> =
        drawn.iter().map(|drawn| (drawn.element.area, drawn.triangles)).collect();
    sizes.sort_unstable_by(|one, other| (other.0 / other.1).total_cmp(&(one.0 / one.1)));
    let mut rest: f64 = sizes.iter().map(|size| size.0).sum();
    let mut left = budget;
    for (area, triangles) in sizes {
        if area / triangles < rest / left || left <= triangles {
            break;
        }
        rest -= area;
        left -= triangles;
    }
    rest / left.max(1.0)
}

/// Cuts a group into runs that are to become one element each. The largest branch stays alone, however coarse the level: a
/// trunk that stands for all twigs of the crown would be a hill.
fn gather<'a>(group: &'a [Drawn<'a>], share: f64) -> Vec<Vec<&'a Drawn<'a>>> {
    let trunk = group
        .iter()
        .filter(|drawn| drawn.cylinder.is_some())
        .max_by(|one, other| one.element.area.total_cmp(&other.element.area));
    let stays = |drawn: &&Drawn| {
        drawn.element.area >= drawn.triangles * share
            || trunk.is_some_and(|trunk| std::ptr::eq(trunk, *drawn))
    };
    let (large, small): (Vec<_>, Vec<_>) = group.iter().partition(stays);
    let mut runs: Vec<Vec<&Drawn>> = large.into_iter().map(|drawn| vec![drawn]).collect();

    // How many elements as large as this one it takes to be worth its triangles, inverted.
    let worth = |drawn: &Drawn| drawn.element.area / (drawn.triangles * share);
    let total: f64 = small.iter().map(|drawn| worth(drawn)).sum();
    let step = total / total.round().max(1.0);
    let (mut filled, mut full) = (0.0, step);
    let mut run = Vec::new();
    for drawn in small {
        filled += worth(drawn);
        run.push(drawn);
        if filled >= full {
            runs.push(std::mem::take(&mut run));
            full += step;
        }
    }
    if !run.is_empty() {
        runs.push(run);
    }
    runs
}

/// The meshes of a level, by material.
#[derive(Default)]
struct Meshes(Vec<Mesh>);

impl Meshes {
    fn of(&mut self, material: usize) -> &mut Mesh {
        if self.0.len() <= material {
            self.0.resize_with(material + 1, Mesh::default);
        }
        &mut self.0[material]
    }

    /// Adds a leaf that is `growth` times as large. It moves by `shift`, but by no more than it grows.
    fn leaf(&mut self, leaf: &Leaf, blade: &Blade, shape: Shape, growth: f64, shift: DVec3) {
        let (length, width) = (blade.length, blade.width());
        let along = (growth * width / (STOUT * length).max(width)).sqrt().max(1.0);
        let across = growth / along;
        let grown = leaf.scale() * ((along - 1.0) * length + (across - 1.0) * width) / 4.0;
        let shift = shift.clamp_length_max(grown.max(0.0));

        let mesh = self.of(blade.material);
        for triangle in blade.triangles(shape) {
            let mut corners = triangle.map(|corner| {
                let position = leaf.place.transform_point3(blade.stretched(corner, along, across)) + shift;
                (position, blade.uv(corner))
            });
            if leaf.is_mirrored() {
                corners.swap(1, 2);
            }
            let [a, b, c] = corners.map(|(position, _)| position);
            let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners.map(|(position, _)| position.as_vec3().to_array()));
            mesh.normals.extend([normal.as_vec3().to_array(); 3]);
            mesh.uvs.extend(corners.map(|(_, uv)| uv));
            mesh.triangles.push([first, first + 1, first + 2]);
        }
    }

    fn level(self, detail: f32) -> Level {
        let filled = self.0.into_iter().enumerate().filter(|(_, mesh)| !mesh.triangles.is_empty());
        Level { detail, parts: filled.map(|(material, mesh)| Part { material, mesh }).collect() }
    }
}

const CURVE_BITS: u32 = 16;

/// How far along Hilbert's curve a cell lies (Skilling 2004, "Programming the Hilbert curve"): cells that are near each
/// other on the curve are so in space.
fn hilbert(cell: UVec3) -> u64 {
    let mut axes = cell.to_array();
    for bit in (1..CURVE_BITS).rev() {
        let (mask, below) = (1 << bit, (1 << bit) - 1);
        for axis in 0..3 {
            if axes[axis] & mask != 0 {
                axes[0] ^= below;
            } else {
                let exchange = (axes[0] ^ axes[axis]) & below;
                axes[0] ^= exchange;
                axes[axis] ^= exchange;
            }
        }
    }
    axes[1] ^= axes[0];
    axes[2] ^= axes[1];
    let mut flip = 0;
    for bit in (1..CURVE_BITS).rev() {
        if axes[2] & (1 << bit) != 0 {
            flip ^= (1 << bit) - 1;
        }
    }
    let bit_of = |axis: u32, bit: u32| u64::from((axis ^ flip) >> bit & 1);
    (0..CURVE_BITS)
        .rev()
        .flat_map(|bit| axes.map(|axis| bit_of(axis, bit)))
        .fold(0, |index, bit| index << 1 | bit)
}
