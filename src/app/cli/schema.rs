//! `terrane schema`: what a world file may hold, for editors.

use super::output::print;
use crate::app::{Error, Session};
use crate::formats::file;
use crate::world;
use clap::{Args, ValueHint};
use std::io::Write;
use std::path::PathBuf;

/// Print the JSON schema of world files, with which editors complete and check them
///
/// Editors with Taplo (Even Better TOML in Visual Studio Code) find it by a world's first line:
///
/// #:schema ./worlds.schema.json
#[derive(Args)]
pub struct Arguments {
    /// File to write [default: standard output]
    #[arg(short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let text = format!("{:#}\n", world::json_schema());
    let Some(path) = &arguments.out else { return print(text.as_bytes()) };
    let written = file::write(path, |out| out.write_all(text.as_bytes()))?;
    session.report.wrote(&written);
    Ok(())
}
