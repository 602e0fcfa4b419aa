//! Reads the lines of a grammar.

use super::expression::{Code, Constant, Parameter, Randomness, Scope};
use super::text::{Cursor, lines};
use super::warnings::{Braces, Uses};
use super::{CLOSE, CUT, Context, Error, Grammar, Letter, LetterId, OPEN, Rule, Successor, warnings};
use crate::core::text::cut;
use std::collections::HashMap;
use std::ops::Range;

/// Parameters of one module, and of a predecessor with its contexts.
const MOST_PARAMETERS: usize = 32;
/// Brackets in a right context, one in the other.
const DEEPEST_CONTEXT: usize = 16;
/// What can't be a symbol, since it is part of how a line is written.
const RESERVED: &str = "(),:<>=*#";
/// What can't name a sub-model.
const NO_NAMES: &str = "[]{}.~@%";

/// Mistakes that are told of one text.
const MOST_ERRORS: usize = 24;

pub fn grammar(text: &str, ignore: &str) -> Result<Grammar, Vec<Error>> {
    let mut reader = Reader::new(text);
    let mut errors = Vec::new();
    for line in lines(text).map_err(|error| vec![error])? {
        errors.extend(reader.line(line).err());
        if errors.len() == MOST_ERRORS {
            break;
        }
    }
    if errors.is_empty() { reader.finish(ignore).map_err(|error| vec![error]) } else { Err(errors) }
}

struct Reader<'a> {
    text: &'a str,
    alphabet: Alphabet,
    constants: HashMap<String, Constant>,
    hidden: Vec<Parameter>,
    axiom: Option<Successor>,
    rules: Vec<Rule>,
    uses: Uses,
    /// Calls of `rnd` so far.
    sites: u32,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Self {
        let mut alphabet = Alphabet::default();
        for (symbol, id) in [('[', OPEN), (']', CLOSE), ('%', CUT)] {
            alphabet.ids.insert(Letter { symbol, arity: 0 }, id);
            alphabet.letters.push(Letter { symbol, arity: 0 });
        }
        Reader {
            text,
            alphabet,
            constants: HashMap::new(),
            hidden: Vec::new(),
            axiom: None,
            rules: Vec::new(),
            uses: Uses::default(),
            sites: 0,
        }
    }

    fn line(&mut self, line: Range<usize>) -> Result<(), Error> {
        let mut cursor = Cursor::new(self.text, line.clone());
        if !cursor.peek().is_some_and(|first| first.is_alphabetic() || first == '_') {
            return self.rule(line);
        }
        let name = cursor.name();
        let span = line.start..cursor.last();
        let spaced = self.text[span.end..line.end].chars().next().is_none_or(char::is_whitespace);
        if cursor.peek() == Some('=') {
            self.constant(name, span, cursor)
        } else if name == "axiom" && spaced {
            self.axiom(span, cursor)
        } else {
            self.rule(line)
        }
    }

    /// `name = expression`
    fn constant(&mut self, name: &str, span: Range<usize>, mut cursor: Cursor) -> Result<(), Error> {
        if name == "axiom" {
            return Err(Error::new(span, "the axiom is no constant", "`axiom WORD`, without `=`"));
        }
        if self.constants.contains_key(name) {
            let problem = format!("`{}` is defined twice", cut(name));
            return Err(Error::new(span, problem, "another name"));
        }
        cursor.bump();
        let code = self.expression(&mut cursor, &[], Randomness::Refused);
        let code = code.and_then(|code| {
            end(&cursor, "an operator or the end of the line")?;
            Ok(code)
        });
        // Without parameters and chance, every expression is folded. The name of one that is wrong is known all the same.
        let value = code.as_ref().ok().and_then(Code::constant).unwrap_or(1.0);
        self.constants.insert(name.into(), Constant { value, span, used: false });
        code.map(|_| ())
    }

    /// `axiom WORD`
    fn axiom(&mut self, span: Range<usize>, mut cursor: Cursor) -> Result<(), Error> {
        if self.axiom.is_some() {
            return Err(Error::new(span, "there is an axiom already", "one axiom"));
        }
        if cursor.peek().is_none() {
            return Err(Error::new(span, "the axiom is empty", "a word behind it"));
        }
        let word = self.word(&mut cursor, &[])?;
        // Behind the words of rules there may be more.
        self.uses.nameless.extend(self.uses.last.take());
        self.axiom = Some(word);
        Ok(())
    }

    /// `LEFT < MODULE > RIGHT : condition -(weight)> WORD`
    fn rule(&mut self, line: Range<usize>) -> Result<(), Error> {
        let parts = Parts::of(self.text, line.clone())?;
        let mut parameters = Vec::new();

        let mut left = Vec::new();
        if let Some(range) = parts.left {
            let mut cursor = Cursor::new(self.text, range);
            while !context_ends(&mut cursor)? {
                if let Some(bracket @ ('[' | ']')) = cursor.peek() {
                    let span = cursor.place()..cursor.place() + 1;
                    let problem = format!("unexpected `{bracket}`");
                    let expected = "modules without branches: a left context is the path from the root";
                    return Err(Error::new(span, problem, expected));
                }
                left.push(self.formal(&mut cursor, &mut parameters)?);
            }
        }
        let left_parameters = parameters.len();

        let mut cursor = Cursor::new(self.text, parts.module.clone());
        if cursor.peek().is_none() {
            let place = cursor.place();
            return Err(Error::new(place..place, "the rule has no module", "what it rewrites, as `A(x)`"));
        }
        let letter = self.formal(&mut cursor, &mut parameters)?;
        if matches!(letter, OPEN | CLOSE | CUT) {
            let problem = "brackets and `%` can't be rewritten";
            return Err(Error::new(parts.module.start..cursor.last(), problem, "another symbol"));
        }
        let head = cut(&self.text[parts.module.start..cursor.last()]);
        end(&cursor, "one module only, then `<`, `>`, `:` or `->`")?;

        let mut right = Vec::new();
        if let Some(range) = parts.right {
            let mut cursor = Cursor::new(self.text, range);
            if !context_ends(&mut cursor)? {
                right = self.branch(&mut cursor, &mut parameters, 0)?;
            }
        }

        let condition = match parts.condition {
            Some(range) => self.condition(range, &parameters)?,
            None => None,
        };
        let weight = match parts.weight {
            Some(range) => {
                let mut cursor = Cursor::new(self.text, range);
                let code = self.expression(&mut cursor, &parameters, Randomness::Allowed)?;
                end(&cursor, "an operator or `)>`")?;
                Some(code)
            }
            None => None,
        };
        let mut cursor = Cursor::new(self.text, parts.word);
        let successor = self.word(&mut cursor, &parameters)?;

        self.hidden
            .extend(parameters.into_iter().filter(|parameter| self.constants.contains_key(&parameter.name)));
        self.rules.push(Rule {
            span: line,
            head,
            letter,
            left,
            right,
            left_parameters,
            condition,
            weight,
            successor,
        });
        Ok(())
    }

    /// A module of a predecessor: a symbol and names of its parameters.
    fn formal(&mut self, cursor: &mut Cursor, parameters: &mut Vec<Parameter>) -> Result<LetterId, Error> {
        let start = cursor.place();
        let symbol = symbol(cursor)?;
        let mut arity = 0;
        if cursor.take('(') {
            loop {
                let name_start = cursor.place();
                if !cursor.peek().is_some_and(|first| first.is_alphabetic() || first == '_') {
                    return Err(cursor.unexpected("the name of a parameter"));
                }
                let name = cursor.name();
                let span = name_start..cursor.last();
                if parameters.iter().any(|parameter| parameter.name == name) {
                    let problem = format!("two parameters are called `{}`", cut(name));
                    return Err(Error::new(span, problem, "another name; compare them in the condition"));
                }
                if parameters.len() == MOST_PARAMETERS {
                    return Err(too_many_parameters(span));
                }
                parameters.push(Parameter { name: name.into(), span });
                arity += 1;
                if cursor.take(')') {
                    break;
                }
                if !cursor.take(',') {
                    return Err(cursor.unexpected("`,` or `)`"));
                }
            }
        }
        self.alphabet.id(Letter { symbol, arity }, start..cursor.last())
    }

    /// A right context, or a branch of one up to its `]`.
    fn branch(
        &mut self,
        cursor: &mut Cursor,
        parameters: &mut Vec<Parameter>,
        depth: usize,
    ) -> Result<Vec<Context>, Error> {
        let mut contexts = Vec::new();
        loop {
            let place = cursor.place();
            match cursor.peek() {
                None => return Ok(contexts),
                Some(']') if depth == 0 => return Err(no_opening(place)),
                Some(']') => return Ok(contexts),
                Some('[') if depth == DEEPEST_CONTEXT => {
                    return Err(Error::new(place..place + 1, "this is nested too deeply", "fewer brackets"));
                }
                Some('[') => {
                    cursor.bump();
                    contexts.push(Context::Branch(self.branch(cursor, parameters, depth + 1)?));
                    if !cursor.take(']') {
                        return Err(no_closing(place));
                    }
                }
                Some(_) => contexts.push(Context::Module(self.formal(cursor, parameters)?)),
            }
        }
    }

    fn condition(&mut self, range: Range<usize>, parameters: &[Parameter]) -> Result<Option<Code>, Error> {
        let mut cursor = Cursor::new(self.text, range);
        if cursor.take('*') {
            end(&cursor, "`->`: a `*` alone stands for no condition")?;
            return Ok(None);
        }
        let code = self.expression(&mut cursor, parameters, Randomness::Allowed)?;
        end(&cursor, "an operator or `->`")?;
        Ok(Some(code).filter(|code| code.constant().is_none_or(|value| value == 0.0)))
    }

    /// A word up to the end of the cursor; `*`, `ε` or nothing is the empty one.
    fn word(&mut self, cursor: &mut Cursor, parameters: &[Parameter]) -> Result<Successor, Error> {
        let mut word = Successor { span: cursor.rest(), cost: 1, ..Successor::default() };
        if matches!(cursor.peek(), Some('*' | 'ε'))
            && self.text[word.span.clone()].trim().chars().count() == 1
        {
            return Ok(word);
        }
        let mut open = Vec::new();
        // The `~` before, if it is one.
        let mut placing = None;
        let mut braces = Braces::default();
        while cursor.peek().is_some() {
            let start = cursor.place();
            let symbol = symbol(cursor)?;
            let first = word.arguments.len();
            if cursor.peek() == Some('(') {
                let paren = cursor.place();
                if matches!(symbol, '[' | ']' | '%') {
                    return Err(cursor.unexpected(&format!("a module: `{symbol}` has no parameters")));
                }
                cursor.bump();
                loop {
                    let code = self.expression(cursor, parameters, Randomness::Allowed)?;
                    if word.arguments.len() - first == MOST_PARAMETERS {
                        return Err(too_many_parameters(code.span));
                    }
                    word.cost += code.cost;
                    word.arguments.push(code);
                    if cursor.take(')') {
                        break;
                    }
                    if cursor.peek().is_none() {
                        return Err(Error::new(paren..paren + 1, "this `(` is not closed", "`)`"));
                    }
                    if !cursor.take(',') {
                        return Err(cursor.unexpected("an operator, `,` or `)`"));
                    }
                }
            }
            match symbol {
                '[' => open.push(start),
                ']' if open.pop().is_none() => return Err(no_opening(start)),
                _ => {}
            }
            let span = start..cursor.last();
            let arity = (word.arguments.len() - first) as u32;
            let letter = self.alphabet.id(Letter { symbol, arity }, span.clone())?;
            let names_model = placing.is_some();
            self.uses.nameless.extend(placing.take().filter(|_| NO_NAMES.contains(symbol)));
            placing = (!names_model && matches!(symbol, '~' | '@')).then(|| (letter, span.clone()));
            braces.add(symbol, span.clone());
            self.uses.add(letter, span, names_model);
            word.letters.push(letter);
            word.cost += 1;
        }
        self.uses.braces.push(braces);
        self.uses.last = placing;
        match open.pop() {
            Some(start) => Err(no_closing(start)),
            None => Ok(word),
        }
    }

    fn expression(
        &mut self,
        cursor: &mut Cursor,
        parameters: &[Parameter],
        randomness: Randomness,
    ) -> Result<Code, Error> {
        let constants = &mut self.constants;
        Code::read(cursor, &mut Scope { constants, parameters, sites: &mut self.sites, randomness })
    }

    fn finish(self, ignore: &str) -> Result<Grammar, Error> {
        let Some(axiom) = self.axiom else {
            let end = self.text.trim_end().len();
            return Err(Error::new(end..end, "there is no axiom", "a line `axiom WORD`"));
        };
        let letters = self.alphabet.letters;
        let mut rules_of = vec![Vec::new(); letters.len()];
        for (index, rule) in self.rules.iter().enumerate() {
            rules_of[usize::from(rule.letter)].push(index);
        }
        let ignored = letters.iter().map(|letter| ignore.contains(letter.symbol)).collect();
        let rules = self.rules;
        let mut grammar =
            Grammar { alphabet: letters.into(), axiom, rules, rules_of, ignored, warnings: Vec::new() };
        grammar.warnings = warnings::all(&grammar, &self.constants, &self.hidden, &self.uses);
        Ok(grammar)
    }
}

#[derive(Default)]
struct Alphabet {
    letters: Vec<Letter>,
    ids: HashMap<Letter, LetterId>,
}

impl Alphabet {
    fn id(&mut self, letter: Letter, span: Range<usize>) -> Result<LetterId, Error> {
        if let Some(&id) = self.ids.get(&letter) {
            return Ok(id);
        }
        let Ok(id) = LetterId::try_from(self.letters.len()) else {
            return Err(Error::new(span, "these are too many different symbols", "fewer of them"));
        };
        self.letters.push(letter);
        self.ids.insert(letter, id);
        Ok(id)
    }
}

/// The parts of a rule's line, by their bytes.
struct Parts {
    left: Option<Range<usize>>,
    module: Range<usize>,
    right: Option<Range<usize>>,
    condition: Option<Range<usize>>,
    weight: Option<Range<usize>>,
    word: Range<usize>,
}

impl Parts {
    /// Takes a line apart at what stands outside of parentheses. The arrow is the last `>` behind `-` or `-(…)`: `+` and
    /// `-` are symbols, and `>` compares.
    fn of(text: &str, line: Range<usize>) -> Result<Parts, Error> {
        let mut cursor = Cursor::new(text, line.clone());
        let mut open = Vec::new();
        // The last parentheses that were closed outside of others.
        let mut closed = None;
        let mut colon = None;
        let mut angles = Vec::new();
        let mut arrow: Option<(Range<usize>, Option<Range<usize>>)> = None;
        while let Some(next) = cursor.bump() {
            let at = cursor.last() - next.len_utf8();
            let before = text[line.start..at].chars().next_back();
            match next {
                '(' => open.push(at),
                ')' => {
                    let Some(start) = open.pop() else {
                        return Err(Error::new(at..at + 1, "this `)` has no `(`", "`(` before it"));
                    };
                    closed = open.is_empty().then_some(start..at + 1);
                }
                _ if !open.is_empty() => {}
                '>' if before == Some('-') => arrow = Some((at - 1..at + 1, None)),
                '>' => {
                    angles.push((at, next));
                    let weight = closed
                        .clone()
                        .filter(|weight| weight.end == at && text[line.start..weight.start].ends_with('-'));
                    if let Some(weight) = weight {
                        arrow = Some((weight.start - 1..at + 1, Some(weight.start + 1..weight.end - 1)));
                    }
                }
                '<' => angles.push((at, next)),
                ':' if colon.is_none() => colon = Some(at),
                _ => {}
            }
        }
        if let Some(start) = open.pop() {
            return Err(Error::new(start..start + 1, "this `(` is not closed", "`)`"));
        }
        let Some((arrow, weight)) = arrow else {
            let expected = "`axiom WORD`, `name = expression` or `A -> WORD`";
            return Err(Error::new(line, "this line is no rule: it has no `->`", expected));
        };
        let colon = colon.filter(|&colon| colon < arrow.start);
        let head_end = colon.unwrap_or(arrow.start);
        let (mut left, mut right) = (None, None);
        for (at, angle) in angles.into_iter().filter(|(at, _)| *at < head_end) {
            let late = angle == '<' && right.is_some();
            let place = if angle == '<' { &mut left } else { &mut right };
            if late || place.is_some() {
                let problem = format!("unexpected `{angle}`");
                return Err(Error::new(at..at + 1, problem, "`LEFT < MODULE > RIGHT`"));
            }
            *place = Some(at);
        }
        let module_start = left.map_or(line.start, |at| at + 1);
        let module_end = right.unwrap_or(head_end);
        let blank = text[module_start..module_end].len() - text[module_start..module_end].trim_start().len();
        Ok(Parts {
            left: left.map(|at| line.start..at),
            module: module_start + blank..module_end,
            right: right.map(|at| at + 1..head_end),
            condition: colon.map(|colon| colon + 1..arrow.start),
            weight,
            word: arrow.end..line.end,
        })
    }
}

fn symbol(cursor: &mut Cursor) -> Result<char, Error> {
    match cursor.peek() {
        Some(symbol) if !RESERVED.contains(symbol) && !symbol.is_control() => {
            cursor.bump();
            Ok(symbol)
        }
        _ => Err(cursor.unexpected("a symbol")),
    }
}

/// Whether a context is at its end; `*` alone is none.
fn context_ends(cursor: &mut Cursor) -> Result<bool, Error> {
    if cursor.take('*') {
        end(cursor, "nothing: a `*` alone stands for no context")?;
    }
    Ok(cursor.peek().is_none())
}

fn end(cursor: &Cursor, expected: &str) -> Result<(), Error> {
    if cursor.peek().is_none() { Ok(()) } else { Err(cursor.unexpected(expected)) }
}

fn too_many_parameters(span: Range<usize>) -> Error {
    Error::new(span, "these are too many parameters", format!("at most {MOST_PARAMETERS}"))
}

fn no_opening(at: usize) -> Error {
    Error::new(at..at + 1, "this `]` has no `[`", "`[` before it, in the same word")
}

fn no_closing(at: usize) -> Error {
    Error::new(at..at + 1, "this `[` is not closed", "`]` behind it, in the same word")
}
