//! The files of a folder, read with care: nothing long, nothing that is no file, no folder in a folder.

use crate::formats;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::path::Path;

/// Longest file of settings, bytes.
pub const MAX_FILE: usize = 1 << 16;

/// Most files of a kind.
const MAX_FILES: usize = 64;

/// Most that may lie in the folder itself: pictures and notes are nobody's business.
const MAX_ENTRIES: usize = 4096;

/// Folders inside the folder.
pub const FOLDERS: [&str; 5] = ["leafs", "materials", "plants", "spawners", "trees"];

/// What lies in a folder, or would.
#[derive(Clone, Debug, Default)]
pub struct Folder {
    /// As messages show it.
    pub name: String,
    /// By their way from the folder, parts of it separated by `/`; in order.
    pub files: BTreeMap<String, Contents>,
    /// Folders in it.
    pub folders: BTreeSet<String>,
}

/// What is known of a file.
#[derive(Clone, Debug)]
pub enum Contents {
    /// Of a file that is longer than [`MAX_FILE`], one byte more than that.
    Bytes(Vec<u8>),
    /// Why it can't be read.
    Unreadable(String),
}

impl Folder {
    /// Reads the settings in a folder: files that end in `.conf`, and all in its folders of leaves, materials, plants,
    /// spawners and trees. Hidden files and those of editors (`name~`) are passed over.
    ///
    /// # Errors
    /// When the folder itself, or one in it, can't be read or holds too much. What is wrong with a file is kept in its
    /// place.
    pub fn read(path: &Path) -> Result<Folder, formats::Error> {
        let mut folder = Folder { name: shown(path), ..Folder::default() };
        for name in entries(path, MAX_ENTRIES)? {
            let inside = path.join(&name);
            let name = name.to_string_lossy().into_owned();
            if inside.is_dir() {
                if FOLDERS.contains(&name.as_str()) {
                    folder.read_folder(&inside, &name)?;
                }
                folder.folders.insert(name);
            } else if name.ends_with(".conf") {
                folder.files.insert(name, Contents::read(&inside));
            }
        }
        Ok(folder)
    }

    fn read_folder(&mut self, path: &Path, name: &str) -> Result<(), formats::Error> {
        for entry in entries(path, MAX_FILES)? {
            let way = format!("{name}/{}", entry.to_string_lossy());
            self.files.insert(way, Contents::read(&path.join(entry)));
        }
        Ok(())
    }

    /// Files in the folder `name`, in order: their ways from here.
    pub fn files_in(&self, name: &str) -> impl Iterator<Item = &str> {
        let within = format!("{name}/");
        self.files.keys().map(String::as_str).filter(move |way| way.starts_with(&within))
    }

    /// The way of a file, as messages show it.
    pub fn shown(&self, way: &str) -> String {
        if self.name.ends_with('/') { format!("{}{way}", self.name) } else { format!("{}/{way}", self.name) }
    }
}

impl Contents {
    fn read(path: &Path) -> Contents {
        match formats::read_bytes(path, MAX_FILE) {
            Ok(bytes) => Contents::Bytes(bytes),
            Err(error) => Contents::Unreadable(error.to_string()),
        }
    }
}

/// Names of what lies in a folder; nothing if there is too much.
fn entries(path: &Path, most: usize) -> Result<Vec<OsString>, formats::Error> {
    let failed = |source| formats::Error::Read { path: path.into(), source };
    let mut names = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        if name.to_string_lossy().contains(char::is_control) {
            let reason = format!("{name:?} in it is no name of a file of settings: rename or remove it");
            return Err(failed(io::Error::new(io::ErrorKind::InvalidData, reason)));
        }
        if !passed_over(&name) {
            names.push(name);
        }
        if names.len() > most {
            let reason = format!("more than {most} files lie in it");
            return Err(failed(io::Error::new(io::ErrorKind::InvalidData, reason)));
        }
    }
    Ok(names)
}

fn passed_over(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes();
    name.starts_with(b".") || name.ends_with(b"~")
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}
