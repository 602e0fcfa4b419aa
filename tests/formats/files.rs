//! Files: what is written is read back by independent readers, and what is read is refused unless it is sound.

use crate::kit::tiff::{self, Tiff, Value};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
};
use exr::prelude::{LineOrder, ReadChannels, ReadLayers, Vec2, WritableImage};
use image::ImageDecoder;
use proptest::prelude::*;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::sync::OnceLock;
use tempfile::TempDir;
use terrane::formats::png::Depth;
use terrane::formats::raw::ByteOrder;
use terrane::formats::sidecar::{Range, Sidecar, Values};
use terrane::formats::tiff::Georeference;
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
fn raw_files_are_integers_in_the_order_that_was_asked_for() {
    let folder = folder();
    let path = folder.path().join("height.r16");
    let (values, range) = (ramp(9 * 6), [-120.0, 730.0]);
    for (order, first_row) in [
        (ByteOrder::Little, FirstRow::North),
        (ByteOrder::Big, FirstRow::North),
        (ByteOrder::Little, FirstRow::South),
    ] {
        let window = Window::whole(&values, [9, 6], 1).ordered(first_row);
        formats::raw::write(&path, window, range, order).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert_eq!(bytes.len(), 9 * 6 * 2);
        let step = (range[1] - range[0]) / 65535.0;
        for (index, pair) in bytes.as_chunks::<2>().0.iter().enumerate() {
            let (row, column) = (index / 9, index % 9);
            let row = if first_row == FirstRow::South { 5 - row } else { row };
            let integer =
                if order == ByteOrder::Big { u16::from_be_bytes(*pair) } else { u16::from_le_bytes(*pair) };
            let height = range[0] + f32::from(integer) * step;
            assert!(
                (height - values[row * 9 + column]).abs() <= 0.51 * step,
                "{order:?} {first_row:?} {index}"
            );
        }
        // The sidecar says how it is to be read.
        let sidecar = Sidecar { first_row, byte_order: Some(order), ..beside(range) };
        sidecar::write(&path, &sidecar).unwrap();
        let map = read_map(&path).unwrap();
        assert_eq!((map.width, map.height, map.scale), (9, 6, Scale::Share));
        let metres = map.into_metres(None).unwrap();
        assert!(largest_difference(&metres.values, &values) <= 0.51 * step, "{order:?} {first_row:?}");
    }
    let two = Window::whole(&values, [9, 3], 2);
    assert!(formats::raw::write(&path, two, range, ByteOrder::Little).is_err());
}

#[test]
fn hints_stand_for_a_sidecar_and_win_over_it() {
    let folder = folder();
    let path = folder.path().join("height.raw");
    let values: Vec<f32> = (0..16).map(|value| value as f32).collect();
    let window = Window::whole(&values, [4, 4], 1).ordered(FirstRow::South);
    formats::raw::write(&path, window, [0.0, 15.0], ByteOrder::Big).unwrap();
    let hints = Hints { byte_order: Some(ByteOrder::Big), first_row: Some(FirstRow::South) };
    let read =
        |hints| formats::read_map(&path, hints).unwrap().into_metres(Some([0.0, 15.0])).unwrap().values;
    assert!(largest_difference(&read(hints), &values) < 1e-3);
    assert!(largest_difference(&read(Hints::default()), &values) > 1.0);
    sidecar::write(&path, &Sidecar { samples: [4, 4], ..beside([0.0, 15.0]) }).unwrap();
    assert!(largest_difference(&read(hints), &values) < 1e-3);
}

#[test]
fn a_geotiff_holds_the_floats_and_where_they_lie() {
    let folder = folder();
    let path = folder.path().join("height.tif");
    let values = ramp(300 * 70);
    let place = Georeference { origin: [-1000.0, 2000.0], cell_size: 12.5 };
    formats::tiff::write(&path, Window::whole(&values, [300, 70], 1), place).unwrap();
    let bytes = fs::read(&path).unwrap();
    let doubles = |tag| {
        let (kind, value) = tiff::find(&bytes, tag).unwrap();
        assert_eq!(kind, 12);
        value.as_chunks::<8>().0.iter().map(|double| f64::from_le_bytes(*double)).collect::<Vec<f64>>()
    };
    assert_eq!(doubles(tiff::PIXEL_SCALE), [12.5, 12.5, 0.0]);
    assert_eq!(doubles(tiff::TIEPOINT), [0.0, 0.0, 0.0, -1000.0, 2000.0, 0.0]);
    let (_, keys) = tiff::find(&bytes, tiff::GEO_KEYS).unwrap();
    let keys: Vec<u16> = keys.as_chunks::<2>().0.iter().map(|key| u16::from_le_bytes(*key)).collect();
    let (header, keys) = keys.as_chunks::<4>().0.split_first().unwrap();
    assert_eq!((header[0], usize::from(header[3])), (1, keys.len()));
    // Samples are points; lengths are in metres.
    assert!(keys.contains(&[1025, 0, 1, 2]) && keys.contains(&[3076, 0, 1, 9001]), "{keys:?}");
    assert!(keys.is_sorted(), "{keys:?}");
    assert_eq!(tiff::find(&bytes, tiff::NO_DATA).unwrap().1, b"nan\0");

    let map = read_map(&path).unwrap();
    assert_eq!((map.width, map.height, map.scale), (300, 70, Scale::Absolute));
    assert_eq!(map.values, values);
    // A part of a raster, and several bands.
    let part = Window::whole(&values, [100, 70], 3).part([10, 20], [30, 40]);
    formats::tiff::write(&path, part, place).unwrap();
    let mut decoder = ::tiff::decoder::Decoder::new(fs::File::open(&path).unwrap()).unwrap();
    assert_eq!(decoder.dimensions().unwrap(), (30, 40));
    let ::tiff::decoder::DecodingResult::F32(bands) = decoder.read_image().unwrap() else {
        panic!("no floats")
    };
    let expected: Vec<f32> = part.rows().flatten().copied().collect();
    assert_eq!(bands, expected);
    assert_eq!(bands[4], values[3 * (20 * 100 + 10) + 4]);
    assert!(read_map(&path).unwrap_err().to_string().contains("3 bands"));
}

#[test]
fn tiffs_of_other_programs_are_read() {
    let folder = folder();
    let path = folder.path().join("map.tif");
    let heights: Vec<i16> = (0..40 * 30).map(|value| value * 7 - 3000).collect();
    let expected: Vec<f32> = heights.iter().copied().map(f32::from).collect();
    let read = |file: &Tiff| {
        fs::write(&path, file.bytes()).unwrap();
        read_map(&path).unwrap()
    };
    // Elevations as surveys have them, in both byte orders, in one strip and in several.
    for big_endian in [false, true] {
        for rows in [30, 7] {
            let bytes = |height: &i16| if big_endian { height.to_be_bytes() } else { height.to_le_bytes() };
            let chunks =
                heights.chunks(40 * rows).map(|rows| rows.iter().flat_map(bytes).collect()).collect();
            let file = Tiff { big_endian, ..Tiff::strips([40, 30], 16, 2, rows as u32, chunks) };
            let map = read(&file);
            assert_eq!((map.scale, &map.values), (Scale::Absolute, &expected), "{big_endian} {rows}");
        }
    }
    // Tiles that reach beyond the edges, of 64-bit floats.
    let within = &expected;
    let tile = |left: usize, top: usize| {
        let sample = move |index: usize| {
            let [column, row] = [left + index % 16, top + index / 16];
            let height = if column < 40 && row < 30 { within[row * 40 + column] } else { -1e30 };
            f64::from(height).to_le_bytes()
        };
        (0..256).flat_map(sample).collect::<Vec<u8>>()
    };
    let corners = [[0, 0], [16, 0], [32, 0], [0, 16], [16, 16], [32, 16]];
    let tiles = corners.iter().map(|[left, top]| tile(*left, *top)).collect();
    assert_eq!(read(&Tiff::tiles([40, 30], 64, 3, [16, 16], tiles)).values, expected);
    // Unsigned integers are shares, unless they lie somewhere.
    let grey: Vec<u8> = (0..64_u16).flat_map(|value| (value * 1040).to_le_bytes()).collect();
    let grey = Tiff::strips([8, 8], 16, 1, 8, vec![grey]);
    let map = read(&grey);
    assert_eq!((map.scale, map.values[63]), (Scale::Share, 63.0 * 1040.0 / 65535.0));
    let placed = grey.with(tiff::PIXEL_SCALE, Value::Double(vec![30.0, 30.0, 0.0]));
    let map = read(&placed);
    assert_eq!((map.scale, map.values[63]), (Scale::Absolute, 63.0 * 1040.0));
    let bytes = Tiff::strips([8, 8], 8, 1, 8, vec![(0..64).map(|value| value * 4).collect()]);
    assert_eq!(
        read(&bytes.with(tiff::PIXEL_SCALE, Value::Double(vec![30.0, 30.0, 0.0]))).values[63],
        252.0 / 255.0
    );
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
    let error = read_map(&worded).unwrap_err();
    assert!(matches!(error, Error::ForeignSidecar { .. }), "{error}");
    let error = error.to_string();
    assert!(error.contains("height.png.json") && error.contains("none of terrane"), "{error}");
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

proptest! {
    /// Sound files with some bytes changed are read or refused, without panic.
    #[test]
    fn fuzz_damaged_maps(
        which in 0..8_usize,
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
    let place = Georeference { origin: [0.0, 0.0], cell_size: 1.0 };
    formats::tiff::write(&path, Window::whole(&values, [24, 20], 1), place).unwrap();
    samples.push(("map.tif", fs::read(&path).unwrap()));
    let tiles = [vec![1; 1024], vec![2; 1024]];
    samples.push(("map.tif", Tiff::tiles([24, 20], 16, 2, [16, 32], tiles.into()).bytes()));
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
