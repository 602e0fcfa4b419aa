//! Pictures of a zoom: one at a depth, or the frames of a flight.

use super::{Arguments, Finish, Job, Target, trace};
use crate::app::way::{self, Way};
use crate::app::{Error, Session, interrupt, land, memory, report::Flown};
use crate::scene::Picture;
use crate::world::{Overrides, Renderer, Zoom};
use crate::zoom::{
    address::Location,
    height::Spine,
    motion::{Distance, Flight, moved},
    view::{self, Ahead, View},
};
use clap::Args;
use std::time::Duration;

/// What only pictures of a zoom have.
#[derive(Args)]
pub struct Options {
    /// The frames of a zoom are those of the way back: the first is what the last of the way there is
    #[arg(long = "return", requires = "frames")]
    back: bool,

    /// The frames of a zoom make a film of so many a second, in which a level passes in one second: `zoom.levels_per_frame` is
    /// 1/F
    #[arg(long, value_name = "F", requires = "frames", value_parser = rate)]
    fps: Option<f64>,

    /// A zoom is seen by two eyes, `zoom.eyes` apart: two pictures beside each other in one that is twice as wide, that of the
    /// left eye first
    #[arg(long)]
    pub stereo: bool,

    #[command(flatten)]
    from: way::From,
}

impl Options {
    /// Refuses what a world without a zoom has no use for.
    pub fn check_absent(&self) -> Result<(), Error> {
        let given = [
            ("--return", self.back),
            ("--fps", self.fps.is_some()),
            ("--stereo", self.stereo),
            ("--from", self.from.is_given()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((option, _)) => Err(Error::Missing(format!("{option}: the world has no `zoom`"))),
        }
    }
}

impl Job<'_> {
    /// Makes all pictures.
    pub(super) fn fly(&self, zoom: &Zoom, session: &mut Session) -> Result<(), Error> {
        let Job { arguments, world, film, .. } = self;
        check_use(arguments, self.renderer)?;
        let mut way = Way::new(world, zoom, &arguments.zoom.from, &arguments.world.set)?;
        if let Some(fps) = arguments.zoom.fps {
            let set = Overrides { set: arguments.world.set.clone(), seed: None };
            if set.sets("zoom.levels_per_frame") {
                let message = "--fps and --set zoom.levels_per_frame both say how far apart frames are; leave one of them out";
                return Err(Error::Usage(message.into()));
            }
            way.pass(1.0 / fps);
        }
        way.tell_seed(session);
        let gpu = land::open(&arguments.device, session)?;
        let settings = zoom.settings(film, way.fov());
        memory::check_zoom(&settings, film, &world.light.sky, &memory::Limits::of(&gpu))?;
        let mut renderer = view::Renderer::new(&gpu, way.surface(), settings, &world.light, film)?;
        way.come_to(renderer.spine(), self.on_the_way(self.shots.start), || {
            interrupt::check(&session.report)
        })?;
        way.check(renderer.spine(), &self.shots)?;
        let (mut ahead, frames_ahead) = (Ahead::default(), way.frames_in(Ahead::LEVELS));
        for number in self.shots.clone() {
            let done = number - self.shots.start;
            session.progress.show("frames", done.into(), self.shots.len() as u64);
            interrupt::check(&session.report)?;
            let location = way.at(renderer.spine(), self.on_the_way(number))?;
            let (picture, flown) = self.look(&mut renderer, &location, zoom)?;
            let flown = Flown { gpu_bytes: gpu.memory().used, ..flown };
            let shot = self.shot(number);
            let written = self.write(&shot, picture, session)?;
            session.report.flown(shot.frame, &written, flown);
            let coming = |spine: &mut Spine, frame| {
                let location = way.at(spine, self.on_the_way(frame))?;
                Ok::<_, Error>(View::of(&location))
            };
            ahead.look(&mut renderer, number..self.shots.end, frames_ahead, coming)?;
        }
        session.progress.show("frames", self.shots.len() as u64, self.shots.len() as u64);
        session.progress.end();
        if let (Some(fps), Target::Frames(name)) = (arguments.zoom.fps, &self.target) {
            let (start, frames) = (self.shots.start, name.pattern());
            session.progress.say(&format!(
                "as a film: ffmpeg -framerate {fps} -start_number {start} -i {} -pix_fmt yuv420p film.mp4",
                frames.display()
            ));
        }
        Ok(())
    }

    /// On the way back, frame A + B − 1 − f is what f is on the way there.
    fn on_the_way(&self, number: u32) -> u32 {
        match &self.arguments.frames {
            Some(frames) if self.arguments.zoom.back => frames.start + frames.end - 1 - number,
            _ => number,
        }
    }

    /// By one eye or by two.
    fn look(
        &self,
        renderer: &mut view::Renderer,
        location: &Location,
        zoom: &Zoom,
    ) -> Result<(Picture, Flown), Error> {
        let view = View::of(location);
        if !self.arguments.zoom.stereo {
            let shot = renderer.render(&view)?;
            let flown = flown(location, shot.altitude, &[&shot]);
            return Ok((shot.picture, flown));
        }
        let flight =
            Flight::new(renderer.spine(), view.place.clone(), view.level).map_err(view::Error::from)?;
        let altitude = flight.clearance();
        let [right, ..] = view.attitude.axes();
        // They are at most half as far from the middle as the surface is.
        let [left, right] = [-0.5, 0.5].map(|side| {
            let step = side * f64::from(zoom.eyes) * right;
            View { place: moved(&view.place, altitude, step, location.surface.roughness), ..view.clone() }
        });
        // Through the haze of the middle, or one of them would see farther than the other.
        let [left, right] = [left, right].map(|eye| renderer.render_in_haze(&eye, Some(altitude)));
        let (left, right) = (left?, right?);
        let flown = flown(location, altitude, &[&left, &right]);
        Ok((left.picture.beside(&right.picture), flown))
    }
}

fn flown(location: &Location, altitude: Distance, eyes: &[&view::Shot]) -> Flown {
    let milliseconds =
        |of: fn(&view::Shot) -> Duration| eyes.iter().map(|shot| 1e3 * of(shot).as_secs_f64()).sum();
    Flown {
        depth: altitude.depth(),
        level: altitude.level,
        cells: altitude.cells,
        location: location.code(),
        tiles_drawn: eyes.iter().map(|shot| shot.drawn).sum(),
        tiles_made: eyes.iter().map(|shot| shot.made).sum(),
        cpu_ms: milliseconds(|shot| shot.cpu),
        gpu_ms: milliseconds(|shot| shot.gpu),
        gpu_bytes: 0,
    }
}

/// Refuses options that are for traced pictures, or for runs that can go on.
fn check_use(arguments: &Arguments, renderer: Renderer) -> Result<(), Error> {
    if renderer == Renderer::Trace {
        return Err(Error::Usage("--renderer trace: a zoom is rasterised".into()));
    }
    if arguments.resume {
        return Err(Error::Usage(
            "--resume: a zoom keeps nothing to go on from; name the frames that are missing with --frames"
                .into(),
        ));
    }
    let trace::Limits { spp, time_limit, noise, finish: Finish { half, .. } } = &arguments.limits;
    let given = [
        ("--spp", spp.is_some()),
        ("--time-limit", time_limit.is_some()),
        ("--noise", noise.is_some()),
        ("--half", *half),
        ("--traversal", arguments.traversal.0.is_some()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Error::Usage(format!(
            "{option} is for traced pictures, and a zoom is rasterised; leave it out"
        ))),
    }
}

/// Reads frames a second.
fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if (1.0..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("it must be a number of frames a second between 1 and 1000".into()),
    }
}

impl From<view::Error> for Error {
    fn from(error: view::Error) -> Error {
        match error {
            view::Error::Gpu(error) => Error::Gpu(error),
            view::Error::TooMany(_) | view::Error::Slots { .. } => Error::Missing(format!(
                "{error}; raise `zoom.tiles`, or lower `zoom.detail` or `zoom.visibility`"
            )),
            error => Error::Missing(error.to_string()),
        }
    }
}
