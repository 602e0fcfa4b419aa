//! Path tracing from where the eye is: a picture that gets better as long as nobody moves.

use super::{Command, Frame, Land, Means, News, Speaker, Status, Studio, Traced, land::show};
use crate::app::Error;
use crate::core::camera::Pinhole;
use crate::formats;
use crate::scene::{Film, Scene};
use crate::trace::{Assets, Sums, Tracer, Tracing};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::TryRecvError;
use std::time::{Duration, Instant};

/// Between two looks at what has been traced: developing it takes time, too.
const LOOKS: Duration = Duration::from_millis(300);

/// What has been traced, and how to go on.
#[derive(Default)]
pub struct Trace {
    tracer: Option<Tracer>,
    /// Of the land as it is.
    assets: Option<Arc<Assets>>,
    /// With what it was gathered for.
    kept: Option<(Sums, Film, Pinhole)>,
    pub traced: Option<Traced>,
}

/// Why tracing ended.
pub enum Ended {
    /// It has all its samples, or is to end.
    Done,
    /// This has to be done first, and does away with the picture.
    By(Command),
    /// Nobody is there any more.
    Gone,
}

impl Trace {
    /// The land, its light or its plants have changed.
    pub fn forget(&mut self) {
        (self.assets, self.kept, self.traced) = (None, None, None);
    }

    /// Traces until there are `samples` a pixel or another command comes.
    pub fn run(
        &mut self,
        (studio, speaker, inbox, load): Means<'_>,
        land: &Land,
        scene: &Scene,
        samples: u32,
    ) -> Result<Ended, Error> {
        let film = land.film(studio.size);
        let camera = land.camera(&film);
        let tracer = match self.tracer.take() {
            Some(tracer) => tracer,
            None => {
                speaker.say(News::Status(Box::new(busy(land, studio, "compiling the tracer"))));
                Tracer::new(&studio.gpu)?
            }
        };
        let tracer = self.tracer.insert(tracer);
        let assets = match self.assets.take() {
            Some(assets) => assets,
            None => {
                speaker.say(News::Status(Box::new(busy(land, studio, "building trees of the scene"))));
                tracer.assets(scene)?
            }
        };
        self.assets = Some(assets.clone());
        let mut tracing = tracer.begin_with(&assets, scene, &film, &camera, land.world().tracing)?;
        if let Some((sums, ..)) = self.kept.take().filter(|(_, other, from)| (*other, *from) == (film, camera)) {
            tracing.resume(sums);
        }
        let (begun, before) = (Instant::now(), tracing.sums().progress().1);
        let mut looked = None;
        let ended = loop {
            let command = inbox.try_recv();
            let ends = matches!(&command, Ok(command) if !goes_on(command, studio.size));
            // One that ends it is counted where it is obeyed.
            if command.is_ok() && !ends {
                load.pending.fetch_sub(1, Ordering::SeqCst);
            }
            match command {
                Ok(Command::Picture(path)) => save(&mut tracing, &film, &path, speaker)?,
                Ok(Command::Steer(steering)) if steering.is_still() => studio.steering = steering,
                Ok(command) if !ends => drop(command),
                Err(TryRecvError::Disconnected) => break Ended::Gone,
                Ok(command) => break Ended::By(command),
                Err(TryRecvError::Empty) => {}
            }
            let more = tracing.step(samples)?;
            let all = tracing.sums().samples() > 0;
            let is_time = looked.is_none_or(|since: Instant| since.elapsed() >= LOOKS);
            if (all && is_time) || !more {
                let (each, gathered) = tracing.sums().progress();
                let rate = (gathered - before) as f64 / begun.elapsed().as_secs_f64();
                let pixels = f64::from(film.width) * f64::from(film.height);
                let left = (f64::from(samples) - each).max(0.0) * pixels / rate.max(1.0);
                let noise = tracing.sums().noise();
                self.traced = Some(Traced { samples: each, of: samples, noise, rate, left });
                let image = show(studio, &tracing.sums().picture(), &film)?;
                speaker.say(News::Frame(Frame { image, scale: 1.0 }));
                let status = Status { world: land.status_with(more, self.traced), ..super::status(studio, land.counts()) };
                speaker.say(News::Status(Box::new(status)));
                looked = Some(Instant::now());
            }
            if !more {
                break Ended::Done;
            }
        };
        tracing.settle()?;
        self.kept = Some((tracing.take_sums(), film, camera));
        Ok(ended)
    }
}

/// Whether a command changes nothing of what is traced.
fn goes_on(command: &Command, size: [u32; 2]) -> bool {
    match command {
        Command::Picture(_) | Command::Trace(true) | Command::Section(_) => true,
        Command::Steer(steering) => steering.is_still(),
        Command::Size(other) => *other == size,
        _ => false,
    }
}

fn busy(land: &Land, studio: &Studio, what: &str) -> Status {
    Status {
        world: land.status_with(true, None),
        work: Some((what.into(), 0, 0)),
        ..super::status(studio, land.counts())
    }
}

/// Writes what has been traced so far: .exr with its layers, or .png.
fn save(tracing: &mut Tracing, film: &Film, path: &Path, speaker: &Speaker) -> Result<(), Error> {
    tracing.settle()?;
    let sums = tracing.sums();
    let size = [film.width, film.height];
    if formats::extension(path) == "exr" {
        let picture = formats::exr::Layered {
            size,
            origin: [0, 0],
            whole: size,
            white_luminance: 1.0 / film.exposure,
            comments: format!("terrane view, {} samples a pixel", sums.samples()),
            channels: sums.channels(),
        };
        formats::exr::write_layered(path, picture, false)?;
    } else {
        formats::png::write_picture(path, size, &sums.picture().developed(film.tone_map))?;
    }
    speaker.say(News::Said(format!("wrote {} with {} samples a pixel", path.display(), sums.samples())));
    Ok(())
}
