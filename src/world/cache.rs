//! What runs leave for later ones: states of the land, each in a file that is named after the hash of all that determines
//! it.
//!
//! Nothing is locked. A file appears whole or not at all, may be removed at any time, and is believed only when its
//! checksum is right: so any number of runs may use one folder, and a run that is killed leaves nothing in their way.

use super::World;
use crate::core::{hash::hexadecimal, memory::mebibytes};
use crate::formats::{self, file, sealed};
use crate::gpu::{self, DeviceInfo, Gpu};
use crate::terrain::{Part, Plan, Position, Simulation};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{self, File, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// A folder of states that stays below a size.
#[derive(Clone, Debug)]
pub struct Cache {
    pub folder: PathBuf,
    /// Bytes.
    pub limit: u64,
}

/// All that determines the land behind a stage, as a hash in hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key(String);

/// A file of the cache.
#[derive(Debug)]
pub struct Entry {
    pub bytes: u64,
    /// Time since it was last written or read.
    pub age: Duration,
    /// What it says about itself; `None` if it can't be read.
    pub land: Option<Header>,
    path: PathBuf,
}

/// What a file says about itself.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    key: String,
    /// Name of the world that it was made for.
    pub world: String,
    /// Samples along a side.
    pub cells: u32,
    pub position: Position,
    /// Iterations of the stage.
    pub iterations: u32,
    /// The images, and the floats of each.
    parts: Vec<(String, u64)>,
}

/// Why a state could not be kept or taken up.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error("{} is damaged ({reason})", path.display())]
    Damaged { path: PathBuf, reason: String },
    #[error("{} can't be read ({source})", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{} can't be written ({source})", path.display())]
    Write { path: PathBuf, source: io::Error },
    #[error("a state of this land takes {}, and the cache may have {}", mebibytes(*bytes), mebibytes(*limit))]
    TooLarge { bytes: u64, limit: u64 },
    #[error("the world has no hash ({0})")]
    Hash(#[from] serde_json::Error),
    #[error(transparent)]
    File(formats::Error),
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
}

/// Ending of the files' names.
const EXTENSION: &str = "land";
/// An unfinished file that nobody has written to for so long was left behind by a process that was killed.
const ABANDONED: Duration = Duration::from_secs(600);

/// The keys of a plan's stages, in their order. The build of the program is in them, as far as it takes part in making
/// land: other code, other keys.
///
/// # Errors
/// Those of [`Plan::digests`].
pub fn keys(plan: &Plan, device: &DeviceInfo) -> Result<Vec<Key>, Error> {
    let maker =
        [env!("CARGO_PKG_VERSION"), env!("TERRANE_CODE"), &device.name, &device.driver, &device.identity];
    let maker = serde_json::to_vec(&maker)?;
    let key = |digest| hexadecimal(&Sha256::new().chain_update(&maker).chain_update(digest).finalize());
    Ok(plan.digests()?.into_iter().map(|digest: [u8; 32]| Key(key(digest))).collect())
}

impl Cache {
    /// Brings a new `simulation` to the state that is kept under `key`; false if there is none. On any error the
    /// simulation may hold parts of that state, and is of no more use.
    ///
    /// # Errors
    /// When there is one, and it can't be read, is damaged or belongs to something else.
    pub fn load(&self, gpu: &Gpu, key: &Key, simulation: &mut Simulation) -> Result<bool, Error> {
        let path = self.path(key);
        let damaged = |reason: &str| Error::Damaged { path: path.clone(), reason: reason.into() };
        let (header, mut reader) = match sealed::Reader::open::<Header>(&path) {
            Err(formats::Error::Read { source, .. }) if is_missing(&source) => return Ok(false),
            opened => opened.map_err(reading)?,
        };
        if header.key != key.0 {
            return Err(damaged("it belongs to another land"));
        }
        let parts =
            simulation.parts(header.position).ok_or_else(|| damaged("it is from no place in this run"))?;
        if header.parts != table(&parts) {
            return Err(damaged("it has other images"));
        }
        for part in &parts {
            part.upload(gpu, &reader.block(part.floats()).map_err(reading)?)?;
        }
        reader.finish().map_err(reading)?;
        simulation.resume(header.position);
        touch(&path);
        Ok(true)
    }

    /// Keeps the state of `simulation` under `key`, unless another run has come as far, and removes what has not been used
    /// for the longest time where the folder would grow beyond its limit.
    ///
    /// # Errors
    /// When it can't be written, or does not fit into the limit.
    pub fn store(&self, gpu: &Gpu, key: &Key, world: &World, simulation: &Simulation) -> Result<(), Error> {
        let Some(position) = simulation.position() else { return Ok(()) };
        let Some(parts) = simulation.parts(position) else { return Ok(()) };
        let path = self.path(key);
        if self.has(key, position) {
            touch(&path);
            return Ok(());
        }
        let stages = world.plan.stages();
        let header = Header {
            key: key.0.clone(),
            world: world.name.chars().take(100).collect(),
            cells: world.plan.grid.cells,
            position,
            iterations: stages.iter().find(|(stage, _)| *stage == position.stage).map_or(0, |(_, of)| *of),
            parts: table(&parts),
        };
        fs::create_dir_all(&self.folder)
            .map_err(|source| Error::Write { path: self.folder.clone(), source })?;
        self.make_room(&path, sealed::bytes(header.parts.iter().map(|(_, floats)| floats).sum()))?;
        let written = sealed::write(&path, &header, |writer| {
            parts.iter().try_for_each(|part| writer.block(&part.download(gpu).map_err(io::Error::other)?))
        });
        written.map_err(writing)
    }

    /// Removes what is kept under `key`.
    pub fn remove(&self, key: &Key) {
        // What can't be removed, or has been, is not worth more words.
        let _ = fs::remove_file(self.path(key));
    }

    /// Everything in the cache, what was used last first.
    ///
    /// # Errors
    /// When its folder can't be read; one that is not there is empty.
    pub fn entries(&self) -> Result<Vec<Entry>, Error> {
        let mut entries: Vec<Entry> = self
            .files()?
            .into_iter()
            .filter_map(|(path, metadata)| {
                let land = sealed::Reader::open(&path).ok().map(|(header, _)| header);
                is_entry(&path).then(|| Entry { bytes: metadata.len(), age: age(&metadata), land, path })
            })
            .collect();
        entries.sort_by(|one, other| (one.age, &one.path).cmp(&(other.age, &other.path)));
        Ok(entries)
    }

    /// Removes everything but what other runs are writing, and says how many bytes these were.
    ///
    /// # Errors
    /// When something can't be removed.
    pub fn clear(&self) -> Result<u64, Error> {
        let mut bytes = 0;
        for (path, metadata) in self.files()? {
            if !is_entry(&path) && age(&metadata) <= ABANDONED {
                continue;
            }
            match fs::remove_file(&path) {
                Err(source) if source.kind() != io::ErrorKind::NotFound => {
                    return Err(Error::Write { path, source });
                }
                _ => bytes += metadata.len(),
            }
        }
        Ok(bytes)
    }

    fn path(&self, Key(key): &Key) -> PathBuf {
        self.folder.join(key).with_extension(EXTENSION)
    }

    /// Whether the state that is kept under `key` is as far on as `position`.
    fn has(&self, key: &Key, position: Position) -> bool {
        let way = |Position { stage, iteration, process, pass }| (stage, iteration, process, pass);
        let kept = sealed::Reader::open::<Header>(&self.path(key));
        kept.is_ok_and(|(header, _)| header.key == key.0 && way(header.position) >= way(position))
    }

    /// Makes room for a file of so many bytes that replaces the one at `path`.
    fn make_room(&self, path: &Path, bytes: u64) -> Result<(), Error> {
        if bytes > self.limit {
            return Err(Error::TooLarge { bytes, limit: self.limit });
        }
        let mut files = self.files()?;
        files.retain(|(other, _)| other != path);
        files.sort_by_key(|(_, metadata)| std::cmp::Reverse(age(metadata)));
        let mut total = bytes + files.iter().map(|(_, metadata)| metadata.len()).sum::<u64>();
        for (path, metadata) in files {
            let removed = if is_entry(&path) { total > self.limit } else { age(&metadata) > ABANDONED };
            if removed {
                // Another run may have been faster.
                let _ = fs::remove_file(path);
                total -= metadata.len();
            }
        }
        Ok(())
    }

    /// The cache's own files in the folder, unfinished ones too.
    fn files(&self) -> Result<Vec<(PathBuf, Metadata)>, Error> {
        let failed = |source| Error::Read { path: self.folder.clone(), source };
        let found = match fs::read_dir(&self.folder) {
            Err(error) if is_missing(&error) => return Ok(Vec::new()),
            found => found.map_err(failed)?,
        };
        let mut files = Vec::new();
        for found in found {
            let path = found.map_err(failed)?.path();
            // A file that has just been removed is none.
            let Ok(metadata) = fs::symlink_metadata(&path) else { continue };
            if metadata.is_file() && (is_entry(&path) || file::is_unfinished(&path)) {
                files.push((path, metadata));
            }
        }
        Ok(files)
    }
}

/// A file in the folder's place is reported when something is to be kept in it.
fn is_missing(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

fn is_entry(path: &Path) -> bool {
    let stem = path.file_stem().unwrap_or_default().as_encoded_bytes();
    path.extension().is_some_and(|extension| extension == EXTENSION)
        && stem.len() == 64
        && stem.iter().all(u8::is_ascii_hexdigit)
}

fn table(parts: &[Part]) -> Vec<(String, u64)> {
    parts.iter().map(|part| (part.name.into(), part.floats() as u64)).collect()
}

/// Counts a use. Where that can't be noted, the file is only removed earlier.
fn touch(path: &Path) {
    let _ = File::options().append(true).open(path).and_then(|file| file.set_modified(SystemTime::now()));
}

fn age(metadata: &Metadata) -> Duration {
    metadata.modified().ok().and_then(|time| time.elapsed().ok()).unwrap_or_default()
}

fn reading(error: formats::Error) -> Error {
    match error {
        formats::Error::Corrupt { path, reason, .. } => Error::Damaged { path, reason },
        formats::Error::Read { path, source } => Error::Read { path, source },
        other => Error::File(other),
    }
}

fn writing(error: formats::Error) -> Error {
    match error {
        formats::Error::Write { path, source } => Error::Write { path, source },
        other => Error::File(other),
    }
}
