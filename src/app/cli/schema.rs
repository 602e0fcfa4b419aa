//! `terrane schema`: what a world file or a species file may hold, for editors.

use super::output::print;
use crate::app::{Error, Session};
use crate::formats::file;
use crate::world;
use clap::{Args, ValueHint};
use std::io::Write;
use std::path::PathBuf;

/// Print the JSON schema of world files or species files, with which editors complete and check them
///
/// Editors with Taplo (Even Better TOML in Visual Studio Code) find it by a file's first line:
///
/// #:schema ./worlds.schema.json
#[derive(Args)]
pub struct Arguments {
    /// The schema of species files, which say how a kind of plant grows
    #[arg(long)]
    species: bool,

    /// File to write [default: standard output]
    #[arg(short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let schema = if arguments.species { world::json_schema_of_species() } else { world::json_schema() };
    let text = format!("{schema:#}\n");
    let Some(path) = &arguments.out else { return print(text.as_bytes()) };
    let written = file::write(path, |out| out.write_all(text.as_bytes()))?;
    session.report.wrote(&written);
    Ok(())
}
