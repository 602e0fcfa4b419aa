//! The engine: a thread that makes the world and draws it, in slices of some 12 ms, between which it listens. So the window never
//! waits for a world.
//!
//! Commands go in, news come out; nothing is shared but pictures, which are never written while anybody has them.

mod land;
mod plants;
mod trace;
mod zoom;

pub use land::{Legend, Map, Overlay, Section};
pub use plants::{Census, Selected};
pub use zoom::{Course, Drawn};

use super::camera::{Rig, Steering};
use crate::app::{Error, Session, interrupt, keep, progress::Progress, report::Report};
use crate::core::camera::Pinhole;
use crate::formats;
use crate::gpu::{Gpu, Image, MessageLog, Usage, format::Rgba8};
use crate::raster;
use crate::scene::{Film, Picture};
use crate::terrain::{self, BrushKind, Kind};
use crate::trace::Tracer;
use crate::world::{World, cache::Cache};
use crate::zoom::marks::Marks;
use glam::Vec2;
use land::Land;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvError, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zoom::Zoom;

/// What the window wants.
#[derive(Clone, Debug)]
pub enum Command {
    /// To see a world from its beginning.
    Open(Arc<World>),
    /// To see what has become of the same world.
    Edit(Arc<World>),
    /// Pictures of this size, pixels; none if a side is 0.
    Size([u32; 2]),
    /// What is held down from now on.
    Steer(Steering),
    /// To look to the right and up, radians.
    Turn(Vec2),
    /// To move round what is in the middle, radians.
    Orbit(Vec2),
    /// To come nearer to what is in the middle, by this share of the way.
    Approach(f32),
    /// To see all of it.
    FrameAll,
    /// To be there.
    GoTo(Pose),
    Play(bool),
    /// One iteration, or one frame.
    Step,
    Restart,
    /// Iterations between two pictures; 0 is as many as there is time for.
    PerPicture(u32),
    Enable(Kind, bool),
    /// The brush is set to the land.
    Stroke,
    /// It touches what is seen at a place of the picture, which goes from 0 to 1 to the right and down.
    Paint {
        kind: BrushKind,
        at: [f32; 2],
        radius: f32,
        strength: f32,
    },
    TakeStrokeBack,
    /// A cut through what is seen at such a place.
    Section([f32; 2]),
    /// The plant that is seen at such a place; none for none.
    Select(Option<[f32; 2]>),
    Overlay(Option<Overlay>),
    /// Path tracing from where the eye is, whenever nothing moves.
    Trace(bool),
    /// Writes what is seen as a picture.
    Picture(PathBuf),
    Course(Course),
    /// What pictures of a zoom show beside its surface.
    Mark(Marks),
    /// Its tiles stay those that are seen from where the eye is.
    Freeze(bool),
    /// Programs have been replaced, and perhaps some that make land.
    #[cfg(feature = "reload")]
    Reprogram {
        land: bool,
    },
    Quit,
}

/// Where somebody is in a world.
#[derive(Clone, Debug, PartialEq)]
pub enum Pose {
    Land(Rig),
    /// A location code.
    Zoom(String),
}

/// What has happened.
#[derive(Debug)]
pub enum News {
    /// From here on it is of the world that was to be opened.
    Opened,
    /// There is a newer picture.
    Frame(Frame),
    Status(Box<Status>),
    Section(Option<Section>),
    /// A sentence for the user.
    Said(String),
    /// One for the user to know.
    Warned(String),
    /// Something failed; the world is as it was.
    Failed(String),
    /// The engine has ended.
    Ended(Error),
}

/// A picture of the world.
#[derive(Clone, Debug)]
pub struct Frame {
    pub image: Image<Rgba8>,
    /// Texels of it for one of the window's pixels; less than 1 while something moves.
    pub scale: f32,
    /// What it is seen through, where that is in a world of metres.
    pub camera: Option<Pinhole>,
}

/// How things are.
#[derive(Clone, Debug, Default)]
pub struct Status {
    pub world: WorldStatus,
    /// A long work: what, how much is done, of how much.
    pub work: Option<(String, u64, u64)>,
    /// Milliseconds of the last of each kind of work.
    pub timings: Vec<(&'static str, f32)>,
    /// Milliseconds that the device needed for the passes of the last picture.
    pub passes: Vec<(&'static str, f32)>,
    pub memory: Usage,
    pub plants: usize,
    pub triangles: u64,
}

#[derive(Clone, Debug, Default)]
pub enum WorldStatus {
    #[default]
    None,
    Land {
        rig: Rig,
        progress: terrain::Progress,
        playing: bool,
        off: Vec<Kind>,
        /// Strokes of the brush that can be taken back.
        strokes: usize,
        per_picture: u32,
        legend: Option<Legend>,
        tracing: bool,
        traced: Option<Traced>,
        /// How many plants there are of each model.
        census: Arc<[Census]>,
        selected: Option<Arc<Selected>>,
        /// The level of detail that the one which is selected is drawn in.
        level: Option<usize>,
    },
    Zoom {
        depth: f64,
        level: u32,
        /// To the surface, cells of the level.
        cells: f64,
        /// Of the ground below, radians.
        slope: f64,
        code: String,
        course: Course,
        frozen: bool,
        drawn: Drawn,
    },
}

/// Whether to make of a world what has become of it begins it again: land that has come to this stage, or a flight. All else that is seen
/// changes as it is.
pub fn begins_again(shown: &World, edited: &World, stage: terrain::Stage) -> bool {
    match (&shown.zoom, &edited.zoom) {
        (None, None) => !shown.plan.goes_on_as(&edited.plan, stage),
        _ => !zoom::is_same_place(shown, edited),
    }
}

/// How far path tracing has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traced {
    /// A pixel.
    pub samples: f64,
    pub of: u32,
    /// Estimated relative error.
    pub noise: Option<f64>,
    /// A second.
    pub rate: f64,
    /// Seconds until all are there.
    pub left: f64,
}

/// What there is to do.
#[derive(Default)]
struct Load {
    /// Commands that have not been obeyed.
    pending: AtomicUsize,
    /// Those among them that say what the world is.
    worlds: AtomicUsize,
    busy: AtomicBool,
}

impl Load {
    fn sent(&self, command: &Command) {
        self.pending.fetch_add(1, Ordering::SeqCst);
        if matches!(command, Command::Open(_) | Command::Edit(_)) {
            self.worlds.fetch_add(1, Ordering::SeqCst);
        }
    }

    /// Counts a command that was received, and says whether it is still of use: a world that another one follows is not.
    fn received(&self, command: &Command) -> bool {
        self.pending.fetch_sub(1, Ordering::SeqCst);
        match command {
            Command::Open(_) => {
                self.worlds.fetch_sub(1, Ordering::SeqCst);
                true
            }
            Command::Edit(_) => self.worlds.fetch_sub(1, Ordering::SeqCst) == 1,
            _ => true,
        }
    }
}

/// The window's end.
pub struct Engine {
    commands: Sender<Command>,
    news: Receiver<News>,
    load: Arc<Load>,
    thread: Option<JoinHandle<()>>,
}

impl Engine {
    /// Starts it. `wake` is called, from its thread, whenever there is news.
    pub fn start(gpu: &Gpu, validation: Option<MessageLog>, wake: impl Fn() + Send + 'static) -> Engine {
        let (commands, inbox) = channel();
        let (outbox, news) = channel();
        let gpu = gpu.clone();
        let load = Arc::<Load>::default();
        let own_load = load.clone();
        let thread = std::thread::Builder::new().name("engine".into()).spawn(move || {
            let speaker = Speaker { outbox, wake: Box::new(wake) };
            let session =
                Session { report: Report::of("view"), progress: Progress::silent(), cache: None, validation };
            let mut works = Works::new(gpu, inbox, speaker, session, own_load);
            if let Err(error) = works.run() {
                works.speaker.say(News::Ended(error));
            }
        });
        Engine { commands, news, load, thread: thread.ok() }
    }

    pub fn send(&self, command: Command) {
        // What takes long and is of no use any more ends.
        if matches!(command, Command::Open(_) | Command::Restart | Command::Quit) {
            interrupt::cancel(true);
        }
        self.load.sent(&command);
        // An engine that has ended has said why.
        let _ = self.commands.send(command);
    }

    /// The next news, if there is any.
    pub fn news(&self) -> Option<News> {
        self.news.try_recv().ok()
    }

    /// Whether nothing is left to do until there is a command.
    pub fn is_idle(&self) -> bool {
        self.load.pending.load(Ordering::SeqCst) == 0 && !self.load.busy.load(Ordering::SeqCst)
    }

    /// Whether it has obeyed all that it was told.
    pub fn has_heard(&self) -> bool {
        self.load.pending.load(Ordering::SeqCst) == 0
    }

    /// Whether it keeps up with what it is told.
    pub fn is_listening(&self) -> bool {
        self.load.pending.load(Ordering::SeqCst) < 4
    }

    /// Whether its thread has ended.
    pub fn is_dead(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.send(Command::Quit);
        if let Some(thread) = self.thread.take() {
            // A panic has been told on standard error.
            let _ = thread.join();
        }
    }
}

/// What says news to the window.
struct Speaker {
    outbox: Sender<News>,
    wake: Box<dyn Fn() + Send>,
}

impl Speaker {
    fn say(&self, news: News) {
        // A window that is gone needs none.
        let _ = self.outbox.send(news);
        (self.wake)();
    }

    /// What was done, or why it was not.
    fn tell(&self, done: Result<String, Error>) {
        self.say(match done {
            Ok(sentence) => News::Said(sentence),
            Err(error) => News::Failed(error.to_string()),
        });
    }
}

/// What a slice of work came to.
enum Slice {
    /// Nothing is left to do until there is a command.
    Idle,
    Worked,
    /// It listened itself, and this is to be done now.
    Interrupted(Box<Command>),
    /// Nobody is there any more.
    Gone,
}

/// What a slice of work is done with.
type Means<'a> = (&'a mut Studio, &'a Speaker, &'a Receiver<Command>, &'a Load);

/// What all worlds are shown with.
struct Studio {
    gpu: Gpu,
    session: Session,
    size: [u32; 2],
    steering: Steering,
    /// When steering was last acted on.
    steered: Instant,
    frames: Vec<Image<Rgba8>>,
    marks: Marks,
    /// Made when the first land is seen.
    renderer: Option<Arc<raster::Renderer>>,
    /// Made when paths are first traced.
    tracer: Option<Arc<Tracer>>,
    timings: Vec<(&'static str, f32)>,
    passes: Vec<(&'static str, f32)>,
}

/// The thread's end.
struct Works {
    studio: Studio,
    inbox: Receiver<Command>,
    speaker: Speaker,
    load: Arc<Load>,
    stage: Stand,
    told: Instant,
}

enum Stand {
    Empty,
    Land(Box<Land>),
    Zoom(Box<Zoom>),
}

/// Time between two accounts of how things are.
const ACCOUNTS: Duration = Duration::from_millis(100);

impl Works {
    fn new(gpu: Gpu, inbox: Receiver<Command>, speaker: Speaker, session: Session, load: Arc<Load>) -> Works {
        let studio = Studio {
            gpu,
            session,
            size: [0, 0],
            steering: Steering::default(),
            steered: Instant::now(),
            frames: Vec::new(),
            marks: Marks::default(),
            renderer: None,
            tracer: None,
            timings: Vec::new(),
            passes: Vec::new(),
        };
        Works { studio, inbox, speaker, load, stage: Stand::Empty, told: Instant::now() }
    }

    fn run(&mut self) -> Result<(), Error> {
        let mut idle = true;
        loop {
            self.load.busy.store(!idle, Ordering::SeqCst);
            let command = if idle {
                match self.inbox.recv() {
                    Ok(command) => Some(command),
                    Err(RecvError) => return Ok(()),
                }
            } else {
                match self.inbox.try_recv() {
                    Ok(command) => Some(command),
                    Err(TryRecvError::Empty) => None,
                    Err(TryRecvError::Disconnected) => return Ok(()),
                }
            };
            if let Some(command) = command {
                self.load.busy.store(true, Ordering::SeqCst);
                let is_wanted = self.load.received(&command);
                if matches!(command, Command::Quit) {
                    return Ok(());
                }
                let result = if is_wanted { self.obey(command) } else { Ok(()) };
                self.forgive(result)?;
                // What was clicked on shows it.
                if self.told.elapsed() >= ACCOUNTS {
                    self.account();
                }
                idle = false;
                continue;
            }
            let slice = self.slice();
            let slice = match self.forgive(slice)? {
                Some(Slice::Interrupted(command)) => {
                    let is_wanted = self.load.received(&command);
                    if matches!(*command, Command::Quit) {
                        return Ok(());
                    }
                    let result = if is_wanted { self.obey(*command) } else { Ok(()) };
                    self.forgive(result)?;
                    Some(Slice::Worked)
                }
                Some(Slice::Gone) => return Ok(()),
                slice => slice,
            };
            idle = !matches!(slice, Some(Slice::Worked));
            if idle || self.told.elapsed() >= ACCOUNTS {
                self.account();
            }
        }
    }

    /// Tells what failed, and goes on if that is possible.
    fn forgive<T>(&mut self, result: Result<T, Error>) -> Result<Option<T>, Error> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(Error::Interrupted { .. }) => Ok(None),
            Err(error) if error.exit_code() == 5 => Err(error),
            Err(error) => {
                self.speaker.say(News::Failed(error.to_string()));
                Ok(None)
            }
        }
    }

    fn obey(&mut self, command: Command) -> Result<(), Error> {
        let Works { studio, stage, speaker, .. } = self;
        // What that ended has ended.
        if matches!(command, Command::Open(_) | Command::Restart) {
            interrupt::cancel(false);
        }
        match (command, stage) {
            (Command::Open(world), stage) => {
                speaker.say(News::Opened);
                // Its memory is needed for the next.
                *stage = Stand::Empty;
                studio.timings.clear();
                studio.passes.clear();
                if studio.renderer.is_none() || world.zoom.is_some() {
                    let work = Some(("preparing programs for the device".into(), 0, 0));
                    speaker.say(News::Status(Box::new(Status { work, ..Status::default() })));
                }
                *stage = match &world.zoom {
                    Some(_) => Stand::Zoom(Box::new(Zoom::new(studio, &world)?)),
                    None => Stand::Land(Box::new(Land::new(studio, &world)?)),
                };
            }
            (Command::Edit(world), stage) => match stage {
                Stand::Land(land) if world.zoom.is_none() => land.edit(studio, speaker, &world)?,
                Stand::Zoom(zoom) if world.zoom.is_some() => zoom.edit(studio, &world)?,
                _ => return self.obey(Command::Open(world)),
            },
            (Command::Size(size), stage) => {
                studio.size = size;
                match stage {
                    Stand::Land(land) => land.look_again(),
                    Stand::Zoom(zoom) => zoom.resize(studio)?,
                    Stand::Empty => {}
                }
            }
            (Command::Steer(steering), _) => {
                if studio.steering.is_still() {
                    studio.steered = Instant::now();
                }
                studio.steering = steering;
            }
            (Command::Quit, _) => {}
            #[cfg(feature = "reload")]
            (Command::Reprogram { land }, stage) => {
                studio.renderer = None;
                match stage {
                    Stand::Land(stage) => stage.reprogram(studio, land)?,
                    Stand::Zoom(zoom) => zoom.reprogram(studio)?,
                    Stand::Empty => {}
                }
            }
            (command, Stand::Land(land)) => land.obey(studio, speaker, command)?,
            (command, Stand::Zoom(zoom)) => zoom.obey(studio, speaker, command)?,
            (_, Stand::Empty) => {}
        }
        Ok(())
    }

    fn slice(&mut self) -> Result<Slice, Error> {
        let Works { studio, stage, speaker, inbox, load, .. } = self;
        if studio.size.contains(&0) {
            return Ok(Slice::Idle);
        }
        match stage {
            Stand::Empty => Ok(Slice::Idle),
            Stand::Land(land) => land.slice((studio, speaker, inbox, load)),
            Stand::Zoom(zoom) => zoom.slice(studio, speaker),
        }
    }

    fn account(&mut self) {
        self.told = Instant::now();
        let world = match &self.stage {
            Stand::Empty => WorldStatus::None,
            Stand::Land(land) => land.status(),
            Stand::Zoom(zoom) => zoom.status(),
        };
        let (plants, triangles) = match &self.stage {
            Stand::Land(land) => land.counts(),
            _ => (0, 0),
        };
        let work = match &self.stage {
            Stand::Land(land) => land.work(),
            Stand::Zoom(zoom) => zoom.work(),
            Stand::Empty => None,
        };
        let status = Status { world, work, ..status(&self.studio, (plants, triangles)) };
        self.speaker.say(News::Status(Box::new(status)));
    }
}

impl Studio {
    /// The time that steering has been held since it was last asked, seconds.
    fn held(&mut self) -> f32 {
        let seconds = self.steered.elapsed().as_secs_f32().min(0.5);
        self.steered = Instant::now();
        seconds
    }

    /// The cache of finished land; none once that is made by other programs than those of the build.
    fn cache(&mut self) -> Result<Option<Cache>, Error> {
        #[cfg(feature = "reload")]
        if self.gpu.has_replaced("terrain") {
            return Ok(None);
        }
        keep::cache(&mut self.session)
    }

    /// What land is drawn with.
    fn renderer(&mut self) -> Result<Arc<raster::Renderer>, Error> {
        let renderer = match self.renderer.take() {
            Some(renderer) => renderer,
            None => Arc::new(raster::Renderer::new(&self.gpu)?),
        };
        Ok(self.renderer.insert(renderer).clone())
    }

    /// An image for a picture, which nobody looks at.
    fn image(&mut self, size: [u32; 2]) -> Result<Image<Rgba8>, Error> {
        self.frames.retain(|image| image.size() == size || image.is_shared());
        let free = self.frames.iter().find(|image| image.size() == size && !image.is_shared());
        if let Some(image) = free {
            return Ok(image.clone());
        }
        let image = Image::new(&self.gpu, "frame", size)?;
        self.frames.push(image.clone());
        Ok(image)
    }

    /// Remembers how long something took.
    fn took(&mut self, what: &'static str, since: Instant) {
        let milliseconds = 1e3 * since.elapsed().as_secs_f32();
        match self.timings.iter_mut().find(|(name, _)| *name == what) {
            Some((_, known)) => *known = milliseconds,
            None => self.timings.push((what, milliseconds)),
        }
    }
}

/// Writes a picture as its name says: with all of its light, or developed.
fn write_picture(path: &Path, picture: &Picture, film: &Film) -> Result<String, Error> {
    let size = [film.width, film.height];
    if formats::extension(path) == "exr" {
        formats::exr::write_picture(path, size, &picture.pixels, 1.0 / film.exposure)?;
    } else {
        formats::png::write_picture(path, size, &picture.developed(film.tone_map))?;
    }
    Ok(format!("wrote {}", path.display()))
}

/// How things are, whatever the world.
fn status(studio: &Studio, (plants, triangles): (usize, u64)) -> Status {
    Status {
        world: WorldStatus::None,
        work: None,
        timings: studio.timings.clone(),
        passes: studio.passes.clone(),
        memory: studio.gpu.memory(),
        plants,
        triangles,
    }
}
