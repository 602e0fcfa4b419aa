//! Shaders that are edited while the window is open: they are compiled by a thread of their own, which sleeps while nobody writes.

use crate::gpu::{Changes, Gpu, Sources};
use notify::{RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Those that the program was built with.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/glsl");

/// An editor writes a file in steps, and several files one after another.
const SETTLED: Duration = Duration::from_millis(100);

/// What looks after the shaders.
pub struct Shaders {
    gpu: Gpu,
    changes: Receiver<Changes>,
    /// The thread ends with it.
    _watcher: notify::RecommendedWatcher,
}

impl Shaders {
    /// Begins to watch. `wake` is called, from another thread, whenever there are changes.
    ///
    /// # Errors
    /// When the folder is gone, or can't be watched.
    pub fn watch(gpu: &Gpu, wake: Arc<dyn Fn() + Send + Sync>) -> Result<Shaders, String> {
        let no_watch = |error: notify::Error| format!("shaders are not watched: {error}");
        let (touch, touched) = channel();
        let told = move |event: notify::Result<notify::Event>| {
            if event.is_ok_and(|event| !event.kind.is_access()) {
                // A thread that is gone needs no news.
                let _ = touch.send(());
            }
        };
        let mut watcher = notify::recommended_watcher(told).map_err(no_watch)?;
        watcher.watch(Path::new(FOLDER), RecursiveMode::Recursive).map_err(no_watch)?;
        let mut sources = Sources::new(Path::new(FOLDER))?;
        let (outbox, changes) = channel();
        let compile = move || {
            while touched.recv().is_ok() {
                while touched.recv_timeout(SETTLED).is_ok() {}
                if outbox.send(sources.changes()).is_err() {
                    return;
                }
                wake();
            }
        };
        let thread = std::thread::Builder::new().name("shaders".into()).spawn(compile);
        thread.map_err(|error| format!("shaders are not watched: {error}"))?;
        Ok(Shaders { gpu: gpu.clone(), changes, _watcher: watcher })
    }

    /// Replaces the programs that have been edited since it was last called: those who run them have to make them anew.
    pub fn replaced(&self) -> Option<Replaced> {
        let Changes { programs, files, refusals } = self.changes.try_recv().ok()?;
        let rooms = programs.iter().map(|program| program.room().to_owned()).collect();
        programs.into_iter().for_each(|program| self.gpu.replace(program));
        Some(Replaced { rooms, files, refusals })
    }
}

/// What has come of edits.
pub struct Replaced {
    /// Of the programs that are others now.
    pub rooms: BTreeSet<String>,
    pub files: Vec<String>,
    /// Why programs stay as they were.
    pub refusals: Vec<String>,
}
