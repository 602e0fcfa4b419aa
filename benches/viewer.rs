//! `cargo bench --bench viewer`: how long input waits until it is seen while an island changes at full speed, and what an idle window costs. On a desktop
//! that nobody sees (Xvfb, openbox, xdotool), whose screen is read.

#[path = "../tests/kit/desktop.rs"]
#[allow(dead_code)]
mod desktop;
#[path = "../tests/kit/program.rs"]
#[allow(dead_code)]
mod program;

use desktop::{Desktop, Viewer};
use std::fs;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The size of the window's inside, pixels.
const SIZE: &str = "960x540";

/// Times that a key is pressed.
const PRESSES: usize = 100;

/// How long an idle window is watched.
const IDLE: Duration = Duration::from_secs(20);

/// An island that never ends.
const ISLAND: &str = "format = 1\n[erosion.hydraulic]\nduration = 1000000\n";

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let desktop = Desktop::new();
    fs::write(folder.join("island.toml"), ISLAND).expect("it can be written");
    println!("| | median | 95 % | longest |\n|---|--:|--:|--:|");
    for cells in [256, 512, 1024] {
        for (what, mut waits) in [
            ("a key, until the next frame", input(&desktop, folder, cells)),
            ("a look elsewhere, until it is seen", look(&desktop, folder, cells)),
        ] {
            waits.sort_by(f64::total_cmp);
            let at = |share: f64| waits[((share * waits.len() as f64) as usize).min(waits.len() - 1)];
            println!("| {cells}²: {what} | {:.0} ms | {:.0} ms | {:.0} ms |", at(0.5), at(0.95), at(1.0));
        }
    }
    println!("\nidle: {:.2} % of a core", 100.0 * idle(&desktop, folder));
}

fn open<'a>(desktop: &'a Desktop, folder: &Path, cells: u32) -> Viewer<'a> {
    let cells = format!("terrain.cells={cells}");
    let mut command = program::command(folder, &["view", "island.toml", "--size", SIZE, "--set", &cells]);
    // It costs time.
    command.env_remove("TERRANE_VALIDATION");
    desktop.start(folder, command)
}

/// From each of two acts, which take turns, to when the screen shows what it does, milliseconds. Both are asked whether it is the first of them.
fn waits(act: impl Fn(bool), is_seen: impl Fn(bool) -> bool) -> Vec<f64> {
    let wait = |press: usize| {
        let first = press.is_multiple_of(2);
        let begun = Instant::now();
        act(first);
        while !is_seen(first) {
            assert!(begun.elapsed() < Duration::from_secs(10), "nothing else is seen");
            sleep(Duration::from_millis(1));
        }
        let wait = 1e3 * begun.elapsed().as_secs_f64();
        sleep(Duration::from_millis(200 + 37 * (press as u64 % 7)));
        wait
    };
    (0..PRESSES).map(wait).collect()
}

/// From pressing a key to when the screen shows what it does, milliseconds: the menu comes and goes.
fn input(desktop: &Desktop, folder: &Path, cells: u32) -> Vec<f64> {
    let mut viewer = open(desktop, folder, cells);
    viewer.see("Pause");
    sleep(Duration::from_secs(5));
    let [x, y] = viewer.origin();
    let strip = || desktop.row([x + 400, y + 4], 200);
    let menu = strip();
    let waits = waits(|_| viewer.key("F1"), |first| (strip() == menu) != first);
    viewer.key("ctrl+q");
    program::good(&viewer.end());
    waits
}

/// From moving the mouse, whose right button is held, to when the picture shows what lies there, milliseconds: sky and land take turns.
fn look(desktop: &Desktop, folder: &Path, cells: u32) -> Vec<f64> {
    let mut viewer = open(desktop, folder, cells);
    viewer.see("Pause");
    sleep(Duration::from_secs(5));
    let [x, y] = viewer.origin();
    let colour = || {
        let pixels = desktop.row([x + 500, y + 300], 60);
        [0, 1, 2].map(|channel| pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / 60.0)
    };
    let distance = |one: [f64; 3], other: [f64; 3]| {
        one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum::<f64>()
    };
    let turn = |up: bool| viewer.point([530, if up { 150 } else { 400 }]);
    viewer.take([530, 400], "3");
    let [sky, land] = [true, false].map(|up| {
        turn(up);
        sleep(Duration::from_secs(2));
        colour()
    });
    assert!(distance(sky, land) > 1000.0, "sky {sky:?} and land {land:?} look alike");
    let is_sky = || {
        let now = colour();
        distance(now, sky) < distance(now, land)
    };
    let waits = waits(turn, |up| is_sky() == up);
    viewer.key("ctrl+q");
    program::good(&viewer.end());
    waits
}

/// The share of a core that a window costs in which nothing happens.
fn idle(desktop: &Desktop, folder: &Path) -> f64 {
    let mut viewer = open(desktop, folder, 64);
    viewer.push("Pause");
    viewer.see("Play");
    sleep(Duration::from_secs(20));
    let before = viewer.spent();
    sleep(IDLE);
    let spent = viewer.spent() - before;
    viewer.key("ctrl+q");
    program::good(&viewer.end());
    spent.as_secs_f64() / IDLE.as_secs_f64()
}
