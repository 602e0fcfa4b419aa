//! Ctrl-C and SIGTERM: the first asks the run to end between two steps, one behind it ends the process at once.

use super::{Error, report::Report};
use crate::formats::file;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// When the first signal came.
static REQUESTED: OnceLock<Instant> = OnceLock::new();
/// What follows sooner is the same request: `timeout` signals the process and then the whole group it is in.
const SAME: Duration = Duration::from_secs(1);

/// Starts to listen. Where signals can't be caught they keep their usual effect.
pub fn listen() {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.get_or_init(Instant::now).elapsed() > SAME {
            file::remove_unfinished();
            std::process::exit(130);
        }
    });
}

/// Whether an interruption has been asked for.
pub fn requested() -> bool {
    REQUESTED.get().is_some()
}

/// Fails once an interruption has been asked for; called between steps.
pub fn check(report: &Report) -> Result<(), Error> {
    if requested() { Err(Error::Interrupted { written: report.written(), kept: None }) } else { Ok(()) }
}
