//! From the files of a folder to checked settings.

use super::files::{
    Camera, Family, Generator, Honda, LSystem, Material, PathTracer, Sky, Spawner, Substance, Terrain,
    ViewMode,
};
use super::folder::{Contents, FOLDERS, Folder, MAX_FILE};
use super::growth::Growth;
use super::mistakes::Mistakes;
use super::parameters::{self, Entries};
use super::productions::TURTLE;
use crate::world::Error;
use crate::world::fault::{Cause, Complaint};
use crate::world::kinds::guess;
use crate::world::place::shown;

/// All that a folder says, checked.
pub struct Settings {
    pub path_tracer: PathTracer,
    pub camera: Camera,
    pub view_mode: ViewMode,
    pub sky: Sky,
    pub terrain: Terrain,
    pub materials: Materials,
    pub trees: Vec<Named<Tree>>,
    pub plants: Vec<Named<LSystem>>,
    pub leafs: Vec<Named<Leaf>>,
    pub spawners: Vec<Named<Spawner>>,
}

pub struct Materials {
    pub ground: Material,
    pub rock: Material,
    pub plant: Material,
    pub leaf: Material,
    pub bark: Material,
}

impl Materials {
    pub fn of(&self, substance: Substance) -> &Material {
        match substance {
            Substance::Leaf => &self.leaf,
            Substance::Bark => &self.bark,
            Substance::Plant => &self.plant,
        }
    }
}

/// What a file says.
pub struct Named<T> {
    /// Way of the file from the folder.
    pub file: String,
    pub says: T,
}

pub enum Tree {
    LSystem(LSystem),
    Honda(Honda),
}

/// A leaf, as trees bear it.
pub struct Leaf {
    pub growth: Growth,
    pub material: Substance,
    /// What its drawing is scaled by, so that it is as high as it should be.
    pub scale: f64,
}

/// Files that every folder has.
const FILES: [&str; 5] = ["camera.conf", "pathTracer.conf", "sky.conf", "terrain.conf", "viewMode.conf"];

/// Names of materials, without folder and ending.
const MATERIALS: [&str; 5] = ["bark", "ground", "leaf", "plant", "rock"];

/// Reads every file.
///
/// # Errors
/// With every mistake that was found.
pub fn read(folder: &Folder) -> Result<Settings, Error> {
    let mistakes = Mistakes::default();
    let reader = Reader { folder, mistakes: &mistakes };
    let strangers = !folder.files.keys().any(|file| FILES.contains(&file.as_str()));
    if strangers {
        let report = format!(
            "{} is a folder, and none of settings: a world is a TOML file, or a folder with {} and others",
            folder.name,
            FILES.join(", ")
        );
        return Err(Error::Wrong { report });
    }
    reader.names();
    let terrain = reader.file("terrain.conf", check_terrain);
    let settings = Settings {
        path_tracer: reader.file("pathTracer.conf", unchecked).unwrap_or_default(),
        camera: reader
            .file("camera.conf", |entries, camera| check_camera(entries, camera, terrain.as_ref()))
            .unwrap_or_default(),
        view_mode: reader.file("viewMode.conf", unchecked).unwrap_or_default(),
        sky: reader.file("sky.conf", unchecked).unwrap_or_default(),
        terrain: terrain.clone().unwrap_or_default(),
        materials: Materials {
            ground: reader.file("materials/ground.mat", unchecked).unwrap_or_default(),
            rock: reader.file("materials/rock.mat", unchecked).unwrap_or_default(),
            plant: reader.file("materials/plant.mat", unchecked).unwrap_or_default(),
            leaf: reader.file("materials/leaf.mat", unchecked).unwrap_or_default(),
            bark: reader.file("materials/bark.mat", unchecked).unwrap_or_default(),
        },
        trees: reader.files("trees", |file, ending| match ending {
            "lsys" => reader.file(file, check_symbols).map(Tree::LSystem),
            "honda" => reader.file(file, unchecked).map(Tree::Honda),
            _ => None,
        }),
        plants: reader.files("plants", |file, ending| match ending {
            "lsys" => reader.file(file, check_symbols),
            _ => None,
        }),
        leafs: reader.files("leafs", |file, ending| match ending {
            "lsys" => {
                let leaf: LSystem = reader.file(file, check_symbols)?;
                reader.leaf(file, leaf.growth(&[]), leaf.height, leaf.material)
            }
            "family" => {
                let leaf: Family = reader.file(file, unchecked)?;
                reader.leaf(file, leaf.growth(), leaf.height, leaf.material)
            }
            _ => None,
        }),
        spawners: reader.files("spawners", |file, ending| match ending {
            "spawner" => reader.file(file, |entries, spawner| check_spawner(entries, spawner, folder)),
            _ => None,
        }),
    };
    mistakes.check(folder)?;
    Ok(settings)
}

/// Reads files, and notes what is wrong.
struct Reader<'a> {
    folder: &'a Folder,
    mistakes: &'a Mistakes,
}

impl Reader<'_> {
    /// What a file says, if nothing is wrong with it; `check` looks at it as a whole once every part of it is good.
    fn file<S: parameters::Settings>(&self, file: &str, check: impl Fn(&Entries, &S)) -> Option<S> {
        let before = self.mistakes.count();
        let good = || self.mistakes.count() == before;
        let entries = Entries::of::<S>(file, self.text(file)?, self.mistakes);
        let settings = S::read(&entries);
        if good() {
            check(&entries, &settings);
        }
        good().then_some(settings)
    }

    /// A leaf that grows like this to a height.
    fn leaf(&self, file: &str, growth: Growth, height: f64, material: Substance) -> Option<Leaf> {
        match growth.height() {
            Ok(grown) => Some(Leaf { growth, material, scale: height / grown }),
            Err(problem) => {
                let title = format!("`{file}` grows into no leaf");
                self.mistakes.note(file, None, title, Complaint::new("", problem));
                None
            }
        }
    }

    fn text(&self, file: &str) -> Option<&str> {
        let bytes = match self.folder.files.get(file) {
            Some(Contents::Bytes(bytes)) => bytes,
            Some(Contents::Unreadable(why)) => {
                let complaint = Complaint { cause: Cause::File, ..Complaint::new("", why) };
                self.mistakes.note(file, None, format!("`{file}` can't be read"), complaint);
                return None;
            }
            None => {
                self.missing(file, format!("`{file}` is missing"), "every folder of settings has it");
                return None;
            }
        };
        if bytes.len() > MAX_FILE {
            let complaint = Complaint::new("", format!("at most {MAX_FILE} bytes"));
            self.mistakes.note(file, None, format!("`{file}` is too long"), complaint);
            return None;
        }
        std::str::from_utf8(bytes)
            .map_err(|error| {
                let good = error.valid_up_to();
                let span = good..good + '\u{fffd}'.len_utf8();
                let complaint = Complaint::new("is not UTF-8 text", "this byte is no part of a character");
                self.mistakes.note(file, Some(span), format!("`{file}` is not UTF-8 text"), complaint);
            })
            .ok()
    }

    /// A folder that lacks something says something wrong, like a file without a name that must be there.
    fn missing(&self, file: &str, title: String, label: &str) {
        self.mistakes.note(file, None, title, Complaint::new("", label));
    }

    /// What the files in a folder say, in the order of their names.
    fn files<T>(&self, name: &str, read: impl Fn(&str, &str) -> Option<T>) -> Vec<Named<T>> {
        self.folder
            .files_in(name)
            .filter_map(|file| {
                let says = read(file, file.rsplit_once('.').map_or("", |(_, ending)| ending))?;
                Some(Named { file: file.into(), says })
            })
            .collect()
    }

    /// Refuses what nobody would read, and folders that are missing.
    fn names(&self) {
        let folder = self.folder;
        for name in FOLDERS.into_iter().filter(|name| *name != "leafs" && !folder.folders.contains(*name)) {
            let title = format!("the folder `{name}` is missing");
            self.missing(name, title, "it may be empty");
        }
        for name in folder.folders.iter().filter(|name| !FOLDERS.contains(&name.as_str())) {
            let complaint = guess("", name, FOLDERS.into_iter(), String::new());
            // Pictures and notes are nobody's business; `leaves` is.
            if complaint.help.is_some() {
                let title = format!("the folder `{}` is unknown", shown(name));
                self.mistakes.note(name, None, title, Complaint { help: None, ..complaint });
            }
        }
        for file in folder.files.keys() {
            let (within, name) = file.rsplit_once('/').unwrap_or(("", file));
            let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
            let endings: &[&str] = match within {
                "materials" => &["mat"],
                "trees" => &["lsys", "honda"],
                "plants" => &["lsys"],
                "leafs" => &["lsys", "family"],
                "spawners" => &["spawner"],
                _ => &["conf"],
            };
            let known_ending = endings.iter().any(|ending| name == format!("{stem}.{ending}"));
            let title = format!("the file `{}` is unknown", shown(file));
            if !known_ending {
                let allowed = endings.iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>();
                let label = format!("names in `{within}` end in {}", allowed.join(" or "));
                self.mistakes.note(file, None, title, Complaint::new("", label));
            } else if within.is_empty() && !FILES.contains(&name) {
                let known = format!("known here: {}", FILES.join(", "));
                self.mistakes.note(file, None, title, guess("", name, FILES.into_iter(), known));
            } else if within == "materials" && !MATERIALS.contains(&stem) {
                let known = format!("known here: {}", MATERIALS.join(", "));
                self.mistakes.note(file, None, title, guess("", stem, MATERIALS.into_iter(), known));
            }
        }
    }
}

fn unchecked<S>(_: &Entries, _: &S) {}

fn check_camera(entries: &Entries, camera: &Camera, terrain: Option<&Terrain>) {
    let half = terrain.map_or(f64::INFINITY, |terrain| terrain.size / 2.0);
    // A terrain that is small for what stands for nothing written has room in its middle.
    if entries.has("EdgeMinOffset") && camera.edge_min_offset > half {
        let label = format!("allowed: up to {half}, half of `Size` in terrain.conf");
        entries.refuse("EdgeMinOffset", Complaint::new("leaves no place to stand", label));
    }

    if let [0.0, _, 0.0] = camera.look_direction {
        let complaint = Complaint::new("points nowhere", "its first or third number must not be 0");
        entries.refuse(
            "LookDirection",
            complaint.help("how far up or down the camera looks follows from the ground"),
        );
    }
}

fn check_terrain(entries: &Entries, terrain: &Terrain) {
    if terrain.ground_end <= terrain.rock_start {
        let label = format!("allowed: above `RockStartY`, {}", terrain.rock_start);
        // The one that is written, of the two.
        let name = if entries.has("GroundEndY") { "GroundEndY" } else { "RockStartY" };
        entries.refuse(name, Complaint::new("leaves no ground below the rock", label));
    }
}

fn check_spawner(entries: &Entries, spawner: &Spawner, folder: &Folder) {
    if spawner.max_element_scale < spawner.min_element_scale {
        let label = format!("allowed: `MinElementScale`, {}, and more", spawner.min_element_scale);
        let name = if entries.has("MaxElementScale") { "MaxElementScale" } else { "MinElementScale" };
        entries.refuse(name, Complaint::new("leaves no size to choose", label));
    }
    let within = match spawner.generator_type {
        Generator::Tree => "trees",
        Generator::Plant => "plants",
    };
    if folder.files_in(within).next().is_none() {
        let label = format!("the folder `{within}` holds none");
        entries.refuse("GeneratorType", Complaint::new("names what there is none of", label));
    }
}

/// Letters that the turtle does not know must grow into something, and what grows must occur.
fn check_symbols(entries: &Entries, system: &LSystem) {
    let occurs = |symbol: char| {
        symbol == system.axiom || system.productions.iter().any(|production| production.word.contains(symbol))
    };
    if let Some(idle) = system.productions.iter().find(|production| !occurs(production.symbol)) {
        let problem = format!("is for `{}`, which never occurs", idle.symbol);
        let label = "it stands in no word, and is not the axiom";
        entries.refuse_production(idle.symbol, Complaint::new(problem, label));
    }
    let grows = |symbol: char| {
        TURTLE.contains(symbol) || system.productions.iter().any(|production| production.symbol == symbol)
    };
    if !grows(system.axiom) {
        let problem = format!("is `{}`, which means nothing", system.axiom);
        let label = format!(
            "the turtle does not know it, and no `Prod {} > …` says what it grows into",
            system.axiom
        );
        entries.refuse("Axiom", Complaint::new(problem, label));
    }
    for production in &system.productions {
        if let Some(idle) = production.word.chars().find(|&symbol| !grows(symbol)) {
            let problem = format!("holds `{idle}`, which means nothing");
            let label =
                format!("the turtle does not know it, and no `Prod {idle} > …` says what it grows into");
            entries.refuse_production(production.symbol, Complaint::new(problem, label));
        }
    }
}
