//! What runs leave for later ones: the same bits with it and without, whatever happens to the runs or to their files.

use crate::kit;
use crate::kit::land::{barrier, hill, layer, random, slides, texels, valleys, world};
use serde_json::Value;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use tempfile::TempDir;
use terrane::core::hash::mix;
use terrane::formats::sealed;
use terrane::gpu::{DeviceKind, Gpu, PingPong, Recorder, Transfer};
use terrane::terrain::hydraulic::Transport;
use terrane::terrain::thermal::Settle;
use terrane::terrain::{Boundary, Controls, Layer, Map, Plan, Simulation};
use terrane::world::cache::{self, Cache, Error, Key};
use terrane::world::{Overrides, World};

// The state of a run.

#[test]
fn a_run_that_is_taken_up_anywhere_ends_in_the_same_bits() {
    let gpu = kit::gpu();
    for plan in [everything(), paper(), debris()] {
        let whole = kit::land::finished(&gpu, &plan);
        let expected = layers(&gpu, &whole);
        let mut steps = 0;
        let mut first = Simulation::new(&gpu, &plan).unwrap();
        while !first.step(Duration::ZERO).unwrap().finished {
            steps += 1;
        }
        // A step of no time is one pass: some places at random, and the end.
        let mut places: Vec<u32> = (0..12).map(|place| mix(place) % steps).chain([steps]).collect();
        places.sort_unstable();
        places.dedup();
        assert!(places.len() > 8, "{places:?} of {steps}");
        let mut first = Simulation::new(&gpu, &plan).unwrap();
        let mut done = 0;
        for place in places {
            while done <= place {
                first.step(Duration::ZERO).unwrap();
                done += 1;
            }
            let position = first.position().unwrap();
            let mut second = Simulation::new(&gpu, &plan).unwrap();
            poison(&gpu, &second);
            let parts = first.parts(position).unwrap().into_iter().zip(second.parts(position).unwrap());
            for (from, to) in parts {
                to.upload(&gpu, &from.download(&gpu).unwrap()).unwrap();
            }
            second.resume(position);
            assert_eq!(second.position(), Some(position));
            assert_eq!(second.progress(), first.progress());
            second.finish().unwrap();
            assert!(layers(&gpu, &second) == expected, "from {position:?}");
        }
        assert!(first.progress().finished);
    }
}

#[test]
fn a_state_without_one_of_its_images_goes_on_to_other_bits() {
    let gpu = kit::gpu();
    let plan = everything();
    let expected = layers(&gpu, &kit::land::finished(&gpu, &plan));
    let mut first = Simulation::new(&gpu, &plan).unwrap();
    while first.progress().iteration < 10 || first.progress().stage.name() != "erosion" {
        first.step(Duration::ZERO).unwrap();
    }
    let position = first.position().unwrap();
    for missing in ["height", "start", "change", "water", "sediment", "axis", "diagonal"] {
        let mut second = Simulation::new(&gpu, &plan).unwrap();
        for (from, to) in first.parts(position).unwrap().into_iter().zip(second.parts(position).unwrap()) {
            if from.name != missing {
                to.upload(&gpu, &from.download(&gpu).unwrap()).unwrap();
            }
        }
        second.resume(position);
        second.finish().unwrap();
        assert!(layers(&gpu, &second) != expected, "{missing} makes no difference");
    }
}

#[test]
fn a_place_that_a_run_does_not_pass_is_no_place_to_go_on_from() {
    let gpu = kit::gpu();
    let mut simulation = Simulation::new(&gpu, &everything()).unwrap();
    let erosion = loop {
        let progress = simulation.step(Duration::ZERO).unwrap();
        if progress.stage.name() == "erosion" && progress.iteration > 4 {
            break simulation.position().unwrap();
        }
    };
    let of = simulation.progress().of;
    assert!(simulation.parts(erosion).is_some());
    for wrong in [
        terrane::terrain::Position { iteration: of + 1, ..erosion },
        terrane::terrain::Position { iteration: of, process: 1, ..erosion },
        terrane::terrain::Position { iteration: u32::MAX, ..erosion },
        terrane::terrain::Position { process: 2, ..erosion },
        terrane::terrain::Position { process: u32::MAX, ..erosion },
        terrane::terrain::Position { pass: 1000, ..erosion },
    ] {
        assert!(simulation.parts(wrong).is_none(), "{wrong:?}");
        simulation.resume(wrong);
        assert_eq!(simulation.position(), Some(erosion));
    }
    let bare = Simulation::new(&gpu, &world(8, 100.0, hill(8, 10.0))).unwrap();
    assert!(bare.parts(erosion).is_none());
}

// What determines a state.

#[test]
fn a_plan_determines_its_land_from_the_stage_on_that_reads_what_changed() {
    let plan = everything();
    let stages: Vec<&str> = plan.stages().iter().map(|(stage, _)| stage.name()).collect();
    let digests = plan.digests().unwrap();
    assert_eq!(stages, ["base terrain", "settling", "erosion", "sea bed", "reef"]);
    assert_eq!(digests, everything().digests().unwrap());
    for (index, digest) in digests.iter().enumerate() {
        assert!(!digests[..index].contains(digest), "two stages with one digest");
    }

    type Change = fn(&mut Plan);
    let changes: [(usize, Change); 16] = [
        (0, |plan| plan.grid.extent += 1.0),
        (0, |plan| plan.sea_level = f32::from_bits(plan.sea_level.to_bits() + 1)),
        (0, |plan| plan.sea_level = -0.0),
        (0, |plan| plan.boundary = Boundary::Open),
        (0, |plan| plan.layers.push(kit::land::heightmap(8, vec![0.0; 64]))),
        (0, |plan| plan.layers = vec![kit::land::heightmap(24, hill(24, 151.0))]),
        (0, |plan| plan.controls.rain = None),
        (0, |plan| plan.controls.erodibility = plan.controls.rain.take()),
        (1, |plan| plan.thermal.as_mut().unwrap().settle.as_mut().unwrap().repose += 0.1),
        (2, |plan| plan.thermal.as_mut().unwrap().diffusivity += 0.1),
        (2, |plan| plan.hydraulic.as_mut().unwrap().rain *= 1.000_001),
        (2, |plan| plan.hydraulic.as_mut().unwrap().transport = Transport::SemiLagrangian),
        (2, |plan| plan.hydraulic.as_mut().unwrap().wet_memory += 1.0),
        (3, |plan| plan.seabed_smoothing += 1.0),
        (4, |plan| plan.reef.as_mut().unwrap().growth += 0.001),
        (4, |plan| plan.reef.as_mut().unwrap().stages[1].rise += 0.5),
    ];
    for (number, (stage, change)) in changes.into_iter().enumerate() {
        let mut changed = everything();
        change(&mut changed);
        let others = changed.digests().unwrap();
        let same = digests.iter().zip(&others).take_while(|(one, other)| one == other).count();
        assert_eq!(same, stage, "change {number}");
        assert!(digests.iter().zip(&others).skip(stage).all(|(one, other)| one != other));
    }
    // Without its last stage a land is what it was before that.
    let mut shorter = everything();
    shorter.reef = None;
    assert_eq!(shorter.digests().unwrap(), digests[..4]);
}

#[test]
fn another_device_or_driver_has_other_keys() {
    let gpu = kit::gpu();
    let keys = |change: fn(&mut terrane::gpu::DeviceInfo)| {
        let mut device = gpu.info().clone();
        change(&mut device);
        cache::keys(&everything(), &device).unwrap()
    };
    let mine = keys(|_| {});
    assert!(!gpu.info().identity.trim_matches('0').is_empty());
    assert_eq!(mine, keys(|device| device.index += 1));
    assert_ne!(mine, keys(|device| device.name += "!"));
    assert_ne!(mine, keys(|device| device.driver += "!"));
    assert_ne!(mine, keys(|device| device.identity += "!"));
}

// Files.

#[test]
fn every_flipped_byte_is_noticed() {
    let gpu = kit::gpu();
    let kept = Kept::new(&gpu);
    let sound = fs::read(&kept.path).unwrap();
    let header = 12 + u32::from_le_bytes(sound[8..12].try_into().unwrap()) as usize;
    assert!(header > 200 && sound.len() > 10_000);
    let payload = (0..400).map(|at| header + mix(at) as usize % (sound.len() - 32 - header));
    let places = (0..header + 4).chain(payload).chain(sound.len() - 40..sound.len());
    let mut simulation = Simulation::new(&gpu, &kept.world.plan).unwrap();
    for (number, at) in places.enumerate() {
        let mut damaged = sound.clone();
        damaged[at] ^= 1 << (mix(number as u32) % 8);
        fs::write(&kept.path, &damaged).unwrap();
        let loaded = kept.cache.load(&gpu, &kept.key, &mut simulation);
        assert!(matches!(loaded, Err(Error::Damaged { .. })), "byte {at}: {loaded:?}");
    }
    fs::write(&kept.path, &sound).unwrap();
    assert!(kept.cache.load(&gpu, &kept.key, &mut simulation).unwrap());
    simulation.finish().unwrap();
    assert!(layers(&gpu, &simulation) == layers(&gpu, &kit::land::finished(&gpu, &kept.world.plan)));
}

#[test]
fn what_is_no_whole_entry_is_refused() {
    let gpu = kit::gpu();
    let kept = Kept::new(&gpu);
    let sound = fs::read(&kept.path).unwrap();
    let mut simulation = Simulation::new(&gpu, &kept.world.plan).unwrap();
    let mut refused = |what: &str, bytes: &[u8]| {
        fs::write(&kept.path, bytes).unwrap();
        let loaded = kept.cache.load(&gpu, &kept.key, &mut simulation);
        assert!(matches!(loaded, Err(Error::Damaged { .. })), "{what}: {loaded:?}");
    };
    refused("empty", b"");
    refused("longer", &[&sound[..], b"!"].concat());
    refused("zeros", &vec![0; sound.len()]);
    refused("text", "terrane ".repeat(1000).as_bytes());
    let noise: Vec<u8> = (0..5000).map(|at| mix(at) as u8).collect();
    refused("noise", &noise);
    refused("noise behind the right letters", &[&sound[..8], &noise].concat());
    for length in (0..sound.len()).step_by(97) {
        refused(&format!("cut to {length}"), &sound[..length]);
    }

    // The file of another land, under this one's name.
    let other = World { plan: paper(), ..kept.world.clone() };
    let other_key = last_key(&gpu, &other);
    let whole = kit::land::finished(&gpu, &other.plan);
    kept.cache.store(&gpu, &other_key, &other, &whole).unwrap();
    let path = kept.cache.folder.join(name_of(&kept.cache, &kept.path));
    refused("another land", &fs::read(path).unwrap());

    // Nothing there is no failure.
    fs::remove_file(&kept.path).unwrap();
    assert!(!kept.cache.load(&gpu, &kept.key, &mut simulation).unwrap());
}

#[test]
fn sizes_that_a_header_promises_are_compared_before_memory_is_taken() {
    const MUCH: u64 = 100 << 30;

    let gpu = kit::gpu();
    let kept = Kept::new(&gpu);
    let mut simulation = Simulation::new(&gpu, &kept.world.plan).unwrap();
    let sound = fs::read(&kept.path).unwrap();
    let length = u32::from_le_bytes(sound[8..12].try_into().unwrap()) as usize;
    let header: Value = serde_json::from_slice(&sound[12..12 + length]).unwrap();
    let mut forgeries = Vec::new();
    for floats in [MUCH / 4, u64::MAX / 4, u64::MAX, 0] {
        let mut forged = header.clone();
        forged["parts"][0][1] = floats.into();
        forgeries.push(forged);
    }
    for (key, value) in [("iteration", u64::from(u32::MAX)), ("process", 1 << 20), ("pass", 1 << 31)] {
        let mut forged = header.clone();
        forged["position"][key] = value.into();
        forgeries.push(forged);
    }
    let mut forged = header.clone();
    forged["parts"] = Value::Array(vec![]);
    forgeries.push(forged);
    for header in &forgeries {
        // Under a right checksum, and as long as it says.
        sealed::write(&kept.path, header, |_| Ok(())).unwrap();
        for length in [None, Some(MUCH)] {
            if let Some(length) = length {
                File::options().write(true).open(&kept.path).unwrap().set_len(length).unwrap();
            }
            let loaded = kept.cache.load(&gpu, &kept.key, &mut simulation);
            assert!(matches!(loaded, Err(Error::Damaged { .. })), "{header}: {loaded:?}");
        }
    }
    // A header that never ends.
    for length in [4097_u32, 1 << 30, u32::MAX] {
        let mut forged = sound.clone();
        forged[8..12].copy_from_slice(&length.to_le_bytes());
        fs::write(&kept.path, forged).unwrap();
        let loaded = kept.cache.load(&gpu, &kept.key, &mut simulation);
        assert!(matches!(loaded, Err(Error::Damaged { .. })), "{length}: {loaded:?}");
    }
}

/// A process of its own that may take little memory.
#[cfg(target_os = "linux")]
#[test]
fn a_block_that_a_file_has_not_costs_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("forged");
    sealed::write(&path, &0, |writer| writer.block(&[1.0; 1000])).unwrap();
    let limited = Command::new("sh")
        .args([
            "-c",
            "ulimit -v 400000 && exec \"$0\" --exact --ignored cache::reads_a_block_of_100_gigabytes",
        ])
        .arg(std::env::current_exe().unwrap())
        .env("FORGED_FILE", &path)
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .unwrap();
    let output = String::from_utf8_lossy(&limited.stdout) + String::from_utf8_lossy(&limited.stderr);
    assert!(limited.status.success() && output.contains("1 passed"), "{output}");
}

#[test]
#[ignore = "run by a_block_that_a_file_has_not_costs_no_memory"]
fn reads_a_block_of_100_gigabytes() {
    let Some(path) = std::env::var_os("FORGED_FILE") else { return };
    for floats in [25 << 30, usize::MAX / 4, usize::MAX] {
        let (_, mut reader) = sealed::Reader::open::<u32>(Path::new(&path)).unwrap();
        assert!(reader.block(floats).is_err());
    }
}

#[test]
fn what_was_not_used_for_the_longest_time_goes_first() {
    let gpu = kit::gpu();
    let kept = Kept::new(&gpu);
    fs::remove_file(&kept.path).unwrap();
    let simulation = kit::land::finished(&gpu, &kept.world.plan);
    let keys: Vec<Key> = (0..4).map(|seed| last_key(&gpu, &reseeded(&kept.world, seed))).collect();
    let store = |cache: &Cache, key| cache.store(&gpu, key, &kept.world, &simulation);
    store(&kept.cache, &keys[0]).unwrap();
    let bytes = fs::metadata(only_file(&kept.cache.folder)).unwrap().len();
    let made = only_file(&kept.cache.folder);
    File::options().write(true).open(made).unwrap().set_modified(SystemTime::UNIX_EPOCH).unwrap();

    // What others have put into the folder stays, and does not count.
    let foreign = kept.cache.folder.join("notes.txt");
    fs::write(&foreign, vec![0; 1 << 20]).unwrap();
    let cache = Cache { limit: 3 * bytes + 8192, ..kept.cache.clone() };
    let has = |key: &Key| kept.cache.load(&gpu, key, &mut Simulation::new(&gpu, &kept.world.plan).unwrap());
    for key in &keys[1..] {
        store(&cache, key).unwrap();
        let total: u64 = cache.entries().unwrap().iter().map(|entry| entry.bytes).sum();
        assert!(total <= cache.limit);
    }
    assert_eq!(cache.entries().unwrap().len(), 3);
    assert!(!has(&keys[0]).unwrap(), "the oldest is still there");
    assert!(has(&keys[1]).unwrap() && has(&keys[2]).unwrap() && has(&keys[3]).unwrap());

    // More than all of it is refused, and costs nothing that is there.
    let small = Cache { limit: bytes / 2, ..cache.clone() };
    assert!(matches!(store(&small, &keys[0]), Err(Error::TooLarge { .. })));
    assert_eq!(cache.entries().unwrap().len(), 3);

    // What a killed process has left goes when it is old, and what another one is writing stays.
    let [old, new] = [".terrane-1-0.part", ".terrane-1-1.part"].map(|name| cache.folder.join(name));
    fs::write(&old, b"old").unwrap();
    fs::write(&new, b"new").unwrap();
    let hour_ago = SystemTime::now() - Duration::from_secs(3600);
    File::options().write(true).open(&old).unwrap().set_modified(hour_ago).unwrap();
    store(&cache, &keys[0]).unwrap();
    assert!(!old.exists() && new.exists());

    assert!(cache.clear().unwrap() > 3 * bytes - 3);
    assert!(cache.entries().unwrap().is_empty() && new.exists() && foreign.exists());
}

#[test]
fn a_run_that_is_behind_takes_nothing_from_one_that_is_ahead() {
    let gpu = kit::gpu();
    let kept = Kept::new(&gpu);
    let ahead = fs::read(&kept.path).unwrap();
    let mut behind = Simulation::new(&gpu, &kept.world.plan).unwrap();
    while behind.progress().stage.name() != "reef" {
        behind.step(Duration::from_millis(100)).unwrap();
    }
    behind.step(Duration::ZERO).unwrap();
    kept.cache.store(&gpu, &kept.key, &kept.world, &behind).unwrap();
    assert!(fs::read(&kept.path).unwrap() == ahead);
}

// The program.

/// A world of some seconds.
const WORLD: &str = r#"
format = 1
seed = 5
[terrain]
cells = 96
extent = 3000
layers = [{ cone = { height = 500, radius = 1300 } }, { simplex = { amplitude = 60, wavelength = 700, octaves = 5 } }]
[sea]
level = 90
[erosion.hydraulic]
duration = 1500
[reef]
stages = [{ duration = 3000, rise = 8 }]
[render]
size = [64, 36]
"#;

#[test]
fn another_picture_of_the_same_land_simulates_nothing() {
    let folder = folder();
    let render = |out: &str, more: &[&str]| {
        let arguments = [&["render", "world.toml", "--json", "-o", out], more].concat();
        let output = terrane(folder.path(), &arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        (fs::read(folder.path().join(out)).unwrap(), stages(&output))
    };
    let (first, simulated) = render("first.png", &[]);
    assert!(simulated.iter().all(|stage| stage.cached == 0 && stage.iterations > 0), "{simulated:?}");
    let (again, reused) = render("again.png", &[]);
    assert!(first == again);
    let (without, alone) = render("without.png", &["--no-cache"]);
    assert!(first == without);
    assert!(alone.iter().all(|stage| stage.cached == 0), "{alone:?}");
    for stage in reused.iter().filter(|stage| stage.name != "picture") {
        let of = simulated.iter().find(|other| other.name == stage.name).unwrap().iterations;
        assert_eq!((stage.iterations, stage.cached), (0, of), "{stage:?}");
    }

    let camera = ["--set", "camera.fov=25", "--set", "sun.place.time=15"];
    let (other, reused) = render("other.png", &camera);
    assert!(reused.iter().all(|stage| stage.iterations == 0 || stage.name == "picture"), "{reused:?}");
    let (without, _) = render("without.png", &[&camera[..], &["--no-cache"]].concat());
    assert!(other == without && other != first);

    // Another reef on the same erosion; another erosion on the same ground.
    let (reef, reused) = render("reef.png", &["--set", "reef.growth=0.02"]);
    let names = |reused: &[Stage]| -> Vec<String> {
        reused.iter().filter(|stage| stage.iterations > 0).map(|stage| stage.name.clone()).collect()
    };
    assert_eq!(names(&reused), ["reef", "picture"]);
    let (without, _) = render("without.png", &["--set", "reef.growth=0.02", "--no-cache"]);
    assert!(reef == without);
    let (_, reused) = render("dry.png", &["--set", "erosion.hydraulic.rain=50"]);
    assert_eq!(names(&reused), ["erosion", "sea bed", "reef", "picture"]);
    let (_, reused) = render("seed.png", &["--seed", "6"]);
    assert!(reused.iter().all(|stage| stage.cached == 0), "{reused:?}");
}

#[test]
fn without_the_cache_nothing_is_read_or_written() {
    let folder = folder();
    assert_eq!(code(&terrane(folder.path(), &["render", "world.toml", "--no-cache"])), 0);
    assert!(!folder.path().join("cache").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_where_it_was() {
    // A graphics card is done with this land before a signal reaches it; killed runs are tested there, too.
    if kit::gpu().info().kind != DeviceKind::Cpu {
        return;
    }
    for signal in ["INT", "TERM"] {
        let folder = folder();
        let expected = layers_of(&folder, &["--no-cache"]);
        // Only the interruption keeps a state.
        let mut child =
            command(folder.path(), &EXPORT).env("TERRANE_CACHE_INTERVAL", "1000").spawn().unwrap();
        let mut lines = stderr_of(&mut child);
        assert!(lines.any(|line| line.unwrap().starts_with("settling")));
        std::thread::sleep(Duration::from_millis(300));
        // Twice, as `timeout` does: to the process, and to the group it is in.
        let signals = format!("kill -{signal} {0}; kill -{signal} {0}", child.id());
        assert!(Command::new("sh").args(["-c", &signals]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        let said = lines.find(|line| line.as_ref().unwrap().starts_with("error")).unwrap().unwrap();
        assert_eq!(
            said,
            "error: interrupted; no file was written; the land so far is kept, and the same command goes on from there"
        );

        let output = terrane(folder.path(), &EXPORT);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert!(stderr(&output).contains("erosion: continuing at iteration"), "{}", stderr(&output));
        let erosion = stages(&output).into_iter().find(|stage| stage.name == "erosion").unwrap();
        assert!(erosion.cached > 0 && erosion.iterations > 0, "{erosion:?}");
        assert!(fs::read(folder.path().join("all.exr")).unwrap() == expected);
    }
}

#[cfg(unix)]
#[test]
fn a_killed_run_goes_on_where_it_last_kept_its_state() {
    kill_at_random_moments(3);
}

#[cfg(unix)]
#[test]
#[ignore = "takes minutes"]
fn runs_killed_at_many_moments_go_on_where_they_last_kept_their_state() {
    kill_at_random_moments(20);
}

/// With nothing said about it, what a kill costs is half a minute.
#[cfg(unix)]
#[test]
#[ignore = "takes a minute"]
fn a_run_keeps_its_state_every_half_minute() {
    let folder = folder();
    let mut export = command(folder.path(), &[&EXPORT[..], &["--set", "terrain.cells=1024"]].concat());
    let mut child = export.env_remove("TERRANE_CACHE_INTERVAL").spawn().unwrap();
    std::thread::sleep(Duration::from_secs(50));
    child.kill().unwrap();
    child.wait().unwrap();
    let kept =
        fs::read_dir(folder.path().join("cache")).unwrap().map(|file| file.unwrap().metadata().unwrap());
    let last = kept.map(|file| file.modified().unwrap()).max().expect("nothing was kept");
    assert!(last.elapsed().unwrap() < Duration::from_secs(32), "{:?}", last.elapsed());
}

#[cfg(unix)]
fn kill_at_random_moments(times: u32) {
    let folder = folder();
    let expected = layers_of(&folder, &["--no-cache"]);
    let start = std::time::Instant::now();
    layers_of(&folder, &[]);
    let whole = start.elapsed();
    let mut continued = 0;
    for time in 0..times {
        fs::remove_dir_all(folder.path().join("cache")).unwrap();
        let mut child = command(folder.path(), &EXPORT).spawn().unwrap();
        let share = f64::from(mix(time)) / f64::from(u32::MAX);
        std::thread::sleep(whole.mul_f64(share));
        // SIGKILL.
        child.kill().unwrap();
        child.wait().unwrap();
        let entries = fs::read_dir(folder.path().join("cache")).map_or(0, |found| {
            found
                .filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|it| it == "land"))
                .count()
        });

        let output = terrane(folder.path(), &EXPORT);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert!(!stderr(&output).contains("warning"), "{}", stderr(&output));
        let cached: u64 = stages(&output).iter().map(|stage| stage.cached).sum();
        assert_eq!(cached > 0, entries > 0, "{share}: {}", stderr(&output));
        continued += u32::from(cached > 0);
        assert!(fs::read(folder.path().join("all.exr")).unwrap() == expected, "killed at {share}");
    }
    assert!(continued > 0, "no run had kept anything");
}

#[test]
fn damaged_entries_are_made_again() {
    let folder = folder();
    let expected = layers_of(&folder, &[]);
    let entries = || {
        let mut files: Vec<PathBuf> =
            fs::read_dir(folder.path().join("cache")).unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        files
    };
    let sound: Vec<(PathBuf, Vec<u8>)> =
        entries().into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    assert!(sound.len() >= 4);
    for (path, bytes) in &sound {
        let mut damaged = bytes.clone();
        damaged[bytes.len() / 2] ^= 1;
        fs::write(path, damaged).unwrap();
    }
    let output = terrane(folder.path(), &EXPORT);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let warnings =
        stderr(&output).matches("is damaged (its checksum is another); that land is made again").count();
    assert_eq!(warnings, sound.len(), "{}", stderr(&output));
    assert!(fs::read(folder.path().join("all.exr")).unwrap() == expected);
    assert!(entries().into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).eq(sound));
}

#[test]
fn two_runs_at_once_share_a_folder() {
    let folder = folder();
    let expected = layers_of(&folder, &["--no-cache"]);
    // Once with room for all, once with room for a few entries that they take from each other.
    for limit in ["1GiB", "1.5MiB"] {
        let start = |out: &str, seed: &str| {
            command(folder.path(), &["export", "world.toml", "--layer", "all", "-o", out, "--seed", seed])
                .env("TERRANE_CACHE_LIMIT", limit)
                .spawn()
                .unwrap()
        };
        let children = [start("one.exr", "5"), start("two.exr", "5"), start("three.exr", "6")];
        for child in children {
            let output = child.wait_with_output().unwrap();
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            assert!(!stderr(&output).contains("warning"), "{}", stderr(&output));
        }
        for out in ["one.exr", "two.exr"] {
            assert!(fs::read(folder.path().join(out)).unwrap() == expected);
        }
        assert!(fs::read(folder.path().join("three.exr")).unwrap() != expected);
        let left: Vec<String> = names(&folder.path().join("cache"));
        assert!(!left.is_empty() && left.iter().all(|name| name.ends_with(".land")), "{left:?}");
    }
}

#[test]
fn a_cache_that_cannot_be_used_is_said_once_and_does_no_harm() {
    let folder = folder();
    let expected = layers_of(&folder, &["--no-cache"]);
    fs::write(folder.path().join("file"), b"").unwrap();
    let mut cases = vec![("file", "1GiB"), ("file/below", "1GiB"), ("small", "4KiB")];
    // Where nobody may make a file, root neither.
    if cfg!(target_os = "linux") {
        cases.push(("/proc/terrane", "1GiB"));
        cases.push(("/proc/self", "1GiB"));
    }
    for (cache, limit) in cases {
        let output = command(folder.path(), &EXPORT)
            .env("TERRANE_CACHE", cache)
            .env("TERRANE_CACHE_LIMIT", limit)
            .output()
            .unwrap();
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        assert_eq!(stderr(&output).matches("warning").count(), 1, "{cache}: {}", stderr(&output));
        assert!(stderr(&output).contains("this run keeps nothing for later ones"), "{}", stderr(&output));
        assert!(fs::read(folder.path().join("all.exr")).unwrap() == expected);
    }
    let output = command(folder.path(), &EXPORT).env("TERRANE_CACHE_LIMIT", "much").output().unwrap();
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("TERRANE_CACHE_LIMIT is `much`"), "{}", stderr(&output));
}

/// Room that is missing for a while costs what would have been kept then, and nothing after.
#[test]
fn a_run_that_could_not_keep_its_state_tries_again() {
    let folder = folder();
    let obstacle = folder.path().join("obstacle");
    fs::write(&obstacle, b"").unwrap();
    let mut export = command(folder.path(), &EXPORT);
    let mut child = export.env("TERRANE_CACHE", "obstacle/cache").spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(
        lines.any(|line| line.unwrap().starts_with("warning: this run keeps nothing for later ones until"))
    );
    fs::remove_file(&obstacle).unwrap();
    assert_eq!(lines.filter(|line| line.as_ref().unwrap().starts_with("warning")).count(), 0);
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 0);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["warnings"].as_array().unwrap().len(), 1);
    assert!(fs::read_dir(obstacle.join("cache")).unwrap().count() > 0);
}

#[test]
fn the_cache_shows_and_clears_what_it_holds() {
    let folder = folder();
    let shown = |arguments: &[&str]| {
        let output = terrane(folder.path(), arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    // An empty one is no failure, and is not made.
    assert!(shown(&["cache"]).contains("0.0 MiB in 0 files"));
    assert!(!folder.path().join("cache").exists());

    layers_of(&folder, &[]);
    fs::write(folder.path().join("cache").join("0".repeat(64)).with_extension("land"), b"no entry").unwrap();
    fs::write(folder.path().join("cache/notes.txt"), b"mine").unwrap();
    let json: Value = serde_json::from_str(&shown(&["cache", "--json"])).unwrap();
    assert_eq!(json["command"], "cache");
    let cache = &json["cache"];
    assert_eq!((&cache["folder"], &cache["limit_bytes"]), (&"cache".into(), &(8_u64 << 30).into()));
    let entries = cache["entries"].as_array().unwrap();
    let files = names(&folder.path().join("cache"));
    assert_eq!(entries.len(), files.iter().filter(|name| name.ends_with(".land")).count());
    let bytes: u64 = entries.iter().map(|entry| entry["bytes"].as_u64().unwrap()).sum();
    assert_eq!(cache["bytes"], bytes);
    let reef = entries.iter().find(|entry| entry["stage"] == "reef").unwrap();
    assert_eq!(
        (&reef["world"], &reef["cells"], &reef["of"]),
        (&"world".into(), &96.into(), &reef["iteration"])
    );
    assert_eq!(entries.iter().filter(|entry| entry["world"].is_null()).count(), 1);
    let table = shown(&["cache"]);
    assert!(table.contains("world, 96 × 96, erosion") && table.contains("damaged"), "{table}");

    assert_eq!(shown(&["cache", "clear", "--quiet"]), "");
    assert_eq!(names(&folder.path().join("cache")), ["notes.txt"]);
    assert_eq!(code(&terrane(folder.path(), &["cache", "eat"])), 2);
}

// Helpers.

const EXPORT: [&str; 7] = ["export", "world.toml", "--layer", "all", "-o", "all.exr", "--json"];

/// Every process, and controls.
fn everything() -> Plan {
    let map = |name: &str| {
        let values = random(name, 49).into_iter().map(|value| 0.75 + 0.25 * value).collect();
        Some(Arc::new(Map { width: 7, height: 7, values }))
    };
    let settle = Settle { repose: 35_f32.to_radians(), length: 60.0 };
    Plan {
        sea_level: 5.0,
        controls: Controls { rain: map("rain"), erodibility: None, mask: map("mask") },
        hydraulic: Some(valleys(60.0)),
        thermal: Some(terrane::terrain::thermal::Params { settle: Some(settle), ..slides() }),
        seabed_smoothing: 40.0,
        reef: Some(barrier()),
        ..world(24, 600.0, hill(24, 150.0))
    }
}

/// Four pipes and traced sediment.
fn paper() -> Plan {
    Plan { hydraulic: Some(kit::land::paper(60.0)), ..world(24, 600.0, hill(24, 150.0)) }
}

/// Debris alone.
fn debris() -> Plan {
    let thermal = terrane::terrain::thermal::Params { duration: 12_000.0, ..slides() };
    Plan { thermal: Some(thermal), ..world(24, 600.0, hill(24, 400.0)) }
}

fn layers(gpu: &Gpu, simulation: &Simulation) -> Vec<Vec<u32>> {
    let bits = |kind| layer(gpu, simulation, kind).into_iter().map(f32::to_bits).collect();
    Layer::ALL.into_iter().map(bits).collect()
}

/// Fills the halves that are to be written with what must never be read.
fn poison(gpu: &Gpu, simulation: &Simulation) {
    fn fill<T: Transfer>(rec: &mut Recorder, gpu: &Gpu, pair: &PingPong<T>) {
        let elements = texels(gpu, pair.dst()).len();
        // A single texel stands for an image that the world does not have: nobody writes it, and it is read as 0.
        if elements == 1 {
            return;
        }
        let mut poisoned = vec![bytemuck::Zeroable::zeroed(); elements];
        bytemuck::cast_slice_mut::<T::Element, f32>(&mut poisoned).fill(f32::NAN);
        rec.upload(pair.dst(), &poisoned);
    }
    let fields = simulation.fields();
    let mut rec = Recorder::new(gpu);
    fill(&mut rec, gpu, &fields.height);
    fill(&mut rec, gpu, &fields.water);
    fill(&mut rec, gpu, &fields.sediment);
    fill(&mut rec, gpu, &fields.axis);
    fill(&mut rec, gpu, &fields.diagonal);
    fill(&mut rec, gpu, &fields.carbon);
    rec.submit().unwrap().wait().unwrap();
}

/// A land in a cache.
struct Kept {
    cache: Cache,
    world: World,
    key: Key,
    path: PathBuf,
    _folder: TempDir,
}

impl Kept {
    fn new(gpu: &Gpu) -> Kept {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache { folder: folder.path().join("cache"), limit: 1 << 30 };
        let parsed = terrane::world::parse("test.toml", b"format = 1", folder.path(), &Overrides::default());
        let world = World { plan: everything(), ..parsed.unwrap() };
        let key = last_key(gpu, &world);
        cache.store(gpu, &key, &world, &kit::land::finished(gpu, &world.plan)).unwrap();
        let path = only_file(&cache.folder);
        Kept { cache, world, key, path, _folder: folder }
    }
}

fn last_key(gpu: &Gpu, world: &World) -> Key {
    cache::keys(&world.plan, gpu.info()).unwrap().pop().unwrap()
}

fn reseeded(world: &World, seed: u32) -> World {
    let mut world = world.clone();
    world.plan.sea_level += seed as f32;
    world
}

fn only_file(folder: &Path) -> PathBuf {
    let mut files = fs::read_dir(folder).unwrap().map(|file| file.unwrap().path());
    let (Some(file), None) = (files.next(), files.next()) else { panic!("one file in {}", folder.display()) };
    file
}

/// The name of the one file that is not `known`.
fn name_of(cache: &Cache, known: &Path) -> String {
    let known = known.file_name().unwrap().to_str().unwrap();
    let other: Vec<String> = names(&cache.folder).into_iter().filter(|name| name != known).collect();
    let [other] = other.as_slice() else { panic!("one other file: {other:?}") };
    other.clone()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), WORLD).unwrap();
    folder
}

/// Runs that keep every state that they pass, in the folder `cache`.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(arguments).current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.env("TERRANE_VALIDATION", "1").env("TERRANE_CACHE", "cache").env("TERRANE_CACHE_INTERVAL", "0");
    command.env_remove("TERRANE_CACHE_LIMIT");
    command
}

fn terrane(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// The file with all layers.
fn layers_of(folder: &TempDir, more: &[&str]) -> Vec<u8> {
    let output = terrane(folder.path(), &[&EXPORT[..], more].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    fs::read(folder.path().join("all.exr")).unwrap()
}

#[cfg(unix)]
fn stderr_of(child: &mut Child) -> std::io::Lines<BufReader<std::process::ChildStderr>> {
    BufReader::new(child.stderr.take().unwrap()).lines()
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("it was not killed")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A stage, as `--json` has it.
#[derive(Debug, serde::Deserialize)]
struct Stage {
    name: String,
    iterations: u64,
    cached: u64,
}

fn stages(output: &Output) -> Vec<Stage> {
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    serde_json::from_value(json["stages"].clone()).unwrap()
}
