//! `terrane merge`: the picture that shards are parts of.

use super::options::OutputOptions;
use super::output::check_extension;
use super::render::picture;
use crate::app::{Error, Session, interrupt};
use crate::core::memory::mebibytes;
use crate::formats::{self, file};
use crate::gpu;
use crate::shaders::Pixel;
use crate::trace::{Crop, Sums};
use crate::world::shard::{self, Header, Render, Shard};
use clap::{Args, ValueHint};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Put shards of a traced picture together: the same bytes as if it had been traced in one go
///
/// Shards come from `terrane render --samples A..B --of N`, with --crop or without. Together they must have every sample of every
/// pixel once. The checkpoint of a finished picture is a shard, too.
#[derive(Args)]
pub struct Arguments {
    /// Shards, in any order
    #[arg(value_name = "SHARD", required = true, value_hint = ValueHint::FilePath)]
    shards: Vec<PathBuf>,

    /// Picture to write, .png or .exr
    #[arg(short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: PathBuf,

    /// Write 16-bit floats to EXR
    #[arg(long)]
    half: bool,

    #[command(flatten)]
    pub output: OutputOptions,
}

/// A shard and the samples that it has.
struct Part<'a> {
    path: &'a Path,
    header: Header,
    samples: Range<u32>,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    check_extension(&arguments.out, &["png", "exr"])?;
    file::check_writable(&arguments.out)?;
    interrupt::listen();
    let parts = arguments.shards.iter().map(|path| Part::of(path)).collect::<Result<Vec<_>, _>>()?;
    let Some((render, crop, of)) = fit(&parts)? else { return Ok(()) };
    session.report.seed = Some(render.seed);
    session.report.device = Some(render.device.clone());
    check_memory(crop, &parts)?;

    let mut sums = Sums::of(crop, 0);
    for (index, part) in parts.iter().enumerate() {
        session.progress.show("merging", index as u64, parts.len() as u64);
        interrupt::check(&session.report)?;
        let shard = open(part.path)?;
        // It may have been written since.
        if shard.header != part.header {
            return Err(misfit(format!("{} has changed meanwhile", part.path.display())));
        }
        if let Some(more) = shard.sums()? {
            sums.absorb(&more);
        }
    }
    sums.complete(of);
    session.progress.show("merging", parts.len() as u64, parts.len() as u64);
    session.progress.end();
    let (written, clamped) = picture::write(&arguments.out, render, &sums, arguments.half)?;
    picture::warnings(&sums, clamped).into_iter().for_each(|warning| session.warn(warning));
    session.report.wrote(&written);
    let [width, height] = crop.size;
    let path = arguments.out.display();
    session.progress.say(&format!("wrote {path}, {width} × {height} pixels, {of} samples a pixel"));
    Ok(())
}

impl<'a> Part<'a> {
    fn of(path: &'a Path) -> Result<Self, Error> {
        let shard = open(path)?;
        let header = shard.header.clone();
        match shard.samples()? {
            Some(samples) if !samples.is_empty() => Ok(Part { path, header, samples }),
            _ => Err(misfit(format!("{} is not finished", path.display()))),
        }
    }
}

/// What the parts make: whose picture, which pixels of it, and how many samples. They fit if none of them has what another has, and
/// together they have as much as that.
fn fit<'a>(parts: &'a [Part]) -> Result<Option<(&'a Render, Crop, u32)>, Error> {
    let Some(first) = parts.first() else { return Ok(None) };
    let of = |part: &Part| part.header.of.unwrap_or(part.samples.end);
    for (index, part) in parts.iter().enumerate() {
        let differences = first.header.render.differences(&part.header.render);
        let [one, other] = [first, part].map(|part| part.path.display());
        if !differences.is_empty() {
            return Err(misfit(format!(
                "{one} and {other} are of different pictures: {}",
                differences.join("; ")
            )));
        }
        if of(first) != of(part) {
            return Err(misfit(format!("{one} is of {} samples and {other} of {}", of(first), of(part))));
        }
        let shared = |before: &&Part| {
            before.header.crop.overlaps(&part.header.crop)
                && before.samples.start < part.samples.end
                && part.samples.start < before.samples.end
        };
        if let Some(before) = parts[..index].iter().find(shared) {
            let (start, end) =
                (before.samples.start.max(part.samples.start), before.samples.end.min(part.samples.end));
            return Err(misfit(format!(
                "{} and {other} both have samples {start}..{end}",
                before.path.display()
            )));
        }
    }
    let origin = [0, 1].map(|axis| parts.iter().map(|part| part.header.crop.origin[axis]).min().unwrap_or(0));
    let end = [0, 1].map(|axis| parts.iter().map(|part| part.header.crop.end()[axis]).max().unwrap_or(0));
    // Within the picture, as each of them is.
    let crop = Crop { origin, size: [0, 1].map(|axis| (end[axis] - u64::from(origin[axis])) as u32) };
    let samples = |crop: &Crop, range: &Range<u32>| u128::from(crop.pixels()) * range.len() as u128;
    let all = samples(&crop, &(0..of(first)));
    let found: u128 = parts.iter().map(|part| samples(&part.header.crop, &part.samples)).sum();
    if found != all {
        let has = ranges(parts);
        let (whole, missing) = (of(first), all.saturating_sub(found));
        return Err(misfit(format!("{missing} of {all} samples are missing: of 0..{whole} there are {has}")));
    }
    Ok(Some((&first.header.render, crop, of(first))))
}

/// The samples that parts have, in order, and not too many of them.
fn ranges(parts: &[Part]) -> String {
    let mut ranges: Vec<_> = parts.iter().map(|part| (part.samples.start, part.samples.end)).collect();
    ranges.sort_unstable();
    ranges.dedup();
    let shown: Vec<String> = ranges.iter().take(20).map(|(start, end)| format!("{start}..{end}")).collect();
    shown.join(", ") + if ranges.len() > 20 { " and more" } else { "" }
}

/// The sums, the largest part of them, and the picture's planes.
fn check_memory(crop: Crop, parts: &[Part]) -> Result<(), Error> {
    let largest = parts.iter().map(|part| part.header.crop.pixels()).max().unwrap_or(0);
    let bytes = (crop.pixels() + largest) * size_of::<Pixel>() as u64 + crop.pixels() * 2 * 19 * 4;
    match gpu::free_ram().filter(|free| *free < bytes) {
        Some(free) => {
            let [needed, free] = [bytes, free].map(mebibytes);
            Err(Error::Memory(format!(
                "merging takes {needed} of memory, and {free} are free; merge crops one by one"
            )))
        }
        None => Ok(()),
    }
}

fn open(path: &Path) -> Result<Shard, Error> {
    shard::open(path)?.ok_or_else(|| {
        formats::Error::Read { path: path.into(), source: io::ErrorKind::NotFound.into() }.into()
    })
}

fn misfit(reason: String) -> Error {
    Error::Shards(reason)
}
