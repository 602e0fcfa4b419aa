//! Figures of a plant.

use crate::core::hash::hexadecimal;
use crate::plants::derive::{Change, Derivation, Limits, Steps};
use crate::plants::mesh::Body;
use crate::plants::species::{Error, Species, variant_seed};
use crate::plants::turtle::{self, Measure};
use crate::scene::Model;
use glam::DVec3;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// What a plant is made of.
pub struct Stats {
    name: String,
    variant: u32,
    /// How often each symbol stands in the word: in the axiom, and after each step.
    counts: Vec<BTreeMap<char, u64>>,
    /// SHA-256 of the last word's symbols, without parameters.
    sha256: String,
    /// Of the turtle's way, before the plant is scaled to its height.
    measure: Measure,
    /// Least and greatest coordinates of the plant, metres.
    bounds: [DVec3; 2],
    /// One-sided, of organs too, m².
    leaf_area: f64,
    /// Smallest detail, metres, and triangles of each level.
    levels: Vec<(f32, usize)>,
}

impl Stats {
    pub fn of(
        species: &Species,
        variant: u32,
        seed: u32,
        body: &Body,
        model: &Model,
        limits: &Limits,
    ) -> Result<Stats, Error> {
        let form = &species.form;
        let mut derivation = Derivation::new(&form.grammar, variant_seed(seed, variant), limits)?;
        let mut counts = vec![derivation.word().counts()];
        let most = match form.steps {
            Steps::Fixed(steps) => steps,
            Steps::UntilDone => limits.steps,
        };
        for _ in 0..most {
            // A step that changes nothing is none, unless it was asked for.
            if derivation.step()? == Change::Done && form.steps == Steps::UntilDone {
                break;
            }
            counts.push(derivation.word().counts());
        }
        let word = derivation.into_word();
        Ok(Stats {
            name: species.name.clone(),
            variant,
            counts,
            sha256: hexadecimal(&word.sha256()),
            measure: turtle::draw(&word, &form.turtle)?.measure,
            bounds: body.bounds().unwrap_or_default(),
            leaf_area: body.leaf_area(),
            levels: model.levels.iter().map(|level| (level.detail, level.triangles())).collect(),
        })
    }

    fn last(&self) -> &BTreeMap<char, u64> {
        // The axiom is counted in any case.
        &self.counts[self.counts.len() - 1]
    }

    /// For programs. Lengths and areas of the turtle's way are those of the grammar, before the plant is scaled to its
    /// height.
    pub fn object(&self) -> Value {
        let Stats { measure, bounds: [least, most], .. } = self;
        let steps = self.counts.iter().map(|counts| json!({ "modules": modules(counts), "counts": counts }));
        let levels =
            self.levels.iter().map(|(detail, triangles)| json!({ "detail": detail, "triangles": triangles }));
        json!({
            "name": self.name,
            "variant": self.variant,
            "modules": modules(self.last()),
            "counts": self.last(),
            "branches": self.last().get(&'[').unwrap_or(&0),
            "sha256_symbols": self.sha256,
            "steps": steps.collect::<Vec<_>>(),
            "bbox_min": measure.bounds[0].to_array(),
            "bbox_max": measure.bounds[1].to_array(),
            "end_position": measure.end.to_array(),
            "drawn_segments": measure.segments,
            "drawn_length": measure.length,
            "max_bracket_depth": measure.depth,
            "polygons": measure.polygons,
            "polygon_vertices": measure.polygon_vertices,
            "polygon_area_sum": measure.polygon_area,
            "model_min": least.to_array(),
            "model_max": most.to_array(),
            "height": most.y - least.y,
            "leaf_area": self.leaf_area,
            "levels": levels.collect::<Vec<_>>(),
        })
    }
}

fn modules(counts: &BTreeMap<char, u64>) -> u64 {
    counts.values().sum()
}

/// For people.
impl Display for Stats {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Stats { measure, bounds: [least, most], .. } = self;
        writeln!(out, "{}, variant {}", self.name, self.variant)?;
        for (step, counts) in self.counts.iter().enumerate() {
            let heading = if step == 0 { "steps" } else { "" };
            write!(out, "{heading:<9} {step:>4} {:>9} modules:", modules(counts))?;
            counts.iter().try_for_each(|(symbol, count)| write!(out, " {symbol} {count}"))?;
            writeln!(out)?;
        }
        writeln!(out, "symbols   SHA-256 {}", self.sha256)?;
        writeln!(out, "branches  {}, at most {} deep", self.last().get(&'[').unwrap_or(&0), measure.depth)?;
        writeln!(out, "turtle    {} segments, {:.4} long in all", measure.segments, measure.length)?;
        let [from, to] = measure.bounds;
        writeln!(out, "          from {} to {}", Point(from), Point(to))?;
        writeln!(
            out,
            "polygons  {} with {} vertices, area {:.6} in all",
            measure.polygons, measure.polygon_vertices, measure.polygon_area
        )?;
        let size = *most - *least;
        writeln!(out, "plant     {:.3} m high, {:.3} m × {:.3} m wide", size.y, size.x, size.z)?;
        writeln!(out, "leaves    {:.4} m² on one side", self.leaf_area)?;
        for (level, (detail, triangles)) in self.levels.iter().enumerate() {
            let heading = if level == 0 { "levels" } else { "" };
            writeln!(out, "{heading:<9} {level:>4} {triangles:>9} triangles, details from {detail:.4} m")?;
        }
        Ok(())
    }
}

struct Point(DVec3);

impl Display for Point {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Point(DVec3 { x, y, z }) = self;
        write!(out, "({x:.4}, {y:.4}, {z:.4})")
    }
}
