//! The shipped forests: they check, and the small one looks as it should.

use crate::kit;
use crate::kit::picture::flip;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const FOLDERS: [&str; 2] = ["forest", "landscape"];

fn shipped() -> Vec<PathBuf> {
    let of = |folder: &str| {
        let entries =
            fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(folder)).unwrap();
        entries
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|it| it == "toml"))
    };
    let mut paths: Vec<PathBuf> = FOLDERS.into_iter().flat_map(of).collect();
    paths.sort();
    paths
}

fn terrane(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(arguments).current_dir(folder).env("TERRANE_VALIDATION", "1");
    command.env("TERRANE_CACHE", folder.join("cache")).output().unwrap()
}

#[track_caller]
fn good(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!String::from_utf8_lossy(&output.stderr).contains("warning"), "{output:?}");
}

#[test]
fn every_shipped_forest_checks_without_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let paths = shipped();
    let names: Vec<_> = paths.iter().map(|path| path.file_stem().unwrap().to_string_lossy()).collect();
    assert_eq!(names, ["dead", "debug", "default", "mountain", "tiny", "million", "reef_forest"]);
    for path in &paths {
        good(&terrane(&["check", "--no-time", path.to_str().unwrap()], folder.path()));
    }
}

/// The same bits twice; and what somebody has looked at.
#[test]
fn the_small_forest_looks_as_it_should() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let world = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/forest/tiny.toml");
    let render = |name: &str| {
        good(&terrane(&["render", world, "--renderer", "raster", "--no-cache", "-o", name], folder.path()));
        fs::read(folder.path().join(name)).unwrap()
    };
    let (first, second) = (render("one.png"), render("two.png"));
    assert!(first == second, "two runs give two pictures");

    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/forest.png");
    if std::env::var_os("TERRANE_BLESS").is_some() {
        fs::write(golden, &first).unwrap();
    }
    let read = |path: &Path| image::open(path).expect("a picture").into_rgb8();
    let (golden, found) = (read(Path::new(golden)), read(&folder.path().join("one.png")));
    // Drivers differ in the last bits of sin and exp, and by a sample on outlines, of which leaves have many.
    const THRESHOLD: f32 = 0.02;
    let difference = flip(&golden, &found);
    assert!(difference < THRESHOLD, "FLIP {difference}");

    // The comparison must see what an eye would: a little more light, a shift by a pixel, another plant.
    let mut brighter = found.clone();
    brighter.iter_mut().for_each(|value| *value = value.saturating_add(8));
    assert!(flip(&golden, &brighter) > THRESHOLD, "a brighter picture passes");
    let mut shifted = found.clone();
    shifted.rotate_left(3);
    assert!(flip(&golden, &shifted) > THRESHOLD, "a shifted picture passes");
    let other = ["render", world, "--renderer", "raster", "--no-cache", "-o", "other.png", "--seed", "6"];
    good(&terrane(&other, folder.path()));
    assert!(flip(&golden, &read(&folder.path().join("other.png"))) > THRESHOLD, "another forest passes");
}
