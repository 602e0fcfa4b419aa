//! Looks in on growth while it goes on: to show how far it is, and to end it.

use std::fmt::{self, Debug, Formatter};

/// Is told of work that was done, and says whether there shall be more.
#[derive(Clone, Copy)]
pub struct Watch<'a>(&'a (dyn Fn(u64) -> bool + Sync));

/// Growth was ended from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("growth was stopped")]
pub struct Stopped;

/// Operations between two looks: they take some milliseconds.
const OFTEN: u64 = 1 << 20;

impl Watch<'_> {
    /// Lets everything grow to its end.
    pub const NONE: Watch<'static> = Watch(&|_| true);
}

impl<'a> Watch<'a> {
    /// `look` is told how many operations, of a few nanoseconds each, were done since it was called last; false ends the
    /// growth.
    pub fn new(look: &'a (dyn Fn(u64) -> bool + Sync)) -> Watch<'a> {
        Watch(look)
    }

    pub fn pace(self) -> Pace<'a> {
        Pace { watch: self, done: 0 }
    }
}

impl Debug for Watch<'_> {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        out.write_str("Watch")
    }
}

/// Work on the way from one look to the next.
#[derive(Debug)]
pub struct Pace<'a> {
    watch: Watch<'a>,
    done: u64,
}

impl Pace<'_> {
    /// Counts operations, and looks now and then.
    ///
    /// # Errors
    /// When there shall be no more.
    #[inline]
    pub fn count(&mut self, operations: u64) -> Result<(), Stopped> {
        self.done += operations;
        if self.done < OFTEN { Ok(()) } else { self.look() }
    }

    #[cold]
    fn look(&mut self) -> Result<(), Stopped> {
        let Watch(look) = self.watch;
        if look(std::mem::take(&mut self.done)) { Ok(()) } else { Err(Stopped) }
    }
}
