//! A folder of settings as Rudzki 2020 has it (section 4.3) is a world: every parameter by name, default and place, its
//! turning conventions, the order of its files, and an error for all that is wrong.

#[path = "thesis/mistakes.rs"]
mod mistakes;

use crate::kit::committed::{BLESS, check_committed};

use glam::{DVec3, Vec3, vec2};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use terrane::plants::derive::{Limits, derive};
use terrane::plants::planting::{Grid, Places, Rule};
use terrane::plants::turtle::{self, Drawing};
use terrane::world::thesis::{self, Contents, Folder};
use terrane::world::{self, Overrides, Renderer, World};

// Parameters ---------------------------------------------------------------------------------------------------------

/// What stands for a parameter that is not written.
#[derive(Clone, Copy)]
enum Absent {
    Required,
    Is(&'static str),
}
use Absent::{Is, Required};

/// File, name, default, another value, and one that is none.
type Row = (&'static str, &'static str, Absent, &'static str, &'static str);

#[rustfmt::skip]
const PARAMETERS: [Row; 75] = [
    ("pathTracer.conf", "PhotoName", Required, "hill", "../hill"),
    ("pathTracer.conf", "Resolution", Required, "64 32", "64 0"),
    ("pathTracer.conf", "Samples", Is("1"), "9", "0"),
    ("pathTracer.conf", "MaxRayBounces", Is("5"), "7", "-1"),
    ("pathTracer.conf", "DebugMode", Is("0"), "1", "maybe"),
    ("camera.conf", "LookHeight", Is("1"), "2.5", "-1"),
    ("camera.conf", "LookDirection", Is("0 0 1"), "1 0 0", "0 1 0"),
    ("camera.conf", "LookDistance", Is("2"), "20", "0"),
    ("camera.conf", "EdgeMinOffset", Is("10"), "20", "-1"),
    ("camera.conf", "ExpectedPositionY", Is("0"), "1000", "high"),
    ("viewMode.conf", "Enabled", Is("0"), "true", "2"),
    ("viewMode.conf", "Resolution", Is("800 600"), "640 480", "640.5 480"),
    ("viewMode.conf", "CameraVelocity", Is("10"), "5", "nan"),
    ("sky.conf", "SunColor", Required, "1 1 0.5", "1 1 -1"),
    ("sky.conf", "SunPower", Required, "50000", "0"),
    ("sky.conf", "SkyLuminanceFactor", Required, "0.0001", "0"),
    ("sky.conf", "Latitude", Required, "-30", "91"),
    ("sky.conf", "Longitude", Required, "360", "361"),
    ("sky.conf", "StandardMeridian", Required, "23", "24"),
    ("sky.conf", "JulianDay", Required, "366", "367"),
    ("sky.conf", "TimeOfDay", Required, "14.25", "24.5"),
    ("sky.conf", "Turbidity", Required, "6", "1"),
    ("terrain.conf", "N", Required, "7", "-1"),
    ("terrain.conf", "Size", Required, "100", "0"),
    ("terrain.conf", "InitHeight", Required, "3", "-3"),
    ("terrain.conf", "Spread", Required, "0", "-1"),
    ("terrain.conf", "SpreadReductionRate", Required, "0.9", "1.1"),
    ("terrain.conf", "RockStartY", Is("10"), "-5", "1e9"),
    ("terrain.conf", "GroundEndY", Is("20"), "70", "inf"),
    ("materials/ground.mat", "Color1", Required, "0.5 0.5 0.5", "255 0 0"),
    ("materials/ground.mat", "Color2", Required, "0.5 0.5 0.5", "0.5 0.5"),
    ("materials/ground.mat", "NoisePositionFactor", Is("1"), "3", "-1"),
    ("materials/ground.mat", "NoiseValueFactor", Is("1"), "3", "1,5"),
    ("materials/rock.mat", "NoiseValueFactor", Is("1"), "3", "x"),
    ("materials/plant.mat", "NoiseValueFactor", Is("1"), "3", "x"),
    ("materials/leaf.mat", "NoiseValueFactor", Is("1"), "3", "x"),
    ("materials/bark.mat", "NoiseValueFactor", Is("1"), "3", "x"),
    ("trees/fork.lsys", "N", Required, "3", "-3"),
    ("trees/fork.lsys", "Height", Required, "9", "0"),
    ("trees/fork.lsys", "ConeBasePoints", Is("3"), "8", "2"),
    ("trees/fork.lsys", "Material", Is("Plant"), "Leaf", "leaf"),
    ("trees/fork.lsys", "InitRadius", Is("0.3"), "0.05", "0"),
    ("trees/fork.lsys", "TurnAngle", Is("0"), "33", "right"),
    ("trees/fork.lsys", "PitchAngle", Is("0"), "33", "400"),
    ("trees/fork.lsys", "RollAngle", Is("0"), "33", "1e"),
    ("plants/weed.lsys", "Axiom", Required, "F", "XX"),
    ("plants/weed.lsys", "Material", Is("Plant"), "Bark", "Wood"),
    ("plants/weed.lsys", "InitRadius", Is("0.3"), "0.05", "0"),
    ("leafs/blade.lsys", "Material", Is("Plant"), "Bark", "Wood"),
    ("trees/round.honda", "N", Required, "3", "1.5"),
    ("trees/round.honda", "R1", Required, "0.5", "0"),
    ("trees/round.honda", "R2", Required, "0.5", "0"),
    ("trees/round.honda", "A0", Required, "20", "x"),
    ("trees/round.honda", "A2", Required, "20", "x"),
    ("trees/round.honda", "D", Required, "90", "x"),
    ("trees/round.honda", "Wr", Required, "0.5", "0"),
    ("trees/round.honda", "Height", Is("2"), "3", "0"),
    ("trees/round.honda", "ConeBasePoints", Is("6"), "7", "1"),
    ("trees/round.honda", "Material", Is("Bark"), "Plant", "bark"),
    ("trees/round.honda", "InitRadius", Is("0.2"), "0.1", "-1"),
    ("leafs/oval.family", "N", Required, "9", "-9"),
    ("leafs/oval.family", "Delta", Required, "30", "x"),
    ("leafs/oval.family", "LA", Required, "5", "-5"),
    ("leafs/oval.family", "RA", Required, "1.1", "-1"),
    ("leafs/oval.family", "LB", Required, "1", "-1"),
    ("leafs/oval.family", "RB", Required, "1", "-1"),
    ("leafs/oval.family", "PD", Required, "0", "-1"),
    ("leafs/oval.family", "Height", Is("0.4"), "0.3", "0"),
    ("leafs/oval.family", "Material", Is("Leaf"), "Plant", "Leaves"),
    ("spawners/left.spawner", "CameraOffset", Required, "5 5", "5"),
    ("spawners/left.spawner", "XGridN", Is("1"), "9", "0"),
    ("spawners/left.spawner", "ZGridN", Is("1"), "9", "-1"),
    ("spawners/left.spawner", "CellSize", Is("0"), "3", "-3"),
    ("spawners/left.spawner", "GeneratorType", Required, "Plant", "Trees"),
    ("spawners/left.spawner", "SpawnProbability", Is("1"), "0.5", "2"),
];

#[rustfmt::skip]
const MORE: [Row; 3] = [
    ("spawners/left.spawner", "RandomPositionPercentage", Is("0.5"), "0.25", "50"),
    ("spawners/left.spawner", "MinElementScale", Is("0.5"), "0.75", "0"),
    ("spawners/left.spawner", "MaxElementScale", Is("2"), "1.5", "-2"),
];

/// The names of a file's parameters.
fn names_in(file: &str) -> Vec<&'static str> {
    let ending = file.rsplit_once('.').unwrap().1;
    let alike = |other: &str| other == file || ending != "conf" && other.ends_with(&format!(".{ending}"));
    let mut names: Vec<&str> = Vec::new();
    for (other, name, ..) in PARAMETERS.into_iter().chain(MORE) {
        if alike(other) && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

#[test]
fn every_parameter_has_its_name_default_range_and_effect() {
    let settings = all();
    for (file, name, default, other, wrong) in PARAMETERS.into_iter().chain(MORE) {
        let row = format!("{file}, {name}");
        let bare = without(&settings, file, name);
        let with = |value: &str| thesis::convert(&and(&bare, file, &format!("\n{name} {value}")));
        let text = |value: &str| with(value).unwrap_or_else(|error| panic!("{row}: {error}")).text;
        match default {
            Required => {
                let refused = refusal(&bare);
                assert!(refused.contains(&format!("`{name}` is missing")), "{row}: {refused}");
            }
            Is(default) => {
                let unwritten = thesis::convert(&bare).unwrap_or_else(|error| panic!("{row}: {error}")).text;
                assert_eq!(text(default), unwritten, "{row}");
                assert_ne!(text(other), unwritten, "{row} says nothing");
            }
        }
        parse(&text(other)).unwrap_or_else(|error| panic!("{row} {other}: {error}"));

        let refused = with(wrong).unwrap_err().to_string();
        assert!(refused.contains(&format!("`{name}`")), "{row}: {refused}");
        let line = text_of(&bare, file).lines().count() + 1;
        assert!(refused.contains(&format!("settings/{file}:{line}:")), "{row}, line {line}: {refused}");

        let small = and(&bare, file, &format!("\n{} {other}", name.to_lowercase()));
        let refused = refusal(&small);
        assert!(refused.contains(&format!("`{}` is unknown", name.to_lowercase())), "{row}: {refused}");
        // A mistake says what is allowed: the name that was meant, or all.
        let all = names_in(file);
        let strange = refusal(&and(&bare, file, "\nQwertzuiop 1"));
        assert!(all.iter().all(|name| strange.contains(name)), "{row}: {strange}");

        // The last one wins, and what comes first does not.
        if wrong.split(' ').count() != other.split(' ').count() {
            continue;
        }
        let twice = and(&bare, file, &format!("\n{name} {wrong}\n{name} {other} # yes"));
        assert_eq!(thesis::convert(&twice).unwrap().text, text(other), "{row}");
    }
}

#[test]
fn a_value_may_stand_on_the_next_line_and_names_in_any_order() {
    let settings = all();
    let camera =
        "LookDistance 12 LookHeight\n1.6\n\n  EdgeMinOffset 40\tLookDirection 0\n 0 1 ExpectedPositionY 4";
    let turned = with_file(&settings, "camera.conf", camera);
    assert_eq!(thesis::convert(&turned).unwrap().text, thesis::convert(&settings).unwrap().text);
    // As some editors write.
    let windows = with_file(&settings, "camera.conf", &format!("\u{feff}{}", camera.replace('\n', "\r\n")));
    assert_eq!(thesis::convert(&windows).unwrap().text, thesis::convert(&settings).unwrap().text);
}

/// Names of files stand in the converted text: one must not go on in the next line.
#[cfg(unix)]
#[test]
fn names_of_files_are_names() {
    let folder = tempfile::tempdir().unwrap();
    write(&small(), folder.path());
    fs::write(folder.path().join("trees/a\nseed = 3\n#.lsys"), "").unwrap();
    let error = Folder::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("rename or remove it"), "{error}");
}

#[test]
fn the_reference_page_is_the_declarations() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/folders.md");
    if let Err(difference) = check_committed(&path, &thesis::reference()) {
        panic!("run this test with {BLESS}=1 and commit docs/folders.md\n{difference}");
    }
}

/// What the folder's own ranges allow the world file allows, too: no mistake is told in a text that nobody has written.
#[test]
fn the_ends_of_every_range_make_a_world() {
    let mut tried = 0;
    let mut files = Vec::new();
    for line in thesis::reference().lines() {
        if line.starts_with("## ") {
            files = all().files.into_keys().filter(|file| is_of(line, file)).collect::<Vec<_>>();
        }
        let mut columns = line.split('|').map(str::trim).skip(1);
        let (Some(name), Some(values)) = (columns.next(), columns.next()) else { continue };
        let Some((kind, range)) = values.split_once(" from ") else { continue };
        let count = kind.chars().find_map(|letter| letter.to_digit(10)).unwrap_or(1) as usize;
        for (end, file) in range.split(" to ").flat_map(|end| files.iter().map(move |file| (end, file))) {
            let line = format!("\n{} {}", name.trim_matches('`'), vec![end; count].join(" "));
            // What can't stand beside the other settings, and what can't grow, is told where it is written.
            let Ok(converted) = thesis::convert(&and(&all(), file, &line)) else { continue };
            parse(&converted.text).unwrap_or_else(|error| panic!("{file}, {line}: {error}"));
            tried += 1;
        }
    }
    assert!(tried > 100, "{tried}");
}

/// Whether a heading of the reference is about a file.
fn is_of(heading: &str, file: &str) -> bool {
    let (folder, name) = file.rsplit_once('/').unwrap_or(("", file));
    let ending = name.rsplit_once('.').unwrap().1;
    let ways = [file.to_owned(), format!("{folder}/*.{ending}"), format!("{folder}/NAME.{ending}")];
    ways.iter().any(|way| heading.contains(&format!("`{way}`")))
}

#[test]
fn the_edge_is_as_far_as_there_is_room() {
    let edge = |lines: &str, size: &str| {
        let settings = and(&all(), "terrain.conf", &format!("\nSize {size}"));
        let settings = and(&without(&settings, "camera.conf", "EdgeMinOffset"), "camera.conf", lines);
        parse(&converted(&settings)).map(|world| format!("{:?}", world.viewpoint)).unwrap()
    };
    assert!(edge("\nEdgeMinOffset 50", "100").contains("edge_offset: 50.0"));
    // What stands for nothing written is no mistake.
    assert!(edge("", "100").contains("edge_offset: 10.0"));
    assert!(edge("", "15").contains("edge_offset: 7.5"));
}

/// No ground lies so low that it could lie under it.
#[test]
fn there_is_no_sea() {
    let world = parse(&converted(&all())).unwrap();
    assert!(world.sea.level <= -terrane::terrain::FARTHEST_GROUND, "{}", world.sea.level);
}

// What it becomes ----------------------------------------------------------------------------------------------------

#[test]
fn settings_become_the_keys_that_mean_them() {
    let World { plan, film, viewpoint, surface, light, fov, seed, renderer, samples, tracing, .. } =
        parse(&converted(&all())).unwrap();
    assert_eq!((renderer, samples, tracing.bounces), (Renderer::Trace, 64, 4));
    assert_eq!((seed, plan.grid.cells, plan.grid.extent), (1, 257, 240.0));
    assert!(plan.hydraulic.is_none() && plan.thermal.is_none() && plan.reef.is_none());
    assert_eq!((film.width, film.height), (320, 180));
    // SkyLuminanceFactor · SunPower / 100000.
    assert!((film.exposure / 7.2e-5 - 1.0).abs() < 1e-6);
    assert!((fov.to_degrees() - 53.13).abs() < 1e-4);
    let told = format!("{viewpoint:?}");
    for part in ["1.6", "12.0", "40.0", "4.0"] {
        assert!(told.contains(part), "{told}");
    }
    let by_height = surface.by_height.unwrap();
    assert_eq!((by_height.rock_start, by_height.ground_end), (9.0, 15.0));
    assert_eq!(by_height.ground.reflectance, [0.09, 0.12, 0.03]);
    assert_eq!(by_height.ground.value_factor, 1.2);
    assert_eq!(by_height.rock.second_reflectance, [0.32, 0.3, 0.27]);
    // Where there is no sea everything would lie high enough for snow.
    assert!(surface.snow.is_none());
    assert!(light.sun.is_some() && light.clouds == 0.0);
}

#[test]
fn spawners_become_grids_in_order() {
    let world = parse(&converted(&all())).unwrap();
    let plants: Vec<&str> = world.plants.species.iter().map(|species| species.name.as_str()).collect();
    let rules = &world.plants.rules;
    assert_eq!(rules.len(), 3);
    // spawners/left.spawner, which comes first.
    let Places::Grid(grid) = &rules[0].places else { panic!("{:?}", rules[0].places) };
    let wanted =
        Grid { offset: vec2(-14.0, 22.0), cells: [4, 8], cell_size: 6.0, probability: 0.7, jitter: 0.8 };
    assert_eq!((*grid, rules[0].scale, rules[0].lean, rules[0].shade), (wanted, [0.7, 1.3], 0.0, 1.0));
    let named =
        |rule: &Rule| rule.kinds.iter().map(|(kind, share)| (plants[*kind], *share)).collect::<Vec<_>>();
    assert_eq!(named(&rules[0]), [("trees_fork_lsys", 1.0), ("trees_round_honda", 1.0)]);
    // spawners/meadow.spawner, of plants.
    assert_eq!(named(&rules[1]), [("plants_tuft_lsys", 1.0), ("plants_weed_lsys", 1.0)]);
}

/// Coordinates are the world's: +X east, +Z south.
#[test]
fn the_camera_looks_along_its_direction() {
    for (direction, azimuth) in [("0 0 1", 180.0), ("1 0 0", 90.0), ("0 5 -2", 0.0), ("-1 0 0", 270.0)] {
        let settings = and(&all(), "camera.conf", &format!("\nLookDirection {direction}"));
        let told = format!("{:?}", parse(&converted(&settings)).unwrap().viewpoint);
        let at = told.find("azimuth: ").unwrap() + "azimuth: ".len();
        let end = told[at..].find([',', ' ']).unwrap() + at;
        let found = told[at..end].parse::<f64>().unwrap().to_degrees().rem_euclid(360.0);
        assert!((found - azimuth).abs() < 1e-4, "{direction}: {found}");
    }
}

#[test]
fn the_sun_stands_where_the_models_authors_put_it() {
    let reference: Value = serde_json::from_str(include_str!("../data/preetham_reference.json")).unwrap();
    let cases = reference["solar_position"]["cases"].as_array().unwrap();
    let mut above = 0;
    for case in cases {
        let number = |key: &str| case[key].as_f64().unwrap();
        // The zones from 15 on are those west of Greenwich.
        let zone = number("utc_offset_h");
        let zones = if zone < 0.0 { vec![zone, zone + 24.0] } else { vec![zone] };
        let [south, east, up] =
            [0, 1, 2].map(|axis| case["preetham"]["to_sun_x_south_y_east_z_up"][axis].as_f64().unwrap());
        for zone in zones.into_iter().filter(|zone| zone.fract() == 0.0) {
            let lines = format!(
                "\nLatitude {}\nLongitude {}\nStandardMeridian {zone}\nJulianDay {}\nTimeOfDay {}",
                number("lat_deg"),
                number("lon_east_deg"),
                number("julian_day"),
                number("time_h")
            );
            let world = parse(&converted(&and(&all(), "sky.conf", &lines))).unwrap();
            let Some(sun) = world.light.sun else {
                assert!(up < 1e-3, "{case}");
                continue;
            };
            let wanted = Vec3::new(east as f32, up as f32, south as f32);
            assert!(sun.direction.distance(wanted) < 2e-5, "{} {wanted}: {case}", sun.direction);
            above += 1;
        }
    }
    assert!(above > 20, "{above}");
}

/// Seen along the heading at first, up: `+` turns right, `-` left, `^` up, `&` down, `\` rolls clockwise, `/` the other way.
#[test]
fn the_turtle_turns_as_in_the_thesis() {
    let [right, left, up, down] = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];
    for (word, end) in [
        ("F", DVec3::Y),
        ("+F", right),
        ("-F", left),
        ("^F", up),
        ("&F", down),
        ("|F", DVec3::NEG_Y),
        // Rolled clockwise, what was up is at the right.
        (r"\^F", right),
        ("/^F", left),
        (r"\+F", down),
        ("[+F]F", DVec3::Y),
        ("f+F", DVec3::Y + right),
    ] {
        let system = format!(
            "N 1\nHeight 1\nTurnAngle 90\nPitchAngle 90\nRollAngle 90\nAxiom A\nProd A > {word}\nInitRadius 0.1\n"
        );
        let Drawing { measure, .. } =
            drawn(&with_file(&all(), "plants/tuft.lsys", &system), "plants_tuft_lsys");
        assert!(measure.end.distance(end) < 1e-12, "{word} ends at {}, not {end}", measure.end);
    }
    // Only `.` leaves corners in a polygon.
    let system = "N 1\nHeight 1\nTurnAngle 90\nAxiom A\nProd A > {.F.+FF.+F.}\n";
    let Drawing { polygons, axes, .. } =
        drawn(&with_file(&all(), "plants/tuft.lsys", system), "plants_tuft_lsys");
    assert_eq!((polygons[0].vertices.len(), axes.len()), (4, 0));
}

/// A species of the world, drawn as it grows.
fn drawn(settings: &Folder, species: &str) -> Drawing {
    let world = parse(&converted(settings)).unwrap();
    let species = world.plants.species.iter().find(|found| found.name == species).expect(species);
    let form = &species.form;
    let word = derive(&form.grammar, form.steps, 1, &Limits::default()).unwrap();
    turtle::draw(&word, &form.turtle, &Limits::default()).unwrap()
}

#[test]
fn plants_are_as_high_as_they_should_be() {
    let settings = all();
    let world = parse(&converted(&settings)).unwrap();
    for (species, height) in [
        ("trees_fork_lsys", 4.5),
        ("trees_round_honda", 5.5),
        ("plants_weed_lsys", 0.6),
        ("plants_tuft_lsys", 0.35),
    ] {
        let found = world.plants.species.iter().find(|found| found.name == species).expect(species);
        let body = found.body(3, 0, &Limits::default()).unwrap();
        let [least, most] = body.bounds().unwrap();
        assert!(((most.y - least.y) / height - 1.0).abs() < 1e-6, "{species}: {}", most.y - least.y);
    }
    // Trees bear leaves, in the material of the leaf's file; without the folder they are bare.
    let count = |settings: &Folder| {
        let world = parse(&converted(settings)).unwrap();
        let tree = world.plants.species.iter().find(|found| found.name == "trees_round_honda").unwrap();
        let model = tree.grow(3, 0, &Limits::default()).unwrap();
        model.materials.iter().map(|material| material.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(count(&settings), ["bark", "leaf"]);
    let mut bare = settings.clone();
    bare.files.retain(|name, _| !name.starts_with("leafs/"));
    assert_eq!(count(&bare), ["bark"]);
    bare.folders.remove("leafs");
    assert_eq!(count(&bare), ["bark"]);
}

#[test]
fn files_are_taken_in_the_order_of_their_names() {
    let mut settings = all();
    for name in ["trees/b.honda", "trees/a.lsys", "trees/Z.honda", "trees/10.honda"] {
        let like = if name.ends_with("honda") { "trees/round.honda" } else { "trees/fork.lsys" };
        settings.files.insert(name.into(), settings.files[like].clone());
    }
    let world = parse(&converted(&settings)).unwrap();
    let names: Vec<&str> = world.plants.species.iter().map(|species| species.name.as_str()).collect();
    let wanted = ["10_honda", "Z_honda", "a_lsys", "b_honda", "fork_lsys", "round_honda"];
    assert_eq!(names[..6], wanted.map(|name| format!("trees_{name}")));
    assert_eq!(names[6..], ["plants_tuft_lsys", "plants_weed_lsys"]);
}

// The program --------------------------------------------------------------------------------------------------------

#[test]
fn a_converted_folder_is_the_same_world_and_gives_the_same_picture() {
    let area = tempfile::tempdir().unwrap();
    write(&small(), &area.path().join("wood"));
    let run = |arguments: &str| {
        let output = terrane(area.path(), arguments);
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        output
    };
    run("convert wood -o world.toml");
    let load = |path: &str| world::load(&area.path().join(path), &Overrides::default()).unwrap();
    let (folder, file) = (load("wood"), load("world.toml"));
    let told = |world: &World| {
        let World { seed, plan, light, sea, surface, plants, viewpoint, fov, film, .. } = world;
        // Rules are called after the place that they are written in.
        let mut plants = plants.clone();
        plants.rules.iter_mut().for_each(|rule| rule.name.clear());
        format!("{seed} {plan:?} {light:?} {sea:?} {surface:?} {plants:?} {viewpoint:?} {fov} {film:?}")
    };
    assert_eq!(told(&folder), told(&file));
    // All that can't be said in a file.
    let [warning] = &folder.warnings[..] else { panic!("{:?}", folder.warnings) };
    assert!(warning.contains("sky.conf: `SunColor` 1 0.97 0.9 is left out"), "{warning}");
    assert_eq!(file.warnings, [""; 0]);
    let white = and(&small(), "sky.conf", "\nSunColor 1 1 1.0");
    assert_eq!(thesis::convert(&white).unwrap().warnings, [""; 0]);
    assert_eq!(folder.name, "wood");

    // A picture without `-o` goes into the folder, in a folder that is made for it.
    run("render wood --no-cache");
    run("render world.toml -o again.exr --no-cache");
    run("compare wood/photos/meadow.exr again.exr");
    // The picture is no mistake in the folder, and what the command line says wins.
    run("render wood -o other.png --size 40x30 --no-cache");
    let picture = image::open(area.path().join("other.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (40, 30));
    run("check wood --no-time");
    run("export wood --layer height -o height.exr --no-cache");
    // Slashes and dots behind a name change nothing.
    run("check wood/ --no-time");
    run("convert ./wood/. --set render.exposure=1 -o set.toml");
    assert_eq!(load("set.toml").film.exposure, 1.0);

    let output = terrane(area.path(), "convert world.toml -o again.toml");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_file_that_is_missing_is_an_error_of_reading_and_a_mistake_is_one_of_writing() {
    let area = tempfile::tempdir().unwrap();
    let run = |settings: Folder, change: &dyn Fn(&Path)| {
        let folder = area.path().join("wood");
        let _ = fs::remove_dir_all(&folder);
        write(&settings, &folder);
        change(&folder);
        let output = terrane(area.path(), "check wood --no-time");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, told) = run(small(), &|folder| fs::remove_file(folder.join("sky.conf")).unwrap());
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("`sky.conf` is missing"), "{told}");
    let (code, told) = run(small(), &|folder| fs::remove_dir_all(folder.join("spawners")).unwrap());
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("the folder `spawners` is missing"), "{told}");
    let (code, told) = run(and(&small(), "terrain.conf", "\nN -1"), &|_| {});
    assert_eq!(code, Some(3), "{told}");
    // Refused by its size, before it is read.
    let (code, told) = run(small(), &|folder| {
        let file = fs::File::create(folder.join("trees/round.honda")).unwrap();
        file.set_len(1 << 30).unwrap();
    });
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("round.honda") && told.contains("at most 65536 bytes"), "{told}");
    // A pipe in place of a file never gives anything.
    let (code, told) = run(small(), &|folder| {
        fs::remove_file(folder.join("camera.conf")).unwrap();
        let made = Command::new("mkfifo").arg(folder.join("camera.conf")).status().unwrap();
        assert!(made.success());
    });
    assert_eq!(code, Some(7), "{told}");
    // A folder of other things is no world.
    let (code, told) = run(Folder::default(), &|folder| fs::create_dir_all(folder).unwrap());
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("a world is a TOML file, or a folder with"), "{told}");
    // What is not there can't be read.
    let (code, told) = run(Folder::default(), &|_| {});
    assert_eq!(code, Some(7), "{told}");
}

// Mistakes -----------------------------------------------------------------------------------------------------------

#[test]
fn mistakes_are_told_with_their_place_and_what_is_allowed() {
    let mut wrong = 0;
    for (name, change, wanted) in mistakes::MISTAKES {
        let mut settings = all();
        change(&mut settings);
        let report = refusal(&settings);
        let trimmed: Vec<&str> = report.lines().map(str::trim_end).collect();
        let report = trimmed.join("\n");
        if report != wanted.trim_matches('\n') {
            wrong += 1;
            eprintln!("== {name}\n{report}");
        }
    }
    assert_eq!(wrong, 0);
}

fn set(settings: &mut Folder, file: &str, text: &str) {
    *settings = with_file(settings, file, text);
}

// Folders ------------------------------------------------------------------------------------------------------------

/// The folder of the tests, and one leaf more.
fn all() -> Folder {
    let mut settings = Folder::read(&default()).unwrap();
    settings.name = "settings".into();
    let blade = "N 1\nHeight 0.2\nTurnAngle 30\nAxiom A\nProd A > {.+F.-F.-F.}\nMaterial Leaf\n";
    with_file(&settings, "leafs/blade.lsys", blade)
}

/// With few plants and pixels.
fn small() -> Folder {
    let mut settings = and(&all(), "pathTracer.conf", "\nResolution 64 36\nSamples 2");
    for spawner in ["left", "right", "meadow"] {
        settings = and(&settings, &format!("spawners/{spawner}.spawner"), "\nXGridN 3\nZGridN 3");
    }
    settings
}

fn default() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/thesis/default")
}

fn text_of(settings: &Folder, file: &str) -> String {
    let Contents::Bytes(bytes) = &settings.files[file] else { panic!("{file}") };
    String::from_utf8(bytes.clone()).unwrap()
}

fn with_file(settings: &Folder, file: &str, text: &str) -> Folder {
    let mut settings = settings.clone();
    settings.files.insert(file.into(), Contents::Bytes(text.into()));
    settings
}

/// With more text at the end of a file.
fn and(settings: &Folder, file: &str, text: &str) -> Folder {
    let before = text_of(settings, file);
    with_file(settings, file, &format!("{}{text}", before.trim_end()))
}

/// Without the lines of a parameter.
fn without(settings: &Folder, file: &str, name: &str) -> Folder {
    let text = text_of(settings, file);
    let lines = text.lines().filter(|line| line.split_whitespace().next() != Some(name));
    with_file(settings, file, &lines.collect::<Vec<_>>().join("\n"))
}

fn converted(settings: &Folder) -> String {
    thesis::convert(settings).unwrap_or_else(|error| panic!("{error}")).text
}

fn refusal(settings: &Folder) -> String {
    thesis::convert(settings).map(|converted| converted.text).unwrap_err().to_string()
}

fn parse(text: &str) -> Result<World, world::Error> {
    world::parse("settings", text.as_bytes(), Path::new(""), &Overrides::default())
}

fn write(settings: &Folder, into: &Path) {
    for folder in &settings.folders {
        fs::create_dir_all(into.join(folder)).unwrap();
    }
    for (name, contents) in &settings.files {
        let Contents::Bytes(bytes) = contents else { panic!("{name}") };
        fs::write(into.join(name), bytes).unwrap();
    }
}

fn terrane(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_terrane"))
        .args(arguments.split(' '))
        .current_dir(folder)
        .env("TERRANE_VALIDATION", "1")
        .output()
        .unwrap()
}
