//! Draws a scene by rasterisation: land by tessellation, then light, sea and sky once a sample.
//!
//! 1. `patches` bounds every patch of ground; the camera that frames the island stands by these.
//! 2. [`Exposure`] finds what reaches each place: sun, sky, waves.
//! 3. For each tile of the picture, `terrain` rasterises how far away the ground is, `shade` gives every sample its
//!    radiance, and `resolve` makes pixels of samples.

mod exposure;
mod frame;
mod light;
mod maps;
pub mod memory;
mod patches;
mod picture;

use crate::gpu::{
    self, Blend, Compute, Cull, Depth, Draw, Gpu, Image, Load, Raster, RasterState, Recorder, Targets,
    Topology,
    format::{D32f, Format, R32f, Rgba32f},
};
use crate::scene::{Film, Scene};
use crate::shaders::raster::{resolve, shade, terrain};

pub use exposure::Exposure;
pub use maps::Maps;
pub use picture::Picture;

use frame::Prepared;

/// Draws scenes. Making one compiles its programs; it can then draw any number of pictures.
pub struct Renderer {
    gpu: Gpu,
    patches: patches::Pass,
    exposure: exposure::Passes,
    maps: maps::Pass,
    terrain: Raster<terrain::Shader>,
    shade: Compute<shade::Shader>,
    resolve: Compute<resolve::Shader>,
}

/// How a picture is cut and sampled; neither changes what it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Side of the square of samples in a pixel.
    pub samples: u32,
    /// Largest side of the tiles that the picture is drawn in, pixels.
    pub tile: u32,
}

impl Default for Quality {
    fn default() -> Self {
        Quality { samples: 2, tile: 512 }
    }
}

impl Renderer {
    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        let state = RasterState {
            color: &[R32f::VK],
            depth: Depth::TestWrite,
            topology: Topology::Patches(4),
            cull: Cull::None,
            blend: Blend::None,
        };
        Ok(Renderer {
            gpu: gpu.clone(),
            patches: patches::Pass::new(gpu)?,
            exposure: exposure::Passes::new(gpu)?,
            maps: maps::Pass::new(gpu)?,
            terrain: Raster::new(gpu, (), &state)?,
            shade: Compute::new(gpu, ())?,
            resolve: Compute::new(gpu, ())?,
        })
    }

    /// Begins the picture of `scene`, of `film`'s size: lights the ground. [`Drawing::step`] draws.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn begin<'a>(&'a self, scene: &'a Scene, film: &Film, quality: Quality) -> gpu::Result<Drawing<'a>> {
        let prepared = self.patches.prepare(&self.gpu, scene, film, quality)?;
        let exposure = self.exposure.measure(&self.gpu, scene, &prepared)?;
        let tiles = Tile::cut(film, quality);
        let picture = Picture::new(film.width, film.height);
        Ok(Drawing { renderer: self, scene, film: *film, prepared, exposure, tiles, done: 0, picture })
    }

    /// The whole picture at once.
    ///
    /// # Errors
    /// As [`Renderer::begin`].
    pub fn render(&self, scene: &Scene, film: &Film, quality: Quality) -> gpu::Result<Picture> {
        let mut drawing = self.begin(scene, film, quality)?;
        while drawing.step()? {}
        Ok(drawing.into_picture())
    }

    /// Distance of the ground from the eye for every sample of the picture, metres, row by row; 0 where there is
    /// none. Ground that lies wholly under the sea may be left out.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn ground_range(&self, scene: &Scene, film: &Film, quality: Quality) -> gpu::Result<Vec<f32>> {
        let prepared = self.patches.prepare(&self.gpu, scene, film, quality)?;
        let tile = Tile { origin: [0, 0], size: [film.width, film.height], samples: quality.samples };
        let range = self.range(&prepared, scene, film, tile)?;
        let mut rec = Recorder::new(&self.gpu);
        let download = rec.download(&range);
        let finished = rec.submit()?.wait()?;
        Ok(download.take(&finished))
    }

    /// Slope, normal and material weights of the ground.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn maps(&self, scene: &Scene) -> gpu::Result<Maps> {
        let film = Film { width: 1, height: 1, exposure: 1.0, tone_map: crate::scene::ToneMap::None };
        let prepared = self.patches.prepare(&self.gpu, scene, &film, Quality::default())?;
        let exposure = self.exposure.measure(&self.gpu, scene, &prepared)?;
        self.maps.draw(&self.gpu, scene, &prepared, &exposure)
    }

    fn range(&self, prepared: &Prepared, scene: &Scene, film: &Film, tile: Tile) -> gpu::Result<Image<R32f>> {
        let size = tile.sample_size();
        let range = Image::new(&self.gpu, "range", size)?;
        let depth = Image::<D32f>::new(&self.gpu, "depth", size)?;
        let [scale, offset] = tile.clip(film);
        let mut rec = Recorder::new(&self.gpu);
        let targets = Targets { color: &[&range], depth: Some(&depth), load: Load::Clear([0.0; 4]) };
        rec.render(&targets, |draws| {
            let side = prepared.patches_per_side;
            draws.draw(
                &self.terrain,
                Draw { vertices: 4, instances: side * side },
                terrain::Push { scale, offset },
                terrain::Bindings {
                    frame: &prepared.frame,
                    height: &scene.ground.height,
                    patches: &prepared.patches,
                },
            );
        });
        rec.submit()?.wait()?;
        Ok(range)
    }

    fn shade(
        &self,
        prepared: &Prepared,
        scene: &Scene,
        exposure: &Exposure,
        film: &Film,
        tile: Tile,
        range: &Image<R32f>,
    ) -> gpu::Result<Vec<[f32; 4]>> {
        let radiance = Image::<Rgba32f>::new(&self.gpu, "radiance", tile.sample_size())?;
        let pixels = Image::<Rgba32f>::new(&self.gpu, "pixels", tile.size)?;
        let ground = &scene.ground;
        let mut rec = Recorder::new(&self.gpu);
        rec.dispatch(
            &self.shade,
            tile.sample_size(),
            shade::Push {
                origin: tile.origin.map(|at| (at * tile.samples) as i32),
                coarse_cells: exposure.openness.size()[0] as i32,
            },
            shade::Bindings {
                frame: &prepared.frame,
                range,
                radiance: &radiance,
                height: &ground.height,
                water: &ground.water,
                wetness: &ground.wetness,
                reef: &ground.reef,
                openness: &exposure.openness,
                surf: &exposure.surf,
                shadow: &exposure.shadow,
                glow: &exposure.glow,
            },
        );
        rec.dispatch(
            &self.resolve,
            tile.size,
            resolve::Push { side: tile.samples as i32, exposure: film.exposure },
            resolve::Bindings { radiance: &radiance, picture: &pixels },
        );
        let download = rec.download(&pixels);
        let finished = rec.submit()?.wait()?;
        Ok(download.take(&finished))
    }
}

/// A picture in the making, tile by tile.
pub struct Drawing<'a> {
    renderer: &'a Renderer,
    scene: &'a Scene,
    film: Film,
    prepared: Prepared,
    exposure: Exposure,
    tiles: Vec<Tile>,
    done: usize,
    picture: Picture,
}

impl Drawing<'_> {
    /// Draws the next tile; false if there was none left.
    ///
    /// # Errors
    /// As [`Renderer::begin`].
    pub fn step(&mut self) -> gpu::Result<bool> {
        let Some(&tile) = self.tiles.get(self.done) else { return Ok(false) };
        let Drawing { renderer, scene, film, prepared, exposure, .. } = self;
        let range = renderer.range(prepared, scene, film, tile)?;
        let pixels = renderer.shade(prepared, scene, exposure, film, tile, &range)?;
        self.picture.place(tile.origin, tile.size[0], &pixels);
        self.done += 1;
        Ok(true)
    }

    /// Tiles drawn, and tiles in all.
    pub fn progress(&self) -> (usize, usize) {
        (self.done, self.tiles.len())
    }

    /// What is drawn so far; the rest is black.
    pub fn into_picture(self) -> Picture {
        self.picture
    }
}

/// A part of the picture.
#[derive(Clone, Copy)]
struct Tile {
    /// Left and top, pixels.
    origin: [u32; 2],
    /// Pixels.
    size: [u32; 2],
    /// Side of the square of samples in a pixel.
    samples: u32,
}

impl Tile {
    /// The tiles of a picture, row by row.
    fn cut(film: &Film, quality: Quality) -> Vec<Tile> {
        let starts = |whole: u32| (0..whole).step_by(quality.tile as usize);
        starts(film.height)
            .flat_map(|top| starts(film.width).map(move |left| [left, top]))
            .map(|origin| {
                let [left, top] = origin;
                let size = [quality.tile.min(film.width - left), quality.tile.min(film.height - top)];
                Tile { origin, size, samples: quality.samples }
            })
            .collect()
    }

    fn sample_size(self) -> [u32; 2] {
        self.size.map(|side| side * self.samples)
    }

    /// Scale and offset from the whole picture's clip coordinates to the tile's.
    fn clip(self, film: &Film) -> [[f32; 2]; 2] {
        let axis = |origin: u32, size: u32, whole: u32| {
            let (origin, size, whole) = (f64::from(origin), f64::from(size), f64::from(whole));
            (whole / size, (whole - 2.0 * origin - size) / size)
        };
        let (scale_x, offset_x) = axis(self.origin[0], self.size[0], film.width);
        // Clip coordinates point up, rows count down.
        let (scale_y, offset_y) = axis(self.origin[1], self.size[1], film.height);
        [[scale_x as f32, scale_y as f32], [offset_x as f32, -offset_y as f32]]
    }
}
