//! Taking the noise out of traced pictures: the program that does it is a script here, which halves nothing, guesses nothing, and
//! gives back what it gets.

use crate::kit;
use crate::kit::program::{good, terrane, told};
use exr::prelude::read_all_flat_layers_from_file;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Output;
use tempfile::TempDir;

const WORLD: &str = "format = 1\nerosion = \"none\"\nreef = \"none\"\n[terrain]\ncells = 64\n";

/// Gives back the picture; remembers what it was asked.
const ECHO: &str = r#"#!/bin/sh
[ "$1" = --help ] && exit 0
echo "$@" > asked
while [ $# -gt 1 ]; do
    case $1 in --hdr) colour=$2;; --nrm) normal=$2;; -o) out=$2;; esac
    shift 2
done
[ -s "$normal" ] && cp "$colour" "$out"
"#;

/// Answers with the normals instead of the picture.
const NORMALS: &str = r#"#!/bin/sh
[ "$1" = --help ] && exit 0
cp "$6" "$8"
"#;

const FAILS: &str = "#!/bin/sh\n[ \"$1\" = --help ] && exit 0\necho 'no memory for it' >&2\nexit 3\n";
const SHORT: &str = "#!/bin/sh\n[ \"$1\" = --help ] && exit 0\nprintf 'PF\\n32 18\\n-1.0\\nshort' > \"$8\"\n";

#[test]
fn the_picture_is_what_the_program_gives_back() {
    let _turn = kit::turn();
    let folder = folder();
    good(&render(&folder, &["-o", "plain.exr"]));
    let plain = channels(&folder.path().join("plain.exr"));

    script(&folder, ECHO);
    good(&render(&folder, &["-o", "same.exr", "--denoise=./denoise"]));
    let same = channels(&folder.path().join("same.exr"));
    for (name, values) in &plain {
        assert_eq!(*values, same[name], "{name}");
    }
    for color in ["R", "G", "B"] {
        assert_eq!(same[&format!("noisy.{color}")], plain[color]);
    }
    let asked = fs::read_to_string(folder.path().join("asked")).unwrap();
    let options: Vec<&str> = asked.split_whitespace().step_by(2).collect();
    assert_eq!(options, ["--hdr", "--alb", "--nrm", "-o"]);

    script(&folder, NORMALS);
    good(&render(&folder, &["-o", "other.exr", "--denoise=./denoise"]));
    let other = channels(&folder.path().join("other.exr"));
    for (color, axis) in [("R", "normal.X"), ("G", "normal.Y"), ("B", "normal.Z")] {
        assert_eq!(other[color], plain[axis]);
        assert_eq!(other[&format!("noisy.{color}")], plain[color]);
    }
    // What is seen on a screen is the same picture.
    good(&render(&folder, &["-o", "other.png", "--denoise=./denoise"]));
    good(&render(&folder, &["-o", "plain.png"]));
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("other.png") != read("plain.png"));
}

/// Nothing is lost: what can't be found is told at once, and what fails leaves the picture as it was traced.
#[test]
fn a_program_that_fails_costs_no_picture() {
    let _turn = kit::turn();
    let folder = folder();
    let missing = render(&folder, &["-o", "a.exr", "--denoise=./none"]);
    told(&missing, 1, "./none");
    assert!(!folder.path().join("a.exr").exists());

    for (program, part) in [(FAILS, "no memory for it"), (SHORT, "not a picture of that size")] {
        script(&folder, program);
        let failed = render(&folder, &["-o", "a.exr", "--denoise=./denoise"]);
        told(&failed, 1, part);
        told(&failed, 1, "a.exr was written with its noise");
        assert!(!channels(&folder.path().join("a.exr")).contains_key("noisy.R"));
        fs::remove_file(folder.path().join("a.exr")).unwrap();
    }
    told(
        &render(&folder, &["-o", "a.exr", "--renderer", "raster", "--denoise=./denoise"]),
        2,
        "--renderer trace",
    );
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), WORLD).unwrap();
    folder
}

fn script(folder: &TempDir, text: &str) {
    let path: PathBuf = folder.path().join("denoise");
    // Another file each time: one that runs can't be written.
    let _ = fs::remove_file(&path);
    fs::write(&path, text).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

fn render(folder: &TempDir, arguments: &[&str]) -> Output {
    let common = ["render", "world.toml", "--spp", "2", "--size", "32x18", "--no-cache", "--quiet"];
    let renderer: &[&str] = if arguments.contains(&"--renderer") { &[] } else { &["--renderer", "trace"] };
    terrane(folder.path(), &[&common, renderer, arguments].concat())
}

fn channels(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let image = read_all_flat_layers_from_file(path).unwrap();
    let list = &image.layer_data[0].channel_data.list;
    list.iter()
        .map(|channel| (channel.name.to_string(), channel.sample_data.values_as_f32().collect()))
        .collect()
}
