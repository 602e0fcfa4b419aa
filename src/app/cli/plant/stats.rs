//! Figures of a plant.

use crate::core::hash::hexadecimal;
use crate::plants::derive::Steps;
use crate::plants::mesh::Body;
use crate::plants::species::{Seen, Species};
use crate::plants::turtle::Measure;
use crate::scene::Model;
use glam::DVec3;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// What a plant is made of.
#[derive(Default)]
pub struct Stats {
    name: String,
    variant: u32,
    steps: Steps,
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
    pub fn of(species: &Species, variant: u32) -> Stats {
        Stats { name: species.name.clone(), variant, steps: species.form.steps, ..Stats::default() }
    }

    /// Counts what is seen of the plant while it grows.
    pub fn see(&mut self, seen: &Seen) {
        match seen {
            Seen::Word(word) => self.counts.push(word.counts()),
            Seen::Way(word, measure) => {
                self.sha256 = hexadecimal(&word.sha256());
                self.measure = **measure;
            }
        }
    }

    /// Measures what has grown.
    pub fn end(&mut self, body: &Body, model: &Model) {
        // Steps that change nothing are none, unless they were asked for.
        if let (Steps::Fixed(steps), Some(last)) = (self.steps, self.counts.last()) {
            let last = last.clone();
            self.counts.resize(steps as usize + 1, last);
        }
        self.bounds = body.bounds().unwrap_or_default();
        self.leaf_area = body.leaf_area();
        self.levels = model.levels.iter().map(|level| (level.detail, level.triangles())).collect();
    }

    /// Of the last word.
    fn branches(&self) -> u64 {
        self.counts.last().and_then(|counts| counts.get(&'[')).copied().unwrap_or(0)
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
            "modules": self.counts.last().map_or(0, modules),
            "counts": self.counts.last(),
            "branches": self.branches(),
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
        writeln!(out, "branches  {}, at most {} deep", self.branches(), measure.depth)?;
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
