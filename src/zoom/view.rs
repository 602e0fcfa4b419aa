//! Pictures of the surface: which tiles are drawn, where they lie from the eye, and how they are drawn.
//!
//! A picture depends on the surface, the view, the settings and the light alone. What is kept from one picture to the next are tiles and patches, and
//! these come again, bit for bit.

use super::{
    address::{Attitude, Cell, Location, Place},
    background::{self, Background, Behind, Means},
    height::{Corners, Spine, Surface},
    marks::{self, Lines, Marks},
    motion::{Buried, Clearance, Distance, clearance},
    paint::{Canvas, Frustum, Lattice, Painter, Sight, Stage, TooDeep},
    tiles::{Heights, Made, Tiles},
    tree::{Detail, Leaf, TooMany, Tree},
};
use crate::{
    core::{
        camera::Pinhole,
        pace::{Pace, SLICE},
    },
    gpu::{self, Compute, Gpu, Image, Load, Recorder, Timing, format::Rgba32f},
    scene::{Film, Light, Picture},
    shaders::zoom::develop,
};
use glam::{DVec3, Vec3};
use std::{
    ops::Range,
    time::{Duration, Instant},
};

/// How a surface is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// log₂ of the quads along a side of a tile.
    pub bits: u32,
    pub detail: Detail,
    /// Octaves of distance, from that to the surface on, to where nothing is seen but sky.
    pub octaves: u32,
    /// The share of these that is clear: from there on there is haze.
    pub clear: f32,
    /// Most layers of the background: [`background::layers`] of these octaves. More don't show. With `None` all is in the foreground, which whole numbers
    /// have the digits for near the start only.
    pub layers: Option<u32>,
    /// Texels along the edge of a face of the background.
    pub face: u32,
    /// Tiles that the device keeps.
    pub slots: u32,
    /// Side of the square of samples in a pixel.
    pub samples: u32,
}

/// Where a picture is taken from.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    pub place: Place,
    pub attitude: Attitude,
    /// Vertical field of view, radians.
    pub fov: f32,
    /// About the level whose cells are as large as the surface is far. It decides nothing but time.
    pub level: u32,
}

impl View {
    /// From a location, whatever its surface.
    pub fn of(location: &Location) -> View {
        let Location { level, place, attitude, .. } = location;
        View { place: place.clone(), attitude: *attitude, fov: location.fov_radians(), level: *level }
    }
}

/// Why there is no picture.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    #[error(transparent)]
    Buried(#[from] Buried),
    #[error(transparent)]
    TooMany(#[from] TooMany),
    #[error("a view needs {needed} tiles and more, and the device keeps {slots}")]
    Slots { needed: usize, slots: u32 },
    #[error(transparent)]
    TooDeep(#[from] TooDeep),
    #[error("the frozen tiles are too far away, or too large, to be seen from here")]
    Away,
}

/// A picture, and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    pub picture: Picture,
    /// To the surface.
    pub altitude: Distance,
    /// Tiles looked at, in all directions.
    pub leaves: usize,
    /// Levels of the coarsest and the finest of these.
    pub levels: [u32; 2],
    /// Those in the picture.
    pub drawn: usize,
    /// Those that were not there.
    pub made: usize,
    /// Time that it took on the processor, without waiting for the device.
    pub cpu: Duration,
    /// And on the device, from when it was told until it was done.
    pub gpu: Duration,
    /// Of this, what each pass says that it took; empty where a device doesn't tell.
    pub passes: Vec<Timing>,
}

/// Draws a surface.
pub struct Renderer {
    gpu: Gpu,
    settings: Settings,
    film: Film,
    spine: Spine,
    tiles: Tiles,
    painter: Painter,
    stage: Stage,
    background: Background,
    canvas: Canvas,
    pixels: Image<Rgba32f>,
    develop: Compute<develop::Shader>,
    marks: Marks,
    /// Made when first wanted.
    lines: Option<Lines>,
    frozen: Option<Selection>,
    /// What the device did since the last picture.
    bill: Bill,
    /// How long it takes to make or draw a tile,
    tile: Pace,
    /// and to develop a row.
    row: Pace,
}

/// Rows of a workgroup that develops.
const ROWS: u32 = 8;

/// What the device did.
#[derive(Default)]
pub(super) struct Bill {
    waited: Duration,
    passes: Vec<Timing>,
}

/// Tiles are made when they are nearer than this many times what they are drawn at, as long as there are not too many,
const EARLY: f64 = 1.25;
/// more than this in one picture.
const TILES_AHEAD: usize = 8;

/// Sides of a root that frozen tiles may be away: whole numbers have the digits for twice as many.
const FARTHEST: f64 = 128.0;

/// What hides what is far.
#[derive(Clone, Copy, Debug)]
struct Haze {
    /// The altitude that its octaves count from.
    altitude: Distance,
    /// Octaves of distance from there on to where nothing is seen but sky.
    octaves: f32,
}

/// What a view shows.
#[derive(Clone, Debug)]
pub struct Selection {
    /// Where it was selected for.
    place: Place,
    pub tree: Tree,
    /// To the surface.
    pub altitude: Distance,
    haze: Haze,
    /// What the tiles are made from: from coarse to fine.
    wanted: Vec<(Cell, Corners)>,
}

impl Renderer {
    /// # Errors
    /// What the device has no room for.
    pub fn new(
        gpu: &Gpu,
        surface: Surface,
        settings: Settings,
        light: &Light,
        film: &Film,
    ) -> gpu::Result<Renderer> {
        let Settings { bits, detail, layers, face, slots, samples, .. } = settings;
        let size = [film.width, film.height];
        Ok(Renderer {
            gpu: gpu.clone(),
            settings,
            film: *film,
            spine: Spine::new(surface),
            tiles: Tiles::new(gpu, surface, bits, slots)?,
            painter: Painter::new(gpu, surface, detail, bits)?,
            stage: Stage::new(gpu, light, film)?,
            background: Background::new(
                gpu,
                surface,
                (detail, bits, slots as usize),
                layers.unwrap_or(0),
                face,
            )?,
            canvas: Canvas::new(gpu, "radiance", size.map(|side| side * samples))?,
            pixels: Image::new(gpu, "pixels", size)?,
            develop: Compute::new(gpu, ())?,
            marks: Marks::default(),
            lines: None,
            frozen: None,
            bill: Bill::default(),
            tile: Pace::of(u32::MAX),
            row: Pace::of(u32::MAX),
        })
    }

    /// From now on pictures are of another size, or have another number of samples along the side of a pixel. The background stays as fine as it
    /// is.
    ///
    /// # Errors
    /// What the device has no room for.
    pub fn reshape(&mut self, film: &Film, samples: u32) -> gpu::Result<()> {
        if (self.film, self.settings.samples) == (*film, samples) {
            return Ok(());
        }
        let size = [film.width, film.height];
        self.canvas = Canvas::new(&self.gpu, "radiance", size.map(|side| side * samples))?;
        self.pixels = Image::new(&self.gpu, "pixels", size)?;
        (self.film, self.settings.samples) = (*film, samples);
        Ok(())
    }

    /// From now on the background is made from faces of so many texels along an edge, see [`background::side`]. It is made anew.
    ///
    /// # Errors
    /// What the device has no room for.
    pub fn refine(&mut self, face: u32) -> gpu::Result<()> {
        let Settings { bits, detail, layers, slots, .. } = self.settings;
        let most = (detail, bits, slots as usize);
        let surface = *self.spine.surface();
        self.background = Background::new(&self.gpu, surface, most, layers.unwrap_or(0), face)?;
        self.settings.face = face;
        Ok(())
    }

    /// What pictures show beside the surface from now on.
    ///
    /// # Errors
    /// What the device has no room for.
    pub fn mark(&mut self, marks: Marks) -> gpu::Result<()> {
        self.painter.mark(marks)?;
        if marks.has_lines() && self.lines.is_none() {
            self.lines = Some(Lines::new(&self.gpu)?);
        }
        self.marks = marks;
        Ok(())
    }

    /// From now on no submission takes much longer than a slice, so that a window on the same device need not wait: a picture is the same, and takes
    /// somewhat longer.
    pub fn share_the_device(&mut self) {
        (self.tile, self.row) = (Pace::new(1.5e-3), Pace::new(1.5e-3));
    }

    /// From now on pictures show the tiles that this view selects, wherever they are taken from; without a view, those that each selects for itself.
    ///
    /// # Errors
    /// As [`Renderer::select`].
    pub fn freeze(&mut self, view: Option<&View>) -> Result<(), Error> {
        self.frozen = view.map(|view| self.select(view)).transpose()?;
        Ok(())
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Patches of the surface, for flights.
    pub fn spine(&mut self) -> &mut Spine {
        &mut self.spine
    }

    /// Forgets all tiles, patches and backgrounds.
    pub fn clear(&mut self) {
        self.tiles.clear();
        self.background.clear();
        self.spine = Spine::new(*self.spine.surface());
    }

    /// Begins what is behind a view that a flight will come to after so many calls of [`Renderer::work`]. Whether it is there: while it is not, there is no use
    /// in looking further ahead.
    ///
    /// # Errors
    /// If the eye is below the surface or too near to it.
    pub fn prepare(&mut self, view: &View, calls: usize) -> Result<bool, Error> {
        let altitude = self.altitude(view)?;
        Ok(self.background.prepare(&view.place, altitude, calls))
    }

    /// Does a share of what is prepared, so that no picture has to wait for it.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn work(&mut self) -> Result<(), Error> {
        let (background, mut means) = self.means();
        background.work(&mut means)
    }

    /// The picture of a view, with all of its tiles.
    ///
    /// # Errors
    /// If the eye is below the surface or too near to it, or what the device has no memory for.
    pub fn render(&mut self, view: &View) -> Result<Shot, Error> {
        self.render_in_haze(view, None)
    }

    /// The same, in the haze of a place at another altitude, at least half as high and at most twice: eyes of a pair look through that of the middle between
    /// them.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_in_haze(&mut self, view: &View, altitude: Option<Distance>) -> Result<Shot, Error> {
        let start = Instant::now();
        let mut selection = self.shown(view)?;
        if let Some(altitude) = altitude {
            selection.haze = self.haze(altitude);
        }
        // First, since its tiles may take slots.
        let behind = if self.marks.no_background {
            None
        } else {
            let (background, mut means) = self.means();
            background.ensure(&mut means, &view.place, selection.altitude)?
        };
        let made = self.make(&selection)?;
        let camera = camera(view, &self.film);
        let (mut rec, drawn) = self.draw(view, &selection, &camera)?;
        self.develop(&mut rec, &selection, behind)?;
        let download = rec.download(&self.pixels);
        let pixels = download.take(&self.wait(rec)?);
        let Film { width, height, .. } = self.film;
        let mut picture = Picture::new(width, height);
        picture.place([0, 0], width, &pixels);
        let Selection { tree, altitude, .. } = selection;
        // From coarse to fine.
        let leaves = tree.leaves();
        let levels = [leaves.first(), leaves.last()].map(|leaf| leaf.map_or(0, |leaf| leaf.cell.level));
        let Bill { waited: gpu, passes } = std::mem::take(&mut self.bill);
        let cpu = start.elapsed().saturating_sub(gpu);
        Ok(Shot { picture, altitude, leaves: leaves.len(), levels, drawn, made, cpu, gpu, passes })
    }

    /// The distance of the foreground for every sample of a picture, in cells of the altitude's level, row by row; 0 where there is none.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn ranges(&mut self, view: &View) -> Result<Vec<f32>, Error> {
        let selection = self.shown(view)?;
        self.make(&selection)?;
        let (mut rec, _) = self.draw(view, &selection, &camera(view, &self.film))?;
        let download = rec.download(&self.canvas.radiance);
        let samples = download.take(&self.wait(rec)?);
        Ok(samples.into_iter().map(|[.., range]| range).collect())
    }

    fn altitude(&mut self, view: &View) -> Result<Distance, Error> {
        match clearance(&mut self.spine, &view.place, view.level) {
            Some(Clearance { distance, is_above: true }) => Ok(distance),
            _ => Err(Buried.into()),
        }
    }

    /// The tiles in the foreground of a picture, from coarse to fine, with all their heights, and how far the surface is.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn seen(&mut self, view: &View) -> Result<(Distance, Vec<(Leaf, Heights)>), Error> {
        let selection = self.select(view)?;
        self.make(&selection)?;
        let Selection { tree, altitude, .. } = selection;
        let frustum = Frustum::new(&camera(view, &self.film));
        let leaves: Vec<Leaf> = tree.leaves().into_iter().filter(|leaf| frustum.has(&tree, leaf)).collect();
        let heights = self.tiles.read(&self.gpu, leaves.iter().map(|leaf| leaf.cell))?;
        Ok((altitude, leaves.into_iter().zip(heights).collect()))
    }

    /// Which tiles a view shows in the foreground.
    ///
    /// # Errors
    /// If the eye is below the surface or too near to it.
    pub fn select(&mut self, view: &View) -> Result<Selection, Error> {
        let Settings { layers, slots, detail, .. } = self.settings;
        let surface = *self.spine.surface();
        let altitude = self.altitude(view)?;
        let layer = layers.map_or(0, |_| background::nearest(altitude));
        let roots = background::roots(&mut self.spine, &view.place, layer, detail);
        let mut wanted = background::above(&mut self.spine, &view.place, &roots);
        let tree = Tree::new(&surface, &view.place, &roots, detail, slots as usize)?;
        wanted.extend(tree.nodes());
        Ok(Selection { place: view.place.clone(), tree, altitude, haze: self.haze(altitude), wanted })
    }

    /// What a picture of a view shows: what it selects, or what is frozen, as it is seen from there.
    fn shown(&mut self, view: &View) -> Result<Selection, Error> {
        let Some(mut frozen) = self.frozen.clone() else { return self.select(view) };
        frozen.tree.look_from(&view.place);
        if frozen.tree.distance() > FARTHEST {
            return Err(Error::Away);
        }
        frozen.altitude = self.altitude(view)?;
        frozen.haze = self.haze(frozen.altitude);
        Ok(frozen)
    }

    fn haze(&self, altitude: Distance) -> Haze {
        // There is sky where the plain ends.
        let to_end = background::PLAIN_OCTAVES + altitude.depth();
        Haze { altitude, octaves: (to_end as f32).clamp(0.01, self.settings.octaves as f32) }
    }

    /// Makes the tiles that are not there; returns how many.
    fn make(&mut self, selection: &Selection) -> Result<usize, Error> {
        let most = self.most();
        let wanted = || selection.wanted.iter().copied();
        let mut rec = recorder(&self.gpu);
        let Made { mut tiles, mut waiting } =
            self.tiles.make(&mut rec, &mut self.spine, &selection.place, wanted(), most);
        let mut share = tiles;
        while waiting > 0 && share > 0 {
            wait(std::mem::replace(&mut rec, recorder(&self.gpu)), &mut self.bill)?;
            let also = self.tiles.make_also(&mut rec, &mut self.spine, &selection.place, wanted(), most);
            (share, waiting) = (also.tiles, also.waiting);
            tiles += share;
        }
        let soon = selection.tree.soon(EARLY * self.settings.detail.sides());
        self.tiles.make_also(&mut rec, &mut self.spine, &selection.place, soon, TILES_AHEAD);
        self.wait(rec)?;
        match waiting {
            0 => Ok(tiles),
            _ => Err(Error::Slots { needed: selection.wanted.len(), slots: self.settings.slots }),
        }
    }

    /// Draws the foreground, all but what the recorder has yet to submit; how many tiles these are.
    fn draw(
        &mut self,
        view: &View,
        selection: &Selection,
        camera: &Pinhole,
    ) -> Result<(Recorder, usize), Error> {
        let Selection { place, altitude, tree, .. } = selection;
        let leaves = tree.leaves();
        let surface = *self.spine.surface();
        // Of frozen tiles the eye may be nearer than what they were selected for.
        let is_own = *place == view.place;
        let levels = (altitude.level, if is_own { 0 } else { altitude.level });
        let lattice = Lattice::new(surface, &view.place, &leaves, levels, self.settings.bits)
            .map_err(|error| if is_own { error.into() } else { Error::Away })?;
        let frustum = Frustum::new(camera);
        // What is near first: it hides the rest.
        let seen: Vec<&Leaf> = leaves.iter().rev().filter(|leaf| frustum.has(tree, leaf)).collect();
        let views = seen.iter().map(|leaf| self.painter.view(&self.tiles, place, &lattice, leaf));
        let missing = Error::Slots { needed: selection.wanted.len(), slots: self.settings.slots };
        let views = views.collect::<Option<Vec<_>>>().ok_or(missing)?;
        let near = libm::exp2(libm::log2(altitude.cells).floor()) as f32 / 4.0;
        let exposure = self.film.exposure;
        let looks = Some(marks::looks(&self.canvas, exposure));
        let sight = Sight { lattice: &lattice, near, focus: lattice.to(place), looks };
        let mut rec = recorder(&self.gpu);
        self.stage.look(&mut rec, self.canvas.size(), camera);
        let mut load = Load::Clear([0.0; 4]);
        let mut rest = views.as_slice();
        loop {
            let (now, later) = rest.split_at(self.share(rest.len()));
            self.painter.draw(&mut rec, (&self.canvas, load), &self.stage, &self.tiles, sight, now)?;
            if later.is_empty() {
                break;
            }
            let start = Instant::now();
            wait(std::mem::replace(&mut rec, recorder(&self.gpu)), &mut self.bill)?;
            self.tile.took(now.len() as u32, start.elapsed());
            (rest, load) = (later, Load::Keep);
        }
        if let Some(lines) = self.lines.as_ref().filter(|_| self.marks.has_lines()) {
            let seen = seen.into_iter();
            let all = marks::lines(self.marks, seen, (&surface, &view.place), altitude.level, exposure);
            lines.draw(&mut rec, &self.canvas, &self.stage, near, &all)?;
        }
        Ok((rec, views.len()))
    }

    /// Tiles that a submission makes or draws at most.
    fn most(&self) -> usize {
        self.tile.fits(SLICE).max(1) as usize
    }

    /// How many of so many tiles the next submission draws: all have about as many, so that each of them tells a pace.
    fn share(&self, tiles: usize) -> usize {
        tiles.div_ceil(tiles.div_ceil(self.most()).max(1))
    }

    /// From samples to pixels, with what is behind them.
    fn develop(
        &mut self,
        rec: &mut Recorder,
        selection: &Selection,
        behind: Option<Behind>,
    ) -> gpu::Result<()> {
        let Selection { altitude: own, haze: Haze { altitude, octaves }, .. } = selection;
        // Samples tell distances in cells of the level of their own altitude.
        let scale = libm::exp2(f64::from(own.level) - f64::from(altitude.level));
        let push = develop::Push {
            exposure: self.film.exposure,
            altitude: (altitude.cells * scale) as f32,
            veil: [self.settings.clear.min(0.99) * octaves, *octaves],
            offset: behind.map_or(0.0, |of| altitude.depth() - f64::from(of.level)) as f32,
            has_background: behind.is_some().into(),
            row: 0,
        };
        let [width, height] = self.pixels.size();
        let mut row = 0;
        loop {
            let rows = (self.row.fits(SLICE) / ROWS * ROWS).clamp(ROWS, height.next_multiple_of(ROWS));
            let Stage { frame, panorama, .. } = &self.stage;
            let bindings = develop::Bindings {
                frame,
                panorama,
                radiance: &self.canvas.radiance,
                background: self.background.texels(behind),
                picture: &self.pixels,
            };
            let push = develop::Push { row: row as i32, ..push };
            rec.dispatch(&self.develop, [width, rows.min(height - row)], push, bindings);
            row += rows;
            if row >= height {
                return Ok(());
            }
            let start = Instant::now();
            wait(std::mem::replace(rec, recorder(&self.gpu)), &mut self.bill)?;
            self.row.took(rows, start.elapsed());
        }
    }

    fn means(&mut self) -> (&mut Background, Means<'_>) {
        let most = self.most();
        let Renderer { gpu, spine, tiles, painter, stage, background, bill, .. } = self;
        (background, Means { gpu, spine, tiles, painter, stage, bill, most })
    }

    fn wait(&mut self, rec: Recorder) -> gpu::Result<gpu::Finished> {
        wait(rec, &mut self.bill)
    }
}

/// Looks ahead on a flight whose frames are known, so that no picture has to wait for what is behind it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ahead {
    /// The first frame that has not been looked at.
    next: u32,
}

/// Frames that are looked at in one call.
const LOOKS: u32 = 8;

impl Ahead {
    /// How far: somewhat less than a layer of the background has.
    pub const LEVELS: f64 = 7.0;

    /// Prepares what is behind the frames after the first of `frames`, at most so many, and does a share of the work.
    ///
    /// # Errors
    /// Those of `view` and of the device.
    pub fn look<E: From<Error>>(
        &mut self,
        renderer: &mut Renderer,
        frames: Range<u32>,
        most: u32,
        mut view: impl FnMut(&mut Spine, u32) -> Result<View, E>,
    ) -> Result<(), E> {
        let Range { start: now, end } = frames;
        self.next = self.next.max(now + 1);
        let last = end.min(now.saturating_add(most).saturating_add(1)).min(self.next + LOOKS);
        while self.next < last {
            let view = view(renderer.spine(), self.next)?;
            match renderer.prepare(&view, (self.next - now) as usize) {
                Ok(true) => self.next += 1,
                Err(Error::Gpu(error)) => return Err(Error::Gpu(error).into()),
                // A view that can't be shown says so when it is its turn.
                Ok(false) | Err(_) => break,
            }
        }
        match renderer.work() {
            Err(Error::Gpu(error)) => Err(Error::Gpu(error).into()),
            _ => Ok(()),
        }
    }
}

/// Takes the time of passes.
pub(super) fn recorder(gpu: &Gpu) -> Recorder {
    Recorder::timed(gpu, 16)
}

/// Waits until the device has done it, and adds how long that took.
pub(super) fn wait(rec: Recorder, bill: &mut Bill) -> gpu::Result<gpu::Finished> {
    let start = Instant::now();
    let mut finished = rec.submit()?.wait()?;
    bill.waited += start.elapsed();
    for timing in std::mem::take(&mut finished.timings) {
        match bill.passes.iter_mut().find(|known| known.name == timing.name) {
            Some(known) => known.duration += timing.duration,
            None => bill.passes.push(timing),
        }
    }
    Ok(finished)
}

fn camera(view: &View, film: &Film) -> Pinhole {
    let [right, up, forward] = view.attitude.axes().map(DVec3::as_vec3);
    let tangent = libm::tanf(view.fov / 2.0);
    let aspect = film.width as f32 / film.height as f32;
    Pinhole { eye: Vec3::ZERO, right, up, forward, tangent: [tangent * aspect, tangent] }
}
