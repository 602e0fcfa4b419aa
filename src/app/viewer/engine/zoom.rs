//! A zoom on the stage: flown by hand, by the autopilot, or back out.

use super::{Command, Frame, News, Slice, Speaker, Studio, WorldStatus, land::show};
use crate::app::Error;
use crate::scene::Film;
use crate::world::World;
use crate::zoom::{
    address::{Attitude, Location},
    height::Surface,
    motion::{Approach, Autopilot, Depth, Distance, Flight, Pose},
    view::{self, View},
};
use glam::{DVec3, Vec2};
use std::f32::consts::TAU;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// How the flight goes on by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Course {
    /// Where it is steered.
    #[default]
    Hand,
    /// Down, to spots of gentle slope, for ever.
    In,
    /// Up again, the same way.
    Out,
}

/// What the last picture took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Tiles looked at, drawn, made.
    pub leaves: usize,
    pub drawn: usize,
    pub made: usize,
    /// Of those looked at, the coarsest and the finest.
    pub levels: [u32; 2],
    /// In the tiles that were drawn.
    pub triangles: u64,
}

/// Levels that the autopilot passes a second.
const LEVELS_A_SECOND: f64 = 0.5;

/// Texels for one of the window's pixels, along a side, and samples along a side of a texel.
const DETAILS: [(f32, u32); 3] = [(0.5, 1), (1.0, 1), (1.0, 2)];

pub struct Zoom {
    world: Arc<World>,
    surface: Surface,
    renderer: view::Renderer,
    flight: Flight,
    attitude: Attitude,
    /// What turns have not come to a step of the attitude yet, steps.
    rest: Vec2,
    course: Course,
    autopilot: Option<Autopilot>,
    /// Where the autopilot is.
    depth: f64,
    /// The way out from where it was flown to by hand.
    way_out: Option<(Approach, Depth)>,
    frozen: bool,
    detail: usize,
    /// Of the ground below, radians.
    slope: f64,
    drawn: Drawn,
}

impl Zoom {
    pub fn new(studio: &mut Studio, world: &Arc<World>) -> Result<Zoom, Error> {
        let zoom = zoom_of(world)?;
        let surface = zoom.surface(world.seed);
        let mut renderer = renderer(studio, world)?;
        let (flight, attitude, course, autopilot) = match zoom.from.clone() {
            Some(Location { place, level, attitude, .. }) => {
                let flight = Flight::new(renderer.spine(), place, level)
                    .map_err(|error| Error::Missing(format!("zoom.from: {error}")))?;
                (flight, attitude, Course::Hand, None)
            }
            None => {
                let mut autopilot = Autopilot::new(surface);
                let depth = Depth((zoom.depth * 65_536.0) as u64);
                let Pose { place, attitude } = autopilot.at(renderer.spine(), depth);
                let flight =
                    Flight::new(renderer.spine(), place, depth.whole()).map_err(view::Error::from)?;
                (flight, attitude, Course::In, Some(autopilot))
            }
        };
        Ok(Zoom {
            world: world.clone(),
            surface,
            renderer,
            flight,
            attitude,
            rest: Vec2::ZERO,
            course,
            autopilot,
            depth: zoom.depth,
            way_out: None,
            frozen: false,
            detail: 0,
            slope: 0.0,
            drawn: Drawn::default(),
        })
    }

    /// The same world with changes.
    pub fn edit(&mut self, studio: &mut Studio, world: &Arc<World>) -> Result<(), Error> {
        if !is_same_place(&self.world, world) {
            *self = Zoom::new(studio, world)?;
            return Ok(());
        }
        // Exposure and tone map are those of each picture.
        let keeps_tiles = self.world.light == world.light
            && settings(&self.world, studio.size)? == settings(world, studio.size)?;
        if !keeps_tiles {
            (self.renderer, self.frozen) = (renderer(studio, world)?, false);
        }
        let from = &zoom_of(world)?.from;
        let is_elsewhere = zoom_of(&self.world)?.from != *from;
        (self.world, self.detail) = (world.clone(), 0);
        match from {
            // Who flies goes on.
            Some(location) if is_elsewhere && self.course == Course::Hand => self.go_to(location.clone()),
            _ => Ok(()),
        }
    }

    /// Programs have been replaced: what draws is made anew from them.
    #[cfg(feature = "reload")]
    pub fn reprogram(&mut self, studio: &Studio) -> Result<(), Error> {
        (self.renderer, self.detail, self.frozen) = (renderer(studio, &self.world)?, 0, false);
        Ok(())
    }

    pub fn resize(&mut self, studio: &mut Studio) -> Result<(), Error> {
        if studio.size.contains(&0) {
            return Ok(());
        }
        self.detail = 0;
        // It is dear: not for each step of a border that is dragged.
        let face = settings(&self.world, studio.size)?.face;
        if face > self.renderer.settings().face * 5 / 4 {
            self.renderer.refine(face)?;
        }
        Ok(())
    }

    pub fn obey(&mut self, studio: &mut Studio, speaker: &Speaker, command: Command) -> Result<(), Error> {
        match command {
            Command::Turn(by) => {
                self.take_over();
                self.turn(by);
            }
            Command::Orbit(by) => {
                self.take_over();
                self.turn(-by);
            }
            Command::Approach(share) => {
                self.take_over();
                let [_, _, forward] = self.attitude.axes();
                self.flight.fly(
                    self.renderer.spine(),
                    forward * f64::from(share.signum()),
                    share.abs().into(),
                );
                self.detail = 0;
            }
            Command::Course(course) => self.steer_by(course),
            Command::Mark(marks) => {
                studio.marks = marks;
                self.renderer.mark(marks)?;
                self.detail = 0;
            }
            Command::Freeze(on) => self.freeze(on)?,
            Command::Restart => *self = Zoom::new(studio, &self.world.clone())?,
            Command::GoTo(super::Pose::Zoom(code)) => {
                let location = Location::parse(&code).map_err(|error| Error::Usage(error.to_string()))?;
                if location.surface != self.surface {
                    return Err(Error::Usage("the location code is one of another surface".into()));
                }
                self.go_to(location)?;
            }
            Command::FrameAll => {
                self.take_over();
                self.attitude.roll = 0;
                self.detail = 0;
            }
            Command::Picture(path) => speaker.tell(self.write_picture(studio, &path)),
            _ => {}
        }
        Ok(())
    }

    /// Writes what is seen as `terrane render` makes it: without marks, and with a background as fine as the picture.
    fn write_picture(&self, studio: &Studio, path: &Path) -> Result<String, Error> {
        let film = film(&self.world, studio.size, 1.0);
        let view = self.view();
        let settings = zoom_of(&self.world)?.settings(&film, view.fov);
        let mut renderer =
            view::Renderer::new(&studio.gpu, self.surface, settings, &self.world.light, &film)?;
        renderer.share_the_device();
        super::write_picture(path, &renderer.render(&view)?.picture, &film)
    }

    /// The hand is at the wheel from now on.
    fn take_over(&mut self) {
        self.course = Course::Hand;
        self.way_out = None;
    }

    fn steer_by(&mut self, course: Course) {
        if course == Course::Out && self.autopilot.is_none() {
            self.way_out = Some(self.flight.way_out(self.renderer.spine()));
        }
        if course == Course::In && self.autopilot.is_none() {
            // A new descent from where the autopilot would be at this depth.
            self.autopilot = Some(Autopilot::new(*self.renderer.spine().surface()));
            self.depth = self.flight.clearance().depth().max(0.0);
        }
        self.course = course;
    }

    fn freeze(&mut self, on: bool) -> Result<(), Error> {
        let view = self.view();
        self.renderer.freeze(on.then_some(&view))?;
        (self.frozen, self.detail) = (on, 0);
        Ok(())
    }

    /// To a place on this surface.
    fn go_to(&mut self, location: Location) -> Result<(), Error> {
        let flight = Flight::new(self.renderer.spine(), location.place, location.level);
        self.flight = flight.map_err(view::Error::from)?;
        (self.attitude, self.detail) = (location.attitude, 0);
        self.take_over();
        self.autopilot = None;
        Ok(())
    }

    /// Radians, to the right and up.
    fn turn(&mut self, by: Vec2) {
        self.rest += by / TAU * 65_536.0;
        let steps = self.rest.trunc();
        self.rest -= steps;
        self.attitude.yaw = self.attitude.yaw.wrapping_add_signed(steps.x as i16);
        let pitch = i32::from(self.attitude.pitch.cast_signed()) + steps.y as i32;
        self.attitude.pitch = (pitch.clamp(-16_300, 16_300) as i16).cast_unsigned();
        self.detail = 0;
    }

    pub fn slice(&mut self, studio: &mut Studio, speaker: &Speaker) -> Result<Slice, Error> {
        let seconds = studio.held();
        let moves = self.fly(studio, seconds)?;
        if !moves && self.detail >= DETAILS.len() {
            return Ok(Slice::Idle);
        }
        if moves {
            self.detail = 0;
        }
        let (scale, samples) = DETAILS[self.detail];
        let begun = Instant::now();
        let film = film(&self.world, studio.size, scale);
        self.renderer.reshape(&film, samples)?;
        let shot = match self.renderer.render(&self.view()) {
            Err(error) if self.frozen && !matches!(error, view::Error::Gpu(_)) => {
                speaker.say(News::Said(format!("not frozen any more: {error}")));
                self.freeze(false)?;
                self.renderer.render(&self.view())?
            }
            shot => shot?,
        };
        let image = show(studio, &shot.picture, &film)?;
        self.slope = self.flight.slope(self.renderer.spine());
        let view::Shot { leaves, drawn, made, levels, passes, .. } = shot;
        studio.passes = passes.iter().map(|pass| (pass.name, 1e3 * pass.duration.as_secs_f32())).collect();
        let triangles = (drawn as u64) << (2 * self.renderer.settings().bits + 1);
        self.drawn = Drawn { leaves, drawn, made, levels, triangles };
        speaker.say(News::Frame(Frame { image, scale, camera: None }));
        studio.took("picture", begun);
        if moves {
            let begun = Instant::now();
            self.look_ahead()?;
            studio.took("background", begun);
        } else {
            self.detail += 1;
        }
        Ok(Slice::Worked)
    }

    /// Goes on for some seconds; whether anything moves.
    fn fly(&mut self, studio: &mut Studio, seconds: f32) -> Result<bool, Error> {
        let steering = studio.steering;
        if !steering.is_still() {
            self.take_over();
            self.autopilot = None;
            self.turn(Vec2::new(steering.turn.x, steering.turn.y) * seconds);
            let roll = (steering.turn.z * seconds / TAU * 65_536.0) as i16;
            self.attitude.roll = self.attitude.roll.wrapping_add_signed(roll);
            let [right, _, forward] = self.attitude.axes();
            let go = steering.go.as_dvec3();
            let direction = right * go.x + DVec3::Y * go.y + forward * go.z;
            let way = f64::from(seconds * steering.speed);
            self.flight.fly(self.renderer.spine(), direction, way);
            return Ok(true);
        }
        if self.course == Course::Hand {
            return Ok(false);
        }
        let levels = LEVELS_A_SECOND * f64::from(seconds);
        let roughness = self.renderer.spine().surface().roughness;
        let (place, level) = match (self.course, &mut self.autopilot, &mut self.way_out) {
            (Course::Out, None, Some((approach, depth))) => {
                *depth = Depth(depth.0.saturating_sub((levels * 65_536.0) as u64));
                if *depth == Depth(0) {
                    self.course = Course::Hand;
                }
                (approach.at(*depth, roughness), depth.whole())
            }
            (course, Some(autopilot), _) => {
                self.depth =
                    if course == Course::In { self.depth + levels } else { (self.depth - levels).max(0.0) };
                if self.depth == 0.0 {
                    self.course = Course::Hand;
                }
                let depth = Depth((self.depth * 65_536.0) as u64);
                let pose = autopilot.at(self.renderer.spine(), depth);
                self.attitude = pose.attitude;
                (pose.place, depth.whole())
            }
            _ => return Ok(false),
        };
        self.flight = Flight::new(self.renderer.spine(), place, level).map_err(view::Error::from)?;
        Ok(true)
    }

    /// Prepares what is behind the views of the next seconds of a course, and does a share of the work.
    fn look_ahead(&mut self) -> Result<(), Error> {
        let frames = 64;
        if let (Course::In | Course::Out, Some(autopilot)) = (self.course, &mut self.autopilot) {
            let ahead = if self.course == Course::In { 1.0 } else { -1.0 };
            let depth = Depth(((self.depth + ahead).max(0.0) * 65_536.0) as u64);
            let pose = autopilot.at(self.renderer.spine(), depth);
            let view = View {
                place: pose.place,
                attitude: pose.attitude,
                fov: self.world.fov,
                level: depth.whole(),
            };
            match self.renderer.prepare(&view, frames) {
                Ok(_) | Err(view::Error::Buried(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(self.renderer.work()?)
    }

    fn location(&self) -> Location {
        let Distance { level, .. } = self.flight.clearance();
        Location {
            surface: self.surface,
            level,
            place: self.flight.place().clone(),
            attitude: self.attitude,
            fov: Location::nearest_fov(self.world.fov),
        }
    }

    fn view(&self) -> View {
        View::of(&self.location())
    }

    /// What is being done that takes long, if anything is.
    pub fn work(&self) -> Option<(String, u64, u64)> {
        (self.drawn == Drawn::default()).then(|| ("drawing the first picture".into(), 0, 0))
    }

    pub fn status(&self) -> WorldStatus {
        let clearance = self.flight.clearance();
        WorldStatus::Zoom {
            depth: clearance.depth(),
            level: clearance.level,
            cells: clearance.cells,
            slope: self.slope,
            code: self.location().code(),
            course: self.course,
            frozen: self.frozen,
            drawn: self.drawn,
        }
    }
}

/// Whether two worlds are the same surface, flown to the same depth: then one goes on where one is.
pub fn is_same_place(one: &World, other: &World) -> bool {
    let place = |world: &World| world.zoom.as_ref().map(|zoom| (zoom.surface(world.seed), zoom.depth));
    place(one) == place(other)
}

fn zoom_of(world: &World) -> Result<&crate::world::Zoom, Error> {
    world.zoom.as_ref().ok_or_else(|| Error::Missing("the world has no `zoom`".into()))
}

fn renderer(studio: &Studio, world: &World) -> Result<view::Renderer, Error> {
    let surface = zoom_of(world)?.surface(world.seed);
    let settings = settings(world, studio.size)?;
    let film = film(world, studio.size, DETAILS[0].0);
    let mut renderer = view::Renderer::new(&studio.gpu, surface, settings, &world.light, &film)?;
    renderer.mark(studio.marks)?;
    renderer.share_the_device();
    Ok(renderer)
}

/// How its first picture is drawn.
fn settings(world: &World, size: [u32; 2]) -> Result<view::Settings, Error> {
    let (scale, samples) = DETAILS[0];
    Ok(view::Settings { samples, ..zoom_of(world)?.settings(&film(world, size, scale), world.fov) })
}

fn film(world: &World, [width, height]: [u32; 2], scale: f32) -> Film {
    let side = |side: u32, usual: u32| {
        let side = if side == 0 { usual } else { side };
        ((side as f32 * scale) as u32).max(1)
    };
    Film { width: side(width, 640), height: side(height, 360), ..world.film }
}
