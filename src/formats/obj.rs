//! Wavefront OBJ: a mesh as text.

use super::Error;
use super::file::{self, Written};
use crate::core::mesh::Mesh;
use std::io::Write;
use std::path::Path;

/// Writes a mesh as the object `name`. The axes are ours (+Y up, metres); texture coordinates count upwards, as the
/// format's do. Numbers are as short as gives back the same float.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write(path: &Path, name: &str, mesh: &Mesh) -> Result<Written, Error> {
    file::write(path, |writer| {
        writeln!(writer, "# terrane: metres, +X east, +Y up, +Z south\no {name}")?;
        for [x, y, z] in &mesh.positions {
            writeln!(writer, "v {x} {y} {z}")?;
        }
        for [u, v] in &mesh.uvs {
            writeln!(writer, "vt {u} {}", 1.0 - v)?;
        }
        for [x, y, z] in &mesh.normals {
            writeln!(writer, "vn {x} {y} {z}")?;
        }
        // Counted from 1; the three indices of a corner are the same.
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|index| u64::from(index) + 1);
            writeln!(writer, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
        }
        Ok(())
    })
}
