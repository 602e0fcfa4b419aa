//! Forged and damaged input, one case a file: the program ends with an error and its exit code, within 512 MiB of memory
//! beside its own, and never panics.

#![cfg(target_os = "linux")]

mod kit;

use exr::prelude::{AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer};
use exr::prelude::{LayerAttributes, LineOrder, Vec2, WritableImage};
use kit::tiff::{self, Tiff, Value};
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
    let long = |tag, value| sound().with(tag, Value::Long(vec![value])).bytes();
    let short = |tag, values: &[u16]| sound().with(tag, Value::Short(values.to_vec())).bytes();
    let size = |width, height| {
        sound()
            .with(tiff::WIDTH, Value::Long(vec![width]))
            .with(tiff::HEIGHT, Value::Long(vec![height]))
            .with(tiff::ROWS_PER_STRIP, Value::Long(vec![height]))
            .bytes()
    };
    let tile = |width, height| {
        tiled()
            .with(tiff::TILE_WIDTH, Value::Long(vec![width]))
            .with(tiff::TILE_HEIGHT, Value::Long(vec![height]))
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
                    .with(tiff::TILE_WIDTH, Value::Long(vec![8]))
                    .with(tiff::TILE_OFFSETS, Value::Offsets)
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
                    .with(tiff::NO_DATA, Value::Ascii("-9999".into()))
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
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
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
        .args(["-c", &format!("ulimit -v {kib} && exec \"$0\" check world.toml --json")])
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
