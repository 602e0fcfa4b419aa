//! Ctrl-C and SIGTERM: the first asks the run to end between two steps, the second ends the process at once.

use super::{Error, report::Report};
use crate::formats::file;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Starts to listen. Where signals can't be caught they keep their usual effect.
pub fn listen() {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            file::remove_unfinished();
            std::process::exit(130);
        }
    });
}

/// Whether an interruption has been asked for.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// Fails once an interruption has been asked for; called between steps.
pub fn check(report: &Report) -> Result<(), Error> {
    if requested() { Err(Error::Interrupted { written: report.written(), kept: None }) } else { Ok(()) }
}
