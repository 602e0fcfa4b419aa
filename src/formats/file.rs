//! Files appear whole or not at all: written under a temporary name in the same folder, synced, renamed.

use super::Error;
use crate::core::hash::hexadecimal;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    pub path: PathBuf,
    pub bytes: u64,
    /// Of the contents, in hexadecimal.
    pub sha256: String,
}

/// Writes a file by `fill`, replacing what bore its name. Whatever goes wrong, and when the process is told to stop
/// (see [`remove_unfinished`]), the old file or none is left, never a part of the new one.
///
/// # Errors
/// When the folder is missing or can't be written to, the disk is full, or `path` is something other than a file.
pub fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<Written, Error> {
    let target = Target::new(path)?;
    let (bytes, sha256) =
        target.write(fill, measure).map_err(|source| Error::Write { path: path.into(), source })?;
    Ok(Written { path: path.into(), bytes, sha256 })
}

/// Writes a file as [`write()`] does, and does not read it again to say what it holds. What bore its name bears the name `older`
/// then, if that is given: at any time there is a whole file of one of these names.
///
/// # Errors
/// Those of [`write()`].
pub fn replace_keeping(
    path: &Path,
    older: Option<&Path>,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), Error> {
    let target = Target::new(path)?;
    let keep = |_: &File| match older.map(|older| fs::rename(&target.path, older)) {
        Some(Err(error)) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    };
    target.write(fill, keep).map_err(|source| Error::Write { path: path.into(), source })
}

/// A file that is there already, as if it had just been written.
///
/// # Errors
/// When it can't be read.
pub fn found(path: &Path) -> Result<Written, Error> {
    let (file, _) = super::open(path)?;
    let (bytes, sha256) = measure(&file).map_err(|source| Error::Read { path: path.into(), source })?;
    Ok(Written { path: path.into(), bytes, sha256 })
}

/// Finds out whether [`write()`] would work, without leaving anything behind: asked before minutes of simulation.
///
/// # Errors
/// Those of [`write()`] that can be known beforehand.
pub fn check_writable(path: &Path) -> Result<(), Error> {
    let target = Target::new(path)?;
    Unfinished::new(&target.folder).map_err(|source| Error::Write { path: path.into(), source })?;
    Ok(())
}

/// Finds out whether [`make_folder`] would work, without leaving anything behind.
///
/// # Errors
/// Those of [`make_folder`].
pub fn check_folder(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        return Ok(());
    }
    // Behind a separator no file would be found.
    let plain: PathBuf = path.components().collect();
    if plain.exists() {
        let reason = "a file bears that name; name another folder with -o, ending in /";
        return Err(Error::Target { path: plain, reason });
    }
    check_writable(&plain)
}

/// Makes a folder, if need be; its parent must exist.
///
/// # Errors
/// When the parent is missing or can't be written to, or a file bears the folder's name.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    match fs::create_dir(path) {
        Err(source) if !path.is_dir() => Err(Error::Write { path: path.into(), source }),
        _ => Ok(()),
    }
}

/// Whether a file is one that [`write()`] has not finished, or was stopped from removing.
pub fn is_unfinished(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    name.starts_with(b".terrane-") && name.ends_with(b".part")
}

/// Removes unfinished files from a folder that nobody has written to for ten minutes: processes that were killed have left them.
pub fn remove_abandoned(folder: &Path) {
    let abandoned = |path: &Path| {
        let modified = fs::symlink_metadata(path).and_then(|metadata| metadata.modified()).ok();
        let age = modified.and_then(|time| time.elapsed().ok()).unwrap_or_default();
        is_unfinished(path) && age > ABANDONED
    };
    for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|found| found.path()) {
        if abandoned(&path) {
            // Another run may have been faster, or the file is somebody else's.
            let _ = fs::remove_file(path);
        }
    }
}

const ABANDONED: Duration = Duration::from_secs(600);

/// Removes the temporary files of every [`write()`] under way, and lets none of them finish: for a process that is about
/// to exit at once.
pub fn remove_unfinished() {
    let mut unfinished = unfinished();
    for path in unfinished.drain(..) {
        // Nobody is left to tell.
        let _ = fs::remove_file(path);
    }
    // The lock is never released, so no renaming can follow.
    std::mem::forget(unfinished);
}

/// The temporary files that exist now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a file will stand once symbolic links are followed, so that renaming replaces the file and not the link to it.
struct Target {
    path: PathBuf,
    folder: PathBuf,
}

impl Target {
    fn new(path: &Path) -> Result<Self, Error> {
        let refused = |reason| Error::Target { path: path.into(), reason };
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => {
                return Err(refused(
                    "a folder bears that name; choose another with -o, or end it in / to write into it",
                ));
            }
            // Renaming a file over a device or a pipe would do away with it.
            Ok(found) if !found.is_file() => {
                return Err(refused("it is a device or a pipe; choose the name of a file with -o"));
            }
            _ => {}
        }
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.into(),
            Some(_) => PathBuf::from("."),
            None => return Err(refused("it names no file; choose a name with -o")),
        };
        Ok(Self { path, folder })
    }

    /// Gives what `inspect` finds in the file before it gets its name.
    fn write<T>(
        &self,
        fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
        inspect: impl FnOnce(&File) -> io::Result<T>,
    ) -> io::Result<T> {
        let unfinished = Unfinished::new(&self.folder)?;
        let mut writer = BufWriter::new(&unfinished.file);
        fill(&mut writer)?;
        writer.flush()?;
        drop(writer);

        unfinished.file.sync_all()?;
        let found = inspect(&unfinished.file)?;

        unfinished.rename(&self.path)?;
        sync_folder(&self.folder)?;
        Ok(found)
    }
}

/// A temporary file that vanishes unless it is renamed.
struct Unfinished {
    file: File,
    path: PathBuf,
}

impl Unfinished {
    fn new(folder: &Path) -> io::Result<Self> {
        static COUNTER: AtomicU32 = AtomicU32::new(0);

        // Held over the creation, so that no file escapes `remove_unfinished`.
        let mut unfinished = unfinished();
        loop {
            let number = COUNTER.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!(".terrane-{}-{number}.part", std::process::id()));
            match File::options().read(true).write(true).create_new(true).open(&path) {
                Ok(file) => {
                    unfinished.push(path.clone());
                    return Ok(Self { file, path });
                }
                // Left behind by a process of the same number that was killed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn rename(self, path: &Path) -> io::Result<()> {
        let mut unfinished = unfinished();
        fs::rename(&self.path, path)?;
        unfinished.retain(|other| *other != self.path);
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        let mut unfinished = unfinished();
        if let Some(index) = unfinished.iter().position(|other| *other == self.path) {
            unfinished.swap_remove(index);
            // The error that brought us here says more than this one could.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Length of a file, and its SHA-256 in hexadecimal.
fn measure(mut file: &File) -> io::Result<(u64, String)> {
    file.rewind()?;
    let mut reader = BufReader::new(file);
    let (mut bytes, mut digest) = (0, Sha256::new());
    loop {
        let chunk = reader.fill_buf()?;
        if chunk.is_empty() {
            break;
        }
        digest.update(chunk);
        let length = chunk.len();
        bytes += length as u64;
        reader.consume(length);
    }
    Ok((bytes, hexadecimal(&digest.finalize())))
}

/// Makes the renaming last through a power cut. Only Unix lets a folder be opened and synced.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
