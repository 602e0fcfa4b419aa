//! `cargo bench`: the table of `terrane bench forest`, on the device that is found first.

mod kit;

use std::process::ExitCode;
use terrane::bench;

fn main() -> ExitCode {
    kit::print(|gpu| Ok(bench::forest(gpu, || false, |row| eprintln!("{}: {:.2} s", row.name, row.seconds))?))
}
