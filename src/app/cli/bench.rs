//! `terrane bench`: how fast this machine makes land.

use super::options::{DeviceOptions, OutputOptions};
use crate::app::report::Details;
use crate::app::{Error, Session, land};
use crate::bench;
use clap::{Args, ValueEnum, value_parser};
use std::io::{self, Write};
use std::time::Duration;

/// Measure how fast this machine makes land, beside the same steps in plain Rust
#[derive(Args)]
pub struct Arguments {
    /// What to measure
    #[arg(value_enum, default_value = "terrain")]
    subject: Subject,

    /// Samples along a side; may be a list
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = bench::Options::default().cells)]
    #[arg(value_parser = value_parser!(u32).range(32..=4096))]
    cells: Vec<u32>,

    /// Seconds for each row of the table
    #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = seconds)]
    time: Duration,

    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Base terrain, erosion, reef
    Terrain,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let gpu = land::open(&arguments.device, session)?;
    let options = bench::Options { cells: arguments.cells.clone(), time: arguments.time };
    let bench = match arguments.subject {
        Subject::Terrain => bench::terrain(&gpu, &options, |row| {
            let bench::Row { name, size, ns_per_cell, .. } = row;
            session.progress.say(&format!("{name}: {ns_per_cell:.2} ns a cell at {size} × {size}"));
        })?,
    };
    if !arguments.output.json {
        // Nobody may be reading.
        let _ = write!(io::stdout().lock(), "{bench}");
    }
    session.report.details = Some(Details::Bench(bench));
    Ok(())
}

/// Reads a time, up to a minute.
fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.001..=60.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("it must be a number of seconds between 0.001 and 60".into()),
    }
}
