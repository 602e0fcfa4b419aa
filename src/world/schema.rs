//! What may stand in a world file, as data: messages, the reference page and the viewer's sliders are made from it. The kinds of values come from `kinds`, the declarations from `keys`.

use super::place::Place;
use toml_edit::{Item, Value};

/// What may stand at a place in a world file, and what it becomes.
pub trait Kind {
    type Value;

    /// What may be written.
    fn shape(&self) -> Shape;

    /// What stands for nothing written, as TOML or, where it depends on other keys, in words; or [`REQUIRED`].
    fn default(&self) -> String;

    /// What an editor writes first, as TOML, where nothing is written and the default is told in words, or is a word.
    fn start(&self) -> String {
        self.default()
    }

    /// What is written, in the program's units. Mistakes are noted at the place, and the default stands for them.
    fn read(&self, place: &Place) -> Self::Value;
}

/// What may be written at a place, as data.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A number of `unit` in `range`; `usual` is the part of it that was tried and gives good worlds.
    Number {
        unit: Unit,
        range: [f64; 2],
        usual: Option<[f64; 2]>,
    },
    Whole {
        range: [i64; 2],
    },
    Switch,
    /// `"#rrggbb"` (sRGB) or three linear numbers.
    Colour,
    /// The path of a file, from the folder of the world file.
    File,
    /// Any text; in a few words, what it must be.
    Text(&'static str),
    /// One of these words; each with its meaning.
    Choice(Vec<[&'static str; 2]>),
    /// As many as there are shapes.
    Array(Vec<Shape>),
    /// A number of elements in `len`.
    List {
        element: Box<Shape>,
        len: [usize; 2],
        /// What an editor writes for a new element, as TOML.
        start: String,
    },
    Table(Table),
    /// A table with one of these keys, or one of the words.
    OneOf(Vec<Alternative>),
    /// Or this word, with its meaning.
    OrWord(Box<Shape>, [&'static str; 2]),
    /// A table whose keys the user makes up.
    Named {
        names: Names,
        element: Box<Shape>,
        /// What an editor writes for a new element, as TOML.
        start: String,
    },
}

/// How names that users make up are formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Names {
    /// Letters, digits, `_` and `-`.
    Words,
    /// One character.
    Symbols,
}

/// A table with known keys.
#[derive(Clone, Debug)]
pub struct Table {
    pub about: &'static str,
    pub keys: Vec<Key>,
    pub presets: &'static [Preset],
}

/// One row: everything that is known of a key.
#[derive(Clone, Debug)]
pub struct Key {
    pub name: &'static str,
    pub about: &'static str,
    /// [`REQUIRED`], or what [`Kind::default`] says.
    pub default: String,
    /// As [`Kind::start`].
    pub start: String,
    pub shape: Shape,
}

/// In place of a default: the key must be written.
pub const REQUIRED: &str = "required";

/// One of the things that a place may hold: `name = { … }`, or the word `"name"` where there is no table.
#[derive(Clone, Debug)]
pub struct Alternative {
    pub name: &'static str,
    pub table: Option<Table>,
    pub about: &'static str,
}

/// Named values for several keys of a section, as TOML.
#[derive(Debug)]
pub struct Preset {
    pub name: &'static str,
    pub about: &'static str,
    pub keys: &'static str,
}

/// A unit that users write, and how many of the program's it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    pub symbol: &'static str,
    pub factor: f64,
}

/// A table that is read into a value: declared with `section!`.
pub trait Section: Sized {
    const ABOUT: &'static str;
    const PRESETS: &'static [Preset] = &[];

    fn keys() -> Vec<Key>;

    /// Names of the keys.
    fn names() -> Vec<&'static str> {
        Self::keys().iter().map(|key| key.name).collect()
    }

    /// Reads each key of the table at `place`, whose names are known to be good.
    fn read(place: &Place) -> Self;
}

/// Declares the keys of a table, one a row: `name = kind` with its meaning as a doc comment. Either for a type of the
/// program, whose fields the keys fill, or with `struct` for a new one (`name: type = kind`).
macro_rules! section {
    ($(#[doc = $about:literal])+ struct $name:ident { $($(#[doc = $doc:literal])+ $key:ident: $type:ty = $kind:expr,)+ }) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug)]
        pub struct $name { $($(#[doc = $doc])+ pub $key: $type,)+ }

        section! { $(#[doc = $about])+ for $name { $($(#[doc = $doc])+ $key = $kind,)+ } }
    };
    ($(#[doc = $about:literal])+ for $type:ty $(, presets $presets:ident)? { $($(#[doc = $doc:literal])+ $key:ident = $kind:expr,)+ }) => {
        impl $crate::world::schema::Section for $type {
            const ABOUT: &'static str = concat!($($about),+);
            $(const PRESETS: &'static [$crate::world::schema::Preset] = $presets;)?

            fn keys() -> Vec<$crate::world::schema::Key> {
                use $crate::world::schema::{Key, Kind as _};
                vec![$({
                    let kind = $kind;
                    let about = concat!($($doc),+);
                    let name = stringify!($key).trim_start_matches("r#");
                    Key { name, about, default: kind.default(), start: kind.start(), shape: kind.shape() }
                }),+]
            }

            // Without their shapes, which are as large as all tables inside this one.
            fn names() -> Vec<&'static str> {
                vec![$(stringify!($key).trim_start_matches("r#")),+]
            }

            fn read(place: &$crate::world::place::Place) -> Self {
                use $crate::world::schema::Kind as _;
                Self { $($key: $kind.read(&place.key(stringify!($key).trim_start_matches("r#")))),+ }
            }
        }
    };
}
pub(super) use section;

impl Shape {
    /// What may be written, in a few words.
    pub fn allowed(&self) -> String {
        match self {
            Shape::Number { unit, range: [least, most], usual } => {
                let unit = if unit.symbol.is_empty() { String::new() } else { format!(" {}", unit.symbol) };
                let usual =
                    usual.map(|[least, most]| format!(" (usual: {least} to {most})")).unwrap_or_default();
                format!("allowed: {least} to {most}{unit}{usual}")
            }
            Shape::Whole { range: [least, most] } if least == most => format!("allowed: {least}"),
            Shape::Whole { range: [least, most] } => format!("allowed: whole numbers from {least} to {most}"),
            Shape::Switch => "allowed: true, false".into(),
            Shape::Colour => "allowed: \"#rrggbb\" (sRGB) or [red, green, blue] (linear, 0 to 1)".into(),
            Shape::File => "a path, from the folder of the world file".into(),
            Shape::Choice(words) => {
                let words: Vec<String> = words.iter().map(|[word, _]| quoted(word)).collect();
                format!("allowed: {}", words.join(", "))
            }
            Shape::Array(elements) => match elements.first() {
                Some(element) => format!(
                    "{} elements, each {}",
                    elements.len(),
                    element.allowed().replace("allowed: ", "")
                ),
                None => "an empty array".into(),
            },
            Shape::List { len: [least, most], .. } => {
                format!("allowed: an array of {least} to {most} elements")
            }
            Shape::Table(_) => "a table: `{ key = value, … }`".into(),
            Shape::OneOf(alternatives) => {
                let names: Vec<String> = alternatives.iter().map(Alternative::written).collect();
                format!("allowed: {}", names.join(", "))
            }
            Shape::Text(what) => (*what).into(),
            Shape::OrWord(shape, [word, _]) => format!("{}, or \"{word}\"", shape.allowed()),
            Shape::Named { names, .. } => format!("a table: `{{ NAME = … }}`, each NAME {}", names.rule()),
        }
    }
}

impl Shape {
    /// Unit and usual range of a number, or of the numbers of an array.
    pub fn number(&self) -> Option<(Unit, Option<[f64; 2]>)> {
        match self {
            Shape::Number { unit, usual, .. } => Some((*unit, *usual)),
            Shape::Array(elements) => elements.first()?.number(),
            _ => None,
        }
    }
}

impl Names {
    /// What a name must be.
    pub fn rule(self) -> &'static str {
        match self {
            Names::Words => "of letters, digits, `_` and `-`",
            Names::Symbols => "one character",
        }
    }

    pub fn allow(self, name: &str) -> bool {
        match self {
            Names::Words => {
                !name.is_empty()
                    && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte))
            }
            Names::Symbols => name.chars().count() == 1,
        }
    }

    /// The same as a regular expression.
    pub fn pattern(self) -> &'static str {
        match self {
            Names::Words => "^[A-Za-z0-9_-]+$",
            Names::Symbols => "^.$",
        }
    }
}

impl Key {
    pub fn required(&self) -> bool {
        self.default == REQUIRED
    }

    /// The default as TOML; `None` where it is told in words.
    pub fn default_value(&self) -> Option<Value> {
        self.default.parse().ok()
    }
}

impl Alternative {
    /// As it is written in a file.
    pub fn written(&self) -> String {
        if self.table.is_some() { format!("{{ {} = {{…}} }}", self.name) } else { quoted(self.name) }
    }
}

impl Table {
    /// The tables inside this one that have a key of this name.
    pub fn homes(&self, name: &str) -> Vec<String> {
        self.keys.iter().flat_map(|key| key.shape.homes(name, key.name)).collect()
    }

    fn homes_at(&self, name: &str, path: &str) -> Vec<String> {
        let here = self.keys.iter().any(|key| key.name == name).then(|| format!("`{path}`"));
        let inside = self.keys.iter().flat_map(|key| key.shape.homes(name, &format!("{path}.{}", key.name)));
        here.into_iter().chain(inside).collect()
    }

    /// The default of the array at `path`, which `--set` needs before it can change an element of it.
    pub fn default_array(&self, path: &[String]) -> Option<Item> {
        let (first, rest) = path.split_first()?;
        let key = self.keys.iter().find(|key| key.name == first)?;
        key.shape.default_array(&key.default, rest)
    }
}

impl Shape {
    /// The tables at and inside this shape, which stands at `path`, that have a key of this name.
    fn homes(&self, name: &str, path: &str) -> Vec<String> {
        match self {
            Shape::Table(table) => table.homes_at(name, path),
            Shape::OrWord(shape, _) => shape.homes(name, path),
            Shape::Named { element, .. } => element.homes(name, &format!("{path}.NAME")),
            Shape::List { element, .. } => element.homes(name, &format!("{path}.N")),
            Shape::OneOf(alternatives) => {
                let tables =
                    alternatives.iter().filter_map(|other| Some((other.name, other.table.as_ref()?)));
                tables.flat_map(|(tag, table)| table.homes_at(name, &format!("{path}.{tag}"))).collect()
            }
            _ => Vec::new(),
        }
    }

    fn default_array(&self, default: &str, path: &[String]) -> Option<Item> {
        match self {
            Shape::List { .. } | Shape::Array(_) if path.is_empty() => parse_item(default),
            Shape::Table(table) => table.default_array(path),
            Shape::OrWord(shape, _) => shape.default_array(default, path),
            Shape::OneOf(alternatives) => {
                let (first, rest) = path.split_first()?;
                alternatives.iter().find(|other| other.name == first)?.table.as_ref()?.default_array(rest)
            }
            _ => None,
        }
    }
}

/// A number as people write it: powers of ten where zeros would have to be counted.
pub fn digits(number: f64) -> String {
    let plain = number == 0.0 || (1e-3..1e6).contains(&number.abs());
    if plain { number.to_string() } else { format!("{number:e}") }
}

pub fn parse_item(text: &str) -> Option<Item> {
    text.parse::<Value>().ok().map(Item::Value)
}

/// The lines of a doc comment as one paragraph.
pub fn paragraph(about: &str) -> String {
    about.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub fn quoted(word: &str) -> String {
    format!("\"{word}\"")
}
