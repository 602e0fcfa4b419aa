//! Files of layers, each with its sidecar.

use super::layers::{Layer, Raster};
use super::preset::{self, Preset};
use super::tiles::{self, Tiles};
use crate::app::cli::options::WorldOptions;
use crate::app::{Error, Session, interrupt};
use crate::core::grid::Grid;
use crate::formats::file::Written;
use crate::formats::png::Depth;
use crate::formats::raw::ByteOrder;
use crate::formats::sidecar::{Sidecar, Tile, Values};
use crate::formats::tiff::Georeference;
use crate::formats::{self, FirstRow, Window, sidecar};
use crate::terrain::Simulation;
use crate::world::World;
use std::path::{Path, PathBuf};

/// Layers that are written alike: into one file, or one a tile and channel.
pub struct LayerFile {
    /// Without the suffixes of tiles and channels.
    pub path: PathBuf,
    pub layers: Vec<Layer>,
    pub encoding: Encoding,
    pub parts: Parts,
}

/// How values become bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Exr,
    Tiff,
    Png {
        depth: Depth,
        first_row: FirstRow,
    },
    Raw {
        byte_order: ByteOrder,
        first_row: FirstRow,
        /// What names end in when nobody has named the file.
        extension: &'static str,
    },
}

/// Where the channels of a layer go.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Parts {
    Together,
    /// Files of their own, called after layer and channel.
    OneAChannel,
}

impl Encoding {
    pub fn raw(byte_order: ByteOrder) -> Self {
        Encoding::Raw { byte_order, first_row: FirstRow::North, extension: "r16" }
    }

    /// What names of files end in, the usual ending first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Encoding::Exr => &["exr"],
            Encoding::Tiff => &["tif", "tiff"],
            Encoding::Png { .. } => &["png"],
            Encoding::Raw { extension: "raw", .. } => &["raw", "r16"],
            Encoding::Raw { .. } => &["r16", "raw"],
        }
    }

    fn first_row(self) -> FirstRow {
        match self {
            Encoding::Exr | Encoding::Tiff => FirstRow::North,
            Encoding::Png { first_row, .. } | Encoding::Raw { first_row, .. } => first_row,
        }
    }
}

impl LayerFile {
    /// All files that will be written beside their sidecars.
    pub fn paths(&self, tiles: Tiles, preset: Option<Preset>) -> Vec<PathBuf> {
        let parts: Vec<PathBuf> = match (self.parts, self.layers.as_slice()) {
            (Parts::OneAChannel, [layer]) => {
                layer.channels().iter().map(|channel| self.path_of(channel)).collect()
            }
            _ => vec![self.path.clone()],
        };
        parts.iter().flat_map(|part| tiles.all().map(move |tile| tiles::path(part, tile, preset))).collect()
    }

    /// `splat_grass.png` for `splat.png`.
    fn path_of(&self, channel: &str) -> PathBuf {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let extension = self.path.extension().unwrap_or_default().to_string_lossy();
        self.path.with_file_name(format!("{stem}_{channel}.{extension}"))
    }
}

/// What is the same for every file of a run.
pub struct Land<'a> {
    pub world: &'a World,
    /// Name of the world file.
    file: String,
    /// What the command line changed in it.
    set: Vec<String>,
    sea_level: f32,
    /// Samples along a side of what is written.
    cells: u32,
    pub tiles: Tiles,
    pub preset: Option<Preset>,
}

impl<'a> Land<'a> {
    pub fn new(
        options: &WorldOptions,
        world: &'a World,
        simulation: &Simulation,
        cells: u32,
        tiles: Tiles,
        preset: Option<Preset>,
    ) -> Self {
        let file = options.world.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let set = options.set.clone();
        Land { world, file, set, sea_level: simulation.sea_level(), cells, tiles, preset }
    }

    /// The land as it is written.
    pub fn grid(&self) -> Grid {
        Grid { cells: self.cells, extent: self.world.plan.grid.extent }
    }

    /// What is said beside a file with these values, first row north.
    pub fn sidecar(&self, values: Values, tile: Option<Tile>) -> Sidecar {
        let grid = self.grid();
        Sidecar {
            values,
            samples: self.tiles.size(grid.cells),
            first_row: FirstRow::North,
            byte_order: None,
            tile,
            extent: grid.extent,
            cell_size: grid.cell_size(),
            sea_level: self.sea_level,
            seed: self.world.seed,
            world: self.file.clone(),
            world_sha256: self.world.sha256.clone(),
            set: self.set.clone(),
            engine: None,
        }
    }

    fn sidecar_of_layers(&self, rasters: &[Raster], encoding: Encoding, tile: Option<Tile>) -> Sidecar {
        let values = match rasters {
            [raster] => Values::One(raster.in_words()),
            rasters => Values::Several {
                channels: rasters
                    .iter()
                    .map(|raster| (raster.layer.name().into(), raster.in_words()))
                    .collect(),
            },
        };
        let grid = self.grid();
        let engine = match (self.preset, rasters) {
            (Some(preset), [raster]) if raster.layer.is_height() => {
                Some(preset.engine(raster.range, grid.extent, grid.cells, tile))
            }
            _ => None,
        };
        Sidecar {
            first_row: encoding.first_row(),
            byte_order: match encoding {
                Encoding::Raw { byte_order, .. } => Some(byte_order),
                _ => None,
            },
            engine,
            ..self.sidecar(values, tile)
        }
    }

    /// Colour of a mesh: what the land is made of, linear Rec.709.
    pub fn rock(&self) -> [f32; 3] {
        self.world.surface.rock
    }

    fn place(&self, origin: [u32; 2]) -> Georeference {
        let grid = self.grid();
        let cell_size = f64::from(grid.extent) / f64::from(grid.cells - 1);
        let [east, south] = origin.map(|at| f64::from(at) * cell_size - f64::from(grid.extent) / 2.0);
        Georeference { origin: [east, -south], cell_size }
    }
}

/// Writes rasters tile by tile and part by part, each file with its sidecar.
pub fn write(file: &LayerFile, rasters: &[Raster], land: &Land, session: &mut Session) -> Result<(), Error> {
    let size = land.tiles.size(land.cells);
    for tile in land.tiles.all() {
        interrupt::check(&session.report)?;
        let origin = land.tiles.origin(tile, land.cells);
        let sidecar = land.sidecar_of_layers(rasters, file.encoding, tile);
        let name = |part: &Path| tiles::path(part, tile, land.preset);
        match (file.parts, rasters) {
            (Parts::OneAChannel, [raster]) => {
                for (index, channel) in raster.layer.channels().iter().enumerate() {
                    let plane = raster.window().part(origin, size).plane(index);
                    let path = name(&file.path_of(channel));
                    let window = Window::whole(&plane, size, 1);
                    let file = encode(&path, window, raster.range, file.encoding, land.place(origin))?;
                    report(&file, &sidecar, session)?;
                }
            }
            (Parts::Together, [raster]) if file.encoding != Encoding::Exr => {
                let path = name(&file.path);
                let window = raster.window().part(origin, size);
                let file = encode(&path, window, raster.range, file.encoding, land.place(origin))?;
                report(&file, &sidecar, session)?;
            }
            (_, rasters) => {
                let path = name(&file.path);
                let file = write_exr(&path, rasters, origin, size)?;
                report(&file, &sidecar, session)?;
            }
        }
        if let Some(engine) = sidecar.engine.filter(|_| tile.is_none_or(|tile| tile.row + tile.column == 0)) {
            session.progress.say(&preset::advice(&engine, &name(&file.path), &sidecar));
        }
    }
    Ok(())
}

/// Tells of a file that is written, and writes what is said beside it.
pub fn report(file: &Written, sidecar: &Sidecar, session: &mut Session) -> Result<(), Error> {
    session.progress.say(&format!("wrote {}", file.path.display()));
    session.report.wrote(file);
    session.report.wrote(&sidecar::write(&file.path, sidecar)?);
    Ok(())
}

/// Writes one layer, or one channel of it.
fn encode(
    path: &Path,
    window: Window,
    range: [f32; 2],
    encoding: Encoding,
    place: Georeference,
) -> Result<Written, formats::Error> {
    let window = window.ordered(encoding.first_row());
    match encoding {
        Encoding::Exr => {
            formats::exr::write_channels(path, window.size(), vec![("Y".into(), window.plane(0))])
        }
        Encoding::Tiff => formats::tiff::write(path, window, place),
        Encoding::Png { depth, .. } => formats::png::write_integers(path, window, depth, range),
        Encoding::Raw { byte_order, .. } => formats::raw::write(path, window, range, byte_order),
    }
}

/// Channels bear the layer's name; a layer of several has R, G, B, A, behind its name where other layers share the file.
fn write_exr(
    path: &Path,
    rasters: &[Raster],
    origin: [u32; 2],
    size: [u32; 2],
) -> Result<Written, formats::Error> {
    let shared = rasters.len() > 1;
    let mut channels = Vec::new();
    for raster in rasters {
        let window = raster.window().part(origin, size);
        let several = window.channels() > 1;
        for (index, letter) in ["R", "G", "B", "A"].into_iter().enumerate().take(window.channels()) {
            let name = match (several, shared) {
                (false, _) => raster.layer.name().into(),
                (true, false) => letter.into(),
                (true, true) => format!("{}.{letter}", raster.layer.name()),
            };
            channels.push((name, window.plane(index)));
        }
    }
    formats::exr::write_channels(path, size, channels)
}
