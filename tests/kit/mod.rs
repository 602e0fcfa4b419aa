//! What every test with a device needs: one device a process, under validation, and comparisons that can fail.

// Each test crate uses its own part of the kit.
#![allow(dead_code)]

pub mod field;
pub mod island;
pub mod land;

use std::{
    ops::Deref,
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
};
use terrane::gpu::{Gpu, MessageLog, Options};

/// The device that the tests of one process share. Any validation message fails the test that drops the guard.
pub fn gpu() -> Guard {
    static SHARED: OnceLock<(Gpu, MessageLog)> = OnceLock::new();
    let turn = turn();
    let (gpu, log) = SHARED.get_or_init(open);
    Guard { gpu: gpu.clone(), log: log.clone(), _turn: turn }
}

/// A device of its own, with core and synchronization validation, and the log of its messages. The turn comes first,
/// so that it is given up last.
pub fn validated_gpu() -> (Turn, Gpu, MessageLog) {
    let turn = turn();
    let (gpu, log) = open();
    (turn, gpu, log)
}

/// One test at a time uses devices: a message then belongs to the test that caused it, lavapipe has all cores to itself,
/// and the validation layer, which may crash when devices come and go on several threads, sees one thread.
pub fn turn() -> Turn {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

pub type Turn = MutexGuard<'static, ()>;

fn open() -> (Gpu, MessageLog) {
    let log = MessageLog::default();
    let options = Options { validation: Some(log.clone()), ..Options::default() };
    (Gpu::new(&options).expect("a Vulkan device and the validation layer"), log)
}

/// A shared device; see [`gpu`].
pub struct Guard {
    gpu: Gpu,
    log: MessageLog,
    _turn: Turn,
}

impl Deref for Guard {
    type Target = Gpu;

    fn deref(&self) -> &Gpu {
        &self.gpu
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        let messages = self.log.take();
        if !std::thread::panicking() {
            assert!(messages.is_empty(), "validation messages:\n{}", messages.join("\n"));
        }
    }
}
