//! Derivation: all modules of a word are rewritten at once, step by step, within limits.
//!
//! A step chooses a rule for every module and so counts the next word, before any memory is taken for it; then it
//! writes that word. Chance is a hash of the seed, the step and the module's place in the word.

mod context;
mod stepper;
mod word;

pub use stepper::{Change, Derivation};
pub use word::{Module, Word};

use super::grammar::{Grammar, Undefined};
use super::watch::{Stopped, Watch};
use crate::core::text::brief;
use std::ops::Range;

/// How often a word is rewritten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Steps {
    Fixed(u32),
    /// Until nothing changes.
    #[default]
    UntilDone,
}

/// What a derivation may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits<'a> {
    /// Modules of a word.
    pub modules: u64,
    /// Memory of all words at a time, bytes.
    pub bytes: u64,
    /// Steps of [`Steps::UntilDone`].
    pub steps: u32,
    /// Modules read and written, rules tried and operations of expressions, in all steps together: a few nanoseconds
    /// each.
    pub work: u64,
    /// Who looks in, and may end it.
    pub watch: Watch<'a>,
}

impl Default for Limits<'_> {
    fn default() -> Self {
        let watch = Watch::NONE;
        Limits { modules: 10_000_000, bytes: 192 << 20, steps: 100_000, work: 1_000_000_000, watch }
    }
}

/// Why there is no word.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("step {step}, {rule}: {problem}")]
pub struct Error {
    pub problem: Problem,
    /// The first word after the axiom is made by step 1.
    pub step: u32,
    /// "the axiom", or "the rule for" what it rewrites.
    pub rule: String,
    /// Bytes of the grammar's text: the rule, or the part of it that is to blame.
    pub span: Range<usize>,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    #[error("the word would have {count} modules, and {limit} are allowed")]
    Modules { count: u64, limit: u64 },
    #[error("the words would take {bytes} bytes, and {limit} are allowed")]
    Bytes { bytes: u64, limit: u64 },
    #[error("there is no memory for {bytes} bytes")]
    Memory { bytes: u64 },
    #[error("the derivation takes more than {limit} operations")]
    Work { limit: u64 },
    #[error("the word still changes after {steps} steps")]
    Endless { steps: u32 },
    #[error("the word is empty")]
    Empty,
    #[error(transparent)]
    Undefined(Undefined),
    #[error("the weight is {}, and a weight can't be negative", brief(*.0))]
    NegativeWeight(f64),
    #[error("no rule that could apply has a weight above 0")]
    NoWeight,
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Rewrites the axiom. The same seed gives the same word on every machine.
///
/// # Errors
/// When a limit would be passed, before it is; when a number is none; when nothing is left of the word.
pub fn derive(grammar: &Grammar, steps: Steps, seed: u32, limits: &Limits) -> Result<Word, Error> {
    derive_seen(grammar, steps, seed, limits, |_| ())
}

/// As [`derive()`], and shows `see` the axiom and the word after each step that may have changed it.
pub fn derive_seen(
    grammar: &Grammar,
    steps: Steps,
    seed: u32,
    limits: &Limits,
    mut see: impl FnMut(&Word),
) -> Result<Word, Error> {
    let mut derivation = Derivation::new(grammar, seed, limits)?;
    see(derivation.word());
    let most = match steps {
        Steps::Fixed(steps) => steps,
        Steps::UntilDone => limits.steps,
    };
    for _ in 0..most {
        if derivation.step()? == Change::Done {
            return Ok(derivation.into_word());
        }
        see(derivation.word());
    }
    match steps {
        Steps::Fixed(_) => Ok(derivation.into_word()),
        Steps::UntilDone => Err(derivation.endless()),
    }
}
