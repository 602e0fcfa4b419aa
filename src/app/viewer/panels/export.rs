//! The form for everything that `terrane export` can do, made from the declaration of its options: a new option needs no work here.
//! What it yields are that command's arguments.

use super::super::export::Said;
use clap::builder::PossibleValue;
use clap::{Arg, ArgAction, Command};
use egui::{ComboBox, RichText, ScrollArea, TextEdit, Ui};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the form holds.
pub struct Form {
    command: Command,
    out: PathBuf,
    /// Words that were chosen or typed, by the option's name.
    values: BTreeMap<String, Vec<String>>,
}

/// What was clicked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Run `terrane export WORLD` with these arguments.
    Export(Vec<String>),
    /// Ask for a folder, or a file, to write to.
    ChooseFolder,
    ChooseFile,
    Cancel,
}

/// How an option is shown.
enum Widget {
    Switch,
    /// One of some words.
    Choice(Vec<PossibleValue>),
    /// Any of them.
    Several(Vec<PossibleValue>),
    Text,
}

/// Options that the viewer answers itself.
const ANSWERED: &[&str] = &["world", "set", "seed", "device", "memory_limit", "json", "quiet", "out", "help"];
/// Those of an endless zoom, beside its layers.
const OF_ZOOM: &[&str] = &["size", "from"];
const LAYERS_OF_ZOOM: &[&str] = &["mesh", "tiles"];

impl Form {
    /// `command` is that of `terrane export`; what it writes goes to `out` unless the user chooses something else.
    pub fn new(command: Command, out: &Path) -> Form {
        Form { command, out: out.into(), values: BTreeMap::new() }
    }

    pub fn set_out(&mut self, out: &Path) {
        self.out = out.into();
    }

    /// The arguments behind the world's name.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = Vec::new();
        for option in self.command.get_arguments() {
            let Some(values) = self.values.get(option.get_id().as_str()).filter(|values| !values.is_empty())
            else {
                continue;
            };
            arguments.extend(option.get_long().map(|long| format!("--{long}")));
            match widget(option) {
                Widget::Switch => {}
                Widget::Several(_) => arguments.push(values.join(",")),
                _ => arguments.extend(values.iter().cloned()),
            }
        }
        arguments.push("-o".into());
        arguments.push(self.out.display().to_string());
        arguments
    }

    /// What is wrong with the arguments, if anything is.
    fn mistake(&self) -> Option<String> {
        let words = ["export".to_string(), "world.toml".into()].into_iter().chain(self.arguments());
        let error = self.command.clone().try_get_matches_from(words).err()?;
        let text = error.to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        Some(text.lines().take_while(|line| !line.trim().is_empty()).collect::<Vec<_>>().join(" "))
    }

    /// Shows the form, and what an export under way says.
    pub fn show(&mut self, ui: &mut Ui, is_zoom: bool, said: Option<&Said>) -> Option<Outcome> {
        let mut outcome = None;
        ui.heading("Export");
        let mut out = self.out.display().to_string();
        ui.horizontal(|ui| {
            ui.label("to").on_hover_text("A folder, ending in /, for one file a layer; or a file");
            let width = ui.available_width() - 124.0;
            if ui.add(TextEdit::singleline(&mut out).desired_width(width)).changed() {
                self.out = out.into();
            }
            if ui.button("Folder …").clicked() {
                outcome = Some(Outcome::ChooseFolder);
            }
            if ui.button("File …").clicked() {
                outcome = Some(Outcome::ChooseFile);
            }
        });
        let options: Vec<Arg> = self.command.get_arguments().cloned().collect();
        ScrollArea::vertical().max_height(ui.available_height() - 70.0).show(ui, |ui| {
            for option in options.iter().filter(|option| is_shown(option, is_zoom)) {
                ui.push_id(option.get_id().as_str(), |ui| self.option(ui, option, is_zoom));
            }
        });
        ui.add_space(6.0);
        let mistake = self.mistake();
        if let Some(mistake) = &mistake {
            ui.colored_label(ui.visuals().error_fg_color, mistake);
        }
        ui.horizontal(|ui| match said {
            Some(said) => {
                // The button comes first: where it is pressed, it is the same one when it is let go, whatever else is told by then.
                let row = egui::Layout::right_to_left(egui::Align::Center);
                ui.with_layout(row, |ui| {
                    if ui.button("Cancel").clicked() {
                        outcome = Some(Outcome::Cancel);
                    }
                    progress(ui, said);
                });
            }
            None => {
                if ui.add_enabled(mistake.is_none(), egui::Button::new("Write files")).clicked() {
                    outcome = Some(Outcome::Export(self.arguments()));
                }
                if ui.button("Close").clicked() {
                    outcome = Some(Outcome::Cancel);
                }
            }
        });
        outcome
    }

    fn option(&mut self, ui: &mut Ui, option: &Arg, is_zoom: bool) {
        let id = option.get_id().as_str().to_string();
        let name = option.get_long().unwrap_or(&id).replace('-', " ");
        let help = option.get_long_help().or(option.get_help()).map(ToString::to_string).unwrap_or_default();
        let values = self.values.entry(id).or_default();
        ui.horizontal_top(|ui| {
            let row = ui.spacing().interact_size.y;
            ui.allocate_ui(egui::vec2(96.0, row), |ui| {
                ui.set_min_width(96.0);
                ui.label(name).on_hover_text(&help);
            });
            match widget(option) {
                Widget::Switch => {
                    let mut on = !values.is_empty();
                    if ui.checkbox(&mut on, "").on_hover_text(&help).changed() {
                        *values = if on { vec![String::new()] } else { Vec::new() };
                    }
                }
                Widget::Choice(words) => choice(ui, &words, values),
                Widget::Several(words) => {
                    ui.horizontal_wrapped(|ui| several(ui, &words, values, is_zoom));
                }
                Widget::Text => {
                    let mut text = values.first().cloned().unwrap_or_default();
                    let hint =
                        option.get_value_names().and_then(|names| names.first()).map(ToString::to_string);
                    let field = TextEdit::singleline(&mut text).desired_width(120.0);
                    if ui.add(field.hint_text(hint.unwrap_or_default())).on_hover_text(&help).changed() {
                        *values = if text.trim().is_empty() { Vec::new() } else { vec![text.trim().into()] };
                    }
                }
            }
        });
    }
}

fn choice(ui: &mut Ui, words: &[PossibleValue], values: &mut Vec<String>) {
    let current = values.first().cloned();
    let text = current.clone().unwrap_or_else(|| "default".into());
    ComboBox::from_id_salt("choice").selected_text(text).show_ui(ui, |ui| {
        if ui.selectable_label(current.is_none(), RichText::new("default").italics()).clicked() {
            values.clear();
        }
        for word in words {
            let help = word.get_help().map(ToString::to_string).unwrap_or_default();
            let is_current = current.as_deref() == Some(word.get_name());
            if ui.selectable_label(is_current, word.get_name()).on_hover_text(help).clicked() {
                *values = vec![word.get_name().into()];
            }
        }
    });
}

fn several(ui: &mut Ui, words: &[PossibleValue], values: &mut Vec<String>, is_zoom: bool) {
    for word in words.iter().map(PossibleValue::get_name) {
        let is_of_zoom = LAYERS_OF_ZOOM.contains(&word);
        let is_there = if is_zoom { is_of_zoom } else { word != "tiles" };
        if !is_there {
            continue;
        }
        let mut on = values.iter().any(|value| value == word);
        if ui.checkbox(&mut on, word.replace('_', " ")).changed() {
            values.retain(|value| value != word);
            if on {
                values.push(word.into());
            }
        }
    }
}

/// How far an export has come.
fn progress(ui: &mut Ui, said: &Said) {
    let text = RichText::new(&said.last).small();
    match said.share {
        Some(share) => {
            ui.add(egui::ProgressBar::new(share).desired_width(ui.available_width()).text(text));
        }
        None => {
            ui.spinner();
            ui.add(egui::Label::new(text).truncate());
        }
    }
}

fn is_shown(option: &Arg, is_zoom: bool) -> bool {
    let id = option.get_id().as_str();
    !ANSWERED.contains(&id)
        && option.get_long().is_some()
        && (is_zoom || !OF_ZOOM.contains(&id))
        && (!is_zoom || OF_ZOOM.contains(&id) || id == "layers")
}

fn widget(option: &Arg) -> Widget {
    let words = option.get_possible_values();
    match option.get_action() {
        ArgAction::SetTrue => Widget::Switch,
        ArgAction::Append if !words.is_empty() => Widget::Several(words),
        _ if !words.is_empty() => Widget::Choice(words),
        _ => Widget::Text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::cli::export_command;

    fn form() -> Form {
        Form::new(export_command(), Path::new("out/"))
    }

    fn with(values: &[(&str, &[&str])]) -> Form {
        let mut form = form();
        for (name, words) in values {
            form.values.insert((*name).into(), words.iter().map(|word| (*word).into()).collect());
        }
        form
    }

    #[test]
    fn a_form_is_what_the_command_takes() {
        assert_eq!(form().arguments(), ["-o", "out/"]);
        assert_eq!(form().mistake(), None);
        let form = with(&[
            ("layers", &["height", "mesh"]),
            ("preset", &["unity"]),
            ("flip", &[""]),
            ("cells", &["513"]),
        ]);
        assert_eq!(form.mistake(), None);
        let arguments = form.arguments().join(" ");
        assert_eq!(arguments, "--layer height,mesh --preset unity --cells 513 --flip -o out/");
    }

    #[test]
    fn what_the_command_refuses_is_told() {
        let mistake = with(&[("cells", &["3"])]).mistake().expect("a mistake");
        assert!(mistake.contains("--cells"), "{mistake}");
        assert!(with(&[("tiles", &["two"])]).mistake().is_some());
    }

    #[test]
    fn every_option_has_a_widget_or_an_answer() {
        let command = export_command();
        let ids: Vec<&str> = command.get_arguments().map(|option| option.get_id().as_str()).collect();
        for answered in ANSWERED.iter().chain(OF_ZOOM).filter(|id| **id != "help") {
            assert!(ids.contains(answered), "{answered} is not among {ids:?}");
        }
        let shown = |is_zoom| command.get_arguments().filter(|option| is_shown(option, is_zoom)).count();
        assert_eq!(shown(false) + OF_ZOOM.len() + ANSWERED.len() - 1, ids.len(), "{ids:?}");
        assert_eq!(shown(true), OF_ZOOM.len() + 1);
        let layers = command.get_arguments().find(|option| option.get_id() == "layers").map(widget);
        assert!(matches!(layers, Some(Widget::Several(words)) if words.len() > 10));
    }
}
