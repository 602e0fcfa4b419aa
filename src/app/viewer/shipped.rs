//! The worlds that come with the program: they lie in it, and in a folder of the user's once one is opened, as files to change.

use crate::core::hash::hexadecimal;
use crate::formats::{self, file};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Path below `configs/` and bytes of every file there, written by build.rs.
const FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/worlds.rs"));

/// A world that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct World {
    pub name: &'static str,
    /// Of the island, the forest and so on.
    pub kind: &'static str,
    /// What it shows, in a sentence.
    pub about: &'static str,
    /// Below the folder of worlds.
    path: &'static str,
    /// A small picture of it, PNG.
    pub picture: &'static [u8],
}

macro_rules! worlds {
    ($($kind:literal / $name:literal: $about:literal,)*) => {
        /// Those that are offered, in their order.
        pub const WORLDS: &[World] = &[$(World {
            name: $name,
            kind: $kind,
            about: $about,
            path: concat!($kind, "/", $name, ".toml"),
            picture: include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/pictures/small/", $kind, "_", $name, ".png")),
        }),*];
    };
}

worlds! {
    "island" / "volcano": "Rain cuts valleys into a volcano, and a reef grows round it.",
    "zoom" / "descent": "Down to a fractal surface, for ever.",
    "landscape" / "reef_forest": "A wooded island behind its reef.",
    "forest" / "default": "A meadow at the edge of a wood.",
    "island" / "atoll": "Only the reef is left of a volcano that sank.",
    "island" / "dendritic": "Nothing but rain on a plain that slopes.",
    "island" / "old_barrier": "An old island and its lagoon.",
    "forest" / "mountain": "Spruces below the snow.",
    "forest" / "dead": "A dead wood at dusk.",
    "zoom" / "thesis": "The surface with flat facets, without haze.",
    "island" / "tiny": "A small island that is done in seconds.",
    "forest" / "tiny": "A few trees, soon there.",
}

/// In the folder of worlds: SHA-256 of each file as it was written.
const WRITTEN: &str = ".written.json";

/// Writes the worlds into a folder of the user's, and returns the path of one of them. What the user has changed there stays; what is as
/// an earlier version of the program wrote it becomes what it is now.
///
/// # Errors
/// When the folder can't be written to.
pub fn unpack(world: &World, folder: &Path) -> Result<PathBuf, formats::Error> {
    unpack_files(FILES, &folder.join("worlds"))?;
    Ok(folder.join("worlds").join(world.path))
}

/// The same for worlds that were unpacked before, by whatever version.
///
/// # Errors
/// As [`unpack`].
pub fn refresh(folder: &Path) -> Result<(), formats::Error> {
    let folder = folder.join("worlds");
    if folder.join(WRITTEN).exists() { unpack_files(FILES, &folder) } else { Ok(()) }
}

fn unpack_files(files: &[(&str, &[u8])], folder: &Path) -> Result<(), formats::Error> {
    let hash = |bytes: &[u8]| hexadecimal(&Sha256::digest(bytes));
    // Without it, what is there is taken for the user's.
    let record = std::fs::read(folder.join(WRITTEN)).unwrap_or_default();
    let before: BTreeMap<String, String> = serde_json::from_slice(&record).unwrap_or_default();
    let mut written = BTreeMap::new();
    for (name, bytes) in files {
        let path = folder.join(name);
        let there = match std::fs::read(&path) {
            Ok(there) => Some(hash(&there)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
            // It is somebody's.
            Err(_) => continue,
        };
        let is_ours = there.is_none() || there.as_ref() == before.get(*name);
        let new = hash(bytes);
        if is_ours && there.as_ref() != Some(&new) {
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)
                    .map_err(|source| formats::Error::Write { path: parent.into(), source })?;
            }
            file::replace_keeping(&path, None, |out| out.write_all(bytes))?;
        }
        // What is the same is ours again, whoever wrote it.
        if is_ours || there.as_ref() == Some(&new) {
            written.insert((*name).to_owned(), new);
        }
    }
    if written != before {
        let text = serde_json::to_vec_pretty(&written).unwrap_or_default();
        file::replace_keeping(&folder.join(WRITTEN), None, |out| out.write_all(&text))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_worlds_that_are_offered_can_be_opened() {
        let folder = tempfile::tempdir().expect("a folder");
        for world in WORLDS {
            let path = unpack(world, folder.path()).expect("it can be written");
            crate::world::load(&path, &crate::world::Overrides::default()).expect("it is a world");
        }
    }

    #[test]
    fn what_was_changed_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = unpack(&WORLDS[0], folder.path()).expect("it can be written");
        std::fs::write(&path, "format = 1").expect("it can be written");
        unpack(&WORLDS[0], folder.path()).expect("it is there");
        assert_eq!(std::fs::read_to_string(&path).expect("it is there"), "format = 1");
    }

    #[test]
    fn what_nobody_changed_becomes_what_is_shipped_now() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let [changed, kept] = ["a/changed.toml", "kept.toml"].map(|name| folder.join(name));
        let read = |path: &Path| std::fs::read_to_string(path).expect("it is there");
        let ship = |one: &[u8], other: &[u8]| {
            unpack_files(&[("a/changed.toml", one), ("kept.toml", other)], folder).expect("it is written");
        };
        ship(b"one", b"one");
        std::fs::write(&changed, "mine").expect("it is written");
        ship(b"two", b"two");
        assert_eq!((read(&changed), read(&kept)), ("mine".into(), "two".into()));
        // Nor later, though it was ours once.
        ship(b"three", b"three");
        assert_eq!((read(&changed), read(&kept)), ("mine".into(), "three".into()));
        // What is thrown away comes again.
        std::fs::remove_file(&changed).expect("it was there");
        ship(b"three", b"three");
        assert_eq!(read(&changed), "three");
    }
}
