//! `<file>.json`: what the numbers of a file mean, and how to make it again.

use super::file::{self, Written};
use super::raw::ByteOrder;
use super::{Error, FirstRow, open};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// What is said beside a raster or a mesh of the land.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sidecar {
    #[serde(flatten)]
    pub values: Values,
    /// Width and height of the file, or of the raster that a mesh keeps to; samples.
    pub samples: [u32; 2],
    /// The edge that its first row is, of pixels or of vertices.
    pub first_row: FirstRow,
    /// Of a RAW file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_order: Option<ByteOrder>,
    /// Which part of the land the file is; all of it without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile: Option<Tile>,
    /// Length of one side of the whole land, metres.
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
    /// What to type into the import dialog of an engine.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub engine: Option<Engine>,
}

/// One of the tiles of a land, which share the samples of their edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tile {
    /// Counted from the west edge.
    pub column: u32,
    /// Counted from the north edge.
    pub row: u32,
    /// Tiles along the land: west to east, north to south.
    pub of: [u32; 2],
}

/// The size of a land as an engine counts it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    Unreal {
        /// Scale of the landscape actor: x, y, z.
        scale: [f32; 3],
        /// Its location, centimetres, which puts the land's middle and the datum at the origin: x, y, z.
        location: [f32; 3],
    },
    Unity {
        /// Terrain size, metres: x, y (height), z.
        terrain_size: [f32; 3],
        /// Its position, metres, which puts the land's middle and the datum at the origin: x, y, z.
        position: [f32; 3],
    },
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Values {
    /// The file holds one layer.
    One(Range),
    /// The file holds several, by the name of the channel.
    Several { channels: BTreeMap<String, Range> },
    /// The file holds what stands on the land, and maybe the land.
    Scene { plants: u64, models: u64, triangles: u64 },
    /// The file holds a mesh over the height.
    Mesh {
        #[serde(flatten)]
        height: Range,
        vertices: u64,
        triangles: u64,
        /// The farthest that a sample may lie above or below the mesh, metres.
        largest_error: f32,
    },
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

/// What a reader of a raster needs of its sidecar.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Notes {
    /// Least and greatest value.
    pub range: Option<[f32; 2]>,
    /// Width and height.
    pub samples: Option<[u32; 2]>,
    pub byte_order: Option<ByteOrder>,
    pub first_row: Option<FirstRow>,
    /// Length of one side of the whole land, metres.
    pub extent: Option<f32>,
    pub tile: Option<Tile>,
}

/// Reads the sidecar of `file`; there are no notes where there is no sidecar.
///
/// # Errors
/// When it can't be read, is another program's, or one of its values is none that it can be.
pub fn read(map: &Path) -> Result<Notes, Error> {
    /// A sidecar takes a few hundred bytes.
    const MAX_BYTES: u64 = 1 << 20;

    #[derive(Deserialize)]
    struct Written {
        min: Option<f32>,
        max: Option<f32>,
        samples: Option<[u32; 2]>,
        byte_order: Option<ByteOrder>,
        first_row: Option<FirstRow>,
        extent: Option<f32>,
        tile: Option<Tile>,
    }

    let path = path(map);
    if !path.exists() {
        return Ok(Notes::default());
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
    let written: Written = serde_json::from_slice(&text).map_err(|error| Error::ForeignSidecar {
        map: map.into(),
        line: error.line(),
        column: error.column(),
    })?;
    let Written { min, max, samples, byte_order, first_row, extent, tile } = written;
    let range = min.zip(max).map(<[f32; 2]>::from);
    if let Some([min, max]) = range.filter(|range| !range.iter().all(|end| end.is_finite())) {
        return Err(corrupt(format!("`min` ({min}) and `max` ({max}) must be finite")));
    }
    Ok(Notes { range, samples, byte_order, first_row, extent, tile })
}
