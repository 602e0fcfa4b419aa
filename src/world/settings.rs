//! Edits of a world as a document: `--set section.key=value`, later the viewer's sliders. Comments stay.

use super::fault::{self, Complaint, Fault};
use super::place::{KeyPath, array_len, noun, shown};
use std::ops::Range;
use toml_edit::{Document, DocumentMut, InlineTable, Item, Table, Value};

const OPTION: &str = "--set ";

/// One `--set`: a line of TOML, whose words may go without quotes.
#[derive(Debug)]
pub struct Setting {
    /// As it was typed.
    argument: String,
    /// The same as TOML.
    document: Document<String>,
    path: KeyPath,
    value: Value,
}

impl Setting {
    /// # Errors
    /// A report that points into the argument.
    pub fn parse(argument: &str) -> Result<Self, String> {
        parse(argument).map_err(|Refusal { span, title, label }| {
            let shown = format!("{OPTION}{}", argument.replace(['\n', '\r'], " "));
            let span = OPTION.len() + span.start..OPTION.len() + span.end;
            fault::report_text(title, span, &label, None, &shown)
        })
    }

    /// The key.
    pub fn path(&self) -> &KeyPath {
        &self.path
    }

    /// As messages show it.
    pub fn shown(&self) -> String {
        format!("{OPTION}{}", self.argument)
    }

    /// The argument as a parsed text with positions, for [`Setting::in_shown`].
    pub fn document(&self) -> &Item {
        self.document.as_item()
    }

    /// The text that [`Setting::document`] is of.
    pub fn raw(&self) -> &str {
        self.document.raw()
    }

    /// A span of the document as one of [`Setting::shown`]. The quotes round a bare word make it longer.
    pub fn in_shown(&self, span: Range<usize>) -> Range<usize> {
        let end = span.end.min(self.argument.len());
        OPTION.len() + span.start.min(end)..OPTION.len() + end
    }

    /// Edits the world. `default` gives the item that stands for a key that is not written.
    ///
    /// # Errors
    /// When the key lies in something that is no table, or past the end of an array.
    pub fn apply(
        &self,
        world: &mut DocumentMut,
        default: impl Fn(&KeyPath) -> Option<Item>,
    ) -> Result<(), Fault> {
        set(world.as_item_mut(), &self.path, self.value.clone(), &default)
    }
}

/// Why an argument is none.
struct Refusal {
    span: Range<usize>,
    title: &'static str,
    label: String,
}

fn parse(argument: &str) -> Result<Setting, Refusal> {
    const FORM: &str = "`--set` takes KEY=VALUE";

    let refusal = |span, title, label: &str| Refusal { span, title, label: label.into() };
    let everything = 0..argument.len();
    if argument.contains(['\n', '\r']) {
        return Err(refusal(everything, "`--set` takes one line", "a line break in it"));
    }
    let Some(equals) = argument.find('=') else { return Err(refusal(everything, FORM, "no `=` in it")) };
    if argument[equals + 1..].trim().is_empty() {
        return Err(refusal(equals..equals + 1, FORM, "no value behind it"));
    }
    let document = match Document::parse(argument.to_string()) {
        Ok(document) => document,
        Err(error) => with_quotes(argument, equals)
            .and_then(|quoted| Document::parse(quoted).ok())
            .ok_or_else(|| {
                refusal(error.span().unwrap_or(0..argument.len()), "`--set` can't be read", error.message())
            })?,
    };
    // Without positions a value keeps its spelling.
    let leaf = only_leaf(document.clone().into_mut().as_item());
    let (path, value) = leaf.ok_or_else(|| refusal(everything, FORM, "no key in it"))?;
    Ok(Setting { argument: argument.to_string(), document, path, value })
}

/// Sets the key at `path` to `value`, and makes the tables on the way to it.
///
/// # Errors
/// When the key lies in something that is no table, or past the end of an array.
pub fn set(
    top: &mut Item,
    path: &KeyPath,
    mut value: Value,
    default: impl Fn(&KeyPath) -> Option<Item>,
) -> Result<(), Fault> {
    let Some((last, way)) = path.0.split_last() else { return Ok(()) };
    let mut item = top;
    let mut here = KeyPath::default();
    for key in way {
        let place = here.clone();
        here = here.join(key);
        let inline = item.is_inline_table();
        let new = || {
            let table = if inline { Item::Value(InlineTable::new().into()) } else { Item::Table(implicit()) };
            default(&here).unwrap_or(table)
        };
        item = enter(item, key, &place, new)?;
    }
    let slot = enter(item, last, &here, || Item::None)?;
    let decor = slot.as_value().map(|old| old.decor().clone());
    *value.decor_mut() = decor.unwrap_or_default();
    *slot = Item::Value(value);
    Ok(())
}

/// The item under `key` in `item`, which lies at `place`; `new` where a table has none.
fn enter<'a>(
    item: &'a mut Item,
    key: &str,
    place: &KeyPath,
    new: impl FnOnce() -> Item,
) -> Result<&'a mut Item, Fault> {
    if item.is_table_like() {
        if item.get(key).is_none() {
            let fresh = new();
            if let (Some(table), false) = (item.as_table_like_mut(), fresh.is_none()) {
                table.insert(key, fresh);
            }
        }
        // Indexing a table mutably makes the slot.
        return item.get_mut(key).ok_or_else(|| Complaint::new("is not a table", "").at(place.clone()));
    }
    let inside = |problem| Complaint::new(problem, format!("has no `{}` to set", shown(key))).about_key();
    let Some(len) = array_len(item) else {
        let what =
            item.as_str().map_or_else(|| noun(item).to_string(), |word| format!("\"{}\"", shown(word)));
        let complaint = inside(format!("is {what} here, not a table"));
        return Err(complaint.help(format!("set all of it: --set '{place}={{ … }}'")).at(place.clone()));
    };
    let place = place.clone();
    key.parse::<usize>().ok().and_then(|index| item.get_mut(index)).ok_or_else(|| {
        inside(format!("is an array of {len} elements")).help("elements go by their number, from 0").at(place)
    })
}

fn implicit() -> Table {
    let mut table = Table::new();
    table.set_implicit(true);
    table
}

/// The argument with its value in quotes, if that is a bare word: a name, a path, a colour.
fn with_quotes(argument: &str, equals: usize) -> Option<String> {
    let (key, value) = (&argument[..=equals], argument[equals + 1..].trim());
    let bare = |c: char| c.is_alphanumeric() || "_-./~#:+@%".contains(c);
    let start = argument[equals + 1..].find(value)? + equals + 1;
    let space = &argument[equals + 1..start];
    value.chars().all(bare).then(|| format!("{key}{space}\"{value}\""))
}

/// The one key of a document and its value.
fn only_leaf(top: &Item) -> Option<(KeyPath, Value)> {
    let mut path = KeyPath::default();
    let mut item = top;
    // Inline tables are values, not part of the way.
    while let Some(table) = item.as_table() {
        let (key, inner) = table.iter().next()?;
        path = path.join(key);
        item = inner;
    }
    Some((path, item.as_value()?.clone()))
}
