//! The world's rules of planting: what they say, and what they become.

use super::fault::Complaint;
use super::keys::{DEGREES, M, NONE};
use super::kinds::*;
use super::place::{KeyPath, shown};
use super::plan::Check;
use super::schema::{REQUIRED, Unit, section};
use crate::core::hash::derive_seed;
use crate::core::map::Map;
use crate::plants::planting::{self, Footing, Places, Ramp, Rivalry};
use std::collections::HashMap;
use std::sync::Arc;

const PER_HECTARE: Unit = Unit { symbol: "per hectare", factor: 1e-4 };
const PER_M2: Unit = Unit { symbol: "m⁻²", factor: 1.0 };
const M3_PER_S: Unit = Unit { symbol: "m³/s", factor: 1.0 };

// Keys ---------------------------------------------------------------------------------------------------------------

/// A rule as it is written.
#[derive(Clone, Debug)]
pub enum Rule {
    Scatter(Scatter),
    Cover(Cover),
    Grid(Grid),
}

pub fn rule() -> OneOf<Rule> {
    one_of([tag("scatter", Rule::Scatter), tag("cover", Rule::Cover), tag("grid", Rule::Grid)])
}

/// Declares a rule: its own keys, and those that all rules share with this rule's values for what is not written.
macro_rules! rule {
    ($(#[doc = $about:literal])+ struct $name:ident {
        $($(#[doc = $doc:literal])+ $key:ident: $type:ty = $kind:expr,)+
        ..shared { scale: $scale:expr, lean: $lean:expr, shade: $shade:expr }
    }) => {
        section! {
            $(#[doc = $about])+
            struct $name {
                /// What is planted: names of `species` and `models`.
                species: Option<Vec<String>> = species(),
                /// How many there are of each, in proportion to the others.
                shares: Option<Vec<f32>> = shares(),
                $($(#[doc = $doc])+ $key: $type = $kind,)+
                /// Least and greatest size, as multiples of the species' own.
                scale: [f32; 2] = numbers($scale, NONE, 1e-3..=1000.0),
                /// How far plants lean away from the slope: 0 is upright, 1 is as the ground does.
                lean: f32 = number($lean, NONE, 0.0..=1.0),
                /// Share of the plants that lives under the crowns of those that earlier rules planted; nothing lives where
                /// a trunk stands.
                shade: f32 = number($shade, NONE, 0.0..=1.0),
                /// What they stand on.
                ground: Footing = footing(),
                /// Where they like to grow.
                site: Site = table::<Site>(),
                /// Its own seed.
                seed: Option<u32> = own_seed(),
            }
        }

        impl $name {
            fn shared(&self) -> Shared<'_> {
                let &$name { ref species, ref shares, scale, lean, shade, ground, ref site, seed, .. } = self;
                Shared { species, shares, scale, lean, shade, ground, site, seed }
            }
        }
    };
}

rule! {
    /// Plants at random places all over the land, none nearer to another than `spacing`: trees, shrubs, rocks.
    struct Scatter {
        /// Least distance between two plants of the rule.
        spacing: f32 = number(5.0, M, 0.05..=10_000.0),
        /// Plants where the site is at its best, before any is shaded out.
        density: Option<f32> = optional(number(100.0, PER_HECTARE, 1e-6..=1e7), "as many as `spacing` lets stand: 6121/spacing²"),
        /// What shades plants out (after Deussen et al. 1998).
        thinning: Rivalry = choice([
            ("earlier", "crowns of earlier rules", Rivalry::None),
            ("all", "larger plants of this rule, too", Rivalry::Size),
        ]),
        ..shared { scale: [0.75, 1.35], lean: 0.0, shade: 0.0 }
    }
}

rule! {
    /// Ground cover round the camera: grass, flowers, ferns, stones. Every plant has its place in the world; further from
    /// the camera fewer of them are seen, and of those that are seen from afar all are large.
    struct Cover {
        /// Plants where all are seen and the site is at its best.
        density: f32 = number(20.0, PER_M2, 1e-6..=10_000.0).usual(0.5..=40.0),
        /// All are seen up to this distance from the camera; beyond, their number falls with its square.
        near: f32 = number(8.0, M, 0.1..=10_000.0).usual(4.0..=20.0),
        /// None is seen beyond.
        reach: f32 = number(60.0, M, 0.1..=100_000.0).usual(30.0..=300.0),
        ..shared { scale: [0.6, 1.4], lean: 0.3, shade: 1.0 }
    }
}

rule! {
    /// Plants in the cells of a grid that the camera carries along (Rudzki 2020, section 4.3.10).
    struct Grid {
        /// From the camera to the middle of the grid: metres east and south.
        offset: [f32; 2] = numbers([0.0, 0.0], M, -1e6..=1e6),
        /// Cells from west to east, and from north to south.
        cells: [u32; 2] = wholes([1, 1], 1..=10_000),
        /// Side of a cell.
        cell_size: f32 = number(5.0, M, 0.0..=10_000.0),
        /// Share of the cells that are filled.
        probability: f32 = number(1.0, NONE, 0.0..=1.0),
        /// Side of the square round a cell's middle in which a plant stands, as a share of the cell's.
        jitter: f32 = number(0.5, NONE, 0.0..=1.0),
        ..shared { scale: [0.5, 2.0], lean: 0.0, shade: 1.0 }
    }
}

section! {
    /// Where plants like to grow: their density is the product of all that is said here. Two numbers are where none grows and
    /// where all do: `slope = [35, 25]` leaves out what is steeper than 35 degrees. Four are none, all, all, none:
    /// `height = [2, 10, 300, 500]`. Between them the density rises and falls in straight lines.
    struct Site {
        /// Height above the sea.
        height: Option<Vec<f32>> = ramp(M, -20_000.0..=20_000.0),
        /// Slope of the ground.
        slope: Option<Vec<f32>> = ramp(DEGREES, -1.0..=90.0),
        /// Distance to the sea.
        sea: Option<Vec<f32>> = ramp(M, -1.0..=1e7),
        /// Distance to a river, a lake or the sea.
        water: Option<Vec<f32>> = ramp(M, -1.0..=1e7),
        /// How lately water ran here, from 0 to 1; of hydraulic erosion.
        wetness: Option<Vec<f32>> = ramp(NONE, -1.0..=2.0),
        /// Water that runs off here; of hydraulic erosion.
        flow: Option<Vec<f32>> = ramp(M3_PER_S, -1.0..=1e6),
        /// A painted map, stretched over the terrain: nothing grows where it is black (0), all where it is white (1). Grey PNG
        /// or RAW, EXR or TIFF.
        mask: Option<String> = file(),
        /// Patches with bare ground between.
        patches: Option<Patches> = word_or("none", "Plants are spread evenly.", table::<Patches>()),
    }
}

section! {
    /// Plants stand in patches.
    struct Patches {
        /// Size of a patch.
        size: f32 = number(20.0, M, 0.01..=100_000.0),
        /// Share of the ground that lies in patches.
        cover: f32 = number(0.5, NONE, 0.0..=1.0),
    }
}

fn species() -> Optional<List<Text>> {
    optional(list(text("a name of `species` or `models`", ""), 1..=64, "[]"), REQUIRED)
}

fn shares() -> Optional<List<Number>> {
    optional(list(number(1.0, NONE, 0.0..=1e6), 1..=64, "[]"), "all alike")
}

fn footing() -> Choice<Footing> {
    choice([
        ("land", "ground above the sea and out of rivers and lakes", Footing::Land),
        ("water", "the bed of the sea, of rivers and of lakes", Footing::Water),
        ("anywhere", "land and water", Footing::Anywhere),
    ])
}

fn ramp(unit: Unit, range: std::ops::RangeInclusive<f64>) -> Optional<List<Number>> {
    optional(list(number(0.0, unit, range), 2..=4, "[]"), "anywhere").starting("[0, 1]")
}

fn own_seed() -> Optional<Whole> {
    optional(whole(1, 0..=u32::MAX), "from the world's seed and the names of its species")
}

// Checking -----------------------------------------------------------------------------------------------------------

/// What the rules of a world become. `names` are what they may plant, in the order of the kinds; `seed` is the world's.
pub fn rules(
    written: &[Rule],
    names: &[&str],
    seed: u32,
    has_rivers: bool,
    check: &mut Check,
) -> Vec<planting::Rule> {
    let mut reader = Reader { names, seed, has_rivers, same: HashMap::new(), check };
    let rules = written.iter().enumerate().map(|(index, rule)| reader.rule(rule, index));
    rules.collect::<Vec<_>>().into_iter().flatten().collect()
}

struct Reader<'a, 'b> {
    names: &'a [&'a str],
    seed: u32,
    /// Whether the world has hydraulic erosion.
    has_rivers: bool,
    /// How many rules there are with the same key for their seed.
    same: HashMap<String, u32>,
    check: &'a mut Check<'b>,
}

/// What all rules say.
struct Shared<'a> {
    species: &'a Option<Vec<String>>,
    shares: &'a Option<Vec<f32>>,
    scale: [f32; 2],
    lean: f32,
    shade: f32,
    ground: Footing,
    site: &'a Site,
    seed: Option<u32>,
}

impl Reader<'_, '_> {
    /// `None` where something is wrong that was noted.
    fn rule(&mut self, rule: &Rule, index: usize) -> Option<planting::Rule> {
        let place = KeyPath::from("plants").join(index);
        match rule {
            Rule::Scatter(scatter) => {
                let place = place.join("scatter");
                let places = Places::Scatter(self.scatter(scatter, &place));
                self.planted(scatter.shared(), places, "scatter", place)
            }
            Rule::Cover(cover) => {
                let place = place.join("cover");
                let &Cover { density, near, reach, .. } = cover;
                if near > reach {
                    let label = format!("allowed: up to `reach`, {reach} m");
                    self.refuse(
                        &[place.join("near"), place.join("reach")],
                        Complaint::new("lies beyond the reach", label),
                    );
                }
                self.planted(
                    cover.shared(),
                    Places::Cover(planting::Cover { density, near, reach }),
                    "cover",
                    place,
                )
            }
            Rule::Grid(grid) => {
                let place = place.join("grid");
                let &Grid { offset, cells, cell_size, probability, jitter, .. } = grid;
                let places = Places::Grid(planting::Grid {
                    offset: offset.into(),
                    cells,
                    cell_size,
                    probability,
                    jitter,
                });
                self.planted(grid.shared(), places, "grid", place)
            }
        }
    }

    fn scatter(&mut self, scatter: &Scatter, place: &KeyPath) -> planting::Scatter {
        let densest = planting::Scatter::densest(scatter.spacing);
        let density = scatter.density.unwrap_or(densest);
        if density > densest {
            let label = format!(
                "with a `spacing` of {} m, places at random hold {:.4} per hectare",
                scatter.spacing,
                1e4 * densest
            );
            let complaint = Complaint::new("is more than the spacing lets stand", label);
            self.refuse(
                &[place.join("density"), place.join("spacing")],
                complaint.help("lower it, or lower `spacing`"),
            );
        }
        planting::Scatter { spacing: scatter.spacing, density, rivalry: scatter.thinning }
    }

    fn planted(
        &mut self,
        shared: Shared,
        places: Places,
        tag: &str,
        place: KeyPath,
    ) -> Option<planting::Rule> {
        let [least, greatest] = shared.scale;
        if least > greatest {
            let complaint = Complaint::new("must not fall", "the least size before the greatest");
            self.refuse(&[place.join("scale")], complaint);
        }
        let kinds = self.kinds(&shared, &place)?;
        let key = format!(
            "plants.{tag}.{}",
            shared.species.iter().flatten().cloned().collect::<Vec<_>>().join(".")
        );
        let same = self.same.entry(key.clone()).or_default();
        *same += 1;
        // A rule like an earlier one has places of its own.
        let key = if *same > 1 { format!("{key}.{same}") } else { key };
        let seed = shared.seed.unwrap_or_else(|| derive_seed(self.seed, &key));
        Some(planting::Rule {
            name: place.to_string(),
            seed,
            kinds,
            scale: shared.scale,
            lean: shared.lean,
            shade: shared.shade,
            site: self.site(shared.site, shared.ground, seed, &place.join("site")),
            places,
        })
    }

    /// Kinds with their shares.
    fn kinds(&mut self, shared: &Shared, place: &KeyPath) -> Option<Vec<(usize, f32)>> {
        let at = place.join("species");
        let Some(species) = shared.species else {
            let known = format!("one or more of: {}", self.names.join(", "));
            let label = if self.names.is_empty() { NO_SPECIES.into() } else { known };
            self.refuse(&[at, place.clone()], Complaint::new("is missing", label).about_key());
            return None;
        };
        let mut kinds = Vec::new();
        for (index, name) in species.iter().enumerate() {
            let known = self.names.iter().copied();
            match self.names.iter().position(|known| known == name) {
                Some(kind) => kinds.push(kind),
                None => {
                    let allowed = if self.names.is_empty() {
                        NO_SPECIES.into()
                    } else {
                        format!("known: {}", self.names.join(", "))
                    };
                    let complaint = guess(format!("can't be \"{}\"", shown(name)), name, known, allowed);
                    self.refuse(&[at.join(index)], complaint);
                }
            }
        }
        let shares = shared.shares.clone().unwrap_or_else(|| vec![1.0; species.len()]);
        let wrong = if shares.len() != species.len() {
            Some(Complaint::new(
                format!("has {} numbers", shares.len()),
                format!("one for each of `species`: {}", species.len()),
            ))
        } else if shares.iter().all(|share| *share == 0.0) {
            Some(Complaint::new("leaves nothing to plant", "at least one above 0"))
        } else {
            None
        };
        if let Some(complaint) = wrong {
            self.refuse(&[place.join("shares"), at], complaint);
        }
        (kinds.len() == species.len()).then(|| kinds.into_iter().zip(shares).collect())
    }

    fn site(&mut self, site: &Site, footing: Footing, seed: u32, place: &KeyPath) -> planting::Site {
        let rivers = [("wetness", &site.wetness), ("flow", &site.flow)];
        for (name, _) in rivers.into_iter().filter(|(_, ramp)| ramp.is_some() && !self.has_rivers) {
            self.check
                .warn(format!("`{}` is 0 everywhere: the world has no hydraulic erosion", place.join(name)));
        }
        planting::Site {
            height: self.ramp(&site.height, &place.join("height")),
            slope: self.ramp(&site.slope, &place.join("slope")),
            sea: self.ramp(&site.sea, &place.join("sea")),
            water: self.ramp(&site.water, &place.join("water")),
            wetness: self.ramp(&site.wetness, &place.join("wetness")),
            flow: self.ramp(&site.flow, &place.join("flow")),
            mask: self.mask(site.mask.as_deref(), &place.join("mask")),
            patches: site.patches.as_ref().map(|patches| {
                planting::Patches::new(derive_seed(seed, "patches"), patches.size, patches.cover)
            }),
            footing,
        }
    }

    fn ramp(&mut self, values: &Option<Vec<f32>>, place: &KeyPath) -> Option<Ramp> {
        let values = values.as_ref()?;
        let ramp = Ramp::new(values);
        if ramp.is_none() {
            let problem = if values.len() == 4 { "must not fall" } else { "is no ramp" };
            let label = "two numbers that differ: where none grows, where all do; or four that rise: none, all, all, none";
            self.refuse(std::slice::from_ref(place), Complaint::new(problem, label));
        }
        ramp
    }

    fn mask(&mut self, path: Option<&str>, place: &KeyPath) -> Option<Arc<Map>> {
        let mask = self.check.factors(path?, place)?;
        if mask.values.iter().any(|value| !(0.0..=1.0).contains(value)) {
            let complaint = Complaint::new("holds values beyond 0 and 1", "a map of shares, from 0 to 1");
            self.refuse(std::slice::from_ref(place), complaint);
        }
        Some(mask)
    }

    fn refuse(&mut self, paths: &[KeyPath], complaint: Complaint) {
        self.check.refuse(paths, complaint);
    }
}

const NO_SPECIES: &str = "the world has no species: name some in its table `species`, or files in `models`";
