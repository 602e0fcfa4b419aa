//! What is wrong with a world, and how it is shown: file, line, caret, what is allowed.

use super::place::KeyPath;
use super::settings::Setting;
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use toml_edit::{Document, Item};

/// Something wrong with what the user wrote.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Where: the first of these keys that is written is pointed at, one that the command line sets before others.
    pub paths: Vec<KeyPath>,
    pub complaint: Complaint,
    /// The text that the keys stand in, where it is another than the world's.
    pub text: Option<Arc<Text>>,
}

/// A world's file or one that a world names, as it was read.
#[derive(Debug)]
pub struct Text {
    /// Path of the file, as messages show it.
    pub name: String,
    /// What it describes: "the species".
    pub what: &'static str,
    pub text: String,
    /// What the command line changes in it.
    pub settings: Arc<[Setting]>,
    pub origins: Arc<Origins>,
}

impl PartialEq for Text {
    fn eq(&self, other: &Text) -> bool {
        (&self.name, &self.text) == (&other.name, &other.text)
    }
}

/// Where the keys of a text that nobody has written come from: files, by the keys that were made from them.
#[derive(Clone, Debug, Default)]
pub struct Origins(pub BTreeMap<String, String>);

impl Origins {
    /// The file that a key comes from.
    pub fn of(&self, path: &KeyPath) -> Option<&str> {
        let around = |len: usize| self.0.get(&KeyPath(path.0[..len].to_vec()).to_string());
        (1..=path.0.len()).rev().find_map(around).map(String::as_str)
    }
}

/// What is wrong, without the place.
#[derive(Clone, Debug, PartialEq)]
pub struct Complaint {
    /// Follows the key's name: "is out of range".
    pub problem: String,
    /// Stands beside the caret: what is allowed.
    pub label: String,
    pub help: Option<String>,
    pub mark: Mark,
    pub cause: Cause,
}

/// More faults than these are consequences of the same mistake, or not read.
pub const MOST: usize = 20;

/// What of a key the caret points at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Key,
    Value,
    /// Bytes of a string's text: texts are far shorter than 4 GiB.
    Part {
        start: u32,
        end: u32,
    },
}

/// Whose fault it is: decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// What is written in the world, or in a text that it names.
    World,
    /// A file that the world names and that can't be read.
    File,
}

impl Complaint {
    pub fn new(problem: impl Into<String>, label: impl Into<String>) -> Self {
        let (problem, label) = (problem.into(), label.into());
        Self { problem, label, help: None, mark: Mark::Value, cause: Cause::World }
    }

    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Points at the key in place of its value.
    pub fn about_key(self) -> Self {
        Self { mark: Mark::Key, ..self }
    }

    /// Points at a part of the string that is the value.
    pub fn about_part(self, part: Range<usize>) -> Self {
        Self { mark: Mark::Part { start: part.start as u32, end: part.end as u32 }, ..self }
    }

    pub fn at(self, path: KeyPath) -> Fault {
        Fault { paths: vec![path], complaint: self, text: None }
    }
}

/// The texts that faults point into: the world file and the arguments of `--set`.
pub struct Sources<'a> {
    pub name: &'a str,
    /// What the file describes: "the world".
    pub what: &'static str,
    pub document: Document<&'a str>,
    pub settings: &'a [Setting],
    pub origins: &'a Origins,
}

impl Sources<'_> {
    /// Shows the faults one below the other, in the order of the text, and then those in other texts. The first goes
    /// without its "error:", which the program puts before every message.
    pub fn report(&self, faults: &[Fault]) -> String {
        let mut reports = self.reports(faults.iter().filter(|fault| fault.text.is_none()));
        reports.extend(reports_elsewhere(faults));
        together(reports)
    }

    /// The same faults where they are no more than remarkable, one sentence each.
    pub fn sentences(&self, faults: &[Fault]) -> Vec<String> {
        let sentence = |fault: &Fault| {
            let complaint = &fault.complaint;
            let path = fault.paths.first().map(|path| format!("`{path}` ")).unwrap_or_default();
            if let Some(file) = self.origin(fault) {
                return format!("{file}: {}: {}", complaint.problem, complaint.label);
            }
            let place = match &fault.text {
                None => self.place(fault),
                Some(text) => text.sources().and_then(|sources| sources.place(fault)),
            };
            format!("{}{path}{}: {}", place.unwrap_or_default(), complaint.problem, complaint.label)
        };
        faults.iter().map(sentence).collect()
    }

    /// File and line of a fault, as a sentence begins with it.
    fn place(&self, fault: &Fault) -> Option<String> {
        let spot = self.find(fault)?;
        match spot.source {
            Source::File => Some(format!("{}:{}: ", self.name, line(self.document.raw(), spot.span.start))),
            Source::Setting(_) => None,
        }
    }

    /// One report a fault, and not many more than can be shown.
    fn reports<'a>(&self, faults: impl Iterator<Item = &'a Fault>) -> Vec<String> {
        let mut found: Vec<(Option<Spot>, &Fault)> = faults.map(|fault| (self.find(fault), fault)).collect();
        found.sort_by_key(|(spot, _)| spot.as_ref().map(|spot| (spot.source, spot.span.start)));
        found.iter().take(MOST + 1).map(|(spot, fault)| self.show(spot, fault)).collect()
    }

    /// The file that its key comes from, where that is another one.
    fn origin(&self, fault: &Fault) -> Option<&str> {
        fault.paths.iter().find_map(|path| self.origins.of(path))
    }

    fn show(&self, spot: &Option<Spot>, fault: &Fault) -> String {
        let Fault { paths, complaint, .. } = fault;
        let set = matches!(spot, Some(Spot { source: Source::Setting(_), .. }));
        if let Some(file) = self.origin(fault).filter(|_| !set) {
            // There is no such text that a label could stand beside.
            let title = format!("`{file}` {}", complaint.problem);
            return show_whole(title, file, &Complaint { label: String::new(), ..complaint.clone() });
        }
        let title = match paths.first() {
            Some(path) if !path.0.is_empty() => format!("`{path}` {}", complaint.problem),
            _ => format!("{} {}", self.what, complaint.problem),
        };
        match spot {
            None => report_place(title, self.name, None, complaint),
            Some(Spot { source, span }) => {
                let snippet = match source {
                    Source::File => Snippet::source(self.document.raw()).path(self.name),
                    Source::Setting(index) => Snippet::source(self.settings[*index].shown()),
                };
                show(title, snippet, span.clone(), complaint)
            }
        }
    }

    /// Where the fault shows: in the last `--set` that touches one of its keys, or else in the file; at the nearest
    /// table around it, or the top, where it is written in neither.
    fn find(&self, fault: &Fault) -> Option<Spot> {
        let mark = fault.complaint.mark;
        let in_settings = fault.paths.iter().find_map(|path| {
            self.settings.iter().enumerate().rev().find_map(|(index, setting)| {
                let span = find(setting.document(), path, mark, setting.raw())?;
                Some(Spot { source: Source::Setting(index), span: setting.in_shown(span) })
            })
        });
        let text: &str = self.document.raw();
        let in_file = || fault.paths.iter().find_map(|path| find(self.document.as_item(), path, mark, text));
        let around = || {
            let path = &fault.paths.first()?.0;
            (1..path.len()).rev().find_map(|len| {
                find(self.document.as_item(), &KeyPath(path[..len].to_vec()), Mark::Key, text)
            })
        };
        in_settings.or_else(|| {
            let top = || (!text.is_empty()).then_some(0..0);
            let span = in_file().or_else(around).or_else(top)?;
            Some(Spot { source: Source::File, span: first_line(text, span) })
        })
    }
}

/// Shows faults that lie in texts of their own, as [`Sources::report`] does.
pub fn report(faults: &[Fault]) -> String {
    together(reports_elsewhere(faults))
}

fn reports_elsewhere(faults: &[Fault]) -> Vec<String> {
    let mut texts: Vec<&Text> = Vec::new();
    for text in faults.iter().filter_map(|fault| fault.text.as_deref()) {
        if !texts.contains(&text) {
            texts.push(text);
        }
    }
    let mut reports = Vec::new();
    for text in texts {
        let Some(sources) = text.sources() else { continue };
        reports.extend(sources.reports(faults.iter().filter(|fault| fault.text.as_deref() == Some(text))));
    }
    reports
}

/// Reports one below the other, and not many more than can be shown; the first without its "error:".
pub fn together(mut reports: Vec<String>) -> String {
    if reports.len() > MOST {
        reports.truncate(MOST);
        reports.push("error: and more".into());
    }
    without_level(reports.join("\n\n"))
}

impl Text {
    /// As [`Sources::sentences`].
    pub fn sentences(&self, faults: &[Fault]) -> Vec<String> {
        self.sources().map(|sources| sources.sentences(faults)).unwrap_or_default()
    }

    /// `None` if it is no TOML: then nothing in it has a place.
    fn sources(&self) -> Option<Sources<'_>> {
        let document = Document::parse(self.text.as_str()).ok()?;
        let Text { name, what, settings, origins, .. } = self;
        Some(Sources { name, what, document, settings, origins })
    }
}

struct Spot {
    source: Source,
    span: Range<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    File,
    Setting(usize),
}

/// One report about a text as a whole: it is no TOML, not UTF-8. An argument has no name.
pub fn report_text(title: &str, span: Range<usize>, label: &str, name: Option<&str>, text: &str) -> String {
    let span = first_line(text, span);
    without_level(show(title.into(), Snippet::source(text).path(name), span, &Complaint::new("", label)))
}

/// One report about a place in the text called `name`, or about it as a whole.
pub fn report_place(
    title: String,
    name: &str,
    place: Option<(&str, Range<usize>)>,
    complaint: &Complaint,
) -> String {
    match place {
        Some((text, span)) => show(title, Snippet::source(text).path(name), span, complaint),
        None => show_whole(title, name, complaint),
    }
}

fn show_whole(title: String, name: &str, complaint: &Complaint) -> String {
    let mut group = Level::ERROR.primary_title(title).element(Origin::path(name));
    if !complaint.label.is_empty() {
        group = group.element(Level::NOTE.message(complaint.label.as_str()));
    }
    render(group, complaint)
}

fn show(title: String, snippet: Snippet<Annotation>, span: Range<usize>, complaint: &Complaint) -> String {
    let annotation = AnnotationKind::Primary.span(span).label(complaint.label.as_str());
    render(Level::ERROR.primary_title(title).element(snippet.annotation(annotation)), complaint)
}

fn render<'a>(mut group: Group<'a>, complaint: &'a Complaint) -> String {
    if let Some(help) = &complaint.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    Renderer::plain().render(&[group])
}

fn without_level(report: String) -> String {
    report.strip_prefix("error: ").map(String::from).unwrap_or(report)
}

/// Where `path` stands in a parsed `text`, if it does.
fn find(top: &Item, path: &KeyPath, mark: Mark, text: &str) -> Option<Range<usize>> {
    let mut item = top;
    let mut key_span = None;
    for key in &path.0 {
        if let Some(table) = item.as_table_like() {
            key_span = table.key(key).and_then(|key| key.span());
            item = table.get(key)?;
        } else {
            item = item.get(key.parse::<usize>().ok()?)?;
            key_span = item.span();
        }
    }
    match mark {
        Mark::Key => key_span,
        Mark::Value => item.span().or(key_span),
        Mark::Part { start, end } => {
            let whole = item.span()?;
            let written = text.get(whole.clone())?;
            let [start, end] = [start, end].map(|at| whole.start + place_in_string(written, at as usize));
            Some(start..end)
        }
    }
}

/// Where byte `at` of a string's text stands in the string as it is written in TOML, quotes and all
/// (<https://toml.io/en/v1.1.0#string>).
fn place_in_string(written: &str, at: usize) -> usize {
    let basic = written.starts_with('"');
    let long = written.starts_with("\"\"\"") || written.starts_with("'''");
    let mut place = if long { 3 } else { 1 };
    if long {
        // A line break right behind the opening quotes is none of the text.
        place += ["\r\n", "\n"]
            .iter()
            .find(|line| written[place..].starts_with(**line))
            .map_or(0, |line| line.len());
    }
    let mut text = 0;
    while text < at {
        let rest = &written[place..];
        let Some(letter) = rest.chars().next() else { break };
        let (written_bytes, text_bytes) = match letter {
            '\\' if basic => escape(rest),
            '\r' if rest.starts_with("\r\n") => (2, 1),
            letter => (letter.len_utf8(), letter.len_utf8()),
        };
        place += written_bytes;
        text += text_bytes;
    }
    place
}

/// Bytes of the escape that `rest` begins with, as written and as text.
fn escape(rest: &str) -> (usize, usize) {
    let digits = match rest[1..].chars().next() {
        Some('x') => 2,
        Some('u') => 4,
        Some('U') => 8,
        // The end of a line, and all white space up to the next word.
        Some(' ' | '\t' | '\r' | '\n') => return (rest.len() - rest[1..].trim_start().len(), 0),
        Some(letter) => return (1 + letter.len_utf8(), letter.len_utf8()),
        None => return (1, 0),
    };
    let code = rest.get(2..2 + digits).and_then(|code| u32::from_str_radix(code, 16).ok());
    (2 + digits, code.and_then(char::from_u32).map_or(0, char::len_utf8))
}

/// Number of the line, from 1, that byte `at` of a text lies in.
fn line(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|byte| *byte == b'\n').count()
}

/// A caret under one line reads better than a bracket round twenty.
fn first_line(text: &str, span: Range<usize>) -> Range<usize> {
    let boundary =
        |at: usize| (0..=at.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    let start = boundary(span.start);
    let end = boundary(span.end).max(start);
    let line = text[start..end].find(['\n', '\r']).unwrap_or(end - start);
    start..start + line
}
