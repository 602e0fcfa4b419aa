//! What lies before the user: the picture of the world, and the panels round it.

use super::camera::Steering;
use super::engine::{Command, Course, Engine, Frame, News, Pose, Process, Status, WorldStatus};
use super::window::WORLD;
use crate::app::Error;
use crate::gpu::{Image, Pacing, Timing, format::Rgba8};
use crate::world::World;
use egui::{Align2, Color32, Context, Key, Panel, PointerButton, Rect, RichText, Sense, Ui, Vec2, vec2};
use std::path::PathBuf;
use std::sync::Arc;
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
    /// Points.
    Resize([f32; 2]),
    Pace(Pacing),
    Close,
}

pub struct Desk {
    engine: Engine,
    world: Option<Arc<World>>,
    frame: Option<Frame>,
    status: Status,
    wishes: Vec<Wish>,
    /// Of the picture in the window, pixels.
    size: [u32; 2],
    steering: Steering,
    /// log₂ of how much faster than usual it goes.
    speed: f32,
    panels: bool,
    looking: bool,
    over: bool,
    messages: Vec<(Instant, String, bool)>,
    /// When the engine last said anything.
    heard: Instant,
}

/// How long a message can be read.
const MESSAGE: Duration = Duration::from_secs(8);

/// Radians that the eye turns for a point of the mouse's way.
const LOOK: f32 = 0.004;

/// What the engine said last may be on its way to the window for so long.
const QUIET: Duration = Duration::from_millis(100);

impl Desk {
    pub fn new(context: &Context, engine: Engine, world: Option<Arc<World>>) -> Desk {
        context.set_theme(egui::Theme::Dark);
        let mut desk = Desk {
            engine,
            world: None,
            frame: None,
            status: Status::default(),
            wishes: Vec::new(),
            size: [0, 0],
            steering: Steering::default(),
            speed: 0.0,
            panels: true,
            looking: false,
            over: false,
            messages: Vec::new(),
            heard: Instant::now(),
        };
        if let Some(world) = world {
            desk.open(world);
        }
        desk
    }

    fn open(&mut self, world: Arc<World>) {
        self.wishes.push(Wish::Title(format!("{} – terrane", world.name)));
        self.engine.send(Command::Open(world.clone()));
        self.world = Some(world);
        self.frame = None;
    }

    /// Takes in what the engine has to say.
    ///
    /// # Errors
    /// What ended it.
    pub fn listen(&mut self) -> Result<(), Error> {
        while let Some(news) = self.engine.news() {
            self.heard = Instant::now();
            match news {
                News::Frame(frame) => self.frame = Some(frame),
                News::Status(status) => self.status = *status,
                News::Said(sentence) => self.messages.push((Instant::now(), sentence, false)),
                News::Failed(sentence) => self.messages.push((Instant::now(), sentence, true)),
                News::Ended(error) => return Err(error),
            }
        }
        match self.engine.is_dead() {
            true => Err(Error::Window("the engine has ended; what it said is above".into())),
            false => Ok(()),
        }
    }

    pub fn picture(&self) -> Option<&Image<Rgba8>> {
        self.frame.as_ref().map(|frame| &frame.image)
    }

    /// Whether the world has nothing left to do.
    pub fn is_quiet(&self) -> bool {
        self.engine.is_idle() && self.heard.elapsed() > QUIET
    }

    pub fn wishes(&mut self) -> Vec<Wish> {
        std::mem::take(&mut self.wishes)
    }

    pub fn ask_to_close(&mut self) {
        self.close();
    }

    pub fn close(&mut self) {
        self.over = true;
    }

    pub fn is_over(&self) -> bool {
        self.over
    }

    /// Keeps what has not been saved.
    pub fn keep(&mut self) {}

    /// The panels and the picture of one frame.
    pub fn show(&mut self, ui: &mut Ui, timings: &[Timing]) {
        self.shortcuts(ui);
        if self.panels {
            Panel::bottom("status").show(ui, |ui| self.status_bar(ui));
            Panel::left("world").default_size(280.0).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.controls(ui));
            });
            Panel::right("timings").default_size(220.0).show(ui, |ui| self.timings(ui, timings));
        }
        let rect = ui.available_rect_before_wrap();
        self.view(ui, rect);
        self.told(ui.ctx(), rect);
    }

    fn shortcuts(&mut self, ui: &Ui) {
        let typing = ui.ctx().egui_wants_keyboard_input();
        ui.input(|input| {
            if input.key_pressed(Key::F1) {
                self.panels = !self.panels;
            }
            if input.key_pressed(Key::F11) {
                self.wishes.push(Wish::FullScreen);
            }
            if typing {
                return;
            }
            if input.key_pressed(Key::F) || self.looking && input.key_pressed(Key::Escape) {
                self.looking = !self.looking;
                self.wishes.push(Wish::Grab(self.looking));
            }
            if input.key_pressed(Key::Home) {
                self.engine.send(Command::FrameAll);
            }
            if input.key_pressed(Key::P) {
                self.engine.send(Command::Trace(true));
            }
        });
        let steering = if typing { Steering::default() } else { self.steer(ui) };
        if steering != self.steering {
            self.steering = steering;
            self.engine.send(Command::Steer(steering));
        }
    }

    fn steer(&self, ui: &Ui) -> Steering {
        ui.input(|input| {
            // Shortcuts are no flights.
            let held = |key| f32::from(u8::from(input.key_down(key) && !input.modifiers.command));
            let axis = |less, more| held(more) - held(less);
            Steering {
                go: glam::vec3(axis(Key::A, Key::D), axis(Key::C, Key::Space), axis(Key::S, Key::W)),
                turn: glam::vec3(
                    axis(Key::ArrowLeft, Key::ArrowRight),
                    axis(Key::ArrowDown, Key::ArrowUp),
                    axis(Key::Q, Key::E),
                ),
                speed: self.speed.exp2(),
            }
        })
    }

    /// The picture, and what the mouse does in it.
    fn view(&mut self, ui: &mut Ui, rect: Rect) {
        let pixels_per_point = ui.ctx().pixels_per_point();
        let size = [rect.width(), rect.height()].map(|side| (side * pixels_per_point).round().max(0.0) as u32);
        if size != self.size {
            self.size = size;
            self.engine.send(Command::Size(size));
        }
        let response = ui.interact(rect, ui.id().with("view"), Sense::click_and_drag());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 0.0, Color32::from_gray(12));
        if self.frame.is_some() {
            let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            painter.image(WORLD, rect, whole, Color32::WHITE);
        }
        let moved = ui.input(|input| {
            let motions = input.events.iter().filter_map(|event| match event {
                egui::Event::MouseMoved(by) => Some(*by),
                _ => None,
            });
            motions.fold(Vec2::ZERO, |sum, by| sum + by)
        });
        if self.looking && moved != Vec2::ZERO {
            self.engine.send(Command::Turn(glam::vec2(moved.x, -moved.y) * LOOK));
        } else if response.dragged_by(PointerButton::Secondary) {
            let by = response.drag_delta();
            self.engine.send(Command::Turn(glam::vec2(by.x, -by.y) * LOOK));
        } else if response.dragged_by(PointerButton::Primary) {
            let by = response.drag_delta();
            self.engine.send(Command::Orbit(glam::vec2(by.x, -by.y) * LOOK));
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

    fn told(&mut self, context: &Context, rect: Rect) {
        self.messages.retain(|(since, ..)| since.elapsed() < MESSAGE);
        if self.messages.is_empty() {
            return;
        }
        context.request_repaint_after(Duration::from_millis(500));
        egui::Area::new("messages".into())
            .anchor(Align2::LEFT_BOTTOM, vec2(rect.left() + 12.0, -36.0))
            .show(context, |ui| {
                for (_, sentence, bad) in &self.messages {
                    let colour = if *bad { Color32::LIGHT_RED } else { Color32::WHITE };
                    egui::Frame::popup(ui.style()).show(ui, |ui| {
                        ui.set_max_width(rect.width() - 40.0);
                        ui.label(RichText::new(sentence).color(colour));
                    });
                }
            });
    }

    fn status_bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            match &self.status.world {
                WorldStatus::None => {
                    ui.label(if self.world.is_some() { "opening…" } else { "no world" });
                }
                WorldStatus::Land { rig, progress, .. } => {
                    let stage = progress.stage.name();
                    if progress.finished {
                        ui.label("finished");
                    } else {
                        ui.label(format!("{stage}: {} of {}", progress.iteration, progress.of));
                    }
                    ui.separator();
                    let [east, up, south] = rig.eye.to_array();
                    ui.label(format!("{east:.0} m east, {south:.0} m south, {up:.0} m up"));
                }
                WorldStatus::Zoom { depth, drawn, .. } => {
                    ui.label(format!("depth {depth:.2}"));
                    ui.separator();
                    ui.label(format!("{} tiles, {} made", drawn.drawn, drawn.made));
                }
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(format!("speed ×{:.2}", self.speed.exp2()));
            });
        });
    }

    fn controls(&mut self, ui: &mut Ui) {
        let Some(world) = &self.world else { return };
        ui.heading(&world.name);
        match self.status.world.clone() {
            WorldStatus::None => {}
            WorldStatus::Land { playing, off, progress, .. } => {
                ui.horizontal(|ui| {
                    if ui.button(if playing { "Pause" } else { "Play" }).clicked() {
                        self.engine.send(Command::Play(!playing));
                    }
                    if ui.button("Step").clicked() {
                        self.engine.send(Command::Step);
                    }
                    if ui.button("Restart").clicked() {
                        self.engine.send(Command::Restart);
                    }
                });
                for (process, name) in [
                    (Process::Hydraulic, "Water"),
                    (Process::Thermal, "Slides"),
                    (Process::Seabed, "Sea bed"),
                    (Process::Reef, "Reef"),
                ] {
                    let mut on = !off.contains(&process);
                    if ui.checkbox(&mut on, name).changed() {
                        self.engine.send(Command::Enable(process, on));
                    }
                }
                ui.label(format!("{:?}", progress.stage));
            }
            WorldStatus::Zoom { code, course, .. } => {
                ui.horizontal(|ui| {
                    for (wanted, name) in [(Course::In, "In"), (Course::Hand, "Stop"), (Course::Out, "Out")] {
                        if ui.selectable_label(course == wanted, name).clicked() {
                            self.engine.send(Command::Course(wanted));
                        }
                    }
                });
                if ui.button("Copy location code").clicked() {
                    ui.ctx().copy_text(code.clone());
                }
                ui.label(RichText::new(code).monospace().small());
            }
        }
    }

    fn timings(&mut self, ui: &mut Ui, timings: &[Timing]) {
        ui.strong("Milliseconds");
        egui::Grid::new("timings").striped(true).show(ui, |ui| {
            for (name, milliseconds) in &self.status.timings {
                ui.label(*name);
                ui.label(format!("{milliseconds:.1}"));
                ui.end_row();
            }
            for timing in timings {
                ui.label(timing.name);
                ui.label(format!("{:.1}", 1e3 * timing.duration.as_secs_f32()));
                ui.end_row();
            }
        });
        ui.add_space(8.0);
        ui.strong("Memory");
        ui.label(format!("{:.1} MiB", self.status.memory.used as f64 / f64::from(1 << 20)));
    }

    /// Where the eye is.
    pub fn pose(&self) -> Option<Pose> {
        match &self.status.world {
            WorldStatus::None => None,
            WorldStatus::Land { rig, .. } => Some(Pose::Land(*rig)),
            WorldStatus::Zoom { code, .. } => Some(Pose::Zoom(code.clone())),
        }
    }
}
