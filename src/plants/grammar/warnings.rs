//! What a grammar may hold and hardly means.

use super::expression::{Constant, Parameter};
use super::{CUT, Context, Grammar, Letter, LetterId};
use crate::core::text::cut;
use std::collections::HashMap;
use std::ops::Range;

/// Something that is allowed and hardly meant: bytes of the text, what is odd there, what may be meant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{problem}: {expected}")]
pub struct Warning {
    pub kind: WarningKind,
    pub span: Range<usize>,
    pub problem: String,
    pub expected: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WarningKind {
    /// A rule for a module that stands nowhere.
    MissingSymbol,
    /// A rule for a module that stands only in words that are never written.
    Unreachable,
    /// A rule behind another one that always applies in its place, or whose context is skipped.
    NeverApplies,
    /// The name of a sub-model is rewritten.
    RewrittenModel,
    /// A module without rules, whose symbol has rules for another number of parameters.
    OtherParameters,
    UnusedConstant,
    /// A parameter with the name of a constant.
    HiddenConstant,
    /// A `{` that no word can close, or a `}` that closes none: the drawing fails as soon as it is written.
    OpenBrace,
    /// A `~` or `@` with nothing behind it that could name a sub-model.
    NoModel,
}

/// Where letters stand first in words.
#[derive(Default)]
pub struct Uses {
    modules: HashMap<LetterId, Range<usize>>,
    /// Behind `~` or `@`.
    models: HashMap<LetterId, Range<usize>>,
    /// Those that have nothing behind them, whatever becomes of the word.
    pub nameless: Vec<(LetterId, Range<usize>)>,
    /// One that ends the word that was read last.
    pub last: Option<(LetterId, Range<usize>)>,
    /// Of the axiom and the words of rules, in the order of the text.
    pub braces: Vec<Braces>,
}

/// The braces of a word.
#[derive(Default)]
pub struct Braces {
    /// Places of those that the word does not close.
    open: Vec<Range<usize>>,
    /// Places of those that it has not opened.
    closing: Vec<Range<usize>>,
}

impl Braces {
    pub fn add(&mut self, symbol: char, span: Range<usize>) {
        match symbol {
            '{' => self.open.push(span),
            '}' if self.open.pop().is_none() => self.closing.push(span),
            _ => {}
        }
    }
}

impl Uses {
    pub fn add(&mut self, letter: LetterId, span: Range<usize>, names_model: bool) {
        let uses = if names_model { &mut self.models } else { &mut self.modules };
        uses.entry(letter).or_insert(span);
    }
}

/// All warnings, in the order of the text.
pub fn all(
    grammar: &Grammar,
    constants: &HashMap<String, Constant>,
    hidden: &[Parameter],
    uses: &Uses,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut warn = |kind, span: &Range<usize>, problem: String, expected: &str| {
        warnings.push(Warning { kind, span: span.clone(), problem, expected: expected.into() });
    };

    let letter = |id: LetterId| grammar.alphabet[usize::from(id)];
    let rules_of =
        |id: LetterId| grammar.rules_of[usize::from(id)].iter().map(|&index| &grammar.rules[index]);
    let stands = |id: &LetterId| uses.modules.contains_key(id) || uses.models.contains_key(id);
    let letters = grammar.alphabet.iter().zip(0..);
    let standing: HashMap<char, u32> =
        letters.filter(|(_, id)| stands(id)).map(|(letter, _)| (letter.symbol, letter.arity)).collect();

    let reachable = reachable(grammar);
    let plain = |&&index: &&usize| grammar.rules[index].is_plain();
    let first_plain: Vec<Option<usize>> =
        grammar.rules_of.iter().map(|rules| rules.iter().find(plain).copied()).collect();
    for (index, rule) in grammar.rules.iter().enumerate() {
        let head = &rule.head;
        if !stands(&rule.letter) {
            let symbol = letter(rule.letter).symbol;
            let expected = match standing.get(&symbol) {
                Some(&arity) => &format!("`{symbol}` stands with {}", parameters(arity)),
                None => "it stands neither in the axiom nor in the word of a rule",
            };
            warn(WarningKind::MissingSymbol, &rule.span, format!("there is never a `{head}`"), expected);
        } else if !reachable[usize::from(rule.letter)] {
            let expected = "it stands only in words that are never written";
            warn(WarningKind::Unreachable, &rule.span, format!("there is never a `{head}`"), expected);
        }

        if first_plain[usize::from(rule.letter)].is_some_and(|plain| plain < index) {
            let expected = "a rule above it always applies";
            warn(
                WarningKind::NeverApplies,
                &rule.span,
                format!("this rule for `{head}` is never tried"),
                expected,
            );
        } else if skips(grammar, &rule.left, &rule.right) {
            let problem = format!("the context of `{head}` holds an ignored symbol");
            warn(
                WarningKind::NeverApplies,
                &rule.span,
                problem,
                "contexts skip it, and the rule never applies",
            );
        }
    }

    for (span, problem, expected) in braces(grammar, uses) {
        warn(WarningKind::OpenBrace, span, problem.into(), expected);
    }
    let rewritten = |id: &LetterId| rules_of(*id).next().is_some();
    for span in uses.nameless.iter().filter(|(id, _)| !rewritten(id)).map(|(_, span)| span) {
        warn(WarningKind::NoModel, span, "nothing behind this names a sub-model".into(), "as in `~L(1)`");
    }
    for (id, span) in uses.models.iter().filter(|(id, _)| rewritten(id)) {
        let problem = format!("the sub-model `{}` has a rule, which rewrites its name", letter(*id).symbol);
        warn(WarningKind::RewrittenModel, span, problem, "another name for one of them");
    }
    let ruled: HashMap<char, u32> =
        grammar.rules.iter().map(|rule| (letter(rule.letter).symbol, letter(rule.letter).arity)).collect();
    for (&id, span) in uses.modules.iter().filter(|(id, _)| !rewritten(id)) {
        let Letter { symbol, arity } = letter(id);
        if let Some(&other) = ruled.get(&symbol) {
            let problem = format!("no rule is for `{symbol}` with {}", parameters(arity));
            let expected = format!("there are rules for {}", parameters(other));
            warn(WarningKind::OtherParameters, span, problem, &expected);
        }
    }
    for (name, constant) in constants.iter().filter(|(_, constant)| !constant.used) {
        let problem = format!("`{}` is not used", cut(name));
        warn(WarningKind::UnusedConstant, &constant.span, problem, "a use, or no constant");
    }
    for Parameter { name, span } in hidden {
        let problem = format!("the parameter `{}` hides a constant", cut(name));
        warn(WarningKind::HiddenConstant, span, problem, "another name");
    }
    warnings.sort_by_key(|warning| (warning.span.start, warning.span.end));
    // Nobody reads on after so many of a kind.
    let mut counts = HashMap::new();
    warnings.retain(|warning| {
        let count = counts.entry(warning.kind).or_insert(0);
        *count += 1;
        *count <= MOST
    });
    warnings
}

/// Warnings of one kind.
const MOST: usize = 20;

/// Of each letter: whether rules lead to it from the axiom, if they apply.
fn reachable(grammar: &Grammar) -> Vec<bool> {
    let mut reachable = vec![false; grammar.alphabet.len()];
    let mut found = grammar.axiom.letters.clone();
    while let Some(letter) = found.pop() {
        let letter = usize::from(letter);
        if !std::mem::replace(&mut reachable[letter], true) {
            let rules = grammar.rules_of[letter].iter().map(|&index| &grammar.rules[index]);
            found.extend(rules.flat_map(|rule| &rule.successor.letters));
        }
    }
    reachable
}

/// Braces that can't find their partners. What a word leaves open another one may close; but where none closes more than it
/// opens, what is open stays so, and the other way round. Rules for braces, and `%`, may take some away.
fn braces<'a>(grammar: &Grammar, uses: &'a Uses) -> Vec<(&'a Range<usize>, &'static str, &'static str)> {
    let is_brace = |&id: &usize| matches!(grammar.alphabet[id].symbol, '{' | '}');
    let rewritten = (0..grammar.alphabet.len()).filter(is_brace).any(|id| !grammar.rules_of[id].is_empty());
    if rewritten || uses.modules.contains_key(&CUT) {
        return Vec::new();
    }
    let (mut least, mut most) = (0, 0);
    for Braces { open, closing } in &uses.braces {
        let balance = open.len() as i64 - closing.len() as i64;
        (least, most) = (least.min(balance), most.max(balance));
    }
    let first =
        |list: fn(&Braces) -> &Vec<Range<usize>>| uses.braces.iter().find_map(move |word| list(word).first());
    let never_closed = first(|word| &word.open).filter(|_| least == 0 && most > 0);
    let never_opened = first(|word| &word.closing).filter(|_| most == 0 && least < 0);
    let open = never_closed.map(|span| (span, "this `{` is never closed", "`}` behind it"));
    open.into_iter().chain(never_opened.map(|span| (span, "this `}` has no `{`", "`{` before it"))).collect()
}

fn skips(grammar: &Grammar, left: &[LetterId], right: &[Context]) -> bool {
    left.iter().any(|letter| grammar.ignored[usize::from(*letter)])
        || right.iter().any(|context| match context {
            Context::Module(letter) => grammar.ignored[usize::from(*letter)],
            Context::Branch(inner) => skips(grammar, &[], inner),
        })
}

fn parameters(arity: u32) -> String {
    match arity {
        0 => "no parameter".into(),
        1 => "1 parameter".into(),
        _ => format!("{arity} parameters"),
    }
}
