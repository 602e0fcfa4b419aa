//! Where the time goes, and the memory.

use super::super::engine::Status;
use super::round_marks;
use crate::gpu::Timing;
use egui::{Color32, Grid, RichText, ScrollArea, Ui};
use egui_plot::{Line, Plot, Points};
use std::cmp::Reverse;
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
    /// How many there were when it came: its colour stays.
    index: usize,
    /// Milliseconds that were told last.
    last: f32,
    /// Seconds since the start, and milliseconds: the most of each slot.
    points: VecDeque<[f64; 2]>,
}

/// What is shown of the past, seconds.
const PAST: f64 = 30.0;

/// What one point of a line stands for, seconds.
const SLOT: f64 = 0.125;

/// Names that have a row of their own in the table of memory.
const MOST_NAMES: usize = 14;

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

impl Row {
    /// Takes in what was told at a time, in seconds. What is told once more is no news: reports come more often than what they
    /// tell of.
    fn add(&mut self, now: f64, milliseconds: f32) {
        if milliseconds.to_bits() == self.last.to_bits() {
            return;
        }
        self.last = milliseconds;
        let slot = |time: f64| (time / SLOT).floor();
        match self.points.back_mut() {
            Some([time, most]) if slot(*time) == slot(now) => *most = most.max(milliseconds.into()),
            _ => self.points.push_back([now, milliseconds.into()]),
        }
        while self.points.front().is_some_and(|[time, _]| now - time > PAST) {
            self.points.pop_front();
        }
    }

    /// What is to be seen of it: seconds from now on, and milliseconds.
    fn line(&self, now: f64) -> Vec<[f64; 2]> {
        let past = self.points.iter().filter(|[time, _]| now - time <= PAST);
        past.map(|[time, milliseconds]| [time - now, *milliseconds]).collect()
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
        let index = self.rows.values().filter(|row| row.on_device == on_device).count();
        let new = || Row { on_device, index, last: f32::NAN, points: VecDeque::new() };
        self.rows.entry(name).or_insert_with(new).add(now, milliseconds);
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
        let index = self.rows.get(name).map_or(0, |row| row.index);
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
                ui.label(RichText::new(*name).color(self.colour(name)));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.monospace(format!("{:.1}", row.last));
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
            .show_grid([false, true])
            .y_grid_spacer(round_marks)
            .show(ui, |plot| {
                for (name, row) in rows() {
                    let points = row.line(now);
                    // A line of one point could not be seen.
                    if let [point] = points[..] {
                        plot.points(Points::new("", vec![point]).radius(2.5).color(self.colour(name)));
                    } else {
                        plot.line(Line::new("", points).color(self.colour(name)));
                    }
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
    let mut names: Vec<(&str, u64)> =
        usage.by_name.iter().map(|(name, bytes)| (name.as_str(), *bytes)).collect();
    names.sort_by_key(|(_, bytes)| Reverse(*bytes));
    let others = names.split_off(names.len().min(MOST_NAMES));
    if !others.is_empty() {
        names.push(("others", others.iter().map(|(_, bytes)| bytes).sum()));
    }
    Grid::new("memory").num_columns(2).striped(true).show(ui, |ui| {
        let rows = names.into_iter().map(|(name, bytes)| (RichText::new(name), bytes));
        for (name, bytes) in rows.chain([(RichText::new("all").strong(), usage.used)]) {
            ui.label(name);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.monospace(mebibytes(bytes));
            });
            ui.end_row();
        }
    });
    if status.plants > 0 {
        ui.add_space(6.0);
        ui.label(format!("{} plants, {} triangles if all were kept", status.plants, status.triangles));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> Row {
        Row { on_device: true, index: 0, last: f32::NAN, points: VecDeque::new() }
    }

    #[test]
    fn a_line_goes_back_half_a_minute() {
        let mut row = row();
        for frame in 0..60 * 60 {
            // One frame takes long.
            let milliseconds = if frame == 60 * 45 { 20.0 } else { 1.0 + (frame % 2) as f32 };
            row.add(f64::from(frame) / 60.0, milliseconds);
        }
        let line = row.line(60.0);
        assert!((239..=241).contains(&line.len()), "{}", line.len());
        assert!(line.first().is_some_and(|[time, _]| (-30.0..-29.8).contains(time)));
        assert!(line.last().is_some_and(|[time, _]| *time > -0.2));
        assert!(line.iter().all(|[_, most]| [2.0, 20.0].contains(most)), "each has the most of its slot");
        assert_eq!(line.iter().filter(|[_, most]| *most == 20.0).count(), 1);
        assert!(row.line(95.0).is_empty());
    }

    #[test]
    fn what_is_told_again_is_no_news() {
        let mut row = row();
        (0..100).for_each(|report| row.add(f64::from(report), 16_000.0));
        assert_eq!(row.line(10.0), [[-10.0, 16_000.0]]);
        row.add(100.0, 4.0);
        assert_eq!((row.last, row.line(100.0)), (4.0, vec![[0.0, 4.0]]));
    }
}
