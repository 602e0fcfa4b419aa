//! The menus above the picture.

use super::files::Next;
use super::{Desk, Wish};
use crate::app::viewer::engine::WorldStatus;
use crate::app::viewer::keys::{self, Action};
use crate::app::viewer::panels::files::{Purpose, Recent, recent};
use crate::app::viewer::state::Bookmark;
use crate::gpu::Pacing;
use egui::{MenuBar, Ui};

/// What menus have and keys have not.
enum Other {
    New,
    OpenFolder,
    Pace(Pacing),
    ShowTimings(bool),
    /// Worlds that were open before.
    Recent(Recent),
    /// Places that were remembered.
    GoTo(String),
    Forget(String),
}

/// The name of a panel that can be hidden alone.
pub(super) const TIMINGS: &str = "timings";

/// A wider window has room for timings beside the picture, points.
const ROOMY: f32 = 880.0;

impl Desk {
    /// Whether timings are among the panels of a window of this width: as the user has said, or else where there is room.
    pub(super) fn shows_timings(&self, width: f32) -> bool {
        self.state.panels.get(TIMINGS).copied().unwrap_or(width > ROOMY)
    }

    pub(super) fn menu(&mut self, ui: &mut Ui, width: f32) {
        let (mut action, mut other) = (None, None);
        let context = ui.ctx().clone();
        let open = self.document.is_some();
        MenuBar::new().ui(ui, |ui| {
            let mut item = |ui: &mut Ui, enabled: bool, name: &str, of: Action| {
                let button = egui::Button::new(name).shortcut_text(keys::shortcut(of).unwrap_or_default());
                if ui.add_enabled(enabled, button).clicked() {
                    action = Some(of);
                    ui.close();
                }
            };
            ui.menu_button("File", |ui| {
                if ui.button("New").clicked() {
                    other = Some(Other::New);
                }
                item(ui, true, "Open …", Action::Open);
                if ui.button("Open a folder of settings …").clicked() {
                    other = Some(Other::OpenFolder);
                }
                ui.menu_button("Recent", |ui| {
                    other = other.take().or(recent(ui, &self.state).map(Other::Recent));
                });
                ui.separator();
                item(ui, open, "Save", Action::Save);
                item(ui, open, "Save as …", Action::SaveAs);
                item(ui, open, "Read again", Action::Reload);
                ui.separator();
                item(ui, open, "Export …", Action::Export);
                item(ui, open, "Save picture …", Action::Screenshot);
                ui.separator();
                item(ui, true, "Leave", Action::Quit);
            });
            let (undo, redo) = match &self.document {
                Some(document) => {
                    (document.undo_name().map(String::from), document.redo_name().map(String::from))
                }
                None => (None, None),
            };
            ui.menu_button("Edit", |ui| {
                let name = |verb: &str, what: &Option<String>| match what {
                    Some(what) => format!("{verb} {what}"),
                    None => verb.into(),
                };
                item(ui, undo.is_some(), &name("Undo", &undo), Action::Undo);
                item(ui, redo.is_some(), &name("Redo", &redo), Action::Redo);
            });
            ui.menu_button("View", |ui| {
                let is_land = matches!(self.status.world, WorldStatus::Land { .. });
                let is_zoom = matches!(self.status.world, WorldStatus::Zoom { .. });
                let all = if is_zoom { "Level the horizon" } else { "All of the land" };
                item(ui, is_land || is_zoom, all, Action::FrameAll);
                item(ui, open, "Look round with the mouse", Action::MouseLook);
                item(ui, is_land, "Trace paths", Action::Trace);
                ui.separator();
                item(ui, is_land || is_zoom, "Copy the command line of this view", Action::CopyCommand);
                item(ui, is_land || is_zoom, "Remember this place as 1", Action::SetBookmark(1));
                ui.menu_button("Places", |ui| other = other.take().or(self.places(ui)));
                ui.separator();
                item(ui, true, "Panels", Action::TogglePanels);
                let mut timings = self.shows_timings(width);
                let checkbox = egui::Checkbox::new(&mut timings, "Timings");
                if ui.add_enabled(open, checkbox).changed() {
                    other = Some(Other::ShowTimings(timings));
                    ui.close();
                }
                item(ui, true, "Full screen", Action::FullScreen);
                ui.menu_button("Frames", |ui| {
                    for (pacing, name) in [
                        (Pacing::Fifo, "with the display"),
                        (Pacing::Mailbox, "with the display, the newest"),
                        (Pacing::Immediate, "at once"),
                    ] {
                        let radio = egui::RadioButton::new(self.pacing == pacing, name);
                        let radio = ui.add_enabled(self.pacings.contains(&pacing), radio);
                        if radio.on_disabled_hover_text("This display can't").clicked() {
                            other = Some(Other::Pace(pacing));
                        }
                    }
                });
            });
            item(ui, true, "Help", Action::Help);
        });
        if let Some(action) = action {
            self.act(&context, action);
        }
        match other {
            Some(Other::New) => self.ask_for(Next::New),
            Some(Other::OpenFolder) => self.ask(Purpose::OpenFolder, ""),
            Some(Other::Recent(Recent::Open(path))) => self.ask_for(Next::Open(path)),
            Some(Other::Recent(Recent::Forget(path))) => self.state.forget(&path),
            Some(Other::GoTo(name)) => self.go_back(&name),
            Some(Other::Forget(name)) => {
                if let Some(document) = &self.document {
                    self.state.remove_bookmark(document.source(), &name);
                }
            }
            Some(Other::ShowTimings(shown)) => {
                self.state.panels.insert(TIMINGS.into(), shown);
            }
            Some(Other::Pace(pacing)) => {
                self.pacing = pacing;
                self.state.pacing = Some(pacing.name().into());
                self.wishes.push(Wish::Pace(pacing));
            }
            None => {}
        }
    }

    /// Places to go back to.
    fn places(&self, ui: &mut Ui) -> Option<Other> {
        let mut clicked = None;
        let bookmarks =
            self.document.as_ref().map_or(&[][..], |document| self.state.bookmarks(document.source()));
        if bookmarks.is_empty() {
            ui.weak("none yet");
        }
        for Bookmark { name, .. } in bookmarks {
            ui.horizontal(|ui| {
                if ui.button(name).clicked() {
                    clicked = Some(Other::GoTo(name.clone()));
                    ui.close();
                }
                if ui.add(egui::Button::new("✖").frame(false)).on_hover_text("Forget it").clicked() {
                    clicked = Some(Other::Forget(name.clone()));
                }
            });
        }
        clicked
    }
}
