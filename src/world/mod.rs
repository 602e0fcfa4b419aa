//! World files: one TOML file describes one world.
//!
//! `keys` declares every key once, with unit, range, default and meaning, out of `kinds` of values. Reading takes two
//! steps: a file as it is written becomes values in the program's units (`keys::World`), and these become what the
//! makers take, checked as a whole (`plan`). Nothing downstream checks again. The file itself is kept as a document
//! ([`toml_edit`]): what changes it, `--set` first, edits that and keeps its comments.

pub mod cache;
mod fault;
mod json_schema;
mod keys;
mod kinds;
mod place;
mod plan;
mod reference;
pub mod schema;
mod settings;

pub use json_schema::json_schema;
pub use place::KeyPath;
pub use reference::reference;

use crate::core::hash::hexadecimal;
use crate::scene;
use crate::terrain;
use fault::{Cause, Fault, Sources, report_text};
use place::Place;
use schema::Section;
use settings::Setting;
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use toml_edit::{Document, DocumentMut};

/// A world: what makers and renderers need, checked, in metres, seconds, years, radians and cd/m².
#[derive(Clone, Debug)]
pub struct World {
    /// Name of the file without folder and ending.
    pub name: String,
    /// The file, as it was named.
    pub path: PathBuf,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub sha256: String,
    pub seed: u32,
    pub plan: terrain::Plan,
    pub light: scene::Light,
    pub sea: scene::Sea,
    pub surface: scene::Surface,
    pub camera: scene::Camera,
    pub film: scene::Film,
    /// What is allowed and hardly meant, one sentence each.
    pub warnings: Vec<String>,
    /// The file, with what the command line changed.
    pub document: DocumentMut,
}

/// What the command line changes in a world.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// `section.key=value`, in order. The value is TOML; words may go without quotes.
    pub set: Vec<String>,
    /// Wins over `set`.
    pub seed: Option<u32>,
}

/// Why there is no world. A message begins without "error:" and may have many lines.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("can't read {}: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },

    /// The file or an argument of `--set` is wrong.
    #[error("{report}")]
    Wrong { report: String },

    /// A file that the world names can't be read.
    #[error("{report}")]
    Unreadable { report: String },
}

impl Error {
    /// What the program exits with: 3 for something the user wrote, 7 for a file that can't be read.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Wrong { .. } => 3,
            Error::Read { .. } | Error::Unreadable { .. } => 7,
        }
    }
}

/// Longer files are no worlds.
pub const MAX_BYTES: usize = 1 << 20;

/// Reads a world file.
///
/// # Errors
/// When it can't be read, or says something wrong: see [`parse`].
pub fn load(path: &Path, overrides: &Overrides) -> Result<World, Error> {
    let failed = |source| Error::Read { path: path.into(), source };
    let file = std::fs::File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(&path.display().to_string(), &bytes, folder, overrides)
}

/// Reads a world from the bytes of its file. `name` is the path that messages show; the files that the world names
/// lie in `folder`, and nothing else is read.
///
/// # Errors
/// With every mistake that was found: where, what is wrong, what is allowed.
pub fn parse(name: &str, bytes: &[u8], folder: &Path, overrides: &Overrides) -> Result<World, Error> {
    let text = text(name, bytes)?;
    let parsed = Document::parse(text).map_err(|error| {
        let report =
            report_text("not a TOML file", error.span().unwrap_or(0..0), error.message(), Some(name), text);
        Error::Wrong { report }
    })?;
    let settings: Result<Vec<Setting>, String> =
        overrides.set.iter().map(|argument| Setting::parse(argument)).collect();
    let settings = settings.map_err(|report| Error::Wrong { report })?;

    let mut document = parsed.clone().into_mut();
    let planned = edit(&mut document, &settings, overrides.seed)
        .and_then(|()| read(&document))
        .and_then(|written| Ok((plan::plan(&written, folder)?, written)));
    let (planned, written) = planned.map_err(|faults| {
        let report = Sources { name, document: parsed, settings: &settings }.report(&faults);
        let files_only = faults.iter().all(|fault| fault.complaint.cause == Cause::File);
        if files_only { Error::Unreadable { report } } else { Error::Wrong { report } }
    })?;

    let path = PathBuf::from(name);
    let plan::Planned { plan, light, camera, film, warnings } = planned;
    let keys::World { format: (), seed, sea, surface, .. } = written;
    Ok(World {
        name: path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
        path,
        sha256: hexadecimal(&Sha256::digest(bytes)),
        seed,
        plan,
        light,
        sea,
        surface,
        camera,
        film,
        warnings,
        document,
    })
}

/// Everything that may stand in a world file, as data.
pub fn shape() -> schema::Table {
    schema::Table { about: keys::World::ABOUT, keys: keys::World::keys(), presets: keys::World::PRESETS }
}

/// Applies what the command line changes.
fn edit(document: &mut DocumentMut, settings: &[Setting], seed: Option<u32>) -> Result<(), Vec<Fault>> {
    let default = |path: &KeyPath| shape().default_array(&path.0);
    for setting in settings {
        setting.apply(document, default).map_err(|fault| vec![fault])?;
    }
    if let Some(seed) = seed {
        let value = i64::from(seed).into();
        settings::set(document.as_item_mut(), &"seed".into(), value, default).map_err(|fault| vec![fault])?;
    }
    Ok(())
}

/// Reads the document as it is written, with everything that is wrong in it.
fn read(document: &DocumentMut) -> Result<keys::World, Vec<Fault>> {
    let faults = RefCell::default();
    let written = kinds::read_section(&Place::top(document.as_item(), &faults));
    let faults = faults.into_inner();
    if faults.is_empty() { Ok(written) } else { Err(faults) }
}

fn text<'a>(name: &str, bytes: &'a [u8]) -> Result<&'a str, Error> {
    if bytes.len() > MAX_BYTES {
        let report = format!("{name} is too large for a world file: it may have {MAX_BYTES} bytes");
        return Err(Error::Wrong { report });
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let good = error.valid_up_to();
        let readable = String::from_utf8_lossy(bytes);
        let span = good..good + '\u{fffd}'.len_utf8();
        let report =
            report_text("not UTF-8 text", span, "this byte is no part of a character", Some(name), &readable);
        Error::Wrong { report }
    })
}
