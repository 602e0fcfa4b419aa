//! Which tiles of a zoom are looked at: all of the ground, once, as finely as it is near, neighbours one level apart.

use std::collections::HashSet;
use terrane::zoom::{
    address::{Cell, Place},
    height::{Refinement, Roughness, Spine, Surface},
    motion::{Autopilot, Depth},
    tree::{Borders, Detail, Eye, Leaf, TooMany, Tree},
};

fn surface(seed: u32) -> Surface {
    Surface { seed, refinement: Refinement::Triangles, roughness: Roughness::Half }
}

/// Random words: splitmix64 (Steele, Lea & Flood 2014).
fn words(mut state: u64) -> impl FnMut() -> u64 {
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let word = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ word >> 31
    }
}

/// A random place, one to two cells of a level above the ground below it.
fn random_place(spine: &mut Spine, seed: u64, depth: u32) -> Place {
    let mut word = words(seed);
    let mut place = Place::default();
    for level in (32..depth + 64).step_by(32) {
        place.x.add((word() >> 32) as i64, level);
        place.z.add((word() >> 32) as i64, level);
    }
    place.y = spine.ground(&place, depth + 12);
    let digits = spine.surface().roughness.halvings();
    place.y.add((1 << 10) + (word() >> 54) as i64, depth + 10 - digits);
    place
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
        let place = random_place(&mut spine, seed.into(), depth);
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
        for (cell, corners) in tree.cells().filter(|(cell, _)| !known.contains(cell)) {
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
                !words(cell.x ^ cell.z.rotate_left(32) ^ u64::from(cell.level))().is_multiple_of(missing)
            };
            let mut tree = all.clone();
            tree.wait_for(is_ready);
            let leaves = tree.leaves();
            check(&leaves, root);
            assert!(leaves.iter().all(|leaf| leaf.cell.level == root.level || is_ready(leaf.cell)));
        }
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
