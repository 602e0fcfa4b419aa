//! What `terrane export` writes, read by programs of other makes: OpenImageIO, GDAL, trimesh and the Khronos glTF validator,
//! which are fetched from PyPI and npm.

mod kit;

use kit::land;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use terrane::terrain::Layer;
use terrane::world::{self, Overrides};

/// A world with every layer, in a second.
const WORLD: &str = r#"
format = 1
seed = 5
[terrain]
cells = 65
extent = 2000
layers = [{ cone = { height = 500, radius = 900 } }, { simplex = { amplitude = 60, wavelength = 500, octaves = 4 } }]
[sea]
level = 60
[erosion.hydraulic]
duration = 40
[reef]
stages = [{ duration = 200, rise = 2 }]
"#;

#[test]
#[ignore = "fetches readers from PyPI and npm"]
fn readers_of_other_makes_find_what_was_simulated() {
    let readers = readers();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), WORLD).unwrap();
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
    run(Command::new("node")
        .arg(script("validate.js"))
        .arg(readers.join("node_modules"))
        .args(meshes.map(|mesh| folder.path().join(mesh))));
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
    let _turn = kit::turn();
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(["export", "world.toml", "--quiet"]).args(arguments.split(' ')).current_dir(folder);
    run(command.env("TERRANE_VALIDATION", "1").env("TERRANE_CACHE", folder.join("cache")));
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers").join(name)
}

#[track_caller]
fn run(command: &mut Command) {
    let status = command.status().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(status.success(), "{command:?}: {status}");
}
