//! PLY (Turk 1994), binary and little-endian. Property names are those that Blender, MeshLab and CloudCompare read. The axes
//! are ours (+Y up, metres); texture coordinates count upwards, as programs that read PLY take them.

mod read;

pub use read::read;

use super::Error;
use super::file::{self, Written};
use crate::core::color::srgb8_from_linear;
use crate::core::mesh::Mesh;
use crate::scene::Model;
use std::io::Write;
use std::path::Path;

/// Writes a mesh.
///
/// # Errors
/// Those of [`file::write()`], and for more vertices than a signed integer of 32 bits can number, which is what readers
/// expect.
pub fn write(path: &Path, mesh: &Mesh) -> Result<Written, Error> {
    write_parts(path, &[(mesh, None)], &[METRES.into()])
}

/// Writes a mesh whose header has these lines, which say what its unit is; readers take some 1000 letters a line.
///
/// # Errors
/// Those of [`write()`].
pub fn write_with(path: &Path, mesh: &Mesh, comments: &[String]) -> Result<Written, Error> {
    write_parts(path, &[(mesh, None)], comments)
}

const METRES: &str = "terrane: metres, +X east, +Y up, +Z south";

/// Writes the finest level of a model, each vertex in the colour of its material (sRGB, as programs show them).
///
/// # Errors
/// Those of [`write()`].
pub fn write_model(path: &Path, model: &Model) -> Result<Written, Error> {
    let parts = model.levels.first().into_iter().flat_map(|level| &level.parts);
    let coloured = parts.map(|part| {
        let color = model.materials[part.material].mean_reflectance();
        (&part.mesh, Some(color.map(|channel| srgb8_from_linear(channel, 0.5))))
    });
    write_parts(path, &coloured.collect::<Vec<_>>(), &[METRES.into()])
}

/// Writes meshes as one; either all of them have a colour or none has.
fn write_parts(
    path: &Path,
    parts: &[(&Mesh, Option<[u8; 3]>)],
    comments: &[String],
) -> Result<Written, Error> {
    let vertices: usize = parts.iter().map(|(mesh, _)| mesh.positions.len()).sum();
    let triangles: usize = parts.iter().map(|(mesh, _)| mesh.triangles.len()).sum();
    if i32::try_from(vertices).is_err() {
        let reason =
            "a .ply file numbers at most 2147483647 vertices; make the mesh coarser, or cut it into tiles";
        return Err(Error::Target { path: path.into(), reason });
    }
    let coloured = parts.iter().any(|(_, color)| color.is_some());
    let colors =
        if coloured { "property uchar red\nproperty uchar green\nproperty uchar blue\n" } else { "" };
    let comments: String = comments.iter().map(|line| format!("comment {line}\n")).collect();
    file::write(path, |writer| {
        write!(
            writer,
            "ply\n\
             format binary_little_endian 1.0\n\
             {comments}\
             element vertex {vertices}\n\
             property float x\n\
             property float y\n\
             property float z\n\
             property float nx\n\
             property float ny\n\
             property float nz\n\
             property float s\n\
             property float t\n\
             {colors}\
             element face {triangles}\n\
             property list uchar int vertex_indices\n\
             end_header\n",
        )?;
        for (Mesh { positions, normals, uvs, .. }, color) in parts {
            for ((position, normal), [u, v]) in positions.iter().zip(normals).zip(uvs) {
                for value in position.iter().chain(normal).chain(&[*u, 1.0 - v]) {
                    writer.write_all(&value.to_le_bytes())?;
                }
                writer.write_all(color.as_ref().map_or(&[], |color| &color[..]))?;
            }
        }
        let mut first = 0;
        for (mesh, _) in parts {
            for triangle in &mesh.triangles {
                writer.write_all(&[3])?;
                for index in triangle {
                    writer.write_all(&(index + first).to_le_bytes())?;
                }
            }
            first += mesh.positions.len() as u32;
        }
        Ok(())
    })
}
