//! Forged and damaged input, one case a file: the program ends with an error and its exit code, within 512 MiB of memory
//! beside its own, and never panics.

use crate::kit::tiff::{self, Tiff, Value as Field};
use exr::prelude::{AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer};
use exr::prelude::{LayerAttributes, LineOrder, Vec2, WritableImage};
use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Address space that a case may take, KiB: 512 MiB, and 14 MiB for the program itself.
const LIMIT: u32 = (512 + 14) << 10;

/// What a world file, or the map that it names, does wrong.
struct Case {
    name: String,
    /// Name and bytes of each file in the folder.
    files: Vec<(&'static str, Vec<u8>)>,
    expected: i32,
}

#[test]
fn worlds() {
    let world = |text: &str| Some(text.as_bytes().to_vec());
    let deep = |open: &str, close: &str| {
        format!("format = 1\nseed = {}{}", open.repeat(200_000), close.repeat(200_000)).into_bytes()
    };
    let cases = [
        ("no UTF-8", Some(b"format = 1\nname = \"\xff\xfe\"".to_vec())),
        ("zeros", Some(vec![0; 4096])),
        ("a picture", Some(png([8, 8]))),
        ("cut in a string", world("format = 1\n[camera]\nview = \"fra")),
        ("cut in a table", world("format = 1\n[terrain\ncells = 64")),
        ("a key twice", world("format = 1\nseed = 1\nseed = 2")),
        ("a number too large", world("format = 1\n[terrain]\nextent = 1e400")),
        ("no number", world("format = 1\n[terrain]\nextent = nan")),
        ("a whole number too large", world("format = 1\nseed = 99999999999999999999")),
        ("another format", world("format = 2")),
        ("arrays in arrays", Some(deep("[", "]"))),
        ("tables in tables", Some(deep("{a=", "}"))),
        ("too long", Some([b"format = 1\n".to_vec(), b"#\n".repeat(1 << 20)].concat())),
        (
            "too many layers",
            world(&format!("format = 1\n[terrain]\nlayers = [{}]", "{ crater = {} },".repeat(10_000))),
        ),
    ];
    for (name, world) in cases {
        let files = world.map(|bytes| vec![("world.toml", bytes)]).unwrap_or_default();
        run(&Case { name: format!("world: {name}"), files, expected: 3 });
    }
    run(&Case { name: "world: missing".into(), files: vec![], expected: 7 });
}

#[test]
fn pngs() {
    let sound = png([24, 20]);
    let header = |place: usize, bytes: &[u8]| {
        let mut forged = sound.clone();
        forged[place..place + bytes.len()].copy_from_slice(bytes);
        let checksum = crc32(&forged[12..29]).to_be_bytes();
        forged[29..33].copy_from_slice(&checksum);
        forged
    };
    let size = |width: u32, height: u32| header(16, &[width.to_be_bytes(), height.to_be_bytes()].concat());
    let mut bad_checksum = sound.clone();
    bad_checksum[18] ^= 1;
    let data = sound.windows(4).position(|name| name == b"IDAT").unwrap();
    let mut bad_data = sound.clone();
    bad_data[data + 4..data + 24].fill(0xff);
    let mut bad_length = sound.clone();
    bad_length[data - 4..data].copy_from_slice(&u32::MAX.to_be_bytes());
    // A tenth of a gigabyte of values in a file of 200 KiB, and its end is missing.
    let mut bomb = png([10_000, 10_000]);
    bomb.truncate(bomb.len() - 100);
    let profile = [b"a\0\0".to_vec(), vec![0x78, 0x9c], vec![0; 100]].concat();
    maps(
        "map.png",
        vec![
            ("empty", vec![], 7),
            ("its magic alone", sound[..8].to_vec(), 7),
            ("cut in its header", sound[..20].to_vec(), 7),
            ("cut in its data", sound[..data + 30].to_vec(), 7),
            ("no width", size(0, 20), 7),
            ("huge", size(i32::MAX as u32, i32::MAX as u32), 7),
            ("long", size(1, 1 << 30), 7),
            ("as large as may be", size(10_200, 10_200), 7),
            ("higher than its data", size(24, 4000), 7),
            ("three bits", header(24, &[3]), 7),
            ("indexed colour without a palette", header(24, &[8, 3]), 3),
            ("an unknown colour", header(25, &[9]), 7),
            ("an unknown compression", header(26, &[7]), 7),
            ("interlaced", header(28, &[1]), 3),
            ("a wrong checksum", bad_checksum, 7),
            ("damaged data", bad_data, 7),
            ("a chunk longer than the file", bad_length, 7),
            ("a bomb", bomb, 7),
            ("a chunk in the wrong place", [&sound[..33], &chunk(b"IEND", &[]), &sound[33..]].concat(), 7),
            ("a damaged profile, and no data", [&sound[..33], &chunk(b"iCCP", &profile)].concat(), 7),
        ],
    );
}

#[test]
fn exrs() {
    let plain = exr(Compression::Uncompressed, Blocks::ScanLines, "height", 1.0);
    let zip = exr(Compression::ZIP16, Blocks::ScanLines, "height", 1.0);
    let tiled = exr(Compression::PIZ, Blocks::Tiles(Vec2(8, 8)), "height", 1.0);
    let value = |bytes: &[u8], attribute: &str| {
        let name = attribute.as_bytes();
        bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len() + 4
    };
    let forge = |sound: &[u8], place: usize, with: &[u8]| {
        let mut forged = sound.to_vec();
        forged[place..place + with.len()].copy_from_slice(with);
        forged
    };
    let size = |sound: &[u8], width: i32, height: i32| {
        let mut forged = sound.to_vec();
        for window in ["dataWindow\0box2i\0", "displayWindow\0box2i\0"] {
            let start = value(&forged, window) + 8;
            let corner = [(width - 1).to_le_bytes(), (height - 1).to_le_bytes()].concat();
            forged[start..start + 8].copy_from_slice(&corner);
        }
        let count = forged.windows(10).position(|part| part == b"chunkCount").unwrap();
        forged[count] = b'C';
        forged
    };
    // A single tile is left, behind a table of one offset: what was the table's second entry and third are taken for its
    // coordinates, and its length comes next.
    let huge_tile = {
        let sides = [(1_u32 << 15).to_le_bytes(), (1_u32 << 14).to_le_bytes()].concat();
        let mut forged = forge(&tiled, value(&tiled, "tiles\0tiledesc\0"), &sides);
        let first = forged.windows(8).position(|word| {
            let offset = u64::from_le_bytes(word.try_into().unwrap());
            offset > 100 && offset < tiled.len() as u64 && tiled[offset as usize..].starts_with(&[0; 16])
        });
        let length = first.unwrap() + 24;
        forged[length..length + 4].copy_from_slice(&i32::MAX.to_le_bytes());
        let count = forged.windows(10).position(|part| part == b"chunkCount").unwrap();
        forged[count] = b'C';
        forged
    };
    let window = value(&plain, "dataWindow\0box2i\0");
    let data = zip.len() - 200;
    maps(
        "map.exr",
        vec![
            ("empty", vec![], 7),
            ("its magic alone", plain[..4].to_vec(), 7),
            ("another version", forge(&plain, 4, &[9]), 7),
            ("one part that says it is several", forge(&plain, 5, &[0x10]), 7),
            ("cut in its header", plain[..100].to_vec(), 7),
            ("cut in its data", plain[..plain.len() - 300].to_vec(), 7),
            ("a table of blocks that is cut", zip[..zip.len() - 900].to_vec(), 7),
            ("huge", size(&zip, i32::MAX - 1, i32::MAX - 1), 7),
            ("wide", size(&zip, 1 << 14, 1), 7),
            ("long", size(&zip, 1, 1 << 30), 7),
            ("square", size(&zip, 1 << 13, 1 << 13), 7),
            (
                "huge tiles",
                forge(&tiled, value(&tiled, "tiles\0tiledesc\0"), &(1_u32 << 31).to_le_bytes()),
                7,
            ),
            ("one huge tile", huge_tile, 7),
            ("no tiles", forge(&tiled, value(&tiled, "tiles\0tiledesc\0"), &0_u32.to_le_bytes()), 7),
            ("a window inside out", forge(&plain, window, &1000_i32.to_le_bytes()), 7),
            ("a window at the end of the world", forge(&plain, window, &i32::MIN.to_le_bytes()), 7),
            (
                "an attribute longer than the file",
                forge(&plain, value(&plain, "channels\0chlist\0") - 4, &i32::MAX.to_le_bytes()),
                7,
            ),
            ("many blocks", forge(&plain, value(&plain, "chunkCount\0int\0"), &i32::MAX.to_le_bytes()), 7),
            ("an unknown compression", forge(&plain, value(&plain, "compression\0compression\0"), &[77]), 7),
            ("an unknown number", forge(&plain, value(&plain, "channels\0chlist\0") + 7, &[9]), 7),
            ("damaged data", forge(&zip, data, &[0xaa; 150]), 7),
            ("values that are not numbers", exr(Compression::RLE, Blocks::ScanLines, "height", f32::NAN), 3),
            ("infinite values", exr(Compression::RLE, Blocks::ScanLines, "height", f32::INFINITY), 3),
        ],
    );
}

#[test]
fn tiffs() {
    let floats: Vec<u8> = (0..24 * 20).flat_map(|index| (index as f32).to_le_bytes()).collect();
    let sound = || Tiff::strips([24, 20], 32, 3, 20, vec![floats.clone()]);
    let tiled = || Tiff::tiles([24, 20], 32, 3, [32, 32], vec![vec![0; 32 * 32 * 4]]);
    let long = |tag, value| sound().with(tag, Field::Long(vec![value])).bytes();
    let short = |tag, values: &[u16]| sound().with(tag, Field::Short(values.to_vec())).bytes();
    let size = |width, height| {
        sound()
            .with(tiff::WIDTH, Field::Long(vec![width]))
            .with(tiff::HEIGHT, Field::Long(vec![height]))
            .with(tiff::ROWS_PER_STRIP, Field::Long(vec![height]))
            .bytes()
    };
    let tile = |width, height| {
        tiled()
            .with(tiff::TILE_WIDTH, Field::Long(vec![width]))
            .with(tiff::TILE_HEIGHT, Field::Long(vec![height]))
            .bytes()
    };
    let plain = sound().bytes();
    let forge = |place: usize, with: &[u8]| {
        let mut forged = plain.clone();
        forged[place..place + with.len()].copy_from_slice(with);
        forged
    };
    let directory = u32::from_le_bytes(plain[4..8].try_into().unwrap()) as usize;
    let loops = |bits: u32| {
        // The next directory is the first again; its strips are tiny and need many of them.
        let mut forged = forge(plain.len() - 4, &(directory as u32).to_le_bytes());
        forged[directory + 2 + 12 + 8..][..4].copy_from_slice(&bits.to_le_bytes());
        forged
    };
    let big = |offset: u64| [&b"II\x2b\0\x08\0\0\0"[..], &offset.to_le_bytes(), &[0xff; 64]].concat();
    // 65536 × 2^31 entries of a type that is eight bytes long.
    let entry = directory + 2 + 5 * 12;
    let holes: Vec<u8> =
        (0..24 * 20).flat_map(|index| if index == 77 { -9999_f32 } else { 1.0 }.to_le_bytes()).collect();
    let voids: Vec<u8> =
        (0..24 * 20).flat_map(|index| if index == 77 { i16::MIN } else { 1 }.to_le_bytes()).collect();
    maps(
        "map.tif",
        vec![
            ("empty", vec![], 7),
            ("its magic alone", plain[..4].to_vec(), 7),
            ("cut in its data", plain[..500].to_vec(), 7),
            ("cut in its directory", plain[..plain.len() - 20].to_vec(), 7),
            ("an unknown byte order", forge(0, b"IM"), 7),
            ("a directory beyond its end", forge(4, &u32::MAX.to_le_bytes()), 7),
            ("a directory in its header", forge(4, &0_u32.to_le_bytes()), 7),
            ("a directory of 65535 entries", forge(directory, &[0xff, 0xff]), 7),
            ("a directory that follows itself", loops(3), 7),
            ("offsets without end", forge(entry + 2, &[[12, 0, 0xff, 0xff], [0xff; 4]].concat()), 7),
            ("big, and nowhere", big(u64::MAX - 3), 7),
            ("big, with endless entries", big(16), 7),
            ("no width", size(0, 20), 7),
            ("huge", size(u32::MAX, u32::MAX), 7),
            ("long", size(1, 1 << 30), 7),
            ("square", size(10_000, 10_000), 7),
            ("no rows in a strip", long(tiff::ROWS_PER_STRIP, 0), 7),
            ("more strips than it names", long(tiff::ROWS_PER_STRIP, 1), 7),
            ("a strip beyond its end", long(tiff::STRIP_OFFSETS, u32::MAX - 8), 7),
            ("a strip longer than the file", long(tiff::STRIP_LENGTHS, u32::MAX), 7),
            ("no tiles", tile(0, 0), 7),
            ("wide tiles", tile(1 << 31, 32), 7),
            ("huge tiles", tile(1 << 16, 1 << 16), 7),
            (
                "strips and tiles",
                sound()
                    .with(tiff::TILE_WIDTH, Field::Long(vec![8]))
                    .with(tiff::TILE_OFFSETS, Field::Offsets)
                    .bytes(),
                7,
            ),
            ("numbers of 77 bits", short(tiff::BITS, &[77]), 7),
            ("numbers of no bits", short(tiff::BITS, &[0]), 7),
            ("an unknown kind of number", short(tiff::SAMPLE_FORMAT, &[6]), 7),
            ("many bands", short(tiff::SAMPLES, &[65535]), 3),
            ("colour", short(tiff::PHOTOMETRIC, &[2]), 3),
            ("a photograph", short(tiff::COMPRESSION, &[7]), 7),
            ("damaged data", short(tiff::COMPRESSION, &[8]), 7),
            ("damaged words", short(tiff::COMPRESSION, &[5]), 7),
            (
                "missing values",
                Tiff::strips([24, 20], 32, 3, 20, vec![holes])
                    .with(tiff::NO_DATA, Field::Ascii("-9999".into()))
                    .bytes(),
                3,
            ),
            ("voids", Tiff::strips([24, 20], 16, 2, 20, vec![voids]).bytes(), 3),
        ],
    );
}

#[test]
fn raws() {
    let cases: [(&str, usize, Option<&str>); 11] = [
        ("empty", 0, None),
        ("half a number", 1, None),
        ("no square", 2 * 63, None),
        ("an odd length", 2 * 64 + 1, None),
        ("a size that is too small", 2 * 64, Some(r#"{ "samples": [8, 7] }"#)),
        ("a size that is too large", 2 * 64, Some(r#"{ "samples": [8, 4000] }"#)),
        ("a size beyond measure", 2 * 64, Some(r#"{ "samples": [4294967295, 4294967295] }"#)),
        ("no size", 2 * 64, Some(r#"{ "samples": [0, 0] }"#)),
        ("a size that is none", 2 * 64, Some(r#"{ "samples": [-1, 8] }"#)),
        ("an infinite height", 2 * 64, Some(r#"{ "min": 0, "max": 1e999 }"#)),
        ("an unknown byte order", 2 * 64, Some(r#"{ "byte_order": "middle" }"#)),
    ];
    for (name, bytes, sidecar) in cases {
        let mut files = vec![("world.toml", heightmap("map.r16")), ("map.r16", vec![7; bytes])];
        files.extend(sidecar.map(|text| ("map.r16.json", text.into())));
        run(&Case { name: format!("RAW: {name}"), files, expected: 7 });
    }
    let long = [("world.toml", heightmap("map.r16")), ("map.r16.json", vec![b' '; 2 << 20])];
    run(&Case { name: "RAW: a long sidecar".into(), files: long.into(), expected: 7 });
}

/// Opening a pipe waits until somebody writes into it, and nobody does.
#[test]
fn pipes_and_devices() {
    for pipe in ["map.r16", "map.r16.json"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("world.toml"), heightmap("map.r16")).unwrap();
        if pipe != "map.r16" {
            fs::write(folder.path().join("map.r16"), [7; 2 * 64]).unwrap();
        }
        assert!(Command::new("mkfifo").arg(folder.path().join(pipe)).status().unwrap().success());
        refused(folder.path(), pipe);
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), heightmap("map.r16")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("map.r16")).unwrap();
    refused(folder.path(), "map.r16");
}

/// `terrane check` ends with 7 and says that the file is none; it is killed if it waits.
fn refused(folder: &Path, file: &str) {
    let output = Command::new("timeout")
        .args(["60", env!("CARGO_BIN_EXE_terrane"), "check", "world.toml", "--no-time"])
        .current_dir(folder)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(7), "{file}: {message}");
    assert!(message.contains(file) && message.contains("name a regular file"), "{message}");
}

/// A checker that lets everything pass would be no good.
#[test]
fn what_is_sound_passes_and_too_much_memory_does_not() {
    let folder = |size| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("world.toml"), heightmap("map.png")).unwrap();
        fs::write(folder.path().join("map.png"), png(size)).unwrap();
        folder
    };
    assert_eq!(limited(folder([24, 20]).path(), LIMIT).status.code(), Some(0));
    // Some 400 MB of values: the limit has room for the greatest map that is read.
    let large = folder([10_000, 10_000]);
    assert_eq!(limited(large.path(), LIMIT).status.code(), Some(0));
    let output = limited(large.path(), 300 << 10);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(7), "{message}");
    assert!(message.contains("10000 × 10000"), "{message}");
}

#[test]
fn gltfs() {
    let triangle = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 44 }],
    });
    let floats: Vec<u8> =
        [0_f32, 0., 0., 1., 0., 0., 0., 1., 0.].into_iter().flat_map(f32::to_le_bytes).collect();
    let binary = [floats, vec![0, 0, 1, 0, 2, 0, 0, 0]].concat();
    let with = |pointer: &str, value: Value| {
        let mut forged = triangle.clone();
        set(&mut forged, pointer, value);
        glb(&forged, &binary)
    };
    let not_finite = |value: f32| glb(&triangle, &[&value.to_le_bytes()[..], &binary[4..]].concat());
    let beyond = [&binary[..40], &[3, 0, 0, 0]].concat();
    let sound = glb(&triangle, &binary);
    let length = |place: usize, value: u32| {
        let mut forged = sound.clone();
        forged[place..place + 4].copy_from_slice(&value.to_le_bytes());
        forged
    };
    let json_length = u32::from_le_bytes(sound[12..16].try_into().unwrap()) as usize;
    let chain = |count: usize, last: Value| {
        let node =
            |index: usize| if index + 1 < count { json!({ "children": [index + 1] }) } else { last.clone() };
        with("/nodes", (0..count).map(node).collect())
    };
    // Nodes of nodes: every level doubles what is in it, unless every node has one parent.
    let doubling: Value =
        (0..40)
            .map(|level| {
                if level < 39 { json!({ "children": [level + 1, level + 1] }) } else { json!({ "mesh": 0 }) }
            })
            .collect();
    let many_views = |accessors: usize| {
        let mut forged = triangle.clone();
        // 60 MB of positions, again and again.
        let position = json!({ "bufferView": 0, "componentType": 5126, "count": 5_000_000, "type": "VEC3" });
        set(&mut forged, "/accessors", vec![position; accessors].into());
        set(&mut forged, "/bufferViews", json!([{ "buffer": 0, "byteLength": 60_000_000 }]));
        set(&mut forged, "/buffers/0/byteLength", 60_000_000.into());
        let primitives = (0..accessors).map(|index| json!({ "attributes": { "POSITION": index } }));
        set(&mut forged, "/meshes/0/primitives", primitives.collect());
        glb(&forged, &vec![0; 60_000_000])
    };
    let instancing = |attributes: Value| {
        with("/nodes/0/extensions", json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } }))
    };
    let mut crowd = triangle.clone();
    // One place of 12 bytes for everybody, and 200 million of them.
    set(
        &mut crowd,
        "/accessors/2",
        json!({ "bufferView": 0, "componentType": 5126, "count": 200_000_000, "type": "VEC3" }),
    );
    set(
        &mut crowd,
        "/nodes/0/extensions",
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 2 } } }),
    );
    let bytes = b"glTF\x02\0\0\0".to_vec();
    // A million parts of one triangle each, in 30 MB of text.
    let crumbs = {
        let primitives = vec!["{\"attributes\":{\"POSITION\":0}}"; 130_000].join(",");
        let meshes = vec![format!("{{\"primitives\":[{primitives}]}}"); 8].join(",");
        let mut forged = triangle.clone();
        set(&mut forged, "/nodes", (0..8).map(|index| json!({ "mesh": index })).collect());
        set(&mut forged, "/scenes/0/nodes", (0..8).collect());
        set(&mut forged, "/meshes", "MESHES".into());
        raw_glb(forged.to_string().replace("\"MESHES\"", &format!("[{meshes}]")).as_bytes(), &binary)
    };
    let colourful = {
        let mut forged = triangle.clone();
        let material = |index: usize| json!({ "name": index.to_string() });
        set(&mut forged, "/materials", (0..100_000).map(material).collect());
        let primitive = |index: usize| json!({ "attributes": { "POSITION": 0 }, "material": index });
        set(&mut forged, "/meshes/0/primitives", (0..100_000).map(primitive).collect());
        glb(&forged, &binary)
    };
    // A triangle in two million places is one model where the world wants one.
    let everywhere = {
        let count = 2_000_000;
        let mut forged = triangle.clone();
        set(
            &mut forged,
            "/accessors/2",
            json!({ "bufferView": 2, "componentType": 5126, "count": count, "type": "VEC3" }),
        );
        set(
            &mut forged,
            "/bufferViews/2",
            json!({ "buffer": 0, "byteOffset": 44, "byteLength": 12 * count }),
        );
        set(&mut forged, "/buffers/0/byteLength", (44 + 12 * count).into());
        set(
            &mut forged,
            "/nodes/0/extensions",
            json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 2 } } }),
        );
        glb(&forged, &[binary.clone(), vec![0; 12 * count]].concat())
    };
    models(
        "model.glb",
        vec![
            ("empty", vec![], 7),
            ("its magic alone", b"glTF".to_vec(), 7),
            ("a JSON that is too long", with("/asset/generator", "x".repeat(33 << 20).into()), 7),
            ("its version alone", bytes, 7),
            ("of version 1", length(4, 1), 7),
            ("zeros", vec![0; 4096], 7),
            ("a picture", png([8, 8]), 7),
            ("cut in its JSON", sound[..100].to_vec(), 7),
            ("cut in its numbers", sound[..sound.len() - 20].to_vec(), 7),
            ("a JSON longer than the file", length(12, u32::MAX), 7),
            ("numbers longer than the file", length(20 + json_length, u32::MAX), 7),
            ("chunks of another kind", length(16, 0x4e4f_534b), 7),
            ("no JSON in it", glb(&Value::Null, &binary), 7),
            ("deep JSON", raw_glb("[".repeat(1_000_000).as_bytes(), &[]), 7),
            (
                "a million nodes",
                raw_glb(
                    format!(
                        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}",
                        "{},".repeat(1_000_000)
                    )
                    .as_bytes(),
                    &[],
                ),
                7,
            ),
            ("40 MB of JSON", raw_glb(" ".repeat(40 << 20).as_bytes(), &[]), 7),
            ("no mesh", with("/nodes/0", json!({})), 3),
            ("a mesh that is missing", with("/nodes/0/mesh", 1.into()), 7),
            ("a node that is missing", with("/scenes/0/nodes/0", 7.into()), 7),
            ("a scene that is missing", with("/scene", 7.into()), 7),
            ("an accessor that is missing", with("/meshes/0/primitives/0/indices", u32::MAX.into()), 7),
            ("a buffer view that is missing", with("/accessors/0/bufferView", 9.into()), 7),
            (
                "an accessor without a view",
                with(
                    "/accessors/0",
                    json!({ "componentType": 5126, "count": 3_000_000_000_u64, "type": "VEC3" }),
                ),
                7,
            ),
            ("a buffer that is missing", with("/bufferViews/0/buffer", 1.into()), 7),
            ("a material that is missing", with("/meshes/0/primitives/0/material", 0.into()), 7),
            ("a buffer longer than the file", with("/buffers/0/byteLength", (1_u64 << 40).into()), 7),
            ("a view longer than its buffer", with("/bufferViews/0/byteLength", 100.into()), 7),
            ("a view that begins nowhere", with("/bufferViews/0/byteOffset", u64::MAX.into()), 7),
            ("an accessor that begins nowhere", with("/accessors/0/byteOffset", (u64::MAX - 8).into()), 7),
            ("more numbers than bytes", with("/accessors/0/count", 4.into()), 7),
            ("10^19 numbers", with("/accessors/0/count", u64::MAX.into()), 7),
            ("a negative count", with("/accessors/0/count", (-1).into()), 7),
            ("no stride to speak of", with("/bufferViews/0/byteStride", 0.into()), 7),
            ("a stride less than a number", with("/bufferViews/0/byteStride", 4.into()), 7),
            ("a negative stride", with("/bufferViews/0/byteStride", (-12).into()), 7),
            ("a long stride", with("/bufferViews/0/byteStride", (1_u64 << 62).into()), 7),
            ("an unknown type of number", with("/accessors/0/componentType", 5124.into()), 7),
            ("positions that are no vectors", with("/accessors/0/type", "SCALAR".into()), 7),
            ("indices that are vectors", with("/accessors/1/type", "VEC2".into()), 7),
            ("indices with a point", with("/meshes/0/primitives/0/indices", 0.into()), 7),
            ("sparse numbers", with("/accessors/0/sparse", json!({ "count": 1 })), 7),
            ("an index beyond the vertices", glb(&triangle, &beyond), 7),
            ("no number", not_finite(f32::NAN), 7),
            ("an infinite number", not_finite(f32::INFINITY), 7),
            (
                "a place that is none",
                with("/nodes/0/matrix", json!([1e38, 0, 0, 0, 0, 1e38, 0, 0, 0, 0, 1e38, 0, 1e39, 0, 0, 1])),
                7,
            ),
            (
                "a perspective for a place",
                with("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
                7,
            ),
            ("a turn about nothing", with("/nodes/0/rotation", json!([0, 0, 0, 0])), 7),
            ("a node inside itself", with("/nodes/0/children", json!([0])), 7),
            ("nodes in a circle", chain(3, json!({ "mesh": 0, "children": [0] })), 7),
            ("a node with two parents", with("/nodes", doubling), 7),
            ("200,000 nodes in each other", chain(200_000, json!({ "mesh": 0 })), 7),
            ("points", with("/meshes/0/primitives/0/mode", 0.into()), 3),
            (
                "compressed",
                with("/meshes/0/primitives/0/extensions", json!({ "KHR_draco_mesh_compression": {} })),
                3,
            ),
            (
                "an extension that is not known",
                with("/extensionsRequired", json!(["EXT_meshopt_compression"])),
                3,
            ),
            ("no base64", with("/buffers/0/uri", "data:application/octet-stream;base64,&&&&".into()), 7),
            ("short base64", with("/buffers/0/uri", "data:application/octet-stream;base64,AAAA".into()), 7),
            ("data of no kind", with("/buffers/0/uri", "data:,hello".into()), 7),
            ("a file above its folder", with("/buffers/0/uri", "../secret.bin".into()), 3),
            ("a hidden way up", with("/buffers/0/uri", "x/%2e%2e/%2e%2e/secret.bin".into()), 3),
            ("a file at the root", with("/buffers/0/uri", "/etc/passwd".into()), 3),
            ("a file of the net", with("/buffers/0/uri", "https://example.org/a.bin".into()), 3),
            ("a device", with("/buffers/0/uri", "%2fdev%2fzero".into()), 3),
            ("a file that is missing", with("/buffers/0/uri", "missing.bin".into()), 7),
            ("the same bytes in many meshes", many_views(40), 7),
            ("as many places as it says, and not", instancing(json!({ "TRANSLATION": 0, "SCALE": 1 })), 7),
            ("a list of places that is missing", instancing(json!({ "TRANSLATION": 5 })), 7),
            ("turns of three numbers", instancing(json!({ "ROTATION": 0 })), 7),
            ("200 million places", glb(&crowd, &binary), 7),
            ("a million parts", crumbs, 7),
            ("100,000 materials", colourful, 3),
        ],
    );
    // What is odd and no mistake.
    let deep = chain(20_000, json!({ "mesh": 0 }));
    for (name, file) in [("deep nodes", deep), ("two million copies", everywhere), ("a sound file", sound)] {
        let output = check(&[("world.toml", model_world("model.glb")), ("model.glb", file)]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn objs() {
    let text = |text: String| text.into_bytes();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    models(
        "model.obj",
        vec![
            ("empty", vec![], 3),
            ("zeros", vec![0; 1 << 20], 3),
            ("a picture", png([8, 8]), 3),
            ("no faces", corners.into(), 3),
            ("corners that are missing", text(format!("{corners}f 1 2 4\n")), 7),
            ("a corner numbered 0", text(format!("{corners}f 0 1 2\n")), 7),
            ("corners before the first", text(format!("{corners}f -1 -2 -4\n")), 7),
            ("a corner of 20 digits", text(format!("{corners}f 1 2 99999999999999999999\n")), 7),
            ("the least number there is", text(format!("{corners}f 1 2 -9223372036854775808\n")), 7),
            ("normals that are missing", text(format!("{corners}f 1//1 2//1 3//1\n")), 7),
            ("two corners", text(format!("{corners}f 1 2\n")), 7),
            ("words for numbers", text("v a b c\n".into()), 7),
            ("no number", text(format!("v nan 0 0\n{corners}f 1 2 3\n")), 7),
            ("an infinite number", text(format!("v 1e999 0 0\n{corners}f 1 2 3\n")), 7),
            ("a number that is missing", text("v 1 2\n".into()), 7),
            // A hundred megabytes of faces.
            ("millions of faces", text(format!("{corners}{}", "f 1 2 3\n".repeat(14_000_000))), 7),
            ("a face of millions of corners", text(format!("{corners}f {}", "1 2 3 ".repeat(14_000_000))), 7),
            ("millions of corners", text("v 1 1 1\n".repeat(14_000_000)), 7),
            (
                "millions of materials",
                text((0..2_000_000).map(|index| format!("usemtl m{index}\nv 0 0 0\nf 1 1 1\n")).collect()),
                7,
            ),
        ],
    );
    // Materials are a wish, and a face without them is grey.
    for library in ["/etc/passwd", "../../secret.mtl", "missing.mtl", "world.toml"] {
        let object = text(format!("mtllib {library}\nusemtl red\n{corners}f 1 2 3\n"));
        let output = check(&[("world.toml", model_world("model.obj")), ("model.obj", object)]);
        assert_eq!(output.status.code(), Some(0), "{library}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn plys() {
    let header = |format: &str, vertices: &str, faces: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {faces}\nproperty list uchar uint vertex_indices\nend_header\n"
        )
    };
    let text = |vertices: &str, faces: &str, data: &str| {
        [header("ascii", vertices, faces).as_str(), data].concat().into_bytes()
    };
    let bytes = |vertices: &str, faces: &str, data: &[u8]| {
        [header("binary_little_endian", vertices, faces).as_bytes(), data].concat()
    };
    let corners = "0 0 0\n1 0 0\n0 1 0\n";
    let longs = |kind: &str, count: &[u8]| {
        let header =
            header("binary_little_endian", "3", "1").replace("list uchar uint", &format!("list {kind} uint"));
        [header.as_bytes(), &[0; 36], count, &[0; 12]].concat()
    };
    models(
        "model.ply",
        vec![
            ("empty", vec![], 7),
            ("its magic alone", b"ply\n".to_vec(), 7),
            ("no end of its header", b"ply\nformat ascii 1.0\n".repeat(10_000), 7),
            ("a picture", png([8, 8]), 7),
            ("10^18 vertices", text("1000000000000000000", "1", corners), 7),
            ("more vertices than can be counted", text("99999999999999999999999", "1", corners), 7),
            ("negative vertices", text("-3", "1", corners), 7),
            ("10^18 vertices in bytes", bytes("1000000000000000000", "1", &[0; 48]), 7),
            ("10^18 faces", bytes("3", "1000000000000000000", &[0; 48]), 7),
            ("cut in its vertices", bytes("3", "1", &[0; 30]), 7),
            ("cut in its faces", bytes("3", "1", &[[0; 36].as_slice(), &[3, 0, 0, 0, 0]].concat()), 7),
            ("a face longer than the file", longs("uint", &u32::MAX.to_le_bytes()), 7),
            ("a face of negative length", longs("int", &(-3_i32).to_le_bytes()), 7),
            ("a corner that is missing", text("3", "1", &format!("{corners}3 0 1 3\n")), 7),
            ("a negative corner", text("3", "1", &format!("{corners}3 0 1 -1\n")), 7),
            ("no number", text("3", "1", "nan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), 7),
            ("words for numbers", text("3", "1", "a b c\n1 0 0\n0 1 0\n3 0 1 2\n"), 7),
            ("no faces", text("3", "0", corners), 3),
            ("faces of two corners", text("3", "1", &format!("{corners}2 0 1\n")), 3),
            (
                "nothing but an element without properties",
                b"ply\nformat ascii 1.0\nelement vertex 1000000000000\nend_header\n".to_vec(),
                7,
            ),
            (
                "60 million empty faces",
                {
                    let data = [vec![0; 36], vec![0; 60_000_000]].concat();
                    bytes("3", "60000000", &data)
                },
                7,
            ),
        ],
    );
}

/// Sets what a JSON pointer names, and makes the last key if need be.
fn set(json: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match json.pointer_mut(parent).unwrap() {
        Value::Object(object) => drop(object.insert(key.into(), value)),
        Value::Array(array) if key.parse() == Ok(array.len()) => array.push(value),
        array => array[key.parse::<usize>().unwrap()] = value,
    }
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    raw_glb(json.to_string().as_bytes(), binary)
}

fn raw_glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
    let chunks = [&length(&json), &b"JSON"[..], &json, &length(binary), b"BIN\0", binary].concat();
    [b"glTF", &2_u32.to_le_bytes()[..], &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

fn models(file: &'static str, cases: Vec<(&str, Vec<u8>, i32)>) {
    for (name, bytes, expected) in cases {
        let files = vec![("world.toml", model_world(file)), (file, bytes)];
        run(&Case { name: format!("{file}: {name}"), files, expected });
    }
}

fn model_world(file: &str) -> Vec<u8> {
    format!("format = 1\nmodels = [{{ file = \"{file}\", height = 1 }}]").into_bytes()
}

fn maps(file: &'static str, cases: Vec<(&str, Vec<u8>, i32)>) {
    for (name, bytes, expected) in cases {
        let files = vec![("world.toml", heightmap(file)), (file, bytes)];
        run(&Case { name: format!("{file}: {name}"), files, expected });
    }
}

fn run(case: &Case) {
    let name = &case.name;
    let start = Instant::now();
    let output = check(&case.files);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(case.expected), "{name}: {message}");
    assert!(message.starts_with("error: ") && !message.contains("panicked"), "{name}: {message}");
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["error"]["exit_code"], case.expected, "{name}");
    // Not a measurement: hours are what this is about.
    assert!(start.elapsed() < Duration::from_secs(60), "{name} takes forever");
}

/// `terrane check world.toml` beside these files, with little memory.
fn check(files: &[(&'static str, Vec<u8>)]) -> Output {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    limited(folder.path(), LIMIT)
}

fn limited(folder: &Path, kib: u32) -> Output {
    Command::new("sh")
        .args(["-c", &format!("ulimit -v {kib} && exec \"$0\" check world.toml --json --no-time")])
        .arg(env!("CARGO_BIN_EXE_terrane"))
        .current_dir(folder)
        .output()
        .unwrap()
}

fn heightmap(file: &str) -> Vec<u8> {
    format!(
        "format = 1\n[terrain]\ncells = 64\nlayers = [{{ heightmap = {{ file = \"{file}\", min = 0, max = 100 }} }}]"
    )
    .into_bytes()
}

/// A grey file of 16 bits.
fn png([width, height]: [u32; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer().unwrap();
    for row in 0..height {
        stream.write_all(&[row as u8; 2].repeat(width as usize)).unwrap();
    }
    stream.finish().unwrap();
    drop(writer);
    bytes
}

/// A chunk of a PNG.
fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [name, data].concat();
    [&(data.len() as u32).to_be_bytes(), named.as_slice(), &crc32(&named).to_be_bytes()].concat()
}

/// One channel of 24 × 20 values.
fn exr(compression: Compression, blocks: Blocks, channel: &str, value: f32) -> Vec<u8> {
    let values = (0..24 * 20).map(|index| value * index as f32).collect();
    let channel = AnyChannel::new(channel, FlatSamples::F32(values));
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new((24, 20), LayerAttributes::named("layer"), encoding, channels);
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

/// ISO 3309, as PNG has it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 },
        )
    })
}
