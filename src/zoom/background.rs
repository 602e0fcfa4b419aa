//! What is far away, as pictures of all directions: layers of eight levels each, laid over one another.
//!
//! A layer is taken from a *canonical* eye, the middle of a grid cell that the place is in, and serves all places in that cell, from which it differs by
//! less than a third of a pixel. So a background depends on where the place is and on nothing else, not on the way that led there: what is kept is kept for speed alone.
//! Haze hides all that is more octaves away than a view has, so that a background has as few layers as these take; older ones may lie below them,
//! and don't show.
//!
//! Layer n begins around the roots of the foreground at level 8n (or the nearer layer's) and ends at the roots of level 8 (n − 1). It reaches further in than
//! what lies over it, so that nothing shows between the two.

use super::{
    address::{Cell, Fixed, Place},
    height::{Corners, Patch, Spine, Surface},
    motion::Distance,
    paint::{Canvas, Frustum, Lattice, Painter, RELIEF_LEVELS, Sight, Stage},
    tiles::{Made, Tiles},
    tree::{Detail, Leaf, TooMany, Tree},
    view::{Bill, Error, recorder, wait},
};
use crate::{
    core::camera::Pinhole,
    gpu::{self, Compute, Gpu, Layers, Load, Recorder, format::Rgba16f},
    scene::Film,
    shaders::zoom::layer,
};
use glam::Vec3;

/// Levels of a layer.
const LEVELS: u32 = 8;

/// log₂ of how many sides of a canonical eye's cell a layer's nearest ground is away: √3 / 2 · 2⁻¹² radians are 0.26 pixels of 1440 rows in 60°.
const CELLS_AWAY: u32 = 12;

/// Levels from the roots of the foreground to that of an altitude, at least: half a cell of the canonical eye's, so that one serves for some way.
const ALTITUDE: u32 = CELLS_AWAY + 1;

/// Backgrounds that are kept: of the place, of one that it comes to, and of one that it was at.
pub const KEPT: usize = 3;

/// Cells of level 0 around the place that there are tiles for.
const PLAIN: i64 = 16;

/// Octaves that the plain's end is away from the place, at least: log₂ 15, since the place may be at its cell's border.
pub(super) const PLAIN_OCTAVES: f64 = 3.906_890_595_608_519;

/// Layers that show through `octaves` of haze.
pub fn layers(octaves: u32) -> u32 {
    octaves.saturating_sub(ALTITUDE - 1).div_ceil(LEVELS)
}

/// Texels along the edge of a face: at its middle as large as a picture's pixels in the middle, and half as many again.
pub fn side(film: &Film, fov: f32) -> u32 {
    // Half a face is seen in a tangent of 1.
    let side = 1.5 * film.height as f32 / libm::tanf(fov / 2.0).max(1e-3);
    (side as u32).next_multiple_of(64).min(MOST_SIDE)
}

/// Of a background of 200 MB.
const MOST_SIDE: u32 = 2048;

/// The nearest layer behind a foreground, counted from 1; 0 if the foreground is all there is.
pub fn nearest(altitude: Distance) -> u32 {
    altitude.level.saturating_sub(ALTITUDE) / LEVELS
}

/// The level of a foreground's roots, or of the roots of the layer that is as much nearer.
pub fn root(layer: u32) -> u32 {
    layer * LEVELS
}

/// Cells from the place's that roots reach to each side. Beyond, a tile of their level would show what is coarser.
fn reach(detail: Detail) -> u64 {
    detail.sides().ceil() as u64
}

/// The roots of a tree around a place.
pub fn roots(spine: &mut Spine, place: &Place, layer: u32, detail: Detail) -> Patch {
    if layer == 0 {
        let [x, z] = [&place.x, &place.z].map(|number| number.whole().wrapping_sub(PLAIN));
        return Patch::start(spine.surface(), x, z, 2 * PLAIN as usize + 1);
    }
    let level = root(layer);
    let reach = reach(detail);
    let [x, z] = [&place.x, &place.z].map(|number| number.slice(level).wrapping_sub(reach));
    let patch = spine.patch(place, level);
    patch.part(x, z, 2 * reach as usize + 2).unwrap_or_else(|| patch.clone())
}

/// The tiles above the roots that these and their parents are compared with, from coarse to fine.
pub fn above(spine: &mut Spine, place: &Place, roots: &Patch) -> Vec<(Cell, Corners)> {
    let mut above = Vec::new();
    for level in roots.level().saturating_sub(RELIEF_LEVELS + 1)..roots.level() {
        let up = roots.level() - level;
        let patch = spine.patch(place, level);
        let ancestor = |[column, row]: [usize; 2]| {
            let cell = roots.cell(column, row);
            (0..up).try_fold(cell, |cell, _| place.parent(cell))
        };
        let last = roots.size - 2;
        let [Some(first), Some(end)] = [[0, 0], [last, last]].map(ancestor) else { continue };
        let [wide, deep] = [end.x.wrapping_sub(first.x), end.z.wrapping_sub(first.z)];
        let cells = (0..=deep).flat_map(|south| (0..=wide).map(move |east| (east as i64, south as i64)));
        above.extend(cells.filter_map(|(east, south)| {
            let cell = first.beside(east, south);
            let [column, row] = patch.find(cell)?;
            Some((cell, patch.corners(column, row)))
        }));
    }
    above
}

/// Which canonical eye a layer is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Key {
    layer: u32,
    cell: Cell,
    /// Which cell upwards, modulo 2⁶⁴.
    up: u64,
}

/// A layer's grid: each layer's is shifted by its own share of a cell, so that no place is beside the cell walls of all.
struct Grid {
    level: u32,
    /// In 2⁻⁹ of a cell.
    shift: [i64; 3],
}

/// Binary digits of a shift.
const SHIFT_BITS: u32 = 9;

impl Grid {
    fn new(surface: &Surface, layer: u32) -> Grid {
        // Cells are 2⁻¹² of the distance of the layer's nearest ground, two cells of its roots.
        let octave = surface.octave(layer);
        Grid {
            level: root(layer) + CELLS_AWAY - 1,
            shift: [1, 2, 3].map(|axis| (i64::from(octave.at(axis, 0)) + (1 << (SHIFT_BITS - 1))).max(1)),
        }
    }

    /// A number of an axis, and the level that its grid cells are of: heights are in amplitudes.
    fn axes<'a>(&self, surface: &Surface, place: &'a Place) -> [(&'a Fixed, u32); 3] {
        let up = self.level - surface.roughness.halvings();
        [(&place.x, self.level), (&place.y, up), (&place.z, self.level)]
    }

    /// The place, shifted so that cells are those of the lattice.
    fn shifted(&self, surface: &Surface, place: &Place) -> Place {
        let axes = self.axes(surface, place);
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let (number, level) = axes[axis];
            let mut shifted = number.clone();
            shifted.add(self.shift[axis], level + SHIFT_BITS);
            shifted
        });
        Place { x, y, z }
    }

    fn key(&self, surface: &Surface, place: &Place, layer: u32) -> Key {
        let shifted = self.shifted(surface, place);
        let up = self.level - surface.roughness.halvings();
        Key { layer, cell: shifted.cell(self.level), up: shifted.y.slice(up) }
    }

    /// The middle of the cell that a place is in.
    fn eye(&self, surface: &Surface, place: &Place) -> Place {
        let shifted = self.shifted(surface, place);
        let axes = self.axes(surface, &shifted);
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let (number, level) = axes[axis];
            let mut middle = number.floor(level);
            middle.add((1 << (SHIFT_BITS - 1)) - self.shift[axis], level + SHIFT_BITS);
            middle
        });
        Place { x, y, z }
    }
}

/// The canonical eye that a layer behind a place is taken from.
pub fn eye(surface: &Surface, place: &Place, layer: u32) -> Place {
    Grid::new(surface, layer).eye(surface, place)
}

/// The tiles of a layer, as a tree around its canonical eye, and its leaves that are drawn.
pub struct Band {
    pub eye: Place,
    pub tree: Tree,
    pub leaves: Vec<Leaf>,
    /// What tiles are made from: nodes and what is above them, from coarse to fine.
    wanted: Vec<(Cell, Corners)>,
    /// The level of its finest leaves, whose cells are the unit.
    level: u32,
}

impl Band {
    /// The tiles that a layer shows of the surface behind a place.
    ///
    /// # Errors
    /// If these are more than `most`.
    pub fn new(
        spine: &mut Spine,
        place: &Place,
        layer: u32,
        detail: Detail,
        most: usize,
    ) -> Result<Band, TooMany> {
        let surface = *spine.surface();
        let eye = eye(&surface, place, layer);
        let roots = roots(spine, &eye, layer - 1, detail);
        let mut wanted = above(spine, &eye, &roots);
        let level = root(layer) + 1;
        let tree = Tree::down_to(level, &surface, &eye, &roots, detail, most)?;
        // The foreground, or the layer that lies over this one, reaches at least twice as far.
        let middle = eye.cell(level);
        let reach = reach(detail);
        let is_under = |cell: Cell| {
            let beside = |of: u64, middle: u64| of.wrapping_sub(middle).wrapping_add(reach) <= 2 * reach;
            cell.level == level && beside(cell.x, middle.x) && beside(cell.z, middle.z)
        };
        let mut leaves = tree.leaves();
        leaves.retain(|leaf| !is_under(leaf.cell));
        wanted.extend(tree.nodes().filter(|(cell, _)| !is_under(*cell)));
        Ok(Band { eye, tree, leaves, wanted, level })
    }
}

/// A background in the making.
struct Job {
    /// From the nearest layer to the farthest.
    keys: Vec<Key>,
    /// What it is the background of.
    place: Place,
    /// Which of those that are kept it becomes.
    target: usize,
    /// Layers that are not laid yet, those of `keys` before this.
    left: usize,
    /// What the first of them is laid over.
    below: Option<usize>,
    current: Option<Laying>,
    /// Calls of [`Background::prepare`] that it may take yet.
    calls: usize,
}

/// A layer that is being drawn.
struct Laying {
    band: Band,
    lattice: Lattice,
    /// Tiles of each face.
    faces: Vec<Vec<Leaf>>,
    /// Faces that are laid, and tiles that are drawn of the next.
    face: usize,
    drawn: usize,
    /// What all of it costs, in tiles that are made or drawn, and what has been done.
    cost: usize,
    spent: usize,
}

/// Backgrounds, and what they are made with.
pub struct Background {
    surface: Surface,
    detail: Detail,
    bits: u32,
    most: usize,
    /// Most layers of one.
    layers: u32,
    kept: Vec<Composite>,
    /// One face.
    canvas: Canvas,
    lay: Compute<layer::Shader>,
    job: Option<Job>,
    /// What the last layer cost, in tiles that are drawn.
    usual: usize,
    /// What calls of [`Background::work`] have done beyond their share.
    owed: usize,
    clock: u64,
}

struct Composite {
    /// From the nearest layer to the farthest; empty if it is of nothing.
    keys: Vec<Key>,
    texels: Layers<Rgba16f>,
    used: u64,
    /// Until when it is kept for a place that is expected to come.
    expected: u64,
}

/// The background of a view: which one it is.
#[derive(Clone, Copy)]
pub struct Behind {
    index: usize,
    /// The level whose cells distances are told in.
    pub level: u32,
}

/// What making backgrounds needs.
pub(super) struct Means<'a> {
    pub gpu: &'a Gpu,
    pub spine: &'a mut Spine,
    pub tiles: &'a mut Tiles,
    pub painter: &'a Painter,
    pub stage: &'a Stage,
    /// Time spent waiting for the device.
    pub bill: &'a mut Bill,
    /// Tiles that are drawn in a submission at most.
    pub most: usize,
}

impl Background {
    /// For `layers` layers in faces of `side` texels along an edge, and one more on each side.
    ///
    /// # Errors
    /// What the device has no memory for.
    pub fn new(
        gpu: &Gpu,
        surface: Surface,
        (detail, bits, most): (Detail, u32, usize),
        layers: u32,
        side: u32,
    ) -> gpu::Result<Background> {
        // Without layers there is nothing, but a shader asks for something.
        let (side, kept) = if layers == 0 { (1, 1) } else { (side + 2, KEPT) };
        let composite = |_| {
            let texels = Layers::new(gpu, "background", [side; 2], FACES.len() as u32)?;
            Ok(Composite { keys: Vec::new(), texels, used: 0, expected: 0 })
        };
        Ok(Background {
            surface,
            detail,
            bits,
            most,
            layers,
            kept: (0..kept).map(composite).collect::<gpu::Result<_>>()?,
            canvas: Canvas::new(gpu, "background face", [side; 2])?,
            lay: Compute::new(gpu, ())?,
            job: None,
            usual: 1000,
            owed: 0,
            clock: 0,
        })
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.job = None;
        self.kept.iter_mut().for_each(|composite| composite.keys.clear());
    }

    /// From the nearest layer to the farthest that shows.
    fn keys(&self, place: &Place, altitude: Distance) -> Vec<Key> {
        let layers = (1..=nearest(altitude)).rev().take(self.layers as usize);
        layers.map(|layer| Grid::new(&self.surface, layer).key(&self.surface, place, layer)).collect()
    }

    /// Begins a background, to be made in so many calls. What is being made already is given up.
    fn begin(&mut self, keys: Vec<Key>, place: &Place, target: usize, calls: usize) {
        // Over the nearest that is there already of what lies behind.
        let below = |left: usize| self.kept.iter().position(|kept| shows(&kept.keys, &keys[left..]));
        let start = (1..keys.len()).find_map(|left| Some((left, below(left)?)));
        let (left, below) = start.map_or((keys.len(), None), |(left, below)| (left, Some(below)));
        // It can be laid over itself.
        self.kept[target].keys.clear();
        self.job = Some(Job { keys, place: place.clone(), target, left, below, current: None, calls });
    }

    /// The background that was not used for longest, apart from the last one, and from those that are expected to be used.
    fn oldest(&self, is_expected: impl Fn(&Composite) -> bool) -> Option<usize> {
        let free = |index: &usize| {
            let composite = &self.kept[*index];
            (composite.used < self.clock || self.clock == 0) && !is_expected(composite)
        };
        (0..self.kept.len()).filter(free).min_by_key(|index| self.kept[*index].used)
    }

    /// Begins what is to be behind a place that a flight comes to after so many `calls` of [`Background::work`]. Whether it is there: while it is not, there
    /// is no use in looking further ahead.
    pub(super) fn prepare(&mut self, place: &Place, altitude: Distance, calls: usize) -> bool {
        let keys = self.keys(place, altitude);
        let expected = self.clock + 2 * calls as u64;
        let there = self.kept.iter_mut().find(|composite| shows(&composite.keys, &keys));
        if let Some(there) = there {
            there.expected = there.expected.max(expected);
            return true;
        }
        if keys.is_empty() {
            return true;
        }
        if self.job.is_none()
            && let Some(target) = self.oldest(|composite| composite.expected > self.clock)
        {
            self.begin(keys, place, target, (calls * 3 / 4).min(CALLS));
            self.kept[target].expected = expected;
        }
        false
    }

    /// Goes on with what is prepared, by its share.
    ///
    /// # Errors
    /// If more tiles are needed than there may be, or what the device has no memory for.
    pub(super) fn work(&mut self, means: &mut Means) -> Result<(), Error> {
        let Some(job) = &mut self.job else { return Ok(()) };
        let calls = job.calls.max(1);
        job.calls = calls - 1;
        let budget = self.work_left().div_ceil(calls).max(self.usual.div_ceil(CALLS));
        // A call that did more than its share is followed by some that do nothing.
        self.owed = self.owed.saturating_sub(budget);
        if self.owed == 0 {
            self.owed = self.advance(means, budget)?.saturating_sub(budget);
        }
        Ok(())
    }

    /// What it costs to lay a face, in tiles.
    fn cost_of_a_face(&self) -> usize {
        let [width, height] = self.canvas.size().map(|side| side as usize);
        width * height / TEXELS_A_TILE + 1
    }

    /// Tiles to be made or drawn, about.
    fn work_left(&self) -> usize {
        let Some(job) = &self.job else { return 0 };
        match &job.current {
            None => job.left * self.usual,
            Some(laying) => (job.left - 1) * self.usual + laying.cost.saturating_sub(laying.spent),
        }
    }

    /// The background of a place, all of it; `None` if it has none.
    ///
    /// # Errors
    /// As [`Background::prepare`].
    pub(super) fn ensure(
        &mut self,
        means: &mut Means,
        place: &Place,
        altitude: Distance,
    ) -> Result<Option<Behind>, Error> {
        let keys = self.keys(place, altitude);
        let Some(nearest) = keys.first() else { return Ok(None) };
        let level = root(nearest.layer) + 1;
        let there = self.kept.iter().position(|composite| shows(&composite.keys, &keys));
        let index = match there {
            Some(index) => index,
            None => {
                if self.job.as_ref().is_none_or(|job| job.keys != keys) {
                    let target = self.oldest(|_| false).unwrap_or(0);
                    self.begin(keys, place, target, 1);
                }
                let target = self.job.as_ref().map_or(0, |job| job.target);
                while self.job.is_some() {
                    self.advance(means, usize::MAX)?;
                }
                target
            }
        };
        self.clock += 1;
        self.kept[index].used = self.clock;
        self.kept[index].expected = 0;
        Ok(Some(Behind { index, level }))
    }

    /// The texels of a background; of none, some that don't matter.
    pub fn texels(&self, behind: Option<Behind>) -> &Layers<Rgba16f> {
        &self.kept[behind.map_or(0, |behind| behind.index)].texels
    }

    /// Goes on with what is being made; returns how many tiles that was, about.
    fn advance(&mut self, means: &mut Means, budget: usize) -> Result<usize, Error> {
        let Some(mut job) = self.job.take() else { return Ok(0) };
        let mut spent = 0;
        while spent < budget && job.left > 0 {
            let mut laying = match job.current.take() {
                Some(laying) => laying,
                None => {
                    let laying = self.lay_next(means, &job)?;
                    self.usual = laying.cost;
                    laying
                }
            };
            let most = (budget - spent).min(means.most);
            let part = self.go_on(means, &job, &mut laying, most)?;
            (spent, laying.spent) = (spent + part, laying.spent + part);
            if laying.face < FACES.len() {
                job.current = Some(laying);
                continue;
            }
            job.left -= 1;
            job.below = Some(job.target);
        }
        if job.left == 0 {
            self.kept[job.target].keys = job.keys;
        } else {
            self.job = Some(job);
        }
        Ok(spent)
    }

    /// The tiles of the layer that is the next of a job.
    fn lay_next(&self, means: &mut Means, job: &Job) -> Result<Laying, Error> {
        let layer = job.keys[job.left - 1].layer;
        let band = Band::new(means.spine, &job.place, layer, self.detail, self.most)?;
        let lattice = Lattice::new(self.surface, &band.eye, &band.leaves, (band.level, 0), self.bits)?;
        let seen = |face| {
            let frustum = Frustum::new(&face_camera(face, self.canvas.size()[0]));
            // What is near first: it hides the rest.
            band.leaves.iter().rev().filter(|leaf| frustum.has(&band.tree, leaf)).copied().collect()
        };
        let faces: Vec<Vec<Leaf>> = (0..FACES.len()).map(seen).collect();
        let missing = band.wanted.iter().filter(|(cell, _)| means.tiles.slot(*cell).is_none()).count();
        let cost = missing + faces.iter().map(|face| face.len() + self.cost_of_a_face()).sum::<usize>();
        Ok(Laying { band, lattice, faces, face: 0, drawn: 0, cost, spent: 0 })
    }

    /// Makes the layer's tiles that are not there, then draws some of them; returns how many these were.
    fn go_on(
        &self,
        means: &mut Means,
        job: &Job,
        laying: &mut Laying,
        budget: usize,
    ) -> Result<usize, Error> {
        let Means { gpu, spine, tiles, painter, stage, bill, .. } = means;
        let Band { eye, wanted, .. } = &laying.band;
        let too_few = |tiles: &Tiles| Error::Slots { needed: wanted.len(), slots: tiles.capacity() };
        let mut rec = recorder(gpu);
        let made = tiles.make(&mut rec, spine, eye, wanted.iter().copied(), budget);
        if made.waiting > 0 {
            wait(rec, bill)?;
            return match made {
                Made { tiles: 0, .. } => Err(too_few(tiles)),
                Made { tiles, .. } => Ok(tiles),
            };
        }
        let mut spent = made.tiles;
        while spent < budget && laying.face < FACES.len() {
            let face = &laying.faces[laying.face];
            let end = laying.drawn.saturating_add(budget - spent).min(face.len());
            let part = face[laying.drawn..end].iter();
            let views = part.map(|leaf| painter.view(tiles, eye, &laying.lattice, leaf));
            let views = views.collect::<Option<Vec<_>>>().ok_or_else(|| too_few(tiles))?;
            let size = self.canvas.size();
            stage.look(&mut rec, size, &face_camera(laying.face, size[0]));
            let load = if laying.drawn == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
            let sight = Sight { lattice: &laying.lattice, near: NEAR, focus: [0.0; 3], looks: None };
            painter.draw(&mut rec, (&self.canvas, load), stage, tiles, sight, &views)?;
            spent += end - laying.drawn;
            laying.drawn = end;
            if end == face.len() {
                spent += self.cost_of_a_face();
                self.lay(&mut rec, job, laying.face);
                (laying.face, laying.drawn) = (laying.face + 1, 0);
            }
        }
        wait(rec, bill)?;
        Ok(spent)
    }

    /// Lays a face that has been drawn over what is below it.
    fn lay(&self, rec: &mut Recorder, job: &Job, face: usize) {
        let push =
            layer::Push { face: face as i32, has_farther: job.below.is_some().into(), levels: LEVELS as f32 };
        let target = &self.kept[job.target].texels;
        let farther = job.below.map_or(target, |index| &self.kept[index].texels);
        let bindings = layer::Bindings { drawn: &self.canvas.radiance, farther, composite: target };
        rec.dispatch(&self.lay, self.canvas.size(), push, bindings);
    }
}

/// Most calls that a background is made in: the rest of the time until it is needed is for those that are needed soon after.
const CALLS: usize = 64;

/// Laying so many texels of a face takes as long as drawing a tile.
const TEXELS_A_TILE: usize = 8192;

/// Whether a background shows these layers, and behind them none but such as are behind them all.
fn shows(kept: &[Key], keys: &[Key]) -> bool {
    !keys.is_empty() && kept.starts_with(keys)
}

/// Distance of the near plane, cells of the layer's finest leaves: the nearest of them are two cells away, and so at least one in front of their face.
const NEAR: f32 = 0.5;

/// Right, up and forward of each face. Twin of `on_face` in zoom/develop.comp.
const FACES: [[Vec3; 3]; 6] = [
    [Vec3::Z, Vec3::Y, Vec3::X],
    [Vec3::NEG_Z, Vec3::Y, Vec3::NEG_X],
    [Vec3::X, Vec3::Z, Vec3::Y],
    [Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y],
    [Vec3::NEG_X, Vec3::Y, Vec3::Z],
    [Vec3::X, Vec3::Y, Vec3::NEG_Z],
];

/// What sees a face of `size` texels, the outermost of which lie beyond it.
fn face_camera(face: usize, size: u32) -> Pinhole {
    let [right, up, forward] = FACES[face];
    let tangent = size as f32 / (size - 2).max(1) as f32;
    Pinhole { eye: Vec3::ZERO, right, up, forward, tangent: [tangent; 2] }
}
