//! Hydraulic erosion (docs/model.md, section 2): the boundaries Sea and Closed, one sweep of sediment diffusion.

use super::{
    CHANGE, Ground, HEIGHT,
    planes::{Around, Margin, OPPOSITE, Planes, split},
};
use crate::terrain::{
    Plan,
    hydraulic::{Params, Section, Slope},
};
use rayon::prelude::*;
use std::f32::consts::SQRT_2;

pub struct Hydraulic {
    constants: Constants,
    pipes: usize,
    /// The planes that follow.
    water: Planes,
    water_next: Planes,
    /// Outflow to each neighbour.
    flux: Planes,
    flux_next: Planes,
    /// What the first half leaves for the second: sediment that has travelled, and tan of the slope.
    halfway: Planes,
}

const DEPTH: usize = 0;
/// Sediment that leaves with each m³/s.
const LOAD: usize = 1;
const DISCHARGE: usize = 2;
const WETNESS: usize = 3;
const SEDIMENT: usize = 4;
const EAST: usize = 5;
const SOUTH: usize = 6;

const DRY: f32 = 1e-6;

/// Of one step, in metres, seconds and shares.
#[derive(Clone, Copy)]
struct Constants {
    cell: f32,
    time: f32,
    sea_level: f32,
    rain: f32,
    gravity: f32,
    pipe_depth: f32,
    fixed_section: bool,
    drag: f32,
    central_slope: bool,
    traces_back: bool,
    sediment_mixing: f32,
    creep: f32,
    bank: f32,
    max_speed: f32,
    capacity: f32,
    min_slope: f32,
    ramp_start: f32,
    ramp: f32,
    sea_fade: f32,
    erosion: f32,
    deposition: f32,
    max_change: f32,
    evaporation: f32,
    wet_depth: f32,
    wet_memory: f32,
}

impl Constants {
    fn of(plan: &Plan, params: &Params) -> Constants {
        let time = params.steps(plan.grid).step;
        let cell = f64::from(plan.grid.extent) / f64::from(plan.grid.cells - 1);
        let mixing = |diffusivity: f32| f64::from(diffusivity) * time / (cell * cell);
        let share = |rate: f32| (1.0 - (-f64::from(rate) * time).exp()) as f32;
        let ramps = params.ramp_depth > 0.0;
        Constants {
            cell: cell as f32,
            time: time as f32,
            sea_level: plan.acting_sea_level(),
            rain: (f64::from(params.rain) * time) as f32,
            gravity: params.gravity,
            pipe_depth: params.pipe_depth,
            fixed_section: params.section == Section::Fixed,
            drag: params.drag,
            central_slope: params.slope == Slope::Central,
            traces_back: params.traces_back(),
            sediment_mixing: mixing(params.sediment_diffusivity) as f32,
            creep: mixing(params.creep) as f32,
            bank: (0.5 * mixing(params.bank_diffusion)) as f32,
            max_speed: (cell / time) as f32,
            capacity: params.capacity,
            min_slope: params.min_slope,
            ramp_start: if ramps { params.ramp_start } else { -1.0 },
            ramp: if ramps { 1.0 / params.ramp_depth } else { 1.0 },
            sea_fade: if params.sea_fade > 0.0 { 1.0 / params.sea_fade } else { f32::MAX },
            erosion: share(params.erosion_rate),
            deposition: share(params.deposition_rate),
            max_change: (f64::from(params.rate_limit) * time) as f32,
            evaporation: (f64::from(params.evaporation) * time).min(1.0) as f32,
            wet_depth: params.wet_depth,
            wet_memory: params.wet_memory,
        }
    }
}

impl Hydraulic {
    pub fn new(plan: &Plan, params: &Params) -> Hydraulic {
        let cells = plan.grid.cells as usize;
        let constants = Constants::of(plan, params);
        let pipes = if params.flows_diagonally() { 8 } else { 4 };
        let water = if constants.traces_back { SOUTH + 1 } else { SEDIMENT + 1 };
        Hydraulic {
            constants,
            pipes,
            water: Planes::new(cells, water),
            water_next: Planes::new(cells, water),
            flux: Planes::new(cells, pipes),
            flux_next: Planes::new(cells, pipes),
            halfway: Planes::new(cells, 2),
        }
    }

    pub fn step(&mut self, ground: &mut Ground) {
        ground.now.surround(Margin::Rim);
        self.water.surround(Margin::Rim);
        match self.pipes {
            8 => self.let_flow::<8>(ground),
            _ => self.let_flow::<4>(ground),
        }
        self.halfway.surround(Margin::Rim);
        match self.pipes {
            8 => self.let_erode::<8>(ground),
            _ => self.let_erode::<4>(ground),
        }
        std::mem::swap(&mut self.flux, &mut self.flux_next);
        std::mem::swap(&mut self.water, &mut self.water_next);
        ground.swap();
    }

    pub fn depth(&self) -> Vec<f32> {
        self.water.plane(DEPTH)
    }

    pub fn sediment(&self) -> Vec<f32> {
        self.water.plane(SEDIMENT)
    }

    pub fn flow(&self) -> Vec<f32> {
        let pipes = (0..self.pipes).map(|pipe| self.flux.plane(pipe));
        let add =
            |sum: Vec<f32>, pipe: Vec<f32>| sum.iter().zip(pipe).map(|(sum, flux)| sum + flux).collect();
        pipes.reduce(add).unwrap_or_default()
    }

    /// Sediment travels with the last fluxes, it rains, the pipes accelerate (A).
    fn let_flow<const PIPES: usize>(&mut self, ground: &Ground) {
        let it = &self.constants;
        let pipes = pipes::<PIPES>(it);
        let (water, flux, ground) = (&self.water, &self.flux, &ground.now);
        let cells = ground.cells();
        let rows = self.flux_next.rows_mut().zip(self.halfway.rows_mut()).enumerate();
        rows.for_each_init(
            || Scratch::new(cells),
            |Scratch { padded, plain }, (y, (flux_next, halfway))| {
                let [sediment, slope] = split(halfway, 2);
                let mut next: [_; PIPES] = split(flux_next, PIPES);
                let [depth, steepest, total, ..] = plain;

                if it.traces_back {
                    let velocity = [water.row(y, EAST), water.row(y, SOUTH)];
                    trace_back(sediment, water.around(y, SEDIMENT), velocity, it.time / it.cell);
                } else {
                    let load = water.around(y, LOAD);
                    total.fill(0.0);
                    (0..PIPES).for_each(|k| add(total, flux.row(y, k)));
                    leave(sediment, water.row(y, SEDIMENT), total, load.here);
                    for (k, back) in OPPOSITE.into_iter().enumerate().take(PIPES) {
                        arrive(sediment, flux.around(y, back).beside[k], load.beside[k]);
                    }
                }

                rain(depth, ground.row(y, HEIGHT), water.row(y, DEPTH), it);
                for (row, surface) in padded.iter_mut().enumerate() {
                    flood(surface, ground.padded(y + row, HEIGHT), water.padded(y + row, DEPTH), it);
                }
                let [north, here, south] = &*padded;
                let (height, surface) = (ground.around(y, HEIGHT), Around::of([north, here, south]));
                gradient(steepest, surface, it.cell);
                total.fill(0.0);
                slope.fill(0.0);
                for (k, next) in next.iter_mut().enumerate() {
                    let (ground, surface) =
                        ([height.here, height.beside[k]], [surface.here, surface.beside[k]]);
                    accelerate(next, flux.row(y, k), ground, surface, steepest, pipes[k], it);
                    stop_at_rim(next, OFFSETS[k], y == 0, y + 1 == cells);
                    add(total, next);
                    descend(slope, next, surface, 1.0 / pipes[k].length);
                }
                if it.central_slope {
                    gradient(slope, height, it.cell);
                } else {
                    per_outflow(slope, total);
                }
                scale(total, depth, it);
                next.iter_mut().for_each(|next| multiply(next, total));
            },
        );
    }

    /// Sediment and bed diffuse, water moves, the ground wears or fills, water evaporates (B).
    fn let_erode<const PIPES: usize>(&mut self, ground: &mut Ground) {
        let it = &self.constants;
        let planes = self.water_next.planes();
        let (water, flux, halfway) = (&self.water, &self.flux_next, &self.halfway);
        let (now, start) = (&ground.now, &ground.start);
        let cells = now.cells();
        let rows = ground.next.rows_mut().zip(self.water_next.rows_mut()).enumerate();
        rows.for_each_init(
            || Scratch::new(cells),
            |Scratch { plain, .. }, (y, (ground_next, water_next))| {
                let [height, change] = split(ground_next, 2);
                let [depth, load, discharge, wetness, sediment, east, south] = split(water_next, planes);
                let [rained, gained, x_flow, z_flow, capacity, lowest, highest] = plain;
                let ground = now.around(y, HEIGHT);
                let old_depth = water.around(y, DEPTH);

                diffuse(sediment, halfway.around(y, 0), old_depth, it);
                creep(change, now.row(y, CHANGE), ground, water.around(y, DISCHARGE), it);

                rain(rained, ground.here, old_depth.here, it);
                gained.fill(0.0);
                x_flow.fill(0.0);
                z_flow.fill(0.0);
                for (k, back) in OPPOSITE.into_iter().enumerate().take(PIPES) {
                    let (out, into) = (flux.row(y, k), flux.around(y, back).beside[k]);
                    pass([gained, x_flow, z_flow], out, into, OFFSETS[k]);
                }
                carry(
                    [capacity, discharge, depth],
                    [ground.here, rained, gained, x_flow, z_flow, halfway.row(y, 1)],
                    it,
                );
                if it.traces_back {
                    velocity([east, south], [x_flow, z_flow, rained, depth], it);
                }

                extremes(lowest, highest, ground);
                wear([change, height, sediment], [capacity, lowest, highest, start.row(y, 0)], it);
                dry([depth, load, wetness], [height, rained, sediment, water.row(y, WETNESS)], it);
            },
        );
    }
}

/// Rows that a thread works in.
struct Scratch {
    /// With margins.
    padded: [Vec<f32>; 3],
    plain: [Vec<f32>; 7],
}

impl Scratch {
    fn new(cells: usize) -> Scratch {
        let rows = |cells: usize| move |_| vec![0.0; cells];
        Scratch { padded: std::array::from_fn(rows(cells + 2)), plain: std::array::from_fn(rows(cells)) }
    }
}

/// To the neighbours of a cell.
const OFFSETS: [[i32; 2]; 8] = [[-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [1, -1], [-1, 1], [1, 1]];

#[derive(Clone, Copy, Default)]
struct Pipe {
    length: f32,
    width: f32,
}

/// Eight pipes have the widths that make them isotropic.
fn pipes<const PIPES: usize>(it: &Constants) -> [Pipe; PIPES] {
    let cell = it.cell;
    std::array::from_fn(|k| match (PIPES, k) {
        (8, 0..4) => Pipe { length: cell, width: 2.0 / 3.0 * cell },
        (8, _) => Pipe { length: SQRT_2 * cell, width: SQRT_2 / 6.0 * cell },
        _ => Pipe { length: cell, width: cell },
    })
}

// Loops along a row.

fn add(sum: &mut [f32], addend: &[f32]) {
    for (sum, addend) in sum.iter_mut().zip(addend) {
        *sum += addend;
    }
}

fn multiply(product: &mut [f32], factor: &[f32]) {
    for (product, factor) in product.iter_mut().zip(factor) {
        *product *= factor;
    }
}

/// What stays of the sediment (17).
fn leave(stays: &mut [f32], sediment: &[f32], outflow: &[f32], load: &[f32]) {
    for (((stays, sediment), outflow), load) in stays.iter_mut().zip(sediment).zip(outflow).zip(load) {
        *stays = (sediment - load * outflow).max(0.0);
    }
}

/// What comes with the water of one neighbour (17).
fn arrive(sediment: &mut [f32], inflow: &[f32], load: &[f32]) {
    for ((sediment, inflow), load) in sediment.iter_mut().zip(inflow).zip(load) {
        *sediment += inflow * load;
    }
}

/// Sediment where the water was a step ago (17): at most one cell away.
fn trace_back(out: &mut [f32], sediment: Around, velocity: [&[f32]; 2], cells_per_speed: f32) {
    let n = out.len();
    let [east, south] = velocity.map(|row| &row[..n]);
    let here = &sediment.here[..n];
    let [l, r, t, b, tl, tr, bl, br] = sediment.beside.map(|row| &row[..n]);
    for x in 0..n {
        let (dx, dz) = (east[x] * cells_per_speed, south[x] * cells_per_speed);
        let (west, east) = (dx.max(0.0), (-dx).max(0.0));
        let (north, south) = (dz.max(0.0), (-dz).max(0.0));
        let (middle, level) = (1.0 - dx.abs(), 1.0 - dz.abs());
        out[x] = level * (middle * here[x] + west * l[x] + east * r[x])
            + north * (middle * t[x] + west * tl[x] + east * tr[x])
            + south * (middle * b[x] + west * bl[x] + east * br[x]);
    }
}

/// Depth after the rain (6).
fn rain(out: &mut [f32], height: &[f32], depth: &[f32], it: &Constants) {
    let (sea_level, rain) = (it.sea_level, it.rain);
    for ((out, h), d) in out.iter_mut().zip(height).zip(depth) {
        *out = if *h < sea_level { sea_level - h } else { d + rain };
    }
}

/// The surface of the water after the rain.
fn flood(out: &mut [f32], height: &[f32], depth: &[f32], it: &Constants) {
    let (sea_level, rain) = (it.sea_level, it.rain);
    for ((out, h), d) in out.iter_mut().zip(height).zip(depth) {
        *out = if *h < sea_level { sea_level } else { h + (d + rain) };
    }
}

/// Length of the gradient by central differences.
fn gradient(out: &mut [f32], field: Around, cell: f32) {
    let n = out.len();
    let [l, r, t, b, ..] = field.beside.map(|row| &row[..n]);
    let per_metre = 0.5 / cell;
    for x in 0..n {
        let (dx, dz) = ((r[x] - l[x]) * per_metre, (b[x] - t[x]) * per_metre);
        out[x] = (dx * dx + dz * dz).sqrt();
    }
}

/// One pipe (7, 8).
fn accelerate(
    out: &mut [f32],
    flux: &[f32],
    ground: [&[f32]; 2],
    surface: [&[f32]; 2],
    steepest: &[f32],
    pipe: Pipe,
    it: &Constants,
) {
    let n = out.len();
    let (flux, steepest) = (&flux[..n], &steepest[..n]);
    let [h, h_n] = ground.map(|row| &row[..n]);
    let [s, s_n] = surface.map(|row| &row[..n]);
    let per_width = 1.0 / pipe.width;
    let (push, friction) = (it.time * it.gravity / pipe.length, 4.0 * it.time * it.drag);
    let (cap, least) = (it.pipe_depth, if it.fixed_section { it.pipe_depth } else { 0.0 });
    if friction > 0.0 {
        for x in 0..n {
            let drop = s[x] - s_n[x];
            let depth = filled([s[x], s_n[x]], [h[x], h_n[x]], cap);
            let pushed = (flux[x] * per_width + push * depth.max(least) * drop).max(0.0);
            // From the gradient of the surface to its share along the pipe.
            let along = (steepest[x] * pipe.length / drop.max(1e-30)).clamp(1.0, 10.0);
            let along = if drop > 0.0 { along } else { 1.0 };
            let root = (depth * depth + friction * along * pushed).sqrt();
            out[x] = pipe.width * (2.0 * pushed * depth / (depth + root).max(1e-30));
        }
    } else {
        for x in 0..n {
            let section = filled([s[x], s_n[x]], [h[x], h_n[x]], cap).max(least);
            let pushed = (flux[x] * per_width + push * section * (s[x] - s_n[x])).max(0.0);
            out[x] = if section > 0.0 { pipe.width * pushed } else { 0.0 };
        }
    }
}

/// Depth of the flow between two cells, up to the pipe's.
#[inline(always)]
fn filled([s, s_n]: [f32; 2], [h, h_n]: [f32; 2], pipe_depth: f32) -> f32 {
    (s.max(s_n) - h.max(h_n)).max(0.0).min(pipe_depth)
}

fn stop_at_rim(flux: &mut [f32], [dx, dz]: [i32; 2], northernmost: bool, southernmost: bool) {
    if (dz < 0 && northernmost) || (dz > 0 && southernmost) {
        flux.fill(0.0);
    }
    match (dx, flux) {
        (-1, [first, ..]) | (1, [.., first]) => *first = 0.0,
        _ => {}
    }
}

/// Adds the drop along a pipe, weighted by its outflow.
fn descend(fall: &mut [f32], flux: &[f32], [own, other]: [&[f32]; 2], per_length: f32) {
    for (((fall, flux), own), other) in fall.iter_mut().zip(flux).zip(own).zip(other) {
        *fall += flux * (own - other) * per_length;
    }
}

fn per_outflow(fall: &mut [f32], outflow: &[f32]) {
    for (fall, outflow) in fall.iter_mut().zip(outflow) {
        *fall = if *outflow > 0.0 { fall.max(0.0) / outflow } else { 0.0 };
    }
}

/// From the outflow to its share that there is water for (9).
fn scale(outflow: &mut [f32], depth: &[f32], it: &Constants) {
    let rate = it.cell * it.cell / it.time;
    for (outflow, depth) in outflow.iter_mut().zip(depth) {
        let available = depth * rate;
        *outflow = if *outflow > available { available / *outflow } else { 1.0 };
    }
}

/// Suspended sediment mixes between wet cells (18).
fn diffuse(out: &mut [f32], sediment: Around, depth: Around, it: &Constants) {
    let n = out.len();
    let (s, d) = (&sediment.here[..n], &depth.here[..n]);
    let [s_l, s_r, s_t, s_b, ..] = sediment.beside.map(|row| &row[..n]);
    let [d_l, d_r, d_t, d_b, ..] = depth.beside.map(|row| &row[..n]);
    for x in 0..n {
        let wet = |depth: f32| if depth > DRY { 1.0 } else { 0.0 };
        let gain = |s_n: f32, d_n: f32| wet(d[x].min(d_n)) * (s_n - s[x]);
        let gained =
            (gain(s_l[x], d_l[x]) + gain(s_r[x], d_r[x])) + (gain(s_t[x], d_t[x]) + gain(s_b[x], d_b[x]));
        out[x] = s[x] + it.sediment_mixing * gained;
    }
}

/// The bed creeps, and rivers wear their banks.
fn creep(out: &mut [f32], change: &[f32], height: Around, discharge: Around, it: &Constants) {
    let n = out.len();
    let (e, h, q) = (&change[..n], &height.here[..n], &discharge.here[..n]);
    let [h_l, h_r, h_t, h_b, ..] = height.beside.map(|row| &row[..n]);
    let [q_l, q_r, q_t, q_b, ..] = discharge.beside.map(|row| &row[..n]);
    for x in 0..n {
        let face = |h_n: f32, q_n: f32| (it.creep + it.bank * (q[x] + q_n)).min(0.2) * (h_n - h[x]);
        let gained =
            (face(h_l[x], q_l[x]) + face(h_r[x], q_r[x])) + (face(h_t[x], q_t[x]) + face(h_b[x], q_b[x]));
        out[x] = e[x] + gained;
    }
}

/// Adds what one pipe takes and brings: to the balance of the cell, and to the flow through it (13, 14).
fn pass([gained, east, south]: [&mut Vec<f32>; 3], out: &[f32], into: &[f32], [dx, dz]: [i32; 2]) {
    let (dx, dz) = (dx as f32, dz as f32);
    let flows = gained.iter_mut().zip(east).zip(south).zip(out).zip(into);
    for ((((gained, east), south), out), into) in flows {
        *gained += into - out;
        *east += dx * (out - into);
        *south += dz * (out - into);
    }
}

/// Depth (10), discharge, and the capacity (11, 12).
fn carry(out: [&mut [f32]; 3], from: [&[f32]; 6], it: &Constants) {
    let n = from[0].len();
    let [capacity, discharge, depth] = out.map(|row| &mut row[..n]);
    let [h, rained, gained, east, south, slope] = from.map(|row| &row[..n]);
    let per_area = it.time / (it.cell * it.cell);
    for x in 0..n {
        let sea = h[x] < it.sea_level;
        let flowed = (rained[x] + per_area * gained[x]).max(0.0);
        depth[x] = if sea { rained[x] } else { flowed };
        let both = rained[x] + depth[x];
        let per_speed = if both > 2.0 * DRY { 1.0 / (it.cell * both) } else { 0.0 };
        let speed = ((east[x] * east[x] + south[x] * south[x]).sqrt() * per_speed).min(it.max_speed);
        let mean = 0.5 * both;
        let sine = (slope[x] / (1.0 + slope[x] * slope[x]).sqrt()).max(it.min_slope);
        let ramp = ((mean - it.ramp_start) * it.ramp).clamp(0.0, 1.0);
        let fade = (1.0 - (it.sea_level - h[x]) * it.sea_fade).clamp(0.0, 1.0);
        discharge[x] = speed * mean;
        capacity[x] = it.capacity * speed * sine * ramp * if sea { fade } else { 1.0 };
    }
}

/// Of the water (13, 14), for transport along it.
fn velocity(out: [&mut [f32]; 2], from: [&[f32]; 4], it: &Constants) {
    let n = from[0].len();
    let [out_east, out_south] = out.map(|row| &mut row[..n]);
    let [east, south, before, after] = from.map(|row| &row[..n]);
    for x in 0..n {
        let both = before[x] + after[x];
        let flow = (east[x] * east[x] + south[x] * south[x]).sqrt();
        let speed = if both > 2.0 * DRY { (flow / (it.cell * both)).min(it.max_speed) } else { 0.0 };
        let per_flow = if flow > 0.0 { speed / flow } else { 0.0 };
        out_east[x] = east[x] * per_flow;
        out_south[x] = south[x] * per_flow;
    }
}

/// How far the ground may fall and rise: to its lowest and highest neighbour.
fn extremes(lowest: &mut [f32], highest: &mut [f32], height: Around) {
    lowest.copy_from_slice(height.here);
    highest.copy_from_slice(height.here);
    for beside in height.beside {
        for ((lowest, highest), h) in lowest.iter_mut().zip(highest.iter_mut()).zip(beside) {
            *lowest = lowest.min(*h);
            *highest = highest.max(*h);
        }
    }
}

/// The ground wears or fills (15, 16).
fn wear(out: [&mut [f32]; 3], from: [&[f32]; 4], it: &Constants) {
    let n = from[0].len();
    let [change, height, sediment] = out.map(|row| &mut row[..n]);
    let [capacity, lowest, highest, start] = from.map(|row| &row[..n]);
    for x in 0..n {
        let lack = capacity[x] - sediment[x];
        let rate = if lack > 0.0 { it.erosion } else { it.deposition };
        let crept = start[x] + change[x];
        let taken = (rate * lack).max(-it.max_change).min(it.max_change);
        let taken = taken.max((crept - highest[x]).min(0.0)).min((crept - lowest[x]).max(0.0));
        let before = change[x];
        change[x] = before - taken;
        sediment[x] += before - change[x];
        height[x] = start[x] + change[x];
    }
}

/// Water evaporates (19), and the ground remembers where it stood.
fn dry(out: [&mut [f32]; 3], from: [&[f32]; 4], it: &Constants) {
    let n = from[0].len();
    let [depth, load, wetness] = out.map(|row| &mut row[..n]);
    let [height, rained, sediment, wet] = from.map(|row| &row[..n]);
    let per_area = it.time / (it.cell * it.cell);
    for x in 0..n {
        let left = depth[x] - depth[x] * it.evaporation;
        depth[x] = if height[x] < it.sea_level { it.sea_level - height[x] } else { left };
        let per_flow = per_area * sediment[x] / rained[x].max(DRY);
        load[x] = if rained[x] > DRY { per_flow } else { 0.0 };
        let change = if depth[x] > it.wet_depth { it.time } else { -it.time };
        wetness[x] = (wet[x] + change).max(0.0).min(it.wet_memory);
    }
}
