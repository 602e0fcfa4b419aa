//! Disks that fail under the program: whichever access to the files that it makes is refused, it says so and exits with 7, what was
//! there is whole, nothing unfinished is left, and the same command makes the same bytes when the disk is sound again.
//!
//! The program is the one that is shipped: `faults/faults.c` is loaded before the C library and stands for the disk.

#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use tempfile::TempDir;
use terrane::world::shard;

/// Bare ground, and a camera that flies past.
const WORLD: &str = r#"
format = 1
erosion = "none"
reef = "none"
[terrain]
cells = 64
extent = 2000
layers = [{ cone = { height = 500, radius = 900 } }]
[camera]
keyframes = [
  { frame = 0, position = [0, 300, 2500], target = [0, 200, 0] },
  { frame = 2, position = [900, 400, 2300] },
]
[render]
renderer = "trace"
size = [16, 9]
spp = 2
"#;

/// The disk that fails, as a library.
fn library() -> &'static Path {
    static SHARED: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = SHARED.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("faults.so");
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/faults/faults.c");
        // Rust links with `cc`, so there is one.
        let compiled = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror", "-o"])
            .arg(&path)
            .args([source, "-ldl"])
            .status();
        assert!(compiled.expect("a C compiler").success());
        (folder, path)
    });
    path
}

/// What lies in a folder and in those within: bytes by name.
type Contents = BTreeMap<PathBuf, Vec<u8>>;

/// A folder with a world, and one within, `out`, on the disk that fails.
struct Stage {
    _folder: TempDir,
    root: PathBuf,
    out: PathBuf,
}

/// How the disk fails.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// One access is refused.
    Io,
    /// There is no more room from one access on.
    Full,
}

impl Stage {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        // The library knows no symbolic links.
        let root = folder.path().canonicalize().unwrap();
        fs::write(root.join("world.toml"), WORLD).unwrap();
        let out = root.join("out");
        fs::create_dir(&out).unwrap();
        Stage { _folder: folder, root, out }
    }

    /// The program; `@` in its arguments is the folder on the disk that fails.
    fn command(&self, arguments: &str) -> Command {
        let arguments = arguments.replace('@', self.out.to_str().unwrap());
        let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
        command.args(arguments.split_whitespace()).arg("--quiet").current_dir(&self.root);
        command.env("TERRANE_CACHE", self.root.join("cache"));
        command
    }

    #[track_caller]
    fn run(&self, arguments: &str) {
        let output = self.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    }

    /// Runs the program on a disk whose access number `at` is the first to fail; and which failed. With 0, none fails and all are named.
    fn run_on(&self, arguments: &str, kind: Kind, at: usize) -> (Output, Vec<String>) {
        let log = self.root.join("log");
        let _ = fs::remove_file(&log);
        let child = self
            .command(arguments)
            .env("LD_PRELOAD", library())
            .env("FAULTS_FOLDER", &self.out)
            .env("FAULTS_KIND", if matches!(kind, Kind::Full) { "full" } else { "io" })
            .env("FAULTS_AT", at.to_string())
            .env("FAULTS_LOG", &log)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // It is in the names of files that are not finished.
        let process = child.id().to_string();
        let output = child.wait_with_output().unwrap();
        let failed = fs::read_to_string(&log).unwrap_or_default();
        (output, failed.lines().map(|line| line.replace(&process, "")).collect())
    }

    fn contents(&self) -> Contents {
        fn read(folder: &Path, root: &Path, contents: &mut Contents) {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    read(&path, root, contents);
                } else {
                    contents.insert(path.strip_prefix(root).unwrap().into(), fs::read(&path).unwrap());
                }
            }
        }
        let mut contents = Contents::new();
        read(&self.out, &self.out, &mut contents);
        contents
    }

    fn restore(&self, contents: &Contents) {
        fs::remove_dir_all(&self.out).unwrap();
        fs::create_dir(&self.out).unwrap();
        for (name, bytes) in contents {
            let path = self.out.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
    }

    /// Lets accesses of a command fail, one run each: those that `chosen` says of all that there are. Then `again`, if that is given,
    /// has to end in what the command would have made on a sound disk.
    #[track_caller]
    fn try_faults(&self, arguments: &str, again: Option<&str>, chosen: impl Fn(Kind, &[String]) -> Vec<usize>) {
        let before = self.contents();
        let mut tried = 0;
        for kind in [Kind::Io, Kind::Full] {
            self.restore(&before);
            let (output, accesses) = self.run_on(arguments, kind, 0);
            assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
            let after = self.contents();
            let chosen = chosen(kind, &accesses);
            assert!(!chosen.is_empty(), "{arguments}: {kind:?} of {accesses:#?}");
            for index in chosen {
                self.restore(&before);
                let (output, failed) = self.run_on(arguments, kind, index + 1);
                let case = format!("{arguments}: {kind:?} at {index}, {failed:?}: {}", stderr(&output));
                assert_eq!(failed.first(), Some(&accesses[index]), "{case}");
                let now = self.contents();
                // What can't be read may be made again.
                let reads = ["open ", "read "].iter().any(|start| accesses[index].starts_with(start));
                let is_mended = reads && output.status.success() && now == after;
                if !is_mended {
                    assert_eq!(output.status.code(), Some(7), "{case}");
                    assert!(stderr(&output).starts_with("error: "), "{case}");
                }
                assert_whole(&self.out, &now, [&before, &after], &case);
                if let Some(again) = again {
                    self.run(again);
                    let made = self.contents();
                    assert!(made == after, "{case}: then {:?}", made.keys());
                }
                tried += 1;
            }
            self.restore(&after);
        }
        eprintln!("{arguments}: {tried} accesses failed");
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file is what it was or what it was to become, and none is missing.
#[track_caller]
fn assert_whole(folder: &Path, now: &Contents, [before, after]: [&Contents; 2], case: &str) {
    for (name, bytes) in now {
        let is_known = [before, after].iter().any(|known| known.get(name) == Some(bytes));
        // What is between the first and the last sample is known by its checksum.
        let is_checkpoint = || {
            let is_named = name.to_str().unwrap().contains(".checkpoint");
            is_named && shard::open(&folder.join(name)).is_ok_and(|shard| shard.is_some())
        };
        assert!(is_known || is_checkpoint(), "{case}: {} is damaged", name.display());
    }
    for name in before.keys().filter(|name| after.contains_key(*name)) {
        let older = PathBuf::from(format!("{}.1", name.display()));
        assert!(now.contains_key(name) || now.contains_key(&older), "{case}: {} is missing", name.display());
    }
}

fn all(_: Kind, accesses: &[String]) -> Vec<usize> {
    (0..accesses.len()).collect()
}

/// The first access of each kind: where a run takes seconds.
fn of_each_kind(_: Kind, accesses: &[String]) -> Vec<usize> {
    let kinds: Vec<&str> = accesses.iter().filter_map(|access| access.split(' ').next()).collect();
    (0..kinds.len()).filter(|index| !kinds[..*index].contains(&kinds[*index])).collect()
}

/// A picture of samples that are there is only written, in no time: every access is tried.
#[test]
fn pictures_and_their_checkpoints() {
    let stage = Stage::new();
    stage.run("render world.toml -o @/a.exr");
    let half = "render world.toml -o @/a.exr --resume --half";
    stage.try_faults(half, Some(half), all);
    fs::rename(stage.out.join("a.exr.checkpoint"), stage.out.join("a.png.checkpoint")).unwrap();
    let png = "render world.toml -o @/a.png --resume";
    stage.try_faults(png, Some(png), all);
}

/// While it is traced, too, and what is there of another run is refined.
#[test]
fn pictures_that_are_refined() {
    let stage = Stage::new();
    stage.run("render world.toml -o @/a.exr --spp 1");
    let refine = "render world.toml -o @/a.exr --resume";
    // Of the first of the checkpoints, and of the last: its writing, and both of its renamings.
    let chosen = |kind, accesses: &[String]| {
        let found = |what: &str| {
            let is_it = |index: &usize| accesses[*index].starts_with(what);
            (0..accesses.len()).filter(is_it).collect::<Vec<_>>()
        };
        let (renamings, writes) = (found("rename"), found("write"));
        assert!(renamings.len() > 2, "{accesses:#?}");
        match kind {
            Kind::Io => renamings[..2].into(),
            Kind::Full => vec![writes[1]],
        }
    };
    stage.try_faults(refine, Some(refine), chosen);
}

#[test]
fn merged_pictures_and_differences() {
    let stage = Stage::new();
    stage.run("render world.toml -o @/a.exr");
    stage.try_faults("merge @/a.exr.checkpoint -o @/b.exr", None, all);
    stage.try_faults("merge @/a.exr.checkpoint -o @/b.png", None, all);
    stage.try_faults("compare @/a.exr @/b.exr -o @/c.png", None, all);
}

#[test]
fn exported_files() {
    let stage = Stage::new();
    for out in ["height -o @/h.tif", "height -o @/h.exr", "height -o @/h.png", "height -o @/h.r16", "mesh -o @/m.glb"] {
        let export = format!("export world.toml --layer {out}");
        stage.try_faults(&export, None, all);
        // Over one that is there.
        if out.ends_with("tif") {
            stage.try_faults(&format!("{export} --seed 2"), None, all);
        }
    }
    stage.try_faults("export world.toml --layer mitsuba -o @/scene/", None, of_each_kind);
}
