//! Species files: how a kind of plant grows and what it is made of. A world names such a file, or has the same keys in
//! its table `species`.

use super::fault::{self, Cause, Complaint, Fault, Sources, Text};
use super::keys::{DEGREES, Format, M, NONE, PER_M};
use super::kinds::*;
use super::place::{KeyPath, Place, shown};
use super::schema::{self, Key, Kind, Names, REQUIRED, Section, Table, section};
use super::{Error, MAX_BYTES};
use crate::formats;
use crate::plants::derive::{self, Steps};
use crate::plants::grammar::{self, Grammar, WarningKind};
use crate::plants::species::{self as plant, Form, Shape};
use crate::plants::turtle::{self, Interpretation, Side};
use crate::scene;
use std::cell::RefCell;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use toml_edit::Item;

// Keys ---------------------------------------------------------------------------------------------------------------

section! {
    /// A kind of plant: the rules of its growth, what its symbols draw, and what it is made of.
    struct Species {
        /// What it is, and where its rules come from.
        about: String = text("a text", ""),
        /// The L-system: an axiom and productions, one a line. `docs/plants.md` tells the language.
        grammar: String = text(GRAMMAR, REQUIRED),
        /// How often the axiom is rewritten.
        steps: Option<u32> = word_or("auto", "Until nothing changes.", whole(5, 0..=100_000)),
        /// Turn of `+ - & ^ \ /` without a parameter.
        angle: f64 = angle(),
        /// Turn of `& ^` without a parameter.
        pitch: Option<f64> = optional(angle(), "that of `angle`"),
        /// Turn of `\ /` without a parameter.
        roll: Option<f64> = optional(angle(), "that of `angle`"),
        /// Symbols that move the turtle and draw a segment.
        draw: String = text("symbols", "F"),
        /// Symbols that move it and draw nothing.
        r#move: String = text("symbols", "f"),
        /// Symbols that move it and leave no vertex in a polygon.
        silent: String = text("symbols", "G"),
        /// Symbols that are no context of others.
        ignore: String = text("symbols", ""),
        /// The way that `+` turns.
        plus: Side = choice([
            ("left", "as in \"The Algorithmic Beauty of Plants\"", Side::Left),
            ("right", "the other way", Side::Right),
        ]),
        /// Diameter of segments before the first `!`.
        width: f64 = exact(number(0.1, M, 0.0..=1000.0)),
        /// What `!` without a parameter multiplies the diameter by: 0.7071 halves the cross-section.
        taper: f64 = exact(number(0.7071, NONE, 0.0..=1.0)),
        /// What segments turn towards as they grow: light above, weight below.
        tropism: Option<Tropism> = word_or("none", "They grow as the rules say.", table::<Tropism>()),
        /// How many different plants there are of it: each has its own random numbers.
        variants: u32 = whole(1, 1..=64),
        /// Vertical extent that every plant is scaled to.
        height: Option<f32> = height(),
        /// What its parts are made of.
        materials: Vec<(String, Material)> = named(Names::Words, table::<Material>(), DEFAULT_MATERIALS),
        /// The material of segments.
        wood: Option<String> = optional(text("a name of `materials`", ""), "the first of `materials`"),
        /// Materials of polygons: the first one, and the next after every `'`.
        leaves: Option<Vec<String>> = optional(
            list(text("a name of `materials`", ""), 1..=64, "[]"),
            "those of `materials` behind the first",
        ),
        /// Sub-models, by the symbol that places them: `~L(s)` places the organ `L`, scaled by `s`.
        organs: Vec<(String, Organ)> = named(Names::Symbols, table::<Organ>(), "{}"),
    }
}

const GRAMMAR: &str = "an L-system in quotes, best between three of them";

fn angle() -> Exact {
    exact(number(90.0, DEGREES, -360.0..=360.0))
}

fn height() -> Optional<Number> {
    optional(number(10.0, M, 1e-3..=1000.0), "as it grows")
}

const DEFAULT_MATERIALS: &str = r#"{
    bark = { reflectance = [0.13, 0.1, 0.075] },
    leaf = { reflectance = [0.05, 0.1, 0.025], transmittance = [0.05, 0.11, 0.013] },
}"#;

section! {
    /// Segments turn as they grow: each by `strength · |H × direction|` radians, H its heading (Prusinkiewicz &
    /// Lindenmayer 1990, section 2.1).
    struct Tropism {
        /// What they turn towards: metres east, up and south. Its length counts.
        direction: [f64; 3] = exacts([0.0, -1.0, 0.0], NONE, -1000.0..=1000.0),
        /// Their willingness, e.
        strength: f64 = exact(number(0.1, NONE, -100.0..=100.0)),
    }
}

section! {
    /// A material: its colour in the world is `mix(reflectance, second_reflectance, clamp(noise(p · position_factor) ·
    /// value_factor, 0, 1))`, with Perlin's noise of 2002 from 0 to 1 at the place p.
    struct Material {
        /// Light that it scatters back.
        reflectance: [f32; 3] = colour("#7a6a58"),
        /// The other colour, which noise mixes in.
        second_reflectance: Option<[f32; 3]> = optional(colour("#7a6a58"), "the same as `reflectance`"),
        /// How fine the mixture is.
        position_factor: f32 = number(1.0, PER_M, 0.0..=10_000.0),
        /// How strong it is.
        value_factor: f32 = number(1.0, NONE, 0.0..=100.0),
        /// Light that it lets through, which leaves do.
        transmittance: [f32; 3] = colour("#000000"),
        /// Of its thin gloss; 1 is without one.
        refractive_index: f32 = number(1.0, NONE, 1.0..=3.0).usual(1.0..=1.5),
        /// Of the gloss: 0 is a mirror, 1 has no highlight to speak of.
        roughness: f32 = number(1.0, NONE, 0.0..=1.0),
    }
}

section! {
    /// A sub-model, placed at the turtle's heading, left and up: polygons, or an L-system of its own, which may place
    /// other organs.
    struct Organ {
        /// Its polygons.
        polygons: Vec<Outline> = list(table::<Outline>(), 0..=10_000, "[]"),
        /// Its L-system. `draw`, `move`, `silent`, `ignore` and `plus` are the plant's.
        grammar: String = text(GRAMMAR, ""),
        /// How often its axiom is rewritten.
        steps: Option<u32> = word_or("auto", "Until nothing changes.", whole(5, 0..=100_000)),
        /// Turn of `+ - & ^ \ /` without a parameter.
        angle: Option<f64> = optional(angle(), "the plant's"),
        /// Diameter of segments before the first `!`.
        width: f64 = exact(number(0.01, M, 0.0..=1000.0)),
        /// The material of segments.
        wood: Option<String> = optional(text("a name of `materials`", ""), "the plant's"),
        /// Materials of polygons.
        leaves: Option<Vec<String>> =
            optional(list(text("a name of `materials`", ""), 1..=64, "[]"), "the plant's"),
    }
}

section! {
    /// A polygon, concave if need be.
    struct Outline {
        /// What it is made of.
        material: Option<String> = optional(text("a name of `materials`", ""), "the first of `leaves`"),
        /// Its corners, in order: metres along the turtle's heading, to its left and upwards.
        vertices: Vec<[f64; 3]> = list(exacts([0.0; 3], M, -1000.0..=1000.0), 3..=10_000, "[]"),
    }
}

/// A species file: its format and the keys of a species.
struct SpeciesFile(Species);

impl Section for SpeciesFile {
    const ABOUT: &'static str = Species::ABOUT;

    fn keys() -> Vec<Key> {
        let about = "Version of the format, 1.";
        let format = Key { name: "format", about, default: Format.default(), shape: Format.shape() };
        std::iter::once(format).chain(Species::keys()).collect()
    }

    fn read(place: &Place) -> Self {
        Format.read(&place.key("format"));
        SpeciesFile(Species::read(place))
    }
}

/// Everything that may stand in a species file, as data.
pub fn shape() -> Table {
    Table { about: SpeciesFile::ABOUT, keys: SpeciesFile::keys(), presets: &[] }
}

/// A species of a world.
#[derive(Clone, Debug)]
pub enum Entry {
    File(Named),
    Here(Box<Species>),
}

section! {
    /// A kind of plant: a species file, or its keys written here.
    struct Named {
        /// A species file. Beside it only `variants` and `height` may stand, which win over the file's.
        file: Option<String> = required_file(),
        /// How many different plants there are of it: each has its own random numbers.
        variants: Option<u32> = optional(whole(1, 1..=64), "the file's"),
        /// Vertical extent that every plant is scaled to.
        height: Option<f32> = height(),
    }
}

/// The kind of a world's species.
pub struct EntryKind;

impl Kind for EntryKind {
    type Value = Entry;

    fn shape(&self) -> schema::Shape {
        let file = Named::keys().into_iter().take(1).map(|key| Key { default: "none".into(), ..key });
        let own = Species::keys().into_iter().map(|key| match key.name {
            "grammar" => Key { default: "required without `file`".into(), ..key },
            _ => key,
        });
        schema::Shape::Table(Table { about: Named::ABOUT, keys: file.chain(own).collect(), presets: &[] })
    }

    fn default(&self) -> String {
        "{}".into()
    }

    fn read(&self, place: &Place) -> Entry {
        if place.key("file").item().is_none() {
            return Entry::Here(Box::new(read_section(place)));
        }
        let names = Species::keys().into_iter().map(|key| key.name);
        for name in names.filter(|name| !["variants", "height"].contains(name)) {
            if place.key(name).item().is_some() {
                let label = "write it in that file, or all of the species here";
                place.key(name).refuse(Complaint::new("can't stand beside `file`", label).about_key());
            }
        }
        Entry::File(Named::read(place))
    }
}

// Reading ------------------------------------------------------------------------------------------------------------

/// A species and what is remarkable about it.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub species: plant::Species,
    pub source: Source,
    /// What is allowed and hardly meant, one sentence each.
    pub warnings: Vec<String>,
}

/// Where a species is written: some of what is wrong with it shows only when it grows.
#[derive(Clone, Debug)]
pub struct Source {
    text: Arc<Text>,
    place: KeyPath,
}

impl Source {
    /// What is wrong with the species, with its place in the file.
    pub fn blame(&self, error: &plant::Error) -> Error {
        let (mut place, mut error) = (self.place.clone(), error);
        while let plant::Error::Organ { symbol, problem } = error {
            place = self.place.join("organs").join(symbol);
            error = problem;
        }
        let complaint = Complaint::new(format!("can't grow: {error}"), "");
        let complaint = match error {
            plant::Error::Derive(error) => {
                let (label, help) = advice(&error.problem);
                let complaint = Complaint { label: label.into(), ..complaint };
                complaint.about_part(error.span.clone()).help(help)
            }
            _ => Complaint { label: "drawn by this grammar".into(), ..complaint },
        };
        let fault = Fault { text: Some(self.text.clone()), ..complaint.at(place.join("grammar")) };
        Error::Wrong { report: fault::report(&[fault]) }
    }
}

/// What is to blame, and what to do.
fn advice(problem: &derive::Problem) -> (&'static str, &'static str) {
    use derive::Problem::*;
    match problem {
        Modules { .. } | Bytes { .. } | Memory { .. } | Work { .. } => (
            "it writes the most of them",
            "take fewer `steps`, or give the rule a condition that ends its growth",
        ),
        Endless { .. } => {
            ("this never ends", "give `steps` a number, or the rule a condition that ends its growth")
        }
        Empty => ("nothing is left", "a word needs symbols, and `%` cuts off all that follows it"),
        Undefined(_) => ("this has no value", "keep such values out with a condition of the rule"),
        NegativeWeight(_) | NoWeight => (
            "weights are 0 or more, and one at least is more",
            "mind the range of what the weight is made of",
        ),
    }
}

/// Reads a species file. The species bears the file's name without folder and ending.
///
/// # Errors
/// When it can't be read, or says something wrong: see [`parse`].
pub fn load(path: &Path) -> Result<Loaded, Error> {
    let bytes = formats::read_bytes(path, MAX_BYTES)?;
    parse(&path.display().to_string(), &bytes)
}

/// Reads a species from the bytes of its file, whose path is `name`.
///
/// # Errors
/// With every mistake that was found: where, what is wrong, what is allowed.
pub fn parse(name: &str, bytes: &[u8]) -> Result<Loaded, Error> {
    let text = super::text(name, "species", bytes)?;
    let document = super::document(name, text)?;
    let stem =
        Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let checked = read(document.as_item()).and_then(|written| check(&stem, &written, &KeyPath::default()));
    let sources = Sources { name, what: "the species", document, settings: &[] };
    match checked {
        Ok((species, remarks)) => {
            let text = Arc::new(Text { name: name.into(), what: "the species", text: text.into() });
            let source = Source { text, place: KeyPath::default() };
            Ok(Loaded { species, source, warnings: sources.sentences(&remarks) })
        }
        Err(faults) => Err(Error::Wrong { report: sources.report(&faults) }),
    }
}

/// The species of a world, in the order of the file, and what is remarkable about them. Files start from `folder`.
///
/// # Errors
/// With every mistake that was found.
pub fn of_world(
    entries: &[(String, Entry)],
    folder: &Path,
) -> Result<(Vec<Arc<plant::Species>>, Vec<Fault>), Vec<Fault>> {
    let (mut found, mut remarks, mut faults) = (Vec::new(), Vec::new(), Vec::new());
    for (name, entry) in entries {
        let place = KeyPath::from("species").join(name);
        let read = match entry {
            Entry::Here(written) => check(name, written, &place),
            Entry::File(named) => of_file(name, named, folder, &place),
        };
        match read {
            Ok((species, more)) => {
                found.push(Arc::new(species));
                remarks.extend(more);
            }
            Err(more) => faults.extend(more),
        }
    }
    if faults.is_empty() { Ok((found, remarks)) } else { Err(faults) }
}

fn of_file(name: &str, named: &Named, folder: &Path, place: &KeyPath) -> Checked {
    // A fault that was noted.
    let Some(file) = &named.file else { return Err(Vec::new()) };
    let path = folder.join(file);
    let shown_path = path.display().to_string();
    let refuse = |label: String, cause| {
        let complaint = Complaint::new(format!("names \"{}\"", shown(file)), label);
        vec![Complaint { cause, ..complaint }.at(place.join("file"))]
    };
    let bytes =
        formats::read_bytes(&path, MAX_BYTES).map_err(|error| refuse(error.to_string(), Cause::File))?;
    let whole = super::text(&shown_path, "species", &bytes)
        .and_then(|text| Ok((text, super::document(&shown_path, text)?)))
        .map_err(|error| refuse(error.to_string(), Cause::World));
    let (text, document) = whole?;
    let text = Arc::new(Text { name: shown_path, what: "the species", text: text.to_string() });
    let here = |faults: Vec<Fault>| -> Vec<Fault> {
        faults.into_iter().map(|fault| Fault { text: Some(text.clone()), ..fault }).collect()
    };
    let written = read(document.as_item()).map_err(here)?;
    let own = Species {
        variants: named.variants.unwrap_or(written.variants),
        height: named.height.or(written.height),
        ..written
    };
    let (species, remarks) = check(name, &own, &KeyPath::default()).map_err(here)?;
    Ok((species, here(remarks)))
}

/// Reads the keys of a species file, with everything that is wrong in it.
fn read(file: &Item) -> Result<Species, Vec<Fault>> {
    let faults = RefCell::default();
    let SpeciesFile(written) = read_section(&Place::top(file, shape, &faults));
    let faults = faults.into_inner();
    if faults.is_empty() { Ok(written) } else { Err(faults) }
}

// Checking -----------------------------------------------------------------------------------------------------------

/// A species and what is allowed in it and hardly meant, or what is wrong.
type Checked = Result<(plant::Species, Vec<Fault>), Vec<Fault>>;

/// Checks what `written`, which stands at `place`, says as a whole.
fn check(name: &str, written: &Species, place: &KeyPath) -> Checked {
    let mut check = Check { written, place, faults: Vec::new(), remarks: Vec::new(), forms: 0 };
    let materials = check.materials();
    let form = check.plant();
    let Check { faults, remarks, .. } = check;
    let Some(form) = form.filter(|_| faults.is_empty()) else { return Err(faults) };
    let species = plant::Species {
        name: name.into(),
        form,
        materials,
        variants: written.variants,
        height: written.height,
    };
    Ok((species, remarks))
}

/// L-systems inside each other that a species may have: organs of organs are copied.
const MOST_FORMS: u32 = 256;

struct Check<'a> {
    written: &'a Species,
    place: &'a KeyPath,
    faults: Vec<Fault>,
    remarks: Vec<Fault>,
    forms: u32,
}

impl Check<'_> {
    fn refuse(&mut self, place: KeyPath, complaint: Complaint) {
        let fault = complaint.at(place);
        // An organ that stands in several others is met as often.
        if !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
    }

    fn materials(&mut self) -> Vec<scene::Material> {
        let at = self.place.join("materials");
        let mut materials = Vec::new();
        for (name, material) in &self.written.materials {
            let second = material.second_reflectance.unwrap_or(material.reflectance);
            let brightest = material.reflectance.iter().zip(second).map(|(first, second)| first.max(second));
            if brightest.zip(material.transmittance).any(|(back, through)| back + through > 1.0) {
                let label = "what is scattered back and what is let through are shares of the same light: together at most 1";
                self.refuse(at.join(name).join("transmittance"), Complaint::new("is too much light", label));
            }
            materials.push(scene::Material {
                name: name.clone(),
                reflectance: [material.reflectance, second],
                position_factor: material.position_factor,
                value_factor: material.value_factor,
                transmittance: material.transmittance,
                refractive_index: material.refractive_index,
                roughness: material.roughness,
            });
        }
        if materials.is_empty() {
            self.refuse(at, Complaint::new("is empty", "a plant is made of something: name a material"));
        }
        materials
    }

    /// Index of a material; of the first one for a name that there is not.
    fn material(&mut self, name: &str, place: KeyPath) -> usize {
        let names = self.written.materials.iter().map(|(name, _)| name.as_str());
        if let Some(index) = names.clone().position(|known| known == name) {
            return index;
        }
        let allowed = format!("materials: {}", names.clone().collect::<Vec<_>>().join(", "));
        self.refuse(place, guess(format!("can't be \"{}\"", shown(name)), name, names, allowed));
        0
    }

    fn wood(&mut self, name: Option<&String>, place: &KeyPath) -> Option<usize> {
        name.map(|name| self.material(name, place.join("wood")))
    }

    fn leaves(&mut self, names: Option<&Vec<String>>, place: &KeyPath) -> Option<Vec<usize>> {
        let place = place.join("leaves");
        let indices = names?.iter().enumerate().map(|(index, name)| self.material(name, place.join(index)));
        Some(indices.collect())
    }

    /// The plant itself.
    fn plant(&mut self) -> Option<Form> {
        let written = self.written;
        let wood = self.wood(written.wood.as_ref(), self.place).unwrap_or(0);
        let leaves = self.leaves(written.leaves.as_ref(), self.place);
        let others: Vec<usize> = (1..written.materials.len()).collect();
        let leaves = leaves.unwrap_or(if others.is_empty() { vec![0] } else { others });
        let turtle = Interpretation {
            angle: written.angle,
            pitch: written.pitch,
            roll: written.roll,
            draw: written.draw.clone(),
            moves: written.r#move.clone(),
            silent: written.silent.clone(),
            plus: written.plus,
            width: written.width,
            taper: written.taper,
            tropism: written.tropism.as_ref().map(|tropism| turtle::Tropism {
                direction: tropism.direction.into(),
                strength: tropism.strength,
            }),
        };
        let place = self.place.clone();
        // Organs that nothing places are wrong all the same when they are.
        let mut organs = Vec::new();
        for (name, organ) in &written.organs {
            let turtle = Interpretation { tropism: None, ..turtle.clone() };
            let outer = Outer { turtle, wood, leaves: leaves.clone(), inside: Vec::new() };
            organs.extend(self.organ(name, organ, &outer));
        }
        let outer = Outer { turtle: turtle.clone(), wood, leaves, inside: Vec::new() };
        self.form(&written.grammar, written.steps, &place, outer)
    }

    /// An L-system at `place`, with the organs that it places.
    fn form(&mut self, text: &str, steps: Option<u32>, place: &KeyPath, outer: Outer) -> Option<Form> {
        self.forms += 1;
        let at = place.join("grammar");
        if self.forms > MOST_FORMS {
            let label = format!("organs inside organs are copied, and {MOST_FORMS} are the most");
            self.refuse(at, Complaint::new("has too many organs inside each other", label));
            return None;
        }
        let grammar = match Grammar::parse(text, &self.written.ignore) {
            Ok(grammar) => grammar,
            Err(error) => {
                self.refuse(at, complaint(&error));
                return None;
            }
        };
        for warning in grammar.warnings() {
            let remark = Complaint::new(warning.problem.clone(), warning.expected.clone());
            let remark = remark.about_part(warning.span.clone());
            if warning.kind == WarningKind::MissingSymbol {
                self.refuse(at.clone(), remark);
                continue;
            }
            let remark = remark.at(at.clone());
            if !self.remarks.contains(&remark) {
                self.remarks.push(remark);
            }
        }
        let mut organs = Vec::new();
        for (symbol, span) in placed(text) {
            let name = symbol.to_string();
            let Some((_, organ)) = self.written.organs.iter().find(|(known, _)| *known == name) else {
                let known: Vec<&str> = self.written.organs.iter().map(|(name, _)| name.as_str()).collect();
                let label = match known.is_empty() {
                    true => "there are no `organs`".into(),
                    false => format!("organs: {}", known.join(", ")),
                };
                self.refuse(
                    at.clone(),
                    Complaint::new("places an organ that there is not", label).about_part(span),
                );
                continue;
            };
            if outer.inside.contains(&symbol) {
                let label = format!("`{symbol}` would hold itself");
                self.refuse(
                    at.clone(),
                    Complaint::new("places an organ inside itself", label).about_part(span),
                );
                continue;
            }
            organs.extend(self.organ(&name, organ, &outer));
        }
        let Outer { turtle, wood, leaves, .. } = outer;
        let steps = steps.map_or(Steps::UntilDone, Steps::Fixed);
        Some(Form { grammar, steps, turtle, wood, leaves, organs })
    }

    fn organ(&mut self, name: &str, organ: &Organ, outer: &Outer) -> Option<plant::Organ> {
        let place = self.place.join("organs").join(name);
        let symbol = name.chars().next()?;
        let wood = self.wood(organ.wood.as_ref(), &place).unwrap_or(outer.wood);
        let leaves = self.leaves(organ.leaves.as_ref(), &place).unwrap_or_else(|| outer.leaves.clone());
        let shape = match (organ.polygons.is_empty(), organ.grammar.is_empty()) {
            (true, true) => {
                let label = "its `polygons`, or its `grammar`";
                self.refuse(place, Complaint::new("is empty", label).about_key());
                return None;
            }
            (false, false) => {
                let label = "an organ has either polygons or a grammar";
                self.refuse(
                    place.join("grammar"),
                    Complaint::new("can't stand beside `polygons`", label).about_key(),
                );
                return None;
            }
            (false, true) => Shape::Polygons(self.outlines(organ, &leaves, &place)),
            (true, false) => {
                let turtle = Interpretation {
                    angle: organ.angle.unwrap_or(outer.turtle.angle),
                    width: organ.width,
                    tropism: None,
                    ..outer.turtle.clone()
                };
                let inside = outer.inside.iter().copied().chain([symbol]).collect();
                let own = Outer { turtle, wood, leaves, inside };
                Shape::Grown(Box::new(self.form(&organ.grammar, organ.steps, &place, own)?))
            }
        };
        Some(plant::Organ { symbol, shape })
    }

    fn outlines(&mut self, organ: &Organ, leaves: &[usize], place: &KeyPath) -> Vec<plant::Outline> {
        let mut outlines = Vec::new();
        for (index, Outline { material, vertices }) in organ.polygons.iter().enumerate() {
            let place = place.join("polygons").join(index);
            if vertices.is_empty() {
                self.refuse(place.join("vertices"), Complaint::new("is missing", "its corners").about_key());
            }
            let material = material.as_ref().map(|name| self.material(name, place.join("material")));
            let material = material.or(leaves.first().copied()).unwrap_or(0);
            outlines.push(plant::Outline { material, vertices: vertices.clone() });
        }
        outlines
    }
}

/// What a form takes from the one that holds it.
#[derive(Clone)]
struct Outer {
    turtle: Interpretation,
    wood: usize,
    leaves: Vec<usize>,
    /// Organs that it is a part of.
    inside: Vec<char>,
}

fn complaint(error: &grammar::Error) -> Complaint {
    Complaint::new(error.problem.clone(), error.expected.clone()).about_part(error.span.clone())
}

/// The symbols behind `~` and `@` with their place in the text, each once.
fn placed(grammar: &str) -> Vec<(char, Range<usize>)> {
    let mut found: Vec<(char, Range<usize>)> = Vec::new();
    let mut at = 0;
    for line in grammar.split_inclusive('\n') {
        let code = line.split('#').next().unwrap_or_default();
        for (index, _) in code.match_indices(['~', '@']) {
            let Some(symbol) = code[index + 1..].chars().next() else { continue };
            if !symbol.is_whitespace() && found.iter().all(|(known, _)| *known != symbol) {
                let start = at + index;
                found.push((symbol, start..start + 1 + symbol.len_utf8()));
            }
        }
        at += line.len();
    }
    found
}
