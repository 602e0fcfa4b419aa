//! Where output goes: what `-o` means, and standard output.

use crate::app::Error;
use crate::formats::{self, file};
use std::io::{self, Write};
use std::path::{self, Path, PathBuf};

/// Where the files of a run go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// One file of that name.
    File(PathBuf),
    /// Any number of files in a folder.
    Folder(PathBuf),
}

impl Place {
    /// A folder if it exists as one or ends in `/`.
    pub fn of(out: &Path) -> Self {
        let ends_in_separator = out.to_string_lossy().ends_with(path::is_separator);
        if ends_in_separator || out.is_dir() { Place::Folder(out.into()) } else { Place::File(out.into()) }
    }

    /// The path of a file of this `name`: in the folder, or the one that was given whatever its name.
    pub fn file(&self, name: &str) -> PathBuf {
        match self {
            Place::File(path) => path.clone(),
            Place::Folder(folder) => folder.join(name),
        }
    }

    /// Finds out whether the files of these names can be written, and leaves nothing behind.
    pub fn prepare<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<(), Error> {
        if let Place::Folder(folder) = self {
            file::check_folder(folder)?;
            if !folder.exists() {
                return Ok(());
            }
        }
        for name in names {
            file::check_writable(&self.file(name))?;
        }
        Ok(())
    }

    /// Makes the folder if need be, now that there is something to put into it.
    pub fn make(&self) -> Result<(), Error> {
        match self {
            Place::File(_) => Ok(()),
            Place::Folder(folder) => Ok(file::make_folder(folder)?),
        }
    }
}

/// Refuses a file whose name ends in none of these.
pub fn check_extension(path: &Path, known: &[&str]) -> Result<(), Error> {
    if known.contains(&formats::extension(path).as_str()) {
        return Ok(());
    }
    let known: Vec<String> = known.iter().map(|extension| format!(".{extension}")).collect();
    Err(Error::Usage(format!(
        "-o {}: its name must end in {}; a folder's name ends in /",
        path.display(),
        known.join(" or ")
    )))
}

/// Writes on standard output. That nobody reads on is no failure.
pub fn print(bytes: &[u8]) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(formats::Error::Write { path: "standard output".into(), source }.into())
        }
        _ => Ok(()),
    }
}
