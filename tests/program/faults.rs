//! Disks that fail under the program: whichever access to its files is refused, it says so and exits with 7, what was there is whole,
//! nothing unfinished is left, and the same command makes the same bytes when the disk is sound again. All accesses are tried for pictures
//! that finish, exports and the cache; chosen ones while pictures are traced, for each try compiles shaders.
//!
//! The program is the one that is shipped: `faults/faults.c` is loaded before the C library and stands for the disk.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;
use terrane::formats::file;
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
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/program/faults/faults.c");
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

impl Kind {
    fn refuses(self, access: &str) -> bool {
        let reads = access.starts_with("open ") || access.starts_with("read ");
        matches!(self, Kind::Io) || !reads
    }
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
        command.env("TERRANE_CACHE", self.root.join("cache")).env("TERRANE_CACHE_INTERVAL", "0");
        command
    }

    #[track_caller]
    fn run(&self, arguments: &str) {
        let output = self.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
    }

    /// Runs the program with the folder `disk` on a disk whose access number `at` is the first to fail; returns which ones failed. With 0
    /// none fails, and all are named.
    fn run_on(&self, disk: &Path, arguments: &str, kind: Kind, at: usize) -> (Output, Vec<String>) {
        let log = self.root.join("log");
        let _ = fs::remove_file(&log);
        let output = self
            .command(arguments)
            .env("LD_PRELOAD", library())
            .env("FAULTS_FOLDER", disk)
            .env("FAULTS_KIND", if matches!(kind, Kind::Full) { "full" } else { "io" })
            .env("FAULTS_AT", at.to_string())
            .env("FAULTS_LOG", &log)
            .output()
            .unwrap();
        let failed = fs::read_to_string(&log).unwrap_or_default();
        // Files that are not finished have numbers in their names.
        let named = |line: &str| match line.split_once("/.terrane-") {
            Some((before, _)) => format!("{before}/unfinished"),
            None => line.into(),
        };
        (output, failed.lines().map(named).collect())
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
    fn try_faults(
        &self,
        arguments: &str,
        again: Option<&str>,
        chosen: impl Fn(Kind, &[String]) -> Vec<usize>,
    ) {
        let before = self.contents();
        let (output, accesses) = self.run_on(&self.out, arguments, Kind::Io, 0);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {}", stderr(&output));
        let after = self.contents();
        let mut tried = 0;
        for kind in [Kind::Io, Kind::Full] {
            let accesses: Vec<_> = accesses.iter().filter(|access| kind.refuses(access)).cloned().collect();
            let chosen = chosen(kind, &accesses);
            for index in chosen {
                self.restore(&before);
                let (output, failed) = self.run_on(&self.out, arguments, kind, index + 1);
                let case = format!("{arguments}: {kind:?} at {index}, {failed:?}: {}", stderr(&output));
                assert_eq!(failed.first(), Some(&accesses[index]), "{case}");
                let now = self.contents();
                // What can't be read may be made again.
                let is_mended =
                    !Kind::Full.refuses(&accesses[index]) && output.status.success() && now == after;
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
        }
        self.restore(&after);
        assert!(tried > 0, "{arguments}: {accesses:#?}");
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
fn of_each_kind(accesses: &[String]) -> Vec<usize> {
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

/// Numbers of the accesses of one kind.
fn kind_of(what: &str, accesses: &[String]) -> Vec<usize> {
    (0..accesses.len()).filter(|index| accesses[*index].split(' ').next() == Some(what)).collect()
}

/// While it is traced, too, what is there of another run stays whole. Each try takes seconds.
#[test]
fn pictures_that_are_refined() {
    let stage = Stage::new();
    stage.run("render world.toml -o @/a.exr --spp 1");
    let refine = "render world.toml -o @/a.exr --resume";
    stage.try_faults(refine, Some(refine), |kind, accesses| {
        let (renamings, writes) = (kind_of("rename", accesses), kind_of("write", accesses));
        // A checkpoint and a picture at the beginning, since they are due at once, and both at the end.
        assert!(renamings.len() >= 6, "{accesses:#?}");
        // The first checkpoint: when the old one has been renamed already, and while it is written.
        vec![if matches!(kind, Kind::Io) { renamings[1] } else { writes[1] }]
    });
}

#[test]
fn shards_and_frames() {
    let stage = Stage::new();
    let shard = "render world.toml -o @/a.shard --samples 1..2 --of 2 --resume";
    stage.try_faults(shard, Some(shard), |kind, accesses| match kind {
        Kind::Io => vec![],
        Kind::Full => kind_of("write", accesses)[..1].into(),
    });
    let frames = "render world.toml -o @/traced/%d.exr --frames 0..1 --spp 1 --resume";
    stage.try_faults(frames, Some(frames), |kind, accesses| match kind {
        Kind::Io => kind_of("sync", accesses)[..1].into(),
        Kind::Full => vec![],
    });
    let frames = "render world.toml -o @/drawn/%d.png --frames 0..2 --renderer raster --resume";
    stage.try_faults(frames, Some(frames), |kind, accesses| match kind {
        Kind::Io => kind_of("make", accesses)[..1].into(),
        // What says that the first frame is finished.
        Kind::Full => {
            let frame = kind_of("rename", accesses)[0];
            kind_of("write", accesses).into_iter().filter(|index| *index > frame).take(1).collect()
        }
    });
}

#[test]
fn drawn_pictures() {
    let stage = Stage::new();
    stage.run("render world.toml -o @/a.png --renderer raster --size 8x6");
    stage.try_faults("render world.toml -o @/a.png --renderer raster", None, |kind, accesses| match kind {
        Kind::Io => kind_of("sync", accesses)[..1].into(),
        Kind::Full => kind_of("write", accesses)[..1].into(),
    });
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
    for out in [
        "height -o @/h.tif",
        "height -o @/h.exr",
        "height -o @/h.png",
        "height -o @/h.r16",
        "mesh -o @/m.glb",
    ] {
        let export = format!("export world.toml --layer {out}");
        stage.try_faults(&export, None, all);
        // Over one that is there.
        if out.ends_with("tif") {
            stage.try_faults(&format!("{export} --seed 2"), None, all);
        }
    }
    stage.try_faults("export world.toml --layer mitsuba -o @/scene/", None, |_, accesses| {
        of_each_kind(accesses)
    });
}

/// What is kept for later runs is a convenience: if its disk fails, the file is made all the same, and by later runs too.
#[test]
fn land_that_is_kept() {
    let stage = Stage::new();
    let cache = stage.root.join("cache");
    let export = "export world.toml --layer height -o @/h.tif";
    let no_cache = || drop(fs::remove_dir_all(&cache));
    stage.run(export);
    let expected = stage.contents();
    for is_there in [false, true] {
        let prepare = || if is_there { stage.run(export) } else { no_cache() };
        no_cache();
        prepare();
        let (_, accesses) = stage.run_on(&cache, export, Kind::Io, 0);
        assert!(accesses.len() > 3, "{accesses:?}");
        for kind in [Kind::Io, Kind::Full] {
            for (index, _) in accesses.iter().filter(|access| kind.refuses(access)).enumerate() {
                no_cache();
                prepare();
                stage.restore(&Contents::new());
                let (output, failed) = stage.run_on(&cache, export, kind, index + 1);
                let case = format!("{kind:?} at {index}, {failed:?}: {}", stderr(&output));
                assert!(!failed.is_empty() && output.status.success(), "{case}");
                assert!(stage.contents() == expected, "{case}");
                let mut kept = fs::read_dir(&cache).into_iter().flatten();
                assert!(!kept.any(|entry| file::is_unfinished(&entry.unwrap().path())), "{case}");
                stage.run(export);
                assert!(stage.contents() == expected, "{case}");
            }
        }
    }
}
