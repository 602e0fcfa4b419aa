//! Changes of a world file as a document: what a person does in a panel. Comments stay.

use super::fault::{Complaint, Fault};
use super::place::{KeyPath, array_len};
use super::settings;
use super::{Error, shape};
use toml_edit::{Array, ArrayOfTables, Decor, DocumentMut, Item, Key, Table, Value};

/// One change of a world file.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Writes a value, whatever stood there.
    Set(KeyPath, Value),
    /// Leaves a key to its default, or takes an element out of an array or of a table of names.
    Remove(KeyPath),
    /// Puts a new element into an array: at the path's last number, and before those that follow.
    Insert(KeyPath, Value),
    /// Takes an element of an array to another place in it.
    Move { list: KeyPath, from: usize, to: usize },
    /// Gives a key of a table of names another name.
    Rename(KeyPath, String),
}

impl Edit {
    /// The key that is changed, or the array.
    pub fn path(&self) -> &KeyPath {
        match self {
            Edit::Set(path, _) | Edit::Remove(path) | Edit::Insert(path, _) | Edit::Rename(path, _) => path,
            Edit::Move { list, .. } => list,
        }
    }

    /// Changes the document, which is not yet a world for that: [`parse`](super::parse) tells.
    ///
    /// # Errors
    /// When the key lies in something that is no table, or past the end of an array.
    pub fn apply(&self, document: &mut DocumentMut) -> Result<(), Error> {
        self.change(document.as_item_mut()).map_err(|fault| {
            let Complaint { problem, label, .. } = fault.complaint;
            let place = fault.paths.first().map(|path| format!("`{path}` ")).unwrap_or_default();
            Error::Wrong { report: format!("{place}{problem}: {label}") }
        })
    }

    fn change(&self, top: &mut Item) -> Result<(), Fault> {
        match self {
            Edit::Set(path, value) => set(top, path, value.clone()),
            Edit::Remove(path) => {
                remove(top, path);
                Ok(())
            }
            Edit::Insert(path, value) => insert(top, path, value.clone()),
            Edit::Move { list, from, to } => {
                if let Some(item) = find(top, &list.0) {
                    shift(item, *from, *to);
                }
                Ok(())
            }
            Edit::Rename(path, name) => rename(top, path, name),
        }
    }
}

fn default(path: &KeyPath) -> Option<Item> {
    shape().default_array(&path.0)
}

fn missing(path: &KeyPath) -> Fault {
    Complaint::new("is not there", "it was taken away meanwhile").at(path.clone())
}

/// The item at `path`, if it is written.
fn find<'a>(top: &'a mut Item, path: &[String]) -> Option<&'a mut Item> {
    path.iter().try_fold(top, |item, key| match array_len(item) {
        Some(_) => item.get_mut(key.parse::<usize>().ok()?),
        // Asking a table for what it has not would make it.
        None => item.as_table_like_mut()?.get_mut(key),
    })
}

/// As `--set` does it. A table in place of a table keeps its header, and the comment above it.
fn set(top: &mut Item, path: &KeyPath, value: Value) -> Result<(), Fault> {
    if let (Some(Item::Table(old)), Value::InlineTable(new)) = (find(top, &path.0), &value) {
        let mut table = new.clone().into_table();
        *table.decor_mut() = header(old);
        table.set_position(old.position());
        *old = table;
        return Ok(());
    }
    settings::set(top, path, value, default)
}

/// What stands around the first header of a table: its own, or that of the first table in it, as in `[sky.preetham]`.
fn header(table: &Table) -> Decor {
    let inner = table.iter().find_map(|(_, item)| item.as_table());
    match inner {
        Some(inner) if table.is_implicit() => header(inner),
        _ => table.decor().clone(),
    }
}

/// Takes a key or an element away. Lines of comment above a key in a table of its own stay: they may be about what
/// follows, too.
fn remove(top: &mut Item, path: &KeyPath) {
    let Some((last, way)) = path.0.split_last() else { return };
    let Some(holder) = find(top, way) else { return };
    let index = last.parse::<usize>().unwrap_or(usize::MAX);
    match holder {
        Item::Value(Value::Array(array)) if index < array.len() => {
            array.remove(index);
        }
        Item::ArrayOfTables(tables) if index < tables.len() => {
            tables.remove(index);
        }
        Item::Value(Value::InlineTable(table)) => {
            let suffix = table.get(last).and_then(|value| value.decor().suffix().cloned());
            let is_last = table.iter().last().is_some_and(|(key, _)| key == last);
            table.remove(last);
            // The space before the brace.
            if let (true, Some(suffix), Some((_, value))) = (is_last, suffix, table.iter_mut().last()) {
                value.decor_mut().set_suffix(suffix);
            }
        }
        Item::Table(table) => remove_line(table, last),
        _ => {}
    }
}

fn remove_line(table: &mut Table, name: &str) {
    let names: Vec<String> = table.iter().map(|(name, _)| name.to_string()).collect();
    let Some(place) = names.iter().position(|other| other == name) else { return };
    let Some((key, item)) = table.remove_entry(name) else { return };
    let above = match &item {
        Item::Table(inner) => inner.decor().prefix(),
        _ => key.leaf_decor().prefix(),
    };
    let above = above.and_then(|text| text.as_str()).unwrap_or_default().trim_end_matches(' ').to_string();
    if !above.contains('#') || !item.is_value() {
        return;
    }
    let next = names.get(place + 1).filter(|next| table.get(next).is_some_and(Item::is_value));
    if let Some(mut next) = next.and_then(|next| table.key_mut(next)) {
        let decor = next.leaf_decor_mut();
        let own = decor.prefix().and_then(|text| text.as_str()).unwrap_or_default().to_string();
        decor.set_prefix(format!("{above}{own}"));
        return;
    }
    let below = format!("\n{}", above.trim_end());
    let previous = place.checked_sub(1).and_then(|index| table.get_mut(&names[index]));
    let decor = match previous.and_then(Item::as_value_mut) {
        Some(value) => value.decor_mut(),
        None => table.decor_mut(),
    };
    let own = decor.suffix().and_then(|text| text.as_str()).unwrap_or_default().to_string();
    decor.set_suffix(format!("{own}{below}"));
}

fn insert(top: &mut Item, path: &KeyPath, value: Value) -> Result<(), Fault> {
    let Some((last, way)) = path.0.split_last() else { return Ok(()) };
    let list = KeyPath(way.to_vec());
    let index = last.parse::<usize>().map_err(|_| missing(path))?;
    if find(top, way).is_none() {
        let written = default(&list).and_then(|item| item.into_value().ok());
        set(top, &list, written.unwrap_or_else(|| Array::new().into()))?;
    }
    match find(top, way) {
        Some(Item::Value(Value::Array(array))) => {
            let index = index.min(array.len());
            insert_value(array, index, value);
            Ok(())
        }
        Some(Item::ArrayOfTables(tables)) => {
            let Value::InlineTable(table) = value else { return Err(missing(path)) };
            let index = index.min(tables.len());
            tables.insert(index, table.into_table());
            in_order(tables);
            Ok(())
        }
        _ => Err(missing(&list)),
    }
}

/// An array of one line stays one; in one with a line for each element, the new one gets a line.
fn insert_value(array: &mut Array, index: usize, mut value: Value) {
    let prefix = array.get(index.saturating_sub(1)).and_then(|value| value.decor().prefix()?.as_str());
    let indent = prefix.filter(|prefix| prefix.contains('\n')).and_then(|prefix| prefix.rsplit('\n').next());
    match indent.map(|indent| format!("\n{indent}")) {
        Some(prefix) => {
            *value.decor_mut() = Decor::new(prefix, "");
            array.insert_formatted(index, value);
        }
        None => {
            array.insert(index, value);
            // The first of a line has no space before it.
            let first = if index == 0 { array.get_mut(1) } else { None };
            if let Some(first) = first.filter(|value| value.decor().prefix().is_none_or(blank)) {
                first.decor_mut().set_prefix(" ");
            }
        }
    }
}

fn blank(text: &toml_edit::RawString) -> bool {
    text.as_str().is_none_or(|text| text.trim().is_empty())
}

fn shift(list: &mut Item, from: usize, to: usize) {
    let len = array_len(list).unwrap_or(0);
    if from >= len || to >= len {
        return;
    }
    match list {
        Item::Value(Value::Array(array)) => {
            let value = array.remove(from);
            let one_line = value.decor().prefix().is_none_or(blank_line);
            if one_line { array.insert(to, value) } else { array.insert_formatted(to, value) }
            if one_line {
                for (index, value) in array.iter_mut().enumerate() {
                    value.decor_mut().set_prefix(if index == 0 { "" } else { " " });
                }
            }
        }
        Item::ArrayOfTables(tables) => {
            let table = tables.remove(from);
            tables.insert(to, table);
            in_order(tables);
        }
        _ => {}
    }
}

fn blank_line(text: &toml_edit::RawString) -> bool {
    text.as_str().is_none_or(|text| text.trim().is_empty() && !text.contains('\n'))
}

/// Lets tables be written in the order that they have in the array, and not in that of the file they were read from.
fn in_order(tables: &mut ArrayOfTables) {
    let first = tables.iter().filter_map(Table::position).min();
    for (index, table) in tables.iter_mut().enumerate() {
        forget_positions(table);
        if index == 0 {
            table.set_position(first);
        }
    }
}

fn forget_positions(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(inner) => forget_positions(inner),
            Item::ArrayOfTables(inner) => inner.iter_mut().for_each(forget_positions),
            _ => {}
        }
    }
}

fn rename(top: &mut Item, path: &KeyPath, name: &str) -> Result<(), Fault> {
    let Some((last, way)) = path.0.split_last() else { return Ok(()) };
    let renamed = |key: Key| match key.get() == last {
        true => Key::new(name).with_leaf_decor(key.leaf_decor().clone()),
        false => key,
    };
    let taken = |table: &dyn toml_edit::TableLike| {
        let complaint = Complaint::new("is there already", "choose another name");
        let other = table.contains_key(name) && name != last;
        if other { Err(complaint.at(KeyPath(way.to_vec()).join(name))) } else { Ok(()) }
    };
    match find(top, way) {
        Some(Item::Table(table)) if table.contains_key(last) => {
            taken(table)?;
            let names: Vec<String> = table.iter().map(|(name, _)| name.to_string()).collect();
            let entries: Vec<_> = names.iter().filter_map(|name| table.remove_entry(name)).collect();
            for (key, item) in entries {
                table.insert_formatted(&renamed(key), item);
            }
            Ok(())
        }
        Some(Item::Value(Value::InlineTable(table))) if table.contains_key(last) => {
            taken(table)?;
            let names: Vec<String> = table.iter().map(|(name, _)| name.to_string()).collect();
            let entries: Vec<_> = names.iter().filter_map(|name| table.remove_entry(name)).collect();
            for (key, value) in entries {
                table.insert_formatted(&renamed(key), value);
            }
            Ok(())
        }
        _ => Err(missing(path)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edited(text: &str, edit: Edit) -> String {
        let mut document: DocumentMut = text.parse().expect("TOML");
        edit.apply(&mut document).expect("the edit applies");
        document.to_string()
    }

    fn value(text: &str) -> Value {
        text.parse().expect("a value")
    }

    #[test]
    fn what_is_set_keeps_its_comments() {
        let text = "# A world.\nformat = 1 # version\n\n# Rain.\n[erosion.hydraulic]\nrain = 100   # mm/h\n";
        let edit = Edit::Set("erosion.hydraulic.rain".into(), value("120"));
        assert_eq!(edited(text, edit), text.replace("100", "120"));
    }

    #[test]
    fn another_table_keeps_the_header_and_its_comment() {
        let text = "format = 1\n\n# Light.\n[sky.preetham]\nturbidity = 3\n\n[sea]\nlevel = 1\n";
        let edit = Edit::Set("sky".into(), value("{ hosek_wilkie = {} }"));
        let wanted = "format = 1\n\n# Light.\n[sky]\nhosek_wilkie = {}\n\n[sea]\nlevel = 1\n";
        assert_eq!(edited(text, edit), wanted);
    }

    #[test]
    fn keys_go_and_the_lines_above_them_stay() {
        let text = "format = 1\n# A number.\nseed = 2 # its own\n\n[sea]\nlevel = 3\n# Waves.\nroughness = 0.1\n";
        let wanted = "format = 1\n# A number.\n\n[sea]\nlevel = 3\n# Waves.\nroughness = 0.1\n";
        assert_eq!(edited(text, Edit::Remove("seed".into())), wanted);
        let wanted = "format = 1\n# A number.\nseed = 2 # its own\n\n[sea]\nlevel = 3\n# Waves.\n";
        assert_eq!(edited(text, Edit::Remove("sea.roughness".into())), wanted);
        let inline = "a = { b = 1, c = 2 }\n";
        assert_eq!(edited(inline, Edit::Remove("a.c".into())), "a = { b = 1 }\n");
        assert_eq!(edited(inline, Edit::Remove("a.d".into())), inline);
    }

    #[test]
    fn elements_come_and_go_and_move() {
        let text = "[terrain]\nlayers = [\n    # One.\n    { cone = {} },\n    { crater = {} },\n]\n";
        let new = Edit::Insert("terrain.layers.2".into(), value("{ simplex = {} }"));
        let wanted = "[terrain]\nlayers = [\n    # One.\n    { cone = {} },\n    { crater = {} },\n    { simplex = {} },\n]\n";
        assert_eq!(edited(text, new), wanted);
        let up = Edit::Move { list: "terrain.layers".into(), from: 1, to: 0 };
        let wanted = "[terrain]\nlayers = [\n    { crater = {} },\n    # One.\n    { cone = {} },\n]\n";
        assert_eq!(edited(text, up), wanted);
        let gone = Edit::Remove("terrain.layers.1".into());
        assert_eq!(edited(text, gone), "[terrain]\nlayers = [\n    # One.\n    { cone = {} },\n]\n");
        let line = "at = [1, 2, 3]\n";
        assert_eq!(edited(line, Edit::Move { list: "at".into(), from: 2, to: 0 }), "at = [3, 1, 2]\n");
        assert_eq!(edited(line, Edit::Insert("at.0".into(), value("7"))), "at = [7, 1, 2, 3]\n");
        assert_eq!(edited(line, Edit::Insert("at.3".into(), value("7"))), "at = [1, 2, 3, 7]\n");
    }

    #[test]
    fn tables_in_arrays_come_and_go_and_move() {
        let text = "# First.\n[[plants]]\n[plants.grid]\njitter = 1\n\n# Second.\n[[plants]]\ncover = {}\n\n[sea]\nlevel = 1\n";
        let move_up = Edit::Move { list: "plants".into(), from: 1, to: 0 };
        let wanted = "\n# Second.\n[[plants]]\ncover = {}\n# First.\n[[plants]]\n[plants.grid]\njitter = 1\n\n[sea]\nlevel = 1\n";
        assert_eq!(edited(text, move_up).trim_start(), wanted.trim_start());
        let new = Edit::Insert("plants.1".into(), value("{ scatter = {} }"));
        let wanted = "# First.\n[[plants]]\n[plants.grid]\njitter = 1\n\n[[plants]]\nscatter = {}\n\n# Second.\n[[plants]]\ncover = {}\n\n[sea]\nlevel = 1\n";
        assert_eq!(edited(text, new), wanted);
    }

    #[test]
    fn a_default_array_is_written_before_it_grows() {
        let grown = edited("format = 1\n", Edit::Insert("terrain.layers.2".into(), value("{ crater = {} }")));
        let document: DocumentMut = grown.parse().expect("TOML");
        let layers = document["terrain"]["layers"].as_array().expect("an array");
        assert_eq!(layers.len(), 3, "{grown}");
        let first = edited("format = 1\n", Edit::Insert("models.0".into(), value("{ file = \"a.ply\" }")));
        assert_eq!(first, "format = 1\nmodels = [{ file = \"a.ply\" }]\n");
    }

    #[test]
    fn names_change_where_they_stand() {
        let text = "[species]\n# Tall.\noak = { file = \"oak.toml\" }\npine = {}\n";
        let edit = Edit::Rename("species.oak".into(), "beech".into());
        assert_eq!(edited(text, edit), text.replace("oak =", "beech ="));
        let mut document: DocumentMut = text.parse().expect("TOML");
        let taken = Edit::Rename("species.oak".into(), "pine".into()).apply(&mut document);
        assert!(taken.is_err_and(|error| error.to_string().contains("another name")));
    }

    #[test]
    fn what_is_not_there_is_refused_or_left() {
        let mut document: DocumentMut = "reef = \"none\"\n".parse().expect("TOML");
        let inside = Edit::Set("reef.growth".into(), value("1")).apply(&mut document);
        assert!(inside.is_err());
        assert!(Edit::Rename("species.x".into(), "y".into()).apply(&mut document).is_err());
        assert!(Edit::Remove("species.x.y".into()).apply(&mut document).is_ok());
        assert_eq!(document.to_string(), "reef = \"none\"\n");
    }
}
