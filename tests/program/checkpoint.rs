//! Long renders lose nothing: pictures that were interrupted, killed, refined, cut into shards or traced on devices that were lost
//! have the same bytes as pictures that were traced in one go.

use crate::kit;
use crate::kit::forest::Random;
use crate::kit::program::{code, command, json, stderr, terrane};
use crate::kit::stage::{ball, empty, grey, with};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use terrane::core::camera::Pinhole;
use terrane::formats::{self, sealed};
use terrane::gpu::Gpu;
use terrane::scene::{Film, Material, Scene, Sky, ToneMap};
use terrane::trace::{Crop, Settings, Sums, Tracer};
use terrane::world::shard::{self, Curve, Header, Render};
use terrane::world::{self, Overrides};

// Sums, in this process.

const WIDTH: u32 = 24;
const HEIGHT: u32 = 16;
const SAMPLES: u32 = 12;

/// Traces these samples of these pixels in many small steps; what is under way is counted now and then, if anything is random.
fn traced(
    gpu: &Gpu,
    scene: &Scene,
    tracer: &Tracer,
    part: (Crop, u32, u32),
    random: Option<&mut Random>,
) -> Sums {
    let film = Film { width: WIDTH, height: HEIGHT, exposure: 1.0, tone_map: ToneMap::None };
    let camera = Pinhole::look_at(Vec3::new(0.2, -0.1, 0.1), Vec3::NEG_Y, 1.0, WIDTH as f32 / HEIGHT as f32);
    let mut tracing =
        tracer.begin(scene, &film, &camera, Settings { bounces: 3, ..Settings::default() }).unwrap();
    assert!(!gpu.info().name.is_empty());
    let (crop, first, end) = part;
    tracing.resume(Sums::of(crop, first));
    let mut random = random;
    while tracing.step(end).unwrap() {
        if random.as_mut().is_some_and(|random| random.unit() < 0.5) {
            tracing.settle().unwrap();
        }
    }
    tracing.take_sums()
}

/// Cuts a picture into parts by halving what there is at random places, along any axis or between samples.
fn partition(random: &mut Random) -> Vec<(Crop, u32, u32)> {
    let mut parts = vec![(Crop::whole(WIDTH, HEIGHT), 0, SAMPLES)];
    for _ in 0..5 {
        let index = (random.unit() * parts.len() as f32) as usize % parts.len();
        let (crop, first, end) = parts.swap_remove(index);
        let cut = |random: &mut Random, length: u32| {
            1 + (random.unit() * (length - 1) as f32) as u32 % (length - 1)
        };
        let axis = (random.unit() * 3.0) as usize;
        if axis < 2 && crop.size[axis] > 1 {
            let place = cut(random, crop.size[axis]);
            let (mut one, mut other) = (crop, crop);
            one.size[axis] = place;
            (other.origin[axis], other.size[axis]) = (crop.origin[axis] + place, crop.size[axis] - place);
            parts.extend([(one, first, end), (other, first, end)]);
        } else if end - first > 1 {
            let place = first + cut(random, end - first);
            parts.extend([(crop, first, place), (crop, place, end)]);
        } else {
            parts.push((crop, first, end));
        }
    }
    parts
}

#[test]
fn any_partition_gives_the_same_sums() {
    let gpu = kit::gpu();
    let mut scene = with(empty(&gpu), vec![(ball(Vec3::ZERO, 1.0, 0.0, 64, true), grey(0.5))]);
    scene.light.sky = Sky::Constant { radiance: [1.0, 0.5, 0.25] };
    let tracer = kit::tracer(&gpu);
    let all = Crop::whole(WIDTH, HEIGHT);
    let whole = traced(&gpu, &scene, tracer, (all, 0, SAMPLES), None);
    assert_eq!(whole.range(), Some(0..SAMPLES));
    let mut random = Random(1);
    for number in 0..20 {
        let mut sums = Sums::of(all, 0);
        for part in partition(&mut random) {
            sums.absorb(&traced(&gpu, &scene, tracer, part, Some(&mut random)));
        }
        sums.complete(SAMPLES);
        assert!(sums == whole, "partition {number}");
        assert_eq!(sums.noise(), whole.noise());
        assert_eq!(sums.channels(), whole.channels());
    }
    // Other samples are others.
    let mut sums = Sums::of(all, 0);
    sums.absorb(&traced(&gpu, &scene, tracer, (all, 0, 4), None));
    sums.absorb(&traced(&gpu, &scene, tracer, (all, 5, SAMPLES + 1), None));
    sums.complete(SAMPLES);
    assert!(sums != whole);
}

/// Light that is no number is counted, and black: nothing that follows from it gets into a picture.
#[test]
fn samples_that_are_no_numbers_are_counted() {
    let gpu = kit::gpu();
    let tracer = kit::tracer(&gpu);
    for (emission, flawed) in [(f32::NAN, true), (f32::INFINITY, true), (1e4, false)] {
        let material = Material { emission: [emission; 3], ..grey(0.5) };
        let scene = with(empty(&gpu), vec![(ball(Vec3::ZERO, 1.0, 1.0, 16, true), material)]);
        let sums = traced(&gpu, &scene, tracer, (Crop::whole(WIDTH, HEIGHT), 0, 2), None);
        let flaws = sums.flaws();
        assert_eq!(flaws.not_finite, if flawed { u64::from(2 * WIDTH * HEIGHT) } else { 0 }, "{emission}");
        assert_eq!(flaws.cut_off, 0);
        for (name, values) in sums.channels() {
            assert!(values.iter().all(|value| value.is_finite()), "{emission}: {name}");
        }
    }
}

// Files, in this process.

fn header() -> Header {
    Header {
        render: Render {
            terrane: "1".into(),
            build: "2".into(),
            renderer: "trace".into(),
            world: "a".into(),
            world_file: "b".repeat(64),
            changes: "c".repeat(64),
            contents: "d".repeat(64),
            seed: 1,
            size: [8, 6],
            frame: None,
            exposure: f64::from(6e-5_f32),
            tone_map: Curve::Filmic,
            device: "e".into(),
            driver: "f".into(),
            driver_build: "0".into(),
        },
        crop: Crop { origin: [2, 1], size: [6, 4] },
        first: 3,
        of: Some(12),
        flaws: Default::default(),
        finished: None,
        picture: None,
    }
}

fn read(path: &Path) -> Result<Option<Sums>, formats::Error> {
    shard::open(path)?.map_or(Ok(None), |shard| shard.sums())
}

#[test]
fn every_flipped_bit_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.shard");
    let header = header();
    let mut sums = Sums::of(header.crop, header.first);
    sums.complete(7);
    shard::write(&path, None, &header, Some(&sums)).unwrap();
    assert_eq!(read(&path).unwrap(), Some(sums));
    let sound = fs::read(&path).unwrap();
    assert!((3500..8000).contains(&sound.len()), "{}", sound.len());
    let mut damaged = sound.clone();
    for at in 0..sound.len() {
        for bit in 0..8 {
            damaged[at] ^= 1 << bit;
            fs::write(&path, &damaged).unwrap();
            let found = shard::open(&path);
            assert!(matches!(found, Err(formats::Error::Corrupt { .. })), "bit {bit} of byte {at}");
            damaged[at] = sound[at];
        }
    }
    for length in (0..sound.len()).step_by(7) {
        fs::write(&path, &sound[..length]).unwrap();
        assert!(matches!(shard::open(&path), Err(formats::Error::Corrupt { .. })), "cut to {length}");
    }
    fs::write(&path, [&sound[..], b"!"].concat()).unwrap();
    assert!(matches!(shard::open(&path), Err(formats::Error::Corrupt { .. })));
    assert!(read(&folder.path().join("missing")).unwrap().is_none());
}

/// What a header promises under a right checksum is compared with the file before memory is taken.
#[test]
fn forged_headers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.shard");
    let refused = |what: &str, header: &Header, ends: &[u32], pixels: usize| {
        sealed::write(&path, header, |writer| {
            writer.values(ends)?;
            writer.values(&vec![0_u64; pixels * 17])
        })
        .unwrap();
        let found = read(&path);
        assert!(matches!(found, Err(formats::Error::Corrupt { .. })), "{what}: {found:?}");
        // As long as it says, but for the checksum.
        fs::File::options().write(true).open(&path).unwrap().set_len(40 << 30).unwrap();
        let begun = Instant::now();
        assert!(read(&path).is_err() && begun.elapsed() < Duration::from_secs(5), "{what}");
    };
    let sized = |crop: Crop, size: [u32; 2]| {
        let header = header();
        Header { crop, render: Render { size, ..header.render.clone() }, ..header }
    };
    let huge = [u32::MAX; 2];
    refused("huge", &sized(Crop { origin: [0; 2], size: huge }, huge), &[7], 24);
    refused("large", &sized(Crop::whole(16_384, 16_384), [16_384; 2]), &[7; 1024], 24);
    refused("empty", &sized(Crop { origin: [0; 2], size: [0; 2] }, [8, 6]), &[], 0);
    refused("outside", &sized(Crop { origin: [3, 0], size: [6, 4] }, [8, 6]), &[7], 24);
    refused("beyond all numbers", &sized(Crop { origin: [u32::MAX; 2], size: [6, 4] }, [8, 6]), &[7], 24);
    refused("before its first sample", &header(), &[2], 24);
    refused("more samples than may be", &header(), &[u32::MAX], 24);
    refused("finished, with sums", &Header { finished: Some("so".into()), ..header() }, &[7], 24);
    let dark = Render { exposure: -1.0, ..header().render };
    refused("without exposure", &Header { render: dark, ..header() }, &[7], 24);
}

// The program.

/// Nothing but bare ground, and a camera that flies past.
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
  { frame = 4, position = [1500, 500, 1500], fov = 50 },
]
[render]
renderer = "trace"
size = [32, 18]
spp = 16
"#;

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), WORLD).unwrap();
    folder
}

/// Renders the world; fails unless it ends with `expected`.
#[track_caller]
fn render(folder: &Path, out: &str, more: &[&str], expected: i32) -> Output {
    let output = terrane(folder, &[&["render", "world.toml", "--json", "-o", out], more].concat());
    assert_eq!(code(&output), expected, "{out} {more:?}: {}", stderr(&output));
    output
}

#[track_caller]
fn merge(folder: &Path, shards: &[&str], out: &str, expected: i32) -> Output {
    let output = terrane(folder, &[&["merge"], shards, &["-o", out]].concat());
    assert_eq!(code(&output), expected, "{shards:?}: {}", stderr(&output));
    output
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn a_finished_picture_is_refined_or_left_as_it_is() {
    let folder = folder();
    let folder = folder.path();
    let output = render(folder, "whole.exr", &[], 0);
    assert_eq!(json(&output)["checkpoint"], "whole.exr.checkpoint");
    let whole = bytes(folder, "whole.exr");

    let begun = render(folder, "a.exr", &["--spp", "3", "--resume"], 0);
    assert!(stderr(&begun).contains("there is no a.exr.checkpoint to resume"), "{}", stderr(&begun));
    assert!(bytes(folder, "a.exr") != whole);
    let refined = render(folder, "a.exr", &["--resume"], 0);
    assert!(stderr(&refined).contains("continuing at iteration 3 of 16"), "{}", stderr(&refined));
    assert!(bytes(folder, "a.exr") == whole);

    // Nothing is traced for a picture that is there, for one that was lost, and for one that is not what was made of the sums: a
    // run may have ended between the two. Other files are made of the same sums, too.
    let left = render(folder, "a.exr", &["--resume"], 0);
    assert!(stderr(&left).contains("left as it is"), "{}", stderr(&left));
    let untraced = |output: &Output| {
        let json = json(output);
        !json["stages"].as_array().unwrap().iter().any(|stage| stage["name"] == "tracing")
    };
    for lost in [false, true] {
        fs::write(folder.join("a.exr"), "a picture").unwrap();
        if lost {
            fs::remove_file(folder.join("a.exr")).unwrap();
        }
        let again = render(folder, "a.exr", &["--resume"], 0);
        assert!(bytes(folder, "a.exr") == whole && untraced(&again));
    }
    let half = render(folder, "a.exr", &["--resume", "--half"], 0);
    assert!(bytes(folder, "a.exr").len() < whole.len() && untraced(&half));
    render(folder, "a.exr", &["--resume"], 0);
    assert!(bytes(folder, "a.exr") == whole);

    // A damaged checkpoint gives way to the one before it; without that it is an error, and stays.
    let [checkpoint, older] = ["a.exr.checkpoint", "a.exr.checkpoint.1"];
    render(folder, "a.exr", &["--spp", "3"], 0);
    let few = bytes(folder, checkpoint);
    let mut damaged = few.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 4;
    fs::write(folder.join(checkpoint), &damaged).unwrap();
    let refused = render(folder, "a.exr", &["--resume"], 7);
    assert!(
        stderr(&refused).contains("a.exr.checkpoint is not a readable shard")
            || stderr(&refused).contains("checksum")
    );
    fs::write(folder.join(older), &few).unwrap();
    let recovered = render(folder, "a.exr", &["--resume"], 0);
    assert!(stderr(&recovered).contains("going on from a.exr.checkpoint.1"), "{}", stderr(&recovered));
    assert!(bytes(folder, "a.exr") == whole);
    fs::write(folder.join(checkpoint), &damaged).unwrap();
    fs::write(folder.join(older), &damaged).unwrap();
    render(folder, "a.exr", &["--resume"], 7);
    assert!(bytes(folder, "a.exr") == whole && bytes(folder, checkpoint) == damaged);

    // Another picture's checkpoint is none of this one.
    fs::write(folder.join(checkpoint), &few).unwrap();
    for (change, difference) in [
        (&["--seed", "2"][..], "seed 1 and 2"),
        (&["--size", "31x18"], "size 32x18 and 31x18"),
        (&["--set", "camera.fov=39"], "--set"),
        (&["--crop", "0,0,32,17"], "pixels 0,0,32,18 and 0,0,32,17"),
    ] {
        let refused = render(folder, "a.exr", &[&["--resume"], change].concat(), 1);
        assert!(stderr(&refused).contains(difference), "{}", stderr(&refused));
        assert!(bytes(folder, checkpoint) == few);
    }
}

#[test]
fn shards_make_the_picture() {
    let folder = folder();
    let folder = folder.path();
    render(folder, "whole.exr", &[], 0);
    let part = |name: &str, samples: &str, more: &[&str]| {
        render(folder, name, &[&["--samples", samples, "--of", "16"], more].concat(), 0)
    };
    part("a.shard", "0..5", &[]);
    let left = part("b.shard", "5..16", &["--crop", "0,0,32,7"]);
    part("c.shard", "5..16", &["--crop", "0,7,32,11"]);
    assert_eq!(json(&left)["outputs"][0]["path"], "b.shard");
    assert!(!folder.join("b.shard.checkpoint").exists());
    merge(folder, &["c.shard", "a.shard", "b.shard"], "merged.exr", 0);
    assert!(bytes(folder, "merged.exr") == bytes(folder, "whole.exr"));
    // A finished checkpoint is a shard; and a finished shard is left as it is.
    merge(folder, &["whole.exr.checkpoint"], "merged.png", 0);
    render(folder, "whole.png", &["--resume"], 0);
    assert!(bytes(folder, "merged.png") == bytes(folder, "whole.png"));
    let again = part("b.shard", "5..16", &["--crop", "0,0,32,7", "--resume"]);
    assert!(stderr(&again).contains("left as it is"), "{}", stderr(&again));

    let misfit = |shards: &[&str], reason: &str| {
        let refused = merge(folder, shards, "none.exr", 1);
        assert!(stderr(&refused).contains(reason), "{}", stderr(&refused));
        assert!(!folder.join("none.exr").exists());
    };
    misfit(&["a.shard", "b.shard"], "are missing");
    misfit(&["a.shard", "b.shard", "c.shard", "a.shard"], "both have samples 0..5");
    misfit(&["a.shard", "whole.exr.checkpoint"], "both have samples 0..5");
    part("d.shard", "5..16", &["--seed", "2"]);
    misfit(&["a.shard", "d.shard"], "seed 1 and 2");
    let mut damaged = bytes(folder, "c.shard");
    damaged[700] ^= 1;
    fs::write(folder.join("c.shard"), damaged).unwrap();
    merge(folder, &["a.shard", "b.shard", "c.shard"], "none.exr", 7);
    merge(folder, &["a.shard", "missing.shard"], "none.exr", 7);
    merge(folder, &["a.shard"], "none.jpg", 2);
}

#[test]
fn a_crop_has_the_pixels_of_the_picture() {
    let folder = folder();
    let folder = folder.path();
    let ([left, top, width, height], crop) = ([9, 4, 14, 11], ["--crop", "9,4,14,11"]);
    render(folder, "whole.exr", &["--spp", "4"], 0);
    render(folder, "part.exr", &[&crop[..], &["--spp", "4"]].concat(), 0);
    let [(whole, _), (part, windows)] = ["whole.exr", "part.exr"].map(|name| read_exr(&folder.join(name)));
    assert_eq!(windows, [9, 4, 14, 11, 32, 18]);
    assert_eq!(whole.len(), part.len());
    for ((name, all), (other, cut)) in whole.iter().zip(&part) {
        assert_eq!(name, other);
        let rows = all.chunks(32).skip(top).take(height);
        let expected: Vec<u32> =
            rows.flat_map(|row| &row[left..left + width]).map(|value| value.to_bits()).collect();
        assert!(expected == cut.iter().map(|value| value.to_bits()).collect::<Vec<_>>(), "{name}");
    }
    // To the last bit in colours of the screen as well, and by the other renderer.
    for renderer in ["trace", "raster"] {
        let arguments = ["--spp", "1", "--renderer", renderer];
        render(folder, "whole.png", &arguments, 0);
        render(folder, "part.png", &[&crop[..], &arguments].concat(), 0);
        let [mut whole, part] =
            ["whole.png", "part.png"].map(|name| image::open(folder.join(name)).unwrap().to_rgb8());
        assert!(image::imageops::crop(&mut whole, 9, 4, 14, 11).to_image() == part, "{renderer}");
    }
}

/// Channels by name, and the windows of an EXR: x, y, width and height of the data, width and height of the display.
fn read_exr(path: &Path) -> (Vec<(String, Vec<f32>)>, [i32; 6]) {
    use exr::prelude::{ReadChannels, ReadLayers};
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let (at, size) = (image.layer_data.attributes.layer_position, image.layer_data.size);
    let display = image.attributes.display_window.size;
    let windows = [
        at.x(),
        at.y(),
        size.width() as i32,
        size.height() as i32,
        display.width() as i32,
        display.height() as i32,
    ];
    let channels = image.layer_data.channel_data.list.into_iter();
    (channels.map(|it| (it.name.to_string(), it.sample_data.values_as_f32().collect())).collect(), windows)
}

#[test]
fn frames_go_along_the_keyframes() {
    let folder = folder();
    let folder = folder.path();
    let frames = ["--frames", "1..4", "--spp", "1"];
    let output = render(folder, "frames/%03d.png", &frames, 0);
    let listed = json(&output)["frames"].clone();
    let numbers: Vec<u64> =
        listed.as_array().unwrap().iter().map(|frame| frame["number"].as_u64().unwrap()).collect();
    assert_eq!(numbers, [1, 2, 3]);
    assert_eq!(listed[0]["path"], "frames/001.png");
    let names = ["frames/001.png", "frames/002.png", "frames/003.png"];
    let made = names.map(|name| bytes(folder, name));
    assert!(made[0] != made[1] && made[1] != made[2]);
    assert!(fs::metadata(folder.join("frames/001.png.checkpoint")).unwrap().len() < 4096);

    // Finished frames are left as they are, and others made again.
    fs::write(folder.join(names[0]), "a picture").unwrap();
    fs::remove_file(folder.join(names[1])).unwrap();
    let output = render(folder, "frames/%03d.png", &[&frames[..], &["--resume"]].concat(), 0);
    assert_eq!(bytes(folder, names[0]), b"a picture");
    assert!(bytes(folder, names[1]) == made[1] && bytes(folder, names[2]) == made[2]);
    let found: Vec<bool> = json(&output)["frames"]
        .as_array()
        .unwrap()
        .iter()
        .map(|frame| frame["found"].as_bool().unwrap())
        .collect();
    assert_eq!(found, [true, false, true]);

    // A frame at a keyframe is the picture from there.
    let at = "camera.view={ look_at = { position = [900, 400, 2300], target = [0, 200, 0] } }";
    render(folder, "still.png", &["--spp", "1", "--set", at], 0);
    assert!(bytes(folder, "still.png") == made[1]);
    render(folder, "drawn/%d.png", &["--frames", "0..2", "--renderer", "raster"], 0);
    assert!(bytes(folder, "drawn/0.png") != bytes(folder, "drawn/1.png"));

    // A device that is lost is opened again in the middle of a film; three times.
    let lost = |steps: &str, expected: i32| {
        let arguments = ["render", "world.toml", "-o", "lost/%03d.png", "--frames", "1..4", "--spp", "1"];
        let output = command(folder, &arguments).env("TERRANE_LOSE_DEVICE", steps).output().unwrap();
        assert_eq!(code(&output), expected, "{}", stderr(&output));
    };
    lost("1,3,5", 0);
    assert!(names.map(|name| bytes(folder, &name.replace("frames", "lost"))) == made);
    lost("1,2,3,4", 5);
}

#[test]
fn arguments_that_make_no_sense_are_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("still.toml"), "format = 1\n").unwrap();
    let refused = |arguments: &[&str], expected: i32, part: &str| {
        let output = command(folder, &[&["render"], arguments].concat()).output().unwrap();
        assert_eq!(code(&output), expected, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(part), "{arguments:?}: {}", stderr(&output));
    };
    refused(&["world.toml", "--frames", "3..3"], 2, "empty");
    refused(&["world.toml", "--frames", "3"], 2, "0..60");
    refused(&["world.toml", "--frames", "0..3", "-o", "a.png"], 2, "%05d");
    refused(&["world.toml", "--frames", "0..3", "-o", "%5d.png"], 2, "%5d");
    refused(&["world.toml", "--frames", "0..3", "-o", "missing/folder/%05d.png"], 7, "missing");
    refused(&["still.toml", "--frames", "0..3"], 3, "camera.keyframes");
    refused(&["world.toml", "--samples", "0..3"], 2, "--of");
    refused(&["world.toml", "--of", "3"], 2, "--samples");
    refused(&["world.toml", "--samples", "3..9", "--of", "8"], 2, "no such samples");
    refused(&["world.toml", "--samples", "3..9", "--of", "9", "--spp", "4"], 2, "--spp");
    refused(&["world.toml", "--samples", "0..3", "--of", "9", "-o", "a.exr"], 2, ".shard");
    refused(&["world.toml", "--samples", "0..3", "--of", "9", "--renderer", "raster"], 2, "trace");
    refused(&["world.toml", "--crop", "0,0,33,18"], 2, "32x18");
    refused(&["world.toml", "--crop", "0,0,0,18"], 2, "at least 1");
    refused(&["world.toml", "--spp", "0"], 2, "--spp");
}

/// As many frames as there may be are no list in memory: what is missing in 512 MiB is a driver.
#[test]
fn frames_take_no_memory() {
    let folder = folder();
    let output = Command::new("sh")
        .args(["-c", "ulimit -v 524288 && exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_terrane")])
        .args(["render", "world.toml", "--frames", "0..10000001", "-o", "%d.png", "--no-cache"])
        .current_dir(folder.path())
        .envs([("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")])
        .output()
        .unwrap();
    assert_eq!(code(&output), 4, "{}", stderr(&output));
}

#[test]
fn keyframes_say_the_rest_once() {
    let keys = "{ frame = 1, position = [0, 1300, 2500], target = [0, 200, 0] }, { frame = 3, roll = 90, fov = 20 }, { frame = 9, focus = 7 }";
    let text = format!("format = 1\n[camera]\nkeyframes = [{keys}]\n");
    let world = world::parse("a.toml", text.as_bytes(), Path::new("."), &Overrides::default()).unwrap();
    let [first, second, third] = world.camera_path.keys[..] else { panic!("three keyframes") };
    assert_eq!((first.roll, second.roll, third.roll), (0.0, FRAC_PI_2, FRAC_PI_2));
    assert_eq!((third.position, third.target, third.fov), (first.position, first.target, second.fov));
    assert_eq!((second.focus, third.focus), (first.focus, 7.0));
}

#[test]
fn keyframes_that_make_no_path_are_refused() {
    let refused = |keyframes: &str, part: &str| {
        let text = format!("format = 1\n[camera]\nkeyframes = {keyframes}\n");
        let parsed = world::parse("a.toml", text.as_bytes(), Path::new("."), &Overrides::default());
        let message = parsed.expect_err(keyframes).to_string();
        assert!(message.contains(part), "{keyframes}: {message}");
    };
    let key = |frame: i32| format!("{{ frame = {frame}, position = [0, 300, 2500], target = [0, 200, 0] }}");
    refused(&format!("[{}, {}]", key(3), key(3)), "is out of order");
    refused(&format!("[{}, {}]", key(3), key(2)), "more than 3");
    refused("[{ frame = 0, target = [0, 0, 0] }]", "`camera.keyframes.0.position` is missing");
    refused("[{ frame = 0, position = [0, 300, 0] }]", "`camera.keyframes.0.target` is missing");
    refused("[{ frame = 0, position = [0, 300, 0], target = [0, 300, 0] }]", "is where the camera stands");
    refused("[{ frame = 0, position = [0, -3000, 0], target = [0, 300, 0] }]", "lies under the sea");
    refused("[{ frame = -1 }]", "out of range");
    refused("[{ fram = 1 }]", "is unknown");
}

// Signals and accidents.

/// Starts a render and waits until it traces.
fn begun(
    folder: &Path,
    out: &str,
    more: &[&str],
) -> (Child, std::io::Lines<BufReader<std::process::ChildStderr>>) {
    let arguments = [&["render", "world.toml", "--json", "-o", out], more].concat();
    let mut child = command(folder, &arguments)
        .env("TERRANE_CACHE_INTERVAL", "0.05")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("acceleration")));
    (child, lines)
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// An endless picture writes what it has when it is asked to, and goes on; then it ends, and says from where it can be resumed.
#[cfg(unix)]
#[test]
fn signals_write_and_go_on_or_stop() {
    let folder = folder();
    let folder = folder.path();
    let arguments = ["render", "world.toml", "--json", "-o", "a.exr", "--spp", "1000000"];
    let mut child =
        command(folder, &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("acceleration")));
    // The first one may come before there is a sample.
    let picture = folder.join("a.exr");
    for _ in 0..600 {
        if picture.exists() {
            break;
        }
        signal(&child, "-HUP");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(picture.exists() && folder.join("a.exr.checkpoint").exists());
    assert!(child.try_wait().unwrap().is_none(), "it goes on");
    signal(&child, "-TERM");
    let output = child.wait_with_output().unwrap();
    assert_eq!(code(&output), 130);
    let json = json(&output);
    assert_eq!(json["checkpoint"], "a.exr.checkpoint");
    assert_eq!(json["outputs"][0]["path"], "a.exr");
    assert!(json["error"]["message"].as_str().unwrap().contains("with --resume goes on"), "{json}");
    assert!(folder.join("a.exr.checkpoint.1").exists());
    // What it had is a picture: as many samples as it has, and more, come out as in one go.
    let shard = shard::open(&folder.join("a.exr.checkpoint")).unwrap().unwrap();
    let samples = shard.samples().unwrap().unwrap().end.to_string();
    render(folder, "a.exr", &["--resume", "--spp", &samples], 0);
    render(folder, "b.exr", &["--spp", &samples], 0);
    assert!(bytes(folder, "a.exr") == bytes(folder, "b.exr"));
}

/// Kills renders at random moments of their tracing; each, resumed, has the bytes of one that was left alone.
#[cfg(unix)]
fn killed(times: u32) {
    let folder = folder();
    let folder = folder.path();
    let many = ["--spp", "64"];
    let start = Instant::now();
    let (child, _) = begun(folder, "whole.exr", &many);
    let traces = start.elapsed();
    assert!(child.wait_with_output().unwrap().status.success());
    let length = start.elapsed() - traces;
    let whole = bytes(folder, "whole.exr");
    let (mut random, mut resumed) = (Random(11), 0);
    for number in 0..times {
        let out = format!("{number}.exr");
        let (mut child, _lines) = begun(folder, &out, &many);
        // Every other one has something to go on from, however slow the machine is.
        let checkpoint = folder.join(format!("{out}.checkpoint"));
        while number % 2 == 0 && !checkpoint.exists() && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(length.mul_f32(random.between(0.05, 0.95)));
        child.kill().unwrap();
        child.wait().unwrap();
        let output = render(folder, &out, &[&many[..], &["--resume"]].concat(), 0);
        resumed += u32::from(stderr(&output).contains("continuing at iteration"));
        assert!(bytes(folder, &out) == whole, "{number}");
    }
    assert!(resumed * 4 >= times, "{resumed} of {times} had anything to go on from");
}

#[cfg(unix)]
#[test]
fn killed_renders_go_on_to_the_same_bytes() {
    killed(3);
}

#[cfg(unix)]
#[test]
#[ignore = "minutes: the same as killed_renders_go_on_to_the_same_bytes, more often"]
fn renders_killed_at_fifty_moments_go_on_to_the_same_bytes() {
    killed(50);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_what_was_there() {
    let folder = folder();
    let folder = folder.path();
    render(folder, "a.exr", &["--spp", "2"], 0);
    let before = ["a.exr", "a.exr.checkpoint"].map(|name| bytes(folder, name));
    let [picture, checkpoint] = before.each_ref().map(|bytes| bytes.len().next_multiple_of(4096));
    let compare = "cmp a.exr disk/a.exr && cmp a.exr.checkpoint disk/a.exr.checkpoint && ls -A disk";
    // A disk that has room for these and for no more, where a process may mount one; else files may have a few blocks.
    for more in ["--resume --spp 3", "--spp 3"] {
        let told = on_a_small_disk(folder, picture + checkpoint + 8192, more, compare);
        assert_eq!(told, "a.exr\na.exr.checkpoint\n");
    }
    // And one that has room for another picture, but not for another checkpoint: what is there can be gone on from.
    if may_mount() {
        assert!(checkpoint > picture + 8192);
        let compare = "! cmp -s a.exr disk/a.exr && cmp a.exr.checkpoint disk/a.exr.checkpoint && ls -A disk";
        let told = on_a_small_disk(folder, 2 * picture + checkpoint + 8192, "--resume --spp 3", compare);
        assert_eq!(told, "a.exr\na.exr.checkpoint\n");
    }
}

#[cfg(target_os = "linux")]
fn may_mount() -> bool {
    let command = Command::new("unshare").args(["-rm", "sh", "-c", "mount -t tmpfs none /mnt"]).status();
    command.is_ok_and(|status| status.success())
}

/// Renders on a disk of that many bytes, on which there are a picture and its checkpoint already; returns what `compare` says then.
#[cfg(target_os = "linux")]
#[track_caller]
fn on_a_small_disk(folder: &Path, size: usize, more: &str, compare: &str) -> String {
    let mounts = may_mount();
    let (shell, prepare): (&[&str], _) = match mounts {
        true => (&["unshare", "-rm", "sh"], format!("mount -t tmpfs -o size={size} none disk")),
        false => (&["sh"], "trap '' XFSZ && ulimit -f 8".into()),
    };
    // The disk is filled before a limit on files holds for what fills it.
    let copy = "cp a.exr a.exr.checkpoint disk";
    let prepare = if mounts {
        format!("mkdir disk && {prepare} && {copy}")
    } else {
        format!("mkdir disk && {copy} && {prepare}")
    };
    let script = format!(
        "{prepare} && \"$0\" render world.toml -o disk/a.exr {more} --quiet --no-cache; code=$?; {compare}; exit $code"
    );
    let output = Command::new(shell[0])
        .args(&shell[1..])
        .args(["-c", &script, env!("CARGO_BIN_EXE_terrane")])
        .current_dir(folder)
        // Its files would be cut too, where those of this process are.
        .env("MESA_SHADER_CACHE_DISABLE", if mounts { "false" } else { "true" })
        .output()
        .unwrap();
    assert_eq!(code(&output), 7, "{}", stderr(&output));
    assert!(stderr(&output).contains("free some space"), "{}", stderr(&output));
    let _ = fs::remove_dir_all(folder.join("disk"));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A CPU device gives the same bytes with any number of threads, and the clock has no say either.
#[test]
fn threads_make_no_difference() {
    let folder = folder();
    let folder = folder.path();
    let traced = |threads: &str, out: &str| {
        let arguments = ["render", "world.toml", "-o", out, "--spp", "5", "--quiet"];
        let output = command(folder, &arguments).env("LP_NUM_THREADS", threads).output().unwrap();
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        bytes(folder, out)
    };
    assert!(traced("1", "one.exr") == traced("2", "two.exr"));
}
