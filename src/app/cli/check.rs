//! `terrane check`: whether a world can be made, and what it takes, without making it.

use super::options::{DeviceOptions, OutputOptions, WorldOptions};
use crate::app::memory::{self, Goal, Limits, Needs, by_name, check_picture, largest_grid};
use crate::app::report::Details;
use crate::app::{Error, Session, land};
use crate::core::memory::{Memory, mebibytes, total};
use crate::terrain::{Plan, schedule::Stage};
use crate::world::World;
use clap::Args;
use serde_json::json;
use std::fmt::{self, Display, Formatter};
use std::io::{self, Write};

/// Check a world file and print what it takes to make, without making it
///
/// Exits with 3 if the world is wrong, and with 6 if it needs more memory than --memory-limit or the --device allows.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    world: WorldOptions,
    // A device is asked only if it is named.
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let world = land::load(&arguments.world, session)?;
    let mut limits = Limits::of_option(arguments.device.memory_limit);
    if arguments.device.device.is_some() {
        limits = Limits::of(&land::open(&arguments.device, session)?);
    }
    let goal = |_: &Plan| Goal::Picture(world.film);
    let needs = Needs::of(&world.plan, &goal(&world.plan));
    // Only a limit makes a grid too large.
    let largest = limits.device.and_then(|_| largest_grid(&world.plan, goal, &limits));
    session.report.details = Some(Details::Plan(object(&world, &needs, largest)));
    let table = Table { world: &world, needs: &needs, largest };
    if !arguments.output.quiet && !arguments.output.json {
        // Nobody may be reading.
        let _ = write!(io::stdout().lock(), "{table}");
    }
    check_picture(&world.film)?;
    memory::check(&world.plan, goal, &limits)
}

/// The plan for programs.
fn object(world: &World, needs: &Needs, largest: Option<u32>) -> serde_json::Value {
    let plan = &world.plan;
    let stages: Vec<_> = plan
        .stages()
        .into_iter()
        .map(|(stage, iterations)| json!({ "name": stage.name(), "iterations": iterations }))
        .collect();
    let memory = |parts: &[Memory]| -> Vec<_> {
        parts.iter().map(|part| json!({ "name": part.name, "bytes": part.bytes })).collect()
    };
    json!({
        "cells": plan.grid.cells,
        "extent": plan.grid.extent,
        "cell_size": plan.grid.cell_size(),
        "sea_level": plan.sea_level,
        "final_sea_level": plan.final_sea_level(),
        "stages": stages,
        "time_step": plan.time_step(),
        "reef_step": plan.reef.as_ref().map(|reef| reef.step),
        "memory": memory(&needs.land),
        "memory_bytes": total(&needs.land),
        "picture": {
            "width": world.film.width,
            "height": world.film.height,
            "memory": memory(&needs.picture),
            "memory_bytes": total(&needs.picture),
        },
        "host": { "memory": memory(&needs.host), "memory_bytes": total(&needs.host) },
        "largest_cells": largest,
    })
}

/// The plan for people.
struct Table<'a> {
    world: &'a World,
    needs: &'a Needs,
    /// Most cells that the limits would allow, where there are limits.
    largest: Option<u32>,
}

impl Display for Table<'_> {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Table { world, needs, largest } = self;
        let plan = &world.plan;
        let grid = plan.grid;
        writeln!(out, "{}, seed {}", world.name, world.seed)?;
        writeln!(
            out,
            "grid     {0} × {0} samples over {1} m, {2:.3} m apart",
            grid.cells,
            grid.extent,
            grid.cell_size()
        )?;
        writeln!(
            out,
            "sea      {} m above the datum, {} m at the end",
            plan.sea_level,
            plan.final_sea_level()
        )?;
        for (index, (stage, iterations)) in plan.stages().into_iter().enumerate() {
            let heading = if index == 0 { "stages" } else { "" };
            write!(out, "{heading:<8} {:<16} {iterations:>6}", stage.name())?;
            match (stage, plan.time_step(), &plan.reef) {
                (Stage::Hydraulic, Some(step), _) => writeln!(out, " steps of {step:.4} model seconds")?,
                (Stage::Reef, _, Some(reef)) => writeln!(out, " steps of {} years", reef.step)?,
                _ => writeln!(out)?,
            }
        }
        writeln!(out, "memory   on the device, {}", Parts(&needs.land))?;
        writeln!(out, "picture  {} × {} pixels", world.film.width, world.film.height)?;
        writeln!(out, "         on the device, {}", Parts(&needs.picture))?;
        writeln!(out, "host     {}", Parts(&needs.host))?;
        match largest {
            Some(cells) => writeln!(out, "largest  {cells} cells a side fit the limits"),
            None => Ok(()),
        }
    }
}

/// A sum and what it is of.
struct Parts<'a>(&'a [Memory]);

impl Display for Parts<'_> {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Parts(parts) = self;
        write!(out, "{}: {}", mebibytes(total(parts)), by_name(parts))
    }
}
