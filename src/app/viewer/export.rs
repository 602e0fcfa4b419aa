//! `terrane export` beside the viewer, in a process of its own: it has its own memory, and can be ended at any time without loss.

use super::document::Document;
use crate::app::Error;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// An export under way.
pub struct Export {
    child: Child,
    /// The last line that it said, and all that it said.
    said: Arc<Mutex<(String, String)>>,
    /// What was written for it to read.
    world: Option<tempfile::TempPath>,
}

/// Most of what it says is kept.
const MOST_TEXT: usize = 1 << 16;

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
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let said = Arc::new(Mutex::new(Default::default()));
        if let Some(stderr) = child.stderr.take() {
            let said = said.clone();
            std::thread::spawn(move || listen(stderr, &said));
        }
        Ok(Export { child, said, world })
    }

    /// The last thing that it said.
    pub fn progress(&self) -> String {
        self.said.lock().unwrap_or_else(PoisonError::into_inner).0.clone()
    }

    /// How it ended, if it has: what there is to tell, or what went wrong.
    pub fn ended(&mut self) -> Option<Result<String, String>> {
        let status = self.child.try_wait().ok()??;
        self.world = None;
        // Its last words may be on their way.
        std::thread::sleep(Duration::from_millis(20));
        let (last, all) = self.said.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Some(if status.success() { Ok(last) } else { Err(all) })
    }
}

impl Drop for Export {
    fn drop(&mut self) {
        // Files appear whole or not at all.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn listen(stderr: impl Read, said: &Mutex<(String, String)>) {
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
        if said.1.len() + line.len() < MOST_TEXT {
            said.1 += &line;
            said.1.push('\n');
        }
        said.0 = line;
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
