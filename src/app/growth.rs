//! Plants that grow side by side, with progress that moves while each of them grows, and an ear for Ctrl-C.

use super::{Error, Session, interrupt};
use crate::plants::derive::Limits;
use crate::plants::watch::Watch;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// Grows `count` things, the next one whenever a thread is free: the results are in order, whichever was done first. `grow`
/// is told which one, and within what limits. The calling thread grows, too: one thing needs no other, nor its memory.
///
/// # Errors
/// The first one in that order; [`Error::Interrupted`].
pub fn side_by_side<T: Send>(
    count: usize,
    session: &mut Session,
    grow: impl Fn(usize, &Limits) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(usize::MAX));
    let (done, operations) = (AtomicU64::new(0), AtomicU64::new(0));
    let grown: Mutex<Vec<(usize, Result<T, Error>)>> = Mutex::default();
    session.progress.show("growing", 0, count as u64);
    let progress = Mutex::new(&mut session.progress);

    let queue = || {
        loop {
            let index = next.fetch_add(1, Relaxed);
            // What comes behind a failure is not asked for.
            let is_wanted = || index <= failed.load(Relaxed) && !interrupt::requested();
            if index >= count || !is_wanted() {
                return;
            }
            let look = |more| {
                let operations = operations.fetch_add(more, Relaxed) + more;
                // Another thread that shows something shows this as well.
                if let Ok(mut progress) = progress.try_lock() {
                    progress.show("growing", done.load(Relaxed), count as u64);
                    progress.detail(format!("{} million operations", operations / 1_000_000));
                }
                is_wanted()
            };
            let result = grow(index, &Limits { watch: Watch::new(&look), ..Limits::default() });
            match result {
                Ok(_) => done.fetch_add(1, Relaxed),
                Err(_) => failed.fetch_min(index, Relaxed) as u64,
            };
            grown.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    if count < 2 {
        queue();
    } else {
        rayon::in_place_scope(|scope| {
            for _ in 1..rayon::current_num_threads().min(count) {
                scope.spawn(|_| queue());
            }
            queue();
        });
    }
    session.progress.show("growing", done.into_inner(), count as u64);
    session.progress.end();
    interrupt::check(&session.report)?;
    let mut grown = grown.into_inner().unwrap_or_else(PoisonError::into_inner);
    grown.sort_unstable_by_key(|(index, _)| *index);
    grown.into_iter().map(|(_, result)| result).collect()
}
