//! The program itself: what it writes, prints and exits with, and that it leaves no half-written file.

use crate::kit::program::{self, code, json, stderr};
use exr::prelude::{ReadChannels, ReadLayers};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A world that takes a second.
const WORLD: &str = r#"
format = 1
seed = 5
[terrain]
cells = 64
extent = 2000
layers = [{ cone = { height = 500, radius = 900 } }, { simplex = { amplitude = 60, wavelength = 500, octaves = 4 } }]
[erosion.hydraulic]
duration = 60
[reef]
stages = [{ duration = 500, rise = 4 }]
[render]
size = [64, 36]
"#;

/// A world with nothing but bare ground.
const BARE: &str = r#"
format = 1
erosion = "none"
reef = "none"
[terrain]
cells = 64
extent = 2000
layers = [{ cone = { height = 500, radius = 900 } }]
"#;

// What is written.

#[test]
fn a_picture_is_named_after_its_world_and_two_runs_give_the_same_bytes() {
    let folder = folder();
    let output = terrane(folder.path(), &["render", "world.toml", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let first = fs::read(folder.path().join("world.png")).unwrap();
    assert_eq!(
        terrane(folder.path(), &["render", "world.toml", "--quiet", "-o", "again.png"]).status.code(),
        Some(0)
    );
    assert!(first == fs::read(folder.path().join("again.png")).unwrap());
    // Another seed is another land.
    let other =
        terrane(folder.path(), &["render", "world.toml", "--quiet", "-o", "other.png", "--seed", "6"]);
    assert_eq!(code(&other), 0);
    assert!(first != fs::read(folder.path().join("other.png")).unwrap());

    let picture = image::open(folder.path().join("world.png")).unwrap();
    assert_eq!((picture.width(), picture.height(), picture.color()), (64, 36, image::ColorType::Rgb8));

    let json = json(&output);
    assert_eq!(json["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(json["command"], "render");
    assert_eq!(json["world"], "world.toml");
    assert_eq!(json["seed"], 5);
    assert!(json["device"].is_string());
    assert_eq!(json["error"], Value::Null);
    let stages: Vec<&str> =
        json["stages"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    for name in ["base terrain", "erosion", "reef", "picture"] {
        assert!(stages.contains(&name), "{stages:?}");
    }
    for stage in json["stages"].as_array().unwrap() {
        assert!(
            stage["seconds"].as_f64().unwrap() >= 0.0 && stage["iterations"].as_u64().unwrap() > 0,
            "{stage}"
        );
    }
    let outputs = json["outputs"].as_array().unwrap();
    assert_eq!(outputs.len(), 1);
    assert_eq!(outputs[0]["path"], "./world.png");
    assert_eq!(outputs[0]["bytes"], first.len());
    assert_eq!(outputs[0]["sha256"], sha256(&first));
    assert_eq!(json["frames"], Value::Array(vec![]));
}

#[test]
fn a_picture_in_exr_holds_radiance_and_says_its_white() {
    let folder = folder();
    let arguments = ["render", "world.toml", "-o", "pictures/", "--size", "48x20"];
    assert_eq!(code(&terrane(folder.path(), &arguments)), 0);
    assert_eq!(names(&folder.path().join("pictures")), ["world.png"]);
    assert_eq!(
        code(&terrane(folder.path(), &["render", "world.toml", "-o", "pictures/a.exr", "--size", "48x20"])),
        0
    );
    let picture = exr::prelude::read_first_rgba_layer_from_file(
        folder.path().join("pictures/a.exr"),
        |size, _| (size.width(), size.height(), 0.0_f64),
        |sum, _, (r, g, b, _): (f32, f32, f32, f32)| sum.2 += f64::from(r + g + b),
    )
    .unwrap();
    let (width, height, sum) = picture.layer_data.channel_data.pixels;
    assert_eq!((width, height), (48, 20));
    assert!(sum.is_finite() && sum > 0.0);
    assert!(picture.layer_data.attributes.white_luminance.unwrap() > 0.0);
}

#[test]
fn a_traced_picture_has_layers_and_the_same_bytes_again() {
    let folder = folder();
    let trace = |out: &str, more: &[&str]| {
        let arguments =
            ["render", "bare.toml", "--renderer", "trace", "--size", "32x18", "--json", "-o", out];
        let output = terrane(folder.path(), &[&arguments, more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        output
    };
    trace("one.exr", &["--spp", "2"]);
    trace("two.exr", &["--spp", "2"]);
    assert!(
        fs::read(folder.path().join("one.exr")).unwrap() == fs::read(folder.path().join("two.exr")).unwrap()
    );
    let channels = read_exr(&folder.path().join("one.exr"));
    let channel =
        |name: &str| &channels.iter().find(|(it, _)| it == name).unwrap_or_else(|| panic!("{name}")).1;
    for name in [
        "R",
        "G",
        "B",
        "A",
        "albedo.R",
        "normal.Y",
        "position.X",
        "depth.Z",
        "object.Y",
        "samples.Y",
        "variance.G",
    ] {
        assert!(channel(name).iter().all(|value| value.is_finite()), "{name}");
    }
    assert!(channel("samples.Y").iter().all(|samples| *samples == 2.0));
    // Sky above, which is no surface, and the island or the sea below, which faces up and is some way off.
    assert_eq!(channel("depth.Z")[0], 0.0);
    assert!(channel("depth.Z")[32 * 17 + 16] > 100.0 && channel("normal.Y")[32 * 17 + 16] > 0.3);

    trace("half.exr", &["--spp", "1", "--half"]);
    let bytes = |name: &str| fs::metadata(folder.path().join(name)).unwrap().len();
    assert!(bytes("half.exr") < bytes("one.exr"));
    // It ends when it is told to, whatever is left to do.
    trace("limited.png", &["--spp", "1000000", "--time-limit", "0.1"]);
    trace("clean.png", &["--spp", "1000000", "--noise", "10"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_trace_leaves_what_it_has() {
    let folder = folder();
    let arguments = [
        "render",
        "bare.toml",
        "--renderer",
        "trace",
        "--size",
        "32x18",
        "--spp",
        "1000000",
        "-o",
        "part.png",
        "--json",
    ];
    let mut child = command(folder.path(), &arguments)
        .env("TERRANE_CACHE_INTERVAL", "0")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("acceleration")));
    // The picture so far is written at intervals.
    while !folder.path().join("part.png").exists() {
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 130);
    assert_eq!(image::open(folder.path().join("part.png")).unwrap().width(), 32);
    assert_eq!(json(&output)["outputs"].as_array().unwrap().len(), 1);
}

#[test]
fn every_layer_is_a_file_with_a_sidecar() {
    let folder = folder();
    let output = terrane(folder.path(), &["export", "world.toml", "--layer", "all", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let layers = [
        ("height", "m", vec!["height"]),
        ("water", "m", vec!["water"]),
        ("sediment", "m", vec!["sediment"]),
        ("wear", "m", vec!["wear"]),
        ("deposit", "m", vec!["deposit"]),
        ("reef", "m", vec!["reef"]),
        ("flow", "m³/s", vec!["flow"]),
        ("slope", "degrees", vec!["slope"]),
        ("normal", "1", vec!["B", "G", "R"]),
        ("splat", "1", vec!["A", "B", "G", "R"]),
        ("wetness", "1", vec!["wetness"]),
    ];
    assert_eq!(names(&folder.path().join("world")).len(), 2 * layers.len());
    assert_eq!(json(&output)["outputs"].as_array().unwrap().len(), 2 * layers.len());
    for (name, unit, channels) in layers {
        let path = folder.path().join(format!("world/{name}.exr"));
        let read = read_exr(&path);
        assert_eq!(read.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), channels);
        let sidecar: Value =
            serde_json::from_slice(&fs::read(path.with_extension("exr.json")).unwrap()).unwrap();
        assert_eq!(sidecar["unit"], unit, "{name}");
        assert_eq!(
            (&sidecar["extent"], &sidecar["seed"], &sidecar["world"]),
            (&2000.0.into(), &5.into(), &"world.toml".into())
        );
        assert!((sidecar["cell_size"].as_f64().unwrap() - 2000.0 / 63.0).abs() < 1e-5);
        assert!(sidecar["sea_level"].is_number());
        assert_eq!(sidecar["world_sha256"], sha256(WORLD.as_bytes()));
        assert_eq!(sidecar["set"], Value::Array(vec![]));
        let [min, max] = ["min", "max"].map(|key| sidecar[key].as_f64().unwrap() as f32);
        for (_, values) in &read {
            assert_eq!(values.len(), 64 * 64);
            assert!(values.iter().all(|&value| min <= value && value <= max), "{name} {min} {max}");
        }
        if channels.len() == 1 {
            let least = read[0].1.iter().copied().fold(f32::INFINITY, f32::min);
            assert_eq!(least, min, "{name}");
        }
    }
}

#[test]
fn layers_in_one_exr_are_channels() {
    let folder = folder();
    let arguments =
        ["export", "world.toml", "--layer", "splat", "height", "--layer", "water", "-o", "land.exr"];
    assert_eq!(code(&terrane(folder.path(), &arguments)), 0);
    let names: Vec<String> =
        read_exr(&folder.path().join("land.exr")).into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["height", "splat.A", "splat.B", "splat.G", "splat.R", "water"]);
    let sidecar: Value =
        serde_json::from_slice(&fs::read(folder.path().join("land.exr.json")).unwrap()).unwrap();
    assert_eq!(sidecar["channels"]["height"]["unit"], "m");
}

#[test]
fn a_height_map_can_be_the_ground_of_another_world() {
    let folder = folder();
    assert_eq!(code(&terrane(folder.path(), &["export", "bare.toml", "-o", "h.png"])), 0);
    let height = image::open(folder.path().join("h.png")).unwrap();
    assert_eq!((height.width(), height.color()), (64, image::ColorType::L16));
    // With its sidecar beside it, the heights are known.
    let again = "format = 1\nerosion = \"none\"\nreef = \"none\"\n[terrain]\ncells = 64\nextent = 2000\nlayers = [{ heightmap = { file = \"h.png\" } }]\n";
    fs::write(folder.path().join("again.toml"), again).unwrap();
    let output = terrane(folder.path(), &["export", "again.toml", "-o", "again.exr"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(code(&terrane(folder.path(), &["export", "bare.toml", "-o", "first.exr"])), 0);
    let (first, again) =
        (read_exr(&folder.path().join("first.exr")), read_exr(&folder.path().join("again.exr")));
    for (first, again) in first[0].1.iter().zip(&again[0].1) {
        assert!((first - again).abs() < 0.01, "{first} {again}");
    }
}

#[test]
fn a_sidecar_says_how_to_make_the_land_again() {
    let folder = folder();
    let set = ["terrain.extent=3000", "terrain.layers.0.cone.height=400"];
    let output = terrane(
        folder.path(),
        &["export", "bare.toml", "-o", "h.exr", "--set", set[0], "--seed", "9", "--set", set[1]],
    );
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let sidecar =
        || -> Value { serde_json::from_slice(&fs::read(folder.path().join("h.exr.json")).unwrap()).unwrap() };
    let first = sidecar();
    assert_eq!((&first["seed"], &first["world_sha256"]), (&9.into(), &sha256(BARE.as_bytes()).into()));
    assert_eq!(first["set"], Value::from(set.to_vec()));

    let height = fs::read(folder.path().join("h.exr")).unwrap();
    let mut again = vec!["export".into(), first["world"].as_str().unwrap().to_owned()];
    again.extend(["-o", "h.exr", "--seed"].map(String::from));
    again.push(first["seed"].to_string());
    for set in first["set"].as_array().unwrap() {
        again.extend(["--set".into(), set.as_str().unwrap().to_owned()]);
    }
    let again: Vec<&str> = again.iter().map(String::as_str).collect();
    assert_eq!(code(&terrane(folder.path(), &again)), 0);
    assert!(height == fs::read(folder.path().join("h.exr")).unwrap());
    assert_eq!(first, sidecar());
}

#[test]
fn a_check_prints_the_plan_and_makes_nothing() {
    let folder = folder();
    let before = names(folder.path());
    let output = terrane(folder.path(), &["check", "world.toml"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    for part in ["64 × 64", "erosion", "model seconds", "reef", "memory", "64 × 36 pixels"] {
        assert!(text.contains(part), "{text}");
    }
    // It does without a device, and then can't know how long.
    let mut without = command(folder.path(), &["check", "world.toml", "--json"]);
    // The loader tells the validation layer that there is no driver, which is no fault here.
    let output = without.envs(NO_DRIVER).env_remove("TERRANE_VALIDATION").output().unwrap();
    assert_eq!(code(&output), 0);
    let plan = &json(&output)["plan"];
    assert_eq!(plan["cells"], 64);
    assert!(
        plan["time_step"].as_f64().unwrap() > 0.0 && plan["memory_bytes"].as_u64().unwrap() > 64 * 64 * 4
    );
    assert_eq!(plan["stages"][0]["name"], "base terrain");
    assert_eq!((&plan["seconds"], &plan["stages"][0]["seconds"]), (&Value::Null, &Value::Null));
    let picture = &plan["picture"];
    let parts = picture["memory"].as_array().unwrap();
    assert!(parts.iter().any(|part| part["name"] == "tile"), "{picture}");
    for part in [plan, picture, &plan["host"]] {
        let parts = part["memory"].as_array().unwrap();
        let sum: u64 = parts.iter().map(|part| part["bytes"].as_u64().unwrap()).sum();
        assert_eq!(part["memory_bytes"], sum);
    }
    // Nothing is known of what there is.
    assert_eq!(plan["largest_cells"], Value::Null);
    assert_eq!(names(folder.path()), before);
}

#[test]
fn a_check_estimates_how_long_the_land_takes() {
    let folder = folder();
    let seconds = |cells: u32| {
        let cells = format!("terrain.cells={cells}");
        let output = terrane(folder.path(), &["check", "world.toml", "--json", "--set", &cells]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let json = json(&output);
        assert!(json["device"].is_string());
        let plan = &json["plan"];
        let stages: Vec<f64> = plan["stages"]
            .as_array()
            .unwrap()
            .iter()
            .map(|stage| stage["seconds"].as_f64().unwrap())
            .collect();
        assert!(stages.iter().all(|seconds| *seconds > 0.0), "{plan}");
        let all = plan["seconds"].as_f64().unwrap();
        assert!((all - stages.iter().sum::<f64>()).abs() < 1e-6 * all);
        all
    };
    // Sixteen times the cells, four times the steps, and sixteen times the sweeps of the reef.
    assert!(seconds(1024) > 10.0 * seconds(256));

    let output = terrane(folder.path(), &["check", "world.toml"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("\ntime     about "));
    let output = terrane(folder.path(), &["check", "world.toml", "--json", "--no-time"]);
    let json = json(&output);
    assert_eq!((&json["device"], &json["plan"]["seconds"]), (&Value::Null, &Value::Null));
}

#[test]
fn devices_are_listed() {
    let folder = folder();
    let output = terrane(folder.path(), &["devices", "--json"]);
    assert_eq!(code(&output), 0);
    let json = json(&output);
    let devices = json["devices"].as_array().unwrap();
    assert!(devices.iter().any(|device| device["usable"] == true), "{json}");
    let name = devices[0]["name"].as_str().unwrap();
    let output = terrane(folder.path(), &["devices"]);
    assert!(String::from_utf8(output.stdout).unwrap().contains(name));
}

#[test]
fn the_bench_tells_every_process_at_every_size() {
    let folder = folder();
    let output = terrane(folder.path(), &["bench", "--cells", "48,64", "--time", "0.005", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let json = json(&output);
    assert_eq!((&json["command"], &json["error"]), (&"bench".into(), &Value::Null));
    assert!(json["device"].is_string() && json["driver"].is_string());
    assert!(json["cores"].as_u64().unwrap() > 0 && json["copy_bandwidth"].as_f64().unwrap() > 0.0);
    let rows = json["rows"].as_array().unwrap();
    let names = ["base", "hydraulic", "hydraulic_paper", "thermal", "reef", "reef_sweep"];
    let expected: Vec<(u64, &str)> =
        [48, 64].into_iter().flat_map(|size| names.map(|name| (size, name))).collect();
    let told: Vec<(u64, &str)> =
        rows.iter().map(|row| (row["size"].as_u64().unwrap(), row["name"].as_str().unwrap())).collect();
    assert_eq!(told, expected);
    for row in rows {
        let of = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        for key in ["ns_per_cell", "bytes_per_cell", "bandwidth_share", "native_ns_per_cell", "ratio"] {
            assert!(of(key) > 0.0 && of(key).is_finite(), "{key} of {row}");
        }
        assert!((of("ratio") - of("ns_per_cell") / of("native_ns_per_cell")).abs() < 1e-9 * of("ratio"));
    }
    // A pass of carbon reads one image beside it, and the ground.
    assert_eq!(rows[5]["bytes_per_cell"], 12.0);

    let table = terrane(folder.path(), &["bench", "--cells", "48", "--time", "0.005", "--quiet"]);
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(names.iter().all(|name| table.contains(&format!("| `{name}` | 48 |"))), "{table}");
}

// What goes wrong.

/// Where the Vulkan loader is to look for drivers, by its new name and its old one.
const NO_DRIVER: [(&str, &str); 2] =
    [("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")];

/// Fails with the code and a message that has every part, says the same in JSON, has simulated nothing and leaves
/// nothing behind.
fn refused(arguments: &[&str], expected: i32, parts: &[&str]) {
    let folder = folder();
    let before = names(folder.path());
    let arguments: Vec<&str> = arguments.iter().copied().chain(["--json"]).collect();
    let output = terrane(folder.path(), &arguments);
    let message = stderr(&output);
    assert_eq!(code(&output), expected, "{arguments:?}: {message}");
    for part in parts {
        assert!(message.contains(part), "{arguments:?}: `{part}` is not in: {message}");
    }
    let json = json(&output);
    assert_eq!(json["error"]["exit_code"], expected, "{arguments:?}");
    for part in parts {
        assert!(json["error"]["message"].as_str().unwrap().contains(part), "{arguments:?}: {json}");
    }
    assert_eq!(json["stages"], Value::Array(vec![]), "{arguments:?}");
    assert_eq!(json["outputs"], Value::Array(vec![]), "{arguments:?}");
    assert_eq!(names(folder.path()), before, "{arguments:?}");
}

#[test]
fn arguments_that_make_no_sense_are_refused() {
    refused(&["render"], 2, &["<WORLD>"]);
    refused(&["render", "world.toml", "--size", "64"], 2, &["1280x720"]);
    refused(&["render", "world.toml", "--size", "0x20"], 2, &["between 1 and"]);
    refused(&["render", "world.toml", "--renderer", "radiosity"], 2, &["raster or trace"]);
    refused(&["render", "world.toml", "--renderer", "trace", "--spp", "0"], 2, &["--spp"]);
    refused(&["render", "world.toml", "--renderer", "trace", "--noise", "0"], 2, &["above 0"]);
    refused(&["render", "world.toml", "--renderer", "trace", "--time-limit", "nan"], 2, &["seconds"]);
    refused(&["render", "world.toml", "--memory-limit", "2 bananas"], 2, &["GiB"]);
    refused(&["render", "world.toml", "-o", "picture.jpg"], 2, &["picture.jpg", ".png or .exr"]);
    refused(&["render", "world.toml", "-o", "picture"], 2, &[".png or .exr", "ends in /"]);
    refused(&["export", "world.toml", "--layer", "heights"], 2, &["heights", "height"]);
    refused(&["export", "world.toml", "--layer", "height", "water", "-o", "a.png"], 2, &["a.png", ".exr"]);
    refused(&["export", "world.toml", "-o", "a.png", "--format", "exr"], 2, &["contradict"]);
}

#[test]
fn mistakes_in_a_world_are_refused() {
    refused(&["render", "world.toml", "--set", "terrain.cells=63"], 3, &["terrain.cells"]);
    refused(&["render", "world.toml", "--set", "terrain.celsl=64"], 3, &["celsl", "cells"]);
    refused(&["export", "bare.toml", "--layer", "reef"], 3, &["bare", "`reef`", "height"]);
}

/// Layers that are allowed one by one: their product is 10,000 km high, and infinite with ten of them.
#[test]
fn ground_beyond_all_measure_is_refused() {
    let folder = folder();
    for factors in [1, 10] {
        let factors =
            ["{ simplex = { combine = 'multiply', offset = 20000, amplitude = 0 } }"].repeat(factors);
        let layers =
            format!("terrain.layers=[{{ cone = {{ height = 500, radius = 900 }} }}, {}]", factors.join(", "));
        let output = terrane(folder.path(), &["export", "bare.toml", "--set", &layers]);
        assert_eq!(code(&output), 3, "{}", stderr(&output));
        assert!(stderr(&output).contains("error: `terrain.layers` make ground"), "{}", stderr(&output));
    }
}

#[test]
fn what_cannot_be_read_or_written_is_named() {
    refused(&["render", "missing.toml"], 7, &["missing.toml"]);
    // A folder of settings that lacks all of them.
    refused(&["render", "directory"], 3, &["directory"]);
    refused(&["check", "directory"], 3, &["directory"]);
    refused(&["render", "world.toml", "-o", "missing/a.png"], 7, &["missing/a.png", "make its folder first"]);
    refused(&["render", "world.toml", "-o", "missing/folder/"], 7, &["missing/folder"]);
    refused(&["render", "world.toml", "-o", "world.toml/a.png"], 7, &["world.toml/a.png"]);
    refused(&["export", "world.toml", "-o", "missing/folder/"], 7, &["missing/folder"]);
    refused(&["export", "world.toml", "-o", "bare.toml/"], 7, &["bare.toml", "a file bears", "-o"]);
    // The folder that export makes when none is named.
    let folder = folder();
    fs::write(folder.path().join("world"), "").unwrap();
    let output = terrane(folder.path(), &["export", "world.toml"]);
    assert_eq!(code(&output), 7);
    assert!(stderr(&output).contains("name another folder with -o"), "{}", stderr(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_nobody_may_write_is_refused() {
    // Not even root may make files there.
    refused(&["render", "world.toml", "-o", "/proc/a.png"], 7, &["/proc/a.png"]);
    refused(&["export", "world.toml", "-o", "/proc/self/"], 7, &["/proc/self/height.exr"]);
}

#[test]
fn devices_and_drivers_that_are_not_there_are_refused() {
    refused(&["render", "world.toml", "--device", "nonesuch"], 4, &["nonesuch"]);
    refused(&["render", "world.toml", "--device", "99"], 4, &["99"]);

    let folder = folder();
    let before = names(folder.path());
    for arguments in [&["render", "world.toml"][..], &["devices"]] {
        let output = command(folder.path(), arguments).envs(NO_DRIVER).output().unwrap();
        assert_eq!(code(&output), 4, "{}", stderr(&output));
        assert!(stderr(&output).contains("mesa-vulkan-drivers"), "{}", stderr(&output));
        assert_eq!(names(folder.path()), before);
    }
}

#[test]
fn memory_is_not_taken_beyond_the_limit() {
    refused(&["render", "world.toml", "--memory-limit", "100KiB"], 6, &["--memory-limit"]);
    refused(&["check", "world.toml", "--memory-limit", "100KiB"], 6, &["--memory-limit", "terrain.cells"]);
    refused(&["bench", "--cells", "512", "--memory-limit", "1MiB"], 6, &["give --cells less"]);
    // There is room for the simulation, and not for the picture.
    let large = ["--memory-limit", "4MiB", "--set", "render.size=[400,400]"];
    for verb in ["render", "check"] {
        let arguments = [&[verb, "world.toml"][..], &large].concat();
        refused(&arguments, 6, &["the picture needs", "4.0 MiB may be used", "the picture's size"]);
    }
    // Nothing of it has been made by then, and no folder for it.
    refused(&["export", "world.toml", "-o", "maps/", "--memory-limit", "100KiB"], 6, &["the land needs"]);
    let layers = ["export", "bare.toml", "--layer", "height", "normal", "--memory-limit", "300KiB"];
    refused(&layers, 6, &["the land needs"]);
    refused(&["render", "world.toml", "--size", "16384x16384"], 6, &["4608.0 MiB", "3072.0 MiB", "--size"]);
}

/// Four million cells, to the end: 250 s of rain and ten steps of the reef.
#[test]
#[ignore = "takes four minutes on two cores"]
fn a_large_land_is_made_to_the_end() {
    let folder = folder();
    let volcano = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/island/volcano.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_terrane"))
        .args(["render", volcano, "--json", "--no-cache", "-o", "large.png"])
        .args(["--set", "terrain.cells=2048", "--set", "erosion.hydraulic.duration=250"])
        .args(["--set", "reef.stages=[{ duration = 250, rise = 1 }]"])
        .current_dir(folder.path())
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    assert_eq!(code(&output), 0);
    let json = json(&output);
    let stages = json["stages"].as_array().unwrap();
    let reef = stages.iter().find(|stage| stage["name"] == "reef").unwrap();
    assert_eq!(reef["iterations"], 10);
    let picture = image::open(folder.path().join("large.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (1280, 720));
}

/// What a refusal says would do does, and one cell more does not.
#[test]
fn a_land_too_large_is_refused_with_the_figures() {
    let folder = folder();
    let check = |cells: u64, limit: &str| {
        let cells = format!("terrain.cells={cells}");
        terrane(folder.path(), &["check", "world.toml", "--json", "--set", &cells, "--memory-limit", limit])
    };
    for (cells, limit) in [(4096, "1638MiB"), (8192, "1638MiB"), (8192, "4GiB")] {
        let output = check(cells, limit);
        assert_eq!(code(&output), 6, "{}", stderr(&output));
        let largest = json(&output)["plan"]["largest_cells"].as_u64().unwrap();
        for part in ["the land needs", "flow ", "water ", &format!("lower terrain.cells: {largest} would do")]
        {
            assert!(stderr(&output).contains(part), "`{part}` is not in: {}", stderr(&output));
        }
        assert_eq!(code(&check(largest, limit)), 0);
        assert_eq!(code(&check(largest + 1, limit)), 6);
    }
    let roomy = check(8192, "16GiB");
    assert_eq!((code(&roomy), &json(&roomy)["plan"]["largest_cells"]), (0, &8192.into()));
    // Neither a smaller grid nor a smaller picture: nothing is promised.
    refused(&["check", "world.toml", "--memory-limit", "100KiB"], 6, &["alone are not enough"]);
    // The same for layers, before anything is made; the renderer's maps come on top.
    let export = ["export", "world.toml", "--set", "terrain.cells=4096", "--memory-limit", "1GiB", "--layer"];
    refused(&[&export[..], &["height"]].concat(), 6, &["flow ", "would do"]);
    refused(&[&export[..], &["all"]].concat(), 6, &["maps ", "would do"]);
    refused(
        &["render", "world.toml", "--set", "terrain.cells=4096", "--memory-limit", "1GiB"],
        6,
        &["would do"],
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_no_file() {
    let folder = folder();
    fs::create_dir(folder.path().join("disk")).unwrap();
    // A disk of one page, where a process may mount one; else files may have one block.
    let mount = "mount -t tmpfs -o size=4k none disk";
    let may_mount = Command::new("unshare")
        .args(["-rm", "sh", "-c", mount])
        .current_dir(folder.path())
        .output()
        .is_ok_and(|output| output.status.success());
    let (shell, prepare): (&[&str], _) =
        if may_mount { (&["unshare", "-rm", "sh"], mount) } else { (&["sh"], "trap '' XFSZ; ulimit -f 2") };
    for (verb, name) in [("render", "a.exr"), ("export", "height.exr")] {
        let script = format!(
            "{prepare} && \"$0\" {verb} world.toml -o disk/{name} --quiet --no-cache; code=$?; ls -A disk; exit $code"
        );
        let output = Command::new(shell[0])
            .args(&shell[1..])
            .args(["-c", &script, env!("CARGO_BIN_EXE_terrane")])
            .current_dir(folder.path())
            // Its files would be cut too.
            .env("MESA_SHADER_CACHE_DISABLE", "true")
            .output()
            .unwrap();
        assert_eq!(code(&output), 7, "{}", stderr(&output));
        assert!(stderr(&output).contains(&format!("disk/{name}")), "{}", stderr(&output));
        assert!(stderr(&output).contains("free some space"), "{}", stderr(&output));
        assert_eq!(output.stdout, b"", "left behind: {}", String::from_utf8_lossy(&output.stdout));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_ends_with_130_and_leaves_no_file() {
    for signal in ["INT", "TERM"] {
        let folder = folder();
        let before = names(folder.path());
        let endless = ["render", "world.toml", "--json", "--set", "erosion.hydraulic.duration=100000"];
        let mut child =
            command(folder.path(), &endless).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        // The first stage is over: the simulation is under way.
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().starts_with("base terrain")));
        let pid = child.id().to_string();
        assert!(Command::new("kill").args([format!("-{signal}"), pid]).status().unwrap().success());

        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), 130);
        assert!(lines.any(|line| line.unwrap() == "error: interrupted; no file was written"));
        let json = json(&output);
        assert_eq!(json["error"]["exit_code"], 130);
        assert_eq!(json["outputs"], Value::Array(vec![]));
        assert_eq!(names(folder.path()), before);
    }
}

/// What grows for minutes ends at once.
#[cfg(unix)]
#[test]
fn interrupted_growth_ends_with_130() {
    let folder = folder();
    let slow =
        "variants = 64\nsteps = 100000\ngrammar = '''\naxiom A(1)\nA(x) -> A(sqrt(x+1)*sin(x))F\n'''\n";
    let world = "format = 1\nplants = [{ scatter = { species = ['slow'] } }]\n[species.slow]\n";
    fs::write(folder.path().join("slow.toml"), format!("format = 1\n{slow}")).unwrap();
    fs::write(folder.path().join("forest.toml"), format!("{world}{slow}")).unwrap();
    for arguments in [&["check", "--no-time", "forest.toml"][..], &["plant", "slow.toml", "--stats"]] {
        let mut child = command(folder.path(), arguments).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(500));
        let start = std::time::Instant::now();
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{arguments:?}");
        assert!(start.elapsed().as_secs() < 2, "{arguments:?}: {:?}", start.elapsed());
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_picture_leaves_no_file() {
    let folder = folder();
    let before = names(folder.path());
    let large = ["render", "bare.toml", "--json", "--size", "4096x4096", "-o", "pictures/"];
    let mut child =
        command(folder.path(), &large).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("base terrain")));
    // The simulation looks once more whether it is to end.
    std::thread::sleep(std::time::Duration::from_millis(200));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());

    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 130);
    assert!(lines.any(|line| line.unwrap() == "error: interrupted; no file was written"));
    let json = json(&output);
    let picture = &json["stages"][1];
    assert_eq!(picture["name"], "picture", "{json}");
    assert!(picture["iterations"].as_u64().unwrap() < 64, "it was drawn to its end");
    assert_eq!(names(folder.path()), before);
}

#[cfg(unix)]
#[test]
fn an_interrupted_export_says_what_it_has_written() {
    let folder = folder();
    let all = ["export", "world.toml", "--json", "--layer", "all", "--set", "terrain.cells=512"];
    let short = ["--set", "erosion.hydraulic.duration=1", "--set", "reef=\"none\""];
    let mut child = command(folder.path(), &[&all[..], &short].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("wrote")));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());

    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 130);
    let written = json(&output)["outputs"].as_array().unwrap().len();
    assert_eq!(names(&folder.path().join("world")).len(), written);
    let expected = format!("error: interrupted; {written} files had been written, and are whole");
    assert!(lines.any(|line| line.unwrap() == expected));
}

#[cfg(unix)]
#[test]
fn an_interrupted_bench_tells_what_it_has_measured() {
    for json_asked in [true, false] {
        let folder = folder();
        let slow = ["bench", "--cells", "48,2048", "--time", "0.3"];
        let mut bench = command(folder.path(), &slow);
        if json_asked {
            bench.arg("--json");
        }
        let mut child = bench.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().starts_with("reef_sweep")));
        assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());

        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), 130);
        if json_asked {
            let json = json(&output);
            assert_eq!(json["error"]["exit_code"], 130);
            let rows = json["rows"].as_array().unwrap().len();
            assert!((6..12).contains(&rows), "{json}");
        } else {
            let table = String::from_utf8(output.stdout).unwrap();
            assert!(table.contains("| `reef_sweep` | 48 |"), "{table}");
            assert!(!table.contains("| `reef_sweep` | 2048 |"), "{table}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_does_not_fit_its_disk_is_a_failure() {
    let folder = folder();
    for (arguments, expected) in [
        (&["check", "world.toml", "--no-time", "--json"][..], 7),
        (&["check", "world.toml", "--no-time"], 7),
        (&["devices"], 7),
        // What went wrong first counts.
        (&["check", "world.toml", "--seed", "x", "--json"], 2),
        (&["check", "bare.toml", "--set", "terrain.cells=1", "--json"], 3),
    ] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = command(folder.path(), arguments).stdout(full).output().unwrap();
        assert_eq!(code(&output), expected, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("standard output"), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn nobody_reading_is_no_failure() {
    let folder = folder();
    for arguments in
        [&["check", "world.toml"][..], &["check", "world.toml", "--json"], &["devices"], &["--help"]]
    {
        let mut child =
            command(folder.path(), arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().unwrap().code(), Some(0), "{arguments:?}");
    }
    let mut child =
        command(folder.path(), &["render", "missing.toml"]).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(7));
}

#[test]
fn quiet_is_quiet() {
    let folder = folder();
    let output = terrane(folder.path(), &["export", "bare.toml", "-q", "-o", "h.exr"]);
    assert_eq!((code(&output), stderr(&output).as_str(), output.stdout.as_slice()), (0, "", &b""[..]));
}

// Helpers.

/// A folder with the worlds, and a directory.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), WORLD).unwrap();
    fs::write(folder.path().join("bare.toml"), BARE).unwrap();
    fs::create_dir(folder.path().join("directory")).unwrap();
    folder
}

/// A program that keeps nothing.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program::command(folder, arguments);
    if let Some(&"render" | &"export") = arguments.first() {
        command.arg("--no-cache");
    }
    command
}

fn terrane(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Channels by name, as an independent reader finds them.
fn read_exr(path: &Path) -> Vec<(String, Vec<f32>)> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let channels = image.layer_data.channel_data.list.into_iter();
    channels
        .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
        .collect()
}

fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
