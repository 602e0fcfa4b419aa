//! The path tracer against closed forms: what light must come out of scenes that can be worked out by hand. Seeds are fixed.

mod kit;

use glam::Vec3;
use std::f64::consts::PI;
use terrane::core::camera::Pinhole;
use terrane::core::mesh::Mesh;
use terrane::gpu::Gpu;
use terrane::scene::{Film, Material, Scene, Sky, Sun, ToneMap};
use terrane::trace::{Settings, Tracer};

use kit::stage::{ball, empty, grey, sheet, with};

/// Pixels that see a place, and samples of each.
const SIDE: u32 = 8;
const SAMPLES: u32 = 256;

/// Mean radiance that reaches `eye` from round about `target`, within a quarter of a degree, and its standard error by how
/// much pixels differ.
fn radiance(gpu: &Gpu, scene: &Scene, bounces: u32, eye: Vec3, target: Vec3) -> (f64, f64) {
    let film = Film { width: SIDE, height: SIDE, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(eye, target, 0.25_f32.to_radians(), 1.0);
    let tracer = Tracer::new(gpu).expect("a tracer");
    let settings = Settings { bounces, plain: true, ..Settings::default() };
    let mut tracing = tracer.begin(scene, &film, &camera, settings).expect("begun");
    while tracing.step(SAMPLES).expect("a step") {}
    let picture = tracing.sums().picture();
    let count = picture.pixels.len() as f64;
    let values = || picture.pixels.iter().map(|pixel| f64::from(pixel[1]));
    let mean = values().sum::<f64>() / count;
    let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// Within three standard errors, and half a percent. Where nothing seems left to chance there is one rare event: a path that finds
/// the sun's disc by itself, which weighs 2e-5 of what is looked for.
#[track_caller]
fn assert_radiance((mean, error): (f64, f64), expected: f64) {
    let off = (mean - expected).abs();
    assert!(off <= 3.0 * error + 5e-5 * expected, "{mean} ± {error}, expected {expected}");
    assert!(off <= 0.005 * expected, "{mean}, expected {expected}: {:.2} % off", 100.0 * off / expected);
}

fn sky(mut scene: Scene, radiance: f32) -> Scene {
    scene.light.sky = Sky::Constant { radiance: [radiance; 3] };
    scene
}

/// `angle` degrees from the zenith, towards the south.
fn sun(mut scene: Scene, angle: f32, irradiance: f32) -> Scene {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let direction = Vec3::new(0.0, cosine, sine);
    scene.light.sun = Some(Sun { direction, irradiance: [irradiance; 3], diameter: 0.53_f32.to_radians() });
    scene
}

/// A bowl of albedo ½ round the origin, open above.
fn bowl(gpu: &Gpu) -> Scene {
    with(empty(gpu), vec![(ball(Vec3::ZERO, 1.0, 0.0, 256, true), grey(0.5))])
}

/// Σ ½ᵏ of emission 1: each scattering sends on half of what came.
#[test]
fn closed_cube() {
    let gpu = kit::gpu();
    let glowing = Material { emission: [1.0; 3], ..grey(0.5) };
    let corner = Vec3::splat(-1.0);
    let [x, y, z] = [2.0 * Vec3::X, 2.0 * Vec3::Y, 2.0 * Vec3::Z];
    let sides = [
        sheet(corner, x, z),
        sheet(corner + y, z, x),
        sheet(corner, y, x),
        sheet(corner + z, x, y),
        sheet(corner, z, y),
        sheet(corner + x, y, z),
    ];
    let scene = with(empty(&gpu), sides.map(|side| (side, glowing.clone())).into());
    for (bounces, expected) in [(0, 1.0), (1, 1.5), (5, 1.96875)] {
        assert_radiance(radiance(&gpu, &scene, bounces, Vec3::new(0.1, 0.2, 0.3), Vec3::NEG_Y), expected);
    }
}

/// albedo/π · E · cos θ.
#[test]
fn plane_under_the_sun() {
    let gpu = kit::gpu();
    let plane = || sheet(Vec3::new(-5.0, 0.0, -5.0), 10.0 * Vec3::Z, 10.0 * Vec3::X);
    for angle in [0.0_f32, 45.0, 80.0] {
        let scene = sun(with(empty(&gpu), vec![(plane(), grey(0.5))]), angle, 3.0);
        let expected = 0.5 / PI * 3.0 * f64::from(angle.to_radians()).cos();
        assert_radiance(radiance(&gpu, &scene, 3, Vec3::new(1.0, 4.0, 0.5), Vec3::ZERO), expected);
    }
}

/// Half of what leaves a place in a hemisphere meets the hemisphere again, wherever the place is.
#[test]
fn bowl_under_a_constant_sky() {
    let gpu = kit::gpu();
    let scene = sky(bowl(&gpu), 1.0);
    let eye = Vec3::new(0.2, -0.1, 0.1);
    for target in [Vec3::NEG_Y, Vec3::new(0.6, -0.8, 0.0)] {
        for (bounces, expected) in [(1, 0.25), (2, 0.3125), (3, 0.328125), (5, 0.33300781)] {
            assert_radiance(radiance(&gpu, &scene, bounces, eye, target), expected);
        }
    }
}

#[test]
fn bowl_under_the_sun() {
    let gpu = kit::gpu();
    let scene = sun(bowl(&gpu), 0.0, PI as f32);
    let eye = Vec3::new(0.05, -0.1, 0.02);
    for (angle, expected) in [(0.0_f32, 0.5830078), (30.0, 0.5160205), (60.0, 0.3330078)] {
        let (sine, cosine) = angle.to_radians().sin_cos();
        let target = Vec3::new(sine, -cosine, 0.0);
        assert_radiance(radiance(&gpu, &scene, 5, eye, target), expected);
    }
}

/// Two plates of width 1 that meet at a right angle, so long that their ends don't matter.
#[test]
fn two_plates() {
    let gpu = kit::gpu();
    let length = 400.0;
    let along = Vec3::X * length;
    let start = Vec3::X * (-length / 2.0);
    let plates = [sheet(start, Vec3::Z, along), sheet(start, along, Vec3::Y)];
    let scene = sky(with(empty(&gpu), plates.map(|plate| (plate, grey(0.5))).into()), 1.0);
    for (from_edge, expected) in [(0.1, 0.359684), (0.5, 0.418940), (0.9, 0.452242)] {
        let target = Vec3::new(0.0, 0.0, from_edge);
        let eye = target + Vec3::new(0.05, 0.4, 0.3);
        assert_radiance(radiance(&gpu, &scene, 5, eye, target), expected);
    }
}

/// Light that comes through a leaf: transmittance/π · E · cos θ, and nothing of the reflectance.
#[test]
fn transmitting_sheet() {
    let gpu = kit::gpu();
    let leaf = Material { transmittance: [0.4; 3], ..grey(0.3) };
    let plane = || sheet(Vec3::new(-5.0, 0.0, -5.0), 10.0 * Vec3::Z, 10.0 * Vec3::X);
    let scene = sun(with(empty(&gpu), vec![(plane(), leaf.clone())]), 30.0, 3.0);
    let cosine = 30.0_f64.to_radians().cos();
    let below = radiance(&gpu, &scene, 3, Vec3::new(0.5, -3.0, 1.0), Vec3::ZERO);
    assert_radiance(below, 0.4 / PI * 3.0 * cosine);
    let above = radiance(&gpu, &scene, 3, Vec3::new(0.5, 3.0, 1.0), Vec3::ZERO);
    assert_radiance(above, 0.3 / PI * 3.0 * cosine);
    // Under a sky that is 1 everywhere both sides send on all that comes.
    let scene = sky(with(empty(&gpu), vec![(plane(), leaf)]), 1.0);
    assert_radiance(radiance(&gpu, &scene, 1, Vec3::new(0.5, -3.0, 1.0), Vec3::ZERO), 0.7);
}

/// In a furnace of radiance 1 nothing is brighter than 1, and what takes nothing away is as bright as that.
#[test]
fn white_furnace() {
    let gpu = kit::gpu();
    let sphere = |material: Material| {
        sky(with(empty(&gpu), vec![(ball(Vec3::ZERO, 1.0, 1.0, 64, false), material)]), 1.0)
    };
    let eye = Vec3::new(0.0, 0.3, 4.0);
    for target in [Vec3::ZERO, Vec3::new(0.9, 0.0, 0.0)] {
        assert_radiance(radiance(&gpu, &sphere(grey(1.0)), 60, eye, target), 1.0);
        for (index, roughness) in [(1.3, 0.2), (1.5, 0.5), (2.0, 0.9)] {
            let coated = Material { refractive_index: index, roughness, ..grey(1.0) };
            let (mean, error) = radiance(&gpu, &sphere(coated), 8, eye, target);
            assert!(mean <= 1.0 + 3.0 * error, "{index}, {roughness}: {mean} ± {error}");
            assert!(mean > 0.6, "{index}, {roughness}: {mean}");
        }
    }
}

/// Nothing of a thing is behind it: a mesh that is turned and scaled is met where it stands.
#[test]
fn instances_stand_where_they_are_put() {
    let gpu = kit::gpu();
    let mesh: Mesh = sheet(Vec3::new(-0.5, 0.0, -0.5), Vec3::Z, Vec3::X);
    let glowing = Material { emission: [1.0; 3], ..grey(0.0) };
    let mut scene = with(empty(&gpu), vec![(mesh, glowing)]);
    let rotation = glam::Quat::from_rotation_z(0.5) * glam::Quat::from_rotation_y(0.7);
    let mut instance = scene.population.instances[0];
    (instance.position, instance.rotation, instance.scale) = (Vec3::new(30.0, -4.0, 7.0), rotation, 3.0);
    scene.population.instances = [instance].into();
    let edge = |along: f32| instance.position + rotation * (3.0 * Vec3::new(along, 0.0, 0.2));
    let eye = instance.position + rotation * Vec3::new(1.0, 9.0, 2.0);
    assert_radiance(radiance(&gpu, &scene, 0, eye, edge(0.45)), 1.0);
    assert_eq!(radiance(&gpu, &scene, 0, eye, edge(0.55)).0, 0.0);
}
