//! How the land is made: its layers, what wears it down, and what grows round it.

use super::Check;
use super::maps::Use;
use crate::core::hash::derive_seed;
use crate::formats::{self, Hints};
use crate::terrain::layers::{Combine, Generator, Layer};
use crate::terrain::{Controls, FARTHEST_GROUND, Map, Plan, reef, seabed, thermal};
use crate::world::fault::Complaint;
use crate::world::keys;
use crate::world::place::KeyPath;
use std::path::Path;
use std::sync::Arc;

const NO_FIRST: &str = "the first layer starts from level ground";
const LARGER_CELLS: &str =
    "a smaller value, or larger cells: fewer `terrain.cells`, a larger `terrain.extent`";

impl Check<'_> {
    pub(super) fn layers(&mut self, terrain: &keys::Terrain, seed: u32) -> Vec<Layer> {
        // The height that a later `combine = "power"` leaves as it is.
        let mut cone_height = None;
        let mut layers = Vec::new();
        for (index, layer) in terrain.layers.iter().enumerate() {
            let place = KeyPath::from("terrain.layers").join(index);
            let own_seed = |own: Option<u32>| own.unwrap_or_else(|| derive_seed(seed, &place.to_string()));
            let (place, generator, combine, reference) = match layer {
                keys::Layer::Crater(keys::Crater { level }) => {
                    if index == 0 {
                        self.refuse(
                            &[place],
                            Complaint::new("is a crater with nothing to sink into", NO_FIRST),
                        );
                    }
                    layers.push(Layer::Crater { level: *level });
                    continue;
                }
                keys::Layer::Cone(cone) => {
                    let place = place.join("cone");
                    self.cone(cone, terrain.extent, &place);
                    let &keys::Cone { height, radius, exponent, center, combine, reference } = cone;
                    (place, Some(Generator::Cone { height, radius, exponent, center }), combine, reference)
                }
                keys::Layer::Simplex(simplex) => {
                    let &keys::Simplex { wavelength, octaves, warp, combine, reference, .. } = simplex;
                    let plain = matches!(combine, keys::Combine::Power | keys::Combine::Multiply);
                    let amplitude = simplex.amplitude.unwrap_or(if plain { 0.2 } else { 20.0 });
                    let one = if combine == keys::Combine::Multiply { 1.0 } else { 0.0 };
                    let (offset, seed) = (simplex.offset.unwrap_or(one), own_seed(simplex.seed));
                    let generator = Generator::Simplex { amplitude, offset, wavelength, octaves, warp, seed };
                    (place.join("simplex"), Some(generator), combine, reference)
                }
                keys::Layer::DiamondSquare(square) => {
                    let &keys::DiamondSquare {
                        n, init_height, spread, reduction, combine, reference, ..
                    } = square;
                    let seed = own_seed(square.seed);
                    let generator = Generator::DiamondSquare { n, init_height, spread, reduction, seed };
                    (place.join("diamond_square"), Some(generator), combine, reference)
                }
                keys::Layer::Heightmap(heightmap) => {
                    let place = place.join("heightmap");
                    let map = self.heightmap(heightmap, &place);
                    let generator = map.map(|map| Generator::Heightmap { map });
                    (place, generator, heightmap.combine, heightmap.reference)
                }
            };
            let combine = self.combine(combine, reference, cone_height, index, &place);
            if let keys::Layer::Cone(cone) = layer {
                cone_height = Some(cone.height);
            }
            layers.extend(generator.map(|generator| Layer::Generate { generator, combine }));
        }
        layers
    }

    fn cone(&mut self, cone: &keys::Cone, extent: f32, place: &KeyPath) {
        if cone.radius > extent {
            let label = format!("allowed: up to the terrain's extent, {extent} m");
            let paths = [place.join("radius"), "terrain.extent".into()];
            self.refuse(&paths, Complaint::new("is wider than the terrain", label));
        }
        if cone.center.iter().any(|along| along.abs() > extent / 2.0) {
            let label = format!("allowed: up to {} m from the middle, half of the extent", extent / 2.0);
            let paths = [place.join("center"), "terrain.extent".into()];
            self.refuse(&paths, Complaint::new("lies outside the terrain", label));
        }
    }

    fn combine(
        &mut self,
        combine: keys::Combine,
        reference: Option<f32>,
        cone_height: Option<f32>,
        index: usize,
        place: &KeyPath,
    ) -> Combine {
        if index == 0 && !matches!(combine, keys::Combine::Add | keys::Combine::Max) {
            self.refuse(&[place.join("combine")], Complaint::new("has nothing to combine with", NO_FIRST));
        }
        if reference.is_some() && combine != keys::Combine::Power {
            let complaint = Complaint::new("has no use here", "goes with `combine = \"power\"`").about_key();
            self.refuse(&[place.join("reference")], complaint);
        }
        match combine {
            keys::Combine::Add => Combine::Add,
            keys::Combine::Multiply => Combine::Multiply,
            keys::Combine::Max => Combine::Max,
            keys::Combine::Min => Combine::Min,
            keys::Combine::Power => {
                let reference = reference.or(cone_height).unwrap_or_else(|| {
                    if index > 0 {
                        let complaint =
                            Complaint::new("is missing", "no cone before this layer gives the height")
                                .help("`reference` is the height in metres that the power leaves as it is");
                        self.refuse(&[place.join("reference"), place.join("combine")], complaint);
                    }
                    1.0
                });
                Combine::Power { reference }
            }
        }
    }

    fn heightmap(&mut self, heightmap: &keys::Heightmap, place: &KeyPath) -> Option<Arc<Map>> {
        let (min, max, file) = (place.join("min"), place.join("max"), place.join("file"));
        let range = match (heightmap.min, heightmap.max) {
            (Some(least), Some(most)) if least < most => Some([least, most]),
            (None, None) => None,
            (Some(_), Some(_)) => {
                self.refuse(
                    &[max, min],
                    Complaint::new("must be above `min`", "heights rise from `min` to `max`"),
                );
                return None;
            }
            (least, _) => {
                let (missing, other) = if least.is_none() { (min, max) } else { (max, min) };
                self.refuse(
                    &[missing, other],
                    Complaint::new("is missing", "give both `min` and `max`").about_key(),
                );
                return None;
            }
        };
        let path = heightmap.file.as_ref()?;
        let hints = Hints { byte_order: heightmap.byte_order, first_row: heightmap.first_row };
        let raw = matches!(formats::extension(Path::new(path)).as_str(), "raw" | "r16");
        if hints.byte_order.is_some() && !raw {
            let complaint = Complaint::new("has no use here", "only a RAW file leaves it open").about_key();
            self.refuse(&[place.join("byte_order"), file.clone()], complaint);
        }
        let map = self.map(path, &file, hints, Use::Heights(range))?;
        if map.values.iter().any(|height| height.abs() > FARTHEST_GROUND) {
            let label = format!("a map of heights within {FARTHEST_GROUND} m of the datum");
            self.refuse(&[file], Complaint::new("holds heights that no ground has", label));
        }
        Some(map)
    }

    pub(super) fn controls(&mut self, controls: &keys::Controls) -> Controls {
        let mut map = |path: &Option<String>, name: &str| {
            let place = KeyPath::from("controls").join(name);
            let map = self.map(path.as_ref()?, &place, Hints::default(), Use::Factors)?;
            if map.values.iter().any(|value| *value < 0.0) {
                let place = place.clone();
                self.refuse(&[place], Complaint::new("holds values below 0", "a map of factors, from 0 up"));
            }
            // More of what is just stable is not.
            if name == "mask" && map.values.iter().any(|value| *value > 1.0) {
                self.refuse(&[place], Complaint::new("holds values above 1", "a map of shares, from 0 to 1"));
            }
            Some(map)
        };
        Controls {
            rain: map(&controls.rain, "rain"),
            erodibility: map(&controls.erodibility, "erodibility"),
            mask: map(&controls.mask, "mask"),
        }
    }

    pub(super) fn thermal(&mut self, erosion: Option<&keys::Erosion>) -> Option<thermal::Params> {
        let erosion = erosion?;
        let thermal = erosion.thermal.as_ref()?;
        let refuse = |key: &str, label: &str| {
            let place = KeyPath::from("erosion.thermal").join(key);
            (place, Complaint::new("has no use here", label).about_key())
        };
        let useless = match (&erosion.hydraulic, thermal.every, thermal.duration) {
            (None, Some(_), _) => {
                Some(refuse("every", "counts iterations of hydraulic erosion, and there is none"))
            }
            (Some(_), _, Some(_)) => Some(refuse("duration", "hydraulic erosion says how long")),
            _ => None,
        };
        if let Some((place, complaint)) = useless {
            self.refuse(&[place, "erosion.hydraulic".into()], complaint);
        }
        let &keys::Thermal { law, repose, repose_under_water, diffusivity, settle, .. } = thermal;
        let every = thermal.every.unwrap_or(4);
        let duration = thermal.duration.unwrap_or(5000.0);
        Some(thermal::Params { law, repose, repose_under_water, diffusivity, every, duration, settle })
    }

    pub(super) fn reef(&mut self, reef: Option<&reef::Params>) -> Option<reef::Params> {
        let reef = reef?;
        if reef.ocean_depth < reef.max_depth {
            let label = format!("allowed: `max_depth`, {} m, and more", reef.max_depth);
            let complaint = Complaint::new("must not be less than `reef.max_depth`", label)
                .help("coral would grow in the open ocean, where its carbon never runs out");
            self.refuse(&["reef.ocean_depth".into(), "reef.max_depth".into()], complaint);
        }
        if reef.keep >= reef.max_depth {
            let label = format!("allowed: less than `max_depth`, {} m", reef.max_depth);
            let complaint = Complaint::new("leaves no depth to grow in", label);
            self.refuse(&["reef.keep".into(), "reef.max_depth".into()], complaint);
        }
        self.warn_of_drowning(reef);
        Some(reef.clone())
    }

    fn warn_of_drowning(&mut self, reef: &reef::Params) {
        let speeds =
            reef.stages.iter().filter(|stage| stage.duration > 0.0).map(|stage| stage.rise / stage.duration);
        let fastest = speeds.fold(0.0, f32::max);
        let least = if reef.rubble.is_some() { 4.0 } else { 3.5 };
        if reef.growth < least * fastest {
            self.warnings.push(format!(
                "the sea rises by {fastest} m/yr and the reef may drown: give `reef.growth` at least {}",
                least * fastest
            ));
        }
    }

    /// Refuses what takes longer than a day even on a fast device, stage by stage.
    pub(super) fn passes(&mut self, plan: &Plan) {
        let grid = plan.grid;
        if let Some(settle) = plan.thermal.and_then(|thermal| thermal.settle) {
            self.bound(&[(settle.passes(grid).into(), &["erosion.thermal.settle.length"], LARGER_CELLS)]);
        }
        if let Some(water) = &plan.hydraulic {
            let steps = water.steps(grid);
            let count = f64::from(steps.count);
            let slides = plan.thermal.map_or(0.0, |thermal| {
                let every = f64::from(thermal.every);
                count / every * f64::from(thermal.passes(grid, every * steps.step))
            });
            let sweeps = count * f64::from(water.sediment_sweeps(grid));
            let help = "less time, a larger `safety`, or larger cells: fewer `terrain.cells`, a larger `terrain.extent`";
            self.bound(&[
                (count, &["erosion.hydraulic.duration", "erosion.hydraulic.safety"], help),
                (sweeps, &["erosion.hydraulic.sediment_diffusivity"], LARGER_CELLS),
                (slides, &["erosion.thermal.diffusivity"], LARGER_CELLS),
            ]);
        } else if let Some(thermal) = &plan.thermal {
            let passes = thermal.passes(grid, thermal.duration.into());
            let keys = ["erosion.thermal.diffusivity", "erosion.thermal.duration"];
            self.bound(&[(passes.into(), &keys, LARGER_CELLS)]);
        }
        let sweeps = seabed::sweeps(plan.seabed_smoothing, grid);
        self.bound(&[(sweeps.into(), &["erosion.seabed_smoothing"], LARGER_CELLS)]);
        if let Some(reef) = &plan.reef {
            let steps = f64::from(reef.steps());
            let sweeps = steps * f64::from(reef.sweeps(grid));
            let rubble = reef.rubble.map_or(0.0, |rubble| f64::from(rubble.passes) / f64::from(rubble.every));
            self.bound(&[
                (steps, &["reef.step", "reef.stages"], "longer steps, or a shorter history"),
                (sweeps, &["reef.diffusivity"], LARGER_CELLS),
                (steps * rubble, &["reef.rubble.passes"], "fewer passes, or a larger `every`"),
            ]);
        }
    }

    /// Refuses a stage by the first of its rows that is too much: passes, the keys that ask for them, what to do.
    fn bound(&mut self, rows: &[(f64, &[&str], &str)]) {
        const MOST: f64 = 1e7;

        if let Some((_, keys, help)) = rows.iter().find(|(passes, ..)| *passes > MOST) {
            let keys: Vec<KeyPath> =
                keys.iter().chain(&["terrain.cells"]).map(|key| KeyPath::from(*key)).collect();
            let complaint =
                Complaint::new("asks for too much work", "more than ten million passes over the terrain");
            self.refuse(&keys, complaint.help(*help));
        }
    }
}
