//! L-systems of the folder in the language of grammars.

use super::files::{Family, Honda, LSystem};
use crate::plants::derive::{Limits, Steps, derive};
use crate::plants::grammar::Grammar;
use crate::plants::turtle::{Interpretation, Side, draw};
use crate::plants::watch::Watch;
use glam::DVec3;
use std::fmt::Write;

/// Symbols that draw, that move and leave no vertex, and the way that `+` turns. In the thesis only `.` leaves vertices.
pub const DRAW: &str = "F";
pub const SILENT: &str = "FfG";

/// An L-system as a species or an organ has it.
pub struct Growth {
    pub grammar: String,
    pub steps: u32,
    /// Diameter of segments at first.
    pub width: f64,
    /// Degrees, of turns without a parameter.
    pub angle: f64,
}

impl Growth {
    /// Vertical extent of what it draws.
    ///
    /// # Errors
    /// Why there is none.
    pub fn height(&self) -> Result<f64, String> {
        let limits = Limits { modules: 100_000, bytes: 32 << 20, work: 10_000_000, ..Limits::default() };
        let how = Interpretation {
            angle: self.angle.to_radians(),
            draw: DRAW.into(),
            moves: String::new(),
            silent: SILENT.into(),
            plus: Side::Right,
            ..Interpretation::default()
        };
        let grammar = Grammar::parse(&self.grammar, "").map_err(|error| error.to_string())?;
        let word =
            derive(&grammar, Steps::Fixed(self.steps), 0, &limits).map_err(|error| error.to_string())?;
        let drawing = draw(&word, &how, Watch::NONE).map_err(|error| error.to_string())?;
        let nodes = drawing.axes.iter().flat_map(|axis| axis.nodes.iter().map(|node| node.position));
        let vertices = drawing.polygons.iter().flat_map(|polygon| polygon.vertices.iter().copied());
        let heights = nodes.chain(vertices).map(|point: DVec3| point.y);
        let [least, greatest] = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
            [low.min(height), high.max(height)]
        });
        let height = greatest - least;
        if height > 1e-9 && height < 1e12 { Ok(height) } else { Err("what it draws has no height".into()) }
    }
}

/// A leaf that a tree bears: the symbol of its organ, and what its drawing is scaled by.
#[derive(Clone, Copy)]
pub struct Leaf {
    pub symbol: char,
    pub scale: f64,
}

/// Segments of so many last steps of a tree of Honda bear leaves.
const YOUNG: u32 = 3;

impl LSystem {
    /// Symbols of organs that don't occur in it as others.
    pub fn free_symbols(&self) -> impl Iterator<Item = char> {
        symbols().filter(|symbol| !self.uses(*symbol) && Some(*symbol) != self.stand_in())
    }

    /// `@` stands for one of the leaves. A tree that has no `@` bears them at the tips of all branches.
    pub fn growth(&self, leaves: &[Leaf]) -> Growth {
        let at_tips = !leaves.is_empty() && !self.uses('@');
        let spelled = |word: &str, turn: usize| {
            let word = if at_tips { word.replace(']', "@]") } else { word.into() };
            self.spelled(&word, leaves, turn)
        };
        let axiom = format!("{}{}", self.axiom, if at_tips { "@" } else { "" });
        let mut grammar = format!("axiom {}\n", self.spelled(&axiom, leaves, 0));
        for production in &self.productions {
            let symbol = self.renamed(production.symbol);
            let word = &production.word;
            // One rule a leaf, and chance chooses.
            let bears = leaves.len() > 1 && (word.contains('@') || at_tips && word.contains(']'));
            let (arrow, turns) = if bears { ("-(1)>", leaves.len()) } else { ("->", 1) };
            for turn in 0..turns {
                let _ = writeln!(grammar, "{symbol} {arrow} {}", spelled(word, turn));
            }
        }
        Growth { grammar, steps: self.n as u32, width: 2.0 * self.init_radius, angle: 0.0 }
    }

    /// A word in the language of grammars: each pair of turns has its own angle. The thesis rolls clockwise with `\`, the
    /// language counter-clockwise.
    fn spelled(&self, word: &str, leaves: &[Leaf], turn: usize) -> String {
        let mut spelled = String::new();
        let mut leaves = leaves.iter().cycle().skip(turn);
        for symbol in word.chars() {
            let _ = match symbol {
                '+' | '-' => write!(spelled, "{symbol}({})", self.turn_angle),
                '^' | '&' => write!(spelled, "{symbol}({})", self.pitch_angle),
                '\\' => write!(spelled, "/({})", self.roll_angle),
                '/' => write!(spelled, "\\({})", self.roll_angle),
                '@' => match leaves.next() {
                    Some(Leaf { symbol, scale }) => write!(spelled, "~{symbol}({scale})"),
                    None => Ok(()),
                },
                _ => write!(spelled, "{}", self.renamed(symbol)),
            };
        }
        spelled
    }

    /// `G` moves the turtle in the language, and is nothing but a letter in the thesis.
    fn renamed(&self, symbol: char) -> char {
        if symbol == 'G' { self.stand_in().unwrap_or(symbol) } else { symbol }
    }

    fn stand_in(&self) -> Option<char> {
        symbols().find(|symbol| self.uses('G') && !self.uses(*symbol))
    }

    fn uses(&self, symbol: char) -> bool {
        let holds = |word: &str| word.contains(symbol);
        let mut productions = self.productions.iter();
        self.axiom == symbol
            || productions.any(|production| production.symbol == symbol || holds(&production.word))
    }
}

/// Letters that the turtle does not know.
fn symbols() -> impl Iterator<Item = char> {
    ('a'..='z').chain('A'..='Z').filter(|symbol| !"FfG".contains(*symbol))
}

impl Honda {
    /// Symbols of organs.
    pub fn free_symbols() -> impl Iterator<Item = char> {
        symbols().filter(|symbol| !"ABC".contains(*symbol))
    }

    /// The tree of figure 2.3, and leaves at both sides of the youngest segments and above them. With leaves, the third
    /// parameter counts the steps that are left.
    pub fn growth(&self, leaves: &[Leaf]) -> Growth {
        let Honda { n, r1, r2, a0, a2, d, wr, init_radius, .. } = self;
        let width = 2.0 * init_radius;
        let mut grammar = format!("r1 = {r1}\nr2 = {r2}\na0 = {a0}\na2 = {a2}\nd = {d}\nwr = {wr}\n");
        if leaves.is_empty() {
            grammar += &format!(
                "axiom A(1,{width})\n\
                 A(l,w) -> !(w)F(l)[&(a0)B(l*r2,w*wr)]/(d)A(l*r1,w*wr)\n\
                 B(l,w) -> !(w)F(l)[-(a2)$C(l*r2,w*wr)]C(l*r1,w*wr)\n\
                 C(l,w) -> !(w)F(l)[+(a2)$B(l*r2,w*wr)]B(l*r1,w*wr)\n"
            );
        } else {
            grammar += &format!(
                "axiom A(1,{width},{n})\n\
                 A(l,w,k) -> !(w)F(l)[&(a0)B(l*r2,w*wr,k-1)]/(d)A(l*r1,w*wr,k-1)\n"
            );
            for (from, side, to) in [('B', '-', 'C'), ('C', '+', 'B')] {
                let rest = format!("[{side}(a2)${to}(l*r2,w*wr,k-1)]{to}(l*r1,w*wr,k-1)");
                let _ = writeln!(grammar, "{from}(l,w,k) : k > {YOUNG} -> !(w)F(l){rest}");
                for turn in 0..leaves.len() {
                    let mut leaf = leaves.iter().cycle().skip(turn);
                    let twig: String = ["+(55)", "-(55)", "^(40)"]
                        .iter()
                        .zip(&mut leaf)
                        .map(|(turn, leaf)| format!("[{turn}~{}({})]", leaf.symbol, leaf.scale))
                        .collect();
                    let _ = writeln!(grammar, "{from}(l,w,k) : k <= {YOUNG} -(1)> !(w)F(l){twig}{rest}");
                }
            }
        }
        Growth { grammar, steps: *n as u32, width, angle: 0.0 }
    }
}

impl Family {
    /// The leaf of figure 2.4.
    pub fn growth(&self) -> Growth {
        let Family { n, delta, la, ra, lb, rb, pd, .. } = self;
        let grammar = format!(
            "LA = {la}\nRA = {ra}\nLB = {lb}\nRB = {rb}\nPD = {pd}\n\
             axiom {{.A(0)}}\n\
             A(t) -> G(LA,RA)[-B(t).][A(t+1)][+B(t).]\n\
             B(t) : t > 0 -> G(LB,RB)B(t-PD)\n\
             G(s,r) -> G(s*r,r)\n"
        );
        Growth { grammar, steps: *n as u32, width: 0.01, angle: *delta }
    }
}
