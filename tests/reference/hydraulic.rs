//! Hydraulic erosion by virtual pipes (Mei, Decaudin & Hu 2007), mended.

use super::lattice::{Lattice, OPPOSITE, each, sum};
use std::f64::consts::SQRT_2;
use terrane::terrain::Boundary;
use terrane::terrain::hydraulic::{Params, Pipes, Section, Slope, Transport};

/// Shallower water than this is none, m.
pub const DRY: f64 = 1e-6;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// Change of the ground since the start, m.
    pub e: f64,
    /// Suspended sediment, as metres of ground.
    pub s: f64,
    /// Sediment that one unit of outflow carries away in one step, m per m³/s.
    pub c: f64,
    /// Depth of the water, m.
    pub d: f64,
    /// Discharge per unit of width, m²/s.
    pub q: f64,
    /// Water counter, s.
    pub wet: f64,
    /// m/s, towards +X and +Z.
    pub velocity: [f64; 2],
    /// Outflows, m³/s.
    pub flux: [f64; 8],
}

/// Ground and water when the flow starts, after the rain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Column {
    /// Height of the ground, m.
    pub h: f64,
    /// Depth, m.
    pub depth: f64,
    /// Height of the water's surface, m.
    pub surface: f64,
    pub is_sea: bool,
}

/// What the first half of an iteration makes.
#[derive(Clone, Debug, Default)]
pub struct Flow {
    pub columns: Vec<Column>,
    /// Sediment after transport, m.
    pub s: Vec<f64>,
    /// Outflows, m³/s.
    pub flux: Vec<[f64; 8]>,
}

/// The start, the parameters and the controls: all that an iteration needs beside the state.
#[derive(Clone)]
pub struct Erosion {
    pub lattice: Lattice,
    pub params: Params,
    pub boundary: Boundary,
    pub sea_level: f64,
    /// Step, s.
    pub step: f64,
    /// Shares of the missing or the surplus load that erode and settle in one step.
    eroded_share: f64,
    deposited_share: f64,
    /// Ground at the start, m.
    pub h0: Vec<f64>,
    pub rain: Vec<f64>,
    pub erodibility: Vec<f64>,
    pub mask: Vec<f64>,
}

/// Largest stable step: `safety·½·ℓ/sqrt(g·D)`.
pub fn stable_step(params: &Params, cell: f64) -> f64 {
    f64::from(params.safety) * 0.5 * cell / (f64::from(params.gravity) * f64::from(params.pipe_depth)).sqrt()
}

/// Iterations that fill the duration.
pub fn iterations(params: &Params, cell: f64) -> usize {
    (f64::from(params.duration) / stable_step(params, cell)).ceil() as usize
}

impl Erosion {
    /// With every control at 1.
    pub fn new(lattice: Lattice, params: Params, boundary: Boundary, sea_level: f64, h0: Vec<f64>) -> Self {
        let step = f64::from(params.duration) / iterations(&params, lattice.cell) as f64;
        let share = |rate: f32| 1.0 - (-f64::from(rate) * step).exp();
        let ones = || vec![1.0; lattice.len()];
        Self {
            lattice,
            params,
            boundary,
            sea_level,
            step,
            eroded_share: share(params.erosion_rate),
            deposited_share: share(params.deposition_rate),
            h0,
            rain: ones(),
            erodibility: ones(),
            mask: ones(),
        }
    }

    pub fn start(&self) -> Vec<Cell> {
        let depth = |h: f64| if self.is_sea(h) { self.sea_level - h } else { 0.0 };
        self.h0.iter().map(|&h| Cell { d: depth(h), ..Cell::default() }).collect()
    }

    /// One iteration; `flow` and `next` are room to work in.
    pub fn iterate(&self, cells: &mut Vec<Cell>, flow: &mut Flow, next: &mut Vec<Cell>) {
        self.flow(cells, flow);
        self.diffuse_sediment(cells, &mut flow.s);
        self.erode(cells, flow, next);
        std::mem::swap(cells, next);
    }

    /// Transport of the sediment by the last flow, rain, and the new flow.
    pub fn flow(&self, cells: &[Cell], flow: &mut Flow) {
        let lattice = self.lattice;
        lattice.fill(&mut flow.columns, |i, j| self.rained(cells, lattice.index(i, j)));
        lattice.fill(&mut flow.flux, |i, j| self.outflow(cells, &flow.columns, i, j));
        lattice.fill(&mut flow.s, |i, j| match self.params.transport {
            Transport::Flux => self.carried(cells, i, j),
            Transport::SemiLagrangian => self.traced(cells, i, j),
        });
    }

    /// All sweeps of sediment diffusion between wet cells, conservative form of (18).
    pub fn diffuse_sediment(&self, cells: &[Cell], s: &mut Vec<f64>) {
        let Lattice { cell, .. } = self.lattice;
        let share = f64::from(self.params.sediment_diffusivity) * self.step / (cell * cell);
        let sweeps = (8.0 * share).ceil();
        for _ in 0..sweeps as usize {
            *s = self.lattice.map(|i, j| {
                let at = self.lattice.index(i, j);
                if cells[at].d <= DRY {
                    return s[at];
                }
                let exchange: [f64; 8] = each(|k| match self.lattice.neighbour(i, j, k) {
                    Some(n) if k < 4 && cells[n].d > DRY => s[n] - s[at],
                    _ => 0.0,
                });
                s[at] + share / sweeps * sum(&exchange)
            });
        }
    }

    /// Everything after the flow: the bed, the depth, erosion and deposition, evaporation, the water counter.
    pub fn erode(&self, cells: &[Cell], flow: &Flow, next: &mut Vec<Cell>) {
        self.lattice.fill(next, |i, j| self.eroded(cells, flow, i, j));
    }

    pub fn height(&self, cells: &[Cell], at: usize) -> f64 {
        self.h0[at] + cells[at].e
    }

    fn is_sea(&self, h: f64) -> bool {
        self.boundary == Boundary::Sea && h < self.sea_level
    }

    /// Rain (6); the sea stays at its level.
    fn rained(&self, cells: &[Cell], at: usize) -> Column {
        let h = self.height(cells, at);
        if self.is_sea(h) {
            return Column { h, depth: self.sea_level - h, surface: self.sea_level, is_sea: true };
        }
        let depth = cells[at].d + f64::from(self.params.rain) * self.step * self.rain[at];
        Column { h, depth, surface: h + depth, is_sea: false }
    }

    /// Transport by the pipes: sediment leaves with the water that carries it.
    fn carried(&self, cells: &[Cell], i: usize, j: usize) -> f64 {
        let cell = &cells[self.lattice.index(i, j)];
        let inflow: [f64; 8] = each(|k| match self.lattice.neighbour(i, j, k) {
            Some(n) => cells[n].flux[OPPOSITE[k]] * cells[n].c,
            None => 0.0,
        });
        (cell.s - cell.c * sum(&cell.flux)).max(0.0) + sum(&inflow)
    }

    /// Semi-Lagrangian transport (17).
    fn traced(&self, cells: &[Cell], i: usize, j: usize) -> f64 {
        let Lattice { n, cell } = self.lattice;
        let last = (n - 1) as f64;
        let [vx, vz] = cells[self.lattice.index(i, j)].velocity;
        let x = (i as f64 - vx * self.step / cell).clamp(0.0, last);
        let z = (j as f64 - vz * self.step / cell).clamp(0.0, last);
        let (i, j, fx, fz) = (x as usize, z as usize, x.fract(), z.fract());
        let s = |i: usize, j: usize| cells[self.lattice.index(i.min(n - 1), j.min(n - 1))].s;
        let along = |j| s(i, j) * (1.0 - fx) + s(i + 1, j) * fx;
        along(j) * (1.0 - fz) + along(j + 1) * fz
    }

    /// Outflows (7–9), with the section and drag of the flow's own depth.
    fn outflow(&self, cells: &[Cell], columns: &[Column], i: usize, j: usize) -> [f64; 8] {
        let Lattice { cell, .. } = self.lattice;
        let at = self.lattice.index(i, j);
        let here = columns[at];
        if here.is_sea && cells[at].flux == [0.0; 8] {
            return [0.0; 8]; // The sea is level: no water leaves it.
        }
        let [gx, gz] = self.lattice.gradient(i, j, |at| columns[at].surface);
        let gradient = (gx * gx + gz * gz).sqrt();
        let wanted: [f64; 8] = each(|k| {
            let Some(pipe) = self.pipe(k) else { return 0.0 };
            let there = match self.lattice.neighbour(i, j, k) {
                Some(n) => columns[n],
                None if self.boundary == Boundary::Open => outside(here),
                None => return 0.0,
            };
            pipe.width * self.discharge(cells[at].flux[k] / pipe.width, pipe, here, there, gradient)
        });
        let total = sum(&wanted);
        let most = here.depth * cell * cell / self.step;
        let scale = if total > most { most / total } else { 1.0 }; // (9)
        each(|k| scale * wanted[k])
    }

    /// Discharge per width through one pipe after a step (7), bed drag solved implicitly.
    fn discharge(&self, last: f64, pipe: Pipe, here: Column, there: Column, gradient: f64) -> f64 {
        let params = &self.params;
        let (gravity, drag) = (f64::from(params.gravity), f64::from(params.drag));
        let drop = here.surface - there.surface; // (8)
        let depth = (here.surface.max(there.surface) - here.h.max(there.h)).max(0.0);
        let depth = depth.min(f64::from(params.pipe_depth));
        let section = match params.section {
            Section::Fixed => f64::from(params.pipe_depth),
            Section::Depth => depth,
        };
        if depth <= 0.0 && (params.section == Section::Depth || drag > 0.0) {
            return 0.0;
        }
        let driven = (last + self.step * gravity * section * drop / pipe.length).max(0.0);
        if drag == 0.0 {
            return driven;
        }
        let obliqueness = if drop > 0.0 { (gradient * pipe.length / drop).clamp(1.0, 10.0) } else { 1.0 };
        let m = self.step * drag * obliqueness / (depth * depth);
        2.0 * driven / (1.0 + (1.0 + 4.0 * m * driven).sqrt())
    }

    fn eroded(&self, cells: &[Cell], flow: &Flow, i: usize, j: usize) -> Cell {
        let Lattice { cell, .. } = self.lattice;
        let at = self.lattice.index(i, j);
        let (old, params) = (&cells[at], &self.params);
        let (Column { h, depth: before, is_sea, .. }, flux, s) =
            (flow.columns[at], flow.flux[at], flow.s[at]);
        let e = old.e + self.bed_diffusion(cells, i, j);

        let inflow: [f64; 8] = each(|k| match self.lattice.neighbour(i, j, k) {
            Some(n) => flow.flux[n][OPPOSITE[k]],
            None => 0.0,
        });
        let balance = sum(&inflow) - sum(&flux);
        let after = if is_sea { before } else { (before + self.step * balance / (cell * cell)).max(0.0) }; // (10)
        let mean_depth = 0.5 * (before + after);
        let velocity = self.velocity(&flux, &inflow, before + after);
        let speed = (velocity[0] * velocity[0] + velocity[1] * velocity[1]).sqrt();

        let ramp = match params.ramp_depth {
            0.0 => 1.0,
            depth => ((mean_depth - f64::from(params.ramp_start)) / f64::from(depth)).clamp(0.0, 1.0),
        };
        let fade = if !is_sea {
            1.0
        } else if params.sea_fade > 0.0 {
            (1.0 - (self.sea_level - h) / f64::from(params.sea_fade)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let capacity = f64::from(params.capacity) * speed * self.sine(flow, i, j) * ramp * fade; // (11)

        // Neither below all neighbours nor above them, so that no constants dig a hole or pile a tower.
        let ground = self.h0[at] + e;
        let (lowest, highest) = self.range(flow, i, j);
        let limit = f64::from(params.rate_limit) * self.step;
        let worn = if capacity > s {
            let rock = self.erodibility[at] * self.mask[at];
            (self.eroded_share * (capacity - s) * rock).min(limit).min((ground - lowest).max(0.0)) // (15)
        } else {
            -(self.deposited_share * (s - capacity) * self.mask[at])
                .min(limit)
                .min((highest - ground).max(0.0)) // (16), sign mended
        };
        let e_next = e - worn;
        let s_next = s + (e - e_next);

        let h_next = self.h0[at] + e_next;
        let d_next = if self.is_sea(h_next) {
            self.sea_level - h_next
        } else {
            after * (1.0 - f64::from(params.evaporation) * self.step).max(0.0) // (19)
        };
        // Semi-Lagrangian transport keeps the velocity in the place of c and q.
        let traced = params.transport == Transport::SemiLagrangian;
        let towards = if d_next > f64::from(params.wet_depth) { self.step } else { -self.step };
        Cell {
            e: e_next,
            s: s_next,
            c: if before > DRY && !traced { self.step * s_next / (cell * cell * before) } else { 0.0 },
            d: d_next,
            q: speed * if traced { d_next } else { mean_depth },
            wet: (old.wet + towards).clamp(0.0, f64::from(params.wet_memory)),
            velocity,
            flux,
        }
    }

    /// Lowest and highest ground of the cell and its neighbours.
    fn range(&self, flow: &Flow, i: usize, j: usize) -> (f64, f64) {
        let own = flow.columns[self.lattice.index(i, j)].h;
        let heights = (0..8).filter_map(|k| self.lattice.neighbour(i, j, k)).map(|n| flow.columns[n].h);
        heights.fold((own, own), |(low, high), h| (low.min(h), high.max(h)))
    }

    /// Creep and bank diffusion of the bed, from the discharge of the last iteration.
    fn bed_diffusion(&self, cells: &[Cell], i: usize, j: usize) -> f64 {
        let Lattice { cell, .. } = self.lattice;
        let at = self.lattice.index(i, j);
        let (creep, bank) = (f64::from(self.params.creep), f64::from(self.params.bank_diffusion));
        let exchange: [f64; 8] = each(|k| match self.lattice.neighbour(i, j, k) {
            Some(n) if k < 4 => {
                let diffusivity = creep + bank * 0.5 * (cells[at].q + cells[n].q);
                let share = (diffusivity * self.step / (cell * cell)).min(0.2);
                share * self.mask[at].min(self.mask[n]) * (self.height(cells, n) - self.height(cells, at))
            }
            _ => 0.0,
        });
        sum(&exchange)
    }

    /// (13, 14): the water that passes through the cell, per length and depth; at most a cell a step.
    fn velocity(&self, out: &[f64; 8], inflow: &[f64; 8], depths: f64) -> [f64; 2] {
        if depths <= 2.0 * DRY {
            return [0.0, 0.0];
        }
        let y: [f64; 8] = each(|k| out[k] - inflow[k]);
        let x = (y[1] - y[0]) + ((y[5] + y[7]) - (y[4] + y[6]));
        let z = (y[3] - y[2]) + ((y[6] + y[7]) - (y[4] + y[5]));
        let Lattice { cell, .. } = self.lattice;
        let (x, z) = (x / (cell * depths), z / (cell * depths));
        let scale = (cell / self.step / (x * x + z * z).sqrt()).min(1.0);
        [scale * x, scale * z]
    }

    /// sin α of the capacity (12), bounded below.
    fn sine(&self, flow: &Flow, i: usize, j: usize) -> f64 {
        let at = self.lattice.index(i, j);
        let (here, flux) = (flow.columns[at], flow.flux[at]);
        let tangent = match self.params.slope {
            Slope::Central => {
                let [x, z] = self.lattice.gradient(i, j, |at| flow.columns[at].h);
                (x * x + z * z).sqrt()
            }
            Slope::Outflow => {
                let drops: [f64; 8] = each(|k| {
                    if flux[k] == 0.0 {
                        return 0.0;
                    }
                    let there = self.lattice.neighbour(i, j, k).map_or(outside(here), |n| flow.columns[n]);
                    flux[k] * (here.surface - there.surface) / self.lattice.distance(k)
                });
                let total = sum(&flux);
                if total > 0.0 { sum(&drops).max(0.0) / total } else { 0.0 }
            }
        };
        (tangent / (1.0 + tangent * tangent).sqrt()).max(f64::from(self.params.min_slope))
    }

    /// Pipe `k`, with widths that make eight pipes isotropic.
    #[inline(always)]
    fn pipe(&self, k: usize) -> Option<Pipe> {
        let Lattice { cell, .. } = self.lattice;
        let width = match (self.params.pipes, k < 4) {
            (Pipes::Four, true) => cell,
            (Pipes::Four, false) => return None,
            (Pipes::Eight, true) => 2.0 / 3.0 * cell,
            (Pipes::Eight, false) => SQRT_2 / 6.0 * cell,
        };
        Some(Pipe { width, length: self.lattice.distance(k) })
    }
}

/// Volume of water on the grid and what the sediment and the ground hold together, m³.
pub fn volumes(lattice: Lattice, cells: &[Cell]) -> (f64, f64) {
    let area = lattice.cell * lattice.cell;
    let water: f64 = cells.iter().map(|cell| cell.d).sum();
    let ground: f64 = cells.iter().map(|cell| cell.e + cell.s).sum();
    (area * water, area * ground)
}

/// Beyond an open rim lies dry ground at the rim's height.
fn outside(rim: Column) -> Column {
    Column { depth: 0.0, surface: rim.h, ..rim }
}

#[derive(Clone, Copy)]
struct Pipe {
    width: f64,
    length: f64,
}
