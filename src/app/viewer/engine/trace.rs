//! Path tracing from where the eye is: a picture that gets better as long as nothing moves.

use super::{Command, Frame, Land, Means, News, Status, Studio, Traced, land::show};
use crate::app::Error;
use crate::core::camera::Pinhole;
use crate::formats;
use crate::scene::{Film, Picture, Scene};
use crate::trace::{Assets, Settings, Sums, Tracer};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, TryRecvError};
use std::time::{Duration, Instant};

/// Between two looks at what has been traced: developing it takes time, too.
const LOOKS: Duration = Duration::from_millis(300);

/// Who rests for less goes on moving: nothing is traced for that.
pub const REST: Duration = Duration::from_millis(150);

/// What has been traced, and how to go on.
#[derive(Default)]
pub struct Trace {
    /// Of the land as it is.
    assets: Option<Arc<Assets>>,
    kept: Option<Kept>,
    /// How what was traced has been developed, if it is what is shown.
    shown: Option<Film>,
    pub traced: Option<Traced>,
}

/// What has been traced, and what it shows.
struct Kept {
    sums: Sums,
    /// What it was gathered for. It may be developed for another exposure.
    film: Film,
    camera: Pinhole,
    settings: Settings,
}

/// Why tracing ended.
pub enum Ended {
    /// It has all its samples.
    Done,
    /// This has to be done first.
    By(Command),
    /// Nobody is there any more.
    Gone,
}

impl Trace {
    /// The land, its light or its plants have changed.
    pub fn forget(&mut self) {
        (self.assets, self.kept, self.traced) = (None, None, None);
    }

    /// Something else is shown from now on.
    pub fn hide(&mut self) {
        self.shown = None;
    }

    /// Whether it is what is shown.
    pub fn is_shown(&self) -> bool {
        self.shown.is_some()
    }

    /// Traces until all samples are there, or a command comes that changes what is seen.
    pub fn run(
        &mut self,
        (studio, speaker, inbox, load): Means<'_>,
        land: &mut Land,
        scene: &Scene,
    ) -> Result<Ended, Error> {
        let film = land.film(studio.size);
        let camera = land.written_camera(&film);
        let settings = land.world().tracing;
        self.kept = self.kept.take().filter(|kept| kept.shows(&film, &camera, &settings));
        if let Some(kept) = self.kept.as_ref().filter(|kept| kept.sums.samples() >= land.world().samples) {
            if self.shown != Some(film) {
                let image = show(studio, &developed(&kept.sums, &kept.film, &film), &film)?;
                speaker.say(News::Frame(Frame { image, scale: 1.0, camera: Some(camera) }));
                self.shown = Some(film);
            }
            return Ok(Ended::Done);
        }
        if self.kept.is_none() {
            match inbox.recv_timeout(REST) {
                Ok(command) => return Ok(Ended::By(command)),
                Err(RecvTimeoutError::Disconnected) => return Ok(Ended::Gone),
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
        let tracer = match studio.tracer.take() {
            Some(tracer) => tracer,
            None => {
                speaker.say(News::Status(Box::new(busy(land, studio, "compiling the tracer"))));
                Arc::new(Tracer::new(&studio.gpu)?)
            }
        };
        let tracer = studio.tracer.insert(tracer).clone();
        let assets = match self.assets.take() {
            Some(assets) => assets,
            None => {
                speaker.say(News::Status(Box::new(busy(land, studio, "building trees of the scene"))));
                tracer.assets(scene)?
            }
        };
        self.assets = Some(assets.clone());
        // Exposures are part of the sums: they go on with their own.
        let film = self.kept.as_ref().map_or(film, |kept| kept.film);
        let mut tracing = tracer.begin_with(&assets, scene, &film, &camera, settings)?;
        if let Some(kept) = self.kept.take() {
            tracing.resume(kept.sums);
        }
        let (begun, before) = (Instant::now(), tracing.sums().progress().1);
        let mut looked = None;
        let ended = loop {
            let some = tracing.sums().samples() > 0;
            match inbox.try_recv() {
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => break Ended::Gone,
                Ok(command) if !goes_on(&command, land, studio.size, some) => break Ended::By(command),
                Ok(command) => {
                    // One that ends it is counted where it is obeyed.
                    load.received(&command);
                    match command {
                        Command::Edit(world) => {
                            land.develop(&world);
                            looked = None;
                        }
                        Command::Picture(path) => {
                            tracing.settle()?;
                            let shown = land.film(studio.size);
                            speaker.tell(save(tracing.sums(), &film, &shown, &path));
                        }
                        Command::Steer(steering) => studio.steering = steering,
                        command => {
                            land.obey(studio, speaker, command)?;
                            speaker.say(News::Status(Box::new(status(land, studio, self.traced))));
                        }
                    }
                }
            }
            let samples = land.world().samples;
            let more = tracing.step(samples)?;
            let some = tracing.sums().samples() > 0;
            let is_time = looked.is_none_or(|since: Instant| since.elapsed() >= LOOKS);
            if (some && is_time) || !more {
                let (each, gathered) = tracing.sums().progress();
                let rate = (gathered - before) as f64 / begun.elapsed().as_secs_f64();
                let pixels = f64::from(film.width) * f64::from(film.height);
                let left = (f64::from(samples) - each).max(0.0) * pixels / rate.max(1.0);
                let noise = tracing.sums().noise();
                self.traced = Some(Traced { samples: each, of: samples, noise, rate, left });
                let shown = land.film(studio.size);
                let image = show(studio, &developed(tracing.sums(), &film, &shown), &shown)?;
                speaker.say(News::Frame(Frame { image, scale: 1.0, camera: Some(camera) }));
                self.shown = Some(shown);
                speaker.say(News::Status(Box::new(status(land, studio, self.traced))));
                looked = Some(Instant::now());
            }
            if !more {
                break Ended::Done;
            }
        };
        // Who moves on does not wait for what he leaves.
        if matches!(ended, Ended::By(Command::Trace(false))) {
            tracing.settle()?;
        }
        self.kept = Some(Kept { sums: tracing.take_sums(), film, camera, settings });
        Ok(ended)
    }

    /// Writes what is shown: .exr with its layers, or .png.
    pub fn save(&self, path: &Path) -> Option<Result<String, Error>> {
        let (kept, film) = (self.kept.as_ref()?, self.shown.as_ref()?);
        Some(save(&kept.sums, &kept.film, film, path))
    }
}

impl Kept {
    /// Whether it is part of such a picture.
    fn shows(&self, film: &Film, camera: &Pinhole, settings: &Settings) -> bool {
        let size = |film: &Film| [film.width, film.height];
        size(&self.film) == size(film) && self.camera == *camera && self.settings == *settings
    }
}

/// Whether a command changes nothing of what is traced. Without a picture of `some` samples there is none to be developed anew.
fn goes_on(command: &Command, land: &Land, size: [u32; 2], some: bool) -> bool {
    match command {
        Command::Picture(_)
        | Command::Trace(true)
        | Command::Play(false)
        | Command::PerPicture(_)
        | Command::Enable(..)
        | Command::Section(_)
        | Command::Select(_) => true,
        Command::Edit(world) => some && land.is_developed_as(world),
        Command::Steer(steering) => steering.is_still(),
        Command::Size(other) => *other == size,
        _ => false,
    }
}

fn status(land: &Land, studio: &Studio, traced: Option<Traced>) -> Status {
    Status { world: land.status_with(traced), ..super::status(studio, land.counts()) }
}

fn busy(land: &Land, studio: &Studio, what: &str) -> Status {
    Status { work: Some((what.into(), 0, 0)), ..status(land, studio, None) }
}

/// What was gathered for one film, as another shows it.
fn developed(sums: &Sums, gathered: &Film, film: &Film) -> Picture {
    sums.picture().exposed(film.exposure / gathered.exposure)
}

/// Writes what was gathered for one film as another shows it: .exr with its layers, or .png. Returns what is to be said.
fn save(sums: &Sums, gathered: &Film, film: &Film, path: &Path) -> Result<String, Error> {
    let size = [film.width, film.height];
    if formats::extension(path) == "exr" {
        let times = film.exposure / gathered.exposure;
        let mut channels = sums.channels();
        for (name, values) in &mut channels {
            let times = match name.as_str() {
                "R" | "G" | "B" => times,
                name if name.starts_with("variance.") => times * times,
                _ => continue,
            };
            values.iter_mut().for_each(|value| *value *= times);
        }
        let picture = formats::exr::Layered {
            size,
            origin: [0, 0],
            whole: size,
            white_luminance: 1.0 / film.exposure,
            comments: format!("terrane view, {} samples a pixel", sums.samples()),
            channels,
        };
        formats::exr::write_layered(path, picture, false)?;
    } else {
        let picture = developed(sums, gathered, film);
        formats::png::write_picture(path, size, &picture.developed(film.tone_map))?;
    }
    Ok(format!("wrote {} with {} samples a pixel", path.display(), sums.samples()))
}
