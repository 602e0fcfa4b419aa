//! glTF 2.0, in its binary form (.glb) where it is written: meshes with their materials, what stands where, sun and camera,
//! in one file. The axes are ours: +Y up, metres. So are the colours: linear Rec.709.

mod accessor;
mod document;
mod read;
mod scene;
mod shape;
mod transform;
mod write;

pub use read::read;
pub use scene::{Contents, Land, MOST_NODES, Options, Places, Sea, write_scene};

use super::Error;
use super::file::Written;
use crate::core::mesh::Mesh;
use crate::scene::{Level, Model};
use document::{Index, InstanceAttributes, Instancing, Levels, Node, NodeExtensions, NodeExtras};
use serde::Serialize;
use std::path::Path;
use write::{Builder, file_bytes, mesh_bytes, raw};

/// What the generator of our files begins with.
const PROGRAM: &str = "terrane ";

/// Writes a mesh of land as the one node, called `name`, of a scene. Its surface has this `color`, is rough and no metal.
///
/// # Errors
/// Those of [`file::write()`](super::file::write()), and for a mesh that takes more than the 4 GiB that a .glb file can
/// have.
pub fn write(path: &Path, name: &str, mesh: &Mesh, color: [f32; 3]) -> Result<Written, Error> {
    write_with(path, name, mesh, color, None::<()>)
}

/// Writes a mesh whose node says these `extras`.
///
/// # Errors
/// Those of [`write()`].
pub fn write_with(
    path: &Path,
    name: &str,
    mesh: &Mesh,
    color: [f32; 3],
    extras: Option<impl Serialize>,
) -> Result<Written, Error> {
    let mut builder = Builder::default();
    let material = builder.land_material(name, color);
    let mesh = builder.mesh(name, [(mesh, material)]);
    let extras = extras.and_then(|extras| raw(&extras));
    let node = builder.node(Node { name: Some(name.into()), mesh, extras, ..Node::default() });
    builder.write(path, vec![node])
}

/// Writes a model: a node of its name for the finest level, in a scene, and one outside of it for every other.
///
/// The levels are tied together by `MSFT_lod`. Programs that know it (Babylon.js, MRTK) switch between them; others
/// (three.js, Unreal) show what is in the scene, the finest level alone, and never all of them on top of each other.
///
/// # Errors
/// Those of [`write()`].
pub fn write_model(path: &Path, model: &Model) -> Result<Written, Error> {
    let mut builder = Builder::default();
    let node = add_model(&mut builder, &model.name, model, &model.levels, coverage(model), None);
    builder.write(path, vec![node])
}

/// Whether a mesh of that size fits into a .glb file.
pub fn fits(vertices: u64, triangles: u64) -> bool {
    /// More than our JSON takes.
    const JSON: u64 = 4096;
    u32::try_from(file_bytes(JSON, mesh_bytes(vertices, triangles))).is_ok()
}

/// Why a mesh that doesn't fit is not written.
pub fn too_large(path: &Path) -> Error {
    let reason = "a .glb file holds at most 4 GiB and this mesh takes more; make it coarser, cut the land into tiles, or \
                  write a .ply file";
    Error::Target { path: path.into(), reason }
}

fn corrupt(path: &Path, reason: impl Into<String>) -> Error {
    Error::Corrupt { path: path.into(), format: "glTF", reason: reason.into() }
}

/// Adds a node called `name` for the first of a model's `levels`, tied to one outside of the scene for every other. With
/// places, all of them stand there instead.
fn add_model<'a>(
    builder: &mut Builder<'a>,
    name: &str,
    model: &'a Model,
    levels: &'a [Level],
    mut screen_coverage: Vec<f32>,
    places: Option<InstanceAttributes>,
) -> Index {
    let mut nodes = Vec::new();
    for (number, level) in levels.iter().enumerate() {
        let suffix = if number == 0 { String::new() } else { format!("_lod{number}") };
        let mesh = add_level(builder, &format!("{}{suffix}", model.name), model, level);
        let screen_coverage = std::mem::take(&mut screen_coverage);
        let extras =
            raw(&NodeExtras { detail: Some(level.detail), screen_coverage, ..NodeExtras::default() });
        let instancing = places.filter(|_| mesh.is_some()).map(|attributes| Instancing { attributes });
        let extensions = instancing
            .map(|it| Box::new(NodeExtensions { instancing: Some(it), ..NodeExtensions::default() }));
        let name = Some(format!("{name}{suffix}").into());
        nodes.push(builder.node(Node { name, mesh, extensions, extras, ..Node::default() }));
    }
    let Some((&finest, ids)) = nodes.split_first() else {
        return builder.node(Node { name: Some(name.into()), ..Node::default() });
    };
    if !ids.is_empty() {
        builder.extension("MSFT_lod");
        let extensions = &mut builder.document.nodes[finest as usize].extensions;
        extensions.get_or_insert_default().levels = Some(Levels { ids: ids.into() });
    }
    finest
}

/// Adds a level's mesh with its materials; `None` if it has no triangles.
fn add_level<'a>(builder: &mut Builder<'a>, name: &str, model: &'a Model, level: &'a Level) -> Option<Index> {
    let parts: Vec<_> = level
        .parts
        .iter()
        .map(|part| (&part.mesh, builder.material(&model.materials[part.material])))
        .collect();
    builder.mesh(name, parts)
}

/// The least share of the picture's height that each level is good for: less, and a detail that the next one leaves out is
/// smaller than a pixel of 1080.
fn coverage(model: &Model) -> Vec<f32> {
    const ROWS: f32 = 1080.0;

    let [least, most] = model.bounds();
    let size = (most - least).max_element();
    let share =
        |level: &Level| if level.detail > 0.0 { (size / (level.detail * ROWS)).min(1.0) } else { 1.0 };
    model.levels.iter().skip(1).map(share).chain([0.0]).collect()
}
