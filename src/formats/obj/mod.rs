//! Wavefront OBJ: meshes as text. The axes are ours (+Y up, metres); texture coordinates count upwards, as the format's do.
//! Numbers are as short as gives back the same float.

mod read;

pub use read::read;

use super::Error;
use super::file::{self, Written};
use crate::core::mesh::Mesh;
use crate::scene::Model;
use std::io::{self, Write};
use std::path::Path;

/// Writes a mesh as the object `name`.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write(path: &Path, name: &str, mesh: &Mesh) -> Result<Written, Error> {
    file::write(path, |writer| {
        writeln!(writer, "{HEADER}\no {}", word(name))?;
        vertices(writer, mesh)?;
        faces(writer, mesh, 1)
    })
}

/// Writes the finest level of a model as one object with a group a part (programs that read OBJ would show several levels
/// on top of each other), and its materials into the .mtl file of the same name.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write_model(path: &Path, model: &Model) -> Result<Vec<Written>, Error> {
    let library = path.with_extension("mtl");
    let names: Vec<String> = (0..model.materials.len()).map(|index| material_name(model, index)).collect();
    let parts = || model.levels.first().into_iter().flat_map(|level| &level.parts);
    let object = file::write(path, |writer| {
        writeln!(writer, "{HEADER}")?;
        writeln!(writer, "mtllib {}", library.file_name().unwrap_or_default().display())?;
        writeln!(writer, "o {}", word(&model.name))?;
        parts().try_for_each(|part| vertices(writer, &part.mesh))?;
        let mut first = 1;
        for part in parts() {
            let material = &names[part.material];
            writeln!(writer, "g {material}\nusemtl {material}")?;
            faces(writer, &part.mesh, first)?;
            first += part.mesh.positions.len() as u64;
        }
        Ok(())
    })?;
    let materials = file::write(&library, |writer| {
        writeln!(writer, "# terrane: colours are linear Rec.709")?;
        for (name, material) in names.iter().zip(&model.materials) {
            let [red, green, blue] = material.mean_reflectance();
            writeln!(writer, "newmtl {name}\nKd {red} {green} {blue}\nKs 0 0 0")?;
            // `Pr` is of the extension for physically based materials (Clara.io, Exocortex 2015).
            writeln!(writer, "Ni {}\nPr {}", material.refractive_index, material.roughness)?;
        }
        Ok(())
    })?;
    Ok(vec![object, materials])
}

const HEADER: &str = "# terrane: metres, +X east, +Y up, +Z south";

fn vertices(writer: &mut impl Write, mesh: &Mesh) -> io::Result<()> {
    for [x, y, z] in &mesh.positions {
        writeln!(writer, "v {x} {y} {z}")?;
    }
    for [u, v] in &mesh.uvs {
        writeln!(writer, "vt {u} {}", 1.0 - v)?;
    }
    for [x, y, z] in &mesh.normals {
        writeln!(writer, "vn {x} {y} {z}")?;
    }
    Ok(())
}

/// The faces of a mesh whose vertices begin with the number `first`. The three indices of a corner are the same.
fn faces(writer: &mut impl Write, mesh: &Mesh, first: u64) -> io::Result<()> {
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|index| u64::from(index) + first);
        writeln!(writer, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")?;
    }
    Ok(())
}

/// A name of its own for a material.
fn material_name(model: &Model, index: usize) -> String {
    let names = || model.materials.iter().map(|material| word(&material.name));
    let name = word(&model.materials[index].name);
    let alone = names().filter(|other| *other == name).count() == 1;
    if alone && !name.is_empty() { name } else { format!("{name}_{index}") }
}

/// A name as one word: a line of an OBJ ends where its text has a line break, and for some readers a name at a space.
fn word(name: &str) -> String {
    name.replace(|letter: char| letter.is_control() || letter.is_whitespace(), "_")
}
