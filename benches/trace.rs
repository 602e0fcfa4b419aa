//! `cargo bench`: the table of `terrane bench trace`, on the device that is found first.

mod kit;

use std::process::ExitCode;
use terrane::bench;

fn main() -> ExitCode {
    kit::print(|gpu| {
        Ok(bench::rays(
            gpu,
            || false,
            |row| eprintln!("{}: {:.2} million rays a second", row.name, row.mrays),
        )?)
    })
}
