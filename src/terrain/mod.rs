//! Makes land: base terrain, erosion, sea-bed smoothing, reef; all on the GPU.

pub mod fields;
pub mod hydraulic;
pub mod layers;
pub mod reef;
pub mod schedule;
pub mod seabed;
mod simulation;
mod state;
pub mod thermal;

pub use self::{
    fields::Fields,
    schedule::Stage,
    simulation::{Brush, BrushKind, Kind, Layer, Progress, Simulation, Snapshot, processes},
    state::{Part, Position},
};
pub use crate::core::map::Map;

use crate::{
    core::grid::Grid,
    gpu::{self, DeviceKind, Gpu, Image, Recorder, format::R32f},
};
use serde::Serialize;
use std::collections::HashMap;
use std::sync::Arc;

/// Everything that determines the land, checked, in metres, seconds, years and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub grid: Grid,
    pub layers: Vec<layers::Layer>,
    /// Height of the sea above the datum at the start, metres.
    pub sea_level: f32,
    pub boundary: Boundary,
    pub controls: Controls,
    pub hydraulic: Option<hydraulic::Params>,
    pub thermal: Option<thermal::Params>,
    /// Length over which the sea bed is smoothed before the reef grows, σ in metres; 0 = not at all.
    pub seabed_smoothing: f32,
    pub reef: Option<reef::Params>,
}

/// No ground lies further above or below the datum, m: in 32 bits it would lose the centimetres.
pub const FARTHEST_GROUND: f32 = 50_000.0;

/// What happens to water and sediment at the rim of the grid and in the sea.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Boundary {
    /// The sea swallows rivers: its surface stays at sea level. Nothing flows over the rim.
    Sea,
    /// Nothing flows over the rim and there is no sea (the paper).
    Closed,
    /// The rim drains: outside lies dry ground at the rim's own height.
    Open,
}

/// Maps that scale the processes cell by cell; `None` is 1 everywhere.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Controls {
    /// Multiplies the rain.
    pub rain: Option<Arc<Map>>,
    /// Multiplies what water can take from the ground: soft (1) and hard (0) rock.
    pub erodibility: Option<Arc<Map>>,
    /// Multiplies every change of the ground: "erode here only".
    pub mask: Option<Arc<Map>>,
}

/// One process of a stage. It works in iterations and these in passes, between which a run may be cut.
pub trait Process {
    /// Passes of an iteration, counted from 1; it may have none.
    fn passes(&self, _iteration: u32) -> u32 {
        1
    }

    /// Records one pass, counted from 0: as much as must run in one go.
    fn pass(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32, pass: u32);

    /// Records what even those iterations need that leave the process out: nothing, but before its first one.
    fn begin(&mut self, _rec: &mut Recorder, _fields: &mut Fields) {}

    /// Takes its parameters from another plan of the same land, between two iterations.
    ///
    /// # Errors
    /// A program that can't be made.
    fn retune(&mut self, _gpu: &Gpu, _plan: &Plan) -> gpu::Result<()> {
        Ok(())
    }

    /// Records a whole iteration.
    fn step(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32) {
        (0..self.passes(iteration)).for_each(|pass| self.pass(rec, fields, iteration, pass));
    }
}

/// The blocks of cells that the invocations of a kernel work on (`glsl/lib/block.glsl`), as its constants take them.
#[derive(Clone, Copy, Debug)]
struct Blocks {
    columns: i32,
    rows: i32,
}

impl Blocks {
    /// Blocks of this many columns and rows on a CPU device, where they save what neighbours have in common; single cells on a
    /// GPU, which wants many invocations.
    fn of(gpu: &Gpu, columns: i32, rows: i32) -> Blocks {
        match gpu.info().kind {
            DeviceKind::Cpu => Blocks { columns, rows },
            _ => Blocks { columns: 1, rows: 1 },
        }
    }

    /// Invocations that cover a grid of this size.
    fn over(self, [width, height]: [u32; 2]) -> [u32; 2] {
        [width.div_ceil(self.columns.cast_unsigned()), height.div_ceil(self.rows.cast_unsigned())]
    }
}

impl Plan {
    /// Memory of the host that the maps take, bytes; one that several layers share is there once.
    pub fn map_bytes(&self) -> u64 {
        let Controls { rain, erodibility, mask } = &self.controls;
        let heights = self.layers.iter().filter_map(layers::Layer::map);
        let maps = heights.chain([rain, erodibility, mask].into_iter().flatten());
        let distinct: HashMap<*const Map, u64> = maps.map(|map| (Arc::as_ptr(map), map.bytes())).collect();
        distinct.values().sum()
    }

    /// Height of the sea that erosion knows, m: far below everything unless the boundary is the sea.
    pub fn acting_sea_level(&self) -> f32 {
        match self.boundary {
            Boundary::Sea => self.sea_level,
            Boundary::Closed | Boundary::Open => f32::MIN,
        }
    }
}

impl Controls {
    pub fn any(&self) -> bool {
        self.channels().iter().any(Option::is_some)
    }

    /// In the order of the image's channels.
    fn channels(&self) -> [Option<&Map>; 3] {
        [self.rain.as_deref(), self.erodibility.as_deref(), self.mask.as_deref()]
    }
}

/// An empty image that the values of a map fit in.
fn image_of(map: &Map, gpu: &Gpu) -> gpu::Result<Image<R32f>> {
    Image::new(gpu, "raster", [map.width, map.height])
}
