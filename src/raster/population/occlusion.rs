//! How much of the sky and of the ground a plant's own leaves leave to see, for places in it: the light in a crown falls
//! off as in a cloudy medium (Beer & Lambert), whose density is the leaves' (Monsi & Saeki 1953).

use super::shapes::projected;
use crate::scene::{Level, Model};
use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Cells along the longest side.
const CELLS: f32 = 20.0;
/// Directions in each half of the sphere.
const DIRECTIONS: usize = 20;
/// Points at most by which a triangle is spread over the cells that it crosses.
const MOST_POINTS: f32 = 64.0;

/// Openness on a grid round a model.
pub struct Occlusion {
    least: Vec3,
    cell: f32,
    size: UVec3,
    /// Of sky and ground, in the middle of every cell, 0…1.
    open: Vec<[f32; 2]>,
}

impl Occlusion {
    /// By the leaves and branches of a model's finest level.
    pub fn of(model: &Model) -> Occlusion {
        let [least, greatest] = model.bounds();
        let extent = greatest - least;
        let cell = (extent.max_element() / CELLS).max(1e-6);
        let size = (extent / cell).ceil().as_uvec3().clamp(UVec3::ONE, UVec3::splat(CELLS as u32 + 1));
        let mut occlusion = Occlusion { least, cell, size, open: Vec::new() };
        let extinction = model.levels.first().map_or(Vec::new(), |level| occlusion.extinction(model, level));
        let directions = directions();
        let count = (size.x * size.y * size.z) as usize;
        occlusion.open = (0..count)
            .into_par_iter()
            .map(|index| {
                let at = occlusion.cell_of(index).as_vec3() + 0.5;
                let seen = |sign: f32| {
                    let through = |toward: &Vec3| {
                        occlusion.through(&extinction, at, *toward * Vec3::new(1.0, sign, 1.0))
                    };
                    directions.iter().map(through).sum::<f32>() / DIRECTIONS as f32
                };
                [seen(1.0), seen(-1.0)]
            })
            .collect();
        occlusion
    }

    /// Of the sky and of the ground, between the cells' middles.
    pub fn at(&self, point: Vec3) -> [f32; 2] {
        let most = (self.size - 1).as_vec3();
        let at = ((point - self.least) / self.cell - 0.5).clamp(Vec3::ZERO, most);
        let first = at.as_uvec3();
        let t = at - first.as_vec3();
        let mut sum = [0.0; 2];
        for corner in 0..8 {
            let step = UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let side = |t: f32, step: u32| if step == 1 { t } else { 1.0 - t };
            let weight = side(t.x, step.x) * side(t.y, step.y) * side(t.z, step.z);
            let open =
                self.open.get(self.index((first + step).min(self.size - 1))).copied().unwrap_or([1.0; 2]);
            sum = [sum[0] + weight * open[0], sum[1] + weight * open[1]];
        }
        sum
    }

    /// By metre of path in every cell: the mean over all directions of the area that is in the way.
    fn extinction(&self, model: &Model, level: &Level) -> Vec<f32> {
        let mut area = vec![0.0f32; (self.size.x * self.size.y * self.size.z) as usize];
        for part in &level.parts {
            let share = projected(model, part.material);
            for triangle in &part.mesh.triangles {
                let [a, b, c] = triangle.map(|corner| Vec3::from(part.mesh.positions[corner as usize]));
                let whole = (b - a).cross(c - a).length() / 2.0;
                let points = (4.0 * whole / (self.cell * self.cell)).ceil().clamp(1.0, MOST_POINTS);
                let rows = points.sqrt().ceil() as u32;
                for index in 0..rows * rows {
                    // A square folded onto the triangle.
                    let [u, v] = [index % rows, index / rows].map(|at| (at as f32 + 0.5) / rows as f32);
                    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                    let cell = ((a + u * (b - a) + v * (c - a) - self.least) / self.cell).as_uvec3();
                    if let Some(area) = area.get_mut(self.index(cell.min(self.size - 1))) {
                        *area += share * whole / (rows * rows) as f32;
                    }
                }
            }
        }
        area.iter().map(|area| area / self.cell.powi(3)).collect()
    }

    /// Share of the light that gets in from far away. The half cell round the place itself counts as empty: what is there
    /// is the leaf that is asked for.
    fn through(&self, extinction: &[f32], from: Vec3, toward: Vec3) -> f32 {
        let mut depth = 0.0;
        for step in 1.. {
            let at = (from + (step as f32 - 0.25) * toward).floor().as_ivec3();
            if at.cmplt(IVec3::ZERO).any() || at.cmpge(self.size.as_ivec3()).any() {
                break;
            }
            depth += extinction.get(self.index(at.as_uvec3())).copied().unwrap_or(0.0) * self.cell;
        }
        (-depth).exp()
    }

    fn index(&self, cell: UVec3) -> usize {
        ((cell.z * self.size.y + cell.y) * self.size.x + cell.x) as usize
    }

    fn cell_of(&self, index: usize) -> UVec3 {
        let index = index as u32;
        UVec3::new(
            index % self.size.x,
            index / self.size.x % self.size.y,
            index / (self.size.x * self.size.y),
        )
    }
}

/// Evenly over the upper half of the sphere, along a spiral.
fn directions() -> [Vec3; DIRECTIONS] {
    std::array::from_fn(|index| {
        let y = (index as f32 + 0.5) / DIRECTIONS as f32;
        let azimuth = index as f32 * PI * (3.0 - 5f32.sqrt());
        let level = (1.0 - y * y).sqrt();
        Vec3::new(level * azimuth.cos(), y, level * azimuth.sin())
    })
}
