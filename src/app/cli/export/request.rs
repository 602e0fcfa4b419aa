//! From the arguments to the files that are asked for, before anything is simulated.

use super::files::{Encoding, LayerFile, Parts};
use super::layers::Layer;
use super::mesh::{self, MeshFile};
use super::preset::Preset;
use super::scene::{SceneFile, What};
use super::tiles::Tiles;
use super::{Arguments, Choice, Format};
use crate::app::Error;
use crate::app::cli::output::{Place, check_extension};
use crate::core::grid::Grid;
use crate::formats::png::Depth;
use crate::formats::raw::ByteOrder;
use crate::formats::{self, FirstRow, file};
use crate::terrain::Layer as Simulated;
use crate::world::World;
use std::path::{Path, PathBuf};

/// What is to be written.
pub struct Request {
    pub place: Place,
    pub contents: Vec<Content>,
    /// Samples along a side of all tiles together.
    pub cells: u32,
    pub tiles: Tiles,
    pub preset: Option<Preset>,
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
}

/// What a file holds.
pub enum Content {
    Layers(LayerFile),
    Mesh(MeshFile),
    Scene(SceneFile),
    /// A folder.
    Mitsuba(PathBuf),
}

impl Request {
    /// # Errors
    /// Arguments that make no sense together, a layer that the world has not, and files that can't be written.
    pub fn new(arguments: &Arguments, world: &World) -> Result<Self, Error> {
        let default = PathBuf::from(format!("./{}/", world.name));
        let place = Place::of(arguments.out.as_ref().unwrap_or(&default));
        let choices = choices(arguments, &place);
        let mesh = asks_for_mesh(arguments, &choices, &place)?;
        let scenes = scenes(arguments, &choices, &place, world)?;
        let mitsuba = asks_for_mitsuba(arguments, &choices, &place)?;
        let models = mesh || !scenes.is_empty() || mitsuba.is_some();
        let format =
            if models && matches!(place, Place::File(_)) { None } else { file_format(arguments, &place)? };
        let tiles = arguments.tiles.unwrap_or(Tiles::ONE);
        let cells = match arguments.preset {
            Some(preset) => preset.cells(arguments.cells, world.plan.grid.cells, tiles)?,
            None => arguments.cells.unwrap_or(world.plan.grid.cells),
        };
        tiles.check(cells)?;
        let mut notes = Vec::new();
        let layers = choose(&choices, arguments, format, world, &mut notes)?;
        let encode = |layer| encoding(arguments, format, layer);
        let files = layer_files(&place, &layers, encode)?;
        check_use(arguments, &files)?;
        for file in &files {
            prepare(&place, &file.paths(tiles, arguments.preset))?;
        }
        let mut contents: Vec<Content> = files.into_iter().map(Content::Layers).collect();
        if mesh {
            let cell_size = Grid { cells, ..world.plan.grid }.cell_size();
            let file = MeshFile::new(arguments, &place, cell_size, tiles.size(cells))?;
            prepare(&place, &file.paths(tiles, arguments.preset))?;
            contents.push(Content::Mesh(file));
        }
        for what in scenes {
            let file = SceneFile::new(arguments, &place, what, world.plan.grid.cell_size());
            prepare(&place, std::slice::from_ref(&file.path))?;
            contents.push(Content::Scene(file));
        }
        if let Some(folder) = mitsuba {
            prepare(&place, &[folder.join("scene.xml")])?;
            contents.push(Content::Mitsuba(folder));
        }
        Ok(Request { place, contents, cells, tiles, preset: arguments.preset, notes })
    }

    /// The layers that are written as such.
    pub fn layers(&self) -> impl Iterator<Item = Layer> {
        self.contents
            .iter()
            .flat_map(|content| match content {
                Content::Layers(file) => file.layers.as_slice(),
                Content::Mesh(_) | Content::Scene(_) | Content::Mitsuba(_) => &[],
            })
            .copied()
    }
}

/// What was asked for, and what a name alone asks for.
fn choices(arguments: &Arguments, place: &Place) -> Vec<Choice> {
    match place {
        _ if !arguments.layers.is_empty() => arguments.layers.clone(),
        Place::File(path) if mesh::EXTENSIONS.contains(&formats::extension(path).as_str()) => {
            vec![Choice::Mesh]
        }
        _ => vec![Choice::One(Layer::Simulated(Simulated::Height))],
    }
}

/// Whether there is to be a mesh; it has files of its own.
fn asks_for_mesh(arguments: &Arguments, choices: &[Choice], place: &Place) -> Result<bool, Error> {
    let refuse = |message: String| Err(Error::Usage(message));
    let asked = choices.contains(&Choice::Mesh);
    let of_triangles = |choice: &Choice| matches!(choice, Choice::Mesh | Choice::Scene(_) | Choice::Mitsuba);
    let alone = choices.iter().all(of_triangles);
    if let Place::File(path) = place {
        let extension = formats::extension(path);
        let is_mesh = mesh::EXTENSIONS.contains(&extension.as_str());
        if is_mesh && !alone {
            return refuse(format!(
                "-o {}: a .{extension} file holds a mesh; give --layer mesh",
                path.display()
            ));
        }
        if asked && !is_mesh {
            return refuse(format!(
                "-o {}: a mesh is a .{} file of its own; name one, or a folder for layers and mesh",
                path.display(),
                mesh::EXTENSIONS.join(", .")
            ));
        }
    }
    if alone && arguments.format.is_some() {
        return refuse(
            "--format is for layers, and none is asked for; a mesh follows the name of its file".into(),
        );
    }
    let with_land = asked || choices.contains(&Choice::Scene(What::Scene));
    if arguments.mesh_error.is_some() && !with_land {
        return refuse("--mesh-error is for the mesh, and none is asked for; give --layer mesh".into());
    }
    Ok(asked)
}

/// The folder for Mitsuba, if that is asked for.
fn asks_for_mitsuba(
    arguments: &Arguments,
    choices: &[Choice],
    place: &Place,
) -> Result<Option<PathBuf>, Error> {
    if !choices.contains(&Choice::Mitsuba) {
        return Ok(None);
    }
    let Place::Folder(folder) = place else {
        return Err(Error::Usage("--layer mitsuba is a folder; name one with -o, ending in /".into()));
    };
    check_whole(arguments)?;
    Ok(Some(folder.clone()))
}

/// Refuses options that cut or resample the land, where things stand on it.
fn check_whole(arguments: &Arguments) -> Result<(), Error> {
    let refused = [
        ("--tiles", arguments.tiles.is_some()),
        ("--cells", arguments.cells.is_some()),
        ("--preset", arguments.preset.is_some()),
    ];
    match refused.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Error::Usage(format!(
            "{option} is for the land, and plants stand on it as it is; leave it out"
        ))),
    }
}

/// Which scenes are asked for; each is a file of its own.
fn scenes(
    arguments: &Arguments,
    choices: &[Choice],
    place: &Place,
    world: &World,
) -> Result<Vec<What>, Error> {
    let refuse = |message: String| Err(Error::Usage(message));
    let asked = |what: &What| choices.contains(&Choice::Scene(*what));
    let scenes: Vec<What> = [What::Plants, What::Scene].into_iter().filter(asked).collect();
    if scenes.is_empty() {
        let option = match (arguments.instancing, arguments.lod) {
            (Some(_), _) => "--instancing",
            (_, Some(_)) => "--lod",
            _ => return Ok(scenes),
        };
        return refuse(format!(
            "{option} is for plants and scene, and neither is asked for; give --layer scene"
        ));
    }
    if let Place::File(path) = place {
        let alone = choices.iter().all(|choice| *choice == choices[0]);
        if !alone || formats::extension(path) != "glb" {
            let message = "plants and scene are a .glb file each; name one, or a folder for several layers";
            return refuse(format!("-o {}: {message}", path.display()));
        }
    }
    check_whole(arguments)?;
    let plants = &world.plants;
    if scenes.contains(&What::Plants) && plants.rules.is_empty() && plants.standing.is_empty() {
        let reason = "nothing stands on its ground; give it `plants` or `models`";
        return Err(Error::Missing(format!("{} has no plants: {reason}", world.name)));
    }
    Ok(scenes)
}

/// The format that the name of the output or `--format` asks for, if either does.
fn file_format(arguments: &Arguments, place: &Place) -> Result<Option<Format>, Error> {
    let Place::File(path) = place else { return Ok(arguments.format) };
    check_extension(path, &["exr", "png", "tif", "tiff", "r16", "raw", "glb", "ply", "obj"])?;
    let format = match formats::extension(path).as_str() {
        "png" => Format::Png16,
        "tif" | "tiff" => Format::Tif,
        "r16" | "raw" => Format::R16,
        _ => Format::Exr,
    };
    match arguments.format {
        Some(other) if other != format => Err(Error::Usage(format!(
            "-o {} and --format contradict each other; leave --format out, or name a folder",
            path.display()
        ))),
        _ => Ok(Some(format)),
    }
}

/// The layers that were asked for, once each.
fn choose(
    choices: &[Choice],
    arguments: &Arguments,
    format: Option<Format>,
    world: &World,
    notes: &mut Vec<String>,
) -> Result<Vec<Layer>, Error> {
    let present: Vec<Layer> = Layer::ALL.into_iter().filter(|layer| layer.exists_in(&world.plan)).collect();
    // A preset finds another format for them.
    let grey_only = format == Some(Format::R16) && arguments.preset.is_none();
    let (held, left_out): (Vec<Layer>, Vec<Layer>) =
        present.iter().partition(|layer| !grey_only || layer.channels().len() == 1);
    let mut layers = Vec::new();
    for &choice in choices {
        match choice {
            Choice::Mesh | Choice::Scene(_) | Choice::Mitsuba | Choice::Tiles => {}
            Choice::All => {
                layers.extend(&held);
                let names: Vec<&str> = left_out.iter().map(|layer| layer.name()).collect();
                if !names.is_empty() {
                    notes.push(format!("left out, since a RAW file holds one channel: {}", names.join(", ")));
                }
            }
            Choice::One(layer) if held.contains(&layer) => layers.push(layer),
            Choice::One(layer) if left_out.contains(&layer) => {
                return Err(Error::Usage(format!(
                    "`{}` has {} channels and a RAW file holds one; choose another format for it",
                    layer.name(),
                    layer.channels().len()
                )));
            }
            Choice::One(layer) => {
                let names: Vec<&str> = present.iter().map(|layer| layer.name()).collect();
                return Err(Error::Missing(format!(
                    "{} has no layer `{}`, since no process in it makes one; it has {}",
                    world.name,
                    layer.name(),
                    names.join(", ")
                )));
            }
        }
    }
    Ok(Layer::ALL.into_iter().filter(|layer| layers.contains(layer)).collect())
}

/// How a layer is written.
fn encoding(arguments: &Arguments, format: Option<Format>, layer: Layer) -> Result<(Encoding, Parts), Error> {
    let first_row = if arguments.flip { FirstRow::South } else { FirstRow::North };
    let (encoding, parts) = match (arguments.preset, format) {
        (Some(preset), format) => preset.encoding(layer, format)?,
        (None, None | Some(Format::Exr)) => (Encoding::Exr, Parts::Together),
        (None, Some(Format::Tif)) => (Encoding::Tiff, Parts::Together),
        (None, Some(Format::Png16)) => {
            (Encoding::Png { depth: Depth::Sixteen, first_row: FirstRow::North }, Parts::Together)
        }
        (None, Some(Format::R16)) => (Encoding::raw(ByteOrder::Little), Parts::Together),
    };
    let encoding = match encoding {
        Encoding::Raw { byte_order, first_row: usual, extension } => Encoding::Raw {
            byte_order: arguments.byte_order.unwrap_or(byte_order),
            first_row: if arguments.flip { first_row } else { usual },
            extension,
        },
        Encoding::Png { depth, .. } => Encoding::Png { depth, first_row },
        encoding => encoding,
    };
    Ok((encoding, parts))
}

/// The files for the layers: one, or one each in a folder.
fn layer_files(
    place: &Place,
    layers: &[Layer],
    encode: impl Fn(Layer) -> Result<(Encoding, Parts), Error>,
) -> Result<Vec<LayerFile>, Error> {
    let path = match place {
        Place::Folder(_) => {
            let file = |&layer: &Layer| {
                let (encoding, parts) = encode(layer)?;
                let path = place.file(&format!("{}.{}", layer.name(), encoding.extensions()[0]));
                Ok(LayerFile { path, layers: vec![layer], encoding, parts })
            };
            return layers.iter().map(file).collect();
        }
        Place::File(path) => path,
    };
    let [first, ..] = layers else { return Ok(Vec::new()) };
    let (encoding, parts) = encode(*first)?;
    if !encoding.extensions().contains(&formats::extension(path).as_str()) {
        return Err(Error::Usage(format!(
            "-o {}: with this preset `{}` is a .{} file; name one, or a folder",
            path.display(),
            first.name(),
            encoding.extensions().join(" or .")
        )));
    }
    if encoding != Encoding::Exr && layers.len() > 1 {
        return Err(Error::Usage(format!(
            "{} can hold one layer and {} were asked for; name an .exr file or a folder",
            path.display(),
            layers.len()
        )));
    }
    Ok(vec![LayerFile { path: path.clone(), layers: layers.to_vec(), encoding, parts }])
}

/// Refuses options that no file heeds.
fn check_use(arguments: &Arguments, files: &[LayerFile]) -> Result<(), Error> {
    let refuse = |message: &str| Err(Error::Usage(message.into()));
    let any = |heeds: fn(&Encoding) -> bool| files.iter().any(|file| heeds(&file.encoding));
    if arguments.byte_order.is_some() && !any(|encoding| matches!(encoding, Encoding::Raw { .. })) {
        return refuse(
            "--byte-order is for RAW files, and none is asked for; leave it out, or give --format r16",
        );
    }
    match arguments.preset {
        Some(Preset::Unreal) if arguments.byte_order == Some(ByteOrder::Big) => {
            refuse("--preset unreal: RAW files are little-endian; leave --byte-order out")
        }
        Some(Preset::Unity) if arguments.flip => {
            refuse("--flip: --preset unity turns what needs it; leave --flip out")
        }
        _ if arguments.flip && !any(|encoding| !matches!(encoding, Encoding::Exr | Encoding::Tiff)) => {
            refuse("--flip is for PNG and RAW files, and none is asked for; leave it out")
        }
        _ => Ok(()),
    }
}

/// Finds out whether the files can be written, and leaves nothing behind.
fn prepare(place: &Place, paths: &[PathBuf]) -> Result<(), Error> {
    match place {
        Place::Folder(_) => {
            let names = paths.iter().filter_map(|path| path.file_name()?.to_str());
            place.prepare(names)
        }
        Place::File(_) => {
            paths.iter().map(PathBuf::as_path).try_for_each(|path: &Path| Ok(file::check_writable(path)?))
        }
    }
}
