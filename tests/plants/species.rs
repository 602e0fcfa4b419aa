//! Species files: the shipped ones grow as they say, the book's figures come out of them, and what is wrong with a file is
//! told with its place.

use crate::kit::committed::{BLESS, check_committed};
use glam::DVec3;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use terrane::plants::derive::Limits;
use terrane::plants::mesh::{Body, Shape};
use terrane::plants::watch::Watch;
use terrane::world;
use terrane::world::species::{self, Loaded};
use toml_edit::{DocumentMut, Item};

const FOLDER: &str = "configs/species";

/// What a landscape is planted with: heights of all variants (m), triangles of the finest level at most, what may lie below
/// the ground (m), and the sum of leaves' areas by the area of the crown, seen from above.
struct Portrait {
    name: &'static str,
    height: [f64; 2],
    triangles: usize,
    below: f64,
    leaf_area_index: [f64; 2],
}

const fn portrait(
    name: &'static str,
    height: [f64; 2],
    triangles: usize,
    below: f64,
    leaf_area_index: [f64; 2],
) -> Portrait {
    Portrait { name, height, triangles, below, leaf_area_index }
}

const PORTRAITS: [Portrait; 12] = [
    portrait("beech", [10.0, 13.0], 150_000, 0.02, [2.5, 7.0]),
    portrait("daisy", [0.3, 0.7], 1_500, 0.02, [0.1, 1.5]),
    portrait("dead", [6.0, 9.5], 60_000, 0.02, [0.0, 0.0]),
    portrait("fern", [0.6, 1.1], 30_000, 0.02, [1.0, 3.0]),
    portrait("grass", [0.3, 0.8], 420, 0.01, [0.1, 2.0]),
    portrait("oak", [7.5, 10.5], 150_000, 0.02, [2.5, 7.0]),
    portrait("palm", [10.0, 15.0], 60_000, 0.2, [1.0, 3.0]),
    // Needles stand in crossed fans: half of their area faces the sky.
    portrait("pine", [12.0, 17.0], 150_000, 0.02, [3.0, 10.0]),
    portrait("poppy", [0.3, 0.75], 1_500, 0.02, [0.1, 1.5]),
    portrait("shrub", [1.5, 2.5], 60_000, 0.02, [2.0, 5.0]),
    portrait("spruce", [12.0, 16.0], 150_000, 0.02, [4.0, 14.0]),
    portrait("tussock", [0.5, 1.1], 600, 0.01, [0.1, 2.0]),
];

fn files(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect();
    files.sort();
    files
}

fn load(name: &str) -> Loaded {
    let path = Path::new(FOLDER).join(name).with_extension("toml");
    species::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

fn body(loaded: &Loaded, variant: u32) -> Body {
    let body = loaded.species.body(1, variant, &Limits::default());
    body.unwrap_or_else(|error| panic!("{}: {}", loaded.species.name, loaded.source.blame(&error)))
}

// What ships ---------------------------------------------------------------------------------------------------------

#[test]
fn the_shipped_species_are_all_there() {
    let mut names: Vec<String> = PORTRAITS.iter().map(|portrait| portrait.name.into()).collect();
    for figure in ["abop_1_24a-f", "abop_2_7a-d", "abop_2_8a-d", "abop_5_6a-f", "honda_a-d"] {
        let (stem, last) = figure.split_once("a-").unwrap();
        let last = last.chars().next().unwrap();
        names.extend(('a'..=last).map(|letter| format!("{stem}{letter}")));
    }
    names.extend(["abop_1_25", "abop_1_26"].map(String::from));
    names.sort();
    let stem = |path: &PathBuf| path.file_stem().unwrap().to_string_lossy().into_owned();
    assert_eq!(files(FOLDER).iter().map(stem).collect::<Vec<_>>(), names);
}

#[test]
fn shipped_species_read_without_warnings_and_grow_in_every_variant() {
    for path in files(FOLDER) {
        let loaded = species::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.warnings, [""; 0], "{}", path.display());
        let species = &loaded.species;
        let mut bodies = Vec::new();
        for variant in 0..species.variants {
            let body = body(&loaded, variant);
            let [least, most] = body.bounds().unwrap();
            if let Some(height) = species.height {
                assert!((most.y - least.y - f64::from(height)).abs() < 1e-3 * f64::from(height));
            }
            let levels = species.model(&body, Watch::NONE).unwrap().levels;
            let triangles = levels[0].triangles();
            assert!(triangles > 0 && triangles < 150_000, "{}: {triangles}", path.display());
            assert!(levels.len() >= 3, "{}: {} levels", path.display(), levels.len());
            bodies.push(body);
        }
        // Variants are different plants.
        for (index, body) in bodies.iter().enumerate() {
            assert!(!bodies[..index].contains(body), "{}: variant {index} is another again", path.display());
        }
    }
}

/// However small a plant is, it has three levels: each with larger details than the one before, and with no more triangles.
#[test]
fn the_smallest_plants_have_three_levels() {
    for text in [
        "grammar = 'axiom F'",
        "grammar = 'axiom {F+(90)F+(90)F}'\ndraw = 'F'",
        "grammar = 'axiom ~L'\norgans.L.polygons = [{ vertices = [[0, 0, 0], [1, 0.2, 0], [1, -0.2, 0]] }]",
    ] {
        let loaded = species::parse("plant.toml", format!("format = 1\n{text}\n").as_bytes()).unwrap();
        let levels = loaded.species.grow(1, 0, &Limits::default()).unwrap().levels;
        assert!(levels.len() == 3 && levels[2].triangles() > 0, "{text}: {} levels", levels.len());
        for pair in levels.windows(2) {
            assert!(pair[0].detail < pair[1].detail && pair[0].triangles() >= pair[1].triangles(), "{text}");
        }
    }
}

#[test]
fn plants_of_landscapes_have_the_size_and_the_leaves_that_they_should() {
    for Portrait { name, height, triangles, below, leaf_area_index } in PORTRAITS {
        let loaded = load(name);
        for variant in 0..loaded.species.variants {
            let body = body(&loaded, variant);
            let [least, most] = body.bounds().unwrap();
            let found = loaded.species.model(&body, Watch::NONE).unwrap().levels[0].triangles();
            let within = |what: &str, value: f64, [low, high]: [f64; 2]| {
                assert!((low..=high).contains(&value), "{name}, variant {variant}: {what} is {value}");
            };
            within("height", most.y, height);
            within("number of triangles", found as f64, [1.0, triangles as f64]);
            within("depth", -least.y, [-0.01, below]);
            let size = most - least;
            let crown = std::f64::consts::PI / 4.0 * ((size.x + size.z) / 2.0).powi(2);
            within("leaf area index", body.leaf_area() / crown, leaf_area_index);
        }
    }
}

/// Least and greatest as people read them: two or three figures, and one number where these are the same.
fn range(values: &[f64], unit: &str) -> String {
    let [least, most] = [f64::INFINITY, f64::NEG_INFINITY];
    let (least, most) =
        values.iter().fold((least, most), |(least, most), value| (least.min(*value), most.max(*value)));
    let decimals = if most < 1.0 { 2 } else { usize::from(most < 20.0) };
    let [least, most] = [least, most].map(|value| match value {
        0.0 => "0".into(),
        _ => format!("{value:.decimals$}"),
    });
    if least == most { format!("{most}{unit}") } else { format!("{least}–{most}{unit}") }
}

/// The figures of a row in the table of docs/species.md, of all variants.
fn figures(name: &str) -> String {
    let loaded = load(name);
    let [mut heights, mut widths, mut leaves] = [const { Vec::new() }; 3];
    let [mut triangles, mut levels] = [const { Vec::new() }; 2];
    for variant in 0..loaded.species.variants {
        let body = body(&loaded, variant);
        let [least, most] = body.bounds().unwrap();
        heights.push(most.y);
        widths.push((most.x - least.x + most.z - least.z) / 2.0);
        leaves.push(body.leaf_area());
        let model = loaded.species.model(&body, Watch::NONE).unwrap();
        triangles.push(model.levels[0].triangles());
        levels.push(model.levels.len());
    }
    let whole = |counts: &[usize]| {
        let [least, most] = [counts.iter().min().unwrap(), counts.iter().max().unwrap()];
        if least == most { most.to_string() } else { format!("{least}–{most}") }
    };
    let thousands: Vec<f64> = triangles.iter().map(|&count| count as f64 / 1000.0).collect();
    let are_many = triangles.iter().all(|&count| count >= 1000);
    let triangles = if are_many { range(&thousands, " k") } else { whole(&triangles) };
    let [heights, widths, leaves] = [heights, widths, leaves].map(|values| range(&values, ""));
    let (levels, variants) = (whole(&levels), loaded.species.variants);
    format!("{heights} | {widths} | {leaves} | {triangles} | {levels} | {variants}")
}

#[test]
fn the_table_of_species_has_their_figures() {
    let path = Path::new("docs/species.md");
    let text = fs::read_to_string(path).unwrap();
    let mut rows = 0;
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let name = cells.get(1).unwrap_or(&"").trim_matches('`').to_string();
        if !PORTRAITS.iter().any(|portrait| portrait.name == name) {
            return format!("{line}\n");
        }
        rows += 1;
        format!("| `{name}` | {} | {} |\n", cells[2], figures(&name))
    };
    let wanted: String = text.lines().map(row).collect();
    assert_eq!(rows, PORTRAITS.len());
    if let Err(difference) = check_committed(path, &wanted) {
        panic!("run this test with {BLESS}=1 and commit docs/species.md\n{difference}");
    }
}

// Nothing floats -----------------------------------------------------------------------------------------------------

/// A line of a plant: a piece of a branch with its radius, or an edge of a leaf.
#[derive(Clone, Copy)]
struct Line {
    from: DVec3,
    to: DVec3,
    radius: f64,
    part: usize,
}

impl Line {
    fn distance(&self, point: DVec3) -> f64 {
        let along = self.to - self.from;
        let share = ((point - self.from).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        (self.from + share * along).distance(point) - self.radius
    }
}

/// Branches and leaves that nothing holds: each must begin at the ground, or at a part that is held.
fn floating(body: &Body, tolerance: f64) -> Vec<String> {
    let mut lines = Vec::new();
    // Where parts begin.
    let mut bases = Vec::new();
    for (part, stem) in body.stems.iter().enumerate() {
        bases.push(stem.nodes[0].position);
        lines.extend(stem.nodes.windows(2).map(|pair| Line {
            from: pair[0].position,
            to: pair[1].position,
            radius: pair[0].width.min(pair[1].width) / 2.0,
            part,
        }));
    }
    for (index, leaf) in body.leaves.iter().enumerate() {
        bases.push(leaf.place.translation);
        for triangle in body.blades[leaf.blade].triangles(Shape::Whole) {
            let corners = triangle.map(|corner| leaf.place.transform_point3(corner));
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let part = body.stems.len() + index;
                lines.push(Line { from: corners[from], to: corners[to], radius: 0.0, part });
            }
        }
    }
    // Lines by the cells that they pass.
    let cell = 20.0 * tolerance;
    let key = |point: DVec3| (point / cell).floor().as_i64vec3();
    let mut cells: HashMap<_, Vec<usize>> = HashMap::new();
    for (index, line) in lines.iter().enumerate() {
        let steps = (line.from.distance(line.to) / (cell / 2.0)).ceil().max(1.0) as u32;
        let reach = ((line.radius + cell / 4.0) / cell).ceil() as i64;
        let mut passed = BTreeSet::new();
        for step in 0..=steps {
            let centre = key(line.from.lerp(line.to, f64::from(step) / f64::from(steps)));
            for x in -reach..=reach {
                for y in -reach..=reach {
                    for z in -reach..=reach {
                        passed.insert([centre.x + x, centre.y + y, centre.z + z]);
                    }
                }
            }
        }
        passed.into_iter().for_each(|at| cells.entry(at).or_default().push(index));
    }
    // From the ground upwards: which parts begin at which.
    let mut borne: Vec<Vec<usize>> = vec![Vec::new(); bases.len()];
    let mut queue = VecDeque::new();
    let mut held = vec![false; bases.len()];
    for (part, &base) in bases.iter().enumerate() {
        if base.y <= tolerance {
            held[part] = true;
            queue.push_back(part);
        }
        for &index in cells.get(&key(base).to_array()).into_iter().flatten() {
            if lines[index].part != part && lines[index].distance(base) <= tolerance {
                borne[lines[index].part].push(part);
            }
        }
    }
    while let Some(part) = queue.pop_front() {
        for &next in &borne[part] {
            if !std::mem::replace(&mut held[next], true) {
                queue.push_back(next);
            }
        }
    }
    let loose = (0..bases.len()).filter(|&part| !held[part]);
    loose
        .map(|part| {
            let what = if part < body.stems.len() { "branch" } else { "leaf" };
            format!("{what} {part} at {}", bases[part])
        })
        .collect()
}

#[test]
fn nothing_floats() {
    for path in files(FOLDER) {
        let loaded = species::load(&path).unwrap();
        let variants = loaded.species.variants.min(2);
        for variant in 0..variants {
            let body = body(&loaded, variant);
            let [least, most] = body.bounds().unwrap();
            let found = floating(&body, 1e-3 * (most - least).length());
            assert!(
                found.is_empty(),
                "{}, variant {variant}: {:?}",
                path.display(),
                &found[..found.len().min(5)]
            );
        }
    }
}

/// And would be seen.
#[test]
fn what_floats_is_found() {
    let loaded = load("oak");
    let mut body = body(&loaded, 0);
    assert!(floating(&body, 0.01).is_empty());
    body.leaves[1000].place.translation.y += 30.0;
    let stem = body.stems.len() - 1;
    body.stems[stem].nodes.iter_mut().for_each(|node| node.position.x += 50.0);
    let found = floating(&body, 0.01);
    for what in [format!("branch {stem} "), format!("leaf {} ", body.stems.len() + 1000)] {
        assert!(found.iter().any(|found| found.starts_with(&what)), "{what} is not in {found:?}");
    }
    // They and what the twig bore.
    assert!(found.len() < 12, "{found:?}");
}

/// An L-system inside a plant goes on where it is placed, in the turtle's direction and with its left and up.
#[test]
fn an_organ_that_grows_stands_as_the_turtle_does() {
    let rules = "-(35)&(20)/(50)F(0.5)[+(90)F(0.2)][^(90)F(0.1)]";
    let in_one = format!("format = 1\ngrammar = \"axiom F(1)+(40)&(60)[{rules}]\"");
    let in_two = format!(
        "format = 1\ngrammar = \"axiom F(1)+(40)&(60)~T(1)\"\norgans.T.width = 0.1\norgans.T.grammar = \"axiom {rules}\""
    );
    let stems = |text: String| {
        let loaded = species::parse("plant.toml", text.as_bytes()).unwrap();
        body(&loaded, 0).stems
    };
    let [one, two] = [in_one, in_two].map(stems);
    assert_eq!(one.len(), 4);
    for (one, two) in one.iter().zip(&two) {
        for (one, two) in one.nodes.iter().zip(&two.nodes) {
            assert!(one.position.distance(two.position) < 1e-12, "{one:?} {two:?}");
        }
    }
}

// Figures of the book ------------------------------------------------------------------------------------------------

/// Files whose grammar is that of a system of the conformance data, step by step and letter by letter.
const OF_THE_BOOK: [(&str, &str); 11] = [
    ("abop_1_24a", "abop_1.24a"),
    ("abop_1_24b", "abop_1.24b"),
    ("abop_1_24c", "abop_1.24c"),
    ("abop_1_24d", "abop_1.24d"),
    ("abop_1_26", "abop_1.26"),
    ("honda_a", "abop_2.6a"),
    ("honda_d", "abop_2.6d"),
    ("abop_2_7a", "abop_2.7a"),
    ("abop_2_8b", "abop_2.8b"),
    ("abop_5_6a", "abop_5.6a"),
    ("abop_5_6d", "abop_5.6d"),
];

fn conformance() -> HashMap<String, Value> {
    let data: Value = serde_json::from_str(include_str!("../data/lsystem_conformance.json")).unwrap();
    let systems = data["systems"].as_array().unwrap().iter();
    systems.map(|system| (system["id"].as_str().unwrap().into(), system["expected"].clone())).collect()
}

fn near(found: &Value, wanted: &Value, scale: f64) -> bool {
    match (found, wanted) {
        (Value::Array(found), Value::Array(wanted)) => {
            found.len() == wanted.len()
                && found.iter().zip(wanted).all(|(found, wanted)| near(found, wanted, scale))
        }
        _ => (found.as_f64().unwrap() - wanted.as_f64().unwrap()).abs() <= 1e-9 * scale,
    }
}

/// `terrane plant --stats` says of them what the data say.
#[test]
fn figures_of_the_book_have_the_books_numbers() {
    let conformance = conformance();
    for (file, id) in OF_THE_BOOK {
        let expected = &conformance[id];
        let file = format!("{FOLDER}/{file}.toml");
        let output = terrane(&["plant", &file, "--stats", "--json"]);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let plant = &report["plant"];
        let exact = [
            "modules",
            "counts",
            "branches",
            "sha256_symbols",
            "drawn_segments",
            "max_bracket_depth",
            "polygons",
            "polygon_vertices",
        ];
        for name in exact {
            assert_eq!(plant[name], expected[name], "{id}: {name}");
        }
        let per_step: Vec<&Value> =
            plant["steps"].as_array().unwrap().iter().map(|step| &step["modules"]).collect();
        assert_eq!(
            per_step,
            expected["per_step_modules"].as_array().unwrap().iter().collect::<Vec<_>>(),
            "{id}"
        );
        let size =
            expected["bbox_max"].as_array().unwrap().iter().chain(expected["bbox_min"].as_array().unwrap());
        let size = size.map(|value| value.as_f64().unwrap().abs()).fold(1.0, f64::max);
        for name in ["bbox_min", "bbox_max", "end_position"] {
            assert!(near(&plant[name], &expected[name], size), "{id}: {name} is {}", plant[name]);
        }
        for name in ["drawn_length", "polygon_area_sum"] {
            let scale = expected[name].as_f64().unwrap();
            assert!(near(&plant[name], &expected[name], scale), "{id}: {name} is {}", plant[name]);
        }
        // For people, the same.
        let output = terrane(&["plant", &file, "--stats"]);
        let text = String::from_utf8(output.stdout).unwrap();
        for (name, value) in expected["counts"].as_object().unwrap() {
            assert!(text.contains(&format!(" {name} {value}")), "{id}: no {name} {value} in\n{text}");
        }
        for words in [
            format!("SHA-256 {}\n", expected["sha256_symbols"].as_str().unwrap()),
            format!("branches  {}, at most {} deep\n", expected["branches"], expected["max_bracket_depth"]),
            format!("turtle    {} segments, ", expected["drawn_segments"]),
            format!("polygons  {} with {} vertices, ", expected["polygons"], expected["polygon_vertices"]),
        ] {
            assert!(text.contains(&words), "{id}: no {words} in\n{text}");
        }
    }
}

fn terrane(arguments: &[&str]) -> Output {
    let output = Command::new(env!("CARGO_BIN_EXE_terrane"))
        .args(arguments)
        .env("TERRANE_CACHE", std::env::temp_dir().join("terrane-species"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

// Mistakes -----------------------------------------------------------------------------------------------------------

/// One case a file, and beside it the message. What shows only when the plant grows is told with its place, too.
#[test]
fn each_bad_species_gets_its_message() {
    let cases = files("tests/data/bad_species");
    assert!(cases.len() >= 35, "only {} cases", cases.len());
    let limits = Limits { work: 20_000_000, ..Limits::default() };
    let mut wrong = Vec::new();
    for case in cases {
        let name = case.file_name().unwrap().to_string_lossy();
        let bytes = fs::read(&case).unwrap();
        let error = match species::parse(&name, &bytes) {
            Err(error) => error,
            Ok(loaded) => match loaded.species.body(1, 0, &limits) {
                Err(error) => loaded.source.blame(&error),
                Ok(_) => panic!("{name} is accepted"),
            },
        };
        let message = format!("exit code {}\nerror: {error}\n", error.exit_code());
        wrong.extend(check_committed(&case.with_extension("txt"), &message).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_file_over_the_limit_is_refused_and_so_is_one_that_is_no_text() {
    let mut bytes = b"format = 1\ngrammar = \"axiom F\"\n".to_vec();
    bytes.resize(world::MAX_BYTES, b'#');
    assert!(species::parse("plant.toml", &bytes).is_ok());
    bytes.push(b'#');
    let error = species::parse("plant.toml", &bytes).unwrap_err();
    assert_eq!((error.exit_code(), error.to_string().contains("too large")), (3, true), "{error}");
    let error = species::parse("plant.toml", b"format = 1 # \xff").unwrap_err();
    assert_eq!(error.exit_code(), 3, "{error}");
    let error = species::load(Path::new("tests/data/nowhere.toml")).unwrap_err();
    assert_eq!(error.exit_code(), 7, "{error}");
}

// The schema and the reference ---------------------------------------------------------------------------------------

#[test]
fn the_committed_schema_and_reference_are_up_to_date() {
    let schema = format!("{:#}\n", world::json_schema_of_species());
    for (path, text) in
        [("configs/species.schema.json", schema), ("docs/species_files.md", world::reference_of_species())]
    {
        if let Err(difference) = check_committed(Path::new(path), &text) {
            panic!("run this test with {BLESS}=1 and commit {path}\n{difference}");
        }
    }
    assert_eq!(
        terrane(&["schema", "--species"]).stdout,
        fs::read("configs/species.schema.json").unwrap(),
        "terrane schema --species"
    );
}

#[test]
fn shipped_species_pass_the_schema_and_lead_to_it() {
    let schema = world::json_schema_of_species();
    jsonschema::meta::validate(&schema).unwrap();
    let validator = jsonschema::draft202012::new(&schema).unwrap();
    let complaints = |value: &Value| -> Vec<String> {
        validator.iter_errors(value).map(|error| format!("{}: {error}", error.instance_path())).collect()
    };
    for path in files(FOLDER) {
        let text = fs::read_to_string(&path).unwrap();
        let document: DocumentMut = text.parse().unwrap();
        assert_eq!(complaints(&json(document.as_item())), [""; 0], "{}", path.display());
        let schema = text.lines().next().unwrap().strip_prefix("#:schema ").unwrap();
        assert!(path.parent().unwrap().join(schema).is_file(), "{schema}");
    }
    for example in schema["examples"].as_array().unwrap() {
        assert_eq!(complaints(example), [""; 0]);
    }
    for bad in [
        "unknown_key",
        "no_variants",
        "negative_steps",
        "plus_upwards",
        "organ_of_two_letters",
        "outline_of_two_corners",
    ] {
        let text = fs::read_to_string(format!("tests/data/bad_species/{bad}.toml")).unwrap();
        let document: DocumentMut = text.parse().unwrap();
        assert!(!complaints(&json(document.as_item())).is_empty(), "{bad}");
    }
}

/// A file as editors see it.
fn json(item: &Item) -> Value {
    use toml_edit::Value as Toml;
    if let Some(table) = item.as_table_like() {
        return table
            .iter()
            .map(|(key, item)| (key.to_string(), json(item)))
            .collect::<serde_json::Map<_, _>>()
            .into();
    }
    match item.as_value() {
        Some(Toml::String(word)) => word.value().as_str().into(),
        Some(Toml::Integer(whole)) => (*whole.value()).into(),
        Some(Toml::Float(float)) => (*float.value()).into(),
        Some(Toml::Boolean(switch)) => (*switch.value()).into(),
        Some(Toml::Array(elements)) => {
            elements.iter().map(|element| json(&Item::Value(element.clone()))).collect()
        }
        _ => Value::Null,
    }
}
