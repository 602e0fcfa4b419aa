//! How fast a world becomes a clean picture: samples a second, the error that is left, and what the low-discrepancy sequence is
//! worth beside independent random numbers.

use super::Error;
use super::clock::{self, Stopwatch};
use crate::core::camera::Pinhole;
use crate::gpu::Gpu;
use crate::scene::{self, Film, Scene};
use crate::trace::{Settings, Tracer};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::time::Duration;

/// What was measured, and on what.
#[derive(Clone, Debug, Serialize)]
pub struct Picture {
    #[serde(skip)]
    pub device: String,
    pub driver: String,
    pub cores: usize,
    /// Name of the world.
    pub name: String,
    pub size: [u32; 2],
    /// Of each pixel.
    pub samples: u32,
    pub rows: Vec<Row>,
}

/// With one kind of random numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub numbers: &'static str,
    pub samples_per_second: f64,
    /// The same by the work of one core, where the device is the processor.
    pub samples_per_core_second: f64,
    /// Root of the mean squared error of R, G and B over their mean, times the root of the samples a pixel: half as much is as
    /// good as four times the speed.
    pub spread: f64,
    /// That error after a minute.
    pub error_after_a_minute: f64,
}

/// Samples of each pixel: a power of two, where the sequence is evenest.
const SAMPLES: u32 = 64;

/// Traces `scene` four times, twice with each kind of random numbers. The error of a picture is that by which it differs from
/// another of its kind with another seed, over √2: no reference is needed. Between two steps `stops` is asked whether to end.
///
/// # Errors
/// No memory; [`Error::Stopped`].
pub fn picture(
    gpu: &Gpu,
    name: &str,
    (scene, film, camera): (&Scene, &Film, &Pinhole),
    settings: Settings,
    stops: impl Fn() -> bool,
    mut done: impl FnMut(&Row),
) -> Result<Picture, Error> {
    let info = gpu.info();
    let size = [film.width, film.height];
    let mut rows = Vec::new();
    for (numbers, tracer) in
        [("Owen-scrambled Sobol", Tracer::new(gpu)?), ("independent", Tracer::independent(gpu)?)]
    {
        let mut pictures = Vec::new();
        let (mut wall, mut work) = (Duration::ZERO, Duration::ZERO);
        for seed in [settings.seed, settings.seed.wrapping_add(1)] {
            let mut tracing = tracer.begin(scene, film, camera, Settings { seed, ..settings })?;
            // Programs are compiled when they first run.
            tracing.step(SAMPLES)?;
            let watch = Stopwatch::start();
            while tracing.step(SAMPLES)? {
                if stops() {
                    return Err(Error::Stopped);
                }
            }
            let spent = watch.stop();
            (wall, work) = (wall + spent.wall, work + spent.work);
            pictures.push(tracing.sums().picture());
        }
        let row = row(numbers, &pictures, size, [wall, work]);
        done(&row);
        rows.push(row);
    }
    Ok(Picture {
        device: info.name.clone(),
        driver: info.driver.clone(),
        cores: clock::cores(),
        name: name.into(),
        size,
        samples: SAMPLES,
        rows,
    })
}

fn row(
    numbers: &'static str,
    pictures: &[scene::Picture],
    [width, height]: [u32; 2],
    [wall, work]: [Duration; 2],
) -> Row {
    let values = |index: usize| pictures.iter().skip(index).take(1).flat_map(|it| it.pixels.as_flattened());
    let count = f64::from(width) * f64::from(height) * 3.0;
    let squares: f64 = values(0).zip(values(1)).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let mean = values(0).chain(values(1)).map(|value| f64::from(*value)).sum::<f64>() / (2.0 * count);
    let error = (squares / count / 2.0).sqrt() / mean.max(1e-12);
    let spread = error * f64::from(SAMPLES).sqrt();
    let pixels = f64::from(width) * f64::from(height);
    let traced = pixels * f64::from(SAMPLES) * pictures.len() as f64;
    let samples_per_second = traced / wall.as_secs_f64();
    Row {
        numbers,
        samples_per_second,
        samples_per_core_second: traced / work.as_secs_f64(),
        spread,
        error_after_a_minute: spread / (60.0 * samples_per_second / pixels).sqrt(),
    }
}

/// A table, in Markdown.
impl Display for Picture {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Picture { device, driver, cores, name, size, samples, rows } = self;
        let [width, height] = size;
        writeln!(
            out,
            "{device}, {driver}; {cores} cores; {name}, {width} × {height}, {samples} samples a pixel, twice\n"
        )?;
        writeln!(
            out,
            "| random numbers | samples/s | samples/s and core | error · √samples | error after a minute |"
        )?;
        writeln!(out, "|---|--:|--:|--:|--:|")?;
        for row in rows {
            let Row { numbers, samples_per_second, samples_per_core_second, spread, error_after_a_minute } =
                row;
            writeln!(
                out,
                "| {numbers} | {samples_per_second:.0} | {samples_per_core_second:.0} | {spread:.3} | {:.2} % |",
                100.0 * error_after_a_minute
            )?;
        }
        Ok(())
    }
}
