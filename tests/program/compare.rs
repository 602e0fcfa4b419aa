//! `terrane compare`: figures that can be worked out by hand, and every way that two files can fail to be the same.

use crate::kit::program::{self, terrane};
use serde_json::Value;
use std::process::Output;
use tempfile::TempDir;
use terrane::formats::{exr, png};

const SIZE: [u32; 2] = [32, 16];

/// Every pixel of the first is 0.5; of the second, one channel of one pixel is 0.75.
#[test]
fn figures_are_those_worked_out_by_hand() {
    let folder = folder();
    let grey = |at: Option<usize>| {
        (0..512).map(|index| [0.5, if at == Some(index) { 0.75 } else { 0.5 }, 0.5]).collect::<Vec<_>>()
    };
    write(&folder, "a.exr", &grey(None));
    write(&folder, "b.exr", &grey(Some(3 * 32 + 7)));

    let same = compare(&folder, &["a.exr", "a.exr", "--json"]);
    assert_eq!(same.status.code(), Some(0));
    let same = json(&same);
    for figure in ["max", "rmse", "relmse", "flip"] {
        assert_eq!(same[figure], 0.0, "{figure}");
    }

    let other = compare(&folder, &["a.exr", "b.exr", "--json"]);
    assert_eq!(other.status.code(), Some(9));
    let other = json(&other);
    let squares = 0.25f64.powi(2) / (512.0 * 3.0);
    near(&other["max"], 0.25);
    near(&other["rmse"], squares.sqrt());
    // f32 0.5 is exact, so that only the mean's own division rounds.
    near(&other["relmse"], squares / (0.25 + 0.01));
    assert!(other["flip"].as_f64().unwrap() > 0.0);
    assert_eq!(other["differs"], true);

    let text = compare(&folder, &["a.exr", "b.exr"]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.contains("max     2.500000e-1   in G, column 7, row 3\n"), "{text}");
}

#[test]
fn a_threshold_is_for_the_metric_that_is_named() {
    let folder = folder();
    write(&folder, "a.exr", &[[0.5; 3]; 512]);
    write(&folder, "b.exr", &[[0.51; 3]; 512]);
    let code = |rest: &[&str]| {
        let arguments: Vec<&str> = ["a.exr", "b.exr", "--quiet"].iter().chain(rest).copied().collect();
        compare(&folder, &arguments).status.code()
    };
    assert_eq!(code(&["--threshold", "0.0101"]), Some(0));
    assert_eq!(code(&["--threshold", "0.0099"]), Some(9));
    assert_eq!(code(&["--metric", "rmse", "--threshold", "0.0101"]), Some(0));
    assert_eq!(code(&["--metric", "rmse", "--threshold", "0.0099"]), Some(9));
    // 0.01² / (0.5² + 0.01)
    assert_eq!(code(&["--metric", "relmse", "--threshold", "0.000386"]), Some(0));
    assert_eq!(code(&["--metric", "relmse", "--threshold", "0.000384"]), Some(9));
    assert_eq!(code(&["--metric", "flip", "--threshold", "1"]), Some(0));
    assert_eq!(code(&["--metric", "flip"]), Some(9));
    assert_eq!(code(&["--threshold", "-1"]), Some(2));
    assert_eq!(code(&["--metric", "psnr"]), Some(2));
}

/// An eye that may choose its exposure sees the same whatever unit the light is counted in; and more where there is more to see.
#[test]
fn what_is_seen_does_not_hang_on_the_unit_of_light() {
    let folder = folder();
    let ramp = |scale: f32, ripple: f32| -> Vec<[f32; 3]> {
        let value = |index: usize| (index % 32 + 1) as f32 * (1.0 + ripple * ((index * 7 % 5) as f32 - 2.0));
        (0..512).map(|index| [scale * value(index); 3]).collect()
    };
    let flip = |scale: f32, ripple: f32| {
        write(&folder, "a.exr", &ramp(scale, 0.0));
        write(&folder, "b.exr", &ramp(scale, ripple));
        json(&compare(&folder, &["a.exr", "b.exr", "--json"]))["flip"].as_f64().unwrap()
    };
    let (little, much) = (flip(1.0, 0.02), flip(1.0, 0.2));
    assert!(0.0 < little && little < much && much < 1.0, "{little} {much}");
    // Powers of two scale floats exactly; what is left are the roots and logarithms that find the exposures.
    let scaled = flip(1024.0, 0.2);
    assert!((scaled - much).abs() < 1e-3 * much, "{scaled} {much}");
}

#[test]
fn black_is_as_far_from_white_as_it_gets() {
    let folder = folder();
    let picture = |name: &str, value: u8| {
        png::write_picture(&folder.path().join(name), SIZE, &[value; 1536]).unwrap();
    };
    picture("black.png", 0);
    picture("white.png", 255);
    let found = compare(&folder, &["black.png", "white.png", "--json", "-o", "seen.png"]);
    assert_eq!(found.status.code(), Some(9));
    let found = json(&found);
    near(&found["max"], 1.0);
    near(&found["rmse"], 1.0);
    assert!(found["flip"].as_f64().unwrap() > 0.9, "{}", found["flip"]);
    assert_eq!(found["outputs"].as_array().unwrap().len(), 1);
    let seen = image::open(folder.path().join("seen.png")).unwrap().into_rgb8();
    assert_eq!(seen.dimensions(), (SIZE[0], SIZE[1]));
    // The bright end of the colours of errors.
    assert!(seen.get_pixel(16, 8).0.iter().all(|&channel| channel > 120), "{:?}", seen.get_pixel(16, 8));
}

/// A value that is none in both pictures is the same; in one of them, nothing is farther away.
#[test]
fn what_is_not_a_number_is_no_number_s_equal() {
    let folder = folder();
    let mut pixels = [[0.5; 3]; 512];
    write(&folder, "a.exr", &pixels);
    for odd in [f32::NAN, f32::INFINITY] {
        pixels[100][2] = odd;
        write(&folder, "b.exr", &pixels);
        let arguments = ["a.exr", "b.exr", "--threshold", "1e30", "--json"];
        assert_eq!(compare(&folder, &arguments).status.code(), Some(9), "{odd}");
        assert_eq!(compare(&folder, &["b.exr", "b.exr"]).status.code(), Some(0), "{odd}");
    }
}

#[test]
fn files_that_do_not_fit_together_are_told_apart() {
    let folder = folder();
    write(&folder, "a.exr", &[[0.5; 3]; 512]);
    let small = folder.path().join("small.exr");
    exr::write_picture(&small, [16, 16], &[[0.5; 3]; 256], 1.0).unwrap();
    let map = folder.path().join("map.exr");
    exr::write_channels(&map, SIZE, vec![("height".into(), vec![1.0; 512])]).unwrap();
    png::write_picture(&folder.path().join("p.png"), SIZE, &[9; 1536]).unwrap();
    std::fs::write(folder.path().join("broken.exr"), b"v/1\x01 and no more").unwrap();

    let told = |arguments: &[&str], code: i32, part: &str| {
        let output = compare(&folder, arguments);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        assert!(error.contains(part), "{arguments:?}: {error}");
    };
    told(&["a.exr", "small.exr"], 9, "16 × 16");
    told(&["a.exr", "map.exr"], 9, "height");
    told(&["a.exr", "p.png"], 2, "a screen");
    told(&["a.exr", "broken.exr"], 7, "broken.exr");
    told(&["a.exr", "none.exr"], 7, "none.exr");
    told(&["a.exr", "a.exr", "-o", "seen.jpg"], 2, ".png");
    told(&["a.exr", "a.exr", "-o", "none/seen.png"], 7, "none");
    told(&["map.exr", "map.exr", "-o", "seen.png"], 2, "nothing to see");
    assert_eq!(compare(&folder, &["map.exr", "map.exr"]).status.code(), Some(0));
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn write(folder: &TempDir, name: &str, pixels: &[[f32; 3]]) {
    exr::write_picture(&folder.path().join(name), SIZE, pixels, 1.0).unwrap();
}

fn compare(folder: &TempDir, arguments: &[&str]) -> Output {
    terrane(folder.path(), &[&["compare"], arguments].concat())
}

fn json(output: &Output) -> Value {
    let object = program::json(output);
    let comparison = object["comparison"].as_object().unwrap().clone();
    let mut object = object.as_object().unwrap().clone();
    object.extend(comparison);
    Value::Object(object)
}

/// As many digits as sums of 1536 doubles have.
fn near(found: &Value, expected: f64) {
    let found = found.as_f64().unwrap();
    assert!((found - expected).abs() <= 1e-12 * expected, "{found} for {expected}");
}
