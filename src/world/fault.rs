//! What is wrong with a world, and how it is shown: file, line, caret, what is allowed.

use super::place::KeyPath;
use super::settings::Setting;
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use std::ops::Range;
use toml_edit::{Document, Item};

/// Something wrong with what the user wrote.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Where: the first of these keys that is written is pointed at, one that the command line sets before others.
    pub paths: Vec<KeyPath>,
    pub complaint: Complaint,
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
}

/// Whose fault it is: decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// What is written in the world.
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

    pub fn at(self, path: KeyPath) -> Fault {
        Fault { paths: vec![path], complaint: self }
    }
}

/// The texts that faults point into: the world file and the arguments of `--set`.
pub struct Sources<'a> {
    pub name: &'a str,
    pub document: Document<&'a str>,
    pub settings: &'a [Setting],
}

impl Sources<'_> {
    /// Shows the faults one below the other, in the order of the text. The first goes without its "error:", which
    /// the program puts before every message.
    pub fn report(&self, faults: &[Fault]) -> String {
        let mut found: Vec<(Option<Spot>, &Fault)> =
            faults.iter().map(|fault| (self.find(fault), fault)).collect();
        found.sort_by_key(|(spot, _)| spot.as_ref().map(|spot| (spot.source, spot.span.start)));
        let mut reports: Vec<String> =
            found.iter().take(MOST).map(|(spot, fault)| self.show(spot, fault)).collect();
        if faults.len() > MOST {
            reports.push("error: and more".into());
        }
        without_level(reports.join("\n\n"))
    }

    fn show(&self, spot: &Option<Spot>, Fault { paths, complaint }: &Fault) -> String {
        let title = match paths.first() {
            Some(path) if !path.0.is_empty() => format!("`{path}` {}", complaint.problem),
            _ => format!("the world {}", complaint.problem),
        };
        match spot {
            None => {
                let group = Level::ERROR.primary_title(title).element(Origin::path(self.name));
                render(group.element(Level::NOTE.message(complaint.label.as_str())), complaint)
            }
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
                let span = find(setting.document(), path, mark)?;
                Some(Spot { source: Source::Setting(index), span: setting.in_shown(span) })
            })
        });
        let in_file = || fault.paths.iter().find_map(|path| find(self.document.as_item(), path, mark));
        let around = || {
            let path = &fault.paths.first()?.0;
            (1..path.len())
                .rev()
                .find_map(|len| find(self.document.as_item(), &KeyPath(path[..len].to_vec()), Mark::Key))
        };
        in_settings.or_else(|| {
            let text = self.document.raw();
            let top = || (!text.is_empty()).then_some(0..0);
            let span = in_file().or_else(around).or_else(top)?;
            Some(Spot { source: Source::File, span: first_line(text, span) })
        })
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

/// Where `path` stands in a parsed text, if it does.
fn find(top: &Item, path: &KeyPath, mark: Mark) -> Option<Range<usize>> {
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
    }
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
