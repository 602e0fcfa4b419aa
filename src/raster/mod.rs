//! Draws a scene by rasterisation: land by tessellation, then light, sea and sky once a sample.
//!
//! 1. `patches` bounds every patch of ground; the camera that frames the island stands by these.
//! 2. [`Exposure`] finds what reaches each place: sun, sky, waves.
//! 3. `population` draws the shadows of plants, as the sun sees them.
//! 4. For each tile of the picture, `terrain` rasterises how far away the ground is, and `plant` what stands before it;
//!    `foliage` and `shade` give every sample its radiance, and `resolve` makes pixels of samples.
//!
//! [`Live`] draws the same scene again and again for somebody who watches, and works out only what has changed.

mod exposure;
mod live;
mod maps;
pub mod memory;
mod overlay;
mod patches;
mod population;
mod tile;

use crate::gpu::{
    self, Blend, Compute, Cull, Depth, Gpu, Image, Load, Raster, RasterState, Recorder, Targets, Topology,
    format::{D32f, Format, R32f, Rgba32f, Rgba32ui},
};
use crate::scene::{Film, Picture, Scene};
use crate::shaders::raster::{foliage, resolve, shade, terrain};

pub use exposure::Exposure;
pub use live::{Detail, Live, View};
pub use maps::Maps;
pub use overlay::{COLOURS, MATERIALS, Overlay, Scale, Shown, colour as overlay_colour};

use patches::Prepared;
use population::Crowd;
use std::ops::Range;
use tile::Tile;

/// Draws scenes. Making one compiles its programs; it can then draw any number of pictures.
pub struct Renderer {
    gpu: Gpu,
    patches: patches::Pass,
    exposure: exposure::Passes,
    maps: maps::Pass,
    population: population::Passes,
    terrain: Raster<terrain::Shader>,
    foliage: Compute<foliage::Shader>,
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
            population: population::Passes::new(gpu)?,
            terrain: Raster::new(gpu, (), &state)?,
            foliage: Compute::new(gpu, ())?,
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
        let crowd = self.population.prepare(&self.gpu, scene, &prepared)?;
        let tiles = Tile::cut(film, quality);
        let picture = Picture::new(film.width, film.height);
        Ok(Drawing { renderer: self, scene, film: *film, prepared, exposure, crowd, tiles, done: 0, picture })
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
        let (range, _) = self.range(&prepared, scene, film, tile)?;
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

    /// Draws the ground: how far away it is, and the depth that goes with it.
    fn range(
        &self,
        prepared: &Prepared,
        scene: &Scene,
        film: &Film,
        tile: Tile,
    ) -> gpu::Result<(Image<R32f>, Image<D32f>)> {
        let size = tile.sample_size();
        let range = Image::new(&self.gpu, "range", size)?;
        let depth = Image::<D32f>::new(&self.gpu, "depth", size)?;
        let mut rec = Recorder::new(&self.gpu);
        let all = 0..prepared.patches_per_side.pow(2);
        self.record_range(&mut rec, (prepared, scene), tile.clip(film), (&range, &depth), all);
        rec.submit()?.wait()?;
        Ok((range, depth))
    }

    /// Some patches of the ground, the first of them on empty images.
    fn record_range(
        &self,
        rec: &mut Recorder,
        (prepared, scene): (&Prepared, &Scene),
        [scale, offset]: [[f32; 2]; 2],
        (range, depth): (&Image<R32f>, &Image<D32f>),
        patches: Range<u32>,
    ) {
        let load = if patches.start == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
        let targets = Targets { color: &[range], depth: Some(depth), load };
        rec.render(&targets, |draws| {
            draws.draw_some(
                &self.terrain,
                4,
                patches,
                terrain::Push { scale, offset },
                terrain::Bindings {
                    frame: &prepared.frame,
                    height: &scene.ground.height,
                    patches: &prepared.patches,
                },
            );
        });
    }

    /// The pixels of a tile, row by row.
    fn draw(&self, drawing: &Drawing, tile: Tile) -> gpu::Result<Vec<[f32; 4]>> {
        let Drawing { scene, film, prepared, exposure, crowd, .. } = drawing;
        let (range, depth) = self.range(prepared, scene, film, tile)?;
        let size = tile.sample_size();
        let radiance = Image::<Rgba32f>::new(&self.gpu, "radiance", size)?;
        let origin = tile.origin.map(|at| (at * tile.samples) as i32);
        let lit = Lit { scene, prepared, exposure, crowd };
        if crowd.materials().is_some() {
            let plant = Image::new(&self.gpu, "plant", size)?;
            self.population.draw_tile(
                &self.gpu,
                crowd,
                (scene, prepared),
                tile.clip(film),
                (&range, &plant, &depth),
            )?;
            let mut rec = Recorder::new(&self.gpu);
            self.record_foliage(&mut rec, &lit, origin, (&range, &plant), &radiance);
            rec.submit()?.wait()?;
        }
        let pixels = Image::<Rgba32f>::new(&self.gpu, "pixels", tile.size)?;
        let mut rec = Recorder::new(&self.gpu);
        self.record_shade(&mut rec, &lit, origin, &range, &radiance);
        rec.dispatch(
            &self.resolve,
            tile.size,
            resolve::Push { exposure: film.exposure },
            resolve::Bindings { radiance: &radiance, picture: &pixels },
        );
        let download = rec.download(&pixels);
        let finished = rec.submit()?.wait()?;
        Ok(download.take(&finished))
    }

    /// Shades what a tile whose first sample is `origin` shows of plants.
    fn record_foliage(
        &self,
        rec: &mut Recorder,
        lit: &Lit,
        origin: [i32; 2],
        (range, plant): (&Image<R32f>, &Image<Rgba32ui>),
        radiance: &Image<Rgba32f>,
    ) {
        let Lit { prepared, exposure, crowd, .. } = lit;
        let Some(materials) = crowd.materials() else { return };
        rec.dispatch(
            &self.foliage,
            range.size(),
            foliage::Push { origin, coarse_cells: exposure.glow.size()[0] as i32 },
            foliage::Bindings {
                frame: &prepared.frame,
                panorama: &prepared.panorama,
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
            },
        );
    }

    /// Shades what a tile whose first sample is `origin` shows beside plants: ground, sea and sky.
    fn record_shade(
        &self,
        rec: &mut Recorder,
        lit: &Lit,
        origin: [i32; 2],
        range: &Image<R32f>,
        radiance: &Image<Rgba32f>,
    ) {
        let Lit { scene, prepared, exposure, crowd } = lit;
        let ground = &scene.ground;
        let coarse_cells = exposure.glow.size()[0] as i32;
        rec.dispatch(
            &self.shade,
            range.size(),
            shade::Push { origin, coarse_cells },
            shade::Bindings {
                frame: &prepared.frame,
                panorama: &prepared.panorama,
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
            },
        );
    }
}

/// A scene and the light in it.
struct Lit<'a> {
    scene: &'a Scene,
    prepared: &'a Prepared,
    exposure: &'a Exposure,
    crowd: &'a Crowd,
}

/// A picture in the making, tile by tile.
pub struct Drawing<'a> {
    renderer: &'a Renderer,
    scene: &'a Scene,
    film: Film,
    prepared: Prepared,
    exposure: Exposure,
    crowd: Crowd,
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
        let pixels = self.renderer.draw(self, tile)?;
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
