//! Species files: how a kind of plant grows and what it is made of. A world names such a file, or has the same keys in
//! its table `species`.
//!
//! `keys` declares what may be written, `check` makes a species of it.

mod check;
mod keys;

pub use keys::{Entry, EntryKind, shape};

use super::fault::{self, Cause, Complaint, Fault, Origins, Sources, Text};
use super::kinds::read_section;
use super::place::{KeyPath, Place, shown};
use super::{Error, MAX_BYTES};
use crate::core::hash::derive_seed;
use crate::formats;
use crate::plants::derive;
use crate::plants::species as plant;
use crate::plants::species::Unfinished;
use check::{Checked, check};
use keys::{Named, Species, SpeciesFile};
use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;
use toml_edit::Item;

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
                let (label, mut help) = advice(&error.problem);
                if self.text.origins.of(&place).is_some() {
                    help = "lower `N`, or make the words of the productions shorter";
                }
                let complaint = Complaint { label: label.into(), ..complaint };
                complaint.about_part(error.span.clone()).help(help)
            }
            _ => Complaint { label: "drawn by this grammar".into(), ..complaint },
        };
        Error::Wrong { report: fault::report(&[self.fault(place.join("grammar"), complaint)]) }
    }

    /// That growth is cut short, as a sentence.
    pub fn warn(&self, unfinished: &Unfinished) -> String {
        let &Unfinished { organ, steps, ends } = unfinished;
        let place = organ.map_or_else(|| self.place.clone(), |organ| self.place.join("organs").join(organ));
        let label = format!("it ends by itself after {ends}; give it as many, or \"auto\"");
        let complaint = Complaint::new(format!("cut the growth short after {steps}"), label);
        let fault = self.fault(place.join("steps"), complaint);
        self.text.sentences(&[fault]).concat()
    }

    fn fault(&self, place: KeyPath, complaint: Complaint) -> Fault {
        Fault { text: Some(self.text.clone()), ..complaint.at(place) }
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
        Stopped(_) => ("this was growing", "let it grow"),
        Empty => ("nothing is left", "a word needs symbols, and `%` cuts off all that follows it"),
        Undefined(_) => ("this has no value", "keep such values out with a condition of the rule"),
        NegativeWeight(_) | NoWeight => (
            "weights are 0 or more, and one at least is more",
            "mind the range of what the weight is made of",
        ),
    }
}

const WORLDS: &str = "look at it with `terrane check`, or see it with `terrane render`";

/// The seed of a species that is called so in a world with this seed.
pub fn seed(world: u32, name: &str) -> u32 {
    derive_seed(world, &format!("plants.{name}"))
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
    let of_world = ["terrain", "species", "plants"].into_iter().find(|key| document.contains_key(key));
    let checked = match of_world {
        Some(key) if !document.contains_key("grammar") => {
            // Every key would be wrong.
            let complaint = Complaint::new("makes this a world, and the file of a species is wanted", WORLDS);
            Err(vec![complaint.about_key().at(key.into())])
        }
        _ => checked,
    };
    let origins = Origins::default();
    let sources = Sources { name, what: "the species", document, settings: &[], origins: &origins };
    match checked {
        Ok((species, remarks)) => {
            let source = Source { text: of_species(name.into(), text), place: KeyPath::default() };
            Ok(Loaded { species, source, warnings: sources.sentences(&remarks) })
        }
        Err(faults) => Err(Error::Wrong { report: sources.report(&faults) }),
    }
}

fn of_species(name: String, text: &str) -> Arc<Text> {
    let (settings, origins) = (Arc::new([]), Arc::default());
    Arc::new(Text { name, what: "the species", text: text.into(), settings, origins })
}

/// The species of a world, in the order of the file, with the places that they are written in, and what is remarkable
/// about them. `text` is the world's file; other files start from `folder`.
///
/// # Errors
/// With every mistake that was found.
pub fn of_world(
    entries: &[(String, Entry)],
    text: &Arc<Text>,
    folder: &Path,
) -> Checked<Vec<(Arc<plant::Species>, Source)>> {
    let (mut found, mut remarks, mut faults) = (Vec::new(), Vec::new(), Vec::new());
    for (name, entry) in entries {
        let place = KeyPath::from("species").join(name);
        let read = match entry {
            Entry::Here(written) => check(name, written, &place)
                .map(|(species, remarks)| ((species, Source { text: text.clone(), place }), remarks)),
            Entry::File(named) => of_file(name, named, folder, &place),
        };
        match read {
            Ok(((species, source), more)) => {
                found.push((Arc::new(species), source));
                remarks.extend(more);
            }
            Err(more) => faults.extend(more),
        }
    }
    if faults.is_empty() { Ok((found, remarks)) } else { Err(faults) }
}

fn of_file(name: &str, named: &Named, folder: &Path, place: &KeyPath) -> Checked<(plant::Species, Source)> {
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
    let text = of_species(shown_path, text);
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
    let remarks = here(remarks);
    Ok(((species, Source { text, place: KeyPath::default() }), remarks))
}

/// Reads the keys of a species file, with everything that is wrong in it.
fn read(file: &Item) -> Result<Species, Vec<Fault>> {
    let faults = RefCell::default();
    let SpeciesFile(written) = read_section(&Place::top(file, shape, &faults));
    let faults = faults.into_inner();
    if faults.is_empty() { Ok(written) } else { Err(faults) }
}
