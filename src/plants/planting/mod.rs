//! Where plants stand.
//!
//! Rules are followed in order. Each finds places (`scatter`, `cover`, `grid`, `spots`), asks whether its plants like the
//! ground there (`site`) and whether earlier ones leave them light (`shade`), and stands them on it (`stand`).

mod cover;
mod darts;
mod distance;
mod grid;
mod ground;
mod kind;
mod random;
mod scatter;
mod shade;
mod site;
mod spots;
mod stand;

pub use cover::Cover;
pub use distance::distances;
pub use grid::Grid;
pub use ground::{Ground, Needs};
pub use kind::Kind;
pub use scatter::{Rivalry, Scatter};
pub use site::{Footing, Patches, Ramp, Site};
pub use spots::Spot;

use super::species::Species;
use crate::core::camera::Pinhole;
use crate::scene::{Instance, Model, Population};
use glam::Vec2;
use random::Random;
use shade::{Circle, Crowns, Place};
use stand::{Plant, stand, turn};
use std::sync::Arc;

/// What stands on a world's ground: kinds, and rules that place them, in order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// The first kinds.
    pub species: Vec<Arc<Species>>,
    /// The kinds that follow: models from files, one each.
    pub models: Vec<Arc<Model>>,
    pub rules: Vec<Rule>,
    /// What stands already, whatever the ground.
    pub standing: Vec<Population>,
}

impl Plan {
    /// The plants that have to grow: of each species that a rule plants all variants, as indices of species with the number
    /// of the variant, species by species.
    pub fn variants(&self) -> Vec<(usize, u32)> {
        let planted =
            |index: &usize| self.rules.iter().flat_map(|rule| &rule.kinds).any(|(kind, _)| kind == index);
        let species = (0..self.species.len()).filter(planted);
        species
            .flat_map(|index| (0..self.species[index].variants).map(move |variant| (index, variant)))
            .collect()
    }

    /// The kinds that rules name, of these models: those of [`Plan::variants`] and [`Plan::models`], in that order.
    pub fn kinds(&self, models: &[Arc<Model>]) -> Vec<Kind> {
        let variants = self.variants();
        let kind = |index: usize| {
            let range = variants.partition_point(|(other, _)| *other < index)
                ..variants.partition_point(|(other, _)| *other <= index);
            Kind::of_models(range.start as u32, models.get(range).unwrap_or_default())
        };
        let solid = |(index, model)| Kind::of_solid((variants.len() + index) as u32, model);
        let species = (0..self.species.len()).map(kind);
        species.chain(self.models.iter().enumerate().map(solid)).collect()
    }

    /// About how many plants the rules make at most, whatever the ground of this extent (m) is like.
    ///
    /// # Errors
    /// Where a rule would be refused on any ground.
    pub fn foresee(&self, extent: f32) -> Result<u64, Error> {
        self.rules.iter().try_fold(self.standing(), |sum, rule| {
            let plants = rule.foresee(extent)?.ceil() as u64;
            Ok(sum.saturating_add(plants))
        })
    }

    /// How many things stand already.
    pub fn standing(&self) -> u64 {
        self.standing.iter().map(|population| population.instances.len() as u64).sum()
    }

    /// Whether any rule asks where the camera is.
    pub fn follows_camera(&self) -> bool {
        self.rules.iter().any(Rule::follows_camera)
    }

    /// What the rules need to know of the land.
    pub fn needs(&self) -> Needs {
        self.rules.iter().map(|rule| rule.site.needs()).fold(Needs::default(), Needs::or)
    }
}

/// A rule that places plants.
#[derive(Clone, Debug)]
pub struct Rule {
    /// As messages call it.
    pub name: String,
    pub seed: u32,
    /// What it plants: indices of kinds, each with its share of the plants; shares need not sum to 1.
    pub kinds: Vec<(usize, f32)>,
    /// Least and greatest size, as multiples of the models'.
    pub scale: [f32; 2],
    /// How far plants lean away from the slope: 0 is upright, 1 is as the ground does.
    pub lean: f32,
    /// Share that lives under the crowns of earlier rules.
    pub shade: f32,
    pub site: Site,
    pub places: Places,
}

/// How a rule finds places.
#[derive(Clone, Debug, PartialEq)]
pub enum Places {
    Scatter(Scatter),
    Cover(Cover),
    Grid(Grid),
    Spots(Arc<[Spot]>),
}

/// Why nothing is planted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    #[error(
        "`{rule}` would bring the plants to about {count}, and there may be {most} of them; give it more spacing, less \
         density, or a narrower site"
    )]
    TooMany { rule: String, count: u64, most: u64 },

    #[error(
        "`{rule}` looks for places in {cells} cells of the ground, and may in {most}; give it more spacing, or less reach and density"
    )]
    TooFine { rule: String, cells: u64, most: u64 },
}

/// Most plants of a world.
pub const MOST_PLANTS: u64 = 10_000_000;

/// Memory that a plant takes while it is planted and then, bytes.
pub const PLANT_BYTES: u64 = (size_of::<Plant>() + size_of::<Instance>() + size_of::<Circle>() + 4) as u64;

impl Rule {
    /// Whether it plants where the camera is: cover round it, or a grid that it carries along.
    fn follows_camera(&self) -> bool {
        matches!(self.places, Places::Cover(_) | Places::Grid(_))
    }

    /// One of the kinds by their shares.
    fn pick(&self, random: &mut Random) -> usize {
        let all: f32 = self.kinds.iter().map(|(_, share)| share).sum();
        let mut left = random.share() * all;
        for (kind, share) in &self.kinds {
            left -= share;
            if left < 0.0 {
                return *kind;
            }
        }
        self.kinds.last().map_or(0, |(kind, _)| *kind)
    }

    /// About how many plants it makes where all ground is at its best.
    fn foresee(&self, extent: f32) -> Result<f64, Error> {
        // Where the ground decides, more of them are no mistake.
        let (plants, is_sure) = match &self.places {
            Places::Scatter(scatter) => {
                scatter.check(self, extent / 2.0)?;
                (f64::from(extent).powi(2) * f64::from(scatter.density), false)
            }
            Places::Cover(cover) => {
                cover.squares(self, Vec2::ZERO)?;
                (cover.predict(), true)
            }
            Places::Grid(grid) => (grid.predict(extent), true),
            Places::Spots(spots) => (spots.len() as f64, true),
        };
        let (count, most) = (plants.ceil() as u64, MOST_PLANTS);
        if is_sure && count > most {
            return Err(Error::TooMany { rule: self.name.clone(), count, most });
        }
        Ok(plants)
    }

    /// About how many plants it makes on this ground before any is shaded out, or hidden from the camera.
    pub fn predict(&self, ground: &Ground) -> f64 {
        match &self.places {
            Places::Scatter(scatter) => scatter::predict(self, scatter, ground),
            Places::Cover(cover) => cover.predict(),
            Places::Grid(grid) => grid.predict(ground.grid.extent),
            Places::Spots(spots) => spots.len() as f64,
        }
    }
}

/// What stands after some of the rules.
#[derive(Clone, Default)]
pub struct Standing {
    instances: Vec<Instance>,
    /// Of each rule.
    crowns: Vec<Arc<Crowns>>,
    done: usize,
}

/// Plants rule by rule.
pub struct Planter<'a> {
    rules: &'a [Rule],
    kinds: &'a [Kind],
    ground: &'a Ground,
    camera: &'a Pinhole,
    all_round: bool,
    standing: Standing,
    /// Things of the world that stand beside them.
    others: u64,
    most: u64,
}

impl<'a> Planter<'a> {
    /// `ground` has measured what the rules need; the rules' kinds are indices into `kinds`.
    pub fn new(rules: &'a [Rule], kinds: &'a [Kind], ground: &'a Ground, camera: &'a Pinhole) -> Self {
        let standing = Standing::default();
        Planter { rules, kinds, ground, camera, all_round: false, standing, others: 0, most: MOST_PLANTS }
    }

    /// Goes on from what the same rules made on the same ground, for whichever camera as long as none was [asked](Self::asks_camera).
    pub fn after(self, standing: Standing) -> Self {
        Planter { standing, ..self }
    }

    /// Plants ground cover on all sides of the camera, wherever it looks.
    pub fn all_round(self) -> Self {
        Planter { all_round: true, ..self }
    }

    /// Allows so many plants, in place of [`MOST_PLANTS`].
    pub fn at_most(self, most: u64) -> Self {
        Planter { most, ..self }
    }

    /// Counts so many other things with the plants.
    pub fn beside(self, others: u64) -> Self {
        Planter { others, ..self }
    }

    /// Follows the next rule; false if there was none left.
    ///
    /// # Errors
    /// When there would be too many plants: before memory is taken for them.
    pub fn step(&mut self) -> Result<bool, Error> {
        let Some(rule) = self.rules.get(self.standing.done) else { return Ok(false) };
        self.check(rule, rule.predict(self.ground))?;
        let plants = match &rule.places {
            Places::Scatter(scatter) => scatter::plant(rule, scatter, self)?,
            Places::Cover(cover) => cover::plant(rule, cover, self)?,
            Places::Grid(grid) => grid::plant(rule, grid, self),
            Places::Spots(spots) => spots::plant(rule, spots, self),
        };
        self.check(rule, plants.len() as f64)?;
        let standing = &mut self.standing;
        standing.instances.extend(plants.iter().map(|plant| plant.instance));
        standing.done += 1;
        // Nothing looks at the crowns of the last rule.
        if standing.done < self.rules.len() {
            let circles: Vec<Circle> = plants.iter().map(|plant| plant.circle).collect();
            standing.crowns.push(Arc::new(Crowns::new(self.ground.grid.extent / 2.0, &circles)));
        }
        Ok(true)
    }

    /// Whether the next rule asks where the camera is.
    pub fn asks_camera(&self) -> bool {
        self.rules.get(self.standing.done).is_some_and(Rule::follows_camera)
    }

    /// Rules followed, and rules in all.
    pub fn progress(&self) -> (usize, usize) {
        (self.standing.done, self.rules.len())
    }

    /// What is planted so far, to go on from.
    pub fn into_standing(self) -> Standing {
        self.standing
    }

    /// What is planted so far, rule by rule.
    pub fn into_instances(self) -> Vec<Instance> {
        self.standing.instances
    }

    fn check(&self, rule: &Rule, more: f64) -> Result<(), Error> {
        let count = self.others.saturating_add(self.standing.instances.len() as u64 + more.ceil() as u64);
        let (name, most) = (rule.name.clone(), self.most);
        if count > most { Err(Error::TooMany { rule: name, count, most }) } else { Ok(()) }
    }

    /// A plant of a rule at a place, unless earlier ones don't let it live.
    fn grow(&self, rule: &Rule, at: Vec2, scale: f32, random: &mut Random) -> Option<Plant> {
        let kind = &self.kinds[rule.pick(random)];
        let turn = turn(random);
        let plant = stand(rule, kind, self.ground, at, scale, turn, random);
        let place = self.standing.crowns.iter().map(|crowns| crowns.place(at, plant.circle.foot)).max();
        let lives = match place.unwrap_or(Place::Open) {
            Place::Open => true,
            Place::Shaded => plant.tolerance < rule.shade,
            Place::Taken => false,
        };
        lives.then_some(plant)
    }
}
