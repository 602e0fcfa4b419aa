//! The JSON schema of world files: what it says of a world is what the program says.

use crate::kit::committed::{BLESS, check_committed};
use jsonschema::Validator;
use proptest::prelude::*;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use terrane::world::{self, Overrides, schema};
use toml_edit::{DocumentMut, InlineTable, Item};

static VALIDATOR: LazyLock<Validator> =
    LazyLock::new(|| jsonschema::draft202012::new(&world::json_schema()).unwrap());

fn files(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "toml")).collect();
    files.sort();
    files
}

/// A world as editors see it: JSON has no dates and no infinity.
fn json(item: &Item) -> Value {
    use toml_edit::Value as Toml;
    if let Some(table) = item.as_table_like() {
        return table
            .iter()
            .map(|(key, item)| (key.to_string(), json(item)))
            .collect::<serde_json::Map<_, _>>()
            .into();
    }
    if let Some(tables) = item.as_array_of_tables() {
        return tables.iter().map(|table| json(&Item::Table(table.clone()))).collect();
    }
    match item.as_value() {
        Some(Toml::String(word)) => word.value().as_str().into(),
        Some(Toml::Integer(whole)) => (*whole.value()).into(),
        Some(Toml::Float(float)) => (*float.value()).into(),
        Some(Toml::Boolean(switch)) => (*switch.value()).into(),
        Some(Toml::Datetime(date)) => date.value().to_string().into(),
        Some(Toml::Array(elements)) => {
            elements.iter().map(|element| json(&Item::Value(element.clone()))).collect()
        }
        _ => Value::Null,
    }
}

fn complaints(world: &Value) -> Vec<String> {
    VALIDATOR.iter_errors(world).map(|error| format!("{}: {error}", error.instance_path())).collect()
}

#[test]
fn the_committed_schema_is_up_to_date() {
    let text = format!("{:#}\n", world::json_schema());
    if let Err(difference) = check_committed(Path::new("configs/worlds.schema.json"), &text) {
        panic!("run this test with {BLESS}=1 and commit configs/worlds.schema.json\n{difference}");
    }
}

#[test]
fn it_is_a_schema() {
    jsonschema::meta::validate(&world::json_schema()).unwrap();
}

#[test]
fn shipped_worlds_pass_and_lead_to_it() {
    for path in files("configs/island").into_iter().chain(files("configs/zoom")) {
        let text = fs::read_to_string(&path).unwrap();
        let world = json(text.parse::<DocumentMut>().unwrap().as_item());
        assert_eq!(complaints(&world), [""; 0], "{}", path.display());
        let schema = text.lines().next().unwrap().strip_prefix("#:schema ").unwrap();
        assert!(path.parent().unwrap().join(schema).is_file(), "{schema}");
    }
    for example in world::json_schema()["examples"].as_array().unwrap() {
        assert_eq!(complaints(example), [""; 0]);
    }
}

/// Taplo, the reader behind most editors, finds the schema by the first line and takes the shipped worlds.
#[test]
#[ignore = "fetches Taplo from npm"]
fn taplo_takes_shipped_worlds_and_refuses_others() {
    let lint = |path: &Path| {
        let mut taplo = Command::new("npx");
        taplo.args(["--yes", "@taplo/cli@0.7.0", "lint"]).arg(path).output().expect("npx of Node.js")
    };
    for path in files("configs/island") {
        let output = lint(&path);
        assert!(output.status.success(), "{}: {output:?}", path.display());
    }
    let folder = tempfile::tempdir().unwrap();
    fs::copy("configs/worlds.schema.json", folder.path().join("worlds.schema.json")).unwrap();
    let path = folder.path().join("world.toml");
    fs::write(&path, "#:schema ./worlds.schema.json\nformat = 1\n[terrain]\ncells = 10\n").unwrap();
    let output = lint(&path);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("less than the minimum of 64"), "{output:?}");
}

/// Wrong in a way that a schema can't say: keys that don't go together, files, and what JSON has no word for.
const ONLY_THE_PROGRAM: &[&str] = &[
    "camera_inside_its_target",
    "camera_under_the_sea",
    "cone_outside_terrain",
    "cone_wider_than_terrain",
    "crater_first",
    "heightmap_missing",
    "heightmap_of_no_known_kind",
    "heightmap_upside_down",
    "heightmap_with_half_a_range",
    "mask_is_a_folder",
    "plants_mask_missing",
    "plants_near_beyond_reach",
    "plants_of_no_species",
    "plants_ramp_level",
    "plants_ramp_of_three",
    "plants_scale_falling",
    "plants_shares_of_others",
    "plants_shares_zero",
    "plants_too_dense",
    "plants_unknown_species",
    "power_first",
    "power_without_cone",
    "reef_in_the_open_ocean",
    "reef_of_too_many_steps",
    "reef_without_depth",
    "reference_without_power",
    "rock_slope_falling",
    "thermal_duration_with_hydraulic",
    "thermal_every_without_hydraulic",
    "too_many_passes",
    "too_many_slides",
    "too_many_sweeps",
    // 512.0 is an integer of JSON.
    "whole_number_with_a_point",
];

#[test]
fn bad_worlds_are_refused() {
    let (mut refused, mut accepted) = (0, Vec::new());
    for path in files("tests/data/bad_worlds") {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        // Some are wrong in the arguments of --set, some are no TOML: no editor gets as far as the schema.
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let Ok(document) = text.parse::<DocumentMut>() else { continue };
        if text.starts_with("#set ") {
            continue;
        }
        if VALIDATOR.is_valid(&json(document.as_item())) {
            accepted.push(name);
        } else {
            refused += 1;
        }
    }
    assert_eq!(accepted, ONLY_THE_PROGRAM);
    assert!(refused > 40, "{refused}");
}

/// What the program says beyond the schema, when it has understood every key by itself.
const BEYOND: &[&str] = &[
    "is where the camera stands",
    "lies under the sea",
    "lies outside the terrain",
    "is wider than the terrain",
    "is a crater with nothing to sink into",
    "has nothing to combine with",
    "is missing",
    "must be above `min`",
    "must lie above",
    "names \"",
    "must not be less than",
    "leaves no depth to grow in",
    "leaves no place to stand",
    "has no use here",
    "must rise",
    "asks for too much work",
    // Of a grammar, which is a string to the schema.
    "can't be read: ",
    // JSON takes 512.0 for an integer, and has a date as a string.
    "not a number with a point",
    "not a date",
];

/// Every key of the file with its way, through the alternatives that a world can have at once.
fn keys() -> Vec<(String, schema::Key)> {
    fn collect(path: &str, shape: &schema::Shape, keys: &mut Vec<(String, schema::Key)>) {
        use schema::Shape;
        match shape {
            Shape::Table(table) => {
                for key in &table.keys {
                    let path = if path.is_empty() { key.name.into() } else { format!("{path}.{}", key.name) };
                    keys.push((path.clone(), key.clone()));
                    collect(&path, &key.shape, keys);
                }
            }
            Shape::OrWord(shape, _) => collect(path, shape, keys),
            Shape::Named { element, .. } => collect(&format!("{path}.x"), element, keys),
            Shape::List { element, .. } => collect(&format!("{path}.0"), element, keys),
            Shape::OneOf(alternatives) => {
                for alternative in alternatives {
                    if let Some(table) = &alternative.table {
                        collect(&format!("{path}.{}", alternative.name), &Shape::Table(table.clone()), keys);
                    }
                }
            }
            _ => {}
        }
    }
    let mut keys = Vec::new();
    collect("", &schema::Shape::Table(world::shape()), &mut keys);
    keys
}

/// Values as TOML: some of any kind, and some at the ends of what `key` allows.
fn value(key: &schema::Key) -> BoxedStrategy<String> {
    let any = prop::sample::select(vec![
        "true",
        "0",
        "1",
        "-1",
        "0.5",
        "1e300",
        "\"\"",
        "\"none\"",
        "\"sea\"",
        "\"#12345g\"",
        "\"#123456\"",
        "[]",
        "{}",
        "[1, 2]",
        "[0.5, 0.5, 0.5]",
        "[1, 2, 3]",
        "[\"a\", 1]",
        "{ none = {} }",
        "{ cone = {} }",
        "{ preetham = {} }",
        "{ preset = \"paper\" }",
        "{ preset = 1 }",
        "[{ cone = {} }]",
        "[{}, {}]",
        "1979-05-27",
        "nan",
        "-inf",
        "9223372036854775807",
    ])
    .prop_map(String::from);
    match &key.shape {
        schema::Shape::Number { range: [least, most], .. } => {
            let width = most - least;
            let near = (-0.1..1.1_f64).prop_map({
                let least = *least;
                move |share| format!("{:?}", least + share * width)
            });
            prop_oneof![any, near, Just(format!("{least:?}")), Just(format!("{most:?}"))].boxed()
        }
        schema::Shape::Whole { range: [least, most] } => {
            let (least, most) = (*least, *most);
            prop_oneof![
                any,
                (least - 2..=least + 2).prop_map(|whole| whole.to_string()),
                (most - 2..=most + 2).prop_map(|whole| whole.to_string())
            ]
            .boxed()
        }
        schema::Shape::Choice(words) => {
            let words: Vec<String> = words.iter().map(|[word, _]| format!("\"{word}\"")).collect();
            prop_oneof![any, prop::sample::select(words)].boxed()
        }
        _ => any.boxed(),
    }
}

/// An assignment to one key of a world: its name now and then misspelt.
fn mutation() -> impl Strategy<Value = (String, String)> {
    prop::sample::select(keys()).prop_flat_map(|(path, key)| {
        let path = prop_oneof![9 => Just(path.clone()), 1 => Just(path + "x")];
        (path, value(&key))
    })
}

/// Sets what lies at `path`, and makes tables on the way. Does nothing where something else is in the way.
fn assign(item: &mut Item, path: &[&str], value: toml_edit::Value) {
    let Some((first, rest)) = path.split_first() else {
        *item = Item::Value(value);
        return;
    };
    if let Some(table) = item.as_table_like_mut() {
        assign(table.entry(first).or_insert(Item::Value(InlineTable::new().into())), rest, value);
    } else if let Some(element) = item.as_array_mut().and_then(|array| array.get_mut(first.parse().ok()?)) {
        let mut inner = Item::Value(element.clone());
        assign(&mut inner, rest, value);
        *element = inner.into_value().unwrap();
    }
}

/// What `make fuzz` runs with many more cases.
mod fuzz {
    use super::*;

    proptest! {
        #[test]
        fn the_schema_and_the_program_agree(
            path in prop::sample::select(files("configs/island")),
            set in prop::collection::vec(mutation(), 1..4),
        ) {
            let mut document: DocumentMut = fs::read_to_string(&path).unwrap().parse().unwrap();
            for (path, value) in &set {
                assign(document.as_item_mut(), &path.split('.').collect::<Vec<_>>(), value.parse().unwrap());
            }
            let text = document.to_string();
            let complaints = complaints(&json(document.as_item()));
            match world::parse("world.toml", text.as_bytes(), path.parent().unwrap(), &Overrides::default()) {
                Ok(_) => prop_assert!(complaints.is_empty(), "the schema refuses {:?}: {:?}", set, complaints),
                Err(error) => {
                    let message = error.to_string();
                    let beyond = BEYOND.iter().any(|words| message.lines().next().unwrap().contains(words));
                    prop_assert!(beyond || !complaints.is_empty(), "the schema accepts {:?}: {}", set, message);
                }
            }
        }
    }
}
