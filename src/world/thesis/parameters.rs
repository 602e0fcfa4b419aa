//! What may stand in a file of settings: parameters with their kinds, ranges, defaults and meanings, one row each.

use super::mistakes::Mistakes;
use super::tokens::{Token, tokens};
use crate::world::fault::Complaint;
use crate::world::kinds::guess;
use crate::world::place::shown;
use std::ops::RangeInclusive;

/// The settings of one kind of file: declared with `settings!`.
pub trait Settings: Sized {
    /// Where the file lies, and what it is about.
    const ABOUT: &'static str;

    fn parameters() -> Vec<Parameter>;

    /// Reads each parameter; what is wrong is noted.
    fn read(entries: &Entries) -> Self;
}

/// Everything that is known of a parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    pub name: &'static str,
    pub about: &'static str,
    /// What may be written, in a few words.
    pub allowed: String,
    /// What stands for nothing written; `None` where it must be.
    pub default: Option<String>,
    /// How many words follow the name.
    pub count: usize,
    /// Whether all of them stand on the line of the name.
    pub one_line: bool,
}

/// What may follow a name, and what it becomes.
pub trait Kind {
    type Value: Default;

    /// How many words.
    fn count(&self) -> usize {
        1
    }

    /// Whether they stand on the line of the name. Those that could be names must, or a value that was left out would take
    /// the name of the next line.
    fn one_line(&self) -> bool {
        false
    }

    /// In a few words.
    fn allowed(&self) -> String;

    /// What stands for nothing written, as it would be written; `None` where it must be.
    fn default(&self) -> Option<String>;

    /// # Errors
    /// Which word is wrong, and why.
    fn read(&self, words: &[&str]) -> Result<Self::Value, (usize, Complaint)>;

    /// The value of several entries of the same name: the last one's.
    fn read_all(&self, entries: &[Vec<&str>]) -> Result<Self::Value, (usize, usize, Complaint)> {
        let Some(last) = entries.len().checked_sub(1) else { return Ok(Self::Value::default()) };
        self.read(&entries[last]).map_err(|(word, complaint)| (last, word, complaint))
    }
}

/// Declares the settings of a file: `field: type = Name(kind)`, with the meaning as a doc comment.
macro_rules! settings {
    ($(#[doc = $about:literal])+ $name:ident { $($(#[doc = $doc:literal])+ $field:ident: $type:ty = $parameter:ident($kind:expr),)+ }) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, Default)]
        pub struct $name { $($(#[doc = $doc])+ pub $field: $type,)+ }

        impl $crate::world::thesis::parameters::Settings for $name {
            const ABOUT: &'static str = concat!($($about),+);

            fn parameters() -> Vec<$crate::world::thesis::parameters::Parameter> {
                use $crate::world::thesis::parameters::{Kind as _, Parameter};
                vec![$({
                    let kind = $kind;
                    Parameter {
                        name: stringify!($parameter),
                        about: concat!($($doc),+).trim_ascii(),
                        allowed: kind.allowed(),
                        default: kind.default(),
                        count: kind.count(),
                        one_line: kind.one_line(),
                    }
                }),+]
            }

            fn read(entries: &$crate::world::thesis::parameters::Entries) -> Self {
                Self { $($field: entries.read(stringify!($parameter), &$kind)),+ }
            }
        }
    };
}
pub(super) use settings;

// Entries ------------------------------------------------------------------------------------------------------------

/// The entries of a file, in its order.
pub struct Entries<'a> {
    /// The file's way from the folder.
    pub file: &'a str,
    found: Vec<Entry<'a>>,
    mistakes: &'a Mistakes,
}

/// A name and the words that belong to it.
struct Entry<'a> {
    name: Token<'a>,
    words: Vec<Token<'a>>,
}

impl<'a> Entries<'a> {
    /// Finds the entries of a file that holds settings of the kind `S`.
    pub fn of<S: Settings>(file: &'a str, text: &'a str, mistakes: &'a Mistakes) -> Entries<'a> {
        let parameters = S::parameters();
        let mut entries = Entries { file, found: Vec::new(), mistakes };
        let mut rest = tokens(text).into_iter().peekable();
        let known = |token: &Token| parameters.iter().find(|parameter| parameter.name == token.text);
        while let Some(name) = rest.next() {
            let Some(parameter) = known(&name) else {
                entries.refuse_name(&name, &parameters);
                // What stands behind an unknown name belongs to it.
                while rest.next_if(|token| token.line == name.line).is_some() {}
                continue;
            };
            let mut words = Vec::new();
            // A name on a line of its own begins the next entry, whatever is missing here.
            let belongs =
                |token: &Token| token.line == name.line || !parameter.one_line && known(token).is_none();
            while let Some(word) = rest.next_if(|token| words.len() < parameter.count && belongs(token)) {
                words.push(word);
            }
            if words.len() < parameter.count {
                let problem = if words.is_empty() { "has no value" } else { "has too few values" };
                entries.refuse_at(&name, Complaint::new(problem, parameter.allowed.clone()));
            } else {
                entries.found.push(Entry { name, words });
            }
        }
        entries
    }

    /// The value of a parameter: of its last entry, or the default.
    pub fn read<K: Kind>(&self, name: &'static str, kind: &K) -> K::Value {
        let found: Vec<&Entry> = self.found.iter().filter(|entry| entry.name.text == name).collect();
        if found.is_empty() {
            let Some(default) = kind.default() else {
                let complaint =
                    Complaint::new("is missing", format!("write `{name}` and {}", kind.allowed()));
                self.mistakes.note(self.file, None, format!("`{name}` is missing"), complaint);
                return K::Value::default();
            };
            let words: Vec<&str> = default.split_whitespace().collect();
            return kind.read(&words).unwrap_or_default();
        }
        let words: Vec<Vec<&str>> =
            found.iter().map(|entry| entry.words.iter().map(|word| word.text).collect()).collect();
        kind.read_all(&words).unwrap_or_else(|(entry, word, complaint)| {
            let span = found[entry].words.get(word).map(|word| word.span.clone());
            let title = format!("`{name}` {}", complaint.problem);
            self.mistakes.note(self.file, span, title, complaint);
            K::Value::default()
        })
    }

    /// Whether a parameter is written.
    pub fn has(&self, name: &str) -> bool {
        self.found.iter().any(|entry| entry.name.text == name)
    }

    /// Notes what is wrong with the value of a parameter, beside others.
    pub fn refuse(&self, name: &str, complaint: Complaint) {
        self.refuse_entry(name, complaint, |_| true);
    }

    /// Notes what is wrong with the production of a symbol.
    pub fn refuse_production(&self, symbol: char, complaint: Complaint) {
        let of_symbol = |entry: &Entry| entry.words.first().is_some_and(|word| word.text.starts_with(symbol));
        self.refuse_entry("Prod", complaint, of_symbol);
    }

    /// Points at the last entry of a name that `is_meant`.
    fn refuse_entry(&self, name: &str, complaint: Complaint, is_meant: impl Fn(&Entry) -> bool) {
        let entry = self.found.iter().rev().find(|entry| entry.name.text == name && is_meant(entry));
        let span =
            entry.and_then(|entry| Some(entry.words.first()?.span.start..entry.words.last()?.span.end));
        self.mistakes.note(self.file, span, format!("`{name}` {}", complaint.problem), complaint);
    }

    fn refuse_name(&self, name: &Token, parameters: &[Parameter]) {
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
        let known = format!("known here: {}", names.join(", "));
        let before = self.found.last().filter(|entry| entry.name.line == name.line);
        let complaint = match before {
            Some(entry) => {
                let parameter = entry.name.text;
                let count = entry.words.len();
                let values = if count == 1 { "value" } else { "values" };
                Complaint::new("is one too many", format!("`{parameter}` takes {count} {values}"))
            }
            None if name.text.parse::<f64>().is_ok() => {
                Complaint::new("stands without a name", "a name, then its values").help(known)
            }
            None => guess("is unknown", name.text, names.iter().copied(), known),
        };
        self.refuse_at(name, complaint);
    }

    fn refuse_at(&self, token: &Token, complaint: Complaint) {
        let title = format!("`{}` {}", shown(token.text), complaint.problem);
        self.mistakes.note(self.file, Some(token.span.clone()), title, complaint);
    }
}

// Kinds --------------------------------------------------------------------------------------------------------------

/// As many numbers as there are defaults, if they have any.
#[derive(Clone, Copy)]
pub struct Numbers<const N: usize> {
    range: [f64; 2],
    whole: Whole,
    default: Option<[f64; N]>,
}

#[derive(Clone, Copy, PartialEq)]
enum Whole {
    Yes,
    No,
}

/// Finite numbers.
pub fn numbers<const N: usize>(range: RangeInclusive<f64>) -> Numbers<N> {
    Numbers { range: [*range.start(), *range.end()], whole: Whole::No, default: None }
}

/// Whole numbers.
pub fn wholes<const N: usize>(range: RangeInclusive<i32>) -> Numbers<N> {
    let range = [(*range.start()).into(), (*range.end()).into()];
    Numbers { range, whole: Whole::Yes, default: None }
}

/// A finite number.
pub fn number(range: RangeInclusive<f64>) -> One {
    One(numbers(range))
}

/// A whole number.
pub fn whole(range: RangeInclusive<i32>) -> One {
    One(wholes(range))
}

impl<const N: usize> Numbers<N> {
    pub fn or(self, default: [f64; N]) -> Self {
        Self { default: Some(default), ..self }
    }
}

impl<const N: usize> Kind for Numbers<N>
where
    [f64; N]: Default,
{
    type Value = [f64; N];

    fn count(&self) -> usize {
        N
    }

    fn allowed(&self) -> String {
        let [least, most] = self.range;
        let kind = match (N, self.whole) {
            (1, Whole::Yes) => "a whole number".into(),
            (1, Whole::No) => "a number".into(),
            (_, Whole::Yes) => format!("{N} whole numbers"),
            (_, Whole::No) => format!("{N} numbers"),
        };
        format!("{kind} from {least} to {most}")
    }

    fn default(&self) -> Option<String> {
        let words = |numbers: [f64; N]| numbers.map(|number| number.to_string()).join(" ");
        self.default.map(words)
    }

    fn read(&self, words: &[&str]) -> Result<[f64; N], (usize, Complaint)> {
        let mut numbers = [0.0; N];
        for (index, (number, word)) in numbers.iter_mut().zip(words).enumerate() {
            let refuse = |problem: String| {
                Err((index, Complaint::new(problem, format!("allowed: {}", self.allowed()))))
            };
            let Ok(read) = word.parse::<f64>() else {
                return refuse(format!("can't be `{}`", shown(word)));
            };
            if !read.is_finite() {
                return refuse("must be finite".into());
            }
            if self.whole == Whole::Yes && read.fract() != 0.0 {
                return refuse("must be whole".into());
            }
            if read < self.range[0] || read > self.range[1] {
                return refuse("is out of range".into());
            }
            *number = read;
        }
        Ok(numbers)
    }
}

/// One number.
#[derive(Clone, Copy)]
pub struct One(Numbers<1>);

impl One {
    pub fn or(self, default: f64) -> Self {
        One(self.0.or([default]))
    }
}

impl Kind for One {
    type Value = f64;

    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn default(&self) -> Option<String> {
        self.0.default()
    }

    fn read(&self, words: &[&str]) -> Result<f64, (usize, Complaint)> {
        self.0.read(words).map(|[number]| number)
    }
}

/// One of some words, each with what it becomes.
#[derive(Clone, Copy)]
pub struct Choice<T: 'static> {
    words: &'static [(&'static str, T)],
    default: Option<&'static str>,
}

pub const fn choice<T>(words: &'static [(&'static str, T)]) -> Choice<T> {
    Choice { words, default: None }
}

impl<T: Copy> Choice<T> {
    pub const fn or(self, default: &'static str) -> Self {
        Self { default: Some(default), ..self }
    }
}

impl<T: Copy + Default> Kind for Choice<T> {
    type Value = T;

    fn allowed(&self) -> String {
        self.words.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(" or ")
    }

    fn default(&self) -> Option<String> {
        self.default.map(String::from)
    }

    fn read(&self, words: &[&str]) -> Result<T, (usize, Complaint)> {
        let word = words.first().copied().unwrap_or_default();
        let known = self.words.iter().find(|(name, _)| *name == word);
        known.map(|(_, value)| *value).ok_or_else(|| {
            let names = self.words.iter().map(|(name, _)| *name);
            let allowed = format!("allowed: {}", self.allowed());
            (0, guess(format!("can't be `{}`", shown(word)), word, names, allowed))
        })
    }
}

/// The name of a file, without folder and ending.
#[derive(Clone, Copy)]
pub struct FileName;

impl Kind for FileName {
    type Value = String;

    fn one_line(&self) -> bool {
        true
    }

    fn allowed(&self) -> String {
        "the name of a file, without folder and ending".into()
    }

    fn default(&self) -> Option<String> {
        None
    }

    fn read(&self, words: &[&str]) -> Result<String, (usize, Complaint)> {
        let name = words.first().copied().unwrap_or_default();
        // A name may not lead out of the folder.
        let plain =
            !name.starts_with('.') && !name.contains(['/', '\\', ':']) && !name.contains(char::is_control);
        if plain && name.len() <= 200 {
            return Ok(name.into());
        }
        Err((0, Complaint::new(format!("can't be `{}`", shown(name)), self.allowed())))
    }
}
