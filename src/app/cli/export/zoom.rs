//! What is in view of a zoom: its surface as a mesh, its tiles as heights with their addresses.

use super::{Arguments, Choice, mesh};
use crate::app::cli::options::Size;
use crate::app::cli::output::Place;
use crate::app::way::Way;
use crate::app::{Error, Session, interrupt, land, memory};
use crate::core::mesh::Mesh;
use crate::formats::file::{self, Written};
use crate::formats::{self, gltf, ply, sidecar};
use crate::scene::Film;
use crate::world::{World, Zoom};
use crate::zoom::{
    self,
    address::Location,
    height::{FRACTION_BITS, Refinement, Roughness},
    motion::Distance,
    tiles::Heights,
    tree::Leaf,
    view::{Renderer, Settings, View},
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The deepest level whose tiles are written out: each has three numbers of that many binary digits.
const DEEPEST_TILES: u32 = 100_000;

/// What is in view.
struct Seen {
    location: Location,
    altitude: Distance,
    /// log₂ of the quads along a side of a tile.
    bits: u32,
    tiles: Vec<(Leaf, Heights)>,
}

/// Where it is written to.
struct Request {
    place: Place,
    mesh: Option<PathBuf>,
    tiles: Option<PathBuf>,
}

/// Writes what is asked for.
pub fn export(arguments: &Arguments, world: &World, zoom: &Zoom, session: &mut Session) -> Result<(), Error> {
    let request = Request::new(arguments, world)?;
    let mut film = world.film;
    if let Some(Size { width, height }) = arguments.size {
        film = Film { width, height, ..film };
    }
    let mut way = Way::new(world, zoom, &arguments.from, &arguments.world.set)?;
    way.tell_seed(session);
    interrupt::listen();
    let gpu = land::open(&arguments.device, session)?;
    // Nothing is drawn: what counts is the picture's shape.
    let settings = Settings { layers: Some(0), samples: 1, ..zoom.settings(&film, way.fov()) };
    memory::check_zoom(&settings, &film, &world.light.sky, &memory::Limits::of(&gpu))?;
    let mut renderer = Renderer::new(&gpu, way.surface(), settings, &world.light, &film)?;
    way.come_to(renderer.spine(), 0, || interrupt::check(&session.report))?;
    way.check(renderer.spine(), &(0..1))?;
    let location = way.at(renderer.spine(), 0)?;
    let (altitude, tiles) = renderer.seen(&View::of(&location))?;
    drop(renderer);
    interrupt::check(&session.report)?;
    let seen = Seen { location, altitude, bits: settings.bits, tiles };
    if let Some(path) = &request.mesh {
        request.place.make()?;
        seen.write_mesh(path, world, session)?;
    }
    if let Some(folder) = &request.tiles {
        request.place.make()?;
        seen.write_tiles(folder, session)?;
    }
    Ok(())
}

impl Request {
    fn new(arguments: &Arguments, world: &World) -> Result<Request, Error> {
        let refuse = |message: String| Err(Error::Usage(message));
        check_use(arguments)?;
        let default = PathBuf::from(format!("./{}/", world.name));
        let place = Place::of(arguments.out.as_ref().unwrap_or(&default));
        let asked = |choice| arguments.layers.contains(&choice) || arguments.layers.contains(&Choice::All);
        let known = |choice: &Choice| matches!(choice, Choice::Mesh | Choice::Tiles | Choice::All);
        if !arguments.layers.iter().all(known) {
            return Err(Error::Missing(format!(
                "{} is a zoom, and has no such layer; it has mesh and tiles",
                world.name
            )));
        }
        let nothing = arguments.layers.is_empty();
        match &place {
            Place::Folder(folder) => {
                let mesh = (asked(Choice::Mesh) || nothing).then(|| folder.join("terrain.glb"));
                let tiles = (asked(Choice::Tiles) || nothing).then(|| folder.clone());
                let names = mesh.iter().map(|_| "terrain.glb").chain(tiles.iter().map(|_| INDEX));
                place.prepare(names.collect::<Vec<_>>())?;
                Ok(Request { mesh, tiles, place })
            }
            Place::File(path) if asked(Choice::Tiles) => refuse(format!(
                "-o {}: tiles are a folder; name one, ending in /, or give --layer mesh",
                path.display()
            )),
            Place::File(path) if !["glb", "ply"].contains(&formats::extension(path).as_str()) => {
                refuse(format!(
                    "-o {}: what is in view of a zoom is a .glb or .ply file, or a folder, which ends in /",
                    path.display()
                ))
            }
            Place::File(path) => {
                place.prepare([""])?;
                Ok(Request { mesh: Some(path.clone()), tiles: None, place })
            }
        }
    }
}

/// Refuses what is for land.
fn check_use(arguments: &Arguments) -> Result<(), Error> {
    let given = [
        ("--format", arguments.format.is_some()),
        ("--preset", arguments.preset.is_some()),
        ("--cells", arguments.cells.is_some()),
        ("--tiles", arguments.tiles.is_some()),
        ("--byte-order", arguments.byte_order.is_some()),
        ("--mesh-error", arguments.mesh_error.is_some()),
        ("--instancing", arguments.instancing.is_some()),
        ("--lod", arguments.lod.is_some()),
        ("--flip", arguments.flip),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => {
            Err(Error::Usage(format!("{option} is for land, and the world is a zoom; leave it out")))
        }
    }
}

/// What says the rest about a folder of tiles.
const INDEX: &str = "tiles.json";

impl Seen {
    /// What every file says: which surface it is of, and from where.
    fn facts(&self) -> Value {
        let Location { surface, .. } = &self.location;
        let refinement = match surface.refinement {
            Refinement::Triangles => "triangles",
            Refinement::Bilinear => "bilinear",
        };
        let roughness = match surface.roughness {
            Roughness::Whole => "whole",
            Roughness::Half => "half",
            Roughness::Quarter => "quarter",
        };
        json!({
            "location": self.location.code(),
            "surface": { "seed": surface.seed, "refinement": refinement, "roughness": roughness },
        })
    }

    fn write_mesh(&self, path: &Path, world: &World, session: &mut Session) -> Result<(), Error> {
        let Location { surface, place, .. } = &self.location;
        let [vertices, triangles] = zoom::mesh::size(self.tiles.len(), self.bits);
        if Mesh::bytes(vertices, triangles) > mesh::MOST_MESH {
            return Err(Error::Memory(format!(
                "the mesh has {triangles} triangles, and may take {}; lower zoom.tile or zoom.detail",
                crate::core::memory::mebibytes(mesh::MOST_MESH)
            )));
        }
        let mesh = zoom::mesh::mesh(surface, place, self.altitude, self.bits, &self.tiles);
        let mut facts = self.facts();
        let unit = format!("cells of level {}, from the eye; +X east, +Y up, +Z south", self.altitude.level);
        facts["unit"] = json!(unit);
        facts["level"] = json!(self.altitude.level);
        facts["altitude"] = json!(self.altitude.cells);
        let name = path.file_stem().unwrap_or_default().to_string_lossy().replace(char::is_control, "_");
        let written = match formats::extension(path).as_str() {
            "ply" => ply::write_with(path, &mesh, &comments(&unit, &self.location))?,
            _ => gltf::write_with(path, &name, &mesh, world.surface.rock, Some(&facts))?,
        };
        facts["vertices"] = json!(mesh.positions.len());
        facts["triangles"] = json!(mesh.triangles.len());
        tell(&written, session);
        session.report.wrote(&write_json(&sidecar::path(path), &facts)?);
        Ok(())
    }

    fn write_tiles(&self, folder: &Path, session: &mut Session) -> Result<(), Error> {
        let Location { surface, place, .. } = &self.location;
        let deepest = self.tiles.iter().map(|(leaf, _)| leaf.cell.level).max().unwrap_or(0);
        if deepest > DEEPEST_TILES {
            return Err(Error::Missing(format!(
                "addresses of tiles are written out down to level {DEEPEST_TILES}, and this view has level {deepest}; \
                 lower zoom.depth, or give --layer mesh"
            )));
        }
        let side = (1usize << self.bits) + 1;
        let mut tiles = Vec::new();
        for (number, (Leaf { cell, .. }, heights)) in self.tiles.iter().enumerate() {
            interrupt::check(&session.report)?;
            session.progress.show("tiles", number as u64, self.tiles.len() as u64);
            let name = format!("tile_{number:05}.i32");
            let written = file::write(&folder.join(&name), |writer| {
                // Without what is outside.
                let rows = heights.differences.chunks(side + 2).skip(1).take(side);
                let bytes = rows.flat_map(|row| row[1..=side].iter().flat_map(|height| height.to_le_bytes()));
                std::io::Write::write_all(writer, &bytes.collect::<Vec<u8>>())
            })?;
            let vertices = cell.level + self.bits;
            tiles.push(json!({
                "file": name,
                "sha256": written.sha256,
                "level": cell.level,
                "x": place.x.without_wrapping(cell.x, cell.level).to_string(),
                "z": place.z.without_wrapping(cell.z, cell.level).to_string(),
                "base": place.y.without_wrapping(heights.base as u64, vertices + FRACTION_BITS).to_string(),
                "unit_log2": -i64::from(vertices + FRACTION_BITS + surface.roughness.halvings()),
            }));
            session.report.wrote(&written);
        }
        session.progress.show("tiles", self.tiles.len() as u64, self.tiles.len() as u64);
        session.progress.end();
        let mut index = self.facts();
        index["samples"] = json!([side, side]);
        index["type"] = json!("32-bit integers, little-endian, rows from north to south");
        index["vertex_level"] = json!(format!("level + {}", self.bits));
        index["height"] = json!("(base + sample) · 2^unit_log2 cells of level 0");
        index["tiles"] = json!(tiles);
        let written = write_json(&folder.join(INDEX), &index)?;
        session.progress.say(&format!("{} tiles of {side} × {side} heights", self.tiles.len()));
        tell(&written, session);
        Ok(())
    }
}

fn tell(written: &Written, session: &mut Session) {
    session.progress.say(&format!("wrote {}", written.path.display()));
    session.report.wrote(written);
}

fn write_json(path: &Path, value: &Value) -> Result<Written, formats::Error> {
    file::write(path, |writer| {
        serde_json::to_writer_pretty(&mut *writer, value)?;
        std::io::Write::write_all(writer, b"\n")
    })
}

/// Lines of a header: codes are longer than readers take at once.
fn comments(unit: &str, location: &Location) -> Vec<String> {
    const LETTERS: usize = 72;
    let code = location.code();
    let lines =
        code.as_bytes().chunks(LETTERS).map(|line| format!("location {}", String::from_utf8_lossy(line)));
    [format!("terrane: {unit}")].into_iter().chain(lines).collect()
}
