//! Models from files: what the world says of them, and what they become.

use super::fault::{Cause, Complaint};
use super::keys::{DEGREES, M, NONE};
use super::kinds::*;
use super::place::{KeyPath, shown};
use super::plan::Check;
use super::schema::{Names, section};
use crate::core::hash::derive_seed;
use crate::core::memory::mebibytes;
use crate::core::mesh::Mesh;
use crate::formats::{self, model::Import};
use crate::plants::planting::{Footing, Places, Rule, Site, Spot};
use crate::scene::{self, Instance, Population};
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;

// Keys ---------------------------------------------------------------------------------------------------------------

section! {
    /// A model from a file, with its materials: a rock, a house, a plant. It stands on the ground where `at` says, and rules
    /// of `plants` may plant it by its name like a species.
    struct Model {
        /// The file: glTF 2.0 (.glb, .gltf), OBJ or PLY. All that is in it is one model. `docs/formats.md` says what is read.
        file: Option<String> = required_file(),
        /// What rules call it.
        name: Option<String> = optional(text("a name", ""), "that of the file, without its ending"),
        /// Vertical extent that it is scaled to.
        height: Option<f32> = optional(number(10.0, M, 1e-3..=10_000.0), "as it is in the file"),
        /// What its lengths are multiplied by, in place of `height`: 0.01 for a file in centimetres.
        scale: Option<f32> = optional(number(1.0, NONE, 1e-6..=1e6), "1"),
        /// The axis of the file that points up.
        up: Up = choice([
            ("y", "as in glTF, and as OBJ files mostly have it", Up::Y),
            ("z", "as in most scans and plans", Up::Z),
        ]),
        /// The point of the model that stands on the ground.
        origin: Origin = choice([
            ("file", "the file's origin", Origin::File),
            ("base", "the middle of its base, at the height of its lowest point", Origin::Base),
        ]),
        /// The colour of all of it, in place of the file's.
        reflectance: Option<[f32; 3]> = optional(colour("#8c8c8c"), "what the file says; grey where it says nothing"),
        /// Where it stands: for each, metres east and south of the middle of the terrain, then if need be a turn in degrees,
        /// clockwise from above, and a scale: `at = [[120, -40], [135, -52, 90, 1.5]]`. Nothing of `plants` grows there. Or
        /// `"file"`: all that the file has stands where the file has it, in the world's coordinates and whatever the ground; so
        /// come plants back that `terrane export` wrote, and of the other keys `reflectance` alone has a use then.
        at: Option<Option<Vec<Vec<f32>>>> = optional(
            word_or("file", IN_PLACE, list(list(number(0.0, NONE, -1e6..=1e6), 2..=4, "[]"), 0..=100_000, "[]")),
            "where rules plant it",
        ),
        /// How far those of `at` lean away from the slope: 0 is upright, 1 is as the ground does.
        lean: f32 = number(0.0, NONE, 0.0..=1.0),
    }
}

/// What to do with a scene of ours.
const BACK: &str = "`at = \"file\"` puts all that `terrane export` wrote back where it stood";

const IN_PLACE: &str = "Where the file has it.";

/// The axis of a file that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    Y,
    Z,
}

/// The point of a model that stands on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    File,
    Base,
}

// Reading ------------------------------------------------------------------------------------------------------------

/// Most memory, bytes, that all models of a world take together.
const MOST: u64 = 1 << 30;

/// Farthest that a part of a model may lie from its origin, and what a file has from the middle of the terrain, metres.
const FARTHEST: f32 = 1e6;

/// What a model may be off its origin before it is remarkable, as a share of its size.
const OFF: f32 = 0.1;

/// What the models of a world become.
#[derive(Default)]
pub struct Models {
    /// Those that stand on the ground, by the names that rules know.
    pub models: Vec<Arc<scene::Model>>,
    /// A rule for each that has places of its own. Their kinds follow the species.
    pub rules: Vec<Rule>,
    /// What stands where its file has it.
    pub standing: Vec<Population>,
}

/// Reads the files of `written`, whose names must differ from those of the `species`. `seed` is the world's.
pub fn models(written: &[Model], species: &[&str], seed: u32, check: &mut Check) -> Models {
    let mut found = Models::default();
    let mut bytes = 0;
    for (index, model) in written.iter().enumerate() {
        let place = KeyPath::from("models").join(index);
        let mut reader = Reader { place, model, check };
        // What is wrong was noted.
        let Some((file, import)) = reader.import(&mut bytes) else { continue };
        if let Some(None) = model.at {
            reader.check_in_place();
            found.standing.push(reader.standing(import));
            continue;
        }
        let taken =
            |name: &str| species.contains(&name) || found.models.iter().any(|other| other.name == name);
        reader.warn_of_scene(file, &import);
        let Some(name) = reader.name(file, taken) else { continue };
        let Some(shape) = reader.shape(file, import, &name) else { continue };
        if let Some(Some(at)) = &model.at {
            let spots = at.iter().enumerate().map(|(index, spot)| reader.spot(index, spot)).collect();
            let kind = species.len() + found.models.len();
            found.rules.push(reader.rule(kind, derive_seed(seed, &format!("models.{name}")), spots));
        }
        found.models.push(Arc::new(shape));
    }
    found
}

struct Reader<'a, 'b, 'c> {
    place: KeyPath,
    model: &'a Model,
    check: &'b mut Check<'c>,
}

impl<'a> Reader<'a, '_, '_> {
    /// What is in the file, whose name comes with it. `bytes` counts what all models take.
    fn import(&mut self, bytes: &mut u64) -> Option<(&'a str, Import)> {
        let file = self.model.file.as_deref()?;
        let at = self.place.join("file");
        let refuse = |label: String, cause| {
            let complaint = Complaint::new(format!("names \"{}\"", shown(file)), label);
            Complaint { cause, ..complaint }
        };
        let complaint = match formats::model::read(&self.check.folder.join(file)) {
            Ok(import) => {
                *bytes += import.bytes();
                if *bytes <= MOST {
                    import.warnings.iter().for_each(|warning| self.check.warn(warning.clone()));
                    return Some((file, import));
                }
                let label = format!(
                    "with it the models take {} of memory, and may take {}",
                    mebibytes(*bytes),
                    mebibytes(MOST)
                );
                refuse(label, Cause::World)
            }
            Err(error) => {
                let unsuitable = matches!(error, formats::Error::NoModel { .. });
                refuse(error.to_string(), if unsuitable { Cause::World } else { Cause::File })
            }
        };
        self.check.refuse(&[at], complaint);
        None
    }

    fn check_in_place(&mut self) {
        let Model { name, height, scale, .. } = self.model;
        let given = [("name", name.is_some()), ("height", height.is_some()), ("scale", scale.is_some())];
        for (key, _) in given.into_iter().filter(|(_, given)| *given) {
            let complaint =
                Complaint::new("has no use here", "all is as the file has it: `at = \"file\"`").about_key();
            self.check.refuse(&[self.place.join(key), self.place.join("at")], complaint);
        }
    }

    fn standing(&mut self, import: Import) -> Population {
        let Population { models, instances } = import.population;
        let reach: Vec<f32> = models
            .iter()
            .map(|model| model.bounds().map(|corner| corner.abs().max_element()))
            .map(|[least, most]| least.max(most))
            .collect();
        let far =
            |it: &Instance| it.position.abs().max_element() + it.scale * reach[it.model as usize] > FARTHEST;
        if instances.iter().any(far) {
            let label = format!("allowed: up to {FARTHEST} m from the middle of the terrain");
            let complaint = Complaint::new("has things that stand too far away", label);
            self.check.refuse(&[self.place.join("file")], complaint);
        }
        let Some(color) = self.model.reflectance else { return Population { models, instances } };
        let painted = |model: Arc<scene::Model>| {
            let mut model = Arc::unwrap_or_clone(model);
            paint(&mut model, color);
            Arc::new(model)
        };
        Population { models: models.into_iter().map(painted).collect(), instances }
    }

    /// The name that rules know, which must not be `taken`.
    fn name(&mut self, file: &str, taken: impl Fn(&str) -> bool) -> Option<String> {
        let stem = || Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = self.model.name.clone().unwrap_or_else(stem);
        let at = [self.place.join("name"), self.place.join("file")];
        let complaint = if !Names::Words.allow(&name) {
            let label = format!("a `name` must be {}", Names::Words.rule());
            Complaint::new(format!("can't make \"{}\" a name", shown(&name)), label)
        } else if taken(&name) {
            let label = "give it a `name` that no species and no other model has";
            Complaint::new(format!("makes \"{}\" the name of two things", shown(&name)), label)
        } else {
            return Some(name);
        };
        self.check.refuse(&at, complaint);
        None
    }

    /// The model as it stands at the origin.
    fn shape(&mut self, file: &str, import: Import, name: &str) -> Option<scene::Model> {
        let merged = match import.merged(&self.check.folder.join(file)) {
            Ok(merged) => merged,
            Err(error) => {
                let mut complaint = Complaint::new(format!("names \"{}\"", shown(file)), error.to_string());
                complaint.help = import.is_own_scene.then(|| BACK.into());
                self.check.refuse(&[self.place.join("file")], complaint);
                return None;
            }
        };
        drop(import);
        let mut model = Arc::unwrap_or_clone(merged);
        model.name = name.into();
        if let Some(color) = self.model.reflectance {
            paint(&mut model, color);
        }
        if self.model.up == Up::Z {
            // A quarter turn: z becomes y and y becomes −z.
            let turn = |vectors: &mut Vec<[f32; 3]>| {
                vectors.iter_mut().for_each(|vector| *vector = [vector[0], vector[2], -vector[1]])
            };
            meshes(&mut model).for_each(|mesh| {
                turn(&mut mesh.positions);
                turn(&mut mesh.normals);
            });
        }
        let scale = self.scale(&model)?;
        let [least, most] = model.bounds();
        let foot = match self.model.origin {
            Origin::File => Vec3::ZERO,
            Origin::Base => Vec3::new((least.x + most.x) / 2.0, least.y, (least.z + most.z) / 2.0),
        };
        if scale != 1.0 || foot != Vec3::ZERO {
            for mesh in meshes(&mut model) {
                mesh.positions
                    .iter_mut()
                    .for_each(|position| *position = (scale * (Vec3::from(*position) - foot)).into());
            }
            model.levels.iter_mut().for_each(|level| level.detail *= scale);
        }
        self.check_size(&model)?;
        self.warn_of_origin(&model);
        Some(model)
    }

    /// What lengths are multiplied by; `None` if that was refused.
    fn scale(&mut self, model: &scene::Model) -> Option<f32> {
        let [least, most] = model.bounds();
        let (height, key) = (most.y - least.y, self.place.join("height"));
        match (self.model.height, self.model.scale) {
            (Some(_), Some(_)) => {
                let complaint =
                    Complaint::new("can't stand beside `height`", "one of the two only").about_key();
                self.check.refuse(&[self.place.join("scale"), key], complaint);
                None
            }
            (None, scale) => Some(scale.unwrap_or(1.0)),
            (Some(wanted), None) if (wanted / height).is_finite() => Some(wanted / height),
            (Some(_), None) => {
                let complaint = Complaint::new("can't be reached", "the model is flat: give it a `scale`");
                self.check.refuse(&[key], complaint);
                None
            }
        }
    }

    /// Refuses what no land has room for: `None`.
    fn check_size(&mut self, model: &scene::Model) -> Option<()> {
        let far = |mesh: &Mesh| mesh.positions.as_flattened().iter().any(|along| along.abs() > FARTHEST);
        if !model.levels.iter().flat_map(|level| &level.parts).any(|part| far(&part.mesh)) {
            return Some(());
        }
        let label = format!("allowed: up to {FARTHEST} m from its origin; give it a smaller `scale`");
        let complaint = Complaint::new("names a model that is too large", label);
        self.check.refuse(&[self.place.join("file")], complaint);
        None
    }

    /// A scene of ours would be one model.
    fn warn_of_scene(&mut self, file: &str, import: &Import) {
        if import.is_own_scene && self.model.at.is_none() {
            self.check.warn(format!("`{}`: \"{}\" is a whole scene; {BACK}", self.place, shown(file)));
        }
    }

    fn warn_of_origin(&mut self, model: &scene::Model) {
        let [least, most] = model.bounds();
        let off = OFF * (most - least).max_element();
        if least.y.abs() > off {
            let side = if least.y > 0.0 { "above" } else { "below" };
            self.check.warn(format!(
                "`{}`: the lowest point of \"{}\" lies {} m {side} its origin, which stands on the ground; `origin = \"base\"` \
                 stands the model on it",
                self.place,
                model.name,
                least.y.abs()
            ));
        }
    }

    fn spot(&mut self, index: usize, numbers: &[f32]) -> Spot {
        let number = |index: usize, default: f32| numbers.get(index).copied().unwrap_or(default);
        let (at, scale) = ([number(0, 0.0), number(1, 0.0)], number(3, 1.0));
        let key = self.place.join("at").join(index);
        let half = self.check.extent / 2.0;
        if at.iter().any(|along| along.abs() > half) {
            let label = format!("allowed: up to {half} m from the middle, half of the extent");
            self.check
                .refuse(&[key, "terrain.extent".into()], Complaint::new("lies outside the terrain", label));
        } else if !(1e-6..=1e6).contains(&scale) {
            let complaint =
                Complaint::new("has no size", "the fourth number is a scale: from 0.000001 to 1000000");
            self.check.refuse(&[key], complaint);
        }
        Spot { at: at.into(), turn: (f64::from(number(2, 0.0)) * DEGREES.factor) as f32, scale }
    }

    fn rule(&self, kind: usize, seed: u32, spots: Arc<[Spot]>) -> Rule {
        Rule {
            name: self.place.to_string(),
            seed,
            kinds: vec![(kind, 1.0)],
            scale: [1.0; 2],
            lean: self.model.lean,
            shade: 1.0,
            site: Site { footing: Footing::Anywhere, ..Site::default() },
            places: Places::Spots(spots),
        }
    }
}

/// Warns of models that nothing places. Their kinds follow so many species.
pub fn warn_of_unused(models: &[Arc<scene::Model>], species: usize, rules: &[Rule], check: &mut Check) {
    for (index, model) in models.iter().enumerate() {
        let planted = |rule: &Rule| rule.kinds.iter().any(|(kind, _)| *kind == species + index);
        if !rules.iter().any(planted) {
            check.warn(format!(
                "the model \"{}\" stands nowhere: give it `at`, or name it in a rule of `plants`",
                model.name
            ));
        }
    }
}

fn meshes(model: &mut scene::Model) -> impl Iterator<Item = &mut Mesh> {
    model.levels.iter_mut().flat_map(|level| &mut level.parts).map(|part| &mut part.mesh)
}

/// Gives all of a model one colour.
fn paint(model: &mut scene::Model, color: [f32; 3]) {
    for material in &mut model.materials {
        material.reflectance = [color; 2];
        material.transmittance = [0.0; 3];
    }
}
