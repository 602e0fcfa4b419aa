//! A scene that is drawn again and again, for somebody who watches: what depends on the scene is kept, and only what has changed is worked
//! out again.
//!
//! Two things are made: *light*, images over the ground that say what arrives there and what it looks like, and *pictures*. Both take
//! as long as they take, so both are made in steps of some milliseconds, between which the device can do other things. Light may lag
//! behind ground that changes: pictures then show the new shape in the old light.

mod parts;

use super::patches::{self, Prepared, top, values};
use super::population::batch::Cut;
use super::population::{Care, Coming, Crowd, Kept};
use super::{Exposure, Maps, Overlay, Renderer, overlay};
use crate::core::camera::Pinhole;
use crate::core::grid::Grid;
use crate::core::pace::{Pace, SLICE};
use crate::gpu::{
    self, Buffer, Compute, Gpu, Image, Recorder, Timing,
    format::{D32f, R32f, Rg32f, Rgba8, Rgba32f, Rgba32ui},
};
use crate::scene::{
    self, Camera, Developer, Development, Film, Ground, Light, Population, Scene, Sea, Surface, shelter::side,
};
use crate::shaders::{
    Frame, Patch,
    raster::{coat, fine, fine_foliage, sort, swift},
};
use parts::{PLANT, Programs, TILE, Tiles};
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A scene on the device, and the pictures that are drawn of it.
pub struct Live {
    gpu: Gpu,
    renderer: Arc<Renderer>,
    passes: Passes,
    scene: Scene,
    prepared: Prepared,
    bounds: Vec<Patch>,
    light: Lighting,
    kept: Kept,
    canvas: Option<Canvas>,
    drawing: Option<Drawing>,
    /// Of tiles, by detail.
    pace: [Pace; 2],
    /// Of the ground's.
    patches: Pace,
    /// Of triangles of plants, and of those in shadow maps.
    triangles: [Pace; 2],
    timings: Vec<Timing>,
}

struct Passes {
    coat: Compute<coat::Shader>,
    sort: Compute<sort::Shader>,
    swift: Option<Programs<swift::Shader>>,
    fine: Option<Programs<fine::Shader>>,
    /// By detail, with the sky that they are for.
    foliage: [Option<(u32, Compute<fine_foliage::Shader>)>; 2],
    overlay: overlay::Pass,
    developer: Developer,
}

/// A picture to draw.
#[derive(Clone, Debug)]
pub struct View {
    pub camera: Pinhole,
    /// Its size is that of the image that is drawn into.
    pub film: Film,
    /// Side of the square of samples in a pixel.
    pub samples: u32,
    pub detail: Detail,
    pub overlay: Option<Overlay>,
}

/// How carefully a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// As finely as the ground's grid, in a fraction of the time: for what moves.
    Swift,
    /// As [`Renderer::render`] does.
    Full,
}

/// What pictures find on the ground.
struct Lighting {
    exposure: Exposure,
    /// Albedo, and the share of white water.
    coat: Image<Rgba32f>,
    /// Slope beside that of the ground.
    relief: Image<Rg32f>,
    /// The next row to be measured …
    row: u32,
    /// … and how many from there are not those of the scene as it is now.
    stale: u32,
    pace: Pace,
}

/// Images of one size that pictures are drawn through.
struct Canvas {
    range: Image<R32f>,
    depth: Image<D32f>,
    radiance: Image<Rgba32f>,
    /// There once plants have been seen.
    plant: Option<Image<Rgba32ui>>,
    tiles: Tiles,
}

/// A picture under way.
struct Drawing {
    view: View,
    target: Image<Rgba8>,
    stage: Stage,
}

/// What is to be done next.
enum Stage {
    /// It is found how far away the ground is, from this patch on.
    Ground(u32),
    /// Plants are chosen, and come to the device with their shadows.
    Coming(Coming),
    /// They are drawn, up to there.
    Plants(Crowd, Cut),
    /// Samples are sorted by what they see.
    Sorting(Crowd),
    /// They are lit: the next row of tiles.
    Rows(Crowd, u32),
}

impl Live {
    /// Takes the scene over. Its light is there at once, but as if nothing hid sky, sun or waves: [`Live::relight`] measures it.
    ///
    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn new(gpu: &Gpu, renderer: Arc<Renderer>, scene: Scene) -> gpu::Result<Live> {
        let passes = Passes {
            coat: Compute::new(gpu, ())?,
            sort: Compute::new(gpu, ())?,
            swift: None,
            fine: None,
            foliage: [None, None],
            overlay: overlay::Pass::new(gpu)?,
            developer: Developer::new(gpu)?,
        };
        let (prepared, bounds) = prepared(gpu, &renderer, &scene)?;
        let light = Lighting::new(gpu, scene.ground.grid)?;
        let mut live = Live {
            gpu: gpu.clone(),
            renderer,
            passes,
            scene,
            prepared,
            bounds,
            light,
            kept: Kept::default(),
            canvas: None,
            drawing: None,
            pace: [Pace::new(2e-4), Pace::new(1e-3)],
            patches: Pace::new(1e-5),
            triangles: [Pace::new(1e-6); 2],
            timings: Vec::new(),
        };
        live.assume_open()?;
        Ok(live)
    }

    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The ground's heights, water, wetness or coral have changed, in the images of the scene. A picture under way is given up.
    ///
    /// # Errors
    /// A lost device.
    pub fn ground_changed(&mut self) -> gpu::Result<()> {
        self.drawing = None;
        self.bounds = self.renderer.patches.bound(&self.gpu, &self.scene.ground, &self.prepared.patches)?;
        self.light.stale();
        Ok(())
    }

    /// Other ground.
    ///
    /// # Errors
    /// As [`Live::new`].
    pub fn set_ground(&mut self, ground: Ground) -> gpu::Result<()> {
        let same_grid = self.scene.ground.grid == ground.grid;
        self.scene.ground = ground;
        if same_grid {
            return self.ground_changed();
        }
        self.drawing = None;
        (self.prepared, self.bounds) = prepared(&self.gpu, &self.renderer, &self.scene)?;
        self.light = Lighting::new(&self.gpu, self.scene.ground.grid)?;
        self.kept = Kept::default();
        self.assume_open()
    }

    /// # Errors
    /// No memory for a picture of the sky.
    pub fn set_light(&mut self, light: Light) -> gpu::Result<()> {
        self.drawing = None;
        if self.scene.light.sky != light.sky {
            self.prepared.panorama = scene::panorama(&self.gpu, &light.sky)?;
        }
        self.scene.light = light;
        self.light.stale();
        Ok(())
    }

    pub fn set_sea(&mut self, sea: Sea) {
        self.drawing = None;
        self.scene.sea = sea;
        self.light.stale();
    }

    pub fn set_surface(&mut self, surface: Surface) {
        self.drawing = None;
        self.scene.surface = surface;
        self.light.stale();
    }

    pub fn set_population(&mut self, population: Population) {
        self.drawing = None;
        let before = std::mem::replace(&mut self.scene.population, population);
        self.kept.replant(&before, &self.scene.population);
    }

    /// The level of detail of an instance in the picture begun last, were it drawn in full; `None` before there is one.
    pub fn level_of(&self, instance: usize) -> Option<usize> {
        let level = self.kept.level_of(&self.scene.population, instance, &self.prepared)?;
        Some(level as usize)
    }

    /// Where `camera` stands on the ground as it is now.
    pub fn stand(&self, camera: Camera, film: &Film) -> Pinhole {
        let scene = Scene { camera, population: Population::default(), ..self.scene.clone() };
        patches::camera(&scene, film, &self.bounds)
    }

    /// Slope, normal, and the weights of materials, as they are now, in the light that is there: for overlays.
    ///
    /// # Errors
    /// No memory, or a lost device.
    pub fn maps(&self) -> gpu::Result<Maps> {
        let mut rec = self.recorder();
        let frame = self.frame(&anywhere(), &NO_FILM, 1);
        rec.upload(&self.prepared.frame, &[frame]);
        rec.submit()?.wait()?;
        self.renderer.maps.draw(&self.gpu, &self.scene, &self.prepared, &self.light.exposure)
    }

    /// Whether light is that of the scene as it is now.
    pub fn is_lit(&self) -> bool {
        self.light.stale == 0
    }

    /// Measures light anew on some more rows of the ground, for about as long as `budget` (but at least one row); after the last row comes
    /// the first one again. False once there are none left whose light isn't that of the scene.
    ///
    /// # Errors
    /// A lost device.
    pub fn relight(&mut self, budget: Duration) -> gpu::Result<bool> {
        let cells = side(self.scene.ground.grid);
        if self.light.stale == 0 {
            return Ok(false);
        }
        let row = self.light.row;
        let count = self.light.rows(budget);
        let start = Instant::now();
        let mut rec = self.recorder();
        let frame = self.frame(&anywhere(), &NO_FILM, 1);
        rec.upload(&self.prepared.frame, &[frame]);
        let exposure = &self.light.exposure;
        self.renderer.exposure.record(&mut rec, &self.scene, &self.prepared, exposure, row..row + count);
        self.record_coat(&mut rec, row..row + count);
        self.note(rec.submit()?.wait()?.timings);
        self.light.pace.took(count, start.elapsed());
        self.light.row = (row + count) % cells;
        self.light.stale -= count;
        Ok(self.light.stale > 0)
    }

    /// Draws a picture into `target`: [`Live::begin`] and all of its steps.
    ///
    /// # Errors
    /// As [`Live::begin`].
    pub fn draw(&mut self, view: &View, target: &Image<Rgba8>) -> gpu::Result<()> {
        self.begin(view, target)?;
        while self.step(SLICE)? {}
        Ok(())
    }

    /// Begins a picture. One that was under way is given up. [`Live::step`] draws into `target`, from the top down.
    ///
    /// # Errors
    /// A target of another size than the film's; no memory; a lost device.
    pub fn begin(&mut self, view: &View, target: &Image<Rgba8>) -> gpu::Result<()> {
        self.drawing = None;
        self.timings.clear();
        let film = &view.film;
        let pixels = [film.width, film.height];
        if target.size() != pixels {
            let [width, height] = target.size();
            let error =
                format!("a picture of {} × {} in an image of {width} × {height}", film.width, film.height);
            return Err(gpu::Error::Unsupported(error));
        }
        let size = pixels.map(|side| side * view.samples);
        if self.canvas.as_ref().is_none_or(|canvas| canvas.range.size() != size) {
            // First the old one goes, so that there is room.
            self.canvas = None;
            self.canvas = Some(Canvas::new(&self.gpu, size)?);
        }
        let frame = self.frame(&view.camera, film, view.samples);
        self.passes.prepare(&self.gpu, view.detail, frame.sky)?;
        self.prepared.camera = view.camera;
        self.prepared.sample_angle = frame.sample_angle;
        let mut rec = Recorder::new(&self.gpu);
        rec.upload(&self.prepared.frame, &[frame]);
        rec.submit()?.wait()?;
        self.drawing = Some(Drawing { view: view.clone(), target: target.clone(), stage: Stage::Ground(0) });
        Ok(())
    }

    /// Finds how far away some more patches of the ground are.
    fn find_ground(&mut self, view: &View, first: u32) -> gpu::Result<Stage> {
        let count = self.prepared.patches_per_side.pow(2);
        let Some(canvas) = self.canvas.as_ref().filter(|_| first < count) else {
            let care = match view.detail {
                Detail::Swift => Care::Swift,
                Detail::Full => Care::Full,
            };
            return Ok(Stage::Coming(Coming::new(care)));
        };
        let some = self.patches.fits(SLICE).max(self.prepared.patches_per_side);
        let patches = first..count.min(first.saturating_add(some));
        let mut rec = self.recorder();
        let (seen, whole) = ((&self.prepared, &self.scene), [[1.0; 2], [0.0; 2]]);
        let images = (&canvas.range, &canvas.depth);
        self.renderer.record_range(&mut rec, seen, whole, images, patches.clone());
        let timings = self.patches.time(patches.len() as u32, || Ok(rec.submit()?.wait()?.timings))?;
        self.note(timings);
        Ok(Stage::Ground(patches.end))
    }

    /// Sorts the samples of the picture by what they see.
    fn sort(&mut self) -> gpu::Result<()> {
        let mut rec = self.recorder();
        let Some(canvas) = &mut self.canvas else { return Ok(()) };
        let masks = canvas.tiles.record(&mut rec, &self.passes.sort, &self.prepared.frame, &canvas.range);
        let finished = rec.submit()?.wait()?;
        let list = canvas.tiles.sort(&masks.take(&finished));
        let mut rec = Recorder::new(&self.gpu);
        rec.upload(&canvas.tiles.list, &list);
        rec.submit()?.wait()?;
        self.note(finished.timings);
        Ok(())
    }

    /// Does some more of the picture under way, for about as long as `budget`, but at least something: ground and plants first, then rows from the
    /// top down. False once it is finished, or if there is none.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn step(&mut self, budget: Duration) -> gpu::Result<bool> {
        let begun = Instant::now();
        while let Some(Drawing { view, target, stage }) = self.drawing.take() {
            let stage = match stage {
                Stage::Ground(first) => Some(self.find_ground(&view, first)?),
                Stage::Coming(coming) => Some(self.come(coming)?),
                Stage::Plants(crowd, cut) => Some(self.draw_plants(&view, crowd, cut)?),
                Stage::Sorting(crowd) => {
                    self.sort()?;
                    Some(Stage::Rows(crowd, 0))
                }
                Stage::Rows(crowd, row) => {
                    let left = budget.saturating_sub(begun.elapsed());
                    let next = self.light((&view, &target), &crowd, row, left)?;
                    next.map(|row| Stage::Rows(crowd, row))
                }
            };
            let Some(stage) = stage else { return Ok(false) };
            self.drawing = Some(Drawing { view, target, stage });
            if begun.elapsed() >= budget {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Lights some rows of tiles, from `row` on, for about as long as `budget` (but at least as many as a workgroup has). Returns the row
    /// behind them; `None` behind the last.
    fn light(
        &mut self,
        (view, target): (&View, &Image<Rgba8>),
        crowd: &Crowd,
        row: u32,
        budget: Duration,
    ) -> gpu::Result<Option<u32>> {
        let Some(canvas) = &self.canvas else { return Ok(None) };
        let View { film, samples, detail, overlay, .. } = view;
        let Canvas { range, radiance, tiles, .. } = canvas;
        let detail = *detail;
        let most = self.pace[detail as usize].fits(budget.min(SLICE));
        let rows = row..row + tiles.rows_of(row, most);
        let finished = rows.end == tiles.rows();
        let start = Instant::now();
        let mut rec = self.recorder();
        match detail {
            Detail::Swift => self.record_swift(&mut rec, crowd, rows.clone(), canvas),
            Detail::Full => self.record_fine(&mut rec, crowd, rows.clone(), canvas),
        }
        self.record_foliage(&mut rec, detail, crowd, rows.clone(), canvas);
        // Pixels of which all samples are there.
        let pixel_row = |row: u32| if row == tiles.rows() { film.height } else { row * TILE / samples };
        let pixel_rows = pixel_row(rows.start)..pixel_row(rows.end);
        let development = Development { exposure: film.exposure, tone_map: film.tone_map };
        let developer = &self.passes.developer;
        if !pixel_rows.is_empty() {
            developer.develop_rows(&mut rec, radiance, target, development, pixel_rows.clone());
            if let Some(overlay) = overlay {
                let seen = (&self.prepared.frame, range);
                self.passes.overlay.record(&mut rec, overlay, seen, target, pixel_rows);
            }
        }
        let count = tiles.within(rows.clone()).map(|tiles| tiles.len() as u32).sum();
        let timings = rec.submit()?.wait()?.timings;
        self.pace[detail as usize].took(count, start.elapsed());
        self.note(timings);
        Ok(Some(rows.end).filter(|_| !finished))
    }

    /// Time on the device of the picture drawn last and of what was lit since, by pass; empty where a device doesn't tell.
    pub fn timings(&self) -> &[Timing] {
        &self.timings
    }

    fn recorder(&self) -> Recorder {
        Recorder::timed(&self.gpu, 16)
    }

    fn note(&mut self, timings: Vec<Timing>) {
        for timing in timings {
            match self.timings.iter_mut().find(|known| known.name == timing.name) {
                Some(known) => known.duration += timing.duration,
                None => self.timings.push(timing),
            }
        }
    }

    fn frame(&self, camera: &Pinhole, film: &Film, samples: u32) -> Frame {
        values(&self.scene, film, samples, camera, top(&self.bounds))
    }

    /// Light where nothing hides anything: something to show before it is measured.
    fn assume_open(&mut self) -> gpu::Result<()> {
        let mut rec = self.recorder();
        let frame = self.frame(&anywhere(), &NO_FILM, 1);
        rec.upload(&self.prepared.frame, &[frame]);
        let texels = (side(self.scene.ground.grid) as usize).pow(2);
        rec.upload(&self.light.exposure.shelter.openness, &vec![1.0; texels]);
        rec.upload(&self.light.exposure.shadow, &vec![[-1e9, 0.0]; texels]);
        rec.submit()?.wait()?;
        let cells = side(self.scene.ground.grid);
        let mut row = 0;
        while row < cells {
            let count = self.light.rows_from(row, SLICE);
            let start = Instant::now();
            let mut rec = self.recorder();
            self.record_coat(&mut rec, row..row + count);
            self.note(rec.submit()?.wait()?.timings);
            self.light.pace.took(count, start.elapsed());
            row += count;
        }
        Ok(())
    }

    /// What the ground looks like, on some rows.
    fn record_coat(&self, rec: &mut Recorder, rows: Range<u32>) {
        let ground = &self.scene.ground;
        let Lighting { exposure, coat, relief, .. } = &self.light;
        let cells = side(ground.grid);
        rec.dispatch(
            &self.passes.coat,
            [cells, rows.len() as u32],
            coat::Push { cells: cells as i32, first: rows.start as i32 },
            coat::Bindings {
                frame: &self.prepared.frame,
                panorama: &self.prepared.panorama,
                height: &ground.height,
                wetness: &ground.wetness,
                reef: &ground.reef,
                openness: &exposure.shelter.openness,
                surf: &exposure.shelter.surf,
                shadow: &exposure.shadow,
                glow: &exposure.glow,
                coat,
                relief,
            },
        );
    }

    /// Shades some rows of tiles.
    fn record_swift(&self, rec: &mut Recorder, crowd: &Crowd, rows: Range<u32>, canvas: &Canvas) {
        let ground = &self.scene.ground;
        let Lighting { exposure, coat, relief, .. } = &self.light;
        let Canvas { range, radiance, tiles, .. } = canvas;
        let programs = self.passes.swift.iter().flat_map(Programs::iter);
        for (program, own) in programs.zip(tiles.within(rows)).filter(|(_, own)| !own.is_empty()) {
            rec.dispatch(
                program,
                [own.len() as u32 * TILE, TILE],
                swift::Push { coarse_cells: coat.size()[0] as i32, first_tile: own.start },
                swift::Bindings {
                    frame: &self.prepared.frame,
                    panorama: &self.prepared.panorama,
                    range,
                    radiance,
                    height: &ground.height,
                    water: &ground.water,
                    openness: &exposure.shelter.openness,
                    shadow: &exposure.shadow,
                    coat,
                    relief,
                    canopy: &crowd.canopy,
                    tiles: &tiles.list,
                },
            );
        }
    }

    /// The same as [`Renderer`] does it.
    fn record_fine(&self, rec: &mut Recorder, crowd: &Crowd, rows: Range<u32>, canvas: &Canvas) {
        let ground = &self.scene.ground;
        let exposure = &self.light.exposure;
        let Canvas { range, radiance, tiles, .. } = canvas;
        let programs = self.passes.fine.iter().flat_map(Programs::iter);
        for (program, own) in programs.zip(tiles.within(rows)).filter(|(_, own)| !own.is_empty()) {
            rec.dispatch(
                program,
                [own.len() as u32 * TILE, TILE],
                fine::Push { coarse_cells: exposure.glow.size()[0] as i32, first_tile: own.start },
                fine::Bindings {
                    frame: &self.prepared.frame,
                    panorama: &self.prepared.panorama,
                    range,
                    radiance,
                    height: &ground.height,
                    water: &ground.water,
                    wetness: &ground.wetness,
                    reef: &ground.reef,
                    openness: &exposure.shelter.openness,
                    surf: &exposure.shelter.surf,
                    shadow: &exposure.shadow,
                    glow: &exposure.glow,
                    casts: &crowd.casts.casts,
                    cast_maps: &crowd.casts.maps,
                    canopy: &crowd.canopy,
                    tiles: &tiles.list,
                },
            );
        }
    }

    /// Shades plants.
    fn record_foliage(
        &self,
        rec: &mut Recorder,
        detail: Detail,
        crowd: &Crowd,
        rows: Range<u32>,
        canvas: &Canvas,
    ) {
        let exposure = &self.light.exposure;
        let Canvas { range, radiance, plant, tiles, .. } = canvas;
        let (Some((_, program)), Some(materials), Some(plant), Some(own)) = (
            &self.passes.foliage[detail as usize],
            crowd.materials(),
            plant,
            tiles.within(rows).nth(PLANT as usize).filter(|own| !own.is_empty()),
        ) else {
            return;
        };
        rec.dispatch(
            program,
            [own.len() as u32 * TILE, TILE],
            fine_foliage::Push { coarse_cells: exposure.glow.size()[0] as i32, first_tile: own.start },
            fine_foliage::Bindings {
                frame: &self.prepared.frame,
                panorama: &self.prepared.panorama,
                range,
                plant,
                radiance,
                materials,
                openness: &exposure.shelter.openness,
                shadow: &exposure.shadow,
                glow: &exposure.glow,
                casts: &crowd.casts.casts,
                cast_maps: &crowd.casts.maps,
                canopy: &crowd.canopy,
                tiles: &tiles.list,
            },
        );
    }

    /// Brings plants to the device.
    fn come(&mut self, mut coming: Coming) -> gpu::Result<Stage> {
        let seen = (&self.scene, &self.prepared);
        let [_, pace] = &mut self.triangles;
        let came = self.renderer.population.come(&self.gpu, seen, &mut self.kept, &mut coming, pace)?;
        Ok(match came {
            Some(crowd) => Stage::Plants(crowd, Cut::default()),
            None => Stage::Coming(coming),
        })
    }

    /// Draws some more of whoever is seen.
    fn draw_plants(&mut self, view: &View, crowd: Crowd, mut cut: Cut) -> gpu::Result<Stage> {
        let Some(canvas) = self.canvas.as_mut().filter(|_| crowd.materials().is_some()) else {
            return Ok(Stage::Sorting(crowd));
        };
        let plant = match &canvas.plant {
            Some(plant) => plant.clone(),
            None => canvas.plant.insert(Image::new(&self.gpu, "plant", canvas.range.size())?).clone(),
        };
        let targets = (&canvas.range, &plant, &canvas.depth);
        let whole = [[1.0; 2], [0.0; 2]];
        let seen = (&self.scene, &self.prepared);
        let [pace, _] = &mut self.triangles;
        let drawn = (&crowd, crowd.seen.as_slice(), &mut cut);
        if self.renderer.population.draw(&self.gpu, drawn, seen, whole, targets, pace)? {
            return Ok(Stage::Plants(crowd, cut));
        }
        let sky = self.frame(&view.camera, &view.film, view.samples).sky;
        self.passes.prepare_foliage(&self.gpu, view.detail, sky)?;
        Ok(Stage::Sorting(crowd))
    }
}

impl Passes {
    /// Makes the programs that pictures under this sky need, if they are not there.
    fn prepare(&mut self, gpu: &Gpu, detail: Detail, sky: u32) -> gpu::Result<()> {
        match detail {
            Detail::Swift if self.swift.as_ref().is_none_or(|programs| !programs.is_for(sky)) => {
                self.swift = Some(Programs::new(gpu, sky, |part| swift::Constants { part, sky })?);
            }
            Detail::Full if self.fine.as_ref().is_none_or(|programs| !programs.is_for(sky)) => {
                self.fine = Some(Programs::new(gpu, sky, |part| fine::Constants { part, sky })?);
            }
            Detail::Swift | Detail::Full => {}
        }
        Ok(())
    }

    /// The same for the program of plants.
    fn prepare_foliage(&mut self, gpu: &Gpu, detail: Detail, sky: u32) -> gpu::Result<()> {
        let program = &mut self.foliage[detail as usize];
        if program.as_ref().is_none_or(|(known, _)| *known != sky) {
            let constants = fine_foliage::Constants { part: PLANT, sky, casts: detail == Detail::Full };
            *program = Some((sky, Compute::new(gpu, constants)?));
        }
        Ok(())
    }
}

/// Where no picture is drawn.
const NO_FILM: Film = Film { width: 1, height: 1, exposure: 1.0, tone_map: scene::ToneMap::None };

/// A camera for passes that look at nothing.
fn anywhere() -> Pinhole {
    Pinhole::look_along(glam::Vec3::ZERO, glam::Vec3::NEG_Z, 1.0, 1.0)
}

/// What pictures of the scene share, and the bounds of its ground.
fn prepared(gpu: &Gpu, renderer: &Renderer, scene: &Scene) -> gpu::Result<(Prepared, Vec<Patch>)> {
    let side = patches::side(scene.ground.grid);
    let patches = Buffer::new(gpu, "patches", (side * side) as usize)?;
    let bounds = renderer.patches.bound(gpu, &scene.ground, &patches)?;
    let prepared = Prepared {
        camera: anywhere(),
        sample_angle: 1.0,
        frame: Buffer::new(gpu, "frame", 1)?,
        panorama: scene::panorama(gpu, &scene.light.sky)?,
        patches,
        patches_per_side: side,
    };
    Ok((prepared, bounds))
}

impl Lighting {
    fn new(gpu: &Gpu, grid: Grid) -> gpu::Result<Lighting> {
        let cells = side(grid);
        Ok(Lighting {
            exposure: Exposure::new(gpu, grid)?,
            coat: Image::new(gpu, "coat", [cells; 2])?,
            relief: Image::new(gpu, "relief", [cells; 2])?,
            row: 0,
            stale: cells,
            pace: Pace::new(1e-3),
        })
    }

    fn stale(&mut self) {
        self.stale = self.coat.size()[1];
    }

    /// Rows to measure next.
    fn rows(&self, budget: Duration) -> u32 {
        self.rows_from(self.row, budget).min(self.stale)
    }

    /// As many rows as fit into a budget, whole workgroups if there are.
    fn rows_from(&self, row: u32, budget: Duration) -> u32 {
        let fit = self.pace.fits(budget.min(SLICE)) / TILE * TILE;
        fit.max(TILE).min(self.coat.size()[1] - row)
    }
}

impl Canvas {
    fn new(gpu: &Gpu, size: [u32; 2]) -> gpu::Result<Canvas> {
        Ok(Canvas {
            range: Image::new(gpu, "range", size)?,
            depth: Image::new(gpu, "depth", size)?,
            radiance: Image::new(gpu, "radiance", size)?,
            plant: None,
            tiles: Tiles::new(gpu, size)?,
        })
    }
}
