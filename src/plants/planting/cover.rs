//! Ground cover round the camera: grass, flowers, ferns, stones.
//!
//! Every plant has its place in the world and its rank, whatever the camera does: the camera only decides down to which rank
//! plants are seen. Ranks come from a quadtree over the cells of the world: of the four plants of a square one, at random,
//! also stands for the square, and so on upwards. So what is left far away is spread as evenly as what stands near.

use super::random::Random;
use super::{Error, Plant, Planter, Rule};
use crate::core::camera::Pinhole;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// Plants a square metre, where all of them are seen and the site is at its best.
    pub density: f32,
    /// All plants are seen up to this distance from the camera, metres; beyond, their number falls with its square, as the
    /// picture that a plant makes does.
    pub near: f32,
    /// None is seen beyond, metres.
    pub reach: f32,
}

/// Plants come in over this last share of the reach.
const FADE: f32 = 0.25;
/// Outside the picture by so many times its height a plant may still cast its shadow into it.
const SHADOW: f32 = 4.0;
/// How far a plant may stand from the middle of its cell, as a share of its side.
const JITTER: f32 = 0.8;
/// Levels of the quadtree below a square of the first one.
const LEVELS: u32 = 6;
/// Most squares of the first level within reach.
const MOST_SQUARES: u64 = 1 << 22;

impl Cover {
    /// Share of the plants at this distance from the camera that is seen.
    fn share(&self, distance: f32) -> f32 {
        let fewer = (self.near / distance.max(self.near)).powi(2);
        let fade = (self.reach - distance) / (FADE * self.reach);
        fewer * fade.clamp(0.0, 1.0)
    }

    fn tree(&self, rule: &Rule) -> Tree {
        Tree { seed: rule.seed, cell: 1.0 / self.density.sqrt() }
    }

    /// The first and the last of the squares of the first level within reach of a place, by column and row.
    ///
    /// # Errors
    /// If they are too many.
    pub fn squares(&self, rule: &Rule, eye: Vec2) -> Result<[Vec2; 2], Error> {
        let side = self.tree(rule).side(LEVELS);
        let [first, last] = [eye - self.reach, eye + self.reach].map(|at| (at / side).floor());
        let across = (last - first).as_dvec2() + 1.0;
        let (cells, most) = ((across.x * across.y) as u64, MOST_SQUARES);
        if cells > most {
            return Err(Error::TooFine { rule: rule.name.clone(), cells, most });
        }
        Ok([first, last])
    }

    /// How many plants are seen in all directions where the site is at its best, at most.
    pub fn predict(&self) -> f64 {
        let Cover { density, near, reach } = *self;
        let [density, near, reach] = [density, near.min(reach), reach].map(f64::from);
        density * std::f64::consts::PI * near.powi(2) * (1.0 + 2.0 * libm::log(reach / near))
    }
}

pub fn plant(rule: &Rule, cover: &Cover, planter: &Planter) -> Result<Vec<Plant>, Error> {
    let tree = cover.tree(rule);
    let eye = Vec2::new(planter.camera.eye.x, planter.camera.eye.z);
    let [first, last] = cover.squares(rule, eye)?;
    let columns = first.x as i32..last.x as i32 + 1;
    let squares: Vec<[i32; 2]> = (first.y as i32..last.y as i32 + 1)
        .flat_map(|row| columns.clone().map(move |column| [column, row]))
        .collect();
    let visible = |[column, row]: [i32; 2], level: u32| {
        let low = Vec2::new(column as f32, row as f32) * tree.side(level);
        cover.share(eye.clamp(low, low + tree.side(level)).distance(eye))
    };
    let square = |square: [i32; 2]| {
        let mut plants = Vec::new();
        let rank = Random::of_cell(rule.seed, SQUARES, square).share() * tree.most_rank(LEVELS);
        tree.walk(square, LEVELS, rank, &visible, &mut |cell, rank| {
            plants.extend(plant_at(cell, rank, rule, cover, &tree, planter));
        });
        plants
    };
    Ok(squares.into_par_iter().map(square).collect::<Vec<_>>().concat())
}

/// The plant of a cell, if there is one and the camera may see it.
fn plant_at(
    cell: [i32; 2],
    rank: f32,
    rule: &Rule,
    cover: &Cover,
    tree: &Tree,
    planter: &Planter,
) -> Option<Plant> {
    let mut random = Random::of_cell(rule.seed, PLANTS, cell);
    let jitter = Vec2::new(random.share() - 0.5, random.share() - 0.5) * JITTER;
    let at = (Vec2::new(cell[0] as f32, cell[1] as f32) + 0.5 + jitter) * tree.cell;
    if random.share() >= rule.site.density(planter.ground, at) {
        return None;
    }
    // What is seen from afar is large by nature, so that few plants hide as much ground there.
    let [least, greatest] = rule.scale;
    let scale = greatest + (least - greatest) * rank.sqrt().sqrt();
    let plant = planter.grow(rule, at, scale, &mut random)?;
    let position = plant.instance.position;
    let is_near = rank < cover.share(position.distance(planter.camera.eye));
    let is_seen = || {
        let middle = position + Vec3::Y * (plant.height / 2.0);
        is_near_picture(planter.camera, middle, SHADOW * plant.height + plant.circle.crown)
    };
    (is_near && (planter.all_round || is_seen())).then_some(plant)
}

/// The quadtree over the plane. Squares of level 0 are cells, each with one plant.
struct Tree {
    seed: u32,
    /// Side of a cell, metres.
    cell: f32,
}

impl Tree {
    fn side(&self, level: u32) -> f32 {
        self.cell * (1_u32 << level) as f32
    }

    /// Share of all plants that stand for squares of a level: their ranks lie below.
    fn most_rank(&self, level: u32) -> f32 {
        0.25_f32.powi(level as i32)
    }

    /// Visits the plants of a square that may be seen, as cells with ranks. `rank` is that of the plant that stands for
    /// the square, `visible` the greatest rank that is seen somewhere in a square of a level.
    fn walk(
        &self,
        square: [i32; 2],
        level: u32,
        rank: f32,
        visible: &impl Fn([i32; 2], u32) -> f32,
        visit: &mut impl FnMut([i32; 2], f32),
    ) {
        if level == 0 {
            return visit(square, rank);
        }
        let others = [self.most_rank(level), self.most_rank(level - 1)];
        let seen = visible(square, level);
        let mut random = Random::of_cell(self.seed, RANKS + level, square);
        let chosen = random.bits() >> 30;
        for quarter in 0..4 {
            let own = random.between(others);
            let rank = if quarter == chosen { rank } else { own };
            let child = [2 * square[0] + (quarter & 1) as i32, 2 * square[1] + (quarter >> 1) as i32];
            // Every other plant of the child has a greater rank.
            if rank < seen {
                self.walk(child, level - 1, rank, visible, visit);
            }
        }
    }
}

/// Whether a sphere reaches into the picture.
fn is_near_picture(camera: &Pinhole, center: Vec3, radius: f32) -> bool {
    let from_eye = center - camera.eye;
    let depth = camera.forward.dot(from_eye);
    let inside = |across: f32, tangent: f32| {
        // Distance to the picture's edge planes, which lean by their tangent.
        across.abs() - tangent * depth <= radius * (1.0 + tangent * tangent).sqrt()
    };
    depth > -radius
        && inside(camera.right.dot(from_eye), camera.tangent[0])
        && inside(camera.up.dot(from_eye), camera.tangent[1])
}

/// Purposes of random numbers.
const PLANTS: u32 = 0x636f;
const SQUARES: u32 = 0x7371;
const RANKS: u32 = 0x7261_0000;
