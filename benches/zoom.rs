//! `cargo bench`: the tables of `terrane bench zoom`, on the device that is found first.

mod kit;

use std::process::ExitCode;
use terrane::bench;

fn main() -> ExitCode {
    kit::print(|gpu| {
        Ok(bench::zoom(
            gpu,
            || false,
            |row| eprintln!("from depth {}: {:.1} ms a frame", row.depth, row.wall.median),
        )?)
    })
}
