//! A folder of settings as Rudzki 2020 ("Realistic rendering of procedural generated forest landscapes", §4.3) has it,
//! read as a world: it becomes the text of a world file, and that is read like any other.

mod document;
mod files;
mod folder;
mod growth;
mod mistakes;
mod parameters;
mod productions;
mod reference;
mod settings;
mod species;
mod tokens;

pub use folder::{Contents, Folder, MAX_FILE};
pub use reference::reference;

use super::Error;
use super::fault::Origins;
use std::path::Path;

/// A folder as a world file.
#[derive(Clone, Debug)]
pub struct Converted {
    /// What the world file holds.
    pub text: String,
    /// Name of its picture, without folder and ending.
    pub photo: String,
    /// What it could not say in a world file, one sentence each.
    pub warnings: Vec<String>,
    /// The files that its keys come from, as messages show them.
    pub origins: Origins,
}

/// Reads a folder.
///
/// # Errors
/// With every mistake that was found, each with its file and place.
pub fn read(path: &Path) -> Result<Converted, Error> {
    convert(&Folder::read(path)?)
}

/// Turns settings into a world file.
///
/// # Errors
/// As [`read`].
pub fn convert(folder: &Folder) -> Result<Converted, Error> {
    let settings = settings::read(folder)?;
    let (text, origins) = document::write(folder, &settings);
    let warnings = document::warnings(&settings);
    Ok(Converted { text, photo: settings.path_tracer.photo_name, warnings, origins })
}
