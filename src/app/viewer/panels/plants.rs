//! What grows on the land: the plant that was clicked, and how many there are of each kind.

use super::super::engine::{Census, Selected, Status, WorldStatus};
use super::super::theme;
use super::rounded;
use crate::core::camera::Pinhole;
use egui::{Align, Grid, Layout, Painter, Pos2, Rect, RichText, ScrollArea, Stroke, Ui, pos2, vec2};

/// The panel.
pub fn show(ui: &mut Ui, status: &Status) {
    let WorldStatus::Land { census, selected, level, .. } = &status.world else { return };
    match selected {
        Some(selected) => self::selected(ui, selected, *level),
        None if census.is_empty() && status.work.is_some() => drop(ui.weak("Plants are growing …")),
        None if census.is_empty() => drop(ui.weak("Nothing stands on this land.")),
        None => drop(ui.weak("Click a plant in the picture.")),
    }
    if !census.is_empty() {
        ui.add_space(4.0);
        table(ui, census);
    }
}

fn selected(ui: &mut Ui, selected: &Selected, level: Option<usize>) {
    let Selected { species, variant, position, height, levels, .. } = selected;
    ui.label(RichText::new(title(species, *variant)).strong().color(theme::ACCENT));
    Grid::new("selected plant").num_columns(2).striped(true).show(ui, |ui| {
        let [east, up, south] = position.to_array().map(|metres| rounded(metres, 1));
        let finest = levels.first().copied().unwrap_or_default();
        let mut rows = vec![
            ("height", format!("{height:.2} m")),
            ("stands at", format!("{east} m east, {south} m south, {up} m up")),
            ("triangles", grouped(finest)),
        ];
        if let Some(drawn) = level.and_then(|level| Some((level, levels.get(level)?))) {
            let (level, triangles) = drawn;
            rows.push((
                "drawn with",
                format!("{} (level {} of {})", grouped(*triangles), level + 1, levels.len()),
            ));
        }
        for (name, value) in rows {
            ui.weak(name);
            ui.label(value);
            ui.end_row();
        }
    });
}

/// The kinds, the most frequent first.
fn table(ui: &mut Ui, census: &[Census]) {
    let mut rows: Vec<&Census> = census.iter().collect();
    rows.sort_by_key(|census| std::cmp::Reverse(census.plants));
    let plants: u64 = census.iter().map(|census| census.plants).sum();
    let triangles: u64 = census.iter().map(|census| census.plants * census.triangles).sum();
    ScrollArea::vertical().max_height(220.0).show(ui, |ui| {
        Grid::new("census").num_columns(4).striped(true).show(ui, |ui| {
            ui.weak("species");
            for (name, hover) in [
                ("plants", "How many there are"),
                ("triangles", "Of one plant, in its finest level of detail"),
                ("together", "If all were drawn in their finest levels"),
            ] {
                right(ui, |ui| drop(ui.weak(name).on_hover_text(hover)));
            }
            ui.end_row();
            for Census { species, variant, plants, triangles } in rows {
                ui.label(title(species, *variant));
                for number in [*plants, *triangles, plants * triangles] {
                    right(ui, |ui| drop(ui.label(short(number)).on_hover_text(grouped(number))));
                }
                ui.end_row();
            }
            ui.strong("all");
            right(ui, |ui| drop(ui.strong(short(plants)).on_hover_text(grouped(plants))));
            ui.label("");
            right(ui, |ui| drop(ui.strong(short(triangles)).on_hover_text(grouped(triangles))));
            ui.end_row();
        });
    });
}

fn right(ui: &mut Ui, show: impl FnOnce(&mut Ui)) {
    ui.with_layout(Layout::right_to_left(Align::Center), show);
}

fn title(species: &str, variant: u32) -> String {
    match variant {
        0 => species.into(),
        variant => format!("{species} {variant}"),
    }
}

/// Brackets round a plant, in a picture that is seen through `camera` and fills `rect`.
pub fn outline(painter: &Painter, rect: Rect, camera: &Pinhole, selected: &Selected) {
    let Some(plant) = around(rect, camera, selected) else { return };
    // A plant that fills the picture has its brackets at the rim; one that is far has room in them.
    let plant = plant.expand(4.0).intersect(rect.shrink(6.0));
    if !plant.is_positive() {
        return;
    }
    let arm = (0.25 * plant.width().min(plant.height())).clamp(3.0, 16.0);
    let corners = [
        (plant.left_top(), 1.0, 1.0),
        (plant.right_top(), -1.0, 1.0),
        (plant.left_bottom(), 1.0, -1.0),
        (plant.right_bottom(), -1.0, -1.0),
    ];
    // Dark below light: it is seen before sky and forest.
    for (width, colour) in [(4.0, egui::Color32::from_black_alpha(130)), (2.0, theme::ACCENT)] {
        for (corner, right, down) in corners {
            let points = vec![corner + vec2(right * arm, 0.0), corner, corner + vec2(0.0, down * arm)];
            painter.line(points, Stroke::new(width, colour));
        }
    }
}

/// The part of the picture that a plant takes; `None` if it is behind the eye.
fn around(rect: Rect, camera: &Pinhole, selected: &Selected) -> Option<Rect> {
    let seen = selected.shape.iter().filter_map(|corner| {
        let [right, down] = camera.project(*corner)?;
        Some(pos2(rect.left() + right * rect.width(), rect.top() + down * rect.height()))
    });
    let around = seen.fold(Rect::NOTHING, |around, at: Pos2| around.union(Rect::from_min_max(at, at)));
    around.is_finite().then_some(around)
}

/// With three digits.
fn short(number: u64) -> String {
    const STEPS: [(u64, &str); 3] = [(1_000_000_000, "G"), (1_000_000, "M"), (1_000, "k")];
    let Some((step, unit)) = STEPS.into_iter().find(|(step, _)| number >= 10 * step) else {
        return number.to_string();
    };
    let value = number as f64 / step as f64;
    if value >= 100.0 { format!("{value:.0} {unit}") } else { format!("{value:.1} {unit}") }
}

/// With a space before every three digits.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::sync::Arc;

    fn plant(shape: &[[f32; 3]]) -> Selected {
        let shape: Arc<[Vec3]> = shape.iter().map(|corner| Vec3::from(*corner)).collect();
        Selected {
            instance: 0,
            species: "oak".into(),
            variant: 0,
            position: Vec3::ZERO,
            height: 2.0,
            levels: vec![1],
            shape,
        }
    }

    #[test]
    fn outlines_go_round_what_is_seen() {
        let camera = Pinhole::look_along(Vec3::ZERO, Vec3::NEG_Z, std::f32::consts::FRAC_PI_2, 2.0);
        let rect = Rect::from_min_max(pos2(100.0, 50.0), pos2(500.0, 250.0));
        let around = |shape: &[[f32; 3]]| around(rect, &camera, &plant(shape));
        let ahead = around(&[[-5.0, 0.0, -10.0], [5.0, 5.0, -10.0], [0.0, -5.0, -10.0]]);
        let expected = Rect::from_min_max(pos2(250.0, 100.0), pos2(350.0, 200.0));
        assert!(ahead.is_some_and(|ahead| (ahead.min - expected.min).length() < 1e-2));
        assert!(ahead.is_some_and(|ahead| (ahead.max - expected.max).length() < 1e-2));
        assert_eq!(around(&[[0.0, 0.0, 10.0]]), None);
        assert_eq!(around(&[]), None);
    }

    #[test]
    fn numbers_are_short_and_long() {
        let both = |number| [short(number), grouped(number)];
        assert_eq!(both(0), ["0", "0"]);
        assert_eq!(both(9_999), ["9999", "9\u{202f}999"]);
        assert_eq!(both(12_345), ["12.3 k", "12\u{202f}345"]);
        assert_eq!(both(1_234_567_890), ["1235 M", "1\u{202f}234\u{202f}567\u{202f}890"]);
    }
}
