//! `terrane export` beside the viewer, in a process of its own: it has its own memory, and can be ended at any time without loss.

use super::document::Document;
use crate::app::{Error, progress};
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// An export under way.
pub struct Export {
    child: Child,
    said: Arc<Mutex<Said>>,
    /// Who listens to it.
    listener: Option<JoinHandle<()>>,
    cancelled: bool,
    /// What was written for it to read.
    world: Option<tempfile::TempPath>,
}

/// What it has said.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Said {
    pub last: String,
    /// Of the stage under way, where that is known.
    pub share: Option<f32>,
    /// All but how far stages have come.
    text: String,
}

/// How it ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// With its last words.
    Done(String),
    Cancelled(String),
    Failed(String),
}

/// Most of what it says is kept.
const MOST_TEXT: usize = 1 << 16;

/// How often it says how far it has come, seconds.
const INTERVAL: &str = "0.2";

/// Time that it has to end by itself.
const PATIENCE: Duration = Duration::from_secs(2);

impl Export {
    /// Begins to export a world, as it is now, with the arguments that stand behind its name.
    ///
    /// # Errors
    /// If the program can't be run, or the world can't be written for it.
    pub fn begin(document: &Document, arguments: &[String]) -> Result<Export, Error> {
        let failed = |error: std::io::Error| Error::Window(format!("the export does not start: {error}"));
        let (path, world) = written(document).map_err(failed)?;
        let mut child = Command::new(std::env::current_exe().map_err(failed)?)
            .arg("export")
            .arg(path)
            .args(arguments)
            .env(progress::INTERVAL, INTERVAL)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let said = Arc::<Mutex<Said>>::default();
        let listener = child.stderr.take().map(|stderr| {
            let said = said.clone();
            std::thread::spawn(move || listen(stderr, &said))
        });
        Ok(Export { child, said, listener, cancelled: false, world })
    }

    pub fn said(&self) -> Said {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Asks it to end: it finishes no file any more, and says what there is.
    pub fn cancel(&mut self) {
        self.cancelled = true;
        #[cfg(unix)]
        if let Some(process) = i32::try_from(self.child.id()).ok().and_then(rustix::process::Pid::from_raw) {
            let _ = rustix::process::kill_process(process, rustix::process::Signal::TERM);
        }
        #[cfg(not(unix))]
        let _ = self.child.kill();
    }

    /// How it ended, if it has.
    pub fn ended(&mut self) -> Option<Ended> {
        let status = self.child.try_wait().ok()??;
        self.world = None;
        // Its last words may be on their way.
        if let Some(listener) = self.listener.take() {
            let _ = listener.join();
        }
        let Said { last, text, .. } = self.said();
        Some(match status.success() {
            true => Ended::Done(last),
            false if self.cancelled => Ended::Cancelled(reason(&text).unwrap_or("interrupted").into()),
            false => Ended::Failed(reason(&text).unwrap_or(&text).into()),
        })
    }
}

impl Drop for Export {
    fn drop(&mut self) {
        // By itself it leaves nothing unfinished behind.
        self.cancel();
        let begun = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) && begun.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What it says of why it ended.
fn reason(text: &str) -> Option<&str> {
    let (before, reason) = text.split_once("error: ")?;
    (before.is_empty() || before.ends_with('\n')).then(|| reason.trim_end())
}

fn listen(stderr: impl Read, said: &Mutex<Said>) {
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        said.lock().unwrap_or_else(PoisonError::into_inner).take(line);
    }
}

impl Said {
    fn take(&mut self, line: String) {
        self.share = progress::share(&line);
        if self.share.is_none() && self.text.len() + line.len() < MOST_TEXT {
            self.text += &line;
            self.text.push('\n');
        }
        self.last = line;
    }
}

/// The file of a document, or one beside it with what has not been saved: files that the world names are found from there.
fn written(document: &Document) -> std::io::Result<(PathBuf, Option<tempfile::TempPath>)> {
    if let Some(path) = document.path().filter(|_| document.is_on_disk()) {
        return Ok((path.into(), None));
    }
    let name = document.world().name.clone();
    let folder = if document.folder().as_os_str().is_empty() { ".".as_ref() } else { document.folder() };
    let file = tempfile::Builder::new().prefix(&format!(".{name}.")).suffix(".toml").tempfile_in(folder)?;
    std::fs::write(file.path(), document.text())?;
    let path = file.into_temp_path();
    Ok((path.to_path_buf(), Some(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_says_is_a_share_or_a_reason() {
        let said = Mutex::default();
        listen("base terrain: 1 in 0.1 s\nerosion: 30 of 120, 9.5/s, 9 s left\n".as_bytes(), &said);
        let heard = said.lock().expect("whole").clone();
        assert_eq!((heard.share, reason(&heard.text)), (Some(0.25), None));
        assert_eq!(heard.text, "base terrain: 1 in 0.1 s\n", "progress is passing");
        listen("error: interrupted; one file had been written, and is whole\n".as_bytes(), &said);
        let heard = said.lock().expect("whole").clone();
        assert_eq!(heard.share, None);
        assert_eq!(reason(&heard.text), Some("interrupted; one file had been written, and is whole"));
    }
}
