//! A place in a world file and the way to it.

use super::fault::{Complaint, Fault};
use super::schema::Table;
pub use crate::core::text::shown;
use std::cell::RefCell;
use std::fmt;
use toml_edit::{Item, TableLike};

/// The way to a key, from the top of the file: `terrain.layers.0.cone.height`. Elements of arrays go by their index.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct KeyPath(pub Vec<String>);

impl KeyPath {
    /// The way to `key` inside the table or array that `self` leads to.
    pub fn join(&self, key: impl ToString) -> Self {
        let mut path = self.clone();
        path.0.push(key.to_string());
        path
    }

    /// The key itself.
    pub fn last(&self) -> Option<&str> {
        self.0.last().map(String::as_str)
    }
}

impl From<&str> for KeyPath {
    /// Splits at the dots; for paths known to the program, whose keys hold no dot.
    fn from(dotted: &str) -> Self {
        Self(dotted.split('.').map(String::from).collect())
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.iter().map(|key| shown(key)).collect::<Vec<_>>().join("."))
    }
}

/// A place in a world file: what is written there, if anything, and the way to it. What is wrong with it is noted,
/// and reading goes on with the default, so that one run reports every mistake.
pub struct Place<'a> {
    pub path: KeyPath,
    item: Option<&'a Item>,
    /// A preset's keys, which stand for those that are not written.
    preset: Option<&'a Item>,
    /// All that may stand in the file.
    pub shape: fn() -> Table,
    faults: &'a RefCell<Vec<Fault>>,
}

impl<'a> Place<'a> {
    /// The top of the file.
    pub fn top(item: &'a Item, shape: fn() -> Table, faults: &'a RefCell<Vec<Fault>>) -> Self {
        Self { path: KeyPath::default(), item: Some(item), preset: None, shape, faults }
    }

    pub fn item(&self) -> Option<&'a Item> {
        self.item
    }

    /// The word that is written here, if it is one.
    pub fn word(&self) -> Option<&'a str> {
        self.item?.as_str()
    }

    /// The table here; anything else that is written is noted as wrong.
    pub fn table(&self) -> Option<&'a dyn TableLike> {
        let item = self.item?;
        let table = item.as_table_like();
        if table.is_none() {
            self.refuse(Complaint::new(
                format!("must be a table, not {}", noun(item)),
                "a table: `{ key = value, … }`",
            ));
        }
        table
    }

    /// The place of a key in the table here.
    pub fn key(&self, name: &str) -> Place<'a> {
        let inside = |item: Option<&'a Item>| item.and_then(|item| item.get(name));
        Place {
            path: self.path.join(name),
            item: inside(self.item).or_else(|| inside(self.preset)),
            preset: None,
            shape: self.shape,
            faults: self.faults,
        }
    }

    /// The place of an element of the array here.
    pub fn element(&self, index: usize) -> Place<'a> {
        let item = self.item.and_then(|item| item.get(index));
        Place { path: self.path.join(index), item, preset: None, shape: self.shape, faults: self.faults }
    }

    /// The same place as if `item` were written there.
    pub fn with<'b>(&'b self, item: &'b Item) -> Place<'b> {
        Place {
            path: self.path.clone(),
            item: Some(item),
            preset: None,
            shape: self.shape,
            faults: self.faults,
        }
    }

    /// The same place, where keys that are not written have the values of `preset`.
    pub fn with_preset<'b>(&'b self, preset: &'b Item) -> Place<'b> {
        Place {
            path: self.path.clone(),
            item: self.item,
            preset: Some(preset),
            shape: self.shape,
            faults: self.faults,
        }
    }

    /// What is written here, or `default` where nothing is, or nothing that `parse` accepts.
    pub fn read<T>(&self, default: T, parse: impl FnOnce(&Item) -> Result<T, Complaint>) -> T {
        match self.item.map(parse) {
            None => default,
            Some(Ok(value)) => value,
            Some(Err(complaint)) => {
                self.refuse(complaint);
                default
            }
        }
    }

    /// Notes what is wrong here.
    pub fn refuse(&self, complaint: Complaint) {
        self.faults.borrow_mut().push(complaint.at(self.path.clone()));
    }
}

/// What kind of thing an item is, with its article.
pub fn noun(item: &Item) -> &'static str {
    match item.type_name() {
        "string" => "a string",
        "integer" => "a whole number",
        "float" => "a number with a point",
        "boolean" => "true or false",
        "datetime" => "a date",
        "array" | "array of tables" => "an array",
        _ => "a table",
    }
}

/// Number of elements of an array in either of its spellings; `None` for anything else.
pub fn array_len(item: &Item) -> Option<usize> {
    item.as_array().map(|array| array.len()).or_else(|| item.as_array_of_tables().map(|array| array.len()))
}
