//! `cargo bench --bench derivation`: how fast words are derived, beside a plain implementation, as a table in Markdown.
//!
//! The plain one is what one writes first: a word is a vector of modules, each a symbol with a vector of parameters, and
//! a hash map finds the function that writes what becomes of it. Its rules are compiled with it, expressions and all. Both
//! run on one core and take turns; the shortest of the runs counts.

use std::collections::HashMap;
use std::hint::black_box;
use std::time::{Duration, Instant};
use terrane::plants::derive::{Derivation, Limits};
use terrane::plants::grammar::Grammar;

const RUNS: u32 = 7;

fn main() {
    println!("| grammar | steps | modules | M modules/min | ns a module | plain ns | ratio |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for subject in subjects() {
        let (mut ours, mut plain) = (Duration::MAX, Duration::MAX);
        let (mut written, mut last) = (0, 0);
        for _ in 0..RUNS {
            let start = Instant::now();
            (written, last) = subject.derive();
            ours = ours.min(start.elapsed());
            if let Some(system) = &subject.plain {
                let start = Instant::now();
                let count = system.derive(subject.steps);
                plain = plain.min(start.elapsed());
                assert_eq!(count, (written, last), "{}", subject.name);
            }
        }
        let nanoseconds = |time: Duration| time.as_secs_f64() * 1e9 / written as f64;
        let beside = match subject.plain {
            Some(_) => format!("{:.1} | {:.2}", nanoseconds(plain), nanoseconds(ours) / nanoseconds(plain)),
            None => " | ".into(),
        };
        println!(
            "| {} | {} | {last} | {:.0} | {:.1} | {beside} |",
            subject.name,
            subject.steps,
            60e3 / nanoseconds(ours),
            nanoseconds(ours)
        );
    }
}

/// A figure of Prusinkiewicz & Lindenmayer 1990, in more steps than the book has.
struct Subject {
    name: &'static str,
    grammar: &'static str,
    ignore: &'static str,
    steps: u32,
    plain: Option<Plain>,
}

impl Subject {
    /// Modules written in all steps, and in the last one.
    fn derive(&self) -> (usize, usize) {
        let grammar = Grammar::parse(self.grammar, self.ignore).expect("a grammar");
        let limits = Limits { bytes: 4 << 30, work: u64::MAX, ..Limits::default() };
        let mut derivation = Derivation::new(&grammar, 1, &limits).expect("an axiom");
        let mut written = 0;
        for _ in 0..self.steps {
            derivation.step().expect("a word");
            written += derivation.word().len();
        }
        (written, black_box(derivation.into_word()).len())
    }
}

fn subjects() -> [Subject; 5] {
    [
        Subject {
            name: "1.24b, without parameters",
            grammar: "axiom F\nF -> F[+F]F[-F][F]",
            ignore: "",
            steps: 8,
            plain: Some(Plain {
                axiom: vec![bare('F')],
                rules: HashMap::from([(
                    'F',
                    (|_, next| next.extend("F[+F]F[-F][F]".chars().map(bare))) as Write,
                )]),
            }),
        },
        Subject {
            name: "2.6a, a tree of Honda",
            grammar: "r1 = 0.9\nr2 = 0.6\na0 = 45\na2 = 45\nd = 137.5\nwr = 0.707\naxiom A(1,10)\n\
                A(l,w) -> !(w)F(l)[&(a0)B(l*r2,w*wr)]/(d)A(l*r1,w*wr)\n\
                B(l,w) -> !(w)F(l)[-(a2)$C(l*r2,w*wr)]C(l*r1,w*wr)\n\
                C(l,w) -> !(w)F(l)[+(a2)$B(l*r2,w*wr)]B(l*r1,w*wr)",
            ignore: "",
            steps: 18,
            plain: Some(Plain {
                axiom: vec![with('A', [1.0, 10.0])],
                rules: HashMap::from([('A', trunk as Write), ('B', right as Write), ('C', left as Write)]),
            }),
        },
        Subject {
            name: "5.11a, a leaf with conditions",
            grammar: "axiom A(0)\nA(d) : d > 0 -> A(d-1)\nA(d) : d = 0 -> F(1)[+A(0)][-A(0)]F(1)A(0)\nF(a) -> F(a*2)",
            ignore: "",
            steps: 12,
            plain: Some(Plain {
                axiom: vec![with('A', [0.0])],
                rules: HashMap::from([
                    ('A', leaf as Write),
                    ('F', (|own, next| next.push(with('F', [own[0] * 2.0]))) as Write),
                ]),
            }),
        },
        Subject {
            name: "1.27, chance",
            grammar: "axiom F\nF -(1)> F[+F]F[-F]F\nF -(1)> F[+F]F\nF -(1)> F[-F]F",
            ignore: "",
            steps: 10,
            plain: None,
        },
        Subject {
            name: "1.31a, contexts",
            grammar: "axiom F1F1F1\n0 < 0 > 0 -> 0\n0 < 0 > 1 -> 1[+F1F1]\n0 < 1 > 0 -> 1\n0 < 1 > 1 -> 1\n1 < 0 > 0 -> 0\n\
                1 < 0 > 1 -> 1F1\n1 < 1 > 0 -> 0\n1 < 1 > 1 -> 0\n+ -> -\n- -> +",
            ignore: "+-F",
            steps: 52,
            plain: None,
        },
    ]
}

/// A word as a vector of modules, and functions that rewrite them.
struct Plain {
    axiom: Vec<Module>,
    rules: HashMap<char, Write>,
}

#[derive(Clone)]
struct Module {
    symbol: char,
    parameters: Vec<f64>,
}

type Write = fn(&[f64], &mut Vec<Module>);

impl Plain {
    fn derive(&self, steps: u32) -> (usize, usize) {
        let mut word = self.axiom.clone();
        let mut written = 0;
        for _ in 0..steps {
            let mut next = Vec::new();
            for module in &word {
                match self.rules.get(&module.symbol) {
                    Some(write) => write(&module.parameters, &mut next),
                    None => next.push(module.clone()),
                }
            }
            word = next;
            written += word.len();
        }
        (written, black_box(word).len())
    }
}

fn bare(symbol: char) -> Module {
    Module { symbol, parameters: Vec::new() }
}

fn with<const N: usize>(symbol: char, parameters: [f64; N]) -> Module {
    Module { symbol, parameters: parameters.to_vec() }
}

fn trunk(own: &[f64], next: &mut Vec<Module>) {
    let &[l, w] = own else { return };
    next.extend([
        with('!', [w]),
        with('F', [l]),
        bare('['),
        with('&', [45.0]),
        with('B', [l * 0.6, w * 0.707]),
    ]);
    next.extend([bare(']'), with('/', [137.5]), with('A', [l * 0.9, w * 0.707])]);
}

fn right(own: &[f64], next: &mut Vec<Module>) {
    fork(own, next, '-', 'C');
}

fn left(own: &[f64], next: &mut Vec<Module>) {
    fork(own, next, '+', 'B');
}

fn fork(own: &[f64], next: &mut Vec<Module>, turn: char, branch: char) {
    let &[l, w] = own else { return };
    next.extend([with('!', [w]), with('F', [l]), bare('['), with(turn, [45.0]), bare('$')]);
    next.extend([with(branch, [l * 0.6, w * 0.707]), bare(']'), with(branch, [l * 0.9, w * 0.707])]);
}

fn leaf(own: &[f64], next: &mut Vec<Module>) {
    if own[0] > 0.0 {
        next.push(with('A', [own[0] - 1.0]));
    } else {
        next.extend([
            with('F', [1.0]),
            bare('['),
            bare('+'),
            with('A', [0.0]),
            bare(']'),
            bare('['),
            bare('-'),
        ]);
        next.extend([with('A', [0.0]), bare(']'), with('F', [1.0]), with('A', [0.0])]);
    }
}
