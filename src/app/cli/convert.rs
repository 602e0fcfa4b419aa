//! `terrane convert`: a folder of settings as a world file.

use super::options::{OutputOptions, WorldOptions};
use super::output::check_extension;
use crate::app::{Error, Session, land};
use crate::formats::file;
use clap::{Args, ValueHint};
use std::io::Write;
use std::path::PathBuf;

/// Write a folder of settings as a world file
///
/// Folders of settings are those of Rudzki 2020, "Realistic rendering of procedural generated forest landscapes"; every
/// verb takes them in place of a world file, and the file that is written is the same world.
#[derive(Args)]
pub struct Arguments {
    /// World file to write
    #[arg(short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: PathBuf,

    #[command(flatten)]
    world: WorldOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    check_extension(&arguments.out, &["toml"])?;
    let path = &arguments.world.world;
    if path.is_file() {
        let message = format!("{} is a file; `convert` takes a folder of settings", path.display());
        return Err(Error::Usage(message));
    }
    let world = land::load(&arguments.world, session)?;
    let text = world.document.to_string();
    let written = file::write(&arguments.out, |out| out.write_all(text.as_bytes()))?;
    session.progress.say(&format!("wrote {}", arguments.out.display()));
    session.report.wrote(&written);
    Ok(())
}
