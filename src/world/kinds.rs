//! The kinds of values that keys have: how each is read, with its default, unit and range, and what is said when it
//! can't be.

use super::fault::{self, Complaint};
use super::place::{Place, array_len, noun, shown};
use super::schema::{
    Alternative, Kind, Names, REQUIRED, Section, Shape, Table, Unit, digits, parse_item, quoted,
};
use crate::core::color::linear_from_srgb;
use crate::zoom::address::Location;
use std::ops::RangeInclusive;
use toml_edit::{DocumentMut, Item};

// Numbers ------------------------------------------------------------------------------------------------------------

pub struct Number {
    default: f64,
    unit: Unit,
    range: [f64; 2],
    usual: Option<[f64; 2]>,
}

/// A finite number of `unit`.
pub fn number(default: f64, unit: Unit, range: RangeInclusive<f64>) -> Number {
    Number { default, unit, range: [*range.start(), *range.end()], usual: None }
}

impl Number {
    /// The part of the range that was tried and gives good worlds.
    pub fn usual(self, range: RangeInclusive<f64>) -> Self {
        Self { usual: Some([*range.start(), *range.end()]), ..self }
    }
}

impl Kind for Number {
    type Value = f32;

    fn shape(&self) -> Shape {
        Shape::Number { unit: self.unit, range: self.range, usual: self.usual }
    }

    fn default(&self) -> String {
        digits(self.default)
    }

    fn read(&self, place: &Place) -> f32 {
        self.read_exact(place) as f32
    }
}

impl Number {
    fn read_exact(&self, place: &Place) -> f64 {
        let allowed = self.shape().allowed();
        let written = place.read(self.default, |item| {
            let number = item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64));
            let Some(number) = number else {
                return Err(Complaint::new(format!("must be a number, not {}", noun(item)), allowed));
            };
            if !number.is_finite() {
                return Err(Complaint::new("must be finite", allowed));
            }
            if number < self.range[0] || number > self.range[1] {
                return Err(Complaint::new("is out of range", allowed));
            }
            Ok(number)
        });
        written * self.unit.factor
    }
}

pub struct Exact(Number);

/// A number with all its digits.
pub fn exact(number: Number) -> Exact {
    Exact(number)
}

impl Kind for Exact {
    type Value = f64;

    fn shape(&self) -> Shape {
        self.0.shape()
    }

    fn default(&self) -> String {
        self.0.default()
    }

    fn read(&self, place: &Place) -> f64 {
        self.0.read_exact(place)
    }
}

pub struct Whole {
    default: i64,
    range: [i64; 2],
}

/// A whole number.
pub fn whole(default: u32, range: RangeInclusive<u32>) -> Whole {
    Whole { default: default.into(), range: [(*range.start()).into(), (*range.end()).into()] }
}

impl Kind for Whole {
    type Value = u32;

    fn shape(&self) -> Shape {
        Shape::Whole { range: self.range }
    }

    fn default(&self) -> String {
        self.default.to_string()
    }

    fn read(&self, place: &Place) -> u32 {
        let allowed = self.shape().allowed();
        let written = place.read(self.default, |item| match item.as_integer() {
            None => Err(Complaint::new(format!("must be a whole number, not {}", noun(item)), allowed)),
            Some(whole) if whole < self.range[0] || whole > self.range[1] => {
                Err(Complaint::new("is out of range", allowed))
            }
            Some(whole) => Ok(whole),
        });
        u32::try_from(written).unwrap_or_default()
    }
}

// Words --------------------------------------------------------------------------------------------------------------

pub struct Choice<T>(Vec<(&'static str, &'static str, T)>);

/// One of some words, each with its meaning and what it becomes; the first is the default.
pub fn choice<T: Copy, const N: usize>(words: [(&'static str, &'static str, T); N]) -> Choice<T> {
    Choice(words.into())
}

impl<T: Copy> Kind for Choice<T> {
    type Value = T;

    fn shape(&self) -> Shape {
        Shape::Choice(self.0.iter().map(|(word, about, _)| [*word, *about]).collect())
    }

    fn default(&self) -> String {
        self.0.first().map(|(word, ..)| quoted(word)).unwrap_or_default()
    }

    fn read(&self, place: &Place) -> T {
        let allowed = self.shape().allowed();
        place.read(self.0[0].2, |item| {
            let Some(word) = item.as_str() else {
                return Err(Complaint::new(format!("must be a word in quotes, not {}", noun(item)), allowed));
            };
            let known = self.0.iter().find(|(name, ..)| *name == word);
            known.map(|(.., value)| *value).ok_or_else(|| {
                let names = self.0.iter().map(|(name, ..)| *name);
                guess(format!("can't be \"{}\"", shown(word)), word, names, allowed)
            })
        })
    }
}

pub struct Switch(bool);

/// `true` or `false`.
pub fn switch(default: bool) -> Switch {
    Switch(default)
}

impl Kind for Switch {
    type Value = bool;

    fn shape(&self) -> Shape {
        Shape::Switch
    }

    fn default(&self) -> String {
        self.0.to_string()
    }

    fn read(&self, place: &Place) -> bool {
        place.read(self.0, |item| {
            let problem = || format!("must be true or false, not {}", noun(item));
            item.as_bool().ok_or_else(|| Complaint::new(problem(), Shape::Switch.allowed()))
        })
    }
}

pub struct File;

/// The path of a file; nothing by default.
pub fn file() -> File {
    File
}

impl Kind for File {
    type Value = Option<String>;

    fn shape(&self) -> Shape {
        Shape::OrWord(Box::new(Shape::File), NONE_WORD)
    }

    fn default(&self) -> String {
        quoted("none")
    }

    fn start(&self) -> String {
        quoted("")
    }

    fn read(&self, place: &Place) -> Option<String> {
        read_path(place).filter(|path| path != "none")
    }
}

pub struct RequiredFile;

/// The path of a file that must be named; `None` is a fault that was noted.
pub fn required_file() -> RequiredFile {
    RequiredFile
}

impl Kind for RequiredFile {
    type Value = Option<String>;

    fn shape(&self) -> Shape {
        Shape::File
    }

    fn default(&self) -> String {
        REQUIRED.into()
    }

    fn start(&self) -> String {
        quoted("")
    }

    fn read(&self, place: &Place) -> Option<String> {
        if place.item().is_none() {
            place.refuse(Complaint::new("is missing", Shape::File.allowed()).about_key());
        }
        read_path(place)
    }
}

fn read_path(place: &Place) -> Option<String> {
    place.read(None, |item| match item.as_str() {
        None => Err(Complaint::new(
            format!("must be a path in quotes, not {}", noun(item)),
            Shape::File.allowed(),
        )),
        Some("") => Err(Complaint::new("is empty", Shape::File.allowed())),
        Some(path) => Ok(Some(path.to_string())),
    })
}

pub struct Text {
    what: &'static str,
    default: &'static str,
}

/// Any text; `what` says in a few words what it must be, `default` what stands for nothing written.
pub fn text(what: &'static str, default: &'static str) -> Text {
    Text { what, default }
}

impl Kind for Text {
    type Value = String;

    fn shape(&self) -> Shape {
        Shape::Text(self.what)
    }

    fn default(&self) -> String {
        if self.default == REQUIRED { REQUIRED.into() } else { quoted(self.default) }
    }

    fn start(&self) -> String {
        if self.default == REQUIRED { quoted("") } else { self.default() }
    }

    fn read(&self, place: &Place) -> String {
        let required = self.default == REQUIRED;
        if required && place.item().is_none() {
            place.refuse(Complaint::new("is missing", self.what).about_key());
        }
        let default = if required { "" } else { self.default };
        place.read(default.to_string(), |item| match item.as_str() {
            None => Err(Complaint::new(format!("must be a text in quotes, not {}", noun(item)), self.what)),
            Some(text) => Ok(text.to_string()),
        })
    }
}

pub struct LocationCode;

/// Where somebody is in a zoom, as a code; nowhere by default.
pub fn location_code() -> LocationCode {
    LocationCode
}

impl Kind for LocationCode {
    type Value = Option<Location>;

    fn shape(&self) -> Shape {
        Shape::OrWord(Box::new(Shape::Text("a location code")), ["none", "Where `depth` says."])
    }

    fn default(&self) -> String {
        quoted("none")
    }

    fn start(&self) -> String {
        quoted("")
    }

    fn read(&self, place: &Place) -> Option<Location> {
        let allowed = self.shape().allowed();
        place.read(None, |item| match item.as_str() {
            None => {
                Err(Complaint::new(format!("must be a location code in quotes, not {}", noun(item)), allowed))
            }
            Some("none") => Ok(None),
            Some(code) => match Location::parse(code) {
                Ok(location) => Ok(Some(location)),
                Err(error) => Err(Complaint::new("is no place", error.to_string())),
            },
        })
    }
}

// Colours and arrays -------------------------------------------------------------------------------------------------

pub struct Colour(&'static str);

/// A colour, with a default of `"#rrggbb"`; becomes linear Rec.709.
pub fn colour(default: &'static str) -> Colour {
    Colour(default)
}

impl Kind for Colour {
    type Value = [f32; 3];

    fn shape(&self) -> Shape {
        Shape::Colour
    }

    fn default(&self) -> String {
        quoted(self.0)
    }

    fn read(&self, place: &Place) -> [f32; 3] {
        let default = parse_hex(self.0).unwrap_or_default();
        if place.item().is_some_and(|item| array_len(item).is_some()) {
            return linear(default).read(place);
        }
        place.read(default, |item| {
            let Some(text) = item.as_str() else {
                return Err(Complaint::new(
                    format!("must be a colour, not {}", noun(item)),
                    Shape::Colour.allowed(),
                ));
            };
            parse_hex(text).ok_or_else(|| {
                Complaint::new(format!("can't be \"{}\"", shown(text)), Shape::Colour.allowed())
            })
        })
    }
}

/// The three numbers of a linear colour.
fn linear(default: [f32; 3]) -> Array<Number, 3> {
    numbers(default.map(f64::from), Unit { symbol: "", factor: 1.0 }, 0.0..=1.0)
}

/// `#rrggbb` as linear light.
fn parse_hex(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#')?;
    if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return None;
    }
    let value = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| linear_from_srgb((value >> shift & 0xff) as f32 / 255.0)))
}

pub struct Array<K, const N: usize>([K; N]);

/// As many numbers as there are defaults.
pub fn numbers<const N: usize>(
    defaults: [f64; N],
    unit: Unit,
    range: RangeInclusive<f64>,
) -> Array<Number, N> {
    Array(defaults.map(|default| number(default, unit, range.clone())))
}

/// As many numbers as there are defaults, with all their digits.
pub fn exacts<const N: usize>(defaults: [f64; N], unit: Unit, range: RangeInclusive<f64>) -> Array<Exact, N> {
    Array(defaults.map(|default| exact(number(default, unit, range.clone()))))
}

/// As many whole numbers as there are defaults.
pub fn wholes<const N: usize>(defaults: [u32; N], range: RangeInclusive<u32>) -> Array<Whole, N> {
    Array(defaults.map(|default| whole(default, range.clone())))
}

impl<K: Kind, const N: usize> Kind for Array<K, N> {
    type Value = [K::Value; N];

    fn shape(&self) -> Shape {
        Shape::Array(self.0.iter().map(K::shape).collect())
    }

    fn default(&self) -> String {
        format!("[{}]", self.0.iter().map(K::default).collect::<Vec<_>>().join(", "))
    }

    fn start(&self) -> String {
        format!("[{}]", self.0.iter().map(K::start).collect::<Vec<_>>().join(", "))
    }

    fn read(&self, place: &Place) -> Self::Value {
        place.read((), |item| match array_len(item) {
            Some(len) if len == N => Ok(()),
            Some(len) => {
                Err(Complaint::new(format!("must have {N} elements, not {len}"), self.shape().allowed()))
            }
            None => {
                Err(Complaint::new(format!("must be an array, not {}", noun(item)), self.shape().allowed()))
            }
        });
        std::array::from_fn(|index| self.0[index].read(&place.element(index)))
    }
}

pub struct List<K> {
    element: K,
    default: &'static str,
    len: [usize; 2],
}

/// A number of elements in `len`; `default` is the whole array as TOML.
pub fn list<K: Kind>(element: K, len: RangeInclusive<usize>, default: &'static str) -> List<K> {
    List { element, default, len: [*len.start(), *len.end()] }
}

impl<K: Kind> Kind for List<K> {
    type Value = Vec<K::Value>;

    fn shape(&self) -> Shape {
        Shape::List { element: Box::new(self.element.shape()), len: self.len, start: self.element.start() }
    }

    fn default(&self) -> String {
        self.default.to_string()
    }

    fn start(&self) -> String {
        let [least, _] = self.len;
        if self.default != "[]" || least == 0 {
            return self.default();
        }
        format!("[{}]", vec![self.element.start(); least].join(", "))
    }

    fn read(&self, place: &Place) -> Self::Value {
        let Some(item) = place.item() else {
            return match parse_item(self.default) {
                Some(default) => self.read(&place.with(&default)),
                None => Vec::new(),
            };
        };
        let [least, most] = self.len;
        let Some(len) = array_len(item) else {
            place.refuse(Complaint::new(
                format!("must be an array, not {}", noun(item)),
                self.shape().allowed(),
            ));
            return Vec::new();
        };
        if len < least {
            place.refuse(Complaint::new("is empty", self.shape().allowed()));
        } else if len > most {
            place.refuse(Complaint::new(format!("has {len} elements"), self.shape().allowed()));
        }
        (0..len.min(most)).map(|index| self.element.read(&place.element(index))).collect()
    }
}

// Tables -------------------------------------------------------------------------------------------------------------

pub struct TableOf<T>(std::marker::PhantomData<T>);

/// A section; its keys' defaults where it is not written.
pub fn table<T: Section>() -> TableOf<T> {
    TableOf(std::marker::PhantomData)
}

impl<T: Section> Kind for TableOf<T> {
    type Value = T;

    fn shape(&self) -> Shape {
        Shape::Table(Table { about: T::ABOUT, keys: T::keys(), presets: T::PRESETS })
    }

    fn default(&self) -> String {
        "{}".into()
    }

    fn read(&self, place: &Place) -> T {
        read_section(place)
    }
}

/// Reads the section at `place`, whose keys must all be known.
pub fn read_section<T: Section>(place: &Place) -> T {
    let presets = T::PRESETS;
    if let Some(table) = place.table() {
        let mut names = T::names();
        if !presets.is_empty() {
            names.insert(0, "preset");
        }
        let unknown = table.iter().map(|(name, _)| name).filter(|name| !names.contains(name));
        for name in unknown.take(fault::MOST) {
            place.key(name).refuse(unknown_key(name, &names, &(place.shape)()));
        }
    }
    if presets.is_empty() {
        return T::read(place);
    }
    let words = presets.iter().map(|preset| (preset.name, preset.about, preset.keys));
    let keys = Choice(words.collect()).read(&place.key("preset"));
    match keys.parse::<DocumentMut>() {
        Ok(preset) => T::read(&place.with_preset(preset.as_item())),
        Err(_) => T::read(place),
    }
}

/// A complaint about a key that is none of the `known`, in a file of the shape `file`.
fn unknown_key(name: &str, known: &[&str], file: &Table) -> Complaint {
    let here = format!("known here: {}", known.join(", "));
    let homes = file.homes(name);
    let complaint = match homes.as_slice() {
        [] => guess("is unknown", name, known.iter().copied(), here),
        homes => Complaint::new("is unknown", format!("it is a key of {}", homes.join(", "))).help(here),
    };
    complaint.about_key()
}

pub struct Named<K> {
    names: Names,
    element: K,
    default: &'static str,
}

/// A table whose keys the user makes up, in the order of the file; `default` is the whole table as TOML.
pub fn named<K: Kind>(names: Names, element: K, default: &'static str) -> Named<K> {
    Named { names, element, default }
}

impl<K: Kind> Kind for Named<K> {
    type Value = Vec<(String, K::Value)>;

    fn shape(&self) -> Shape {
        Shape::Named {
            names: self.names,
            element: Box::new(self.element.shape()),
            start: self.element.start(),
        }
    }

    fn default(&self) -> String {
        self.default.to_string()
    }

    fn read(&self, place: &Place) -> Self::Value {
        if place.item().is_none() {
            return match parse_item(self.default) {
                Some(default) => self.read(&place.with(&default)),
                None => Vec::new(),
            };
        }
        let Some(table) = place.table() else { return Vec::new() };
        let names = table.iter().map(|(name, _)| name);
        let read = names.map(|name| {
            let place = place.key(name);
            if !self.names.allow(name) {
                let label = format!("a name must be {}", self.names.rule());
                place.refuse(Complaint::new("is no name", label).about_key());
            }
            (name.to_string(), self.element.read(&place))
        });
        read.collect()
    }
}

pub struct OrWord<K> {
    kind: K,
    word: [&'static str; 2],
    /// As TOML.
    default: String,
}

const NONE_WORD: [&str; 2] = ["none", "Nothing."];

/// A value, or the word "none".
pub fn or_none<K: Kind>(kind: K) -> OrWord<K> {
    OrWord { default: kind.default(), kind, word: NONE_WORD }
}

/// A word with its meaning, or a value. The word is the default.
pub fn word_or<K: Kind>(word: &'static str, about: &'static str, kind: K) -> OrWord<K> {
    OrWord { kind, word: [word, about], default: quoted(word) }
}

impl<K: Kind> Kind for OrWord<K> {
    /// `None` for the word.
    type Value = Option<K::Value>;

    fn shape(&self) -> Shape {
        Shape::OrWord(Box::new(self.kind.shape()), self.word)
    }

    fn default(&self) -> String {
        self.default.clone()
    }

    fn start(&self) -> String {
        self.kind.start()
    }

    fn read(&self, place: &Place) -> Self::Value {
        let [own, _] = self.word;
        let Some(word) = place.word() else {
            let absent = place.item().is_none() && self.default == quoted(own);
            return (!absent).then(|| self.kind.read(place));
        };
        if word != own {
            place.refuse(Complaint::new(format!("can't be \"{}\"", shown(word)), self.shape().allowed()));
        }
        None
    }
}

pub struct Optional<K> {
    kind: K,
    absent: &'static str,
    start: Option<&'static str>,
}

/// A value whose default depends on other keys, as `absent` says.
pub fn optional<K: Kind>(kind: K, absent: &'static str) -> Optional<K> {
    Optional { kind, absent, start: None }
}

impl<K> Optional<K> {
    /// What an editor writes first, as TOML.
    pub fn starting(self, start: &'static str) -> Self {
        Self { start: Some(start), ..self }
    }
}

impl<K: Kind> Kind for Optional<K> {
    type Value = Option<K::Value>;

    fn shape(&self) -> Shape {
        self.kind.shape()
    }

    fn default(&self) -> String {
        self.absent.to_string()
    }

    fn start(&self) -> String {
        self.start.map_or_else(|| self.kind.start(), String::from)
    }

    fn read(&self, place: &Place) -> Self::Value {
        place.item().map(|_| self.kind.read(place))
    }
}

pub struct OneOf<T> {
    tags: Vec<Tag<T>>,
}

/// One of several things: a table with one key that says which, or a word. The first is the default.
pub fn one_of<T, const N: usize>(tags: [Tag<T>; N]) -> OneOf<T> {
    OneOf { tags: tags.into() }
}

/// One of the things that [`one_of`] takes.
pub struct Tag<T> {
    name: &'static str,
    about: &'static str,
    /// `None` for a word.
    table: Option<fn() -> Table>,
    read: Box<dyn Fn(&Place) -> T>,
}

/// `name = { … }` with the keys of the section `S`.
pub fn tag<S: Section + 'static, T: 'static>(name: &'static str, make: fn(S) -> T) -> Tag<T> {
    let table = || Table { about: S::ABOUT, keys: S::keys(), presets: S::PRESETS };
    Tag { name, about: S::ABOUT, table: Some(table), read: Box::new(move |place| make(read_section(place))) }
}

/// The word `"name"`.
pub fn word<T: Clone + 'static>(name: &'static str, about: &'static str, value: T) -> Tag<T> {
    Tag { name, about, table: None, read: Box::new(move |_| value.clone()) }
}

impl<T> Kind for OneOf<T> {
    type Value = T;

    fn shape(&self) -> Shape {
        let alternative = |Tag { name, about, table, .. }: &Tag<T>| Alternative {
            name,
            about,
            table: table.map(|table| table()),
        };
        Shape::OneOf(self.tags.iter().map(alternative).collect())
    }

    fn default(&self) -> String {
        let Tag { name, table, .. } = &self.tags[0];
        if table.is_some() { format!("{{ {name} = {{}} }}") } else { quoted(name) }
    }

    fn read(&self, place: &Place) -> T {
        let written = place.item().and_then(|item| match item.as_str() {
            Some(word) => self.tag_of_word(place, word),
            None => self.tag_of_table(place, item),
        });
        let tag = written.unwrap_or(&self.tags[0]);
        (tag.read)(&place.key(tag.name))
    }
}

impl<T> OneOf<T> {
    fn tag_of_word(&self, place: &Place, word: &str) -> Option<&Tag<T>> {
        match self.tag(word) {
            Some(tag) if tag.table.is_none() => return Some(tag),
            Some(_) => {
                let label = format!("write `{{ {word} = {{}} }}`");
                place.refuse(Complaint::new(format!("takes `{word}` as a table"), label));
            }
            None => place.refuse(self.complaint(word, format!("can't be \"{}\"", shown(word)))),
        }
        None
    }

    fn tag_of_table(&self, place: &Place, item: &Item) -> Option<&Tag<T>> {
        let Some(table) = item.as_table_like() else {
            place.refuse(Complaint::new(format!("can't be {}", noun(item)), self.shape().allowed()));
            return None;
        };
        let mut names = table.iter().map(|(name, _)| name);
        let Some(name) = names.next() else {
            place.refuse(Complaint::new("is empty", self.shape().allowed()));
            return None;
        };
        for other in names {
            let problem = format!("can't stand beside `{}`", shown(name));
            place.key(other).refuse(Complaint::new(problem, "one of the two only").about_key());
        }
        match self.tag(name) {
            Some(tag) if tag.table.is_some() => return Some(tag),
            Some(_) => {
                let label = format!("write \"{name}\" in place of the table");
                place.key(name).refuse(Complaint::new("is a word, not a table", label).about_key());
            }
            None => place.key(name).refuse(self.complaint(name, "is unknown").about_key()),
        }
        None
    }

    fn tag(&self, name: &str) -> Option<&Tag<T>> {
        self.tags.iter().find(|tag| tag.name == name)
    }

    fn complaint(&self, name: &str, problem: impl Into<String>) -> Complaint {
        guess(problem, name, self.tags.iter().map(|tag| tag.name), self.shape().allowed())
    }
}

/// A complaint about a word that is none of the `known`: with a guess at what was meant, if one is near.
pub fn guess<'a>(
    problem: impl Into<String>,
    word: &str,
    known: impl Iterator<Item = &'a str>,
    allowed: String,
) -> Complaint {
    // Nobody mistypes a hundred letters, and the distance takes quadratic time.
    let near = if word.len() > 100 { 0 } else { (word.chars().count() / 3).max(1) };
    let distances = known.filter(|_| near > 0).map(|name| (strsim::damerau_levenshtein(word, name), name));
    match distances.filter(|(distance, _)| *distance <= near).min() {
        Some((_, name)) => Complaint::new(problem, format!("did you mean `{name}`?")).help(allowed),
        None => Complaint::new(problem, allowed),
    }
}
