//! What a grammar may hold and hardly means.

use super::expression::{Constant, Parameter};
use super::{Context, Grammar, Letter, LetterId};
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
}

/// Where letters stand first in words.
#[derive(Default)]
pub struct Uses {
    modules: HashMap<LetterId, Range<usize>>,
    /// Behind `~` or `@`.
    models: HashMap<LetterId, Range<usize>>,
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

    let rewritten = |id: &LetterId| rules_of(*id).next().is_some();
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
        let problem = format!("`{name}` is not used");
        warn(WarningKind::UnusedConstant, &constant.span, problem, "a use, or no constant");
    }
    for Parameter { name, span } in hidden {
        let problem = format!("the parameter `{name}` hides a constant");
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
