//! What a hand may do to a run while it is under way: other parameters, processes switched off and on, brushes, undo.
//!
//! Erosion and reef exclude each other as they always do: a reef grows in a stage of its own, behind all that erodes. To grow it on land
//! that has been eroded less, processes before it are switched off: their stages then pass without work.

use super::{Layer, Pace, Progress, Simulation, StageWork};
use crate::core::map::Map;
use crate::gpu::{self, Compute, Gpu, Image, Recorder, format::Rgba32f};
use crate::scene::Ground;
use crate::shaders::terrain::brush;
use crate::terrain::{
    Plan, Stage,
    fields::Images,
    state::{self, Part, Position},
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Processes that can be switched off and on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Hydraulic,
    Thermal,
    Seabed,
    Reef,
}

impl Kind {
    pub const ALL: [Kind; 4] = [Kind::Hydraulic, Kind::Thermal, Kind::Seabed, Kind::Reef];

    /// The one that is at `index` among the processes of a stage. Base terrain and what settles it are always there.
    pub(super) fn of(stage: Stage, index: usize) -> Option<Kind> {
        match (stage, index) {
            (Stage::Hydraulic, 0) => Some(Kind::Hydraulic),
            (Stage::Hydraulic | Stage::Thermal, _) => Some(Kind::Thermal),
            (Stage::Seabed, _) => Some(Kind::Seabed),
            (Stage::Reef, _) => Some(Kind::Reef),
            (Stage::Base | Stage::Settle, _) => None,
        }
    }
}

/// A touch of the land, strongest in its middle and nothing at its rim: of (1 − (r/R)²)² there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    pub kind: BrushKind,
    /// World x and z of its middle, metres.
    pub at: [f32; 2],
    /// R, metres.
    pub radius: f32,
    /// In the middle: metres of ground, metres of water, or what the mask shall be.
    pub strength: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BrushKind {
    /// The ground that changes are counted from.
    Raise,
    Lower,
    /// Water where rivers run; what would fall into the sea is lost.
    Rain,
    /// What every change of the ground is multiplied by, 0…1. It is whole over more than the middle half of the radius.
    Mask,
}

/// Programs of brushes, made when they are first used.
#[derive(Default)]
pub(super) struct Brushes([Option<Compute<brush::Shader>>; 3]);

/// The state of a run at some time, on the device.
pub struct Snapshot {
    position: Position,
    parts: Vec<Part>,
    /// If there were any.
    controls: Option<Image<Rgba32f>>,
}

impl Snapshot {
    /// Device memory that it takes.
    pub fn bytes(&self) -> u64 {
        let controls = self.controls.as_ref().map_or(0, |image| {
            let [width, height] = image.size().map(u64::from);
            16 * width * height
        });
        self.parts.iter().map(Part::bytes).sum::<u64>() + controls
    }

    /// Where the run was.
    pub fn position(&self) -> Position {
        self.position
    }
}

impl Plan {
    /// Whether a run of this plan that has come to `stage` can take the parameters of another one and go on. Otherwise what differs is
    /// over, and the land begins again.
    pub fn goes_on_as(&self, other: &Plan, stage: Stage) -> bool {
        // Without `..`: what is new is judged here.
        let Plan {
            grid,
            layers,
            sea_level,
            boundary,
            controls: _,
            hydraulic,
            thermal,
            seabed_smoothing,
            reef,
        } = other;
        let over = |of: Stage| stage > of;
        let settle = |thermal: &Option<crate::terrain::thermal::Params>| thermal.and_then(|it| it.settle);
        let images = |plan: &Plan| Images { controls: false, ..Images::of(plan) };
        (grid, layers, sea_level, boundary) == (&self.grid, &self.layers, &self.sea_level, &self.boundary)
            && images(other) == images(self)
            && (stage == Stage::Base || settle(thermal) == settle(&self.thermal))
            && (!over(Stage::Thermal) || (hydraulic, thermal) == (&self.hydraulic, &self.thermal))
            && (!over(Stage::Seabed) || *seabed_smoothing == self.seabed_smoothing)
            && (stage < Stage::Reef || reef.is_some())
            && other.stages().iter().any(|(other, _)| *other == stage)
    }
}

impl Simulation {
    /// Whether the land may be another one than the plan makes: then states of this run are not to be kept under its keys.
    pub fn touched(&self) -> bool {
        self.touched
    }

    /// Height of the sea above the datum as it is now, m: a reef's history moves it.
    pub fn sea_level_now(&self) -> f32 {
        let Progress { stage, iteration, finished, .. } = self.progress();
        match &self.plan.reef {
            _ if finished => self.sea_level(),
            Some(reef) if stage == Stage::Reef => {
                let levels = reef.sea_levels(self.plan.sea_level);
                levels.get(iteration as usize).copied().unwrap_or_else(|| self.sea_level())
            }
            _ => self.plan.sea_level,
        }
    }

    /// Brings the images of `ground`, which are as large as this land's grid, and its sea to what the land is now.
    ///
    /// # Errors
    /// A lost device.
    pub fn update(&self, ground: &mut Ground) -> gpu::Result<()> {
        ground.sea_level = self.sea_level_now();
        let mut rec = Recorder::new(&self.gpu);
        rec.concurrent(|rec| {
            let Ground { height, water, wetness, reef, sea_level, .. } = &*ground;
            for (layer, image) in [
                (Layer::Height, height),
                (Layer::Water, water),
                (Layer::Wetness, wetness),
                (Layer::Reef, reef),
            ] {
                self.record_layer(rec, layer, *sea_level, image);
            }
        });
        rec.submit()?.wait()?;
        Ok(())
    }

    /// The same for a single layer.
    ///
    /// # Errors
    /// A lost device.
    pub fn update_layer(&self, layer: Layer, image: &Image<gpu::format::R32f>) -> gpu::Result<()> {
        let mut rec = Recorder::new(&self.gpu);
        self.record_layer(&mut rec, layer, self.sea_level_now(), image);
        rec.submit()?.wait()?;
        Ok(())
    }

    /// Advances by `count` iterations of the current stage, or as many as fit into `budget` (but at least one submission).
    ///
    /// # Errors
    /// A lost device.
    pub fn step_iterations(&mut self, count: u32, budget: Duration) -> gpu::Result<Progress> {
        let Progress { stage, iteration, .. } = self.progress();
        let last = iteration.saturating_add(count);
        let start = Instant::now();
        loop {
            let progress = self.step_to(last, budget.saturating_sub(start.elapsed()))?;
            let reached = progress.stage != stage || progress.iteration >= last;
            if reached || progress.finished || start.elapsed() >= budget {
                return Ok(progress);
            }
        }
    }

    /// Switches a process off or on: iterations that leave it out pass without it. What the sea or a reef begins with is done all the same.
    pub fn enable(&mut self, kind: Kind, on: bool) {
        self.off.retain(|off| *off != kind);
        if !on {
            self.off.push(kind);
            self.touched = true;
        }
    }

    pub fn is_enabled(&self, kind: Kind) -> bool {
        !self.off.contains(&kind)
    }

    /// Takes the parameters of processes from another plan, and goes on from where the run is; numbers of iterations may change. False,
    /// and nothing has happened, where only a new run can do that: other land to begin with, processes that need other images, or
    /// parameters of what is over.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn retune(&mut self, plan: &Plan) -> gpu::Result<bool> {
        let mut plan = plan.clone();
        if self.brushes.paint(&self.plan) {
            plan.controls.mask.get_or_insert_with(everywhere);
        }
        if plan == self.plan {
            return Ok(true);
        }
        if !self.can_become(&plan) {
            return Ok(false);
        }
        self.finish_iteration()?;
        if plan.controls != self.plan.controls {
            self.fields.retune_controls(&self.gpu, &plan)?;
        }
        self.retune_processes(plan)?;
        self.touched = true;
        Ok(true)
    }

    fn can_become(&self, plan: &Plan) -> bool {
        self.stages.get(self.current).is_some_and(|work| self.plan.goes_on_as(plan, work.stage))
    }

    /// Goes on to the end of the iteration under way: numbers of passes may change.
    fn finish_iteration(&mut self) -> gpu::Result<()> {
        while let Some(work) = self.stages.get(self.current)
            && (work.processes_done, work.passes_done) != (0, 0)
        {
            self.step_to(work.done + 1, Duration::MAX)?;
        }
        Ok(())
    }

    fn retune_processes(&mut self, plan: Plan) -> gpu::Result<()> {
        let stage = self.stages.get(self.current).map(|work| work.stage);
        let mut old = std::mem::take(&mut self.stages);
        for (stage, iterations) in plan.stages() {
            let known = old.iter().position(|work| work.stage == stage).map(|index| old.swap_remove(index));
            // Beside water there may be debris, or none.
            let same = (plan.thermal.is_some(), plan.hydraulic.is_some())
                == (self.plan.thermal.is_some(), self.plan.hydraulic.is_some());
            let work = match known {
                Some(mut work) if same => {
                    work.processes.iter_mut().try_for_each(|process| process.retune(&self.gpu, &plan))?;
                    StageWork { iterations, done: work.done.min(iterations), ..work }
                }
                known => {
                    let done = known.map_or(0, |work| work.done.min(iterations));
                    StageWork { done, ..StageWork::new(&self.gpu, &plan, stage, iterations)? }
                }
            };
            self.stages.push(work);
        }
        self.current = self.stages.iter().position(|work| Some(work.stage) == stage).unwrap_or(0);
        self.pace = Pace::default();
        self.plan = plan;
        self.end_stage();
        Ok(())
    }

    /// Touches the land. A brush that comes while base terrain is being made waits for it. False if there is nothing to touch: no water in
    /// this world, or a brush without size.
    ///
    /// # Errors
    /// No memory for a mask; a lost device.
    pub fn brush(&mut self, brush: Brush) -> gpu::Result<bool> {
        let Brush { kind, at, radius, strength } = brush;
        let sound = at.iter().chain([&radius, &strength]).all(|value| value.is_finite());
        if !sound || radius <= 0.0 || kind == BrushKind::Rain && self.plan.hydraulic.is_none() {
            return Ok(false);
        }
        while self.progress().stage == Stage::Base && !self.progress().finished {
            self.step(Duration::MAX)?;
        }
        self.finish_iteration()?;
        if kind == BrushKind::Mask && !self.plan.controls.any() {
            self.make_mask()?;
        }
        let grid = self.plan.grid;
        let cell = grid.cell_size();
        let middle = at.map(|along| (along + grid.extent / 2.0) / cell);
        let reach = radius / cell;
        let first = middle.map(|along| (along - reach).floor().clamp(0.0, grid.cells as f32) as i32);
        let last = middle.map(|along| (along + reach).ceil().clamp(0.0, (grid.cells - 1) as f32) as i32);
        let size = [0, 1].map(|axis| (last[axis] - first[axis] + 1).max(0).cast_unsigned());
        self.touched = true;
        if size.contains(&0) {
            return Ok(true);
        }
        let (number, strength) = match kind {
            BrushKind::Raise => (0, strength),
            BrushKind::Lower => (0, -strength),
            BrushKind::Rain => (1, strength),
            BrushKind::Mask => (2, strength.clamp(0.0, 1.0)),
        };
        let coral = self.coral_grows();
        let push = brush::Push {
            first,
            middle,
            radius: reach,
            strength,
            sea_level: self.plan.acting_sea_level(),
            coral: u32::from(coral),
        };
        let program = self.brushes.program(&self.gpu, number)?;
        let fields = &self.fields;
        let bindings = brush::Bindings {
            height: fields.height.src(),
            start: &fields.start,
            change: if coral { &fields.reef } else { &fields.change },
            water: fields.water.src(),
            controls: &fields.controls,
        };
        let mut rec = Recorder::new(&self.gpu);
        rec.dispatch(program, size, push, bindings);
        rec.submit()?.wait()?;
        Ok(true)
    }

    /// Whether height is `start + reef`: once a reef has begun.
    fn coral_grows(&self) -> bool {
        self.stages.get(self.current).is_some_and(|work| work.stage == Stage::Reef && !work.at_start())
    }

    /// A mask of 1 everywhere, for a world that has no controls.
    fn make_mask(&mut self) -> gpu::Result<()> {
        let mut plan = self.plan.clone();
        plan.controls.mask = Some(everywhere());
        self.fields.retune_controls(&self.gpu, &plan)?;
        self.retune_processes(plan)
    }

    /// Takes away a mask that brushes have made.
    fn remove_mask(&mut self) -> gpu::Result<()> {
        let mut plan = self.plan.clone();
        plan.controls.mask = None;
        if !plan.controls.any() {
            self.fields.controls = Image::new(&self.gpu, "controls", [1; 2])?;
        }
        self.retune_processes(plan)
    }

    /// What the run is now, to come back to.
    ///
    /// # Errors
    /// No memory for it, or a lost device.
    pub fn snapshot(&self) -> gpu::Result<Option<Snapshot>> {
        let Some(position) = self.position() else { return Ok(None) };
        let Some(parts) = self.parts(position) else { return Ok(None) };
        let mut rec = Recorder::new(&self.gpu);
        let parts = parts.iter().map(|part| part.copied(&self.gpu, &mut rec)).collect::<gpu::Result<_>>()?;
        let controls = match self.plan.controls.any() {
            true => {
                let copy = Image::new(&self.gpu, "snapshot", self.fields.controls.size())?;
                rec.copy(&self.fields.controls, &copy);
                Some(copy)
            }
            false => None,
        };
        rec.submit()?.wait()?;
        Ok(Some(Snapshot { position, parts, controls }))
    }

    /// Goes back (or forth) to a snapshot of this run. Its parameters and switches stay as they are now. False if the run doesn't pass there
    /// any more.
    ///
    /// # Errors
    /// A lost device.
    pub fn restore(&mut self, snapshot: &Snapshot) -> gpu::Result<bool> {
        if self.parts(snapshot.position).is_none() {
            return Ok(false);
        }
        match &snapshot.controls {
            Some(_) if !self.plan.controls.any() => self.make_mask()?,
            None if self.brushes.paint(&self.plan) => self.remove_mask()?,
            _ => {}
        }
        let Some(parts) = self.parts(snapshot.position) else { return Ok(false) };
        let alike = |(own, kept): (&Part, &Part)| (own.name, own.floats()) == (kept.name, kept.floats());
        if parts.len() != snapshot.parts.len() || !parts.iter().zip(&snapshot.parts).all(alike) {
            return Ok(false);
        }
        let mut rec = Recorder::new(&self.gpu);
        state::clear(&mut rec, &self.fields);
        parts.iter().zip(&snapshot.parts).for_each(|(own, kept)| own.fill(&mut rec, kept));
        match &snapshot.controls {
            Some(controls) if controls.size() == self.fields.controls.size() => {
                rec.copy(controls, &self.fields.controls);
            }
            _ => {}
        }
        rec.submit()?.wait()?;
        for work in &mut self.stages {
            let done = if work.stage < snapshot.position.stage { work.iterations } else { 0 };
            (work.done, work.processes_done, work.passes_done) = (done, 0, 0);
        }
        self.resume(snapshot.position);
        Ok(true)
    }
}

/// A map that is 1 everywhere.
fn everywhere() -> Arc<Map> {
    Arc::new(Map { width: 1, height: 1, values: vec![1.0] })
}

impl Brushes {
    fn program(&mut self, gpu: &Gpu, kind: u32) -> gpu::Result<&Compute<brush::Shader>> {
        match &mut self.0[kind as usize] {
            Some(program) => Ok(program),
            none => Ok(none.insert(Compute::new(gpu, brush::Constants { kind })?)),
        }
    }

    /// Whether the mask of the plan is one that brushes have made.
    fn paint(&self, plan: &Plan) -> bool {
        plan.controls.mask.as_ref().is_some_and(|mask| **mask == *everywhere())
    }
}
