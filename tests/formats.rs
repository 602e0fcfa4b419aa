//! Files: what is written is read back by independent readers, what is read is refused unless it is sound, and a forged
//! header costs no memory.

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
};
use exr::prelude::{LineOrder, ReadChannels, ReadLayers, Vec2, WritableImage};
use image::ImageDecoder;
use proptest::prelude::*;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;
use tempfile::TempDir;
use terrane::formats::png::Depth;
use terrane::formats::sidecar::{Range, Sidecar, Values};
use terrane::formats::{self, Error, FirstRow, Hints, Map, Scale, Window, file, sidecar};

// Round trips.

#[test]
fn a_picture_in_png_says_that_it_is_srgb_and_keeps_its_pixels() {
    let folder = folder();
    let path = folder.path().join("picture.png");
    let pixels: Vec<u8> = (0..7 * 5).flat_map(|i| [i, 255 - i, 3 * i]).collect();
    let written = formats::png::write_picture(&path, [7, 5], &pixels).unwrap();

    let bytes = fs::read(&path).unwrap();
    let decoder = image::codecs::png::PngDecoder::new(io::Cursor::new(&bytes)).unwrap();
    assert_eq!(decoder.color_type(), image::ColorType::Rgb8);
    let picture = image::open(&path).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (7, 5));
    assert_eq!(*picture.as_raw(), pixels);
    assert!(bytes.windows(4).any(|chunk| chunk == b"sRGB"));
    assert_eq!((written.bytes, written.sha256), (bytes.len() as u64, sha256(&bytes)));
}

#[test]
fn a_height_map_in_png_comes_back_within_half_a_step() {
    let folder = folder();
    let path = folder.path().join("height.png");
    let (values, range) = (ramp(9 * 6), [-120.0, 730.0]);
    write_png(&path, [9, 6], &values, range).unwrap();
    sidecar::write(&path, &beside(range)).unwrap();

    // An independent reader sees the integers.
    let grey = image::open(&path).unwrap();
    assert_eq!(grey.color(), image::ColorType::L16);
    let step = (range[1] - range[0]) / 65535.0;
    for (stored, &value) in grey.into_luma16().as_raw().iter().zip(&values) {
        let height = range[0] + f32::from(*stored) * step;
        assert!((height - value).abs() <= 0.51 * step, "{height} {value}");
    }
    // And so do we, by the sidecar, or by a range that is given.
    let map = read_map(&path).unwrap();
    assert_eq!((map.width, map.height, map.scale, map.range), (9, 6, Scale::Share, Some(range)));
    let metres = map.clone().into_metres(None).unwrap();
    assert!(largest_difference(&metres.values, &values) <= 0.51 * step);
    let doubled = map.into_metres(Some([-240.0, 1460.0])).unwrap();
    let twice: Vec<f32> = values.iter().map(|value| 2.0 * value).collect();
    assert!(largest_difference(&doubled.values, &twice) <= 1.02 * step);
}

#[test]
fn a_png_that_nothing_says_the_heights_of_is_no_height_map() {
    let folder = folder();
    let path = folder.path().join("height.png");
    write_png(&path, [4, 4], &ramp(16), [0.0, 1.0]).unwrap();
    let error = read_map(&path).unwrap().into_metres(None).unwrap_err();
    assert!(matches!(error, Error::NoRange { .. }));
    assert!(error.to_string().contains("height.png.json"), "{error}");
}

#[test]
fn a_flat_layer_survives_png() {
    let folder = folder();
    let path = folder.path().join("reef.png");
    write_png(&path, [4, 4], &[2.5; 16], [2.5, 2.5]).unwrap();
    let map = read_map(&path).unwrap().into_metres(Some([2.5, 2.5])).unwrap();
    assert_eq!(map.values, [2.5; 16]);
}

#[test]
fn weights_in_png_are_red_green_blue_and_alpha() {
    let folder = folder();
    let path = folder.path().join("splat.png");
    let weights = [0.0, 0.25, 0.5, 1.0, 1.0, 0.0, 0.0, 2.0];
    let write = |depth, channels| {
        let window = Window::whole(&weights[..2 * channels], [2, 1], channels);
        formats::png::write_integers(&path, window, depth, [0.0, 1.0])
    };
    write(Depth::Sixteen, 4).unwrap();
    let splat = image::open(&path).unwrap();
    assert_eq!(splat.color(), image::ColorType::Rgba16);
    assert_eq!(*splat.into_rgba16().as_raw(), [0, 16384, 32768, 65535, 65535, 0, 0, 65535]);
    write(Depth::Eight, 4).unwrap();
    let splat = image::open(&path).unwrap();
    assert_eq!(splat.color(), image::ColorType::Rgba8);
    assert_eq!(*splat.into_rgba8().as_raw(), [0, 64, 128, 255, 255, 0, 0, 255]);
    assert!(write(Depth::Sixteen, 2).is_err());
}

#[test]
fn a_picture_in_exr_keeps_its_floats_and_says_what_they_are() {
    let folder = folder();
    let path = folder.path().join("picture.exr");
    let pixels: Vec<[f32; 3]> = (0..20 * 18).map(|i| [i as f32 * 0.37, 1e-6 * i as f32, 65_536.5]).collect();
    formats::exr::write_picture(&path, [20, 18], &pixels, 12_500.0).unwrap();

    let picture = exr::prelude::read_first_rgba_layer_from_file(
        &path,
        |size, _| vec![[0.0; 3]; size.area()],
        |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * 20 + at.x()] = [r, g, b],
    )
    .unwrap();
    assert_eq!(picture.layer_data.channel_data.pixels, pixels);
    assert_eq!(picture.layer_data.attributes.white_luminance, Some(12_500.0));
    let primaries = picture.attributes.chromaticities.unwrap();
    assert_eq!((primaries.red.x(), primaries.white.y()), (0.64, 0.329));
}

#[test]
fn layers_in_exr_are_channels_by_name() {
    let folder = folder();
    let path = folder.path().join("land.exr");
    let (height, water) = (ramp(35 * 33), vec![0.125; 35 * 33]);
    let channels = vec![("water".into(), water.clone()), ("height".into(), height.clone())];
    formats::exr::write_channels(&path, [35, 33], channels).unwrap();

    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(&path)
        .unwrap();
    let channels = &image.layer_data.channel_data.list;
    let find = |name: &str| {
        let channel = channels.iter().find(|channel| channel.name.eq(name)).unwrap();
        channel.sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    assert_eq!(find("height"), height);
    assert_eq!(find("water"), water);
    // A map is read from the channel that is named for it.
    let map = read_map(&path).unwrap();
    assert_eq!((map.width, map.height, map.scale), (35, 33, Scale::Absolute));
    assert_eq!(map.values, height);
    let stretched = map.into_metres(Some([0.0, 1.0])).unwrap().values;
    assert_eq!(formats::extremes(&stretched), [0.0, 1.0]);
}

#[test]
fn an_exr_of_any_lossless_kind_is_read() {
    let folder = folder();
    let path = folder.path().join("map.exr");
    let values = ramp(70 * 50);
    for (compression, blocks) in [
        (Compression::Uncompressed, Blocks::ScanLines),
        (Compression::RLE, Blocks::ScanLines),
        (Compression::ZIP1, Blocks::ScanLines),
        (Compression::PIZ, Blocks::ScanLines),
        (Compression::ZIP16, Blocks::Tiles(Vec2(32, 16))),
    ] {
        write_exr(&path, [70, 50], compression, blocks, &values);
        assert_eq!(read_map(&path).unwrap().values, values, "{compression:?} {blocks:?}");
    }
}

#[test]
fn a_sidecar_is_plain_json() {
    let folder = folder();
    let path = folder.path().join("height.exr");
    sidecar::write(&path, &beside([-3.5, 811.25])).unwrap();
    let text = fs::read_to_string(folder.path().join("height.exr.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        json,
        serde_json::json!({
            "min": -3.5, "max": 811.25, "unit": "m", "samples": [9, 6], "first_row": "north", "extent": 8000.0, "cell_size": 15.625, "sea_level": 0.5,
            "seed": 7, "world": "volcano.toml", "world_sha256": "00ff",
            "set": ["terrain.cells=64"]
        })
    );
    let notes = sidecar::read(&path).unwrap();
    assert_eq!((notes.range, notes.samples), (Some([-3.5, 811.25]), Some([9, 6])));
    assert_eq!(sidecar::read(&folder.path().join("other.exr")).unwrap(), sidecar::Notes::default());
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let folder = folder();
    let write = |name: &str| {
        let pixels: Vec<[f32; 3]> = ramp(300 * 200).iter().map(|&v| [v, v * v, -v]).collect();
        formats::exr::write_picture(&folder.path().join(name), [300, 200], &pixels, 1.0).unwrap().sha256
    };
    assert_eq!(write("one.exr"), write("other.exr"));
}

// Whole or not at all.

#[test]
fn a_failed_writing_leaves_the_old_file_and_nothing_else() {
    let folder = folder();
    let path = folder.path().join("land.bin");
    fs::write(&path, "old").unwrap();
    let error = file::write(&path, |writer| {
        writer.write_all(&[7; 100_000])?;
        Err(io::ErrorKind::StorageFull.into())
    })
    .unwrap_err();
    let message = error.to_string();
    assert!(message.contains("land.bin") && message.contains("free some space"), "{message}");
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["land.bin"]);

    file::write(&path, |writer| writer.write_all(b"new")).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names(folder.path()), ["land.bin"]);
}

#[test]
fn asking_whether_a_file_could_be_written_leaves_no_trace() {
    let folder = folder();
    file::check_writable(&folder.path().join("new.png")).unwrap();
    assert_eq!(names(folder.path()), [""; 0]);

    let missing = file::check_writable(&folder.path().join("missing/new.png")).unwrap_err().to_string();
    assert!(missing.contains("make its folder first"), "{missing}");
    let directory = file::check_writable(folder.path()).unwrap_err().to_string();
    assert!(directory.contains("folder bears that name"), "{directory}");
}

#[cfg(unix)]
#[test]
fn devices_are_not_replaced_and_links_are_followed() {
    let folder = folder();
    let device = file::check_writable(Path::new("/dev/null")).unwrap_err().to_string();
    assert!(device.contains("device"), "{device}");

    let (target, link) = (folder.path().join("target.bin"), folder.path().join("link.bin"));
    fs::write(&target, "old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    file::write(&link, |writer| writer.write_all(b"new")).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&target).unwrap(), b"new");
}

// Refused.

#[test]
fn unreadable_files_are_named() {
    let folder = folder();
    let missing = read_map(&folder.path().join("missing.exr")).unwrap_err();
    assert!(
        matches!(missing, Error::Read { .. }) && missing.to_string().contains("missing.exr"),
        "{missing}"
    );

    let directory = folder.path().join("directory.png");
    fs::create_dir(&directory).unwrap();
    let error = read_map(&directory).unwrap_err();
    assert!(matches!(error, Error::Read { .. }) && error.to_string().contains("directory"), "{error}");

    let error = read_map(&folder.path().join("map.jpg")).unwrap_err();
    assert!(matches!(error, Error::Unsuitable { .. }) && error.to_string().contains(".exr"), "{error}");

    let text = folder.path().join("text.exr");
    fs::write(&text, "not a picture").unwrap();
    assert!(matches!(read_map(&text).unwrap_err(), Error::Corrupt { .. }));
}

#[test]
fn colour_pictures_and_holes_are_no_maps() {
    let folder = folder();
    let colour = folder.path().join("colour.png");
    formats::png::write_picture(&colour, [2, 2], &[1; 12]).unwrap();
    let error = read_map(&colour).unwrap_err().to_string();
    assert!(error.contains("greyscale"), "{error}");

    let hole = folder.path().join("hole.exr");
    formats::exr::write_channels(&hole, [2, 2], vec![("height".into(), vec![0.0, 1.0, f32::NAN, 3.0])])
        .unwrap();
    let error = read_map(&hole).unwrap_err().to_string();
    assert!(error.contains("column 0, row 1"), "{error}");

    let nameless = folder.path().join("nameless.exr");
    formats::exr::write_channels(&nameless, [1, 1], vec![("a".into(), vec![0.0]), ("b".into(), vec![0.0])])
        .unwrap();
    let error = read_map(&nameless).unwrap_err().to_string();
    assert!(error.contains("a, b") && error.contains("height"), "{error}");

    let worded = folder.path().join("height.png");
    write_png(&worded, [1, 1], &[0.0], [0.0, 1.0]).unwrap();
    fs::write(sidecar::path(&worded), "{\"min\": \"low\"}").unwrap();
    assert!(matches!(read_map(&worded).unwrap_err(), Error::Corrupt { format: "sidecar", .. }));
}

#[test]
fn cut_files_are_refused_wherever_they_are_cut() {
    let folder = folder();
    for (name, bytes) in samples(folder.path()) {
        // What follows the last row of a PNG (its checksums and the end mark) can be missed without harm.
        let needed = if name.ends_with(".png") { bytes.len() - 24 } else { bytes.len() };
        for length in (0..needed).step_by(7) {
            assert!(
                read_bytes(folder.path(), name, &bytes[..length]).is_err(),
                "{name} cut to {length} bytes"
            );
        }
    }
}

/// Each forged file is read by a process of its own that may take little memory.
#[cfg(target_os = "linux")]
#[test]
fn forged_sizes_cost_no_memory() {
    let folder = folder();
    for (name, bytes) in samples(folder.path()) {
        let sizes = [(1 << 14, 1 << 14), (1 << 14, 1), (1, 1 << 30), (i32::MAX - 1, i32::MAX - 1)];
        let forgeries = sizes.map(|size| forge_size(name, &bytes, size)).into_iter();
        for forged in forgeries.chain(forge_tiles(&bytes)) {
            let path = folder.path().join(name);
            fs::write(&path, forged).unwrap();
            let limited = Command::new("sh")
                .args(["-c", "ulimit -v 400000 && exec \"$0\" --exact --ignored reads_the_forged_file"])
                .arg(std::env::current_exe().unwrap())
                .env("FORGED_FILE", &path)
                // The memory that the C library reserves for each thread would count.
                .env("MALLOC_ARENA_MAX", "1")
                .output()
                .unwrap();
            let output = String::from_utf8_lossy(&limited.stdout) + String::from_utf8_lossy(&limited.stderr);
            assert!(limited.status.success(), "{name}: {output}");
            assert!(output.contains("1 passed"), "{output}");
        }
    }
}

#[test]
#[ignore = "run by forged_sizes_cost_no_memory"]
fn reads_the_forged_file() {
    let Some(path) = std::env::var_os("FORGED_FILE") else { return };
    assert!(read_map(Path::new(&path)).is_err());
}

proptest! {
    /// Sound files with some bytes changed are read or refused, without panic.
    #[test]
    fn fuzz_damaged_maps(
        which in 0..6_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        length in any::<prop::sample::Index>(),
        cut in 0..4_u8,
    ) {
        let folder = folder();
        static SAMPLES: OnceLock<Vec<(&str, Vec<u8>)>> = OnceLock::new();
        let (name, mut bytes) = SAMPLES.get_or_init(|| samples(folder.path()))[which].clone();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if cut == 0 {
            bytes.truncate(length.index(bytes.len()));
        }
        let _ = read_bytes(folder.path(), name, &bytes);
    }

    #[test]
    fn fuzz_noise(png in any::<bool>(), tail in prop::collection::vec(any::<u8>(), 0..400)) {
        let folder = folder();
        let (name, magic): (_, &[u8]) =
            if png { ("map.png", b"\x89PNG\r\n\x1a\n") } else { ("map.exr", &[0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]) };
        prop_assert!(read_bytes(folder.path(), name, &[magic, &tail].concat()).is_err());
    }

    #[test]
    fn fuzz_sidecars(text in "[{}\\[\\]\":, minax0-9.e+-]{0,40}") {
        let folder = folder();
        let path = folder.path().join("map.png");
        fs::write(sidecar::path(&path), text).unwrap();
        if let Ok(sidecar::Notes { range: Some([min, max]), .. }) = sidecar::read(&path) {
            prop_assert!(min.is_finite() && max.is_finite());
        }
    }
}

// Helpers.

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// Heights that rise unevenly from −120 to 730.
fn ramp(count: usize) -> Vec<f32> {
    (0..count).map(|i| -120.0 + 850.0 * (i as f32 / (count - 1) as f32).powf(1.5)).collect()
}

fn beside([min, max]: [f32; 2]) -> Sidecar {
    Sidecar {
        values: Values::One(Range { min, max, unit: "m".into() }),
        samples: [9, 6],
        first_row: FirstRow::North,
        byte_order: None,
        tile: None,
        extent: 8000.0,
        cell_size: 15.625,
        sea_level: 0.5,
        seed: 7,
        world: "volcano.toml".into(),
        world_sha256: "00ff".into(),
        set: vec!["terrain.cells=64".into()],
        engine: None,
    }
}

/// Sound files: the ones that are then damaged.
fn samples(folder: &Path) -> Vec<(&'static str, Vec<u8>)> {
    let (path, values) = (folder.join("sound"), ramp(24 * 20));
    write_png(&path, [24, 20], &values, [-120.0, 730.0]).unwrap();
    let mut samples = vec![("map.png", fs::read(&path).unwrap())];
    for (compression, blocks) in [
        (Compression::ZIP16, Blocks::ScanLines),
        (Compression::RLE, Blocks::ScanLines),
        (Compression::PXR24, Blocks::ScanLines),
        (Compression::B44, Blocks::ScanLines),
        (Compression::PIZ, Blocks::Tiles(Vec2(8, 8))),
    ] {
        write_exr(&path, [24, 20], compression, blocks, &values);
        samples.push(("map.exr", fs::read(&path).unwrap()));
    }
    samples
}

fn write_exr(path: &Path, size: [usize; 2], compression: Compression, blocks: Blocks, values: &[f32]) {
    let channel = AnyChannel::new("anything", FlatSamples::F32(values.to_vec()));
    let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new((size[0], size[1]), LayerAttributes::named("layer"), encoding, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

fn write_png(path: &Path, size: [u32; 2], values: &[f32], range: [f32; 2]) -> Result<file::Written, Error> {
    formats::png::write_integers(path, Window::whole(values, size, 1), Depth::Sixteen, range)
}

fn read_map(path: &Path) -> Result<Map, Error> {
    formats::read_map(path, Hints::default())
}

fn read_bytes(folder: &Path, name: &str, bytes: &[u8]) -> Result<Map, Error> {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    read_map(&path)
}

/// The file with another size in its header.
fn forge_size(name: &str, sound: &[u8], (width, height): (i32, i32)) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    if name.ends_with(".png") {
        // The size stands at a fixed place; the checksum of the header must be made anew.
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let checksum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        return bytes;
    }
    for window in ["dataWindow\0box2i\0", "displayWindow\0box2i\0"] {
        // Behind the length stands the least corner, then the greatest.
        let start = attribute(&bytes, window).unwrap() + 8;
        bytes[start..start + 4].copy_from_slice(&(width - 1).to_le_bytes());
        bytes[start + 4..start + 8].copy_from_slice(&(height - 1).to_le_bytes());
    }
    forget_count(&mut bytes);
    bytes
}

/// A tiled file whose tiles are said to be huge and whose first tile is said to fill one.
fn forge_tiles(sound: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = sound.to_vec();
    let start = attribute(&bytes, "tiles\0tiledesc\0")?;
    bytes[start..start + 4].copy_from_slice(&(1_u32 << 15).to_le_bytes());
    bytes[start + 4..start + 8].copy_from_slice(&(1_u32 << 14).to_le_bytes());
    // A single tile is left, behind a table of one offset: what was the table's second entry and third are taken for
    // its coordinates, and its length comes next.
    let first = bytes.windows(8).position(|word| {
        let offset = u64::from_le_bytes(word.try_into().unwrap());
        offset > 100 && offset < sound.len() as u64 && bytes[offset as usize..].starts_with(&[0; 16])
    })?;
    bytes[first + 24..first + 28].copy_from_slice(&i32::MAX.to_le_bytes());
    forget_count(&mut bytes);
    Some(bytes)
}

/// Makes another attribute of the one that counts the blocks: it is optional, and gives a forged size away.
fn forget_count(bytes: &mut [u8]) {
    let name = b"chunkCount";
    let start = bytes.windows(name.len()).position(|part| part == name).unwrap();
    bytes[start] = b'C';
}

/// Where the value of an attribute starts.
fn attribute(bytes: &[u8], name_and_type: &str) -> Option<usize> {
    let name = name_and_type.as_bytes();
    Some(bytes.windows(name.len()).position(|part| part == name)? + name.len() + 4)
}

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn largest_difference(one: &[f32], other: &[f32]) -> f32 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).fold(0.0, |largest, (one, other)| (one - other).abs().max(largest))
}

fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
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
