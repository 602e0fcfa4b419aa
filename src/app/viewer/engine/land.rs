//! Land on the stage: it is simulated, looked at, planted and traced.

use super::trace::{Ended, Trace};
use super::{Command, Frame, News, Pose, Slice, Speaker, Studio, Traced, WorldStatus};
use crate::app::viewer::camera::Rig;
use crate::app::{Error, keep::{self, Keeper}, land, population};
use crate::core::camera::Pinhole;
use crate::formats;
use crate::gpu::{Recorder, format::Rgba8, Image};
use crate::plants::planting::Ground;
use crate::raster::{self, Quality};
use crate::scene::{Film, Picture, Population, Scene, View};
use crate::terrain::{Layer, Simulation};
use crate::world::World;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// What can be left out of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Process {
    Hydraulic,
    Thermal,
    Seabed,
    Reef,
}

/// A layer of the land over the picture, in false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlay {
    pub layer: Layer,
    /// The values that the ends of the colours stand for.
    pub range: [f32; 2],
    pub opacity: f32,
}

/// Work between two looks at the inbox.
const SLICE: Duration = Duration::from_millis(30);

/// Between two pictures while land changes.
const CHANGING: Duration = Duration::from_millis(60);

/// Texels for one of the window's pixels, along a side, and samples along a side of a texel: from a picture that moves to
/// one that stands still.
const DETAILS: [(f32, u32); 3] = [(0.4, 1), (1.0, 1), (1.0, 2)];

pub struct Land {
    world: Arc<World>,
    simulation: Simulation,
    renderer: raster::Renderer,
    /// The land as it was when it was last looked at.
    ground: Ground,
    rig: Rig,
    playing: bool,
    steps: u32,
    off: Vec<Process>,
    population: Option<Population>,
    /// What the picture shows is not what there is.
    stale: Stale,
    /// Of [`DETAILS`], the next that is to be drawn.
    detail: usize,
    drawn: Instant,
    tracing: bool,
    trace: Trace,
    /// Whether the land is what the world's file makes.
    pristine: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Stale {
    ground: bool,
    view: bool,
}

impl Land {
    /// The finished land, if it is known; the bare ground otherwise, which then changes.
    pub fn new(studio: &mut Studio, world: &Arc<World>) -> Result<Land, Error> {
        studio.session.cache = keep::cache(&mut studio.session)?;
        let mut simulation = Keeper::new(&studio.gpu, world, &mut studio.session).begin(&mut studio.session)?;
        if !simulation.progress().finished {
            simulation = Simulation::new(&studio.gpu, &world.plan)?;
        }
        Land::with(studio, world, simulation)
    }

    fn with(studio: &mut Studio, world: &Arc<World>, mut simulation: Simulation) -> Result<Land, Error> {
        // The base terrain at least: there is nothing to see before.
        if !simulation.progress().finished {
            simulation.step(Duration::ZERO)?;
        }
        let ground = ground(studio, &simulation)?;
        let mut land = Land {
            world: world.clone(),
            renderer: raster::Renderer::new(&studio.gpu)?,
            ground,
            simulation,
            rig: Rig::default(),
            playing: true,
            steps: 0,
            off: Vec::new(),
            population: None,
            stale: Stale { ground: true, view: true },
            detail: 0,
            drawn: Instant::now(),
            tracing: false,
            trace: Trace::default(),
            pristine: true,
        };
        land.rig = land.starting_rig(studio)?;
        Ok(land)
    }

    /// Whether nothing can be shown any more.
    pub fn is_hopeless(&self) -> bool {
        false
    }

    /// The eye as the world's camera has it.
    fn starting_rig(&self, studio: &Studio) -> Result<Rig, Error> {
        let camera = land::camera(&studio.gpu, &self.world, &self.simulation)?;
        let film = self.film(studio.size);
        let camera = match camera.view {
            View::LookAt { .. } | View::FrameIsland { .. } => {
                population::seen_from(&studio.gpu, &self.simulation, &camera, &film)?
            }
        };
        Ok(Rig::of(&camera))
    }

    pub fn world(&self) -> &World {
        &self.world
    }

    /// What is seen in a picture of this size.
    pub fn camera(&self, film: &Film) -> Pinhole {
        self.rig.pinhole(self.world.fov, film.width as f32 / film.height as f32)
    }

    pub fn film(&self, [width, height]: [u32; 2]) -> Film {
        // A window that has no size yet is thought of as usual.
        let [width, height] = if width * height == 0 { [16, 9] } else { [width, height] };
        Film { width, height, ..self.world.film }
    }

    /// The same world with changes.
    pub fn edit(&mut self, studio: &mut Studio, world: &Arc<World>) -> Result<(), Error> {
        let same_land = self.world.plan == world.plan;
        let same_eye = self.world.viewpoint == world.viewpoint;
        let same_plants = self.world.document.get("plants").map(ToString::to_string)
            == world.document.get("plants").map(ToString::to_string)
            && self.world.document.get("species").map(ToString::to_string)
                == world.document.get("species").map(ToString::to_string);
        let before = std::mem::replace(&mut self.world, world.clone());
        if !same_land {
            let (rig, playing) = (self.rig, self.playing);
            *self = Land::new(studio, world)?;
            (self.rig, self.playing) = (rig, playing);
        }
        if !same_plants {
            self.population = None;
        }
        if !same_eye || before.fov != world.fov {
            self.rig = self.starting_rig(studio)?;
        }
        self.stale.ground = true;
        self.trace.forget();
        self.look_again();
        Ok(())
    }

    /// What is seen has changed.
    pub fn look_again(&mut self) {
        self.trace.traced = None;
        self.stale.view = true;
        self.detail = 0;
        self.tracing = false;
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
                self.rig = self.framing(studio);
                self.look_again();
            }
            Command::GoTo(Pose::Land(rig)) => {
                self.rig = rig;
                self.look_again();
            }
            Command::Play(playing) => self.playing = playing,
            Command::Step => {
                self.playing = false;
                self.simulation.step(Duration::ZERO)?;
                self.stale.ground = true;
                self.look_again();
            }
            Command::Restart => {
                crate::app::interrupt::cancel(false);
                let rig = self.rig;
                let simulation = Simulation::new(&studio.gpu, &self.world.plan)?;
                *self = Land::with(studio, &self.world.clone(), simulation)?;
                self.rig = rig;
            }
            Command::PerPicture(steps) => self.steps = steps,
            Command::Enable(process, on) => {
                self.off.retain(|other| *other != process);
                if !on {
                    self.off.push(process);
                }
                self.pristine = false;
            }
            Command::Trace(on) => self.tracing = on,
            Command::Picture(path) => {
                let scene = self.scene(studio)?;
                let film = self.film(studio.size);
                let picture = self.picture(&scene, &film, 2)?;
                let rgb = picture.developed(film.tone_map);
                let written = formats::png::write_picture(&path, [film.width, film.height], &rgb)?;
                let _ = written;
                speaker.say(News::Said(format!("wrote {}", path.display())));
            }
            _ => {}
        }
        Ok(())
    }

    fn move_rig(&mut self, by: impl FnOnce(&mut Rig, &dyn Fn(Vec2) -> f32)) {
        let ground = &self.ground;
        let sea = self.simulation.sea_level();
        by(&mut self.rig, &|at| floor(ground, sea, at));
        self.look_again();
    }

    /// The point of the ground in the middle of the picture, or one as far as the ground is below.
    fn looked_at(&self) -> Vec3 {
        let (eye, forward) = (self.rig.eye, self.rig.forward());
        let sea = self.simulation.sea_level();
        let extent = self.simulation.plan().grid.extent;
        let step = extent / 1000.0;
        let mut range = step;
        while range < 4.0 * extent {
            let at = eye + forward * range;
            if at.y <= floor(&self.ground, sea, Vec2::new(at.x, at.z)) {
                return at;
            }
            range += step;
        }
        eye + forward * extent / 2.0
    }

    /// All of the land in the picture, from where the eye looks.
    fn framing(&self, studio: &Studio) -> Rig {
        let film = self.film(studio.size);
        let aspect = film.width as f32 / film.height as f32;
        let rig = Rig { elevation: self.rig.elevation.min(-0.2), roll: 0.0, ..self.rig };
        let camera = Pinhole::frame(&self.ground.land(), rig.forward(), 1.05, self.world.fov, aspect);
        Rig { eye: camera.eye, ..rig }
    }

    pub fn slice(
        &mut self,
        (studio, speaker, inbox): (&mut Studio, &Speaker, &Receiver<Command>),
    ) -> Result<Slice, Error> {
        if self.tracing {
            return self.trace((studio, speaker, inbox));
        }
        let seconds = studio.held();
        if !studio.steering.is_still() {
            let steering = studio.steering;
            self.move_rig(|rig, ground| rig.steer(&steering, seconds, ground));
        }
        let runs = self.playing && !self.simulation.progress().finished;
        if runs {
            let begun = Instant::now();
            let before = self.simulation.progress();
            let after = self.simulation.step(SLICE)?;
            studio.took(before.stage.name(), begun);
            self.trace.forget();
            self.stale.ground = true;
            self.detail = 0;
            if after.finished && self.pristine {
                Keeper::new(&studio.gpu, &self.world, &mut studio.session).keep(&self.simulation, &mut studio.session);
            }
        }
        let finished = self.simulation.progress().finished;
        if finished && self.population.is_none() {
            self.plant(studio)?;
            self.trace.forget();
            self.stale.ground = true;
            self.look_again();
        }
        let wanted = if runs { self.drawn.elapsed() >= CHANGING } else { self.detail < DETAILS.len() };
        let moves = runs || !studio.steering.is_still();
        if self.stale.view || wanted {
            let detail = if self.stale.view || moves { 0 } else { self.detail };
            self.draw(studio, speaker, detail)?;
            self.detail = if runs { 0 } else { detail + 1 };
            self.stale.view = false;
            return Ok(Slice::Worked);
        }
        Ok(if moves { Slice::Worked } else { Slice::Idle })
    }

    fn trace(&mut self, means: (&mut Studio, &Speaker, &Receiver<Command>)) -> Result<Slice, Error> {
        self.tracing = false;
        let scene = self.scene(means.0)?;
        let mut trace = std::mem::take(&mut self.trace);
        let ended = trace.run(means, self, &scene, self.world.samples);
        self.trace = trace;
        Ok(match ended? {
            Ended::Done => Slice::Idle,
            Ended::By(command) => Slice::Interrupted(Box::new(command)),
            Ended::Gone => Slice::Gone,
        })
    }

    fn plant(&mut self, studio: &mut Studio) -> Result<(), Error> {
        let camera = land::camera(&studio.gpu, &self.world, &self.simulation)?;
        let film = self.film(studio.size);
        let begun = Instant::now();
        let population =
            population::populate(&studio.gpu, &self.world, &self.simulation, &camera, &film, &mut studio.session)?;
        studio.took("planting", begun);
        self.population = Some(population);
        Ok(())
    }

    fn scene(&mut self, studio: &Studio) -> Result<Scene, Error> {
        let _ = studio;
        let eye = self.rig.eye;
        let camera = crate::scene::Camera {
            view: View::LookAt { position: eye, target: eye + self.rig.forward() * 100.0 },
            fov: self.world.fov,
        };
        let population = self.population.clone().unwrap_or_default();
        Ok(land::scene(&self.world, self.simulation.land()?, camera, population))
    }

    fn picture(&self, scene: &Scene, film: &Film, samples: u32) -> Result<Picture, Error> {
        Ok(self.renderer.render(scene, film, Quality { samples, tile: 4096 })?)
    }

    fn draw(&mut self, studio: &mut Studio, speaker: &Speaker, detail: usize) -> Result<(), Error> {
        let (scale, samples) = DETAILS[detail.min(DETAILS.len() - 1)];
        let begun = Instant::now();
        if std::mem::take(&mut self.stale.ground) {
            self.ground = ground(studio, &self.simulation)?;
        }
        let size = studio.size.map(|side| ((side as f32 * scale) as u32).max(1));
        let film = self.film(size);
        let scene = self.scene(studio)?;
        let picture = self.picture(&scene, &film, samples)?;
        let image = show(studio, &picture, &film)?;
        speaker.say(News::Frame(Frame { image, scale }));
        self.drawn = Instant::now();
        studio.took("picture", begun);
        Ok(())
    }

    pub fn status(&self) -> WorldStatus {
        self.status_with(self.trace.traced)
    }

    pub fn status_with(&self, traced: Option<Traced>) -> WorldStatus {
        WorldStatus::Land {
            rig: self.rig,
            progress: self.simulation.progress(),
            playing: self.playing,
            off: self.off.clone(),
            traced,
        }
    }

    /// Plants, and their triangles.
    pub fn counts(&self) -> (usize, u64) {
        let Some(population) = &self.population else { return (0, 0) };
        let triangles = |model: &Arc<crate::scene::Model>| {
            model.levels.first().map_or(0, |level| level.triangles() as u64)
        };
        let each: Vec<u64> = population.models.iter().map(triangles).collect();
        let all = population.instances.iter().map(|instance| each[instance.model as usize]).sum();
        (population.instances.len(), all)
    }
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

/// The land as it is now, on the host.
fn ground(studio: &Studio, simulation: &Simulation) -> Result<Ground, Error> {
    let mut rec = Recorder::new(&studio.gpu);
    let heights = rec.download(&simulation.layer(Layer::Height)?);
    let heights = heights.take(&rec.submit()?.wait()?);
    Ok(Ground::new(simulation.plan().grid, simulation.sea_level(), heights))
}

/// What can't be flown through: ground, and the sea.
fn floor(ground: &Ground, sea: f32, at: Vec2) -> f32 {
    let half = ground.grid.extent / 2.0;
    if at.abs().max_element() > half { sea } else { ground.height_at([at.x, at.y].into()).max(sea) }
}
