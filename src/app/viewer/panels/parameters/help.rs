//! What is known of a key, in words.

use super::title;
use crate::world::schema::{Alternative, Key, REQUIRED, Shape, paragraph};
use egui::{RichText, Ui};

/// Everything about a key, as a tooltip.
pub fn of_key(ui: &mut Ui, key: &Key) {
    ui.set_max_width(ui.spacing().tooltip_width);
    ui.label(RichText::new(title(key.name)).strong());
    ui.label(paragraph(key.about));
    if let Some(allowed) = allowed(&key.shape) {
        ui.weak(allowed);
    }
    ui.weak(format!("Default: {}.", default(key).trim_end_matches('.')));
}

/// About one of several things that a key may be.
pub fn of_alternative(ui: &mut Ui, alternative: &Alternative) {
    ui.set_max_width(ui.spacing().tooltip_width);
    ui.label(RichText::new(title(alternative.name)).strong());
    ui.label(paragraph(alternative.about));
}

/// What is allowed, as a sentence; `None` where the widget shows it.
fn allowed(shape: &Shape) -> Option<String> {
    match shape {
        Shape::Switch | Shape::Choice(_) | Shape::Table(_) | Shape::OneOf(_) | Shape::Colour => None,
        Shape::OrWord(_, [word, about]) => {
            let inner = Some(shape).and_then(|shape| if let Shape::OrWord(inner, _) = shape { allowed(inner) } else { None });
            let word = format!("Or \"{word}\": {}", lower(about));
            Some(inner.map_or_else(|| word.clone(), |inner| format!("{inner}\n{word}")))
        }
        shape => Some(format!("{}.", upper(&shape.allowed()))),
    }
}

/// The default, in words.
pub fn default(key: &Key) -> String {
    let unit = key.shape.number().map(|(unit, _)| unit.symbol).filter(|symbol| !symbol.is_empty());
    match (key.default.as_str(), unit) {
        (REQUIRED, _) => "none, it must be written".into(),
        ("{}", _) => "the defaults of its keys".into(),
        ("[]", _) => "none".into(),
        (default, Some(unit)) if key.default_value().is_some() => format!("{default} {unit}"),
        (default, _) => paragraph(default),
    }
}

fn upper(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect()
}

fn lower(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().into_iter().flat_map(char::to_lowercase).chain(letters).collect()
}
