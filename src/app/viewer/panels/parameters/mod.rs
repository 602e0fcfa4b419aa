//! Every key of the world as a widget, made from the declarations of the keys and from nothing else: a new key needs no work here.

mod foresight;
mod help;
mod sections;
#[cfg(test)]
mod tests;
mod widgets;

pub use foresight::Foresight;
pub use widgets::call;

use super::super::document::{Document, Refusal};
use crate::world::schema::{Key, REQUIRED, Shape, Table, parse_item};
use crate::world::{self, Edit, KeyPath};
use egui::{Align, Label, Layout, RichText, Sense, Ui, Vec2, vec2};
use std::sync::LazyLock;
use toml_edit::{DocumentMut, Item};

/// Width of what stands behind a widget: the button that resets it.
const RESET_WIDTH: f32 = 16.0;

/// What the user wants of the world.
#[derive(Default)]
pub struct Wishes {
    pub edits: Vec<Edit>,
    /// A key whose file is to be chosen in a dialog.
    pub browse: Option<KeyPath>,
}

static SHAPE: LazyLock<Table> = LazyLock::new(world::shape);

/// Shows the keys of the world that the words of `filter` lead to, all without any.
pub fn show(ui: &mut Ui, document: &Document, foresight: &mut Foresight, filter: &str) -> Wishes {
    let mut panel = Panel { foresight: Some(foresight), ..Panel::of(document) };
    panel.words = filter.split_whitespace().map(str::to_lowercase).collect();
    let top = KeyPath::default();
    if !panel.words.is_empty() && !SHAPE.keys.iter().any(|key| panel.leads_to(key, "")) {
        ui.add(Label::new(RichText::new("No key has these words in its name or meaning.").weak()));
    }
    panel.table(ui, &SHAPE, Some(document.item()), &top);
    Wishes { edits: panel.edits, browse: panel.browse }
}

/// Keys that an endless zoom does not heed.
const OF_LAND: &[&str] =
    &["controls", "terrain", "erosion", "reef", "sea", "surface", "species", "models", "plants"];

/// Shows some keys of a section by themselves.
pub fn rows(ui: &mut Ui, document: &Document, section: &str, names: &[&str]) -> Wishes {
    let mut panel = Panel::of(document);
    let shape = SHAPE.keys.iter().find(|key| key.name == section).map(|key| &key.shape);
    if let Some(Shape::Table(table)) = shape {
        let rows = table.keys.iter().filter(|key| names.contains(&key.name)).cloned().collect();
        let table = Table { keys: rows, ..table.clone() };
        let item = document.item().get(section);
        panel.table(ui, &table, item, &KeyPath::from(section));
    }
    Wishes { edits: panel.edits, browse: panel.browse }
}

/// What is shown while it is shown.
struct Panel<'a> {
    /// All of them must be in a key's name or meaning; in small letters.
    words: Vec<String>,
    /// Keys of the world that mean nothing to it; they are shown if they are written.
    without: &'static [&'static str],
    /// The last edit, if it was refused.
    refused: Option<&'a Refusal>,
    edits: Vec<Edit>,
    browse: Option<KeyPath>,
    /// Whether what is shown is not in the file yet.
    is_aside: bool,
    /// Where it is told what begins the world again.
    foresight: Option<&'a mut Foresight>,
}

/// A key with what is written for it.
struct Entry<'a> {
    key: &'a Key,
    path: KeyPath,
    written: Option<&'a Item>,
    /// What stands for nothing written, where it is not told in words.
    default: Option<Item>,
}

impl Entry<'_> {
    /// What counts.
    fn item(&self) -> Option<&Item> {
        self.written.or(self.default.as_ref())
    }

    fn differs(&self) -> bool {
        match (self.written, &self.default) {
            (Some(written), Some(default)) => !same(written, default),
            (written, _) => written.is_some(),
        }
    }
}

impl<'a> Panel<'a> {
    fn of(document: &'a Document) -> Panel<'a> {
        Panel {
            words: Vec::new(),
            without: if document.world().zoom.is_some() { OF_LAND } else { &[] },
            refused: document.refused(),
            edits: Vec::new(),
            browse: None,
            is_aside: false,
            foresight: None,
        }
    }
}

impl Panel<'_> {
    /// The keys of a table: first those of one line, then those that have keys of their own.
    fn table(&mut self, ui: &mut Ui, table: &Table, item: Option<&Item>, path: &KeyPath) {
        let preset = self.presets(ui, table, item, path);
        let (sections, rows): (Vec<&Key>, Vec<&Key>) =
            table.keys.iter().partition(|key| is_section(&key.shape));
        for key in rows.into_iter().chain(sections) {
            let is_written = item.is_some_and(|item| item.get(key.name).is_some());
            let is_idle = *path == KeyPath::default() && self.without.contains(&key.name) && !is_written;
            if is_idle || is_fixed(&key.shape) || !self.leads_to(key, &path.to_string()) {
                continue;
            }
            let of_preset = preset.as_ref().and_then(|preset| preset.get(key.name));
            let entry = Entry {
                key,
                path: path.join(key.name),
                written: item.and_then(|item| item.get(key.name)),
                default: of_preset.cloned().or_else(|| parse_item(&key.default)),
            };
            ui.push_id(key.name, |ui| {
                if is_section(&key.shape) {
                    self.section(ui, &entry)
                } else {
                    self.row(ui, &entry)
                }
                self.refusal(ui, &entry.path);
            });
        }
    }

    /// The choice of a preset, if the table has some; returns its keys.
    fn presets(&mut self, ui: &mut Ui, table: &Table, item: Option<&Item>, path: &KeyPath) -> Option<Item> {
        let first = table.presets.first()?;
        let written = item.and_then(|item| item.get("preset"));
        let word = written.and_then(Item::as_str).unwrap_or(first.name);
        let preset = table.presets.iter().find(|preset| preset.name == word)?;
        let words = table.presets.iter().map(|preset| [preset.name, preset.about]).collect();
        let key = Key {
            name: "preset",
            about: "Values for several keys at once; what is written beside it wins.",
            default: format!("\"{}\"", first.name),
            start: String::new(),
            shape: Shape::Choice(words),
        };
        if self.leads_to(&key, &path.to_string()) {
            let default = parse_item(&key.default);
            let entry = Entry { key: &key, path: path.join("preset"), written, default };
            ui.push_id("preset", |ui| self.row(ui, &entry));
        }
        preset.keys.parse::<DocumentMut>().ok().map(DocumentMut::into_item)
    }

    /// A key of one line: name, widget, and a button that resets it.
    fn row(&mut self, ui: &mut Ui, entry: &Entry) {
        let wide = widgets::is_wide(entry);
        let height = ui.spacing().interact_size.y;
        let resettable = entry.written.is_some() && entry.key.default != REQUIRED;
        let again = self.begins_again(entry);
        ui.horizontal(|ui| {
            let all = ui.available_width();
            let gap = ui.spacing().item_spacing.x;
            let rest = if resettable { RESET_WIDTH + gap } else { 0.0 };
            let width = if wide { (all - rest - gap).max(30.0) } else { (0.43 * all).min(150.0) };
            name(ui, entry, again, vec2(width, height));
            if !wide {
                let size = vec2((all - width - RESET_WIDTH - 2.0 * gap).max(30.0), height);
                ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                    self.value(ui, entry);
                });
            }
            if resettable {
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| self.reset(ui, entry));
            }
        });
        if wide {
            ui.horizontal(|ui| {
                ui.add_space(10.0);
                self.value(ui, entry);
            });
        }
    }

    /// Whether another value of a key begins the world again.
    fn begins_again(&mut self, entry: &Entry) -> bool {
        match &mut self.foresight {
            Some(foresight) if !self.is_aside => foresight.begins_again(entry),
            _ => false,
        }
    }

    /// The widget of a key; weak where nothing is written.
    fn value(&mut self, ui: &mut Ui, entry: &Entry) {
        if entry.written.is_none() {
            ui.visuals_mut().override_text_color = Some(ui.visuals().weak_text_color());
        }
        match entry.item() {
            Some(item) => self.widget(ui, &entry.key.shape, item, entry),
            None => self.words(ui, entry),
        }
    }

    /// The default where it is told in words; a click writes a value.
    fn words(&mut self, ui: &mut Ui, entry: &Entry) {
        let text = RichText::new(&entry.key.default).italics();
        let button = egui::Button::new(text).frame(false).truncate();
        let hint =
            if entry.key.default == REQUIRED { "Click to write it." } else { "Click to write a value." };
        let button = ui.add(button).on_hover_ui(|ui| {
            ui.label(&entry.key.default);
            ui.weak(hint);
        });
        widgets::call(ui, &button, format!("write {}", entry.path));
        if button.clicked() {
            self.start(entry);
        }
    }

    /// Writes a key for which nothing is written.
    fn start(&mut self, entry: &Entry) {
        if let Ok(value) = entry.key.start.parse() {
            self.edits.push(Edit::Set(entry.path.clone(), value));
        }
    }

    fn reset(&mut self, ui: &mut Ui, entry: &Entry) {
        let text = RichText::new("⟲").color(ui.visuals().weak_text_color());
        let button = egui::Button::new(text).frame(false).min_size(vec2(RESET_WIDTH, 0.0));
        let hover = match entry.differs() {
            true => format!("Back to the default, {}", help::default(entry.key)),
            false => "It is written, and is the default: take it out of the file".into(),
        };
        let button = ui.add(button).on_hover_text(hover);
        widgets::call(ui, &button, format!("reset {}", entry.path));
        if button.clicked() {
            self.edits.push(Edit::Remove(entry.path.clone()));
        }
    }

    /// Why the last edit was refused, if it was one of this key.
    fn refusal(&self, ui: &mut Ui, path: &KeyPath) {
        let Some(refused) = self.refused.filter(|refused| refused.path.as_ref() == Some(path)) else {
            return;
        };
        let text = RichText::new(&refused.message).small().color(ui.visuals().error_fg_color);
        ui.add(Label::new(text).wrap()).on_hover_text(RichText::new(&refused.report).monospace());
    }

    // The filter -----------------------------------------------------------------------------------------------------

    /// Whether the filter lets a key, or one inside it, be shown. `place` is the path of its table.
    fn leads_to(&self, key: &Key, place: &str) -> bool {
        self.words.is_empty()
            || self.finds(key, place)
            || self.leads_into(&key.shape, &format!("{place} {}", key.name))
    }

    /// Whether the filter finds the key itself.
    fn finds(&self, key: &Key, place: &str) -> bool {
        let choices = match &key.shape {
            Shape::Choice(words) => words.iter().map(|[word, _]| *word).collect(),
            _ => Vec::new(),
        };
        let text = format!("{place} {} {} {}", key.name, key.about, choices.join(" ")).to_lowercase();
        self.words.iter().all(|word| text.contains(word))
    }

    /// Whether the filter finds a key inside a shape.
    fn leads_into(&self, shape: &Shape, place: &str) -> bool {
        match shape {
            Shape::Table(table) => table.keys.iter().any(|key| self.leads_to(key, place)),
            Shape::OrWord(inner, _) => self.leads_into(inner, place),
            Shape::List { element, .. } | Shape::Named { element, .. } => self.leads_into(element, place),
            Shape::OneOf(alternatives) => alternatives.iter().any(|other| {
                let place = format!("{place} {}", other.name);
                other
                    .table
                    .as_ref()
                    .is_some_and(|table| table.keys.iter().any(|key| self.leads_to(key, &place)))
            }),
            _ => false,
        }
    }
}

/// A key's name, brighter where it differs from its default, with all that is known of the key when the mouse is over it.
fn name(ui: &mut Ui, entry: &Entry, again: bool, size: Vec2) {
    let text = RichText::new(title(entry.key.name));
    let text = match (entry.written.is_some(), entry.differs()) {
        (_, true) => text.color(ui.visuals().strong_text_color()),
        (true, false) => text,
        (false, _) => text.color(ui.visuals().weak_text_color()),
    };
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(size.x);
        let (mark, _) = ui.allocate_exact_size(vec2(4.0, size.y), Sense::hover());
        if entry.differs() {
            ui.painter().circle_filled(mark.center(), 2.0, ui.visuals().hyperlink_color);
        }
        let label = |ui: &mut Ui| {
            ui.add(Label::new(text).truncate().selectable(false))
                .on_hover_ui(|ui| help::of_key(ui, entry.key));
        };
        if !again {
            return label(ui);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            sign(ui, &entry.path);
            ui.with_layout(Layout::left_to_right(Align::Center), label);
        });
    });
}

/// Beside keys that begin the world again.
pub const AGAIN: &str = "⏮";

/// Says that another value begins the world again.
fn sign(ui: &mut Ui, path: &KeyPath) {
    let text = RichText::new(AGAIN).small().color(ui.visuals().weak_text_color());
    let sign =
        ui.add(Label::new(text).selectable(false)).on_hover_text("Another value begins the world again.");
    call(ui, &sign, format!("{path} begins the world again"));
}

/// A key's name as people read it.
fn title(name: &str) -> String {
    name.replace('_', " ")
}

/// Whether a key has keys of its own, and is shown as a heading over them.
fn is_section(shape: &Shape) -> bool {
    match shape {
        Shape::Table(_) | Shape::List { .. } | Shape::Named { .. } => true,
        Shape::OneOf(alternatives) => alternatives.iter().any(|alternative| alternative.table.is_some()),
        Shape::OrWord(inner, _) => is_section(inner),
        _ => false,
    }
}

/// Whether there is nothing to choose: the version of the format.
fn is_fixed(shape: &Shape) -> bool {
    matches!(shape, Shape::Whole { range: [least, most] } if least == most)
}

/// Whether two items say the same, however they are spelled.
fn same(a: &Item, b: &Item) -> bool {
    if let (Some(a), Some(b)) = (number(a), number(b)) {
        return a == b;
    }
    match (world::array_len(a), world::array_len(b)) {
        (Some(len), Some(other)) => len == other && (0..len).all(|index| both(a.get(index), b.get(index))),
        (None, None) => match (a.as_table_like(), b.as_table_like()) {
            (Some(a), Some(b)) => {
                a.len() == b.len() && a.iter().all(|(key, item)| both(Some(item), b.get(key)))
            }
            (None, None) => (a.as_str(), a.as_bool()) == (b.as_str(), b.as_bool()),
            _ => false,
        },
        _ => false,
    }
}

fn both(a: Option<&Item>, b: Option<&Item>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if same(a, b))
}

fn number(item: &Item) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))
}
