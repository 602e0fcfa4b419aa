//! What is fuzzed: sound files to begin with, and what reads them.

use super::{Files, one};
use std::fs;
use std::path::{Path, PathBuf};
use terrane::core::mesh::Mesh;
use terrane::formats::{self, Hints, Window, model, png, raw, tiff};
use terrane::plants::derive::{Derivation, Limits};
use terrane::plants::grammar::Grammar;
use terrane::plants::turtle::{self, Drawing, Interpretation};
use terrane::plants::watch::Watch;
use terrane::scene::{Level, Material, Model, Part};
use terrane::world::thesis::{self, Contents, Folder};
use terrane::world::{self, Overrides, species};

pub struct Target {
    pub name: &'static str,
    /// Sound files, and some that are known to be wrong.
    pub corpus: fn(folder: &Path) -> Vec<Files>,
    /// Reads files; `folder` is for those that must lie somewhere.
    pub read: fn(folder: &Path, files: &Files) -> Outcome,
    /// What the language knows.
    pub words: &'static [&'static str],
}

/// What came of it, in words: what leads to a new outcome is damaged further.
pub type Outcome = Result<String, String>;

pub const TARGETS: [Target; 6] = [
    Target { name: "grammars", corpus: grammars, read: read_grammar, words: GRAMMAR },
    Target { name: "worlds", corpus: worlds, read: read_world, words: WORLD },
    Target { name: "species", corpus: all_species, read: read_species, words: SPECIES },
    Target { name: "folders", corpus: folders, read: read_folder, words: FOLDER },
    Target { name: "models", corpus: models, read: read_model, words: MODEL },
    Target { name: "maps", corpus: maps, read: read_map, words: &[] },
];

/// What a mistake costs is bounded by what is allowed; here that is little, so that there are many trials.
const LIMITS: Limits = Limits {
    modules: 20_000,
    bytes: 4 << 20,
    steps: 100,
    work: 2_000_000,
    points: 40_000,
    watch: Watch::NONE,
};

// Grammars -----------------------------------------------------------------------------------------------------------

const GRAMMAR: &[&str] = &[
    "axiom ",
    " -> ",
    " -(1)> ",
    " < ",
    " > ",
    " : ",
    "[",
    "]",
    "(",
    ")",
    ",",
    "{",
    "}",
    "%",
    "~",
    "@",
    "$",
    "|",
    "*",
    "ε",
    "#",
    "\n",
    "\n  ",
    "&&",
    "||",
    "!=",
    "<=",
    ">=",
    "==",
    "rnd(0,1)",
    "min(",
    "sqrt(-1)",
    "ln(0)",
    "1/0",
    "^",
    "tan(90)",
    "A(x)",
    "F(1)",
    "1e308",
    "-",
    "+",
    "x",
    "ß",
    "\t",
    "\r\n",
    "\u{feff}",
    "A -> AA\n",
    "B -> *\n",
];

fn grammars(_: &Path) -> Vec<Files> {
    let species = files_in("configs/species", "toml").into_iter();
    let parts = species.flat_map(|(_, bytes)| {
        let species: toml_edit::DocumentMut = String::from_utf8(bytes).unwrap().parse().unwrap();
        let organs = species.get("organs").and_then(|organs| organs.as_table_like());
        let organs =
            organs.into_iter().flat_map(|organs| organs.iter().map(|(_, organ)| organ.get("grammar")));
        let grammars = organs.chain([species.get("grammar")]).flatten();
        grammars.filter_map(|grammar| grammar.as_str().map(str::to_owned)).collect::<Vec<_>>()
    });
    let conformance = include_str!("../../data/lsystem_conformance.json");
    let conformance: serde_json::Value = serde_json::from_str(conformance).unwrap();
    let systems = conformance["systems"].as_array().unwrap().iter().map(|system| {
        let text = |value: &serde_json::Value| value.as_str().map_or(value.to_string(), str::to_owned);
        let defines = system["defines"].as_object().unwrap().iter();
        let defines = defines.map(|(name, value)| format!("{name} = {}\n", text(value)));
        let productions = system["productions"].as_array().unwrap().iter();
        let productions = productions.map(|rule| format!("{}\n", text(rule)));
        defines.collect::<String>()
            + &format!("axiom {}\n", text(&system["axiom"]))
            + &productions.collect::<String>()
    });
    parts.chain(systems).map(|text| one("grammar", text.into_bytes())).collect()
}

fn read_grammar(_: &Path, files: &Files) -> Outcome {
    let text = String::from_utf8_lossy(&files[0].1);
    let grammar = match Grammar::parse(&text, "+-") {
        Ok(grammar) => grammar,
        Err(error) => {
            assert!(
                text.get(error.span.clone()).is_some(),
                "{error} points beside the text: {:?}",
                error.span
            );
            return Err(error.to_string());
        }
    };
    for warning in grammar.warnings() {
        assert!(text.get(warning.span.clone()).is_some(), "{warning} points beside the text");
    }
    let mut outcome = format!("{} warnings", grammar.warnings().len());
    match grow(&grammar) {
        Ok(told) => Ok(outcome + &told),
        Err((error, span)) => {
            assert!(text.get(span.clone()).is_some(), "{error} points beside the text: {span:?}");
            outcome += &error;
            Err(outcome)
        }
    }
}

fn grow(grammar: &Grammar) -> Result<String, (String, std::ops::Range<usize>)> {
    let told = |error: terrane::plants::derive::Error| (error.to_string(), error.span);
    let mut derivation = Derivation::new(grammar, 1, &LIMITS).map_err(told)?;
    for _ in 0..8 {
        derivation.step().map_err(told)?;
    }
    let word = derivation.into_word();
    let how = Interpretation { angle: 0.4, ..Interpretation::default() };
    Ok(match turtle::draw(&word, &how, &LIMITS) {
        Ok(Drawing { measure, .. }) => {
            format!("polygons {} brackets {}", measure.polygons.min(2), measure.brackets.min(2))
        }
        Err(error) => error.to_string(),
    })
}

// Worlds and species -------------------------------------------------------------------------------------------------

const WORLD: &[&str] = &[
    "[terrain]\n",
    "[erosion.hydraulic]\n",
    "[[plants]]\n",
    "[species.a]\n",
    "grammar = '''\naxiom F\n'''\n",
    "format = 1\n",
    "seed = ",
    "\"none\"",
    "{ cone = {} }",
    "{ simplex = {} }",
    "{ crater = {} }",
    "{ heightmap = { file = \"map.png\" } }",
    "layers = [",
    "]",
    "{",
    "}",
    "=",
    ".",
    "'''",
    "\"\"\"",
    "true",
    "nan",
    "-inf",
    "0x7fffffffffffffff",
    "1979-05-27",
    "\\u0000",
    "#",
    "\n",
    "[sky.preetham]\n",
    "[sun.direct]\n",
    "[camera.view.stand]\n",
    "[reef]\n",
    "stages = [",
    "preset = \"paper\"",
    "cells = 8192",
    "steps = \"auto\"",
];

fn worlds(_: &Path) -> Vec<Files> {
    let folders = ["configs/island", "configs/forest", "configs/landscape", "tests/data/bad_worlds"];
    let files = folders.iter().flat_map(|folder| files_in(folder, "toml"));
    let converted = thesis::read(&root().join("tests/data/thesis/default")).unwrap().text;
    files
        .map(|(_, bytes)| one("world.toml", bytes))
        .chain([one("world.toml", converted.into_bytes())])
        .collect()
}

fn read_world(folder: &Path, files: &Files) -> Outcome {
    match world::parse("world.toml", &files[0].1, folder, &Overrides::default()) {
        Ok(world) => Ok(format!(
            "{} warnings, {} species, {} rules, {} layers",
            world.warnings.len().min(5),
            world.plants.species.len().min(3),
            world.plants.rules.len().min(3),
            world.plan.layers.len().min(4)
        )),
        Err(error) => Err(error.to_string()),
    }
}

const SPECIES: &[&str] = &[
    "[materials.a]\n",
    "[organs.L]\n",
    "polygons = [",
    "{ vertices = [",
    "[0, 0, 0], ",
    "]",
    "}",
    "~L(1)",
    "~a",
    "axiom ",
    " -> ",
    "[",
    "(",
    ")",
    "{.",
    "}",
    "!(0.1)",
    "F(1)",
    "$",
    "'",
    "steps = \"auto\"",
    "steps = 3",
    "tropism = { direction = [0, 1, 0], strength = 5 }",
    "height = 3",
    "width = 0",
    "draw = \"\"",
    "silent = \"FG\"",
    "wood = \"a\"",
    "leaves = [\"a\"]",
    "variants = 64",
    "angle = 0",
    "1e308",
    "1e-300",
    "'''",
    "\"\"\"",
    "\n",
    "#",
];

fn all_species(_: &Path) -> Vec<Files> {
    files_in("configs/species", "toml").into_iter().map(|(_, bytes)| one("plant.toml", bytes)).collect()
}

fn read_species(_: &Path, files: &Files) -> Outcome {
    let loaded = match species::parse("plant.toml", &files[0].1) {
        Ok(loaded) => loaded,
        Err(error) => return Err(error.to_string()),
    };
    match loaded.species.grow(1, 0, &LIMITS) {
        Ok(model) => {
            for part in model.levels.iter().flat_map(|level| &level.parts) {
                check_mesh(&part.mesh, part.material, &model);
            }
            let (levels, materials) = (model.levels.len(), model.materials.len());
            Ok(format!("{} warnings, {levels} levels, {materials} materials", loaded.warnings.len()))
        }
        Err(error) => Err(loaded.source.blame(&error).to_string()),
    }
}

/// Whoever takes a model relies on it.
fn check_mesh(mesh: &Mesh, material: usize, model: &Model) {
    let vertices = mesh.positions.len();
    assert!(material < model.materials.len());
    assert!(mesh.triangles.as_flattened().iter().all(|&corner| (corner as usize) < vertices));
    assert!(mesh.normals.len() == vertices && mesh.uvs.len() == vertices);
    let finite = |values: &[[f32; 3]]| values.as_flattened().iter().all(|value| value.is_finite());
    assert!(finite(&mesh.positions) && finite(&mesh.normals));
}

// Folders of settings ------------------------------------------------------------------------------------------------

const FOLDER: &[&str] = &[
    "N ",
    "Size ",
    "Height ",
    "ConeBasePoints ",
    "Material Bark\n",
    "InitRadius ",
    "TurnAngle ",
    "Axiom ",
    "Prod ",
    " > ",
    "[",
    "]",
    "@",
    "{",
    "}",
    ".",
    "+",
    "\\",
    "F",
    "G",
    "\n",
    "#",
    "nan",
    "Resolution ",
    "PhotoName ",
    "../x",
    "Tree",
    "Plant",
    "GeneratorType ",
    "Color1 ",
    "Delta ",
    "LA ",
    "R1 ",
    "CellSize ",
    "true",
    "\u{feff}",
];

fn folders(_: &Path) -> Vec<Files> {
    let folders = fs::read_dir(root().join("tests/data/thesis")).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<Files> = folders.map(|path| below(&path, &path)).collect();
    // Each file is the one that is damaged most, in a folder of its own.
    let turned: Vec<Files> = folders
        .iter()
        .flat_map(|files| {
            (1..files.len()).map(|first| {
                let mut files = files.clone();
                files.swap(0, first);
                files
            })
        })
        .collect();
    folders.extend(turned);
    folders
}

fn below(root: &Path, path: &Path) -> Files {
    let mut entries: Vec<PathBuf> = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let read = |path: PathBuf| {
        if path.is_dir() {
            return below(root, &path);
        }
        one(path.strip_prefix(root).unwrap().to_str().unwrap(), fs::read(&path).unwrap())
    };
    entries.into_iter().flat_map(read).collect()
}

fn read_folder(folder: &Path, files: &Files) -> Outcome {
    let mut settings = Folder { name: "settings".into(), ..Folder::default() };
    for (name, bytes) in files {
        if let Some((within, _)) = name.rsplit_once('/') {
            settings.folders.insert(within.into());
        }
        settings.files.insert(name.clone(), Contents::Bytes(bytes.clone()));
    }
    let converted = match thesis::convert(&settings) {
        Ok(converted) => converted,
        Err(error) => return Err(error.to_string()),
    };
    // Whatever passes is a world; only how its plants grow may still be wrong.
    match world::parse("settings", converted.text.as_bytes(), folder, &Overrides::default()) {
        Ok(world) => {
            Ok(format!("{} species, {} rules", world.plants.species.len(), world.plants.rules.len()))
        }
        Err(error) => panic!("the folder was taken and became no world: {error}\n{}", converted.text),
    }
}

// Models -------------------------------------------------------------------------------------------------------------

const MODEL: &[&str] = &[
    "\"accessors\":[",
    "\"bufferViews\":[",
    "\"meshes\":[",
    "\"nodes\":[",
    "\"mesh\":0",
    "\"children\":[0]",
    "\"matrix\":[",
    "\"scale\":[0,0,0]",
    "\"count\":4294967295",
    "\"byteOffset\":",
    "\"byteStride\":255",
    "\"componentType\":5125",
    "\"extensionsRequired\":[\"x\"]",
    "\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":0}}",
    "\"sparse\":{}",
    "\"mode\":5",
    "{",
    "}",
    "[",
    "]",
    ",",
    "null",
    "-1",
    "1e39",
    "data:;base64,AAAA",
    "\nv 0 0 0",
    "\nvn 0 0 0",
    "\nvt 0 0",
    "\nf 1 2 3",
    "\nf -1 -2 -3",
    "\nf 1/1/1 2//2 3/3",
    "\nf 1 2 3 4 5 6",
    "\nusemtl x",
    "\nmtllib a.mtl",
    "\no x",
    "\ng x",
    "\nelement vertex 4294967295",
    "\nelement face 1",
    "\nproperty list uchar int vertex_indices",
    "\nproperty float x",
    "\nformat ascii 1.0",
    "\nformat binary_big_endian 1.0",
    "\nend_header\n",
    "\nKd 1 0 0",
    "\nnewmtl x",
    "nan",
    "\\\n",
];

/// A trunk and a leaf, in two levels: what we write ourselves of them, in each format, and variations by hand.
fn models(folder: &Path) -> Vec<Files> {
    let model = model();
    let mut corpus = Vec::new();
    for name in ["model.glb", "model.obj", "model.ply"] {
        let written = model::write(&folder.join(name), &model).unwrap();
        let file =
            |path: &Path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(path).unwrap());
        corpus.push(written.iter().map(|written| file(&written.path)).collect::<Files>());
    }
    let glb = corpus[0][0].1.clone();
    let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let text = String::from_utf8(glb[20..20 + json].to_vec()).unwrap();
    let length = glb.len() - json - 28;
    // The same with its numbers in a file of their own.
    let apart = text.replacen(
        &format!("\"byteLength\":{length}"),
        &format!("\"uri\":\"model.bin\",\"byteLength\":{length}"),
        1,
    );
    corpus.push(vec![
        ("model.gltf".into(), apart.into_bytes()),
        ("model.bin".into(), glb[json + 28..].to_vec()),
    ]);
    let cube = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\
        \"nodes\":[{\"mesh\":0,\"children\":[2],\"translation\":[1,2,3],\"rotation\":[0,0.6,0,0.8],\"scale\":[2,2,2]},\
        {\"mesh\":0,\"matrix\":[1,0,0,0,0,2,0,0,0,0,1,0,5,0,0,1]},\
        {\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":0}}}}],\
        \"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"mode\":4}]}],\
        \"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]},\
        {\"bufferView\":1,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"}],\
        \"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":3}],\
        \"buffers\":[{\"byteLength\":40,\"uri\":\"data:application/octet-stream;base64,\
        AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAECAA==\"}]}";
    corpus.push(one("model.gltf", cube.into()));
    let object = "mtllib model.mtl\no a\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl red\n\
        f 1/1/1 2/1/1 3/1/1 4/1/1\ng b\nusemtl blue\nf -4 -3 -2\nf 1//1 2//1 3//1\ns off\nl 1 2\n";
    let library = "newmtl red\nKd 1 0 0\nNi 1.5\nnewmtl blue\nKd 0 0 1\nd 0.5\nmap_Kd picture.png\n";
    corpus.push(vec![("model.obj".into(), object.into()), ("model.mtl".into(), library.into())]);
    let ascii = "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int vertex_indices\n\
        element edge 1\nproperty int a\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 0 9 9 9\n3 0 1 2\n4 0 1 2 3\n7\n";
    corpus.push(one("model.ply", ascii.into()));
    let big = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty short y\nproperty short z\n\
        element face 1\nproperty list ushort ushort vertex_index\nend_header\n\0\0\0\0\0\0\0\x01\0\0\0\0\0\0\0\x01\0\0\0\x03\0\0\0\x01\0\x02";
    corpus.push(one("model.ply", big.to_vec()));
    corpus
}

fn model() -> Model {
    let mesh = |corners: u32| {
        let mut mesh = Mesh::default();
        for corner in 0..corners {
            let (sin, cos) = (corner as f32).sin_cos();
            mesh.positions.push([cos, 0.5 * corner as f32, sin]);
            mesh.normals.push([cos, 0.0, sin]);
            mesh.uvs.push([0.25 * cos, 0.5]);
        }
        mesh.triangles.extend((2..corners).map(|corner| [0, corner - 1, corner]));
        mesh
    };
    let material = |name: &str| Material { name: name.into(), ..Material::default() };
    let level = |detail, corners| {
        let parts = vec![Part { material: 0, mesh: mesh(corners) }, Part { material: 1, mesh: mesh(3) }];
        Level { detail, parts }
    };
    let materials = vec![
        material("bark"),
        Material { transmittance: [0.1; 3], refractive_index: 1.4, ..material("leaf") },
    ];
    Model { name: "model".into(), materials, levels: vec![level(0.0, 8), level(0.5, 4)] }
}

fn read_model(folder: &Path, files: &Files) -> Outcome {
    for (name, bytes) in files {
        write(folder, name, bytes);
    }
    let path = folder.join(&files[0].0);
    let outcome = model::read(&path).and_then(|import| {
        let merged = import.merged(&path)?;
        let models = &import.population.models;
        for model in models.iter().chain([&merged]) {
            for part in model.levels.iter().flat_map(|level| &level.parts) {
                check_mesh(&part.mesh, part.material, model);
            }
        }
        for instance in import.population.instances.iter() {
            assert!((instance.model as usize) < models.len());
            assert!(
                instance.position.is_finite() && instance.rotation.is_finite() && instance.scale.is_finite()
            );
        }
        let triangles: usize = merged.levels.iter().map(Level::triangles).sum();
        Ok(format!("{} models, {} triangles, {:?}", models.len().min(3), triangles.min(3), import.warnings))
    });
    for (name, _) in files {
        let _ = fs::remove_file(folder.join(name));
    }
    outcome.map_err(|error| error.to_string())
}

// Maps ---------------------------------------------------------------------------------------------------------------

fn maps(folder: &Path) -> Vec<Files> {
    use crate::kit::tiff::{NO_DATA, Tiff, Value};
    let size = [24, 20];
    let values: Vec<f32> = (0..24 * 20).map(|index| (index * 37 % 480) as f32).collect();
    let window = Window::whole(&values, size, 1);
    let range = [0.0, 480.0];
    let read = |name: &str| one(name, fs::read(folder.join(name)).unwrap());
    let at = |name: &str| folder.join(name);

    png::write_integers(&at("map.png"), window, png::Depth::Sixteen, range).unwrap();
    png::write_integers(&at("small.png"), window, png::Depth::Eight, range).unwrap();
    raw::write(&at("map.r16"), window, range, raw::ByteOrder::Big).unwrap();
    let place = tiff::Georeference { origin: [0.0, 0.0], cell_size: 1.0 };
    tiff::write(&at("map.tif"), window, place).unwrap();
    formats::exr::write_channels(&at("map.exr"), size, vec![("height".into(), values.clone())]).unwrap();
    let pixels: Vec<[f32; 3]> = values.iter().map(|value| [*value; 3]).collect();
    formats::exr::write_picture(&at("picture.exr"), size, &pixels, 1.0).unwrap();
    let sidecar = br#"{"min": 0, "max": 480, "unit": "m", "samples": [24, 20], "first_row": "south", "byte_order": "big",
        "extent": 100, "tile": {"column": 0, "row": 1, "of": [2, 2]}}"#;
    let mut corpus: Vec<Files> =
        ["map.png", "small.png", "map.tif", "map.exr", "picture.exr"].into_iter().map(read).collect();
    corpus.push([read("map.r16"), one("map.r16.json", sidecar.to_vec())].concat());
    corpus.push([one("map.png.json", sidecar.to_vec()), read("map.png")].concat());
    corpus.push(one("map.raw", vec![1; 2 * 24 * 24]));
    let floats: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    for tiff in [
        Tiff::tiles(size, 16, 2, [16, 32], vec![vec![1; 1024], vec![2; 1024]]),
        Tiff::strips(size, 32, 3, 20, vec![floats.clone()]).with(NO_DATA, Value::Ascii("-1".into())),
        Tiff::strips(size, 8, 1, 10, vec![vec![9; 240], vec![200; 240]]),
    ] {
        corpus.push(one("map.tif", tiff.bytes()));
    }
    corpus
}

fn read_map(folder: &Path, files: &Files) -> Outcome {
    for (name, bytes) in files {
        write(folder, name, bytes);
    }
    let (map, _) = files.iter().find(|(name, _)| !name.ends_with(".json")).unwrap_or(&files[0]);
    let outcome = match formats::read_map(&folder.join(map), Hints::default()) {
        Ok(map) => {
            assert_eq!(map.values.len(), map.width as usize * map.height as usize);
            assert!(map.values.iter().all(|value| value.is_finite()));
            Ok(format!("{:?} {:?} {:?}", map.scale, map.range.is_some(), map.tile.is_some()))
        }
        Err(error) => Err(error.to_string()),
    };
    for (name, _) in files {
        let _ = fs::remove_file(folder.join(name));
    }
    outcome
}

// Files --------------------------------------------------------------------------------------------------------------

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join(name);
    // A name may have become one in a folder, or that of the folder of another.
    if let Some(within) = path.parent() {
        let _ = fs::create_dir_all(within);
    }
    let _ = fs::write(path, bytes);
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files of a folder of the project, by their names; none where there is no such folder.
fn files_in(folder: &str, ending: &str) -> Files {
    let entries = fs::read_dir(root().join(folder)).into_iter().flatten().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|found| found == ending)).collect();
    paths.sort();
    paths.iter().map(|path| (path.display().to_string(), fs::read(path).unwrap())).collect()
}
