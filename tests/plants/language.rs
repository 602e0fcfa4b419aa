//! The language of L-systems: the figures of the book, in every number that is known of them; chance, by its moments;
//! random grammars, beside an evaluator that works on strings.

use crate::reference::lsystem::{self as naive, Naive};
use proptest::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use terrane::core::hash::hexadecimal;
use terrane::plants::{
    derive::{self, Change, Derivation, Limits, Problem, Steps},
    grammar::Grammar,
    species::Error,
    turtle::{self, Interpretation, Side, Tropism},
    watch::Watch,
};
use terrane::world::species;

/// Figures of Prusinkiewicz & Lindenmayer 1990 with counts, hashes, boxes and areas.
#[derive(Deserialize)]
struct Conformance {
    systems: Vec<System>,
    printed_derivation_eq1_7: Vec<String>,
    stochastic: Vec<Stochastic>,
    thesis_example: Printed,
}

#[derive(Deserialize)]
#[allow(non_snake_case)] // As in the file.
struct Stochastic {
    axiom: String,
    productions: Vec<String>,
    n: u32,
    expected_F_mean_per_step: Vec<f64>,
    expected_F_variance_per_step: Vec<f64>,
    F_min: u64,
    F_max: u64,
}

/// Words, from the axiom on.
#[derive(Deserialize)]
struct Printed {
    axiom: String,
    productions: Vec<String>,
    words: Vec<String>,
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
    serde_json::from_str(include_str!("../data/lsystem_conformance.json")).unwrap()
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

        let measure =
            |side| turtle::draw(&word, &system.interpretation(side), &Limits::default()).unwrap().measure;
        let left = measure(Side::Left);
        assert_eq!(left.brackets, expected.branches, "{id}");
        assert_eq!(left.depth, expected.max_bracket_depth, "{id}");
        assert_eq!(left.segments, expected.drawn_segments, "{id}");
        assert_eq!(left.polygons, expected.polygons, "{id}");
        assert_eq!(left.polygon_vertices, expected.polygon_vertices, "{id}");
        let right = measure(Side::Right);
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

/// The words after 0, 1, 2 … steps.
fn words(text: &str, steps: u32, seed: u32) -> Vec<String> {
    let grammar = Grammar::parse(text, "").unwrap();
    let mut derivation = Derivation::new(&grammar, seed, &Limits::default()).unwrap();
    let mut words = vec![derivation.word().to_string()];
    for _ in 0..steps {
        derivation.step().unwrap();
        words.push(derivation.word().to_string());
    }
    words
}

fn text(axiom: &str, productions: &[String]) -> String {
    format!("axiom {axiom}\n{}", productions.join("\n"))
}

#[test]
fn derivations_come_out_as_they_are_printed() {
    let Conformance { systems, printed_derivation_eq1_7: printed, thesis_example, .. } = conformance();
    let system = systems.iter().find(|system| system.id == "abop_eq1.7").unwrap();
    // The book prints six digits.
    let rounded = |word: &String| -> String {
        let mut parts = word.split_inclusive(['(', ',', ')']).map(|part| {
            let (value, end) = part.split_at(part.len() - 1);
            match value.parse::<f64>() {
                Ok(value) => format!("{}{end}", format!("{value:.5e}").parse::<f64>().unwrap()),
                Err(_) => part.into(),
            }
        });
        parts.by_ref().collect()
    };
    let found: Vec<String> = words(&system.text(), system.n, 1).iter().map(rounded).collect();
    assert_eq!(found, printed);

    let Printed { axiom, productions, words: printed } = thesis_example;
    assert_eq!(words(&text(&axiom, &productions), 2, 1), printed);
}

#[test]
fn chance_has_the_moments_of_its_weights() {
    const SEEDS: u32 = 3000;
    let systems = conformance().stochastic;
    assert!(!systems.is_empty());
    for system in systems {
        let grammar = Grammar::parse(&text(&system.axiom, &system.productions), "").unwrap();
        let steps = system.n as usize;
        let mut counts = vec![Vec::new(); steps + 1];
        for seed in 0..SEEDS {
            let mut derivation = Derivation::new(&grammar, seed, &Limits::default()).unwrap();
            for (step, counts) in counts.iter_mut().enumerate() {
                if step > 0 {
                    derivation.step().unwrap();
                }
                counts.push(derivation.word().counts()[&'F']);
            }
        }
        for (step, counts) in counts.iter().enumerate() {
            let [mean, variance] = moments(counts.iter().map(|&count| count as f64));
            let [wanted, spread] =
                [system.expected_F_mean_per_step[step], system.expected_F_variance_per_step[step]];
            // Four standard errors of a mean.
            let error = 4.0 * (spread / f64::from(SEEDS)).sqrt();
            assert!((mean - wanted).abs() <= error, "step {step}: the mean is {mean}, not {wanted}");
            // A variance of so many has a standard error of 2.6 % where the distribution is normal.
            assert!((variance - spread).abs() <= 0.1 * spread, "step {step}: {variance}, not {spread}");
        }
        let last = &counts[steps];
        assert!(last.iter().all(|count| (system.F_min..=system.F_max).contains(count)));
    }
}

#[test]
fn weights_and_random_numbers_are_as_they_say() {
    // Every one of ten thousand modules chooses for itself.
    let many = format!("axiom {}\n", "A(1)".repeat(10_000));
    let counts = |rules: &str| {
        let grammar = Grammar::parse(&format!("{many}{rules}"), "").unwrap();
        derive::derive(&grammar, Steps::Fixed(1), 5, &Limits::default()).unwrap()
    };
    let word = counts("A(x) -(1)> B\nA(x) -(2)> C\nA(x) : x > 1 -(100)> D\nA(x) -(x+4)> E\nA(x) -(0)> G");
    for (symbol, share) in [('B', 0.125), ('C', 0.25), ('D', 0.0), ('E', 0.625), ('G', 0.0)] {
        let count = word.counts().get(&symbol).copied().unwrap_or_default() as f64;
        let deviation = f64::sqrt(1e4 * share * (1.0 - share));
        assert!((count - 1e4 * share).abs() <= 4.0 * deviation, "{symbol}: {count}");
    }

    let word = counts("A(x) -> A(rnd(2,5),rnd(0,1))");
    let values: Vec<[f64; 2]> =
        word.modules().map(|module| [module.parameters[0], module.parameters[1]]).collect();
    assert!(values.iter().all(|[first, second]| (2.0..5.0).contains(first) && (0.0..1.0).contains(second)));
    let [mean, variance] = moments(values.iter().map(|[first, _]| *first));
    // Uniform over a length of 3: the standard error of the mean is 0.0087, that of the variance 0.9 %.
    assert!((mean - 3.5).abs() < 0.035 && (variance - 0.75).abs() < 0.03, "{mean} {variance}");
    // Two calls in one module, and modules side by side, know nothing of each other.
    let normal = |value: f64, mean: f64, length: f64| (value - mean) / (length / 12_f64.sqrt());
    let pairs = values.iter().map(|[first, second]| normal(*first, 3.5, 3.0) * normal(*second, 0.5, 1.0));
    let [correlation, _] = moments(pairs);
    assert!(correlation.abs() < 0.04, "{correlation}");
    let beside = values.windows(2).map(|pair| normal(pair[0][0], 3.5, 3.0) * normal(pair[1][0], 3.5, 3.0));
    let [correlation, _] = moments(beside);
    assert!(correlation.abs() < 0.04, "{correlation}");
}

fn moments(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    [mean, values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0)]
}

#[test]
fn expressions_have_the_values_of_arithmetic() {
    for (expression, wanted) in [
        ("1+2*3", 7.0),
        ("(1+2)*3", 9.0),
        ("8/4/2", 1.0),
        ("5-2-1", 2.0),
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("4^0.5", 2.0),
        ("-3*-2", 6.0),
        ("1e3 + .5", 1000.5),
        ("2 < 3", 1.0),
        ("2 >= 3", 0.0),
        ("1 = 1", 1.0),
        ("1 == 2", 0.0),
        ("1 != 2", 1.0),
        ("1 < 2 && 2 < 3", 1.0),
        ("0 && 1 || 1", 1.0),
        ("1 || 0 && 0", 1.0),
        ("!0 + 1", 2.0),
        ("!(1 > 2)", 1.0),
        ("2 && 3", 1.0),
        ("min(2,3) + max(2,3)", 5.0),
        ("abs(-2.5)", 2.5),
        ("sqrt(2)", std::f64::consts::SQRT_2),
        ("exp(1)", std::f64::consts::E),
        ("ln(exp(2))", 2.0),
        ("sin(30)", 0.5),
        ("sin(180)", 0.0),
        ("cos(60)", 0.5),
        ("cos(-90)", 0.0),
        ("tan(45)", 1.0),
        ("floor(-1.5)", -2.0),
        ("ceil(-1.5)", -1.0),
        ("sign(-7) + sign(0) + 2*sign(3)", 1.0),
    ] {
        // As a constant, and where parameters keep it from being folded.
        let unfolded: String = expression
            .replace("1e3", "1000")
            .split_inclusive(|letter: char| !letter.is_ascii_digit() && letter != '.')
            .map(|part| {
                let digits = part.trim_end_matches(|letter: char| !letter.is_ascii_digit() && letter != '.');
                if digits.is_empty() { part.into() } else { format!("(x*{digits}){}", &part[digits.len()..]) }
            })
            .collect();
        for text in
            [format!("axiom A({expression})"), format!("axiom B(1)\nB(x) -> A({unfolded})\nA(x) -> A(x)")]
        {
            let grammar = Grammar::parse(&text, "").unwrap();
            let word = derive::derive(&grammar, Steps::Fixed(1), 1, &Limits::default()).unwrap();
            let found = word.modules().next().unwrap().parameters[0];
            assert!(
                (found - wanted).abs() < 1e-14 * wanted.abs().max(1.0),
                "{text} is {found}, not {wanted}"
            );
        }
    }
}

// The manual ---------------------------------------------------------------------------------------------------------

/// The fenced blocks of a page: kind and text.
fn blocks(page: &str) -> Vec<(&str, &str)> {
    let parts: Vec<&str> = page.split("```").collect();
    parts.iter().skip(1).step_by(2).filter_map(|block| block.split_once('\n')).collect()
}

#[test]
fn the_manuals_grammars_grow_as_it_says() {
    let page = include_str!("../../docs/plants.md");
    let blocks = blocks(page);
    let (mut derived, mut grown) = (0, 0);
    for (index, (kind, text)) in blocks.iter().enumerate() {
        match *kind {
            "lsystem" => {
                let grammar = Grammar::parse(text, "").unwrap_or_else(|error| panic!("{error} in\n{text}"));
                derive::derive(&grammar, Steps::Fixed(4), 1, &Limits::default()).unwrap();
                if let Some(("words", printed)) = blocks.get(index + 1) {
                    let printed: Vec<&str> = printed.lines().collect();
                    assert_eq!(words(text, printed.len() as u32 - 1, 1), printed);
                    derived += 1;
                }
            }
            "toml" => {
                let loaded =
                    species::parse("plant.toml", text.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(loaded.warnings, [""; 0]);
                let model = loaded.species.grow(1, 0, &Limits::default()).unwrap();
                assert!(model.levels[0].triangles() > 0);
                grown += 1;
            }
            _ => {}
        }
    }
    assert!(derived >= 3 && grown >= 3, "{derived} {grown}");
    // The table of commands names all that the turtle knows.
    for command in
        ["F", "f", "G", "+", "-", "&", "^", "\\", "/", "$", "[", "]", "!", "'", "{", ".", "}", "~X", "@X"]
    {
        assert!(
            page.contains(&format!("`{command}`")) || page.contains(&format!("`{command}(")),
            "{command}"
        );
    }
}

// Random grammars ----------------------------------------------------------------------------------------------------

/// A grammar out of numbers that decide what comes next.
struct Writer<'a> {
    decisions: std::iter::Cycle<std::slice::Iter<'a, u32>>,
    made: u32,
    names: Vec<String>,
}

impl Writer<'_> {
    fn pick(&mut self, count: u32) -> u32 {
        // The same numbers again decide otherwise.
        self.made = self.made.wrapping_add(0x9e37_79b9);
        terrane::core::hash::mix(self.decisions.next().copied().unwrap_or_default() ^ self.made) % count
    }

    fn one<'b>(&mut self, of: &[&'b str]) -> &'b str {
        of[self.pick(of.len() as u32) as usize]
    }

    /// The names that are known are the parameters' and the constants'.
    fn expression(&mut self, depth: u32) -> String {
        let numbers = ["0", "1", "2", "3", "0.5", "1.25"];
        match self.pick(if depth == 0 { 2 } else { 9 }) {
            0 => self.one(&numbers).into(),
            1 | 2 if !self.names.is_empty() => {
                let index = self.pick(self.names.len() as u32);
                self.names[index as usize].clone()
            }
            3 => format!("({})", self.expression(depth - 1)),
            4 => {
                let sign = self.one(&["-", "!"]);
                format!("{sign}({})", self.expression(depth - 1))
            }
            5 => {
                let function = self.one(&["abs", "floor", "ceil", "sign"]);
                format!("{function}({})", self.expression(depth - 1))
            }
            6 => {
                let function = self.one(&["min", "max"]);
                format!("{function}({},{})", self.expression(depth - 1), self.expression(depth - 1))
            }
            7 if depth > 0 => self.comparison(depth - 1),
            _ if depth > 0 => {
                let operator = self.one(&["+", "-", "*", "+", "-", "*", "/"]);
                format!("{}{operator}{}", self.expression(depth - 1), self.expression(depth - 1))
            }
            _ => self.one(&numbers).into(),
        }
    }

    fn comparison(&mut self, depth: u32) -> String {
        let operator = self.one(&["<", ">", "<=", ">=", "=", "==", "!="]);
        format!("({}{operator}{})", self.expression(depth), self.expression(depth))
    }

    fn condition(&mut self) -> String {
        let first = self.comparison(1);
        match self.pick(4) {
            0 => format!("{first}&&{}", self.comparison(1)),
            1 => format!("{first}||{}", self.comparison(1)),
            _ => first,
        }
    }

    /// A letter with its usual number of parameters, sometimes with another one.
    fn letter(&mut self) -> (&'static str, u32) {
        let (symbol, arity) =
            [("A", 1), ("B", 2), ("C", 0), ("F", 1), ("+", 0), ("F", 0)][self.pick(6) as usize];
        (symbol, if self.pick(10) == 0 { self.pick(3) } else { arity })
    }

    fn formal(&mut self) -> String {
        let (symbol, arity) = self.letter();
        let first = self.names.len();
        self.names.extend((first..first + arity as usize).map(|index| format!("p{index}")));
        if arity == 0 { symbol.into() } else { format!("{symbol}({})", self.names[first..].join(",")) }
    }

    fn word(&mut self, depth: u32) -> String {
        let mut word = String::new();
        for _ in 0..1 + self.pick(4) {
            if depth > 0 && self.pick(4) == 0 {
                word += &format!("[{}]", self.word(depth - 1));
                continue;
            }
            if self.pick(25) == 0 {
                word.push('%');
                continue;
            }
            let (symbol, arity) = self.letter();
            let values: Vec<String> = (0..arity)
                .map(|_| if self.pick(8) == 0 { "rnd(0,2)".into() } else { self.expression(2) })
                .collect();
            word += symbol;
            if !values.is_empty() {
                word += &format!("({})", values.join(","));
            }
        }
        word
    }

    fn rule(&mut self, constants: usize) -> String {
        self.names.truncate(constants);
        let left: String = if self.pick(3) == 0 {
            (0..=self.pick(2)).map(|_| self.formal()).collect()
        } else {
            String::new()
        };
        let module = self.formal();
        let right = if self.pick(3) == 0 { self.right(1) } else { String::new() };
        let mut rule = String::new();
        if !left.is_empty() {
            rule += &format!("{left} < ");
        }
        rule += &module;
        if !right.is_empty() {
            rule += &format!(" > {right}");
        }
        if self.pick(3) == 0 {
            rule += &format!(" : {}", self.condition());
        }
        if self.pick(3) == 0 {
            let weight = if self.pick(3) == 0 { format!("abs({})", self.expression(1)) } else { "2".into() };
            rule += &format!(" -({weight})> ");
        } else {
            rule += " -> ";
        }
        rule + &if self.pick(12) == 0 { "*".into() } else { self.word(2) }
    }

    fn right(&mut self, depth: u32) -> String {
        let mut context = String::new();
        for _ in 0..=self.pick(2) {
            if depth > 0 && self.pick(3) == 0 {
                context += &format!("[{}]", self.right(depth - 1));
            } else {
                context += &self.formal();
            }
        }
        context
    }

    fn grammar(mut self) -> String {
        let mut lines = vec![format!("c = {}", self.expression(1))];
        self.names.push("c".into());
        lines.push(format!("d = {}", self.expression(1)));
        self.names.push("d".into());
        let constants = self.names.len();
        lines.push(format!("axiom {}{}", self.word(2), self.word(2)));
        for _ in 0..3 + self.pick(5) {
            lines.push(self.rule(constants));
        }
        lines.join("\n")
    }
}

/// The property below would be no good if nothing came of its grammars.
#[test]
fn random_grammars_are_of_all_kinds() {
    const COUNT: u32 = 400;
    let (mut read, mut grown) = (0, 0);
    let mut kinds = [0; 5];
    for case in 0..COUNT {
        let decisions: Vec<u32> = (0..50).map(|index| terrane::core::hash::mix(50 * case + index)).collect();
        let text = Writer { decisions: decisions.iter().cycle(), made: 0, names: Vec::new() }.grammar();
        let Ok(grammar) = Grammar::parse(&text, "+") else { continue };
        read += 1;
        let limits = Limits { modules: 1500, ..Limits::default() };
        let Ok(mut derivation) = Derivation::new(&grammar, 1, &limits) else { continue };
        let changes = (0..3).filter(|_| derivation.step() == Ok(Change::Changed)).count();
        grown += u32::from(changes == 3);
        // Without one kind of thing, the third word is another one.
        let third = derivation.word().to_string();
        let without: [fn(&str) -> bool; 5] = [
            |line| line.contains(" < "),
            |line| line.contains(" > "),
            |line| line.contains(" : "),
            |line| line.contains(")> "),
            |line| line.contains('['),
        ];
        for (count, is) in kinds.iter_mut().zip(without) {
            let rest: Vec<&str> = text.lines().filter(|line| line.contains("axiom") || !is(line)).collect();
            let other = Grammar::parse(&rest.join("\n"), "+").unwrap();
            let other = derive::derive(&other, Steps::Fixed(3), 1, &limits);
            *count += u32::from(changes == 3 && other.is_ok_and(|word| word.to_string() != third));
        }
    }
    assert!(read > COUNT / 2 && grown > COUNT / 4, "{read} are grammars, {grown} grow");
    assert!(
        kinds.iter().all(|&count| count > COUNT / 40),
        "contexts, conditions, chance, branches: {kinds:?}"
    );
}

/// Growth looks up in each of its parts, and goes no further once it shall not.
#[test]
fn growth_can_be_stopped_at_any_look() {
    // A million modules, and a branch of ten thousand nodes.
    let grammar = format!("axiom A{}\nA -> AA", "F(0.1)+(7)&(3)".repeat(10_000));
    let text = format!("format = 1\nsteps = 20\ngrammar = '''\n{grammar}\n'''\n");
    let species = species::parse("plant.toml", text.as_bytes()).unwrap().species;
    let grow = |most: u32| {
        let looks = AtomicU32::new(0);
        let operations = AtomicU64::new(0);
        let look = |more| {
            operations.fetch_add(more, Ordering::Relaxed);
            looks.fetch_add(1, Ordering::Relaxed) + 1 < most
        };
        let limits = Limits { watch: Watch::new(&look), ..Limits::default() };
        let grown = species.grow(1, 0, &limits);
        (grown, looks.into_inner(), operations.into_inner())
    };
    let (grown, looks, operations) = grow(u32::MAX);
    assert!(grown.is_ok() && looks >= 8, "{looks} looks");
    assert!(operations / u64::from(looks) < 10_000_000, "{operations} operations in {looks} looks");
    let mut parts = [0; 3];
    for most in 1..=looks {
        let (grown, looked, _) = grow(most);
        assert_eq!(looked, most, "it went on");
        match grown {
            Err(Error::Derive(derive::Error { problem: Problem::Stopped(_), .. })) => parts[0] += 1,
            Err(Error::Draw(turtle::Error { problem: turtle::Problem::Stopped(_), .. })) => parts[1] += 1,
            Err(Error::Stopped(_)) => parts[2] += 1,
            other => panic!("{other:?}"),
        }
    }
    assert!(parts.iter().all(|&count| count > 0), "derivation, turtle, triangles: {parts:?}");
}

#[test]
fn a_word_that_differs_in_the_sign_of_a_zero_is_another() {
    let grammar = Grammar::parse("axiom A(0)\nA(x) -> A(-x)", "").unwrap();
    let mut derivation = Derivation::new(&grammar, 1, &Limits::default()).unwrap();
    assert_eq!(derivation.step().unwrap(), Change::Changed);
    assert_eq!(derivation.word().to_string(), "A(-0)");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn random_grammars_derive_as_a_naive_evaluator_says(
        decisions in prop::collection::vec(any::<u32>(), 1..200),
        ignore in prop::sample::select(vec!["", "+", "F", "+F", "C"]),
        seed in any::<u32>(),
    ) {
        let text = Writer { decisions: decisions.iter().cycle(), made: 0, names: Vec::new() }.grammar();
        // Division by zero where nothing varies is a mistake in the text.
        let Ok(grammar) = Grammar::parse(&text, ignore) else { return Ok(()) };
        let naive = Naive::new(&text, ignore, seed).unwrap();
        let limits = Limits { modules: 1500, ..Limits::default() };
        let word = naive.axiom();
        let derivation = Derivation::new(&grammar, seed, &limits);
        prop_assert_eq!(derivation.is_ok(), word.is_ok(), "{}", text);
        let (Ok(mut derivation), Ok(mut word)) = (derivation, word) else { return Ok(()) };
        prop_assert_eq!(derivation.word().to_string(), word.clone(), "{}", text);
        for step in 1..=6 {
            let next = naive.step(&word, step);
            match derivation.step() {
                Ok(change) => {
                    let Ok(next) = next else { panic!("step {step} has no value:\n{text}") };
                    prop_assert_eq!(derivation.word().to_string(), next.clone(), "step {} of\n{}", step, text);
                    prop_assert!(change == Change::Changed || next == word);
                    word = next;
                }
                // What is refused was counted right.
                Err(derive::Error { problem: Problem::Modules { count, .. }, .. }) => {
                    let Ok(next) = next else { return Ok(()) };
                    prop_assert_eq!(count, naive::length(&next), "step {} of\n{}", step, text);
                    return Ok(());
                }
                Err(error) => {
                    prop_assert!(next.is_err(), "step {step} is {next:?}, not {error}:\n{text}");
                    return Ok(());
                }
            }
        }
    }
}
