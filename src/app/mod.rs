//! The program: what was typed becomes calls of the library; progress, interruption, the report of what came of it.

mod cli;
mod denoise;
mod error;
mod growth;
mod interrupt;
mod keep;
mod land;
mod memory;
mod population;
mod progress;
mod report;
#[cfg(feature = "viewer")]
mod viewer;
mod way;

pub use error::{EXIT_CODES, Error};

use crate::gpu::MessageLog;
use crate::world::cache::Cache;
use clap::Parser;
use cli::Cli;
use progress::Progress;
use report::Report;
use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

/// Runs the program with the arguments of the process. Everything that fails is reported here, once.
pub fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(error) => return refuse(&arguments, &error),
    };
    let validation = std::env::var_os("TERRANE_VALIDATION").map(|_| MessageLog::default());
    let mut session = Session {
        report: Report::of(cli.name()),
        progress: Progress::new(cli.voice()),
        cache: None,
        validation: validation.clone(),
    };
    let mut result = cli.run(&mut session);
    let messages = validation.map(|log| log.take()).unwrap_or_default();
    if result.is_ok() && !messages.is_empty() {
        result = Err(Error::Validation(messages));
    }

    let Session { mut report, mut progress, .. } = session;
    progress.end();
    report.stages = progress.into_stages();
    let mut code = 0;
    if let Err(error) = result {
        code = error.exit_code();
        complain(&error.to_string());
        report.fail(code, &error);
    }
    if cli.json() {
        code = print(&report, code);
    }
    ExitCode::from(code)
}

/// Prints the report of a run that ends with `code`; returns what the process exits with.
fn print(report: &Report, code: u8) -> u8 {
    let Err(error) = report.print() else { return code };
    complain(&error.to_string());
    // What failed first counts.
    if code == 0 { error.exit_code() } else { code }
}

/// What a verb tells about its work while it runs.
struct Session {
    report: Report,
    progress: Progress,
    /// Where states of the land are kept; `None` if that was not asked for, or can't be.
    cache: Option<Cache>,
    /// Messages of the Vulkan validation layer, which the environment variable `TERRANE_VALIDATION` switches on. Any
    /// message fails the run: tests use it.
    validation: Option<MessageLog>,
}

impl Session {
    /// Says what is not as it should be, and goes on.
    fn warn(&mut self, warning: String) {
        self.progress.say(&format!("warning: {warning}"));
        self.report.warnings.push(warning);
    }
}

/// Arguments that make no sense, or a call for help.
fn refuse(arguments: &[OsString], error: &clap::Error) -> ExitCode {
    // Nobody may be reading.
    let _ = error.print();
    let mut code = u8::try_from(error.exit_code()).unwrap_or(2);
    if code != 0 && arguments.iter().any(|argument| argument == "--json") {
        let verb = arguments.get(1).map(|verb| verb.to_string_lossy().into_owned()).unwrap_or_default();
        let mut report = Report::of(&verb);
        report.fail(code, &error.render());
        code = print(&report, code);
    }
    ExitCode::from(code)
}

fn complain(message: &str) {
    let _ = writeln!(io::stderr().lock(), "error: {message}");
}
