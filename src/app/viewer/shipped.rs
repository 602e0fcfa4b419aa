//! The worlds that come with the program: they lie in it, and in a folder of the user's once one is opened, as files to change.

use crate::formats::{self, file};
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

/// Writes what is not there yet of the worlds into a folder of the user's, and returns the path of one of them. What the user has changed
/// there stays.
///
/// # Errors
/// When the folder can't be written to.
pub fn unpack(world: &World, folder: &Path) -> Result<PathBuf, formats::Error> {
    let folder = folder.join("worlds");
    for (path, bytes) in FILES {
        let path = folder.join(path);
        if !path.exists() {
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)
                    .map_err(|source| formats::Error::Write { path: parent.into(), source })?;
            }
            file::replace_keeping(&path, None, |out| out.write_all(bytes))?;
        }
    }
    Ok(folder.join(world.path))
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
}
