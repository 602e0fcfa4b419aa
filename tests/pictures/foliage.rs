//! What stands on the ground, as it is drawn: shadows, leaves and canopies against closed forms, materials against the noise's
//! reference, and pictures that must not depend on how they are made.

use crate::kit;
use crate::kit::{forest, stage};
use glam::{Quat, Vec3};
use serde::Deserialize;
use std::f64::consts::PI;
use std::sync::Arc;
use terrane::core::grid::Grid;
use terrane::core::hash::mix;
use terrane::core::memory;
use terrane::core::mesh::Mesh;
use terrane::gpu::{Gpu, Options};
use terrane::plants::derive::Limits;
use terrane::raster::{self, Quality, Renderer};
use terrane::scene::{
    ByHeight, Camera, Film, Instance, Level, Material, Mixture, Model, Part, Picture, Scene, Sky, Sun,
    ToneMap, View,
};
use terrane::sky::sun;

const ALBEDO: f32 = 0.4;
const ONE_SAMPLE: Quality = Quality { samples: 1, tile: 512 };

/// Level ground of one grey at this height, seen straight from above, and nothing else: no sea, no light.
fn plain(gpu: &Gpu, extent: f32, height: f32) -> Scene {
    let grid = Grid { cells: 65, extent };
    let mut scene = stage::on(stage::empty(gpu), gpu, grid, &vec![height; grid.samples()]);
    scene.surface.by_height = stage::one_colour(ALBEDO);
    scene
}

fn film(width: u32, height: u32) -> Film {
    Film { width, height, exposure: 1.0, tone_map: ToneMap::None }
}

fn look(position: Vec3, target: Vec3, fov: f32) -> Camera {
    Camera { view: View::LookAt { position, target, roll: 0.0 }, fov }
}

fn render(gpu: &Gpu, scene: &Scene, width: u32, height: u32, quality: Quality) -> Picture {
    kit::renderer(gpu).render(scene, &film(width, height), quality).expect("a picture")
}

fn middle(picture: &Picture) -> [f32; 3] {
    picture.pixels[((picture.height / 2) * picture.width + picture.width / 2) as usize]
}

/// Azimuth in degrees clockwise from north, elevation in radians.
fn sun_at(azimuth: f64, elevation: f64, irradiance: f32) -> Sun {
    let position = sun::Position { zenith: PI / 2.0 - elevation, azimuth: azimuth.to_radians() };
    let direction = position.direction().as_vec3();
    Sun { direction, irradiance: [irradiance; 3], diameter: sun::DIAMETER as f32 }
}

#[track_caller]
fn assert_close(found: f32, expected: f64, tolerance: f64) {
    let difference = (f64::from(found) - expected).abs();
    assert!(difference <= tolerance * expected.abs(), "{found}, expected {expected}");
}

fn matt(name: &str, reflectance: f32) -> Material {
    Material { name: name.into(), reflectance: [[reflectance; 3]; 2], ..Material::default() }
}

/// A box whose foot is in the middle, closed.
fn block(size: Vec3) -> Model {
    let mut mesh = Mesh::default();
    let half = Vec3::new(0.5, 0.5, 0.5) * size;
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            let (mut u, mut v) = (Vec3::ZERO, Vec3::ZERO);
            u[(axis + 1) % 3] = half[(axis + 1) % 3];
            v[(axis + 2) % 3] = sign * half[(axis + 2) % 3];
            let first = mesh.positions.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let corner = normal * half + a * u + b * v + Vec3::Y * half.y;
                mesh.positions.push(corner.to_array());
                mesh.normals.push(normal.to_array());
                mesh.uvs.push([0.0; 2]);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    let parts = vec![Part { material: 0, mesh }];
    Model {
        name: "box".into(),
        materials: vec![matt("box", 0.5)],
        levels: vec![Level { detail: 0.0, parts }],
    }
}

/// A square of one metre that faces upwards, in a model so large that the square takes nothing from its own light.
fn tablet(material: Material) -> Model {
    let mut mesh = Mesh::default();
    forest::quad(&mut mesh, Vec3::ZERO, Vec3::Y, Vec3::X, 1.0);
    // Its other end.
    forest::quad(&mut mesh, 60.0 * Vec3::NEG_Y, Vec3::Y, Vec3::X, 1e-3);
    let parts = vec![Part { material: 0, mesh }];
    Model { name: "tablet".into(), materials: vec![material], levels: vec![Level { detail: 0.0, parts }] }
}

// Shadows ------------------------------------------------------------------------------------------------------------

#[test]
fn shadow_of_a_box_lies_where_it_must() {
    let gpu = kit::gpu();
    let size = Vec3::new(2.0, 3.0, 4.0);
    for (azimuth, elevation, eye) in
        [(270.0, 0.6f64, 40.0f32), (270.0, 1.1, 400.0), (90.0, 0.35, 40.0), (180.0, 0.8, 90.0)]
    {
        let mut scene = plain(&gpu, 200.0, 0.0);
        scene.light.sun = Some(sun_at(azimuth, elevation, 100_000.0));
        scene.population = forest::standing(block(size), [Vec3::ZERO]);
        // From above: north is up.
        let (pixels, span) = (401u32, 24.0f32);
        let fov = 2.0 * (span / 2.0 / eye).atan();
        scene.camera = look(Vec3::new(0.0, eye, 0.0), Vec3::ZERO, fov);
        let picture = render(&gpu, &scene, pixels, pixels, ONE_SAMPLE);
        // The shadow of its top's far edge: as long as the box is high by the tangent of the sun's elevation.
        let length = f64::from(size.y) / elevation.tan();
        let away = [azimuth.to_radians().sin(), -azimuth.to_radians().cos()].map(|part: f64| -part);
        let along_x = away[0].abs() > 0.5;
        let half = f64::from(if along_x { size.x } else { size.z }) / 2.0;
        let across = f64::from(if along_x { size.z } else { size.x }) / 2.0;
        let lit = f64::from(ALBEDO) / PI * 100_000.0 * elevation.sin();
        let pixel = f64::from(span) / f64::from(pixels);
        // Light at a place given by metres away from the sun, and to the side.
        let light = |along: f64, aside: f64| {
            let [x, z] = if along_x { [along * away[0], aside] } else { [aside, along * away[1]] };
            let at = |metres: f64| ((metres / pixel) + f64::from(pixels) / 2.0).floor() as u32;
            f64::from(picture.pixels[(at(z) * pixels + at(x)) as usize][0]) / lit
        };
        // A texel of the map, a pixel, and half the penumbra of a disc of 0.53 degrees.
        let margin = 3.0 * pixel + 0.0047 * f64::from(size.y) / elevation.sin().powi(2) + 0.06;
        let end = half + length;
        for aside in [-0.8 * across, 0.0, 0.8 * across] {
            for share in [0.05, 0.3, 0.6, 0.9] {
                let along = half + margin + share * (length - 2.0 * margin);
                assert!(
                    light(along, aside) < 0.02,
                    "light {along} m behind the box, {aside} m aside: {elevation}"
                );
            }
            assert!((light(end + margin, aside) - 1.0).abs() < 0.01, "a shadow beyond {end} m: {elevation}");
            assert!((light(-half - margin - 0.3, aside) - 1.0).abs() < 0.01, "a shadow before the box");
        }
        for side in [-1.0, 1.0] {
            let along = half + 0.5 * length;
            assert!(light(along, side * (across - margin)) < 0.02, "light within the shadow's sides");
            assert!((light(along, side * (across + margin)) - 1.0).abs() < 0.01, "a shadow beyond its sides");
        }
    }
}

#[test]
fn a_penumbra_is_as_wide_as_the_sun() {
    // The edge of a roof 8 m above the ground under a sun ten times as wide as ours in the zenith.
    let gpu = kit::gpu();
    let mut scene = plain(&gpu, 200.0, 0.0);
    let diameter = 0.02f32;
    scene.light.sun = Some(Sun { diameter, ..sun_at(270.0, PI / 2.0, 1.0) });
    let mut roof = Mesh::default();
    forest::quad(&mut roof, Vec3::new(-10.0, 3.0, 0.0), Vec3::Y, Vec3::X, 20.0);
    let level = Level { detail: 0.0, parts: vec![Part { material: 0, mesh: roof }] };
    let model = Model { name: "roof".into(), materials: vec![matt("roof", 0.5)], levels: vec![level] };
    scene.population = forest::standing(model, [Vec3::ZERO]);
    // From below the roof, so that its edge is not in the way: the strip of ground east of it.
    scene.camera = look(Vec3::new(2.0, 20.0, 0.0), Vec3::new(0.0, 0.0, 0.0), 0.2);
    let (width, height) = (200, 9);
    let picture = render(&gpu, &scene, width, height, Quality { samples: 4, tile: 512 });
    let lit = f64::from(ALBEDO) / PI;
    let row = &picture.pixels[(height / 2 * width) as usize..][..width as usize];
    let share: Vec<f64> = row.iter().map(|pixel| f64::from(pixel[0]) / lit).collect();
    let least = share.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least < 0.6, "the roof throws a shadow: {least}");
    assert!(share.iter().any(|share| (share - 1.0).abs() < 0.01), "and there is light beside it");
}

// Light --------------------------------------------------------------------------------------------------------------

/// By which factor the colour of one of many differs from the others': brightness by a deviation of 0.10 and hue, from red to
/// blue, by 0.06 in log space, each the sum of two uniform numbers.
fn variation(random: u32) -> [f64; 3] {
    let (brightness, hue) = (mix(random), mix(mix(random)));
    let deviate = |bits: u32| {
        let halves = [bits & 0xffff, bits >> 16].map(|half| f64::from(half) / 65535.0 - 0.5);
        (halves[0] + halves[1]) * 6f64.sqrt()
    };
    [1.0, 0.0, -1.0].map(|red| (0.10 * deviate(brightness) + 0.06 * red * deviate(hue)).exp())
}

#[test]
fn leaves_scatter_and_transmit_by_lambert() {
    let gpu = kit::gpu();
    let elevation = 0.7f64;
    let material = Material { transmittance: [0.11, 0.22, 0.05], ..matt("leaf", 0.3) };
    let mut white = material.clone();
    (white.reflectance, white.transmittance) = ([[0.5; 3]; 2], [0.5; 3]);
    let draw = |material: &Material, eye: f32| {
        let mut scene = plain(&gpu, 400.0, -100.0);
        scene.surface.by_height = stage::one_colour(0.0);
        scene.light.sun = Some(sun_at(200.0, elevation, 1000.0));
        scene.population = forest::standing(tablet(material.clone()), [Vec3::ZERO]);
        scene.camera = look(Vec3::new(0.0, eye, 0.0), Vec3::ZERO, 0.1);
        middle(&render(&gpu, &scene, 33, 33, ONE_SAMPLE))
    };
    let cosine = elevation.sin();
    let varied = variation(0);
    for (eye, share) in [(3.0, [0.3; 3]), (-3.0, material.transmittance)] {
        let (found, white) = (draw(&material, eye), draw(&white, eye));
        for channel in 0..3 {
            assert_close(found[channel] / white[channel], f64::from(share[channel]) / 0.5, 1e-3);
            assert_close(white[channel], varied[channel] * 0.5 / PI * 1000.0 * cosine, 2e-3);
        }
    }
}

#[derive(Deserialize)]
struct Reference {
    perlin: PerlinReference,
}

#[derive(Deserialize)]
struct PerlinReference {
    values: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    p: [f64; 3],
    improved_2002: f64,
}

#[test]
fn colours_follow_the_noise() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/terrain_noise_reference.json");
    let text = std::fs::read_to_string(path).expect("the reference");
    let reference: Reference = serde_json::from_str(&text).expect("as it should be");
    let gpu = kit::gpu();
    let renderer = kit::renderer(&gpu);
    let draw = |material: Material, at: Vec3| {
        let mut scene = plain(&gpu, 4000.0, -500.0);
        scene.light.sky = Sky::Constant { radiance: [1.0; 3] };
        scene.population = forest::standing(tablet(material), [at]);
        scene.camera = look(at + 2.0 * Vec3::Y, at, 0.01);
        middle(&renderer.render(&scene, &film(3, 3), ONE_SAMPLE).expect("a picture"))
    };
    let (from, to) = ([0.1f32, 0.2, 0.3], [0.4f32, 0.1, 0.05]);
    let mut shares = Vec::new();
    for (position_factor, value_factor) in [(1.0f32, 1.0f32), (1.0, 1.7), (3.0, 0.6)] {
        for sample in &reference.perlin.values {
            let at = (glam::DVec3::from(sample.p) / f64::from(position_factor)).as_vec3();
            let mut material = Material { reflectance: [from, to], ..matt("noise", 0.0) };
            (material.position_factor, material.value_factor) = (position_factor, value_factor);
            let found = draw(material, at);
            let white = draw(matt("white", 0.5), at);
            let share = ((0.5 * sample.improved_2002 + 0.5) * f64::from(value_factor)).clamp(0.0, 1.0);
            shares.push(share);
            for channel in 0..3 {
                let [from, to] = [from, to].map(|colour| f64::from(colour[channel]));
                // Where the place is rounded to 32 bits, far from the origin, the noise moves by 1e-5.
                assert_close(found[channel] / white[channel], (from + (to - from) * share) / 0.5, 2e-3);
            }
        }
    }
    shares.sort_by(f64::total_cmp);
    assert!(shares[0] < 0.3 && shares[shares.len() - 1] == 1.0, "small and clamped ones are among them");
}

#[test]
fn ground_mixes_two_materials_by_height() {
    let gpu = kit::gpu();
    let tint = |from: f32, to: f32| Mixture {
        reflectance: [from; 3],
        second_reflectance: [to; 3],
        // The noise is 0 at the origin, where the picture's middle lies: ½ of 0…1.
        position_factor: 1e-3,
        value_factor: 1.0,
    };
    let (low, high) = (tint(0.1, 0.2), tint(0.4, 0.8));
    for (height, expected) in
        [(0.0, 0.15), (10.0, 0.15), (14.0, 0.6 * 0.15 + 0.4 * 0.6), (20.0, 0.6), (90.0, 0.6)]
    {
        let mut scene = plain(&gpu, 200.0, height);
        scene.surface.by_height =
            Some(ByHeight { ground: low, rock: high, rock_start: 10.0, ground_end: 20.0 });
        scene.light.sky = Sky::Constant { radiance: [1.0; 3] };
        scene.camera = look(Vec3::new(0.0, height + 10.0, 0.0), Vec3::new(0.0, height, 0.0), 0.1);
        let found = middle(&render(&gpu, &scene, 9, 9, ONE_SAMPLE))[1];
        // At a height that is no multiple of 1000 m the noise is not quite 0.
        assert_close(found, expected, 0.06);
    }
}

#[test]
fn light_under_a_canopy_falls_off_with_its_leaves() {
    // Monsi & Saeki 1953: leaves that face every way hide half of their area from a ray, and more from slanting ones.
    let gpu = kit::gpu();
    let radiance = 1000.0;
    let mut last = f64::INFINITY;
    for count in [0, 1, 3, 6] {
        let mut scene = plain(&gpu, 300.0, 0.0);
        scene.light.sky = Sky::Constant { radiance: [radiance; 3] };
        // Nothing of a leaf is in the way of the eye, which is below them all.
        let mut mesh = Mesh::default();
        forest::quad(&mut mesh, 20.0 * Vec3::Y, Vec3::Y, Vec3::X, 4.0);
        let parts = vec![Part { material: 0, mesh }];
        let model = Model {
            name: "leaf".into(),
            materials: vec![forest::leaf()],
            levels: vec![Level { detail: 0.0, parts }],
        };
        let places = (0..count * 75 * 75).map(|index| {
            let at = index / count;
            Vec3::new((at % 75) as f32 * 4.0 - 148.0, 0.0, (at / 75) as f32 * 4.0 - 148.0)
        });
        scene.population = forest::standing(model, places);
        scene.camera = look(Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 0.0), 0.1);
        let found = f64::from(middle(&render(&gpu, &scene, 9, 9, ONE_SAMPLE))[0]);
        let through = found / f64::from(ALBEDO * radiance);
        // ½ of the area along the mean path of light from a dome, between that from the zenith and that from 60 degrees.
        let index = f64::from(count);
        let bounds = [(-0.5 * index * 2.0).exp(), (-0.5 * index).exp()];
        assert!(through >= 0.99 * bounds[0] && through <= 1.01 * bounds[1], "{through}, {bounds:?}");
        assert!(through < last, "more leaves, less light");
        last = through;
    }
}

// Whatever way it is made --------------------------------------------------------------------------------------------

/// A stand of trees and tufts on a slope in the afternoon's sun.
fn grove(gpu: &Gpu) -> Scene {
    let mut scene = plain(gpu, 120.0, 0.0);
    scene.population = forest::forest(40, 60.0, |_, _| 0.0);
    scene.light.sky = Sky::Constant { radiance: [4000.0, 5000.0, 7000.0] };
    scene.light.sun = Some(sun_at(240.0, 0.6, 90_000.0));
    scene.camera = look(Vec3::new(0.0, 3.0, 42.0), Vec3::new(0.0, 4.0, 0.0), 0.9);
    scene
}

#[test]
fn tiles_make_the_same_picture() {
    let gpu = kit::gpu();
    let scene = grove(&gpu);
    let draw = |tile| render(&gpu, &scene, 200, 120, Quality { samples: 2, tile });
    let (whole, tiled) = (draw(512), draw(56));
    let brightest = whole.pixels.iter().flatten().copied().fold(0.0, f32::max);
    let differs = |(one, other): (&[f32; 3], &[f32; 3])| {
        (0..3).any(|channel| (one[channel] - other[channel]).abs() > 0.01 * brightest)
    };
    let different = whole.pixels.iter().zip(&tiled.pixels).filter(|pair| differs(*pair)).count();
    // A tile rounds its vertices by itself: a leaf's edge may move by a hair.
    assert!(different <= whole.pixels.len() / 100, "{different} pixels differ");
}

#[test]
fn two_runs_are_the_same_bits() {
    let gpu = kit::gpu();
    let scene = grove(&gpu);
    let draw = || render(&gpu, &scene, 160, 90, Quality::default());
    assert_eq!(draw(), draw());
}

#[test]
fn whoever_is_out_of_sight_changes_nothing() {
    let gpu = kit::gpu();
    let scene = grove(&gpu);
    let few = render(&gpu, &scene, 160, 90, ONE_SAMPLE);
    // Far behind the eye and away from the sun, where neither they nor their shadows are seen.
    let mut crowded = scene.clone();
    let behind = (0..200).map(|index| Instance {
        model: index % 8,
        random: index,
        position: Vec3::new(30.0 + (index % 14) as f32, 0.0, 118.0 + (index / 14) as f32),
        rotation: Quat::IDENTITY,
        scale: 1.0,
    });
    crowded.population.instances = scene.population.instances.iter().copied().chain(behind).collect();
    assert_eq!(few, render(&gpu, &crowded, 160, 90, ONE_SAMPLE));
    // The test sees them where they are in sight.
    crowded.camera = look(Vec3::new(0.0, 3.0, 42.0), Vec3::new(30.0, 4.0, 120.0), 0.9);
    let mut alone = scene.clone();
    alone.camera = crowded.camera;
    assert_ne!(render(&gpu, &alone, 160, 90, ONE_SAMPLE), render(&gpu, &crowded, 160, 90, ONE_SAMPLE));
}

fn grown(name: &str) -> Model {
    let path = format!("{}/configs/species/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let species = terrane::world::species::load(path.as_ref()).expect("a species").species;
    species.grow(1, 0, &Limits::default()).expect("a plant")
}

#[test]
fn levels_of_detail_look_the_same() {
    const SKY: f32 = 3000.0;
    let gpu = kit::gpu();
    let renderer = kit::renderer(&gpu);
    for name in ["oak", "spruce", "palm", "grass"] {
        let model = grown(name);
        let [least, greatest] = model.bounds();
        let height = greatest.y - least.y;
        // So far away that the plant fills the picture, before the sky: the ground is far below.
        let draw = |index: usize, materials: Vec<Material>| {
            let mut scene = plain(&gpu, 4000.0, -500.0);
            scene.surface.by_height = stage::one_colour(0.0);
            scene.light.sky = Sky::Constant { radiance: [SKY; 3] };
            scene.light.sun = Some(sun_at(230.0, 0.7, 90_000.0));
            let levels = vec![Level { detail: 0.0, ..model.levels[index].clone() }];
            let model = Model { levels, materials, ..model.clone() };
            scene.population = forest::standing(model, [Vec3::ZERO]);
            let target = Vec3::Y * (0.5 * height);
            scene.camera = look(target + Vec3::new(0.0, 0.0, 30.0 * height), target, 0.05);
            let picture =
                renderer.render(&scene, &film(96, 96), Quality { samples: 3, tile: 512 }).expect("a picture");
            let sum: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel[1])).sum();
            sum / picture.pixels.len() as f64
        };
        // How much of the picture the plant covers, seen by what a black one leaves of the sky; and its own light.
        let black = vec![matt("black", 0.0); model.materials.len()];
        let draw = |index: usize| {
            let sky = draw(index, black.clone());
            (draw(index, model.materials.clone()) - sky, 1.0 - sky / f64::from(SKY))
        };
        let (bright, covered) = draw(0);
        for index in 1..model.levels.len() {
            let (light, cover) = draw(index);
            // A tenth that the method loses or gains, and a standard deviation of what few triangles show by chance: that of
            // |cos| over all directions is 0.58 of its mean, and light has two of them, of the sun and of the eye.
            let chance = 1.0 / (model.levels[index].triangles() as f64).sqrt();
            let [light, cover] = [light / bright - 1.0, cover / covered - 1.0];
            assert!(light.abs() < 0.1 + chance, "{name}, level {index}: {light:+.3} of the light");
            assert!(cover.abs() < 0.1 + 0.58 * chance, "{name}, level {index}: {cover:+.3} of the cover");
        }
    }
}

#[test]
fn memory_of_plants_is_known_before() {
    let gpu = kit::own_gpu(Options::default());
    let renderer = Renderer::new(&gpu).expect("a renderer");
    let scene = grove(&gpu);
    let film = film(300, 200);
    let land = gpu.memory().used;
    let mut drawing = renderer.begin(&scene, &film, ONE_SAMPLE).expect("a drawing");
    while drawing.step().expect("a tile") {}
    let most = gpu.memory().peak;
    let mut parts = raster::memory::picture(scene.ground.grid, &film, &scene.light.sky, ONE_SAMPLE);
    parts.extend(raster::memory::plants(scene.ground.grid, &film, ONE_SAMPLE));
    parts.push(raster::memory::models(&scene.population));
    let planned = land + memory::total(&parts);
    assert!(most <= planned + planned / 8 && planned <= 2 * most, "{planned} planned, {most} used");
}

#[test]
fn nobody_and_nothing_are_drawn() {
    let gpu = kit::gpu();
    let mut scene = plain(&gpu, 100.0, 0.0);
    scene.light.sun = Some(sun_at(270.0, 0.5, 1000.0));
    let empty = render(&gpu, &scene, 32, 32, ONE_SAMPLE);
    // A model without triangles, and one that nobody is an instance of.
    let nothing = Model { levels: vec![Level::default()], ..Model::default() };
    scene.population = forest::standing(nothing, [Vec3::ZERO]);
    scene.population.models.push(Arc::new(block(Vec3::ONE)));
    assert_eq!(empty, render(&gpu, &scene, 32, 32, ONE_SAMPLE));
}
