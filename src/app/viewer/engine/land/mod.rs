//! Land on the stage: it is simulated, looked at, planted and traced.

mod look;
mod overlay;
mod planting;

use self::look::{Drawing, Drawn};
pub use self::overlay::{Legend, Map, Overlay};
use super::plants::{Gardener, Plants, Selected};
use super::trace::{Ended, Trace};
use super::{Command, Means, News, Pose, Slice, Speaker, Status, Studio, Traced, WorldStatus};
use crate::app::population::{self, Sight};
use crate::app::viewer::camera::Rig;
use crate::app::{Error, keep::Keeper, land};
use crate::core::camera::Pinhole;
use crate::core::pace::SLICE;
use crate::gpu::{Image, Recorder, format::Rgba8};
use crate::plants::planting::Ground;
use crate::raster::{self, Live, Quality};
use crate::scene::{self, Film, Picture, Population, Scene, View};
use crate::terrain::{Brush, Kind, Simulation, Snapshot, Stage};
use crate::world::World;
use glam::{Vec2, Vec3};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// A cut through the land from west to east.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Where it was asked for, metres.
    pub at: Vec3,
    /// East and height, metres.
    pub points: Vec<[f64; 2]>,
    pub sea_level: f32,
}

/// Points of a [`Section`].
const SECTION: usize = 300;

/// The eye moves as long after it has been moved: land that changes leaves the device to pictures.
const LOOK: Duration = Duration::from_millis(300);

/// Device memory that strokes of the brush may take, to be taken back.
const STROKES: u64 = 256 << 20;

/// Between two glances of the host at land that changes: the eye is kept above it, and clicks meet it.
const GLANCES: Duration = Duration::from_millis(500);

pub struct Land {
    world: Arc<World>,
    simulation: Simulation,
    live: Live,
    /// The land as it was when the host last glanced at it, and whether it has changed since.
    ground: Ground,
    outdated: bool,
    glanced: Instant,
    rig: Rig,
    /// Where it was first, as the world's camera has it for the land of that time.
    started: Rig,
    playing: bool,
    /// Iterations between two pictures; 0 is as many as there is time for.
    per_picture: u32,
    /// The land before each stroke of the brush.
    strokes: Vec<Snapshot>,
    /// None until the land is finished and they have grown.
    plants: Option<Plants>,
    /// None where nothing grows, or nothing that asks where the eye is.
    gardener: Option<Gardener>,
    /// Round what ground cover has been planted.
    covered: Option<Sight>,
    /// What stands in a traced picture, and in which.
    pictured: Option<(Sight, Population)>,
    /// When the eye was last moved.
    moved: Instant,
    selected: Option<Arc<Selected>>,
    /// The land has changed since it was looked at.
    changed: bool,
    drawn: Drawn,
    drawing: Option<Drawing>,
    /// When a picture was last begun.
    begun: Instant,
    /// Seconds that a texel of a swift picture takes.
    seconds_a_texel: f64,
    overlay: Option<Overlay>,
    shown: Option<(raster::Overlay, Legend)>,
    /// Whether pictures are traced while nothing moves.
    tracing: bool,
    trace: Trace,
}

impl Land {
    /// The finished land, if it is known; the bare ground otherwise, which then changes.
    pub fn new(studio: &mut Studio, world: &Arc<World>) -> Result<Land, Error> {
        studio.session.cache = studio.cache()?;
        let mut simulation =
            Keeper::new(&studio.gpu, world, &mut studio.session).begin(&mut studio.session)?;
        if !simulation.progress().finished {
            simulation = Simulation::new(&studio.gpu, &world.plan)?;
        }
        Land::with(studio, world, simulation)
    }

    fn with(studio: &mut Studio, world: &Arc<World>, mut simulation: Simulation) -> Result<Land, Error> {
        // The base terrain at least: there is nothing to see before.
        while !simulation.progress().finished && simulation.progress().stage == Stage::Base {
            simulation.step(SLICE)?;
        }
        let shown = simulation.land()?;
        let ground = ground(studio, &shown)?;
        let scene = land::scene(world, shown, NO_CAMERA, Population::default());
        let renderer = studio.renderer()?;
        let mut land = Land {
            world: world.clone(),
            live: Live::new(&studio.gpu, renderer, scene)?,
            ground,
            outdated: false,
            glanced: Instant::now(),
            simulation,
            rig: Rig::default(),
            started: Rig::default(),
            playing: true,
            per_picture: 0,
            strokes: Vec::new(),
            plants: None,
            gardener: None,
            covered: None,
            pictured: None,
            moved: Instant::now(),
            selected: None,
            changed: false,
            drawn: Drawn::Not,
            drawing: None,
            begun: Instant::now(),
            seconds_a_texel: 3e-7,
            overlay: None,
            shown: None,
            tracing: false,
            trace: Trace::default(),
        };
        land.start(studio)?;
        Ok(land)
    }

    /// Goes where the world's camera is.
    fn start(&mut self, studio: &Studio) -> Result<(), Error> {
        self.rig = self.starting_rig(studio)?;
        self.started = self.rig;
        Ok(())
    }

    /// The eye as the world's camera has it.
    fn starting_rig(&self, studio: &Studio) -> Result<Rig, Error> {
        let camera = land::camera(&studio.gpu, &self.world, &self.simulation)?;
        let film = self.film(studio.size);
        Ok(Rig::of(&population::seen_from(&studio.gpu, &self.simulation, &camera, &film)?))
    }

    pub fn world(&self) -> &World {
        &self.world
    }

    /// What is seen in a picture of this size.
    pub fn camera(&self, film: &Film) -> Pinhole {
        self.rig.pinhole(self.world.fov, film.width as f32 / film.height as f32)
    }

    /// The same as a command line has it: what is traced or saved is the picture that it makes.
    pub fn written_camera(&self, film: &Film) -> Pinhole {
        self.rig.written().pinhole(self.world.fov, film.width as f32 / film.height as f32)
    }

    pub fn film(&self, [width, height]: [u32; 2]) -> Film {
        // A window that has no size yet is thought of as usual.
        let [width, height] = if width * height == 0 { [16, 9] } else { [width, height] };
        Film { width, height, ..self.world.film }
    }

    /// The same world with changes.
    pub fn edit(&mut self, studio: &mut Studio, speaker: &Speaker, world: &Arc<World>) -> Result<(), Error> {
        if self.tracing && self.trace.is_shown() && self.is_developed_as(world) {
            self.develop(world);
            return Ok(());
        }
        let before = self.world.clone();
        if before.plan != world.plan {
            if !self.simulation.retune(&world.plan)? {
                // What is over can't be changed any more.
                let again = Land::new(studio, world)?;
                let why = "that is settled before the land comes so far: it begins again";
                speaker.say(News::Said(why.into()));
                return self.begin_again(again);
            }
            // Plants stand where the land was.
            self.uproot();
            self.changed = true;
        }
        // Not before what may fail: it would seem to be done when it is tried again.
        self.world = world.clone();
        if before.light != world.light {
            self.live.set_light(world.light.clone())?;
        }
        if before.sea != world.sea {
            self.live.set_sea(world.sea);
        }
        if before.surface != world.surface {
            self.live.set_surface(world.surface.clone());
        }
        if !same_plants(&before, world) {
            self.uproot();
            self.live.set_population(Population::default());
        }
        if !same_scene(&before, world) {
            self.trace.forget();
        }
        if before.viewpoint != world.viewpoint {
            self.start(studio)?;
        }
        self.drawing = None;
        self.look_again();
        Ok(())
    }

    /// Whether other pictures of such a world differ only in how light becomes colours, or in how many samples they have.
    pub fn is_developed_as(&self, world: &World) -> bool {
        let own = &self.world;
        let same_view = own.viewpoint == world.viewpoint && own.fov == world.fov;
        world.zoom.is_none() && same_view && own.tracing == world.tracing && same_scene(own, world)
    }

    /// Takes a world that is [the same](Self::is_developed_as) but for that.
    pub fn develop(&mut self, world: &Arc<World>) {
        self.world = world.clone();
    }

    /// What is seen has changed.
    pub fn look_again(&mut self) {
        self.trace.traced = None;
        self.drawn = Drawn::Not;
    }

    /// Nothing stands on the ground, until it has been planted again.
    fn uproot(&mut self) {
        (self.plants, self.gardener, self.selected) = (None, None, None);
        (self.covered, self.pictured) = (None, None);
        self.trace.forget();
    }

    pub fn obey(&mut self, studio: &mut Studio, speaker: &Speaker, command: Command) -> Result<(), Error> {
        match command {
            Command::Turn(by) => self.move_rig(|rig, _| rig.turn(by)),
            Command::Orbit(by) => {
                let point = self.looked_at();
                self.move_rig(|rig, ground| rig.orbit(point, by, ground));
            }
            Command::Approach(share) => {
                let point = self.looked_at();
                self.move_rig(|rig, ground| rig.approach(point, share, ground));
            }
            Command::FrameAll => {
                let framing = self.framing(studio);
                self.move_rig(|rig, _| *rig = framing);
            }
            Command::GoTo(Pose::Land(rig)) => {
                self.move_rig(|own, _| *own = rig);
            }
            Command::Play(playing) => self.playing = playing,
            Command::Step => {
                self.playing = false;
                if !self.simulation.progress().finished {
                    self.simulate(studio, 1)?;
                }
            }
            Command::Restart => self.restart(studio)?,
            Command::Stroke => self.begin_stroke()?,
            Command::Paint { kind, at, radius, strength } => {
                if let Some(point) = self.under(studio, at) {
                    let brush = Brush { kind, at: [point.x, point.z], radius, strength };
                    self.simulation.brush(brush)?;
                    self.uproot();
                    self.changed = true;
                    self.look_again();
                }
            }
            Command::TakeStrokeBack => {
                if let Some(before) = self.strokes.pop() {
                    if self.simulation.restore(&before)? {
                        self.uproot();
                        self.changed = true;
                        self.look_again();
                    } else {
                        let why = "the land does not come by there any more: this stroke stays";
                        speaker.say(News::Said(why.into()));
                    }
                }
            }
            Command::Section(at) => {
                let section = self.under(studio, at).map(|at| self.section(at));
                speaker.say(News::Section(section));
            }
            Command::PerPicture(iterations) => self.per_picture = iterations,
            Command::Enable(process, on) => self.simulation.enable(process, on),
            Command::Select(at) => {
                let index = at.and_then(|at| self.seen_at(studio, at));
                let plants = self.plants.as_ref();
                self.selected = index.and_then(|index| plants?.tell(index)).map(Arc::new);
            }
            Command::Overlay(overlay) => {
                // It lies over no picture that is traced.
                self.tracing &= overlay.is_none();
                (self.overlay, self.shown) = (overlay, None);
                self.drawing = None;
                self.look_again();
            }
            Command::Trace(true) => {
                self.tracing = true;
                // Land that changes is not traced.
                self.playing &= self.simulation.progress().finished;
            }
            Command::Trace(false) => {
                self.tracing = false;
                // What was traced is kept, and goes on if the eye has not moved.
                self.drawn = self.drawn.min(Drawn::Swift);
            }
            Command::Picture(path) => {
                let written = match self.trace.save(&path) {
                    Some(written) => written,
                    None => self.write_picture(studio, speaker, &path),
                };
                speaker.tell(written);
            }
            _ => {}
        }
        Ok(())
    }

    /// Writes what is seen, drawn as `terrane render` would, as .exr or .png.
    fn write_picture(&self, studio: &mut Studio, speaker: &Speaker, path: &Path) -> Result<String, Error> {
        let film = self.film(studio.size);
        super::write_picture(path, &self.picture(studio, speaker, &film)?, &film)
    }

    /// The plant that is seen at a place of the picture.
    fn seen_at(&self, studio: &Studio, at: [f32; 2]) -> Option<usize> {
        let film = self.film(studio.size);
        let eye = self.rig.eye;
        let ground = |ray: Vec3| self.met(ray).map_or(f32::INFINITY, |point| point.distance(eye));
        self.plants.as_ref()?.seen_at(at, &self.camera(&film), &film, ground)
    }

    /// Programs have been replaced: what draws is made anew from them, and the land begins again if they `make_land`.
    #[cfg(feature = "reload")]
    pub fn reprogram(&mut self, studio: &mut Studio, make_land: bool) -> Result<(), Error> {
        if make_land {
            studio.session.cache = studio.cache()?;
            return self.restart(studio);
        }
        let renderer = studio.renderer()?;
        self.live = Live::new(&studio.gpu, renderer, self.live.scene().clone())?;
        (self.trace, self.drawing, self.shown) = (Trace::default(), None, None);
        self.look_again();
        Ok(())
    }

    fn restart(&mut self, studio: &mut Studio) -> Result<(), Error> {
        let simulation = Simulation::new(&studio.gpu, &self.world.plan)?;
        let again = Land::with(studio, &self.world.clone(), simulation)?;
        self.begin_again(again)
    }

    /// Other land in its place, looked at and made as this one was.
    fn begin_again(&mut self, again: Land) -> Result<(), Error> {
        let off: Vec<Kind> = self.off().collect();
        let (rig, playing, overlay, per_picture) = (self.rig, self.playing, self.overlay, self.per_picture);
        let tracing = self.tracing;
        let same_eye = self.world.viewpoint == again.world.viewpoint;
        let moved = self.rig != self.started;
        *self = again;
        (self.playing, self.overlay, self.per_picture) = (playing, overlay, per_picture);
        self.tracing = tracing;
        if same_eye && moved {
            self.rig = rig;
        }
        off.into_iter().for_each(|process| self.simulation.enable(process, false));
        Ok(())
    }

    fn off(&self) -> impl Iterator<Item = Kind> + '_ {
        Kind::ALL.into_iter().filter(|process| !self.simulation.is_enabled(*process))
    }

    /// Remembers the land as it is before the brush touches it.
    fn begin_stroke(&mut self) -> Result<(), Error> {
        self.strokes.extend(self.simulation.snapshot()?);
        while self.strokes.iter().map(Snapshot::bytes).sum::<u64>() > STROKES && self.strokes.len() > 1 {
            self.strokes.remove(0);
        }
        Ok(())
    }

    /// The point of the ground that is seen at a place of the picture, which goes from 0 to 1 to the right and down.
    fn under(&self, studio: &Studio, [right, down]: [f32; 2]) -> Option<Vec3> {
        self.met(self.camera(&self.film(studio.size)).ray(right, down))
    }

    fn section(&self, at: Vec3) -> Section {
        let half = self.simulation.plan().grid.extent / 2.0;
        let point = |index: usize| {
            let east = half * (2.0 * index as f32 / (SECTION - 1) as f32 - 1.0);
            [f64::from(east), f64::from(self.ground.height_at(Vec2::new(east, at.z)))]
        };
        Section { at, points: (0..SECTION).map(point).collect(), sea_level: self.simulation.sea_level_now() }
    }

    fn move_rig(&mut self, by: impl FnOnce(&mut Rig, &dyn Fn(Vec2) -> f32)) {
        let ground = &self.ground;
        let sea = self.simulation.sea_level();
        by(&mut self.rig, &|at| floor(ground, sea, at));
        self.moved = Instant::now();
        self.look_again();
    }

    /// The point of the ground in the middle of the picture, or one as far as the ground is below.
    fn looked_at(&self) -> Vec3 {
        let forward = self.rig.forward();
        self.met(forward).unwrap_or(self.rig.eye + forward * self.simulation.plan().grid.extent / 2.0)
    }

    /// Where a look from the eye meets ground or sea.
    fn met(&self, forward: Vec3) -> Option<Vec3> {
        let eye = self.rig.eye;
        let sea = self.simulation.sea_level();
        let extent = self.simulation.plan().grid.extent;
        let step = extent / 1000.0;
        let mut range = step;
        while range < 4.0 * extent {
            let at = eye + forward * range;
            if at.y <= floor(&self.ground, sea, Vec2::new(at.x, at.z)) {
                return Some(at);
            }
            range += step;
        }
        None
    }

    /// All of the land in the picture, from where the eye looks.
    fn framing(&self, studio: &Studio) -> Rig {
        let film = self.film(studio.size);
        let aspect = film.width as f32 / film.height as f32;
        let rig = Rig { elevation: self.rig.elevation.min(-0.2), roll: 0.0, ..self.rig };
        let camera = Pinhole::frame(&self.ground.land(), rig.forward(), 1.05, self.world.fov, aspect);
        Rig { eye: camera.eye, ..rig }
    }

    pub fn slice(&mut self, (studio, speaker, inbox, load): Means<'_>) -> Result<Slice, Error> {
        let seconds = studio.held();
        let steered = !studio.steering.is_still();
        if steered {
            let steering = studio.steering;
            self.move_rig(|rig, ground| rig.steer(&steering, seconds, ground));
        }
        let runs = self.playing && !self.simulation.progress().finished;
        // Pictures are for those who watch: one is finished before the land goes on, if that has its own pace, or while the eye moves.
        let looks = self.moved.elapsed() < LOOK && self.drawing.is_some();
        let waits = looks || self.per_picture > 0 && (self.drawing.is_some() || self.changed);
        if runs && !waits {
            self.simulate(studio, self.per_picture)?;
        }
        if self.outdated && (!runs || self.glanced.elapsed() >= GLANCES) {
            let begun = Instant::now();
            self.ground = ground(studio, &self.live.scene().ground)?;
            (self.outdated, self.glanced) = (false, Instant::now());
            studio.took("heights", begun);
            return Ok(Slice::Worked);
        }
        let moves = runs || steered;
        if self.simulation.progress().finished && !self.changed {
            self.plant(studio, speaker, moves)?;
        }
        if self.look(studio, speaker, moves)? || moves {
            return Ok(Slice::Worked);
        }
        let is_busy = |gardener: &Gardener| gardener.is_busy() || self.bare(studio).is_some();
        if self.gardener.as_ref().is_some_and(is_busy) {
            return Ok(wait(inbox));
        }
        if self.tracing {
            return self.trace((studio, speaker, inbox, load));
        }
        Ok(Slice::Idle)
    }

    /// Runs the simulation for a slice, at most so many iterations (0 is any number).
    fn simulate(&mut self, studio: &mut Studio, most: u32) -> Result<(), Error> {
        let begun = Instant::now();
        let before = self.simulation.progress();
        let after = match most {
            0 => self.simulation.step(SLICE)?,
            most => self.simulation.step_iterations(most, 4 * SLICE)?,
        };
        studio.took(before.stage.name(), begun);
        self.changed = true;
        // An eye that nobody has moved sees the finished land as `terrane render` does.
        if after.finished && self.rig == self.started {
            self.start(studio)?;
        }
        if after.finished && !self.simulation.touched() {
            let session = &mut studio.session;
            Keeper::new(&studio.gpu, &self.world, session).keep(&self.simulation, session);
        }
        Ok(())
    }

    fn trace(&mut self, means: Means<'_>) -> Result<Slice, Error> {
        let live = self.live.scene();
        let population = self.pictured.as_ref().map_or(&live.population, |(_, population)| population);
        let scene = Scene { camera: NO_CAMERA, population: population.clone(), ..live.clone() };
        let mut trace = std::mem::take(&mut self.trace);
        let ended = trace.run(means, self, &scene);
        self.trace = trace;
        // What fails would fail again.
        self.tracing &= ended.is_ok();
        Ok(match ended? {
            Ended::Done => Slice::Idle,
            Ended::By(command) => Slice::Interrupted(Box::new(command)),
            Ended::Gone => Slice::Gone,
        })
    }

    /// As `terrane render` makes it from here, to the last bit where the same stands on the ground: so it has the same tiles, though each
    /// is a longer work than those of the window.
    fn picture(&self, studio: &mut Studio, speaker: &Speaker, film: &Film) -> Result<Picture, Error> {
        let camera = scene::Camera { view: self.rig.written().view(), fov: self.world.fov };
        let scene = Scene { camera, ..self.live.scene().clone() };
        let renderer = studio.renderer()?;
        let mut drawing = renderer.begin(&scene, film, Quality::default())?;
        while drawing.step()? {
            let (done, of) = drawing.progress();
            let work = Some(("drawing the picture".into(), done as u64, of as u64));
            let status = super::status(studio, self.counts());
            speaker.say(News::Status(Box::new(Status { world: self.status(), work, ..status })));
        }
        Ok(drawing.into_picture())
    }

    pub fn status(&self) -> WorldStatus {
        self.status_with(self.trace.traced)
    }

    pub fn status_with(&self, traced: Option<Traced>) -> WorldStatus {
        WorldStatus::Land {
            rig: self.rig,
            progress: self.simulation.progress(),
            playing: self.playing,
            off: self.off().collect(),
            strokes: self.strokes.len(),
            per_picture: self.per_picture,
            tracing: self.tracing,
            legend: self.shown.as_ref().map(|(_, legend)| *legend),
            traced,
            census: self.plants.as_ref().map(|plants| plants.census.clone()).unwrap_or_default(),
            selected: self.selected.clone(),
            level: self.selected.as_ref().and_then(|selected| self.live.level_of(selected.instance)),
        }
    }

    /// What is being done that takes long, if anything is.
    pub fn work(&self) -> Option<(String, u64, u64)> {
        let (stage, done, of) = self.gardener.as_ref()?.work()?;
        Some((if self.plants.is_some() { "ground cover".into() } else { stage }, done, of))
    }

    /// Plants, and their triangles.
    pub fn counts(&self) -> (usize, u64) {
        self.plants.as_ref().map(Plants::counts).unwrap_or_default()
    }
}

/// Time between two looks at what another thread does.
const POLL: Duration = Duration::from_millis(30);

/// Waits for a command, but not for long.
fn wait(inbox: &Receiver<Command>) -> Slice {
    match inbox.recv_timeout(POLL) {
        Ok(command) => Slice::Interrupted(Box::new(command)),
        Err(RecvTimeoutError::Timeout) => Slice::Worked,
        Err(RecvTimeoutError::Disconnected) => Slice::Gone,
    }
}

/// Of scenes that are looked at through a [`Rig`].
const NO_CAMERA: scene::Camera =
    scene::Camera { view: View::FrameIsland { azimuth: 0.0, elevation: 0.5, distance: 1.0 }, fov: 1.0 };

/// Whether two worlds look the same, from wherever they are seen.
fn same_scene(one: &World, other: &World) -> bool {
    let same_land = one.plan == other.plan && one.surface == other.surface && one.sea == other.sea;
    same_land && one.light == other.light && same_plants(one, other)
}

fn same_plants(one: &World, other: &World) -> bool {
    let same_text = !["plants", "species", "models"].into_iter().any(|key| differ(one, other, key));
    one.seed == other.seed && same_text
}

/// Whether two worlds say different things in a section.
fn differ(one: &World, other: &World, section: &str) -> bool {
    let text = |world: &World| world.document.get(section).map(ToString::to_string);
    text(one) != text(other)
}

/// Brings a picture to the device, developed.
pub fn show(studio: &mut Studio, picture: &Picture, film: &Film) -> Result<Image<Rgba8>, Error> {
    let image = studio.image([picture.width, picture.height])?;
    let developed = picture.developed(film.tone_map);
    let texels: Vec<[u8; 4]> = developed.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
    let mut rec = Recorder::new(&studio.gpu);
    rec.upload(&image, &texels);
    rec.submit()?.wait()?;
    Ok(image)
}

/// Heights of the land as it is shown, on the host.
fn ground(studio: &Studio, land: &scene::Ground) -> Result<Ground, Error> {
    let mut rec = Recorder::new(&studio.gpu);
    let heights = rec.download(&land.height);
    let heights = heights.take(&rec.submit()?.wait()?);
    Ok(Ground::new(land.grid, land.sea_level, heights))
}

/// What can't be flown through: ground, and the sea.
fn floor(ground: &Ground, sea: f32, at: Vec2) -> f32 {
    let half = ground.grid.extent / 2.0;
    if at.abs().max_element() > half { sea } else { ground.height_at([at.x, at.y].into()).max(sea) }
}
