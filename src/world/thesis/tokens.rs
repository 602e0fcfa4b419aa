//! Words of a file of settings: what white space separates, up to `#`.

use std::ops::Range;

/// A word of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Token<'a> {
    pub text: &'a str,
    /// Bytes of the file.
    pub span: Range<usize>,
    /// Number of its line, from 0.
    pub line: usize,
}

/// Splits a file into words. A comment begins at a `#` and goes on to the end of the line.
pub fn tokens(text: &str) -> Vec<Token<'_>> {
    let start_of_text = text.as_ptr() as usize;
    let mut tokens = Vec::new();
    // Some editors begin a file with a byte order mark.
    for (line, words) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let before_comment = words.split('#').next().unwrap_or_default();
        tokens.extend(before_comment.split_whitespace().map(|text| {
            let start = text.as_ptr() as usize - start_of_text;
            Token { text, span: start..start + text.len(), line }
        }));
    }
    tokens
}
