//! Plants at random places, none nearer to another than a given distance, as densely as the site allows.

use super::darts::{Darts, PACKING, cells_along};
use super::ground::Ground;
use super::random::Random;
use super::shade::{Circle, thin};
use super::{Error, Plant, Planter, Rule};
use glam::Vec2;
use rayon::prelude::*;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Least distance between two plants of the rule, metres.
    pub spacing: f32,
    /// Plants a square metre where the site is at its best, before any is shaded out; at most [`Scatter::densest`].
    pub density: f32,
    pub rivalry: Rivalry,
}

/// Whether plants of a rule shade each other out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rivalry {
    #[default]
    None,
    /// The smaller of two, where it stands under the larger.
    Size,
}

/// So many times more places than plants are looked for, at most: enough for places at random, few enough for sparse plants.
const CHOICE: f64 = 4.0;
/// Most cells that darts are thrown at.
const MOST_CELLS: u64 = 1 << 26;

impl Scatter {
    /// Plants a square metre when they stand as close as random places with this distance between them do.
    pub fn densest(spacing: f32) -> f32 {
        (PACKING / f64::from(spacing).powi(2)) as f32
    }

    /// Refuses to look for more places in the square `±half` than there is time for.
    pub fn check(&self, rule: &Rule, half: f32) -> Result<(), Error> {
        let (distance, _) = self.places();
        let (cells, most) = (cells_along(half, distance).pow(2), MOST_CELLS);
        if cells > most { Err(Error::TooFine { rule: rule.name.clone(), cells, most }) } else { Ok(()) }
    }

    /// Distance between places, metres, and the share of them that is taken where the site is at its best.
    fn places(&self) -> (f64, f32) {
        let density = f64::from(self.density);
        let distance = f64::from(self.spacing).max((PACKING / (CHOICE * density)).sqrt());
        (distance, (density * distance * distance / PACKING) as f32)
    }
}

/// How many plants a rule makes before any is shaded out, about.
pub fn predict(rule: &Rule, scatter: &Scatter, ground: &Ground) -> f64 {
    const SAMPLES: usize = 512;
    let side = SAMPLES.min(ground.grid.cells as usize - 1);
    let step = ground.grid.extent / side as f32;
    let sum: f64 = (0..side)
        .into_par_iter()
        .map(|row| {
            let middle = |index: usize| (index as f32 + 0.5) * step - ground.grid.extent / 2.0;
            let density = |column| rule.site.density(ground, Vec2::new(middle(column), middle(row)));
            (0..side).map(|column| f64::from(density(column))).sum::<f64>()
        })
        .collect::<Vec<_>>()
        .into_iter()
        .sum();
    sum * f64::from(step).powi(2) * f64::from(scatter.density)
}

pub fn plant(rule: &Rule, scatter: &Scatter, planter: &Planter) -> Result<Vec<Plant>, Error> {
    let ground = planter.ground;
    let half = ground.grid.extent / 2.0;
    let (distance, share) = scatter.places();
    scatter.check(rule, half)?;
    let reach = (distance / std::f64::consts::SQRT_2) as f32 / 2.0;
    let darts = Darts::throw(rule.seed, half, distance, |at| {
        rule.site.is_possible(ground, ground.height_range(at, reach))
    });
    let row = |row: usize| -> Vec<Plant> {
        let plants = darts.row(row).filter_map(|(cell, at)| {
            let mut random = Random::of_cell(rule.seed, PLANTS, cell);
            // What is left out by chance alone needs no look at the ground.
            let chance = random.share();
            if chance >= share || chance >= share * rule.site.density(ground, at) {
                return None;
            }
            let scale = random.between(rule.scale);
            planter.grow(rule, at, scale, &mut random)
        });
        plants.collect()
    };
    let rows: Vec<Vec<Plant>> = (0..darts.rows()).into_par_iter().map(row).collect();
    let mut plants = rows.concat();
    if scatter.rivalry == Rivalry::Size {
        let circles: Vec<Circle> = plants.iter().map(|plant| plant.circle).collect();
        let survives = |index: usize| plants[index].tolerance < rule.shade;
        let mut lives = thin(half, &circles, survives).into_iter();
        plants.retain(|_| lives.next().unwrap_or(false));
    }
    Ok(plants)
}

/// Purpose of random numbers.
const PLANTS: u32 = 0x706c;
