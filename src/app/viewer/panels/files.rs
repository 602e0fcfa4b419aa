//! Files: which one to open or to save to, what was open before, what an earlier run left, what became of the file on disk.

use super::super::document::{Document, OnDisk, name_from};
use super::super::recovery::Pending;
use super::super::state::State;
use crate::world::KeyPath;
use egui::{Button, Context, Frame, Id, Label, Modal, RichText, Ui};
use egui_file_dialog::{DialogState, FileDialog};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The dialog that asks for a file, and what it asks for.
pub struct Chooser {
    dialog: FileDialog,
    purpose: Option<Purpose>,
}

/// What a file is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Purpose {
    Open,
    /// A folder of settings.
    OpenFolder,
    SaveAs,
    /// Where an export goes: a folder, or a file.
    ExportFolder,
    ExportFile,
    /// A picture of what the window shows.
    Picture,
    /// The file that a key of the world names.
    Key(KeyPath),
}

/// A file that was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chosen {
    pub purpose: Purpose,
    pub path: PathBuf,
}

impl Default for Chooser {
    fn default() -> Self {
        Chooser { dialog: FileDialog::new(), purpose: None }
    }
}

impl Chooser {
    /// Begins to ask. `folder` is where the dialog starts, `name` what a file that is saved is called at first.
    pub fn ask(&mut self, purpose: Purpose, folder: &Path, name: &str) {
        let title = match purpose {
            Purpose::Open => "Open a world",
            Purpose::OpenFolder => "Open a folder of settings",
            Purpose::SaveAs => "Save the world as",
            Purpose::ExportFolder => "Export into a folder",
            Purpose::ExportFile => "Export as",
            Purpose::Picture => "Save the picture as",
            Purpose::Key(_) => "Choose a file",
        };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let dialog = FileDialog::new()
            .id("chooser")
            .title(title)
            .initial_directory(std::path::absolute(folder).unwrap_or_else(|_| folder.into()))
            .default_file_name(name)
            .default_size([560.0, 380.0])
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0]);
        self.dialog = match purpose {
            Purpose::Open => {
                dialog.add_file_filter_extensions("Worlds", vec!["toml"]).default_file_filter("Worlds")
            }
            Purpose::SaveAs => dialog.add_save_extension("World", "toml").default_save_extension("World"),
            Purpose::Picture => dialog
                .add_save_extension("PNG", "png")
                .add_save_extension("OpenEXR", "exr")
                .default_save_extension("PNG"),
            _ => dialog,
        };
        match purpose {
            Purpose::Open | Purpose::Key(_) => self.dialog.pick_file(),
            Purpose::OpenFolder | Purpose::ExportFolder => self.dialog.pick_directory(),
            Purpose::SaveAs | Purpose::ExportFile | Purpose::Picture => self.dialog.save_file(),
        }
        self.purpose = Some(purpose);
    }

    pub fn is_open(&self) -> bool {
        self.purpose.is_some()
    }

    /// Shows the dialog, if it asks; returns what was chosen.
    pub fn show(&mut self, context: &Context) -> Option<Chosen> {
        let purpose = self.purpose.clone()?;
        self.dialog.update(context);
        if let Some(path) = self.dialog.take_picked() {
            self.purpose = None;
            return Some(Chosen { purpose, path });
        }
        if !matches!(self.dialog.state(), DialogState::Open) {
            self.purpose = None;
        }
        None
    }
}

/// The name that a world gives a file which was chosen for one of its keys.
pub fn name_in_world(document: &Document, file: &Path) -> String {
    let folder = if document.folder().as_os_str().is_empty() { Path::new(".") } else { document.folder() };
    let folder = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.into());
    name_from(&folder, file)
}

/// What was clicked in the list of recent worlds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Recent {
    Open(PathBuf),
    Forget(PathBuf),
}

/// The worlds that were open, for a menu or a first page.
pub fn recent(ui: &mut Ui, state: &State) -> Option<Recent> {
    let mut clicked = None;
    for world in state.recent() {
        let name = world.path.file_name().unwrap_or(world.path.as_os_str()).to_string_lossy().into_owned();
        let folder = world.path.parent().unwrap_or(Path::new("")).display().to_string();
        let parent = world.path.parent().and_then(Path::file_name).map(|name| name.to_string_lossy());
        ui.horizontal(|ui| {
            let button = ui.add_enabled(world.exists, Button::new(name)).on_hover_text(&folder);
            if button.on_disabled_hover_text(format!("It is gone from {folder}")).clicked() {
                clicked = Some(Recent::Open(world.path.into()));
            }
            ui.weak(if world.exists { parent.unwrap_or_default() } else { "gone".into() });
            if ui.add(Button::new("×").frame(false)).on_hover_text("Forget it").clicked() {
                clicked = Some(Recent::Forget(world.path.into()));
            }
        });
    }
    if state.recent().next().is_none() {
        ui.weak("None yet.");
    }
    clicked
}

/// What is to become of what an earlier run left; the number is that of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    Open(usize),
    Discard(usize),
    /// It is offered again at the next start.
    Later,
}

/// Offers what earlier runs have left unsaved.
pub fn recovery(context: &Context, pending: &[Pending]) -> Option<Recovery> {
    if pending.is_empty() {
        return None;
    }
    let mut answer = None;
    Modal::new(Id::new("recovery")).show(context, |ui| {
        ui.set_width(380.0);
        ui.heading("Not saved when terrane ended");
        ui.label("What was changed in these worlds was kept.");
        ui.add_space(6.0);
        for (index, pending) in pending.iter().enumerate() {
            let source = pending.source();
            let name = source.file_name().unwrap_or(source.as_os_str()).to_string_lossy().into_owned();
            ui.horizontal(|ui| {
                ui.strong(name).on_hover_text(source.display().to_string());
                ui.weak(ago(pending.time()));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if ui.button("Discard").clicked() {
                        answer = Some(Recovery::Discard(index));
                    }
                    if ui.button("Open").clicked() {
                        answer = Some(Recovery::Open(index));
                    }
                });
            });
        }
        ui.add_space(6.0);
        if ui.button("Later").on_hover_text("It is offered again at the next start").clicked() {
            answer = Some(Recovery::Later);
        }
    });
    answer
}

fn ago(time: SystemTime) -> String {
    let minutes = time.elapsed().unwrap_or_default().as_secs() / 60;
    match minutes {
        0 => "just now".into(),
        1..120 => format!("{minutes} min ago"),
        120..2880 => format!("{} h ago", minutes / 60),
        _ => format!("{} days ago", minutes / 1440),
    }
}

/// What is to be done about a file that changed on disk, or an edit that was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    Reload,
    Overwrite,
    SaveAs,
    Dismiss,
}

/// A strip that tells what is not as it should be: the file has changed or gone, what was edited makes no world.
pub fn notice(ui: &mut Ui, document: &Document, on_disk: OnDisk) -> Option<Notice> {
    let mut answer = None;
    let mut strip = |text: &str, hover: &str, choices: &[(&str, &str, Notice)]| {
        Frame::new().fill(ui.visuals().faint_bg_color).inner_margin(6).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let text = RichText::new(text).color(ui.visuals().warn_fg_color);
                let label = ui.add(Label::new(text).wrap());
                if !hover.is_empty() {
                    label.on_hover_text(RichText::new(hover).monospace());
                }
                for (name, hover, choice) in choices {
                    if ui.button(*name).on_hover_text(*hover).clicked() {
                        answer = Some(*choice);
                    }
                }
            });
        });
    };
    let reload = match document.is_dirty() {
        true => "What is not saved can be had back by undo",
        false => "Show the world that the file has now",
    };
    match on_disk {
        OnDisk::Same => {}
        OnDisk::Changed => strip(
            "The file has changed on disk.",
            "",
            &[
                ("Read it again", reload, Notice::Reload),
                ("Overwrite", "With what is shown", Notice::Overwrite),
                ("Save as …", "Leave the file as it is", Notice::SaveAs),
            ],
        ),
        OnDisk::Gone => strip(
            "The file is gone.",
            "",
            &[
                ("Write it again", "Where it was", Notice::Overwrite),
                ("Save as …", "Somewhere else", Notice::SaveAs),
            ],
        ),
    }
    if let Some(refused) = document.refused() {
        strip(&refused.message, &refused.report, &[("Close", "The world stays as it was", Notice::Dismiss)]);
    }
    answer
}

/// What is to become of what is not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsaved {
    Save,
    Discard,
    Cancel,
}

/// Asks before strokes of the brush are lost.
pub fn painted(context: &Context) -> Option<Unsaved> {
    let text = "The world's file is saved, but strokes of the brush are no part of it.";
    left(context, "Leave what was painted?", text, ["Leave it", "Cancel"])
}

/// Asks before an export is ended.
pub fn exporting(context: &Context) -> Option<Unsaved> {
    let text =
        "Files are being written. Those that are there are whole; land that was made for them is kept.";
    left(context, "End the export?", text, ["End it", "Wait"])
}

/// Asks before something is left that can't be saved.
fn left(context: &Context, question: &str, text: &str, [leave, stay]: [&str; 2]) -> Option<Unsaved> {
    let mut answer = None;
    let modal = Modal::new(Id::new(question)).show(context, |ui| {
        ui.set_width(320.0);
        ui.heading(question);
        ui.add(Label::new(text).wrap());
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            for (name, choice) in [(leave, Unsaved::Discard), (stay, Unsaved::Cancel)] {
                if ui.button(name).clicked() {
                    answer = Some(choice);
                }
            }
        });
    });
    if modal.should_close() { Some(Unsaved::Cancel) } else { answer }
}

/// Asks before another world is opened, or the window closed.
pub fn unsaved(context: &Context, document: &Document) -> Option<Unsaved> {
    let mut answer = None;
    let modal = Modal::new(Id::new("unsaved")).show(context, |ui| {
        ui.set_width(320.0);
        ui.heading("Save what was changed?");
        let name = document.source().display().to_string();
        ui.add(Label::new(RichText::new(name).weak()).truncate());
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let save = if document.path().is_some() { "Save" } else { "Save as …" };
            for (name, choice) in
                [(save, Unsaved::Save), ("Discard", Unsaved::Discard), ("Cancel", Unsaved::Cancel)]
            {
                if ui.button(name).clicked() {
                    answer = Some(choice);
                }
            }
        });
    });
    if modal.should_close() { Some(Unsaved::Cancel) } else { answer }
}
