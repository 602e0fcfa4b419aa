//! World files: what is read, what is refused and with which words.

use crate::kit::committed::{BLESS, check_committed};
use std::fs;
use std::path::{Path, PathBuf};
use terrane::formats;
use terrane::scene::{Sky, ToneMap, View, Viewpoint};
use terrane::terrain::layers::{Combine, Generator, Layer};
use terrane::terrain::{Boundary, hydraulic};
use terrane::world::{self, Error, Overrides, World};

fn parse(text: &str, set: &[&str]) -> Result<World, Error> {
    parse_bytes(text.as_bytes(), set)
}

fn parse_bytes(bytes: &[u8], set: &[&str]) -> Result<World, Error> {
    let overrides = Overrides { set: set.iter().map(|argument| argument.to_string()).collect(), seed: None };
    world::parse("test.toml", bytes, Path::new("tests/data/bad_worlds"), &overrides)
}

fn good(text: &str, set: &[&str]) -> World {
    parse(text, set).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|is| is == extension)).collect();
    files.sort();
    files
}

/// One case a file; arguments of `--set` stand in its first lines as `#set key=value`. Beside it lies the message.
#[test]
fn each_bad_world_gets_its_message() {
    let cases = files("tests/data/bad_worlds", "toml");
    assert!(cases.len() >= 50, "only {} cases", cases.len());
    let mut wrong = Vec::new();
    for case in cases {
        let bytes = fs::read(&case).unwrap();
        let readable = String::from_utf8_lossy(&bytes).into_owned();
        let set = readable.lines().map_while(|line| line.strip_prefix("#set ")).map(String::from).collect();
        let name = case.file_name().unwrap().to_string_lossy();
        let overrides = Overrides { set, seed: None };
        let message = match world::parse(&name, &bytes, case.parent().unwrap(), &overrides) {
            Ok(_) => "accepted\n".to_string(),
            Err(error) => format!("exit code {}\nerror: {error}\n", error.exit_code()),
        };
        assert_ne!(message, "accepted\n", "{name} is accepted");
        wrong.extend(check_committed(&case.with_extension("txt"), &message).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn files_that_can_not_be_read_exit_with_7() {
    // A folder can be read; this one is no folder of settings.
    for (path, code) in [("tests/data/bad_worlds/nowhere.toml", 7), ("tests/data", 3)] {
        let error = world::load(Path::new(path), &Overrides::default()).unwrap_err();
        assert_eq!(error.exit_code(), code, "{error}");
        assert!(error.to_string().contains(path), "{error}");
    }
}

#[test]
fn a_file_over_the_limit_is_refused() {
    let mut bytes = b"format = 1\n".to_vec();
    bytes.resize(world::MAX_BYTES, b'#');
    assert!(parse_bytes(&bytes, &[]).is_ok());
    bytes.push(b'#');
    let error = parse_bytes(&bytes, &[]).unwrap_err();
    assert_eq!(error.exit_code(), 3);
    assert_eq!(error.to_string(), "test.toml is too large for a world file: it may have 1048576 bytes");
}

#[test]
fn a_file_full_of_mistakes_shows_the_first_ones() {
    let mut text = "format = 1\n".to_string();
    for index in 0..50_000 {
        text += &format!("unknown_{index} = 1\n");
    }
    text += "[terrain]\ncels = 1\n";
    let message = parse(&text, &[]).unwrap_err().to_string();
    assert!(message.starts_with("`unknown_0` is unknown\n --> test.toml:2:1\n"), "{message}");
    assert!(message.ends_with("error: and more") && message.lines().count() < 200, "{message}");
}

#[test]
fn the_shipped_worlds_load_without_warnings() {
    let shipped = files("configs/island", "toml");
    let names = ["atoll", "dendritic", "old_barrier", "paper", "tiny", "volcano", "young_cone"];
    assert_eq!(
        shipped.iter().map(|path| path.file_stem().unwrap().to_string_lossy()).collect::<Vec<_>>(),
        names
    );
    for (path, name) in shipped.iter().zip(names) {
        let world = world::load(path, &Overrides::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(world.name, name);
        assert_eq!(world.warnings, [""; 0], "{name}");
        assert_eq!(world.document.to_string(), fs::read_to_string(path).unwrap());
    }
}

#[test]
fn the_shortest_world_is_an_island_with_everything() {
    let world = good("format = 1", &[]);
    assert_eq!(world.warnings, [""; 0]);
    assert_eq!(world.seed, 1);
    assert_eq!(world.plan.grid.cells, 512);
    assert_eq!(world.plan.boundary, Boundary::Sea);
    assert!(world.plan.hydraulic.is_some() && world.plan.thermal.is_some() && world.plan.reef.is_some());
    assert!(matches!(world.light.sky, Sky::Preetham(_)));
    assert!(world.light.sun.is_some_and(|sun| sun.direction.y > 0.5), "{:?}", world.light.sun);
    assert!(matches!(world.viewpoint, Viewpoint::Fixed(View::FrameIsland { .. })));
    assert_eq!(world.film.tone_map, ToneMap::Filmic);
    assert_eq!([world.film.width, world.film.height], [1280, 720]);
    let [Layer::Generate { generator: Generator::Cone { height, .. }, .. }, noise] = &world.plan.layers[..]
    else {
        panic!("{:?}", world.plan.layers);
    };
    let Layer::Generate { combine: Combine::Power { reference }, .. } = noise else { panic!("{noise:?}") };
    assert_eq!(reference, height);
}

/// What stands in the table as a default is itself a value that the file may have.
#[test]
fn the_defaults_may_be_written_out() {
    fn write_out(table: &world::schema::Table, path: &str, set: &mut Vec<String>) {
        use world::schema::Shape;
        for key in &table.keys {
            let path = format!("{path}{}", key.name);
            match &key.shape {
                Shape::Table(inner) => write_out(inner, &format!("{path}."), set),
                Shape::OrWord(shape, [word, _]) => match &**shape {
                    Shape::Table(inner) if key.default != format!("\"{word}\"") => {
                        write_out(inner, &format!("{path}."), set)
                    }
                    _ => set.push(format!("{path}={}", key.default)),
                },
                // Defaults in words depend on other keys.
                _ if key.default_value().is_some() => {
                    set.push(format!("{path}={}", key.default.replace('\n', " ").replace(", ]", "]")));
                }
                _ => {}
            }
        }
    }
    let mut set = Vec::new();
    write_out(&world::shape(), "", &mut set);
    assert!(set.len() > 70, "{}", set.len());
    let set: Vec<&str> = set.iter().map(String::as_str).collect();
    let (written, default) = (good("format = 1", &set), good("format = 1", &[]));
    assert_eq!(written.plan, default.plan);
    assert_eq!(written.light, default.light);
    assert_eq!(written.sea, default.sea);
    assert_eq!(written.surface, default.surface);
    assert_eq!((written.viewpoint, written.fov), (default.viewpoint, default.fov));
    assert_eq!(written.film, default.film);
}

/// The ranges of the page: usual within allowed, defaults within usual.
#[test]
fn ranges_hold_each_other() {
    fn check(shape: &world::schema::Shape, default: Option<f64>, path: &str, checked: &mut usize) {
        use world::schema::Shape;
        match shape {
            Shape::Number { range: [least, most], usual, .. } => {
                *checked += 1;
                let [low, high] = usual.unwrap_or([*least, *most]);
                assert!(least <= &low && low < high && high <= *most, "{path}");
                assert!(default.is_none_or(|default| (low..=high).contains(&default)), "{path}");
            }
            Shape::Array(elements) => elements.iter().for_each(|element| check(element, None, path, checked)),
            Shape::OrWord(shape, _) => check(shape, None, path, checked),
            Shape::Named { element, .. } => check(element, None, path, checked),
            Shape::List { element, .. } => check(element, None, path, checked),
            Shape::Table(table) => table.keys.iter().for_each(|key| {
                check(&key.shape, key.default.parse().ok(), &format!("{path}.{}", key.name), checked);
            }),
            Shape::OneOf(alternatives) => {
                alternatives.iter().filter_map(|one| one.table.clone()).for_each(|table| {
                    check(&Shape::Table(table), None, path, checked);
                })
            }
            _ => {}
        }
    }
    let mut checked = 0;
    check(&world::schema::Shape::Table(world::shape()), None, "world", &mut checked);
    assert!(checked > 80, "{checked}");
}

#[test]
fn units_become_the_programs_own() {
    let world = good(
        r##"
        format = 1
        sea.level = -1000
        erosion.hydraulic.rain = 90
        erosion.thermal.repose = 45
        surface.grass = "#808080"
        surface.rock = [0.25, 0.5, 1]
        sun = { direct = { azimuth = 90, elevation = 0, irradiance = [1, 2, 3] } }
        camera = { fov = 90, view = { look_at = { position = [1, 2, 3], target = [0, 0, 0] } } }
        "##,
        &[],
    );
    let hydraulic = world.plan.hydraulic.unwrap();
    assert_eq!(hydraulic.rain, 2.5e-5); // 90 mm/h = 0.09 m / 3600 s
    assert_eq!(world.plan.thermal.unwrap().repose, std::f32::consts::FRAC_PI_4);
    assert!((world.surface.grass[0] - 0.215_860_5).abs() < 1e-6, "{:?}", world.surface.grass); // sRGB 128/255
    assert_eq!(world.surface.rock, [0.25, 0.5, 1.0]);
    let sun = world.light.sun.unwrap();
    assert!(sun.direction.distance(glam::Vec3::X) < 1e-6, "{}", sun.direction); // east is +X
    assert_eq!(sun.irradiance, [1.0, 2.0, 3.0]);
    assert!((sun.diameter - 0.53_f32.to_radians()).abs() < 1e-8);
    assert_eq!(world.fov, std::f32::consts::FRAC_PI_2);
}

#[test]
fn none_switches_off() {
    let world = good("format = 1\nerosion = \"none\"\nreef = \"none\"\nsky = \"none\"\nsun = \"none\"", &[]);
    assert!(world.plan.hydraulic.is_none() && world.plan.thermal.is_none() && world.plan.reef.is_none());
    assert_eq!(world.plan.seabed_smoothing, 0.0);
    assert_eq!(world.light.sky, Sky::None);
    assert!(world.light.sun.is_none());
    let world =
        good("format = 1", &["erosion.thermal.settle=none", "reef.rubble=none", "render.aerial=false"]);
    assert!(world.plan.thermal.unwrap().settle.is_none() && world.plan.reef.unwrap().rubble.is_none());
    assert!(world.light.air.is_none());
}

#[test]
fn a_preset_changes_defaults_only() {
    let world = good("format = 1\nerosion.hydraulic = { preset = \"paper\", drag = 0.1 }", &[]);
    let hydraulic = world.plan.hydraulic.unwrap();
    assert_eq!((hydraulic.pipes, hydraulic.section), (hydraulic::Pipes::Four, hydraulic::Section::Fixed));
    assert_eq!(
        (hydraulic.drag, hydraulic.ramp_depth, hydraulic.rain),
        (0.1, 0.0, 100.0 * (1e-3 / 3600.0) as f32)
    );
}

#[test]
fn each_layer_has_its_own_seed() {
    let seeds = |text: &str| -> Vec<u32> {
        let seed = |layer: &Layer| match layer {
            Layer::Generate { generator: Generator::Simplex { seed, .. }, .. } => Some(*seed),
            _ => None,
        };
        good(text, &[]).plan.layers.iter().filter_map(seed).collect()
    };
    let derived = seeds("format = 1\nterrain.layers = [{ cone = {} }, { simplex = {} }, { simplex = {} }]");
    let key = |path| terrane::core::hash::derive_seed(1, path);
    assert_eq!(derived, [key("terrain.layers.1"), key("terrain.layers.2")]);
    let own = seeds("format = 1\nterrain.layers = [{ simplex = { seed = 7 } }, { simplex = {} }]");
    assert_eq!(own, [7, key("terrain.layers.1")]);
}

#[test]
fn the_command_line_wins_and_the_seed_option_last() {
    let overrides = Overrides { set: vec!["seed=5".into(), "seed=6".into()], seed: Some(u32::MAX) };
    let load = |overrides: &Overrides| {
        world::parse("a/b.toml", b"format = 1\nseed = 4", Path::new("a"), overrides).unwrap()
    };
    assert_eq!(load(&overrides).seed, u32::MAX);
    assert_eq!(load(&Overrides { seed: None, ..overrides }).seed, 6);
    assert_eq!(load(&Overrides::default()).name, "b");
}

#[test]
fn elements_of_arrays_are_set_by_number() {
    let array = "format = 1\nterrain.layers = [{ cone = {} }, { crater = {} }]";
    let tables = "format = 1\n[[terrain.layers]]\ncone = {}\n[[terrain.layers]]\ncrater = {}\n";
    for text in [array, tables, "format = 1"] {
        let world = good(text, &["terrain.layers.0.cone.height=901", "camera.view.frame_island.azimuth=180"]);
        let Layer::Generate { generator: Generator::Cone { height, .. }, .. } = world.plan.layers[0] else {
            panic!()
        };
        assert_eq!((height, world.plan.layers.len()), (901.0, 2));
    }
    let world = good("format = 1", &["reef.stages.1.rise=-1.5", "render.size.0=64"]);
    assert_eq!(world.plan.reef.unwrap().stages[1].rise, -1.5);
}

#[test]
fn words_go_without_quotes() {
    let world =
        good("format = 1", &["surface.sand=#ffffff", "erosion.boundary=open", "sky=none", "seed = 3"]);
    assert_eq!((world.surface.sand, world.plan.boundary, world.seed), ([1.0; 3], Boundary::Open, 3));
}

/// A grey PNG of 16 bits, two samples a side.
fn write_png(path: &Path, samples: [u16; 4]) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), 2, 2);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let bytes: Vec<u8> = samples.iter().flat_map(|sample| sample.to_be_bytes()).collect();
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

#[test]
fn maps_are_read_from_the_folder_of_the_world() {
    let folder = tempfile::tempdir().unwrap();
    write_png(&folder.path().join("land.png"), [0, 65535, 13107, 0]);
    fs::write(folder.path().join("land.png.json"), r#"{ "min": -50, "max": 200 }"#).unwrap();
    let load = |layer: &str| {
        let path = folder.path().join("world.toml");
        fs::write(&path, format!("format = 1\ncontrols.mask = \"land.png\"\nterrain.layers = [{layer}]"))
            .unwrap();
        let plan = world::load(&path, &Overrides::default()).unwrap_or_else(|error| panic!("{error}")).plan;
        assert_eq!(plan.controls.mask.unwrap().values, [0.0, 1.0, 0.2, 0.0]);
        match &plan.layers[0] {
            Layer::Generate { generator: Generator::Heightmap { map }, .. } => {
                map.values.iter().map(|h| h.round()).collect::<Vec<_>>()
            }
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(
        load(r#"{ heightmap = { file = "land.png", min = 100, max = 600 } }"#),
        [100.0, 600.0, 200.0, 100.0]
    );
    assert_eq!(load(r#"{ heightmap = { file = "land.png" } }"#), [-50.0, 200.0, 0.0, -50.0]);
}

/// What names the same file in the same way shares it, and all maps together have a limit.
#[test]
fn maps_are_read_once_and_take_a_gibibyte_at_most() {
    let folder = tempfile::tempdir().unwrap();
    let load = |layers: &[&str]| {
        let text = format!("format = 1\nterrain.layers = [{}]", layers.join(", "));
        world::parse("test.toml", text.as_bytes(), folder.path(), &Overrides::default())
    };
    fs::write(folder.path().join("land.r16"), [0; 2 * 64]).unwrap();
    let low = "{ heightmap = { file = \"land.r16\", min = 0, max = 1 } }";
    let high = "{ heightmap = { file = \"land.r16\", min = 0, max = 2 } }";
    assert_eq!(load(&[low, low, low]).unwrap().plan.map_bytes(), 4 * 64);
    assert_eq!(load(&[low, high, low]).unwrap().plan.map_bytes(), 2 * 4 * 64);

    // 400 MiB of values each, of a file without contents.
    fs::File::create(folder.path().join("large.r16")).unwrap().set_len(2 * 10_240 * 10_240).unwrap();
    let large =
        [1, 2, 3].map(|max| format!("{{ heightmap = {{ file = \"large.r16\", min = 0, max = {max} }} }}"));
    let error = load(&large.each_ref().map(String::as_str)).unwrap_err();
    assert_eq!(error.exit_code(), 3);
    let message = error.to_string();
    for part in ["terrain.layers.2.heightmap.file", "400.0 MiB", "800.0 MiB", "1024.0 MiB"] {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn a_map_of_another_land_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    write_png(&folder.path().join("land.png"), [0, 65535, 13107, 0]);
    let warnings = |extent: u32, sidecar: &str| {
        fs::write(folder.path().join("land.png.json"), sidecar).unwrap();
        let text = format!(
            "format = 1\n[terrain]\nextent = {extent}\nlayers = [{{ heightmap = {{ file = \"land.png\" }} }}]\n"
        );
        let world = world::parse("test.toml", text.as_bytes(), folder.path(), &Overrides::default());
        world.unwrap_or_else(|error| panic!("{error}")).warnings
    };
    let whole = r#"{ "min": 0, "max": 200, "extent": 4000 }"#;
    let tile = r#"{ "min": 0, "max": 200, "extent": 4000, "tile": { "column": 1, "row": 0, "of": [2, 2] } }"#;
    assert_eq!(warnings(8000, r#"{ "min": 0, "max": 200 }"#), [""; 0]);
    assert_eq!(warnings(4000, whole), [""; 0]);
    assert_eq!(warnings(2000, tile), [""; 0]);
    for (sidecar, extent, parts) in [
        (whole, 8000, ["4000 × 4000 m", "8000 × 8000 m", "land.png"]),
        (tile, 4000, ["2000 × 2000 m, tile 1, 0 of 2 × 2", "4000 × 4000 m", "land.png"]),
    ] {
        let warnings = warnings(extent, sidecar);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        for part in [parts.as_slice(), &["`terrain.layers.0.heightmap.file`"]].concat() {
            assert!(warnings[0].contains(part), "`{part}` is not in: {}", warnings[0]);
        }
    }
}

#[test]
fn a_damaged_map_exits_with_7() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("land.png"), b"no picture").unwrap();
    let overrides = Overrides { set: vec!["controls.rain=land.png".into()], seed: None };
    let error = world::parse("test.toml", b"format = 1", folder.path(), &overrides).unwrap_err();
    assert_eq!(error.exit_code(), 7, "{error}");
    assert!(error.to_string().contains("--set controls.rain=land.png"), "{error}");
}

#[test]
fn maps_beyond_all_measure_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let message = |key: &str, value: f32| {
        let channels = vec![("height".into(), vec![0.0, value, 0.5, 1.0])];
        formats::exr::write_channels(&folder.path().join("map.exr"), [2, 2], channels).unwrap();
        let overrides = Overrides { set: vec![key.replace('?', "\"map.exr\"")], seed: None };
        world::parse("test.toml", b"format = 1", folder.path(), &overrides).err().map(|error| {
            assert_eq!(error.exit_code(), 3, "{error}");
            error.to_string()
        })
    };
    let land = "terrain.layers=[{ heightmap = { file = ? } }]";
    assert_eq!(message(land, -49_000.0), None);
    for height in [1e30, -51_000.0] {
        let message = message(land, height).unwrap();
        assert!(message.starts_with("`terrain.layers.0.heightmap.file` holds heights"), "{message}");
    }
    assert_eq!(message("controls.mask=?", 1.0), None);
    assert!(message("controls.mask=?", 1.5).is_some_and(|message| message.contains("from 0 to 1")));
}

#[test]
fn edits_keep_comments() {
    let text = "# A first line.\nformat = 1 # the format\n\n# About the land.\n[terrain]\ncells = 128 # few\n\
                layers = [ # two\n    { cone = { height = 800 } }, # a cone\n]\n# The end.\n";
    let set = ["terrain.cells=64", "terrain.layers.0.cone.height=801", "sea.level=10", "terrain.extent=1e4"];
    let edited = good(text, &set).document.to_string();
    let expected = "# A first line.\nformat = 1 # the format\n\n# About the land.\n[terrain]\ncells = 64 # few\n\
                    layers = [ # two\n    { cone = { height = 801 } }, # a cone\n]\nextent = 1e4\n\n[sea]\nlevel = 10\n# The end.\n";
    assert_eq!(edited, expected);
    // The edited document is the same world.
    let (again, once) = (good(&edited, &[]), good(text, &set));
    assert_eq!(again.plan, once.plan);
}

#[test]
fn byte_order_mark_and_line_ends_are_no_matter() {
    let world = good("\u{feff}format = 1\r\n[terrain]\r\ncells = 99 # few\r\n", &["sea.level=1"]);
    assert_eq!((world.plan.grid.cells, world.sea.level), (99, 1.0));
}

/// The hash is of the file's bytes, whatever the command line changes (`sha256sum` of "format = 1").
#[test]
fn the_hash_is_of_the_bytes() {
    let sha256 = "019d488782a0f9b4fe4cf4402ed764a4aeb64adb3da27ef2d88955db704249c1";
    assert_eq!(good("format = 1", &[]).sha256, sha256);
    assert_eq!(good("format = 1", &["seed=2"]).sha256, sha256);
}

#[test]
fn what_is_hardly_meant_is_warned_of() {
    let warning = |set: &[&str]| good("format = 1", set).warnings.join("\n");
    assert!(warning(&["sky.preetham.turbidity=9"]).contains("turbidity"));
    assert!(warning(&["sun.place.time=23"]).contains("below the horizon"));
    assert!(warning(&["sun.direct.elevation=2"]).contains("degrees high"));
    assert!(warning(&["reef.growth=0.001"]).contains("drown"));
}

#[test]
fn the_reference_page_is_up_to_date() {
    if let Err(difference) = check_committed(Path::new("docs/worlds.md"), &world::reference()) {
        panic!("run this test with {BLESS}=1 and commit docs/worlds.md\n{difference}");
    }
}

/// What `make fuzz` runs with many more cases.
mod fuzz {
    use super::*;
    use proptest::prelude::*;

    /// A shipped world and places to damage it.
    fn mutated() -> impl Strategy<Value = Vec<u8>> {
        let texts: Vec<Vec<u8>> =
            files("configs/island", "toml").iter().map(|path| fs::read(path).unwrap()).collect();
        let damage = prop_oneof![
            (any::<prop::sample::Index>(), any::<u8>()).prop_map(|(at, byte)| (at, vec![byte], 1)),
            (any::<prop::sample::Index>(), 0..40usize).prop_map(|(at, cut)| (at, vec![], cut)),
            (any::<prop::sample::Index>(), prop::sample::select(PIECES)).prop_map(|(at, piece)| (
                at,
                piece.into(),
                0
            )),
        ];
        (prop::sample::select(texts), prop::collection::vec(damage, 1..6)).prop_map(|(mut text, damages)| {
            for (at, insert, cut) in damages {
                let at = at.index(text.len() + 1);
                let end = (at + cut).min(text.len());
                text.splice(at..end, insert);
            }
            text
        })
    }

    const PIECES: &[&str] = &[
        "=",
        ".",
        "[",
        "]",
        "{",
        "}",
        "\"",
        "'''",
        "\n",
        "#",
        "nan",
        "-inf",
        "1e999",
        "9223372036854775807",
        "none",
        "\u{feff}",
        "[[",
        "]]",
        "\r",
        "\0",
        "é",
        "terrain",
        "layers",
        "cone = {}",
        "1979-05-27",
        "true",
        "preset = \"paper\"",
    ];

    proptest! {
        #[test]
        fn random_bytes_are_no_trouble(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse_bytes(&bytes, &[]);
        }

        #[test]
        fn damaged_worlds_are_no_trouble(bytes in mutated()) {
            if let Err(error) = parse_bytes(&bytes, &[]) {
                prop_assert!(!error.to_string().is_empty());
            }
        }

        #[test]
        fn random_arguments_are_no_trouble(argument in "\\PC{0,40}", key in "[a-z_.0-9]{1,20}", value in "\\PC{0,20}") {
            let _ = parse("format = 1", &[&argument]);
            let _ = parse("format = 1", &[&format!("{key}={value}")]);
            let _ = parse("format = 1", &[&format!("terrain.{value}={key}"), &format!("reef.stages={value}")]);
        }
    }
}
