//! Which tiles of a zoom are looked at: all of the ground, once, as finely as it is near, neighbours one level apart.

use crate::kit::zoom::{Words, random_place_above};
use glam::DVec3;
use std::collections::{HashMap, HashSet};
use terrane::zoom::{
    address::{Cell, Place},
    height::{Corners, FRACTION_BITS, Refinement, Roughness, Spine, Surface},
    motion::{Autopilot, Depth},
    tree::{Borders, Detail, Eye, Leaf, TooMany, Tree},
};

fn surface(seed: u32) -> Surface {
    Surface { seed, refinement: Refinement::Triangles, roughness: Roughness::Half }
}

fn steered_place(autopilot: &mut Autopilot, spine: &mut Spine, depth: u32) -> Place {
    autopilot.at(spine, Depth::level(depth)).place
}

/// Levels of the foreground.
const OCTAVES: u32 = 15;

const MOST: usize = 100_000;

fn tree(spine: &mut Spine, place: &Place, depth: u32) -> Tree {
    let root = depth.saturating_sub(OCTAVES);
    let surface = *spine.surface();
    Tree::new(&surface, place, spine.patch(place, root), Detail::default(), MOST).unwrap()
}

/// A cell in whole units of a level that is finer than all: lower corner, counted from the first root, and side.
fn square(cell: Cell, root: Cell) -> [i128; 3] {
    const FINEST: u32 = 50;
    let depth = cell.level - root.level;
    let from = |of: u64, root: u64| i128::from(of.wrapping_sub(root << depth)) << (FINEST - depth);
    [from(cell.x, root.x), from(cell.z, root.z), 1 << (FINEST - depth)]
}

/// Whether two squares that don't overlap touch, and across which edge or corner of the first (in the order of [`Borders`]), if so.
fn touches([x, z, side]: [i128; 3], [other_x, other_z, other_side]: [i128; 3]) -> Option<usize> {
    let place = |own: i128, other: i128| match () {
        () if other + other_side < own || other > own + side => None,
        () if other + other_side == own => Some(-1),
        () if other == own + side => Some(1),
        () => Some(0),
    };
    match (place(x, other_x)?, place(z, other_z)?) {
        (-1, 0) => Some(0),
        (1, 0) => Some(1),
        (0, -1) => Some(2),
        (0, 1) => Some(3),
        (across, down) if across != 0 && down != 0 => {
            Some(4 + usize::from(across == 1) + 2 * usize::from(down == 1))
        }
        _ => panic!("leaves overlap"),
    }
}

/// All that has to hold for leaves, by looking at all pairs of them.
fn check(leaves: &[Leaf], root: Cell) {
    const ROOTS: i128 = 15;
    let squares: Vec<_> = leaves.iter().map(|leaf| square(leaf.cell, root)).collect();
    let area: i128 = squares.iter().map(|[_, _, side]| side * side).sum();
    assert_eq!(area, (ROOTS << 50) * (ROOTS << 50), "all of the ground");
    for (leaf, own) in leaves.iter().zip(&squares) {
        assert!(
            own[0] >= 0 && own[1] >= 0 && own[0] + own[2] <= ROOTS << 50 && own[1] + own[2] <= ROOTS << 50
        );
        let mut edges = [0i32; 4];
        // What touches a corner: those beyond it, and those across its two edges that reach it.
        let mut corners = [[false; 2]; 4];
        for (other, square) in leaves.iter().zip(&squares) {
            if other.cell == leaf.cell {
                continue;
            }
            let Some(side) = touches(*own, *square) else { continue };
            let finer = other.cell.level as i32 - leaf.cell.level as i32;
            assert!(finer.abs() <= 1, "{:?} beside {:?}", leaf.cell, other.cell);
            if let Some(edge) = edges.get_mut(side) {
                *edge = finer;
            }
            for (corner, known) in corners.iter_mut().enumerate() {
                let [x, z] = [own[0] + own[2] * (corner as i128 % 2), own[1] + own[2] * (corner as i128 / 2)];
                let within = |of: i128, from: i128| of >= from && of <= from + square[2];
                if within(x, square[0]) && within(z, square[1]) {
                    known[0] |= finer < 0;
                    known[1] |= finer > 0;
                }
            }
        }
        let Borders(_) = leaf.borders;
        for (edge, finer) in edges.into_iter().enumerate() {
            assert_eq!(leaf.borders.edge_is_coarser(edge), finer < 0);
            assert_eq!(leaf.borders.edge_is_finer(edge), finer > 0);
        }
        for (corner, [coarser, finer]) in corners.into_iter().enumerate() {
            assert_eq!(leaf.borders.corner_is_coarser(corner), coarser);
            assert_eq!(leaf.borders.corner_is_finer(corner), finer && !coarser);
        }
    }
}

/// Trees at random places, where slopes are steep, and at steered ones.
fn places(count: u32, mut visit: impl FnMut(&mut Spine, &Place, u32)) {
    for seed in 0..count {
        let mut spine = Spine::new(surface(seed));
        let depth = 15 + seed * 17 % 300;
        let mut words = Words(seed.into());
        let height = (1 << 10) + (words.word() >> 54) as i64;
        let place = random_place_above(&mut spine, &mut words, depth, height);
        visit(&mut spine, &place, depth);
    }
    let mut autopilot = Autopilot::new(surface(1));
    let mut spine = Spine::new(surface(1));
    for step in 0..count {
        let depth = 15 + step * 3;
        let place = steered_place(&mut autopilot, &mut spine, depth);
        visit(&mut spine, &place, depth);
    }
}

#[test]
fn leaves_cover_all_and_are_balanced() {
    places(40, |spine, place, depth| {
        let tree = tree(spine, place, depth);
        check(&tree.leaves(), spine.patch(place, depth - OCTAVES).cell(0, 0));
    });
}

/// Leaves are far enough, and nothing is split without need: either it is near, or a leaf beside it is more than one level finer.
#[test]
fn nothing_is_split_without_need() {
    let mut forced = 0;
    places(40, |spine, place, depth| {
        let root = spine.patch(place, depth - OCTAVES).cell(0, 0);
        let tree = tree(spine, place, depth);
        let leaves = tree.leaves();
        let known: HashSet<Cell> = leaves.iter().map(|leaf| leaf.cell).collect();
        assert!(leaves.iter().all(|leaf| leaf.distance >= 2.0));
        for (cell, corners) in tree.nodes().filter(|(cell, _)| !known.contains(cell)) {
            let eye = Eye::new(spine.surface(), place, cell.level);
            if eye.square_to(cell.x, cell.z, corners) < 4.0 {
                continue;
            }
            forced += 1;
            let own = square(cell, root);
            let is_below = |other: [i128; 3]| {
                (0..2).all(|axis| other[axis] >= own[axis] && other[axis] + other[2] <= own[axis] + own[2])
            };
            let needs = |leaf: &&Leaf| {
                let other = square(leaf.cell, root);
                leaf.cell.level > cell.level + 1 && !is_below(other) && touches(own, other).is_some()
            };
            assert!(leaves.iter().find(needs).is_some(), "{cell:?}");
        }
    });
    assert!(forced > 0, "no place was steep enough for this test to mean anything");
}

/// Boxes hold all of the surface, however finely it is looked at.
#[test]
fn boxes_hold_the_surface() {
    places(30, |spine, place, depth| {
        let surface = *spine.surface();
        for level in depth - 5..depth {
            let patch = spine.patch(place, level).clone();
            for (column, row) in [(6, 6), (7, 7), (9, 3)] {
                let (cell, corners) = (patch.cell(column, row), patch.corners(column, row));
                let mut fine = patch.clone();
                for step in 1..=7 {
                    fine = fine.refine(&surface, cell.x << step, cell.z << step, (1 << step) + 1).unwrap();
                    let [low, high] = corners.bounds().map(|bound| bound.wrapping_shl(step));
                    for height in fine.heights() {
                        assert!(height.wrapping_sub(low) >= 0 && high.wrapping_sub(height) >= 0);
                    }
                }
            }
        }
    });
}

/// On steered paths trees are as large at any depth.
#[test]
fn trees_do_not_grow_with_depth() {
    let mut autopilot = Autopilot::new(surface(4));
    let mut spine = Spine::new(surface(4));
    let mut mean = |from: u32| {
        let count = 60;
        let leaves = (from..from + count).map(|depth| {
            let place = steered_place(&mut autopilot, &mut spine, depth);
            tree(&mut spine, &place, depth).leaves().len()
        });
        leaves.sum::<usize>() as f64 / f64::from(count)
    };
    let [shallow, deep] = [40, 1000].map(&mut mean);
    println!("{shallow} leaves at depth 40, {deep} at depth 1000");
    assert!((deep / shallow - 1.0).abs() < 0.05, "{shallow} {deep}");
}

/// What is not ready is shown by what it would be made from.
#[test]
fn what_is_not_ready_is_not_drawn() {
    places(25, |spine, place, depth| {
        let root = spine.patch(place, depth - OCTAVES).cell(0, 0);
        let all = tree(spine, place, depth);
        let mut same = all.clone();
        same.wait_for(|_| true);
        assert_eq!(same.leaves(), all.leaves());
        for missing in [1000, 100, 10, 2, 1] {
            let is_ready = |cell: Cell| {
                !Words(cell.x ^ cell.z.rotate_left(32) ^ u64::from(cell.level)).word().is_multiple_of(missing)
            };
            let mut tree = all.clone();
            tree.wait_for(is_ready);
            let leaves = tree.leaves();
            check(&leaves, root);
            assert!(leaves.iter().all(|leaf| leaf.cell.level == root.level || is_ready(leaf.cell)));
        }
    });
}

/// log₂ of the quads along a side of a tile.
const BITS: u32 = 4;

/// The heights of a tile's vertices, without its ring, rows of x: they hang on its corners alone.
fn vertices(surface: &Surface, leaf: &Leaf) -> Vec<i64> {
    let side = (1usize << BITS) + 1;
    let mut heights = vec![0; side * side];
    let mut cells = vec![(leaf.cell, leaf.corners, [0, 0])];
    for bit in (0..BITS).rev() {
        let children = |(cell, corners, [column, row]): (Cell, Corners, [usize; 2])| {
            let quarters = [[0, 0], [1, 0], [0, 1], [1, 1]];
            quarters.into_iter().zip(corners.children(surface, cell)).map(move |([right, down], corners)| {
                let at = [column | right << bit, row | down << bit];
                (cell.child([right as u32, down as u32]), corners, at)
            })
        };
        cells = cells.into_iter().flat_map(children).collect();
    }
    for (_, Corners(corners), [column, row]) in cells {
        for (corner, height) in corners.into_iter().enumerate() {
            heights[(row + corner / 2) * side + column + corner % 2] = height;
        }
    }
    heights
}

/// How much of its octave a vertex has at a distance in sides of its tile: it fades out before the tile is replaced by its parent.
fn share(distance: f64) -> f64 {
    let (from, to) = (2.0 + 1.5625, 4.0);
    let t = ((distance - from) / (to - from)).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

/// What a leaf's border is drawn as: vertices in units of the level `finest`, and their heights. A vertex has a share of its octave that
/// its distance tells; with `rules`, beside other levels, it has all of it or nothing, and odd vertices beside a coarser tile are drawn where an even one is.
fn border(surface: &Surface, place: &Place, leaf: &Leaf, finest: u32, rules: bool) -> Vec<([u64; 2], f64)> {
    let level = leaf.cell.level + BITS;
    let (octave, eye) = (surface.octave(level), Eye::new(surface, place, level));
    let heights = vertices(surface, leaf);
    let quads = 1u64 << BITS;
    let scale = finest - level;
    let draw = |[i, j]: [u64; 2]| {
        let [x, z] = [(leaf.cell.x, i), (leaf.cell.z, j)].map(|(of, step)| (of << BITS).wrapping_add(step));
        let noise = i64::from(octave.at(x, z));
        let coarse = heights[(j * (quads + 1) + i) as usize].wrapping_sub(noise);
        let mut share = share(DVec3::from_array(eye.to(x, coarse, z)).length() / quads as f64);
        let edges = [i == 0, i == quads, j == 0, j == quads];
        let is_corner = [0, quads].contains(&i) && [0, quads].contains(&j);
        let at = if is_corner {
            vec![((i + 2 * j) / quads) as usize]
        } else {
            (0..4).filter(|edge| edges[*edge]).collect()
        };
        let borders = leaf.borders;
        let any = |corner: fn(Borders, usize) -> bool, edge: fn(Borders, usize) -> bool| {
            at.iter().any(|at| if is_corner { corner(borders, *at) } else { edge(borders, *at) })
        };
        if rules && any(Borders::corner_is_coarser, Borders::edge_is_coarser) {
            share = 0.0;
        } else if rules && any(Borders::corner_is_finer, Borders::edge_is_finer) {
            share = 1.0;
        }
        let is_odd = !is_corner && (i | j) % 2 == 1;
        let collapses = rules && is_odd && any(Borders::corner_is_coarser, Borders::edge_is_coarser);
        let up = (coarse << scale).wrapping_sub(place.y.slice(finest + FRACTION_BITS) as i64);
        (!collapses).then_some(([x << scale, z << scale], up as f64 + share * (noise << scale) as f64))
    };
    let all = (0..=quads).flat_map(|j| (0..=quads).map(move |i| [i, j]));
    all.filter(|at| at.iter().any(|of| [0, quads].contains(of))).filter_map(draw).collect()
}

/// Vertices at borders that are drawn at two heights, or by one tile alone.
fn cracks(spine: &mut Spine, place: &Place, depth: u32, rules: bool) -> usize {
    let tree = tree(spine, place, depth);
    let leaves = tree.leaves();
    let root = spine.patch(place, depth - OCTAVES).cell(0, 0);
    let finest = leaves.iter().map(|leaf| leaf.cell.level).max().unwrap_or(0) + BITS;
    let mut known: HashMap<[u64; 2], (f64, u32)> = HashMap::new();
    let mut torn = HashSet::new();
    for leaf in &leaves {
        for (at, height) in border(spine.surface(), place, leaf, finest, rules) {
            let (first, count) = known.entry(at).or_insert((height, 0));
            *count += 1;
            if *first != height {
                torn.insert(at);
            }
        }
    }
    let end = 15u64 << (finest - root.level);
    let from_root = |at: u64, root_at: u64| at.wrapping_sub(root_at << (finest - root.level));
    let is_outside = |[x, z]: [u64; 2]| {
        [from_root(x, root.x), from_root(z, root.z)].iter().any(|from| [0, end].contains(from))
    };
    torn.extend(known.iter().filter(|(at, (_, count))| *count < 2 && !is_outside(**at)).map(|(at, _)| *at));
    torn.len()
}

/// Tiles meet exactly: a vertex at a border is at one height for all that touch it, and no vertex of one lies on an edge of another.
#[test]
fn there_are_no_cracks() {
    let mut without = 0;
    places(8, |spine, place, depth| {
        assert_eq!(cracks(spine, place, depth, true), 0);
        without += cracks(spine, place, depth, false);
    });
    assert!(without > 0, "without rules there are");
}

/// 500 random places and 500 steered ones.
#[test]
#[ignore = "minutes: make test-long"]
fn a_thousand_trees_are_balanced_and_have_no_cracks() {
    places(500, |spine, place, depth| {
        check(&tree(spine, place, depth).leaves(), spine.patch(place, depth - OCTAVES).cell(0, 0));
        assert_eq!(cracks(spine, place, depth, true), 0);
    });
}

#[test]
fn a_tree_has_limits() {
    let mut spine = Spine::new(surface(1));
    // On the surface.
    let mut place = Place::default();
    place.y = spine.ground(&place, 60);
    let surface = *spine.surface();
    let patch = spine.patch(&place, 0).clone();
    let tree = |detail, most| Tree::new(&surface, &place, &patch, detail, most);
    assert!(tree(Detail::default(), 20_000).is_ok(), "an end, though there is no distance");
    assert_eq!(tree(Detail::default(), 300).unwrap_err(), TooMany { most: 300 });
    assert_eq!(tree(Detail::new(f64::INFINITY), 5000).unwrap_err(), TooMany { most: 5000 });
    assert_eq!(Detail::new(f64::NAN), Detail::new(0.0));
}
