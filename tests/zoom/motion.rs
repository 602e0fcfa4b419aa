//! Motion over the surface of a zoom: never through it, down for ever, and back on the same path.

use crate::kit::zoom::{Words, random_place_above};
use glam::DVec3;
use terrane::zoom::{
    address::{Attitude, Fixed, Location, Place},
    height::{AMPLITUDE, Patch, REACH, Refinement, Roughness, Spine, Surface, rises},
    motion::{Approach, Autopilot, Buried, Clearance, Depth, Distance, Flight, LEVEL_A_SECOND, clearance},
    tree::Eye,
};

const MODES: [Refinement; 2] = [Refinement::Triangles, Refinement::Bilinear];

fn surface(seed: u32) -> Surface {
    Surface { seed, refinement: MODES[seed as usize % 2], roughness: Roughness::Half }
}

/// −1 to 1.
fn signed_unit(word: u64) -> f64 {
    (word >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// From a place to the nearest vertex of the surface seven levels below `level`, in cells of `level`, and how much nearer
/// than that the surface may come: it is an amplitude from the triangles or patches between vertices.
fn nearest_vertex(spine: &mut Spine, place: &Place, level: u32) -> (f64, f64) {
    const FINER: u32 = 7;
    let surface = *spine.surface();
    let mut fine: Patch = spine.patch(place, level).clone();
    let [x, z] = [fine.first.x, fine.first.z];
    for step in 1..=FINER {
        fine = fine.refine(&surface, x << step, z << step, (15 << step) + 1).unwrap();
    }
    let eye = Eye::new(&surface, place, level + FINER);
    let mut nearest = f64::INFINITY;
    for row in 0..fine.size {
        for column in 0..fine.size {
            let cell = fine.cell(column, row);
            let [x, y, z] = eye.to(cell.x, fine.height(column, row), cell.z);
            nearest = nearest.min(x * x + y * y + z * z);
        }
    }
    let scale = 0.5f64.powi(FINER as i32);
    (nearest.sqrt() * scale, surface.roughness.cells() * scale)
}

/// Against the nearest of 3.7 million vertices.
#[test]
fn clearance_is_the_distance_to_the_surface() {
    for seed in 0..6 {
        let mut spine = Spine::new(surface(seed));
        let depth = [3, 40, 200][seed as usize % 3];
        let place = random_place_above(&mut spine, &mut Words(seed.into()), depth, 3000);
        let Clearance { distance, is_above } = clearance(&mut spine, &place, depth).unwrap();
        assert!(is_above);
        let cells = |level: u32| distance.cells * 2f64.powi(level as i32 - distance.level as i32);
        let (vertex, amplitude) = nearest_vertex(&mut spine, &place, depth);
        assert!(cells(depth) <= vertex + amplitude, "{} {vertex}", cells(depth));
        // At most 1/16 less, and the surface may be an amplitude nearer than a vertex, and a spacing aside of it on some slope.
        assert!(cells(depth) * (17.0 / 16.0) >= vertex - 6.0 * amplitude, "{} {vertex}", cells(depth));
    }
}

#[test]
fn hints_and_what_was_before_do_not_change_the_clearance() {
    for seed in 0..10 {
        let mut spine = Spine::new(surface(seed));
        let depth = 30 + 40 * seed;
        let place = random_place_above(&mut spine, &mut Words(seed.into()), depth, 1500);
        let expected = clearance(&mut spine, &place, depth);
        assert!(expected.is_some());
        for hint in [0, 5, depth - 7, depth - 1, depth + 1, depth + 40, 100_000] {
            assert_eq!(clearance(&mut spine, &place, hint), expected, "hint {hint}");
            assert_eq!(clearance(&mut Spine::new(surface(seed)), &place, hint), expected, "hint {hint}");
        }
        let below = random_place_above(&mut spine, &mut Words(seed.into()), depth, -1500);
        assert!(!clearance(&mut spine, &below, depth).unwrap().is_above);
        assert_eq!(Flight::new(&mut spine, below, depth).unwrap_err(), Buried);
    }
}

#[test]
fn far_above_the_distance_is_that_to_the_plane() {
    let mut spine = Spine::new(surface(1));
    for height in [10, 1000, 1 << 20] {
        for sign in [1, -1] {
            let place = Place { y: Fixed::from(sign * height), ..Place::default() };
            let Clearance { distance: Distance { level, cells }, is_above } =
                clearance(&mut spine, &place, 0).unwrap();
            assert_eq!((level, is_above), (0, sign == 1));
            // Within two amplitudes, half a cell each, or as little as the 1/16 that is allowed.
            let exact = height as f64 / 2.0;
            assert!(cells <= exact + 1.0 && cells >= exact * (16.0 / 17.0) - 1.0, "{cells} of {exact}");
        }
    }
}

/// The height of a point of a level's surface, above or below a place in cells: on the triangles, or on the bilinear patch.
fn surface_below(spine: &mut Spine, place: &Place, level: u32) -> f64 {
    let refinement = spine.surface().refinement;
    let eye = Eye::new(spine.surface(), place, level);
    let patch = spine.patch(place, level);
    let middle = REACH as usize;
    let (cell, corners) = (patch.cell(middle, middle), patch.corners(middle, middle));
    let heights = corners.0.map(|height| eye.to(cell.x, height, cell.z)[1]);
    let [a, b, c, d] = heights;
    let [x, _, z] = eye.to(cell.x, 0, cell.z).map(|to| -to);
    match (refinement, rises(cell.x, cell.z)) {
        (Refinement::Bilinear, _) => (a * (1.0 - x) + b * x) * (1.0 - z) + (c * (1.0 - x) + d * x) * z,
        (_, true) if x > z => a + (b - a) * x + (d - b) * z,
        (_, true) => a + (d - c) * x + (c - a) * z,
        (_, false) if x + z < 1.0 => a + (b - a) * x + (c - a) * z,
        (_, false) => d + (c - d) * (1.0 - x) + (b - d) * (1.0 - z),
    }
}

/// Flies at random, mostly down, sometimes up or far in one go. Returns the deepest level.
fn fly_at_random(seed: u32, steps: u32) -> u32 {
    let surface = surface(seed);
    let mut spine = Spine::new(surface);
    let start = random_place_above(&mut spine, &mut Words(seed.into()), 5, 2000);
    let mut flight = Flight::new(&mut spine, start, 5).unwrap();
    let mut words = Words(seed.into());
    let mut deepest = 0;
    let mut drift = -0.6;
    for step in 0..steps {
        if words.word().is_multiple_of(300) {
            drift = if words.word().is_multiple_of(4) { 0.5 } else { -0.6 };
        }
        let direction = DVec3::from_array([(); 3].map(|()| signed_unit(words.word()))) + DVec3::Y * drift;
        let way = if words.word().is_multiple_of(50) { 8.0 } else { 0.5 };
        flight.fly(&mut spine, direction, way);
        let Distance { level, cells } = flight.clearance();
        deepest = deepest.max(level);
        assert!(cells >= 1.0 || level == 0 && cells > 0.0, "step {step}");
        // The surface is within an amplitude of what its level shows.
        let fine = level + 6;
        let rest = surface.roughness.cells();
        let below = surface_below(&mut spine, flight.place(), fine);
        assert!(below + rest < 0.0, "step {step}, level {level}: {below}");
        assert!(-below + rest >= cells * 64.0 * (level > 0) as u32 as f64, "the bound is none");
    }
    deepest
}

#[test]
fn no_flight_passes_the_surface() {
    let deepest: Vec<u32> = (0..4).map(|seed| fly_at_random(seed, 5000)).collect();
    println!("{deepest:?}");
    assert!(deepest.iter().all(|level| *level > 300), "{deepest:?}");
}

#[test]
#[ignore = "minutes: make test-long"]
fn no_flight_of_a_million_steps_passes_the_surface() {
    let deepest: Vec<u32> = (0..10).map(|seed| fly_at_random(seed, 100_000)).collect();
    println!("a million steps, down to {deepest:?}");
}

#[test]
fn strange_input_moves_nothing_strangely() {
    let mut spine = Spine::new(surface(1));
    let place = random_place_above(&mut spine, &mut Words(1), 5, 2000);
    let mut flight = Flight::new(&mut spine, place.clone(), 5).unwrap();
    let mut fly = |direction, way| flight.fly(&mut spine, direction, way);
    fly(DVec3::NAN, 1.0);
    fly(DVec3::splat(f64::INFINITY), 1.0);
    fly(DVec3::X, f64::NAN);
    fly(DVec3::X, -1.0);
    assert_eq!(*flight.place(), place);
    // Up for ever ends at the ceiling, however long it lasts.
    for _ in 0..200 {
        flight.fly(&mut spine, DVec3::Y * 1e300, f64::INFINITY);
    }
    let Distance { level, cells } = flight.clearance();
    assert!(level == 0 && (1e6..1e7).contains(&cells), "{cells}");
    flight.fly(&mut spine, -DVec3::Y, 8.0);
    assert!(flight.clearance().cells < cells / 100.0);
}

/// Straight down over flat ground, a level takes a second; and the way is the same however it is cut, nearly.
#[test]
fn speed_is_proportional_to_the_distance() {
    let mut spine = Spine::new(Surface { roughness: Roughness::Quarter, ..surface(2) });
    let place = Place { y: Fixed::from(4_000_000), ..Place::default() };
    let mut flight = Flight::new(&mut spine, place, 0).unwrap();
    let start = flight.clearance().depth();
    for _ in 0..600 {
        flight.fly(&mut spine, -DVec3::Y, LEVEL_A_SECOND / 60.0);
    }
    let levels = flight.clearance().depth() - start;
    // Ten, less what is lost by steps of 1/60 s (1 − x for e^−x: 0.6 %), and distances that are 1/16 short.
    assert!((9.4..10.2).contains(&levels), "{levels}");
}

/// The variance of slopes along the targets of many paths, (amplitudes a cell)² along an axis, and the largest slope.
fn steered(seeds: u32, levels: u32) -> Vec<[f64; 2]> {
    let mut all = vec![[0.0; 2]; levels as usize];
    for seed in 0..seeds {
        let surface = Surface { refinement: Refinement::Triangles, ..surface(seed) };
        let mut autopilot = Autopilot::new(surface);
        let mut spine = Spine::new(surface);
        for (level, [variance, largest]) in (0..).zip(&mut all) {
            let target = autopilot.target(level).clone();
            let patch = spine.patch(&target, level);
            let middle = REACH as usize;
            // Its corner is on the target.
            let corners = patch.corners(middle, middle);
            for gradient in corners.gradients(patch.cell(middle, middle)) {
                let [x, z] = gradient.map(|slope| slope as f64 / AMPLITUDE as f64);
                *variance += (x * x + z * z) / f64::from(4 * seeds);
                *largest = largest.max(x.abs()).max(z.abs());
            }
        }
    }
    all
}

fn slopes_stay_bounded(seeds: u32, levels: u32) {
    let all = steered(seeds, levels);
    let behind = &all[10..];
    let mean = behind.iter().map(|[variance, _]| variance).sum::<f64>() / behind.len() as f64;
    let [variance, largest] = [0, 1].map(|index| behind.iter().map(|of| of[index]).fold(0.0, f64::max));
    println!(
        "{seeds} paths, {levels} levels: variance {mean:.3}, at most {variance:.3}; slopes at most {largest:.2}"
    );
    assert!(variance < 0.8 && mean < 0.25, "{variance} {mean}");
    // By 2/3 a level, the variance would be hundreds.
    assert!(largest < 5.0, "{largest}");
}

#[test]
fn steered_slopes_stay_bounded() {
    slopes_stay_bounded(24, 1000);
}

#[test]
#[ignore = "minutes: make test-long"]
fn steered_slopes_stay_bounded_for_ten_thousand_levels() {
    slopes_stay_bounded(200, 10_000);
}

/// The target's height is that of the surface, to the last digit.
#[test]
fn targets_lie_on_the_surface() {
    for seed in 0..2 {
        let surface = surface(seed);
        let mut autopilot = Autopilot::new(surface);
        for level in [0, 1, 5, 300, 255, 256, 257, 700, 40] {
            let target = autopilot.target(level).clone();
            assert_eq!(Spine::new(surface).ground(&target, level), target.y, "level {level}");
        }
    }
}

/// Frames in, frames out, at random, from the start or from elsewhere: the same poses, to the last bit.
#[test]
fn the_way_back_is_the_way_in() {
    let surface = surface(3);
    let mut autopilot = Autopilot::new(surface);
    let mut spine = Spine::new(surface);
    let depth = |frame| Depth::of_frame(frame, 7, 12);
    let way_in: Vec<_> = (0..1030).map(|frame| autopilot.at(&mut spine, depth(frame))).collect();
    for frame in (0..1030).rev() {
        assert_eq!(autopilot.at(&mut spine, depth(frame)), way_in[frame as usize], "frame {frame}");
    }
    for frame in [600, 3, 1029, 500, 77] {
        assert_eq!(autopilot.at(&mut spine, depth(frame)), way_in[frame as usize], "frame {frame}");
        assert_eq!(
            Autopilot::new(surface).at(&mut Spine::new(surface), depth(frame)),
            way_in[frame as usize],
            "frame {frame}"
        );
    }
}

/// The autopilot keeps its distance, moves smoothly, and looks at its target.
fn autopilot_flies(seed: u32, levels: u32, parts: u64) {
    let surface = surface(seed);
    let mut autopilot = Autopilot::new(surface);
    let mut spine = Spine::new(surface);
    let mut last: Option<Place> = None;
    let mut extremes = [f64::INFINITY, 0.0, 0.0];
    for frame in 0..u64::from(levels) * parts {
        let depth = Depth::of_frame(frame, 1, parts as u32);
        let pose = autopilot.at(&mut spine, depth);
        let level = depth.whole();
        let Clearance { distance, is_above } = clearance(&mut spine, &pose.place, level).unwrap();
        assert!(is_above);
        // In distances of the frame.
        let exact = depth.0 as f64 / 65_536.0;
        let clear = (exact - distance.depth()).exp2();
        // Farther only where the ground beside its target rises higher than usual.
        assert!((0.25..4.0).contains(&clear), "frame {frame}: {clear}");
        extremes = [clear.min(extremes[0]), clear.max(extremes[1]), extremes[2]];
        // From the target, in cells of the level.
        let from = |place: &Place| {
            let target = autopilot.target(level + 24);
            let finer = |number: &Fixed, level| number.slice(level + 24);
            let cells = |of: &Fixed, to: &Fixed, level| {
                (finer(of, level).wrapping_sub(finer(to, level)) as i64) as f64 / f64::from(1 << 24)
            };
            let up = cells(&place.y, &target.y, level) * surface.roughness.cells();
            DVec3::new(cells(&place.x, &target.x, level), up, cells(&place.z, &target.z, level))
        };
        let mut from = from;
        let scale = (f64::from(level) - exact).exp2();
        let offset = from(&pose.place) / scale;
        assert!((offset.x.hypot(offset.z) - 0.75).abs() < 1e-3, "{offset}");
        assert!(offset.y > 0.6249, "{offset}");
        let Attitude { yaw, pitch, roll } = pose.attitude;
        let radians = |angle: u16| f64::from(angle as i16) / 65_536.0 * std::f64::consts::TAU;
        let (sin, cos) = radians(yaw).sin_cos();
        let towards = -DVec3::new(offset.x, 0.0, offset.z).normalize();
        assert!((towards - DVec3::new(sin, 0.0, -cos)).length() < 1e-3);
        let down = offset.y.atan2(offset.x.hypot(offset.z));
        assert!((radians(pitch) + down - 4000.0 / 65_536.0 * std::f64::consts::TAU).abs() < 1e-3);
        assert_eq!(roll, 0);
        if let Some(last) = &last {
            let step = (from(last) / scale - offset).length();
            // ln 2 of its way in an octave, and how much higher it may have to be behind it.
            assert!(step < 4.0 / parts as f64, "frame {frame}: {step}");
            extremes[2] = step.max(extremes[2]);
        }
        last = Some(pose.place);
    }
    let [least, most, step] = extremes;
    println!("{least:.2} to {most:.2} distances from the surface, steps of at most {step:.2}");
}

#[test]
fn the_autopilot_keeps_its_distance() {
    for seed in 0..4 {
        autopilot_flies(seed, 120, 10);
    }
}

#[test]
#[ignore = "minutes: make test-long"]
fn the_autopilot_keeps_its_distance_for_thousands_of_levels() {
    for seed in 0..8 {
        autopilot_flies(seed, 4000, 8);
    }
}

/// What is written in whole numbers is what it stands for.
#[test]
fn approaches_are_powers_of_two() {
    let approach = Approach { target: Place::default(), offset: [0, 1 << 16, -(1 << 16)] };
    for part in (0..65_536).step_by(97) {
        let place = approach.at(Depth(part), Roughness::Whole);
        let exact = (-(part as f64) / 65_536.0).exp2();
        let up = place.y.slice(32) as f64 / 2f64.powi(32);
        assert!((up - exact).abs() < 1e-8, "{up} {exact}");
        assert!((place.z.slice(32) as i64 as f64 / 2f64.powi(32) + up).abs() < 1e-9);
    }
    assert_eq!(Depth::of_frame(90, 1, 30), Depth::level(3));
    assert_eq!(Depth::of_frame(u64::MAX, u32::MAX, 0), Depth(u64::MAX));
}

/// A million levels are an hour of film at 277 levels a second; ten thousand are soon there. A code of such a place leads back to it.
#[test]
fn a_code_leads_to_where_a_flight_was() {
    let surface = surface(6);
    let mut autopilot = Autopilot::new(surface);
    let mut spine = Spine::new(surface);
    let pose = autopilot.at(&mut spine, Depth(10_000 << 16 | 12_345));
    let location =
        Location { surface, level: 10_000, place: pose.place.clone(), attitude: pose.attitude, fov: 10_923 };
    let found = Location::parse(&location.code()).unwrap();
    assert_eq!(found, location);
    let mut spine = Spine::new(found.surface);
    let flight = Flight::new(&mut spine, found.place, found.level).unwrap();
    assert!((flight.clearance().depth() - 10_000.0).abs() < 3.0);
    let mut other = Spine::new(surface);
    for level in (0..10_000).step_by(500) {
        other.patch(&pose.place, level);
    }
    assert_eq!(clearance(&mut other, &pose.place, 9990).unwrap().distance, flight.clearance());
}

/// What is kept grows by less than four bytes a level.
#[test]
fn memory_hardly_grows_with_depth() {
    let surface = surface(8);
    let mut autopilot = Autopilot::new(surface);
    let mut spine = Spine::new(surface);
    let mut kept = |depth: u32| {
        for level in (0..=depth).step_by(100) {
            let pose = autopilot.at(&mut spine, Depth::level(level));
            clearance(&mut spine, &pose.place, level).unwrap();
        }
        autopilot.bytes() + spine.bytes()
    };
    let [some, more] = [2000, 10_000].map(&mut kept);
    let a_level = (more - some) as f64 / 8000.0;
    println!("{some} bytes at depth 2000, {a_level:.2} a level");
    assert!(a_level < 4.0, "{a_level}");
}

/// Assistance leads to slopes that stay bounded, where a straight descent comes to cliffs.
#[test]
fn assistance_leads_to_gentle_ground() {
    let descend = |strength: f64, seed: u32| {
        let surface = Surface { refinement: Refinement::Triangles, ..surface(seed) };
        let mut spine = Spine::new(surface);
        let place = random_place_above(&mut spine, &mut Words(seed.into()), 3, 2000);
        let mut flight = Flight::new(&mut spine, place, 3).unwrap();
        let (mut sum, mut count) = (0.0, 0);
        while flight.clearance().level < 120 {
            let direction = flight.assist(&mut spine, -DVec3::Y, strength);
            flight.fly(&mut spine, direction, 0.4);
            let level = flight.clearance().level;
            if level > 80 {
                let patch = spine.patch(flight.place(), level);
                let middle = REACH as usize;
                let cell = patch.cell(middle, middle);
                sum += patch.corners(middle, middle).steepness(cell) as f64 / (AMPLITUDE * AMPLITUDE) as f64;
                count += 1;
            }
        }
        sum / f64::from(count)
    };
    let mean = |strength| (0..4).map(|seed| descend(strength, seed)).sum::<f64>() / 4.0;
    let [straight, assisted] = [0.0, 1.0].map(mean);
    println!("squared slopes: {straight:.1} straight down, {assisted:.2} with assistance");
    assert!(assisted < 6.0 && straight > 10.0 * assisted, "{straight} {assisted}");
}

/// Out by hand, straight up, and in again on the same places; nothing is in the way.
#[test]
fn a_way_out_leads_back() {
    for seed in 0..4 {
        let mut spine = Spine::new(surface(seed));
        let place = random_place_above(&mut spine, &mut Words(seed.into()), 300, 2000);
        let flight = Flight::new(&mut spine, place.clone(), 300).unwrap();
        let (way, depth) = flight.way_out(&mut spine);
        let roughness = spine.surface().roughness;
        let near = way.at(depth, roughness);
        // Where it is, to 2⁻¹⁶ of the distance.
        assert_eq!((&near.x, &near.z), (&place.x, &place.z));
        let unit = place.y.slice(depth.whole() + 30).wrapping_sub(near.y.slice(depth.whole() + 30)) as i64;
        assert!(unit.abs() < 1 << 16, "{unit}");
        for level in (0..=depth.whole()).rev().step_by(7) {
            let place = way.at(Depth::level(level), roughness);
            assert!(clearance(&mut spine, &place, level).unwrap().is_above, "level {level}");
        }
    }
}
