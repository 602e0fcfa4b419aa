//! `terrane export` as other programs meet it: sizes, ranges, byte orders, tiles, and the way back into a world.

use crate::kit;
use crate::kit::program::{self, code, stderr};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// What every layer is, in the order of the exported files, with its channels.
const LAYERS: [(&str, usize); 11] = [
    ("height", 1),
    ("water", 1),
    ("sediment", 1),
    ("wear", 1),
    ("deposit", 1),
    ("reef", 1),
    ("flow", 1),
    ("slope", 1),
    ("normal", 3),
    ("splat", 4),
    ("wetness", 1),
];

#[test]
fn every_layer_is_the_same_in_every_format() {
    let folder = folder();
    for format in ["exr", "tif", "png16", "r16"] {
        export(&folder, &["--layer", "all", "--format", format, "-o", &format!("{format}/")]);
    }
    for (layer, channels) in LAYERS {
        let floats = read_exr(&folder.path().join(format!("exr/{layer}.exr")));
        assert_eq!(floats.len(), 65 * 65 * channels, "{layer}");
        assert_eq!(
            read_tif(&folder.path().join(format!("tif/{layer}.tif"))),
            (65, floats.clone()),
            "{layer}"
        );

        let png = folder.path().join(format!("png16/{layer}.png"));
        let [min, max] = range(&png);
        let image = image::open(&png).unwrap();
        let integers: Vec<u16> = match channels {
            1 => image.into_luma16().into_raw(),
            3 => image.into_rgb16().into_raw(),
            _ => image.into_rgba16().into_raw(),
        };
        close(layer, &floats, &integers, [min, max]);
        let raw = folder.path().join(format!("r16/{layer}.r16"));
        assert_eq!(raw.exists(), channels == 1, "{layer}");
        if channels == 1 {
            assert!(integers == read_raw(&raw, u16::from_le_bytes), "{layer}");
        }
    }
    // Least and greatest value use the whole range.
    let integers = read_raw(&folder.path().join("r16/height.r16"), u16::from_le_bytes);
    assert_eq!((integers.iter().min(), integers.iter().max()), (Some(&0), Some(&65535)));
}

#[test]
fn what_a_raw_file_cannot_hold_is_left_out_and_said() {
    let folder = folder();
    let output = export(&folder, &["--layer", "all", "--format", "r16", "-o", "raw/"]);
    let message = stderr(&output);
    assert!(message.contains("left out") && message.contains("normal, splat"), "{message}");
}

#[test]
fn raw_files_have_the_byte_order_and_the_first_row_that_was_asked_for() {
    let folder = folder();
    export(&folder, &["-o", "plain.r16"]);
    export(&folder, &["-o", "turned.raw", "--byte-order", "big", "--flip"]);
    let plain = read_raw(&folder.path().join("plain.r16"), u16::from_le_bytes);
    let turned = read_raw(&folder.path().join("turned.raw"), u16::from_be_bytes);
    let rows: Vec<u16> = turned.chunks(65).rev().flatten().copied().collect();
    assert!(plain == rows);
    let sidecar = sidecar(&folder.path().join("turned.raw"));
    assert_eq!((&sidecar["byte_order"], &sidecar["first_row"]), (&"big".into(), &"south".into()));
    assert_eq!(sidecar["samples"], serde_json::json!([65, 65]));
}

#[test]
fn tiles_joined_are_the_whole() {
    let folder = folder();
    for (extension, tiles, across, down) in [("r16", "2x2", 2, 2), ("tif", "4x2", 4, 2), ("exr", "1x4", 1, 4)]
    {
        let [whole, part] = [format!("whole.{extension}"), format!("height.{extension}")];
        export(&folder, &["-o", &whole]);
        export(&folder, &["-o", &part, "--tiles", tiles]);
        let read = |name: &str| -> Vec<f32> {
            let path = folder.path().join(name);
            match extension {
                "r16" => read_raw(&path, u16::from_le_bytes).into_iter().map(f32::from).collect(),
                "tif" => read_tif(&path).1,
                _ => read_exr(&path),
            }
        };
        let mut joined = vec![f32::NAN; 65 * 65];
        let [width, height] = [64 / across + 1, 64 / down + 1];
        for row in 0..down {
            for column in 0..across {
                let name = format!("height_x{column}_y{row}.{extension}");
                let tile = read(&name);
                assert_eq!(tile.len(), width * height);
                for (index, value) in tile.into_iter().enumerate() {
                    let place =
                        (row * (height - 1) + index / width) * 65 + column * (width - 1) + index % width;
                    // Neighbours have the samples of their edge both.
                    assert!(joined[place].is_nan() || joined[place] == value, "{name} {index}");
                    joined[place] = value;
                }
                let tile = &sidecar(&folder.path().join(&name))["tile"];
                assert_eq!(*tile, serde_json::json!({ "column": column, "row": row, "of": [across, down] }));
            }
        }
        assert!(joined == read(&whole), "{extension}");
    }
    // A tile of a GeoTIFF lies where it lay.
    let bytes = fs::read(folder.path().join("height_x3_y1.tif")).unwrap();
    let (_, value) = kit::tiff::find(&bytes, kit::tiff::TIEPOINT).unwrap();
    let place: Vec<f64> = value.as_chunks::<8>().0.iter().map(|double| f64::from_le_bytes(*double)).collect();
    assert_eq!(place, [0.0, 0.0, 0.0, 500.0, 0.0, 0.0]);
}

/// Sizes of the "Landscape Technical Guide"; 16 bits for heights and grey PNGs of 8 bits for weights.
#[test]
fn unreal_gets_its_sizes_and_its_scale() {
    let folder = folder();
    let output = export(&folder, &["--layer", "height,splat,flow", "--preset", "unreal", "-o", "unreal/"]);
    let path = |name: &str| folder.path().join("unreal").join(name);
    let height = image::open(path("height.png")).unwrap();
    // The nearest to 65.
    assert_eq!((height.width(), height.height(), height.color()), (127, 127, image::ColorType::L16));
    let mut sums = vec![0_u32; 127 * 127];
    for name in ["splat_grass.png", "splat_rock.png", "splat_sand.png", "splat_sea_floor.png", "flow.png"] {
        let weight = image::open(path(name)).unwrap();
        assert_eq!((weight.width(), weight.color()), (127, image::ColorType::L8), "{name}");
        if name != "flow.png" {
            let weight = weight.into_luma8().into_raw();
            sums.iter_mut().zip(weight).for_each(|(sum, weight)| *sum += u32::from(weight));
        }
    }
    assert!(sums.iter().all(|sum| sum.abs_diff(255) <= 2), "weights are whole");
    let sidecar = sidecar(&path("height.png"));
    let number = |value: &Value| value.as_f64().unwrap();
    let [min, max] = [number(&sidecar["min"]), number(&sidecar["max"])];
    let (scale, location) = (&sidecar["unreal"]["scale"], &sidecar["unreal"]["location"]);
    assert!((number(&scale[0]) - 100.0 * 2000.0 / 126.0).abs() < 1e-2, "{scale}");
    assert!((number(&scale[2]) - 100.0 * (max - min) / 512.0).abs() < 1e-3, "{scale}");
    // As Unreal reads it: (v − 32768)/128 · scale, in centimetres above the location.
    for (integer, expected) in [(0.0, min), (65535.0, max)] {
        let height = (integer - 32768.0) / 128.0 * number(&scale[2]) + number(&location[2]);
        assert!((height / 100.0 - expected).abs() < (max - min) / 65535.0, "{height} {expected}");
    }
    assert!(stderr(&output).contains("Unreal: import with scale"), "{}", stderr(&output));

    export(&folder, &["--preset", "unreal", "--cells", "253", "-o", "large.r16"]);
    assert_eq!(read_raw(&folder.path().join("large.r16"), u16::from_le_bytes).len(), 253 * 253);
    export(&folder, &["--preset", "unreal", "--tiles", "2x2", "-o", "tiles/"]);
    let tile = image::open(folder.path().join("tiles/height_x1_y1.png")).unwrap();
    assert_eq!(tile.width(), 127);
}

/// 2^n + 1 samples, 16 bits, the byte order that the dialog begins with, and the south edge first.
#[test]
fn unity_gets_its_size_its_byte_order_and_its_rows() {
    let folder = folder();
    export(&folder, &["-o", "plain.r16"]);
    let output = export(&folder, &["--layer", "height,splat", "--preset", "unity", "-o", "unity/"]);
    let height = read_raw(&folder.path().join("unity/height.raw"), u16::from_le_bytes);
    let turned: Vec<u16> = height.chunks(65).rev().flatten().copied().collect();
    assert!(turned == read_raw(&folder.path().join("plain.r16"), u16::from_le_bytes));
    assert_eq!(image::open(folder.path().join("unity/splat.png")).unwrap().color(), image::ColorType::Rgba8);
    let sidecar = sidecar(&folder.path().join("unity/height.raw"));
    let size = &sidecar["unity"]["terrain_size"];
    assert_eq!((&size[0], &size[2]), (&2000.0.into(), &2000.0.into()));
    let range = sidecar["max"].as_f64().unwrap() - sidecar["min"].as_f64().unwrap();
    assert!((size[1].as_f64().unwrap() - range).abs() < 1e-3);
    assert!(stderr(&output).contains("terrain size 2000, "), "{}", stderr(&output));
    assert!(stderr(&output).contains("byte order Windows"), "{}", stderr(&output));

    let output = export(&folder, &["--preset", "unity", "--byte-order", "big", "-o", "mac.raw"]);
    assert!(height == read_raw(&folder.path().join("mac.raw"), u16::from_be_bytes));
    assert!(stderr(&output).contains("byte order Mac"), "{}", stderr(&output));

    let layers = ["--layer", "height,mesh", "--mesh-error", "50"];
    let tiles = ["--preset", "unity", "--tiles", "2x2", "-o", "tiles/", "--cells", "65"];
    let output = export(&folder, &[layers.as_slice(), &tiles].concat());
    assert!(stderr(&output).contains("Import Raw of height_0_1.raw"), "{}", stderr(&output));
    // A mesh is called what its file is.
    let glb = gltf::Glb::from_slice(&fs::read(folder.path().join("tiles/terrain_1_0.glb")).unwrap())
        .map(|glb| glb.json.into_owned())
        .unwrap();
    let json: Value = serde_json::from_slice(&glb).unwrap();
    assert_eq!(json["nodes"][0]["name"], "terrain_1_0");
    // Counted from the south-west.
    let tile = read_raw(&folder.path().join("tiles/height_0_0.raw"), u16::from_le_bytes);
    assert_eq!(tile.len(), 33 * 33);
    assert_eq!(tile[..33], height[..33]);
}

#[test]
fn another_size_keeps_the_land_and_its_corners() {
    let folder = folder();
    export(&folder, &["--layer", "height,water,normal,splat", "-o", "plain/"]);
    for cells in ["33", "129"] {
        export(&folder, &["--layer", "height,water,normal,splat", "--cells", cells, "-o", "other/"]);
        let side: usize = cells.parse().unwrap();
        let read = |name: &str| {
            (
                read_exr(&folder.path().join(format!("plain/{name}.exr"))),
                read_exr(&folder.path().join(format!("other/{name}.exr"))),
            )
        };
        let (plain, other) = read("height");
        assert_eq!(other.len(), side * side);
        assert_eq!((plain[0], plain[65 * 65 - 1]), (other[0], other[side * side - 1]));
        let extremes = |values: &[f32]| {
            values.iter().fold([f32::MAX, f32::MIN], |[min, max], value| [min.min(*value), max.max(*value)])
        };
        let ([min, max], [least, most]) = (extremes(&plain), extremes(&other));
        assert!(min <= least && most <= max && most > 0.9 * max, "{min} {least} {most} {max}");
        let sidecar = sidecar(&folder.path().join("other/height.exr"));
        assert_eq!(sidecar["max"].as_f64().unwrap() as f32, most);
        let cell_size = sidecar["cell_size"].as_f64().unwrap();
        assert!((cell_size - 2000.0 / (side - 1) as f64).abs() < 1e-4);
        assert!(read("water").1.iter().all(|depth| *depth >= 0.0));
        for normal in read("normal").1.as_chunks::<3>().0 {
            let length: f32 = normal.iter().map(|stored| (2.0 * stored - 1.0).powi(2)).sum();
            assert!((length - 1.0).abs() < 1e-4, "{normal:?}");
        }
        for weights in read("splat").1.as_chunks::<4>().0 {
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{weights:?}");
        }
    }
}

/// A height that was exported is the ground of another world, as exact as its format, whatever the preset.
#[test]
fn an_exported_height_is_the_same_land_again() {
    let folder = folder();
    export(&folder, &["-o", "first.exr"]);
    let first = read_exr(&folder.path().join("first.exr"));
    let [min, max] = range(&folder.path().join("first.exr"));
    let step = (max - min) / 65535.0;
    let exports: [(&str, &[&str], f32); 7] = [
        ("a.exr", &[], 0.0),
        ("b.tif", &[], 0.0),
        ("c.png", &[], 0.51 * step),
        ("d.r16", &[], 0.51 * step),
        ("e.raw", &["--byte-order", "big", "--flip"], 0.51 * step),
        ("f.raw", &["--preset", "unity"], 0.51 * step),
        ("g.png", &["--flip"], 0.51 * step),
    ];
    for (name, arguments, tolerance) in exports {
        export(&folder, &[arguments, &["-o", name]].concat());
        let again = format!(
            "format = 1\nerosion = \"none\"\nreef = \"none\"\n[terrain]\ncells = 65\nextent = 2000\n\
             layers = [{{ heightmap = {{ file = \"{name}\" }} }}]\n"
        );
        fs::write(folder.path().join("again.toml"), &again).unwrap();
        let output = terrane(&folder, &["export", "again.toml", "-o", "again.exr"]);
        assert_eq!(code(&output), 0, "{name}: {}", stderr(&output));
        let land = read_exr(&folder.path().join("again.exr"));
        let difference =
            first.iter().zip(&land).fold(0.0_f32, |most, (one, two)| most.max((one - two).abs()));
        assert!(difference <= tolerance, "{name}: {difference} > {tolerance}");
    }
    // A byte order that nothing heeds is a mistake.
    let png =
        "format = 1\n[terrain]\nlayers = [{ heightmap = { file = \"c.png\", byte_order = \"big\" } }]\n";
    fs::write(folder.path().join("png.toml"), png).unwrap();
    let output = terrane(&folder, &["check", "png.toml"]);
    assert_eq!(code(&output), 3);
    assert!(stderr(&output).contains("only a RAW file leaves it open"), "{}", stderr(&output));
    // And a world goes on from it.
    let on = "format = 1\nreef = \"none\"\n[terrain]\ncells = 65\nextent = 2000\n\
              layers = [{ heightmap = { file = \"b.tif\" } }]\n[erosion.hydraulic]\nduration = 40\n";
    fs::write(folder.path().join("on.toml"), on).unwrap();
    let output = terrane(&folder, &["export", "on.toml", "--layer", "height", "wear", "-o", "on/"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let [land, wear] = ["height", "wear"].map(|name| read_exr(&folder.path().join(format!("on/{name}.exr"))));
    let change = first.iter().zip(&land).fold(0.0_f32, |most, (one, two)| most.max((one - two).abs()));
    assert!(change > 0.0 && change < 50.0 && wear.iter().any(|depth| *depth > 0.0), "{change}");
}

/// Maps for the processes are read from every format too.
#[test]
fn controls_are_read_from_every_format() {
    let folder = folder();
    let shares =
        [("wetness.png", "png16"), ("wetness.r16", "r16"), ("wetness.tif", "tif"), ("wetness.exr", "exr")];
    for (file, format) in shares {
        export(&folder, &["--layer", "wetness", "--format", format, "-o", "maps/"]);
        let mask = format!("controls.mask=\"maps/{file}\"");
        let output = terrane(&folder, &["check", "world.toml", "--set", &mask]);
        assert_eq!(code(&output), 0, "{file}: {}", stderr(&output));
        let table = String::from_utf8_lossy(&output.stdout);
        assert!(table.lines().any(|line| line.starts_with("host") && line.contains("maps")), "{table}");
    }
}

#[test]
fn options_that_make_no_sense_together_are_refused() {
    let folder = folder();
    let before = fs::read_dir(folder.path()).unwrap().count();
    let cases: [(&[&str], &[&str]); 18] = [
        (&["--tiles", "3x3"], &["--tiles 3x3", "64 intervals", "--cells 64 or 67"]),
        (&["--tiles", "2"], &["2x2"]),
        (&["--tiles", "0x2"], &["between 1 and 256"]),
        (&["--cells", "15"], &["16..=16385"]),
        (&["--preset", "unreal", "--cells", "1024"], &["1009, 2017", "--cells"]),
        (&["--preset", "unity", "--cells", "1024"], &["513, 1025", "--cells"]),
        (&["--preset", "unity", "--tiles", "2x1"], &["square tiles"]),
        (&["--preset", "unreal", "--tiles", "200x200"], &["--tiles 200x200", "127", "at most 130x130"]),
        (&["--preset", "unreal", "--tiles", "2x2", "--cells", "2018"], &["1009, 2017", "in 2x2 tiles"]),
        (&["--preset", "unreal", "--format", "exr"], &["16 bits", "png16"]),
        (&["--preset", "unity", "-o", "height.png"], &["RAW", ".raw"]),
        (&["--preset", "unity", "--flip"], &["leave --flip out"]),
        (&["--preset", "unreal", "-o", "height.r16", "--byte-order", "big"], &["little-endian"]),
        (&["--preset", "unreal", "--layer", "flow", "-o", "flow.r16"], &["`flow`", ".png"]),
        (&["--byte-order", "big"], &["--byte-order", "--format r16"]),
        (&["--flip", "-o", "height.tif"], &["--flip is for PNG and RAW"]),
        (&["--layer", "splat", "-o", "splat.r16"], &["`splat` has 4 channels"]),
        (&["--layer", "height", "water", "-o", "two.tif"], &["can hold one layer"]),
    ];
    for (arguments, parts) in cases {
        let output = terrane(&folder, &[&["export", "world.toml"], arguments].concat());
        assert_eq!(code(&output), 2, "{arguments:?}: {}", stderr(&output));
        for part in parts {
            assert!(stderr(&output).contains(part), "{arguments:?}: `{part}` is not in: {}", stderr(&output));
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), before);
}

// Helpers.

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), program::EVERY_LAYER).unwrap();
    folder
}

fn terrane(folder: &TempDir, arguments: &[&str]) -> Output {
    let _turn = kit::turn();
    program::terrane(folder.path(), arguments)
}

fn export(folder: &TempDir, arguments: &[&str]) -> Output {
    let output = terrane(folder, &[&["export", "world.toml"], arguments].concat());
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    output
}

fn sidecar(path: &Path) -> Value {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    serde_json::from_slice(&fs::read(name).unwrap()).unwrap()
}

fn range(path: &Path) -> [f32; 2] {
    let sidecar = sidecar(path);
    ["min", "max"].map(|key| sidecar[key].as_f64().unwrap() as f32)
}

/// Integers are the floats to half a step.
fn close(layer: &str, floats: &[f32], integers: &[u16], [min, max]: [f32; 2]) {
    assert_eq!(floats.len(), integers.len(), "{layer}");
    let step = (max - min) / 65535.0;
    for (float, integer) in floats.iter().zip(integers) {
        let value = min + f32::from(*integer) * step;
        // The sum above is rounded too.
        assert!((value - float).abs() <= 0.51 * step + 1e-6 * max.abs(), "{layer}: {value} {float}");
    }
}

fn read_raw(path: &Path, integer: fn([u8; 2]) -> u16) -> Vec<u16> {
    fs::read(path).unwrap().as_chunks::<2>().0.iter().map(|pair| integer(*pair)).collect()
}

/// Width and values, sample by sample.
fn read_tif(path: &Path) -> (u32, Vec<f32>) {
    let mut decoder = tiff::decoder::Decoder::new(fs::File::open(path).unwrap()).unwrap();
    let (width, _) = decoder.dimensions().unwrap();
    match decoder.read_image().unwrap() {
        tiff::decoder::DecodingResult::F32(values) => (width, values),
        _ => panic!("{}: no floats", path.display()),
    }
}

/// Values sample by sample: R, G, B, A where there are several channels.
fn read_exr(path: &Path) -> Vec<f32> {
    use exr::prelude::{ReadChannels, ReadLayers};
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let mut channels: Vec<(String, Vec<f32>)> = image
        .layer_data
        .channel_data
        .list
        .into_iter()
        .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
        .collect();
    channels.sort_by_key(|(name, _)| "RGBA".find(name.as_str()));
    (0..channels[0].1.len()).flat_map(|index| channels.iter().map(move |(_, values)| values[index])).collect()
}
