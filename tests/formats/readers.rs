//! What `terrane export` writes, read by programs of other makes: OpenImageIO, GDAL, trimesh and the Khronos glTF validator,
//! which are fetched from PyPI and npm.

use crate::kit;
use crate::kit::land;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use terrane::terrain::Layer;
use terrane::world::{self, Overrides};

#[test]
#[ignore = "fetches readers from PyPI and npm"]
fn readers_of_other_makes_find_what_was_simulated() {
    let readers = readers();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), kit::program::EVERY_LAYER).unwrap();
    simulate(folder.path());
    for arguments in [
        "--layer all -o exr/",
        "--layer all --format tif -o tif/",
        "--layer all --format png16 -o png16/",
        "--layer all --format r16 -o r16/",
        "--layer all --format r16 --byte-order big --flip -o big/",
        "--layer all -o all.exr",
        "--tiles 2x2 -o tiles/",
        "--layer height,splat --preset unreal --cells 127 -o unreal/",
        "--cells 127 -o unreal/exact/",
        "--layer height,splat --preset unity --cells 65 -o unity/",
        "--mesh-error 0 -o mesh0.glb",
        "--mesh-error 0 -o mesh0.ply",
        "--mesh-error 0 -o mesh0.obj",
        "--mesh-error 2 -o mesh2.glb",
        "--mesh-error 2 -o mesh2.ply",
        "--mesh-error 2 -o mesh2.obj",
        // Indices of 32 bits, and tiles.
        "--mesh-error 0 --cells 300 -o large.glb",
        "--layer mesh --tiles 2x2 -o tiles/",
    ] {
        export(folder.path(), arguments);
    }

    run(Command::new(readers.join("python/bin/python")).arg(script("layers.py")).arg(folder.path()));
    let meshes =
        ["mesh0.glb", "mesh2.glb", "large.glb", "tiles/terrain_x0_y0.glb", "tiles/terrain_x1_y1.glb"];
    validate(&readers, folder.path(), &meshes);
}

/// Plants of every kind, rocks and land, in all forms that they are written in.
#[test]
#[ignore = "fetches readers from PyPI and npm"]
fn readers_of_other_makes_find_no_fault_with_plants_and_scenes() {
    let readers = readers();
    let folder = tempfile::tempdir().unwrap();
    let species: Vec<PathBuf> = fs::read_dir(root().join("configs/species"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    let mut files = Vec::new();
    for path in &species {
        let name = format!("{}.glb", path.file_stem().unwrap().to_str().unwrap());
        terrane(folder.path(), &["plant", path.to_str().unwrap(), "-o", &name]);
        files.push(name);
    }
    let [oak, grass] = ["oak", "grass"].map(|name| root().join(format!("configs/species/{name}.toml")));
    let planted = PLANTED.replace("OAK", oak.to_str().unwrap()).replace("GRASS", grass.to_str().unwrap());
    fs::write(folder.path().join("world.toml"), planted).unwrap();
    fs::write(
        folder.path().join("rock.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n",
    )
    .unwrap();
    for arguments in [
        "--layer plants -o plants.glb",
        "--layer plants --instancing off --lod 2 -o nodes.glb",
        "--layer scene -o scene.glb",
        "--layer scene --instancing off --mesh-error 0 --lod 3 -o scene_nodes.glb",
    ] {
        export(folder.path(), arguments);
    }
    files.extend(["plants", "nodes", "scene", "scene_nodes"].map(|name| format!("{name}.glb")));
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    validate(&readers, folder.path(), &files);
}

/// A world with plants of several models, a model from a file, sea, sun and camera.
const PLANTED: &str = r#"
format = 1
seed = 5
erosion = "none"
reef = "none"
[terrain]
cells = 65
extent = 400
layers = [{ cone = { height = 60, radius = 180 } }]
[sea]
level = 10
[species.oak]
file = "OAK"
[species.grass]
file = "GRASS"
[[models]]
file = "rock.obj"
height = 2
at = [[0, 0], [10, 20, 45, 2]]
[[plants]]
scatter = { species = ["oak", "rock"], spacing = 25 }
[[plants]]
cover = { species = ["grass"], density = 0.5 }
[camera.view.stand]
at = [0, 60]
"#;

/// Runs the Khronos validator over .glb files.
fn validate(readers: &Path, folder: &Path, files: &[&str]) {
    run(Command::new("node")
        .arg(script("validate.js"))
        .arg(readers.join("node_modules"))
        .args(files.iter().map(|file| folder.join(file))));
}

/// The folder that the readers are in.
fn readers() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readers");
    run(Command::new("sh").arg(script("install.sh")).arg(&folder));
    folder
}

/// Writes every layer of the simulation as bare floats, little-endian.
fn simulate(folder: &Path) {
    let world = world::load(&folder.join("world.toml"), &Overrides::default()).unwrap();
    let gpu = kit::gpu();
    let simulation = land::finished(&gpu, &world.plan);
    fs::create_dir(folder.join("simulated")).unwrap();
    for layer in Layer::ALL {
        let values = land::layer(&gpu, &simulation, layer);
        let bytes: Vec<u8> = values.into_iter().flat_map(f32::to_le_bytes).collect();
        fs::write(folder.join(format!("simulated/{}.f32", layer.name())), bytes).unwrap();
    }
}

fn export(folder: &Path, arguments: &str) {
    let command: Vec<&str> =
        ["export", "world.toml", "--quiet"].into_iter().chain(arguments.split(' ')).collect();
    terrane(folder, &command);
}

fn terrane(folder: &Path, arguments: &[&str]) {
    let _turn = kit::turn();
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(arguments).current_dir(folder);
    run(command.env("TERRANE_VALIDATION", "1").env("TERRANE_CACHE", folder.join("cache")));
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn script(name: &str) -> PathBuf {
    root().join("tests/formats/readers").join(name)
}

#[track_caller]
fn run(command: &mut Command) {
    let status = command.status().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(status.success(), "{command:?}: {status}");
}
