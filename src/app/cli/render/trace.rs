//! A picture by path tracing: until it has all its samples, is clean enough, has had its time, or is interrupted.

use super::checkpoint::Checkpoint;
use super::picture::{self, Finish};
use crate::app::cli::output::Place;
use crate::app::error::Kept;
use crate::app::{Error, Session, interrupt, keep};
use crate::formats::file::Written;
use crate::gpu;
use crate::trace::{MOST_SAMPLES, Sums, Tracing};
use clap::Args;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// When a traced picture is finished.
#[derive(Args)]
pub struct Limits {
    /// Samples a pixel, for trace [default: the world's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)))]
    pub spp: Option<u32>,

    /// Stop tracing after so many seconds, and at the earliest when every pixel has a sample
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time_limit: Option<Duration>,

    /// Stop tracing when the estimated error of the picture is below this, for example 0.05 for 5 %; looked at whenever the
    /// number of samples is a power of two
    #[arg(long, value_name = "ERROR", value_parser = noise)]
    pub noise: Option<f64>,

    #[command(flatten)]
    pub finish: Finish,
}

/// What is traced, and where it goes.
pub struct Goal<'a> {
    /// Of the picture; a shard is written when it has all its samples, and not before.
    pub path: &'a Path,
    pub place: &'a Place,
    pub is_shard: bool,
    /// The number of the sample that comes when all is done.
    pub end: u32,
    pub limits: &'a Limits,
}

impl Goal<'_> {
    /// Traces until the goal is reached, and writes what there is now and then, and when it is asked for.
    pub fn pursue(
        &self,
        tracing: &mut Tracing,
        checkpoint: &Checkpoint,
        session: &mut Session,
    ) -> Result<(), Error> {
        let interval = keep::interval();
        let (begun, before) = (Instant::now(), tracing.sums().progress().1);
        let [mut sums_kept, mut picture_written] = [Pace::new(interval), Pace::new(interval)];
        let mut noise = Noise::default();
        loop {
            noise.look(tracing.sums());
            self.tell(tracing.sums(), &noise, begun, before, session);
            if interrupt::requested() {
                tracing.settle()?;
                let sums = tracing.sums();
                let kept = self.keep(sums, checkpoint)?;
                session.report.checkpoint = kept.then(|| checkpoint.path.to_string_lossy().into_owned());
                self.show(sums, checkpoint)?.iter().for_each(|written| session.report.wrote(written));
                let kept = kept.then(|| Kept::Samples(checkpoint.path.clone()));
                return Err(Error::Interrupted { written: session.report.written(), kept });
            }
            if self.is_reached(tracing.sums(), &noise, begun) {
                return Ok(());
            }
            let asked = interrupt::writing_requested();
            if asked || sums_kept.is_due() {
                tracing.settle()?;
                sums_kept.time(|| self.keep(tracing.sums(), checkpoint))?;
            }
            if asked || picture_written.is_due() {
                picture_written.time(|| self.show(tracing.sums(), checkpoint))?;
            }
            lose_device()?;
            if !tracing.step(self.end)? {
                return Ok(());
            }
        }
    }

    /// Writes a checkpoint, if there is anything to keep.
    fn keep(&self, sums: &Sums, checkpoint: &Checkpoint) -> Result<bool, Error> {
        let any = sums.progress().1 > 0;
        if any {
            self.place.make()?;
            checkpoint.write(sums, None)?;
        }
        Ok(any)
    }

    /// Writes the picture so far, if all of its pixels have a sample.
    fn show(&self, sums: &Sums, checkpoint: &Checkpoint) -> Result<Option<Written>, Error> {
        if self.is_shard || sums.samples() == 0 {
            return Ok(None);
        }
        self.place.make()?;
        let (written, _) =
            picture::write(self.path, checkpoint.render(), sums, self.limits.finish.half, None)?;
        Ok(Some(written))
    }

    /// Whether the picture has all its samples, is clean enough, or its time is up.
    fn is_reached(&self, sums: &Sums, noise: &Noise, begun: Instant) -> bool {
        let late = self.limits.time_limit.is_some_and(|limit| begun.elapsed() >= limit);
        sums.samples() > 0 && late || self.is_done(sums, noise)
    }

    /// The same without a look at the clock.
    pub fn is_done(&self, sums: &Sums, noise: &Noise) -> bool {
        let (ends, _) = sums.parts();
        let clean = self.limits.noise.is_some_and(|limit| noise.is_at_most(limit, sums));
        ends.iter().all(|end| *end >= self.end) || clean
    }

    fn tell(&self, sums: &Sums, noise: &Noise, begun: Instant, before: u64, session: &mut Session) {
        let (each, all) = sums.progress();
        let of = self.end - sums.first();
        let rate = (all - before) as f64 / begun.elapsed().as_secs_f64().max(1e-3);
        session.progress.show("tracing", each as u64, of.into());
        let left = self.limits.time_limit.map(|limit| limit.saturating_sub(begun.elapsed()).as_secs());
        let left = left.map(|left| format!(", at most {left} s left")).unwrap_or_default();
        session.progress.detail(format!("{:.2} M samples/s{noise}{left}", rate / 1e6));
    }
}

/// When something is written again: at intervals, and so that writing takes no more than a twentieth of the time.
struct Pace {
    interval: Duration,
    last: Instant,
    pause: Duration,
}

impl Pace {
    fn new(interval: Duration) -> Self {
        Pace { interval, last: Instant::now(), pause: interval }
    }

    fn is_due(&self) -> bool {
        self.last.elapsed() >= self.pause
    }

    fn time<T>(&mut self, write: impl FnOnce() -> Result<T, Error>) -> Result<(), Error> {
        let begun = Instant::now();
        write()?;
        (self.last, self.pause) = (Instant::now(), self.interval.max(20 * begun.elapsed()));
        Ok(())
    }
}

/// The picture's estimated error. It is decided by it when the number of samples is a power of two, and it is estimated then only:
/// so a picture ends with the same samples however its work was cut.
#[derive(Default)]
pub struct Noise {
    /// Samples of every pixel when it was estimated.
    samples: u32,
    estimate: Option<f64>,
}

impl Noise {
    pub fn look(&mut self, sums: &Sums) {
        let samples = sums.range().map_or(0, |range| range.len() as u32);
        if samples.is_power_of_two() && samples != self.samples {
            (self.samples, self.estimate) = (samples, sums.noise());
        }
    }

    fn is_at_most(&self, limit: f64, sums: &Sums) -> bool {
        let is_now = sums.range().is_some_and(|range| range.len() as u32 == self.samples);
        is_now && self.estimate.is_some_and(|noise| noise <= limit)
    }
}

impl std::fmt::Display for Noise {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self.estimate {
            Some(noise) => write!(f, ", error about {:.1} % with {} samples", 100.0 * noise, self.samples),
            None => Ok(()),
        }
    }
}

/// Nobody can make a driver lose its device: tests name steps of tracing in `TERRANE_LOSE_DEVICE`, `3,10` for example, that fail as if
/// it were lost. They are counted from 1, over the whole run.
fn lose_device() -> gpu::Result<()> {
    static STEP: AtomicU64 = AtomicU64::new(0);
    let Ok(steps) = std::env::var("TERRANE_LOSE_DEVICE") else { return Ok(()) };
    let step = STEP.fetch_add(1, Ordering::Relaxed) + 1;
    match steps.split(',').any(|lost| lost.trim().parse() == Ok(step)) {
        true => Err(gpu::Error::Lost { after: format!("step {step} of a test") }),
        false => Ok(()),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| *seconds > 0.0);
    let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| "it must be a number of seconds above 0".into())
}

fn noise(text: &str) -> Result<f64, String> {
    let noise = text.parse::<f64>().ok().filter(|noise| *noise > 0.0 && noise.is_finite());
    noise.ok_or_else(|| "it must be a number above 0, for example 0.05".into())
}
