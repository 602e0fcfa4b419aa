//! Where things are in the window, by the names that a screen reader would tell: scripts find them by these, and so do tests.

use crate::formats;
use egui::accesskit::TreeUpdate;
use egui::{Context, Pos2, Rect};
use std::env;
use std::io::Write;
use std::path::PathBuf;

/// What is shown.
pub struct Widgets {
    found: Vec<(String, Rect)>,
    /// What of it can be seen.
    window: Rect,
    /// Where `TERRANE_WIDGETS` wants it told, in pixels: for tests, which have a mouse and no eyes.
    file: Option<PathBuf>,
    written: String,
}

impl Widgets {
    pub fn new(context: &Context) -> Widgets {
        context.enable_accesskit();
        Widgets { found: Vec::new(), window: Rect::NOTHING, file: file(), written: String::new() }
    }

    /// Whether they are to be told in a file.
    pub fn are_wanted() -> bool {
        file().is_some()
    }

    /// Takes in what a frame shows.
    pub fn note(&mut self, update: Option<&TreeUpdate>, window: Rect, pixels_per_point: f32) {
        let Some(update) = update else { return };
        self.window = window;
        self.found.clear();
        for (_, node) in &update.nodes {
            let names = [node.label(), node.value(), node.placeholder()];
            let name = names.into_iter().flatten().find(|name| !name.is_empty());
            if let (Some(name), Some(bounds)) = (name, node.bounds()) {
                let corner = |x: f64, y: f64| Pos2::new(x as f32, y as f32);
                let rect = Rect::from_min_max(corner(bounds.x0, bounds.y0), corner(bounds.x1, bounds.y1));
                self.found.push((name.into(), rect));
            }
        }
        self.tell(pixels_per_point);
    }

    /// The middle of the first one of this name that is in the window, points.
    pub fn find(&self, name: &str) -> Option<Pos2> {
        let named = self.found.iter().filter(|(known, _)| known == name);
        named.map(|(_, rect)| rect.center()).find(|middle| self.window.contains(*middle))
    }

    fn tell(&mut self, pixels_per_point: f32) {
        let Some(path) = &self.file else { return };
        let mut text = String::new();
        for (name, rect) in &self.found {
            let at = rect.center() * pixels_per_point;
            text += &format!("{:.0} {:.0} {}\n", at.x, at.y, name.replace('\n', " "));
        }
        if text != self.written {
            // A test that finds nothing fails.
            let _ = formats::file::replace_keeping(path, None, |out| out.write_all(text.as_bytes()));
            self.written = text;
        }
    }
}

fn file() -> Option<PathBuf> {
    env::var_os("TERRANE_WIDGETS").filter(|name| !name.is_empty()).map(PathBuf::from)
}
