//! What is shown beside the picture. A panel draws what it is given and returns what the user wants; it changes nothing itself.

pub mod export;
pub mod files;
pub mod help;
pub mod land;
pub mod parameters;
pub mod picture;
pub mod plants;
pub mod timings;
pub mod welcome;
pub mod zoom;

/// A number with so many digits after the point. What is rounded to nothing has no sign.
pub fn rounded(value: impl Into<f64>, digits: usize) -> String {
    let text = format!("{:.digits$}", value.into());
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|letter| matches!(letter, '0' | '.')) => size.into(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn nothing_has_no_sign() {
        assert_eq!([-0.0_f32, -0.4, 0.4].map(|value| rounded(value, 0)), ["0", "0", "0"]);
        assert_eq!([-0.04_f64, -0.06, 1.25].map(|value| rounded(value, 1)), ["0.0", "-0.1", "1.2"]);
        assert_eq!(rounded(-10.0_f32, 0), "-10");
    }
}
