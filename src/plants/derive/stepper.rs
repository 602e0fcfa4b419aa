//! A derivation, step by step.

use super::context::{self, Neighbours};
use super::word::{self, Word};
use super::{Error, Limits, Problem};
use crate::plants::grammar::{CLOSE, CUT, Chance, Grammar, LetterId, OPEN, Rule, Undefined};
use crate::plants::watch::{Pace, Stopped};
use bytemuck::cast_slice;
use std::ops::Range;

/// A derivation, step by step.
#[derive(Debug)]
pub struct Derivation<'a> {
    grammar: &'a Grammar,
    seed: u32,
    limits: Limits<'a>,
    pace: Pace<'a>,
    word: Word,
    step: u32,
    work: u64,
    /// Of each letter: what becomes of its modules.
    fates: Vec<Fate>,
    has_contexts: bool,
    has_choices: bool,
    neighbours: Neighbours,
    /// Of the modules that have a choice, in their order: the rule, or [`STAYS`].
    choices: Vec<u32>,
    /// Of each rule: how often it applies in the step.
    applied: Vec<u64>,
    /// Parameters of the contexts and the module that a rule is about to rewrite.
    scope: Vec<f64>,
    candidates: Vec<(usize, f64)>,
}

/// What a step did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    Changed,
    /// Nothing, and no later step will.
    Done,
}

/// What becomes of all modules of a letter.
#[derive(Clone, Copy, Debug)]
enum Fate {
    Stays,
    /// This rule applies always.
    Rewritten(usize),
    /// It depends.
    Chosen,
    /// The rest of the branch goes, and the module too.
    Cuts,
}

const STAYS: u32 = u32::MAX;
/// The place in the grammar of the number that chooses a rule.
const CHOICE: u32 = u32::MAX;

/// The next word, before it is written.
struct Plan {
    modules: u64,
    parameters: u64,
    /// Whether chance had a part in it.
    random: bool,
}

impl<'a> Derivation<'a> {
    /// Begins with the axiom.
    ///
    /// # Errors
    /// As [`super::derive`].
    pub fn new(grammar: &'a Grammar, seed: u32, limits: &Limits<'a>) -> Result<Derivation<'a>, Error> {
        let fates = grammar.rules_of.iter().enumerate().map(|(letter, rules)| match rules.first() {
            _ if letter == usize::from(CUT) => Fate::Cuts,
            None => Fate::Stays,
            Some(&first) if grammar.rules[first].is_plain() => Fate::Rewritten(first),
            Some(_) => Fate::Chosen,
        });
        let fates: Vec<Fate> = fates.collect();
        let axiom = &grammar.axiom;
        let mut derivation = Derivation {
            grammar,
            seed,
            limits: *limits,
            pace: limits.watch.pace(),
            word: Word { alphabet: grammar.alphabet.clone(), ..Word::default() },
            step: 0,
            work: axiom.cost,
            has_contexts: grammar.rules.iter().any(Rule::has_context),
            has_choices: fates.iter().any(|fate| matches!(fate, Fate::Chosen)),
            fates,
            neighbours: Neighbours::default(),
            choices: Vec::new(),
            applied: vec![0; grammar.rules.len()],
            scope: Vec::new(),
            candidates: Vec::new(),
        };
        let (modules, parameters) = (axiom.letters.len() as u64, axiom.arguments.len() as u64);
        let mut word = derivation.take(&Plan { modules, parameters, random: false })?;
        word.letters.extend_from_slice(&axiom.letters);
        let chance = Chance::new(seed, 0);
        for code in &axiom.arguments {
            let value = code.value(&[], chance).map_err(|undefined| derivation.undefined(undefined, None))?;
            word.parameters.push(value);
        }
        if word.is_empty() {
            return Err(derivation.error(Problem::Empty, None));
        }
        derivation.word = word;
        Ok(derivation)
    }

    pub fn word(&self) -> &Word {
        &self.word
    }

    pub fn into_word(self) -> Word {
        self.word
    }

    /// Steps that were made.
    pub fn steps(&self) -> u32 {
        self.step
    }

    /// Rewrites all modules once.
    ///
    /// # Errors
    /// As [`super::derive`].
    pub fn step(&mut self) -> Result<Change, Error> {
        self.step = self.step.saturating_add(1);
        let plan = self.plan()?;
        let next = self.write(&plan)?;
        // 0 and −0 are equal, but not the same.
        let [before, after] = [&self.word, &next].map(|word| cast_slice::<f64, u64>(&word.parameters));
        let changed = next.letters != self.word.letters || after != before;
        self.word = next;
        Ok(if changed || plan.random { Change::Changed } else { Change::Done })
    }

    pub(super) fn endless(&self) -> Error {
        self.error(Problem::Endless { steps: self.step }, self.busiest())
    }

    /// Chooses a rule for every module, and so counts the next word.
    fn plan(&mut self) -> Result<Plan, Error> {
        let modules = self.word.letters.len();
        // What the last step did is to blame for this one's length.
        let least = modules as u64 + self.applied.len() as u64 + 16;
        self.spend(least, self.busiest())?;
        self.pace.count(least).map_err(|stopped| self.stopped(stopped))?;
        self.applied.fill(0);
        self.choices.clear();
        if self.has_choices {
            let scratch = self.scratch();
            self.afford(scratch)?;
            let refused = Problem::Memory { bytes: scratch };
            self.choices.try_reserve_exact(modules).map_err(|_| self.error(refused, None))?;
        }
        if self.has_contexts {
            self.neighbours.find(&self.word, self.grammar);
        }

        let chance = Chance::new(self.seed, self.step);
        let mut plan = Plan { modules: 0, parameters: 0, random: false };
        let (mut at, mut parameter) = (0, 0);
        while let Some(&letter) = self.word.letters.get(at) {
            let arity = self.grammar.alphabet[usize::from(letter)].arity as usize;
            match self.fates[usize::from(letter)] {
                Fate::Rewritten(rule) => self.applied[rule] += 1,
                Fate::Chosen => {
                    match self.choose(letter, at, parameter..parameter + arity, chance, &mut plan)? {
                        Some(rule) => {
                            self.applied[rule] += 1;
                            self.choices.push(rule as u32);
                        }
                        None => {
                            plan.modules += 1;
                            plan.parameters += arity as u64;
                            self.choices.push(STAYS);
                        }
                    }
                }
                Fate::Stays => {
                    plan.modules += 1;
                    plan.parameters += arity as u64;
                }
                Fate::Cuts => {
                    (at, parameter) = self.behind_cut(at, parameter);
                    continue;
                }
            }
            at += 1;
            parameter += arity;
        }

        let mut work = plan.modules;
        for (rule, &applied) in
            self.grammar.rules.iter().zip(&self.applied).filter(|(_, applied)| **applied > 0)
        {
            plan.modules += applied * rule.successor.letters.len() as u64;
            plan.parameters += applied * rule.successor.arguments.len() as u64;
            plan.random |= rule.is_random();
            work = work.saturating_add(applied.saturating_mul(rule.successor.cost));
        }
        self.spend(work, self.busiest())?;
        Ok(plan)
    }

    /// The rule for a module, whose parameters are in this range.
    fn choose(
        &mut self,
        letter: LetterId,
        at: usize,
        own: Range<usize>,
        chance: Chance,
        plan: &mut Plan,
    ) -> Result<Option<usize>, Error> {
        let grammar = self.grammar;
        let rules = &grammar.rules_of[usize::from(letter)];
        let chance = chance.at(at);
        for (place, &index) in rules.iter().enumerate() {
            if !self.applies(index, at, own.clone(), chance, plan)? {
                continue;
            }
            if grammar.rules[index].weight.is_none() {
                return Ok(Some(index));
            }
            return self.draw(&rules[place..], at, own, chance, plan).map(Some);
        }
        Ok(None)
    }

    /// One of the weighted rules that apply. The first of these is known to.
    fn draw(
        &mut self,
        rules: &[usize],
        at: usize,
        own: Range<usize>,
        chance: Chance,
        plan: &mut Plan,
    ) -> Result<usize, Error> {
        let grammar = self.grammar;
        let mut sum = 0.0;
        self.candidates.clear();
        for (place, &index) in rules.iter().enumerate() {
            let rule = &grammar.rules[index];
            let Some(weight) = &rule.weight else { continue };
            if (place > 0 || rule.has_context()) && !self.applies(index, at, own.clone(), chance, plan)? {
                continue;
            }
            self.spend(weight.cost, Some(index))?;
            let scope = if rule.has_context() { &self.scope } else { &self.word.parameters[own.clone()] };
            let value =
                weight.value(scope, chance).map_err(|undefined| self.undefined(undefined, Some(index)))?;
            if value < 0.0 {
                let error = self.error(Problem::NegativeWeight(value), Some(index));
                return Err(Error { span: weight.span.clone(), ..error });
            }
            sum += value;
            self.candidates.push((index, value));
        }
        if !sum.is_finite() {
            return Err(self.error(Problem::Undefined(Undefined::TooLarge), Some(rules[0])));
        }
        let mut rest = sum * chance.unit(CHOICE);
        let mut chosen = None;
        for &(index, weight) in self.candidates.iter().filter(|(_, weight)| *weight > 0.0) {
            chosen = Some(index);
            if rest < weight {
                break;
            }
            rest -= weight;
        }
        chosen.ok_or_else(|| self.error(Problem::NoWeight, Some(rules[0])))
    }

    /// Whether contexts and condition of a rule hold. Those of a rule with contexts leave its parameters in
    /// [`Derivation::scope`].
    fn applies(
        &mut self,
        index: usize,
        at: usize,
        own: Range<usize>,
        chance: Chance,
        plan: &mut Plan,
    ) -> Result<bool, Error> {
        let rule = &self.grammar.rules[index];
        let cost = 1 + rule.condition.as_ref().map_or(0, |condition| condition.cost);
        self.spend(cost, Some(index))?;
        self.pace.count(cost).map_err(|stopped| self.stopped(stopped))?;
        if rule.has_context() && !self.fits(index, at)? {
            return Ok(false);
        }
        let Some(condition) = &rule.condition else { return Ok(true) };
        plan.random |= condition.is_random();
        let scope = if rule.has_context() { &self.scope } else { &self.word.parameters[own] };
        match condition.value(scope, chance) {
            Ok(value) => Ok(value != 0.0),
            Err(undefined) => Err(self.undefined(undefined, Some(index))),
        }
    }

    fn fits(&mut self, index: usize, at: usize) -> Result<bool, Error> {
        let rule = &self.grammar.rules[index];
        let mut looks = 0;
        let fits = self.neighbours.fit(&self.word, self.grammar, rule, at, &mut self.scope, &mut looks);
        self.spend(looks, Some(index))?;
        self.pace.count(looks).map_err(|stopped| self.stopped(stopped))?;
        Ok(fits)
    }

    /// Writes the next word.
    fn write(&mut self, plan: &Plan) -> Result<Word, Error> {
        let mut next = self.take(plan)?;
        let grammar = self.grammar;
        let chance = Chance::new(self.seed, self.step);
        let choices = std::mem::take(&mut self.choices);
        let mut choice = choices.iter();
        let (mut at, mut parameter) = (0, 0);
        while let Some(&letter) = self.word.letters.get(at) {
            let arity = grammar.alphabet[usize::from(letter)].arity as usize;
            let own = parameter..parameter + arity;
            let rule = match self.fates[usize::from(letter)] {
                Fate::Stays => STAYS as usize,
                Fate::Rewritten(rule) => rule,
                Fate::Chosen => choice.next().map_or(STAYS, |&rule| rule) as usize,
                Fate::Cuts => {
                    (at, parameter) = self.behind_cut(at, parameter);
                    continue;
                }
            };
            match grammar.rules.get(rule) {
                None => {
                    next.letters.push(letter);
                    next.parameters.extend_from_slice(&self.word.parameters[own]);
                }
                Some(Rule { successor, .. }) if successor.arguments.is_empty() => {
                    next.letters.extend_from_slice(&successor.letters);
                }
                Some(applied) => {
                    next.letters.extend_from_slice(&applied.successor.letters);
                    self.pace.count(applied.successor.cost).map_err(|stopped| self.stopped(stopped))?;
                    if applied.has_context() {
                        self.fits(rule, at)?;
                    }
                    let scope = if applied.has_context() { &self.scope } else { &self.word.parameters[own] };
                    let chance = chance.at(at);
                    for code in &applied.successor.arguments {
                        match code.value(scope, chance) {
                            Ok(value) => next.parameters.push(value),
                            Err(undefined) => return Err(self.undefined(undefined, Some(rule))),
                        }
                    }
                }
            }
            at += 1;
            parameter += arity;
        }
        self.choices = choices;
        if next.is_empty() {
            return Err(self.error(Problem::Empty, self.busiest()));
        }
        Ok(next)
    }

    /// The place behind a branch that is cut off here, and that of its parameters: the `]` that closes it, or the end.
    fn behind_cut(&self, mut at: usize, mut parameter: usize) -> (usize, usize) {
        let mut depth = 0_usize;
        while let Some(&letter) = self.word.letters.get(at) {
            match letter {
                OPEN => depth += 1,
                CLOSE if depth == 0 => break,
                CLOSE => depth -= 1,
                _ => parameter += self.grammar.alphabet[usize::from(letter)].arity as usize,
            }
            at += 1;
        }
        (at, parameter)
    }

    /// Memory for the next word, if it is within the limits.
    fn take(&self, plan: &Plan) -> Result<Word, Error> {
        let &Plan { modules, parameters, .. } = plan;
        // Places in a word are 32-bit numbers.
        let limit = self.limits.modules.min(u64::from(u32::MAX - 1));
        if modules > limit {
            return Err(self.error(Problem::Modules { count: modules, limit }, self.busiest()));
        }
        let bytes = word::bytes(modules, parameters);
        self.afford(bytes.saturating_add(self.scratch()))?;
        let mut word = Word { alphabet: self.grammar.alphabet.clone(), ..Word::default() };
        let letters = word.letters.try_reserve_exact(modules as usize);
        let parameters = word.parameters.try_reserve_exact(parameters as usize);
        let refused = Problem::Memory { bytes };
        letters.and(parameters).map_err(|_| self.error(refused, self.busiest()))?;
        Ok(word)
    }

    /// Whether the limit leaves these bytes beside the word.
    fn afford(&self, bytes: u64) -> Result<(), Error> {
        let bytes = self.word.bytes().saturating_add(bytes);
        let limit = self.limits.bytes;
        if bytes <= limit { Ok(()) } else { Err(self.error(Problem::Bytes { bytes, limit }, self.busiest())) }
    }

    /// Bytes that choosing takes.
    fn scratch(&self) -> u64 {
        let choice = if self.has_choices { size_of::<u32>() as u64 } else { 0 };
        let context = if self.has_contexts { context::BYTES_PER_MODULE } else { 0 };
        self.word.letters.len() as u64 * (choice + context)
    }

    fn spend(&mut self, work: u64, rule: Option<usize>) -> Result<(), Error> {
        self.work = self.work.saturating_add(work);
        let limit = self.limits.work;
        if self.work <= limit { Ok(()) } else { Err(self.error(Problem::Work { limit }, rule)) }
    }

    /// The rule that writes most in this step.
    fn busiest(&self) -> Option<usize> {
        let rules = self.grammar.rules.iter().zip(&self.applied).enumerate();
        let written =
            rules.map(|(index, (rule, applied))| (applied.saturating_mul(rule.successor.cost), index));
        let (most, index) = written.max_by_key(|&(written, index)| (written, std::cmp::Reverse(index)))?;
        (most > 0).then_some(index)
    }

    fn stopped(&self, stopped: Stopped) -> Error {
        self.error(stopped.into(), None)
    }

    fn undefined(&self, (problem, span): (Undefined, Range<usize>), rule: Option<usize>) -> Error {
        Error { span, ..self.error(Problem::Undefined(problem), rule) }
    }

    fn error(&self, problem: Problem, rule: Option<usize>) -> Error {
        let (rule, span) = match rule.and_then(|rule| self.grammar.rules.get(rule)) {
            Some(rule) => (format!("the rule for `{}`", rule.head), rule.span.clone()),
            None => ("the axiom".into(), self.grammar.axiom.span.clone()),
        };
        Error { problem, step: self.step, rule, span }
    }
}
