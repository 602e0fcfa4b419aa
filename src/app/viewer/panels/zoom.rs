//! An endless zoom: its flight, and where it is.

use super::super::engine::{Command, Course, Drawn, Pose, Status, WorldStatus};
use super::super::theme;
use egui::{Grid, RichText, TextEdit, Ui};

/// A code that is being typed or pasted.
#[derive(Default)]
pub struct Code(String);

/// The panel; returns what is to be done.
pub fn show(ui: &mut Ui, status: &Status, code: &mut Code) -> Vec<Command> {
    let WorldStatus::Zoom { depth, level, cells, slope, code: here, course, drawn } = &status.world else {
        return Vec::new();
    };
    let mut commands = Vec::new();
    ui.horizontal(|ui| {
        for (wanted, name, hover) in [
            (Course::In, "In", "Down to a spot of gentle slope, for ever (G)"),
            (Course::Hand, "Stop", "Where it is steered"),
            (Course::Out, "Out", "Up again, the same way (B)"),
        ] {
            if ui.selectable_label(course == &wanted, name).on_hover_text(hover).clicked() {
                commands.push(Command::Course(wanted));
            }
        }
        if ui.button("Restart").on_hover_text("Where the world begins (Backspace)").clicked() {
            commands.push(Command::Restart);
        }
    });
    ui.add_space(4.0);
    let Drawn { leaves, drawn, made } = drawn;
    Grid::new("zoom").num_columns(2).striped(true).show(ui, |ui| {
        let rows = [
            ("depth", format!("{depth:.2} octaves")),
            ("altitude", format!("{cells:.2} cells of level {level}")),
            ("slope", format!("{:.0}°", slope.to_degrees())),
            ("tiles", format!("{drawn} of {leaves}, {made} made")),
        ];
        for (name, value) in rows {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        }
    });
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        if ui.button("Copy place").on_hover_text("Its code: exact, and as long as the place is deep (Ctrl L)").clicked() {
            ui.ctx().copy_text(here.clone());
        }
        ui.label(RichText::new(shortened(here)).monospace().small().color(theme::ACCENT)).on_hover_text(here);
    });
    ui.horizontal(|ui| {
        let width = ui.available_width() - 40.0;
        let field = ui.add(TextEdit::singleline(&mut code.0).hint_text("a place's code").desired_width(width));
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if (ui.button("Go").clicked() || entered) && !code.0.trim().is_empty() {
            commands.push(Command::GoTo(Pose::Zoom(std::mem::take(&mut code.0))));
        }
    });
    commands
}

/// The beginning of a code, and its end.
fn shortened(code: &str) -> String {
    const MOST: usize = 24;
    let letters = code.chars().count();
    if letters <= MOST {
        return code.into();
    }
    let begin: String = code.chars().take(MOST / 2).collect();
    let end: String = code.chars().skip(letters - MOST / 2).collect();
    format!("{begin}…{end}")
}
