//! `terrane render`: a picture of a world, a part of one, or the frames of a film.

mod checkpoint;
mod frames;
pub mod picture;
mod trace;
mod zoom;

use super::options::{DeviceOptions, OutputOptions, Size, WorldOptions, size};
use super::output::{Place, check_extension};
use crate::app::denoise::Denoiser;
use crate::app::memory::{self, Goal, check_picture};
use crate::app::population::Garden;
use crate::app::{Error, Session, interrupt, land};
use crate::formats::{self, exr::Layered, file, file::Written};
use crate::gpu::{self, Gpu};
use crate::raster::{self, Quality};
use crate::scene::{Film, Picture, Scene};
use crate::terrain::Plan;
use crate::trace::{Assets, Crop, Sums, Tracer, Tracing, Traversal};
use crate::world::shard::Render;
use crate::world::{self, Renderer, World};
use checkpoint::{Checkpoint, Found};
use clap::{Args, ValueHint};
use frames::Name;
use picture::Finish;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trace::Noise;

/// Render a picture of a world, a part of one, or the frames of a film
#[derive(Args)]
pub struct Arguments {
    /// Picture to write, .png or .exr, or a folder for it; a name with %05d for frames, .shard for samples [default: ./<world>.png,
    /// or what a folder of settings says]
    #[arg(short, value_name = "OUT", value_hint = ValueHint::AnyPath)]
    out: Option<PathBuf>,

    /// Size of the picture in pixels [default: the world's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    /// How the picture is made: raster, or trace for path tracing [default: the world's]
    #[arg(long, value_name = "NAME", value_parser = method)]
    renderer: Option<Renderer>,

    /// Make only these pixels of the picture: the same as in all of it
    #[arg(long, value_name = "X,Y,W,H", value_parser = frames::crop)]
    crop: Option<Crop>,

    /// Make these frames of the way that the world's camera.keyframes describe, or its zoom, B not among them
    #[arg(long, value_name = "A..B", value_parser = frames::frames)]
    frames: Option<Range<u32>>,

    #[command(flatten)]
    zoom: zoom::Options,

    /// Trace only these samples of every pixel, B not among them, and write a shard for `terrane merge`
    #[arg(long, value_name = "A..B", value_parser = frames::samples, requires = "of",
          conflicts_with_all = ["spp", "time_limit", "noise", "half", "denoise", "frames"])]
    samples: Option<Range<u32>>,

    /// Samples a pixel of the picture that the shards will make
    #[arg(long, value_name = "N", requires = "samples", value_parser = clap::value_parser!(u32).range(1..))]
    of: Option<u32>,

    /// Go on from OUT.checkpoint: where an interrupted run stopped, or towards more samples than the finished picture has
    #[arg(long)]
    resume: bool,

    /// What traced rays go through: query (what the device itself has for that), bvh (our own trees), or auto, the first
    /// where there is one
    #[arg(long, value_name = "NAME", value_parser = traversal, default_value = "auto")]
    traversal: Choice,

    #[command(flatten)]
    limits: trace::Limits,

    #[command(flatten)]
    world: WorldOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

/// Of what rays go through; `None` leaves it to the device.
#[derive(Clone, Copy)]
struct Choice(Option<Traversal>);

const EXTENSIONS: [&str; 2] = ["png", "exr"];
const SHARD: [&str; 1] = ["shard"];

/// How often a run takes another device for one that was lost.
const MOST_LOSSES: u32 = 3;

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    // What the arguments alone can say comes before the world is read.
    if let (Some(samples), Some(of)) = (&arguments.samples, arguments.of)
        && samples.end > of
    {
        return Err(Error::Usage(format!(
            "--samples {}..{} --of {of}: there are no such samples",
            samples.start, samples.end
        )));
    }
    let named = arguments.named()?;
    let world = land::load(&arguments.world, session)?;
    if world.zoom.is_none() {
        arguments.zoom.check_absent()?;
    }
    let job = Job::new(arguments, &world, named)?;
    check_picture(&Film { width: job.width(), ..job.film })?;
    job.place.prepare(job.shot(job.shots.start).path.file_name().and_then(|name| name.to_str()))?;

    interrupt::listen();
    if let Some(zoom) = &world.zoom {
        return job.fly(zoom, session);
    }
    let mut work = Work { shots: job.shots.clone(), gathered: None };
    let mut losses = 0;
    loop {
        match job.go_on(&mut work, session) {
            Err(Error::Gpu(gpu::Error::Lost { after }))
                if losses < MOST_LOSSES && !interrupt::requested() =>
            {
                losses += 1;
                session.progress.end();
                session.warn(format!("the device was lost during {after}, and is opened again ({losses} of {MOST_LOSSES} times)"));
            }
            result => return result,
        }
    }
}

/// What is to be made.
struct Job<'a> {
    arguments: &'a Arguments,
    world: &'a World,
    film: Film,
    renderer: Renderer,
    crop: Crop,
    place: Place,
    target: Target,
    /// Numbers of frames; of a picture by itself 0 alone.
    shots: Range<u32>,
    denoiser: Option<Denoiser>,
}

/// Where pictures go.
enum Target {
    Picture(PathBuf),
    Frames(Name),
}

/// A picture by itself, or a frame.
struct Shot {
    frame: Option<u32>,
    path: PathBuf,
}

/// What is left of a job.
struct Work {
    shots: Range<u32>,
    /// What has been traced of the first of them.
    gathered: Option<Sums>,
}

/// What `-o` names.
enum Named {
    Nothing,
    Place(Place),
    Frames(Name),
}

impl Arguments {
    fn named(&self) -> Result<Named, Error> {
        let Some(out) = &self.out else { return Ok(Named::Nothing) };
        let place = Place::of(out);
        let Place::File(path) = &place else { return Ok(Named::Place(place)) };
        check_extension(path, if self.samples.is_some() { &SHARD } else { &EXTENSIONS })?;
        if self.frames.is_none() {
            return Ok(Named::Place(place));
        }
        let name =
            Name::of(path).map_err(|reason| Error::Usage(format!("-o {}: {reason}", path.display())))?;
        Ok(Named::Frames(name))
    }
}

impl<'a> Job<'a> {
    fn new(arguments: &'a Arguments, world: &'a World, named: Named) -> Result<Self, Error> {
        let renderer = arguments.renderer.unwrap_or(world.renderer);
        let mut film = world.film;
        if let Some(Size { width, height }) = arguments.size {
            film = Film { width, height, ..film };
        }
        let (width, height) = (width(&film, arguments), film.height);
        let whole = Crop::whole(width, height);
        let crop = arguments.crop.unwrap_or(whole);
        if !crop.within(&whole) {
            return Err(Error::Usage(format!(
                "--crop: these pixels are not in a picture of {width}x{height}"
            )));
        }
        if arguments.samples.is_some() && renderer == Renderer::Raster {
            return Err(Error::Usage("--samples: only pictures with --renderer trace have samples".into()));
        }
        let (place, target, shots) = match &arguments.frames {
            Some(frames) => {
                let name = frames_of(world, named)?;
                (Place::Folder(name.folder.clone()), Target::Frames(name), frames.clone())
            }
            None => {
                let (place, name) = match named {
                    Named::Place(place) => (place, arguments.name(world)),
                    _ => arguments.unasked(world),
                };
                let path = place.file(&name);
                (place, Target::Picture(path), 0..1)
            }
        };
        if arguments.limits.finish.denoise.is_some() && renderer == Renderer::Raster {
            return Err(Error::Usage("--denoise: only pictures with --renderer trace have noise".into()));
        }
        let denoiser = arguments.limits.finish.denoiser()?;
        Ok(Job { arguments, world, film, renderer, crop, place, target, shots, denoiser })
    }

    /// Of the picture, pixels; with --stereo the film is half of it.
    fn width(&self) -> u32 {
        width(&self.film, self.arguments)
    }

    fn shot(&self, number: u32) -> Shot {
        match &self.target {
            Target::Picture(path) => Shot { frame: None, path: path.clone() },
            Target::Frames(name) => Shot { frame: Some(number), path: name.path(number) },
        }
    }

    /// Makes what is left, on a device of its own.
    fn go_on(&self, work: &mut Work, session: &mut Session) -> Result<(), Error> {
        let Job { arguments, world, film, renderer, .. } = *self;
        let gpu = land::open(&arguments.device, session)?;
        let traversal = arguments.traversal.0.unwrap_or_else(|| Traversal::best(&gpu));
        if renderer == Renderer::Trace {
            traversal.check(&gpu)?;
        }
        let mut studio = Studio { gpu: &gpu, traversal, render: None, raster: None, tracer: None };
        self.remove_abandoned(work);
        self.leave_finished(&mut studio, work, session)?;
        if work.shots.is_empty() {
            return Ok(());
        }
        let planted = !world.plants.rules.is_empty();
        let limits = memory::Limits::of(&gpu);
        let sky = &world.light.sky;
        let goal = |_: &Plan| Goal::Picture { film, sky, planted, models: 0, renderer };
        memory::check(&world.plan, goal, &limits)?;
        let simulation = land::simulate(&gpu, world, session)?;
        let view = land::camera(&gpu, world, &simulation)?;
        let garden = Garden::new(&gpu, world, &simulation, session)?;
        let ground = simulation.land()?;
        drop(simulation);
        while !work.shots.is_empty() {
            let shot = self.shot(work.shots.start);
            let mut settings = world.tracing;
            let keyed = shot.frame.and_then(|frame| world.camera_path.at(frame));
            let camera = keyed.map_or(view, |(camera, focus)| {
                settings.focus = focus;
                camera
            });
            let population = garden.populate(&camera, &film, session)?;
            if renderer == Renderer::Trace {
                let models = crate::trace::memory::population(&population).bytes;
                let goal = |_: &Plan| Goal::Picture { film, sky, planted: models > 0, models, renderer };
                memory::check(&world.plan, goal, &limits)?;
            }
            let pinhole = garden.pinhole(&camera, &film);
            let scene = land::scene(world, ground.clone(), camera, population);
            match renderer {
                Renderer::Raster => self.draw(&mut studio, &shot, &scene, session)?,
                Renderer::Trace => {
                    let checkpoint = self.checkpoint(&mut studio, &shot)?;
                    session.progress.show("acceleration", 0, 1);
                    let (tracer, assets) = studio.tracer(&scene)?;
                    let mut tracing = tracer.begin_with(assets, &scene, &film, &pinhole, settings)?;
                    session.progress.show("acceleration", 1, 1);
                    self.trace(&shot, &mut tracing, checkpoint, &mut work.gathered, session)?;
                }
            }
            work.shots.start += 1;
            self.leave_finished(&mut studio, work, session)?;
        }
        Ok(())
    }

    fn checkpoint(&self, studio: &mut Studio, shot: &Shot) -> Result<Checkpoint, Error> {
        let render = Render { frame: shot.frame, ..studio.render(self)?.clone() };
        let first = self.arguments.samples.as_ref().map_or(0, |samples| samples.start);
        Ok(Checkpoint::new(&shot.path, render, self.crop, first, self.arguments.of))
    }

    fn goal<'b>(&'b self, shot: &'b Shot) -> trace::Goal<'b> {
        let limits = &self.arguments.limits;
        let samples = &self.arguments.samples;
        let end = samples.as_ref().map_or(limits.spp.unwrap_or(self.world.samples), |samples| samples.end);
        trace::Goal { path: &shot.path, place: &self.place, is_shard: samples.is_some(), end, limits }
    }

    /// What a frame has to become, in a few words.
    fn limits(&self) -> String {
        let trace::Limits { spp, time_limit, noise, finish } = &self.arguments.limits;
        let Finish { half, denoise } = finish;
        match self.renderer {
            Renderer::Raster => "drawn".into(),
            Renderer::Trace => {
                let spp = spp.unwrap_or(self.world.samples);
                format!(
                    "{spp} samples, time limit {time_limit:?}, noise {noise:?}, half {half}, denoise {denoise:?}"
                )
            }
        }
    }

    /// With --resume: removes what files an earlier run was writing when it ended.
    fn remove_abandoned(&self, work: &Work) {
        let path = self.shot(work.shots.start).path;
        if let Some(folder) = path.parent().filter(|_| self.arguments.resume) {
            let here = folder.as_os_str().is_empty();
            file::remove_abandoned(if here { Path::new(".") } else { folder });
        }
    }

    /// With --resume: takes from the beginning of the work what is there already, and is as it should be.
    fn leave_finished(
        &self,
        studio: &mut Studio,
        work: &mut Work,
        session: &mut Session,
    ) -> Result<(), Error> {
        if !self.arguments.resume || work.gathered.is_some() {
            return Ok(());
        }
        while !work.shots.is_empty() && self.is_finished(studio, &self.shot(work.shots.start), session)? {
            interrupt::check(&session.report)?;
            work.shots.start += 1;
        }
        Ok(())
    }

    fn is_finished(&self, studio: &mut Studio, shot: &Shot, session: &mut Session) -> Result<bool, Error> {
        if let Some(frame) = shot.frame {
            let is_there = shot.path.is_file();
            let checkpoint = self.checkpoint(studio, shot)?;
            let found = if is_there { checkpoint.load(session)? } else { Found::Nothing };
            let finished = matches!(found, Found::Finished(how) if how == self.limits());
            if finished {
                checkpoint.settle();
                session.report.frame(frame, &file::found(&shot.path)?, true);
            }
            return Ok(finished);
        }
        if self.renderer == Renderer::Raster {
            session.progress.say(
                &"--resume: a picture that is not traced has no checkpoint, and is made from the beginning",
            );
            return Ok(false);
        }
        let checkpoint = self.checkpoint(studio, shot)?;
        let goal = self.goal(shot);
        if goal.is_shard && shot.path.is_file() {
            // Its samples are all it has.
            let own = Checkpoint::shard(&shot.path, &checkpoint);
            if let Found::Sums(sums, _) = own.load(session)?
                && goal.is_done(&sums, &Noise::default())
            {
                checkpoint.remove();
                self.leave(shot, "has all its samples", session)?;
                return Ok(true);
            }
        }
        let (sums, picture) = match checkpoint.load(session)? {
            Found::Sums(sums, picture) => (sums, picture),
            _ => {
                let path = checkpoint.path.display();
                session
                    .warn(format!("there is no {path} to resume: the picture is traced from the beginning"));
                return Ok(false);
            }
        };
        let mut noise = Noise::default();
        noise.look(&sums);
        if goal.is_shard || !goal.is_done(&sums, &noise) {
            return Ok(false);
        }
        session.report.checkpoint = Some(checkpoint.path.to_string_lossy().into_owned());
        // It may be of fewer samples, if a run ended before it wrote the last one.
        let there = file::found(&shot.path).ok().map(|found| self.known(&found.sha256));
        if there.is_some() && there == picture {
            checkpoint.settle();
            self.leave(shot, "has all its samples", session)?;
        } else {
            self.finish(shot, checkpoint, &sums, session)?;
        }
        Ok(true)
    }

    fn leave(&self, shot: &Shot, why: &str, session: &mut Session) -> Result<(), Error> {
        session.progress.say(&format!("{} {why}, and is left as it is", shot.path.display()));
        session.report.wrote(&file::found(&shot.path)?);
        Ok(())
    }

    /// Traces from what was gathered before, or an earlier run has left; what is gathered by the time of an error is there for the
    /// next attempt.
    fn trace(
        &self,
        shot: &Shot,
        tracing: &mut Tracing,
        checkpoint: Checkpoint,
        gathered: &mut Option<Sums>,
        session: &mut Session,
    ) -> Result<(), Error> {
        if gathered.is_none()
            && self.arguments.resume
            && let Found::Sums(sums, _) = checkpoint.load(session)?
        {
            *gathered = Some(sums);
        }
        let first = self.arguments.samples.as_ref().map_or(0, |samples| samples.start);
        tracing.resume(gathered.take().unwrap_or_else(|| Sums::of(self.crop, first)));
        let pursued = self.goal(shot).pursue(tracing, &checkpoint, session);
        let sums = tracing.take_sums();
        if let Err(error) = pursued {
            *gathered = Some(sums);
            return Err(error);
        }
        session.progress.end();
        self.finish(shot, checkpoint, &sums, session)
    }

    /// What a checkpoint says of the picture with this SHA-256.
    fn known(&self, sha256: &str) -> String {
        let Finish { half, denoise } = &self.arguments.limits.finish;
        format!("{sha256}, half {half}, denoise {denoise:?}")
    }

    /// Writes the finished picture; with its noise, if that can't be taken out.
    fn picture(&self, shot: &Shot, checkpoint: &Checkpoint, sums: &Sums) -> Result<(Written, u64), Error> {
        let half = self.arguments.limits.finish.half;
        let write = |denoiser| picture::write(&shot.path, checkpoint.render(), sums, half, denoiser);
        match write(self.denoiser.as_ref()) {
            Err(Error::Denoiser(why)) => {
                write(None)?;
                Err(Error::Denoiser(format!("{why}; {} was written with its noise", shot.path.display())))
            }
            written => written,
        }
    }

    /// Writes what is finished, and what is to be kept beside it.
    fn finish(
        &self,
        shot: &Shot,
        checkpoint: Checkpoint,
        sums: &Sums,
        session: &mut Session,
    ) -> Result<(), Error> {
        self.place.make()?;
        let path = shot.path.display();
        if self.arguments.samples.is_some() {
            checkpoint.into_shard(&shot.path, sums)?;
            session.report.wrote(&file::found(&shot.path)?);
            session.progress.say(&format!("wrote {path}, a shard for `terrane merge`"));
            picture::warnings(sums, 0).into_iter().for_each(|warning| session.warn(warning));
            return Ok(());
        }
        let made = self.picture(shot, &checkpoint, sums);
        if shot.frame.is_none() {
            let known = made.as_ref().ok().map(|(written, _)| self.known(&written.sha256));
            checkpoint.write(sums, known)?;
        }
        let (written, clamped) = made?;
        picture::warnings(sums, clamped).into_iter().for_each(|warning| session.warn(warning));
        let [width, height] = sums.crop().size;
        let noise =
            sums.noise().map(|noise| format!(", error about {:.1} %", 100.0 * noise)).unwrap_or_default();
        session.progress.say(&format!(
            "wrote {path}, {width} × {height} pixels, {} samples a pixel{noise}",
            sums.samples()
        ));
        match shot.frame {
            Some(frame) => {
                checkpoint.finish(self.limits())?;
                session.report.frame(frame, &written, false);
            }
            None => {
                checkpoint.settle();
                session.report.wrote(&written);
                session.report.checkpoint = Some(checkpoint.path.to_string_lossy().into_owned());
                let kept = checkpoint.path.display();
                session
                    .progress
                    .say(&format!("kept {kept}: with --resume and a larger --spp the picture is refined"));
            }
        }
        Ok(())
    }

    fn draw(
        &self,
        studio: &mut Studio,
        shot: &Shot,
        scene: &Scene,
        session: &mut Session,
    ) -> Result<(), Error> {
        let picture = raster(studio.raster()?, scene, &self.film, session)?;
        let written = self.write(shot, picture, session)?;
        match shot.frame {
            Some(frame) => {
                self.checkpoint(studio, shot)?.finish(self.limits())?;
                session.report.frame(frame, &written, false);
            }
            None => session.report.wrote(&written),
        }
        Ok(())
    }

    /// Writes what is asked for of a picture.
    fn write(&self, shot: &Shot, picture: Picture, session: &mut Session) -> Result<Written, Error> {
        self.place.make()?;
        let (path, Crop { origin, size }) = (&shot.path, self.crop);
        let whole = [picture.width, picture.height];
        let picture = picture.cut(origin, size);
        let written = match formats::extension(path).as_str() {
            "exr" if size != whole => {
                let channel = |index: usize| picture.pixels.iter().map(|pixel| pixel[index]).collect();
                let channels = ["R", "G", "B"]
                    .iter()
                    .enumerate()
                    .map(|(index, name)| (name.to_string(), channel(index)));
                let (channels, white_luminance) = (channels.collect(), 1.0 / self.film.exposure);
                let part =
                    Layered { size, origin, whole, white_luminance, comments: String::new(), channels };
                formats::exr::write_layered(path, part, false)?.0
            }
            "exr" => formats::exr::write_picture(path, size, &picture.pixels, 1.0 / self.film.exposure)?,
            _ => {
                formats::png::write_picture(path, size, &picture.developed_from(origin, self.film.tone_map))?
            }
        };
        session.progress.say(&format!("wrote {}, {} × {} pixels", path.display(), size[0], size[1]));
        Ok(written)
    }
}

/// What all pictures of a device have in common: made once, and not before it is needed.
struct Studio<'a> {
    gpu: &'a Gpu,
    traversal: Traversal,
    /// Of no frame.
    render: Option<Render>,
    raster: Option<raster::Renderer>,
    tracer: Option<(Tracer, Arc<Assets>)>,
}

impl Studio<'_> {
    fn render(&mut self, job: &Job) -> Result<&Render, Error> {
        match &mut self.render {
            Some(render) => Ok(render),
            none => {
                let renderer = (job.renderer, self.traversal);
                let render = Render::of(job.world, &job.film, renderer, self.gpu.info());
                Ok(none.insert(render.map_err(world::cache::Error::Hash)?))
            }
        }
    }

    fn raster(&mut self) -> gpu::Result<&raster::Renderer> {
        match &mut self.raster {
            Some(renderer) => Ok(renderer),
            none => Ok(none.insert(raster::Renderer::new(self.gpu)?)),
        }
    }

    /// With what the scenes of all frames have in common.
    fn tracer(&mut self, scene: &Scene) -> gpu::Result<&(Tracer, Arc<Assets>)> {
        match &mut self.tracer {
            Some(tracer) => Ok(tracer),
            none => {
                let tracer = Tracer::with(self.gpu, self.traversal)?;
                let assets = tracer.assets(scene)?;
                Ok(none.insert((tracer, assets)))
            }
        }
    }
}

/// Width of what is made on a film.
fn width(film: &Film, arguments: &Arguments) -> u32 {
    if arguments.zoom.stereo { 2 * film.width } else { film.width }
}

/// The names of frames.
fn frames_of(world: &World, named: Named) -> Result<Name, Error> {
    if world.zoom.is_none() && world.camera_path.keys.is_empty() {
        let advice = "write where the camera is in some of them: \
                      `camera.keyframes = [{ frame = 0, position = [0, 100, 500], target = [0, 0, 0] }, { frame = 60, position = \
                      [500, 100, 0] }]`";
        return Err(Error::Missing(format!("--frames: the world has no `camera.keyframes`; {advice}")));
    }
    match named {
        Named::Frames(name) => Ok(name),
        Named::Place(place) => standard(&place.file("%05d.png")),
        Named::Nothing => standard(&Path::new(".").join(&world.name).join("%05d.png")),
    }
}

fn standard(path: &Path) -> Result<Name, Error> {
    Name::of(path).map_err(Error::Usage)
}

impl Arguments {
    /// The name of what goes into a folder.
    fn name(&self, world: &World) -> String {
        match &self.samples {
            Some(Range { start, end }) => format!("{}_{start}-{end}.shard", world.name),
            None => format!("{}.png", world.name),
        }
    }

    /// Where a picture goes when nobody says it, and its name.
    fn unasked(&self, world: &World) -> (Place, String) {
        let photo = world.photo.as_deref().and_then(|photo| Some((photo.parent()?, photo.file_name()?)));
        match photo {
            Some((folder, name)) if self.samples.is_none() => {
                (Place::Folder(folder.into()), name.to_string_lossy().into_owned())
            }
            _ => (Place::of(Path::new("./")), self.name(world)),
        }
    }
}

fn raster(
    renderer: &raster::Renderer,
    scene: &Scene,
    film: &Film,
    session: &mut Session,
) -> Result<Picture, Error> {
    let mut drawing = renderer.begin(scene, film, Quality::default())?;
    loop {
        let (done, of) = drawing.progress();
        session.progress.show("picture", done as u64, of as u64);
        interrupt::check(&session.report)?;
        if !drawing.step()? {
            break;
        }
    }
    session.progress.end();
    Ok(drawing.into_picture())
}

fn traversal(name: &str) -> Result<Choice, String> {
    match name {
        "auto" => Ok(Choice(None)),
        "query" => Ok(Choice(Some(Traversal::Query))),
        "bvh" => Ok(Choice(Some(Traversal::Bvh))),
        _ => Err("use auto, query or bvh".into()),
    }
}

fn method(name: &str) -> Result<Renderer, String> {
    match name {
        "raster" => Ok(Renderer::Raster),
        "trace" => Ok(Renderer::Trace),
        _ => Err("use raster or trace".into()),
    }
}
