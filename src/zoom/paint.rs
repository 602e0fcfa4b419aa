//! Drawing tiles: where they lie from an eye, in whole numbers, and what the device has to know of each.

use super::{
    address::{Cell, Place},
    height::{AMPLITUDE, FRACTION_BITS, Refinement, Surface},
    marks::Marks,
    tiles::{Slot, Tiles},
    tree::{Detail, Leaf, Tree},
};
use crate::{
    core::camera::Pinhole,
    gpu::{
        self, Blend, Buffer, Cull, Depth, Gpu, Image, IndexedDraw, Load, Raster, RasterState, Recorder,
        Targets, Topology,
        format::{D32f, Format, Rgba32f},
    },
    scene::{Film, Light, light_frame, panorama, through},
    shaders::{Frame, TileMarks, TileSource, TileView, zoom::tile},
};
use glam::{DVec3, Vec3};
use std::array::from_fn;

/// Levels from a tile to the one that its heights are compared with, to tell hollows from summits.
pub(super) const RELIEF_LEVELS: u32 = 6;

/// No tile (see zoom/tile.vert).
const NO_SLOT: u32 = u32::MAX;

/// A tile without a parent: bit 16 of what the device has as borders.
const ROOT: u32 = 1 << 16;

/// Binary digits that whole numbers have behind the spacing of the finest vertices: those of a height, which is a part of its amplitude, which is
/// at least a quarter of a spacing.
const DIGITS: u32 = FRACTION_BITS + 2;

/// Digits that places in whole numbers may have. What is left of 64 are the size of the roots' patch, and slopes of up to 8.
const MOST_DIGITS: u32 = 55;

/// Tiles of so many levels are in view that places on them can't be told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "tiles of {levels} levels are in view, more than places can be told apart in: is the eye beside a cliff?"
)]
pub struct TooDeep {
    levels: u32,
}

/// What tiles are drawn with.
pub(super) struct Painter {
    gpu: Gpu,
    surface: Surface,
    detail: Detail,
    /// log₂ of the quads along a side of a tile.
    bits: u32,
    indices: Buffer<u32>,
    pass: Raster<tile::Shader>,
    /// The same with marks, if there are any, and what these are.
    marked: Option<(Marks, Raster<tile::Shader>)>,
    /// What they look like.
    looks: Buffer<TileMarks>,
}

/// How tiles are looked at.
#[derive(Clone, Copy)]
pub(super) struct Sight<'a> {
    pub lattice: &'a Lattice,
    /// Distance of the near plane, cells of the lattice's reference.
    pub near: f32,
    /// From the eye to what tiles have been selected for, in such cells.
    pub focus: [f32; 3],
    /// What marks look like, where they are seen.
    pub looks: Option<TileMarks>,
}

/// The light, and a camera as the device has it.
pub(super) struct Stage {
    light: Frame,
    pub frame: Buffer<Frame>,
    pub panorama: Buffer<[f32; 3]>,
}

/// Samples on their way to a picture: radiance (cd/m²) and the distance of the ground, 0 where there is none.
pub(super) struct Canvas {
    pub radiance: Image<Rgba32f>,
    pub depth: Image<D32f>,
}

impl Stage {
    pub fn new(gpu: &Gpu, light: &Light, film: &Film) -> gpu::Result<Stage> {
        let nowhere =
            Pinhole { eye: Vec3::ZERO, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, tangent: [1.0; 2] };
        Ok(Stage {
            light: light_frame(light, film, 1, &nowhere),
            frame: Buffer::new(gpu, "frame", 1)?,
            panorama: panorama(gpu, &light.sky)?,
        })
    }

    /// From here on pictures of `size` samples are taken through this camera.
    pub fn look(&self, rec: &mut Recorder, size: [u32; 2], camera: &Pinhole) {
        rec.upload(&self.frame, &[through(self.light, size, camera)]);
    }
}

impl Canvas {
    pub fn new(gpu: &Gpu, name: &str, size: [u32; 2]) -> gpu::Result<Canvas> {
        Ok(Canvas { radiance: Image::new(gpu, name, size)?, depth: Image::new(gpu, "depth", size)? })
    }

    pub fn size(&self) -> [u32; 2] {
        self.radiance.size()
    }
}

impl Painter {
    pub fn new(gpu: &Gpu, surface: Surface, detail: Detail, bits: u32) -> gpu::Result<Painter> {
        Ok(Painter {
            gpu: gpu.clone(),
            surface,
            detail,
            bits,
            indices: indices(gpu, bits)?,
            pass: program(gpu, surface, bits, Marks::default())?,
            marked: None,
            looks: Buffer::new(gpu, "looks of marks", 1)?,
        })
    }

    /// Which marks tiles have from now on where they are seen.
    pub fn mark(&mut self, marks: Marks) -> gpu::Result<()> {
        let marks = marks.on_tiles();
        self.marked = match self.marked.take() {
            _ if marks == Marks::default() => None,
            Some(made) if made.0 == marks => Some(made),
            _ => Some((marks, program(&self.gpu, self.surface, self.bits, marks)?)),
        };
        Ok(())
    }

    /// Draws tiles that are ready.
    pub fn draw(
        &self,
        rec: &mut Recorder,
        (canvas, load): (&Canvas, Load),
        stage: &Stage,
        tiles: &Tiles,
        sight: Sight,
        views: &[TileView],
    ) -> gpu::Result<()> {
        let targets = Targets { color: &[&canvas.radiance], depth: Some(&canvas.depth), load };
        if views.is_empty() {
            rec.render(&targets, |_| ());
            return Ok(());
        }
        let instances = Buffer::new(&self.gpu, "tiles in view", views.len())?;
        rec.upload(&instances, views);
        let (spacings, sides) = (f64::from(1u32 << self.bits), self.detail.sides());
        // Where octaves begin to go is a tile's diagonal beyond where tiles are replaced, so that those that are have all of theirs, and the new
        // ones nothing.
        let fade = [(sides + 1.5625) * spacings, 2.0 * sides * spacings];
        let push = tile::Push {
            unit: sight.lattice.unit(),
            near: sight.near,
            fade: fade.map(|spacings| spacings as f32),
            focus: sight.focus,
            slope: (self.surface.roughness.cells() / AMPLITUDE as f64) as f32,
        };
        let draw = IndexedDraw {
            indices: 0..self.indices.len() as u32,
            first_vertex: 0,
            instances: 0..views.len() as u32,
        };
        let pass = match (&self.marked, sight.looks) {
            (Some((_, marked)), Some(looks)) => {
                rec.upload(&self.looks, &[looks]);
                marked
            }
            _ => &self.pass,
        };
        let [east, south] = tiles.gradients();
        rec.render(&targets, |draws| {
            let bindings = tile::Bindings {
                frame: &stage.frame,
                panorama: &stage.panorama,
                heights: tiles.heights(),
                tiles: &instances,
                east,
                south,
                marks: &self.looks,
            };
            draws.draw_indexed(pass, &self.indices, &draw, push, bindings);
        });
        Ok(())
    }

    /// What the device has to know of a leaf. `None` if its tile or one that it is compared with is not there.
    pub fn view(&self, tiles: &Tiles, place: &Place, lattice: &Lattice, leaf: &Leaf) -> Option<TileView> {
        let Leaf { cell, borders, .. } = *leaf;
        let slot = tiles.slot(cell)?;
        let level = cell.level + self.bits;
        let parent = place.parent(cell);
        let own = self.source(tiles, place, cell, slot)?;
        let before = match parent {
            Some(parent) => self.source(tiles, place, parent, tiles.slot(parent)?)?,
            None => own,
        };
        let first = |coordinate: u64| {
            let first = coordinate << self.bits;
            [first as u32, (first >> 32) as u32]
        };
        Some(TileView {
            origin: lattice.origin(cell, slot.base, self.bits),
            own,
            parent: before,
            quarter: [cell.x, cell.z].map(|coordinate| (coordinate & 1) as u32),
            shift: lattice.level - level,
            height_shift: lattice.height_shift(level),
            level,
            key: self.surface.octave(level).key(),
            x: first(cell.x),
            z: first(cell.z),
            borders: borders.0 | if parent.is_none() { ROOT } else { 0 },
            spacing: lattice.spacing(level),
        })
    }

    /// A tile, and the one that its heights are compared with. `None` if that is not there.
    fn source(&self, tiles: &Tiles, place: &Place, cell: Cell, slot: Slot) -> Option<TileSource> {
        let level = cell.level + self.bits;
        let unit = |levels: u32| 1.0 / (AMPLITUDE << levels) as f32;
        if cell.level < RELIEF_LEVELS {
            // With the datum, from which all octaves together are at most two amplitudes of the first.
            let (rise, relief) = (slot.base as i32, unit(level + 1));
            return Some(TileSource { slot: slot.index, reference: NO_SLOT, first: [0; 2], rise, relief });
        }
        let reference = (0..RELIEF_LEVELS).try_fold(cell, |cell, _| place.parent(cell));
        let coarse = tiles.slot(reference?)?;
        let first = |coordinate: u64| ((coordinate % (1 << RELIEF_LEVELS)) << self.bits) as u32;
        Some(TileSource {
            slot: slot.index,
            reference: coarse.index,
            first: [first(cell.x), first(cell.z)],
            rise: slot.base.wrapping_sub(coarse.base << RELIEF_LEVELS) as i32,
            relief: unit(RELIEF_LEVELS),
        })
    }
}

/// Places in whole numbers: from the eye, in cells of a level so fine that the heights of all vertices are whole numbers of them. A vertex is the same
/// number in all tiles that have it.
pub(super) struct Lattice {
    /// Whose cells are the unit.
    level: u32,
    /// Whose cells lengths are told in.
    reference: u32,
    surface: Surface,
    /// The eye: east, up, south, modulo 2⁶⁴.
    eye: [u64; 3],
}

impl Lattice {
    /// For an eye at a place and the tiles around it, and for eyes as near to the ground as tiles of a level that is `least` need.
    pub fn new(
        surface: Surface,
        place: &Place,
        leaves: &[Leaf],
        (reference, least): (u32, u32),
        bits: u32,
    ) -> Result<Lattice, TooDeep> {
        let levels = leaves.iter().map(|leaf| leaf.cell.level);
        let (coarsest, finest) = (levels.clone().min().unwrap_or(0), levels.max().unwrap_or(0));
        let finest = finest.max(least);
        let level = finest + bits + DIGITS;
        if level - coarsest > MOST_DIGITS {
            return Err(TooDeep { levels: finest - coarsest });
        }
        Ok(Lattice { level, reference, surface, eye: whole(&surface, place, level) })
    }

    /// From the eye to another place, cells of the reference.
    pub fn to(&self, place: &Place) -> [f32; 3] {
        let there = whole(&self.surface, place, self.level);
        from_fn(|axis| there[axis].wrapping_sub(self.eye[axis]) as i64 as f32 * self.unit())
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

    /// The unit, cells of the reference.
    fn unit(&self) -> f32 {
        libm::exp2f((i64::from(self.reference) - i64::from(self.level)) as f32)
    }

    /// Of vertices of a level, cells of the reference.
    fn spacing(&self, level: u32) -> f32 {
        libm::exp2f((i64::from(self.reference) - i64::from(level)) as f32)
    }
}

/// East, up and south of a place in cells of a level, modulo 2⁶⁴.
fn whole(surface: &Surface, place: &Place, level: u32) -> [u64; 3] {
    // Amplitudes are shorter than cells.
    let up = place.y.slice(level - surface.roughness.halvings());
    [place.x.slice(level), up, place.z.slice(level)]
}

/// What a camera sees: the normals of its sides, which point inwards; it sees nothing behind itself either.
pub(super) struct Frustum([DVec3; 5]);

impl Frustum {
    pub fn new(camera: &Pinhole) -> Frustum {
        let [right, up, forward] = [camera.right, camera.up, camera.forward].map(Vec3::as_dvec3);
        // A little wider, since the device's numbers are rounded.
        let [across, upward] = camera.tangent.map(|tangent| f64::from(tangent) * 1.0001);
        Frustum([
            forward,
            forward * across + right,
            forward * across - right,
            forward * upward + up,
            forward * upward - up,
        ])
    }

    /// Whether the box around a leaf is not wholly outside one of the sides.
    pub fn has(&self, tree: &Tree, leaf: &Leaf) -> bool {
        let Some(eye) = tree.eye(leaf.cell.level) else { return true };
        let [low, high] = eye.bounds(leaf.cell.x, leaf.cell.z, leaf.corners).map(DVec3::from_array);
        self.0.iter().all(|side| (*side * low).max(*side * high).element_sum() >= 0.0)
    }
}

/// The program that draws tiles, with marks on them.
fn program(gpu: &Gpu, surface: Surface, bits: u32, marks: Marks) -> gpu::Result<Raster<tile::Shader>> {
    let bilinear = surface.refinement == Refinement::Bilinear;
    let Marks { levels, borders, wireframe, .. } = marks;
    Raster::new(gpu, tile::Constants { bits, bilinear, levels, borders, wireframe }, &STATE)
}

/// How all is drawn that is seen.
pub(super) const STATE: RasterState = RasterState {
    color: &[Rgba32f::VK],
    depth: Depth::TestWrite,
    topology: Topology::Triangles,
    // Nothing below is seen. Triangles smaller than a pixel may turn over when devices round their corners, though, and culling them leaves holes.
    cull: Cull::None,
    blend: Blend::None,
};

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
