//! What was edited and not saved, kept in a file of its own: nothing is lost when the device, the program or the machine goes.
//!
//! A viewer that runs holds a lock beside its file. So a file whose lock is free was left by one that has gone.

use super::document::{Document, Error};
use super::state;
use crate::formats::{self, file};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// What is lost at most when the program is killed.
const INTERVAL: Duration = Duration::from_secs(1);
/// Longer files are none of ours: a world has a mebibyte, and half of it may need escapes.
const MAX_BYTES: usize = 8 << 20;

/// Keeps what is not saved of one document at a time.
pub struct Keeper {
    folder: PathBuf,
    slot: Option<Slot>,
    /// When the file was last written.
    last: Option<Instant>,
    /// The text that it holds.
    kept: Option<String>,
}

/// The file of this viewer, and its lock.
struct Slot {
    path: PathBuf,
    lock_path: PathBuf,
    /// Held while the viewer lives.
    _lock: File,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    source: PathBuf,
    path: Option<PathBuf>,
    folder: PathBuf,
    /// Seconds since 1970.
    time: u64,
    text: String,
}

impl Keeper {
    /// `folder` is [`state::folder`]. Nothing is written before there is something to keep.
    pub fn new(folder: &Path) -> Keeper {
        Keeper { folder: recovery(folder), slot: None, last: None, kept: None }
    }

    /// Keeps the document if it changed and it is time; forgets it once there is nothing to save. To be called in every frame;
    /// says when to call again at the latest, if nothing else happens.
    ///
    /// # Errors
    /// When the file can't be written.
    pub fn watch(&mut self, document: &Document, now: Instant) -> Result<Option<Duration>, formats::Error> {
        if !document.is_dirty() {
            self.forget();
            return Ok(None);
        }
        if self.kept.as_deref() == Some(document.text()) {
            return Ok(None);
        }
        let since = self.last.map(|last| now.saturating_duration_since(last));
        match since {
            Some(since) if since < INTERVAL => Ok(Some(INTERVAL - since)),
            _ => self.keep(document).map(|()| None),
        }
    }

    /// Keeps the document at once, if there is anything to save: the device was lost, or the program is about to end.
    ///
    /// # Errors
    /// When the file can't be written.
    pub fn keep(&mut self, document: &Document) -> Result<(), formats::Error> {
        if !document.is_dirty() {
            self.forget();
            return Ok(());
        }
        self.last = Some(Instant::now());
        let slot = match &self.slot {
            Some(slot) => slot,
            None => self.slot.insert(Slot::new(&self.folder)?),
        };
        let kept = Kept {
            source: absolute(document.source()),
            path: document.path().map(absolute),
            folder: absolute(document.folder()),
            time: SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs(),
            text: document.text().into(),
        };
        let text = serde_json::to_vec(&kept).unwrap_or_default();
        file::replace_keeping(&slot.path, None, |out| out.write_all(&text))?;
        self.kept = Some(kept.text);
        Ok(())
    }

    /// Removes the file: all is saved, or the user wants none of it.
    pub fn forget(&mut self) {
        self.kept = None;
        if let Some(slot) = self.slot.take() {
            // What can't be removed is offered once more.
            let _ = fs::remove_file(&slot.path);
        }
    }
}

impl Slot {
    fn new(folder: &Path) -> Result<Slot, formats::Error> {
        static COUNTER: AtomicU32 = AtomicU32::new(0);

        state::make(folder)?;
        loop {
            let time = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
            let number = COUNTER.fetch_add(1, Ordering::Relaxed);
            let name = format!("{time:x}-{:x}-{number:x}", std::process::id());
            let lock_path = folder.join(format!("{name}.lock"));
            let failed = |source| formats::Error::Write { path: lock_path.clone(), source };
            match File::create_new(&lock_path) {
                Ok(lock) => {
                    // Where files can't be locked, files that were left are offered while their viewer runs; no harm is done.
                    let _ = lock.try_lock();
                    return Ok(Slot { path: folder.join(format!("{name}.json")), lock_path, _lock: lock });
                }
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(error)),
            }
        }
    }
}

impl Drop for Slot {
    /// What is not saved when the viewer ends, in whatever way, stays for the next start.
    fn drop(&mut self) {
        // Nobody is left to tell.
        let _ = fs::remove_file(&self.lock_path);
    }
}

/// What a viewer that has gone left unsaved.
pub struct Pending {
    file: PathBuf,
    kept: Kept,
}

/// All that viewers which have gone left unsaved, the last one first. `folder` is [`state::folder`].
pub fn pending(folder: &Path) -> Vec<Pending> {
    let folder = recovery(folder);
    file::remove_abandoned(&folder);
    let files = fs::read_dir(&folder).into_iter().flatten().flatten().map(|found| found.path());
    let mut found: Vec<Pending> = files.filter_map(|file| Pending::read(&file)).collect();
    found.sort_by_key(|pending| std::cmp::Reverse(pending.kept.time));
    found
}

impl Pending {
    /// `None` for what is none, is damaged, or belongs to a viewer that runs.
    fn read(file: &Path) -> Option<Pending> {
        if formats::extension(file) != "json" {
            return None;
        }
        if let Ok(lock) = File::open(file.with_extension("lock")) {
            lock.try_lock().ok()?;
        }
        let bytes = formats::read_bytes(file, MAX_BYTES).ok()?;
        Some(Pending { file: file.into(), kept: serde_json::from_slice(&bytes).ok()? })
    }

    /// The world that it belongs to.
    pub fn source(&self) -> &Path {
        &self.kept.source
    }

    /// When it was kept.
    pub fn time(&self) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(self.kept.time.min(1 << 40))
    }

    /// Opens the world with what was not saved. The file stays until [`Pending::discard`], which is to follow once a [`Keeper`]
    /// has the document.
    ///
    /// # Errors
    /// When it makes no world any more.
    pub fn open(&self) -> Result<Document, Error> {
        let Kept { source, path, folder, text, .. } = &self.kept;
        Document::recovered(source, path.as_deref(), folder, text)
    }

    /// Forgets it.
    pub fn discard(self) {
        // Another viewer may have been faster.
        let _ = fs::remove_file(&self.file);
        let _ = fs::remove_file(self.file.with_extension("lock"));
    }
}

fn recovery(folder: &Path) -> PathBuf {
    folder.join("recovery")
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(if path.as_os_str().is_empty() { Path::new(".") } else { path })
        .unwrap_or_else(|_| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Overrides;

    const TEXT: &str = "format = 1 # a world\nseed = 2\n";

    fn document(folder: &Path) -> Document {
        let path = folder.join("island.toml");
        fs::write(&path, TEXT).expect("it can be written");
        Document::open(&path, &Overrides::default()).expect("a world")
    }

    /// As a viewer that is killed leaves it: no lock is held.
    fn kill(keeper: Keeper) {
        if let Some(slot) = &keeper.slot {
            slot._lock.unlock().expect("it was locked");
        }
        std::mem::forget(keeper);
    }

    #[test]
    fn what_was_not_saved_comes_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut document = document(folder.path());
        let mut keeper = Keeper::new(folder.path());
        let start = Instant::now();
        assert_eq!(keeper.watch(&document, start).expect("kept"), None);
        assert!(pending(folder.path()).is_empty() && !folder.path().join("recovery").exists());

        document.set(&"seed".into(), 3.into());
        keeper.watch(&document, start).expect("kept");
        document.set(&"seed".into(), 4.into());
        let wait = keeper.watch(&document, Instant::now()).expect("kept");
        assert!(wait.is_some_and(|wait| wait <= INTERVAL));
        keeper.watch(&document, Instant::now() + INTERVAL).expect("kept");
        assert!(pending(folder.path()).is_empty(), "its viewer runs");

        kill(keeper);
        let mut found = pending(folder.path());
        assert_eq!(found.len(), 1);
        let found = found.remove(0);
        assert_eq!(found.source(), folder.path().join("island.toml"));
        assert!(found.time().elapsed().is_ok_and(|age| age < Duration::from_secs(60)));
        let mut recovered = found.open().expect("a world");
        assert_eq!((recovered.world().seed, recovered.is_dirty()), (4, true));
        assert!(recovered.undo());
        assert_eq!((recovered.text(), recovered.is_dirty()), (TEXT, false));
        assert!(recovered.redo());
        recovered.save().expect("it can be saved");
        assert_eq!(
            fs::read_to_string(folder.path().join("island.toml")).expect("text"),
            TEXT.replace('2', "4")
        );
        found.discard();
        assert!(pending(folder.path()).is_empty());
    }

    #[test]
    fn what_was_saved_or_undone_is_not_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut document = document(folder.path());
        let mut keeper = Keeper::new(folder.path());
        let files = || fs::read_dir(folder.path().join("recovery")).map_or(0, Iterator::count);
        document.set(&"seed".into(), 3.into());
        keeper.keep(&document).expect("kept");
        assert_eq!(files(), 2);
        document.save().expect("it can be saved");
        keeper.watch(&document, Instant::now()).expect("kept");
        assert_eq!(files(), 0);
        document.set(&"seed".into(), 4.into());
        keeper.keep(&document).expect("kept");
        document.undo();
        keeper.watch(&document, Instant::now()).expect("kept");
        assert_eq!(files(), 0);
        document.redo();
        keeper.keep(&document).expect("kept");
        drop(keeper);
        assert_eq!(pending(folder.path()).len(), 1, "it ended and was not asked");
    }

    #[test]
    fn damaged_files_are_no_offer() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("recovery")).expect("a folder");
        for (name, text) in [("a.json", "{"), ("b.json", "[]"), ("c.txt", "{}"), ("d.json", "\u{0}")] {
            fs::write(folder.path().join("recovery").join(name), text).expect("it can be written");
        }
        assert!(pending(folder.path()).is_empty());
        let gone = r#"{"source": "/gone/x.toml", "path": "/gone/x.toml", "folder": "/gone", "time": 9, "text": "format = 2"}"#;
        fs::write(folder.path().join("recovery/e.json"), gone).expect("it can be written");
        let found = pending(folder.path());
        assert_eq!(found.len(), 1);
        assert!(found[0].open().is_err());
    }
}
