//! Where the time goes, and the memory.

use super::super::engine::Status;
use crate::gpu::Timing;
use egui::{Color32, Grid, RichText, ScrollArea, Ui};
use egui_plot::{Line, Plot, PlotPoints};
use std::collections::{BTreeMap, VecDeque};
use std::time::Instant;

/// What things took lately.
pub struct Timings {
    begun: Instant,
    rows: BTreeMap<&'static str, Row>,
}

struct Row {
    /// Whether the device told, or a clock did.
    on_device: bool,
    /// Seconds since the start, and milliseconds.
    points: VecDeque<[f64; 2]>,
}

/// Points of a line.
const MOST_POINTS: usize = 240;

/// What is shown of the past, seconds.
const PAST: f64 = 30.0;

/// Colours of lines, told apart by eyes that do not tell red from green, too (Okabe & Ito 2008, "Color Universal Design").
const COLOURS: [Color32; 8] = [
    Color32::from_rgb(0xe6, 0x9f, 0x00),
    Color32::from_rgb(0x56, 0xb4, 0xe9),
    Color32::from_rgb(0x00, 0x9e, 0x73),
    Color32::from_rgb(0xf0, 0xe4, 0x42),
    Color32::from_rgb(0x00, 0x72, 0xb2),
    Color32::from_rgb(0xd5, 0x5e, 0x00),
    Color32::from_rgb(0xcc, 0x79, 0xa7),
    Color32::from_rgb(0xbb, 0xbb, 0xbb),
];

impl Default for Timings {
    fn default() -> Self {
        Timings { begun: Instant::now(), rows: BTreeMap::new() }
    }
}

impl Timings {
    /// Takes in what the last frame of the window took on the device.
    pub fn note_window(&mut self, timings: &[Timing]) {
        let all: f32 = timings.iter().map(|timing| 1e3 * timing.duration.as_secs_f32()).sum();
        if all > 0.0 {
            self.add("window", true, all);
        }
    }

    /// Takes in what the engine tells.
    pub fn note(&mut self, status: &Status) {
        for (name, milliseconds) in &status.timings {
            self.add(name, false, *milliseconds);
        }
        for (name, milliseconds) in &status.passes {
            self.add(name, true, *milliseconds);
        }
    }

    /// Another world takes other times.
    pub fn clear(&mut self) {
        self.rows.clear();
    }

    fn add(&mut self, name: &'static str, on_device: bool, milliseconds: f32) {
        let now = self.begun.elapsed().as_secs_f64();
        let row = self.rows.entry(name).or_insert_with(|| Row { on_device, points: VecDeque::new() });
        row.points.push_back([now, milliseconds.into()]);
        while row.points.len() > MOST_POINTS {
            row.points.pop_front();
        }
    }

    pub fn show(&self, ui: &mut Ui, status: &Status) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (on_device, title) in [(false, "Work, ms"), (true, "Passes on the device, ms")] {
                self.table(ui, on_device, title);
                self.graph(ui, on_device);
            }
            ui.add_space(8.0);
            memory(ui, status);
        });
    }

    fn colour(&self, name: &str) -> Color32 {
        let of = self.rows.get(name).map(|row| row.on_device);
        let alike = self.rows.iter().filter(|(_, row)| Some(row.on_device) == of);
        let index = alike.map(|(other, _)| *other).position(|other| other == name).unwrap_or(0);
        let colour = COLOURS[index % COLOURS.len()];
        // From then on they are paler.
        (0..index / COLOURS.len()).fold(colour, |colour, _| colour.lerp_to_gamma(Color32::WHITE, 0.5))
    }

    fn table(&self, ui: &mut Ui, on_device: bool, title: &str) {
        let rows: Vec<_> = self.rows.iter().filter(|(_, row)| row.on_device == on_device).collect();
        if rows.is_empty() {
            return;
        }
        ui.strong(title);
        Grid::new(title).num_columns(2).striped(true).show(ui, |ui| {
            for (name, row) in rows {
                let last = row.points.back().map_or(0.0, |point| point[1]);
                ui.label(RichText::new(*name).color(self.colour(name)));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.monospace(format!("{last:.1}"));
                });
                ui.end_row();
            }
        });
        ui.add_space(6.0);
    }

    fn graph(&self, ui: &mut Ui, on_device: bool) {
        let rows = || self.rows.iter().filter(|(_, row)| row.on_device == on_device);
        if rows().next().is_none() {
            return;
        }
        let now = self.begun.elapsed().as_secs_f64();
        Plot::new(("timings", on_device))
            .height(120.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .show_x(false)
            .include_x(-PAST)
            .include_x(0.0)
            .include_y(0.0)
            .set_margin_fraction(egui::vec2(0.0, 0.05))
            .show_axes([false, true])
            .y_axis_label("ms")
            .show(ui, |plot| {
                for (name, row) in rows() {
                    let points: PlotPoints = row
                        .points
                        .iter()
                        .filter(|point| now - point[0] <= PAST)
                        .map(|[time, milliseconds]| [time - now, *milliseconds])
                        .collect();
                    plot.line(Line::new("", points).color(self.colour(name)));
                }
            });
        ui.weak(format!("the last {PAST:.0} s"));
        ui.add_space(6.0);
    }
}

fn memory(ui: &mut Ui, status: &Status) {
    let mebibytes = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    ui.strong("Device memory, MiB");
    let usage = &status.memory;
    Grid::new("memory").num_columns(2).striped(true).show(ui, |ui| {
        let mut names: Vec<_> = usage.by_name.iter().collect();
        names.sort_by_key(|(_, bytes)| std::cmp::Reverse(**bytes));
        for (name, bytes) in names.iter().take(14) {
            ui.label(name.as_str());
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.monospace(mebibytes(**bytes));
            });
            ui.end_row();
        }
        ui.strong("all");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.monospace(mebibytes(usage.used));
        });
        ui.end_row();
    });
    if status.plants > 0 {
        ui.add_space(6.0);
        ui.label(format!("{} plants, {} triangles if all were kept", status.plants, status.triangles));
    }
}
