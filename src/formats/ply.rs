//! PLY (Turk 1994), binary and little-endian. Property names are those that Blender, MeshLab and CloudCompare read.

use super::Error;
use super::file::{self, Written};
use crate::core::mesh::Mesh;
use std::io::Write;
use std::path::Path;

/// Writes a mesh. The axes are ours (+Y up, metres); texture coordinates count upwards, as programs that read PLY take them.
///
/// # Errors
/// Those of [`file::write()`], and for more vertices than a signed integer of 32 bits can number, which is what readers
/// expect.
pub fn write(path: &Path, mesh: &Mesh) -> Result<Written, Error> {
    let Mesh { positions, normals, uvs, triangles } = mesh;
    if i32::try_from(positions.len()).is_err() {
        let reason =
            "a .ply file numbers at most 2147483647 vertices; make the mesh coarser, or cut it into tiles";
        return Err(Error::Target { path: path.into(), reason });
    }
    file::write(path, |writer| {
        write!(
            writer,
            "ply\n\
             format binary_little_endian 1.0\n\
             comment terrane: metres, +X east, +Y up, +Z south\n\
             element vertex {}\n\
             property float x\n\
             property float y\n\
             property float z\n\
             property float nx\n\
             property float ny\n\
             property float nz\n\
             property float s\n\
             property float t\n\
             element face {}\n\
             property list uchar int vertex_indices\n\
             end_header\n",
            positions.len(),
            triangles.len()
        )?;
        for ((position, normal), [u, v]) in positions.iter().zip(normals).zip(uvs) {
            for value in position.iter().chain(normal).chain(&[*u, 1.0 - v]) {
                writer.write_all(&value.to_le_bytes())?;
            }
        }
        for triangle in triangles {
            writer.write_all(&[3])?;
            for index in triangle {
                writer.write_all(&index.to_le_bytes())?;
            }
        }
        Ok(())
    })
}
