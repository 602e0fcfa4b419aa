//! The command line: `terrane VERB WORLD [-o OUT] …`, one file a verb.

mod bench;
mod cache;
mod check;
mod compare;
mod completions;
mod convert;
mod devices;
mod export;
mod man;
mod merge;
pub mod options;
pub mod output;
mod plant;
mod render;
mod schema;

use super::progress::Voice;
#[cfg(feature = "viewer")]
use super::viewer;
use super::{EXIT_CODES, Error, Session};
use clap::{Parser, Subcommand};
use options::OutputOptions;

/// Whole landscapes from one text file, made and shown with Vulkan
///
/// A world file describes land, sea, light and a camera; `terrane render` makes a picture of it, `terrane export` files
/// for other programs.
#[derive(Parser)]
#[command(name = "terrane", version, max_term_width = 100, after_help = after_help())]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    Render(render::Arguments),
    #[cfg(feature = "viewer")]
    View(viewer::Arguments),
    Export(export::Arguments),
    Merge(merge::Arguments),
    Plant(plant::Arguments),
    Check(check::Arguments),
    Compare(compare::Arguments),
    Convert(convert::Arguments),
    Devices(devices::Arguments),
    Bench(bench::Arguments),
    Cache(cache::Arguments),
    Schema(schema::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
}

impl Cli {
    pub fn run(&self, session: &mut Session) -> Result<(), Error> {
        match &self.verb {
            Verb::Render(arguments) => render::run(arguments, session),
            #[cfg(feature = "viewer")]
            Verb::View(arguments) => viewer::run(arguments, session),
            Verb::Export(arguments) => export::run(arguments, session),
            Verb::Merge(arguments) => merge::run(arguments, session),
            Verb::Plant(arguments) => plant::run(arguments, session),
            Verb::Check(arguments) => check::run(arguments, session),
            Verb::Compare(arguments) => compare::run(arguments, session),
            Verb::Convert(arguments) => convert::run(arguments, session),
            Verb::Devices(arguments) => devices::run(arguments, session),
            Verb::Bench(arguments) => bench::run(arguments, session),
            Verb::Cache(arguments) => cache::run(arguments, session),
            Verb::Schema(arguments) => schema::run(arguments, session),
            Verb::Completions(arguments) => completions::run(arguments),
            Verb::Man(arguments) => man::run(arguments, session),
        }
    }

    /// Name of the verb.
    pub fn name(&self) -> &'static str {
        match self.verb {
            Verb::Render(_) => "render",
            #[cfg(feature = "viewer")]
            Verb::View(_) => "view",
            Verb::Export(_) => "export",
            Verb::Merge(_) => "merge",
            Verb::Plant(_) => "plant",
            Verb::Check(_) => "check",
            Verb::Compare(_) => "compare",
            Verb::Convert(_) => "convert",
            Verb::Devices(_) => "devices",
            Verb::Bench(_) => "bench",
            Verb::Cache(_) => "cache",
            Verb::Schema(_) => "schema",
            Verb::Completions(_) => "completions",
            Verb::Man(_) => "man",
        }
    }

    pub fn json(&self) -> bool {
        self.output().is_some_and(|output| output.json)
    }

    pub fn voice(&self) -> Voice {
        if self.output().is_some_and(|output| output.quiet) { Voice::Quiet } else { Voice::Normal }
    }

    /// Those that print what was asked for have none.
    fn output(&self) -> Option<&OutputOptions> {
        match &self.verb {
            Verb::Render(arguments) => Some(&arguments.output),
            #[cfg(feature = "viewer")]
            Verb::View(arguments) => Some(&arguments.output),
            Verb::Export(arguments) => Some(&arguments.output),
            Verb::Merge(arguments) => Some(&arguments.output),
            Verb::Plant(arguments) => Some(&arguments.output),
            Verb::Check(arguments) => Some(&arguments.output),
            Verb::Compare(arguments) => Some(&arguments.output),
            Verb::Convert(arguments) => Some(&arguments.output),
            Verb::Devices(arguments) => Some(&arguments.output),
            Verb::Bench(arguments) => Some(&arguments.output),
            Verb::Cache(arguments) => Some(&arguments.output),
            Verb::Schema(_) | Verb::Completions(_) | Verb::Man(_) => None,
        }
    }
}

/// The options of `terrane export`, of which the viewer makes a form.
#[cfg(feature = "viewer")]
pub fn export_command() -> clap::Command {
    use clap::Args;
    export::Arguments::augment_args(clap::Command::new("export"))
}

fn after_help() -> String {
    let codes: Vec<String> =
        EXIT_CODES.iter().map(|(code, meaning)| format!("  {code:<3}  {meaning}")).collect();
    format!(
        "Examples:\n  terrane render island.toml -o island.png\n  \
         terrane render island.toml --set terrain.cells=256 --set erosion.hydraulic.rain=200\n  \
         terrane render island.toml --renderer trace --spp 256 -o island.exr --resume\n  \
         terrane render island.toml --frames 0..240 -o frames/%05d.png\n  \
         terrane render zoom.toml --frames 0..900 --fps 30 -o frames/%05d.png\n  \
         terrane export island.toml --layer all -o island/\n  \
         terrane export island.toml --preset unreal -o unreal/\n  \
         terrane plant oak.toml -o oak.png\n  \
         terrane check island.toml\n\nExit codes:\n{}",
        codes.join("\n")
    )
}
