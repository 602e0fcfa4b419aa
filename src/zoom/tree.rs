//! Which tiles are looked at: a quadtree that is split where the eye is near.
//!
//! A tile is split if it is nearer than [`Detail`] times its side, so that its quads are about as large in the picture wherever they are. How near it
//! is, is told by a box around all that the surface can come to in it: the heights of its four corners, and the amplitudes of the octaves to come.
//! Leaves that touch, at an edge or only at a corner, are one level apart at most. All of it depends on the place and the surface alone: there is
//! no hysteresis, and a picture does not depend on the way that led to it.

use super::{
    address::{Cell, Coordinate, Place},
    height::{Corners, FRACTION_BITS, Patch, Surface},
};
use std::collections::HashMap;

/// A place as seen from the lattice of one level: distances to what is on that lattice are differences of small whole numbers.
#[derive(Clone, Debug)]
pub struct Eye {
    pub level: u32,
    x: Coordinate,
    z: Coordinate,
    /// In units of height.
    y: Coordinate,
    /// Cells in a unit of height.
    unit: f64,
}

impl Eye {
    pub fn new(surface: &Surface, place: &Place, level: u32) -> Eye {
        let unit = surface.roughness.cells() / f64::from(1u32 << FRACTION_BITS);
        let [x, z] = [&place.x, &place.z].map(|number| number.at(level));
        Eye { level, x, z, y: place.y.at(level + FRACTION_BITS), unit }
    }

    /// From the eye to a vertex of the level at a height: east, up, south, cells.
    pub fn to(&self, x: u64, height: i64, z: u64) -> [f64; 3] {
        [self.x.to(x), self.y.to(height as u64) * self.unit, self.z.to(z)]
    }

    /// The box around the surface in a cell of the level, from the eye: its lower and its upper corner, cells.
    pub fn bounds(&self, x: u64, z: u64, corners: Corners) -> [[f64; 3]; 2] {
        let [low, high] = corners.bounds();
        [self.to(x, low, z), self.to(x.wrapping_add(1), high, z.wrapping_add(1))]
    }

    /// How far the box around the surface in a cell of the level is, squared, cells².
    pub fn square_to(&self, x: u64, z: u64, corners: Corners) -> f64 {
        let [low, high] = self.bounds(x, z, corners);
        let square = |axis: usize| {
            let outside = low[axis].max(-high[axis]).max(0.0);
            outside * outside
        };
        square(0) + square(1) + square(2)
    }
}

/// How finely the surface is shown: tiles nearer than this many of their sides are split. Written c / N in papers, c being the least distance in spacings of a
/// tile's vertices and N its quads along a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail(f64);

impl Default for Detail {
    fn default() -> Self {
        Detail::COMMON
    }
}

impl Detail {
    pub const COMMON: Detail = Detail(2.0);

    /// The least at which octaves fade in within one level: a tile's diagonal must fit between where its vertices are all there and where it is replaced.
    pub const LEAST: f64 = 1.72;

    /// At least [`LEAST`](Self::LEAST).
    pub fn new(sides: f64) -> Detail {
        Detail(sides.max(Self::LEAST))
    }

    pub fn sides(self) -> f64 {
        self.0
    }
}

/// A tile that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    pub cell: Cell,
    pub corners: Corners,
    /// From the eye to the tile's box, sides of the tile.
    pub distance: f64,
    pub borders: Borders,
}

/// What the tiles around a leaf are like, a bit each. Edges are west, east, north, south (x − 1, x + 1, z − 1, z + 1); corners are 00, 10, 01, 11 (x, z). A
/// corner has the levels of all that touch it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Borders(pub u32);

impl Borders {
    /// The neighbour across an edge is coarser: vertices on the edge are those of its lattice.
    pub fn edge_is_coarser(self, edge: usize) -> bool {
        self.0 >> edge & 1 == 1
    }

    /// The neighbours across an edge are finer: vertices on the edge have all of their octave.
    pub fn edge_is_finer(self, edge: usize) -> bool {
        self.0 >> (4 + edge) & 1 == 1
    }

    /// A coarser tile touches a corner: the vertex there has nothing of its octave.
    pub fn corner_is_coarser(self, corner: usize) -> bool {
        self.0 >> (8 + corner) & 1 == 1
    }

    /// No coarser tile touches a corner, and a finer one does: the vertex there has all of its octave.
    pub fn corner_is_finer(self, corner: usize) -> bool {
        self.0 >> (12 + corner) & 1 == 1
    }
}

/// More tiles than a tree may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("more than {most} tiles are in view: the eye lies on the surface, or the detail is too high")]
pub struct TooMany {
    pub most: usize,
}

/// Levels below the roots that a tree can have: coordinates below them fit 64 bits, however many roots there are.
const MOST_DEPTH: usize = 56;

/// A quadtree over the cells of a patch.
#[derive(Clone, Debug)]
pub struct Tree {
    surface: Surface,
    /// The lower corner of the first root, and roots along a side.
    root: Cell,
    roots: u64,
    eyes: Vec<Eye>,
    most: usize,
    /// Nodes of each level below the roots.
    levels: Vec<Level>,
    count: usize,
}

/// Nodes by x and z, counted from the first root's corner.
type Level = HashMap<[u64; 2], Node, Scatter>;

#[derive(Clone, Copy, Debug)]
struct Node {
    corners: Corners,
    distance: f64,
    is_split: bool,
}

/// Eight neighbours of a cell: those across its edges, then those at its corners, in the order of [`Borders`].
const AROUND: [[i64; 2]; 8] = [[-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [1, -1], [-1, 1], [1, 1]];

impl Tree {
    /// Splits the cells of a patch until each leaf is far enough from the place, then whatever leaves are more than one level coarser than one
    /// beside them.
    ///
    /// # Errors
    /// If more than `most` tiles are needed.
    pub fn new(
        surface: &Surface,
        place: &Place,
        roots: &Patch,
        detail: Detail,
        most: usize,
    ) -> Result<Tree, TooMany> {
        Tree::down_to(u32::MAX, surface, place, roots, detail, most)
    }

    /// The same, but nothing is split into tiles of a level beyond the `finest`.
    ///
    /// # Errors
    /// As [`Tree::new`].
    pub fn down_to(
        finest: u32,
        surface: &Surface,
        place: &Place,
        roots: &Patch,
        detail: Detail,
        most: usize,
    ) -> Result<Tree, TooMany> {
        let depths = (finest.saturating_sub(roots.level()) as usize).min(MOST_DEPTH);
        let mut tree = Tree {
            surface: *surface,
            root: roots.cell(0, 0),
            roots: roots.size as u64 - 1,
            eyes: eyes(surface, place, roots.level()),
            most,
            levels: vec![Level::default(); MOST_DEPTH + 1],
            count: 0,
        };
        for row in 0..roots.size - 1 {
            for column in 0..roots.size - 1 {
                tree.add(0, [column as u64, row as u64], roots.corners(column, row))?;
            }
        }
        for depth in 0..depths {
            let level = &tree.levels[depth];
            let near = level.iter().filter(|(_, node)| node.distance < detail.0).map(|(at, _)| *at);
            let near: Vec<[u64; 2]> = near.collect();
            for at in near {
                tree.split(depth, at)?;
            }
        }
        tree.balance()?;
        Ok(tree)
    }

    /// Leaves as they are drawn, from coarse to fine, within a level from north to south and west to east.
    pub fn leaves(&self) -> Vec<Leaf> {
        let mut leaves = Vec::new();
        for (depth, level) in self.levels.iter().enumerate() {
            let mut here: Vec<_> = level.iter().filter(|(_, node)| !node.is_split).collect();
            here.sort_unstable_by_key(|([x, z], _)| [*z, *x]);
            leaves.extend(here.into_iter().map(|(at, node)| Leaf {
                cell: self.cell(depth, *at),
                corners: node.corners,
                distance: node.distance,
                borders: self.borders(depth, *at),
            }));
        }
        leaves
    }

    /// All nodes from coarse to fine, leaves too: the tiles that leaves are made from.
    pub fn nodes(&self) -> impl Iterator<Item = (Cell, Corners)> + '_ {
        self.levels.iter().enumerate().flat_map(move |(depth, level)| {
            let mut here: Vec<_> = level.iter().collect();
            here.sort_unstable_by_key(|([x, z], _)| [*z, *x]);
            here.into_iter().map(move |(at, node)| (self.cell(depth, *at), node.corners))
        })
    }

    /// The children of leaves that are nearer than so many of their sides: those that will be split soon.
    pub fn soon(&self, sides: f64) -> Vec<(Cell, Corners)> {
        let near = self.leaves().into_iter().filter(|leaf| leaf.distance < sides);
        near.flat_map(|Leaf { cell, corners, .. }| {
            let quarters = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|quarter| cell.child(quarter));
            quarters.into_iter().zip(corners.children(&self.surface, cell))
        })
        .collect()
    }

    /// Makes leaves of all nodes whose children are not ready, and of what would then not be balanced: from coarse to fine, a node stays split
    /// only if its children are ready and all eight tiles around it are there. Until it is ready, a tile is shown by its parent, whose surface its own begins as.
    pub fn wait_for(&mut self, is_ready: impl Fn(Cell) -> bool) {
        for depth in 0..MOST_DEPTH {
            let mut split: Vec<_> = self.levels[depth].iter().filter(|(_, node)| node.is_split).collect();
            split.sort_unstable_by_key(|(at, _)| **at);
            let waits = |at: [u64; 2]| {
                let ready = children(at).iter().all(|child| is_ready(self.cell(depth + 1, *child)));
                let around = AROUND.iter().filter_map(|step| self.beside(depth, at, *step));
                !ready || around.into_iter().any(|beside| !self.levels[depth].contains_key(&beside))
            };
            let waiting: Vec<[u64; 2]> =
                split.into_iter().map(|(at, _)| *at).filter(|at| waits(*at)).collect();
            waiting.into_iter().for_each(|at| self.close(depth, at));
        }
    }

    /// The same tiles, seen from another place.
    pub fn look_from(&mut self, place: &Place) {
        self.eyes = eyes(&self.surface, place, self.root.level);
    }

    /// From the eye to the first root, sides of it.
    pub fn distance(&self) -> f64 {
        let square = |(eye, node): (&Eye, &Node)| eye.square_to(self.root.x, self.root.z, node.corners);
        let first = self.levels.first().and_then(|level| level.get(&[0, 0]));
        self.eyes.first().zip(first).map_or(0.0, square).sqrt()
    }

    /// The eye, in cells of a level that the tree may have.
    pub fn eye(&self, level: u32) -> Option<&Eye> {
        self.eyes.get(level.checked_sub(self.root.level)? as usize)
    }

    fn cell(&self, depth: usize, at: [u64; 2]) -> Cell {
        self.root.descendant(depth as u32, at)
    }

    fn add(&mut self, depth: usize, at: [u64; 2], corners: Corners) -> Result<(), TooMany> {
        if self.count == self.most {
            return Err(TooMany { most: self.most });
        }
        self.count += 1;
        let cell = self.cell(depth, at);
        let distance = self.eyes[depth].square_to(cell.x, cell.z, corners).sqrt();
        self.levels[depth].insert(at, Node { corners, distance, is_split: false });
        Ok(())
    }

    /// Gives a node children, if it has none.
    fn split(&mut self, depth: usize, at: [u64; 2]) -> Result<(), TooMany> {
        let cell = self.cell(depth, at);
        let Some(node) = self.levels[depth].get_mut(&at) else { return Ok(()) };
        if std::mem::replace(&mut node.is_split, true) {
            return Ok(());
        }
        let corners = node.corners.children(&self.surface, cell);
        children(at).into_iter().zip(corners).try_for_each(|(at, corners)| self.add(depth + 1, at, corners))
    }

    /// Takes all below a node away.
    fn close(&mut self, depth: usize, at: [u64; 2]) {
        let Some(node) = self.levels[depth].get_mut(&at) else { return };
        if !std::mem::replace(&mut node.is_split, false) {
            return;
        }
        for child in children(at) {
            self.close(depth + 1, child);
            self.levels[depth + 1].remove(&child);
            self.count -= 1;
        }
    }

    /// The leaves around the children of a node lie below the node's eight neighbours, or are those. So a tree is balanced if each node that is split has all
    /// of its neighbours. From fine to coarse: what is split on the way is coarser, and is looked at later.
    fn balance(&mut self) -> Result<(), TooMany> {
        for depth in (1..MOST_DEPTH).rev() {
            let split = self.levels[depth].iter().filter(|(_, node)| node.is_split);
            let missing: Vec<[u64; 2]> = split
                .flat_map(|(at, _)| AROUND.iter().filter_map(|step| self.beside(depth, *at, *step)))
                .filter(|beside| !self.levels[depth].contains_key(beside))
                .collect();
            for [x, z] in missing {
                let ancestor = |up: usize| [x >> up, z >> up];
                let known = (1..=depth).find(|up| self.levels[depth - up].contains_key(&ancestor(*up)));
                for up in (1..=known.unwrap_or(0)).rev() {
                    self.split(depth - up, ancestor(up))?;
                }
            }
        }
        Ok(())
    }

    /// A cell beside another, if it is below the roots.
    fn beside(&self, depth: usize, at: [u64; 2], step: [i64; 2]) -> Option<[u64; 2]> {
        let end = self.roots << depth;
        let coordinate = |of: u64, step: i64| of.checked_add_signed(step).filter(|of| *of < end);
        Some([coordinate(at[0], step[0])?, coordinate(at[1], step[1])?])
    }

    fn borders(&self, depth: usize, at: [u64; 2]) -> Borders {
        let around =
            AROUND.map(|step| {
                let beside = self.beside(depth, at, step)?;
                let node = self.levels[depth].get(&beside);
                Some(node.map_or(
                    Beside::Coarser,
                    |node| if node.is_split { Beside::Finer } else { Beside::Equal },
                ))
            });
        let mut bits = 0;
        for (edge, beside) in around[..4].iter().enumerate() {
            bits |= u32::from(*beside == Some(Beside::Coarser)) << edge;
            bits |= u32::from(*beside == Some(Beside::Finer)) << (4 + edge);
        }
        for corner in 0..4 {
            let touching = [around[corner % 2], around[2 + corner / 2], around[4 + corner]];
            let coarser = touching.contains(&Some(Beside::Coarser));
            let finer = !coarser && touching.contains(&Some(Beside::Finer));
            bits |= u32::from(coarser) << (8 + corner) | u32::from(finer) << (12 + corner);
        }
        Borders(bits)
    }
}

/// A place as seen from all levels that a tree may have.
fn eyes(surface: &Surface, place: &Place, first: u32) -> Vec<Eye> {
    (0..=MOST_DEPTH as u32).map(|depth| Eye::new(surface, place, first + depth)).collect()
}

#[derive(Clone, Copy, PartialEq)]
enum Beside {
    Coarser,
    Equal,
    Finer,
}

/// The order of [`Corners::children`].
fn children([x, z]: [u64; 2]) -> [[u64; 2]; 4] {
    [[2 * x, 2 * z], [2 * x + 1, 2 * z], [2 * x, 2 * z + 1], [2 * x + 1, 2 * z + 1]]
}

/// Scatters two numbers over a table: they are ours, so no one chooses them to collide.
#[derive(Clone, Copy, Debug, Default)]
struct Scatter;

impl std::hash::BuildHasher for Scatter {
    type Hasher = Scattered;

    fn build_hasher(&self) -> Scattered {
        Scattered(0)
    }
}

struct Scattered(u64);

impl std::hash::Hasher for Scattered {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64((*byte).into()));
    }

    fn write_u64(&mut self, number: u64) {
        // Multiplication spreads to the upper bits, rotation brings them down (as rustc's own tables do).
        self.0 = (self.0.rotate_left(26) ^ number).wrapping_mul(0xf135_7aea_2e62_a9c5).rotate_left(26);
    }

    fn write_usize(&mut self, number: usize) {
        self.write_u64(number as u64);
    }
}
