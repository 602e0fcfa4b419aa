//! The command line: `terrane VERB WORLD [-o OUT] …`, one file a verb.

mod bench;
mod check;
mod devices;
mod export;
pub mod options;
mod output;
mod render;

use super::progress::Voice;
use super::{Error, Session};
use clap::{Parser, Subcommand};
use options::OutputOptions;

/// Whole landscapes from one text file, made and shown with Vulkan.
#[derive(Parser)]
#[command(name = "terrane", version, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 ok · 1 other · 2 usage · 3 something in the world file or an option is wrong · \
    4 no such device or no driver · 5 device lost · 6 memory · 7 a file can't be read or written · 130 interrupted"
)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Render(render::Arguments),
    Export(export::Arguments),
    Check(check::Arguments),
    Devices(devices::Arguments),
    Bench(bench::Arguments),
}

impl Cli {
    pub fn run(&self, session: &mut Session) -> Result<(), Error> {
        match &self.verb {
            Verb::Render(arguments) => render::run(arguments, session),
            Verb::Export(arguments) => export::run(arguments, session),
            Verb::Check(arguments) => check::run(arguments, session),
            Verb::Devices(arguments) => devices::run(arguments, session),
            Verb::Bench(arguments) => bench::run(arguments, session),
        }
    }

    /// Name of the verb.
    pub fn name(&self) -> &'static str {
        match self.verb {
            Verb::Render(_) => "render",
            Verb::Export(_) => "export",
            Verb::Check(_) => "check",
            Verb::Devices(_) => "devices",
            Verb::Bench(_) => "bench",
        }
    }

    pub fn json(&self) -> bool {
        self.output().json
    }

    pub fn voice(&self) -> Voice {
        if self.output().quiet { Voice::Quiet } else { Voice::Normal }
    }

    fn output(&self) -> &OutputOptions {
        match &self.verb {
            Verb::Render(arguments) => &arguments.output,
            Verb::Export(arguments) => &arguments.output,
            Verb::Check(arguments) => &arguments.output,
            Verb::Devices(arguments) => &arguments.output,
            Verb::Bench(arguments) => &arguments.output,
        }
    }
}
