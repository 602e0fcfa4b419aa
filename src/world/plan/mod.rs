//! From what is written to what the makers take: files are loaded, defaults that depend on other keys are filled in,
//! and what can't go together is refused.

mod camera;
mod land;
mod light;
mod maps;

use super::fault::{Complaint, Fault};
use super::keys;
use super::models::{self, Models};
use super::place::KeyPath;
use super::planting;
use crate::core::grid::Grid;
use crate::plants;
use crate::scene;
use crate::terrain::{Boundary, Plan};
use std::path::Path;
use std::sync::Arc;

/// What the keys become, with what is remarkable about them.
pub struct Planned {
    pub plan: Plan,
    pub light: scene::Light,
    pub viewpoint: scene::Viewpoint,
    pub camera_path: scene::CameraPath,
    pub film: scene::Film,
    pub models: Vec<Arc<scene::Model>>,
    pub rules: Vec<plants::planting::Rule>,
    pub standing: Vec<scene::Population>,
    pub warnings: Vec<String>,
}

/// Checks what `world` says as a whole. Paths of files start from `folder`.
///
/// # Errors
/// Everything that can't go together, and every file that can't be used.
pub fn plan(world: &keys::World, folder: &Path) -> Result<Planned, Vec<Fault>> {
    let terrain = &world.terrain;
    let mut check =
        Check { folder, extent: terrain.extent, maps: Vec::new(), faults: Vec::new(), warnings: Vec::new() };
    let plan = Plan {
        grid: Grid { cells: terrain.cells, extent: terrain.extent },
        layers: check.layers(terrain, world.seed),
        sea_level: world.sea.level,
        boundary: world.erosion.as_ref().map_or(Boundary::Sea, |erosion| erosion.boundary),
        controls: check.controls(&world.controls),
        hydraulic: world.erosion.as_ref().and_then(|erosion| erosion.hydraulic),
        thermal: check.thermal(world.erosion.as_ref()),
        seabed_smoothing: world.erosion.as_ref().map_or(0.0, |erosion| erosion.seabed_smoothing),
        reef: check.reef(world.reef.as_ref()),
    };
    if let Some(zoom) = &world.zoom {
        check.zoom(zoom, world.seed);
    }
    check.passes(&plan);
    check.surface(&world.surface);
    let light = check.light(world);
    let viewpoint = check.viewpoint(&world.camera.view, &plan);
    let camera_path = check.camera_path(&world.camera, plan.final_sea_level());
    let [width, height] = world.render.size;
    let film =
        scene::Film { width, height, exposure: world.render.exposure, tone_map: world.render.tone_map };
    let species: Vec<&str> = world.species.iter().map(|(name, _)| name.as_str()).collect();
    let Models { models, mut rules, standing } =
        models::models(&world.models, &species, world.seed, &mut check);
    let count = species.len();
    let of_models = models.iter().map(|model| model.name.as_str());
    let names: Vec<&str> = species.into_iter().chain(of_models).collect();
    rules.extend(planting::rules(&world.plants, &names, world.seed, plan.hydraulic.is_some(), &mut check));
    models::warn_of_unused(&models, count, &rules, &mut check);
    let Check { faults, warnings, .. } = check;
    if faults.is_empty() {
        Ok(Planned { plan, light, viewpoint, camera_path, film, models, rules, standing, warnings })
    } else {
        Err(faults)
    }
}

/// Gathers what is wrong, and the maps that were read.
pub struct Check<'a> {
    pub folder: &'a Path,
    /// Of the terrain, metres.
    pub extent: f32,
    maps: Vec<maps::Read>,
    faults: Vec<Fault>,
    warnings: Vec<String>,
}

impl Check<'_> {
    pub fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    pub fn refuse(&mut self, paths: &[KeyPath], complaint: Complaint) {
        self.faults.push(Fault { paths: paths.to_vec(), complaint, text: None });
    }
}
