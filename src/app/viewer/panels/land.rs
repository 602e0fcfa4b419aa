//! Land: its simulation, what it is looked at by, and its path tracing.

use super::super::engine::{Command, Legend, Map, Overlay, Section, Status, Traced, WorldStatus};
use super::super::theme;
use super::{round_marks, rounded};
use crate::raster::{MATERIALS, Scale, overlay_colour};
use crate::terrain::{BrushKind, Kind, Progress, Stage};
use crate::world::World;
use egui::{Color32, ComboBox, ProgressBar, Rect, RichText, Slider, Ui, pos2, vec2};
use egui_plot::{Line, LineStyle, Plot, PlotPoints, Points, VLine};

/// What the user has chosen to look at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Look {
    pub map: Option<Map>,
    pub opacity: Option<f32>,
}

/// The panel of the simulation; returns what is to be done.
pub fn simulation(ui: &mut Ui, world: &World, status: &Status) -> Vec<Command> {
    let WorldStatus::Land { progress, playing, off, per_picture, .. } = &status.world else {
        return Vec::new();
    };
    let mut commands = Vec::new();
    let runs = *playing && !progress.finished;
    ui.horizontal(|ui| {
        let (name, hover) = if runs { ("Pause", "Let it rest (Enter)") } else { ("Play", "Go on (Enter)") };
        if ui.add_enabled(!progress.finished, egui::Button::new(name)).on_hover_text(hover).clicked() {
            commands.push(Command::Play(!playing));
        }
        let step = ui.add_enabled(!progress.finished, egui::Button::new("Step"));
        if step.on_hover_text("One iteration (.)").clicked() {
            commands.push(Command::Step);
        }
        if ui.button("Restart").on_hover_text("From the bare ground again (Backspace)").clicked() {
            commands.push(Command::Restart);
        }
    });
    let Progress { stage, iteration, of, finished } = progress;
    let share = if *finished { 1.0 } else { *iteration as f32 / (*of).max(1) as f32 };
    let text = if *finished { "finished".into() } else { format!("{}: {iteration} of {of}", stage.name()) };
    ui.add(ProgressBar::new(share).text(RichText::new(text).small()));
    let mut most = *per_picture;
    let slider =
        Slider::new(&mut most, 0..=100).text("iterations a picture").custom_formatter(
            |value, _| match value {
                0.0 => "all".into(),
                value => format!("{value:.0}"),
            },
        );
    let hover = "Iterations between two pictures; all: as many as there is time for";
    if ui.add(slider).on_hover_text(hover).changed() {
        commands.push(Command::PerPicture(most));
    }
    ui.add_space(4.0);
    let plan = &world.plan;
    for (process, name, about, exists) in [
        (
            Kind::Hydraulic,
            "Water",
            "Rain that runs off, wears the ground and lays it down",
            plan.hydraulic.is_some(),
        ),
        (Kind::Thermal, "Slides", "Ground that is too steep slides down", plan.thermal.is_some()),
        (
            Kind::Seabed,
            "Sea bed",
            "The bottom of the sea is smoothed before coral grows",
            plan.seabed_smoothing > 0.0,
        ),
        (Kind::Reef, "Reef", "Coral grows; nothing erodes any more from then on", plan.reef.is_some()),
    ] {
        if !exists {
            continue;
        }
        let mut on = !off.contains(&process);
        if ui.checkbox(&mut on, name).on_hover_text(about).changed() {
            commands.push(Command::Enable(process, on));
        }
    }
    if *stage == Stage::Reef {
        ui.label(
            RichText::new("Coral and erosion exclude each other: once coral grows, the rain has ended.")
                .weak()
                .small(),
        );
    }
    commands
}

/// What is looked at; returns what is to be laid over the picture, if that has changed.
pub fn layers(ui: &mut Ui, world: &World, status: &Status, look: &mut Look) -> Option<Command> {
    let before = *look;
    let name = look.map.map_or("none", Map::name);
    ComboBox::from_label("layer").selected_text(name).show_ui(ui, |ui| {
        ui.selectable_value(&mut look.map, None, "none");
        for map in Map::all(&world.plan) {
            ui.selectable_value(&mut look.map, Some(map), map.name());
        }
    });
    let mut opacity = look.opacity.unwrap_or(0.75);
    if look.map.is_some() {
        if ui.add(Slider::new(&mut opacity, 0.0..=1.0).text("opacity").fixed_decimals(2)).changed() {
            look.opacity = Some(opacity);
        }
        if let WorldStatus::Land { legend: Some(legend), .. } = &status.world {
            self::legend(ui, legend);
        }
    }
    let changed = look.map != before.map || look.opacity != before.opacity;
    changed.then(|| Command::Overlay(look.map.map(|map| Overlay { map, opacity })))
}

/// What colours stand for.
fn legend(ui: &mut Ui, legend: &Legend) {
    if legend.map == Map::Materials {
        ui.horizontal_wrapped(|ui| {
            for (name, [r, g, b]) in MATERIALS {
                let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), egui::Sense::hover());
                ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
                ui.label(name);
            }
        });
        return;
    }
    const PARTS: usize = 64;
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 12.0), egui::Sense::hover());
    for part in 0..PARTS {
        let [from, to] = [part, part + 1].map(|at| rect.left() + rect.width() * at as f32 / PARTS as f32);
        let [r, g, b] = overlay_colour((part as f32 + 0.5) / PARTS as f32);
        let area = Rect::from_min_max(pos2(from, rect.top()), pos2(to + 0.5, rect.bottom()));
        ui.painter().rect_filled(area, 0.0, Color32::from_rgb(r, g, b));
    }
    let unit = legend.map.unit();
    let [low, high] = legend.bounds;
    let middle = match legend.scale {
        Scale::Linear => (low + high) / 2.0,
        Scale::Logarithmic => (low.max(1e-30) * high.max(1e-30)).sqrt(),
    };
    ui.columns(3, |columns| {
        columns[0].label(RichText::new(format!("{} {unit}", short(low))).small());
        columns[1]
            .vertical_centered(|ui| ui.label(RichText::new(format!("{} {unit}", short(middle))).small()));
        columns[2].with_layout(egui::Layout::right_to_left(egui::Align::Min), |ui| {
            ui.label(RichText::new(format!("{} {unit}", short(high))).small());
        });
    });
}

/// Three digits.
fn short(value: f32) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 1.0 => format!("{value:.1}"),
        size if size >= 0.01 => format!("{value:.3}"),
        _ => format!("{value:.1e}"),
    }
}

/// The brush.
#[derive(Clone, Copy, Debug)]
pub struct Brush {
    /// None while the mouse moves the eye.
    pub kind: Option<BrushKind>,
    /// Metres.
    pub radius: f32,
    pub strength: f32,
}

impl Default for Brush {
    fn default() -> Self {
        Brush { kind: None, radius: 300.0, strength: 0.3 }
    }
}

impl Brush {
    /// What a touch does in the middle, in the unit of its kind.
    pub fn amount(&self) -> f32 {
        match self.kind {
            // A tenth of its radius is a steep hill.
            Some(BrushKind::Raise | BrushKind::Lower) => self.strength * self.radius * 0.1,
            Some(BrushKind::Rain) => self.strength * 2.0,
            _ => 1.0 - self.strength,
        }
    }
}

/// The brush's panel; returns what is to be done.
pub fn brush(ui: &mut Ui, world: &World, status: &Status, brush: &mut Brush) -> Option<Command> {
    let WorldStatus::Land { strokes, progress, .. } = &status.world else { return None };
    // What is poured on finished land would stand where it fell.
    let flows = world.plan.hydraulic.is_some() && !progress.finished;
    if brush.kind == Some(BrushKind::Rain) && !flows {
        brush.kind = None;
    }
    ui.horizontal_wrapped(|ui| {
        for (kind, name, hover) in [
            (None, "Off", "The mouse moves the eye"),
            (Some(BrushKind::Raise), "Raise", "Raise the ground"),
            (Some(BrushKind::Lower), "Lower", "Lower the ground"),
            (Some(BrushKind::Rain), "Rain", "Pour water on it"),
            (
                Some(BrushKind::Mask),
                "Mask",
                "Hold the ground: what is masked wholly does not change any more",
            ),
        ] {
            let exists = kind != Some(BrushKind::Rain) || flows;
            let label = egui::Button::selectable(brush.kind == kind, name);
            let button = ui.add_enabled(exists, label).on_hover_text(hover);
            if button.on_disabled_hover_text("No water runs on this land any more").clicked() {
                brush.kind = kind;
            }
        }
    });
    let most = world.plan.grid.extent / 4.0;
    ui.add(
        Slider::new(&mut brush.radius, most / 100.0..=most)
            .logarithmic(true)
            .text("radius")
            .suffix(" m")
            .max_decimals(0),
    );
    ui.add(Slider::new(&mut brush.strength, 0.01..=1.0).text("strength").max_decimals(2));
    ui.label(
        RichText::new("Strokes are no part of the world's file: they are gone when the land begins again.")
            .weak()
            .small(),
    );
    let name = match strokes {
        0 => "Take the last stroke back".into(),
        many => format!("Take the last stroke back ({many})"),
    };
    let button = ui.add_enabled(*strokes > 0, egui::Button::new(name));
    button.clicked().then_some(Command::TakeStrokeBack)
}

/// A cut through the land under the mouse.
pub fn section(ui: &mut Ui, section: Option<&Section>) {
    let Some(section) = section else {
        ui.weak("Point at the land.");
        return;
    };
    let sea = f64::from(section.sea_level);
    let [first, last] =
        [section.points.first(), section.points.last()].map(|point| point.map_or(0.0, |point| point[0]));
    Plot::new("section")
        .height(110.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show_x(false)
        .show_axes([false, true])
        .y_axis_min_width(34.0)
        .show_grid([false, true])
        .y_grid_spacer(round_marks)
        .y_axis_formatter(|mark, _| format!("{} m", rounded(mark.value, 0)))
        .show(ui, |plot| {
            plot.line(Line::new("ground", PlotPoints::from(section.points.clone())).color(theme::ACCENT));
            let sea = vec![[first, sea], [last, sea]];
            plot.line(Line::new("sea", PlotPoints::from(sea)).color(Color32::from_rgb(0x56, 0xb4, 0xe9)));
            let [east, up] = [section.at.x, section.at.y].map(f64::from);
            plot.vline(VLine::new("here", east).color(Color32::WHITE).style(LineStyle::dashed_dense()));
            plot.points(Points::new("here", vec![[east, up]]).radius(3.0).color(Color32::WHITE));
        });
    let [east, up, south] = section.at.to_array();
    let [east, south, up] = [(east, 0), (south, 0), (up, 1)].map(|(metres, digits)| rounded(metres, digits));
    ui.label(RichText::new(format!("{east} m east, {south} m south: {up} m")).small());
}

/// Path tracing; returns what is to be done. `save` is called when the picture is to be written.
pub fn tracing(ui: &mut Ui, status: &Status, mut save: impl FnMut()) -> Option<Command> {
    let WorldStatus::Land { progress, traced, tracing, .. } = &status.world else { return None };
    let mut command = None;
    ui.horizontal(|ui| {
        let name = if *tracing { "Stop" } else { "Trace paths" };
        let hover = if progress.finished {
            "Whenever nothing moves, from where the eye is (P)"
        } else {
            "The land as it is now, from where the eye is; the simulation rests (P)"
        };
        if ui.button(name).on_hover_text(hover).clicked() {
            command = Some(Command::Trace(!tracing));
        }
        if ui
            .button("Save picture …")
            .on_hover_text("As PNG, or as EXR with all that is known of it")
            .clicked()
        {
            save();
        }
    });
    if let Some(Traced { samples, of, noise, rate, left }) = traced {
        let share = (samples / f64::from(*of)) as f32;
        ui.add(
            ProgressBar::new(share)
                .text(RichText::new(format!("{samples:.1} of {of} samples a pixel")).small()),
        );
        let noise = noise.map(|noise| format!("error about {:.1} %", 100.0 * noise)).unwrap_or_default();
        ui.label(RichText::new(format!("{noise}  {:.2} M samples/s  {left:.0} s left", rate / 1e6)).small());
    }
    if let Some((what, ..)) = &status.work {
        ui.horizontal(|ui| {
            ui.add(egui::Spinner::new().size(12.0).color(theme::ACCENT));
            ui.label(what);
        });
    }
    command
}
