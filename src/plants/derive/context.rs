//! What stands beside a module: in a word with branches, its neighbours are those along the plant.

use super::word::Word;
use crate::plants::grammar::{CLOSE, Context, Grammar, LetterId, OPEN, Rule};

const NONE: u32 = u32::MAX;

/// Memory of the neighbours of each module, and of what finds them, bytes at most.
pub const BYTES_PER_MODULE: u64 = 20;

/// Neighbours of all modules of a word. Brackets and ignored symbols are nobody's neighbours.
#[derive(Debug, Default)]
pub struct Neighbours {
    /// Of a module: the next one towards the root; a branch is left through its `[`. Of `[`: its `]`.
    left: Vec<u32>,
    /// Of a module: the next one on the same branch. Of `[`: the first one in it.
    right: Vec<u32>,
    /// Where its parameters begin.
    parameters: Vec<u32>,
}

impl Neighbours {
    /// Finds them anew.
    pub fn find(&mut self, word: &Word, grammar: &Grammar) {
        let modules = word.letters.len();
        self.parameters.clear();
        self.left.clear();
        self.right.clear();
        self.right.resize(modules, NONE);

        let (mut left, mut first_parameter) = (NONE, 0);
        let mut branches = Vec::new();
        for (at, &letter) in word.letters.iter().enumerate() {
            self.left.push(left);
            self.parameters.push(first_parameter);
            first_parameter += grammar.alphabet[usize::from(letter)].arity;
            match letter {
                OPEN => branches.push(left),
                CLOSE => left = branches.pop().unwrap_or(NONE),
                _ if grammar.ignored[usize::from(letter)] => {}
                _ => left = at as u32,
            }
        }

        let mut right = NONE;
        let mut branches = Vec::new();
        for (at, &letter) in word.letters.iter().enumerate().rev() {
            self.right[at] = right;
            match letter {
                CLOSE => {
                    branches.push((right, at as u32));
                    right = NONE;
                }
                OPEN => (right, self.left[at]) = branches.pop().unwrap_or((NONE, NONE)),
                _ if grammar.ignored[usize::from(letter)] => {}
                _ => right = at as u32,
            }
        }
    }

    /// Whether the contexts of a rule are beside a module. The parameters of contexts and module go to `scope`, in the
    /// order of the rule's text. Places that were looked at are counted.
    pub fn fit(
        &self,
        word: &Word,
        grammar: &Grammar,
        rule: &Rule,
        at: usize,
        scope: &mut Vec<f64>,
        looks: &mut u64,
    ) -> bool {
        scope.clear();
        scope.resize(rule.left_parameters, 0.0);
        let mut end = rule.left_parameters;
        let mut near = at;
        for &wanted in rule.left.iter().rev() {
            *looks += 1;
            let Some(next) = place(self.left[near]).filter(|&next| word.letters[next] == wanted) else {
                return false;
            };
            near = next;
            let values = self.values(word, grammar, near);
            scope[end - values.len()..end].copy_from_slice(values);
            end -= values.len();
        }
        scope.extend_from_slice(self.values(word, grammar, at));
        let mut search = Search { neighbours: self, word, grammar, scope, looks };
        search.follows(&rule.right, at)
    }

    fn values<'a>(&self, word: &'a Word, grammar: &Grammar, at: usize) -> &'a [f64] {
        let first = self.parameters[at] as usize;
        let arity = grammar.alphabet[usize::from(word.letters[at])].arity as usize;
        &word.parameters[first..first + arity]
    }
}

struct Search<'a> {
    neighbours: &'a Neighbours,
    word: &'a Word,
    grammar: &'a Grammar,
    scope: &'a mut Vec<f64>,
    looks: &'a mut u64,
}

impl Search<'_> {
    /// Whether this context comes behind the module or `[` at a place.
    fn follows(&mut self, contexts: &[Context], mut at: usize) -> bool {
        // Where the next branch may begin.
        let mut branch = at + 1;
        for context in contexts {
            *self.looks += 1;
            match context {
                Context::Module(wanted) => {
                    let next = place(self.neighbours.right[at]);
                    let Some(next) = next.filter(|&next| self.word.letters[next] == *wanted) else {
                        return false;
                    };
                    at = next;
                    branch = at + 1;
                    self.scope.extend_from_slice(self.neighbours.values(self.word, self.grammar, at));
                }
                Context::Branch(inner) => match self.branch(inner, branch) {
                    Some(behind) => branch = behind,
                    None => return false,
                },
            }
        }
        true
    }

    /// The first of the branches here that begins so; where it ends.
    fn branch(&mut self, inner: &[Context], mut at: usize) -> Option<usize> {
        loop {
            *self.looks += 1;
            let letter: LetterId = *self.word.letters.get(at)?;
            if letter == OPEN {
                let held = self.scope.len();
                let close = place(self.neighbours.left[at])?;
                if self.follows(inner, at) {
                    return Some(close + 1);
                }
                self.scope.truncate(held);
                at = close + 1;
            } else if letter != CLOSE && self.grammar.ignored[usize::from(letter)] {
                at += 1;
            } else {
                return None;
            }
        }
    }
}

fn place(index: u32) -> Option<usize> {
    (index != NONE).then_some(index as usize)
}
