//! The height as a mesh: a file, or one a tile, each with its sidecar.

use super::Arguments;
use super::files::{self, Land};
use super::layers::Raster;
use super::preset::Preset;
use super::tiles::{self, Tiles};
use crate::app::cli::output::Place;
use crate::app::{Error, Session, interrupt};
use crate::core::grid::Grid;
use crate::core::memory::mebibytes;
use crate::core::mesh::Mesh;
use crate::core::triangulation::{Refinement, Triangulation};
use crate::formats::file::Written;
use crate::formats::sidecar::Values;
use crate::formats::{self, gltf, obj, ply};
use std::path::{Path, PathBuf};

/// What names of meshes end in.
pub const EXTENSIONS: [&str; 3] = ["glb", "ply", "obj"];

/// A mesh that is asked for.
pub struct MeshFile {
    /// Without the suffixes of tiles.
    path: PathBuf,
    encoding: Encoding,
    /// Metres.
    largest_error: f32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Glb,
    Ply,
    Obj,
}

/// Most memory of the host, bytes, that a mesh may take: one of 8192 × 8192 samples fits.
pub const MOST_MESH: u64 = 4 << 30;

/// Samples that are inserted between two looks at Ctrl-C.
const SLICE: u32 = 20_000;

impl MeshFile {
    /// Samples of what is written are `cell_size` metres apart, and each tile has `size` of them.
    ///
    /// # Errors
    /// When every sample is to be kept, and that takes too much memory or doesn't fit into the file.
    pub fn new(arguments: &Arguments, place: &Place, cell_size: f32, size: [u32; 2]) -> Result<Self, Error> {
        let path = place.file("terrain.glb");
        let encoding = match formats::extension(&path).as_str() {
            "ply" => Encoding::Ply,
            "obj" => Encoding::Obj,
            _ => Encoding::Glb,
        };
        let largest_error = arguments.mesh_error.unwrap_or(cell_size / 10.0);
        if largest_error == 0.0 {
            let [vertices, triangles] =
                [size, size.map(|side| side - 1)].map(|[across, down]| u64::from(across) * u64::from(down));
            check_memory(Mesh::bytes(vertices, 2 * triangles))?;
            if encoding == Encoding::Glb && !gltf::fits(vertices, 2 * triangles) {
                return Err(gltf::too_large(&path).into());
            }
        }
        Ok(MeshFile { path, encoding, largest_error })
    }

    /// All files that will be written beside their sidecars.
    pub fn paths(&self, tiles: Tiles, preset: Option<Preset>) -> Vec<PathBuf> {
        tiles.all().map(|tile| tiles::path(&self.path, tile, preset)).collect()
    }
}

/// Writes the mesh over `height`, tile by tile.
pub fn write(file: &MeshFile, height: &Raster, land: &Land, session: &mut Session) -> Result<(), Error> {
    let grid = land.grid();
    let size = land.tiles.size(grid.cells);
    for tile in land.tiles.all() {
        let origin = land.tiles.origin(tile, grid.cells);
        let mesh = of_land(height, grid, origin, size, file.largest_error, session)?;
        let path = tiles::path(&file.path, tile, land.preset);
        let written = encode(&path, &mesh, file.encoding, land)?;
        let values = Values::Mesh {
            height: height.in_words(),
            vertices: mesh.positions.len() as u64,
            triangles: mesh.triangles.len() as u64,
            largest_error: file.largest_error,
        };
        session.progress.say(&format!(
            "{} vertices and {} triangles, within {} m of the land",
            mesh.positions.len(),
            mesh.triangles.len(),
            file.largest_error
        ));
        files::report(&written, &land.sidecar(values, tile), session)?;
    }
    Ok(())
}

/// The mesh over the `size` samples of `height` that begin at `origin`, bit by bit, under a bar. No sample lies farther than
/// `largest_error` metres above or below it.
///
/// # Errors
/// When it takes too much memory, or is interrupted.
pub fn of_land(
    height: &Raster,
    grid: Grid,
    origin: [u32; 2],
    size: [u32; 2],
    largest_error: f32,
    session: &mut Session,
) -> Result<Mesh, Error> {
    let heights = height.window().part(origin, size).plane(0);
    let triangulation = triangulate(&heights, size, largest_error, session)?;
    drop(heights);
    Ok(Mesh::of_land(&height.values, grid, origin, triangulation))
}

/// Triangulates bit by bit, under a bar.
fn triangulate(
    heights: &[f32],
    size: [u32; 2],
    largest_error: f32,
    session: &mut Session,
) -> Result<Triangulation, Error> {
    const STAGE: &str = "mesh";
    interrupt::check(&session.report)?;
    session.progress.show(STAGE, 0, 1);
    let triangulation = if largest_error == 0.0 {
        Triangulation::full(heights, size)
    } else {
        let mut refinement = Refinement::new(heights, size, largest_error);
        while !refinement.finished() {
            interrupt::check(&session.report)?;
            check_memory(refinement.bytes())?;
            session.progress.show(STAGE, refinement.vertices(), refinement.expected());
            refinement.insert(SLICE);
        }
        refinement.into_triangulation()
    };
    let vertices = triangulation.vertices.len() as u64;
    session.progress.show(STAGE, vertices, vertices);
    session.progress.end();
    Ok(triangulation)
}

/// Writes a mesh that bears the name of its file.
fn encode(path: &Path, mesh: &Mesh, encoding: Encoding, land: &Land) -> Result<Written, formats::Error> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    // A line of an OBJ ends where its text has a line break.
    let name = stem.replace(char::is_control, "_");
    match encoding {
        Encoding::Glb => gltf::write(path, &name, mesh, land.rock()),
        Encoding::Ply => ply::write(path, mesh),
        Encoding::Obj => obj::write(path, &name, mesh),
    }
}

fn check_memory(bytes: u64) -> Result<(), Error> {
    if bytes <= MOST_MESH {
        return Ok(());
    }
    Err(Error::Memory(format!(
        "the mesh takes {} of memory, and may take {}; raise --mesh-error, cut the land with --tiles, or lower --cells",
        mebibytes(bytes),
        mebibytes(MOST_MESH)
    )))
}
