//! `terrane cache`: what earlier runs have left, and doing away with it.

use super::{options::OutputOptions, output::print};
use crate::app::report::Details;
use crate::app::{Error, Session, keep};
use crate::core::memory::mebibytes;
use crate::world::cache::{Cache, Entry};
use clap::{Args, ValueEnum};
use serde_json::json;
use std::time::Duration;

/// Show or clear what runs have kept for later ones
///
/// States of the land are kept in the user's cache folder, or in the one that the environment variable TERRANE_CACHE names;
/// those that have not been used for the longest time go when there is more than TERRANE_CACHE_LIMIT [default: 8GiB].
#[derive(Args)]
pub struct Arguments {
    /// What to do with it [default: show]
    action: Option<Action>,

    #[command(flatten)]
    pub output: OutputOptions,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Action {
    Show,
    Clear,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let Some(cache) = keep::cache(session)? else { return Ok(()) };
    if arguments.action == Some(Action::Clear) {
        let bytes = cache.clear()?;
        session.progress.say(&format!("removed {} from {}", mebibytes(bytes), cache.folder.display()));
    }
    let entries = cache.entries()?;
    session.report.details = Some(Details::Cache(object(&cache, &entries)));
    if !arguments.output.json && arguments.action != Some(Action::Clear) {
        print(table(&cache, &entries).as_bytes())?;
    }
    Ok(())
}

fn object(cache: &Cache, entries: &[Entry]) -> serde_json::Value {
    let entry = |entry: &Entry| {
        let land = entry.land.as_ref();
        json!({
            "world": land.map(|land| &land.world),
            "stage": land.map(|land| land.position.stage.name()),
            "iteration": land.map(|land| land.position.iteration),
            "of": land.map(|land| land.iterations),
            "cells": land.map(|land| land.cells),
            "bytes": entry.bytes,
            "age_seconds": entry.age.as_secs(),
        })
    };
    json!({
        "folder": cache.folder.to_string_lossy(),
        "limit_bytes": cache.limit,
        "bytes": total(entries),
        "entries": entries.iter().map(entry).collect::<Vec<_>>(),
    })
}

fn table(cache: &Cache, entries: &[Entry]) -> String {
    let mut table = format!(
        "{}: {} in {} files, of at most {}\n",
        cache.folder.display(),
        mebibytes(total(entries)),
        entries.len(),
        mebibytes(cache.limit)
    );
    for entry in entries {
        let land = match &entry.land {
            Some(land) => {
                let (stage, iteration, of) =
                    (land.position.stage.name(), land.position.iteration, land.iterations);
                let until = if iteration < of { format!(", {iteration} of {of}") } else { String::new() };
                // A damaged name could hold anything.
                format!("{}, {1} × {1}, {stage}{until}", land.world.escape_debug(), land.cells)
            }
            None => "damaged".into(),
        };
        table += &format!("{:>10}  {:>8} ago  {land}\n", mebibytes(entry.bytes), rough(entry.age));
    }
    table
}

fn total(entries: &[Entry]) -> u64 {
    entries.iter().map(|entry| entry.bytes).sum()
}

/// In the largest unit that leaves a whole number above 0.
fn rough(time: Duration) -> String {
    match time.as_secs() {
        seconds @ 0..60 => format!("{seconds} s"),
        seconds @ 60..3600 => format!("{} min", seconds / 60),
        seconds @ 3600..86_400 => format!("{} h", seconds / 3600),
        seconds => format!("{} d", seconds / 86_400),
    }
}
