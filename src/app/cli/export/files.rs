//! Files of layers, each with its sidecar.

use super::Format;
use super::layers::Raster;
use crate::app::cli::options::WorldOptions;
use crate::app::{Error, Session};
use crate::formats::file::Written;
use crate::formats::sidecar::{Range, Sidecar, Values};
use crate::formats::{self, sidecar};
use crate::terrain::Simulation;
use crate::world::World;
use std::path::Path;

/// What every sidecar of a run says.
pub struct Land<'a> {
    world: &'a World,
    /// Name of the world file.
    file: String,
    /// What the command line changed in it.
    set: Vec<String>,
    sea_level: f32,
}

impl<'a> Land<'a> {
    pub fn new(options: &WorldOptions, world: &'a World, simulation: &Simulation) -> Self {
        let file = options.world.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Land { world, file, set: options.set.clone(), sea_level: simulation.sea_level() }
    }

    fn sidecar(&self, rasters: &[Raster]) -> Sidecar {
        let range = |raster: &Raster| {
            let [min, max] = raster.range;
            Range { min, max, unit: raster.layer.unit().into() }
        };
        let values = match rasters {
            [raster] => Values::One(range(raster)),
            rasters => Values::Several {
                channels: rasters.iter().map(|raster| (raster.layer.name().into(), range(raster))).collect(),
            },
        };
        let grid = self.world.plan.grid;
        Sidecar {
            values,
            extent: grid.extent,
            cell_size: grid.cell_size(),
            sea_level: self.sea_level,
            seed: self.world.seed,
            world: self.file.clone(),
            world_sha256: self.world.sha256.clone(),
            set: self.set.clone(),
        }
    }
}

/// Writes a file and its sidecar.
pub fn write(
    path: &Path,
    format: Format,
    rasters: Vec<Raster>,
    land: &Land,
    session: &mut Session,
) -> Result<(), Error> {
    let sidecar = land.sidecar(&rasters);
    let file = match (format, rasters.as_slice()) {
        (Format::Png16, [raster]) => {
            formats::png::write_16(path, raster.size, &raster.channels, raster.range)?
        }
        _ => write_exr(path, rasters)?,
    };
    session.progress.say(&format!("wrote {}", path.display()));
    session.report.wrote(&file);
    session.report.wrote(&sidecar::write(path, &sidecar)?);
    Ok(())
}

/// Channels bear the layer's name; a layer of several has R, G, B, A, behind its name where other layers share the file.
fn write_exr(path: &Path, rasters: Vec<Raster>) -> Result<Written, Error> {
    let size = rasters.first().map_or([0; 2], |raster| raster.size);
    let shared = rasters.len() > 1;
    let mut channels = Vec::new();
    for Raster { layer, channels: values, .. } in rasters {
        let several = values.len() > 1;
        for (letter, values) in ["R", "G", "B", "A"].into_iter().zip(values) {
            let name = match (several, shared) {
                (false, _) => layer.name().into(),
                (true, false) => letter.into(),
                (true, true) => format!("{}.{letter}", layer.name()),
            };
            channels.push((name, values));
        }
    }
    Ok(formats::exr::write_channels(path, size, channels)?)
}
