//! Symbols and productions of an L-system, `Prod A > WORD`.

use super::parameters::Kind;
use crate::world::fault::Complaint;
use crate::world::place::shown;

/// Symbols that the turtle knows; letters that it does not know stand for what grows.
pub const TURTLE: &str = r"Ff[]+-^&\/|{.}@";

/// What becomes of a symbol.
#[derive(Clone, Debug, PartialEq)]
pub struct Production {
    pub symbol: char,
    pub word: String,
}

/// One symbol.
pub struct Symbol;

/// Productions, of which there may be any number. The last one of a symbol counts.
pub struct Productions;

impl Kind for Symbol {
    type Value = char;

    fn allowed(&self) -> String {
        "one symbol".into()
    }

    fn default(&self) -> Option<String> {
        None
    }

    fn read(&self, words: &[&str]) -> Result<char, (usize, Complaint)> {
        symbol(words.first().copied().unwrap_or_default()).map_err(|complaint| (0, complaint))
    }
}

impl Kind for Productions {
    type Value = Vec<Production>;

    fn count(&self) -> usize {
        3
    }

    fn one_line(&self) -> bool {
        true
    }

    fn allowed(&self) -> String {
        "a symbol, `>` and a word: `Prod A > F[+A]A`".into()
    }

    fn default(&self) -> Option<String> {
        Some(String::new())
    }

    fn read(&self, words: &[&str]) -> Result<Vec<Production>, (usize, Complaint)> {
        let &[from, arrow, word] = words else { return Ok(Vec::new()) };
        let from = symbol(from).map_err(|complaint| (0, complaint))?;
        if arrow != ">" {
            let problem = format!("has `{}` in place of `>`", shown(arrow));
            return Err((1, Complaint::new(problem, self.allowed())));
        }
        let unknown = word.chars().find(|&symbol| !is_symbol(symbol));
        if let Some(unknown) = unknown {
            return Err((2, unknown_symbol(unknown)));
        }
        balance(word).map_err(|complaint| (2, complaint))?;
        Ok(vec![Production { symbol: from, word: word.into() }])
    }

    fn read_all(&self, entries: &[Vec<&str>]) -> Result<Vec<Production>, (usize, usize, Complaint)> {
        let mut productions: Vec<Production> = Vec::new();
        for (entry, words) in entries.iter().enumerate() {
            for production in self.read(words).map_err(|(word, complaint)| (entry, word, complaint))? {
                productions.retain(|earlier| earlier.symbol != production.symbol);
                productions.push(production);
            }
        }
        Ok(productions)
    }
}

fn symbol(word: &str) -> Result<char, Complaint> {
    let mut symbols = word.chars();
    match (symbols.next(), symbols.next()) {
        (Some(symbol), None) if is_symbol(symbol) => Ok(symbol),
        (Some(symbol), None) => Err(unknown_symbol(symbol)),
        _ => Err(Complaint::new(format!("can't be `{}`", shown(word)), "one symbol")),
    }
}

fn is_symbol(symbol: char) -> bool {
    symbol.is_ascii_alphabetic() || TURTLE.contains(symbol)
}

fn unknown_symbol(symbol: char) -> Complaint {
    let known = TURTLE.chars().map(String::from).collect::<Vec<_>>().join(" ");
    Complaint::new(
        format!("holds the unknown symbol `{}`", symbol.escape_debug()),
        "letters, and what the turtle knows",
    )
    .help(format!("the turtle knows: {known}"))
}

/// A branch that begins in a word ends in it.
fn balance(word: &str) -> Result<(), Complaint> {
    const WHOLE: &str = "a branch begins and ends in one word";

    let mut open = 0_u32;
    for symbol in word.chars() {
        match symbol {
            '[' => open += 1,
            ']' if open == 0 => return Err(Complaint::new("has a `]` without its `[`", WHOLE)),
            ']' => open -= 1,
            _ => {}
        }
    }
    if open == 0 { Ok(()) } else { Err(Complaint::new("has a `[` without its `]`", WHOLE)) }
}
