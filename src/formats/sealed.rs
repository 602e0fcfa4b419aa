//! Sealed files: what the program keeps for itself, under a checksum, so that any damage is noticed.
//!
//! | bytes | |
//! |---|---|
//! | 8 | the letters `terrane` and the version of this format |
//! | 4 | length of the header, little-endian |
//! | … | header, JSON |
//! | … | blocks of numbers, in the machine's byte order: the files don't travel between kinds of processors |
//! | 32 | SHA-256 of all before |
//!
//! The header says how many numbers there are; whoever reads compares that with what it expects before it takes memory.

use super::{Error, file, open};
use bytemuck::{AnyBitPattern, NoUninit};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: [u8; 8] = *b"terrane\x01";
/// Bytes of the checksum.
pub const SEAL: u64 = 32;
/// No header is longer, bytes.
const MAX_HEADER: usize = 4096;

/// Writes a file whose `header` is followed by what `fill` writes.
///
/// # Errors
/// Those of [`file::write()`], and a header that is too long.
pub fn write(
    path: &Path,
    header: &impl Serialize,
    fill: impl FnOnce(&mut Writer) -> io::Result<()>,
) -> Result<(), Error> {
    write_keeping(path, None, header, fill)
}

/// Writes a file as [`write()`] does; the one that bore its name is then called `older`, if that is given.
///
/// # Errors
/// Those of [`write()`].
pub fn write_keeping(
    path: &Path,
    older: Option<&Path>,
    header: &impl Serialize,
    fill: impl FnOnce(&mut Writer) -> io::Result<()>,
) -> Result<(), Error> {
    let header = serde_json::to_vec(header).map_err(io::Error::other);
    let header = header.and_then(|header| match header.len() {
        0..=MAX_HEADER => Ok(header),
        length => Err(io::Error::other(format!("a header of {length} bytes"))),
    });
    let header = header.map_err(|source| Error::Write { path: path.into(), source })?;
    file::replace_keeping(path, older, |file| {
        let mut writer = Writer { file, digest: Sha256::new() };
        writer.bytes(&MAGIC)?;
        writer.bytes(&(header.len() as u32).to_le_bytes())?;
        writer.bytes(&header)?;
        fill(&mut writer)?;
        let Writer { file, digest } = writer;
        file.write_all(&digest.finalize())
    })
}

/// The most bytes that a file with so many floats has.
pub fn bytes(floats: u64) -> u64 {
    (MAGIC.len() + 4 + MAX_HEADER + 32) as u64 + 4 * floats
}

/// A sealed file in the making.
pub struct Writer<'a, 'b> {
    file: &'a mut BufWriter<&'b File>,
    digest: Sha256,
}

impl Writer<'_, '_> {
    pub fn block(&mut self, floats: &[f32]) -> io::Result<()> {
        self.values(floats)
    }

    pub fn values<T: NoUninit>(&mut self, values: &[T]) -> io::Result<()> {
        self.bytes(bytemuck::cast_slice(values))
    }

    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.digest.update(bytes);
        self.file.write_all(bytes)
    }
}

/// Finds out whether a file is whole, in little memory: false if there is none.
///
/// # Errors
/// When it is damaged, or can't be read.
pub fn verify(path: &Path) -> Result<bool, Error> {
    let (file, length) = match open(path) {
        Err(Error::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => return Ok(false),
        opened => opened?,
    };
    let Some(sealed) = length.checked_sub(32) else { return Err(corrupt(path, "it ends too early")) };
    let (mut reader, mut digest) = (BufReader::new(file), Sha256::new());
    let (mut left, mut chunk) = (sealed, vec![0; 1 << 16]);
    let failed = |source| Error::Read { path: path.into(), source };
    while left > 0 {
        let part = &mut chunk[..left.min(1 << 16) as usize];
        reader.read_exact(part).map_err(failed)?;
        digest.update(&*part);
        left -= part.len() as u64;
    }
    let mut seal = [0; 32];
    reader.read_exact(&mut seal).map_err(failed)?;
    let expected: [u8; 32] = digest.finalize().into();
    if seal == expected { Ok(true) } else { Err(corrupt(path, "its checksum is another")) }
}

/// A sealed file that is being read. Nothing that it holds is to be trusted before [`Reader::finish`].
pub struct Reader {
    path: PathBuf,
    file: BufReader<File>,
    /// Bytes that are left.
    left: u64,
    digest: Sha256,
}

impl Reader {
    /// Opens a file and reads its header.
    ///
    /// # Errors
    /// When it can't be read, is no sealed file or has a header of another kind.
    pub fn open<H: DeserializeOwned>(path: &Path) -> Result<(H, Reader), Error> {
        let (file, left) = open(path)?;
        let mut reader =
            Reader { path: path.into(), file: BufReader::new(file), left, digest: Sha256::new() };
        if reader.bytes::<8>()? != MAGIC {
            return Err(reader.corrupt("it begins with other bytes"));
        }
        let length = u32::from_le_bytes(reader.bytes()?) as usize;
        if length > MAX_HEADER {
            return Err(reader.corrupt("its header is too long"));
        }
        let mut header = vec![0; length];
        reader.fill(&mut header)?;
        let header = serde_json::from_slice(&header).map_err(|error| reader.corrupt(&error.to_string()))?;
        Ok((header, reader))
    }

    /// Reads the next `floats` floats; takes memory for them only if the file has as many.
    ///
    /// # Errors
    /// When it has not, or can't be read.
    pub fn block(&mut self, floats: usize) -> Result<Vec<f32>, Error> {
        self.values(floats)
    }

    /// The same with values of any type that takes any bits.
    ///
    /// # Errors
    /// Those of [`Reader::block`], and no memory.
    pub fn values<T: NoUninit + AnyBitPattern>(&mut self, count: usize) -> Result<Vec<T>, Error> {
        if count as u64 > self.left / size_of::<T>() as u64 {
            return Err(self.corrupt("it ends too early"));
        }
        let mut values = Vec::new();
        values.try_reserve_exact(count).map_err(|_| Error::Read {
            path: self.path.clone(),
            source: io::ErrorKind::OutOfMemory.into(),
        })?;
        values.resize(count, T::zeroed());
        self.fill(bytemuck::cast_slice_mut(&mut values))?;
        Ok(values)
    }

    /// Bytes that are left, with the checksum.
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Finds out whether all that was read is what was written, and all of it.
    ///
    /// # Errors
    /// When it is not.
    pub fn finish(mut self) -> Result<(), Error> {
        let expected: [u8; 32] = self.digest.clone().finalize().into();
        if self.bytes()? != expected {
            return Err(self.corrupt("its checksum is another"));
        }
        if self.left > 0 {
            return Err(self.corrupt("it is too long"));
        }
        Ok(())
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Error> {
        self.file.read_exact(bytes).map_err(|source| match source.kind() {
            io::ErrorKind::UnexpectedEof => corrupt(&self.path, "it ends too early"),
            _ => Error::Read { path: self.path.clone(), source },
        })?;
        self.digest.update(&*bytes);
        self.left = self.left.saturating_sub(bytes.len() as u64);
        Ok(())
    }

    fn corrupt(&self, reason: &str) -> Error {
        corrupt(&self.path, reason)
    }
}

fn corrupt(path: &Path, reason: &str) -> Error {
    Error::Corrupt { path: path.into(), format: "sealed", reason: reason.into() }
}
