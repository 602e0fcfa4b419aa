//! `terrane check`: whether a world can be made, and what it takes, without making it.

mod zoom;

use super::options::{DeviceOptions, OutputOptions, WorldOptions};
use super::output::print;
use crate::app::memory::{self, Goal, Limits, Needs, by_name, check_picture, largest_grid};
use crate::app::report::Details;
use crate::app::{Error, Session, interrupt, land, population};
use crate::bench;
use crate::core::memory::{Memory, mebibytes, total};
use crate::gpu::{self, Gpu};
use crate::plants::planting::{MOST_PLANTS, PLANT_BYTES};
use crate::raster;
use crate::scene::Population;
use crate::terrain::{Plan, schedule::Stage};
use crate::world::World;
use clap::Args;
use serde_json::json;
use std::fmt::{self, Display, Formatter};
use std::time::{Duration, Instant};

/// Check a world file and print what it takes to make, without making it
///
/// Its plants grow, for what is wrong with a grammar may show only then; its land is not made.
///
/// Exits with 3 if the world is wrong, and with 6 if it needs more memory than --memory-limit or the --device allows.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    world: WorldOptions,

    /// Don't find out how long it takes: no device is asked unless it is named
    #[arg(long)]
    no_time: bool,

    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    pub output: OutputOptions,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    interrupt::listen();
    let world = land::load(&arguments.world, session)?;
    if let Some(zoom) = &world.zoom {
        return zoom::check(arguments, &world, zoom, session);
    }
    let mut limits = Limits::of_option(arguments.device.memory_limit);
    let named = arguments.device.device.is_some();
    let mut gpu = None;
    if named {
        limits = Limits::of(gpu.insert(land::open(&arguments.device, session)?));
    }
    let planted = !world.plants.rules.is_empty();
    let plants = Plants::of(&world, session)?;
    let (film, renderer, models) = (world.film, world.renderer, plants.model_bytes());
    let sky = &world.light.sky;
    let goal = |_: &Plan| Goal::Picture { film, sky, planted, models, renderer };
    let mut needs = Needs::of(&world.plan, &goal(&world.plan));
    if plants.bytes() > 0 {
        needs.host.push(Memory { name: "plants", bytes: plants.bytes() });
    }
    if let Some(free) = gpu::free_ram().filter(|free| plants.bytes() > *free) {
        let [bytes, free] = [plants.bytes(), free].map(mebibytes);
        session.warn(format!("the plants may take {bytes} of memory, and {free} are free"));
    }
    // Only a limit makes a grid too large.
    let largest = limits.device.and_then(|_| largest_grid(&world.plan, goal, &limits));
    let possible = check_picture(&world.film).and_then(|()| memory::check(&world.plan, goal, &limits));

    let mut time = None;
    let shown = arguments.output.json || !arguments.output.quiet;
    if shown && !arguments.no_time && possible.is_ok() {
        // A world is checked where there is no device, too.
        gpu = gpu.or_else(|| land::open(&arguments.device, session).ok());
        if let Some(gpu) = gpu {
            time = Time::of(&gpu, &world.plan);
            // A refusal if the device was named; else the world may be meant for another one.
            if let Err(error) = memory::check(&world.plan, goal, &Limits::of(&gpu)) {
                let warning = format!("not on {}: {error}", gpu.info().name);
                session.progress.say(&format!("warning: {warning}"));
                session.report.warnings.push(warning);
            }
        }
    }
    session.report.details = Some(Details::Plan(object(&world, &plants, &needs, largest, time.as_ref())));
    let table = Table { world: &world, plants: &plants, needs: &needs, largest, time: time.as_ref() };
    if !arguments.output.quiet && !arguments.output.json {
        print(table.to_string().as_bytes())?;
    }
    interrupt::check(&session.report).and(possible)
}

/// All that stands on the land.
struct Plants {
    population: Population,
    /// How long the models took to grow.
    time: Duration,
    /// About how many plants there are at most, wherever the ground lets them stand.
    most: u64,
}

impl Plants {
    /// Grows the models, and refuses what no land could bear.
    fn of(world: &World, session: &mut Session) -> Result<Plants, Error> {
        let most = world.plants.foresee(world.plan.grid.extent)?;
        let start = Instant::now();
        let mut models = population::models(world, session)?;
        let time = start.elapsed();
        models.extend(world.plants.models.iter().cloned());
        models.extend(world.plants.standing.iter().flat_map(|standing| standing.models.iter().cloned()));
        Ok(Plants { population: Population { models, ..Population::default() }, time, most })
    }

    /// Memory of the models.
    fn model_bytes(&self) -> u64 {
        raster::memory::models(&self.population).bytes
    }

    /// Memory of the host, for the models and as many plants as there may be.
    fn bytes(&self) -> u64 {
        self.model_bytes().saturating_add(self.most.min(MOST_PLANTS).saturating_mul(PLANT_BYTES))
    }

    fn triangles(&self) -> u64 {
        let levels = self.population.models.iter().filter_map(|model| model.levels.first());
        levels.map(|level| level.triangles() as u64).sum()
    }

    fn object(&self) -> serde_json::Value {
        json!({
            "models": self.population.models.len(),
            "triangles": self.triangles(),
            "growing_seconds": self.time.as_secs_f64(),
            "most": self.most,
            "memory_bytes": self.bytes(),
        })
    }
}

impl Display for Plants {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        write!(
            out,
            "{} at most, of {} models with {} triangles, which grow in {}",
            self.most,
            self.population.models.len(),
            self.triangles(),
            rounded(self.time)
        )
    }
}

/// How long the land takes to make, about.
struct Time {
    device: String,
    stages: Vec<(Stage, Duration)>,
}

impl Time {
    /// `None` if the device can't run even a small part of it.
    fn of(gpu: &Gpu, plan: &Plan) -> Option<Time> {
        let stages = bench::estimate(gpu, plan).ok()?;
        Some(Time { device: gpu.info().name.clone(), stages })
    }

    fn all(&self) -> Duration {
        self.stages.iter().fold(Duration::ZERO, |sum, (_, time)| sum.saturating_add(*time))
    }

    fn of_stage(&self, stage: Stage) -> Option<Duration> {
        self.stages.iter().find(|(at, _)| *at == stage).map(|(_, time)| *time)
    }
}

impl Display for Time {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let all = self.all();
        write!(out, "about {} on {}", rounded(all), self.device)?;
        let mut separator = ": ";
        for (stage, time) in self.stages.iter().filter(|(_, time)| *time >= all / 50) {
            write!(out, "{separator}{} {}", stage.name(), rounded(*time))?;
            separator = ", ";
        }
        Ok(())
    }
}

/// As exactly as it is known.
fn rounded(time: Duration) -> String {
    match time.as_secs_f64() {
        seconds if seconds < 0.95 => format!("{seconds:.1} s"),
        seconds if seconds < 90.0 => format!("{seconds:.0} s"),
        seconds if seconds < 90.0 * 60.0 => format!("{:.0} min", seconds / 60.0),
        seconds => format!("{:.1} h", seconds / 3600.0),
    }
}

/// The plan for programs.
fn object(
    world: &World,
    plants: &Plants,
    needs: &Needs,
    largest: Option<u32>,
    time: Option<&Time>,
) -> serde_json::Value {
    let plan = &world.plan;
    let stages: Vec<_> = plan
        .stages()
        .into_iter()
        .map(|(stage, iterations)| {
            let seconds = time.and_then(|time| time.of_stage(stage)).map(|time| time.as_secs_f64());
            json!({ "name": stage.name(), "iterations": iterations, "seconds": seconds })
        })
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
        // An estimate; null where no device was asked.
        "seconds": time.map(|time| time.all().as_secs_f64()),
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
        "plants": plants.object(),
        "host": { "memory": memory(&needs.host), "memory_bytes": total(&needs.host) },
        "largest_cells": largest,
    })
}

/// The plan for people.
struct Table<'a> {
    world: &'a World,
    plants: &'a Plants,
    needs: &'a Needs,
    /// Most cells that the limits would allow, where there are limits.
    largest: Option<u32>,
    time: Option<&'a Time>,
}

impl Display for Table<'_> {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Table { world, plants, needs, largest, time } = self;
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
        if let Some(time) = time {
            writeln!(out, "time     {time}")?;
        }
        if !plants.population.models.is_empty() {
            writeln!(out, "plants   {plants}")?;
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
