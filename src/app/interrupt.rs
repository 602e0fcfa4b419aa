//! Ctrl-C and SIGTERM: the first asks the run to end between two steps, one behind it ends the process at once. SIGHUP asks it to
//! write what it has and to go on.

use super::{Error, report::Report};
use crate::formats::file;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// When the first signal to end came.
static REQUESTED: OnceLock<Instant> = OnceLock::new();
/// Whether a signal to write has come.
static WRITING: AtomicBool = AtomicBool::new(false);
/// What follows sooner is the same request: `timeout` signals the process and then the whole group it is in.
const SAME: Duration = Duration::from_secs(1);

/// Starts to listen. Where signals can't be caught they keep their usual effect.
#[cfg(unix)]
pub fn listen() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    static LISTENING: AtomicBool = AtomicBool::new(false);
    if LISTENING.swap(true, Ordering::Relaxed) {
        return;
    }
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            match signal {
                SIGHUP => WRITING.store(true, Ordering::Relaxed),
                _ => end(),
            }
        }
    });
}

/// Starts to listen. Where signals can't be caught they keep their usual effect.
#[cfg(not(unix))]
pub fn listen() {
    let _ = ctrlc::set_handler(end);
}

fn end() {
    if REQUESTED.get_or_init(Instant::now).elapsed() > SAME {
        file::remove_unfinished();
        std::process::exit(130);
    }
}

/// Whether the work under way is of no use any more, though the program goes on.
static CANCELLED: AtomicBool = AtomicBool::new(false);

/// How many wait for the end of what is under way.
static ENDINGS: AtomicUsize = AtomicUsize::new(0);

/// Whether an interruption has been asked for.
pub fn requested() -> bool {
    REQUESTED.get().is_some() || CANCELLED.load(Ordering::Relaxed) || ENDINGS.load(Ordering::Relaxed) > 0
}

/// Whether the program has been asked to end.
#[cfg(feature = "viewer")]
pub fn asked() -> bool {
    REQUESTED.get().is_some()
}

/// Ends the work under way as an interruption does, or lets the next begin.
#[cfg(feature = "viewer")]
pub fn cancel(on: bool) {
    CANCELLED.store(on, Ordering::Relaxed);
}

/// As long as there is one, the work under way ends as [`cancel`] ends it, and what that was told stays.
#[cfg(feature = "viewer")]
pub struct Ending(());

#[cfg(feature = "viewer")]
impl Ending {
    pub fn new() -> Ending {
        ENDINGS.fetch_add(1, Ordering::Relaxed);
        Ending(())
    }
}

#[cfg(feature = "viewer")]
impl Drop for Ending {
    fn drop(&mut self) {
        ENDINGS.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Whether it has been asked since the last look that what there is be written.
pub fn writing_requested() -> bool {
    WRITING.swap(false, Ordering::Relaxed)
}

/// Fails once an interruption has been asked for; called between steps.
pub fn check(report: &Report) -> Result<(), Error> {
    if requested() { Err(Error::Interrupted { written: report.written(), kept: None }) } else { Ok(()) }
}
