//! What `--json` prints: one object about the run, whether it went well or not.

use super::{Error, cli::output};
use crate::bench::{Bench, Forest, Picture, Rays, Zoom};
use crate::formats::file::Written;
use serde::Serialize;
use std::fmt::Display;

#[derive(Serialize)]
pub struct Report {
    version: &'static str,
    command: String,
    /// Path of the world file, as it was given.
    pub world: Option<String>,
    pub seed: Option<u32>,
    /// Name of the device.
    pub device: Option<String>,
    pub stages: Vec<Stage>,
    outputs: Vec<Output>,
    frames: Vec<Frame>,
    /// What a later run can go on from, with --resume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoint: Option<String>,
    pub warnings: Vec<String>,
    /// What only this verb has to say, under its own name.
    #[serde(flatten)]
    pub details: Option<Details>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<Failure>,
}

/// A part of the run.
#[derive(Serialize)]
pub struct Stage {
    pub name: &'static str,
    pub seconds: f64,
    /// Done in this run.
    pub iterations: u64,
    /// Done in earlier runs, and taken from the cache.
    pub cached: u64,
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Details {
    Plan(serde_json::Value),
    Devices(serde_json::Value),
    Cache(serde_json::Value),
    Plant(serde_json::Value),
    Comparison(serde_json::Value),
    #[cfg(feature = "viewer")]
    View(Viewed),
    /// `rows` and what they were measured on.
    #[serde(untagged)]
    Bench(Bench),
    #[serde(untagged)]
    Forest(Forest),
    #[serde(untagged)]
    Rays(Rays),
    #[serde(untagged)]
    Picture(Picture),
    #[serde(untagged)]
    Zoom(Zoom),
}

#[derive(Serialize)]
struct Output {
    path: String,
    bytes: u64,
    sha256: String,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    flown: Option<Flown>,
}

/// A picture of a film.
#[derive(Serialize)]
struct Frame {
    number: u32,
    /// Whether it had been finished by an earlier run.
    found: bool,
    #[serde(flatten)]
    output: Output,
}

/// Where a picture of a zoom was taken, and what it took.
#[derive(Serialize)]
pub struct Flown {
    /// −log₂ of the distance to the surface in cells of level 0.
    pub depth: f64,
    /// The same, so that it can be told at any depth: in `cells` of this level.
    pub level: u32,
    pub cells: f64,
    /// Its code; of two eyes, of what is between them.
    pub location: String,
    pub tiles_drawn: usize,
    /// Those that the device did not have.
    pub tiles_made: usize,
    /// On the processor, without waiting for the device.
    pub cpu_ms: f64,
    pub gpu_ms: f64,
    /// What the device keeps from one picture to the next.
    pub gpu_bytes: u64,
}

/// What a window has shown.
#[cfg(feature = "viewer")]
#[derive(Serialize)]
pub struct Viewed {
    pub frames: u64,
    /// Frames that showed what input did, and how long it had waited for them, milliseconds.
    pub inputs: usize,
    pub input_median_ms: f32,
    pub input_95_ms: f32,
    pub input_longest_ms: f32,
}

#[derive(Serialize)]
struct Failure {
    exit_code: u8,
    message: String,
}

impl Output {
    fn of(file: &Written) -> Self {
        let path = file.path.to_string_lossy().into_owned();
        Output { path, bytes: file.bytes, sha256: file.sha256.clone(), flown: None }
    }
}

impl Report {
    pub fn of(command: &str) -> Self {
        Report {
            version: env!("CARGO_PKG_VERSION"),
            command: command.into(),
            world: None,
            seed: None,
            device: None,
            stages: Vec::new(),
            outputs: Vec::new(),
            frames: Vec::new(),
            checkpoint: None,
            warnings: Vec::new(),
            details: None,
            error: None,
        }
    }

    pub fn wrote(&mut self, file: &Written) {
        self.outputs.push(Output::of(file));
    }

    /// A frame is there, made now or `found`.
    pub fn frame(&mut self, number: u32, file: &Written, found: bool) {
        self.frames.push(Frame { number, found, output: Output::of(file) });
    }

    /// A picture of a zoom is there, or a frame.
    pub fn flown(&mut self, frame: Option<u32>, file: &Written, flown: Flown) {
        let output = Output { flown: Some(flown), ..Output::of(file) };
        match frame {
            Some(number) => self.frames.push(Frame { number, found: false, output }),
            None => self.outputs.push(output),
        }
    }

    /// How many files were written.
    pub fn written(&self) -> usize {
        self.outputs.len() + self.frames.iter().filter(|frame| !frame.found).count()
    }

    pub fn fail(&mut self, exit_code: u8, error: &dyn Display) {
        self.error = Some(Failure { exit_code, message: error.to_string() });
    }

    /// Prints the object on standard output.
    pub fn print(&self) -> Result<(), Error> {
        // Nothing in it can fail to be written as JSON.
        let object = serde_json::to_string_pretty(self).unwrap_or_default();
        output::print(format!("{object}\n").as_bytes())
    }
}
