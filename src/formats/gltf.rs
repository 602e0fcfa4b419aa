//! glTF 2.0 in its binary form (.glb): a mesh with its material, in one file.

use super::Error;
use super::file::{self, Written};
use crate::core::mesh::Mesh;
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;

/// Writes a mesh as the one node, called `name`, of a scene. `color` is linear Rec.709, as glTF's colours are; its surface is
/// rough and no metal. The axes are ours: +Y up, metres.
///
/// # Errors
/// Those of [`file::write()`], and for a mesh that takes more than the 4 GiB that a .glb file can have.
pub fn write(path: &Path, name: &str, mesh: &Mesh, color: [f32; 3]) -> Result<Written, Error> {
    let layout = Layout::new(mesh);
    let mut json = document(name, mesh, color, &layout).to_string();
    // Chunks are multiples of 4 bytes long: JSON is filled up with spaces (§4.4.3).
    json.extend(std::iter::repeat_n(' ', json.len().next_multiple_of(4) - json.len()));
    let lengths = (u32::try_from(layout.bytes), u32::try_from(file_bytes(json.len(), &layout)));
    let (Ok(binary_length), Ok(length)) = lengths else {
        return Err(too_large(path));
    };
    file::write(path, |writer| {
        // Header and chunks (§4.4.2, §4.4.3); all numbers are little-endian.
        writer.write_all(b"glTF")?;
        integers(writer, [2, length])?;
        integers(writer, [json.len() as u32])?;
        writer.write_all(b"JSON")?;
        writer.write_all(json.as_bytes())?;
        integers(writer, [binary_length])?;
        writer.write_all(b"BIN\0")?;
        mesh.positions.iter().try_for_each(|position| floats(writer, *position))?;
        mesh.normals.iter().try_for_each(|normal| floats(writer, *normal))?;
        mesh.uvs.iter().try_for_each(|uv| floats(writer, *uv))?;
        match layout.index {
            Index::U16 => mesh.triangles.iter().try_for_each(|triangle| {
                triangle.iter().try_for_each(|&index| writer.write_all(&(index as u16).to_le_bytes()))
            })?,
            Index::U32 => mesh.triangles.iter().try_for_each(|triangle| integers(writer, *triangle))?,
        }
        writer.write_all(&[0; 3][..layout.padding as usize])
    })
}

/// Whether a mesh of that size fits into a .glb file.
pub fn fits(vertices: u64, triangles: u64) -> bool {
    /// More than our JSON takes.
    const JSON: usize = 4096;
    u32::try_from(file_bytes(JSON, &Layout::of(vertices, triangles))).is_ok()
}

/// Why a mesh that doesn't fit is not written.
pub fn too_large(path: &Path) -> Error {
    let reason = "a .glb file holds at most 4 GiB and this mesh takes more; make it coarser, cut the land into tiles, or \
                  write a .ply file";
    Error::Target { path: path.into(), reason }
}

/// Where the parts of the binary chunk lie, in bytes.
struct Layout {
    normals: u64,
    uvs: u64,
    indices: u64,
    index: Index,
    /// Length with the zeros that fill it up to a multiple of 4.
    bytes: u64,
    padding: u64,
}

/// Type of the indices.
#[derive(Clone, Copy)]
enum Index {
    U16,
    U32,
}

impl Layout {
    fn new(mesh: &Mesh) -> Self {
        Self::of(mesh.positions.len() as u64, mesh.triangles.len() as u64)
    }

    fn of(vertices: u64, triangles: u64) -> Self {
        // The greatest number of a type is no index: it may mean that a primitive starts anew (§3.7.2.1).
        let index = if vertices <= u64::from(u16::MAX) { Index::U16 } else { Index::U32 };
        let [normals, uvs, indices] = [12, 24, 32].map(|bytes| bytes * vertices);
        let end = indices + 3 * index.bytes() * triangles;
        let bytes = end.next_multiple_of(4);
        Layout { normals, uvs, indices, index, bytes, padding: bytes - end }
    }
}

impl Index {
    fn bytes(self) -> u64 {
        match self {
            Index::U16 => 2,
            Index::U32 => 4,
        }
    }
}

/// The header, two chunk headers and the chunks.
fn file_bytes(json: usize, layout: &Layout) -> u64 {
    12 + 8 + json as u64 + 8 + layout.bytes
}

/// The JSON chunk. Numbers are the schema's: 5123 and 5125 are integers of 16 and 32 bits, 5126 floats, 34962 vertex
/// attributes, 34963 indices.
fn document(name: &str, mesh: &Mesh, [red, green, blue]: [f32; 3], layout: &Layout) -> serde_json::Value {
    let vertices = mesh.positions.len();
    let indices = 3 * mesh.triangles.len();
    let [least, most] = mesh.bounds();
    let component = match layout.index {
        Index::U16 => 5123,
        Index::U32 => 5125,
    };
    let view = |from: u64, to: u64, target: u32| json!({ "buffer": 0, "byteOffset": from, "byteLength": to - from, "target": target });
    json!({
        "asset": { "version": "2.0", "generator": concat!("terrane ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": name, "mesh": 0 }],
        "meshes": [{
            "name": name,
            "primitives": [{
                "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 },
                "indices": 3,
                "material": 0,
            }],
        }],
        "materials": [{
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [red, green, blue, 1.0],
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
        }],
        "buffers": [{ "byteLength": layout.bytes }],
        "bufferViews": [
            view(0, layout.normals, 34962),
            view(layout.normals, layout.uvs, 34962),
            view(layout.uvs, layout.indices, 34962),
            view(layout.indices, layout.bytes - layout.padding, 34963),
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
                "min": least, "max": most,
            },
            { "bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5126, "count": vertices, "type": "VEC2" },
            { "bufferView": 3, "componentType": component, "count": indices, "type": "SCALAR" },
        ],
    })
}

fn floats<const COUNT: usize>(writer: &mut impl Write, values: [f32; COUNT]) -> io::Result<()> {
    values.iter().try_for_each(|value| writer.write_all(&value.to_le_bytes()))
}

fn integers<const COUNT: usize>(writer: &mut impl Write, values: [u32; COUNT]) -> io::Result<()> {
    values.iter().try_for_each(|value| writer.write_all(&value.to_le_bytes()))
}
