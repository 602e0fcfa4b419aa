//! The land, whose triangles are two a cell of its grid: they are worked out where a ray meets them and lie nowhere in memory.
//! What rays go through to them is a wide tree like those of the models, but of a regular shape, so that it's made in one go.

use crate::core::grid::Grid;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::node::CwBvhNode;
use rayon::prelude::*;
use std::ops::Range;

/// Flag of the land's triangles: the others have numbers in a buffer. The twin of `GRID` in `glsl/lib/ground.glsl`.
pub const GRID: u32 = 0x8000_0000;

/// Cells of a leaf of the tree, across and down: four triangles. The twin of `TILE` in `glsl/lib/ground.glsl`.
const TILE: [u32; 2] = [2, 1];

/// Bits of a block's column in what names its leaves: its row is above, and which of the eight below.
const COLUMN_BITS: u32 = 13;

/// Children of a node, across and down, by its level above the leaves: so that every other level is square.
fn fan(level: usize) -> [u32; 2] {
    if level.is_multiple_of(2) { [2, 4] } else { [4, 2] }
}

/// The wide tree over the land; its first node is the root.
pub struct Ground {
    pub nodes: Vec<CwBvhNode>,
    pub bounds: Aabb,
}

/// Lowest and highest of the land in the boxes of one level, row by row.
struct Level {
    /// Cells of a box, across and down.
    size: [u32; 2],
    columns: u32,
    rows: u32,
    heights: Vec<[f32; 2]>,
}

impl Ground {
    pub fn new(grid: Grid, heights: &[f32]) -> Ground {
        let levels = levels(grid, heights);
        let mut nodes = Vec::new();
        // The boxes of one level that have a node, in the order of these.
        let mut at = vec![[0, 0]];
        for level in (1..levels.len()).rev() {
            let (parent, child) = (&levels[level], &levels[level - 1]);
            let fan = fan(level - 1);
            let first_child = (nodes.len() + at.len()) as u32;
            let placed: Vec<[Option<[u32; 2]>; 8]> =
                at.par_iter().map(|at| children(*at, fan, child, level > 1)).collect();
            let counts = placed.iter().map(|placed| placed.iter().flatten().count() as u32);
            let firsts = counts.scan(first_child, |next, count| {
                let first = *next;
                *next += count;
                Some(first)
            });
            let firsts: Vec<u32> = firsts.collect();
            let node = |((at, placed), first): ((&[u32; 2], &[_; 8]), &u32)| {
                let mut node =
                    wide(bounds(grid, parent, *at), placed.map(|at| Some(bounds(grid, child, at?))));
                if level > 1 {
                    node.child_base_idx = *first;
                    node.imask = mask(placed);
                    for slot in (0..8).filter(|slot| placed[*slot].is_some()) {
                        node.child_meta[slot] = 0b0010_0000 | (24 + slot as u8);
                    }
                } else {
                    node.primitive_base_idx = (at[1] << COLUMN_BITS | at[0]) << 3;
                    for slot in (0..8).filter(|slot| placed[*slot].is_some()) {
                        node.child_meta[slot] = 0b0010_0000 | slot as u8;
                    }
                }
                node
            };
            nodes.par_extend(at.par_iter().zip(&placed).zip(&firsts).map(node));
            at = placed.into_iter().flatten().flatten().collect();
        }
        let root = levels.last().map(|level| bounds(grid, level, [0, 0]));
        Ground { nodes, bounds: root.unwrap_or_else(Aabb::empty) }
    }
}

/// From the tiles up to one box over all of the land.
fn levels(grid: Grid, heights: &[f32]) -> Vec<Level> {
    let last = grid.cells - 1;
    let row = |row: u32| &heights[(row * grid.cells) as usize..][..grid.cells as usize];
    let [width, height] = TILE;
    let (columns, rows) = (last.div_ceil(width), last.div_ceil(height));
    let tile = |index: u32| {
        let (column, top) = (index % columns * width, index / columns * height);
        let samples = (top..=(top + height).min(last))
            .flat_map(|at| &row(at)[column as usize..=(column + width).min(last) as usize]);
        spread(samples.map(|height| [*height; 2]))
    };
    let tiles: Vec<[f32; 2]> = (0..columns * rows).into_par_iter().map(tile).collect();
    let mut levels = vec![Level { size: TILE, columns, rows, heights: tiles }];
    loop {
        let below = &levels[levels.len() - 1];
        let [across, down] = fan(levels.len() - 1);
        let (columns, rows) = (below.columns.div_ceil(across), below.rows.div_ceil(down));
        let whole = |index: u32| {
            let (left, top) = (index % columns * across, index / columns * down);
            let within = (top..(top + down).min(below.rows))
                .flat_map(|row| (left..(left + across).min(below.columns)).map(move |column| [column, row]));
            spread(within.map(|at| below.at(at)))
        };
        let heights = (0..columns * rows).into_par_iter().map(whole).collect();
        levels.push(Level { size: [below.size[0] * across, below.size[1] * down], columns, rows, heights });
        if columns * rows == 1 {
            return levels;
        }
    }
}

fn spread(heights: impl Iterator<Item = [f32; 2]>) -> [f32; 2] {
    heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], [least, greatest]| {
        [low.min(least), high.max(greatest)]
    })
}

impl Level {
    fn at(&self, [column, row]: [u32; 2]) -> [f32; 2] {
        self.heights[(row * self.columns + column) as usize]
    }
}

fn bounds(grid: Grid, level: &Level, at: [u32; 2]) -> Aabb {
    let last = grid.cells - 1;
    let [left, top] = [at[0] * level.size[0], at[1] * level.size[1]];
    let [west, north] = grid.position(left, top);
    let [east, south] = grid.position((left + level.size[0]).min(last), (top + level.size[1]).min(last));
    let [low, high] = level.at(at);
    Aabb::new(Vec3A::new(west, low, north), Vec3A::new(east, high, south))
}

/// Where the children of the box at `at` go. Of leaves the slot says which one it is; other children are visited by their slots, nearest
/// first: these have three bits, of which the highest is for west and east, the lowest for north and south, and the middle one for
/// low and high. Along the longer side neighbours share the first two.
fn children(at: [u32; 2], fan: [u32; 2], child: &Level, ordered: bool) -> [Option<[u32; 2]>; 8] {
    let [across, down] = fan;
    let mut slots = [None; 8];
    let there = |column: u32, row: u32| {
        let at = [at[0] * across + column, at[1] * down + row];
        (at[0] < child.columns && at[1] < child.rows).then_some(at)
    };
    if !ordered {
        for (slot, place) in slots.iter_mut().enumerate() {
            *place = there(slot as u32 % across, slot as u32 / across);
        }
        return slots;
    }
    for (x, z) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let pair = if across > down {
            [there(2 * x, z), there(2 * x + 1, z)]
        } else {
            [there(x, 2 * z), there(x, 2 * z + 1)]
        };
        let top = |at: Option<[u32; 2]>| at.map_or(f32::NEG_INFINITY, |at| child.at(at)[1]);
        let [low, high] = if top(pair[0]) > top(pair[1]) { [pair[1], pair[0]] } else { pair };
        let slot = (x << 2 | z) as usize;
        (slots[slot], slots[slot | 2]) = (low, high);
    }
    slots
}

fn mask(placed: &[Option<[u32; 2]>; 8]) -> u8 {
    (0..8).filter(|slot| placed[*slot].is_some()).fold(0, |mask, slot| mask | 1 << slot)
}

/// A node with its children's boxes: planes in 255 steps of a power of two from its least corner, outwards.
fn wide(all: Aabb, children: [Option<Aabb>; 8]) -> CwBvhNode {
    let steps = ((all.max - all.min) / 255.0).to_array().map(power_of_two);
    let [x, y, z] = steps.map(|step| (step.to_bits() >> 23) as u8);
    let mut node = CwBvhNode { p: all.min.into(), e: [x, y, z], ..CwBvhNode::default() };
    let origin = DVec3::from(Vec3::from(all.min));
    let step = DVec3::from(Vec3::from(steps));
    for (slot, bounds) in children.iter().enumerate().filter_map(|(slot, it)| Some((slot, (*it)?))) {
        let least = ((DVec3::from(Vec3::from(bounds.min)) - origin) / step).floor();
        let greatest = ((DVec3::from(Vec3::from(bounds.max)) - origin) / step).ceil();
        let [low, high] = [least, greatest].map(|at| at.clamp(DVec3::ZERO, DVec3::splat(255.0)));
        (node.child_min_x[slot], node.child_max_x[slot]) = (low.x as u8, high.x as u8);
        (node.child_min_y[slot], node.child_max_y[slot]) = (low.y as u8, high.y as u8);
        (node.child_min_z[slot], node.child_max_z[slot]) = (low.z as u8, high.z as u8);
    }
    node
}

/// The least that is not below `value`, nor so small that its square would vanish.
fn power_of_two(value: f32) -> f32 {
    const MANTISSA: u32 = 0x007f_ffff;
    let bits = value.max(1e-18).to_bits();
    let exponent = if bits & MANTISSA == 0 { bits } else { (bits & !MANTISSA) + MANTISSA + 1 };
    f32::from_bits(exponent)
}

/// Corners of the land's triangles, two a cell, row by row.
pub fn triangles(grid: Grid, heights: &[f32], rows: Range<u32>) -> Vec<[Vec3; 3]> {
    let corner = corner(grid, heights);
    let mut triangles = Vec::with_capacity(2 * rows.len() * grid.cells as usize);
    for row in rows {
        for column in 0..grid.cells - 1 {
            let [nw, ne] = [corner(column, row), corner(column + 1, row)];
            let [sw, se] = [corner(column, row + 1), corner(column + 1, row + 1)];
            triangles.extend([[nw, sw, ne], [ne, sw, se]]);
        }
    }
    triangles
}

fn corner(grid: Grid, heights: &[f32]) -> impl Fn(u32, u32) -> Vec3 {
    move |column: u32, row: u32| {
        let [x, z] = grid.position(column, row);
        Vec3::new(x, heights[(row * grid.cells + column) as usize], z)
    }
}

/// How far the bottom of the sea goes on beyond the grid, in extents of it.
const REACH: f32 = 4.0;

/// What the sea covers beyond the grid: the bottom falls away by half the distance (`height_bilinear` in
/// `glsl/lib/heightfield.glsl`). Nothing where there is no sea.
pub fn skirt(grid: Grid, heights: &[f32], sea_level: f32) -> Vec<[Vec3; 3]> {
    if !reaches_under(heights, sea_level) {
        return Vec::new();
    }
    let corner = corner(grid, heights);
    let rim: Vec<Vec3> = rim(grid).into_iter().map(|[column, row]| corner(column, row)).collect();
    let pairs = rim.iter().zip(rim.iter().cycle().skip(1));
    let sides = |(here, next): (&Vec3, &Vec3)| {
        let [below, below_next] = [here, next].map(|at| pushed(grid, *at));
        [[*here, *next, below], [*next, below_next, below]]
    };
    pairs.flat_map(sides).collect()
}

/// Whether there is land under the sea.
pub fn reaches_under(heights: &[f32], sea_level: f32) -> bool {
    heights.iter().any(|height| *height < sea_level)
}

/// Columns and rows of the grid's edge, round about.
pub fn rim(grid: Grid) -> Vec<[u32; 2]> {
    let last = grid.cells - 1;
    (0..last)
        .map(|at| [at, 0])
        .chain((0..last).map(|at| [last, at]))
        .chain((0..last).map(|at| [last - at, last]))
        .chain((0..last).map(|at| [0, last - at]))
        .collect()
}

/// Where the skirt ends that begins at a place of the rim.
pub fn pushed(grid: Grid, at: Vec3) -> Vec3 {
    let out = REACH * grid.extent;
    let away = Vec3::new(at.x, 0.0, at.z).normalize_or_zero();
    at + out * away - Vec3::Y * (0.5 * out)
}
