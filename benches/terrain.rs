//! `cargo bench`: the table of `terrane bench`, on the device that is found first.

mod kit;

use std::process::ExitCode;
use terrane::bench::{Bench, Options};

fn main() -> ExitCode {
    kit::print(|gpu| {
        let mut bench = Bench::new(gpu)?;
        bench.terrain(gpu, &Options::default(), || false, |row| eprintln!("{} at {}", row.name, row.size))?;
        Ok(bench)
    })
}
