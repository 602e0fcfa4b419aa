//! What users wrote, as messages show it.

/// A user's word: escaped, and cut where it would fill the screen.
pub fn shown(word: &str) -> String {
    let mut shown: String = word.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if word.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}

/// A word without anything that has to be escaped, cut in the same way.
pub fn cut(word: &str) -> String {
    match word.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.into(),
    }
}

/// Characters of a word that are shown.
const LONGEST: usize = 60;

/// A number without hundreds of zeros.
pub fn brief(number: f64) -> String {
    if number == 0.0 || (1e-6..1e15).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}
