//! `terrane man`: the manual, a page for the program and one a verb.

use super::Cli;
use super::output::{Place, print};
use crate::app::{EXIT_CODES, Error, Session};
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
    let Some(folder) = &arguments.out else {
        // Writing to memory can't fail.
        return print(&main_page(&program).unwrap_or_default());
    };

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
    let man = man(program.clone());
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    synopsis(program, &mut page)?;
    man.render_description_section(&mut page)?;
    man.render_subcommands_section(&mut page)?;
    man.render_options_section(&mut page)?;
    writeln!(page, ".SH \"EXIT STATUS\"")?;
    for (code, meaning) in EXIT_CODES {
        writeln!(page, ".TP\n\\fB{code}\\fR\n{meaning}")?;
    }
    page.write_all(SECTIONS.as_bytes())?;
    Ok(page)
}

fn verb_page(verb: &Command, name: &str) -> io::Result<Vec<u8>> {
    let verb = verb.clone().display_name(name);
    let man = man(verb.clone());
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    synopsis(&verb, &mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    page.write_all(b".SH \"SEE ALSO\"\n\\fBterrane\\fR(1)\n")?;
    Ok(page)
}

fn man(command: Command) -> Man {
    Man::new(command).manual("terrane").source(concat!("terrane ", env!("CARGO_PKG_VERSION")))
}

/// As `--help` has it; the crate's own leaves the values of short options out.
fn synopsis(command: &Command, page: &mut Vec<u8>) -> io::Result<()> {
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage:").trim().replace('\\', "\\e").replace('-', "\\-");
    writeln!(page, ".SH SYNOPSIS\n{usage}")
}

/// What the arguments don't tell.
const SECTIONS: &str = r#".SH ENVIRONMENT
.TP
\fBTERRANE_CACHE\fR
Folder for what runs keep for later ones, in place of the user's cache folder.
.TP
\fBTERRANE_CACHE_LIMIT\fR
Most that is kept, for example 20GiB. 8GiB if it is not set.
.TP
\fBTERRANE_PROGRESS\fR
Seconds between two lines of progress where there is no terminal. 10 if it is not set.
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
.TP
\fI~/.cache/terrane/land/\fR
Land of earlier runs: another camera need not wait for it. \fBterrane cache\fR shows and clears it.
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
Its heights as Unreal Engine imports them:
\fBterrane export volcano.toml \-\-preset unreal \-o unreal/\fR
.TP
What it takes, before it is made:
\fBterrane check volcano.toml\fR
"#;
