//! L-systems rewritten naively: words are strings, a step takes a string apart into a tree of branches and writes the
//! next string, expressions are evaluated from their text at every module.
//!
//! Written from the definitions of Prusinkiewicz & Lindenmayer 1990, "The Algorithmic Beauty of Plants", sections 1.6
//! to 1.10. It reads the grammars that tests write: one blank on both sides of `<`, `>`, `:` and the arrow.

use std::collections::HashMap;

pub struct Naive {
    constants: HashMap<String, f64>,
    axiom: String,
    rules: Vec<Rule>,
    ignore: String,
    seed: u32,
}

struct Rule {
    left: String,
    module: String,
    right: String,
    condition: Option<String>,
    weight: Option<String>,
    word: String,
}

/// Where a module stands: its number in the word decides its random numbers.
#[derive(Clone, Debug)]
struct Module {
    symbol: char,
    values: Vec<f64>,
    place: u64,
}

#[derive(Clone, Debug)]
enum Node {
    Module(Module),
    Branch(Vec<Node>),
}

/// There is no value, no rule to choose, or no word left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undefined;

type Result<T> = std::result::Result<T, Undefined>;
type Names = HashMap<String, f64>;

impl Naive {
    pub fn new(text: &str, ignore: &str, seed: u32) -> Result<Naive> {
        // Random numbers are told apart by their place in the text.
        let mut parts = text.split("rnd(");
        let first = parts.next().unwrap().to_owned();
        let text = parts.enumerate().fold(first, |text, (site, part)| format!("{text}rnd{site}({part}"));

        let (constants, axiom) = (HashMap::new(), String::new());
        let mut naive = Naive { constants, axiom, rules: Vec::new(), ignore: ignore.into(), seed };
        for line in text.lines() {
            if let Some(word) = line.strip_prefix("axiom ") {
                naive.axiom = word.into();
            } else if let Some((name, expression)) = line.split_once(" = ") {
                let value = value(&tokens(expression), &naive.constants, &|_| unreachable!())?;
                naive.constants.insert(name.into(), value);
            } else {
                naive.rules.push(Rule::read(line));
            }
        }
        Ok(naive)
    }

    /// The word before the first step.
    pub fn axiom(&self) -> Result<String> {
        let word = self.write(&self.axiom, &self.constants, &|site| unit(self.seed, 0, 0, site))?;
        if word.is_empty() { Err(Undefined) } else { Ok(word) }
    }

    /// The word after the step `step`, counted from 1.
    pub fn step(&self, word: &str, step: u32) -> Result<String> {
        let word = self.branch(&tree(word), &[], step)?;
        if word.is_empty() { Err(Undefined) } else { Ok(word) }
    }

    /// Rewrites a branch, whose modules have these between them and the root.
    fn branch(&self, nodes: &[Node], path: &[Module], step: u32) -> Result<String> {
        let mut path = path.to_vec();
        let mut next = String::new();
        for (index, node) in nodes.iter().enumerate() {
            match node {
                Node::Branch(inner) => next += &format!("[{}]", self.branch(inner, &path, step)?),
                Node::Module(module) if module.symbol == '%' => return Ok(next),
                Node::Module(module) => {
                    next += &self.rewritten(module, &path, &nodes[index + 1..], step)?;
                    if !self.ignores(module) {
                        path.push(module.clone());
                    }
                }
            }
        }
        Ok(next)
    }

    fn rewritten(&self, module: &Module, path: &[Module], rest: &[Node], step: u32) -> Result<String> {
        let random = |site| unit(self.seed, step, module.place, site);
        let mut candidates = Vec::new();
        for rule in &self.rules {
            if !candidates.is_empty() && rule.weight.is_none() {
                continue;
            }
            let Some(names) = self.fits(rule, module, path, rest) else { continue };
            if let Some(condition) = &rule.condition
                && value(&tokens(condition), &names, &random)? == 0.0
            {
                continue;
            }
            let Some(weight) = &rule.weight else { return self.write(&rule.word, &names, &random) };
            let weight = value(&tokens(weight), &names, &random)?;
            if weight < 0.0 {
                return Err(Undefined);
            }
            candidates.push((weight, rule, names));
        }
        if candidates.is_empty() {
            return Ok(shown(module.symbol, &module.values));
        }
        // What chooses is called after no place in the text.
        let mut rest = candidates.iter().map(|(weight, ..)| weight).sum::<f64>() * random(u32::MAX);
        for (weight, rule, names) in candidates {
            if rest < weight {
                return self.write(&rule.word, &names, &random);
            }
            rest -= weight;
        }
        Err(Undefined)
    }

    /// The values of all names in a rule, if it fits.
    fn fits(&self, rule: &Rule, module: &Module, path: &[Module], rest: &[Node]) -> Option<Names> {
        let mut names = self.constants.clone();
        let own = tree_of_names(&rule.module);
        let [Pattern::Module(symbol, parameters)] = own.as_slice() else { panic!("{}", rule.module) };
        bind(*symbol, parameters, module, &mut names)?;

        let left = tree_of_names(&rule.left);
        let from = path.len().checked_sub(left.len())?;
        for (pattern, module) in left.iter().zip(&path[from..]) {
            let Pattern::Module(symbol, parameters) = pattern else { panic!("{}", rule.left) };
            bind(*symbol, parameters, module, &mut names)?;
        }
        self.follows(&tree_of_names(&rule.right), rest, &names)
    }

    /// The names, with those of a right context, if what comes begins with it.
    fn follows(&self, patterns: &[Pattern], nodes: &[Node], names: &Names) -> Option<Names> {
        let Some((pattern, patterns)) = patterns.split_first() else { return Some(names.clone()) };
        let (node, nodes) = nodes.split_first()?;
        match (pattern, node) {
            (_, Node::Module(module)) if self.ignores(module) => {}
            (Pattern::Module(..), Node::Branch(_)) => {}
            (Pattern::Module(symbol, parameters), Node::Module(module)) => {
                let mut names = names.clone();
                bind(*symbol, parameters, module, &mut names)?;
                return self.follows(patterns, nodes, &names);
            }
            (Pattern::Branch(_), Node::Module(_)) => return None,
            (Pattern::Branch(inner), Node::Branch(branch)) => {
                if let Some(names) = self.follows(inner, branch, names)
                    && let Some(names) = self.follows(patterns, nodes, &names)
                {
                    return Some(names);
                }
            }
        }
        // What was here is skipped.
        let all: Vec<Pattern> = std::iter::once(pattern.clone()).chain(patterns.iter().cloned()).collect();
        self.follows(&all, nodes, names)
    }

    fn ignores(&self, module: &Module) -> bool {
        self.ignore.contains(module.symbol)
    }

    /// A word with its expressions evaluated.
    fn write(&self, word: &str, names: &Names, random: &dyn Fn(u32) -> f64) -> Result<String> {
        let mut written = String::new();
        let mut rest = word.replace(' ', "").replace('*', if word == "*" { "" } else { "*" });
        while let Some(symbol) = rest.chars().next() {
            rest.remove(0);
            let mut values = Vec::new();
            if rest.starts_with('(') {
                let end = closing(&rest);
                for argument in arguments(&tokens(&rest[1..end])) {
                    values.push(value(argument, names, random)?);
                }
                rest.drain(..=end);
            }
            written += &shown(symbol, &values);
        }
        Ok(written)
    }
}

impl Rule {
    fn read(line: &str) -> Rule {
        let (head, weight, word) = match line.split_once(" -> ") {
            Some((head, word)) => (head, None, word),
            None => {
                let (head, rest) = line.split_once(" -(").unwrap();
                let (weight, word) = rest.split_once(")> ").unwrap();
                (head, Some(weight.to_owned()), word)
            }
        };
        let (head, condition) = match head.split_once(" : ") {
            Some((head, condition)) => (head, Some(condition.to_owned())),
            None => (head, None),
        };
        let (left, head) = head.split_once(" < ").unwrap_or(("", head));
        let (module, right) = head.split_once(" > ").unwrap_or((head, ""));
        let [left, module, right, word] = [left, module, right, word].map(str::to_owned);
        Rule { left, module, right, condition, weight, word }
    }
}

/// A part of a rule's head: a symbol and names, or the beginning of a branch.
#[derive(Clone)]
enum Pattern {
    Module(char, Vec<String>),
    Branch(Vec<Pattern>),
}

fn bind(symbol: char, parameters: &[String], module: &Module, names: &mut Names) -> Option<()> {
    if symbol != module.symbol || parameters.len() != module.values.len() {
        return None;
    }
    names.extend(parameters.iter().cloned().zip(module.values.iter().copied()));
    Some(())
}

fn tree_of_names(text: &str) -> Vec<Pattern> {
    let mut patterns = Vec::new();
    let mut rest = text;
    while let Some(symbol) = rest.chars().next() {
        if symbol == '[' {
            let end = closing(rest);
            patterns.push(Pattern::Branch(tree_of_names(&rest[1..end])));
            rest = &rest[end + 1..];
            continue;
        }
        rest = &rest[symbol.len_utf8()..];
        let mut names = Vec::new();
        if rest.starts_with('(') {
            let end = closing(rest);
            names.extend(rest[1..end].split(',').map(str::to_owned));
            rest = &rest[end + 1..];
        }
        patterns.push(Pattern::Module(symbol, names));
    }
    patterns
}

/// A word as a tree.
fn tree(word: &str) -> Vec<Node> {
    let mut place = 0;
    subtree(word, &mut place)
}

fn subtree(word: &str, place: &mut u64) -> Vec<Node> {
    let mut nodes = Vec::new();
    let mut rest = word;
    while let Some(symbol) = rest.chars().next() {
        let own = *place;
        *place += 1;
        if symbol == '[' {
            let end = closing(rest);
            nodes.push(Node::Branch(subtree(&rest[1..end], place)));
            *place += 1;
            rest = &rest[end + 1..];
            continue;
        }
        rest = &rest[symbol.len_utf8()..];
        let mut values = Vec::new();
        if rest.starts_with('(') {
            let end = closing(rest);
            values.extend(rest[1..end].split(',').map(|value| value.parse::<f64>().unwrap()));
            rest = &rest[end + 1..];
        }
        nodes.push(Node::Module(Module { symbol, values, place: own }));
    }
    nodes
}

/// Where what the text begins with is closed.
fn closing(text: &str) -> usize {
    let mut depth = 0;
    for (at, letter) in text.char_indices() {
        depth += match letter {
            '(' | '[' => 1,
            ')' | ']' => -1,
            _ => 0,
        };
        if depth == 0 {
            return at;
        }
    }
    panic!("{text} is not closed")
}

fn shown(symbol: char, values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(f64::to_string).collect();
    if values.is_empty() { symbol.into() } else { format!("{symbol}({})", values.join(",")) }
}

/// Modules of a word.
pub fn length(word: &str) -> u64 {
    let mut depth = 0;
    let outside = word.chars().filter(|letter| {
        depth += i32::from(*letter == '(') - i32::from(*letter == ')');
        depth == 0 && *letter != ')'
    });
    outside.count() as u64
}

// Expressions --------------------------------------------------------------------------------------------------------

/// Numbers, names, operators, brackets.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let word = |letter: char| letter.is_alphanumeric() || letter == '.' || letter == '_';
    for letter in text.chars().filter(|letter| !letter.is_whitespace()) {
        if let Some(last) = tokens.last_mut() {
            let pair = format!("{last}{letter}");
            let two = ["==", "!=", "<=", ">=", "&&", "||"].contains(&pair.as_str());
            if two || word(letter) && last.chars().all(word) {
                *last = pair;
                continue;
            }
        }
        tokens.push(letter.into());
    }
    tokens
}

fn arguments(tokens: &[String]) -> Vec<&[String]> {
    let mut depth = 0;
    let mut commas = vec![];
    for (at, token) in tokens.iter().enumerate() {
        depth += i32::from(token == "(") - i32::from(token == ")");
        if depth == 0 && token == "," {
            commas.push(at);
        }
    }
    let starts = std::iter::once(0).chain(commas.iter().map(|at| at + 1));
    let ends = commas.iter().copied().chain([tokens.len()]);
    starts.zip(ends).map(|(start, end)| &tokens[start..end]).collect()
}

/// Splits at the operator that binds least, and evaluates both sides.
fn value(tokens: &[String], names: &Names, random: &dyn Fn(u32) -> f64) -> Result<f64> {
    const RANKS: [&[&str]; 5] =
        [&["||"], &["&&"], &["=", "==", "!=", "<", "<=", ">", ">="], &["+", "-"], &["*", "/"]];
    let of = |part: &[String]| value(part, names, random);
    for rank in RANKS {
        let Some(at) = last_outside(tokens, rank) else { continue };
        let left = of(&tokens[..at])?;
        let right = || of(&tokens[at + 1..]);
        return match tokens[at].as_str() {
            "||" => Ok(truth(left != 0.0 || right()? != 0.0)),
            "&&" => Ok(truth(left != 0.0 && right()? != 0.0)),
            "=" | "==" => Ok(truth(left == right()?)),
            "!=" => Ok(truth(left != right()?)),
            "<" => Ok(truth(left < right()?)),
            "<=" => Ok(truth(left <= right()?)),
            ">" => Ok(truth(left > right()?)),
            ">=" => Ok(truth(left >= right()?)),
            "+" => finite(left + right()?),
            "-" => finite(left - right()?),
            "*" => finite(left * right()?),
            _ => finite(left / right()?),
        };
    }
    match tokens[0].as_str() {
        "-" => return Ok(-of(&tokens[1..])?),
        "!" => return Ok(truth(of(&tokens[1..])? == 0.0)),
        _ => {}
    }
    let [name, inner @ ..] = tokens else { panic!("an empty expression") };
    if inner.is_empty() {
        return names.get(name).copied().map_or_else(|| finite(name.parse().unwrap()), Ok);
    }
    if name == "(" {
        return of(&inner[..inner.len() - 1]);
    }
    let values: Result<Vec<f64>> = arguments(&inner[1..inner.len() - 1]).into_iter().map(of).collect();
    match (name.as_str(), values?.as_slice()) {
        ("abs", [value]) => Ok(value.abs()),
        ("floor", [value]) => Ok(value.floor()),
        ("ceil", [value]) => Ok(value.ceil()),
        ("sqrt", [value]) => finite(value.sqrt()),
        ("sign", [value]) => Ok(truth(*value > 0.0) - truth(*value < 0.0)),
        ("min", [left, right]) => Ok(if right < left { *right } else { *left }),
        ("max", [left, right]) => Ok(if right > left { *right } else { *left }),
        (name, [from, to]) => {
            let site = name.strip_prefix("rnd").unwrap().parse().unwrap();
            finite(from + (to - from) * random(site))
        }
        _ => panic!("{name}"),
    }
}

/// The last of these operators outside of brackets and between two operands.
fn last_outside(tokens: &[String], operators: &[&str]) -> Option<usize> {
    let operand = |token: &String| token == ")" || token.starts_with(|first: char| first.is_alphanumeric());
    let mut candidates = (1..tokens.len()).filter(|&at| operand(&tokens[at - 1]));
    candidates.rfind(|&at| operators.contains(&tokens[at].as_str()) && outside(tokens, at))
}

fn outside(tokens: &[String], at: usize) -> bool {
    let count = |bracket: &str| tokens[..at].iter().filter(|token| *token == bracket).count();
    count("(") == count(")")
}

fn truth(holds: bool) -> f64 {
    if holds { 1.0 } else { 0.0 }
}

fn finite(value: f64) -> Result<f64> {
    if value.is_finite() { Ok(value) } else { Err(Undefined) }
}

/// The random number of a place in the text at a module in a step, from 0 to 1: SplitMix64's output (Steele, Lea & Flood
/// 2014, with Stafford's mix 13) of the seed and the step, of that and the module's place, of that and the place in the
/// text; its upper 53 bits.
fn unit(seed: u32, step: u32, place: u64, site: u32) -> f64 {
    fn split_mix(mut z: u64) -> u64 {
        z = z.wrapping_add(0x9e3779b97f4a7c15);
        z = (z ^ z >> 30).wrapping_mul(0xbf58476d1ce4e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d049bb133111eb);
        z ^ z >> 31
    }
    let of_step = split_mix((seed as u64) * (1 << 32) + step as u64);
    let of_place = split_mix(of_step ^ place);
    (split_mix(of_place ^ site as u64) >> 11) as f64 / 2.0_f64.powi(53)
}
