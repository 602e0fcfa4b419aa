//! What has been traced of a picture, kept beside it: two generations, each whole.

use crate::app::{Error, Session};
use crate::formats;
use crate::trace::{Crop, Sums};
use crate::world::shard::{self, Header, Render, Shard};
use std::fs;
use std::path::{Path, PathBuf};

/// The checkpoint of a picture, or of a shard.
pub struct Checkpoint {
    /// `<OUT>.checkpoint`
    pub path: PathBuf,
    /// The one before it, `<OUT>.checkpoint.1`.
    older: PathBuf,
    /// Of the sums that it is for.
    header: Header,
}

/// What an earlier run has left.
pub enum Found {
    Nothing,
    /// What was traced, and what is known of the picture that was made of it.
    Sums(Sums, Option<String>),
    /// A frame was finished, in this way.
    Finished(String),
}

impl Checkpoint {
    /// Of a picture at `out`, or of a part of its pixels; samples begin with number `first`, in a shard of `of`.
    pub fn new(out: &Path, render: Render, crop: Crop, first: u32, of: Option<u32>) -> Self {
        let named = |ending: &str| {
            let mut name = out.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        let header =
            Header { render, crop, first, of, flaws: Default::default(), finished: None, picture: None };
        Checkpoint { path: named(".checkpoint"), older: named(".checkpoint.1"), header }
    }

    /// The shard at `out` that another checkpoint is the beginning of.
    pub fn shard(out: &Path, unfinished: &Checkpoint) -> Self {
        Checkpoint { path: out.into(), older: unfinished.older.clone(), header: unfinished.header.clone() }
    }

    pub fn render(&self) -> &Render {
        &self.header.render
    }

    /// Takes up what an earlier run has left; where that is damaged, what was left before it.
    pub fn load(&self, session: &mut Session) -> Result<Found, Error> {
        let (shard, path) = match shard::open(&self.path) {
            Ok(Some(shard)) => (shard, &self.path),
            Ok(None) => match shard::open(&self.older)? {
                Some(shard) => (shard, &self.older),
                None => return Ok(Found::Nothing),
            },
            Err(damaged @ formats::Error::Corrupt { .. }) => match shard::open(&self.older) {
                Ok(Some(shard)) if self.differences(&shard).is_empty() => {
                    session.warn(format!("{damaged}; going on from {}", self.older.display()));
                    // Or the next one would drive out the sound one.
                    let _ = fs::remove_file(&self.path);
                    (shard, &self.older)
                }
                _ => return Err(damaged.into()),
            },
            Err(error) => return Err(error.into()),
        };
        let differences = self.differences(&shard);
        if !differences.is_empty() {
            return Err(Error::OtherPicture { path: path.clone(), differences });
        }
        if let Some(finished) = &shard.header.finished {
            return Ok(Found::Finished(finished.clone()));
        }
        let picture = shard.header.picture.clone();
        Ok(shard.sums()?.map_or(Found::Nothing, |sums| Found::Sums(sums, picture)))
    }

    /// What makes a shard another one's checkpoint: there and here.
    fn differences(&self, shard: &Shard) -> Vec<String> {
        let (there, here) = (&shard.header, &self.header);
        let mut differences = there.render.differences(&here.render);
        if there.crop != here.crop {
            let shown = |Crop { origin: [x, y], size: [width, height] }| format!("{x},{y},{width},{height}");
            differences.push(format!("pixels {} and {}", shown(there.crop), shown(here.crop)));
        }
        if there.first != here.first {
            differences.push(format!("samples from {} and from {} on", there.first, here.first));
        }
        if there.of != here.of {
            let shown = |of: Option<u32>| of.map_or("no shard".into(), |of| format!("a shard of {of}"));
            differences.push(format!("{} and {}", shown(there.of), shown(here.of)));
        }
        differences
    }

    /// Writes it; the one before it becomes the older one. `picture` tells of the picture that was made of complete sums.
    pub fn write(&self, sums: &Sums, picture: Option<String>) -> Result<(), Error> {
        let header = Header { flaws: sums.flaws(), picture, ..self.header.clone() };
        Ok(shard::write(&self.path, Some(&self.older), &header, Some(sums))?)
    }

    /// Writes what it holds under another name, as a shard, and removes it.
    pub fn into_shard(self, out: &Path, sums: &Sums) -> Result<(), Error> {
        let header = Header { flaws: sums.flaws(), ..self.header.clone() };
        shard::write(out, None, &header, Some(sums))?;
        self.remove();
        Ok(())
    }

    /// Says that a frame is finished, in a few hundred bytes.
    pub fn finish(&self, how: String) -> Result<(), Error> {
        let header = Header { finished: Some(how), ..self.header.clone() };
        shard::write(&self.path, None, &header, None)?;
        self.settle();
        Ok(())
    }

    /// Leaves one generation, under its own name, now that there is nothing more to come.
    pub fn settle(&self) {
        let _ = match self.path.exists() {
            true => fs::remove_file(&self.older),
            // A run ended, or a disk failed, between the renaming of the one and of the other.
            false => fs::rename(&self.older, &self.path),
        };
    }

    /// Leaves no generation: what they held is elsewhere.
    pub fn remove(&self) {
        let _ = fs::remove_file(&self.path);
        let _ = fs::remove_file(&self.older);
    }
}
