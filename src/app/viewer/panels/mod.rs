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

use egui_plot::{GridInput, GridMark};

/// A number with so many digits after the point. What is rounded to nothing has no sign.
pub fn rounded(value: impl Into<f64>, digits: usize) -> String {
    let text = format!("{:.digits$}", value.into());
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|letter| matches!(letter, '0' | '.')) => size.into(),
        _ => text,
    }
}

/// Marks of an axis at round numbers, two to five of them.
pub fn round_marks(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let least = (high - low) / 4.0;
    let power = 10_f64.powf(least.log10().floor());
    let step_size = [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * power).find(|step| *step >= least);
    let Some(step_size) = step_size.filter(|step| step.is_normal()) else { return Vec::new() };
    let first = (low / step_size).ceil();
    let marks = (0..=4).map(|index| (first + f64::from(index)) * step_size);
    marks.filter(|value| *value <= high).map(|value| GridMark { value, step_size }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_sign() {
        assert_eq!([-0.0_f32, -0.4, 0.4].map(|value| rounded(value, 0)), ["0", "0", "0"]);
        assert_eq!([-0.04_f64, -0.06, 1.25].map(|value| rounded(value, 1)), ["0.0", "-0.1", "1.2"]);
        assert_eq!(rounded(-10.0_f32, 0), "-10");
    }

    #[test]
    fn axes_have_a_few_round_numbers() {
        let marks = |low, high| {
            let marks = round_marks(GridInput { bounds: (low, high), base_step_size: 1.0 });
            marks.into_iter().map(|mark| mark.value).collect::<Vec<_>>()
        };
        assert_eq!(marks(0.0, 700.0), [0.0, 200.0, 400.0, 600.0]);
        assert_eq!(marks(-130.0, 420.0), [0.0, 200.0, 400.0]);
        assert_eq!(marks(0.0, 8.0), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert!(marks(3.0, 3.0).is_empty() && marks(0.0, f64::INFINITY).is_empty());
    }
}
