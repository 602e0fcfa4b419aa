//! The viewer in a real window, with real keys and a real mouse. Every run is under validation: a message fails it.

use crate::kit::desktop::{Desktop, Viewer};
use crate::kit::picture::flip;
use crate::kit::program::{good, json, stderr, terrane};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// A small island that is done in seconds.
const ISLAND: &str = "# A comment that stays.\nformat = 1\nreef = \"none\"\n\n[terrain]\ncells = 64 # few\n\n\
    [erosion.hydraulic]\nduration = 40 # seconds\n\n[erosion.thermal]\nrepose = 35\n\n[render]\nspp = 4096\n";

/// Somewhere in it.
const PLACE: &str = "ByVDVhEAAAHJmfewgAANgwAAEYHsJ9YwAAheQjOkAI2uPAAPl8Pq";

const ZOOM: &str = "format = 1\n\n[zoom]\ntile = 4\ndepth = 3\n";

/// A small glade, wherever its file lies.
fn forest() -> String {
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/configs/forest/tiny.toml"));
    let species = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/species/");
    text.expect("it is there").replace("../species/", species)
}

fn folder_with(worlds: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in worlds {
        fs::write(folder.path().join(name), text).expect("it can be written");
    }
    folder
}

fn text(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).expect("it is there")
}

#[test]
fn an_island_is_watched_changed_and_left() {
    // It goes on for as long as the test.
    let island = ISLAND.replace("duration = 40", "duration = 1000000");
    let folder = folder_with(&[("island.toml", &island)]);
    let folder = folder.path();
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder, &["island.toml", "--size", "960x640"], &[]);
    viewer.see("Simulation");

    // Keys are found by words; a number is written, and taken back.
    viewer.push("find a key");
    let search = viewer.place("find a key");
    viewer.type_in("repose");
    viewer.see("repose under water");
    viewer.enter("erosion.thermal.repose", "30");
    viewer.see("not saved");
    viewer.key("ctrl+z");
    viewer.see_no("not saved");
    viewer.click(&search);
    viewer.key("ctrl+a");
    viewer.key("BackSpace");
    viewer.see_no("repose under water");
    viewer.type_in("cells");
    viewer.see("terrain.cells begins the world again");
    viewer.key("ctrl+a");
    viewer.key("BackSpace");
    viewer.key("Escape");

    // Processes off and on, a single step, and from the start.
    viewer.push("Water");
    viewer.push("Water");
    viewer.push("Pause");
    viewer.see("Play");
    viewer.push("Step");
    viewer.push("Restart");

    // Flight: the eye is elsewhere, and that is put into the world.
    viewer.drag([600, 300], [700, 260], "1");
    viewer.drag([600, 300], [640, 320], "3");
    viewer.wheel([650, 300], true);
    viewer.hold("w", Duration::from_millis(400));
    viewer.push("Put this view into the world");
    viewer.see("not saved");
    viewer.key("ctrl+s");
    viewer.see_no("not saved");
    let saved = text(folder, "island.toml");
    assert!(
        saved.contains("look_at") && saved.contains("# A comment that stays.") && saved.contains("64 # few"),
        "{saved}"
    );

    // Taken back, and done again.
    viewer.key("ctrl+z");
    viewer.see("not saved");
    viewer.key("ctrl+s");
    viewer.see_no("not saved");
    assert_eq!(text(folder, "island.toml"), island);
    viewer.key("ctrl+y");
    viewer.see("not saved");
    viewer.key("ctrl+z");
    viewer.see_no("not saved");

    for step in 0..100 {
        viewer.resize([640 + 7 * (step % 50), 360 + 5 * (step % 40)]);
    }
    viewer.resize([960, 540]);
    std::thread::sleep(Duration::from_millis(500));
    let place = viewer.origin();
    viewer.minimise();
    std::thread::sleep(Duration::from_millis(300));
    viewer.restore();
    // The window manager has it somewhere else on the way, and a full screen would come back to there.
    viewer.wait("its place", |viewer| (viewer.origin() == place).then_some(()));
    std::thread::sleep(Duration::from_millis(500));
    viewer.key("F1");
    viewer.see_no("Simulation");
    viewer.key("F1");
    viewer.see("Simulation");
    // Each is waited for: a window that is still on its way to the one is lost by the other.
    viewer.key("F11");
    viewer.wait("a full screen", |viewer| (viewer.origin() == [0, 0]).then_some(()));
    viewer.key("F11");
    viewer.wait("a window", |viewer| (viewer.origin() != [0, 0]).then_some(()));

    viewer.key("ctrl+e");
    viewer.push("Write files");
    viewer.push("Cancel");
    viewer.see("the export was interrupted");
    viewer.push("Close");

    viewer.key("ctrl+q");
    good(&viewer.end());
}

#[test]
fn a_picture_is_traced_and_left() {
    let folder = folder_with(&[("island.toml", ISLAND)]);
    let folder = folder.path();
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder, &["island.toml", "--size", "960x540"], &[]);
    viewer.see("finished");
    viewer.push("Path tracing");
    viewer.push("Trace paths");
    viewer.see("Stop");
    viewer.see("error about");
    viewer.push("Stop");
    viewer.see("Trace paths");
    // It is left while it traces.
    viewer.push("Trace paths");
    viewer.see("Stop");
    viewer.key("ctrl+q");
    good(&viewer.end());
}

/// What stands in the window before some words, as a number.
#[track_caller]
fn number_before(viewer: &mut Viewer<'_>, words: &str) -> f64 {
    viewer.wait(words, |viewer| {
        let shown = viewer.shown();
        let line = shown.lines().find(|line| line.contains(words))?;
        line.split(words).next()?.split_whitespace().last()?.parse().ok()
    })
}

#[test]
fn plants_are_marked_and_a_traced_picture_is_exposed_anew() {
    let forest = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/forest/tiny.toml");
    let folder = folder_with(&[]);
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder.path(), &[forest, "--size", "640x400"], &[]);
    viewer.see("Simulation");
    viewer.push("Simulation");
    viewer.push("Plants");
    viewer.see("Click a plant");
    // Grass and trees are all round the eye.
    viewer.drag([480, 300], [480, 300], "1");
    viewer.see("stands at");
    viewer.key("Escape");
    viewer.see("Click a plant");
    viewer.push("Plants");

    viewer.push("Path tracing");
    viewer.push("Picture");
    viewer.key("p");
    viewer.see("error about");
    let before = number_before(&mut viewer, " of 64 samples");
    viewer.enter("+0.00 stops", "1.5");
    viewer.see("not saved");
    viewer.see("+1.50 stops");
    let after = number_before(&mut viewer, " of 64 samples");
    assert!(after >= before, "{before} samples a pixel, and then {after}");
    // From another place it goes on by itself.
    viewer.drag([480, 300], [520, 300], "1");
    viewer.see("Stop");
    viewer.see("error about");
    viewer.key("ctrl+z");
    viewer.see("+0.00 stops");
    viewer.key("ctrl+q");
    good(&viewer.end());
}

fn pixels(path: &Path) -> image::RgbImage {
    image::open(path).expect("a picture").into_rgb8()
}

/// Where the eye is, as the bar below says it.
#[track_caller]
fn eye(viewer: &mut Viewer<'_>) -> String {
    viewer.wait("m east", |viewer| {
        let shown = viewer.shown();
        let line = shown.lines().find(|line| line.contains(" m east"))?;
        line.splitn(3, ' ').nth(2).map(String::from)
    })
}

#[test]
fn places_are_gone_back_to_and_land_is_painted() {
    let folder = folder_with(&[("island.toml", ISLAND)]);
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder.path(), &["island.toml", "--size", "960x640"], &[]);
    viewer.see("finished");
    let here = eye(&mut viewer);
    viewer.key("ctrl+1");
    viewer.see("remembered this place as 1");
    viewer.drag([600, 300], [700, 260], "1");
    viewer.wait("another place", |viewer| (!viewer.shown().contains(&here)).then_some(()));
    viewer.key("1");
    viewer.see(&here);
    // The command line of this view, as it comes from the clipboard, makes the picture that is saved from here; rolled, too.
    viewer.hold("e", Duration::from_millis(300));
    // Until the window has heard of it.
    std::thread::sleep(Duration::from_millis(1000));
    viewer.key("ctrl+k");
    viewer.push("find a key");
    viewer.key("ctrl+v");
    let line = viewer.wait("a command line", |viewer| {
        let shown = viewer.shown();
        let begin = "terrane render 'island.toml' --set 'camera.view={";
        let line = shown.lines().find(|line| line.contains(begin))?;
        line.splitn(3, ' ').nth(2).map(String::from)
    });
    assert!(line.contains("roll = "), "{line}");
    viewer.key("ctrl+a");
    viewer.key("BackSpace");
    viewer.key("Escape");
    // In one frame with it, it would end the dialog that is opened.
    std::thread::sleep(Duration::from_millis(500));
    viewer.key("F12");
    viewer.push("📥  Save");
    viewer.see("wrote ");
    let saved = pixels(&folder.path().join("island.png"));
    // What stands in quotes is a word.
    let words = line.split('\'').enumerate().flat_map(|(index, part)| match index % 2 {
        0 => part.split_whitespace().collect(),
        _ => vec![part],
    });
    good(&terrane(folder.path(), &words.skip(1).collect::<Vec<_>>()));
    let rendered = pixels(&folder.path().join("island.png"));
    assert!(saved == rendered, "they differ");
    viewer.key("1");
    viewer.see(&here);

    // What is painted is asked about, and can be taken back.
    viewer.push("Simulation");
    viewer.push("Brush");
    viewer.push("Raise");
    viewer.drag([500, 300], [560, 300], "1");
    viewer.key("ctrl+q");
    viewer.see("Leave what was painted?");
    viewer.push("Cancel");
    viewer.see_no("Leave what was painted?");
    viewer.push("Take the last stroke back (1)");
    viewer.see_no("Take the last stroke back (");
    viewer.key("ctrl+q");
    good(&viewer.end());
}

#[test]
fn files_are_opened_and_written() {
    let folder = folder_with(&[("island.toml", ISLAND), ("zoom.toml", ZOOM)]);
    let folder = folder.path();
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder, &["island.toml", "--size", "960x540"], &[]);
    viewer.see("finished");
    viewer.key("ctrl+e");
    viewer.see("Write files");
    viewer.push("Write files");
    viewer.wait("height.exr", |_| folder.join("island/height.exr").exists().then_some(()));
    viewer.see_no("Write files");

    viewer.key("ctrl+o");
    viewer.push("🗋 zoom.toml");
    viewer.push("🗀  Open");
    viewer.see("Flight");
    viewer.key("ctrl+q");
    good(&viewer.end());
}

#[test]
fn an_export_is_not_left_without_asking() {
    let endless = "format = 1\n[terrain]\ncells = 128\n[erosion.hydraulic]\nduration = 1000000\n";
    let folder = folder_with(&[("endless.toml", endless)]);
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder.path(), &["endless.toml", "--size", "960x540"], &[]);
    viewer.push("Pause");
    viewer.key("ctrl+e");
    viewer.push("Write files");
    viewer.see("Cancel");
    viewer.key("ctrl+q");
    viewer.see("End the export?");
    viewer.push("Wait");
    viewer.see_no("End the export?");
    viewer.key("ctrl+q");
    viewer.push("End it");
    good(&viewer.end());
    assert!(!folder.path().join("endless/height.exr").exists());
}

#[test]
fn a_zoom_is_flown_in_and_out() {
    let folder = folder_with(&[("zoom.toml", ZOOM)]);
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder.path(), &["zoom.toml", "--size", "960x600"], &[]);
    viewer.see("Flight");
    viewer.see("depth 4");
    viewer.key("b");
    viewer.see("depth 2");
    viewer.push("Drawing");
    for mark in ["Levels", "Tile borders", "Wireframe", "Bounding boxes", "Corner heights", "Background"] {
        viewer.push(mark);
    }
    viewer.push("Freeze tiles");
    viewer.hold("w", Duration::from_millis(300));
    // The place is put into the world, which is seen from there.
    viewer.push("Drawing");
    viewer.push("Put this view into the world");
    viewer.key("ctrl+s");
    viewer.see_no("not saved");
    let saved = text(folder.path(), "zoom.toml");
    assert!(saved.contains("\nfrom = \"") && saved.contains("tile = 4"), "{saved}");
    good(&terrane(folder.path(), &["check", "zoom.toml"]));
    // From there, whatever is marked in the window, the picture that is saved is the one that the file makes.
    viewer.key("F12");
    viewer.push("📥  Save");
    viewer.see("wrote ");
    let picture = folder.path().join("zoom.png");
    let saved = pixels(&picture);
    let size = format!("{}x{}", saved.width(), saved.height());
    good(&terrane(folder.path(), &["render", "zoom.toml", "--size", &size, "-o", "zoom.png"]));
    assert!(saved == pixels(&picture), "they differ");
    viewer.key("ctrl+q");
    good(&viewer.end());
}

#[test]
fn what_is_not_saved_is_offered_again() {
    let folder = folder_with(&[("island.toml", ISLAND)]);
    let folder = folder.path();
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder, &["island.toml", "--size", "960x540"], &[]);
    viewer.push("Put this view into the world");
    viewer.see("not saved");
    std::thread::sleep(Duration::from_millis(1500));
    viewer.kill();

    // Killed, or asked to end.
    let mut viewer = desktop.view(folder, &["--size", "960x540"], &[]);
    viewer.see("Not saved when terrane ended");
    viewer.push("Open");
    viewer.see("not saved");
    viewer.terminate();
    assert_eq!(viewer.end().status.code(), Some(130));

    let mut viewer = desktop.view(folder, &["--size", "960x540"], &[]);
    viewer.see("Not saved when terrane ended");
    viewer.push("Open");
    viewer.see("not saved");
    viewer.key("ctrl+s");
    viewer.see_no("not saved");
    assert!(text(folder, "island.toml").contains("look_at"));
    viewer.key("ctrl+q");
    good(&viewer.end());
}

#[test]
fn windows_that_fail_are_made_again() {
    let folder = folder_with(&[("island.toml", ISLAND)]);
    let desktop = Desktop::new();
    let failures = "create:1:surface_lost,acquire:3:out_of_date,acquire:6:surface_lost,present:4:out_of_date,present:9:surface_lost";
    let arguments = ["island.toml", "--size", "480x270", "--exit-after", "40", "--json"];
    let viewer = desktop.view(folder.path(), &arguments, &[("TERRANE_LOSE_WINDOW", failures)]);
    let output = viewer.end();
    good(&output);
    assert_eq!(json(&output)["view"]["frames"], 40);
}

#[test]
fn a_lost_device_ends_it_and_nothing_else() {
    let folder = folder_with(&[("island.toml", ISLAND)]);
    let desktop = Desktop::new();
    for at in ["acquire", "submit", "present"] {
        let failure = format!("{at}:300:device_lost");
        let mut viewer = desktop.view(
            folder.path(),
            &["island.toml", "--size", "960x540"],
            &[("TERRANE_LOSE_WINDOW", &failure)],
        );
        viewer.push("Put this view into the world");
        viewer.see("not saved");
        // Frames, until it happens.
        while viewer.is_running() {
            viewer.press("F1");
        }
        let output = viewer.end();
        assert_eq!(output.status.code(), Some(5), "{at}: {}", stderr(&output));
        let kept = fs::read_dir(folder.path().join("state/recovery")).expect("it is kept");
        assert!(kept.flatten().any(|file| file.path().extension().is_some_and(|ending| ending == "json")));
        fs::remove_dir_all(folder.path().join("state")).expect("it is there");
    }
}

#[test]
fn windows_look_as_they_should() {
    let go = "push Stop\npush a place's code\ntype PLACE\nkey Enter\nwait 5\n".replace("PLACE", PLACE);
    let glade = forest();
    for (name, world, acts) in [
        ("start", "", "wait 5\n"),
        ("forest", glade.as_str(), "push Simulation\nwait 5\npush Plants\n"),
        ("island", ISLAND, "push Layers\nmove 600 300\nwait 30\n"),
        ("zoom", ZOOM, go.as_str()),
    ] {
        let script = format!("{acts}wait quiet\nwait 5\nscreenshot shot.png\nquit\n");
        let folder = folder_with(&[("world.toml", world), ("acts.txt", &script)]);
        let mut arguments = vec!["--size", "800x450", "--script", "acts.txt"];
        arguments.extend((!world.is_empty()).then_some("world.toml"));
        let desktop = Desktop::new();
        good(&desktop.view(folder.path(), &arguments, &[]).end());
        let path = format!("{}/tests/golden/window_{name}.png", env!("CARGO_MANIFEST_DIR"));
        let found = folder.path().join("shot.png");
        if std::env::var_os("TERRANE_BLESS").is_some() {
            fs::copy(&found, &path).expect("it is written");
        }
        let [golden, found] =
            [Path::new(&path), &found].map(|path| image::open(path).expect("a picture").into_rgb8());
        // Numbers that tell what was done on the way may differ; nothing else does.
        let difference = flip(&golden, &found);
        assert!(difference < 0.01, "{name}: FLIP {difference}");
    }
}

/// Keys and mouse at random, for about so many frames. Nothing that asks for a file, and nothing that ends it.
fn monkey(seed: u64, frames: u32) -> String {
    const KEYS: [&str; 26] = [
        "W",
        "A",
        "S",
        "D",
        "Space",
        "C",
        "Q",
        "E",
        "F",
        "F1",
        "F2",
        "Home",
        "Enter",
        "Period",
        "Backspace",
        "Escape",
        "Tab",
        "ArrowLeft",
        "ArrowUp",
        "ctrl+Z",
        "ctrl+Y",
        "1",
        "ctrl+1",
        "F5",
        "P",
        "G",
    ];
    // Splitmix64 (Steele, Lea & Flood 2014).
    let mut state = seed;
    let mut random = move |most: u64| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % most
    };
    let mut script = String::new();
    let mut spent = 0;
    while spent < frames {
        let mut point = || format!("{} {}", random(320), 24 + random(156));
        let (from, to) = (point(), point());
        let (line, cost) = match random(12) {
            0..4 => (format!("key {}", KEYS[random(KEYS.len() as u64) as usize]), 2),
            4 => (format!("press {}", KEYS[random(8) as usize]), 1),
            5 => (format!("release {}", KEYS[random(8) as usize]), 1),
            6..8 => (format!("click {from}"), 3),
            8 => (format!("drag {from} {to}"), 11),
            9 => (format!("drag {from} {to} right"), 11),
            10 => (format!("wheel {}", random(7) as i64 - 3), 1),
            _ => (format!("resize {} {}", 320 + random(80), 180 + random(60)), 1),
        };
        script += &line;
        script.push('\n');
        spent += cost;
    }
    script
}

#[test]
fn a_monkey_breaks_nothing() {
    let script = monkey(1, 500) + "quit\n";
    let folder = folder_with(&[("island.toml", ISLAND), ("monkey.txt", &script)]);
    let desktop = Desktop::new();
    let arguments = ["island.toml", "--size", "320x180", "--script", "monkey.txt"];
    good(&desktop.view(folder.path(), &arguments, &[]).end());
}

#[test]
#[ignore = "minutes: make test-long"]
fn a_monkey_breaks_no_forest_and_no_zoom() {
    for (seed, world) in [(3, forest().as_str()), (4, ZOOM)] {
        let script = monkey(seed, 2000) + "quit\n";
        let folder = folder_with(&[("world.toml", world), ("monkey.txt", &script)]);
        let desktop = Desktop::new();
        let arguments = ["world.toml", "--size", "320x180", "--script", "monkey.txt"];
        good(&desktop.view(folder.path(), &arguments, &[]).end());
    }
}

#[test]
#[ignore = "minutes: make test-long"]
fn a_monkey_breaks_nothing_for_long_and_takes_no_more_memory() {
    const ROUNDS: usize = 8;
    // Everything once, to its end: programs that are compiled for it are there for good.
    let island = ISLAND.replace("4096", "4");
    const ONCE: &str = "resize 960 640\nwait quiet 400\n\
        push Path tracing\npush Trace paths\nwait quiet 2000\npush Stop\nwait quiet 400\npush Path tracing\n\
        push Layers\npush none\npush slope\nwait quiet 400\npush Layers\n\
        push Brush\npush Raise\ndrag 500 300 560 300\nwait quiet 400\npush Brush\n\
        push Section\nmove 520 320\nwait quiet 400\npush Section\n\
        key ctrl+E\nwait 5\nkey Escape\nkey F2\nwait 5\nkey Escape\n";
    // Then the same over and over, and after each time the world as it was at first, of which the same must be in memory.
    let again = "resize 320 180\nopen island.toml\nwait 3\nwait quiet 400\n";
    let held = ["W", "A", "S", "D", "Space", "C", "Q", "E"].map(|key| format!("release {key}\n")).concat();
    let round = monkey(2, 1000) + &held + &"key Escape\n".repeat(3) + again;
    let rounds: String = (0..ROUNDS).map(|index| format!("{round}screenshot {index}.png\n")).collect();
    let script = format!("{ONCE}{again}{rounds}quit\n");
    let folder = folder_with(&[("island.toml", &island), ("monkey.txt", &script)]);
    let folder = folder.path();
    let desktop = Desktop::new();
    // The C library keeps what is freed, for each thread by itself, or gives it back, as it is told here: what is resident is then what
    // is held (mallopt(3)). Drivers and layers allocate by it, too.
    let gives_back =
        [("MALLOC_ARENA_MAX", "1"), ("MALLOC_MMAP_THRESHOLD_", "65536"), ("MALLOC_TRIM_THRESHOLD_", "65536")];
    let arguments = ["island.toml", "--size", "320x180", "--script", "monkey.txt"];
    let mut viewer = desktop.view(folder, &arguments, &gives_back);
    let memory: [_; ROUNDS] = std::array::from_fn(|index| {
        let name = format!("{index}.png");
        viewer.wait(&name, |viewer| folder.join(&name).exists().then(|| viewer.resident()))
    });
    good(&viewer.end());
    println!("KiB after each round: {memory:?}");
    let [early, late] = [&memory[..ROUNDS / 2], &memory[ROUNDS / 2..]].map(|half| half.iter().max().copied());
    let (early, late) = (early.unwrap_or_default(), late.unwrap_or_default());
    assert!(late as f64 <= 1.01 * early as f64, "at most {early} KiB, then {late} KiB: {memory:?}");
}
