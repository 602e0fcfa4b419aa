//! Two clocks: the wall's, and the time that all threads of this process have been at work.

use std::time::{Duration, Instant};

pub struct Stopwatch {
    wall: Instant,
    work: Duration,
}

pub struct Spent {
    pub wall: Duration,
    /// Of all threads together, in the program and in the kernel.
    pub work: Duration,
}

impl Stopwatch {
    pub fn start() -> Stopwatch {
        Stopwatch { wall: Instant::now(), work: work() }
    }

    pub fn stop(&self) -> Spent {
        Spent { wall: self.wall.elapsed(), work: work().saturating_sub(self.work) }
    }
}

/// Cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(unix)]
fn work() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}

/// Without that clock, all cores count as busy all the time.
#[cfg(not(unix))]
fn work() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed() * cores() as u32
}
