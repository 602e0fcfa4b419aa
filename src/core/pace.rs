//! How much work fits into a span of time.

use std::time::Duration;

/// Sizes pieces of work by the time that pieces before took: seconds for each of what they consist of.
#[derive(Clone, Copy, Debug)]
pub struct Pace(pub f64);

impl Pace {
    /// How much takes so long.
    pub fn fits(self, budget: Duration) -> u32 {
        (budget.as_secs_f64() / self.0) as u32
    }

    /// So much took so long.
    pub fn took(&mut self, count: u32, time: Duration) {
        let found = time.as_secs_f64().max(1e-7) / f64::from(count.max(1));
        // They differ; the slowest of the last ones counts most.
        self.0 = found.max(0.7 * self.0);
    }
}
