//! The page that explains keys and numbers.

use super::super::keys::{Group, TABLE};
use super::parameters::AGAIN;
use egui::{Align, Label, Layout, RichText, ScrollArea, Ui};

/// A number that the viewer shows, or a name of such.
struct Entry {
    name: &'static str,
    text: &'static str,
}

const fn entry(name: &'static str, text: &'static str) -> Entry {
    Entry { name, text }
}

/// What the numbers of the panels are.
const NUMBERS: &[(&str, &[Entry])] = &[
    (
        "Frame",
        &[
            entry(
                "work",
                "time from the beginning of a kind of work to its end, slices of other work between them",
            ),
            entry(
                "passes",
                "time that the device took for a pass of the last picture, between two time stamps",
            ),
            entry("window", "time that the device took to draw the panels and to show the window"),
            entry("memory", "device memory by name; the smallest together as others"),
        ],
    ),
    (
        "Simulation",
        &[
            entry("stage", "what happens now: base, settling, erosion, sea bed, reef"),
            entry("iteration", "of the stage, and how many it takes"),
            entry("a frame", "iterations between two pictures; fewer when a picture must not wait"),
            entry(
                AGAIN,
                "beside a key of the world: another value begins the land, or the flight, again; all others are taken as they are",
            ),
        ],
    ),
    (
        "Plants",
        &[
            entry("triangles", "of a plant in its finest level of detail, as path tracing sees it"),
            entry(
                "drawn with",
                "those of the level that the last picture shows, the coarser the farther away",
            ),
            entry("together", "if all plants of the kind were drawn in their finest level"),
            entry("if all were kept", "below the timings: triangles of all plants in their finest levels"),
        ],
    ),
    (
        "Path tracer",
        &[
            entry("samples", "paths for each pixel so far, and how many are asked for"),
            entry("noise", "error of a pixel's lightness that is still expected, as a share"),
            entry("left", "time until all samples are there, at the present speed"),
        ],
    ),
    (
        "Endless zoom",
        &[
            entry("depth", "octaves from the surface as a whole: each halves all lengths"),
            entry("altitude", "distance to the ground below, in cells of the coarsest lattice"),
            entry("slope", "of the ground below"),
            entry("location", "a code of the place, exact at any depth: to copy and to paste"),
            entry("tiles", "in the picture, of those around the eye; and those that were made for it"),
            entry(
                "levels",
                "of the coarsest and the finest tiles in the foreground: each has half the side of the one before",
            ),
            entry("triangles", "of the tiles in the picture, as they are sent to the device"),
        ],
    ),
];

/// Shows the page.
pub fn show(ui: &mut Ui) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.heading("Keys and mouse");
        for group in Group::ALL {
            table(
                ui,
                group.name(),
                TABLE.iter().filter(|row| row.group == group).map(|row| (row.keys(), row.text)),
            );
        }
        ui.add_space(8.0);
        ui.heading("Numbers");
        for (name, entries) in NUMBERS {
            table(ui, name, entries.iter().map(|entry| (entry.name.to_string(), entry.text)));
        }
    });
}

fn table(ui: &mut Ui, name: &str, rows: impl Iterator<Item = (String, &'static str)>) {
    ui.add_space(6.0);
    ui.label(RichText::new(name).strong());
    for (key, text) in rows {
        ui.horizontal_top(|ui| {
            let size = egui::vec2(120.0, ui.spacing().interact_size.y);
            ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Min), |ui| {
                ui.set_min_width(size.x);
                ui.add(Label::new(RichText::new(key).monospace().color(ui.visuals().hyperlink_color)));
            });
            ui.add(Label::new(text).wrap());
        });
    }
}

/// The tables as Markdown, for the manual.
#[cfg(test)]
fn markdown() -> String {
    let mut page = String::new();
    for group in Group::ALL {
        page += &format!("\n### {}\n\n| key | what it does |\n|---|---|\n", group.name());
        for row in TABLE.iter().filter(|row| row.group == group) {
            page += &format!("| {} | {} |\n", row.keys(), row.text);
        }
    }
    for (name, entries) in NUMBERS {
        page += &format!("\n### {name}\n\n| number | what it is |\n|---|---|\n");
        for entry in *entries {
            page += &format!("| {} | {} |\n", entry.name, entry.text);
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::markdown;
    use std::{env, fs, path::Path};

    #[test]
    fn the_manual_has_the_same_tables() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/viewer.md");
        let manual = fs::read_to_string(&path).expect("the manual");
        let (before, rest) = manual.split_once("<!-- keys -->").expect("where they begin");
        let (_, after) = rest.split_once("<!-- /keys -->").expect("where they end");
        let expected = format!("{before}<!-- keys -->\n{}\n<!-- /keys -->{after}", markdown());
        if env::var_os("TERRANE_BLESS").is_some() {
            fs::write(&path, &expected).expect("it can be written");
        }
        assert!(
            manual == expected || env::var_os("TERRANE_BLESS").is_some(),
            "TERRANE_BLESS=1 writes it anew"
        );
    }
}
