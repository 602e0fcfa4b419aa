//! Marks on pictures that show how they are made: which tiles there are, of which levels and triangles, and what the processor knows of them.

use super::{
    address::Place,
    height::{AMPLITUDE, Surface},
    paint::{Canvas, STATE, Stage},
    tree::{Eye, Leaf},
};
use crate::{
    core::color::linear_from_srgb,
    gpu::{self, Buffer, Draw, Gpu, Load, Raster, Recorder, Targets},
    shaders::{TileMarks, ZoomLine, zoom::line},
};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// What is seen beside the surface. The background has no marks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// Tiles have the colours of their levels.
    pub levels: bool,
    /// Lines around tiles,
    pub borders: bool,
    /// and around triangles.
    pub wireframe: bool,
    /// The box around all that the surface can come to in a tile.
    pub boxes: bool,
    /// Heights of tiles' corners, as the processor has them.
    pub corners: bool,
    /// What is far away is left out.
    pub no_background: bool,
}

impl Marks {
    /// Those that are drawn with tiles.
    pub(super) fn on_tiles(self) -> Marks {
        let Marks { levels, borders, wireframe, .. } = self;
        Marks { levels, borders, wireframe, ..Marks::default() }
    }

    /// Whether there are lines beside tiles.
    pub(super) fn has_lines(self) -> bool {
        self.boxes || self.corners
    }
}

/// Colours that all can tell apart, sRGB: those of Okabe & Ito, "Color Universal Design", 2002, so that neighbours are not alike.
const COLOURS: [[u8; 3]; 7] = [
    [230, 159, 0],
    [0, 114, 178],
    [240, 228, 66],
    [204, 121, 167],
    [0, 158, 115],
    [213, 94, 0],
    [86, 180, 233],
];

/// The colour of a level, sRGB: there are few, which take turns.
pub fn colour(level: u32) -> [u8; 3] {
    COLOURS[level as usize % COLOURS.len()]
}

/// The same in linear light.
fn linear(colour: [u8; 3]) -> Vec3 {
    Vec3::from_array(colour.map(|channel| linear_from_srgb(f32::from(channel) / 255.0)))
}

/// Of lines around tiles and triangles.
const BORDER: [u8; 3] = [255, 190, 0];
const EDGE: [u8; 3] = [20, 140, 235];
/// Of what tells a corner's height.
const CORNER: [u8; 3] = [225, 0, 130];

/// Width of a line, parts of a picture's height, so that it looks the same in all sizes; but never less than a sample.
const WIDTH: f32 = 1.0 / 700.0;

fn width(canvas: &Canvas) -> f32 {
    (canvas.size()[1] as f32 * WIDTH).max(1.0)
}

/// What marks on tiles look like in a picture of this exposure.
pub(super) fn looks(canvas: &Canvas, exposure: f32) -> TileMarks {
    TileMarks {
        levels: COLOURS.map(|colour| linear(colour).to_array()),
        border: (linear(BORDER) / exposure).to_array(),
        edge: (linear(EDGE) / exposure).to_array(),
        width: width(canvas),
    }
}

/// Draws lines among tiles.
pub(super) struct Lines {
    gpu: Gpu,
    pass: Raster<line::Shader>,
}

impl Lines {
    pub fn new(gpu: &Gpu) -> gpu::Result<Lines> {
        Ok(Lines { gpu: gpu.clone(), pass: Raster::new(gpu, (), &STATE)? })
    }

    /// Draws them over tiles that have been drawn, hidden by what is nearer; `near` is the distance of the near plane.
    pub fn draw(
        &self,
        rec: &mut Recorder,
        canvas: &Canvas,
        stage: &Stage,
        near: f32,
        lines: &[ZoomLine],
    ) -> gpu::Result<()> {
        if lines.is_empty() {
            return Ok(());
        }
        let buffer = Buffer::new(&self.gpu, "lines", lines.len())?;
        rec.upload(&buffer, lines);
        let draw = Draw { vertices: 6, instances: lines.len() as u32 };
        let push = line::Push { near, width: 1.5 * width(canvas) };
        let bindings = line::Bindings { frame: &stage.frame, lines: &buffer };
        let targets = Targets { color: &[&canvas.radiance], depth: Some(&canvas.depth), load: Load::Keep };
        rec.render(&targets, |draws| draws.draw(&self.pass, draw, push, bindings));
        Ok(())
    }
}

/// The lines of tiles as they are seen from a place, in cells of the level `reference`, in a picture of this exposure.
pub(super) fn lines<'a>(
    marks: Marks,
    leaves: impl Iterator<Item = &'a Leaf>,
    (surface, place): (&Surface, &Place),
    reference: u32,
    exposure: f32,
) -> Vec<ZoomLine> {
    let mut eyes = HashMap::new();
    let mut lines = Vec::new();
    for leaf in leaves {
        let level = leaf.cell.level;
        let eye = eyes.entry(level).or_insert_with(|| Eye::new(surface, place, level));
        let scale = libm::exp2(f64::from(reference) - f64::from(level));
        let mut add = |[from, to]: [DVec3; 2], colour: [u8; 3]| {
            let [from, to] = [from, to].map(|end| (end * scale).as_vec3().to_array());
            lines.push(ZoomLine { from, to, colour: (linear(colour) / exposure).to_array() });
        };
        if marks.boxes {
            edges(eye, leaf).into_iter().for_each(|edge| add(edge, colour(level)));
        }
        if marks.corners {
            (0..4).flat_map(|corner| signs(eye, leaf, corner)).for_each(|line| add(line, CORNER));
        }
    }
    lines
}

/// The edges of a leaf's box, in its cells.
fn edges(eye: &Eye, leaf: &Leaf) -> [[DVec3; 2]; 12] {
    let [low, high] = eye.bounds(leaf.cell.x, leaf.cell.z, leaf.corners).map(DVec3::from_array);
    std::array::from_fn(|index| {
        // Four along each axis: of the other two, a bit each.
        let (axis, bits) = (index / 4, index % 4);
        let mut from = low;
        for (bit, other) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
            if bits >> bit & 1 == 1 {
                from[other] = high[other];
            }
        }
        let mut to = from;
        to[axis] = high[axis];
        [from, to]
    })
}

/// A cross at the height of a leaf's corner, in its cells; the post is as long as octaves to come may move the surface there.
fn signs(eye: &Eye, leaf: &Leaf, corner: usize) -> [[DVec3; 2]; 3] {
    const ARM: f64 = 1.0 / 16.0;
    let [x, z] = [(leaf.cell.x, corner % 2), (leaf.cell.z, corner / 2)]
        .map(|(first, step)| first.wrapping_add(step as u64));
    let height = leaf.corners.0[corner];
    let at = |height: i64| DVec3::from_array(eye.to(x, height, z));
    let middle = at(height);
    let arm = |along: DVec3| [middle - along * ARM, middle + along * ARM];
    let post = [at(height.wrapping_sub(AMPLITUDE)), at(height.wrapping_add(AMPLITUDE))];
    [post, arm(DVec3::X), arm(DVec3::Z)]
}
