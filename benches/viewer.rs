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
    for (what, cells) in [("256² cells", 256), ("512² cells", 512), ("1024² cells", 1024)] {
        let mut waits = input(&desktop, folder, cells);
        waits.sort_by(f64::total_cmp);
        let at = |share: f64| waits[((share * waits.len() as f64) as usize).min(waits.len() - 1)];
        println!("| {what} | {:.0} ms | {:.0} ms | {:.0} ms |", at(0.5), at(0.95), at(1.0));
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

/// From pressing a key to when the screen shows what it does, milliseconds: the menu comes and goes.
fn input(desktop: &Desktop, folder: &Path, cells: u32) -> Vec<f64> {
    let mut viewer = open(desktop, folder, cells);
    viewer.see("Pause");
    sleep(Duration::from_secs(5));
    let [x, y] = viewer.origin();
    let strip = || desktop.row([x + 400, y + 4], 200);
    let menu = strip();
    let waits = (0..PRESSES).map(|press| {
        let begun = Instant::now();
        viewer.key("F1");
        let shown = press % 2 == 1;
        while (strip() == menu) != shown {
            assert!(begun.elapsed() < Duration::from_secs(10), "the menu does not come and go");
            sleep(Duration::from_millis(1));
        }
        let wait = 1e3 * begun.elapsed().as_secs_f64();
        sleep(Duration::from_millis(200 + 37 * (press as u64 % 7)));
        wait
    });
    let waits = waits.collect();
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
