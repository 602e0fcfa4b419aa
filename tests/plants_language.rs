//! The language of L-systems: the figures of the book, in every number that is known of them.

use serde::Deserialize;
use std::collections::BTreeMap;
use terrane::core::hash::hexadecimal;
use terrane::plants::{
    derive::{Derivation, Limits},
    grammar::Grammar,
    turtle::{self, Interpretation, Side, Tropism},
};

/// Figures of Prusinkiewicz & Lindenmayer 1990 with counts, hashes, boxes and areas.
#[derive(Deserialize)]
struct Conformance {
    systems: Vec<System>,
}

#[derive(Deserialize)]
struct System {
    id: String,
    axiom: String,
    /// In the order of their use.
    defines: serde_json::Map<String, serde_json::Value>,
    productions: Vec<String>,
    context_ignore: String,
    n: u32,
    delta_deg: f64,
    tropism: Option<Bend>,
    draw_symbols: String,
    move_symbols: String,
    expected: Expected,
}

#[derive(Deserialize)]
struct Bend {
    #[serde(rename = "T")]
    direction: [f64; 3],
    e: f64,
}

#[derive(Deserialize)]
struct Expected {
    modules: usize,
    counts: BTreeMap<char, u64>,
    branches: u64,
    per_step_modules: Vec<usize>,
    per_step_drawn: Vec<u64>,
    sha256_symbols: String,
    bbox_min: [f64; 3],
    bbox_max: [f64; 3],
    bbox_min_plus_right: [f64; 3],
    bbox_max_plus_right: [f64; 3],
    drawn_segments: u64,
    drawn_length: f64,
    max_bracket_depth: u32,
    polygons: u64,
    polygon_vertices: u64,
    polygon_area_sum: f64,
    end_position: [f64; 3],
}

impl System {
    fn text(&self) -> String {
        let constants = self.defines.iter().map(|(name, value)| match value.as_str() {
            Some(expression) => format!("{name} = {expression}"),
            None => format!("{name} = {value}"),
        });
        let axiom = format!("axiom {}", self.axiom);
        let lines: Vec<String> = constants.chain([axiom]).chain(self.productions.iter().cloned()).collect();
        lines.join("\n")
    }

    fn interpretation(&self, plus: Side) -> Interpretation {
        // A leaf is drawn with the symbol that leaves no vertices; elsewhere `G` is a letter like others.
        let silent = if self.draw_symbols.contains('G') { "G" } else { "" };
        Interpretation {
            angle: self.delta_deg.to_radians(),
            draw: self.draw_symbols.clone(),
            moves: self.move_symbols.clone(),
            silent: silent.into(),
            plus,
            tropism: self
                .tropism
                .as_ref()
                .map(|bend| Tropism { direction: bend.direction.into(), strength: bend.e }),
            ..Interpretation::default()
        }
    }
}

fn conformance() -> Conformance {
    serde_json::from_str(include_str!("data/lsystem_conformance.json")).unwrap()
}

#[test]
fn the_books_figures_come_out_in_every_number() {
    let systems = conformance().systems;
    assert_eq!(systems.len(), 22);
    for system in &systems {
        let (id, expected) = (&system.id, &system.expected);
        let grammar = Grammar::parse(&system.text(), &system.context_ignore).unwrap();
        let mut derivation = Derivation::new(&grammar, 1, &Limits::default()).unwrap();
        let drawn = |derivation: &Derivation| -> u64 {
            let counts = derivation.word().counts();
            system.draw_symbols.chars().filter_map(|symbol| counts.get(&symbol)).sum()
        };
        let mut modules = vec![derivation.word().len()];
        let mut drawn_by_step = vec![drawn(&derivation)];
        for _ in 0..system.n {
            derivation.step().unwrap();
            modules.push(derivation.word().len());
            drawn_by_step.push(drawn(&derivation));
        }
        assert_eq!(modules, expected.per_step_modules, "{id}");
        assert_eq!(drawn_by_step, expected.per_step_drawn, "{id}");
        let word = derivation.into_word();
        assert_eq!(word.len(), expected.modules, "{id}");
        assert_eq!(word.counts(), expected.counts, "{id}");
        assert_eq!(hexadecimal(&word.sha256()), expected.sha256_symbols, "{id}");

        let left = turtle::measure(&word, &system.interpretation(Side::Left)).unwrap();
        assert_eq!(left.brackets, expected.branches, "{id}");
        assert_eq!(left.depth, expected.max_bracket_depth, "{id}");
        assert_eq!(left.segments, expected.drawn_segments, "{id}");
        assert_eq!(left.polygons, expected.polygons, "{id}");
        assert_eq!(left.polygon_vertices, expected.polygon_vertices, "{id}");
        let right = turtle::measure(&word, &system.interpretation(Side::Right)).unwrap();
        let extent = (left.bounds[1] - left.bounds[0]).max_element().max(1.0);
        let near = |found: f64, wanted: f64, scale: f64, what: &str| {
            assert!((found - wanted).abs() <= 1e-9 * scale, "{id}: {what} is {found}, not {wanted}");
        };
        near(left.length, expected.drawn_length, expected.drawn_length, "length");
        near(left.polygon_area, expected.polygon_area_sum, expected.polygon_area_sum, "area");
        for axis in 0..3 {
            near(left.bounds[0][axis], expected.bbox_min[axis], extent, "least");
            near(left.bounds[1][axis], expected.bbox_max[axis], extent, "greatest");
            near(right.bounds[0][axis], expected.bbox_min_plus_right[axis], extent, "least, + is right,");
            near(right.bounds[1][axis], expected.bbox_max_plus_right[axis], extent, "greatest, + is right,");
            near(left.end[axis], expected.end_position[axis], extent, "end");
        }
    }
}
