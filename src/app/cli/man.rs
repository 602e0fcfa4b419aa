//! `terrane man`: the manual, a page for the program and one a verb.

use super::Cli;
use super::output::{Place, print};
use crate::app::{Error, Session};
use crate::formats::file;
use clap::{Args, Command, CommandFactory, ValueHint};
use clap_mangen::Man;
use std::io::{self, Write};
use std::path::PathBuf;

/// Print the manual page, or write a page for every verb into a folder
///
/// Read it with `terrane man | man -l -`.
#[derive(Args)]
pub struct Arguments {
    /// Folder for the pages: terrane.1, terrane-render.1, … [default: the first page on standard output]
    #[arg(short, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    let Some(folder) = &arguments.out else { return print(&main_page(&program).unwrap_or_default()) };

    let mut pages = vec![("terrane.1".to_string(), main_page(&program))];
    for verb in program.get_subcommands() {
        let name = format!("terrane-{}", verb.get_name());
        let page = verb_page(verb, &name);
        pages.push((format!("{name}.1"), page));
    }
    let place = Place::Folder(folder.clone());
    place.make()?;
    for (name, page) in pages {
        let written = file::write(&place.file(&name), |out| out.write_all(&page?))?;
        session.report.wrote(&written);
    }
    Ok(())
}

fn main_page(program: &Command) -> io::Result<Vec<u8>> {
    let man = Man::new(program.clone()).manual("terrane");
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_subcommands_section(&mut page)?;
    man.render_options_section(&mut page)?;
    page.write_all(SECTIONS.as_bytes())?;
    Ok(page)
}

fn verb_page(verb: &Command, name: &str) -> io::Result<Vec<u8>> {
    let verb = verb.clone().bin_name(name.replacen('-', " ", 1)).display_name(name);
    let mut page = Vec::new();
    Man::new(verb).manual("terrane").render(&mut page)?;
    page.write_all(b".SH \"SEE ALSO\"\n\\fBterrane\\fR(1)\n")?;
    Ok(page)
}

/// What the arguments don't tell.
const SECTIONS: &str = r#".SH "EXIT STATUS"
.TP
\fB0\fR
All went well.
.TP
\fB1\fR
Something else failed.
.TP
\fB2\fR
The arguments make no sense.
.TP
\fB3\fR
Something is wrong in the world file or an option, or the world has not what was asked for.
.TP
\fB4\fR
There is no such device, or no driver.
.TP
\fB5\fR
The device was lost.
.TP
\fB6\fR
There is not enough memory.
.TP
\fB7\fR
A file can't be read or written.
.TP
\fB130\fR
The run was interrupted. Files that had been written are whole.
.SH ENVIRONMENT
.TP
\fBTERRANE_VALIDATION\fR
If set, the Vulkan validation layer watches the run, and any message of it is a failure.
.SH FILES
.TP
\fIWORLD\fR.toml
A world. \fBterrane schema\fR prints what may stand in it.
.TP
\fIOUT\fR.json
Beside every layer that is written: its range, unit, extent and world.
.SH EXAMPLES
.TP
A picture of a world, twice the size that it asks for:
\fBterrane render volcano.toml \-\-size 2560x1440 \-o volcano.png\fR
.TP
Another island, with more rain:
\fBterrane render volcano.toml \-\-seed 7 \-\-set erosion.hydraulic.rain=200\fR
.TP
All of its layers as files of floats:
\fBterrane export volcano.toml \-\-layer all \-o volcano/\fR
.TP
What it takes, before it is made:
\fBterrane check volcano.toml\fR
"#;
