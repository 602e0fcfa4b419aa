//! Keys of one line: numbers, switches, words, colours, files and texts.

use super::{Entry, Panel, number};
use crate::core::color::srgb8_from_linear;
use crate::world::schema::{Shape, Unit, digits, paragraph};
use crate::world::{Edit, KeyPath};
use egui::text::LayoutJob;
use egui::{
    Button, Color32, ComboBox, DragValue, FontSelection, Id, Key, Rect, Response, TextEdit, TextFormat,
    TextStyle, Ui,
};
use std::ops::RangeInclusive;
use toml_edit::{Array, Item, Value};

/// Width of an open list of words, points.
pub const POPUP: f32 = 250.0;

/// Whether a key's widget needs a line of its own.
pub fn is_wide(entry: &Entry) -> bool {
    match &entry.key.shape {
        Shape::Array(elements) => elements.len() > 2 && entry.item().is_some(),
        Shape::Text(_) => is_long(entry.item()),
        _ => false,
    }
}

fn is_long(item: Option<&Item>) -> bool {
    item.and_then(Item::as_str).is_some_and(|text| text.contains('\n') || text.len() > 24)
}

impl Panel<'_> {
    /// The widget of a key for which `item` counts, over all of the width.
    pub fn widget(&mut self, ui: &mut Ui, shape: &Shape, item: &Item, entry: &Entry) {
        let path = &entry.path;
        match shape {
            Shape::Number { .. } | Shape::Whole { .. } => {
                let default = entry.default.as_ref().and_then(number);
                let width = ui.available_width();
                if let Some(value) = number_field(ui, shape, item, default, width, path) {
                    self.set(path, value);
                }
            }
            Shape::Switch => {
                let mut on = item.as_bool().unwrap_or_default();
                let switch = ui.checkbox(&mut on, "");
                call(ui, &switch, path);
                if switch.changed() {
                    self.set(path, on.into());
                }
            }
            Shape::Colour => self.colour(ui, item, path),
            Shape::Choice(words) => self.choice(ui, words, item, path),
            Shape::File => {
                let name = item.as_str().unwrap_or_default();
                if let Some(file) = self.file(ui, path, name, "a file") {
                    self.set(path, file.into());
                }
            }
            Shape::Text(what) => {
                let text = item.as_str().unwrap_or_default();
                let long = is_long(Some(item)) && text.contains('\n');
                if let Some(text) = text_field(ui, path, text, what, long) {
                    self.set(path, text.into());
                }
            }
            Shape::Array(elements) => self.array(ui, elements, item, entry),
            Shape::OrWord(inner, word) => self.or_word(ui, inner, *word, item, entry),
            // These are sections.
            Shape::OneOf(_) | Shape::Table(_) | Shape::List { .. } | Shape::Named { .. } => {}
        }
    }

    /// A path to type, and a button that asks for a file.
    fn file(&mut self, ui: &mut Ui, path: &KeyPath, name: &str, hint: &str) -> Option<String> {
        const BUTTON: f32 = 20.0;
        if self.is_aside {
            return text_field(ui, path, name, hint, false);
        }
        let size = egui::vec2((ui.available_width() - BUTTON - 4.0).max(20.0), ui.spacing().interact_size.y);
        ui.spacing_mut().item_spacing.x = 4.0;
        let field = ui.allocate_ui(size, |ui| text_field(ui, path, name, hint, false));
        ui.spacing_mut().button_padding.x = 2.0;
        let button = Button::new("…").min_size(egui::vec2(BUTTON, 0.0));
        let button = ui.add(button).on_hover_text("Choose a file");
        call(ui, &button, format!("choose {path}"));
        if button.clicked() {
            self.browse = Some(path.clone());
        }
        field.inner
    }

    fn set(&mut self, path: &KeyPath, value: Value) {
        self.edits.push(Edit::Set(path.clone(), value));
    }

    /// A value or a word: for a file or a text that is an empty field, for others a button beside the value.
    fn or_word(&mut self, ui: &mut Ui, inner: &Shape, [word, about]: [&str; 2], item: &Item, entry: &Entry) {
        let is_word = item.as_str() == Some(word);
        let text = item.as_str().filter(|_| !is_word).unwrap_or_default();
        let typed = match inner {
            Shape::File => Some(self.file(ui, &entry.path, text, word)),
            Shape::Text(_) => Some(text_field(ui, &entry.path, text, word, false)),
            _ => None,
        };
        if let Some(typed) = typed {
            if let Some(typed) = typed {
                let typed = if typed.is_empty() { word } else { &typed };
                self.set(&entry.path, typed.into());
            }
            return;
        }
        let button = ui.selectable_label(is_word, word).on_hover_text(about);
        call(ui, &button, format!("{} {word}", entry.path));
        match (is_word, button.clicked()) {
            (true, true) => self.start(entry),
            (false, true) => self.set(&entry.path, word.into()),
            (true, false) => {}
            (false, false) => self.widget(ui, inner, item, entry),
        }
    }

    /// Fields side by side.
    fn array(&mut self, ui: &mut Ui, elements: &[Shape], item: &Item, entry: &Entry) {
        let gap = 3.0;
        let count = elements.len().max(1) as f32;
        let width = ((ui.available_width() - gap * (count - 1.0)) / count).max(10.0);
        ui.spacing_mut().item_spacing.x = gap;
        for (index, element) in elements.iter().enumerate() {
            let Some(inner) = item.get(index) else { continue };
            let default = entry.default.as_ref().and_then(|default| number(default.get(index)?));
            let path = entry.path.join(index);
            let field = ui.push_id(index, |ui| number_field(ui, element, inner, default, width, &path));
            let Some(value) = field.inner else { continue };
            if entry.written.is_some() {
                self.set(&path, value);
            } else {
                let values = (0..elements.len()).filter_map(|index| item.get(index)?.as_value().cloned());
                let mut array: Array = values.collect();
                array.replace(index, value);
                self.set(&entry.path, array.into());
            }
        }
    }

    fn choice(&mut self, ui: &mut Ui, words: &[[&str; 2]], item: &Item, path: &KeyPath) {
        let current = item.as_str().unwrap_or_default();
        let width = ui.available_width();
        let about = words.iter().find(|[word, _]| *word == current).map_or("", |[_, about]| about);
        let combo = ComboBox::from_id_salt("choice").width(width).selected_text(current).truncate();
        let chosen = combo.show_ui(ui, |ui| choices(ui, words, current));
        call(ui, &chosen.response, path);
        if !about.is_empty() {
            chosen.response.on_hover_text(paragraph(about));
        }
        if let Some(word) = chosen.inner.flatten().filter(|word| *word != current) {
            self.set(path, word.into());
        }
    }

    fn colour(&mut self, ui: &mut Ui, item: &Item, path: &KeyPath) {
        let Some(current) = colour(item) else { return };
        let mut chosen = current;
        let button = ui.color_edit_button_srgb(&mut chosen);
        call(ui, &button, format!("colour {path}"));
        let text = hex(current);
        let typed = text_field(ui, path, &text, "#rrggbb", false);
        if chosen != current {
            self.set(path, hex(chosen).into());
        } else if let Some(typed) = typed {
            self.set(path, typed.into());
        }
    }
}

/// Gives a widget the name of its key, by which screen readers and scripts know it.
pub fn call(ui: &Ui, response: &Response, name: impl ToString) {
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name.to_string()));
}

/// Words, each with its meaning, in an open list; returns the one that was clicked.
pub fn choices<'a>(ui: &mut Ui, words: &[[&'a str; 2]], current: &str) -> Option<&'a str> {
    ui.set_width(POPUP);
    let mut chosen = None;
    for [word, about] in words {
        if ui.add(Button::selectable(*word == current, explained(ui, word, about)).wrap()).clicked() {
            chosen = Some(*word);
        }
    }
    chosen
}

/// A word, and its meaning below in small letters.
pub fn explained(ui: &Ui, word: &str, about: &str) -> LayoutJob {
    let format = |style: TextStyle, color: Color32| {
        TextFormat::simple(FontSelection::from(style).resolve(ui.style()), color)
    };
    let mut job = LayoutJob::default();
    job.append(word, 0.0, format(TextStyle::Body, ui.visuals().text_color()));
    if !about.is_empty() {
        let about = format!("\n{}", paragraph(about));
        job.append(&about, 0.0, format(TextStyle::Small, ui.visuals().weak_text_color()));
    }
    job
}

// Numbers ------------------------------------------------------------------------------------------------------------

/// A number that is dragged or typed, and a bar that shows where it lies in what is usual. Returns a new value.
fn number_field(
    ui: &mut Ui,
    shape: &Shape,
    item: &Item,
    default: Option<f64>,
    width: f32,
    path: &KeyPath,
) -> Option<Value> {
    let current = number(item)?;
    let (range, usual, unit) = match shape {
        Shape::Number { unit, range: [least, most], usual } => (*least..=*most, *usual, suffix(unit)),
        Shape::Whole { range: [least, most] } => (*least as f64..=*most as f64, None, String::new()),
        _ => return None,
    };
    let is_whole = matches!(shape, Shape::Whole { .. });
    let scale = Scale::new(&range, usual, default, is_whole);
    let mut value = current;
    let field = DragValue::new(&mut value)
        .range(range)
        .clamp_existing_to_range(false)
        .update_while_editing(false)
        .speed(scale.speed(current, width, is_whole))
        .custom_formatter(|value, _| shown(value))
        .custom_parser(|text| text.trim().replace(['_', ','], "").parse().ok())
        .suffix(unit);
    let height = ui.spacing().interact_size.y;
    ui.spacing_mut().interact_size.x = width;
    let response = ui.add_sized([width, height], field);
    call(ui, &response, path);
    if !response.has_focus() {
        scale.paint(ui, current, response.rect);
    }
    let value = if is_whole { value.round() } else { rounded(value) };
    (response.changed() && value != current).then(|| written(value)).flatten()
}

/// What a drag over the whole width of a field goes through.
enum Scale {
    Linear([f64; 2]),
    /// In equal ratios.
    Log([f64; 2]),
    /// Nothing is known: steps in proportion to the value.
    Open(f64),
}

impl Scale {
    /// What is usual, or all that is allowed, or some of it round the default where that is more than anybody wants.
    fn new(
        range: &RangeInclusive<f64>,
        usual: Option<[f64; 2]>,
        default: Option<f64>,
        is_whole: bool,
    ) -> Scale {
        /// The largest part of a range that is one of equal ratios, from least to most.
        const DECADES: f64 = 1e4;
        let (least, most) = (*range.start(), *range.end());
        if let Some([from, to]) = usual {
            return if from > 0.0 && to / from > 100.0 {
                Scale::Log([from, to])
            } else {
                Scale::Linear([from, to])
            };
        }
        let default = default.unwrap_or(0.0);
        let is_far = least >= 0.0 && default > 0.0 && most > 20.0 * default;
        if most - least <= 1000.0 && !is_far && !(least > 0.0 && most / least > 100.0) {
            return Scale::Linear([least, most]);
        }
        if is_whole && most - least > 1e6 {
            return Scale::Open(1.0);
        }
        if least > 0.0 && most / least <= DECADES {
            return Scale::Log([least, most]);
        }
        match default {
            0.0 => Scale::Open(1.0),
            _ if least > 0.0 && default / least > 3.0 => {
                Scale::Log([(default / 32.0).max(least), (default * 32.0).min(most)])
            }
            _ => Scale::Linear([least.max((-4.0 * default).min(0.0)), most.min((4.0 * default).max(0.0))]),
        }
    }

    /// Change of the value for each point.
    fn speed(&self, value: f64, width: f32, is_whole: bool) -> f64 {
        let width = f64::from(width.max(20.0));
        let speed = match self {
            Scale::Linear([from, to]) => (to - from).abs() / width,
            Scale::Log([from, to]) => value.abs().max(*from) * (to / from).ln() / width,
            Scale::Open(least) => 0.005 * value.abs().max(*least * 10.0),
        };
        if is_whole { speed.max(0.05) } else { speed.max(1e-15) }
    }

    /// Where a value lies, from 0 to 1.
    fn share(&self, value: f64) -> Option<f64> {
        let share = match self {
            Scale::Linear([from, to]) => (value - from) / (to - from),
            Scale::Log([from, to]) => (value.max(1e-300) / from).ln() / (to / from).ln(),
            Scale::Open(_) => return None,
        };
        share.is_finite().then_some(share.clamp(0.0, 1.0))
    }

    /// The bar along the lower edge of a field.
    fn paint(&self, ui: &Ui, value: f64, rect: Rect) {
        let Some(share) = self.share(value) else { return };
        let bar = Rect::from_min_max(egui::pos2(rect.left(), rect.bottom() - 2.0), rect.max);
        let filled = Rect::from_min_size(bar.min, egui::vec2(bar.width() * share as f32, bar.height()));
        let visuals = ui.visuals();
        ui.painter().rect_filled(bar, 1.0, visuals.extreme_bg_color);
        ui.painter().rect_filled(filled, 1.0, visuals.hyperlink_color.gamma_multiply(0.8));
    }
}

fn suffix(unit: &Unit) -> String {
    match unit.symbol {
        "" => String::new(),
        "degrees" => "°".into(),
        symbol => format!(" {symbol}"),
    }
}

/// A number as it is shown: seven digits at most.
fn shown(value: f64) -> String {
    digits(rounded(value))
}

/// Without what a drag leaves behind the digits that matter.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// A number as it is written in a file.
fn written(value: f64) -> Option<Value> {
    digits(value).parse().ok()
}

// Colours ------------------------------------------------------------------------------------------------------------

/// A colour as it is written, in sRGB.
fn colour(item: &Item) -> Option<[u8; 3]> {
    if let Some(text) = item.as_str() {
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6)?;
        let value = u32::from_str_radix(digits, 16).ok()?;
        return Some([16, 8, 0].map(|shift| (value >> shift) as u8));
    }
    let linear = [0, 1, 2].map(|index| item.get(index).and_then(number));
    let [Some(r), Some(g), Some(b)] = linear else { return None };
    Some([r, g, b].map(|linear| srgb8_from_linear(linear as f32, 0.5)))
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

// Text ---------------------------------------------------------------------------------------------------------------

/// A text that counts once Enter is pressed or another widget is looked at; Escape leaves it as it was. In a `long` one, Enter
/// begins a line.
pub fn text_field(ui: &mut Ui, path: &KeyPath, current: &str, hint: &str, long: bool) -> Option<String> {
    let id = Id::new(("text", path.to_string()));
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| current.into());
    let field = if long {
        TextEdit::multiline(&mut text).code_editor().desired_rows(current.lines().count().clamp(2, 14))
    } else {
        TextEdit::singleline(&mut text)
    };
    let field =
        field.id(id).desired_width(ui.available_width()).hint_text(egui::RichText::new(hint).italics());
    let response: Response = ui.add(field);
    call(ui, &response, path);
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return None;
    }
    ui.data_mut(|data| data.remove_temp::<String>(id));
    let escaped = ui.input(|input| input.key_pressed(Key::Escape));
    (response.lost_focus() && !escaped && text != current).then_some(text)
}
