//! Pictures of a zoom: no holes, no pops, the same bits again.

use crate::kit;
use crate::kit::zoom::{Words, light, random_place_above, surface};
use glam::DVec3;
use sha2::{Digest, Sha256};
use terrane::{
    scene::{Film, Picture, ToneMap},
    zoom::{
        address::Attitude,
        background,
        height::{Refinement, Roughness, Spine, Surface},
        marks::Marks,
        motion::{Autopilot, Depth},
        tree::Detail,
        view::{self, Ahead, Renderer, Settings, View},
    },
};

/// The least tiles and the coarsest detail that papers speak of: N = 16, c = 32.
const SETTINGS: Settings = Settings {
    bits: 4,
    detail: Detail::COMMON,
    octaves: 24,
    clear: 0.5,
    layers: Some(2),
    face: 192,
    slots: 8000,
    samples: 1,
};

const FILM: Film = Film { width: 160, height: 90, exposure: 1.0 / 20_000.0, tone_map: ToneMap::Filmic };

fn steered(surface: Surface, depth: Depth) -> View {
    let pose = Autopilot::new(surface).at(&mut Spine::new(surface), depth);
    View { place: pose.place, attitude: pose.attitude, fov: 1.0, level: depth.whole() }
}

/// Degrees to parts of a turn.
fn turn(degrees: f64) -> u16 {
    (degrees / 360.0 * 65_536.0).round() as i64 as u16
}

/// The surface is a function of where one stands, so what a column of a picture that looks straight ahead shows is sky, and ground below that:
/// nothing in it can be a hole but sky below ground.
fn holes_ahead(ranges: &[f32]) -> usize {
    let width = FILM.width as usize;
    let column = |column: usize| ranges.iter().skip(column).step_by(width);
    (0..width)
        .map(|at| column(at).skip_while(|range| **range == 0.0).filter(|range| **range == 0.0).count())
        .sum()
}

/// Looks around at so many places, half of them steered, on each of three surfaces.
fn no_holes(places: u32) {
    let gpu = kit::gpu();
    let mut words = Words(4);
    let (mut looked_at, mut ground) = (0, 0);
    let kinds = [
        (Refinement::Triangles, Roughness::Quarter),
        (Refinement::Triangles, Roughness::Half),
        (Refinement::Bilinear, Roughness::Quarter),
    ];
    for (seed, (refinement, roughness)) in (0..).zip(kinds) {
        let surface = Surface { seed, refinement, roughness };
        let mut renderer = Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap();
        for index in 0..places {
            let level = (words.word() % 60) as u32;
            // At random places rough surfaces are cliffs, past which one looks down far.
            let is_steered = index % 2 == 0 || roughness == Roughness::Half;
            let place = if is_steered {
                steered(surface, Depth((u64::from(level) << 16) | (words.word() % 65_536))).place
            } else {
                let height = (1 << 10) + (words.word() >> 53) as i64;
                random_place_above(renderer.spine(), &mut words, level, height)
            };
            let yaw = words.word() as u16;
            let view = |pitch: f64, fov: f64| View {
                place: place.clone(),
                attitude: Attitude { yaw, pitch: turn(pitch), roll: 0 },
                fov: fov.to_radians() as f32,
                level,
            };
            let ahead = renderer.ranges(&view(0.0, 120.0)).unwrap();
            assert_eq!(holes_ahead(&ahead), 0, "seed {seed}, level {level}, steered: {is_steered}");
            // Straight down. In wider views some rays run down cliffs to where the foreground ends.
            let down = renderer.ranges(&view(-90.0, 6.0)).unwrap();
            let holes = down.iter().filter(|range| **range == 0.0).count();
            assert_eq!(holes, 0, "down; seed {seed}, level {level}, steered: {is_steered}");
            looked_at += ahead.len() + down.len();
            ground += ahead.iter().chain(&down).filter(|range| **range > 0.0).count();
        }
    }
    println!("{looked_at} samples, {ground} of the ground");
    assert!(ground > looked_at / 2);
}

#[test]
fn there_are_no_holes() {
    no_holes(8);
}

#[test]
#[ignore = "minutes: make test-long"]
fn there_are_no_holes_at_two_hundred_places() {
    no_holes(70);
}

fn shot(renderer: &mut Renderer, view: &View) -> Picture {
    renderer.render(view).unwrap().picture
}

/// A pool that is almost too small for a view has what that view needs, whatever was seen before.
#[test]
fn a_small_pool_shows_the_same() {
    let gpu = kit::gpu();
    let surface = surface(2);
    let settings = Settings { detail: Detail::new(Detail::LEAST), slots: 1600, ..SETTINGS };
    let new = |settings| Renderer::new(&gpu, surface, settings, &light(), &FILM).unwrap();
    let (mut flown, mut fresh) = (new(settings), new(Settings { slots: 8000, ..settings }));
    for frame in 0..36u64 {
        // Outwards, looking past the corner of the foreground.
        let attitude = Attitude { yaw: turn(45.0), pitch: turn(-5.0), roll: 0 };
        let view = View { attitude, fov: 1.9, ..steered(surface, Depth((280 - frame) << 14)) };
        let picture = shot(&mut flown, &view);
        if frame % 5 == 0 {
            fresh.clear();
            assert!(shot(&mut fresh, &view) == picture, "frame {frame}");
        }
    }
}

#[test]
fn the_same_view_is_the_same_picture() {
    let gpu = kit::gpu();
    let surface = surface(5);
    let views = [0, 7 << 16, 30 << 15, 500 << 16, 501 << 16].map(|depth| steered(surface, Depth(depth)));
    let mut renderer = Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap();
    let first: Vec<Picture> = views.iter().map(|view| shot(&mut renderer, view)).collect();
    // The way back, then from nothing, then each by one that has drawn nothing else.
    for (view, picture) in views.iter().zip(&first).rev() {
        assert!(shot(&mut renderer, view) == *picture);
    }
    for (view, picture) in views.iter().zip(&first) {
        renderer.clear();
        assert!(shot(&mut renderer, view) == *picture);
        assert!(
            shot(&mut Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap(), view) == *picture
        );
    }
    // And in small parts.
    let mut interrupted = Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap();
    interrupted.share_the_device();
    assert!(shot(&mut interrupted, &views[3]) == first[3]);
    // They show something, and something else each.
    for (index, picture) in first.iter().enumerate() {
        let bytes = picture.developed(ToneMap::Filmic);
        let distinct = bytes.iter().collect::<std::collections::HashSet<_>>().len();
        assert!(distinct > 50, "view {index}: {distinct} values");
        assert!(first[..index].iter().all(|other| other != picture));
    }
}

/// Two places that differ by nothing that could be seen, in one of which a tile is split that the other shows whole.
fn places_at_a_split(renderer: &mut Renderer, start: &View, depth: u32) -> Option<[View; 2]> {
    const DIGITS: u32 = 40;
    let raised = |amount: i64| {
        let mut view = start.clone();
        view.place.y.add(amount, depth + DIGITS);
        view
    };
    let mut leaves = |amount: i64| {
        let leaves = renderer.select(&raised(amount)).unwrap().tree.leaves();
        leaves.into_iter().map(|leaf| leaf.cell).collect::<Vec<_>>()
    };
    let (mut low, mut high) = (0, 1i64 << (DIGITS - 3));
    let first = leaves(low);
    if first == leaves(high) {
        return None;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if leaves(middle) == first { low = middle } else { high = middle }
    }
    Some([raised(low), raised(high)])
}

/// A tile that one of two places shows and the other splits, so looked at from both that it is in the middle of the picture.
fn look_at_the_split(renderer: &mut Renderer, views: &mut [View; 2]) {
    let mut tree = |index: usize| renderer.select(&views[index]).unwrap().tree;
    let trees = [tree(0), tree(1)];
    let cells = [0, 1]
        .map(|index: usize| trees[index].leaves().into_iter().map(|leaf| leaf.cell).collect::<Vec<_>>());
    let only = |one: usize| trees[one].leaves().into_iter().find(|leaf| !cells[1 - one].contains(&leaf.cell));
    let [from, to] = [only(0), only(1)].map(|leaf| leaf.expect("they differ"));
    let leaf = if from.cell.level < to.cell.level { from } else { to };
    let eye = trees[0].eye(leaf.cell.level).expect("a level of the tree");
    let [low, high] = eye.bounds(leaf.cell.x, leaf.cell.z, leaf.corners).map(DVec3::from_array);
    let middle = 0.5 * (low + high);
    let attitude = Attitude {
        yaw: turn(middle.x.atan2(-middle.z).to_degrees()),
        pitch: turn((middle.y / middle.length()).asin().to_degrees()),
        roll: 0,
    };
    views.iter_mut().for_each(|view| view.attitude = attitude);
}

/// A tile begins as its parent's surface ends. Devices round where a vertex is seen to a part of a pixel, so the outline of a ridge may lose or win a
/// pixel when its edges are cut in two; nothing else changes.
#[test]
fn nothing_pops_when_a_tile_is_split() {
    let gpu = kit::gpu();
    let (mut splits, mut outlines, mut changed) = (0, 0, 0);
    for seed in 0..4 {
        let surface = surface(seed);
        let mut renderer = Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap();
        for depth in [3, 9, 33, 70, 200] {
            let start = steered(surface, Depth::level(depth));
            let Some(mut views) = places_at_a_split(&mut renderer, &start, depth) else { continue };
            look_at_the_split(&mut renderer, &mut views);
            splits += 1;
            let pictures = [0, 1].map(|index: usize| shot(&mut renderer, &views[index]));
            changed +=
                pictures[0].pixels.iter().zip(&pictures[1].pixels).filter(|(from, to)| from != to).count();
            let mut ranges = |index: usize| renderer.ranges(&views[index]).unwrap();
            let ranges = [ranges(0), ranges(1)];
            let [from, to] = [0, 1].map(|index: usize| pictures[index].developed(ToneMap::Filmic));
            let pixels = from.as_chunks::<3>().0.iter().zip(to.as_chunks::<3>().0);
            for (at, (from, to)) in pixels.enumerate() {
                let worst = (0..3).map(|channel| from[channel].abs_diff(to[channel])).max().unwrap();
                if (ranges[1][at] / ranges[0][at] - 1.0).abs() > 1e-3 {
                    outlines += 1;
                } else {
                    assert!(worst <= 1, "seed {seed}, depth {depth}, pixel {at}: {worst}");
                }
            }
        }
    }
    println!("{splits} splits, {changed} pixels not the same bits, {outlines} of outlines not the same");
    assert!(splits > 8 && changed > 0);
    assert!(outlines < splits);
}

/// Pixels that are not the same in two pictures.
fn changed(one: &Picture, other: &Picture) -> usize {
    one.pixels.iter().zip(&other.pixels).filter(|(one, other)| one != other).count()
}

#[test]
fn marks_are_seen_and_leave_no_trace() {
    let gpu = kit::gpu();
    let surface = surface(5);
    let none = Marks::default();
    for depth in [3, 100] {
        let steered = steered(surface, Depth::level(depth));
        // Straight ahead there is ground far away.
        let view = View { attitude: Attitude { pitch: 0, ..steered.attitude }, ..steered };
        let mut renderer = Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap();
        let bare = shot(&mut renderer, &view);
        let ground = renderer.ranges(&view).unwrap().iter().filter(|range| **range > 0.0).count();
        let mut with = |marks: Marks| {
            renderer.mark(marks).unwrap();
            changed(&bare, &shot(&mut renderer, &view))
        };
        // All of the ground, and nothing else.
        assert_eq!(with(Marks { levels: true, ..none }), ground, "depth {depth}");
        let borders = with(Marks { borders: true, ..none });
        let edges = with(Marks { wireframe: true, ..none });
        // Triangles are hardly larger than pixels of so small a picture.
        assert!(
            ground / 50 < borders && borders < edges && edges <= ground,
            "{borders}, {edges} of {ground}"
        );
        for marks in [Marks { boxes: true, ..none }, Marks { corners: true, ..none }] {
            let lines = with(marks);
            assert!(50 < lines && lines < bare.pixels.len() * 3 / 4, "depth {depth}, {marks:?}: {lines}");
        }
        let sky = with(Marks { no_background: true, ..none });
        assert!(sky <= bare.pixels.len() - ground, "depth {depth}: {sky}");
        assert_eq!(sky > 0, depth == 100, "there is a background at depth 100 only: {sky}");
        assert_eq!(with(none), 0, "depth {depth}");
    }
}

#[test]
fn frozen_tiles_stay() {
    let gpu = kit::gpu();
    let surface = surface(5);
    let view = |depth: u64| steered(surface, Depth(depth << 15));
    let [here, there] = [view(60), view(63)];
    let mut renderer = Renderer::new(&gpu, surface, SETTINGS, &light(), &FILM).unwrap();
    let usual = [&here, &there].map(|view| renderer.render(view).unwrap());
    renderer.freeze(Some(&here)).unwrap();
    let frozen = [&here, &there].map(|view| renderer.render(view).unwrap());
    assert!(frozen[0].picture == usual[0].picture);
    assert_ne!(usual[1].levels, usual[0].levels);
    assert_eq!(frozen[1].levels, usual[0].levels);
    assert_eq!(frozen[1].leaves, usual[0].leaves);
    assert_eq!(frozen[1].altitude, usual[1].altitude);
    assert!(frozen[1].picture != usual[1].picture);
    // So far away, there are no digits to tell where they are.
    for far in [view(10), view(200)] {
        assert!(renderer.render(&far).is_err());
    }
    renderer.freeze(None).unwrap();
    assert!(shot(&mut renderer, &there) == usual[1].picture);
}

/// Pictures of a way in, then of the way back, by a renderer that looks ahead and now and then forgets all it has.
fn in_and_out(seed: u32, first: u32, levels: u32, octaves: u32) {
    let film = Film { width: 64, height: 36, ..FILM };
    let surface = surface(seed);
    let settings = Settings { octaves, layers: Some(background::layers(octaves)), face: 64, ..SETTINGS };
    let gpu = kit::gpu();
    let mut renderer = Renderer::new(&gpu, surface, settings, &light(), &film).unwrap();
    let mut autopilot = Autopilot::new(surface);
    let last = 2 * levels - 1;
    let mut view = |spine: &mut Spine, frame: u32| {
        let level = first + frame.min(last - frame);
        // Not the whole levels, where much is simple.
        let depth = Depth(u64::from(level) << 16 | 23_456);
        let pose = autopilot.at(spine, depth);
        View { place: pose.place, attitude: pose.attitude, fov: 1.2, level: depth.whole() }
    };
    let mut ahead = Ahead::default();
    let mut hashes = Vec::new();
    for frame in 0..=last {
        let here = view(renderer.spine(), frame);
        let picture = renderer.render(&here).unwrap().picture;
        let bytes: Vec<u8> = picture.pixels.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        hashes.push(Sha256::digest(bytes));
        ahead
            .look(&mut renderer, frame..last + 1, 7, |spine, frame| Ok::<_, view::Error>(view(spine, frame)))
            .unwrap();
        if frame % 50 == 49 {
            renderer.clear();
        }
    }
    let all = hashes.len();
    for (frame, hash) in hashes.iter().enumerate() {
        assert_eq!(*hash, hashes[all - 1 - frame], "seed {seed}, frame {frame}");
    }
    let distinct: std::collections::HashSet<_> = hashes.iter().collect();
    assert_eq!(distinct.len(), levels as usize);
}

#[test]
fn the_way_out_shows_what_the_way_in_did() {
    in_and_out(11, 0, 26, 30);
    in_and_out(12, 300, 10, 64);
}

#[test]
#[ignore = "minutes: make test-long"]
fn the_way_out_of_six_hundred_levels_shows_what_the_way_in_did() {
    for (seed, octaves) in [(1, 64), (2, 30), (3, 16)] {
        in_and_out(seed, 0, 600, octaves);
    }
}
