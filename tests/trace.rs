//! The path tracer against closed forms: what light must come out of scenes that can be worked out by hand. Seeds are fixed.

mod kit;

use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::OnceLock;
use terrane::core::camera::Pinhole;
use terrane::core::hash::mix;
use terrane::core::mesh::Mesh;
use terrane::gpu::Gpu;
use terrane::scene::{Film, Instance, Material, Scene, Sky, SkyMap, Sun, ToneMap};
use terrane::trace::{Ray, Settings, Tracer};

use kit::forest::Random;
use kit::stage::{ball, empty, grey, sheet, with};

/// Pixels that see a place, and samples of each.
const SIDE: u32 = 8;
const SAMPLES: u32 = 256;

/// One for all tests: its programs are compiled once.
fn tracer(gpu: &Gpu) -> &'static Tracer {
    static SHARED: OnceLock<Tracer> = OnceLock::new();
    SHARED.get_or_init(|| Tracer::new(gpu).expect("a tracer"))
}

/// Mean radiance that reaches `eye` from round about `target`, within a quarter of a degree, and its standard error by how
/// much pixels differ.
fn radiance(gpu: &Gpu, scene: &Scene, bounces: u32, eye: Vec3, target: Vec3) -> (f64, f64) {
    let film = Film { width: SIDE, height: SIDE, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(eye, target, 0.25_f32.to_radians(), 1.0);
    let tracer = tracer(gpu);
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
    let sphere = |material: Material| {
        sky(with(empty(&gpu), vec![(ball(Vec3::ZERO, 1.0, 1.0, 64, false), material)]), 1.0)
    };
    let eye = Vec3::new(0.0, 0.3, 4.0);
    for target in [Vec3::ZERO, Vec3::new(0.9, 0.0, 0.0)] {
        assert_radiance(radiance(&gpu, &sphere(grey(1.0)), 4, eye, target), 1.0);
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

// Rays ---------------------------------------------------------------------------------------------------------------

/// A heap of turned and scaled balls and sheets on hilly ground, and rays through it in all directions, each against every
/// triangle in f64. What a ray misses by less than rounding may differ: such rays are counted, and are few.
#[test]
fn rays_meet_what_lies_in_their_way() {
    let gpu = kit::gpu();
    let mut random = Random(7);
    let shapes = [
        (ball(Vec3::ZERO, 1.0, 1.0, 24, false), grey(0.5)),
        (sheet(Vec3::new(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X), grey(0.5)),
        (ball(Vec3::new(0.0, 0.5, 0.0), 0.3, 0.2, 12, true), grey(0.5)),
    ];
    let meshes: Vec<Mesh> = shapes.iter().map(|(mesh, _)| mesh.clone()).collect();
    let mut scene = with(empty(&gpu), shapes.into());
    let instance = |random: &mut Random| Instance {
        model: mix(random.0) % 3,
        random: 0,
        position: 10.0
            * Vec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0)),
        rotation: glam::Quat::from_axis_angle(random.direction(), random.between(0.0, 6.0)),
        scale: random.between(0.2, 2.0),
    };
    scene.population.instances = (0..300).map(|_| instance(&mut random)).collect();
    let film = Film { width: 8, height: 8, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::Y, Vec3::ZERO, 1.0, 1.0);
    let tracer = tracer(&gpu);
    let tracing = tracer.begin(&scene, &film, &camera, Settings::default()).expect("begun");
    let ray = |random: &mut Random| Ray {
        origin: random.direction() * random.between(0.0, 30.0),
        direction: random.direction(),
    };
    let mut rays: Vec<Ray> = (0..3000).map(|_| ray(&mut random)).collect();
    // Along the axes directions have components that are 0.
    let axis = |index: usize| [Vec3::X, Vec3::NEG_Y, Vec3::Z][index % 3];
    let along: Vec<Ray> = (0..300).map(|index| Ray { direction: axis(index), ..rays[index] }).collect();
    rays.extend(along);
    let found = tracing.meet(&rays).expect("met");
    let (mut met, mut off) = (0, 0);
    for (ray, found) in rays.iter().zip(found) {
        let expected = nearest(&scene.population.instances, &meshes, ray);
        let found = found.filter(|meeting| meeting.instance.is_some());
        met += usize::from(expected.is_some());
        let same = match (expected, found) {
            (None, None) => true,
            (Some((range, _)), Some(found)) => {
                (range - f64::from(found.range)).abs() <= 1e-4 * range.max(1.0)
            }
            _ => false,
        };
        off += usize::from(!same);
    }
    assert!(met > 1000, "{met} rays meet anything");
    assert!(off <= 3, "{off} of {} rays differ", rays.len());
}

/// The nearest crossing of the ray with any triangle (Möller & Trumbore 1997, in f64).
fn nearest(instances: &[Instance], meshes: &[Mesh], ray: &Ray) -> Option<(f64, u32)> {
    let mut best: Option<(f64, u32)> = None;
    for (index, instance) in instances.iter().enumerate() {
        let mesh = &meshes[instance.model as usize];
        let place = |corner: u32| {
            let corner = DVec3::from(Vec3::from(mesh.positions[corner as usize]));
            DVec3::from(instance.position)
                + instance.rotation.as_dquat() * (f64::from(instance.scale) * corner)
        };
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(place);
            let (origin, direction) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
            let (ab, ac) = (b - a, c - a);
            let p = direction.cross(ac);
            let determinant = ab.dot(p);
            if determinant == 0.0 {
                continue;
            }
            let s = origin - a;
            let u = s.dot(p) / determinant;
            let q = s.cross(ab);
            let v = direction.dot(q) / determinant;
            let range = ac.dot(q) / determinant;
            let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && range > 0.0;
            if inside && best.is_none_or(|(least, _)| range < least) {
                best = Some((range, index as u32));
            }
        }
    }
    best
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
    let tracer = tracer(&gpu);
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
    let tracer = tracer(gpu);
    let settings = Settings { bounces: 3, ..Settings::default() };
    let mut tracing = tracer.begin(scene, &film, &camera, settings).expect("begun");
    for samples in samples {
        while tracing.step(*samples).expect("a step") {}
    }
    tracing.sums().picture().pixels
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
