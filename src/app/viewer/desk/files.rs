//! The file that lies on the desk: opened, watched, saved, exported; and the dialogs that ask about it.

use super::{Desk, Wish};
use crate::app::viewer::document::{self, Document, OnDisk};
use crate::app::viewer::engine::{Command, WorldStatus};
use crate::app::viewer::export::{Ended, Export};
use crate::app::viewer::panels::files::{self, Chosen, Notice, Purpose, Recent, Recovery, Unsaved};
use crate::app::viewer::panels::{export as form, help, picture, welcome};
use crate::app::viewer::{shipped, state};
use crate::world::Overrides;
use egui::{Align2, Context, Panel, Ui, vec2};
use notify::Watcher;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// What is waited for until the user has said what becomes of changes.
#[derive(Clone, Debug)]
pub(super) enum Next {
    Close,
    New,
    Open(PathBuf),
}

/// What only the user knows.
enum Question {
    /// What becomes of files that are being written.
    Export,
    /// What becomes of changes.
    Unsaved,
    /// What becomes of strokes of the brush.
    Strokes,
}

impl Desk {
    /// Shows a world.
    pub(super) fn take(&mut self, document: Document) {
        let world = document.world().clone();
        self.wishes.push(Wish::Title(format!("{} - terrane", world.name)));
        // A world without a file yet can't be opened again.
        if document.source().exists() {
            self.state.opened(document.source());
        }
        self.engine.send(Command::Open(world.clone()));
        self.awaited += 1;
        self.messages.clear();
        (self.frame, self.status, self.look, self.on_disk) = Default::default();
        self.timings.clear();
        // What is shown or asked about the world before goes with it.
        (self.form, self.section, self.pointed, self.brush, self.painted) = Default::default();
        self.exposure = picture::Exposure::of(&world);
        world.warnings.iter().for_each(|warning| self.warn(warning.clone()));
        self.shown = Some(world);
        self.watch(&document);
        self.document = Some(document);
    }

    /// Looks whether somebody else writes to the file.
    fn watch(&mut self, document: &Document) {
        self.watcher = None;
        let Some(path) = document.path() else { return };
        let (touched, wake) = (self.touched.clone(), self.wake.clone());
        let name = path.file_name().map(ToOwned::to_owned);
        let told = move |event: notify::Result<notify::Event>| {
            let ours = |path: &PathBuf| path.file_name().map(ToOwned::to_owned) == name;
            if event.is_ok_and(|event| !event.kind.is_access() && event.paths.iter().any(ours)) {
                touched.store(true, Ordering::Relaxed);
                wake();
            }
        };
        // Where files can't be watched, they are read again when asked for.
        let Ok(mut watcher) = notify::recommended_watcher(told) else { return };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if watcher.watch(folder, notify::RecursiveMode::NonRecursive).is_ok() {
            self.watcher = Some(watcher);
        }
    }

    /// Opens a world, and asks nothing.
    pub fn open(&mut self, path: &Path) {
        self.next = None;
        match Document::open(path, &Overrides::default()) {
            Ok(document) => self.take(document),
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// Does what comes next, or asks first what becomes of changes.
    pub(super) fn ask_for(&mut self, next: Next) {
        self.next = Some(next);
        self.go_on();
    }

    fn do_next(&mut self) {
        match self.next.take() {
            Some(Next::Close) => {
                if let Some(keeper) = &mut self.keeper {
                    keeper.forget();
                }
                // Or it would be kept for the next start.
                self.document = None;
                self.over = true;
            }
            Some(Next::New) => match Document::untitled("untitled", "format = 1\n", Path::new("")) {
                Ok(document) => self.take(document),
                Err(error) => self.fail(error.to_string()),
            },
            Some(Next::Open(path)) => self.open(&path),
            None => {}
        }
    }

    /// Does what waited for an answer, if nothing is left to be asked.
    fn go_on(&mut self) {
        if self.next.is_some() && self.question().is_none() {
            self.do_next();
        }
    }

    /// What is asked before that.
    fn question(&self) -> Option<Question> {
        let leaves_export = self.export.is_some() && matches!(self.next, Some(Next::Close));
        match &self.document {
            _ if leaves_export => Some(Question::Export),
            Some(document) if document.is_dirty() => Some(Question::Unsaved),
            _ if self.has_strokes() => Some(Question::Strokes),
            _ => None,
        }
    }

    /// Whether there are strokes of the brush on the land: no world file has them.
    fn has_strokes(&self) -> bool {
        self.painted || matches!(self.status.world, WorldStatus::Land { strokes: 1.., .. })
    }

    /// Closes, or asks first what becomes of changes.
    pub fn ask_to_close(&mut self) {
        self.ask_for(Next::Close);
    }

    /// Somebody has written to the world's file.
    pub(super) fn look_at_file(&mut self) {
        let Some(document) = &mut self.document else { return };
        self.on_disk = document.on_disk();
        document.note_gone(matches!(self.on_disk, OnDisk::Gone));
        if matches!(self.on_disk, OnDisk::Same) {
            document.note_same();
        }
        if matches!(self.on_disk, OnDisk::Changed) && !document.is_dirty() {
            self.reload();
        }
    }

    pub(super) fn reload(&mut self) {
        let Some(document) = &mut self.document else { return };
        match document.reload() {
            Ok(new) => {
                self.on_disk = document.on_disk();
                self.say(if new { "read the file again" } else { "the file says the same" }.into());
            }
            Err(error) => {
                self.on_disk = OnDisk::Same;
                // What is wrong with a world is shown beside it.
                if !matches!(error, document::Error::World(_)) {
                    self.fail(error.to_string());
                }
            }
        }
    }

    /// Keeps what has not been saved, and what is remembered; `window` is where that stands.
    pub fn keep(&mut self, window: Option<state::Window>) {
        if let (Some(keeper), Some(document)) = (&mut self.keeper, &self.document) {
            // Nobody is left to be told.
            let _ = keeper.keep(document);
        }
        self.state.window = match (window, self.state.window) {
            // It has the screen's size.
            (Some(window), Some(before)) if window.maximised => {
                Some(state::Window { maximised: true, ..before })
            }
            (window, before) => window.or(before),
        };
        if let Some(folder) = &self.folder {
            let _ = self.state.save(folder);
        }
    }

    /// Worlds that are dropped on the window.
    pub(super) fn dropped(&mut self, ui: &Ui) {
        let path = ui.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_path_buf()));
        if let Some(path) = path {
            self.ask_for(Next::Open(path));
        }
    }

    pub(super) fn choose(&mut self, choice: welcome::Choice) {
        match choice {
            welcome::Choice::Shipped(world) => {
                let folder = self.folder.clone().unwrap_or_else(std::env::temp_dir);
                match shipped::unpack(world, &folder) {
                    Ok(path) => self.open(&path),
                    Err(error) => self.fail(error.to_string()),
                }
            }
            welcome::Choice::Recent(Recent::Open(path)) => self.open(&path),
            welcome::Choice::Recent(Recent::Forget(path)) => self.state.forget(&path),
            welcome::Choice::Open => self.ask(Purpose::Open, ""),
        }
    }

    pub(super) fn ask(&mut self, purpose: Purpose, name: &str) {
        self.look_round(false);
        let folder =
            self.document.as_ref().and_then(|document| document.source().parent()).map(Path::to_path_buf);
        self.chooser.ask(purpose, &folder.unwrap_or_default(), name);
    }

    pub(super) fn name(&self, ending: &str) -> String {
        let name = self.document.as_ref().map_or("world", |document| document.world().name.as_str());
        format!("{name}.{ending}")
    }

    pub(super) fn ask_where_to_save(&mut self) {
        self.ask(Purpose::SaveAs, &self.name("toml"));
    }

    pub(super) fn ask_for_picture(&mut self) {
        self.ask(Purpose::Picture, &self.name("png"));
    }

    pub(super) fn save(&mut self) {
        let Some(document) = &mut self.document else { return };
        if document.path().is_none() {
            return self.ask_where_to_save();
        }
        match document.save() {
            Ok(()) => {
                self.on_disk = OnDisk::Same;
                self.say("saved".into());
            }
            Err(error) => {
                self.on_disk = document.on_disk();
                self.fail(error.to_string());
            }
        }
    }

    fn save_as(&mut self, path: &Path) {
        let Some(document) = &mut self.document else { return };
        match document.save_as(path) {
            Ok(()) => {
                self.on_disk = OnDisk::Same;
                self.state.opened(path);
                self.wishes.push(Wish::Title(format!("{} - terrane", document.world().name)));
                if let Some(document) = self.document.take() {
                    self.watch(&document);
                    self.document = Some(document);
                }
                self.say(format!("saved as {}", path.display()));
            }
            Err(error) => self.fail(error.to_string()),
        }
    }

    fn chosen(&mut self, Chosen { purpose, path }: Chosen) {
        match purpose {
            Purpose::Open | Purpose::OpenFolder => self.ask_for(Next::Open(path)),
            Purpose::SaveAs => {
                self.save_as(&path);
                self.go_on();
            }
            Purpose::ExportFolder => {
                if let Some(form) = &mut self.form {
                    form.set_out(&path.join(""));
                }
            }
            Purpose::ExportFile => {
                if let Some(form) = &mut self.form {
                    form.set_out(&path);
                }
            }
            Purpose::Picture => self.engine.send(Command::Picture(path)),
            Purpose::Key(key) => {
                if let Some(document) = &mut self.document {
                    let name = files::name_in_world(document, &path);
                    document.set(&key, name.into());
                }
            }
        }
    }

    pub(super) fn notices(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        if document.refused().is_none() && matches!(self.on_disk, OnDisk::Same) {
            return;
        }
        let notice = Panel::top("notice").show(ui, |ui| files::notice(ui, document, self.on_disk)).inner;
        match notice {
            Some(Notice::Reload) => self.reload(),
            Some(Notice::Overwrite) => {
                let result = self.document.as_mut().map(Document::overwrite);
                match result {
                    Some(Err(error)) => self.fail(error.to_string()),
                    _ => self.on_disk = OnDisk::Same,
                }
            }
            Some(Notice::SaveAs) => self.ask_where_to_save(),
            Some(Notice::Dismiss) => {
                if let Some(document) = &mut self.document {
                    document.forget_refusal();
                }
            }
            None => {}
        }
    }

    /// Dialogs, and the help page.
    pub(super) fn windows(&mut self, context: &Context) {
        if let Some(chosen) = self.chooser.show(context) {
            self.chosen(chosen);
        }
        let mut help = self.help;
        let most = context.content_rect().size() - vec2(40.0, 60.0);
        egui::Window::new("Help")
            .open(&mut help)
            .default_size(vec2(560.0, 520.0).min(most))
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(context, help::show);
        self.help = help;
        self.show_form(context);
        match files::recovery(context, &self.pending) {
            Some(Recovery::Open(index)) if index < self.pending.len() => {
                let pending = self.pending.remove(index);
                match pending.open() {
                    Ok(document) => {
                        self.take(document);
                        if let (Some(keeper), Some(document)) = (&mut self.keeper, &self.document)
                            && keeper.keep(document).is_ok()
                        {
                            pending.discard();
                        }
                    }
                    Err(error) => self.fail(error.to_string()),
                }
                self.pending.clear();
            }
            Some(Recovery::Discard(index)) if index < self.pending.len() => {
                self.pending.remove(index).discard()
            }
            Some(Recovery::Later) => self.pending.clear(),
            _ => {}
        }
        if self.next.is_some() && !self.chooser.is_open() {
            self.ask_on(context);
        }
    }

    /// Asks what must be known before what is next.
    fn ask_on(&mut self, context: &Context) {
        let answer = match (self.question(), &self.document) {
            (Some(Question::Unsaved), Some(document)) => files::unsaved(context, document),
            (Some(Question::Strokes), _) => files::painted(context),
            (Some(Question::Export), _) => files::exporting(context),
            // What was asked about has ended meanwhile.
            _ => return self.do_next(),
        };
        match (answer, self.question()) {
            (Some(Unsaved::Save), _) => {
                self.save();
                self.go_on();
            }
            (Some(Unsaved::Discard), Some(Question::Export)) => {
                self.export = None;
                self.go_on();
            }
            (Some(Unsaved::Discard), _) => self.do_next(),
            (Some(Unsaved::Cancel), _) => self.next = None,
            (None, _) => {}
        }
    }

    pub(super) fn open_form(&mut self) {
        let Some(document) = &self.document else { return };
        let out = document.source().with_extension("").join("");
        self.form = Some(form::Form::new(crate::app::cli::export_command(), &out));
    }

    fn show_form(&mut self, context: &Context) {
        let Some(form) = &mut self.form else { return };
        let is_zoom = self.document.as_ref().is_some_and(|document| document.world().zoom.is_some());
        let said = self.export.as_ref().map(Export::said);
        if said.is_some() {
            context.request_repaint_after(Duration::from_millis(200));
        }
        let most = context.content_rect().size() - vec2(40.0, 60.0);
        let outcome = egui::Window::new("Export")
            .title_bar(false)
            .fixed_size(vec2(460.0, 520.0).min(most))
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(context, |ui| form.show(ui, is_zoom, said.as_ref()))
            .and_then(|shown| shown.inner.flatten());
        match outcome {
            Some(form::Outcome::Export(mut arguments)) => {
                let Some(document) = &self.document else { return };
                arguments.extend(self.device.words());
                match Export::begin(document, &arguments) {
                    Ok(export) => self.export = Some(export),
                    Err(error) => self.fail(error.to_string()),
                }
            }
            Some(form::Outcome::ChooseFolder) => self.ask(Purpose::ExportFolder, ""),
            Some(form::Outcome::ChooseFile) => self.ask(Purpose::ExportFile, &self.name("tiff")),
            Some(form::Outcome::Cancel) => match &mut self.export {
                Some(export) => export.cancel(),
                None => self.form = None,
            },
            None => {}
        }
    }

    /// Takes in what the program that exports has to say at its end.
    pub(super) fn look_at_export(&mut self) {
        let Some(ended) = self.export.as_mut().and_then(Export::ended) else { return };
        self.export = None;
        match ended {
            Ended::Done(said) => {
                self.form = None;
                self.say(format!("exported; {said}"));
            }
            Ended::Cancelled(said) => self.say(format!("the export was {said}")),
            Ended::Failed(said) => {
                // Who was about to leave should see it.
                self.next = self.next.take().filter(|next| !matches!(next, Next::Close));
                self.fail(said);
            }
        }
    }
}
