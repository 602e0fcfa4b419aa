//! What lies before the user: the picture of the world, and the panels round it.

mod files;
mod menu;
mod messages;
mod places;

use self::files::Next;
use self::menu::TIMINGS;
use self::messages::{Messages, Tone};
use super::camera::Steering;
use super::document::{Document, OnDisk};
use super::engine::{Command, Course, Engine, Frame, News, Section, Status, WorldStatus};
use super::export::Export;
use super::keys::{self, Action, Motion};
use super::panels::files::{Chooser, Purpose};
use super::panels::parameters::{Foresight, Wishes};
use super::panels::{export as form, land, parameters, picture, plants, rounded, timings, welcome, zoom};
use super::recovery::{self, Keeper, Pending};
#[cfg(feature = "reload")]
use super::shaders::{Replaced, Shaders};
use super::state::State;
use super::theme;
use super::window::WORLD;
use crate::app::Error;
use crate::app::cli::options::DeviceOptions;
use crate::gpu::{Image, Pacing, Timing, format::Rgba8};
use crate::terrain::Stage;
use crate::world::World;
use crate::zoom::marks::Marks;
use egui::{Align2, Color32, Context, Panel, PointerButton, Rect, RichText, Sense, Ui, Vec2, vec2};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What only the window can do.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// The mouse is taken for looking round, or given back.
    Grab(bool),
    FullScreen,
    Title(String),
    /// The window as a PNG.
    Screenshot(PathBuf),
    /// Another world in place of this one, whatever was changed.
    Open(PathBuf),
    /// Points.
    Resize([f32; 2]),
    Pace(Pacing),
    /// The program that draws panels has been replaced.
    #[cfg(feature = "reload")]
    Reprogram,
    Close,
}

pub struct Desk {
    engine: Engine,
    wake: Arc<dyn Fn() + Send + Sync>,
    document: Option<Document>,
    /// What the engine was told last.
    shown: Option<Arc<World>>,
    frame: Option<Frame>,
    status: Status,
    wishes: Vec<Wish>,

    folder: Option<PathBuf>,
    state: State,
    keeper: Option<Keeper>,
    pending: Vec<Pending>,
    chooser: Chooser,
    form: Option<form::Form>,
    export: Option<Export>,
    /// What exports run on, too.
    device: DeviceOptions,
    watcher: Option<notify::RecommendedWatcher>,
    touched: Arc<AtomicBool>,
    on_disk: OnDisk,
    #[cfg(feature = "reload")]
    shaders: Option<Shaders>,
    next: Option<Next>,
    /// Worlds that the engine was told to open and has not begun with.
    awaited: usize,

    welcome: welcome::Welcome,
    timings: timings::Timings,
    look: land::Look,
    exposure: picture::Exposure,
    brush: land::Brush,
    /// The engine may not have told yet of a stroke.
    painted: bool,
    section: Option<Section>,
    /// Whether the section is seen.
    cutting: bool,
    /// Where the mouse was in the picture when it was last asked about.
    pointed: Option<[f32; 2]>,
    code: zoom::Code,
    marks: Marks,
    filter: String,
    /// What changes of the world would do.
    foresight: Foresight,
    panels: bool,
    help: bool,

    /// Of the picture in the window, pixels.
    size: [u32; 2],
    steering: Steering,
    /// log₂ of how much faster than usual it goes.
    speed: f32,
    looking: bool,
    /// Whether a drag goes round the middle of the picture, or looks round.
    orbits: bool,
    pacing: Pacing,
    /// Those that the window can have.
    pacings: Vec<Pacing>,
    over: bool,
    messages: Messages,
    heard: Instant,
}

/// Radians that the eye turns for a point of the mouse's way.
const LOOK: f32 = 0.004;

/// What the engine said last may be on its way to the window for so long.
const QUIET: Duration = Duration::from_millis(100);

impl Desk {
    pub fn new(
        context: &Context,
        engine: Engine,
        wake: Arc<dyn Fn() + Send + Sync>,
        device: DeviceOptions,
        (pacing, pacings): (Pacing, Vec<Pacing>),
        document: Option<Document>,
        (folder, state, warning): (Option<PathBuf>, State, Option<String>),
    ) -> Desk {
        theme::apply(context);
        let waker = wake.clone();
        let foreseen = move || waker();
        let mut desk = Desk {
            engine,
            wake,
            document: None,
            shown: None,
            frame: None,
            status: Status::default(),
            wishes: Vec::new(),
            keeper: folder.as_deref().map(Keeper::new),
            pending: folder.as_deref().map(recovery::pending).unwrap_or_default(),
            folder,
            state,
            chooser: Chooser::default(),
            form: None,
            export: None,
            device,
            watcher: None,
            touched: Arc::default(),
            on_disk: OnDisk::Same,
            #[cfg(feature = "reload")]
            shaders: None,
            next: None,
            awaited: 0,
            welcome: Default::default(),
            timings: Default::default(),
            look: Default::default(),
            exposure: Default::default(),
            brush: Default::default(),
            painted: false,
            section: None,
            cutting: false,
            pointed: None,
            code: Default::default(),
            marks: Marks::default(),
            filter: String::new(),
            foresight: Foresight::new(foreseen),
            panels: true,
            help: false,
            size: [0, 0],
            steering: Steering::default(),
            speed: 0.0,
            looking: false,
            orbits: true,
            pacing,
            pacings,
            over: false,
            messages: Messages::default(),
            heard: Instant::now(),
        };
        if let Some(document) = document {
            desk.take(document);
        }
        if let Some(warning) = warning {
            desk.warn(warning);
        }
        desk
    }

    /// Shaders are watched from now on, and programs replaced when they are edited.
    #[cfg(feature = "reload")]
    pub fn with_shaders(mut self, gpu: &crate::gpu::Gpu) -> Desk {
        match Shaders::watch(gpu, self.wake.clone()) {
            Ok(shaders) => self.shaders = Some(shaders),
            Err(reason) => self.fail(reason),
        }
        self
    }

    /// Takes edited shaders over.
    #[cfg(feature = "reload")]
    fn look_at_shaders(&mut self) {
        while let Some(Replaced { rooms, files, refusals }) =
            self.shaders.as_ref().and_then(Shaders::replaced)
        {
            // What was wrong with them is mended.
            let files_in = |sentence: &str| files.iter().any(|file| sentence.contains(file.as_str()));
            self.messages.forget_failures(files_in);
            refusals.into_iter().for_each(|refusal| self.fail(refusal));
            if rooms.is_empty() {
                continue;
            }
            self.say(format!("read {} again", files.join(", ")));
            if rooms.contains("viewer") {
                self.wishes.push(Wish::Reprogram);
            }
            self.engine.send(Command::Reprogram { land: rooms.contains("terrain") });
        }
    }

    /// Tells what was done.
    pub fn say(&mut self, sentence: String) {
        self.messages.push(sentence, Tone::Said);
    }

    /// Tells what should be known.
    fn warn(&mut self, sentence: String) {
        self.messages.push(sentence, Tone::Warned);
    }

    /// Tells what failed.
    pub fn fail(&mut self, sentence: String) {
        self.messages.push(sentence, Tone::Failed);
    }

    /// Takes in what the engine has to say.
    ///
    /// # Errors
    /// What ended it.
    pub fn listen(&mut self) -> Result<(), Error> {
        // What it says before it ends is heard.
        let is_dead = self.engine.is_dead();
        while let Some(news) = self.engine.news() {
            self.heard = Instant::now();
            match news {
                News::Opened => self.awaited = self.awaited.saturating_sub(1),
                // They are of the world before.
                News::Frame(_) | News::Status(_) | News::Section(_) if self.awaited > 0 => {}
                News::Frame(frame) => self.frame = Some(frame),
                News::Status(status) => {
                    self.timings.note(&status);
                    self.status = *status;
                    self.painted &= !self.engine.has_heard();
                }
                News::Section(section) => self.section = section.or(self.section.take()),
                News::Said(sentence) => self.say(sentence),
                News::Warned(sentence) => self.warn(sentence),
                News::Failed(sentence) => self.fail(sentence),
                News::Ended(error) => return Err(error),
            }
        }
        if self.touched.swap(false, Ordering::Relaxed) {
            self.look_at_file();
        }
        #[cfg(feature = "reload")]
        self.look_at_shaders();
        self.look_at_export();
        match is_dead {
            true => Err(Error::Window("the engine has ended; what it said is above".into())),
            false => Ok(()),
        }
    }

    pub fn picture(&self) -> Option<&Image<Rgba8>> {
        self.frame.as_ref().map(|frame| &frame.image)
    }

    /// Whether the world has nothing left to do.
    pub fn is_quiet(&self) -> bool {
        self.engine.is_idle() && self.heard.elapsed() > QUIET && self.export.is_none()
    }

    pub fn wishes(&mut self) -> Vec<Wish> {
        std::mem::take(&mut self.wishes)
    }

    /// What changes there are, is kept for the next start.
    pub fn close(&mut self) {
        self.over = true;
    }

    pub fn is_over(&self) -> bool {
        self.over
    }

    /// The panels and the picture of one frame.
    pub fn show(&mut self, ui: &mut Ui, timings: &[Timing]) {
        self.timings.note_window(timings);
        if self.is_asking() {
            // What asks needs a frame to lie over the rest.
            ui.disable();
        }
        self.shortcuts(ui);
        self.dropped(ui);
        let width = ui.available_width();
        if self.panels {
            Panel::top("menu").show(ui, |ui| self.menu(ui, width));
        }
        self.notices(ui);
        if self.panels && self.document.is_some() {
            let most = (ui.available_width() * 0.45).max(120.0);
            Panel::bottom("status").show(ui, |ui| self.status_bar(ui));
            Panel::left("world").default_size(310.0_f32.min(most)).max_size(most).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.controls(ui))
            });
            if self.shows_timings(width) {
                // In a narrow window they leave the picture as much as they take.
                let most = most.min(ui.available_width() * 0.5);
                Panel::right(TIMINGS).default_size(230.0_f32.min(most)).max_size(most).show(ui, |ui| {
                    ui.add_space(4.0);
                    self.timings.show(ui, &self.status);
                });
            }
        }
        let rect = ui.available_rect_before_wrap();
        if self.document.is_some() {
            self.view(ui, rect);
        } else if let Some(choice) = self.welcome.show(ui, &self.state) {
            self.choose(choice);
        }
        self.windows(ui.ctx());
        self.messages.show(ui.ctx(), rect);
        self.follow(ui);
    }

    /// Tells the engine what the document has become, and keeps what is not saved.
    fn follow(&mut self, ui: &Ui) {
        let Some(document) = &mut self.document else { return };
        // A number that is being written says something at each digit.
        let is_writing = ui.ctx().egui_wants_keyboard_input();
        if !is_writing && !ui.input(|input| input.pointer.any_down()) {
            document.settle();
        }
        let world = document.world().clone();
        if !self.shown.as_ref().is_some_and(|shown| Arc::ptr_eq(shown, &world)) {
            self.engine.send(Command::Edit(world.clone()));
            let before = self.shown.replace(world.clone());
            let known = before.as_ref().map_or(&[][..], |world| &world.warnings);
            self.messages.forget_warnings(|warning| {
                let is_in = |warnings: &[String]| warnings.iter().any(|other| other == warning);
                is_in(known) && !is_in(&world.warnings)
            });
            let new = world.warnings.iter().filter(|warning| !known.contains(warning));
            new.for_each(|warning| self.messages.push(warning.clone(), Tone::Warned));
            // Panels that were drawn before the change show what was.
            ui.ctx().request_repaint();
        }
        let Some(keeper) = &mut self.keeper else { return };
        match keeper.watch(document, Instant::now()) {
            Ok(Some(later)) => ui.ctx().request_repaint_after(later),
            Ok(None) => {}
            Err(error) => {
                // Once is enough.
                self.keeper = None;
                self.fail(format!("changes are not kept: {error}"));
            }
        }
    }

    fn shortcuts(&mut self, ui: &Ui) {
        let modal = self.is_asking();
        let typing = ui.ctx().egui_wants_keyboard_input() || modal;
        let actions: Vec<Action> = ui.input(|input| keys::of(input, typing).collect());
        if !modal {
            actions.into_iter().for_each(|action| self.act(ui.ctx(), action));
        }
        let steering = if typing { Steering::default() } else { self.steer(ui) };
        if steering != self.steering {
            self.steering = steering;
            self.engine.send(Command::Steer(steering));
        }
    }

    /// Whether something waits for an answer, and nothing else is heeded.
    fn is_asking(&self) -> bool {
        self.chooser.is_open() || self.next.is_some() || !self.pending.is_empty()
    }

    fn act(&mut self, context: &Context, action: Action) {
        let is_zoom = matches!(self.status.world, WorldStatus::Zoom { .. });
        match action {
            Action::TogglePanels => self.panels = !self.panels,
            Action::Help => self.help = !self.help,
            Action::FullScreen => self.wishes.push(Wish::FullScreen),
            Action::Quit => self.ask_to_close(),
            Action::Open => self.ask(Purpose::Open, ""),
            Action::Save => self.save(),
            Action::SaveAs => self.ask_where_to_save(),
            Action::Reload => self.reload(),
            Action::Export => self.open_form(),
            Action::Undo | Action::Redo => {
                let Some(document) = &mut self.document else { return };
                let what = if action == Action::Undo { Document::undo } else { Document::redo };
                what(document);
            }
            Action::MouseLook => self.look_round(!self.looking && self.document.is_some()),
            // egui closes it.
            Action::LetGo if egui::Popup::is_any_open(context) => {}
            Action::LetGo if self.help => self.help = false,
            // While files are written it tells how far that is.
            Action::LetGo if self.form.is_some() && self.export.is_some() => {}
            Action::LetGo if self.form.is_some() => self.form = None,
            Action::LetGo if self.looking => self.look_round(false),
            Action::LetGo => self.engine.send(Command::Select(None)),
            Action::FrameAll => self.engine.send(Command::FrameAll),
            Action::Screenshot => self.ask_for_picture(),
            Action::Bookmark(number) => self.go_back_to(number),
            Action::SetBookmark(number) => self.remember(number.to_string()),
            Action::CopyCommand if !self.document.as_ref().is_some_and(Document::is_on_disk) => {
                self.fail("save the world first: the command line reads its file".into());
            }
            Action::CopyCommand => {
                if let Some(line) = self.command_line() {
                    context.copy_text(line);
                    self.say("copied the command line of this view".into());
                }
            }
            Action::PlayPause => {
                if let WorldStatus::Land { playing, .. } = &self.status.world {
                    self.engine.send(Command::Play(!playing));
                }
            }
            Action::Step => self.engine.send(Command::Step),
            Action::Restart => self.engine.send(Command::Restart),
            Action::Trace => {
                if let WorldStatus::Land { tracing, .. } = &self.status.world {
                    self.engine.send(Command::Trace(!tracing));
                }
            }
            Action::Autopilot | Action::WayBack if is_zoom => {
                let wanted = if action == Action::Autopilot { Course::In } else { Course::Out };
                let WorldStatus::Zoom { course, .. } = &self.status.world else { return };
                let course = if *course == wanted { Course::Hand } else { wanted };
                self.engine.send(Command::Course(course));
            }
            Action::CopyLocation => {
                if let WorldStatus::Zoom { code, .. } = &self.status.world {
                    context.copy_text(code.clone());
                    self.say("copied the code of this place".into());
                }
            }
            Action::OtherCamera => {
                self.orbits = !self.orbits;
                let does = if self.orbits { "goes round the middle of the picture" } else { "looks round" };
                self.say(format!("a drag {does}"));
            }
            Action::Autopilot | Action::WayBack => {}
        }
    }

    /// The mouse looks round, or points at things.
    pub fn look_round(&mut self, on: bool) {
        if self.looking != on {
            self.looking = on;
            self.wishes.push(Wish::Grab(on));
        }
    }

    fn steer(&self, ui: &Ui) -> Steering {
        ui.input(|input| {
            let axis = |back, forth| keys::axis(input, back, forth);
            let fast = if keys::held(input, Motion::Fast) { 4.0 } else { 1.0 };
            Steering {
                go: glam::vec3(
                    axis(Motion::Left, Motion::Right),
                    axis(Motion::Down, Motion::Up),
                    axis(Motion::Back, Motion::Forward),
                ),
                turn: glam::vec3(
                    axis(Motion::TurnLeft, Motion::TurnRight),
                    axis(Motion::TurnDown, Motion::TurnUp),
                    axis(Motion::RollLeft, Motion::RollRight),
                ),
                speed: self.speed.exp2() * fast,
            }
        })
    }

    // Panels ----------------------------------------------------------------------------------------------------------

    fn status_bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            match (&self.status.work, &self.status.world) {
                (Some((what, done, of)), _) if *of > 0 => drop(ui.label(format!("{what}: {done} of {of} …"))),
                (Some((what, ..)), _) => drop(ui.label(format!("{what} …"))),
                // What failed says so over the picture.
                (None, WorldStatus::None) if self.engine.is_idle() => {}
                (None, WorldStatus::None) => drop(ui.label("opening …")),
                (None, WorldStatus::Land { rig, .. }) => {
                    let [east, up, south] = rig.eye.to_array().map(|metres| rounded(metres, 0));
                    ui.label(format!("{east} m east  {south} m south  {up} m up"));
                }
                (None, WorldStatus::Zoom { depth, .. }) => {
                    drop(ui.label(format!("depth {}", rounded(*depth, 1))))
                }
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let dirty = self.document.as_ref().is_some_and(Document::is_dirty);
                ui.label(format!("speed ×{:.2}", self.speed.exp2()));
                if let Some(scale) = self.frame.as_ref().map(|frame| frame.scale).filter(|scale| *scale < 1.0)
                {
                    ui.weak(format!("picture {:.0} %", 100.0 * scale));
                }
                if dirty {
                    ui.colored_label(theme::WARNING, "not saved");
                }
            });
        });
    }

    fn controls(&mut self, ui: &mut Ui) {
        let Some(document) = &self.document else { return };
        let world = document.world().clone();
        ui.add_space(4.0);
        let mut save = false;
        let (mut commands, mut wishes) = (Vec::new(), Vec::new());
        match &self.status.world {
            WorldStatus::None => {}
            WorldStatus::Land { .. } => {
                folded(ui, "Simulation", true, |ui| {
                    commands.extend(land::simulation(ui, &world, &self.status))
                });
                folded(ui, "Layers", false, |ui| {
                    commands.extend(land::layers(ui, &world, &self.status, &mut self.look));
                });
                folded(ui, "Brush", false, |ui| {
                    commands.extend(land::brush(ui, &world, &self.status, &mut self.brush));
                });
                let header = folded(ui, "Section", false, |ui| land::section(ui, self.section.as_ref()));
                self.cutting = header;
                folded(ui, "Plants", false, |ui| plants::show(ui, &self.status));
                folded(ui, "Path tracing", false, |ui| {
                    commands.extend(land::tracing(ui, &self.status, || save = true));
                    wishes.push(parameters::rows(ui, document, "render", &["spp", "bounces"]));
                });
            }
            WorldStatus::Zoom { .. } => {
                folded(ui, "Flight", true, |ui| {
                    commands.extend(zoom::show(ui, &self.status, &mut self.code))
                });
                folded(ui, "Drawing", false, |ui| {
                    commands.extend(zoom::drawing(ui, &self.status, &mut self.marks));
                });
            }
        }
        folded(ui, "Picture", false, |ui| wishes.push(picture::show(ui, document, self.exposure)));
        commands.into_iter().for_each(|command| self.engine.send(command));
        let mut write_view = false;
        if !matches!(self.status.world, WorldStatus::None) {
            ui.horizontal(|ui| {
                write_view = ui.button("Put this view into the world").clicked();
            });
        }
        ui.separator();
        ui.horizontal(|ui| {
            ui.strong("World");
            let width = ui.available_width();
            ui.add(egui::TextEdit::singleline(&mut self.filter).hint_text("find a key").desired_width(width));
        });
        // Not while it is dragged: each value would be another question.
        if !ui.input(|input| input.pointer.any_down()) {
            let stage = match &self.status.world {
                WorldStatus::Land { progress, .. } => progress.stage,
                WorldStatus::None | WorldStatus::Zoom { .. } => Stage::Base,
            };
            self.foresight.look_at(document, stage);
        }
        wishes.push(parameters::show(ui, document, &mut self.foresight, &self.filter));
        for Wishes { edits, browse } in wishes {
            if let Some(document) = &mut self.document {
                for edit in &edits {
                    document.edit(edit);
                }
            }
            if let Some(key) = browse {
                self.ask(Purpose::Key(key), "");
            }
        }
        if write_view {
            self.write_view();
        }
        if save {
            self.ask_for_picture();
        }
    }

    /// The picture, and what the mouse does in it.
    fn view(&mut self, ui: &mut Ui, rect: Rect) {
        let pixels_per_point = ui.ctx().pixels_per_point();
        let size =
            [rect.width(), rect.height()].map(|side| (side * pixels_per_point).round().max(0.0) as u32);
        if size != self.size {
            self.size = size;
            self.engine.send(Command::Size(size));
        }
        let response = ui.interact(rect, ui.id().with("view"), Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, Color32::from_gray(12));
        if self.frame.is_some() {
            let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            let place = self.place_of_picture(rect, pixels_per_point);
            painter.image(WORLD, place, whole, Color32::WHITE);
            self.mark(&painter, place);
        } else {
            let failed = self.messages.tell_failure() && self.engine.is_idle();
            let text = if failed {
                "There is nothing to show.".into()
            } else {
                let what = self.status.work.as_ref().map_or("opening", |(what, ..)| what);
                format!("{what} …")
            };
            painter.text(
                rect.center(),
                Align2::CENTER_CENTER,
                text,
                egui::FontId::proportional(16.0),
                Color32::GRAY,
            );
        }
        let moved = ui.input(|input| {
            let motions = input.events.iter().filter_map(|event| match event {
                egui::Event::MouseMoved(by) => Some(*by),
                _ => None,
            });
            motions.fold(Vec2::ZERO, |sum, by| sum + by)
        });
        let place = response.hover_pos().map(|at| {
            let part = (at - rect.min) / rect.size();
            [part.x, part.y]
        });
        if self.cutting && place.is_some() && place != self.pointed {
            self.pointed = place;
            self.engine.send(Command::Section(place.unwrap_or_default()));
        }
        if self.paint(&response, place) {
            return;
        }
        let flat = |by: Vec2| glam::vec2(by.x, -by.y) * LOOK;
        if response.clicked() {
            ui.memory_mut(|memory| memory.stop_text_input());
        }
        if response.clicked_by(PointerButton::Primary) && self.brush.kind.is_none() && !self.looking {
            self.engine.send(Command::Select(place));
        }
        let dragged = response.drag_delta();
        if self.looking && moved != Vec2::ZERO {
            self.engine.send(Command::Turn(flat(moved)));
        } else if dragged != Vec2::ZERO && response.dragged_by(PointerButton::Primary) && self.orbits {
            self.engine.send(Command::Orbit(flat(dragged)));
        } else if dragged != Vec2::ZERO {
            self.engine.send(Command::Turn(flat(dragged)));
        }
        if response.hovered() || self.looking {
            let wheel = ui.input(|input| input.smooth_scroll_delta.y);
            if wheel != 0.0 && (self.looking || matches!(self.status.world, WorldStatus::Zoom { .. })) {
                self.speed = (self.speed + wheel * 0.01).clamp(-6.0, 4.0);
            } else if wheel != 0.0 {
                self.engine.send(Command::Approach((wheel * 0.003).clamp(-0.5, 0.5)));
            }
        }
    }

    /// Where in the window the picture lies. One of another shape, which will be replaced soon, is as high as the window and keeps its
    /// shape: as the next one does, it shows as much from top to bottom.
    fn place_of_picture(&self, rect: Rect, pixels_per_point: f32) -> Rect {
        let Some([width, height]) =
            self.frame.as_ref().map(|frame| frame.image.size().map(|side| side as f32))
        else {
            return rect;
        };
        let across = rect.height() * width / height;
        // A swift picture has whole texels, too, and fills the window all the same.
        let texel = (rect.height() / height + 1.0 / pixels_per_point) * (1.0 + width / height);
        let across = if (across - rect.width()).abs() <= texel { rect.width() } else { across };
        Rect::from_center_size(rect.center(), vec2(across, rect.height()))
    }

    /// Shows which plant is selected, where the picture shows it.
    fn mark(&self, painter: &egui::Painter, rect: Rect) {
        let WorldStatus::Land { selected: Some(selected), .. } = &self.status.world else { return };
        if let Some(camera) = self.frame.as_ref().and_then(|frame| frame.camera.as_ref()) {
            plants::outline(painter, rect, camera, selected);
        }
    }

    /// Lets the brush touch the land; whether it is in the hand.
    fn paint(&mut self, response: &egui::Response, place: Option<[f32; 2]>) -> bool {
        let (Some(kind), false) = (self.brush.kind, self.looking) else { return false };
        let (pressed, down) = response.ctx.input(|input| {
            let pointer = &input.pointer;
            (pointer.button_pressed(PointerButton::Primary), pointer.button_down(PointerButton::Primary))
        });
        // A dab may begin and end between two frames.
        let begins = pressed && (response.is_pointer_button_down_on() || response.contains_pointer());
        let held = down && response.is_pointer_button_down_on();
        if !held && !begins {
            return response.dragged_by(PointerButton::Primary);
        }
        if begins {
            self.painted = true;
            self.engine.send(Command::Stroke);
        }
        if let (Some(at), true) = (place, begins || self.engine.is_listening()) {
            let (radius, strength) = (self.brush.radius, self.brush.amount());
            self.engine.send(Command::Paint { kind, at, radius, strength });
        }
        // It goes on as long as it is held.
        response.ctx.request_repaint_after(Duration::from_millis(30));
        true
    }
}

/// A part of a panel that can be folded; whether it is open.
fn folded(ui: &mut Ui, name: &str, open: bool, show: impl FnOnce(&mut Ui)) -> bool {
    let header = egui::CollapsingHeader::new(RichText::new(name).strong()).default_open(open);
    header.show(ui, show).openness > 0.0
}
