//! The picture: geometry without cracks, closed forms of light, sameness, and a golden picture.

use crate::kit;
use crate::kit::scenery::{SAND, island, sandbox, straight_down};
use crate::kit::stage::upload;
use glam::{DVec3, Mat3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;
use terrane::core::camera::Pinhole;
use terrane::core::color::filmic;
use terrane::core::grid::Grid;
use terrane::core::memory;
use terrane::gpu::{DeviceKind, Gpu, Image, Options, Recorder, format::R32f};
use terrane::raster::{self, Quality, Renderer};
use terrane::scene::{
    Air, AirLayer, Camera, Film, Light, Picture, Scene, Sky, SkyMap, Sun, ToneMap, View, dome,
};
use terrane::sky::{hosek_wilkie, preetham, sun};

const ONE_SAMPLE: Quality = Quality { samples: 1, tile: 512 };

fn download(gpu: &Gpu, image: &Image<R32f>) -> Vec<f32> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    download.take(&rec.submit().expect("submitted").wait().expect("finished"))
}

fn film(width: u32, height: u32) -> Film {
    Film { width, height, exposure: 1.0, tone_map: ToneMap::None }
}

fn render(gpu: &Gpu, scene: &Scene, width: u32, height: u32) -> Picture {
    let renderer = kit::renderer(gpu);
    renderer.render(scene, &film(width, height), ONE_SAMPLE).expect("a picture")
}

fn sun_at(elevation: f64, irradiance: f32) -> Sun {
    let position = sun::Position { zenith: PI / 2.0 - elevation, azimuth: 270f64.to_radians() };
    let direction = position.direction().as_vec3();
    Sun { direction, irradiance: [irradiance; 3], diameter: sun::DIAMETER as f32 }
}

fn middle(picture: &Picture) -> [f32; 3] {
    picture.pixels[((picture.height / 2) * picture.width + picture.width / 2) as usize]
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f64; 3], tolerance: f64) {
    let largest = expected.iter().fold(0.0f64, |most, channel| most.max(channel.abs()));
    for (found, channel) in found.iter().zip(expected) {
        assert!(
            (f64::from(*found) - channel).abs() <= tolerance * largest,
            "found {found}, expected {channel} of {expected:?}"
        );
    }
}

#[test]
fn ground_has_no_cracks() {
    // In a column of the picture whatever lies below ground is ground, as long as the ground fills the lower rim:
    // any ray below one that hits a heightfield hits it too. A crack would show what lies behind.
    let gpu = kit::gpu();
    let mut scene = island(&gpu, 256);
    scene.ground.sea_level = -1e5;
    let renderer = kit::renderer(&gpu);
    let (width, height) = (640, 360);
    for (position, target) in [
        (Vec3::new(600.0, 700.0, 2600.0), Vec3::new(0.0, 500.0, 0.0)),
        (Vec3::new(-1900.0, 1500.0, -900.0), Vec3::new(0.0, 100.0, 0.0)),
        (Vec3::new(0.0, 1700.0, 30.0), Vec3::new(200.0, 0.0, 900.0)),
    ] {
        scene.camera = Camera { view: View::LookAt { position, target, roll: 0.0 }, fov: 1.0 };
        let range = renderer.ground_range(&scene, &film(width, height), ONE_SAMPLE).expect("ranges");
        let mut covered = 0;
        for column in 0..width as usize {
            let mut above_ground = true;
            for row in 0..height as usize {
                let ground = range[row * width as usize + column] > 0.0;
                assert!(ground || above_ground, "a crack at column {column}, row {row} from {position}");
                above_ground &= !ground;
                covered += u32::from(ground);
            }
        }
        assert!(covered > width * height / 3, "the view shows ground");
    }
}

#[test]
fn ground_lies_where_the_heightfield_is() {
    let gpu = kit::gpu();
    let grid = Grid { cells: 129, extent: 4000.0 };
    let mut scene = sandbox(&gpu, grid, |x, z| 0.2 * x - 0.3 * z);
    let (eye, target) = (Vec3::new(200.0, 900.0, 700.0), Vec3::new(0.0, 0.0, 0.0));
    let (width, height) = (160, 90);
    let renderer = kit::renderer(&gpu);
    let normal = DVec3::new(-0.2, 1.0, 0.3);
    for roll in [0.0, 0.4] {
        scene.camera = Camera { view: View::LookAt { position: eye, target, roll }, fov: 0.8 };
        let range = renderer.ground_range(&scene, &film(width, height), ONE_SAMPLE).expect("ranges");
        let level = Pinhole::look_at(eye, target, 0.8, width as f32 / height as f32);
        let turn = Mat3::from_axis_angle(level.forward, roll);
        let camera = Pinhole { right: turn * level.right, up: turn * level.up, ..level };
        for row in 0..height {
            for column in 0..width {
                let ray = precise_ray(&camera, [column, row], [width, height]);
                let expected = -normal.dot(eye.as_dvec3()) / normal.dot(ray);
                let found = f64::from(range[(row * width + column) as usize]);
                assert!((found - expected).abs() < 1e-4 * expected, "{found} m in place of {expected} m");
            }
        }
    }
}

/// The ray through a sample's centre, in f64.
fn precise_ray(camera: &Pinhole, at: [u32; 2], size: [u32; 2]) -> DVec3 {
    let screen = |axis: usize| 2.0 * (f64::from(at[axis]) + 0.5) / f64::from(size[axis]) - 1.0;
    let across = camera.right.as_dvec3() * screen(0) * f64::from(camera.tangent[0]);
    let upward = camera.up.as_dvec3() * -screen(1) * f64::from(camera.tangent[1]);
    (camera.forward.as_dvec3() + across + upward).normalize()
}

#[test]
fn tiles_make_the_same_picture() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 128);
    let film = Film { exposure: 6e-5, ..film(200, 120) };
    let renderer = kit::renderer(&gpu);
    let draw = |tile| renderer.render(&scene, &film, Quality { samples: 2, tile }).expect("a picture");
    let (whole, tiled) = (draw(512), draw(56));
    // A tile rounds its vertices by itself, so an edge may move by a hair: a few pixels on outlines, by little.
    let differs =
        |(a, b): (&[f32; 3], &[f32; 3])| (0..3).any(|channel| (a[channel] - b[channel]).abs() > 2e-3);
    let different = whole.pixels.iter().zip(&tiled.pixels).filter(|pair| differs(*pair)).count();
    assert!(different <= whole.pixels.len() / 1000, "{different} pixels differ");
}

#[test]
fn two_runs_are_the_same_bits() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 128);
    let draw = || kit::renderer(&gpu).render(&scene, &film(160, 90), Quality::default()).expect("a picture");
    assert_eq!(draw(), draw());
}

#[test]
fn sun_on_a_tilted_plane_obeys_lambert() {
    let gpu = kit::gpu();
    let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 1000.0 }, |x, z| 0.3 * x + 0.1 * z);
    let sun = sun_at(0.9, 80_000.0);
    scene.light.sun = Some(sun);
    let picture = render(&gpu, &scene, 33, 33);
    let cosine = DVec3::new(-0.3, 1.0, -0.1).normalize().dot(sun.direction.as_dvec3());
    assert_near(middle(&picture), SAND.map(|albedo| f64::from(albedo) / PI * 80_000.0 * cosine), 1e-4);
}

#[test]
fn constant_sky_fills_and_lights_the_picture() {
    let gpu = kit::gpu();
    let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 1000.0 }, |_, _| 0.0);
    let radiance = [3000.0, 5000.0, 8000.0];
    scene.light.sky = Sky::Constant { radiance };
    // A plane under the whole dome receives π L and sends out albedo · L.
    let expected: [f64; 3] = std::array::from_fn(|i| f64::from(SAND[i] * radiance[i]));
    assert_near(middle(&render(&gpu, &scene, 33, 33)), expected, 1e-4);
    let view =
        View::LookAt { position: Vec3::new(0.0, 10.0, 0.0), target: Vec3::new(0.0, 20.0, -5.0), roll: 0.0 };
    scene.camera = Camera { view, fov: 1.0 };
    assert!(render(&gpu, &scene, 33, 33).pixels.iter().all(|pixel| *pixel == radiance));
}

#[test]
fn skies_agree_with_double_precision() {
    let gpu = kit::gpu();
    let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 1000.0 }, |_, _| 0.0);
    let (eye, target) = (Vec3::new(0.0, 10.0, 0.0), Vec3::new(-10.0, 16.0, 0.0));
    scene.camera = Camera { view: View::LookAt { position: eye, target, roll: 0.0 }, fov: 0.9 };
    let size = [160, 90];
    let camera = Pinhole::look_at(eye, target, 0.9, 160.0 / 90.0);
    // In the picture, and without a disc.
    let sun = sun_at(0.6, 0.0).direction.as_dvec3();
    let texels =
        (0..2048u32).map(|index| [index % 7, index % 5, index % 11].map(|channel| 10.0 + channel as f32));
    let map = SkyMap { width: 64, height: 32, texels: texels.collect(), rotation: 1.0 };
    let skies = [
        (preetham::sky(2.0, sun), 2e-5),
        (preetham::sky(3.0, sun), 2e-5),
        (preetham::sky(6.0, sun), 2e-5),
        (hosek_wilkie::sky(3.3, 0.3, sun), 2e-5),
        // Its values jump from texel to texel, and the places of these are as exact as 32-bit angles.
        (Sky::Map(Arc::new(map)), 2e-4),
    ];
    for (sky, tolerance) in skies {
        scene.light.sky = sky;
        let picture = render(&gpu, &scene, size[0], size[1]);
        for row in 0..size[1] {
            for column in 0..size[0] {
                let ray = precise_ray(&camera, [column, row], size);
                if ray.y > 0.01 {
                    let found = picture.pixels[(row * size[0] + column) as usize];
                    assert_near(found, dome::radiance(&scene.light.sky, ray), tolerance);
                }
            }
        }
    }
}

#[test]
fn flat_bottom_obeys_beer_and_lambert() {
    let gpu = kit::gpu();
    let elevation = 1.0;
    for depth in [6.0, 10.0, 25.0] {
        let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 4000.0 }, |_, _| -depth);
        scene.ground.sea_level = 0.0;
        scene.light.sun = Some(sun_at(elevation, 90_000.0));
        let picture = render(&gpu, &scene, 33, 33);
        let index = 1.34f64;
        let normal = ((index - 1.0) / (index + 1.0)).powi(2);
        let schlick = |cosine: f64| normal + (1.0 - normal) * (1.0 - cosine).powi(5);
        let sine = elevation.cos() / index;
        let cosine = (1.0 - sine * sine).sqrt();
        let expected: [f64; 3] = std::array::from_fn(|channel| {
            let attenuation = f64::from(scene.sea.attenuation[channel]);
            let (albedo, depth) = (f64::from(SAND[channel]), f64::from(depth));
            let arriving =
                90_000.0 * (1.0 - schlick(elevation.sin())) * cosine * (-attenuation * depth / cosine).exp();
            let bottom = albedo / PI * arriving / (1.0 - 0.48 * albedo * (-2.4 * attenuation * depth).exp());
            (1.0 - normal) * bottom * (-attenuation * depth).exp() / (index * index)
        });
        assert_near(middle(&picture), expected, 2e-3);
    }
}

#[test]
fn light_obeys_the_cosine_up_to_the_zenith() {
    let gpu = kit::gpu();
    let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 1000.0 }, |_, _| 0.0);
    // The nearer picture resolves the grid; a sample of the other covers twenty cells.
    for height in [200.0, 100_000.0] {
        scene.camera = Camera { view: straight_down(height), fov: 300.0 / height };
        let size = if height < 1e3 { 33 } else { 1 };
        for elevation in [5.0, 40.0, 80.0, 89.0, 89.7, 89.9, 89.99, 89.999, 90.0] {
            let elevation = f64::to_radians(elevation);
            scene.light.sun = Some(sun_at(elevation, 90_000.0));
            let expected = SAND.map(|albedo| f64::from(albedo) / PI * 90_000.0 * elevation.sin());
            assert_near(middle(&render(&gpu, &scene, size, size)), expected, 1e-3);
        }
    }
}

#[test]
fn extreme_worlds_have_finite_pictures() {
    type Change = fn(&mut Scene);
    fn sun(scene: &mut Scene, elevation: f64, irradiance: f32, diameter: f32) {
        scene.light.sun = Some(Sun { diameter, ..sun_at(elevation, irradiance) });
    }
    let cases: [(&str, Change); 12] = [
        ("a sun without a disc", |scene| sun(scene, 0.8, 1e5, 0.0)),
        ("a sun without a disc over a mirror", |scene| {
            sun(scene, 0.8, 1e5, 0.0);
            scene.sea.roughness = 0.0;
        }),
        ("a sun on the horizon", |scene| sun(scene, 0.0, 1e5, 0.0)),
        ("a sun in the zenith", |scene| sun(scene, PI / 2.0, 1e5, 0.01)),
        ("a sun as wide as the sky", |scene| sun(scene, 0.5, 1e5, PI as f32 / 2.0)),
        ("a blinding sun", |scene| sun(scene, 0.8, 1e9, 0.0)),
        ("a blinding sky", |scene| scene.light.sky = Sky::Constant { radiance: [1e9; 3] }),
        ("no light", |scene| scene.light = Light { sky: Sky::None, sun: None, air: None, clouds: 0.0 }),
        ("a shore without a beach", |scene| {
            (scene.surface.beach_height, scene.surface.beach_slope) = (0.0, 0.0);
        }),
        ("the finest and roughest of everything", |scene| {
            scene.surface.patch_size = 0.01;
            scene.sea.roughness = 1.0;
        }),
        ("ink", |scene| scene.sea.attenuation = [100.0; 3]),
        ("clear water", |scene| scene.sea.attenuation = [0.0; 3]),
    ];
    let look = |position, target, fov| Camera { view: View::LookAt { position, target, roll: 0.0 }, fov };
    let cameras = [
        look(Vec3::new(2500.0, 0.6, 0.0), Vec3::new(-1000.0, 0.5, 0.0), 1.0),
        look(Vec3::new(2500.0, 3.0, 0.0), Vec3::new(2400.0, -60.0, 0.0), 2.9),
        look(Vec3::new(0.0, 1e7, 0.0), Vec3::ZERO, 0.02),
        look(Vec3::new(-2600.0, 900.0, 0.0), Vec3::new(-1e7, 1e7, 0.0), 2.9),
    ];
    let gpu = kit::gpu();
    let renderer = kit::renderer(&gpu);
    // Level water and a level shore, as flat as ground can be.
    let mut level = island(&gpu, 64);
    level.ground.height = upload(&gpu, "height", &vec![0.0; level.ground.grid.samples()]);
    for scene in [island(&gpu, 64), level] {
        for (name, change) in cases {
            let mut scene = scene.clone();
            change(&mut scene);
            for camera in cameras {
                scene.camera = camera;
                let picture = renderer.render(&scene, &film(80, 45), ONE_SAMPLE).expect("a picture");
                let wrong = picture.pixels.iter().flatten().filter(|channel| !channel.is_finite()).count();
                assert_eq!(wrong, 0, "{name}, seen by {camera:?}");
            }
        }
    }
}

#[test]
fn air_veils_what_is_far() {
    let gpu = kit::gpu();
    let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 4000.0 }, |_, _| 0.0);
    scene.surface.sand = [0.0; 3];
    scene.light.sky = Sky::Constant { radiance: [1000.0; 3] };
    let layer = |extinction: [f32; 3], scale_height| AirLayer { extinction, scale_height };
    scene.light.air =
        Some(Air { molecules: layer([1e-4, 2e-4, 4e-4], 8000.0), haze: layer([3e-4; 3], 1200.0) });
    // Black ground straight below: what is seen is the air's light alone.
    let column = |scale: f64| scale * (1.0 - (-1000.0 / scale).exp());
    let expected = [1e-4, 2e-4, 4e-4]
        .map(|molecules| 1000.0 * (1.0 - (-(molecules * column(8000.0) + 3e-4 * column(1200.0))).exp()));
    assert_near(middle(&render(&gpu, &scene, 33, 33)), expected, 1e-4);
    scene.light.air = None;
    assert_eq!(middle(&render(&gpu, &scene, 33, 33)), [0.0; 3]);
}

#[test]
fn shadow_of_a_wall_has_its_length() {
    let gpu = kit::gpu();
    let grid = Grid { cells: 257, extent: 2560.0 };
    // A ridge along z, 10 m wide at its top and 30 m at its foot.
    let mut scene = sandbox(&gpu, grid, |x, _| (200.0 * (15.0 - x.abs()) / 10.0).clamp(0.0, 200.0));
    let elevation = 0.5f64;
    scene.light.sun = Some(sun_at(elevation, 100_000.0));
    // From so high that heights hardly shift the picture; a pixel is 2 m.
    let (width, height) = (601u32, 9);
    scene.camera = Camera { view: straight_down(20_000.0), fov: 2.0 * 9.0 / 20_000.0 };
    let picture = render(&gpu, &scene, width, height);
    // The sun stands in the west, so shadow falls to the right.
    let row = &picture.pixels[(height / 2 * width) as usize..][..width as usize];
    let lit = row[10][0];
    let metres = |column: usize| (column as f64 + 0.5 - f64::from(width) / 2.0) * 2.0;
    let end = (width as usize / 2..width as usize - 1)
        .filter(|column| metres(*column) > 20.0)
        .find(|column| row[*column][0] > 0.5 * lit)
        .map(metres)
        .expect("the shadow ends");
    let expected = 5.0 + 200.0 / elevation.tan();
    assert!((end - expected).abs() < grid.cell_size().into(), "{end} m in place of {expected} m");
}

#[test]
fn maps_of_a_plane_are_its_slope_and_normal() {
    let gpu = kit::gpu();
    let grid = Grid { cells: 65, extent: 1000.0 };
    let scene = sandbox(&gpu, grid, |x, z| 0.5 * x - 0.25 * z);
    let maps = kit::renderer(&gpu).maps(&scene).expect("maps");
    let expected = (0.5f32.hypot(0.25)).atan().to_degrees();
    assert!(download(&gpu, &maps.slope).iter().all(|slope| (slope - expected).abs() < 1e-2));
    let mut rec = Recorder::new(&gpu);
    let (normal, splat) = (rec.download(&maps.normal), rec.download(&maps.splat));
    let finished = rec.submit().expect("submitted").wait().expect("finished");
    let up = Vec3::new(-0.5, 1.0, 0.25).normalize();
    let coded = Vec3::new(up.x, -up.z, up.y) * 0.5 + 0.5;
    for [x, y, z, _] in normal.take(&finished) {
        assert!(Vec3::new(x, y, z).distance(coded) < 1e-4);
    }
    assert!(splat.take(&finished).iter().all(|weights| *weights == [0.0, 0.0, 1.0, 0.0]));
}

#[test]
fn material_weights_sum_to_one() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 128);
    let maps = kit::renderer(&gpu).maps(&scene).expect("maps");
    let mut rec = Recorder::new(&gpu);
    let splat = rec.download(&maps.splat);
    let splat = splat.take(&rec.submit().expect("submitted").wait().expect("finished"));
    for weights in &splat {
        assert!(weights.iter().all(|weight| (0.0..=1.0).contains(weight)), "{weights:?}");
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{weights:?}");
    }
    // Each material appears somewhere.
    for material in 0..4 {
        assert!(splat.iter().any(|weights| weights[material] > 0.9), "material {material}");
    }
}

#[test]
fn framing_fills_the_picture_from_its_middle() {
    let boxes = [
        [Vec3::new(-900.0, 0.0, -300.0), Vec3::new(100.0, 250.0, 200.0)],
        [Vec3::new(0.0, 0.0, -100.0), Vec3::new(400.0, 700.0, 600.0)],
    ];
    for turn in 0..12 {
        let azimuth = turn as f32 * std::f32::consts::FRAC_PI_6;
        let forward = Vec3::new(azimuth.sin() * 0.95, -0.3122, azimuth.cos() * 0.95).normalize();
        let camera = Pinhole::frame(&boxes, forward, 1.0, 0.6, 1.6);
        let corners = boxes.iter().flat_map(|[least, greatest]| {
            (0..8).map(|corner| {
                let pick = |axis: usize| if corner >> axis & 1 == 0 { least[axis] } else { greatest[axis] };
                Vec3::new(pick(0), pick(1), pick(2))
            })
        });
        let mut margins = [1.0f32; 4];
        for corner in corners {
            let [x, y] = camera.project(corner).expect("in front");
            for (margin, side) in margins.iter_mut().zip([x, 1.0 - x, y, 1.0 - y]) {
                *margin = margin.min(side);
            }
        }
        let [left, right, above, below] = margins;
        assert!(left.min(above).abs() < 1e-4, "the picture is filled, and not more: {margins:?}");
        assert!((left - right).abs() < 1e-3 && (above - below).abs() < 1e-3, "in the middle: {margins:?}");
    }
}

#[test]
fn drowned_land_is_framed_from_above_the_sea() {
    let gpu = kit::gpu();
    let mut scene = sandbox(&gpu, Grid { cells: 65, extent: 1000.0 }, |_, _| -5000.0);
    scene.ground.sea_level = 0.0;
    scene.sea.deep_colour = [0.1, 0.2, 0.4];
    scene.light.sun = Some(sun_at(0.9, 80_000.0));
    scene.camera.view = View::FrameIsland { azimuth: 0.0, elevation: 0.3, distance: 1.0 };
    // There is no sky: what is not the sea is black.
    assert!(render(&gpu, &scene, 33, 33).pixels.iter().filter(|pixel| pixel[2] > 0.0).count() > 33 * 33 / 2);
}

#[test]
fn filmic_keeps_greys_grey_and_order() {
    let mut last = -1.0;
    for step in 0..200 {
        let value = 1e-4 * 1.06f32.powi(step);
        let [r, g, b] = filmic([value; 3]);
        assert!((r - g).abs() < 1e-5 && (g - b).abs() < 1e-5, "grey {value} became {r} {g} {b}");
        assert!(r >= last, "darker than a darker grey");
        last = r;
    }
    assert!((filmic([0.18; 3])[1] - 0.18).abs() < 1e-4);
    assert_eq!(filmic([100.0; 3]), [1.0; 3]);
}

#[test]
fn memory_of_a_picture_is_known_before() {
    // Small tiles on a fine grid, and a tile that is all.
    for (cells, film, quality) in [
        (512, film(300, 100), Quality { samples: 1, tile: 64 }),
        (1280, film(64, 64), Quality::default()),
        (128, film(500, 400), Quality::default()),
    ] {
        let gpu = kit::own_gpu(Options::default());
        let renderer = Renderer::new(&gpu).expect("a renderer");
        let scene = sandbox(&gpu, Grid { cells, extent: 4000.0 }, |x, _| 0.1 * x);
        let land = gpu.memory().used;
        let mut drawing = renderer.begin(&scene, &film, quality).expect("a drawing");
        while drawing.step().expect("a tile") {}
        let most = gpu.memory().peak;
        let planned = land
            + memory::total(&raster::memory::picture(scene.ground.grid, &film, &scene.light.sky, quality));
        // Graphics cards keep images in tiles, which small ones don't fill.
        let padding = if gpu.info().kind == DeviceKind::Cpu { planned / 4 } else { planned / 2 };
        assert!(most >= planned && most < planned + padding, "{cells}: {planned} planned, {most} used");
    }
}

#[test]
fn golden_picture() {
    let gpu = kit::gpu();
    let scene = island(&gpu, 256);
    let film = Film { exposure: 6e-5, ..film(320, 180) };
    let picture = kit::renderer(&gpu).render(&scene, &film, Quality::default()).expect("a picture");
    let found = picture.developed(ToneMap::Filmic);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/island.png");
    if std::env::var_os("TERRANE_BLESS").is_some() {
        image::save_buffer(path, &found, 320, 180, image::ColorType::Rgb8).expect("written");
    }
    let golden = image::open(path).expect("the golden picture").into_rgb8().into_raw();
    // Drivers differ in the last bits of sin and exp, and by a sample on outlines: far below what an eye sees.
    const THRESHOLD: f32 = 0.01;
    let difference = flip(&golden, &found);
    assert!(difference < THRESHOLD, "FLIP {difference}");

    // The comparison must see what an eye would: a little more light, a shift by a pixel.
    let brighter: Vec<u8> = found.iter().map(|value| value.saturating_add(6)).collect();
    assert!(flip(&golden, &brighter) > THRESHOLD, "a brighter picture passes");
    let shifted: Vec<u8> = found[3..].iter().chain(&found[..3]).copied().collect();
    assert!(flip(&golden, &shifted) > THRESHOLD, "a shifted picture passes");
}

/// Mean FLIP difference (Andersson et al. 2020) of two 320×180 pictures.
fn flip(reference: &[u8], found: &[u8]) -> f32 {
    let image = |bytes: &[u8]| nv_flip::FlipImageRgb8::with_data(320, 180, bytes);
    let errors = nv_flip::flip(image(reference), image(found), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    nv_flip::FlipPool::from_image(&errors).mean()
}
