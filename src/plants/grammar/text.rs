//! The text of a grammar: logical lines, and a cursor that knows where it is.

use super::Error;
use std::ops::Range;

/// Splits a text into logical lines, by their bytes. A line that is indented more than the first one continues the line
/// above; lines with nothing but a comment belong to no line.
///
/// # Errors
/// None but for a line that is indented less than the first one.
pub fn lines(text: &str) -> Result<Vec<Range<usize>>, Error> {
    let mut lines: Vec<Range<usize>> = Vec::new();
    let mut margin = None;
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let written = line.split('#').next().unwrap_or_default();
        let content = written.trim_start();
        let indent = written.len() - content.len();
        let range = start + indent..start + written.trim_end().len();
        start += line.len();
        if content.is_empty() {
            continue;
        }
        let margin = *margin.get_or_insert(indent);
        match lines.last_mut() {
            Some(last) if indent > margin => last.end = range.end,
            _ if indent < margin => {
                let problem = "this line is indented less than the first one";
                return Err(Error::new(
                    range,
                    problem,
                    "all rules in one column, and what continues them further in",
                ));
            }
            _ => lines.push(range),
        }
    }
    Ok(lines)
}

/// Reads a part of a text, over white space and comments.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    text: &'a str,
    /// Up to here.
    end: usize,
    /// Of the next character that counts.
    at: usize,
    last: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(text: &'a str, range: Range<usize>) -> Cursor<'a> {
        let mut cursor = Cursor { text, end: range.end, at: range.start, last: range.start };
        cursor.skip();
        cursor
    }

    /// Where the next character stands, or where the text ends.
    pub fn place(&self) -> usize {
        if self.at < self.end { self.at } else { self.last.max(self.at.min(self.end)) }
    }

    /// Where what was read last ends.
    pub fn last(&self) -> usize {
        self.last
    }

    pub fn peek(&self) -> Option<char> {
        self.text[self.at..self.end].chars().next()
    }

    /// What is left, with the white space in it.
    pub fn rest(&self) -> Range<usize> {
        self.at..self.end
    }

    pub fn bump(&mut self) -> Option<char> {
        let next = self.peek()?;
        self.at += next.len_utf8();
        self.last = self.at;
        self.skip();
        Some(next)
    }

    /// Goes on if this comes next.
    pub fn take(&mut self, wanted: char) -> bool {
        self.peek() == Some(wanted) && self.bump().is_some()
    }

    /// Goes on if these two come next, without anything between them.
    pub fn take_pair(&mut self, first: char, second: char) -> bool {
        let mut next = self.text[self.at..self.end].chars();
        next.next() == Some(first) && next.next() == Some(second) && self.bump().and(self.bump()).is_some()
    }

    /// The name that begins here.
    pub fn name(&mut self) -> &'a str {
        self.while_all(|_, letter| letter.is_alphanumeric() || letter == '_')
    }

    /// What is written like a number here.
    pub fn number(&mut self) -> (&'a str, Range<usize>) {
        let start = self.at;
        let bytes = &self.text.as_bytes()[..self.end];
        let digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_digit);
        let text = self.while_all(|at, letter| match letter {
            '0'..='9' | '.' => true,
            'e' | 'E' => digit(at + 1) || (matches!(bytes.get(at + 1), Some(b'+' | b'-')) && digit(at + 2)),
            '+' | '-' => at > start && matches!(bytes[at - 1], b'e' | b'E'),
            _ => false,
        });
        (text, start..self.last)
    }

    fn while_all(&mut self, belongs: impl Fn(usize, char) -> bool) -> &'a str {
        let rest = &self.text[self.at..self.end];
        let length = rest.char_indices().find(|&(at, letter)| !belongs(self.at + at, letter));
        let length = length.map_or(rest.len(), |(at, _)| at);
        self.at += length;
        self.last = self.at;
        self.skip();
        &rest[..length]
    }

    /// The complaint that something else was to come.
    pub fn unexpected(&self, expected: &str) -> Error {
        let place = self.place();
        match self.peek() {
            Some(next) => {
                Error::new(place..place + next.len_utf8(), format!("unexpected `{next}`"), expected)
            }
            None => Error::new(place..place, "something is missing", expected),
        }
    }

    fn skip(&mut self) {
        while let Some(next) = self.peek() {
            if next == '#' {
                let rest = &self.text[self.at..self.end];
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if next.is_whitespace() {
                self.at += next.len_utf8();
            } else {
                return;
            }
        }
    }
}
