//! A picture by path tracing: until it has all its samples, is clean enough, has had its time, or is interrupted.

use crate::app::{Error, Session, interrupt};
use crate::core::camera::Pinhole;
use crate::formats::{self, exr::Layered};
use crate::gpu::Gpu;
use crate::scene::{Film, Scene};
use crate::trace::{Sums, Tracer};
use crate::world::World;
use clap::Args;
use std::path::Path;
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

/// What is lost at most when a run is killed.
const INTERVAL: Duration = Duration::from_secs(30);

/// Traces the picture and writes it to `path`, now and then on the way, too.
#[allow(clippy::too_many_arguments)]
pub fn run(
    gpu: &Gpu,
    world: &World,
    scene: &Scene,
    film: &Film,
    camera: &Pinhole,
    limits: &Limits,
    path: &Path,
    session: &mut Session,
) -> Result<(), Error> {
    let tracer = Tracer::new(gpu)?;
    session.progress.show("trees", 0, 1);
    let mut tracing = tracer.begin(scene, film, camera, world.tracing)?;
    session.progress.show("trees", 1, 1);
    let samples = limits.spp.unwrap_or(world.samples);
    let begun = Instant::now();
    let mut written = Instant::now();
    let write =
        |sums: &Sums, session: &mut Session| write(path, sums, world, film, gpu, limits.half, session);
    loop {
        tell(tracing.sums(), samples, begun, session);
        if interrupt::requested() {
            write(tracing.sums(), session)?;
            return Err(Error::Interrupted { written: session.report.written(), kept: None });
        }
        if finished(tracing.sums(), limits, begun) || !tracing.step(samples)? {
            break;
        }
        if written.elapsed() >= INTERVAL {
            write(tracing.sums(), session)?;
            written = Instant::now();
        }
    }
    session.progress.end();
    write(tracing.sums(), session)?;
    let sums = tracing.sums();
    let noise = sums.noise().map(|noise| format!(", error about {:.1} %", 100.0 * noise)).unwrap_or_default();
    session.progress.say(&format!(
        "wrote {}, {} × {} pixels, {} samples a pixel{noise}",
        path.display(),
        film.width,
        film.height,
        sums.samples()
    ));
    Ok(())
}

fn tell(sums: &Sums, samples: u32, begun: Instant, session: &mut Session) {
    let (each, all) = sums.progress();
    let rate = all as f64 / begun.elapsed().as_secs_f64().max(1e-3);
    session.progress.show("tracing", each as u64, samples.into());
    let noise = sums.noise().map(|noise| format!(", error about {:.1} %", 100.0 * noise)).unwrap_or_default();
    session.progress.detail(format!("{:.2} M samples/s{noise}", rate / 1e6));
}

/// Whether time is up, or the picture is clean enough.
fn finished(sums: &Sums, limits: &Limits, begun: Instant) -> bool {
    let samples = sums.samples();
    let late = limits.time_limit.is_some_and(|limit| begun.elapsed() >= limit);
    let even = sums.progress().0 == f64::from(samples);
    let clean = || limits.noise.zip(sums.noise()).is_some_and(|(limit, noise)| noise <= limit);
    samples > 0 && (late || even && samples.is_power_of_two() && clean())
}

fn write(
    path: &Path,
    sums: &Sums,
    world: &World,
    film: &Film,
    gpu: &Gpu,
    half: bool,
    session: &mut Session,
) -> Result<(), Error> {
    let size = [film.width, film.height];
    let written = match formats::extension(path).as_str() {
        "exr" => {
            let picture = Layered {
                size,
                white_luminance: 1.0 / film.exposure,
                comments: format!(
                    "world {}, sha256 {}, seed {}, {} samples a pixel, traced on {}",
                    world.name,
                    world.sha256,
                    world.seed,
                    sums.samples(),
                    gpu.info().name
                ),
                channels: sums.channels(),
            };
            let (written, clamped) = formats::exr::write_layered(path, picture, half)?;
            if clamped > 0 {
                session.warn(format!("{clamped} values are too large for 16-bit floats, and were cut off"));
            }
            written
        }
        _ => formats::png::write_picture(path, size, &sums.picture().developed(film.tone_map))?,
    };
    session.report.wrote(&written);
    Ok(())
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
