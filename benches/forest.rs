//! `cargo bench`: the table of `terrane bench forest`, on the device that is found first.

use std::{error::Error, process::ExitCode};
use terrane::{
    bench,
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
    let forest = bench::forest(&gpu, || false, |row| eprintln!("{}: {:.2} s", row.name, row.seconds))?;
    print!("{forest}");
    Ok(())
}
