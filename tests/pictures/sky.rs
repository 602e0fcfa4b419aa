//! The sky and the sun against tests/data/preetham_reference.json: float64 values of the authors' coefficients,
//! checked there against a 40-digit evaluation to 2.4e-15.

use crate::kit;
use std::f64::consts::PI;

use glam::{DMat3, DVec3, Vec3};
use serde_json::Value;
use terrane::core::camera::Pinhole;
use terrane::gpu::{Buffer, Compute, Gpu, Recorder};
use terrane::scene::{self, Film, Scene, Sky, SkyMap, ToneMap, dome};
use terrane::shaders::trace::sky as program;
use terrane::sky::{hosek_wilkie, preetham, sun};
use terrane::world::{self, Overrides};

fn reference() -> Value {
    let text = include_str!("../data/preetham_reference.json");
    serde_json::from_str(text).expect("the reference is JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// A unit vector in the sun's meridian turned by `dphi`; world axes, the sun towards −z.
fn direction(theta: f64, dphi: f64) -> DVec3 {
    DVec3::new(dphi.sin() * theta.sin(), theta.cos(), -dphi.cos() * theta.sin())
}

fn relative(found: f64, expected: f64) -> f64 {
    (found - expected).abs() / expected.abs().max(1e-300)
}

/// Largest relative difference over all cases of `table`, for coefficients from `turbidity · scale`.
fn worst_difference(table: &str, scale: f64) -> f64 {
    let mut worst = 0.0f64;
    for case in reference()[table].as_array().expect("a list of cases") {
        let theta_sun = number(&case["theta_s_deg"]).to_radians();
        let view = direction(number(&case["theta_deg"]).to_radians(), number(&case["dphi_deg"]).to_radians());
        let perez = preetham::perez(number(&case["T"]) * scale, direction(theta_sun, 0.0));
        let [luminance, x, y] = perez.luminance_and_chromaticity(view).expect("above the horizon");
        worst = worst.max(relative(luminance / 1000.0, number(&case["Y_kcd"])));
        worst = worst.max(relative(x, number(&case["x"]))).max(relative(y, number(&case["y"])));
        let largest = case["linear_srgb"].as_array().expect("three channels").iter().map(number);
        let largest = largest.fold(0.0f64, |most, channel| most.max(channel.abs()));
        for (found, expected) in perez.radiance(view).iter().zip(case["linear_srgb"].as_array().unwrap()) {
            worst = worst.max((found / 1000.0 - number(expected)).abs() / largest);
        }
    }
    worst
}

#[test]
fn sky_agrees_with_the_reference() {
    let worst = worst_difference("sky", 1.0);
    assert!(worst < 1e-12, "largest relative difference {worst:e}");
}

#[test]
fn sky_near_the_sun_agrees_with_the_reference() {
    let worst = worst_difference("sky_near_sun", 1.0);
    assert!(worst < 1e-12, "largest relative difference {worst:e}");
}

#[test]
fn a_slightly_wrong_turbidity_is_caught() {
    assert!(worst_difference("sky", 1.0 + 1e-9) > 1e-12);
}

/// What shaders see of a sky in these directions.
fn shaded(gpu: &Gpu, pass: &Compute<program::Shader>, scene: &Scene, views: &[DVec3]) -> Vec<DVec3> {
    let film = Film { width: 1, height: 1, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0, 1.0);
    let given: Vec<[f32; 3]> = views.iter().map(|view| view.as_vec3().to_array()).collect();
    let frame = Buffer::new(gpu, "frame", 1).unwrap();
    let looks = Buffer::new(gpu, "looks", given.len()).unwrap();
    let panorama = scene::panorama(gpu, &scene.light.sky).unwrap();
    let mut rec = Recorder::new(gpu);
    rec.upload(&frame, &[scene::frame(scene, &film, 1, &camera)]);
    rec.upload(&looks, &given);
    let count = given.len() as u32;
    let bindings = program::Bindings { frame: &frame, looks: &looks, panorama: &panorama };
    rec.dispatch(pass, [count, 1], program::Push { count }, bindings);
    let download = rec.download(&looks);
    let radiance = download.take(&rec.submit().unwrap().wait().unwrap());
    radiance.into_iter().map(|radiance| Vec3::from(radiance).as_dvec3()).collect()
}

/// Linear Rec.709 from XYZ, row by row (IEC 61966-2-1, D65).
const REC709_FROM_XYZ: [[f64; 3]; 3] = [
    [3.2404542, -1.5371385, -0.4985314],
    [-0.9692660, 1.8760108, 0.0415560],
    [0.0556434, -0.2040259, 1.0572252],
];

/// Largest relative difference of the shader's Y, x, y and colour, the last as a share of the largest channel, over all cases of
/// `table` for turbidities that are `scale` times as high.
fn worst_difference_of_shaders(table: &str, scale: f64) -> f64 {
    let gpu = kit::gpu();
    let pass = Compute::new(&gpu, ()).unwrap();
    let mut stage = kit::stage::empty(&gpu);
    let xyz_from_rec709 = DMat3::from_cols_array_2d(&REC709_FROM_XYZ).transpose().inverse();
    let mut worst = 0.0f64;
    for case in reference()[table].as_array().expect("a list of cases") {
        let sun = direction(number(&case["theta_s_deg"]).to_radians(), 0.0);
        let view = direction(number(&case["theta_deg"]).to_radians(), number(&case["dphi_deg"]).to_radians());
        stage.light.sky = preetham::sky(number(&case["T"]) * scale, sun);
        let found = shaded(&gpu, &pass, &stage, &[view])[0] / 1000.0;
        let channels = case["linear_srgb"].as_array().expect("three channels");
        let expected = DVec3::from_array([0, 1, 2].map(|channel| number(&channels[channel])));
        worst = worst.max((found - expected).abs().max_element() / expected.max_element());
        let xyz = xyz_from_rec709 * found;
        let sum = xyz.element_sum();
        worst = worst.max(relative(xyz.y, number(&case["Y_kcd"])));
        worst = worst.max(relative(xyz.x / sum, number(&case["x"])));
        worst = worst.max(relative(xyz.y / sum, number(&case["y"])));
    }
    worst
}

/// 32-bit floats, down to the sun's disc.
#[test]
fn shaders_agree_with_the_reference() {
    for table in ["sky", "sky_near_sun"] {
        let worst = worst_difference_of_shaders(table, 1.0);
        eprintln!("{table}: largest relative difference {worst:e}");
        assert!(worst < 2e-5, "{table}: largest relative difference {worst:e}");
        assert!(worst_difference_of_shaders(table, 1.0 + 5e-5) > 2e-5, "{table}");
    }
}

#[test]
fn sky_is_black_below_the_horizon_and_lit_from_it_at_night() {
    let Sky::Preetham(perez) = preetham::sky(3.0, DVec3::new(0.6, -0.8, 0.0)) else { panic!("no sky") };
    assert_eq!(perez.sun, DVec3::X);
    assert_eq!(perez.radiance(DVec3::new(0.6, -0.8, 0.0)), [0.0; 3]);
    assert!(perez.radiance(DVec3::Y).iter().all(|channel| channel.is_finite() && *channel > 0.0));
}

/// Largest differences in degrees from the formulas and from the almanac over all cases, with clocks `off` hours wrong.
fn worst_positions(off: f64) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for case in reference()["solar_position"]["cases"].as_array().expect("a list of cases") {
        let place = sun::Place {
            latitude: number(&case["lat_deg"]).to_radians(),
            longitude: number(&case["lon_east_deg"]).to_radians(),
            utc_offset: number(&case["utc_offset_h"]),
            day: number(&case["julian_day"]),
            time: number(&case["time_h"]) + off,
        };
        let position = sun::Position::at(&place);
        let expected = &case["preetham"];
        let zenith = (position.zenith.to_degrees() - number(&expected["zenith_deg"])).abs();
        let turn = position.azimuth - number(&expected["azimuth_from_north_cw_deg"]).to_radians();
        let turn = ((turn + PI).rem_euclid(2.0 * PI) - PI).abs().to_degrees();
        // The authors' axes are x south, y east, z up.
        let axes = expected["to_sun_x_south_y_east_z_up"].as_array().expect("three components");
        let to_sun = DVec3::new(number(&axes[1]), number(&axes[2]), number(&axes[0]));
        let apart = position.direction().distance(to_sun).to_degrees();
        let almanac = &case["pvlib_2023"];
        let almanac = sun::Position {
            zenith: number(&almanac["zenith_deg"]).to_radians(),
            azimuth: number(&almanac["azimuth_from_north_cw_deg"]).to_radians(),
        };
        let separation = position.direction().angle_between(almanac.direction()).to_degrees();
        worst = [worst[0].max(zenith).max(turn).max(apart), worst[1].max(separation)];
    }
    worst
}

#[test]
fn sun_position_agrees_with_the_formulas_and_an_almanac() {
    let [formulas, almanac] = worst_positions(0.0);
    assert!(formulas < 1e-9, "{formulas:e}° from the formulas");
    assert!(almanac < 1.15, "{almanac}° from the almanac");
    // A clock that is a tenth of a millisecond wrong, and one that is six minutes wrong.
    assert!(worst_positions(3e-8)[0] > 1e-9);
    assert!(worst_positions(0.1)[1] > 1.15);
}

#[test]
fn sun_disc_agrees_with_the_reference() {
    for case in reference()["sun_disc"]["cases"].as_array().expect("a list of cases") {
        let (turbidity, zenith) = (number(&case["T"]), number(&case["theta_s_deg"]).to_radians());
        assert!(relative(sun::optical_mass(zenith), number(&case["optical_mass"])) < 1e-12);
        for (wavelength, expected) in case["radiance_W_m2_nm_sr"].as_object().expect("wavelengths") {
            let wavelength = wavelength.parse().expect("nanometres");
            let found = sun::disc_spectral_radiance(turbidity, zenith, wavelength);
            let off = relative(found, number(expected));
            assert!(off < 1e-12, "T {turbidity}, {wavelength} nm: off by {off:e}");
        }
        let [x, y, z] = sun::disc_radiance_xyz(turbidity, zenith);
        assert!(relative(y, number(&case["luminance_cd_m2"])) < 1e-9);
        assert!(relative(x / (x + y + z), number(&case["x"])) < 1e-9);
        assert!(relative(y / (x + y + z), number(&case["y"])) < 1e-9);
        // The reference rounds the solid angle to 6.7443e-5 sr.
        assert!(relative(y * sun::SOLID_ANGLE / 1000.0, number(&case["normal_illuminance_klx"])) < 1e-5);
    }
}

#[test]
fn an_overhead_sun_gives_101_kilolux_and_a_set_sun_nothing() {
    let overhead = sun::sun(sun::Position { zenith: 0.0, azimuth: 0.0 }, 2.0).expect("a sun");
    assert!((terrane::core::color::luminance(overhead.irradiance) - 100_977.0).abs() < 100.0);
    assert_eq!(overhead.direction, glam::Vec3::Y);
    assert_eq!(sun::sun(sun::Position { zenith: PI / 2.0, azimuth: 0.0 }, 2.0), None);
}

/// Largest difference over all cases, as a share of the largest channel of each, for turbidities `off` too high.
fn worst_difference_of_hosek_wilkie(off: f64) -> f64 {
    let text = include_str!("../data/hosek_wilkie_reference.json");
    let reference: Value = serde_json::from_str(text).expect("the reference is JSON");
    let mut worst = 0.0f64;
    for case in reference["cases"].as_array().expect("a list of cases") {
        let sun = direction((90.0 - number(&case["elevation_deg"])).to_radians(), 0.0);
        let view = direction(number(&case["theta_deg"]).to_radians(), number(&case["dphi_deg"]).to_radians());
        let sky = hosek_wilkie::sky(number(&case["turbidity"]) + off, number(&case["albedo"]), sun);
        // Watts there, lumens here.
        let expected: Vec<f64> =
            case["radiance"].as_array().unwrap().iter().map(|channel| 683.0 * number(channel)).collect();
        let largest = expected.iter().fold(0.0f64, |most, channel| most.max(*channel));
        for (found, expected) in dome::radiance(&sky, view).iter().zip(&expected) {
            worst = worst.max((found - expected).abs() / largest);
        }
    }
    worst
}

/// Of another implementation, in 32-bit floats as the fitted numbers are.
#[test]
fn hosek_wilkie_agrees_with_another_implementation() {
    let worst = worst_difference_of_hosek_wilkie(0.0);
    assert!(worst < 2e-5, "largest relative difference {worst:e}");
    assert!(worst_difference_of_hosek_wilkie(-1e-3) > 2e-5);
}

/// A clear day's sky gives 10 to 20 kilolux (16 to 17 here), and its light comes from where the sun is.
#[test]
fn hosek_wilkie_has_the_light_of_a_clear_day() {
    let sun = direction(PI / 6.0, 0.0);
    let sky = hosek_wilkie::sky(2.5, 0.2, sun);
    let irradiance = dome::sky_irradiance(&sky);
    // The quadratic in the normal, upwards.
    let up = [0, 1, 2]
        .map(|channel| irradiance[0][channel] + irradiance[2][channel] + 2.0 * irradiance[6][channel]);
    let lux = terrane::core::color::luminance(up);
    assert!((15_000.0..18_000.0).contains(&lux), "{lux} lx");
    let towards = dome::radiance(&sky, direction(PI / 6.0 + 0.1, 0.0));
    let away = dome::radiance(&sky, direction(PI / 6.0 + 0.1, PI));
    assert!(towards[1] > 2.0 * away[1]);
    assert_eq!(hosek_wilkie::sky(0.5, 0.2, sun), Sky::None);
}

/// A bright texel lies where its column and row say, and half-way to its neighbours it is half as bright.
#[test]
fn pictures_of_the_sky_lie_where_they_should() {
    let mut map = SkyMap { width: 8, height: 4, texels: vec![[0.0; 3]; 32], rotation: 0.0 };
    // The second row from above, the third column: 67.5° from the zenith, 112.5° from north.
    map.texels[8 + 2] = [1.0, 2.0, 3.0];
    let towards = |zenith: f64, azimuth: f64| {
        let (zenith, azimuth) = (zenith.to_radians(), azimuth.to_radians());
        DVec3::new(zenith.sin() * azimuth.sin(), zenith.cos(), -zenith.sin() * azimuth.cos())
    };
    let near = |map: &SkyMap, view: DVec3, expected: f64| {
        let [red, _, blue] = map.radiance(view);
        assert!(
            (red - expected).abs() < 1e-9 && (blue - 3.0 * expected).abs() < 1e-9,
            "{red}, not {expected}"
        );
    };
    near(&map, towards(67.5, 112.5), 1.0);
    near(&map, towards(67.5, 90.0), 0.5);
    near(&map, towards(45.0, 135.0), 0.25);
    near(&map, towards(112.5, 112.5), 0.0);
    map.rotation = 90f64.to_radians();
    near(&map, towards(67.5, 202.5), 1.0);
    // All of the sphere is there once.
    let whole: f64 = (0..4).map(|row| 8.0 * map.solid_angle(row)).sum();
    assert!((whole - 4.0 * PI).abs() < 1e-12);
}

/// What is too large for renderers loses no light.
#[test]
fn large_pictures_of_the_sky_are_made_smaller() {
    let [width, height] = SkyMap::MOST.map(|most| most + most / 2);
    let mut map = SkyMap { width, height, texels: vec![[0.0; 3]; (width * height) as usize], rotation: 0.0 };
    let row = height / 3;
    map.texels[(row * width + 5) as usize] = [7.0; 3];
    let light = |map: &SkyMap| -> f64 {
        let texels = (0..).zip(&map.texels);
        texels.map(|(index, texel)| f64::from(texel[0]) * map.solid_angle(index / map.width)).sum()
    };
    let expected = light(&map);
    let reduced = map.reduced();
    assert_eq!((reduced.width, reduced.height), (width / 2, height / 2));
    assert!((light(&reduced) / expected - 1.0).abs() < 1e-6);
}

#[test]
fn skies_know_their_limits() {
    let read = |light: &str| {
        let text = format!("format = 1\n{light}\n");
        world::parse("sky.toml", text.as_bytes(), std::path::Path::new(""), &Overrides::default())
    };
    let refused = |light: &str| {
        let message = read(light).expect_err(light).to_string();
        assert!(message.contains("allowed"), "{light}: {message}");
    };
    let warned = |light: &str| !read(light).expect(light).warnings.is_empty();
    let preetham = |turbidity: f64| format!("sky = {{ preetham = {{ turbidity = {turbidity} }} }}");
    for turbidity in [1.69, 0.0, -1.0, 10.1] {
        refused(&preetham(turbidity));
    }
    for (turbidity, expected) in [(1.7, true), (1.99, true), (2.0, false), (8.0, false), (8.1, true)] {
        assert_eq!(warned(&preetham(turbidity)), expected, "turbidity {turbidity}");
    }
    refused("sky = { hosek_wilkie = { turbidity = 0.9 } }");
    refused("sky = { hosek_wilkie = { albedo = 1.1 } }");
    assert!(!warned("sky = { hosek_wilkie = { turbidity = 1, albedo = 1 } }"));
    for place in
        ["day = -1", "day = 367", "time = -0.1", "time = 24.1", "longitude = -181", "longitude = 361"]
    {
        refused(&format!("sun = {{ place = {{ {place} }} }}"));
    }
    for place in ["latitude = 91", "utc_offset = -13"] {
        refused(&format!("sun = {{ place = {{ {place} }} }}"));
    }
    // Below 3°, and below the horizon.
    assert!(
        warned("sun = { direct = { elevation = 2.9 } }") && !warned("sun = { direct = { elevation = 3.1 } }")
    );
    assert!(warned("sun = { place = { time = 23 } }"));
}

/// A file that is no sky is an error that names it and its key.
#[test]
fn files_that_are_no_sky_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let refuse = |name: &str, bytes: &[u8], reason: &str| {
        std::fs::write(folder.path().join(name), bytes).expect("written");
        let text = format!("format = 1\nsky = {{ map = {{ file = \"{name}\" }} }}\n");
        let error = world::parse("sky.toml", text.as_bytes(), folder.path(), &Overrides::default());
        let message = error.expect_err(name).to_string();
        assert!(message.contains("sky.map.file") && message.contains(name), "{message}");
        assert!(message.contains(reason), "{message}");
    };
    let hdr = |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
    refuse("sky.png", b"", ".exr or .hdr");
    refuse("noise.exr", b"noise", "EXR");
    refuse("noise.hdr", b"noise", "HDR");
    // The pixels would take 48 GiB.
    refuse("forged.hdr", &hdr("-Y 65536 +X 65536"), "8192");
    refuse("short.hdr", &hdr("-Y 4096 +X 8192"), "can't hold");
    let mut square = hdr("-Y 2 +X 2");
    square.extend([128, 128, 128, 128].repeat(4));
    refuse("square.hdr", &square, "twice as wide");
}

/// What a picture of the sky holds, by its scale.
#[test]
fn pictures_of_the_sky_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let pixels: Vec<[f32; 3]> = (0..8).map(|index| [index as f32, 0.5, 2.0]).collect();
    terrane::formats::exr::write_picture(&folder.path().join("sky.exr"), [4, 2], &pixels, 1.0)
        .expect("written");
    // Mantissas of 128 with exponents of 128, 129 and so on are ½, 1, …
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    (0..8).for_each(|index| bytes.extend([128, 64, 0, 128 + index]));
    std::fs::write(folder.path().join("sky.hdr"), bytes).expect("written");
    let read = |file: &str| {
        let text =
            format!("format = 1\nsky = {{ map = {{ file = \"{file}\", scale = 100, rotation = 90 }} }}\n");
        let world = world::parse("sky.toml", text.as_bytes(), folder.path(), &Overrides::default());
        match world.expect(file).light.sky {
            Sky::Map(map) => map,
            other => panic!("{other:?}"),
        }
    };
    let map = read("sky.exr");
    assert_eq!((map.width, map.height), (4, 2));
    assert!((map.rotation - PI / 2.0).abs() < 1e-6);
    assert_eq!(map.texels[5], [500.0, 50.0, 200.0]);
    assert_eq!(read("sky.hdr").texels[3], [400.0, 200.0, 0.0]);
}
