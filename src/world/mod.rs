//! World files: one TOML file describes one world.
//!
//! `keys` declares every key once, with unit, range, default and meaning, out of `kinds` of values. Reading takes two
//! steps: a file as it is written becomes values in the program's units (`keys::World`), and these become what the
//! makers take, checked as a whole (`plan`). Nothing downstream checks again. The file itself is kept as a document
//! ([`toml_edit`]): what changes it, `--set` first, edits that and keeps its comments.

pub mod cache;
mod edit;
mod fault;
mod json_schema;
mod keys;
mod kinds;
mod models;
mod place;
mod plan;
mod planting;
mod reference;
pub mod schema;
mod settings;
pub mod shard;
pub mod species;
pub mod thesis;
mod zoom;

pub use edit::Edit;
pub use json_schema::{json_schema, json_schema_of_species};
pub use keys::{MOST_FRAMES, Renderer, Zoom};
pub use place::{KeyPath, array_len};
pub use reference::{reference, reference_of_species};

use crate::core::hash::{derive_seed, hexadecimal};
use crate::formats;
use crate::plants::{self, derive::Limits};
use crate::scene::{self, Model};
use crate::terrain;
use crate::trace;
use fault::{Cause, Complaint, Fault, Origins, Sources, report_text};
use place::Place;
use schema::Section;
use settings::Setting;
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;
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
    pub plants: plants::planting::Plan,
    /// Where the species of [`World::plants`] are written.
    pub written: Vec<species::Source>,
    pub viewpoint: scene::Viewpoint,
    /// The way of the camera through a film.
    pub camera_path: scene::CameraPath,
    /// What there is in place of land and sea.
    pub zoom: Option<Zoom>,
    /// Vertical field of view, radians.
    pub fov: f32,
    pub film: scene::Film,
    /// How the picture is made unless the command line says so.
    pub renderer: Renderer,
    /// Samples a pixel, where it is traced.
    pub samples: u32,
    /// How it is traced.
    pub tracing: trace::Settings,
    /// Where the picture goes unless the command line says so, if the world says it.
    pub photo: Option<PathBuf>,
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

impl Overrides {
    /// Whether a key is among those of `set`, spelled with dots.
    pub fn sets(&self, key: &str) -> bool {
        let paths = self.set.iter().filter_map(|argument| Setting::parse(argument).ok());
        paths.into_iter().any(|setting| *setting.path() == KeyPath::from(key))
    }
}

/// Why there is no world. A message begins without "error:" and may have many lines.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Read(#[from] formats::Error),

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
            Error::Read(_) | Error::Unreadable { .. } => 7,
        }
    }
}

/// Longer files are no worlds.
pub const MAX_BYTES: usize = 1 << 20;

/// Reads a world file, or a folder of settings (see [`thesis`]).
///
/// # Errors
/// When it can't be read, or says something wrong: see [`parse`].
pub fn load(path: &Path, overrides: &Overrides) -> Result<World, Error> {
    if path.is_dir() {
        return load_folder(path, overrides);
    }
    let bytes = formats::read_bytes(path, MAX_BYTES)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(&path.display().to_string(), &bytes, folder, overrides)
}

/// A folder is a world file that nobody has written down, and read as such.
fn load_folder(path: &Path, overrides: &Overrides) -> Result<World, Error> {
    let thesis::Converted { text, photo, origins, mut warnings } = thesis::read(path)?;
    let name = format!("{} as a world file", path.display());
    let world = parse_made(&name, text.as_bytes(), path, overrides, origins)?;
    warnings.extend(world.warnings);
    let whole = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
    Ok(World {
        name: whole.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.into(),
        photo: Some(path.join("photos").join(format!("{photo}.exr"))),
        warnings,
        ..world
    })
}

/// Reads a world from the bytes of its file. `name` is the path that messages show; the files that the world names
/// lie in `folder`, and nothing else is read.
///
/// # Errors
/// With every mistake that was found: where, what is wrong, what is allowed.
pub fn parse(name: &str, bytes: &[u8], folder: &Path, overrides: &Overrides) -> Result<World, Error> {
    parse_made(name, bytes, folder, overrides, Origins::default())
}

/// Reads a world whose text was made from other files.
fn parse_made(
    name: &str,
    bytes: &[u8],
    folder: &Path,
    overrides: &Overrides,
    origins: Origins,
) -> Result<World, Error> {
    let text = text(name, "world", bytes)?;
    let parsed = self::document(name, text)?;
    let settings: Result<Vec<Setting>, String> =
        overrides.set.iter().map(|argument| Setting::parse(argument)).collect();
    let settings: Arc<[Setting]> = settings.map_err(|report| Error::Wrong { report })?.into();
    let origins = Arc::new(origins);
    let whole = Arc::new(fault::Text {
        name: name.into(),
        what: "the world",
        text: text.into(),
        settings: settings.clone(),
        origins: origins.clone(),
    });

    let mut document = parsed.clone().into_mut();
    let planned =
        edit(&mut document, &settings, overrides.seed).and_then(|()| read(&document)).and_then(|written| {
            let (plan, species) =
                both(plan::plan(&written, folder), species::of_world(&written.species, &whole, folder))?;
            Ok((written, plan, species))
        });
    let sources =
        Sources { name, what: "the world", document: parsed, settings: &settings, origins: &origins };
    let (written, planned, (species, remarks)) = planned.map_err(|mut faults| {
        if sources.document.get("grammar").is_some() {
            // Every key would be wrong.
            let label =
                "look at it with `terrane plant`, or let a world name the file in its table `species`";
            let complaint = Complaint::new("makes this the file of a species, and a world is wanted", label);
            faults = vec![complaint.about_key().at("grammar".into())];
        }
        let report = sources.report(&faults);
        let files_only = faults.iter().all(|fault| fault.complaint.cause == Cause::File);
        if files_only { Error::Unreadable { report } } else { Error::Wrong { report } }
    })?;

    let path = PathBuf::from(name);
    let plan::Planned {
        plan,
        light,
        viewpoint,
        camera_path,
        film,
        models,
        mut rules,
        standing,
        mut warnings,
    } = planned;
    for rule in &mut rules {
        if let Some(file) = origins.of(&KeyPath::from(rule.name.as_str())) {
            rule.name = file.into();
        }
    }
    let (species, places) = species.into_iter().unzip();
    warnings.extend(sources.sentences(&remarks));
    let keys::World { format: (), seed, sea, surface, zoom, camera, render, .. } = written;
    Ok(World {
        name: path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
        path,
        sha256: hexadecimal(&Sha256::digest(bytes)),
        seed,
        plan,
        light,
        sea,
        surface,
        plants: plants::planting::Plan { species, models, rules, standing },
        written: places,
        viewpoint,
        camera_path,
        zoom,
        fov: camera.fov,
        film,
        renderer: render.renderer,
        samples: render.spp,
        tracing: trace::Settings {
            seed: derive_seed(seed, "render"),
            bounces: render.bounces,
            aperture: camera.aperture / 2.0,
            focus: camera.focus,
            plain: render.constant_materials,
            sea: !render.constant_materials,
        },
        photo: None,
        warnings,
        document,
    })
}

impl World {
    /// The model of a variant of a species, by its index in [`World::plants`].
    ///
    /// # Errors
    /// Why it can't grow: [`World::blame`] knows its place in the file.
    pub fn grow(
        &self,
        species: usize,
        variant: u32,
        limits: &Limits,
    ) -> Result<Model, plants::species::Error> {
        self.plants.species[species].grow(self.seed_of(species), variant, limits)
    }

    /// Why a species can't grow, with the place in the file.
    pub fn blame(&self, species: usize, error: &plants::species::Error) -> Error {
        self.written[species].blame(error)
    }

    /// Sentences about what of a species is unfinished, see [`plants::species::Species::unfinished`].
    pub fn unfinished(&self, species: usize, limits: &Limits) -> Vec<String> {
        let unfinished = self.plants.species[species].unfinished(self.seed_of(species), limits);
        unfinished.iter().map(|unfinished| self.written[species].warn(unfinished)).collect()
    }

    /// A sentence that a species shows nothing.
    pub fn warn_empty(&self, species: usize) -> String {
        self.written[species].warn_empty()
    }

    fn seed_of(&self, species: usize) -> u32 {
        species::seed(self.seed, &self.plants.species[species].name)
    }
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
    let written = kinds::read_section(&Place::top(document.as_item(), shape, &faults));
    let faults = faults.into_inner();
    if faults.is_empty() { Ok(written) } else { Err(faults) }
}

/// Both results, or all that is wrong with either.
fn both<A, B>(first: Result<A, Vec<Fault>>, second: Result<B, Vec<Fault>>) -> Result<(A, B), Vec<Fault>> {
    match (first, second) {
        (Ok(first), Ok(second)) => Ok((first, second)),
        (first, second) => Err([first.err(), second.err()].into_iter().flatten().flatten().collect()),
    }
}

/// The text of a file that describes `what`.
fn text<'a>(name: &str, what: &str, bytes: &'a [u8]) -> Result<&'a str, Error> {
    if bytes.len() > MAX_BYTES {
        let report = format!("{name} is too large for a {what} file: it may have {MAX_BYTES} bytes");
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

fn document<'a>(name: &str, text: &'a str) -> Result<Document<&'a str>, Error> {
    Document::parse(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        Error::Wrong { report: report_text("not a TOML file", span, error.message(), Some(name), text) }
    })
}
