//! What the viewer remembers from run to run: where its window stood, which worlds were open, which panels are shown, and
//! places to come back to.

use crate::formats::{self, file};
use etcetera::BaseStrategy;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf, absolute};

/// Longer files are none of ours.
const MAX_BYTES: usize = 1 << 20;
/// Recent worlds that are kept.
const MOST_RECENT: usize = 10;
/// Worlds whose bookmarks are kept, and bookmarks of a world.
const MOST_BOOKMARKS: usize = 100;

const NAME: &str = "viewer.json";

/// Where the viewer keeps what outlives it: the folder that `TERRANE_STATE` names, or the user's folder for such things. `None` where
/// there is none.
pub fn folder() -> Option<PathBuf> {
    let named = env::var_os("TERRANE_STATE").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    named.or_else(|| {
        let strategy = etcetera::choose_base_strategy().ok()?;
        Some(strategy.state_dir().unwrap_or_else(|| strategy.data_dir()).join("terrane"))
    })
}

/// Makes that folder with those above it.
pub fn make(folder: &Path) -> Result<(), formats::Error> {
    fs::create_dir_all(folder).map_err(|source| formats::Error::Write { path: folder.into(), source })
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct State {
    pub window: Option<Window>,
    /// Worlds that were open, the last one first: whole paths.
    recent: Vec<PathBuf>,
    /// How frames are paced, by [`Pacing::name`](crate::gpu::Pacing::name), once the user has said so.
    pub pacing: Option<String>,
    /// Whether a panel is shown, by its name, once the user has said so.
    pub panels: BTreeMap<String, bool>,
    bookmarks: BTreeMap<PathBuf, Vec<Bookmark>>,
}

/// Where the window stood, in points of its screen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Window {
    pub size: [u32; 2],
    /// Of its upper left corner; not every system tells.
    pub position: Option<[i32; 2]>,
    pub maximised: bool,
}

/// A place to come back to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    pub name: String,
    pub view: View,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum View {
    /// Metres east, up and south of the middle of the terrain; turned clockwise, radians.
    Land {
        position: [f32; 3],
        target: [f32; 3],
        #[serde(default)]
        roll: f32,
    },
    /// The code of a place in an endless zoom.
    Zoom { code: String },
}

/// A world that was open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recent<'a> {
    pub path: &'a Path,
    /// Whether it is still there.
    pub exists: bool,
}

impl State {
    /// What an earlier run has left in the folder, and a sentence if that can't be used: the viewer then begins anew.
    pub fn load(folder: &Path) -> (State, Option<String>) {
        let path = folder.join(NAME);
        if !path.exists() {
            return (State::default(), None);
        }
        let read = formats::read_bytes(&path, MAX_BYTES).map_err(|error| error.to_string());
        let parsed = read.and_then(|bytes| {
            serde_json::from_slice::<State>(&bytes).map_err(|error| {
                format!("{} is damaged ({error}): windows and recent worlds are forgotten", path.display())
            })
        });
        match parsed {
            Ok(state) => (state.sane(), None),
            Err(warning) => (State::default(), Some(warning)),
        }
    }

    /// Keeps it for the next run.
    ///
    /// # Errors
    /// When the folder can't be made or written to.
    pub fn save(&self, folder: &Path) -> Result<(), formats::Error> {
        make(folder)?;
        let text = serde_json::to_vec_pretty(self).unwrap_or_default();
        file::replace_keeping(&folder.join(NAME), None, |out| out.write_all(&text))
    }

    /// Without what no run would have written.
    fn sane(mut self) -> State {
        self.window =
            self.window.filter(|window| window.size.iter().all(|side| (64..=65_535).contains(side)));
        self.recent.truncate(MOST_RECENT);
        self.bookmarks.values_mut().for_each(|bookmarks| bookmarks.truncate(MOST_BOOKMARKS));
        while self.bookmarks.len() > MOST_BOOKMARKS {
            self.bookmarks.pop_first();
        }
        self
    }

    /// Worlds that were open, the last one first.
    pub fn recent(&self) -> impl Iterator<Item = Recent<'_>> {
        self.recent.iter().map(|path| Recent { path, exists: path.exists() })
    }

    /// Notes that a world was opened.
    pub fn opened(&mut self, path: &Path) {
        let path = whole(path);
        self.recent.retain(|other| *other != path);
        self.recent.insert(0, path);
        self.recent.truncate(MOST_RECENT);
    }

    /// Takes a world off the list of those that were open.
    pub fn forget(&mut self, path: &Path) {
        self.recent.retain(|other| other != path);
    }

    /// The places to come back to in a world.
    pub fn bookmarks(&self, world: &Path) -> &[Bookmark] {
        self.bookmarks.get(&whole(world)).map(Vec::as_slice).unwrap_or_default()
    }

    /// Remembers a place; one of the same name is forgotten.
    pub fn bookmark(&mut self, world: &Path, bookmark: Bookmark) {
        let bookmarks = self.bookmarks.entry(whole(world)).or_default();
        bookmarks.retain(|other| other.name != bookmark.name);
        if bookmarks.len() < MOST_BOOKMARKS {
            bookmarks.push(bookmark);
        }
    }

    pub fn remove_bookmark(&mut self, world: &Path, name: &str) {
        let path = whole(world);
        if let Some(bookmarks) = self.bookmarks.get_mut(&path) {
            bookmarks.retain(|bookmark| bookmark.name != name);
            if bookmarks.is_empty() {
                self.bookmarks.remove(&path);
            }
        }
    }
}

/// The same file, whatever folder a run was started in.
fn whole(path: &Path) -> PathBuf {
    fs::canonicalize(path).or_else(|_| absolute(path)).unwrap_or_else(|_| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path().join("deep/below");
        assert_eq!(State::load(&folder), (State::default(), None));
        let mut state = State {
            window: Some(Window { size: [1280, 720], position: Some([-5, 7]), maximised: true }),
            ..State::default()
        };
        state.panels.insert("timings".into(), true);
        state.opened(&folder.join("gone.toml"));
        let view = View::Land { position: [1.0, 2.5, -3.0], target: [0.0; 3], roll: 0.5 };
        state.bookmark(&folder.join("gone.toml"), Bookmark { name: "beach".into(), view });
        state.bookmark(
            &folder.join("z.toml"),
            Bookmark { name: "x".into(), view: View::Zoom { code: "0a".into() } },
        );
        state.save(&folder).expect("it can be written");
        assert_eq!(State::load(&folder), (state.clone(), None));
        assert!(state.recent().all(|recent| !recent.exists));
        assert_eq!(state.bookmarks(&folder.join("gone.toml")).len(), 1);
        state.remove_bookmark(&folder.join("gone.toml"), "beach");
        assert!(state.bookmarks(&folder.join("gone.toml")).is_empty());
    }

    #[test]
    fn damage_is_told_and_forgotten() {
        let folder = tempfile::tempdir().expect("a folder");
        for damaged in ["", "{", "7", "{\"recent\": 3}", "\u{0}\u{1}"] {
            fs::write(folder.path().join(NAME), damaged).expect("it can be written");
            let (state, warning) = State::load(folder.path());
            assert_eq!(state, State::default(), "{damaged}");
            assert!(warning.is_some_and(|warning| warning.contains(NAME)), "{damaged}");
        }
        let odd = r#"{"window": {"size": [0, 7], "position": null, "maximised": false}, "new key": 1}"#;
        fs::write(folder.path().join(NAME), odd).expect("it can be written");
        assert_eq!(State::load(folder.path()), (State::default(), None));
    }

    #[test]
    fn recent_worlds_are_ten_and_differ() {
        let mut state = State::default();
        (0..12).for_each(|number| state.opened(Path::new(&format!("/nowhere/{number}.toml"))));
        state.opened(Path::new("/nowhere/7.toml"));
        let names: Vec<_> = state.recent().filter_map(|recent| recent.path.file_stem()?.to_str()).collect();
        assert_eq!(names, ["7", "11", "10", "9", "8", "6", "5", "4", "3", "2"]);
        state.forget(Path::new("/nowhere/9.toml"));
        assert_eq!(state.recent().count(), 9);
    }
}
