//! `<file>.json`: what the numbers of a file mean, and how to make it again.

use super::file::{self, Written};
use super::{Error, open};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// What is said beside a raster of the land.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sidecar {
    #[serde(flatten)]
    pub values: Values,
    /// Length of one side of the land, metres.
    pub extent: f32,
    /// Distance between neighbouring samples, metres.
    pub cell_size: f32,
    /// Height of the sea above the datum, metres.
    pub sea_level: f32,
    pub seed: u32,
    /// Name of the world file.
    pub world: String,
    /// Of the world file, in hexadecimal.
    pub world_sha256: String,
    /// What was changed in it, `section.key=value`, in order.
    pub set: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Values {
    /// The file holds one layer.
    One(Range),
    /// The file holds several, by the name of the channel.
    Several { channels: BTreeMap<String, Range> },
}

/// Least and greatest value of a layer, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    pub min: f32,
    pub max: f32,
    /// Empty for numbers without one.
    pub unit: String,
}

/// Where the sidecar of a file lies: `height.png.json` for `height.png`.
pub fn path(file: &Path) -> PathBuf {
    let mut name = OsString::from(file);
    name.push(".json");
    name.into()
}

/// Writes the sidecar of `file`.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write(file: &Path, sidecar: &Sidecar) -> Result<Written, Error> {
    file::write(&path(file), |writer| {
        serde_json::to_writer_pretty(&mut *writer, sidecar)?;
        writer.write_all(b"\n")
    })
}

/// Least and greatest value that the sidecar of `file` names; `None` where there is no sidecar, or it names none.
///
/// # Errors
/// When it can't be read or is no JSON object with finite numbers `min` and `max`.
pub fn read_range(file: &Path) -> Result<Option<[f32; 2]>, Error> {
    /// A sidecar takes a few hundred bytes.
    const MAX_BYTES: u64 = 1 << 20;

    #[derive(Deserialize)]
    struct Written {
        min: Option<f32>,
        max: Option<f32>,
    }

    let path = path(file);
    if !path.exists() {
        return Ok(None);
    }
    let corrupt = |reason: String| Error::Corrupt { path: path.clone(), format: "sidecar", reason };
    let (file, bytes) = open(&path)?;
    if bytes > MAX_BYTES {
        return Err(corrupt(format!("it has {bytes} bytes and may have {MAX_BYTES}")));
    }
    let mut text = Vec::new();
    file.take(MAX_BYTES)
        .read_to_end(&mut text)
        .map_err(|source| Error::Read { path: path.clone(), source })?;
    let written: Written = serde_json::from_slice(&text).map_err(|error| corrupt(error.to_string()))?;
    let (Some(min), Some(max)) = (written.min, written.max) else { return Ok(None) };
    if !(min.is_finite() && max.is_finite()) {
        return Err(corrupt(format!("`min` ({min}) and `max` ({max}) must be finite")));
    }
    Ok(Some([min, max]))
}
