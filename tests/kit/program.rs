//! The program itself, run in a folder.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// A world with every layer, made in a second.
pub const EVERY_LAYER: &str = r#"
format = 1
seed = 5
[terrain]
cells = 65
extent = 2000
layers = [{ cone = { height = 500, radius = 900 } }, { simplex = { amplitude = 60, wavelength = 500, octaves = 4 } }]
[sea]
level = 60
[erosion.hydraulic]
duration = 40
[reef]
stages = [{ duration = 200, rise = 2 }]
"#;

/// The program with these arguments, in this folder and under validation. What it keeps lies there too, in `cache`: what other runs
/// have left belongs to the user.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(arguments).current_dir(folder);
    command.env("TERRANE_VALIDATION", "1").env("TERRANE_CACHE", folder.join("cache"));
    command
}

/// Runs it to its end.
pub fn terrane(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program runs")
}

/// What it ended with; fails if it was killed.
#[track_caller]
pub fn code(output: &Output) -> i32 {
    output.status.code().expect("it was not killed")
}

/// What it had to say.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The one object on standard output.
#[track_caller]
pub fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        panic!("{error}: {}\n{}", String::from_utf8_lossy(&output.stdout), stderr(output))
    })
}

/// Fails unless it did what it was asked for.
#[track_caller]
pub fn good(output: &Output) {
    assert!(output.status.success(), "{}", stderr(output));
}

/// Fails unless it ended with `expected`, and said so.
#[track_caller]
pub fn told(output: &Output, expected: i32, part: &str) {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(expected), "{message}");
    assert!(message.contains(part), "{message}");
}
