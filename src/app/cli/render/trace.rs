//! A picture by path tracing: until it has all its samples, is clean enough, has had its time, or is interrupted.

use crate::app::cli::output::Place;
use crate::app::{Error, Session, interrupt, keep};
use crate::core::camera::Pinhole;
use crate::formats::{self, exr::Layered, file::Written};
use crate::gpu::Gpu;
use crate::scene::{Film, Scene};
use crate::trace::{Sums, Tracer, Traversal};
use crate::world::World;
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// When a traced picture is finished.
#[derive(Args)]
pub struct Limits {
    /// Samples a pixel, for trace [default: the world's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_SAMPLES))]
    spp: Option<u32>,

    /// Stop tracing after so many seconds, and at the earliest when every pixel has a sample
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    time_limit: Option<Duration>,

    /// Stop tracing when the estimated error of the picture is below this, for example 0.05 for 5 %; looked at whenever the
    /// number of samples is a power of two
    #[arg(long, value_name = "ERROR", value_parser = noise)]
    noise: Option<f64>,

    /// Write 16-bit floats to EXR
    #[arg(long)]
    half: bool,
}

const MOST_SAMPLES: i64 = 1 << 24;

/// What is traced, and where the picture goes.
pub struct Shot<'a> {
    pub world: &'a World,
    pub scene: &'a Scene,
    pub film: Film,
    pub camera: Pinhole,
    pub traversal: Traversal,
    pub path: PathBuf,
    pub place: &'a Place,
}

/// Traces the picture and writes it, now and then on the way, too.
pub fn run(gpu: &Gpu, shot: &Shot, limits: &Limits, session: &mut Session) -> Result<(), Error> {
    let tracer = Tracer::with(gpu, shot.traversal)?;
    session.progress.show("acceleration", 0, 1);
    let mut tracing = tracer.begin(shot.scene, &shot.film, &shot.camera, shot.world.tracing)?;
    session.progress.show("acceleration", 1, 1);
    let samples = limits.spp.unwrap_or(shot.world.samples);
    let interval = keep::interval();
    let begun = Instant::now();
    let mut last = Instant::now();
    let write = |sums: &Sums| shot.write(sums, gpu, limits.half);
    loop {
        tell(tracing.sums(), samples, begun, session);
        let sums = tracing.sums();
        if interrupt::requested() {
            if sums.samples() > 0 {
                let (written, _) = write(sums)?;
                session.report.wrote(&written);
            }
            return Err(Error::Interrupted { written: session.report.written(), kept: None });
        }
        if finished(sums, limits, begun) {
            break;
        }
        if sums.samples() > 0 && last.elapsed() >= interval {
            write(sums)?;
            last = Instant::now();
        }
        if !tracing.step(samples)? {
            break;
        }
    }
    session.progress.end();
    let sums = tracing.sums();
    let (written, clamped) = write(sums)?;
    session.report.wrote(&written);
    if clamped > 0 {
        session.warn(format!("{clamped} values are too large for 16-bit floats, and were cut off"));
    }
    let (path, Film { width, height, .. }) = (shot.path.display(), shot.film);
    let (samples, noise) = (sums.samples(), noise_so_far(sums));
    session
        .progress
        .say(&format!("wrote {path}, {width} × {height} pixels, {samples} samples a pixel{noise}"));
    Ok(())
}

fn tell(sums: &Sums, samples: u32, begun: Instant, session: &mut Session) {
    let (each, all) = sums.progress();
    let rate = all as f64 / begun.elapsed().as_secs_f64().max(1e-3);
    session.progress.show("tracing", each as u64, samples.into());
    session.progress.detail(format!("{:.2} M samples/s", rate / 1e6));
}

fn noise_so_far(sums: &Sums) -> String {
    sums.noise().map(|noise| format!(", error about {:.1} %", 100.0 * noise)).unwrap_or_default()
}

/// Whether time is up, or the picture is clean enough.
fn finished(sums: &Sums, limits: &Limits, begun: Instant) -> bool {
    let samples = sums.samples();
    let late = limits.time_limit.is_some_and(|limit| begun.elapsed() >= limit);
    let even = sums.progress().0 == f64::from(samples);
    let clean = || limits.noise.zip(sums.noise()).is_some_and(|(limit, noise)| noise <= limit);
    samples > 0 && (late || even && samples.is_power_of_two() && clean())
}

impl Shot<'_> {
    /// Writes what has been gathered; returns how many values were too large for the file, too.
    fn write(&self, sums: &Sums, gpu: &Gpu, half: bool) -> Result<(Written, u64), Error> {
        self.place.make()?;
        let (path, size) = (&self.path, [self.film.width, self.film.height]);
        if formats::extension(path) != "exr" {
            let developed = sums.picture().developed(self.film.tone_map);
            return Ok((formats::png::write_picture(path, size, &developed)?, 0));
        }
        let World { name, sha256, seed, .. } = self.world;
        let (samples, device) = (sums.samples(), &gpu.info().name);
        let picture = Layered {
            size,
            white_luminance: 1.0 / self.film.exposure,
            comments: format!(
                "world {name}, sha256 {sha256}, seed {seed}, {samples} samples a pixel, traced on {device}"
            ),
            channels: sums.channels(),
        };
        Ok(formats::exr::write_layered(path, picture, half)?)
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
