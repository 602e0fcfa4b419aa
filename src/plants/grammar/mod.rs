//! The language of L-systems (Prusinkiewicz & Lindenmayer 1990, "The Algorithmic Beauty of Plants"): deterministic,
//! stochastic, context-sensitive, parametric.

mod expression;
mod read;
mod text;
mod warnings;

pub(super) use expression::{Chance, Code, Undefined, sin_cos};
pub use warnings::{Warning, WarningKind};

use std::ops::Range;
use std::sync::Arc;

/// Bytes of a text that is read.
pub const MOST_BYTES: usize = 1 << 20;

/// Rules of growth, as they were read.
#[derive(Clone, Debug)]
pub struct Grammar {
    pub(super) alphabet: Arc<[Letter]>,
    pub(super) axiom: Successor,
    pub(super) rules: Vec<Rule>,
    /// Of each letter: its rules, in the order of the text.
    pub(super) rules_of: Vec<Vec<usize>>,
    /// Of each letter: whether contexts skip it.
    pub(super) ignored: Vec<bool>,
    warnings: Vec<Warning>,
}

/// Where a text is no grammar: bytes of the text, what is wrong there, what may stand there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{problem}: {expected}")]
pub struct Error {
    pub span: Range<usize>,
    pub problem: String,
    pub expected: String,
}

/// What a module is besides the values of its parameters: `A` and `A(x)` are different letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Letter {
    pub symbol: char,
    pub arity: u32,
}

/// Index of a [`Letter`] in the alphabet.
pub(super) type LetterId = u16;

/// These are in every alphabet, in this order.
pub(super) const OPEN: LetterId = 0;
pub(super) const CLOSE: LetterId = 1;
pub(super) const CUT: LetterId = 2;

/// A word with expressions in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Successor {
    pub letters: Vec<LetterId>,
    /// Of all letters, one after the other.
    pub arguments: Vec<Code>,
    pub span: Range<usize>,
    /// Operations that writing it takes about.
    pub cost: u64,
}

#[derive(Clone, Debug)]
pub(super) struct Rule {
    pub span: Range<usize>,
    /// What it rewrites, as it is written.
    pub head: String,
    pub letter: LetterId,
    /// From far to near.
    pub left: Vec<LetterId>,
    pub right: Vec<Context>,
    /// Parameters of the left context, which come before those of the module; then come those of the right one.
    pub left_parameters: usize,
    pub condition: Option<Code>,
    pub weight: Option<Code>,
    pub successor: Successor,
}

/// A part of a right context.
#[derive(Clone, Debug)]
pub(super) enum Context {
    Module(LetterId),
    /// The beginning of a branch.
    Branch(Vec<Context>),
}

impl Grammar {
    /// Reads a grammar. Symbols in `ignore` are no context.
    ///
    /// # Errors
    /// The first mistake.
    pub fn parse(text: &str, ignore: &str) -> Result<Grammar, Error> {
        Self::read(text, ignore).map_err(|mut errors| errors.swap_remove(0))
    }

    /// As [`Grammar::parse`].
    ///
    /// # Errors
    /// The first mistake of every line, one at least, and no more than people read.
    pub fn read(text: &str, ignore: &str) -> Result<Grammar, Vec<Error>> {
        if text.len() > MOST_BYTES {
            let problem = format!("{} bytes are too many for a grammar", text.len());
            return Err(vec![Error::new(0..0, problem, format!("at most {MOST_BYTES}"))]);
        }
        read::grammar(text, ignore)
    }

    /// What is allowed and hardly meant, in the order of the text.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}

impl Rule {
    pub fn has_context(&self) -> bool {
        !self.left.is_empty() || !self.right.is_empty()
    }

    /// Whether it applies wherever its letter stands, and always in the same way.
    pub fn is_plain(&self) -> bool {
        !self.has_context() && self.condition.is_none() && self.weight.is_none()
    }

    /// Whether chance has a part in what it writes, or in whether it does.
    pub fn is_random(&self) -> bool {
        self.weight.is_some() || self.successor.arguments.iter().any(Code::is_random)
    }
}

impl Error {
    fn new(span: Range<usize>, problem: impl Into<String>, expected: impl Into<String>) -> Error {
        Error { span, problem: problem.into(), expected: expected.into() }
    }
}
