//! What every bench of a device begins and ends with.

use std::{error::Error, fmt::Display, process::ExitCode};
use terrane::gpu::{self, Gpu};

/// Prints the table that is measured on the device that is found first.
pub fn print<T: Display>(measure: impl FnOnce(&Gpu) -> Result<T, Box<dyn Error>>) -> ExitCode {
    let table = Gpu::new(&gpu::Options::default()).map_err(Into::into).and_then(|gpu| measure(&gpu));
    match table {
        Ok(table) => {
            print!("{table}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
