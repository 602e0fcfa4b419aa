//! Every world that comes with the program can be path traced, and its picture holds numbers only.

use crate::kit;
use exr::prelude::read_all_flat_layers_from_file;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The small ones, under validation.
#[test]
fn small_worlds_are_traced_into_numbers() {
    let _turn = kit::turn();
    for name in ["forest/tiny", "island/tiny"] {
        trace(&configs().join(name).with_extension("toml"), "32x18");
    }
}

#[test]
#[ignore = "takes half an hour: the land of every world is made"]
fn all_worlds_are_traced_into_numbers() {
    for folder in ["forest", "island", "landscape"] {
        let entries = fs::read_dir(configs().join(folder)).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        for path in paths.filter(|path| path.extension().is_some_and(|extension| extension == "toml")) {
            trace(&path, "96x54");
        }
    }
}

fn configs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs")
}

/// Light and everything beside it, with as many scatterings as the world has.
fn trace(world: &Path, size: &str) {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.arg("render").arg(world).current_dir(folder.path()).env("TERRANE_VALIDATION", "1");
    command.args([
        "--renderer",
        "trace",
        "--spp",
        "4",
        "--size",
        size,
        "--no-cache",
        "--json",
        "-o",
        "a.exr",
    ]);
    let output = command.output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{}: {told}", world.display());
    // What is not finite counts as black, and is warned of: so is light that is too bright for the sums.
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for warning in report["warnings"].as_array().unwrap() {
        assert!(!warning.as_str().unwrap().contains("samples were"), "{}: {warning}", world.display());
    }
    let image = read_all_flat_layers_from_file(folder.path().join("a.exr")).unwrap();
    for channel in &image.layer_data[0].channel_data.list {
        let mut values = channel.sample_data.values_as_f32();
        assert!(values.all(f32::is_finite), "{}: {}", world.display(), channel.name);
    }
    let lit = |name: &str| {
        let channels = &image.layer_data[0].channel_data.list;
        let channel = channels.iter().find(|channel| channel.name.eq(name)).unwrap();
        channel.sample_data.values_as_f32().map(f64::from).sum::<f64>()
    };
    assert!(lit("R") > 0.0 && lit("albedo.G") > 0.0 && lit("depth.Z") > 0.0, "{} is black", world.display());
}
