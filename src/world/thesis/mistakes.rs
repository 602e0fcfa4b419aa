//! Mistakes in a folder, noted while reading goes on, so that one run reports them all.

use super::folder::{Contents, Folder};
use crate::world::Error;
use crate::world::fault::{self, Cause, Complaint};
use std::cell::RefCell;
use std::ops::Range;

/// Nobody reads on after so many.
const MOST: usize = 1000;

/// What is wrong so far.
#[derive(Default)]
pub struct Mistakes(RefCell<Vec<Mistake>>);

struct Mistake {
    /// Way of the file from the folder, or what would lie there.
    file: String,
    /// Bytes of the file; `None` for all of it.
    span: Option<Range<usize>>,
    title: String,
    complaint: Complaint,
}

impl Mistakes {
    pub fn note(&self, file: &str, span: Option<Range<usize>>, title: String, complaint: Complaint) {
        let mut mistakes = self.0.borrow_mut();
        if mistakes.len() < MOST {
            mistakes.push(Mistake { file: file.into(), span, title, complaint });
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.borrow().len()
    }

    /// # Errors
    /// All of them, by file and place.
    pub fn check(self, folder: &Folder) -> Result<(), Error> {
        let mut mistakes = self.0.into_inner();
        if mistakes.is_empty() {
            return Ok(());
        }
        mistakes.sort_by(|left, right| {
            let place =
                |mistake: &Mistake| (mistake.file.clone(), mistake.span.as_ref().map(|span| span.start));
            place(left).cmp(&place(right))
        });
        let report = fault::together(mistakes.iter().map(|mistake| mistake.show(folder)).collect());
        let files_only = mistakes.iter().all(|mistake| mistake.complaint.cause == Cause::File);
        Err(if files_only { Error::Unreadable { report } } else { Error::Wrong { report } })
    }
}

impl Mistake {
    fn show(&self, folder: &Folder) -> String {
        let text = match folder.files.get(&self.file) {
            Some(Contents::Bytes(bytes)) => String::from_utf8_lossy(bytes),
            _ => "".into(),
        };
        let span = self.span.clone().map(|span| (&*text, span));
        fault::report_place(self.title.clone(), &folder.shown(&self.file), span, &self.complaint)
    }
}
