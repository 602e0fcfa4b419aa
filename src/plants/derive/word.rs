//! Words: strings of modules.

use crate::plants::grammar::{Letter, LetterId};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter, Write};
use std::sync::Arc;

/// A word: symbols with their parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Word {
    pub(super) alphabet: Arc<[Letter]>,
    pub(super) letters: Vec<LetterId>,
    /// Of all modules, one after the other.
    pub(super) parameters: Vec<f64>,
}

/// One letter of a word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Module<'a> {
    pub symbol: char,
    pub parameters: &'a [f64],
}

impl Word {
    pub fn len(&self) -> usize {
        self.letters.len()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn modules(&self) -> impl Iterator<Item = Module<'_>> {
        let mut rest = self.parameters.as_slice();
        self.letters.iter().map(move |&letter| {
            let Letter { symbol, arity } = self.alphabet[usize::from(letter)];
            let parameters = rest.split_off(..arity as usize).unwrap_or_default();
            Module { symbol, parameters }
        })
    }

    /// How often each symbol stands in the word.
    pub fn counts(&self) -> BTreeMap<char, u64> {
        let mut of_letters = vec![0_u64; self.alphabet.len()];
        self.letters.iter().for_each(|&letter| of_letters[usize::from(letter)] += 1);
        let mut counts = BTreeMap::new();
        for (letter, count) in self.alphabet.iter().zip(of_letters).filter(|(_, count)| *count > 0) {
            *counts.entry(letter.symbol).or_default() += count;
        }
        counts
    }

    /// The symbols, without parameters.
    pub fn symbols(&self) -> String {
        self.letters.iter().map(|&letter| self.alphabet[usize::from(letter)].symbol).collect()
    }

    /// SHA-256 of [`Word::symbols`], in UTF-8.
    pub fn sha256(&self) -> [u8; 32] {
        let mut digest = Sha256::new();
        let mut bytes = String::new();
        for letters in self.letters.chunks(4096) {
            bytes.clear();
            bytes.extend(letters.iter().map(|&letter| self.alphabet[usize::from(letter)].symbol));
            digest.update(&bytes);
        }
        digest.finalize().into()
    }

    /// Memory of it, bytes.
    pub fn bytes(&self) -> u64 {
        bytes(self.letters.len() as u64, self.parameters.len() as u64)
    }
}

/// Memory of a word.
pub(super) fn bytes(letters: u64, parameters: u64) -> u64 {
    letters
        .saturating_mul(size_of::<LetterId>() as u64)
        .saturating_add(parameters.saturating_mul(size_of::<f64>() as u64))
}

/// As grammars are written: `A(1,0.5)[+B]`.
impl Display for Word {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        for Module { symbol, parameters } in self.modules() {
            out.write_char(symbol)?;
            for (index, parameter) in parameters.iter().enumerate() {
                write!(out, "{}{parameter}", if index == 0 { '(' } else { ',' })?;
            }
            if !parameters.is_empty() {
                out.write_char(')')?;
            }
        }
        Ok(())
    }
}
