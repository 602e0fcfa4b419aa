//! Plants that grow side by side, with progress that moves while each of them grows, and an ear for Ctrl-C.

use super::{Error, Session, interrupt};
use crate::plants::derive::Limits;
use crate::plants::watch::Watch;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Time between two looks at what is done.
const LOOK: Duration = Duration::from_millis(100);

/// Grows `count` things, the next one whenever a thread is free: the results are in order, whichever was done first. `grow`
/// is told which one, and within what limits.
///
/// # Errors
/// The first one in that order; [`Error::Interrupted`].
pub fn side_by_side<T: Send>(
    count: usize,
    session: &mut Session,
    grow: impl Fn(usize, &Limits) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(usize::MAX));
    let operations = AtomicU64::new(0);
    let mut grown: Vec<Option<Result<T, Error>>> = Vec::new();
    grown.resize_with(count, || None);

    let queue = |send: &dyn Fn(usize, Result<T, Error>)| {
        loop {
            let index = next.fetch_add(1, Relaxed);
            // What comes behind a failure is not asked for.
            let is_wanted = || index <= failed.load(Relaxed) && !interrupt::requested();
            if index >= count || !is_wanted() {
                return;
            }
            let look = |more| {
                operations.fetch_add(more, Relaxed);
                is_wanted()
            };
            let result = grow(index, &Limits { watch: Watch::new(&look), ..Limits::default() });
            if result.is_err() {
                failed.fetch_min(index, Relaxed);
            }
            send(index, result);
        }
    };
    let (sender, receiver) = channel();
    rayon::in_place_scope(|scope| {
        for _ in 0..rayon::current_num_threads().min(count) {
            let (queue, sender) = (&queue, sender.clone());
            // Whoever listens does so to the end.
            scope.spawn(move |_| queue(&|index, result| _ = sender.send((index, result))));
        }
        drop(sender);
        let mut done = 0_u64;
        loop {
            session.progress.show("growing", done, count as u64);
            session.progress.detail(format!("{} million operations", operations.load(Relaxed) / 1_000_000));
            match receiver.recv_timeout(LOOK) {
                Ok((index, result)) => {
                    done += u64::from(result.is_ok());
                    grown[index] = Some(result);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
    });
    session.progress.end();
    interrupt::check(&session.report)?;
    grown.into_iter().flatten().collect()
}
