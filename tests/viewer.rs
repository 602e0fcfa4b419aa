//! The viewer in a real window, with real keys and a real mouse. Every run is under validation: a message fails it.

#![cfg(feature = "viewer")]

mod kit;

use kit::desktop::Desktop;
use kit::program::{good, json, stderr};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// A small island that is done in seconds.
const ISLAND: &str = "# A comment that stays.\nformat = 1\n\n[terrain]\ncells = 64 # few\n\n\
    [erosion.hydraulic]\nduration = 40\n\n[erosion.thermal]\nrepose = 35\n\n[render]\nspp = 4096\n";

const ZOOM: &str = "format = 1\n\n[zoom]\ntile = 4\ndepth = 3\n";

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
    let folder = folder_with(&[("island.toml", ISLAND), ("other.toml", ISLAND)]);
    let folder = folder.path();
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder, &["island.toml", "--size", "960x540"], &[]);
    viewer.see("Simulation");

    // Another seed, typed into its field.
    viewer.push("find a key");
    viewer.type_in("seed");
    viewer.see("seed");
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
    assert!(saved.contains("look_at") && saved.contains("# A comment that stays.") && saved.contains("64 # few"), "{saved}");

    // Taken back, and done again.
    viewer.key("ctrl+z");
    viewer.see("not saved");
    viewer.key("ctrl+s");
    viewer.see_no("not saved");
    assert_eq!(text(folder, "island.toml"), ISLAND);
    viewer.key("ctrl+y");
    viewer.see("not saved");
    viewer.key("ctrl+z");
    viewer.see_no("not saved");

    for step in 0..100 {
        viewer.resize([640 + 7 * (step % 50), 360 + 5 * (step % 40)]);
    }
    viewer.resize([960, 540]);
    viewer.minimise();
    std::thread::sleep(Duration::from_millis(300));
    viewer.restore();
    viewer.key("F1");
    viewer.see_no("Simulation");
    viewer.key("F1");
    viewer.see("Simulation");
    viewer.key("F11");
    viewer.key("F11");

    viewer.key("ctrl+q");
    let output = viewer.end();
    good(&output);
}

#[test]
fn a_zoom_is_flown_in_and_out() {
    let folder = folder_with(&[("zoom.toml", ZOOM)]);
    let desktop = Desktop::new();
    let mut viewer = desktop.view(folder.path(), &["zoom.toml", "--size", "480x270"], &[]);
    viewer.see("Flight");
    viewer.see("depth 4");
    viewer.key("b");
    viewer.see("depth 2");
    viewer.hold("w", Duration::from_millis(300));
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
    let failures = "acquire:3:out_of_date,acquire:6:surface_lost,present:4:out_of_date,present:9:surface_lost";
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
        let mut viewer =
            desktop.view(folder.path(), &["island.toml", "--size", "960x540"], &[("TERRANE_LOSE_WINDOW", &failure)]);
        viewer.push("Put this view into the world");
        viewer.see("not saved");
        // Frames, until it happens.
        viewer.key("F1");
        viewer.hold("d", Duration::from_secs(5));
        let output = viewer.end();
        assert_eq!(output.status.code(), Some(5), "{}", stderr(&output));
        let kept = fs::read_dir(folder.path().join("state/recovery")).expect("it is kept");
        assert!(kept.flatten().any(|file| file.path().extension().is_some_and(|ending| ending == "json")));
        fs::remove_dir_all(folder.path().join("state")).expect("it is there");
    }
}
