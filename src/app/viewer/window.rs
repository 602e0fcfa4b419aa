//! The native window: events in, frames out, and nothing in between while nothing changes.

use super::desk::{Desk, Wish};
use super::document::Document;
use super::engine::Engine;
use super::painter::Painter;
use super::script::{Player, Script};
use super::state::{self, State};
use super::widgets::Widgets;
use super::{Arguments, Error, Session, interrupt};
use crate::app::report::{Details, Viewed};
use crate::formats;
use crate::gpu::{
    self, Gpu, Image, Pacing, Recorder, Shown, Swapchain, Target, Timing, format::Rgba8, window_extensions,
};
use egui::{TextureId, ViewportId};
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalPosition, LogicalSize};
use winit::event::{DeviceEvent, DeviceId, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{CursorGrabMode, Fullscreen, Window, WindowId};

/// News from the engine wait.
#[derive(Clone, Copy, Debug)]
pub struct Wake;

/// The texture that the picture of the world is.
pub const WORLD: TextureId = TextureId::User(0);

/// Time between two looks at Ctrl-C.
const PATIENCE: Duration = Duration::from_millis(250);

/// Time between two frames of a script that waits for the world.
const GLANCE: Duration = Duration::from_millis(100);

/// The size of the first window ever, points.
const FIRST_SIZE: [f64; 2] = [1280.0, 800.0];

/// Smaller ones have no room for the panels, points.
const LEAST_SIZE: [f64; 2] = [320.0, 180.0];

/// Opens the window and runs until it is closed.
pub fn run(
    arguments: &Arguments,
    document: Option<Document>,
    script: Option<Script>,
    session: &mut Session,
) -> Result<(), Error> {
    let events = EventLoop::<Wake>::with_user_event().build().map_err(no_display)?;
    let mut application = Application {
        arguments,
        document,
        script,
        session,
        proxy: events.create_proxy(),
        open: None,
        result: Ok(()),
    };
    events.run_app(&mut application).map_err(no_window)?;
    let Application { open, result, session, .. } = application;
    if let Some(open) = open {
        session.report.details = Some(Details::View(open.account()));
        // What the engine is at may take a moment yet.
        open.window.set_visible(false);
        // The window's images go before the device, and the engine before both.
        drop(open);
    }
    result
}

/// winit's own text names the line of its source that it failed at, which tells nobody anything.
fn no_display(error: winit::error::EventLoopError) -> Error {
    if !cfg!(all(unix, not(target_os = "macos"))) {
        return no_window(error);
    }
    let named = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"].iter().filter_map(|name| {
        let value = std::env::var_os(name).filter(|value| !value.is_empty())?;
        Some(format!("{name}={}", value.display()))
    });
    Error::Window(match named.collect::<Vec<_>>().join(", ") {
        named if named.is_empty() => {
            "there is no display: neither WAYLAND_DISPLAY nor DISPLAY is set; `terrane render` needs none"
                .into()
        }
        named => format!("the display can't be opened ({named}); `terrane render` needs none"),
    })
}

fn no_window(error: impl std::fmt::Display) -> Error {
    Error::Window(error.to_string())
}

struct Application<'a> {
    arguments: &'a Arguments,
    document: Option<Document>,
    script: Option<Script>,
    session: &'a mut Session,
    proxy: EventLoopProxy<Wake>,
    open: Option<Open>,
    result: Result<(), Error>,
}

/// All that there is once there is a window. Fields are dropped in this order.
struct Open {
    desk: Desk,
    swapchain: Swapchain,
    painter: Painter,
    canvas: Option<Image<Rgba8>>,
    textures: HashMap<TextureId, Image<Rgba8>>,
    egui: egui_winit::State,
    context: egui::Context,
    player: Option<Player>,
    window: Arc<Window>,
    gpu: Gpu,
    pace: Pace,
    frames: u64,
    grabbed: bool,
    widgets: Option<Widgets>,
    timings: Vec<Timing>,
}

/// When a frame is due, and how long input has waited for one.
#[derive(Default)]
struct Pace {
    due: Option<Instant>,
    /// When the first input came that no frame has shown.
    input: Option<Instant>,
    /// Milliseconds from input to the frame that shows it.
    waits: Vec<f32>,
}

impl ApplicationHandler<Wake> for Application<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        match self.open(events) {
            Ok(open) => self.open = Some(open),
            Err(error) => self.end(events, Err(error)),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, Wake: Wake) {
        // A script that waits looks up by itself.
        if let Some(open) = self.open.as_ref().filter(|open| !open.is_patient()) {
            open.window.request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let response = open.egui.on_window_event(&open.window, &event);
        if response.repaint && !matches!(event, WindowEvent::RedrawRequested) {
            open.pace.input.get_or_insert_with(Instant::now);
            open.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => {
                open.desk.ask_to_close();
                open.window.request_redraw();
            }
            WindowEvent::Focused(false) => open.desk.look_round(false),
            WindowEvent::Resized(size) => {
                open.swapchain.resize([size.width, size.height]);
                open.window.request_redraw();
            }
            WindowEvent::RedrawRequested => {
                let result = open.frame(self.session, self.arguments);
                match result {
                    Ok(Some(())) => self.end(events, Ok(())),
                    Ok(None) => {}
                    Err(error) => self.end(events, Err(error)),
                }
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        let Some(open) = &mut self.open else { return };
        if let (DeviceEvent::MouseMotion { delta }, true) = (event, open.grabbed) {
            open.egui.on_mouse_motion(delta);
            open.pace.input.get_or_insert_with(Instant::now);
            open.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        if interrupt::asked() {
            open.keep(self.arguments);
            let written = self.session.report.written();
            return self.end(events, Err(Error::Interrupted { written, kept: None }));
        }
        let now = Instant::now();
        if open.is_counting(self.arguments) || open.pace.due.is_some_and(|due| due <= now) {
            open.pace.due = None;
            open.window.request_redraw();
        }
        let patience = now + PATIENCE;
        let until = open.pace.due.map_or(patience, |due| due.min(patience));
        events.set_control_flow(ControlFlow::WaitUntil(until));
    }
}

impl Application<'_> {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<Open, Error> {
        let folder = state::folder();
        let (state, warning) = folder.as_deref().map(State::load).unwrap_or_default();
        let last = state.window.filter(|_| self.arguments.size.is_none());
        let size = match (self.arguments.size, last) {
            (Some(size), _) => [size.width, size.height].map(f64::from),
            (None, Some(window)) => window.size.map(f64::from),
            (None, None) => FIRST_SIZE,
        };
        let mut attributes = Window::default_attributes()
            .with_title("terrane")
            .with_inner_size(LogicalSize::new(size[0], size[1]))
            .with_min_inner_size(LogicalSize::new(LEAST_SIZE[0], LEAST_SIZE[1]))
            .with_maximized(last.is_some_and(|window| window.maximised));
        if let Some([x, y]) = last.and_then(|window| window.position) {
            attributes = attributes.with_position(LogicalPosition::new(x, y));
        }
        let window = Arc::new(events.create_window(attributes).map_err(no_window)?);
        let options = gpu::Options {
            device: self.arguments.device.device.clone(),
            memory_limit: self.arguments.device.memory_limit,
            validation: self.session.validation.clone(),
            window_extensions: window_extensions(&*window)?,
        };
        let gpu = Gpu::new(&options)?;
        self.session.report.device = Some(gpu.info().name.clone());
        let inner = window.inner_size();
        let target: Arc<dyn Target> = window.clone();
        let mut swapchain = Swapchain::new(&gpu, target, [inner.width, inner.height], Pacing::Fifo)?;
        let pacings = swapchain.pacings()?;
        let wanted = pacings.iter().copied().find(|pacing| state.pacing.as_deref() == Some(pacing.name()));
        swapchain.pace(wanted.unwrap_or_default());
        let painter = Painter::new(&gpu)?;
        let context = egui::Context::default();
        let egui = egui_winit::State::new(
            context.clone(),
            ViewportId::ROOT,
            events,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(gpu.info().max_image as usize),
        );
        let proxy = Mutex::new(self.proxy.clone());
        let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(move || {
            let proxy = proxy.lock().unwrap_or_else(PoisonError::into_inner);
            // A window that is gone needs no news.
            let _ = proxy.send_event(Wake);
        });
        let waker = wake.clone();
        let engine = Engine::start(&gpu, self.session.validation.clone(), move || waker());
        if self.script.is_some() {
            // Its clicks take two frames, however long these are.
            context.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
        }
        let named = self.script.as_ref().is_some_and(Script::has_names);
        let widgets = (named || Widgets::are_wanted()).then(|| Widgets::new(&context));
        let desk = Desk::new(
            &context,
            engine,
            wake,
            self.arguments.device.clone(),
            (wanted.unwrap_or_default(), pacings),
            self.document.take(),
            (folder, state, warning),
        );
        #[cfg(feature = "reload")]
        let desk = desk.with_shaders(&gpu);
        window.request_redraw();
        Ok(Open {
            desk,
            swapchain,
            painter,
            canvas: None,
            textures: HashMap::new(),
            egui,
            context,
            player: self.script.take().map(Player::new),
            window,
            gpu,
            pace: Pace::default(),
            frames: 0,
            grabbed: false,
            widgets,
            timings: Vec::new(),
        })
    }

    fn end(&mut self, events: &ActiveEventLoop, result: Result<(), Error>) {
        if let Some(open) = &mut self.open {
            open.keep(self.arguments);
        }
        if self.result.is_ok() {
            self.result = result;
        }
        events.exit();
    }
}

impl Open {
    /// Whether frames are drawn though nothing changes.
    fn is_counting(&self, arguments: &Arguments) -> bool {
        let counts = arguments.after_frames.is_some() || arguments.exit_after.is_some();
        !self.is_patient() && (counts || self.player.is_some())
    }

    /// Whether a script waits for the world.
    fn is_patient(&self) -> bool {
        self.player.as_ref().is_some_and(Player::is_patient)
    }

    /// One frame: `Some` if it was the last.
    fn frame(&mut self, session: &mut Session, arguments: &Arguments) -> Result<Option<()>, Error> {
        if self.desk.is_over() {
            return Ok(Some(()));
        }
        let inner = self.window.inner_size();
        let size = [inner.width, inner.height];
        self.swapchain.resize(size);
        self.desk.listen()?;
        if size.contains(&0) {
            return Ok(None);
        }
        let mut input = self.egui.take_egui_input(&self.window);
        if let Some(player) = &mut self.player {
            let find = |name: &str| self.widgets.as_ref()?.find(name);
            let wishes = player.play(&mut input, self.desk.is_quiet(), find)?;
            self.obey(wishes, session)?;
            if self.player.as_ref().is_some_and(Player::is_done) {
                self.player = None;
                if arguments.exit_after.is_none() && arguments.after_frames.is_none() {
                    return Ok(Some(()));
                }
            }
        }
        let desk = &mut self.desk;
        let timings = std::mem::take(&mut self.timings);
        let output = self.context.run_ui(input, |ui| desk.show(ui, &timings));
        self.timings = timings;
        if let Some(widgets) = &mut self.widgets {
            let update = output.platform_output.accesskit_update.as_ref();
            widgets.note(update, self.context.content_rect(), output.pixels_per_point);
        }
        self.egui.handle_platform_output(&self.window, output.platform_output);
        let wishes = self.desk.wishes();
        self.obey(wishes, session)?;

        if let Some(image) = self.desk.picture() {
            self.textures.insert(WORLD, image.clone());
        }
        let primitives = self.context.tessellate(output.shapes, output.pixels_per_point);
        self.painter.update(&output.textures_delta)?;
        let shown = self.present(size, &primitives, output.pixels_per_point)?;
        self.painter.free(&output.textures_delta);
        match shown {
            Shown::Yes(timings) => {
                self.painter.painted();
                if !timings.is_empty() {
                    self.timings = timings;
                }
                self.frames += 1;
                if let Some(since) = self.pace.input.take() {
                    self.pace.waits.push(1e3 * since.elapsed().as_secs_f32());
                }
            }
            Shown::Again => self.pace.due = Some(Instant::now() + Duration::from_millis(5)),
            Shown::No => self.pace.due = Some(Instant::now() + Duration::from_millis(50)),
        }
        if self.is_patient() {
            let glance = Instant::now() + GLANCE;
            self.pace.due = Some(self.pace.due.map_or(glance, |due| due.min(glance)));
        }
        let delay = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        match delay {
            Some(Duration::ZERO) => self.window.request_redraw(),
            Some(delay) if delay < Duration::from_secs(3600) => {
                let due = Instant::now() + delay;
                self.pace.due = Some(self.pace.due.map_or(due, |other| other.min(due)));
            }
            _ => {}
        }
        if let (Some(path), Some(after)) = (&arguments.screenshot, arguments.after_frames)
            && self.frames >= after
        {
            self.write(path, session)?;
            return Ok(Some(()));
        }
        if arguments.exit_after.is_some_and(|after| self.frames >= after) || self.desk.is_over() {
            return Ok(Some(()));
        }
        Ok(None)
    }

    fn present(
        &mut self,
        size: [u32; 2],
        primitives: &[egui::ClippedPrimitive],
        pixels_per_point: f32,
    ) -> gpu::Result<Shown> {
        let canvas = match self.canvas.take().filter(|canvas| canvas.size() == size) {
            Some(canvas) => canvas,
            None => Image::new(&self.gpu, "window", size)?,
        };
        let canvas = self.canvas.insert(canvas);
        let mut rec = Recorder::timed(&self.gpu, 8);
        self.painter.paint(&mut rec, canvas, primitives, pixels_per_point, &self.textures)?;
        self.swapchain.show(rec, canvas)
    }

    /// Keeps what has not been saved, and where the window stands.
    fn keep(&mut self, arguments: &Arguments) {
        let factor = self.window.scale_factor();
        let inner = self.window.inner_size().to_logical::<u32>(factor);
        let is_asked_for = arguments.size.is_some() || arguments.script.is_some();
        let position = self.window.outer_position().ok().map(|position| position.to_logical::<i32>(factor));
        let is_usual =
            !is_asked_for && self.window.fullscreen().is_none() && inner.width > 0 && inner.height > 0;
        self.desk.keep(is_usual.then(|| state::Window {
            size: [inner.width, inner.height],
            position: position.map(|position| [position.x, position.y]),
            maximised: self.window.is_maximized(),
        }));
    }

    /// Does what only a window can.
    fn obey(&mut self, wishes: Vec<Wish>, session: &mut Session) -> Result<(), Error> {
        for wish in wishes {
            match wish {
                Wish::Grab(on) => self.grab(on),
                Wish::FullScreen => {
                    let full = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                    self.window.set_fullscreen(full);
                }
                Wish::Title(title) => self.window.set_title(&title),
                Wish::Screenshot(path) => self.write(&path, session)?,
                Wish::Open(path) => self.desk.open(&path),
                Wish::Resize([width, height]) => {
                    let _ = self.window.request_inner_size(LogicalSize::new(width, height));
                }
                Wish::Pace(pacing) => self.swapchain.pace(pacing),
                #[cfg(feature = "reload")]
                Wish::Reprogram => {
                    if let Err(error) = self.painter.reprogram() {
                        self.desk.fail(error.to_string());
                    }
                }
                Wish::Close => self.desk.close(),
            }
        }
        Ok(())
    }

    /// Takes the mouse for looking round, or gives it back.
    fn grab(&mut self, on: bool) {
        self.grabbed = on;
        let modes =
            if on { [CursorGrabMode::Locked, CursorGrabMode::Confined] } else { [CursorGrabMode::None; 2] };
        // A window that can't hold the mouse still follows it.
        let _ = modes.into_iter().any(|mode| self.window.set_cursor_grab(mode).is_ok());
        self.window.set_cursor_visible(!on);
    }

    /// Writes the window as it was drawn last.
    fn write(&self, path: &Path, session: &mut Session) -> Result<(), Error> {
        let Some(canvas) = &self.canvas else { return Ok(()) };
        let mut rec = Recorder::new(&self.gpu);
        let texels = rec.download(canvas);
        let texels = texels.take(&rec.submit()?.wait()?);
        let rgb: Vec<u8> = texels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
        let written = formats::png::write_picture(path, canvas.size(), &rgb)?;
        session.report.wrote(&written);
        Ok(())
    }

    fn account(&self) -> Viewed {
        let mut waits = self.pace.waits.clone();
        waits.sort_by(f32::total_cmp);
        let at = |share: f32| {
            let index = (share * waits.len() as f32) as usize;
            waits.get(index.min(waits.len().saturating_sub(1))).copied().unwrap_or(0.0)
        };
        Viewed {
            frames: self.frames,
            inputs: waits.len(),
            input_median_ms: at(0.5),
            input_95_ms: at(0.95),
            input_longest_ms: at(1.0),
        }
    }
}
