//! What every test with a device needs: one device a process, under validation, and comparisons that can fail.

// Each test crate uses its own part of the kit.
#![allow(dead_code)]

pub mod committed;
#[cfg(feature = "viewer")]
pub mod desktop;
pub mod field;
pub mod forest;
pub mod island;
pub mod land;
pub mod picture;
pub mod program;
pub mod scenery;
pub mod stage;
pub mod tiff;
pub mod zoom;

use std::{
    ops::Deref,
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
};
use terrane::gpu::{Gpu, MessageLog, Options};
use terrane::raster::Renderer;
use terrane::trace::Tracer;

/// The device that the tests of one process share. Any validation message fails the test that drops the guard.
pub fn gpu() -> Guard {
    static SHARED: OnceLock<(Gpu, MessageLog)> = OnceLock::new();
    let turn = turn();
    let (gpu, log) = SHARED.get_or_init(|| open(Options::default()));
    Guard { gpu: gpu.clone(), log: log.clone(), _turn: turn }
}

/// The renderer of the device that tests share: its programs are compiled once a process.
pub fn renderer(gpu: &Gpu) -> &'static Renderer {
    static SHARED: OnceLock<Renderer> = OnceLock::new();
    SHARED.get_or_init(|| Renderer::new(gpu).expect("a renderer"))
}

/// The tracer of the device that tests share.
pub fn tracer(gpu: &Gpu) -> &'static Tracer {
    static SHARED: OnceLock<Tracer> = OnceLock::new();
    SHARED.get_or_init(|| Tracer::new(gpu).expect("a tracer"))
}

/// A device of its own, under validation too.
pub fn own_gpu(options: Options) -> Guard {
    let turn = turn();
    let (gpu, log) = open(options);
    Guard { gpu, log, _turn: turn }
}

/// One test at a time uses devices: a message then belongs to the test that caused it, lavapipe has all cores to itself,
/// and the validation layer, which may crash when devices come and go on several threads, sees one thread.
pub fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn open(options: Options) -> (Gpu, MessageLog) {
    let log = MessageLog::default();
    let options = Options { validation: Some(log.clone()), ..options };
    (Gpu::new(&options).expect("a Vulkan device and the validation layer"), log)
}

/// A device, for as long as one test uses it; see [`gpu`].
pub struct Guard {
    gpu: Gpu,
    log: MessageLog,
    // Given up last.
    _turn: MutexGuard<'static, ()>,
}

impl Guard {
    /// The validation messages since they were last taken.
    pub fn messages(&self) -> Vec<String> {
        self.log.take()
    }

    /// Gives up the device; the messages of its end.
    pub fn close(self) -> Vec<String> {
        let log = self.log.clone();
        drop(self);
        log.take()
    }
}

impl Deref for Guard {
    type Target = Gpu;

    fn deref(&self) -> &Gpu {
        &self.gpu
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        let messages = self.messages();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation messages:\n{}", messages.join("\n"));
        }
    }
}
