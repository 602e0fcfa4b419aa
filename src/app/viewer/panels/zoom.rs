//! An endless zoom: its flight, and where it is.

use super::super::engine::{Command, Course, Drawn, Pose, Status, WorldStatus};
use super::super::theme;
use crate::core::color::{linear_from_srgb, luminance};
use crate::zoom::marks::{self, Marks};
use egui::{Color32, Grid, RichText, TextEdit, Ui};

/// A code that is being typed or pasted.
#[derive(Default)]
pub struct Code(String);

/// The panel; returns what is to be done.
pub fn show(ui: &mut Ui, status: &Status, code: &mut Code) -> Vec<Command> {
    let WorldStatus::Zoom { depth, level, cells, slope, code: here, course, drawn, .. } = &status.world
    else {
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
    let Drawn { leaves, drawn, made, levels: [coarsest, finest], triangles } = drawn;
    Grid::new("zoom").num_columns(2).striped(true).show(ui, |ui| {
        let rows = [
            ("depth", format!("{depth:.2} octaves")),
            ("altitude", format!("{cells:.2} cells of level {level}")),
            ("slope", format!("{:.0}°", slope.to_degrees())),
            ("tiles", format!("{drawn} of {leaves}, {made} made")),
            ("levels", format!("{coarsest} to {finest}")),
            ("triangles", triangles.to_string()),
        ];
        for (name, value) in rows {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        }
    });
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        if ui
            .button("Copy place")
            .on_hover_text("Its code: exact, and as long as the place is deep (Ctrl L)")
            .clicked()
        {
            ui.ctx().copy_text(here.clone());
        }
        ui.label(RichText::new(shortened(here)).monospace().small().color(theme::ACCENT)).on_hover_text(here);
    });
    ui.horizontal(|ui| {
        let width = ui.available_width() - 40.0;
        let field =
            ui.add(TextEdit::singleline(&mut code.0).hint_text("a place's code").desired_width(width));
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if (ui.button("Go").clicked() || entered) && !code.0.trim().is_empty() {
            commands.push(Command::GoTo(Pose::Zoom(std::mem::take(&mut code.0))));
        }
    });
    commands
}

/// What is seen beside the surface; returns what is to be done.
pub fn drawing(ui: &mut Ui, status: &Status, marks: &mut Marks) -> Vec<Command> {
    let WorldStatus::Zoom { frozen, drawn, .. } = &status.world else { return Vec::new() };
    let mut commands = Vec::new();
    let before = *marks;
    let mut background = !marks.no_background;
    for (on, name, hover) in [
        (&mut marks.levels, "Levels", "Tiles have the colours of their levels; the background has none"),
        (&mut marks.borders, "Tile borders", "A line around every tile"),
        (&mut marks.wireframe, "Wireframe", "A line along every edge of a triangle"),
        (
            &mut marks.boxes,
            "Bounding boxes",
            "What the ground of each tile can't leave, whatever octaves are to come: tiles are chosen by how far these are",
        ),
        (
            &mut marks.corners,
            "Corner heights",
            "Heights of tiles' corners as the processor knows them: a cross, on a post as long as octaves to come may move the ground",
        ),
        (
            &mut background,
            "Background",
            "What is far away, drawn once for many pictures; without it the sky is seen where it would be",
        ),
    ] {
        ui.checkbox(on, name).on_hover_text(hover);
    }
    marks.no_background = !background;
    if *marks != before {
        commands.push(Command::Mark(*marks));
    }
    let mut freeze = *frozen;
    let hover = "Tiles stay those that are seen from here, and can be looked at from elsewhere";
    if ui.checkbox(&mut freeze, "Freeze tiles").on_hover_text(hover).changed() {
        commands.push(Command::Freeze(freeze));
    }
    if marks.levels || marks.boxes {
        legend(ui, drawn.levels);
    }
    commands
}

/// What colours stand for.
fn legend(ui: &mut Ui, [coarsest, finest]: [u32; 2]) {
    ui.horizontal_wrapped(|ui| {
        for level in coarsest..=finest {
            let [r, g, b] = marks::colour(level);
            let light = luminance([r, g, b].map(|channel| linear_from_srgb(f32::from(channel) / 255.0)));
            // Whichever of both stands out more.
            let text = if light > 0.18 { Color32::BLACK } else { Color32::WHITE };
            let name = RichText::new(format!("\u{a0}{level}\u{a0}")).small().color(text);
            ui.label(name.background_color(Color32::from_rgb(r, g, b)));
        }
    });
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
