//! Which keys begin the world again when they change: the engine is asked before, with worlds in which a key says something else.

use super::{Entry, is_section};
use crate::app::viewer::document::Document;
use crate::app::viewer::engine::begins_again;
use crate::terrain::Stage;
use crate::world::schema::Shape;
use crate::world::{self, Edit, KeyPath, Overrides, World, array_len};
use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Weak};
use toml_edit::{InlineTable, Item, Value};

/// What is known of keys that have been shown. A thread of its own finds it out: worlds may name large files.
pub struct Foresight {
    asked: Option<Arc<Asked>>,
    /// Questions of it that are on their way, or answered.
    posed: HashSet<KeyPath>,
    known: HashMap<KeyPath, bool>,
    questions: Sender<Question>,
    answers: Receiver<Answer>,
}

/// What is shown.
pub(super) struct Asked {
    pub world: Arc<World>,
    /// Files that the world names are looked for from here.
    folder: PathBuf,
    /// That its land has come to.
    stage: Stage,
}

/// Whether one of these changes of a key begins the world again.
pub(super) struct Question {
    /// Gone once something else is shown.
    pub of: Weak<Asked>,
    pub path: KeyPath,
    pub edits: Vec<Edit>,
}

type Answer = (KeyPath, bool);

impl Foresight {
    /// `wake` is called, from another thread, whenever there is an answer.
    pub fn new(wake: impl Fn() + Send + 'static) -> Foresight {
        let (questions, inbox) = channel::<Question>();
        let (outbox, answers) = channel();
        let answer = move || {
            while let Ok(Question { of, path, edits }) = inbox.recv() {
                let Some(asked) = of.upgrade() else { continue };
                let again = asked.others(&path, &edits).iter().any(|other| asked.begins_again_as(other));
                if outbox.send((path, again)).is_err() {
                    return;
                }
                wake();
            }
        };
        // Without it nothing is told before it happens.
        let _ = std::thread::Builder::new().name("foresight".into()).spawn(answer);
        Foresight::asking(questions, answers)
    }

    /// Somebody else has the answers.
    pub(super) fn asking(questions: Sender<Question>, answers: Receiver<Answer>) -> Foresight {
        Foresight { asked: None, posed: HashSet::new(), known: HashMap::new(), questions, answers }
    }

    /// This is shown from now on. What was known before holds until it is known better.
    pub fn look_at(&mut self, document: &Document, stage: Stage) {
        let world = document.world();
        let is_same = |asked: &Arc<Asked>| Arc::ptr_eq(&asked.world, world) && asked.stage == stage;
        if !self.asked.as_ref().is_some_and(is_same) {
            let asked = Asked { world: world.clone(), folder: document.folder().into(), stage };
            self.asked = Some(Arc::new(asked));
            self.posed.clear();
        }
        self.known.extend(self.answers.try_iter());
    }

    /// Whether another value of a key begins the world again, as far as that is known.
    pub(super) fn begins_again(&mut self, entry: &Entry) -> bool {
        if let Some(asked) = &self.asked
            && self.posed.insert(entry.path.clone())
        {
            let (of, path) = (Arc::downgrade(asked), entry.path.clone());
            let _ = self.questions.send(Question { of, path, edits: changes(entry) });
        }
        self.known.get(&entry.path).copied().unwrap_or(false)
    }
}

impl Asked {
    /// The worlds after such changes of a key. Where none of them can be, the one without what the key stands in.
    pub(super) fn others(&self, path: &KeyPath, edits: &[Edit]) -> Vec<World> {
        let others: Vec<World> = edits.iter().filter_map(|edit| self.after(edit)).collect();
        if !others.is_empty() {
            return others;
        }
        let mut places = (1..=path.0.len()).rev().filter_map(|length| path.0.get(..length));
        places.find_map(|place| self.after(&Edit::Remove(KeyPath(place.to_vec())))).into_iter().collect()
    }

    pub(super) fn begins_again_as(&self, other: &World) -> bool {
        begins_again(&self.world, other, self.stage)
    }

    /// The world after a change, if it is one.
    fn after(&self, edit: &Edit) -> Option<World> {
        let mut document = self.world.document.clone();
        edit.apply(&mut document).ok()?;
        let name = self.world.path.display().to_string();
        world::parse(&name, document.to_string().as_bytes(), &self.folder, &Overrides::default()).ok()
    }
}

/// Changes after which a key says something else.
fn changes(entry: &Entry) -> Vec<Edit> {
    let Entry { key, path, .. } = entry;
    let start = || key.start.parse().ok();
    let values: Vec<Value> = match (&key.shape, entry.item()) {
        (_, None) => start().into_iter().collect(),
        (Shape::OrWord(_, [word, _]), Some(item)) if item.as_str() == Some(word) => {
            start().into_iter().collect()
        }
        (Shape::OrWord(inner, [word, _]), Some(item)) => {
            let inner = if is_section(inner) { Vec::new() } else { others(inner, item) };
            inner.into_iter().chain([Value::from(*word)]).collect()
        }
        (shape, Some(item)) => others(shape, item),
    };
    values.into_iter().map(|value| Edit::Set(path.clone(), value)).collect()
}

/// Other values than this one, the nearest first.
fn others(shape: &Shape, item: &Item) -> Vec<Value> {
    let number = super::number(item);
    match shape {
        Shape::Number { range: [least, most], .. } => {
            let number = number.unwrap_or(*least);
            let nearby = |end: f64| number + 0.01 * (end.clamp(number - 100.0, number + 100.0) - number);
            [nearby(*most), nearby(*least)]
                .into_iter()
                .filter(|other| *other != number)
                .map(Value::from)
                .collect()
        }
        Shape::Whole { range: [least, most] } => {
            let number = number.unwrap_or(*least as f64) as i64;
            let near = [number.saturating_add(1), number.saturating_sub(1), number / 2];
            near.into_iter().filter(|other| (least..=most).contains(&other)).map(Value::from).collect()
        }
        Shape::Switch => item.as_bool().map(|on| Value::from(!on)).into_iter().collect(),
        Shape::Colour => ["#204060", "#604020"].into_iter().map(Value::from).collect(),
        Shape::Choice(words) => {
            let words = words.iter().map(|[word, _]| *word);
            words.filter(|word| item.as_str() != Some(word)).map(Value::from).collect()
        }
        Shape::Array(shapes) => elements(shapes, item),
        Shape::OneOf(alternatives) => {
            let tagged = |name: &str| Value::from(InlineTable::from_iter([(name, InlineTable::new())]));
            let others = alternatives
                .iter()
                .filter(|other| item.as_str() != Some(other.name) && item.get(other.name).is_none());
            others
                .map(|other| if other.table.is_some() { tagged(other.name) } else { other.name.into() })
                .collect()
        }
        // Nothing is to be made up for these.
        Shape::File
        | Shape::Text(_)
        | Shape::List { .. }
        | Shape::Named { .. }
        | Shape::Table(_)
        | Shape::OrWord(..) => Vec::new(),
    }
}

/// Arrays of which one element is another one.
fn elements(shapes: &[Shape], item: &Item) -> Vec<Value> {
    let Some(array) = item.as_array().filter(|array| Some(array.len()) == array_len(item)) else {
        return Vec::new();
    };
    let changed = shapes.iter().enumerate().flat_map(|(index, shape)| {
        let others =
            array.get(index).map(|value| others(shape, &Item::Value(value.clone()))).unwrap_or_default();
        others.into_iter().map(move |other| {
            let mut array = array.clone();
            array.replace(index, other);
            Value::from(array)
        })
    });
    changed.collect()
}
