//! Path traces a scene into a picture, in compute shaders.
//!
//! Paths advance together, one turn at a time, through small programs that each do one thing (Laine, Karras & Aila 2013,
//! "Megakernels Considered Harmful"): `generate` sends them from the eye, `extend` finds what they meet, `escape`, `land`,
//! `model` and `sea` turn them and look for light, `connect` sees whether anything hides it, `film` adds what they gathered to their pixels.

mod assets;
mod film;
pub mod ground;
pub mod memory;
pub mod mesh;
mod rays;
mod sky;
pub mod tree;

use crate::core::camera::Pinhole;
use crate::core::grid::Grid;
use crate::gpu::{self, Buffer, Compute, ComputeInterface, DeviceKind, Gpu, Recorder};
use crate::scene::{self, Film, Ground, Scene, Shelter, shelter};
use crate::shaders::trace::{connect, escape, extend, film as add, generate, land, model, sea};
use crate::shaders::{self, Frame, Turn, Work};
use glam::Vec3;
use std::mem::offset_of;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use assets::Assets;
pub use film::{Crop, Flaws, MOST_SAMPLES, Sums};
pub use rays::Traversal;

use film::Block;
use rays::Programs;
use tree::{Parts, Tree};

/// Traces scenes. Making one compiles its programs; it can then trace any number of pictures.
pub struct Tracer {
    gpu: Gpu,
    shelter: shelter::Passes,
    generate: Compute<generate::Shader>,
    rays: Programs,
    escape: Compute<escape::Shader>,
    land: Compute<land::Shader>,
    model: Compute<model::Shader>,
    sea: Compute<sea::Shader>,
    add: Compute<add::Shader>,
}

/// What decides a picture beside its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub seed: u32,
    /// Most scatterings between a light and the eye. 0 shows lights alone.
    pub bounces: u32,
    /// Radius of the lens, metres; 0 is a pinhole.
    pub aperture: f32,
    /// Distance of what is sharp, metres, along the axis of the camera.
    pub focus: f32,
    /// Whether materials have their mean colour and nothing else, no noise, relief or gloss, and there are no clouds: what other
    /// renderers can show, too.
    pub plain: bool,
    /// Whether there is a sea; without it what it covers lies dry.
    pub sea: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { seed: 1, bounces: 8, aperture: 0.0, focus: 1.0, plain: false, sea: true }
    }
}

/// Work that a submission should last, so that windows stay responsive and no watchdog bites.
const SUBMISSION: Duration = Duration::from_millis(40);

/// Fewest paths at work: a device has that many lanes to fill.
const FEWEST_PATHS: u32 = 2048;

impl Tracer {
    /// Rays go through what is best for the device.
    ///
    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        Tracer::with(gpu, Traversal::best(gpu))
    }

    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn with(gpu: &Gpu, traversal: Traversal) -> gpu::Result<Self> {
        Tracer::make(gpu, traversal, false)
    }

    /// With random numbers that know nothing of each other, to measure what the low-discrepancy sequence is worth.
    ///
    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn independent(gpu: &Gpu) -> gpu::Result<Self> {
        Tracer::make(gpu, Traversal::best(gpu), true)
    }

    fn make(gpu: &Gpu, traversal: Traversal, independent: bool) -> gpu::Result<Self> {
        // Drivers compile on the thread that asks, and `land` takes as long as all the others.
        let (land, others) = rayon::join(
            || Compute::new(gpu, land::Constants { independent }),
            || {
                rayon::join(
                    || Compute::new(gpu, sea::Constants { independent }),
                    || Compute::new(gpu, model::Constants { independent }),
                )
            },
        );
        let (sea, model) = others;
        Ok(Tracer {
            gpu: gpu.clone(),
            shelter: shelter::Passes::new(gpu)?,
            generate: Compute::new(gpu, generate::Constants { independent })?,
            rays: Programs::new(gpu, traversal)?,
            escape: Compute::new(gpu, escape::Constants { independent })?,
            land: land?,
            model: model?,
            sea: sea?,
            add: Compute::new(gpu, ())?,
        })
    }

    /// What all pictures of `scene` have in common: builds the trees over its land and its models.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn assets(&self, scene: &Scene) -> gpu::Result<Arc<Assets>> {
        Ok(Arc::new(Assets::new(self, scene)?))
    }

    /// Begins the picture of `scene`, of `film`'s size.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn begin<'a>(
        &'a self,
        scene: &'a Scene,
        film: &Film,
        camera: &Pinhole,
        settings: Settings,
    ) -> gpu::Result<Tracing<'a>> {
        self.begin_with(&self.assets(scene)?, scene, film, camera, settings)
    }

    /// The same with assets of this scene, or of another with its ground, light and models.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn begin_with<'a>(
        &'a self,
        assets: &Arc<Assets>,
        scene: &'a Scene,
        film: &Film,
        camera: &Pinhole,
        settings: Settings,
    ) -> gpu::Result<Tracing<'a>> {
        let gpu = &self.gpu;
        let tree = Tree::new(gpu, &assets.parts, &scene.population.instances)?;
        let dome_size = sky::size(&scene.light.sky).map(|count| count as i32);
        let frame = Frame { dome_size, ..scene::frame(scene, film, 1, camera) };
        let frame = upload(gpu, "frame", &[frame])?;
        let paths = Paths::new(gpu, Block::most_pixels(film) as usize, settings.bounces)?;
        let sums = Sums::new(film.width, film.height);
        let count = match gpu.info().kind {
            DeviceKind::Cpu => 2 * FEWEST_PATHS,
            _ => 32 * FEWEST_PATHS,
        };
        Ok(Tracing {
            tracer: self,
            scene,
            film: *film,
            settings,
            assets: assets.clone(),
            tree,
            frame,
            paths,
            sums,
            count,
            piece: None,
        })
    }
}

/// A ray into the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// In lengths of the ray's direction.
    pub range: f32,
    /// Index of the instance; `None` is the land.
    pub instance: Option<u32>,
}

/// The twin of `NOTHING` in `glsl/lib/hit.glsl`.
const NOTHING: u32 = u32::MAX;

/// Paths at work on the device.
struct Paths {
    paths: Buffer<shaders::Path>,
    hits: Buffer<shaders::Hit>,
    looks: Buffer<shaders::Look>,
    features: Buffer<shaders::Feature>,
    queues: [Buffer<u32>; 2],
    escaped: Buffer<u32>,
    land: Buffer<u32>,
    models: Buffer<u32>,
    sea: Buffer<u32>,
    turns: Buffer<Turn>,
}

impl Paths {
    /// For `most` paths at once, and so many turns of each.
    fn new(gpu: &Gpu, most: usize, bounces: u32) -> gpu::Result<Paths> {
        Ok(Paths {
            paths: Buffer::new(gpu, "paths", most)?,
            hits: Buffer::new(gpu, "hits", most)?,
            looks: Buffer::new(gpu, "looks", most)?,
            features: Buffer::new(gpu, "features", most)?,
            queues: [Buffer::new(gpu, "queue", most)?, Buffer::new(gpu, "queue", most)?],
            escaped: Buffer::new(gpu, "escaped", most)?,
            land: Buffer::new(gpu, "land", most)?,
            models: Buffer::new(gpu, "models", most)?,
            sea: Buffer::new(gpu, "sea", most)?,
            turns: Buffer::new(gpu, "turns", bounces as usize + 2)?,
        })
    }
}

/// A picture in the making.
pub struct Tracing<'a> {
    tracer: &'a Tracer,
    scene: &'a Scene,
    film: Film,
    settings: Settings,
    assets: Arc<Assets>,
    tree: Tree,
    frame: Buffer<Frame>,
    paths: Paths,
    sums: Sums,
    /// Paths that a submission has at work: as many as it can finish in time.
    count: u32,
    /// What is under way between two steps.
    piece: Option<Piece>,
}

/// A block that is being traced.
struct Piece {
    block: Block,
    film: Buffer<shaders::Pixel>,
    flaws: Buffer<shaders::Flawed>,
    /// The sample that comes next, and the first pixel that is to have it.
    index: u32,
    first: u32,
}

impl Tracing<'_> {
    /// Goes on from what was gathered before: decides which pixels and samples are traced, too, and must be of this picture.
    pub fn resume(&mut self, sums: Sums) {
        (self.sums, self.piece) = (sums, None);
    }

    /// Traces the next piece of the picture, towards the sample of every pixel with the number `end`: as much as one submission does.
    /// What a piece has gathered counts when all of its block is done. False if nothing is left.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn step(&mut self, end: u32) -> gpu::Result<bool> {
        let mut piece = match self.piece.take() {
            Some(piece) => piece,
            None => {
                let Some(block) = self.sums.next(end) else { return Ok(false) };
                let film = Buffer::new(&self.tracer.gpu, "film", block.pixels() as usize)?;
                let flaws = Buffer::new(&self.tracer.gpu, "flaws", 1)?;
                Piece { index: block.samples.start, first: 0, block, film, flaws }
            }
        };
        let pixels = piece.block.pixels();
        let count = self.count.min(pixels - piece.first);
        let begun = Instant::now();
        self.trace(&piece, count)?;
        self.adapt(begun.elapsed(), count);
        piece.first += count;
        if piece.first == pixels {
            (piece.first, piece.index) = (0, piece.index + 1);
        }
        if piece.index < piece.block.samples.end {
            self.piece = Some(piece);
            return Ok(true);
        }
        self.count_in(&piece)?;
        Ok(true)
    }

    /// Lets what is under way count, as far as it has come: its pixels get the sample that some of them have.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn settle(&mut self) -> gpu::Result<()> {
        while self.piece.as_ref().is_some_and(|piece| piece.first > 0) {
            self.step(0)?;
        }
        let Some(mut piece) = self.piece.take() else { return Ok(()) };
        piece.block.samples.end = piece.index;
        self.count_in(&piece)
    }

    fn count_in(&mut self, piece: &Piece) -> gpu::Result<()> {
        let mut rec = Recorder::new(&self.tracer.gpu);
        let (film, flaws) = (rec.download(&piece.film), rec.download(&piece.flaws));
        let finished = rec.submit()?.wait()?;
        let flaws = flaws.take(&finished).first().map_or_else(Flaws::default, |flawed| Flaws {
            not_finite: flawed.not_finite.into(),
            cut_off: flawed.cut_off.into(),
        });
        self.sums.add(&piece.block, &film.take(&finished), flaws);
        Ok(())
    }

    /// Takes what has been gathered so far, and leaves nothing.
    pub fn take_sums(&mut self) -> Sums {
        self.piece = None;
        std::mem::replace(&mut self.sums, Sums::new(0, 0))
    }

    /// What each of these rays meets first: land or an instance. The sea is not in the way.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn meet(&self, rays: &[Ray]) -> gpu::Result<Vec<Option<Meeting>>> {
        if rays.is_empty() {
            return Ok(Vec::new());
        }
        let volley = self.volley(rays)?;
        volley.trace()?;
        volley.meetings()
    }

    /// Brings rays, at least one, to the device.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn volley(&self, rays: &[Ray]) -> gpu::Result<Volley<'_>> {
        let count = rays.len() as u32;
        let paths = Paths::new(&self.tracer.gpu, rays.len(), 0)?;
        let ray = |ray: &Ray| shaders::Path {
            origin: ray.origin.to_array(),
            direction: ray.direction.to_array(),
            ..shaders::Path::default()
        };
        let mut rec = Recorder::new(&self.tracer.gpu);
        rec.upload(&paths.paths, &rays.iter().map(ray).collect::<Vec<_>>());
        rec.upload(&paths.queues[0], &(0..count).collect::<Vec<_>>());
        rec.submit()?.wait()?;
        Ok(Volley { tracing: self, paths, count })
    }

    /// What has been gathered so far.
    pub fn sums(&self) -> &Sums {
        &self.sums
    }

    /// The next sample of the next `count` pixels of the piece.
    fn trace(&self, piece: &Piece, count: u32) -> gpu::Result<()> {
        let &Piece { ref block, ref film, ref flaws, index, first } = piece;
        let Tracing { tracer, scene, settings, assets, tree, frame, paths, .. } = self;
        let Assets { parts, panorama, dome, shelter: Shelter { openness, surf } } = &**assets;
        let Paths { paths, hits, looks, features, queues, escaped, land, models, sea, turns } = paths;
        let Parts { triangles, coats, materials, .. } = parts;
        let placements = &tree.placements;
        let &Ground { ref height, ref water, ref wetness, ref reef, grid, sea_level } = &scene.ground;
        let (world, lattice) = ((tree, height), lattice(grid));
        let (origin, columns) = (block.origin.map(|at| at as i32), block.size[0] as i32);
        let size = [count, 1];
        let (first, count) = (first as i32, count as i32);
        let &Settings { seed, bounces, aperture, focus, plain, sea: with_sea } = settings;
        let sea_level = if with_sea { sea_level } else { f32::MIN };
        let mut rec = Recorder::new(&tracer.gpu);
        rec.dispatch(
            &tracer.generate,
            [size[0].max(bounces + 2), 1],
            generate::Push { seed, index, origin, columns, first, count, aperture, focus },
            generate::Bindings { frame, paths, queue: &queues[0], turns },
        );
        for turn in 0..=bounces {
            let (queue, next) = (&queues[turn as usize % 2], &queues[(turn as usize + 1) % 2]);
            let work =
                Work { seed, index, origin, columns, first, turn, bounces, plain: plain.into(), sea_level };
            let waiting = |queue| (turns, turn as usize * size_of::<Turn>() + queue);
            let push = extend::Push { turn, sea_level, lattice };
            tracer.rays.extend(&mut rec, push, world, &self.paths, queue);
            // One of the programs that turn paths, on those that wait for it: with what all of these programs have, and its own.
            macro_rules! run {
                ($rec:ident, $program:ident: $queue:ident $(, $own:ident)*) => {
                    $rec.dispatch_indirect(
                        &tracer.$program,
                        waiting(offset_of!(Turn, $queue.groups)),
                        $program::Push { work },
                        $program::Bindings {
                            queue: $queue, frame, paths, hits, turns, next, looks, features, dome, panorama $(, $own)*
                        },
                    );
                };
            }
            rec.concurrent(|rec| {
                run!(rec, escape: escaped);
                run!(rec, sea: sea, height, surf);
                run!(rec, land: land, triangles, height, wetness, reef, water, openness);
                run!(rec, model: models, triangles, coats, placements, materials);
            });
            if turn < bounces {
                tracer.rays.connect(&mut rec, connect::Push { turn, lattice }, world, &self.paths);
            }
        }
        rec.dispatch(
            &tracer.add,
            size,
            add::Push { index, first, count, exposure: self.film.exposure },
            add::Bindings { paths, features, film, flaws },
        );
        rec.submit()?.wait()?;
        Ok(())
    }

    /// Next time so many paths as will last a submission.
    fn adapt(&mut self, took: Duration, count: u32) {
        let wanted = f64::from(count) * SUBMISSION.as_secs_f64() / took.as_secs_f64().max(1e-6);
        // A last piece, smaller than the others, says little.
        if count >= self.count / 2 {
            let next = wanted.clamp(f64::from(self.count) / 2.0, f64::from(self.count) * 2.0) as u32;
            self.count = next.clamp(FEWEST_PATHS, Block::MOST_PIXELS);
        }
    }
}

/// Rays that are traced together.
pub struct Volley<'a> {
    tracing: &'a Tracing<'a>,
    paths: Paths,
    count: u32,
}

impl Volley<'_> {
    /// Finds what every ray meets; returns the time that took, where the device can tell.
    ///
    /// # Errors
    /// A lost device.
    pub fn trace(&self) -> gpu::Result<Option<Duration>> {
        let Tracing { tracer, scene, tree, .. } = self.tracing;
        let groups = [self.count.div_ceil(extend::Shader::WORKGROUP[0]), 1, 1];
        let waiting = shaders::Waiting { paths: self.count, groups };
        let mut rec = Recorder::timed(&tracer.gpu, 2);
        rec.upload(&self.paths.turns, &[Turn { paths: waiting, ..Turn::default() }, Turn::default()]);
        let ground = &scene.ground;
        let push = extend::Push { turn: 0, sea_level: f32::MIN, lattice: lattice(ground.grid) };
        let world = (tree, &ground.height);
        tracer.rays.extend(&mut rec, push, world, &self.paths, &self.paths.queues[0]);
        let finished = rec.submit()?.wait()?;
        Ok(finished.timings.last().map(|timing| timing.duration))
    }

    /// What the rays met when they were last traced.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn meetings(&self) -> gpu::Result<Vec<Option<Meeting>>> {
        let mut rec = Recorder::new(&self.tracing.tracer.gpu);
        let hits = rec.download(&self.paths.hits);
        let finished = rec.submit()?.wait()?;
        let objects = &self.tracing.tree.objects;
        let meeting = |hit: &shaders::Hit| {
            (hit.triangle != NOTHING).then(|| Meeting {
                range: hit.range,
                instance: objects.get(hit.placement as usize).and_then(|object| object.checked_sub(1)),
            })
        };
        Ok(hits.take(&finished).iter().map(meeting).collect())
    }
}

fn lattice(grid: Grid) -> shaders::Lattice {
    shaders::Lattice { cell_size: grid.cell_size(), half_extent: grid.extent / 2.0 }
}

fn upload<T: bytemuck::Pod>(gpu: &Gpu, name: &str, values: &[T]) -> gpu::Result<Buffer<T>> {
    let buffer = Buffer::new(gpu, name, values.len())?;
    let mut rec = Recorder::new(gpu);
    rec.upload(&buffer, values);
    rec.submit()?.wait()?;
    Ok(buffer)
}
