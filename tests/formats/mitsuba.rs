//! `--layer mitsuba`: whether the folder says what the tracer has. That Mitsuba sees the same in it is tried by
//! scripts/compare_mitsuba.py, which is not part of CI.

use crate::kit;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::path::Path;
use std::process::Output;
use std::{fs, str};
use terrane::core::camera::Pinhole;
use terrane::formats::exr;
use terrane::formats::mitsuba::{self, Contents, Land};
use terrane::scene::{Film, Light, Material, Sky, Sun, ToneMap, dome};
use terrane::sky::preetham;

use crate::kit::forest::{leaf, standing, tuft};
use crate::kit::program::terrane;
use crate::kit::stage::{ball, grey};

/// Ground of one colour, a model that stands there twice, and a sun.
const WORLD: &str = r##"
format = 1
seed = 5
erosion = "none"
reef = "none"
[terrain]
cells = 64
extent = 100
layers = [{ simplex = { amplitude = 4, wavelength = 50 } }]
[sea]
level = -100
[[models]]
file = "lamp.obj"
at = [[0, 0], [10, -5, 30, 2]]
[surface.by_height]
ground = { reflectance = [0.1, 0.2, 0.3], second_reflectance = [0.3, 0.4, 0.5] }
rock_start = 1000
ground_end = 1001
[sun.direct]
irradiance = [1000, 2000, 3000]
diameter = 2
[camera]
view = { look_at = { position = [3, 20, 40], target = [0, 5, 0] } }
[render]
size = [64, 48]
exposure = 0.01
bounces = 5
"##;

const LAMP: &str = "mtllib lamp.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl lamp\nf 1 2 3\nv 2 0 0\nv 3 0 0\nv 2 1 0\nusemtl post\nf 4 5 6\n";
const MATERIALS: &str = "newmtl lamp\nKd 0.5 0.5 0.5\nnewmtl post\nKd 0.6 0.5 0.4\n";

fn export(folder: &Path, out: &str, more: &[&str]) -> Output {
    let _turn = kit::turn();
    for (name, text) in [("world.toml", WORLD), ("lamp.obj", LAMP), ("lamp.mtl", MATERIALS)] {
        fs::write(folder.join(name), text).expect("written");
    }
    terrane(
        folder,
        &[&["export", "world.toml", "--no-cache", "--layer", "mitsuba", "-o", out], more].concat(),
    )
}

/// The text between quotes after the first `name="NAME" value=` behind `after`, as numbers.
fn values(xml: &str, after: &str, name: &str) -> Vec<f64> {
    let (_, rest) = xml.split_once(after).unwrap_or_else(|| panic!("no {after} in {xml}"));
    let key = format!("name=\"{name}\" value=\"");
    let (_, rest) = rest.split_once(&key).unwrap_or_else(|| panic!("no {name} behind {after}"));
    let (text, _) = rest.split_once('"').expect("the value ends");
    text.split(' ').map(|number| number.parse().unwrap_or_else(|_| panic!("{text} is no number"))).collect()
}

/// Every element is closed by the one that opened it.
fn assert_well_formed(xml: &str) {
    let mut open = Vec::new();
    let without_comments: String =
        xml.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, rest)| rest)).collect();
    for tag in without_comments.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("a tag ends");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().expect("a name");
        match tag {
            _ if tag.starts_with('?') || tag.ends_with('/') => {}
            _ if tag.starts_with('/') => assert_eq!(open.pop(), Some(name.to_owned())),
            _ => open.push(name.to_owned()),
        }
    }
    assert!(open.is_empty(), "{open:?} are not closed");
}

#[test]
fn the_folder_has_what_the_scene_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = export(folder.path(), "out/", &[]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("mean of their colours") && said.contains("aerial"), "{said}");
    assert!(!said.contains("no water"), "{said}");
    let out = folder.path().join("out");
    let xml = fs::read_to_string(out.join("scene.xml")).expect("a scene");
    assert_well_formed(&xml);
    let files = xml.split("name=\"filename\" value=\"").skip(1);
    let files: Vec<&str> = files.map(|rest| rest.split('"').next().unwrap()).collect();
    for file in ["terrain.ply", "sky.exr", "model_0_0.ply", "model_0_1.ply"] {
        assert!(files.contains(&file), "{file} is not named in {files:?}");
    }
    files.iter().for_each(|file| assert!(out.join(file).exists(), "{file}"));
    // The sun's.
    assert_eq!(xml.matches("<emitter type=\"area\">").count(), 1);
    assert_eq!(xml.matches("<shape type=\"instance\">").count(), 2);
    assert_eq!(values(&xml, "integrator", "max_depth"), [6.0]);
    // E / (π sin² r) times the exposure.
    let radiance = values(&xml, "<shape type=\"disk\">", "radiance");
    let expected = 1000.0 * 0.01 / (PI * 1f64.to_radians().sin().powi(2));
    assert!((radiance[0] / expected - 1.0).abs() < 1e-5 && (radiance[2] / expected - 3.0).abs() < 1e-4);

    let land = fs::read(out.join("terrain.ply")).expect("the land");
    let end = land.windows(11).position(|bytes| bytes == b"end_header\n").expect("a header") + 11;
    let header = str::from_utf8(&land[..end]).expect("text");
    assert!(header.contains("element vertex 4096\n") && header.contains("element face 7938\n"), "{header}");
    assert_eq!(land.len() - end, 4096 * 36 + 7938 * 13);
    // All of one colour: the mean of the two that noise mixes.
    let number = |at: usize| f32::from_le_bytes(land[end + 4 * at..end + 4 * at + 4].try_into().unwrap());
    for corner in [0, 77, 4095] {
        for (channel, expected) in [0.2, 0.3, 0.4].into_iter().enumerate() {
            assert!((number(9 * corner + 6 + channel) - expected).abs() < 1e-6);
        }
        let normal = Vec3::new(number(9 * corner + 3), number(9 * corner + 4), number(9 * corner + 5));
        assert!((normal.length() - 1.0).abs() < 1e-5 && normal.y > 0.5);
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (out, more) in [("scene.xml", &[][..]), ("out/", &["--cells", "99"]), ("out/", &["--format", "tif"])]
    {
        let output = export(folder.path(), out, more);
        assert_eq!(
            output.status.code(),
            Some(2),
            "{out} {more:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}

/// Mitsuba's two surfaces together are the leaf; and the sky is the whole sphere.
#[test]
fn leaves_and_sky_are_what_they_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let population = standing(tuft(1, 1.0, 3), [Vec3::ZERO, Vec3::X]);
    let sun = DVec3::new(0.3, 0.5, -0.4).normalize();
    let light = Light { sky: preetham::sky(3.0, sun), sun: None, air: None, clouds: 0.0 };
    let contents = Contents {
        land: Land { corners: Vec::new(), triangles: Vec::new() },
        population: &population,
        light: &light,
        camera: &Pinhole::look_at(Vec3::Y, Vec3::ZERO, 1.0, 1.5),
        film: &Film { width: 3, height: 2, exposure: 1.0, tone_map: ToneMap::None },
        lens: [0.0, 1.0],
        bounces: 0,
        samples: 1,
    };
    mitsuba::write(folder.path(), &contents).expect("written");
    let xml = fs::read_to_string(folder.path().join("scene.xml")).expect("a scene");
    assert_well_formed(&xml);
    let through = values(&xml, "blendbsdf", "weight")[0];
    let reflectance = values(&xml, "blendbsdf", "reflectance");
    let transmittance = values(&xml, "principledthin", "base_color");
    let leaf = leaf();
    for channel in 0..3 {
        let (mean, passes) = (leaf.mean_reflectance()[channel], leaf.transmittance[channel]);
        assert!(((1.0 - through) * reflectance[channel] - f64::from(mean)).abs() < 1e-6);
        assert!((through * transmittance[channel] - f64::from(passes)).abs() < 1e-6);
    }
    assert!(reflectance.iter().chain(&transmittance).all(|channel| *channel <= 1.0));

    let ([width, height], pixels) = exr::read_picture(&folder.path().join("sky.exr")).expect("a sky");
    for (column, row) in [(0, 0), (17, 256), (900, 100), (512, 400), (3, height - 1)] {
        let azimuth = 2.0 * PI * (f64::from(column) + 0.5) / f64::from(width);
        let zenith = PI * f64::from(row) / f64::from(height - 1);
        let view = DVec3::new(zenith.sin() * azimuth.sin(), zenith.cos(), -zenith.sin() * azimuth.cos());
        let expected = dome::radiance(&light.sky, view);
        let found = pixels[(row * width + column) as usize];
        for (found, expected) in found.iter().zip(expected) {
            assert!((f64::from(*found) / expected - 1.0).abs() < 1e-6, "{column}, {row}");
        }
    }
}

/// Emitters of Mitsuba have one side and can't be instances: a front and a back for each lamp.
#[test]
fn what_glows_has_two_sides() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut lamp = tuft(1, 1.0, 3);
    lamp.materials[0].emission = [100.0, 200.0, 300.0];
    let contents = Contents {
        land: Land { corners: Vec::new(), triangles: Vec::new() },
        population: &standing(lamp, [Vec3::ZERO, Vec3::X]),
        light: &Light { sky: Sky::None, sun: None, air: None, clouds: 0.0 },
        camera: &Pinhole::look_at(Vec3::Y, Vec3::ZERO, 1.0, 1.5),
        film: &Film { width: 3, height: 2, exposure: 0.01, tone_map: ToneMap::None },
        lens: [0.5, 7.0],
        bounces: 3,
        samples: 1,
    };
    mitsuba::write(folder.path(), &contents).expect("written");
    let xml = fs::read_to_string(folder.path().join("scene.xml")).expect("a scene");
    assert_well_formed(&xml);
    assert_eq!(xml.matches("<emitter type=\"area\">").count(), 4);
    assert!(!xml.contains("shapegroup") && !xml.contains("sky.exr"));
    for name in ["model_0_0.ply", "model_0_0_back.ply"] {
        assert_eq!(values(&xml, name, "radiance"), [1.0, 2.0, 3.0]);
        assert!(folder.path().join(name).exists());
    }
    assert_eq!(values(&xml, "thinlens", "focus_distance"), [7.0]);
}

/// The warnings say what is lost, and nothing else.
#[test]
fn losses_are_told() {
    let glaring = Material { transmittance: [0.9; 3], ..grey(0.8) };
    let told = |material: Material, light: Light, sea: bool| {
        let model = terrane::scene::Model {
            name: "ball".into(),
            materials: vec![material],
            levels: vec![terrane::scene::Level {
                detail: 0.0,
                parts: vec![terrane::scene::Part { material: 0, mesh: ball(Vec3::ZERO, 1.0, 1.0, 8, false) }],
            }],
        };
        let contents = Contents {
            land: Land { corners: Vec::new(), triangles: Vec::new() },
            population: &standing(model, [Vec3::ZERO]),
            light: &light,
            camera: &Pinhole::look_at(Vec3::Y, Vec3::ZERO, 1.0, 1.5),
            film: &Film { width: 3, height: 2, exposure: 1.0, tone_map: ToneMap::None },
            lens: [0.0, 1.0],
            bounces: 0,
            samples: 1,
        };
        mitsuba::losses(&contents, sea).len()
    };
    let light = |clouds: f32| {
        let sun = Some(Sun { direction: Vec3::Y, irradiance: [1.0; 3], diameter: 0.01 });
        Light { sky: Sky::None, sun, air: None, clouds }
    };
    assert_eq!(told(grey(0.5), light(0.0), false), 1);
    assert_eq!(told(grey(0.5), light(0.0), true), 2);
    assert_eq!(told(grey(0.5), light(0.3), true), 3);
    assert_eq!(told(glaring, light(0.3), true), 4);
}
