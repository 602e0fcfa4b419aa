//! `cargo bench`: the table of `terrane bench`, on the device that is found first.

use std::{error::Error, process::ExitCode};
use terrane::{
    bench::{Bench, Options},
    gpu::{self, Gpu},
};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::new(&gpu::Options::default())?;
    let mut bench = Bench::new(&gpu)?;
    bench.terrain(&gpu, &Options::default(), || false, |row| eprintln!("{} at {}", row.name, row.size))?;
    print!("{bench}");
    Ok(())
}
