//! The world that is edited: the text of its file, the world that it makes, and what was changed.
//!
//! Whatever is done, the text is one that makes a world: an edit that would make none is refused and told.

use crate::formats::{self, file};
use crate::world::schema::{Shape, Table};
use crate::world::{self, Edit, KeyPath, MAX_BYTES, Overrides, World};
use std::collections::VecDeque;
use std::io::Write;
use std::path::{Component, Path, PathBuf, absolute};
use std::sync::Arc;
use toml_edit::{DocumentMut, Item, Value};

/// Most steps that can be undone, and bytes that they take.
const MOST_STEPS: usize = 1000;
const MOST_STEP_BYTES: usize = 64 << 20;

/// A world file that is open.
pub struct Document {
    /// What was opened: a file, or a folder of settings.
    source: PathBuf,
    /// The file that it is saved to, once there is one.
    path: Option<PathBuf>,
    /// Files that the world names are looked for from here.
    folder: PathBuf,
    text: String,
    world: Arc<World>,
    /// The text that needs no saving.
    clean: String,
    /// There is no file any more.
    gone: bool,
    /// What the file holds, as far as is known.
    on_disk: Option<String>,
    undo: VecDeque<Step>,
    redo: Vec<Step>,
    /// The key that is being dragged: more changes of it belong to the same step.
    held: Option<KeyPath>,
    refused: Option<Refusal>,
}

/// A change that can be taken back, or done again.
struct Step {
    /// What it changed, for people.
    what: String,
    /// The text on its other side, and the folder that files in it are named from.
    text: String,
    folder: PathBuf,
}

/// An edit that would have made no world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The key that was to be changed; none where the whole file was.
    pub path: Option<KeyPath>,
    /// One line.
    pub message: String,
    /// Everything that is wrong, with its places.
    pub report: String,
}

/// Why a world could not be opened, read again or saved.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    World(#[from] world::Error),
    #[error(transparent)]
    File(#[from] formats::Error),
    /// It was never in a file of its own.
    #[error("{} is no world file; save it as one", .0.display())]
    NoFile(PathBuf),
    /// Somebody else wrote to the file.
    #[error("{} has changed since it was read; read it again, save under another name, or overwrite it", .0.display())]
    Changed(PathBuf),
}

/// What became of the file meanwhile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnDisk {
    #[default]
    Same,
    Changed,
    Gone,
}

impl Document {
    /// Reads a world file, or a folder of settings, which is then to be saved as a file. What `overrides` change is part of what
    /// is opened, and no edit.
    ///
    /// # Errors
    /// When it can't be read, or makes no world.
    pub fn open(path: &Path, overrides: &Overrides) -> Result<Document, Error> {
        let world = world::load(path, overrides)?;
        let is_folder = path.is_dir();
        let folder = if is_folder { path } else { path.parent().unwrap_or(Path::new("")) };
        let on_disk = if is_folder { None } else { read(path).ok() };
        Ok(Document::new(path, (!is_folder).then(|| path.into()), folder, world, on_disk))
    }

    /// A world that is in no file. Messages call it `name`; files that it names are looked for from `folder`.
    ///
    /// # Errors
    /// When the text makes no world.
    pub fn untitled(name: &str, text: &str, folder: &Path) -> Result<Document, Error> {
        let world = world::parse(name, text.as_bytes(), folder, &Overrides::default())?;
        Ok(Document::new(Path::new(name), None, folder, world, None))
    }

    fn new(
        source: &Path,
        path: Option<PathBuf>,
        folder: &Path,
        world: World,
        on_disk: Option<String>,
    ) -> Document {
        let text = world.document.to_string();
        Document {
            source: source.into(),
            path,
            folder: folder.into(),
            clean: text.clone(),
            gone: false,
            text,
            world: Arc::new(world),
            on_disk,
            undo: VecDeque::new(),
            redo: Vec::new(),
            held: None,
            refused: None,
        }
    }

    /// What an earlier run left unsaved, as a change of the file as it is now.
    ///
    /// # Errors
    /// When it makes no world any more: files that it names may be gone.
    pub fn recovered(
        source: &Path,
        path: Option<&Path>,
        folder: &Path,
        text: &str,
    ) -> Result<Document, Error> {
        let name = source.display().to_string();
        let world = world::parse(&name, text.as_bytes(), folder, &Overrides::default())?;
        let on_disk = path.and_then(|path| read(path).ok());
        let mut document = Document::new(source, path.map(PathBuf::from), folder, world, on_disk);
        document.clean = document.on_disk.clone().unwrap_or_default();
        if !document.clean.is_empty() {
            let before = Step::new("all that was not saved", &document.clean, folder);
            document.undo.push_back(before);
        }
        Ok(document)
    }

    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// The file, parsed.
    pub fn item(&self) -> &Item {
        self.world.document.as_item()
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// What was opened: a file, or a folder of settings.
    pub fn source(&self) -> &Path {
        &self.source
    }

    /// The file that it is saved to, if there is one yet.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The folder that files which the world names are looked for from.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The last edit, if it was refused.
    pub fn refused(&self) -> Option<&Refusal> {
        self.refused.as_ref()
    }

    /// The file is as it was: what was wrong with it is mended.
    pub fn note_same(&mut self) {
        self.refused.take_if(|refused| refused.path.is_none());
    }

    pub fn forget_refusal(&mut self) {
        self.refused = None;
    }

    /// Whether there is anything to save.
    pub fn is_dirty(&self) -> bool {
        self.gone || self.text != self.clean
    }

    // Editing --------------------------------------------------------------------------------------------------------

    /// Changes the world, and says whether it did: what would make no world is refused, and told by
    /// [`Document::refused`]. Values of one key that follow each other are one step, until [`Document::settle`].
    pub fn edit(&mut self, edit: &Edit) -> bool {
        let mut document = self.world.document.clone();
        let edited = edit.apply(&mut document).map(|()| document.to_string());
        let (text, world) =
            match edited.and_then(|text| Ok((self.parse(text.as_bytes(), &self.folder)?, text))) {
                Ok((world, text)) => (text, world),
                Err(error) => {
                    self.refuse(Some(edit.path().clone()), &error);
                    return false;
                }
            };
        self.refused = None;
        if text == self.text {
            return false;
        }
        let held = if let Edit::Set(path, _) = edit { Some(path.clone()) } else { None };
        if held.is_none() || held != self.held {
            self.push_undo(name(edit));
        }
        self.held = held;
        self.redo.clear();
        self.text = text;
        self.world = Arc::new(world);
        true
    }

    /// Writes a value: see [`Document::edit`].
    pub fn set(&mut self, path: &KeyPath, value: Value) -> bool {
        self.edit(&Edit::Set(path.clone(), value))
    }

    /// Leaves a key to its default: see [`Document::edit`].
    #[cfg(test)]
    pub fn remove(&mut self, path: &KeyPath) -> bool {
        self.edit(&Edit::Remove(path.clone()))
    }

    /// Ends a step: a drag is over.
    pub fn settle(&mut self) {
        self.held = None;
    }

    /// What [`Document::undo`] would take back.
    pub fn undo_name(&self) -> Option<&str> {
        self.undo.back().map(|step| step.what.as_str())
    }

    /// What [`Document::redo`] would do again.
    pub fn redo_name(&self) -> Option<&str> {
        self.redo.last().map(|step| step.what.as_str())
    }

    /// Takes the last step back, and says whether it did.
    pub fn undo(&mut self) -> bool {
        let Some(step) = self.undo.pop_back() else { return false };
        match self.take(&step) {
            Some(other) => self.redo.push(other),
            None => self.undo.push_back(step),
        }
        self.refused.is_none()
    }

    /// Does again what was taken back, and says whether it did.
    pub fn redo(&mut self) -> bool {
        let Some(step) = self.redo.pop() else { return false };
        match self.take(&step) {
            Some(other) => self.undo.push_back(other),
            None => self.redo.push(step),
        }
        self.refused.is_none()
    }

    /// Takes the text of a step, and gives the step that leads back. `None` where it makes no world any more: files
    /// that it names are gone.
    fn take(&mut self, step: &Step) -> Option<Step> {
        self.held = None;
        let text = relocated(&step.text, &step.folder, &self.folder);
        match self.parse(text.as_bytes(), &self.folder) {
            Ok(world) => {
                self.refused = None;
                let back = Step::new(&step.what, &self.text, &self.folder);
                self.text = text;
                self.world = Arc::new(world);
                Some(back)
            }
            Err(error) => {
                self.refuse(None, &error);
                None
            }
        }
    }

    fn push_undo(&mut self, what: String) {
        self.undo.push_back(Step::new(&what, &self.text, &self.folder));
        let bytes = |steps: &VecDeque<Step>| steps.iter().map(|step| step.text.len()).sum::<usize>();
        while self.undo.len() > MOST_STEPS || (self.undo.len() > 1 && bytes(&self.undo) > MOST_STEP_BYTES) {
            self.undo.pop_front();
        }
    }

    fn refuse(&mut self, path: Option<KeyPath>, error: &world::Error) {
        let report = error.to_string();
        self.refused = Some(Refusal { path, message: in_a_line(&report), report });
    }

    /// The world that a text makes. What its folder alone knows stays.
    fn parse(&self, text: &[u8], folder: &Path) -> Result<World, world::Error> {
        let source = self.path.as_ref().unwrap_or(&self.source);
        let world = world::parse(&source.display().to_string(), text, folder, &Overrides::default())?;
        match self.path {
            Some(_) => Ok(world),
            None => Ok(World { name: self.world.name.clone(), photo: self.world.photo.clone(), ..world }),
        }
    }

    // Files ----------------------------------------------------------------------------------------------------------

    /// Whether somebody else has changed the file since it was read or saved.
    pub fn on_disk(&self) -> OnDisk {
        let Some(path) = &self.path else { return OnDisk::Same };
        match read(path) {
            Ok(text) if Some(&text) == self.on_disk.as_ref() => OnDisk::Same,
            Ok(_) => OnDisk::Changed,
            Err(_) if path.exists() => OnDisk::Changed,
            Err(_) => OnDisk::Gone,
        }
    }

    /// Whether the file says what is shown.
    pub fn is_on_disk(&self) -> bool {
        self.path.as_ref().is_some_and(|path| read(path).is_ok_and(|text| text == self.text))
    }

    /// Takes in whether the file is gone: then all of the world is yet to be saved.
    pub fn note_gone(&mut self, gone: bool) {
        self.gone = gone;
    }

    /// Reads the file again, as a step that can be undone, and says whether anything is new.
    ///
    /// # Errors
    /// When it can't be read, or makes no world ([`Document::refused`] tells that, too): the old one stays.
    pub fn reload(&mut self) -> Result<bool, Error> {
        let Some(path) = self.path.clone() else { return Err(Error::NoFile(self.source.clone())) };
        let bytes = formats::read_bytes(&path, MAX_BYTES)?;
        if Some(bytes.as_slice()) == self.on_disk.as_ref().map(String::as_bytes) {
            self.note_same();
            return Ok(false);
        }
        let world = match self.parse(&bytes, &self.folder) {
            Ok(world) => world,
            Err(error) => {
                self.refuse(None, &error);
                if let Some(Refusal { message, .. }) = &mut self.refused {
                    *message = format!("{} on disk is not taken: {message}", self.world.name);
                }
                return Err(error.into());
            }
        };
        let text = String::from_utf8_lossy(&bytes).into_owned();
        self.held = None;
        self.refused = None;
        self.on_disk = Some(text.clone());
        self.clean = text.clone();
        if text == self.text {
            return Ok(false);
        }
        self.push_undo("the file on disk".into());
        self.redo.clear();
        self.text = text;
        self.world = Arc::new(world);
        Ok(true)
    }

    /// Writes the file.
    ///
    /// # Errors
    /// When there is none, somebody else has changed it, or it can't be written.
    pub fn save(&mut self) -> Result<(), Error> {
        let Some(path) = self.path.clone() else { return Err(Error::NoFile(self.source.clone())) };
        if self.on_disk() == OnDisk::Changed {
            return Err(Error::Changed(path));
        }
        self.overwrite()
    }

    /// Writes the file, whoever has changed it.
    ///
    /// # Errors
    /// When there is none, or it can't be written.
    pub fn overwrite(&mut self) -> Result<(), Error> {
        let Some(path) = self.path.clone() else { return Err(Error::NoFile(self.source.clone())) };
        write(&path, &self.text)?;
        self.saved();
        Ok(())
    }

    /// Writes another file, which is the one that is edited from now on. Files that the world names get the names that they have
    /// from there.
    ///
    /// # Errors
    /// When it can't be written.
    pub fn save_as(&mut self, path: &Path) -> Result<(), Error> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let text = relocated(&self.text, &self.folder, folder);
        let name = path.display().to_string();
        let world = world::parse(&name, text.as_bytes(), folder, &Overrides::default())?;
        write(path, &text)?;
        self.path = Some(path.into());
        self.source = path.into();
        self.folder = folder.into();
        self.text = text;
        self.world = Arc::new(World { photo: self.world.photo.clone(), ..world });
        self.saved();
        Ok(())
    }

    fn saved(&mut self) {
        (self.held, self.gone) = (None, false);
        self.clean = self.text.clone();
        self.on_disk = Some(self.text.clone());
    }
}

impl Step {
    fn new(what: &str, text: &str, folder: &Path) -> Step {
        Step { what: what.into(), text: text.into(), folder: folder.into() }
    }
}

/// What an edit does, for a menu: "undo …".
fn name(edit: &Edit) -> String {
    match edit {
        Edit::Set(path, _) => path.to_string(),
        Edit::Remove(path) => format!("reset of {path}"),
        Edit::Insert(path, _) => format!("new {path}"),
        Edit::Move { list, .. } => format!("order of {list}"),
        Edit::Rename(path, name) => format!("{path} as {name}"),
    }
}

/// A report's first sentence, with what is allowed.
fn in_a_line(report: &str) -> String {
    let title = report.lines().next().unwrap_or_default();
    // Beside the caret stands what is allowed.
    let below = |line: &str| {
        let (before, label) = line.split_once('^')?;
        let is_caret = before.trim() == "|";
        is_caret.then(|| label.trim_start_matches('^').trim().to_string())
    };
    match report.lines().find_map(below).filter(|label| !label.is_empty()) {
        Some(label) => format!("{title}: {label}"),
        None => title.into(),
    }
}

fn read(path: &Path) -> Result<String, formats::Error> {
    let bytes = formats::read_bytes(path, MAX_BYTES)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn write(path: &Path, text: &str) -> Result<(), formats::Error> {
    file::replace_keeping(path, None, |out| out.write_all(text.as_bytes()))
}

// Names of files -----------------------------------------------------------------------------------------------------

/// A world's text, whose files were named from the folder `from`, with their names from the folder `to`.
fn relocated(text: &str, from: &Path, to: &Path) -> String {
    let (from, to) = (whole(from), whole(to));
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text.into() };
    if from == to {
        return text.into();
    }
    let mut files = Vec::new();
    files_of_table(document.as_item(), &world::shape(), &KeyPath::default(), &mut files);
    for (path, file) in files.into_iter().filter(|(_, file)| Path::new(file).is_relative()) {
        let file = name_from(&to, &from.join(file));
        // What is written can be written again.
        let _ = Edit::Set(path, file.into()).apply(&mut document);
    }
    let text = document.to_string();
    // The first line of a world may tell editors where the schema lies.
    let Some((schema, rest)) = text.strip_prefix("#:schema ").and_then(|text| text.split_once('\n')) else {
        return text;
    };
    let file = from.join(schema.trim());
    if file.is_file() { format!("#:schema {}\n{rest}", name_from(&to, &file)) } else { text }
}

/// The files that are named in an item of this shape.
fn files(item: &Item, shape: &Shape, path: &KeyPath, found: &mut Vec<(KeyPath, String)>) {
    match shape {
        Shape::File => found.extend(item.as_str().map(|file| (path.clone(), file.to_string()))),
        Shape::OrWord(_, [word, _]) if item.as_str() == Some(word) => {}
        Shape::OrWord(inner, _) => files(item, inner, path, found),
        Shape::Table(table) => files_of_table(item, table, path, found),
        Shape::OneOf(alternatives) => {
            for alternative in alternatives {
                let (Some(inner), Some(table)) = (item.get(alternative.name), &alternative.table) else {
                    continue;
                };
                files_of_table(inner, table, &path.join(alternative.name), found);
            }
        }
        Shape::List { element, .. } => {
            for (index, inner) in (0..).map_while(|index: usize| Some((index, item.get(index)?))) {
                files(inner, element, &path.join(index), found);
            }
        }
        Shape::Named { element, .. } => {
            for (name, inner) in item.as_table_like().into_iter().flat_map(|table| table.iter()) {
                files(inner, element, &path.join(name), found);
            }
        }
        _ => {}
    }
}

fn files_of_table(item: &Item, table: &Table, path: &KeyPath, found: &mut Vec<(KeyPath, String)>) {
    for key in &table.keys {
        if let Some(inner) = item.get(key.name) {
            files(inner, &key.shape, &path.join(key.name), found);
        }
    }
}

/// The whole path of a folder, without detours.
fn whole(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::fs::canonicalize(folder).or_else(|_| absolute(folder)).unwrap_or_else(|_| folder.into())
}

/// The name of a file from a folder, both whole, with `/` on every system.
pub fn name_from(folder: &Path, file: &Path) -> String {
    let file = match (file.parent(), file.file_name()) {
        (Some(parent), Some(name)) => whole(parent).join(name),
        _ => file.into(),
    };
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return file.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    let names = up.chain(file.components().skip(common));
    names.map(|name| name.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const TEXT: &str = "# An island.\nformat = 1\nseed = 2 # another\n\n[sea]\nlevel = 100 # metres\n";

    fn document() -> (tempfile::TempDir, Document) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("island.toml");
        fs::write(&path, TEXT).expect("it can be written");
        let document = Document::open(&path, &Overrides::default()).expect("a world");
        (folder, document)
    }

    fn value(text: &str) -> Value {
        text.parse().expect("a value")
    }

    #[test]
    fn edits_keep_comments_and_change_the_world() {
        let (_folder, mut document) = document();
        assert!(!document.is_dirty());
        assert!(document.set(&"sea.level".into(), value("120")));
        assert!(document.set(&"terrain.cells".into(), value("256")));
        assert_eq!((document.world().sea.level, document.world().plan.grid.cells), (120.0, 256));
        assert!(document.text().starts_with(&TEXT.replace("100", "120")), "{}", document.text());
        assert!(document.is_dirty());
        assert!(document.remove(&"terrain.cells".into()));
        assert_eq!(document.world().plan.grid.cells, 512);
    }

    #[test]
    fn what_makes_no_world_is_refused() {
        let (_folder, mut document) = document();
        assert!(!document.set(&"sea.level".into(), value("\"high\"")));
        let refused = document.refused().cloned().expect("a refusal");
        assert_eq!(refused.path, Some("sea.level".into()));
        assert!(refused.message.starts_with("`sea.level` must be a number"), "{}", refused.message);
        assert!(refused.message.contains("allowed:"), "{}", refused.message);
        assert!(!refused.message.contains('\n'));
        assert_eq!((document.text(), document.world().sea.level), (TEXT, 100.0));
        assert_eq!((document.undo_name(), document.is_dirty()), (None, false));
        assert!(document.set(&"sea.level".into(), value("101")));
        assert_eq!(document.refused(), None);
    }

    #[test]
    fn a_report_in_a_line() {
        let report = "`grammar` can't grow: it is too long\n --> w.toml:3:1\n  |\n3 | F -> F^F\n  |      ^^^ this rule\n  |\n";
        assert_eq!(in_a_line(report), "`grammar` can't grow: it is too long: this rule");
        assert_eq!(in_a_line("no such file"), "no such file");
    }

    #[test]
    fn a_drag_is_one_step() {
        let (_folder, mut document) = document();
        for level in 101..120 {
            assert!(document.set(&"sea.level".into(), level.into()));
        }
        document.settle();
        assert!(document.set(&"sea.level".into(), value("150")));
        assert!(document.set(&"seed".into(), value("3")));
        assert_eq!(document.undo_name(), Some("seed"));
        assert!(document.undo());
        assert_eq!((document.undo_name(), document.redo_name()), (Some("sea.level"), Some("seed")));
        assert!(document.undo());
        assert_eq!(document.world().sea.level, 119.0);
        assert!(document.undo());
        assert_eq!((document.text(), document.is_dirty()), (TEXT, false));
        assert!(!document.undo());
        assert!(document.redo() && document.redo() && document.redo() && !document.redo());
        assert_eq!((document.world().sea.level, document.world().seed), (150.0, 3));
        assert!(document.undo() && document.set(&"seed".into(), value("9")));
        assert_eq!(document.redo_name(), None);
    }

    #[test]
    fn nothing_new_is_no_step() {
        let (_folder, mut document) = document();
        assert!(!document.set(&"sea.level".into(), value("100")));
        assert!(!document.remove(&"sea.roughness".into()));
        assert_eq!((document.undo_name(), document.refused()), (None, None));
    }

    #[test]
    fn saving_is_safe() {
        let (folder, mut document) = document();
        let path = folder.path().join("island.toml");
        document.set(&"seed".into(), value("5"));
        document.save().expect("it can be saved");
        assert_eq!(fs::read_to_string(&path).expect("text"), TEXT.replace("seed = 2", "seed = 5"));
        assert!(!document.is_dirty() && document.on_disk() == OnDisk::Same);
        // Undone, it differs from the file again.
        assert!(document.undo() && document.is_dirty() && document.redo() && !document.is_dirty());

        fs::write(&path, TEXT.replace("100", "90")).expect("it can be written");
        document.set(&"seed".into(), value("6"));
        assert_eq!(document.on_disk(), OnDisk::Changed);
        assert!(matches!(document.save(), Err(Error::Changed(_))));
        document.overwrite().expect("it can be overwritten");
        assert_eq!(document.on_disk(), OnDisk::Same);
        fs::remove_file(&path).expect("it goes");
        assert_eq!(document.on_disk(), OnDisk::Gone);
        document.save().expect("it comes back");
    }

    #[test]
    fn a_changed_file_is_read_again() {
        let (folder, mut document) = document();
        let path = folder.path().join("island.toml");
        assert!(!document.reload().expect("it is the same"));
        document.set(&"seed".into(), value("5"));
        fs::write(&path, TEXT.replace("100", "90")).expect("it can be written");
        assert!(document.reload().expect("it is a world"));
        assert_eq!(
            (document.world().sea.level, document.world().seed, document.is_dirty()),
            (90.0, 2, false)
        );
        // What had not been saved is a step away.
        assert!(document.undo());
        assert_eq!((document.world().seed, document.is_dirty()), (5, true));
        fs::write(&path, "format = 1\nsea = 3\n").expect("it can be written");
        assert!(document.reload().is_err());
        assert!(document.refused().is_some_and(|refused| refused.message.contains("`sea` must be a table")));
        assert_eq!(document.world().seed, 5);
        assert!(document.refused().is_some_and(|refused| refused.message.contains("on disk")));
        fs::write(&path, [TEXT.as_bytes(), b"# \xff"].concat()).expect("it can be written");
        assert!(document.reload().is_err());
        // Mended, there is nothing to complain of.
        fs::write(&path, TEXT.replace("100", "90")).expect("it can be written");
        assert!(!document.reload().expect("it is as it was"));
        assert_eq!(document.refused(), None);
    }

    #[test]
    fn overrides_are_no_edits() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("island.toml");
        fs::write(&path, TEXT).expect("it can be written");
        let overrides = Overrides { set: vec!["sea.level=7".into()], seed: None };
        let mut document = Document::open(&path, &overrides).expect("a world");
        assert_eq!((document.world().sea.level, document.is_dirty()), (7.0, false));
        document.save().expect("it can be saved");
        assert!(fs::read_to_string(&path).expect("text").contains("level = 7 # metres"));
    }

    #[test]
    fn saved_elsewhere_a_world_finds_its_files() {
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let mut document =
            Document::open(&configs.join("forest/default.toml"), &Overrides::default()).expect("a world");
        assert!(document.set(&"seed".into(), value("5")));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("copy.toml");
        document.save_as(&path).expect("it can be saved");
        assert_eq!((document.path(), document.world().name.as_str()), (Some(path.as_path()), "copy"));
        let text = fs::read_to_string(&path).expect("text");
        assert!(!text.contains("\"meadow.png\"") && text.contains("forest/meadow.png"), "{text}");
        assert!(text.contains("configs/worlds.schema.json\n"), "{text}");
        let again = Document::open(&path, &Overrides::default()).expect("a world");
        assert_eq!(again.world().plants.species.len(), document.world().plants.species.len());
        // What was done before can still be undone.
        assert!(document.undo(), "{:?}", document.refused());
        assert_eq!(document.world().seed, 7);
        assert!(document.redo() && !document.is_dirty());
    }

    #[test]
    fn names_from_folders() {
        for (folder, file, name) in [
            ("/a/b", "/a/b/c.png", "c.png"),
            ("/a/b", "/a/c/d.png", "../c/d.png"),
            ("/a/b/c", "/x.png", "../../../x.png"),
            ("/", "/a/x.png", "a/x.png"),
        ] {
            assert_eq!(name_from(Path::new(folder), Path::new(file)), name);
        }
    }

    #[test]
    fn a_folder_of_settings_is_saved_as_a_file() {
        let settings = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/thesis");
        let folder = fs::read_dir(settings).expect("folders").flatten().map(|found| found.path());
        let Some(folder) = folder.filter(|path| path.is_dir()).min() else { panic!("no folder of settings") };
        let mut document = Document::open(&folder, &Overrides::default()).expect("a world");
        let name = document.world().name.clone();
        assert!(matches!(document.save(), Err(Error::NoFile(_))));
        assert!(document.set(&"seed".into(), value("77")), "{:?}", document.refused());
        assert_eq!(document.world().name, name);
        let to = tempfile::tempdir().expect("a folder");
        document.save_as(&to.path().join("w.toml")).expect("it can be saved");
        assert!(!document.is_dirty() && document.world().name == "w");
    }

    /// Tells how long that takes, with `--nocapture`.
    #[test]
    fn every_shipped_world_can_be_edited() {
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        for kind in ["island", "forest", "landscape", "zoom"] {
            for path in fs::read_dir(configs.join(kind)).expect("worlds").flatten().map(|found| found.path())
            {
                if path.extension().is_none_or(|extension| extension != "toml") {
                    continue;
                }
                let mut document = Document::open(&path, &Overrides::default()).expect("a world");
                let start = std::time::Instant::now();
                for seed in 100..110 {
                    assert!(document.set(&"seed".into(), seed.into()), "{:?}", document.refused());
                }
                println!("{}: {:.2} ms an edit", path.display(), start.elapsed().as_secs_f64() * 100.0);
            }
        }
    }
}
