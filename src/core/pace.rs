//! How much of a work fits into a slice of time.

use std::time::{Duration, Instant};

/// Time that a submission should take: a window waits no longer.
pub const SLICE: Duration = Duration::from_millis(12);

/// Sizes submissions by the time that things took.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// For each.
    seconds: f64,
    /// So many at a time, however long they take.
    fixed: Option<u32>,
}

impl Pace {
    /// At first so many seconds for each.
    pub const fn new(seconds: f64) -> Pace {
        Pace { seconds, fixed: None }
    }

    /// Where nobody waits for the end of a submission.
    pub const fn of(count: u32) -> Pace {
        Pace { seconds: 1.0, fixed: Some(count) }
    }

    /// How many take so long.
    pub fn fits(self, budget: Duration) -> u32 {
        self.fixed.unwrap_or((budget.as_secs_f64() / self.seconds) as u32)
    }

    /// So many took so long.
    pub fn took(&mut self, count: u32, time: Duration) {
        let found = time.as_secs_f64().max(1e-7) / f64::from(count.max(1));
        // They differ; the slowest of the last ones counts most.
        self.seconds = found.max(0.7 * self.seconds);
    }

    /// Does so many of them.
    pub fn time<T, E>(&mut self, count: u32, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let begun = Instant::now();
        let done = work()?;
        // A few take as long as what is round them.
        if count >= self.fits(SLICE) / 2 {
            self.took(count, begun.elapsed());
        }
        Ok(done)
    }
}
