//! The path tracer against closed forms: what light must come out of scenes that can be worked out by hand. Seeds are fixed.

use crate::kit;
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::{Arc, OnceLock};
use terrane::core::camera::Pinhole;
use terrane::core::grid::Grid;
use terrane::core::hash::mix;
use terrane::core::mesh::Mesh;
use terrane::gpu::{Buffer, Compute, Gpu, Recorder};
use terrane::scene::{Film, Instance, Material, Scene, Sky, SkyMap, Sun, ToneMap, View};
use terrane::shaders::Trial;
use terrane::shaders::trace::{scatter, waves};
use terrane::trace::{Assets, Meeting, Ray, Settings, Tracer, Traversal, ground};

use crate::kit::forest::Random;
use crate::kit::stage::{ball, empty, grey, on, sheet, with};

/// Pixels that see a place, and samples of each.
const SIDE: u32 = 8;
const SAMPLES: u32 = 256;

/// Mean radiance that reaches `eye` from round about `target`, within a quarter of a degree, and its standard error by how
/// much pixels differ.
fn radiance(gpu: &Gpu, scene: &Scene, bounces: u32, eye: Vec3, target: Vec3) -> (f64, f64) {
    radiance_with(gpu, scene, Settings { bounces, plain: true, ..Settings::default() }, eye, target)
}

fn radiance_with(gpu: &Gpu, scene: &Scene, settings: Settings, eye: Vec3, target: Vec3) -> (f64, f64) {
    let film = Film { width: SIDE, height: SIDE, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(eye, target, 0.25_f32.to_radians(), 1.0);
    let tracer = kit::tracer(gpu);
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

/// However large the sun, what faces it receives its irradiance.
#[test]
fn plane_under_a_large_sun() {
    let gpu = kit::gpu();
    let plane = sheet(Vec3::new(-5.0, 0.0, -5.0), 10.0 * Vec3::Z, 10.0 * Vec3::X);
    let mut scene = sun(with(empty(&gpu), vec![(plane, grey(0.5))]), 0.0, 3.0);
    scene.light.sun.as_mut().expect("a sun").diameter = 60_f32.to_radians();
    assert_radiance(radiance(&gpu, &scene, 3, Vec3::new(1.0, 4.0, 0.5), Vec3::ZERO), 0.5 / PI * 3.0);
}

/// One bright texel lights a plane by the integral of its light over the sphere, times the cosine: across, all of a texel's width
/// and of its brightness; down, as its brightness falls off evenly towards the texels above and below.
#[test]
fn plane_under_a_picture_of_the_sky() {
    let gpu = kit::gpu();
    let plane = || sheet(Vec3::new(-5.0, 0.0, -5.0), 10.0 * Vec3::Z, 10.0 * Vec3::X);
    // The second is as small as the sun.
    for (height, row, brightness) in [(32, 8, 100.0), (512, 100, 1e5)] {
        let width = 2 * height;
        let mut map =
            SkyMap { width, height, texels: vec![[0.0; 3]; (width * height) as usize], rotation: 0.3 };
        map.texels[(row * width + width / 3) as usize] = [brightness; 3];
        let side = PI / f64::from(height);
        let middle = side * (f64::from(row) + 0.5);
        let steps = 1000;
        let down = (0..steps).map(|step| {
            let off = 2.0 * (f64::from(step) + 0.5) / f64::from(steps) - 1.0;
            let zenith = middle + off * side;
            (1.0 - off.abs()) * zenith.cos() * zenith.sin() * 2.0 * side / f64::from(steps)
        });
        let irradiance = f64::from(brightness) * side * down.sum::<f64>();
        let mut scene = with(empty(&gpu), vec![(plane(), grey(0.5))]);
        scene.light.sky = Sky::Map(Arc::new(map));
        let found = radiance(&gpu, &scene, 3, Vec3::new(1.0, 4.0, 0.5), Vec3::ZERO);
        assert_radiance(found, 0.5 / PI * irradiance);
        // From below the plane is dark.
        let (below, _) = radiance(&gpu, &scene, 3, Vec3::new(1.0, -4.0, 0.5), Vec3::ZERO);
        assert_eq!(below, 0.0);
    }
}

/// A picture that is 1 everywhere is a constant sky, and one that is 1 below the horizon lights what looks down.
#[test]
fn bowl_under_a_picture_of_the_sky() {
    let gpu = kit::gpu();
    let map = |lit: std::ops::Range<usize>| {
        let texels = (0..128).map(|index| [if lit.contains(&index) { 1.0 } else { 0.0 }; 3]).collect();
        Sky::Map(Arc::new(SkyMap { width: 16, height: 8, texels, rotation: 0.0 }))
    };
    let mut scene = bowl(&gpu);
    scene.light.sky = map(0..128);
    let eye = Vec3::new(0.2, -0.1, 0.1);
    assert_radiance(radiance(&gpu, &scene, 5, eye, Vec3::new(0.6, -0.8, 0.0)), 0.33300781);
    let plane = sheet(Vec3::new(-5.0, 0.0, -5.0), 10.0 * Vec3::Z, 10.0 * Vec3::X);
    let mut scene = with(empty(&gpu), vec![(plane, grey(0.5))]);
    scene.light.sky = map(80..128);
    // All rows but one are lit, and light falls off evenly across the horizon's: ∫ L cos sin over 0…π/2 from straight down.
    let steps = 10_000;
    let lit = (0..steps).map(|step| {
        let angle = PI / 2.0 * (f64::from(step) + 0.5) / f64::from(steps);
        let rows_up = angle / (PI / 8.0);
        let light = (3.5 - rows_up).clamp(0.0, 1.0);
        light * angle.cos() * angle.sin() * (PI / 2.0) / f64::from(steps)
    });
    // The stage's floor, 1 km² and 10 km below, is in the way.
    let hidden = 1e6 / (PI * 1e8);
    let expected = 0.5 * (2.0 * lit.sum::<f64>() - hidden);
    assert_radiance(radiance(&gpu, &scene, 1, Vec3::new(1.0, -4.0, 0.5), Vec3::ZERO), expected);
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
    // Where the normal of shading leans by δ against the facet, (1 − cos δ)/2 of the light would come from behind it: with so
    // many facets, 4e-5 at most.
    let sphere = |material: Material| {
        sky(with(empty(&gpu), vec![(ball(Vec3::ZERO, 1.0, 1.0, 256, false), material)]), 1.0)
    };
    let eye = Vec3::new(0.0, 0.3, 4.0);
    for target in [Vec3::ZERO, Vec3::new(0.9, 0.0, 0.0)] {
        assert_radiance(radiance(&gpu, &sphere(grey(1.0)), 4, eye, target), 1.0);
        for (index, roughness) in [(1.3, 0.2), (1.5, 0.5), (2.0, 0.9)] {
            let coated = Material { refractive_index: index, roughness, ..grey(1.0) };
            let settings = Settings { bounces: 8, ..Settings::default() };
            let (mean, error) = radiance_with(&gpu, &sphere(coated), settings, eye, target);
            assert!(mean <= 1.0 + 3.0 * error, "{index}, {roughness}: {mean} ± {error}");
            assert!(mean > 0.6, "{index}, {roughness}: {mean}");
        }
    }
}

/// A lens of radius R that is sharp at distance f sees each place at distance s as a disc of radius R·|1 − s/f|, evenly bright
/// (Potmesil & Chakravarty 1981). Of such a disc, ½ + (asin t + t·√(1 − t²))/π lies on one side of an edge, t radii from its middle.
#[test]
fn a_lens_blurs_an_edge_into_a_disc() {
    let gpu = kit::gpu();
    let glowing = Material { emission: [1.0; 3], ..grey(0.0) };
    let eye = Vec3::new(3.0, 2.0, -1.0);
    let seen = |aperture: f32, focus: f32, distance: f32, edge: f32, turn: f32| {
        // Beyond an edge that is turned about the axis of the view.
        let (across, along) =
            (Vec3::new(turn.cos(), turn.sin(), 0.0), Vec3::new(-turn.sin(), turn.cos(), 0.0));
        let corner = eye + distance * Vec3::NEG_Z + edge * across - 50.0 * along;
        let scene = with(empty(&gpu), vec![(sheet(corner, -50.0 * across, 100.0 * along), glowing.clone())]);
        let settings = Settings { bounces: 0, plain: true, aperture, focus, ..Settings::default() };
        radiance_with(&gpu, &scene, settings, eye, eye + Vec3::NEG_Z)
    };
    // In front of what is sharp, and behind it.
    for (focus, distance) in [(4.0, 2.0), (2.0, 4.0), (20.0, 4.0)] {
        let aperture = 0.5;
        let radius: f32 = aperture * f32::abs(1.0 - distance / focus);
        for (t, turn) in [(0.0f64, 0.3), (0.35, 0.0), (0.7, 1.1), (0.95, 2.0), (-0.35, 4.0), (-0.7, 1.57)] {
            let share = 0.5 + (t.asin() + t * (1.0 - t * t).sqrt()) / PI;
            assert_share(seen(aperture, focus, distance, t as f32 * radius, turn), share);
        }
        for (t, share) in [(1.05, 1.0), (-1.05, 0.0)] {
            assert_eq!(seen(aperture, focus, distance, t * radius, 0.5).0, share);
        }
    }
    // What is sharp has no disc, nor has anything without a lens.
    for (aperture, distance) in [(0.5, 4.0), (0.0, 9.0)] {
        for (edge, share) in [(0.06, 1.0), (-0.06, 0.0)] {
            assert_eq!(seen(aperture, 4.0, distance, edge, 0.5).0, share);
        }
    }
}

#[track_caller]
fn assert_share((mean, error): (f64, f64), expected: f64) {
    let off = (mean - expected).abs();
    assert!(error < 0.002 && off <= 3.0 * error + 1e-4, "{mean} ± {error}, expected {expected}");
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

// Scattering ---------------------------------------------------------------------------------------------------------

/// Kinds of surface, and the heights of the eye above them.
const SURFACES: [(&str, scatter::Push); 6] = {
    let matt = scatter::Push { reflectance: 0.8, transmittance: 0.0, ..SURFACE };
    let leaf = scatter::Push { reflectance: 0.4, transmittance: 0.5, ..SURFACE };
    [
        ("matt", matt),
        ("leaf", leaf),
        ("glossy leaf", scatter::Push { refractive_index: 1.4, width: 0.16, ..leaf }),
        ("polished", scatter::Push { refractive_index: 1.5, width: 0.04, ..matt }),
        ("rough", scatter::Push { refractive_index: 2.0, width: 0.8, ..matt }),
        ("water", scatter::Push { refractive_index: 1.34, width: 0.02, reflectance: 0.1, ..SURFACE }),
    ]
};
const SURFACE: scatter::Push = scatter::Push {
    view: [0.0, 0.0, 1.0],
    reflectance: 0.0,
    transmittance: 0.0,
    refractive_index: 1.0,
    width: 1.0,
    choose: 0,
    count: 0,
};

/// Lets `surface` judge directions, or choose as many.
fn scattering(gpu: &Gpu, surface: scatter::Push, choose: bool, directions: &[Vec3]) -> Vec<Trial> {
    static SHARED: OnceLock<Compute<scatter::Shader>> = OnceLock::new();
    let pass = SHARED.get_or_init(|| Compute::new(gpu, scatter::Constants::default()).expect("a program"));
    let count = directions.len() as u32;
    let given: Vec<Trial> =
        directions.iter().map(|way| Trial { direction: way.to_array(), ..Trial::default() }).collect();
    let trials = Buffer::new(gpu, "trials", given.len()).unwrap();
    let mut rec = Recorder::new(gpu);
    rec.upload(&trials, &given);
    let push = scatter::Push { choose: choose.into(), count, ..surface };
    rec.dispatch(pass, [count, 1], push, scatter::Bindings { trials: &trials });
    let download = rec.download(&trials);
    download.take(&rec.submit().unwrap().wait().unwrap())
}

fn views() -> impl Iterator<Item = [f32; 3]> {
    [0.0f32, 0.8, 1.45].into_iter().map(|angle| [0.6 * angle.sin(), 0.8 * angle.sin(), angle.cos()])
}

/// Directions are chosen as often as the density says: Pearson's test over bands of height above the plane z = 0 and of azimuth, with
/// the density summed up over each. Independent draws would exceed the limit once in 10,000 tests; these are drawn more evenly.
#[track_caller]
fn assert_density(name: &str, judged: impl Fn(&[Vec3]) -> Vec<Trial>, chosen: impl Fn(usize) -> Vec<Trial>) {
    const BANDS: usize = 24;
    const SECTORS: usize = 24;
    /// Steps of the sum in each cell, down and around: 0.002 and 0.004 radians; the narrowest lobe is 0.02 wide.
    const DOWN: usize = 64;
    const AROUND: usize = 64;
    const DRAWS: usize = 1 << 17;
    let direction = |band: f32, sector: f32| {
        let (level, z) = (std::f32::consts::PI * band / BANDS as f32).sin_cos();
        let azimuth = std::f32::consts::TAU * sector / SECTORS as f32;
        Vec3::new(level * azimuth.cos(), level * azimuth.sin(), z)
    };
    let columns = SECTORS * AROUND;
    let middle = |index: usize, steps: usize| (index as f32 + 0.5) / steps as f32;
    let grid: Vec<Vec3> = (0..BANDS * DOWN * columns)
        .map(|index| direction(middle(index / columns, DOWN), middle(index % columns, AROUND)))
        .collect();
    let step = PI / (BANDS * DOWN) as f64 * 2.0 * PI / columns as f64;
    let mut expected = [[0.0f64; SECTORS]; BANDS];
    for (index, trial) in judged(&grid).iter().enumerate() {
        let (band, sector) = (index / columns / DOWN, index % columns / AROUND);
        let [x, y, _] = grid[index].to_array().map(f64::from);
        expected[band][sector] += f64::from(trial.density) * x.hypot(y) * step * DRAWS as f64;
    }
    let mut found = [[0.0f64; SECTORS]; BANDS];
    let mut drawn = 0.0;
    for trial in chosen(DRAWS) {
        if trial.density <= 0.0 {
            continue;
        }
        let [x, y, z] = trial.direction;
        let length = Vec3::from(trial.direction).length();
        assert!((length - 1.0).abs() < 1e-5, "{name}: {:?}", trial.direction);
        let band = (z.clamp(-1.0, 1.0).acos() / std::f32::consts::PI * BANDS as f32) as usize;
        let turn = y.atan2(x).rem_euclid(std::f32::consts::TAU) / std::f32::consts::TAU;
        let sector = (turn * SECTORS as f32) as usize;
        found[band.min(BANDS - 1)][sector.min(SECTORS - 1)] += 1.0;
        drawn += 1.0;
    }
    // What has no density is not drawn.
    let all: f64 = expected.iter().flatten().sum();
    assert!((all - drawn).abs() < 4.0 * (DRAWS as f64).sqrt(), "{name}: {drawn} of {all}");
    let (mut sum, mut cells, mut few) = (0.0f64, 0.0f64, [0.0f64; 2]);
    for (expected, found) in expected.iter().flatten().zip(found.iter().flatten()) {
        if *expected < 5.0 {
            few = [few[0] + expected, few[1] + found];
            continue;
        }
        sum += (found - expected).powi(2) / expected;
        cells += 1.0;
    }
    assert!(few[1] <= few[0] + 4.0 * few[0].sqrt() + 5.0, "{name}: {few:?} in empty cells");
    // Chi squared of so many cells, one in 10,000 (Wilson & Hilferty 1931).
    let ninth = 2.0 / (9.0 * cells);
    let limit = cells * (1.0 - ninth + 3.719 * ninth.sqrt()).powi(3);
    assert!(sum <= limit, "{name}: {sum:.0} over {cells} cells, at most {limit:.0}");
}

#[test]
fn directions_are_chosen_with_their_density() {
    let gpu = kit::gpu();
    for (name, surface) in SURFACES {
        for view in views() {
            let surface = scatter::Push { view, ..surface };
            assert_density(
                &format!("{name}, {view:?}"),
                |directions| scattering(&gpu, surface, false, directions),
                |draws| scattering(&gpu, surface, true, &vec![Vec3::Z; draws]),
            );
        }
    }
}

/// Lets waves judge directions, or choose as many; `z` of the directions is up.
fn crossing(gpu: &Gpu, sea: waves::Push, choose: bool, directions: &[Vec3]) -> Vec<Trial> {
    static SHARED: OnceLock<Compute<waves::Shader>> = OnceLock::new();
    let pass = SHARED.get_or_init(|| Compute::new(gpu, waves::Constants::default()).expect("a program"));
    let count = directions.len() as u32;
    let trial = |way: &Vec3| Trial { direction: [way.x, way.z, -way.y], ..Trial::default() };
    let given: Vec<Trial> = directions.iter().map(trial).collect();
    let trials = Buffer::new(gpu, "trials", given.len()).unwrap();
    let mut rec = Recorder::new(gpu);
    rec.upload(&trials, &given);
    let push = waves::Push { choose: choose.into(), count, ..sea };
    rec.dispatch(pass, [count, 1], push, waves::Bindings { trials: &trials });
    let download = rec.download(&trials);
    let answers = download.take(&rec.submit().unwrap().wait().unwrap());
    let turned =
        |Trial { direction: [x, y, z], density, value }| Trial { direction: [x, -z, y], density, value };
    answers.into_iter().map(turned).collect()
}

/// Waves, calm and rough, level and leaning, that are seen from above and from near the horizon. What they mirror is chosen with the
/// density that it claims; and with what they let through it is all the light that there is, no more and no less.
#[test]
fn waves_mirror_with_their_density_and_keep_energy() {
    let gpu = kit::gpu();
    for (deviation, slope) in [(0.03, [0.0, 0.0]), (0.1, [0.1, -0.05]), (0.3, [-0.2, 0.3])] {
        for angle in [0.0f32, 0.8, 1.35, 1.52] {
            let view = [0.6 * angle.sin(), -angle.cos(), 0.8 * angle.sin()];
            let sea = waves::Push { view, slope, deviation, choose: 0, count: 0 };
            let name = format!("waves {deviation}, {slope:?} from {angle}");
            let judged = |directions: &[Vec3]| crossing(&gpu, sea, false, directions);
            let chosen = |draws| crossing(&gpu, sea, true, &vec![Vec3::Z; draws]);
            assert_density(&name, judged, chosen);
            let weights: Vec<f64> = chosen(1 << 16).iter().map(|trial| f64::from(trial.value[0])).collect();
            let count = weights.len() as f64;
            let mean = weights.iter().sum::<f64>() / count;
            let variance = weights.iter().map(|weight| (weight - mean).powi(2)).sum::<f64>() / count;
            let error = (variance / count).sqrt();
            assert!((mean - 1.0).abs() <= 3.0 * error + 1e-5, "{name}: {mean} ± {error}");
        }
    }
}

/// Nothing scatters more light than it gets, and light that goes back the same way is as bright (Helmholtz).
#[test]
fn scattering_keeps_energy_and_is_reciprocal() {
    let gpu = kit::gpu();
    for (name, surface) in SURFACES {
        let white = scatter::Push { reflectance: 0.55, transmittance: 0.45, ..surface };
        let white = if surface.transmittance > 0.0 {
            white
        } else {
            scatter::Push { reflectance: 1.0, transmittance: 0.0, ..surface }
        };
        for view in views() {
            let surface = scatter::Push { view, ..white };
            let trials = scattering(&gpu, surface, true, &vec![Vec3::Z; 1 << 14]);
            let weights: Vec<f64> = trials.iter().map(|trial| f64::from(trial.value[0])).collect();
            let count = weights.len() as f64;
            let mean = weights.iter().sum::<f64>() / count;
            let variance = weights.iter().map(|weight| (weight - mean).powi(2)).sum::<f64>() / count;
            assert!(mean <= 1.0 + 3.0 * (variance / count).sqrt() + 1e-6, "{name}, {view:?}: {mean}");
            // A rough coat loses what its facets mirror into each other.
            assert!(mean > 0.4, "{name}, {view:?}: {mean}");
            for other in views() {
                let there = scattering(&gpu, surface, false, &[other.into()])[0].value[0] / other[2];
                let back = scatter::Push { view: other, ..white };
                let back = scattering(&gpu, back, false, &[view.into()])[0].value[0] / view[2];
                assert!((there - back).abs() <= 1e-4 * there.max(back), "{name}: {there} there, {back} back");
            }
        }
    }
}

// Rays ---------------------------------------------------------------------------------------------------------------

/// A heap of turned and scaled balls and sheets, and what it is made of.
fn heap(gpu: &Gpu, random: &mut Random) -> (Scene, Vec<Mesh>) {
    let shapes = [
        (ball(Vec3::ZERO, 1.0, 1.0, 24, false), grey(0.5)),
        (sheet(Vec3::new(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X), grey(0.5)),
        (ball(Vec3::new(0.0, 0.5, 0.0), 0.3, 0.2, 12, true), grey(0.5)),
    ];
    let meshes: Vec<Mesh> = shapes.iter().map(|(mesh, _)| mesh.clone()).collect();
    let mut scene = with(empty(gpu), shapes.into());
    let instance = |random: &mut Random| Instance {
        model: mix(random.0) % 3,
        random: 0,
        position: 10.0
            * Vec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0)),
        rotation: glam::Quat::from_axis_angle(random.direction(), random.between(0.0, 6.0)),
        scale: random.between(0.2, 2.0),
    };
    scene.population.instances = (0..300).map(|_| instance(random)).collect();
    (scene, meshes)
}

/// In all directions, from within `reach` of the origin; then some along the axes: directions with components that are 0.
fn rays(random: &mut Random, reach: f32) -> Vec<Ray> {
    let ray = |random: &mut Random| Ray {
        origin: random.direction() * random.between(0.0, reach),
        direction: random.direction(),
    };
    let mut rays: Vec<Ray> = (0..3000).map(|_| ray(random)).collect();
    let axis = |index: usize| [Vec3::X, Vec3::NEG_Y, Vec3::Z][index % 3];
    let along: Vec<Ray> = (0..300).map(|index| Ray { direction: axis(index), ..rays[index] }).collect();
    rays.extend(along);
    rays
}

fn met(scene: &Scene, tracer: &Tracer, rays: &[Ray]) -> Vec<Option<Meeting>> {
    let film = Film { width: 8, height: 8, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::Y, Vec3::ZERO, 1.0, 1.0);
    let tracing = tracer.begin(scene, &film, &camera, Settings::default()).expect("begun");
    tracing.meet(rays).expect("met")
}

/// How many rays meet something, and how many of them not what they should or not where they should.
fn compared(expected: &[Option<f64>], found: &[Option<f64>]) -> (usize, usize) {
    let same = |expected: Option<f64>, found: Option<f64>| match (expected, found) {
        (Some(expected), Some(found)) => (expected - found).abs() <= 1e-4 * expected.max(1.0),
        (expected, found) => expected == found,
    };
    let off = expected.iter().zip(found).filter(|(expected, found)| !same(**expected, **found)).count();
    (expected.iter().flatten().count(), off)
}

/// Each ray against every triangle in f64. What a ray misses by less than rounding may differ: such rays are counted, and are few.
#[test]
fn rays_meet_what_lies_in_their_way() {
    let gpu = kit::gpu();
    let mut random = Random(7);
    let (scene, meshes) = heap(&gpu, &mut random);
    let rays = rays(&mut random, 30.0);
    let instances = &scene.population.instances;
    let expected: Vec<_> = rays.iter().map(|ray| nearest_instance(instances, &meshes, ray)).collect();
    let found = met(&scene, kit::tracer(&gpu), &rays).into_iter();
    let found = found.map(|it| it.filter(|it| it.instance.is_some()).map(|it| f64::from(it.range)));
    let (met, off) = compared(&expected, &found.collect::<Vec<_>>());
    assert!(met > 1000, "{met} rays meet anything");
    assert!(off <= 3, "{off} of {} rays differ", rays.len());
}

/// Rugged ground of a size that no tree divides evenly.
fn rugged(gpu: &Gpu, scene: Scene, random: &mut Random) -> (Scene, Vec<[Vec3; 3]>) {
    let grid = Grid { cells: 38, extent: 60.0 };
    let heights: Vec<f32> = (0..grid.samples()).map(|_| random.between(-9.0, 3.0)).collect();
    (on(scene, gpu, grid, &heights), ground::triangles(grid, &heights, 0..grid.cells - 1))
}

/// Each ray against every triangle of the land in f64.
#[test]
fn rays_meet_the_land() {
    let gpu = kit::gpu();
    let mut random = Random(11);
    let (scene, land) = rugged(&gpu, empty(&gpu), &mut random);
    let rays = rays(&mut random, 40.0);
    let expected: Vec<_> =
        rays.iter().map(|ray| nearest(land.iter().map(|corners| corners.map(DVec3::from)), ray)).collect();
    let found = met(&scene, kit::tracer(&gpu), &rays);
    let found: Vec<_> = found.into_iter().map(|it| it.map(|it| f64::from(it.range))).collect();
    let (met, off) = compared(&expected, &found);
    assert!(met > 1000, "{met} rays meet the land");
    assert!(off <= 3, "{off} of {} rays differ", rays.len());
}

/// What the device's own structures find is what our trees find, save for rays that pass an edge by less than rounding.
#[test]
fn both_traversals_meet_the_same() {
    let gpu = kit::gpu();
    if !gpu.info().ray_query {
        eprintln!(
            "{} traces no rays by itself: that it finds what our trees do is not tested",
            gpu.info().name
        );
        return;
    }
    let [query, bvh] =
        [Traversal::Query, Traversal::Bvh].map(|traversal| Tracer::with(&gpu, traversal).expect("a tracer"));
    let (mut total, mut different) = (0, 0);
    for seed in [1, 2, 3] {
        let mut random = Random(1000 * seed);
        let (scene, _) = heap(&gpu, &mut random);
        let (scene, _) = rugged(&gpu, scene, &mut random);
        let rays = rays(&mut random, 30.0);
        let [by_query, by_bvh] = [&query, &bvh].map(|tracer| met(&scene, tracer, &rays));
        let same = |(a, b): (&Option<Meeting>, &Option<Meeting>)| match (a, b) {
            (Some(a), Some(b)) => {
                a.instance == b.instance && (a.range - b.range).abs() <= 1e-4 * a.range.max(1.0)
            }
            (a, b) => a.is_none() && b.is_none(),
        };
        total += rays.len();
        different += by_query.iter().zip(&by_bvh).filter(|pair| !same(*pair)).count();
    }
    eprintln!("{different} of {total} rays meet something else");
    assert!(different <= 5, "{different} of {total} rays meet something else");
}

/// The nearest crossing of the ray with any triangle of the instances.
fn nearest_instance(instances: &[Instance], meshes: &[Mesh], ray: &Ray) -> Option<f64> {
    let of = |instance: &Instance| {
        let mesh = &meshes[instance.model as usize];
        let place = |corner: u32| {
            let corner = DVec3::from(Vec3::from(mesh.positions[corner as usize]));
            DVec3::from(instance.position)
                + instance.rotation.as_dquat() * (f64::from(instance.scale) * corner)
        };
        nearest(mesh.triangles.iter().map(|triangle| triangle.map(place)), ray)
    };
    instances.iter().filter_map(of).min_by(f64::total_cmp)
}

/// The nearest crossing of the ray with any of the triangles (Möller & Trumbore 1997, in f64).
fn nearest(triangles: impl Iterator<Item = [DVec3; 3]>, ray: &Ray) -> Option<f64> {
    let (origin, direction) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
    let crossing = |[a, b, c]: [DVec3; 3]| {
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        let s = origin - a;
        let u = s.dot(p) / determinant;
        let q = s.cross(ab);
        let v = direction.dot(q) / determinant;
        let range = ac.dot(q) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && range > 0.0).then_some(range)
    };
    triangles.filter_map(crossing).min_by(f64::total_cmp)
}

/// From inside a closed ball nothing gets out, wherever it goes: neighbouring triangles leave no gap.
#[test]
fn closed_meshes_do_not_leak() {
    let gpu = kit::gpu();
    let mut random = Random(3);
    let mut scene = with(empty(&gpu), vec![(ball(Vec3::ZERO, 1.0, 1.0, 16, true), grey(0.5))]);
    let mut instance = scene.population.instances[0];
    instance.rotation = glam::Quat::from_axis_angle(random.direction(), 1.0);
    instance.position = Vec3::new(30.0, 200.0, -70.0);
    scene.population.instances = [instance].into();
    let film = Film { width: 8, height: 8, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::Y, Vec3::ZERO, 1.0, 1.0);
    let tracer = kit::tracer(&gpu);
    let tracing = tracer.begin(&scene, &film, &camera, Settings::default()).expect("begun");
    // At the corners and along the edges, where a leak would be.
    let mesh = ball(Vec3::ZERO, 1.0, 1.0, 16, true);
    let corner =
        |index: u32| instance.position + instance.rotation * Vec3::from(mesh.positions[index as usize]);
    let mut rays = Vec::new();
    for triangle in &mesh.triangles {
        for side in 0..3 {
            let (a, b) = (corner(triangle[side]), corner(triangle[(side + 1) % 3]));
            for _ in 0..8 {
                let origin = instance.position + 0.5 * random.unit() * random.direction();
                rays.push(Ray { origin, direction: (a.lerp(b, random.unit()) - origin).normalize() });
                rays.push(Ray { origin, direction: (a - origin).normalize() });
            }
        }
    }
    let out = tracing
        .meet(&rays)
        .expect("met")
        .iter()
        .filter(|it| it.is_none_or(|it| it.instance.is_none()))
        .count();
    assert_eq!(out, 0, "{out} of {} rays get out", rays.len());
}

// Samples and sums ---------------------------------------------------------------------------------------------------

fn traced(gpu: &Gpu, scene: &Scene, width: u32, height: u32, samples: &[u32]) -> Vec<[f32; 3]> {
    let film = Film { width, height, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::new(0.2, -0.1, 0.1), Vec3::NEG_Y, 1.0, width as f32 / height as f32);
    let tracer = kit::tracer(gpu);
    let settings = Settings { bounces: 3, ..Settings::default() };
    let mut tracing = tracer.begin(scene, &film, &camera, settings).expect("begun");
    for samples in samples {
        while tracing.step(*samples).expect("a step") {}
    }
    tracing.sums().picture().pixels
}

/// Samples that know of each other leave less noise: at 64 a pixel, by at least 1.4 on the bowl.
#[test]
fn the_sequence_is_worth_its_work() {
    let gpu = kit::gpu();
    let scene = sky(bowl(&gpu), 1.0);
    let film = Film { width: 24, height: 24, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::new(0.2, -0.1, 0.1), Vec3::NEG_Y, 1.0, 1.0);
    let settings = Settings { bounces: 5, plain: true, ..Settings::default() };
    let error = |tracer: &Tracer| {
        let mut tracing = tracer.begin(&scene, &film, &camera, settings).expect("begun");
        while tracing.step(64).expect("a step") {}
        let pixels = tracing.sums().picture().pixels;
        let square = |pixel: &[f32; 3]| (f64::from(pixel[1]) - 0.33300781).powi(2);
        (pixels.iter().map(square).sum::<f64>() / pixels.len() as f64).sqrt()
    };
    let sequence = error(kit::tracer(&gpu));
    let independent = error(&Tracer::independent(&gpu).expect("a tracer"));
    let gain = independent / sequence;
    eprintln!("RMSE·√spp {:.4} instead of {:.4}: {gain:.2} times lower", 8.0 * sequence, 8.0 * independent);
    assert!(gain >= 1.4, "the error is {gain:.2} times lower");
}

/// The same bits again, and whether samples come in one go or in several; other seeds give other bits.
#[test]
fn the_same_samples_give_the_same_bits() {
    let gpu = kit::gpu();
    let scene = sky(bowl(&gpu), 1.0);
    let once = traced(&gpu, &scene, 24, 16, &[8]);
    assert_eq!(once, traced(&gpu, &scene, 24, 16, &[8]));
    assert_eq!(once, traced(&gpu, &scene, 24, 16, &[1, 3, 8]));
    assert_ne!(once, traced(&gpu, &scene, 24, 16, &[9]));
}

/// A frame has the same bits with what was made ready for another frame of its film.
#[test]
fn frames_have_their_assets_in_common() {
    let gpu = kit::gpu();
    let things = [0.8, 0.3].map(|radius| (ball(Vec3::ZERO, radius, 1.0, 16, false), grey(0.5)));
    let first = sky(with(empty(&gpu), things.to_vec()), 1.0);
    let mut second = first.clone();
    second.camera.view = View::LookAt { position: Vec3::new(50.0, 9.0, 7.0), target: Vec3::ZERO, roll: 0.0 };
    let moved = |x: f32, model: u32| {
        let position = Vec3::new(x, -2.0, 0.5);
        Instance { model, position, ..first.population.instances[0] }
    };
    second.population.instances = [moved(0.4, 1), moved(-0.9, 1), moved(1.1, 0)].into();
    let film = Film { width: 16, height: 16, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::Y, Vec3::NEG_Y, 1.0, 1.0);
    let settings = Settings { bounces: 2, ..Settings::default() };
    let tracer = kit::tracer(&gpu);
    let assets = tracer.assets(&first).expect("assets");
    let sums = |assets: &Arc<Assets>, scene: &Scene| {
        let mut tracing = tracer.begin_with(assets, scene, &film, &camera, settings).expect("begun");
        while tracing.step(2).expect("a step") {}
        tracing.take_sums()
    };
    let own = sums(&tracer.assets(&second).expect("assets"), &second);
    assert_eq!(sums(&assets, &second), own);
    assert_ne!(sums(&assets, &first), own);
}

/// The sea in a furnace: what waves mirror and what goes in and comes out again is all there is, whatever the waves. Water that takes
/// nothing over a white bottom sends everything back.
#[test]
fn the_sea_in_a_furnace() {
    let gpu = kit::gpu();
    for roughness in [0.02, 0.15] {
        let mut scene = sky(empty(&gpu), 1.0);
        scene.ground.sea_level = 0.0;
        scene.sea.level = 0.0;
        scene.sea.roughness = roughness;
        scene.sea.attenuation = [0.0; 3];
        let bottom = sheet(Vec3::new(-500.0, -2.0, -500.0), 1000.0 * Vec3::Z, 1000.0 * Vec3::X);
        scene = with(scene, vec![(bottom, grey(1.0))]);
        for eye in [Vec3::new(0.0, 3.0, 0.5), Vec3::new(0.0, 1.0, 4.0)] {
            let (mean, error) = radiance(&gpu, &scene, 40, eye, Vec3::ZERO);
            assert!((mean - 1.0).abs() <= 4.0 * error + 0.01, "{roughness}, {eye}: {mean} ± {error}");
        }
    }
}

/// A picture of the sky that is lit below the horizon alone: over the sea nobody sees that, whether it is looked for or met by chance.
#[test]
fn the_sea_hides_what_is_below_the_horizon() {
    let gpu = kit::gpu();
    let texels = (0..128).map(|index| [if index >= 64 { 1.0 } else { 0.0 }; 3]).collect();
    let wall = sheet(Vec3::new(-5.0, 1.0, 0.0), 10.0 * Vec3::X, 2.0 * Vec3::Y);
    let mut scene = with(empty(&gpu), vec![(wall, grey(0.5))]);
    scene.light.sky = Sky::Map(Arc::new(SkyMap { width: 16, height: 8, texels, rotation: 0.0 }));
    let (eye, target) = (Vec3::new(0.0, 2.0, 4.0), Vec3::new(0.0, 2.0, 0.0));
    let (seen, _) = radiance(&gpu, &scene, 1, eye, target);
    assert!(seen > 0.1, "there is light without a sea: {seen}");
    (scene.ground.sea_level, scene.sea.level) = (0.0, 0.0);
    // The light of the map's horizon fades over half a texel to its other side.
    let (seen, error) = radiance(&gpu, &scene, 1, eye, target);
    assert!(seen < 0.03, "{seen} ± {error}");
}

/// Black water over an endless bottom sends nothing back, however far away it is: the sky is not seen through it.
#[test]
fn the_open_sea_has_no_light_below() {
    let gpu = kit::gpu();
    let mut scene = sky(empty(&gpu), 1.0);
    (scene.ground.sea_level, scene.sea.level) = (0.0, 0.0);
    scene.sea.attenuation = [10.0; 3];
    for along in [0.0, 3.0, 30.0].map(|extents| extents * scene.ground.grid.extent) {
        let target = Vec3::new(along, 0.0, 0.0);
        let (seen, error) = radiance(&gpu, &scene, 8, target + 40.0 * Vec3::Y, target);
        // What flat water mirrors straight up: ((1.34 − 1)/(1.34 + 1))².
        assert!((seen - 0.0211).abs() <= 4.0 * error + 0.002, "{along}: {seen} ± {error}");
    }
}

/// Light bends where it enters the sea, and so does the shadow of what hangs above it.
#[test]
fn shadows_bend_into_the_sea() {
    let gpu = kit::gpu();
    let bed = sheet(Vec3::new(-40.0, -10.0, -40.0), 80.0 * Vec3::Z, 80.0 * Vec3::X);
    let roof = sheet(Vec3::new(-1.0, 10.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X);
    let mut scene = sun(with(empty(&gpu), vec![(bed, grey(0.5)), (roof, grey(0.0))]), 45.0, PI as f32);
    (scene.ground.sea_level, scene.sea.level, scene.sea.attenuation) = (0.0, 0.0, [0.0; 3]);
    let seen = |z| radiance(&gpu, &scene, 2, Vec3::new(0.0, -1.0, z), Vec3::new(0.0, -10.0, z));
    // Snell's law and Fresnel's equations for unpolarised light.
    let (index, above) = (1.34, FRAC_1_SQRT_2);
    let sine = above / index;
    let below = (1.0 - sine * sine).sqrt();
    let across = (above - index * below) / (above + index * below);
    let along = (index * above - below) / (index * above + below);
    let passes = 1.0 - (across * across + along * along) / 2.0;
    let tangent = (sine / below) as f32;
    let (shadow, error) = seen(-10.0 - 10.0 * tangent);
    assert!(shadow <= 3.0 * error + 1e-4, "{shadow} ± {error}");
    // Where the shadow would be if the light had come all the way as it goes in the water.
    assert_radiance(seen(-20.0 * tangent), 0.5 * above * passes);
}
