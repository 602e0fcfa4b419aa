//! Plants that grow side by side, with progress that moves while each of them grows, and an ear for Ctrl-C.

use super::{Error, Session, interrupt};
use crate::plants::derive::Limits;
use crate::plants::species;
use crate::plants::watch::Watch;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// Most things that grow at a time, and the part of the memory of one that each of them may take. Allocators keep what a thread
/// has freed: all of these together are a quarter, to which the whole comes when something grows alone.
const MOST_THREADS: usize = 4;
const SHARE: usize = 4 * MOST_THREADS;

type Grown<T> = (usize, Result<T, species::Error>);

/// Grows `count` things, the next one whenever a thread is free: the results are in order, whichever was done first. `grow`
/// is told which one, and within what limits; `blame` makes an error of the first one that can't grow.
///
/// What grows side by side has a [`SHARE`] each of the memory that one may take; what needs more waits, and grows alone with
/// all of it: so it does not depend on the number of threads what can grow. The calling thread grows, too: one thing needs
/// no other, nor its memory.
///
/// # Errors
/// The first one in that order; [`Error::Interrupted`].
pub fn side_by_side<T: Send>(
    count: usize,
    session: &mut Session,
    grow: impl Fn(usize, &Limits) -> Result<T, species::Error> + Sync,
    blame: impl Fn(usize, &species::Error) -> Error,
) -> Result<Vec<T>, Error> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let failed = AtomicUsize::new(usize::MAX);
    let (done, operations) = (AtomicU64::new(0), AtomicU64::new(0));
    session.progress.show("growing", 0, count as u64);
    let progress = Mutex::new(&mut session.progress);

    let grow_one = |index: usize, threads: usize| -> Option<Grown<T>> {
        // What comes behind a failure is not asked for.
        let is_wanted = || index <= failed.load(Relaxed) && !interrupt::requested();
        if !is_wanted() {
            return None;
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
        let limits = Limits { watch: Watch::new(&look), ..Limits::default() };
        let limits = if threads > 1 { limits.shared(SHARE) } else { limits };
        let result = grow(index, &limits);
        match &result {
            Ok(_) => {
                done.fetch_add(1, Relaxed);
            }
            Err(error) if threads > 1 && error.is_of_memory() => {}
            Err(_) => {
                failed.fetch_min(index, Relaxed);
            }
        }
        Some((index, result))
    };

    let mut threads = rayon::current_num_threads().min(MOST_THREADS).clamp(1, count);
    let mut grown: Vec<Grown<T>> = Vec::new();
    let mut waiting: Vec<usize> = (0..count).collect();
    while !waiting.is_empty() {
        let results = in_turn(&waiting, threads, |index| grow_one(index, threads));
        let waits =
            |(_, result): &Grown<T>| threads > 1 && result.as_ref().is_err_and(species::Error::is_of_memory);
        let (too_large, more): (Vec<_>, Vec<_>) = results.into_iter().partition(waits);
        grown.extend(more);
        waiting = too_large.into_iter().map(|(index, _)| index).collect();
        waiting.sort_unstable();
        threads = 1;
    }
    session.progress.show("growing", done.into_inner(), count as u64);
    session.progress.end();
    interrupt::check(&session.report)?;
    grown.sort_unstable_by_key(|(index, _)| *index);
    grown.into_iter().map(|(index, result)| result.map_err(|error| blame(index, &error))).collect()
}

/// What `grow` makes of these, on so many threads, in any order.
fn in_turn<T: Send>(indices: &[usize], threads: usize, grow: impl Fn(usize) -> Option<T> + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<T>> = Mutex::default();
    let queue = || {
        while let Some(&index) = indices.get(next.fetch_add(1, Relaxed)) {
            let Some(result) = grow(index) else { return };
            results.lock().unwrap_or_else(PoisonError::into_inner).push(result);
        }
    };
    if threads < 2 {
        queue();
    } else {
        rayon::in_place_scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|_| queue());
            }
            queue();
        });
    }
    results.into_inner().unwrap_or_else(PoisonError::into_inner)
}
