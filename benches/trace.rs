//! `cargo bench`: the table of `terrane bench trace`, on the device that is found first.

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
    let rays =
        bench::rays(&gpu, || false, |row| eprintln!("{}: {:.2} million rays a second", row.name, row.mrays))?;
    print!("{rays}");
    Ok(())
}
