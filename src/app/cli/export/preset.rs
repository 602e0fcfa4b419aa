//! What game engines want to import.

use super::files::{Encoding, Parts};
use super::layers::Layer;
use super::tiles::Tiles;
use super::{Error, Format};
use crate::formats::png::Depth;
use crate::formats::raw::ByteOrder;
use crate::formats::sidecar::{Engine, Sidecar, Tile};
use crate::formats::{FirstRow, sidecar};
use clap::ValueEnum;
use std::path::Path;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// Unreal Engine: recommended landscape sizes, heights of 16 bits, a grey 8-bit PNG for every weight
    Unreal,
    /// Unity: 2^n + 1 samples, heights as RAW with the south edge first, weights as one 8-bit RGBA PNG
    Unity,
}

impl Preset {
    pub fn name(self) -> &'static str {
        match self {
            Preset::Unreal => "Unreal",
            Preset::Unity => "Unity",
        }
    }

    /// Samples along a side that the engine imports. Unreal's are the recommended ones of its "Landscape Technical
    /// Guide", Unity's the heightmap resolutions of its terrain settings.
    fn sizes(self) -> &'static [u32] {
        match self {
            Preset::Unreal => &[127, 253, 505, 1009, 2017, 4033, 8129],
            Preset::Unity => &[33, 65, 129, 257, 513, 1025, 2049, 4097],
        }
    }

    /// Samples along a side of all the tiles together: those that were asked for, if each tile then has a size that the
    /// engine imports, else the nearest to those of the world.
    pub fn cells(self, asked: Option<u32>, world: u32, tiles: Tiles) -> Result<u32, Error> {
        if tiles.across != tiles.down {
            return Err(Error::Usage(format!(
                "{} imports square tiles: give --tiles as many down as across",
                self.name()
            )));
        }
        let mut sizes: Vec<u32> = self.sizes().iter().map(|size| (size - 1) * tiles.across + 1).collect();
        sizes.retain(|size| *size <= super::MAX_CELLS);
        match asked {
            Some(cells) if sizes.contains(&cells) => Ok(cells),
            None if !sizes.is_empty() => {
                let apart = |size: u32| (f64::from(size) / f64::from(world)).ln().abs();
                Ok(sizes
                    .into_iter()
                    .min_by(|one, other| apart(*one).total_cmp(&apart(*other)))
                    .unwrap_or(world))
            }
            _ if sizes.is_empty() => {
                let least = self.sizes().iter().min().copied().unwrap_or(2);
                let most = (super::MAX_CELLS - 1) / (least - 1);
                Err(Error::Usage(format!(
                    "--tiles {tiles}: {} imports tiles of {least} samples a side and more, and all of them together \
                     may have {}; give fewer, at most {most}x{most}",
                    self.name(),
                    super::MAX_CELLS
                )))
            }
            _ => {
                let sizes: Vec<String> = sizes.iter().map(u32::to_string).collect();
                let tiles = if tiles.are_one() { String::new() } else { format!(" in {tiles} tiles") };
                Err(Error::Usage(format!(
                    "{} imports lands of {} samples a side{tiles}; give one of them with --cells",
                    self.name(),
                    sizes.join(", ")
                )))
            }
        }
    }

    /// How a layer is written.
    pub fn encoding(self, layer: Layer, format: Option<Format>) -> Result<(Encoding, Parts), Error> {
        let refuse =
            |advice: &str| Err(Error::Usage(format!("--preset {}: {advice}", self.name().to_lowercase())));
        if matches!(format, Some(Format::Exr | Format::Tif)) {
            return refuse("heights have 16 bits; give --format png16 or r16, or leave it out");
        }
        let png = |depth| Encoding::Png { depth, first_row: FirstRow::North };
        match (self, layer) {
            (Preset::Unreal, layer) if layer.is_height() => match format {
                Some(Format::R16) => Ok((Encoding::raw(ByteOrder::Little), Parts::Together)),
                _ => Ok((png(Depth::Sixteen), Parts::Together)),
            },
            // "Layers" (weight maps) of the import dialog are grey and have 8 bits.
            (Preset::Unreal, Layer::Splat) => Ok((png(Depth::Eight), Parts::OneAChannel)),
            (Preset::Unreal, _) => Ok((png(Depth::Eight), Parts::Together)),
            (Preset::Unity, layer) if layer.is_height() => match format {
                Some(Format::Png16) => refuse("heights are imported as RAW; name a .raw file or a folder"),
                _ => Ok((
                    Encoding::Raw {
                        byte_order: ByteOrder::Little,
                        first_row: FirstRow::South,
                        extension: "raw",
                    },
                    Parts::Together,
                )),
            },
            (Preset::Unity, Layer::Splat | Layer::Normal) => Ok((png(Depth::Eight), Parts::Together)),
            (Preset::Unity, _) => Ok((png(Depth::Sixteen), Parts::Together)),
        }
    }

    /// What makes the imported heights as large as the land.
    pub fn engine(
        self,
        [min, max]: [f32; 2],
        extent: f32,
        cells: u32,
        tile: Option<Tile>,
    ) -> sidecar::Engine {
        let range = max - min;
        match self {
            // "Landscape Technical Guide": with a z scale of 100 the integers 0…65535 span 512 m, and 32768 lies at the
            // actor's height. A quad is as many centimetres wide as the scale.
            Preset::Unreal => {
                let quad = 100.0 * extent / (cells - 1) as f32;
                let corner = -50.0 * extent;
                Engine::Unreal {
                    scale: [quad, quad, 100.0 * range / 512.0],
                    location: [corner, corner, 100.0 * (min + range * (32768.0 / 65535.0))],
                }
            }
            Preset::Unity => {
                let (width, [east, north]) = match tile {
                    // Unity's z axis points north.
                    Some(Tile { column, row, of: [across, down] }) => {
                        (extent / across as f32, [column, down - 1 - row])
                    }
                    None => (extent, [0, 0]),
                };
                let [x, z] = [east, north].map(|index| index as f32 * width - extent / 2.0);
                Engine::Unity { terrain_size: [width, range, width], position: [x, min, z] }
            }
        }
    }
}

/// What to type into the import dialog for the file at `path`.
pub fn advice(engine: &Engine, path: &Path, sidecar: &Sidecar) -> String {
    match *engine {
        Engine::Unreal { scale, location } => {
            format!("Unreal: import with scale {} and location {}", triple(scale), triple(location))
        }
        Engine::Unity { terrain_size, position } => {
            let byte_order = match sidecar.byte_order {
                Some(ByteOrder::Big) => "Mac",
                Some(ByteOrder::Little) | None => "Windows",
            };
            let others = match sidecar.tile {
                Some(_) => "; the other tiles have positions of their own, which their sidecars name",
                None => "",
            };
            format!(
                "Unity: Import Raw of {} with depth 16 bit, byte order {byte_order}, no flip, and terrain size {}; \
                 position {}{others}",
                path.file_name().unwrap_or_default().to_string_lossy(),
                triple(terrain_size),
                triple(position)
            )
        }
    }
}

/// Three numbers, to the thousandth.
fn triple(numbers: [f32; 3]) -> String {
    numbers.map(|number| ((f64::from(number) * 1000.0).round() / 1000.0).to_string()).join(", ")
}
