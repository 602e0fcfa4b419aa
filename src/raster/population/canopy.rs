//! Crowns over the ground: how many leaves the light has to get through.

use super::shapes::density_area;
use crate::core::grid::Grid;
use crate::gpu::{self, Gpu, Image, Recorder, format::Rgba32f};
use crate::scene::{Instance, Model, Population};
use glam::Vec2;
use rayon::prelude::*;
use std::f32::consts::PI;
use std::time::{Duration, Instant};

/// Distance of samples where the land is not too large for that, metres: light under crowns varies no faster.
const FINEST: f32 = 2.0;
const MOST_CELLS: u32 = 1024;
/// What is lower than this shades no ground but its own, metres.
pub const LOWEST: f32 = 1.0;
/// Light comes from all sides: leaves count for the ground as far away as this share of their height.
const SLANT: f32 = 0.35;

/// Samples a side over this grid.
pub fn side(grid: Grid) -> u32 {
    (grid.extent / FINEST).ceil().clamp(2.0, MOST_CELLS as f32) as u32
}

/// For every place the area of leaves over it by area of ground, and times that the height of their top above the datum and
/// the depth of the crowns; plant by plant.
pub struct Canopy {
    /// By model; none if all are too flat to shade anything.
    crowns: Vec<Crown>,
    grid: Grid,
    leaves: Vec<[f32; 4]>,
    done: usize,
}

/// Plants between two looks at the clock.
const SOME: usize = 1024;

impl Canopy {
    pub fn begin(population: &Population, grid: Grid) -> Canopy {
        let crowns: Vec<Crown> = population.models.par_iter().map(|model| Crown::of(model)).collect();
        let are_flat = crowns.iter().all(|crown| crown.area == 0.0);
        let cells = if are_flat { 1 } else { side(grid) };
        let crowns = if are_flat { Vec::new() } else { crowns };
        Canopy { crowns, grid, leaves: vec![[0.0; 4]; (cells * cells) as usize], done: 0 }
    }

    /// Adds plants for about so long; false once all are there.
    pub fn step(&mut self, population: &Population, budget: Duration) -> bool {
        if self.crowns.is_empty() {
            return false;
        }
        let begun = Instant::now();
        let (cells, extent) = (side(self.grid), self.grid.extent);
        let mut drawing =
            Drawing { cells, cell: extent / (cells - 1) as f32, extent, leaves: &mut self.leaves };
        // One after another: sums of floats depend on their order.
        for some in population.instances.get(self.done..).unwrap_or_default().chunks(SOME) {
            if begun.elapsed() >= budget {
                return true;
            }
            for instance in some {
                if let Some(crown) = self.crowns.get(instance.model as usize) {
                    drawing.add(crown, instance);
                }
            }
            self.done += some.len();
        }
        false
    }

    /// Brings it to the device.
    pub fn image(&self, gpu: &Gpu) -> gpu::Result<Image<Rgba32f>> {
        let cells = if self.crowns.is_empty() { 1 } else { side(self.grid) };
        let image = Image::new(gpu, "canopy", [cells; 2])?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&image, &self.leaves);
        rec.submit()?.wait()?;
        Ok(image)
    }
}

/// Of a model that stands alone.
struct Crown {
    /// Of its leaves, one-sided, m²; 0 if it is too flat to shade anything.
    area: f32,
    radius: f32,
    top: f32,
    depth: f32,
}

impl Crown {
    fn of(model: &Model) -> Crown {
        let [least, greatest] = model.bounds();
        let size = greatest - least;
        let area = model.levels.first().map_or(0.0, |level| density_area(model, level));
        Crown {
            area: if greatest.y < LOWEST / 2.0 { 0.0 } else { area },
            radius: 0.25 * (size.x + size.z),
            top: greatest.y,
            depth: 0.7 * size.y,
        }
    }
}

struct Drawing<'a> {
    cells: u32,
    cell: f32,
    extent: f32,
    leaves: &'a mut [[f32; 4]],
}

impl Drawing<'_> {
    fn add(&mut self, crown: &Crown, instance: &Instance) {
        let scale = instance.scale;
        let top = scale * crown.top;
        if crown.area == 0.0 || top < LOWEST {
            return;
        }
        let radius = (scale * crown.radius + SLANT * top).max(1.5 * self.cell);
        let area = scale * scale * crown.area;
        let middle = Vec2::new(instance.position.x, instance.position.z);
        let column = |at: f32| (at + 0.5 * self.extent) / self.cell;
        let last = self.cells as f32 - 1.0;
        let range = |at: f32| {
            let (first, end) = (column(at - radius).ceil().max(0.0), column(at + radius).floor().min(last));
            first as u32..end as u32 + u32::from(end >= first)
        };
        if middle.abs().max_element() > 0.5 * self.extent + radius {
            return;
        }
        for row in range(middle.y) {
            for column in range(middle.x) {
                let at = Vec2::new(column as f32, row as f32) * self.cell - 0.5 * self.extent;
                // A paraboloid: its integral over the disc is 1.
                let share = 1.0 - at.distance_squared(middle) / (radius * radius);
                if share > 0.0 {
                    let index = area * share * 2.0 / (PI * radius * radius);
                    let leaves = &mut self.leaves[(row * self.cells + column) as usize];
                    leaves[0] += index;
                    leaves[1] += index * (instance.position.y + top);
                    leaves[2] += index * scale * crown.depth;
                }
            }
        }
    }
}
