//! The surface of a zoom and the addresses on it: every height against integers without bounds, borders, random numbers, codes.

use crate::kit::zoom::Words;
use crate::reference::zoom::{Naive, low};
use glam::DVec3;
use num_bigint::BigInt;
use proptest::prelude::*;
use terrane::zoom::{
    address::{Attitude, Cell, CodeError, DEEPEST, Fixed, Location, MOST_LETTERS, Place},
    height::{Patch, REACH, Refinement, Roughness, Shaded, Spine, Surface, Tile, base},
    motion::Autopilot,
};

const MODES: [Refinement; 2] = [Refinement::Triangles, Refinement::Bilinear];

fn surface(seed: u32, refinement: Refinement) -> Surface {
    Surface { seed, refinement, roughness: Roughness::Half }
}

fn naive(surface: &Surface) -> Naive {
    Naive { seed: surface.seed, bilinear: surface.refinement == Refinement::Bilinear }
}

/// Random digits, `count` of them, behind a whole part.
fn random_number(words: &mut Words, whole: i64, count: u32) -> Fixed {
    let mut number = Fixed::from(whole);
    for level in (32..=count).step_by(32) {
        number.add((words.word() >> 32) as i64, level);
    }
    number
}

fn random_place(seed: u64, count: u32) -> Place {
    let mut words = Words(seed);
    let mut number = |whole| random_number(&mut words, whole, count);
    Place { x: number(-3), y: number(1), z: number(5) }
}

/// ⌊number · 2^level⌋ without bounds.
fn big(number: &Fixed, level: u32) -> BigInt {
    let mut value = BigInt::from(number.whole());
    let mut known = 0;
    while known < level {
        let more = (level - known).min(64);
        let digits = number.slice(known + more) & (u64::MAX >> (64 - more));
        value = (value << more) + digits;
        known += more;
    }
    value
}

fn golden() -> impl Iterator<Item = Vec<&'static str>> {
    let lines = include_str!("../data/zoom_surface.txt").lines();
    lines.filter(|line| !line.starts_with('#')).map(|line| line.split_whitespace().collect())
}

#[test]
fn random_numbers_are_those_of_the_definition() {
    let mut count = 0;
    for words in golden() {
        let ["noise", seed, level, x, z, expected] = words[..] else { continue };
        let [x, z] = [x, z].map(|text| low(&text.parse().unwrap()));
        let octave = surface(seed.parse().unwrap(), Refinement::Triangles).octave(level.parse().unwrap());
        assert_eq!(octave.at(x, z), expected.parse::<i32>().unwrap(), "{words:?}");
        count += 1;
    }
    assert_eq!(count, 120);
}

/// The height of one vertex, by a patch of each level that just holds what it hangs on.
fn height(surface: &Surface, level: u32, x: &BigInt, z: &BigInt) -> i64 {
    let first = |level_of: u32| {
        let first = |of: &BigInt| low(&(of >> (level - level_of))).wrapping_sub(1);
        [first(x), first(z)]
    };
    let [first_x, first_z] = first(0);
    let mut patch = Patch::start(surface, first_x as i64, first_z as i64, 4);
    for level in 1..=level {
        let [x, z] = first(level);
        patch = patch.refine(surface, x, z, 4).expect("four vertices keep themselves up");
    }
    patch.height(1, 1)
}

#[test]
fn heights_are_those_of_the_definition() {
    let mut count = 0;
    for words in golden() {
        let ["height", seed, mode, level, x, z, expected] = words[..] else { continue };
        let refinement = if mode == "bilinear" { Refinement::Bilinear } else { Refinement::Triangles };
        let surface = surface(seed.parse().unwrap(), refinement);
        let [x, z, expected] = [x, z, expected].map(|text| text.parse::<BigInt>().unwrap());
        let level = level.parse().unwrap();
        assert_eq!(height(&surface, level, &x, &z) as u64, low(&expected), "{words:?}");
        // The reference of the other tests, too.
        assert_eq!(naive(&surface).heights(level, &[(x, z)]), [expected], "{words:?}");
        count += 1;
    }
    assert_eq!(count, 264);
}

/// At 10,000 levels, all of a patch, and all the differences in it.
#[test]
fn wrapped_heights_are_those_of_integers_without_bounds() {
    for refinement in MODES {
        let surface = surface(11, refinement);
        let place = random_place(3, 10_050);
        let mut spine = Spine::new(surface);
        for level in [0, 1, 2, 63, 64, 65, 511, 512, 513, 1024, 3000, 10_000] {
            let patch = spine.patch(&place, level).clone();
            let [x, z] = [&place.x, &place.z].map(|number| big(number, level) - REACH);
            // The corners of the patch, and the cell in its middle.
            let some = [0, 1, 6, 7, 8, 9, 15].map(|column| [0, 7, 8, 15].map(|row| [column, row]));
            let some: Vec<[usize; 2]> = some.into_iter().flatten().collect();
            let vertices: Vec<_> = some.iter().map(|[column, row]| (&x + column, &z + row)).collect();
            let expected = naive(&surface).heights(level, &vertices);
            let first = patch.height(some[0][0], some[0][1]);
            for ([column, row], expected_height) in some.iter().zip(&expected) {
                let height = patch.height(*column, *row);
                assert_eq!(height as u64, low(expected_height), "level {level}, {column} {row}");
                let rise = BigInt::from(height.wrapping_sub(first));
                assert_eq!(rise, expected_height - &expected[0], "level {level}, {column} {row}");
            }
        }
    }
}

/// What patches are shaded by, by the definition.
#[test]
fn gradients_are_those_of_the_definition() {
    for refinement in MODES {
        let surface = surface(11, refinement);
        let place = random_place(3, 3000);
        let mut spine = Spine::new(surface);
        for level in [0, 1, 2, 3, 30, 64, 65, 700, 2500] {
            let [x, z] = [&place.x, &place.z].map(|number| big(number, level) - REACH);
            let some = [1, 6, 7, 8, 9, 14].map(|column| [1, 7, 8, 14].map(|row| [column, row]));
            let some: Vec<[usize; 2]> = some.into_iter().flatten().collect();
            let vertices: Vec<_> = some.iter().map(|[column, row]| (&x + column, &z + row)).collect();
            let expected = naive(&surface).gradients(level, &vertices);
            let patch = spine.shaded(&place, level);
            for ([column, row], expected) in some.iter().zip(expected) {
                let gradient = patch.gradient(*column, *row).map(BigInt::from);
                assert_eq!(gradient, expected, "level {level}, {column} {row}");
            }
            assert!((0..16).all(|at| patch.gradient(at, 0) == [0; 2] && patch.gradient(15, at) == [0; 2]));
        }
    }
}

/// True slopes at the vertices of the middle cell, and what gradients miss of them, amplitudes a cell: the root of the mean square of each, and the
/// most that is missed.
fn drift(surface: &Surface, place: &Place, levels: std::ops::Range<u32>) -> [f64; 3] {
    let mut spine = Spine::new(*surface);
    let [mut slopes, mut missed, mut most, mut count] = [0.0; 4];
    for level in levels {
        let shaded = spine.shaded(place, level);
        let patch = shaded.patch();
        for (column, row) in [(7, 7), (8, 7), (7, 8), (8, 8)] {
            let rises = [
                patch.height(column + 1, row).wrapping_sub(patch.height(column - 1, row)),
                patch.height(column, row + 1).wrapping_sub(patch.height(column, row - 1)),
            ];
            for (rise, gradient) in rises.into_iter().zip(shaded.gradient(column, row)) {
                let [slope, difference] = [rise, rise - i64::from(gradient)].map(|of| of as f64 / 512.0);
                slopes += slope * slope;
                missed += difference * difference;
                most = f64::max(most, difference.abs());
                count += 1.0;
            }
        }
    }
    [(slopes / count).sqrt(), (missed / count).sqrt(), most]
}

/// What the surface is shaded by follows its true slope, at random places, whose slopes drift, and where the autopilot goes.
#[test]
fn gradients_keep_to_the_slope() {
    for (refinement, variance) in [(Refinement::Triangles, 2.0 / 3.0f64), (Refinement::Bilinear, 4.0 / 9.0)] {
        let surface = surface(7, refinement);
        let steered = Autopilot::new(surface).target(4030).clone();
        for (name, place) in
            [("random", random_place(40, 4100)), ("random", random_place(41, 4100)), ("steered", steered)]
        {
            for levels in [0..1000, 1000..4000] {
                let [slope, missed, most] = drift(&surface, &place, levels.clone());
                println!(
                    "{refinement:?}, {name}, {levels:?}: slope {slope:.2}, missed {missed:.2}, at most {most:.2}"
                );
                // If all that is new in a slope were missed, and a 16th of that forgotten a level: 2.3 and 1.9. Without forgetting it were 52 and 42 at the end.
                // A thousand levels are some 120 numbers, so this is known to 6 %. Five times as much is as good as never.
                let expected = (16.0 / 2.0 * variance).sqrt();
                assert!(missed < (1.0 + 4.0 * 0.06) * expected, "{name}: {missed} at {levels:?}");
                assert!(most < 5.0 * expected, "{name}: {most} at {levels:?}");
            }
        }
    }
}

/// Rows over a lattice line of a coarse octave look like any others. True slopes jump there, the more the older the octave is.
#[test]
fn creases_do_not_show() {
    const LEVELS: u32 = 6;
    let mut sums = [[[0.0; 2]; 2]; 2];
    for seed in 0..20 {
        let surface = surface(seed, Refinement::Triangles);
        let mut shaded = Shaded::start(&surface, -20, 30, 8);
        for _ in 0..LEVELS {
            let patch = shaded.patch();
            let first = [patch.first.x, patch.first.z].map(|first| first.wrapping_mul(2).wrapping_add(1));
            shaded = shaded.refine(&surface, first[0], first[1], 2 * patch.size - 3).unwrap();
        }
        let patch = shaded.patch();
        for row in 1..patch.size - 1 {
            for column in 2..patch.size - 2 {
                let x = patch.first.x.wrapping_add(column as u64);
                let height = |column| patch.height(column, row);
                let bend = height(column + 1) - 2 * height(column) + height(column - 1);
                let change = shaded.gradient(column + 1, row)[0] - shaded.gradient(column - 1, row)[0];
                let is_crease = usize::from(x.is_multiple_of(1 << (LEVELS - 1)));
                for (sum, of) in sums.iter_mut().zip([bend as f64, f64::from(change)]) {
                    sum[is_crease][0] += of * of;
                    sum[is_crease][1] += 1.0;
                }
            }
        }
    }
    let [slope, gradient] = sums.map(|sums| {
        let [others, creases] = sums.map(|[sum, count]| sum / count);
        (creases / others).sqrt()
    });
    println!("bends at creases over those elsewhere: {slope:.2}, and as shaded {gradient:.2}");
    assert!(slope > 1.4, "{slope}: the surface has no creases to smooth");
    assert!(gradient < 1.05, "{gradient}");
}

/// A spine that came to a level one by one, or from a checkpoint, or at once, or from elsewhere, has the same heights.
#[test]
fn what_a_spine_keeps_does_not_show() {
    let surface = surface(5, Refinement::Triangles);
    let place = random_place(8, 3200);
    // A neighbour, a hair away across a wall of cells of level 1, and so of all that are deeper.
    let mut wall = [place.clone(), place.clone()];
    for (place, side) in wall.iter_mut().zip([0, -1]) {
        place.x = Fixed::from(2);
        place.x.add(1, 1);
        place.x.add(side, 3100);
    }
    let fresh = |place: &Place, level| Spine::new(surface).shaded(place, level).clone();
    let mut spine = Spine::new(surface);
    let there_and_back = (0..3100).chain((0..3100).rev()).step_by(61);
    for level in there_and_back {
        assert_eq!(*spine.shaded(&place, level), fresh(&place, level), "level {level}");
    }
    for level in [3000, 2999, 10, 3000, 1500, 2100, 0, 700] {
        assert_eq!(*spine.shaded(&place, level), fresh(&place, level), "level {level}");
        for place in &wall {
            assert_eq!(*spine.shaded(place, level), fresh(place, level), "level {level} at the wall");
        }
    }
}

/// A cell is the same by whatever way it is reached, and another one if it is 2⁶⁴ cells away.
#[test]
fn cells_are_known_by_all_their_digits() {
    let place = random_place(14, 500);
    for level in 0..450 {
        let cell = place.cell(level);
        let next = place.cell(level + 1);
        assert_eq!(cell.child([next.x, next.z].map(|coordinate| (coordinate & 1) as u32)), next);
        assert_eq!(place.parent(next), Some(cell));
        let beside = cell.beside(-5_000_000_000, 77);
        assert_eq!(beside.beside(5_000_000_000, -77), cell);
        assert_eq!(
            cell.descendant(3, [5, 8]),
            cell.child([1, 1]).child([0, 0]).beside(0, 1).child([1, 0]).beside(0, 2)
        );
        let mut moved = place.clone();
        moved.x.add(-9, level);
        moved.z.add(4, level);
        assert_eq!(moved.cell(level), cell.beside(-9, 4));
        assert_eq!(moved.cell(level + 20), place.cell(level + 20).beside(-9 << 20, 4 << 20));
        let [far, near] = [&moved, &place].map(|place| place.cell(level + 64));
        assert_eq!((far.x, far.z), (near.x, near.z));
        assert_ne!(far, near);
    }
    assert_eq!(place.parent(place.cell(0)), None);
    assert_eq!(Cell::whole(-3, 5), random_place(14, 500).cell(0));
}

/// Places that have moved by some cells of the level of a checkpoint find it useful, or don't, and have the same heights.
#[test]
fn checkpoints_serve_their_neighbourhood() {
    let surface = surface(6, Refinement::Triangles);
    // In the upper half of its cell, from where a patch reaches farthest.
    let mut place = random_place(4, 2500);
    let half = |number: &Fixed| 1 - (number.slice(1537) & 1) as i64;
    let (east, south) = (half(&place.x), half(&place.z));
    place.x.add(east, 1537);
    place.z.add(south, 1537);
    let mut known = Spine::new(surface);
    known.patch(&place, 2400);
    for level in [1537, 1855, 1856, 1857, 2200] {
        for (east, south) in (-3..=3).flat_map(|cells| [(cells, 0), (0, cells)]) {
            let mut moved = place.clone();
            moved.x.add(east, 1536);
            moved.z.add(south, 1536);
            let expected = Spine::new(surface).shaded(&moved, level).clone();
            let found = known.clone().shaded(&moved, level).clone();
            assert_eq!(found, expected, "level {level}, {east} and {south} cells");
        }
    }
}

/// Corner heights alone (what boxes are made from) are the heights of patches.
#[test]
fn corners_refine_like_patches() {
    for refinement in MODES {
        let surface = surface(17, refinement);
        let place = random_place(5, 200);
        let mut spine = Spine::new(surface);
        let middle = REACH as usize;
        for level in 0..150 {
            let patch = spine.patch(&place, level);
            let (cell, corners) = (patch.cell(middle, middle), patch.corners(middle, middle));
            let children = corners.children(&surface, cell);
            let next = spine.patch(&place, level + 1);
            for (index, child) in children.into_iter().enumerate() {
                let Cell { x, z, .. } = cell.child([index as u32 % 2, index as u32 / 2]);
                let [column, row] = [x.wrapping_sub(next.first.x), z.wrapping_sub(next.first.z)];
                assert_eq!(child, next.corners(column as usize, row as usize), "level {level}");
                let [least, most] = corners.bounds();
                let inside = |bound: i64, low: i64| bound.wrapping_sub(low.wrapping_mul(2));
                let [child_least, child_most] = child.bounds();
                assert!(inside(child_least, least) >= 0 && inside(child_most, most) <= 0);
            }
        }
    }
}

/// The chain of 32-bit tiles against the chain of 64-bit patches, at every vertex of every level.
fn tiles_follow_the_spine(bits: u32, levels: u32, refinement: Refinement) -> i64 {
    let surface = surface(3, refinement);
    let place = random_place(29, levels + 64);
    let mut spine = Spine::new(surface);
    let mut tile = Tile::from_patch(&surface, spine.shaded(&place, 0), place.cell(0), bits).unwrap();
    let mut largest = 0;
    for level in 1..=levels {
        let cell = place.cell(level);
        let patch = spine.shaded(&place, level);
        let corners = patch.patch().corners(REACH as usize, REACH as usize);
        tile = tile.child(&surface, [cell.x, cell.z].map(|half| (half & 1) as u32), base(corners, bits));
        assert_eq!(tile.cell, cell);
        let direct = Tile::from_patch(&surface, patch, cell, bits).unwrap();
        assert!(tile == direct, "level {level}");
        let most = tile.heights().map(|height| i64::from(height).abs()).max();
        largest = largest.max(most.unwrap());
    }
    // The bound that 32 bits are safe with, with a bit to spare.
    assert!(largest < 1 << 30, "{largest}");
    largest
}

#[test]
fn tiles_of_32_bits_are_the_surface() {
    for refinement in MODES {
        tiles_follow_the_spine(4, 1500, refinement);
        tiles_follow_the_spine(7, 12, refinement);
    }
}

#[test]
#[ignore = "minutes: make test-long"]
fn tiles_of_32_bits_are_the_surface_for_ten_thousand_levels() {
    for refinement in MODES {
        let largest = tiles_follow_the_spine(7, 10_000, refinement);
        println!("{refinement:?}: 171,610,000 vertices alike, the largest difference to a base {largest}");
    }
}

proptest! {
    /// A tile's base may be any number: heights stay what they are.
    #[test]
    fn bases_do_not_show(seed: u32, quarters in prop::collection::vec((0u32..2, 0u32..2, -1_000_000i64..1_000_000), 1..12),
                         bilinear: bool) {
        let surface = surface(seed, MODES[usize::from(bilinear)]);
        let patch = Shaded::start(&surface, -2, 40, 4);
        let mut cell = patch.patch().cell(1, 1);
        let mut tile = Tile::from_patch(&surface, &patch, cell, 4).unwrap();
        let mut block = patch;
        for (x, z, shift) in quarters {
            cell = cell.child([x, z]);
            block = block.refine(&surface, cell.x.wrapping_sub(1), cell.z.wrapping_sub(1), 4).unwrap();
            let direct = Tile::from_patch(&surface, &block, cell, 4).unwrap();
            tile = tile.child(&surface, [x, z], direct.base + shift);
            for index in 0..tile.side() * tile.side() {
                let (column, row) = (index % tile.side(), index / tile.side());
                prop_assert_eq!(tile.height(column, row), direct.height(column, row));
            }
            prop_assert_eq!(tile.gradients(), direct.gradients());
        }
    }
}

/// Tiles left and right of a wall of all levels, …0111 | …1000, each made by its own ancestors alone: three columns that both have are the same in
/// both, for both are rims of the other.
#[test]
fn neighbours_agree_about_their_border() {
    for refinement in MODES {
        let surface = surface(23, refinement);
        let patch = Shaded::start(&surface, -2, 7, 6);
        let mut pair = [1, 2].map(|column| {
            Tile::from_patch(&surface, &patch, patch.patch().cell(column, 1), 4)
                .expect("all that it hangs on is here")
        });
        let mut words = Words(1);
        for level in 1..=1000 {
            let down = (words.word() & 1) as u32;
            let bases = [words.word(), words.word()].map(|word| (word >> 50) as i64);
            // Each has a base of its own, near that of its parent.
            let [left, right] = [(1, bases[0]), (0, bases[1])].map(|(half, shift)| {
                let tile = &pair[1 - half as usize];
                let middle = tile.height(8 * half as usize + 5, 8 * down as usize + 5).wrapping_mul(2);
                tile.child(&surface, [half, down], middle.wrapping_add(shift))
            });
            let side = left.side();
            for row in 0..side {
                for column in 0..3 {
                    let [there, here] = [left.height(side - 3 + column, row), right.height(column, row)];
                    assert_eq!(there, here, "level {level}, row {row}, column {column}");
                }
                // Of these the middle one is the border, where both have gradients.
                let gradients = [(&left, side - 2), (&right, 1)];
                let [there, here] = gradients.map(|(tile, column)| tile.gradients()[row * side + column]);
                assert_eq!(there, here, "level {level}, row {row}");
            }
            pair = [left, right];
        }
    }
}

/// Samples of the noise around corners where words of 32 and 64 bits wrap.
fn samples(level: u32, x: u64, z: u64) -> Vec<f64> {
    let octave = surface(1, Refinement::Triangles).octave(level);
    let side = 0..512u64;
    let row = |j: u64| side.clone().map(move |i| f64::from(octave.at(x.wrapping_add(i), z.wrapping_add(j))));
    side.clone().flat_map(row).map(|noise| noise / 256.0).collect()
}

#[test]
fn noise_has_the_moments_of_chance() {
    let corners =
        [[0u64, 0], [(1 << 32) - 256, 5], [7u64.wrapping_neg(), (1 << 32) - 256], [u64::MAX - 255; 2]];
    let all: Vec<Vec<f64>> = corners.iter().map(|[x, z]| samples(9, *x, *z)).collect();
    let next: Vec<Vec<f64>> = corners.iter().map(|[x, z]| samples(10, *x, *z)).collect();
    let count = all.iter().map(Vec::len).sum::<usize>() as f64;
    let values = || all.iter().flatten();
    let variance = (1.0 - 1.0 / 65_536.0) / 3.0;
    // Standard errors: √(variance / n); of a uniform number's square, √(4/45 / n); of a correlation, 1 / √n.
    let mean = values().sum::<f64>() / count;
    assert!(mean.abs() < 4.0 * (variance / count).sqrt(), "mean {mean}");
    let square = values().map(|value| value * value).sum::<f64>() / count;
    assert!((square - variance).abs() < 4.0 * (4.0 / 45.0 / count).sqrt(), "variance {square}");
    let mut bins = [0u32; 256];
    values().for_each(|value| bins[((value * 256.0 + 255.0) / 2.0) as usize] += 1);
    let expected = count / 256.0;
    let chi2: f64 = bins.iter().map(|bin| (f64::from(*bin) - expected).powi(2) / expected).sum();
    // 255 degrees of freedom: mean 255, standard deviation √510.
    assert!((chi2 - 255.0).abs() < 4.0 * 510f64.sqrt(), "χ² {chi2}");
    let correlation = |name: &str, pairs: Vec<(f64, f64)>| {
        let number = pairs.len() as f64;
        let sum: f64 = pairs.iter().map(|(own, other)| own * other).sum();
        let correlation = sum / number / variance;
        assert!(correlation.abs() < 4.0 / number.sqrt(), "{name}: {correlation}");
    };
    let pairs = |own: &[f64], other: &[f64]| -> Vec<(f64, f64)> {
        own.iter().copied().zip(other.iter().copied()).collect()
    };
    let rows = all.iter().flat_map(|own| own.chunks(512));
    correlation("along x", rows.flat_map(|row| pairs(row, &row[1..])).collect());
    correlation("along z", all.iter().flat_map(|own| pairs(own, &own[512..])).collect());
    let levels = all.iter().zip(&next).flat_map(|(own, next)| pairs(own, next));
    correlation("the same coordinates a level on", levels.collect());
}

/// A vertex and itself a level on, where its coordinates are twice as large.
#[test]
fn noise_of_a_vertex_is_new_at_each_level() {
    let surface = surface(1, Refinement::Triangles);
    let [own, next] = [20, 21].map(|level| surface.octave(level));
    let mut sum = 0.0;
    let count = 400_000u64;
    for index in 0..count {
        let (x, z) = (index % 632, index / 632);
        sum += f64::from(own.at(x, z)) * f64::from(next.at(2 * x, 2 * z));
    }
    let correlation = sum / count as f64 / (65_535.0 / 3.0);
    assert!(correlation.abs() < 4.0 / (count as f64).sqrt(), "{correlation}");
}

/// At random places slopes drift, by 2/3 of a squared amplitude a level with triangles, 4/9 with bilinear cells.
#[test]
fn slopes_of_random_places_drift() {
    const LEVELS: u32 = 300;
    for (refinement, expected) in [(Refinement::Triangles, 2.0 / 3.0), (Refinement::Bilinear, 4.0 / 9.0)] {
        let surface = surface(2, refinement);
        let mut words = Words(4);
        let mut squares = 0.0;
        let count = 1500;
        for _ in 0..count {
            let patch = Patch::start(&surface, words.word() as i64 >> 1, words.word() as i64 >> 1, 2);
            let (mut cell, mut corners) = (patch.cell(0, 0), patch.corners(0, 0));
            for _ in 0..LEVELS {
                let quarter = (words.word() >> 62) as u32;
                corners = corners.children(&surface, cell)[quarter as usize];
                cell = cell.child([quarter % 2, quarter / 2]);
            }
            let [[x, z], _] = corners.gradients(cell).map(|of| of.map(|slope| slope as f64 / 256.0));
            squares += x * x + z * z;
        }
        let a_level = squares / f64::from(2 * count * LEVELS);
        // 3000 numbers of a normal distribution: their variance is known to 1 part in √1500, 2.6 %.
        assert!((a_level / expected - 1.0).abs() < 4.0 / 1500f64.sqrt(), "{refinement:?}: {a_level}");
    }
}

proptest! {
    /// Slices and sums against integers without bounds.
    #[test]
    fn fixed_point_is_exact(whole in -1000i64..1000, terms in prop::collection::vec((any::<i64>(), 0u32..400), 0..12)) {
        let mut number = Fixed::from(whole);
        let mut exact: BigInt = BigInt::from(whole) << 400;
        for (amount, level) in terms {
            number.add(amount, level);
            exact += BigInt::from(amount) << (400 - level);
            // The whole part is modulo 2^64, and nothing else.
            for level in [0u32, 1, 17, 63, 64, 65, 128, 200, 333, 400] {
                prop_assert_eq!(number.slice(level), low(&(&exact >> (400 - level))), "level {}", level);
            }
            prop_assert_eq!(number.slice(464), low(&(&exact << 64)));
            let trailing = exact.trailing_zeros().unwrap_or(400).min(400) as u32;
            prop_assert_eq!(number.digits(), 400 - trailing);
            let mut back = number.clone();
            back.add(amount, level);
            back.add(amount.wrapping_neg(), level);
            prop_assert!(amount == i64::MIN || back == number);
        }
    }

    /// How far a lattice point is, however deep: its difference, rounded once.
    #[test]
    fn offsets_are_exact(level in 0u32..5000, cells in -(1i64 << 40)..(1i64 << 40), behind: u64, seed: u64) {
        let mut number = random_number(&mut Words(seed), 3, level);
        let lattice = number.slice(level);
        let past = u64::MAX >> (64 - 32) & behind;
        let mut at = Fixed::default();
        std::mem::swap(&mut at, &mut number);
        // Digits down to the level, then 32 known ones.
        let mut exact = Fixed::from(at.whole());
        (1..=level).for_each(|digit| exact.add((at.slice(digit) & 1) as i64, digit));
        exact.add(past as i64, level + 32);
        let offset = exact.at(level).to(lattice.wrapping_add(cells as u64));
        let expected = (cells as f64 * 4_294_967_296.0 - past as f64) / 4_294_967_296.0;
        prop_assert!((offset - expected).abs() <= expected.abs() * f64::EPSILON, "{} {}", offset, expected);
    }

    #[test]
    fn codes_come_back(seed: u32, bilinear: bool, level in 0u32..3000, extra in 0u32..90, numbers: u64,
                       angles: [u16; 3], fov in 183u16..=32_585, whole: [i64; 3], break_at: usize) {
        let mut place = random_place(numbers, level + extra);
        place.x.add(whole[0] >> 25, 0);
        place.y.add(whole[1] >> 30, 0);
        place.z.add(whole[2] >> 60, 0);
        let [yaw, pitch, roll] = angles;
        let surface = Surface { roughness: Roughness::Quarter, ..surface(seed, MODES[usize::from(bilinear)]) };
        let location = Location { surface, level, place, attitude: Attitude { yaw, pitch, roll }, fov };
        let code = location.code();
        prop_assert_eq!(Location::parse(&code).unwrap(), location);
        // Three bits a level, and little besides.
        prop_assert!(code.len() as u32 <= (level + extra) / 2 + 90);
        // Broken into lines, as mail does.
        let lines = format!(" {}\n{}\r\n", &code[..code.len() / 2], &code[code.len() / 2..]);
        prop_assert_eq!(Location::parse(&lines).unwrap().code(), code.clone());
        // Cut, or with one letter that is wrong.
        let at = break_at % code.len();
        prop_assert!(Location::parse(&code[..at]).is_err());
        let other = if &code[at..at + 1] == "A" { "B" } else { "A" };
        let wrong = format!("{}{other}{}", &code[..at], &code[at + 1..]);
        prop_assert!(Location::parse(&wrong).is_err());
    }

    #[test]
    fn no_text_is_too_strange_for_a_code(text in "\\PC*") {
        let _ = Location::parse(&text);
    }
}

#[test]
fn attitudes_are_turns_about_axes() {
    let axes = |yaw: i32, pitch: i32, roll: i32| {
        let [yaw, pitch, roll] = [yaw, pitch, roll].map(|degrees| (degrees * 65_536 / 360) as u16);
        Attitude { yaw, pitch, roll }.axes()
    };
    let close = |axes: [DVec3; 3], expected: [[f64; 3]; 3]| {
        axes.iter().zip(expected).all(|(axis, expected)| axis.abs_diff_eq(DVec3::from_array(expected), 1e-4))
    };
    // North, east, half up to the east, and north with the right side down.
    assert!(close(axes(0, 0, 0), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]));
    assert!(close(axes(90, 0, 0), [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert!(close(axes(90, 45, 0), [[0.0, 0.0, 1.0], [-half, half, 0.0], [half, half, 0.0]]));
    assert!(close(axes(0, 0, 90), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]));
    let [right, up, forward] = axes(213, -67, 31);
    assert!(right.cross(up).abs_diff_eq(-forward, 1e-12) && right.dot(up).abs() < 1e-12);
}

#[test]
fn bad_codes_say_what_is_wrong() {
    let location = Location {
        surface: surface(1, Refinement::Triangles),
        level: 5,
        place: random_place(1, 40),
        attitude: Attitude::default(),
        fov: 10_923,
    };
    let code = location.code();
    let fault = |text: &str| Location::parse(text).unwrap_err();
    assert_eq!(fault(" \n"), CodeError::Empty);
    assert_eq!(fault("BA+A"), CodeError::Letter { found: '+', position: 3 });
    assert_eq!(fault("é"), CodeError::Letter { found: 'é', position: 1 });
    assert_eq!(fault("BA"), CodeError::Cut);
    assert_eq!(fault(&code[..code.len() - 1]), CodeError::Checksum);
    assert_eq!(fault(&format!("C{}", &code[1..])), CodeError::Version { found: 2, known: 1 });
    let long = "B".repeat(3 * MOST_LETTERS);
    assert_eq!(fault(&long), CodeError::TooLong { letters: 3 * MOST_LETTERS, most: MOST_LETTERS });
    let forged = |location: &Location| Location::parse(&location.code()).unwrap_err();
    let impossible = |fault: CodeError| matches!(fault, CodeError::Impossible(_));
    assert!(impossible(forged(&Location { fov: 0, ..location.clone() })));
    let mut far = location.place.clone();
    far.y.add(1 << 41, 0);
    assert!(impossible(forged(&Location { place: far, ..location.clone() })));
    assert!(impossible(forged(&Location { level: DEEPEST + 1, ..location.clone() })));
    // The deepest place has a code that is not too long.
    let mut deepest = random_place(2, DEEPEST + 128);
    deepest.x.add(1, DEEPEST + 128);
    let deepest = Location { level: DEEPEST, place: deepest, ..location };
    assert_eq!(Location::parse(&deepest.code()), Ok(deepest));
}
