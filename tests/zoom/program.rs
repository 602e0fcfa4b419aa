//! Zooms by the program: flights in and out, places by their codes, two eyes, what other programs get, what is refused.

// Gradients are for other tests.
#[allow(dead_code)]
use crate::kit;
use crate::kit::program::{good, json, terrane, told};
use crate::reference::zoom::Naive;
use image::RgbImage;
use num_bigint::BigInt;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::Path;
use terrane::formats::ply;
use terrane::world::Overrides;
use terrane::zoom::address::{Attitude, Location, Place};
use terrane::zoom::height::{Refinement, Roughness, Surface};

const TINY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/zoom/tiny.toml");

/// What the program reports of small pictures.
#[track_caller]
fn report(folder: &Path, options: &[&str]) -> Value {
    let common = ["render", TINY, "--size", "96x54", "--json", "--quiet"];
    let output = terrane(folder, &[&common[..], options].concat());
    good(&output);
    json(&output)
}

/// The frames that the program makes.
#[track_caller]
fn frames(folder: &Path, options: &[&str]) -> Vec<Value> {
    let report = report(folder, &[&["-o", "frames/%03d.png"], options].concat());
    report["frames"].as_array().expect("frames").clone()
}

/// The one picture that it makes.
#[track_caller]
fn picture(folder: &Path, options: &[&str]) -> Value {
    report(folder, options)["outputs"][0].clone()
}

fn hashes(frames: &[Value]) -> Vec<&str> {
    frames.iter().map(|frame| frame["sha256"].as_str().expect("a hash")).collect()
}

fn reversed<T>(mut all: Vec<T>) -> Vec<T> {
    all.reverse();
    all
}

fn code(frame: &Value) -> &str {
    frame["location"].as_str().expect("a location code")
}

/// The way back is the way in, frame by frame, also where a film is made in parts.
#[test]
fn the_program_flies_in_and_out() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let way_in = frames(folder.path(), &["--frames", "0..8"]);
    assert!(way_in.iter().all(|frame| frame["tiles_drawn"].as_u64().unwrap() > 10));
    for (number, frame) in way_in.iter().enumerate() {
        assert_eq!(frame["number"], number);
        // The place is a little more than 2^−depth cells from the spot, and the surface not much nearer.
        let depth = frame["depth"].as_f64().unwrap();
        assert!((depth - number as f64).abs() < 2.0, "frame {number}: {depth}");
        let (level, cells) = (frame["level"].as_f64().unwrap(), frame["cells"].as_f64().unwrap());
        assert!((level - cells.log2() - depth).abs() < 1e-9, "frame {number}: {level}, {cells}");
        assert_eq!(frame["gpu_bytes"], way_in[0]["gpu_bytes"], "frame {number}");
    }
    let way_out = frames(folder.path(), &["--frames", "0..8", "--return"]);
    assert_eq!(hashes(&way_out), reversed(hashes(&way_in)));
    assert_eq!(hashes(&frames(folder.path(), &["--frames", "5..7"])), hashes(&way_in[5..7]));
    let other = frames(folder.path(), &["--frames", "5..7", "--seed", "2"]);
    assert!(hashes(&other).iter().zip(hashes(&way_in[5..7])).all(|(other, own)| *other != own));
    // Sixteen frames a second, a level a second.
    let film = frames(folder.path(), &["--frames", "64..66", "--fps", "16"]);
    let slow = frames(folder.path(), &["--frames", "64..66", "--set", "zoom.levels_per_frame=0.0625"]);
    assert_eq!(hashes(&film), hashes(&slow));
    assert_eq!(hashes(&film)[0], hashes(&way_in)[4]);
}

/// A frame that is reached by its code is the one that was flown to, at any depth.
#[test]
fn a_code_says_what_is_seen() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let flown = frames(path, &["--frames", "40..43", "--seed", "7"]);
    for frame in &flown[1..] {
        // Neither the seed nor the depth of the world counts.
        assert_eq!(picture(path, &["--from", code(frame), "-o", "z.png"])["sha256"], frame["sha256"]);
    }
    // In a world it says the same, and from there the way out; what it leaves out is as in the world.
    let from = format!("zoom.from={:?}", code(&flown[1]));
    let written = ["--seed", "7", "--set", from.as_str()];
    let out = frames(path, &[&written[..], &["--frames", "0..2"]].concat());
    let coded = frames(path, &["--from", code(&flown[1]), "--frames", "0..2"]);
    assert_eq!((hashes(&out), &out[0]["sha256"]), (hashes(&coded), &flown[1]["sha256"]));
    let wide = picture(path, &[&written[..], &["--set", "camera.fov=100", "-o", "z.png"]].concat());
    assert_ne!(wide["sha256"], flown[1]["sha256"]);

    // Codes of this length come in files, in lines.
    let deep = picture(path, &["--set", "zoom.depth=10000", "-o", "deep.png"]);
    assert!(deep["level"].as_u64().unwrap() >= 9_999 && code(&deep).len() > 5000);
    // What the device keeps does not grow.
    assert_eq!(deep["gpu_bytes"], flown[0]["gpu_bytes"]);
    let lines: Vec<&str> =
        code(&deep).as_bytes().chunks(70).map(|line| str::from_utf8(line).unwrap()).collect();
    fs::write(path.join("deep.txt"), lines.join("\r\n")).unwrap();
    let again = picture(path, &["--from", "@deep.txt", "-o", "again.png"]);
    assert_eq!(again["sha256"], deep["sha256"]);
    assert!(again["location"] == deep["location"]);
}

/// From a code frames lead straight up, and back.
#[test]
fn a_code_leads_out_and_back_in() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let start = picture(path, &["--set", "zoom.depth=30.4", "-o", "start.png"]);
    let from = ["--from", code(&start)];
    let out = frames(path, &[&from[..], &["--frames", "0..6"]].concat());
    assert_eq!(out[0]["sha256"], start["sha256"]);
    for (number, frame) in out.iter().enumerate() {
        let passed = start["depth"].as_f64().unwrap() - frame["depth"].as_f64().unwrap();
        // Walls beside the way may be nearer than the ground.
        assert!((passed - number as f64).abs() < 1.0, "frame {number}: {passed} levels");
    }
    let parts = frames(path, &[&from[..], &["--frames", "4..6", "--return"]].concat());
    assert_eq!(hashes(&parts), reversed(hashes(&out[4..6])));
}

/// Brightness of the lower half of one of two pictures beside each other.
fn half(both: &RgbImage, first: u32) -> Vec<Vec<f64>> {
    let rows = both.height() / 2..both.height();
    let at = |row, column| both.get_pixel(first + column, row).0.iter().map(|byte| f64::from(*byte)).sum();
    rows.map(|row| (0..both.width() / 2).map(|column| at(row, column)).collect()).collect()
}

#[test]
fn two_eyes_see_from_two_places() {
    const WIDTH: u32 = 96;
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let load = |options: &[&str]| {
        let depth = ["--set", "zoom.depth=20", "-o", "z.png"];
        picture(path, &[&depth[..], options].concat());
        image::open(path.join("z.png")).unwrap().to_rgb8()
    };
    let one = load(&[]);
    let both = load(&["--stereo"]);
    assert_eq!((one.width(), both.width(), both.height()), (WIDTH, 2 * WIDTH, 54));
    // What is near lies farther to the right in the left eye's picture: by 0.0625 of some 1.5 distances and more.
    let (left, right) = (half(&both, 0), half(&both, WIDTH));
    let difference = |shift: i32| {
        let columns = 16..WIDTH as i32 - 16;
        let row = |row: usize| -> f64 {
            let at = |column: i32| left[row][(column + shift) as usize] - right[row][column as usize];
            columns.clone().map(|column| at(column).abs()).sum()
        };
        (0..left.len()).map(row).sum::<f64>()
    };
    let shift = (-12..=12).min_by(|a, b| difference(*a).total_cmp(&difference(*b))).unwrap();
    assert!((1..=6).contains(&shift), "{shift} pixels");
    assert!(difference(shift) < 0.7 * difference(0), "{} {}", difference(shift), difference(0));
    // With both eyes in one place it is one picture twice; grain goes by the column.
    let same = load(&["--stereo", "--set", "zoom.eyes=0"]);
    for (column, row, pixel) in one.enumerate_pixels() {
        assert_eq!(same.get_pixel(column, row), pixel);
        let other = same.get_pixel(WIDTH + column, row);
        assert!(other.0.iter().zip(pixel.0).all(|(other, own)| other.abs_diff(own) <= 1), "{column} {row}");
    }
    let part = load(&["--stereo", "--crop", "90,10,20,30"]);
    assert_eq!((part.width(), part.height()), (20, 30));
    assert!(
        part.enumerate_pixels().all(|(column, row, pixel)| both.get_pixel(90 + column, 10 + row) == pixel)
    );
}

fn text(value: &Value) -> &str {
    value.as_str().expect("text")
}

/// Tiles are what their addresses say: the definition, in integers without bounds, makes the same numbers from these alone.
#[test]
fn tiles_can_be_made_from_their_addresses() {
    const SIDE: usize = 17;
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    for refinement in ["triangles", "bilinear"] {
        let set = format!("zoom.refinement={refinement}");
        let export =
            ["export", TINY, "--layer", "tiles", "-o", "tiles/", "--size", "96x54", "--quiet", "--json"];
        let options = ["--set", "zoom.depth=150.5", "--set", &set, "--set", "zoom.visibility=8"];
        let output = terrane(folder.path(), &[&export[..], &options].concat());
        good(&output);
        let path = folder.path().join("tiles");
        let index: Value = serde_json::from_slice(&fs::read(path.join("tiles.json")).unwrap()).unwrap();
        let surface = &index["surface"];
        assert_eq!(surface["refinement"], refinement);
        let location = Location::parse(text(&index["location"])).unwrap();
        assert_eq!(surface["seed"], location.surface.seed);
        let naive = Naive { seed: location.surface.seed, bilinear: surface["refinement"] == "bilinear" };
        let tiles = index["tiles"].as_array().unwrap();
        assert!(tiles.len() > 50);
        assert_eq!(json(&output)["outputs"].as_array().unwrap().len(), tiles.len() + 1);
        let mut levels = HashSet::new();
        for tile in [&tiles[0], &tiles[tiles.len() / 2], &tiles[tiles.len() - 1]] {
            let bytes = fs::read(path.join(text(&tile["file"]))).unwrap();
            let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(tile["sha256"], hash);
            let whole = |key: &str| text(&tile[key]).parse::<BigInt>().unwrap();
            let level = tile["level"].as_u64().unwrap() as u32;
            levels.insert(level);
            let vertex = |index: usize| (whole("x") * 16 + index % SIDE, whole("z") * 16 + index / SIDE);
            let vertices: Vec<_> = (0..SIDE * SIDE).map(vertex).collect();
            let heights =
                bytes.as_chunks::<4>().0.iter().map(|bytes| whole("base") + i32::from_le_bytes(*bytes));
            assert!(naive.heights(level + 4, &vertices) == heights.collect::<Vec<_>>(), "level {level}");
            // A 2⁻⁸th of an amplitude, which is a quarter of a cell.
            assert_eq!(tile["unit_log2"], -i64::from(level + 4 + 8 + 2));
        }
        assert_eq!(levels.len(), 3, "of different sizes");
    }
}

/// x and z of a vertex, bit by bit.
type Flat = [u32; 2];

/// Triangles meet at edges and nowhere else, where tiles of different levels touch, too: an edge that has one triangle has nothing over or under it.
#[test]
fn the_mesh_has_no_cracks() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let view = ["--set", "zoom.depth=25", "--set", "zoom.visibility=8", "--size", "96x54"];
    let export = |out: &str| {
        let verb = ["export", TINY, "--quiet", "--layer", "mesh", "-o", out];
        good(&terrane(path, &[&verb[..], &view].concat()));
    };
    export("a.ply");
    export("a.glb");
    let sidecar: Value = serde_json::from_slice(&fs::read(path.join("a.ply.json")).unwrap()).unwrap();
    let seen = picture(path, &[&view[..4], &["-o", "z.png"]].concat());
    assert_eq!(sidecar["location"], seen["location"]);
    assert_eq!(sidecar["level"], seen["level"]);
    // Both files bear the code.
    let bytes = fs::read(path.join("a.ply")).unwrap();
    let header = String::from_utf8_lossy(&bytes[..4096]);
    let lines = header.lines().filter_map(|line| line.strip_prefix("comment location "));
    assert_eq!(lines.collect::<String>(), code(&seen));
    let gltf = gltf::Gltf::open(path.join("a.glb")).unwrap();
    let extras = gltf.nodes().next().unwrap().extras().as_ref().unwrap().get().to_owned();
    let extras: Value = serde_json::from_str(&extras).unwrap();
    assert_eq!(extras["location"], seen["location"]);
    assert!(text(&extras["unit"]).starts_with(&format!("cells of level {},", seen["level"])), "{extras}");

    let import = ply::read(&path.join("a.ply")).unwrap();
    let model = &import.population.models[0];
    let mesh = &model.levels[0].parts[0].mesh;
    let count = |accessor: Option<gltf::Accessor>| accessor.map_or(0, |accessor| accessor.count());
    let primitive = gltf.meshes().next().unwrap().primitives().next().unwrap();
    assert_eq!(count(primitive.indices()), 3 * mesh.triangles.len());
    // The eye is where it should be, as far above as the altitude says.
    let used: HashSet<u32> = mesh.triangles.as_flattened().iter().copied().collect();
    let length = |index: u32| {
        mesh.positions[index as usize].map(|of| f64::from(of).powi(2)).iter().sum::<f64>().sqrt()
    };
    let nearest = used.iter().map(|index| length(*index)).fold(f64::INFINITY, f64::min);
    let altitude = seen["cells"].as_f64().unwrap();
    assert!(nearest >= altitude && nearest < 4.0 * altitude, "{nearest} {altitude}");

    let position = |index: u32| mesh.positions[index as usize].map(f32::to_bits);
    let mut edges: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
    for triangle in &mesh.triangles {
        for side in 0..3 {
            let mut edge = [position(triangle[side]), position(triangle[(side + 1) % 3])];
            edge.sort_unstable();
            *edges.entry(edge).or_default() += 1;
        }
    }
    assert!(edges.values().all(|count| *count <= 2));
    let flat = |[x, _, z]: [u32; 3]| -> Flat { [x, z] };
    let all: HashSet<Flat> = used.iter().map(|index| flat(position(*index))).collect();
    let open: Vec<[Flat; 2]> =
        edges.iter().filter(|(_, count)| **count == 1).map(|(edge, _)| edge.map(flat)).collect();
    let distinct: HashSet<[Flat; 2]> = open.iter().map(|edge| sorted(*edge)).collect();
    assert_eq!(distinct.len(), open.len(), "one edge over another");
    for [from, to] in &open {
        let middle = [0, 1].map(|axis: usize| {
            let [from, to] = [from, to].map(|end| f64::from(f32::from_bits(end[axis])));
            (((from + to) / 2.0) as f32).to_bits()
        });
        assert!(!all.contains(&middle), "a vertex in the middle of an edge");
    }
    // The border of what is in view is little of it.
    assert!(open.len() * 10 < edges.len(), "{} of {}", open.len(), edges.len());
}

fn sorted(mut edge: [Flat; 2]) -> [Flat; 2] {
    edge.sort_unstable();
    edge
}

#[test]
fn what_a_zoom_can_not_is_refused() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let run = |verb: &str, options: &[&str]| terrane(path, &[&[verb, TINY], options].concat());
    let render = |options: &[&str]| run("render", options);
    told(&render(&["--renderer", "trace"]), 2, "a zoom is rasterised");
    told(&render(&["--spp", "4"]), 2, "--spp is for traced pictures");
    told(&render(&["--traversal", "bvh"]), 2, "--traversal is for traced pictures");
    told(&render(&["--resume"]), 2, "--frames");
    told(&render(&["--return"]), 2, "--frames");
    told(&render(&["--fps", "30"]), 2, "--frames");
    told(&render(&["--fps", "0", "--frames", "0..2"]), 2, "between 1 and 1000");
    let twice = ["--fps", "30", "--frames", "0..2", "--set", "zoom.levels_per_frame=1"];
    told(&render(&twice), 2, "leave one of them out");
    told(&render(&["--set", "zoom.depth=-1"]), 3, "zoom.depth");
    told(&render(&["--set", "zoom.tiles=1000"]), 3, "raise `zoom.tiles`");
    told(&render(&["--set", "zoom.eyes=2"]), 3, "allowed: 0 to 1");
    told(&render(&["--frames", "0..10000000"]), 2, "frame 1048576 is the last");
    told(&render(&["--memory-limit", "60MiB"]), 6, "lower zoom.tiles:");
    told(&render(&["--memory-limit", "1MiB"]), 6, "lower zoom.tile, zoom.visibility");
    told(&run("check", &["--memory-limit", "60MiB"]), 6, "lower zoom.tiles:");
    told(&run("export", &["--memory-limit", "30MiB"]), 6, "lower zoom.tiles:");

    let surface = Surface { seed: 1, refinement: Refinement::Triangles, roughness: Roughness::Half };
    let at = |surface, height: i64| {
        let mut place = Place::default();
        place.y.add(height, 0);
        Location { surface, level: 3, place, attitude: Attitude::default(), fov: 9000 }.code()
    };
    let (above, below) = (at(surface, 4), at(surface, -4));
    told(&render(&["--from", &below]), 2, "below the surface");
    told(&render(&["--from", &above, "--frames", "0..9"]), 2, "frame 0 is the last");
    let set = |code: &str| render(&["--set", &format!("zoom.from={code:?}")]);
    told(&set(&above), 3, "`zoom.from` is a place on another surface");
    told(&set(&above[1..]), 3, "the location code");
    let world = terrane::world::load(Path::new(TINY), &Overrides::default()).unwrap();
    let own = world.zoom.as_ref().unwrap().surface(world.seed);
    told(&set(&at(own, -4)), 3, "zoom.from: ");
    told(&run("check", &["--set", &format!("zoom.from={:?}", at(own, -4))]), 3, "zoom.from: ");
    good(&run("check", &["--set", &format!("zoom.from={:?}", at(own, 4))]));
    told(&render(&["--from", &above, "--seed", "3"]), 2, "--seed");
    told(&render(&["--from", &above, "--set", "zoom.depth=3"]), 2, "--set zoom.depth");
    told(&render(&["--from", &above, "--set", "zoom = { depth = 3 }"]), 2, "--set zoom");
    let mut end = Place::default();
    end.x.add(i64::MIN, 0);
    let end = Location { surface, level: 3, place: end, attitude: Attitude::default(), fov: 9000 }.code();
    told(&render(&["--from", &end]), 2, "the world's end");
    told(&render(&["--from", &above[..above.len() - 1]]), 2, "checksum");
    told(&render(&["--from", ""]), 2, "the location code is empty");
    told(&render(&["--from", "@none.txt"]), 7, "none.txt");
    fs::write(path.join("long.txt"), "B".repeat(600_000)).unwrap();
    told(&render(&["--from", "@long.txt"]), 2, "letters; the deepest place");
    fs::write(path.join("bytes.txt"), [0, 255]).unwrap();
    told(&render(&["--from", "@bytes.txt"]), 2, "is none of A-Z");

    told(&run("export", &["--layer", "height", "-o", "a.exr"]), 3, "it has mesh and tiles");
    told(&run("export", &["--layer", "tiles", "-o", "a.glb"]), 2, "tiles are a folder");
    told(&run("export", &["-o", "a.obj"]), 2, ".glb or .ply");
    told(&run("export", &["--cells", "64"]), 2, "--cells is for land");

    let island = TINY.replace("zoom/tiny", "island/tiny");
    let land = |verb: &str, options: &[&str]| terrane(path, &[&[verb, &island], options].concat());
    told(&land("render", &["--frames", "0..2", "--return"]), 3, "--return: the world has no `zoom`");
    told(&land("render", &["--stereo"]), 3, "--stereo: the world has no `zoom`");
    told(&land("render", &["--from", &above]), 3, "--from: the world has no `zoom`");
    told(&land("export", &["--layer", "tiles"]), 3, "the world has no `zoom`");
    // Nothing was written but what the test wrote.
    let left = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut left: Vec<String> = left.filter(|name| name != "cache").collect();
    left.sort_unstable();
    assert_eq!(left, ["bytes.txt", "long.txt"]);
}

#[test]
fn check_says_what_a_zoom_takes() {
    let _turn = kit::turn();
    let folder = tempfile::tempdir().unwrap();
    let output = terrane(folder.path(), &["check", TINY, "--json"]);
    good(&output);
    let plan = &json(&output)["plan"];
    // 12,000 tiles of 19² vertices, each a height and two gradients.
    let tiles = plan["memory"].as_array().unwrap().iter().find(|part| part["name"] == "tiles").unwrap();
    assert_eq!(tiles["bytes"], 12_000 * 19 * 19 * 12);
    assert!(plan["memory_bytes"].as_u64() > tiles["bytes"].as_u64());
    let output = terrane(folder.path(), &["check", TINY]);
    good(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("12000 of 16 × 16 quads") && text.contains("tiles 49.6 MiB"), "{text}");
}
