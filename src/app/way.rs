//! The way through a zoom, frame by frame: down from where the world says, or up from a location code.

use super::{Error, Session};
use crate::formats;
use crate::world::{Overrides, World, Zoom};
use crate::zoom::{
    address::{DEEPEST, Location, MOST_LETTERS},
    height::{Spine, Surface},
    motion::{Approach, Autopilot, Depth, Flight, Pose},
};
use clap::Args;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

/// Where a zoom is looked at from.
#[derive(Args)]
pub struct From {
    /// With a zoom: look from the place of a location code, or of the one in a file (@FILE); --json tells those of pictures
    ///
    /// The code says which surface is seen, from where, and where the view goes; the world says how it is shown. Frames are those of
    /// the way out, straight up from there: frame 0 is the place itself, and with --return the last one is.
    #[arg(long, value_name = "CODE|@FILE", conflicts_with = "seed")]
    from: Option<String>,
}

impl From {
    pub fn is_given(&self) -> bool {
        self.from.is_some()
    }
}

/// What names a location.
const OPTION: &str = "--from";
const KEY: &str = "zoom.from";

/// Keys that the location code of the command line stands for.
const CODED: [&str; 6] = ["seed", "zoom", "zoom.depth", KEY, "zoom.refinement", "zoom.roughness"];

/// Views by the number of a frame.
pub struct Way {
    surface: Surface,
    levels_per_frame: f64,
    course: Course,
}

enum Course {
    /// To a spot of gentle slope, for ever.
    In { autopilot: Box<Autopilot>, depth: f64, fov: u16 },
    /// From a location straight up.
    Out(Box<Ascent>),
}

struct Ascent {
    start: Location,
    /// What named it.
    by: &'static str,
    /// The spot below, and where on the way from there the location is: known when it has been looked for.
    way: Option<(Approach, Depth)>,
}

impl Way {
    /// # Errors
    /// A location code that is none, or that `set`, the keys of the command line, contradict; a file of one that can't be read.
    pub fn new(world: &World, zoom: &Zoom, from: &From, set: &[String]) -> Result<Way, Error> {
        let levels_per_frame = zoom.levels_per_frame;
        let out = |start: Location, by| Way {
            surface: start.surface,
            levels_per_frame,
            course: Course::Out(Box::new(Ascent { start, by, way: None })),
        };
        let fov = Location::nearest_fov(world.fov);
        let Some(code) = &from.from else {
            if let Some(start) = &zoom.from {
                return Ok(out(Location { fov, ..start.clone() }, KEY));
            }
            let surface = zoom.surface(world.seed);
            let autopilot = Box::new(Autopilot::new(surface));
            let course = Course::In { autopilot, depth: zoom.depth, fov };
            return Ok(Way { surface, levels_per_frame, course });
        };
        let overrides = Overrides { set: set.to_vec(), seed: None };
        if let Some(key) = CODED.into_iter().find(|key| overrides.sets(key)) {
            return Err(Error::Usage(format!(
                "--set {key}: --from says which surface is seen and from where; leave one of the two out"
            )));
        }
        Ok(out(parse(code)?, OPTION))
    }

    /// What is seen from a code of the command line is not of the world's seed.
    pub fn tell_seed(&self, session: &mut Session) {
        if matches!(&self.course, Course::Out(ascent) if ascent.by == OPTION) {
            session.report.seed = None;
        }
    }

    pub fn surface(&self) -> Surface {
        self.surface
    }

    /// The vertical field of view, radians.
    pub fn fov(&self) -> f32 {
        match &self.course {
            Course::In { fov, .. } => Location::radians(*fov),
            Course::Out(ascent) => ascent.start.fov_radians(),
        }
    }

    /// Frames in so many levels.
    pub fn frames_in(&self, levels: f64) -> u32 {
        (levels / self.levels_per_frame) as u32
    }

    /// Passes so many levels from one frame to the next.
    pub fn pass(&mut self, levels_per_frame: f64) {
        self.levels_per_frame = levels_per_frame;
    }

    /// Makes known what the way to a frame leads by, which takes seconds far down. In between, `check` may end it.
    ///
    /// # Errors
    /// Those of `check`.
    pub fn come_to(
        &mut self,
        spine: &mut Spine,
        frame: u32,
        check: impl Fn() -> Result<(), Error>,
    ) -> Result<(), Error> {
        const STEP: usize = 1 << 14;
        let ascent;
        let (place, level) = match &mut self.course {
            Course::In { autopilot, depth, .. } => {
                let level = (*depth + f64::from(frame) * self.levels_per_frame) as u32;
                for passed in (0..level).step_by(STEP) {
                    check()?;
                    autopilot.target(passed);
                }
                (autopilot.target(level), level)
            }
            Course::Out(way) => {
                ascent = way;
                (&ascent.start.place, ascent.start.level)
            }
        };
        while !spine.approach(place, level) {
            check()?;
        }
        Ok(())
    }

    /// Refuses frames that the way does not come to.
    ///
    /// # Errors
    /// Also if the location is below the surface.
    pub fn check(&mut self, spine: &mut Spine, frames: &Range<u32>) -> Result<(), Error> {
        let (levels, end) = match &mut self.course {
            Course::In { depth, .. } => (f64::from(DEEPEST) - *depth, "the deepest place that there is"),
            // A picture by itself needs no way.
            Course::Out(ascent) if frames.end == 1 => return ascent.flight(spine).map(drop),
            Course::Out(ascent) => {
                let (_, Depth(depth)) = ascent.way(spine)?;
                (*depth as f64 / 65_536.0, "the whole surface is in view")
            }
        };
        let passed = f64::from(frames.end - 1) * self.levels_per_frame;
        if passed <= levels {
            return Ok(());
        }
        let last = (levels / self.levels_per_frame).floor();
        Err(Error::Usage(format!(
            "--frames {}..{}: frame {last} is the last before {end}; make fewer frames, or lower `zoom.levels_per_frame`",
            frames.start, frames.end
        )))
    }

    /// What a frame shows, if it is one that [`check`](Self::check) lets through. The first of the way out is the location itself.
    pub fn at(&mut self, spine: &mut Spine, frame: u32) -> Result<Location, Error> {
        let passed = f64::from(frame) * self.levels_per_frame;
        match &mut self.course {
            Course::In { autopilot, depth, fov } => {
                let depth = Depth(((*depth + passed) * 65_536.0) as u64);
                let Pose { place, attitude } = autopilot.at(spine, depth);
                Ok(Location { surface: self.surface, level: depth.whole(), place, attitude, fov: *fov })
            }
            Course::Out(ascent) if frame == 0 => Ok(ascent.start.clone()),
            Course::Out(ascent) => {
                let (approach, Depth(start)) = ascent.way(spine)?;
                let depth = Depth(start.saturating_sub((passed * 65_536.0) as u64));
                let place = approach.at(depth, spine.surface().roughness);
                Ok(Location { level: depth.whole(), place, ..ascent.start.clone() })
            }
        }
    }
}

impl Ascent {
    fn flight(&self, spine: &mut Spine) -> Result<Flight, Error> {
        let Location { place, level, .. } = &self.start;
        Flight::new(spine, place.clone(), *level).map_err(|error| {
            let message = format!("{}: {error}", self.by);
            if self.by == OPTION { Error::Usage(message) } else { Error::Missing(message) }
        })
    }

    fn way(&mut self, spine: &mut Spine) -> Result<&(Approach, Depth), Error> {
        let way = match self.way.take() {
            Some(way) => way,
            None => self.flight(spine)?.way_out(spine),
        };
        Ok(self.way.insert(way))
    }
}

/// Reads a location code, or that in the file behind an @.
fn parse(text: &str) -> Result<Location, Error> {
    let Some(path) = text.strip_prefix('@').map(Path::new) else {
        return Location::parse(text).map_err(|error| Error::Usage(format!("--from: {error}")));
    };
    // With line ends, and a byte to tell what is longer.
    let most = 2 * MOST_LETTERS as u64 + 1;
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(most).read_to_end(&mut bytes))
        .map_err(|source| formats::Error::Read { path: path.into(), source })?;
    Location::parse(&String::from_utf8_lossy(&bytes))
        .map_err(|error| Error::Usage(format!("--from {text}: {error}")))
}
