//! What is far away in a zoom: pictures from canonical eyes, in place of tiles.

use crate::kit;
use crate::kit::zoom::{light, surface};
use glam::DVec3;
use std::collections::HashSet;
use terrane::{
    core::camera::direction,
    gpu::Gpu,
    scene::{Film, Light, Picture, Sky, Sun, ToneMap},
    sky::preetham,
    zoom::{
        address::{Attitude, Place},
        background::{self, Band},
        height::{Spine, Surface},
        motion::{Autopilot, Depth, clearance},
        tree::Detail,
        view::{Renderer, Settings, View},
    },
};

const FILM: Film = Film { width: 160, height: 90, exposure: 1.0 / 20_000.0, tone_map: ToneMap::Filmic };

/// N = 16, c = 32.
const SETTINGS: Settings = Settings {
    bits: 4,
    detail: Detail::COMMON,
    octaves: 64,
    clear: 0.5,
    layers: Some(7),
    face: 192,
    slots: 8000,
    samples: 1,
};

fn steered(surface: Surface, depth: Depth) -> View {
    let pose = Autopilot::new(surface).at(&mut Spine::new(surface), depth);
    let attitude = Attitude { pitch: 0, ..pose.attitude };
    View { place: pose.place, attitude, fov: 1.0, level: depth.whole() }
}

/// A low sun 60° wide, and a view that looks at it over the horizon: whatever is behind the haze would be seen before its disc.
fn at_sunset(view: View) -> (Light, View) {
    const AZIMUTH: f32 = 2.0;
    let toward = direction(AZIMUTH, 0.2);
    let sun = Sun { direction: toward, irradiance: [9800.0, 9200.0, 8000.0], diameter: 1.047 };
    let light = Light { sky: preetham::sky(2.6, toward.as_dvec3()), sun: Some(sun), air: None, clouds: 0.0 };
    let yaw = (AZIMUTH / std::f32::consts::TAU * 65_536.0) as u16;
    (light, View { attitude: Attitude { yaw, pitch: 0, roll: 0 }, ..view })
}

fn renderer(gpu: &Gpu, settings: Settings, light: &Light, seed: u32) -> Renderer {
    Renderer::new(gpu, surface(seed), settings, light, &FILM).unwrap()
}

fn shot(renderer: &mut Renderer, view: &View) -> Picture {
    renderer.render(view).unwrap().picture
}

/// A layer serves all places in a cell around the eye that it is taken from. At worst ground that it shows, which is at least as far as the foreground
/// reaches, is seen √3 / 2 · 2⁻¹² radians from where it should: 0.26 pixels of 1440 rows in 60°.
#[test]
fn layers_are_seen_where_they_are() {
    const PIXEL: f64 = 8.0e-4;
    let mut worst: f64 = 0.0;
    let mut eyes = HashSet::new();
    for (seed, level) in (0..).zip([14, 21, 40, 77, 300, 1001]) {
        let surface = surface(seed);
        let mut spine = Spine::new(surface);
        let View { place, .. } = steered(surface, Depth::level(level));
        let altitude = clearance(&mut spine, &place, level).unwrap().distance;
        for layer in (1..=background::nearest(altitude)).rev().take(3) {
            let root = background::root(layer);
            let band = Band::new(&mut spine, &place, layer, Detail::COMMON, 8000).unwrap();
            eyes.insert(band.eye.clone());
            // The place is in the cell whose middle the eye is.
            let grid = root + 11;
            let cells =
                |eye: &terrane::zoom::address::Fixed, place: &terrane::zoom::address::Fixed, level: u32| {
                    eye.at(level + 20).to(place.slice(level + 20)) / f64::from(1 << 20)
                };
            let halvings = surface.roughness.halvings();
            let Place { x, y, z } = &band.eye;
            let away =
                [cells(x, &place.x, grid), cells(y, &place.y, grid - halvings), cells(z, &place.z, grid)];
            assert!(away.iter().all(|away| away.abs() <= 0.5 + 1e-5), "{away:?}");
            for leaf in &band.leaves {
                let eye = band.tree.eye(leaf.cell.level).unwrap();
                // Cells of the leaf in one of the roots', and in half of one of the grid's.
                let scale = libm::exp2(f64::from(leaf.cell.level) - f64::from(root));
                let half = libm::exp2(f64::from(leaf.cell.level) - f64::from(grid) - 1.0);
                for (corner, height) in (0..).zip(leaf.corners.0) {
                    let [x, z] = [leaf.cell.x.wrapping_add(corner % 2), leaf.cell.z.wrapping_add(corner / 2)];
                    let seen = DVec3::from_array(eye.to(x, height, z));
                    // The foreground reaches two cells of its roots beyond the place's own.
                    if seen.x.abs().max(seen.z.abs()) < 2.0 * scale {
                        continue;
                    }
                    for sign in 0..8 {
                        let side = |axis: u32| if sign >> axis & 1 == 1 { half } else { -half };
                        let own = seen - DVec3::new(side(0), side(1), side(2));
                        worst = worst.max(seen.angle_between(own));
                    }
                }
            }
        }
    }
    println!("{:.3} pixels at worst; {} eyes", worst / PIXEL, eyes.len());
    assert!(worst < 0.2655 * PIXEL && worst > 0.1 * PIXEL);
    assert!(eyes.len() > 10);
}

/// What a layer leaves out lies under what is nearer, half a cell of its roots inside at least: from wherever the layer's eye serves.
#[test]
fn layers_overlap() {
    let mut least = f64::INFINITY;
    let mut left_out = 0;
    for (seed, level) in (0..).zip([14, 21, 22, 40, 77, 300, 1001]) {
        for part in 0..4 {
            let surface = surface(seed);
            let mut spine = Spine::new(surface);
            let View { place, .. } = steered(surface, Depth(u64::from(level) << 16 | part << 14));
            let altitude = clearance(&mut spine, &place, level).unwrap().distance;
            // What lies over a layer is seen from here: from the place itself over the nearest.
            let mut over = place.clone();
            for layer in (1..=background::nearest(altitude)).rev().take(4) {
                let roots = background::roots(&mut spine, &over, layer, Detail::COMMON);
                let band = Band::new(&mut spine, &place, layer, Detail::COMMON, 8000).unwrap();
                let drawn: HashSet<_> = band.leaves.iter().map(|leaf| leaf.cell).collect();
                for leaf in band.tree.leaves().iter().filter(|leaf| !drawn.contains(&leaf.cell)) {
                    let finer = leaf.cell.level - roots.level();
                    let [from, to] = [0, roots.size as u64 - 1].map(|step| {
                        [roots.first.x, roots.first.z].map(|first| first.wrapping_add(step) << finer)
                    });
                    let cells = |number: u64| number as i64 as f64 / f64::from(1u32 << finer);
                    for (axis, at) in [leaf.cell.x, leaf.cell.z].into_iter().enumerate() {
                        least = least.min(cells(at.wrapping_sub(from[axis])));
                        least = least.min(cells(to[axis].wrapping_sub(at).wrapping_sub(1)));
                    }
                    left_out += 1;
                }
                over = band.eye;
            }
        }
    }
    println!("{left_out} leaves left out, {least} cells inside at least");
    assert!(left_out > 500 && least >= 0.5);
}

/// Where whole numbers have the digits for it, a picture without layers is what one with layers should be.
#[test]
fn a_background_is_what_tiles_would_show() {
    let gpu = kit::gpu();
    let light = light();
    let octaves = 40;
    let layered =
        Settings { octaves, clear: 0.3, layers: Some(background::layers(octaves)), face: 640, ..SETTINGS };
    let mut differ = 0;
    for (seed, depth) in [(1, 23), (2, 24), (3, 29), (4, 30)] {
        let [mut tiles, mut behind] = [Settings { layers: None, ..layered }, layered]
            .map(|settings| renderer(&gpu, settings, &light, seed));
        // All around.
        for quarter in 0..4u16 {
            let mut view = steered(surface(seed), Depth::level(depth));
            view.attitude.yaw = view.attitude.yaw.wrapping_add(quarter << 14);
            // As they are developed: outlines are not as sharp in a background, that is all.
            let [expected, found] =
                [&mut tiles, &mut behind].map(|renderer| shot(renderer, &view).developed(ToneMap::Filmic));
            let apart: Vec<u8> = expected.iter().zip(&found).map(|(a, b)| a.abs_diff(*b)).collect();
            let far = apart.iter().filter(|apart| **apart > 24).count();
            let mean = apart.iter().map(|apart| f64::from(*apart)).sum::<f64>() / apart.len() as f64;
            println!(
                "depth {depth}, to {}°: mean {mean:.3}, {far} of {} far apart",
                90 * quarter,
                apart.len()
            );
            assert!(mean < 0.1 && far < apart.len() / 1000);
            differ += usize::from(mean > 0.0);
        }
    }
    // Backgrounds are seen.
    assert!(differ > 4);
}

/// Haze hides whatever is below the last layer that counts.
#[test]
fn more_layers_do_not_show() {
    let gpu = kit::gpu();
    let mut seen = 0;
    for (seed, octaves) in [(4, 64), (5, 30), (6, 64), (7, 64)] {
        let layers = background::layers(octaves);
        let settings = Settings { octaves, layers: Some(layers), ..SETTINGS };
        let (light, view) = at_sunset(steered(surface(seed), Depth(150 << 16 | 17_000)));
        let enough = shot(&mut renderer(&gpu, settings, &light, seed), &view);
        let more = Settings { layers: Some(2 * layers + 2), ..settings };
        assert!(shot(&mut renderer(&gpu, more, &light, seed), &view) == enough);
        let less = Settings { layers: Some(1), ..settings };
        seen += usize::from(shot(&mut renderer(&gpu, less, &light, seed), &view) != enough);
    }
    // Those beyond the first do.
    assert!(seen > 0);
}

/// A background is the same whether it is made at once, a few tiles at a time, or over one that was there.
#[test]
fn how_a_background_was_made_does_not_show() {
    let gpu = kit::gpu();
    let at = |depth: u64| at_sunset(steered(surface(6), Depth(depth << 12))).1;
    let last = at(80 * 16);
    let (light, _) = at_sunset(last.clone());
    // Few layers, so that some are below those that count.
    const SETTINGS: Settings = Settings { octaves: 22, layers: Some(2), ..self::SETTINGS };
    let expected = shot(&mut renderer(&gpu, SETTINGS, &light, 6), &last);
    for calls in [8, 60] {
        let mut sliced = renderer(&gpu, SETTINGS, &light, 6);
        let mut made = 0;
        while !sliced.prepare(&last, calls).unwrap() {
            sliced.work().unwrap();
            made += 1;
            assert!(made <= 2 * calls + 10, "{calls} calls");
        }
        assert!(made >= calls / 2);
        assert!(shot(&mut sliced, &last) == expected, "{calls} calls");
    }
    // On the way, with views prepared that lie ahead, and with what is kept thrown away now and then.
    let mut flown = renderer(&gpu, SETTINGS, &light, 6);
    let way = 60 * 16..=80 * 16;
    for depth in way.clone().step_by(4) {
        flown.prepare(&at((depth + 32).min(*way.end())), 8).unwrap();
        flown.work().unwrap();
        let picture = shot(&mut flown, &at(depth));
        if depth == *way.end() {
            assert!(picture == expected);
        }
        if depth % 100 == 0 {
            flown.clear();
        }
    }
}

/// With ground that the sun makes green and a sky that has none of it, nothing of the sky shows below the first ground of a column of a picture that looks
/// straight ahead: neither between layers nor between the faces of one.
#[test]
fn nothing_shows_between_layers() {
    let gpu = kit::gpu();
    let above = direction(0.0, 1.45);
    let sun = Sun { direction: above, irradiance: [0.0, 90_000.0, 0.0], diameter: 0.0093 };
    let light = Light {
        sky: Sky::Constant { radiance: [5000.0, 0.0, 5000.0] },
        sun: Some(sun),
        air: None,
        clouds: 0.0,
    };
    let (mut columns, mut ground) = (0, 0);
    for seed in 0..8 {
        // No haze.
        let settings = Settings { octaves: 1000, layers: Some(20), ..SETTINGS };
        let mut renderer = renderer(&gpu, settings, &light, seed);
        for depth in [15u64, 20, 22, 29, 60] {
            let view = steered(surface(seed), Depth(depth << 16 | u64::from(seed) << 12));
            let view = View { fov: 2.0, ..view };
            let picture = shot(&mut renderer, &view);
            let width = FILM.width as usize;
            for column in 0..width {
                let green =
                    picture.pixels.iter().skip(column).step_by(width).map(|[_, green, ..]| *green > 0.0);
                let hole = green.skip_while(|green| !green).position(|green| !green);
                assert_eq!(hole, None, "seed {seed}, depth {depth}, column {column}");
                columns += 1;
            }
            ground += picture.pixels.iter().filter(|[_, green, ..]| *green > 0.0).count();
        }
    }
    assert!(ground > columns * FILM.height as usize / 4);
}
