//! Keys that have keys of their own: tables, one of several things, lists, tables of names. Each is a heading that folds.

use super::widgets::{POPUP, call, explained, text_field};
use super::{Entry, Panel, help, is_section, sign, title};
use crate::world::schema::{Alternative, Key, Names, REQUIRED, Shape, Table};
use crate::world::{Edit, KeyPath, array_len};
use egui::{
    Align, Button, ComboBox, Frame, Id, Layout, Margin, RichText, Sense, Stroke, Ui, WidgetInfo, WidgetType,
    vec2,
};
use toml_edit::{DocumentMut, InlineTable, Item, Value};

const INDENT: i8 = 10;
/// Elements of a list that are shown: nobody looks through more, and each takes time in every frame.
const MOST_SHOWN: usize = 200;

/// A list or a table of names, and where it stands.
struct Holder<'a> {
    element: &'a Shape,
    /// What a new element begins with, as TOML.
    start: &'a str,
    item: Option<&'a Item>,
    path: &'a KeyPath,
}

/// One of what it holds.
struct Element<'a> {
    name: &'a str,
    shape: &'a Shape,
    item: &'a Item,
    path: &'a KeyPath,
    /// How names are formed, where it has one of the user's.
    names: Option<Names>,
}

impl Panel<'_> {
    pub(super) fn section(&mut self, ui: &mut Ui, entry: &Entry) {
        let Entry { key, path, .. } = entry;
        let word = match &key.shape {
            Shape::OrWord(_, word) => Some(*word),
            _ => None,
        };
        let item = entry.item();
        let is_word = word.is_some_and(|[word, _]| item.and_then(Item::as_str) == Some(word));
        let shape = match &key.shape {
            Shape::OrWord(inner, _) => &**inner,
            shape => shape,
        };
        // Without a default in the file's language nothing is there yet.
        let absent = item.is_none();
        let again = !matches!(shape, Shape::Table(_)) || word.is_some();
        let again = again && self.begins_again(entry);
        let is_open = self.heading(ui, entry, !is_word && !absent, again, |panel, ui| {
            if again {
                sign(ui, path);
            }
            if resettable(entry) {
                panel.reset(ui, entry);
            }
            if absent {
                return panel.words(ui, entry);
            }
            if let Some(word) = word {
                panel.or_word_switch(ui, word, is_word, entry);
            }
            match shape {
                Shape::OneOf(alternatives) if !is_word => {
                    let width = ui.available_width();
                    panel.alternatives(ui, alternatives, item, path, width);
                }
                Shape::List { .. } | Shape::Named { .. } if !is_word => {
                    let names = |item: &Item| item.as_table_like().map(|table| table.len());
                    let len = item.and_then(|item| array_len(item).or_else(|| names(item)));
                    ui.weak(len.unwrap_or(0).to_string());
                }
                _ => {}
            }
        });
        self.draft(ui, shape, path, Edit::Set);
        if !is_open || is_word || absent {
            return;
        }
        // What is a default as a whole must be written as a whole before a part of it can change.
        let is_collection = matches!(shape, Shape::List { .. } | Shape::Named { .. });
        body(ui, |ui| match (&entry.written, &entry.default) {
            (None, Some(default)) if is_collection => {
                let changed =
                    self.aside(path, default, |panel, item| panel.inside(ui, shape, Some(item), path));
                if let Some(Ok(value)) = changed.map(Item::into_value) {
                    self.edits.push(Edit::Set(path.clone(), value));
                }
            }
            (written, _) => self.inside(ui, shape, *written, path),
        });
    }

    /// What a section shows when it is open.
    fn inside(&mut self, ui: &mut Ui, shape: &Shape, item: Option<&Item>, path: &KeyPath) {
        match shape {
            Shape::Table(table) => self.table(ui, table, item, path),
            Shape::OneOf(alternatives) => {
                let Some(current) = current(alternatives, item) else { return };
                if let Some(table) = &current.table {
                    let item = item.and_then(|item| item.get(current.name));
                    ui.push_id(current.name, |ui| self.table(ui, table, item, &path.join(current.name)));
                }
            }
            Shape::OrWord(inner, _) => self.inside(ui, inner, item, path),
            Shape::List { element, len, start } => {
                self.list(ui, &Holder { element, start, item, path }, *len);
            }
            Shape::Named { names, element, start } => {
                self.names(ui, &Holder { element, start, item, path }, *names);
            }
            _ => {}
        }
    }

    // Headings -------------------------------------------------------------------------------------------------------

    /// The heading of a key that has keys of its own; says whether these are to be shown.
    fn heading(
        &mut self,
        ui: &mut Ui,
        entry: &Entry,
        can_open: bool,
        again: bool,
        right: impl FnOnce(&mut Self, &mut Ui),
    ) -> bool {
        let forced = !self.words.is_empty() && self.leads_into(&entry.key.shape, &entry.path.to_string());
        let name = title(entry.key.name);
        let side = match &entry.key.shape {
            Shape::Table(_) => 0.0,
            Shape::OneOf(_) => 130.0,
            _ => 70.0,
        };
        let side = if entry.item().is_none() { 130.0 } else { side };
        let side = if again { side + 18.0 } else { side };
        let strong = entry.written.is_some();
        let fold = Fold { name: &name, strong, can_open, forced, side };
        fold.show(ui, entry.path.to_string(), |ui| right(self, ui), |ui| help::of_key(ui, entry.key))
    }

    /// Switches between a word, "none" as a rule, and what may stand in its place.
    fn or_word_switch(&mut self, ui: &mut Ui, [word, about]: [&str; 2], is_word: bool, entry: &Entry) {
        let mut on = !is_word;
        let text = if is_word { RichText::new(word).weak() } else { RichText::new("") };
        let switch = ui.checkbox(&mut on, text);
        call(ui, &switch, format!("switch {}", entry.path));
        let hover = if is_word { about.to_string() } else { format!("\"{word}\": {about}") };
        if !switch.on_hover_text(hover).changed() {
            return;
        }
        let default_is_word = entry.default.as_ref().and_then(Item::as_str) == Some(word);
        match (on, default_is_word) {
            // The default says it.
            (true, false) if entry.default.is_some() => self.edits.push(Edit::Remove(entry.path.clone())),
            (true, _) => self.start(entry),
            (false, _) => self.edits.push(Edit::Set(entry.path.clone(), word.into())),
        }
    }

    /// The choice between several things.
    fn alternatives(
        &mut self,
        ui: &mut Ui,
        alternatives: &[Alternative],
        item: Option<&Item>,
        path: &KeyPath,
        width: f32,
    ) {
        let Some(current) = current(alternatives, item) else { return };
        let combo = ComboBox::from_id_salt("kind").width(width).selected_text(title(current.name)).truncate();
        let chosen = combo.show_ui(ui, |ui| {
            ui.set_width(POPUP);
            let mut chosen = None;
            for other in alternatives {
                let text = explained(ui, &title(other.name), first_sentence(other.about));
                if ui.add(Button::selectable(other.name == current.name, text).wrap()).clicked() {
                    chosen = Some(other);
                }
            }
            chosen
        });
        call(ui, &chosen.response, format!("kind of {path}"));
        chosen.response.on_hover_ui(|ui| help::of_alternative(ui, current));
        let Some(chosen) = chosen.inner.flatten().filter(|chosen| chosen.name != current.name) else {
            return;
        };
        match &chosen.table {
            Some(table) if asks(table) => begin_draft(ui, path, tagged(chosen.name)),
            Some(_) => self.edits.push(Edit::Set(path.clone(), tagged(chosen.name))),
            None => self.edits.push(Edit::Set(path.clone(), chosen.name.into())),
        }
    }

    // Lists and names ------------------------------------------------------------------------------------------------

    fn list(&mut self, ui: &mut Ui, holder: &Holder, [least, most]: [usize; 2]) {
        let len = holder.item.and_then(array_len).unwrap_or(0);
        for index in 0..len.min(MOST_SHOWN) {
            let Some(item) = holder.item.and_then(|item| item.get(index)) else { continue };
            let path = holder.path.join(index);
            let buttons = |panel: &mut Self, ui: &mut Ui| {
                let list = holder.path.clone();
                if len > least && icon(ui, "×", "remove", &path) {
                    panel.edits.push(Edit::Remove(list.join(index)));
                }
                if index + 1 < len && icon(ui, "⏷", "move down", &path) {
                    panel.edits.push(Edit::Move { list: list.clone(), from: index, to: index + 1 });
                }
                if index > 0 && icon(ui, "⏶", "move up", &path) {
                    panel.edits.push(Edit::Move { list, from: index, to: index - 1 });
                }
            };
            ui.push_id(index, |ui| {
                let (name, shape) = (&summary_with(index, item), holder.element);
                self.element(ui, &Element { name, shape, item, path: &path, names: None }, buttons);
                self.refusal(ui, &path);
            });
        }
        if len > MOST_SHOWN {
            ui.weak(format!("and {} more in the file", len - MOST_SHOWN));
        }
        let new = holder.path.join(len);
        if len < most && !has_draft(ui, &new) && add(ui, holder.path) {
            self.begin(ui, holder, &new, Edit::Insert);
        }
        self.draft(ui, holder.element, &new, Edit::Insert);
        self.refusal(ui, &new);
    }

    fn names(&mut self, ui: &mut Ui, holder: &Holder, names: Names) {
        let entries = holder.item.and_then(Item::as_table_like).into_iter().flat_map(|table| table.iter());
        for (name, item) in entries {
            let path = holder.path.join(name);
            let buttons = |panel: &mut Self, ui: &mut Ui| {
                if icon(ui, "×", "remove", &path) {
                    panel.edits.push(Edit::Remove(path.clone()));
                }
            };
            ui.push_id(name, |ui| {
                let shape = holder.element;
                self.element(ui, &Element { name, shape, item, path: &path, names: Some(names) }, buttons);
                self.refusal(ui, &path);
            });
        }
        ui.horizontal(|ui| {
            let place = holder.path.join("new name");
            ui.spacing_mut().item_spacing.x = 4.0;
            ui.label("+");
            let Some(name) = text_field(ui, &place, "", names.rule(), false) else { return };
            let taken = holder.item.and_then(|item| item.get(&name)).is_some();
            if names.allow(&name) && !taken {
                let named = holder.path.join(&name);
                ui.data_mut(|data| data.insert_temp(draft_id(holder.path), named.clone()));
                self.begin(ui, holder, &named, Edit::Set);
            }
        });
        let named = ui.data(|data| data.get_temp::<KeyPath>(draft_id(holder.path)));
        if let Some(named) =
            named.filter(|named| holder.item.and_then(|item| item.get(named.last()?)).is_none())
        {
            if has_draft(ui, &named) {
                ui.strong(named.last().unwrap_or_default());
            }
            self.draft(ui, holder.element, &named, Edit::Set);
            self.refusal(ui, &named);
        }
    }

    /// An element with the buttons that move and remove it: a line, or a heading. One with a name of the user's can get another.
    fn element(&mut self, ui: &mut Ui, element: &Element, buttons: impl FnOnce(&mut Self, &mut Ui)) {
        let &Element { name, shape, item, path, names } = element;
        let key = |shape: &Shape| Key {
            name: "",
            about: "",
            default: String::new(),
            start: String::new(),
            shape: shape.clone(),
        };
        if !is_section(shape) {
            ui.horizontal(|ui| {
                let size = vec2((ui.available_width() - 66.0).max(30.0), ui.spacing().interact_size.y);
                ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                    let key = key(shape);
                    let entry = Entry { key: &key, path: path.clone(), written: Some(item), default: None };
                    self.widget(ui, shape, item, &entry);
                });
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| buttons(self, ui));
            });
            return;
        }
        let forced = !self.words.is_empty() && self.leads_into(shape, &path.to_string());
        let fold = Fold { name, strong: true, can_open: true, forced, side: 66.0 };
        if !fold.show(ui, path.to_string(), |ui| buttons(self, ui), |_| {}) {
            return;
        }
        body(ui, |ui| {
            if let Some(names) = names {
                ui.horizontal(|ui| {
                    ui.label("called");
                    let place = path.join("another name");
                    if let Some(other) =
                        text_field(ui, &place, name, names.rule(), false).filter(|name| names.allow(name))
                    {
                        self.edits.push(Edit::Rename(path.clone(), other));
                    }
                });
            }
            if let Shape::OneOf(alternatives) = shape {
                let width = ui.available_width();
                self.alternatives(ui, alternatives, Some(item), path, width);
                self.draft(ui, shape, path, Edit::Set);
            }
            self.inside(ui, shape, Some(item), path);
        });
    }

    // Drafts ---------------------------------------------------------------------------------------------------------

    /// A new element: at once, or as a draft if it needs more than it begins with.
    fn begin(&mut self, ui: &Ui, holder: &Holder, path: &KeyPath, edit: fn(KeyPath, Value) -> Edit) {
        let Ok(value) = holder.start.parse::<Value>() else { return };
        let item = Item::Value(value.clone());
        if needs(holder.element, &item) {
            begin_draft(ui, path, value)
        } else {
            self.edits.push(edit(path.clone(), value))
        }
    }

    /// What is being put together at `path` and makes no world yet, if anything is.
    fn draft(&mut self, ui: &mut Ui, shape: &Shape, path: &KeyPath, edit: fn(KeyPath, Value) -> Edit) {
        let id = draft_id(path);
        let Some(text) = ui.data(|data| data.get_temp::<String>(id)) else { return };
        let was_sent = ui.data_mut(|data| data.remove_temp::<bool>(id)).unwrap_or(false);
        if was_sent && self.refused.is_none_or(|refused| refused.path.as_ref() != Some(path)) {
            ui.data_mut(|data| data.remove_temp::<String>(id));
            return;
        }
        let Ok(value) = text.parse::<Value>() else { return };
        let item = Item::Value(value.clone());
        let frame = Frame::new()
            .stroke(Stroke::new(1.0, ui.visuals().hyperlink_color))
            .inner_margin(6)
            .corner_radius(3);
        frame.show(ui, |ui| {
            ui.set_width(ui.available_width());
            let words = std::mem::take(&mut self.words);
            let changed = self.aside(path, &item, |panel, item| {
                ui.push_id("draft", |ui| panel.draft_inside(ui, shape, item, path));
            });
            self.words = words;
            if let Some(Ok(value)) = changed.map(Item::into_value) {
                ui.data_mut(|data| data.insert_temp(id, value.to_string().trim().to_string()));
            }
            ui.horizontal(|ui| {
                if ui.button("Apply").clicked() {
                    self.edits.push(edit(path.clone(), value));
                    // Refused, it can be mended.
                    ui.data_mut(|data| data.insert_temp(id, true));
                }
                if ui.button("Cancel").clicked() {
                    ui.data_mut(|data| data.remove_temp::<String>(id));
                }
            });
        });
    }

    fn draft_inside(&mut self, ui: &mut Ui, shape: &Shape, item: &Item, path: &KeyPath) {
        if is_section(shape) {
            if let Shape::OneOf(alternatives) = shape {
                let width = ui.available_width();
                ui.push_id("draft of", |ui| self.alternatives(ui, alternatives, Some(item), path, width));
            }
            return self.inside(ui, shape, Some(item), path);
        }
        let key =
            Key { name: "", about: "", default: String::new(), start: String::new(), shape: shape.clone() };
        let entry = Entry { key: &key, path: path.clone(), written: Some(item), default: None };
        self.widget(ui, shape, item, &entry);
    }

    /// Shows an item that is not in the file, and applies to it what the user changes in it. Returns it if that was anything.
    fn aside(&mut self, path: &KeyPath, item: &Item, show: impl FnOnce(&mut Self, &Item)) -> Option<Item> {
        const HERE: &str = "item";
        let others = std::mem::take(&mut self.edits);
        let was_aside = std::mem::replace(&mut self.is_aside, true);
        show(self, item);
        self.is_aside = was_aside;
        let edits = std::mem::replace(&mut self.edits, others);
        if edits.is_empty() {
            return None;
        }
        let mut document = DocumentMut::new();
        document.insert(HERE, item.clone());
        for edit in edits {
            let inner = |path_inside: &KeyPath| {
                path_inside.0.iter().skip(path.0.len()).fold(KeyPath::from(HERE), |path, key| path.join(key))
            };
            let edit = match edit {
                Edit::Set(path, value) => Edit::Set(inner(&path), value),
                Edit::Remove(path) => Edit::Remove(inner(&path)),
                Edit::Insert(path, value) => Edit::Insert(inner(&path), value),
                Edit::Move { list, from, to } => Edit::Move { list: inner(&list), from, to },
                Edit::Rename(path, name) => Edit::Rename(inner(&path), name),
            };
            // What was shown can be changed.
            let _ = edit.apply(&mut document);
        }
        document.remove(HERE)
    }
}

// Pieces -------------------------------------------------------------------------------------------------------------

/// A line that opens and closes what stands below it.
struct Fold<'a> {
    name: &'a str,
    strong: bool,
    /// Whether there is anything below it.
    can_open: bool,
    /// Open, since the filter leads inside.
    forced: bool,
    /// Width of what stands at its right end.
    side: f32,
}

impl Fold<'_> {
    fn show(
        &self,
        ui: &mut Ui,
        path: String,
        right: impl FnOnce(&mut Ui),
        hover: impl FnOnce(&mut Ui),
    ) -> bool {
        let id = Id::new(("fold", &path));
        let was_open = ui.data(|data| data.get_temp::<bool>(id)).unwrap_or(false);
        let is_open = self.can_open && (self.forced || was_open);
        let height = ui.spacing().interact_size.y + 2.0;
        ui.horizontal(|ui| {
            let width = (ui.available_width() - self.side - ui.spacing().item_spacing.x).max(40.0);
            let (rect, response) = ui.allocate_exact_size(vec2(width, height), Sense::click());
            response.widget_info(|| WidgetInfo::selected(WidgetType::CollapsingHeader, true, is_open, &path));
            self.paint(ui, rect, &response, is_open);
            if response.on_hover_ui(hover).clicked() {
                ui.data_mut(|data| data.insert_temp(id, !is_open));
            }
            ui.with_layout(Layout::right_to_left(Align::Center), right);
        });
        is_open
    }

    fn paint(&self, ui: &mut Ui, rect: egui::Rect, response: &egui::Response, is_open: bool) {
        let visuals = ui.visuals().clone();
        if response.has_focus() || response.hovered() {
            ui.painter().rect_filled(rect, 3.0, visuals.faint_bg_color);
        }
        if response.has_focus() {
            let stroke = Stroke::new(1.0, visuals.hyperlink_color);
            ui.painter().rect_stroke(rect, 3.0, stroke, egui::StrokeKind::Inside);
        }
        if self.can_open {
            let icon = egui::Rect::from_center_size(rect.left_center() + vec2(7.0, 0.0), vec2(8.0, 8.0));
            let icon = response.clone().with_new_rect(icon);
            egui::collapsing_header::paint_default_icon(ui, if is_open { 1.0 } else { 0.0 }, &icon);
        }
        let color = if self.strong { visuals.strong_text_color() } else { visuals.weak_text_color() };
        let text = egui::WidgetText::from(RichText::new(self.name).color(color));
        let width = rect.width() - 18.0;
        let galley = text.into_galley(ui, Some(egui::TextWrapMode::Truncate), width, egui::TextStyle::Body);
        let place = rect.left_center() + vec2(16.0, -galley.size().y / 2.0);
        ui.painter().galley(place, galley, color);
    }
}

/// What is inside a section, with a line at its left.
fn body(ui: &mut Ui, show: impl FnOnce(&mut Ui)) {
    let frame = Frame::new().inner_margin(Margin { left: INDENT, ..Margin::ZERO });
    let rect = frame.show(ui, show).response.rect;
    let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
    ui.painter().vline(rect.left() + 4.5, rect.y_range(), stroke);
}

/// A small button that does something to the element at `path`.
fn icon(ui: &mut Ui, text: &str, what: &str, path: &KeyPath) -> bool {
    let text = RichText::new(text).color(ui.visuals().weak_text_color());
    let button = Button::new(text).frame(false).min_size(vec2(16.0, 16.0));
    ui.spacing_mut().button_padding.x = 0.0;
    let name = format!("{what} {path}");
    let button = ui.add(button).on_hover_text(&name);
    call(ui, &button, name);
    button.clicked()
}

fn add(ui: &mut Ui, path: &KeyPath) -> bool {
    let button = ui.add(Button::new("+ Add").small());
    call(ui, &button, format!("add to {path}"));
    button.clicked()
}

/// Whether a click takes a whole section back: not where that would be to lose all of it.
fn resettable(entry: &Entry) -> bool {
    let is_table = matches!(entry.key.shape, Shape::Table(_) | Shape::OrWord(..));
    let is_empty = ["{}", "[]", REQUIRED].contains(&entry.key.default.as_str());
    entry.written.is_some() && !is_table && !is_empty
}

/// The alternative that an item is; the first without one.
fn current<'a>(alternatives: &'a [Alternative], item: Option<&Item>) -> Option<&'a Alternative> {
    let Some(item) = item else { return alternatives.first() };
    let tag = |table: &dyn toml_edit::TableLike| table.iter().next().map(|(name, _)| name.to_string());
    let name = item.as_str().map(String::from).or_else(|| tag(item.as_table_like()?))?;
    alternatives.iter().find(|alternative| alternative.name == name)
}

/// `{ name = {} }`.
fn tagged(name: &str) -> Value {
    let mut table = InlineTable::new();
    table.insert(name, InlineTable::new().into());
    table.into()
}

fn summary_with(index: usize, item: &Item) -> String {
    format!("{index}  {}", summary(item))
}

/// What an element of a list is, in a word or two.
fn summary(item: &Item) -> String {
    let Some(table) = item.as_table_like() else {
        let numbers =
            (0..array_len(item).unwrap_or(0)).filter_map(|index| Some(item.get(index)?.to_string()));
        return numbers.map(|number| number.trim().to_string()).collect::<Vec<_>>().join(", ");
    };
    let Some((name, first)) = table.iter().next() else { return String::new() };
    match first.as_table_like() {
        Some(inner) => {
            let of = inner.iter().find_map(|(_, item)| texts(item));
            of.map_or_else(|| title(name), |of| format!("{}: {of}", title(name)))
        }
        None => texts(first).unwrap_or_else(|| format!("{} {}", title(name), first.to_string().trim())),
    }
}

/// A text, or several, as in `species = ["oak", "beech"]`.
fn texts(item: &Item) -> Option<String> {
    let several = || {
        let array = item.as_array()?;
        let texts: Vec<&str> = array.iter().filter_map(Value::as_str).collect();
        (!texts.is_empty()).then(|| texts.join(", "))
    };
    item.as_str().map(String::from).or_else(several)
}

fn first_sentence(about: &str) -> &str {
    about.split_once(". ").or_else(|| about.split_once(".\n")).map_or(about, |(first, _)| first)
}

// What a draft is for ------------------------------------------------------------------------------------------------

fn draft_id(path: &KeyPath) -> Id {
    Id::new(("draft", path.to_string()))
}

fn has_draft(ui: &Ui, path: &KeyPath) -> bool {
    ui.data(|data| data.get_temp::<String>(draft_id(path))).is_some()
}

fn begin_draft(ui: &Ui, path: &KeyPath, value: Value) {
    ui.data_mut(|data| data.insert_temp(draft_id(path), value.to_string().trim().to_string()));
}

/// Whether a table has keys that must be written.
fn asks(table: &Table) -> bool {
    table.keys.iter().any(|key| key.default.starts_with(REQUIRED))
}

/// Whether an item makes no world before more is written in it.
fn needs(shape: &Shape, item: &Item) -> bool {
    match shape {
        Shape::Table(table) => asks(table),
        Shape::OneOf(alternatives) => {
            current(alternatives, Some(item)).is_some_and(|other| other.table.as_ref().is_some_and(asks))
        }
        Shape::Text(_) | Shape::File => item.as_str() == Some(""),
        Shape::OrWord(inner, _) => needs(inner, item),
        _ => false,
    }
}

#[cfg(test)]
pub(super) fn summary_of(text: &str) -> Option<String> {
    crate::world::schema::parse_item(text).map(|item| summary(&item))
}
