//! Pictures of the surface: which tiles are drawn, where they lie from the eye, and how they are drawn.
//!
//! A picture depends on the surface, the view, the settings and the light alone. What is kept from one picture to the next are tiles and patches, and
//! these come again, bit for bit.

use super::{
    address::{Attitude, Cell, Location, Place},
    height::{AMPLITUDE, FRACTION_BITS, Patch, Spine, Surface},
    motion::{Buried, Clearance, Distance, clearance},
    tiles::{Heights, Made, Slot, Tiles},
    tree::{Detail, Leaf, TooMany, Tree},
};
use crate::{
    core::camera::Pinhole,
    gpu::{
        self, Blend, Buffer, Compute, Cull, Depth, Gpu, Image, IndexedDraw, Load, Raster, RasterState,
        Recorder, Targets, Topology,
        format::{D32f, Format, Rgba32f},
    },
    scene::{Film, Light, Picture, light_frame, panorama},
    shaders::{
        Frame, TileSource, TileView,
        zoom::{develop, tile},
    },
};
use glam::{DVec3, Vec3};

/// Levels from a tile to the one that its heights are compared with, to tell hollows from summits.
const RELIEF_LEVELS: u32 = 4;

/// No tile (see zoom/tile.vert).
const NO_SLOT: u32 = u32::MAX;

/// A tile without a parent: bit 16 of what the device has as borders.
const ROOT: u32 = 1 << 16;

/// Cells of level 0 around the place that there are tiles for.
const PLAIN: i64 = 16;

/// Binary digits that whole numbers have behind the spacing of the finest vertices: those of a height, which is a part of its amplitude, which is
/// at least a quarter of a spacing.
const DIGITS: u32 = FRACTION_BITS + 2;

/// Digits that places in whole numbers may have. What is left of 64 are the size of the roots' patch, and slopes of up to 8.
const MOST_DIGITS: u32 = 55;

/// How a surface is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// log₂ of the quads along a side of a tile.
    pub bits: u32,
    pub detail: Detail,
    /// Octaves of distance, from that to the surface on, to where nothing is seen but sky.
    pub octaves: u32,
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
    #[error(
        "tiles of {levels} levels are in view, more than places can be told apart in: is the eye beside a cliff?"
    )]
    Range { levels: u32 },
}

/// A picture, and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    pub picture: Picture,
    /// To the surface.
    pub altitude: Distance,
    /// Tiles looked at, in all directions.
    pub leaves: usize,
    /// Those in the picture.
    pub drawn: usize,
    /// Those that were not there.
    pub made: usize,
}

/// Draws a surface.
pub struct Renderer {
    gpu: Gpu,
    settings: Settings,
    spine: Spine,
    tiles: Tiles,
    indices: Buffer<u32>,
    pass: Raster<tile::Shader>,
    develop: Compute<develop::Shader>,
}

/// What a view shows.
#[derive(Clone, Debug)]
pub struct Selection {
    pub tree: Tree,
    /// To the surface.
    pub altitude: Distance,
    /// Octaves of distance from there on to where nothing is seen but sky.
    pub octaves: f32,
}

/// Camera and light, as the device has them.
struct Lit {
    frame: Buffer<Frame>,
    panorama: Buffer<[f32; 3]>,
}

impl Lit {
    fn new(gpu: &Gpu, light: &Light, film: &Film, samples: u32, camera: &Pinhole) -> gpu::Result<Lit> {
        let frame = Buffer::new(gpu, "frame", 1)?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&frame, &[light_frame(light, film, samples, camera)]);
        rec.submit()?.wait()?;
        Ok(Lit { frame, panorama: panorama(gpu, &light.sky)? })
    }
}

impl Renderer {
    /// # Errors
    /// If the device has no room for so many tiles.
    pub fn new(gpu: &Gpu, surface: Surface, settings: Settings) -> gpu::Result<Renderer> {
        let state = RasterState {
            color: &[Rgba32f::VK],
            depth: Depth::TestWrite,
            topology: Topology::Triangles,
            cull: Cull::Back,
            blend: Blend::None,
        };
        Ok(Renderer {
            gpu: gpu.clone(),
            settings,
            spine: Spine::new(surface),
            tiles: Tiles::new(gpu, surface, settings.bits, settings.slots)?,
            indices: indices(gpu, settings.bits)?,
            pass: Raster::new(gpu, tile::Constants { bits: settings.bits }, &state)?,
            develop: Compute::new(gpu, ())?,
        })
    }

    /// Patches of the surface, for flights.
    pub fn spine(&mut self) -> &mut Spine {
        &mut self.spine
    }

    /// Forgets all tiles and patches.
    pub fn clear(&mut self) {
        self.tiles.clear();
        self.spine = Spine::new(*self.spine.surface());
    }

    /// The picture of a view, with all of its tiles.
    ///
    /// # Errors
    /// If the eye is below the surface or too near to it, or what the device has no memory for.
    pub fn render(&mut self, view: &View, light: &Light, film: &Film) -> Result<Shot, Error> {
        let Settings { samples, .. } = self.settings;
        let selection = self.select(view)?;
        let made = self.make(view, &selection.tree)?;
        let camera = camera(view, film);
        let lit = Lit::new(&self.gpu, light, film, samples, &camera)?;
        let (radiance, drawn) = self.draw(view, &selection, &camera, &lit, film)?;
        let Lit { frame, panorama } = &lit;
        let size = [film.width, film.height];
        let pixels = Image::<Rgba32f>::new(&self.gpu, "pixels", size)?;
        let mut rec = Recorder::new(&self.gpu);
        rec.dispatch(
            &self.develop,
            size,
            develop::Push { side: samples as i32, exposure: film.exposure },
            develop::Bindings { frame, panorama, radiance: &radiance, picture: &pixels },
        );
        let download = rec.download(&pixels);
        let pixels = download.take(&rec.submit()?.wait()?);
        let mut picture = Picture::new(film.width, film.height);
        picture.place([0, 0], film.width, &pixels);
        let Selection { tree, altitude, .. } = selection;
        Ok(Shot { picture, altitude, leaves: tree.leaves().len(), drawn, made })
    }

    /// The distance of the ground for every sample of a picture, in cells of the altitude's level, row by row; 0 where there is none.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn ranges(&mut self, view: &View, light: &Light, film: &Film) -> Result<Vec<f32>, Error> {
        let selection = self.select(view)?;
        self.make(view, &selection.tree)?;
        let camera = camera(view, film);
        let lit = Lit::new(&self.gpu, light, film, self.settings.samples, &camera)?;
        let (radiance, _) = self.draw(view, &selection, &camera, &lit, film)?;
        let mut rec = Recorder::new(&self.gpu);
        let download = rec.download(&radiance);
        let samples = download.take(&rec.submit()?.wait()?);
        Ok(samples.into_iter().map(|[.., range]| range).collect())
    }

    /// The tiles in a picture of this shape, from coarse to fine, with all their heights, and how far the surface is.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn seen(&mut self, view: &View, film: &Film) -> Result<(Distance, Vec<(Leaf, Heights)>), Error> {
        let Selection { tree, altitude, .. } = self.select(view)?;
        self.make(view, &tree)?;
        let sides = sides(&camera(view, film));
        let leaves: Vec<Leaf> = tree.leaves().into_iter().filter(|leaf| is_in(&tree, leaf, &sides)).collect();
        let heights = self.tiles.read(&self.gpu, leaves.iter().map(|leaf| leaf.cell))?;
        Ok((altitude, leaves.into_iter().zip(heights).collect()))
    }

    /// Which tiles a view shows.
    ///
    /// # Errors
    /// If the eye is below the surface or too near to it.
    pub fn select(&mut self, view: &View) -> Result<Selection, Error> {
        let Settings { octaves, slots, detail, .. } = self.settings;
        let surface = *self.spine.surface();
        let place = &view.place;
        let altitude = match clearance(&mut self.spine, place, view.level) {
            Some(Clearance { distance, is_above: true }) => distance,
            _ => return Err(Buried.into()),
        };
        let root = altitude.level.saturating_sub(octaves);
        let octaves = octaves as f32;
        if root > 0 {
            let patch = self.spine.patch(place, root);
            let tree = Tree::new(&surface, place, patch, detail, slots as usize)?;
            return Ok(Selection { tree, altitude, octaves });
        }
        let [x, z] = [&place.x, &place.z].map(|number| number.whole().wrapping_sub(PLAIN));
        let patch = Patch::start(&surface, x, z, 2 * PLAIN as usize + 1);
        let tree = Tree::new(&surface, place, &patch, detail, slots as usize)?;
        // There is sky where the plain ends.
        let to_end = libm::log2(PLAIN as f64) + altitude.depth();
        Ok(Selection { tree, altitude, octaves: (to_end as f32).clamp(0.01, octaves) })
    }

    /// Makes the tiles that are not there; returns how many.
    fn make(&mut self, view: &View, tree: &Tree) -> Result<usize, Error> {
        let mut rec = Recorder::new(&self.gpu);
        let Made { tiles, waiting } =
            self.tiles.make(&mut rec, &mut self.spine, &view.place, tree.nodes(), usize::MAX);
        rec.submit()?.wait()?;
        match waiting {
            0 => Ok(tiles),
            _ => Err(Error::Slots { needed: tree.nodes().count(), slots: self.settings.slots }),
        }
    }

    /// Radiance and distance of every sample, and how many tiles were drawn.
    fn draw(
        &self,
        view: &View,
        selection: &Selection,
        camera: &Pinhole,
        lit: &Lit,
        film: &Film,
    ) -> Result<(Image<Rgba32f>, usize), Error> {
        let Selection { altitude, octaves, tree } = selection;
        let Settings { bits, samples, detail, .. } = self.settings;
        let surface = self.spine.surface();
        let leaves = tree.leaves();
        let lattice = Lattice::new(&view.place, *surface, &leaves, altitude.level, bits)?;
        let sides = sides(camera);
        let seen: Vec<TileView> = leaves
            .iter()
            .filter(|leaf| is_in(tree, leaf, &sides))
            .filter_map(|leaf| self.tile_view(&view.place, &lattice, leaf))
            .collect();

        let size = [film.width * samples, film.height * samples];
        let radiance = Image::new(&self.gpu, "radiance", size)?;
        let depth = Image::<D32f>::new(&self.gpu, "depth", size)?;
        let instances = Buffer::new(&self.gpu, "tiles in view", seen.len().max(1))?;
        let mut rec = Recorder::new(&self.gpu);
        if !seen.is_empty() {
            rec.upload(&instances, &seen);
        }
        let targets = Targets { color: &[&radiance], depth: Some(&depth), load: Load::Clear([0.0; 4]) };
        let side = f64::from(1u32 << bits);
        // Where octaves begin to go is a tile's diagonal beyond where tiles are replaced, so that those that are have all of theirs, and the new
        // ones nothing.
        let fade = [detail.sides() * side + 1.5625 * side, 2.0 * detail.sides() * side];
        let push = tile::Push {
            unit: lattice.unit(),
            near: libm::exp2(libm::log2(altitude.cells).floor()) as f32 / 4.0,
            altitude: altitude.cells as f32,
            octaves: *octaves,
            fade: fade.map(|spacings| spacings as f32),
            slope: (surface.roughness.cells() / AMPLITUDE as f64) as f32,
        };
        let draw = IndexedDraw {
            indices: 0..self.indices.len() as u32,
            first_vertex: 0,
            instances: 0..seen.len() as u32,
        };
        let [east, south] = self.tiles.gradients();
        rec.render(&targets, |draws| {
            let bindings = tile::Bindings {
                frame: &lit.frame,
                panorama: &lit.panorama,
                heights: self.tiles.heights(),
                tiles: &instances,
                east,
                south,
            };
            draws.draw_indexed(&self.pass, &self.indices, &draw, push, bindings);
        });
        rec.submit()?.wait()?;
        Ok((radiance, seen.len()))
    }

    /// What the device has to know of a leaf. `None` if its tile is not there.
    fn tile_view(&self, place: &Place, lattice: &Lattice, leaf: &Leaf) -> Option<TileView> {
        let Leaf { cell, borders, .. } = *leaf;
        let bits = self.settings.bits;
        let slot = self.tiles.slot(cell)?;
        let level = cell.level + bits;
        let parent = place.parent(cell).and_then(|parent| Some((parent, self.tiles.slot(parent)?)));
        let own = self.source(place, cell, slot);
        let first = |coordinate: u64| {
            let first = coordinate << bits;
            [first as u32, (first >> 32) as u32]
        };
        Some(TileView {
            origin: lattice.origin(cell, slot.base, bits),
            own,
            parent: parent.map_or(own, |(parent, slot)| self.source(place, parent, slot)),
            quarter: [cell.x, cell.z].map(|coordinate| (coordinate & 1) as u32),
            shift: lattice.level - level,
            height_shift: lattice.height_shift(level),
            level,
            key: self.spine.surface().octave(level).key(),
            x: first(cell.x),
            z: first(cell.z),
            borders: borders.0 | if parent.is_none() { ROOT } else { 0 },
            spacing: lattice.spacing(level),
        })
    }

    /// A tile, and the one that its heights are compared with.
    fn source(&self, place: &Place, cell: Cell, slot: Slot) -> TileSource {
        let bits = self.settings.bits;
        let level = cell.level + bits;
        let unit = |levels: u32| 1.0 / (AMPLITUDE << levels) as f32;
        if cell.level < RELIEF_LEVELS {
            // With the datum.
            let (rise, relief) = (slot.base as i32, unit(level + 1));
            return TileSource { slot: slot.index, reference: NO_SLOT, first: [0; 2], rise, relief };
        }
        let reference = (0..RELIEF_LEVELS).try_fold(cell, |cell, _| place.parent(cell));
        let Some(coarse) = reference.and_then(|cell| self.tiles.slot(cell)) else {
            // So far away that only sky is seen.
            return TileSource { slot: slot.index, reference: NO_SLOT, first: [0; 2], rise: 0, relief: 0.0 };
        };
        let first = |coordinate: u64| ((coordinate % (1 << RELIEF_LEVELS)) << bits) as u32;
        TileSource {
            slot: slot.index,
            reference: coarse.index,
            first: [first(cell.x), first(cell.z)],
            rise: slot.base.wrapping_sub(coarse.base << RELIEF_LEVELS) as i32,
            relief: unit(RELIEF_LEVELS),
        }
    }
}

/// Places in whole numbers: from the eye, in cells of a level so fine that the heights of all vertices are whole numbers of them. A vertex is the same
/// number in all tiles that have it.
struct Lattice {
    /// Whose cells are the unit.
    level: u32,
    /// That of the altitude.
    reference: u32,
    surface: Surface,
    /// The eye: east, up, south, modulo 2⁶⁴.
    eye: [u64; 3],
}

impl Lattice {
    fn new(
        place: &Place,
        surface: Surface,
        leaves: &[Leaf],
        reference: u32,
        bits: u32,
    ) -> Result<Lattice, Error> {
        let levels = leaves.iter().map(|leaf| leaf.cell.level);
        let (coarsest, finest) = (levels.clone().min().unwrap_or(0), levels.max().unwrap_or(0));
        let level = finest + bits + DIGITS;
        if level - coarsest > MOST_DIGITS {
            return Err(Error::Range { levels: finest - coarsest });
        }
        // Amplitudes are shorter than cells.
        let up = place.y.slice(level - surface.roughness.halvings());
        let eye = [place.x.slice(level), up, place.z.slice(level)];
        Ok(Lattice { level, reference, surface, eye })
    }

    /// From the eye to a cell's lower corner, at a height in the unit of vertices `bits` finer.
    fn origin(&self, cell: Cell, height: i64, bits: u32) -> [i64; 3] {
        let horizontal = |coordinate: u64| coordinate << (self.level - cell.level);
        let up = (height as u64) << self.height_shift(cell.level + bits);
        let [east, eye_up, south] = self.eye;
        [
            horizontal(cell.x).wrapping_sub(east) as i64,
            up.wrapping_sub(eye_up) as i64,
            horizontal(cell.z).wrapping_sub(south) as i64,
        ]
    }

    /// log₂ of a unit of height of a level.
    fn height_shift(&self, level: u32) -> u32 {
        self.level - level - FRACTION_BITS - self.surface.roughness.halvings()
    }

    /// The unit, cells of the altitude's level.
    fn unit(&self) -> f32 {
        libm::exp2f((i64::from(self.reference) - i64::from(self.level)) as f32)
    }

    /// Of vertices of a level, cells of the altitude's level.
    fn spacing(&self, level: u32) -> f32 {
        libm::exp2f((i64::from(self.reference) - i64::from(level)) as f32)
    }
}

fn camera(view: &View, film: &Film) -> Pinhole {
    let [right, up, forward] = view.attitude.axes().map(DVec3::as_vec3);
    let tangent = libm::tanf(view.fov / 2.0);
    let aspect = film.width as f32 / film.height as f32;
    Pinhole { eye: Vec3::ZERO, right, up, forward, tangent: [tangent * aspect, tangent] }
}

/// The sides of what a camera sees, as normals that point inwards; it sees nothing behind itself either.
fn sides(camera: &Pinhole) -> [DVec3; 5] {
    let [right, up, forward] = [camera.right, camera.up, camera.forward].map(Vec3::as_dvec3);
    // A little wider, since the device's numbers are rounded.
    let [across, upward] = camera.tangent.map(|tangent| f64::from(tangent) * 1.0001);
    [
        forward,
        forward * across + right,
        forward * across - right,
        forward * upward + up,
        forward * upward - up,
    ]
}

/// Whether the box around a leaf is not wholly outside one of the sides.
fn is_in(tree: &Tree, leaf: &Leaf, sides: &[DVec3]) -> bool {
    let Some(eye) = tree.eye(leaf.cell.level) else { return true };
    let [low, high] = eye.bounds(leaf.cell.x, leaf.cell.z, leaf.corners).map(DVec3::from_array);
    let is_inside = |side: &DVec3| (*side * low).max(*side * high).element_sum() >= 0.0;
    sides.iter().all(is_inside)
}

/// Two triangles a quad, their diagonals in a checkerboard ([`rises`](super::height::rises)), counter-clockwise from above.
fn indices(gpu: &Gpu, bits: u32) -> gpu::Result<Buffer<u32>> {
    let side = 1u32 << bits;
    let quad = |row: u32, column: u32| {
        let first = row * (side + 1) + column;
        let [a, b, c, d] = [first, first + 1, first + side + 1, first + side + 2];
        if (row ^ column) & 1 == 0 { [a, c, d, a, d, b] } else { [a, c, b, b, c, d] }
    };
    let all: Vec<u32> =
        (0..side).flat_map(|row| (0..side).flat_map(move |column| quad(row, column))).collect();
    let buffer = Buffer::new(gpu, "quads of a tile", all.len())?;
    let mut rec = Recorder::new(gpu);
    rec.upload(&buffer, &all);
    rec.submit()?.wait()?;
    Ok(buffer)
}
