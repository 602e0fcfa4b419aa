//! The reference pages of world files and species files, written from the keys' declarations.

use super::schema::{Alternative, Key, Names, Shape, Table, digits, paragraph};
use std::fmt::Write;

/// The whole reference as Markdown: `docs/worlds.md`.
pub fn reference() -> String {
    let mut page = String::from(INTRODUCTION);
    section(&mut page, "", &super::shape());
    page
}

/// The whole reference of species files as Markdown: `docs/species_files.md`.
pub fn reference_of_species() -> String {
    let mut page = String::from(INTRODUCTION_OF_SPECIES);
    section(&mut page, "", &super::species::shape());
    page
}

const INTRODUCTION: &str = r##"# World files

One TOML file describes one world. The shortest is `format = 1`: an island with everything at its default. The worlds in
`configs/` are there to be copied.

- What a file does not say has its default. `"none"` switches off what can be switched off: `reef = "none"`.
- Choices are tables with one key that says which: `sky = { preetham = { turbidity = 3 } }`.
- Metres, seconds and degrees unless a unit is given. x grows east, y up, z south, from the middle of the terrain.
- Colours are `"#rrggbb"` (sRGB) or `[red, green, blue]` (linear Rec.709, 0 to 1).
- Files are named from the folder of the world file.
- `--set section.key=value` changes any key for one run: `--set terrain.cells=256 --set sun.place.time=17
  --set terrain.layers.0.cone.height=900 --set reef=none`. Elements of arrays go by number, from 0.
- *Allowed* is what is accepted; *usual* is what was tried and gives good islands. `s⁻¹` is "per second".

Editors with Taplo (Even Better TOML in Visual Studio Code) complete, explain and check a world whose first line names
the schema, as those in `configs/` do: `#:schema ../worlds.schema.json`. For worlds of your own, write it beside them
with `terrane schema -o worlds.schema.json` and begin them with `#:schema ./worlds.schema.json`. What no schema can say,
such as keys that do not go together, `terrane check` says.

This page is written by the program from the same table that reads the files.
"##;

const INTRODUCTION_OF_SPECIES: &str = r##"# Species files

One TOML file describes one kind of plant: the rules of its growth, an L-system; what its symbols draw; and what it is made
of. The shortest has a `format` and a `grammar`:

```toml
format = 1
steps = 5
angle = 25.7
height = 2.5
grammar = '''
axiom F
F -> F[+F]F[-F]F
'''
```

- `docs/plants.md` tells the language of `grammar`, `docs/species.md` shows the species in `configs/species`, which are there to
  be copied.
- Write a grammar between three single quotes: what stands there is taken as it is. Between double quotes, `\` must be
  written `\\`.
- Metres and degrees. A plant stands at its origin and grows along +y; an organ's polygons are given along the turtle's heading,
  to its left, and upwards.
- Colours are reflectances, `"#rrggbb"` (sRGB) or `[red, green, blue]` (linear Rec.709, 0 to 1). What a leaf reflects and what
  it lets through are shares of the same light.
- `terrane plant FILE -o plant.png` shows a plant, `--stats` its figures; `-o plant.glb` writes it for other programs.
- A world names species files or has species of its own in its table `species`, with the same keys.

Editors with Taplo (Even Better TOML in Visual Studio Code) complete, explain and check a file whose first line names the
schema, as those in `configs/species` do: `#:schema ../species.schema.json`. For species of your own, write it beside them with
`terrane schema --species -o species.schema.json` and begin them with `#:schema ./species.schema.json`.

This page is written by the program from the same table that reads the files.
"##;

/// A table and those inside it, each under its own heading.
fn section(page: &mut String, path: &str, table: &Table) {
    let heading = if path.is_empty() { "The file".into() } else { format!("`{path}`") };
    // Writing to a string can't fail.
    let _ = write!(page, "\n## {heading}\n\n{}\n", paragraph(table.about));
    for preset in table.presets {
        let _ = write!(page, "\n`preset = \"{}\"`: {}.", preset.name, preset.about);
        if !preset.keys.is_empty() {
            let _ = write!(page, "\n\n```toml\n{}\n```\n", preset.keys.trim());
        }
    }
    page.push_str("\n| key | default | unit | allowed | usual | meaning |\n|---|---|---|---|---|---|\n");
    for key in &table.keys {
        page.push_str(&row(key));
    }
    for Key { name, shape, .. } in &table.keys {
        let path = if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
        inner(page, &path, shape);
    }
}

fn inner(page: &mut String, path: &str, shape: &Shape) {
    match shape {
        Shape::Table(table) => section(page, path, table),
        Shape::OrWord(shape, _) => inner(page, path, shape),
        Shape::Named { element, .. } => inner(page, &format!("{path}.NAME"), element),
        Shape::List { element, .. } => inner(page, &format!("{path}.N"), element),
        Shape::OneOf(alternatives) => {
            for Alternative { name, table, .. } in alternatives {
                if let Some(table) = table {
                    section(page, &format!("{path}.{name}"), table);
                }
            }
        }
        _ => {}
    }
}

fn row(key: &Key) -> String {
    let Key { name, about, default, shape, .. } = key;
    let default = if key.default_value().is_some() { code(&paragraph(default)) } else { default.clone() };
    let (unit, usual) = match shape.number() {
        Some((unit, usual)) => {
            (unit.symbol, usual.map(|[least, most]| span(least, most)).unwrap_or_default())
        }
        None => ("", String::new()),
    };
    let (allowed, meaning) = (cell(&allowed(shape)), cell(&paragraph(about)));
    format!("| `{name}` | {default} | {unit} | {allowed} | {usual} | {meaning}{} |\n", words(shape))
}

/// What may be written, for the column of that name.
fn allowed(shape: &Shape) -> String {
    match shape {
        Shape::Number { range: [least, most], .. } => span(*least, *most),
        Shape::Whole { range: [least, most] } if least == most => least.to_string(),
        Shape::Whole { range: [least, most] } => format!("{least} … {most}, whole"),
        Shape::Switch => "`true`, `false`".into(),
        Shape::Colour => "a colour".into(),
        Shape::File => "a path".into(),
        Shape::Choice(_) => "a word".into(),
        Shape::Array(elements) => match elements.first() {
            Some(element) => format!("{} × {}", elements.len(), allowed(element)),
            None => "an empty array".into(),
        },
        Shape::List { len: [least, most], .. } => format!("{least} … {most} elements"),
        Shape::Table(_) => "a table".into(),
        Shape::OneOf(alternatives) => {
            let names = alternatives.iter();
            names.map(|alternative| code(&alternative.written())).collect::<Vec<_>>().join(", ")
        }
        Shape::Text(what) => (*what).into(),
        Shape::OrWord(shape, [word, _]) => format!("{}, or `\"{word}\"`", allowed(shape)),
        Shape::Named { names: Names::Words, .. } => "a table of names".into(),
        Shape::Named { names: Names::Symbols, .. } => "a table of symbols".into(),
    }
}

fn span(least: f64, most: f64) -> String {
    format!("{} … {}", digits(least), digits(most))
}

/// The words of a choice with their meanings.
fn words(shape: &Shape) -> String {
    match shape {
        Shape::Choice(words) => {
            words.iter().map(|[word, about]| format!("<br>`\"{word}\"`: {}", cell(about))).collect()
        }
        _ => String::new(),
    }
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

/// Text that may stand in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
