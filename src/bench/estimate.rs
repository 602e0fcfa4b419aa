//! How long a plan will take here, found out in a moment.

use super::clock::{self, Stopwatch};
use crate::{
    core::grid::Grid,
    gpu::{self, DeviceKind, Gpu, Recorder},
    terrain::{self, Fields, Plan, Process, Stage},
};
use std::time::{Duration, Instant};

/// Time that each stage of `plan` will take on this device if nothing else is at work: some passes are run on a part of
/// its grid, which has the same cells, and so the same time step and sweeps, but fewer of them.
///
/// # Errors
/// What does not fit the device or its memory.
pub fn estimate(gpu: &Gpu, plan: &Plan) -> gpu::Result<Vec<(Stage, Duration)>> {
    let cells = plan.grid.cells.min(match gpu.info().kind {
        DeviceKind::Cpu => 256,
        // Fewer would leave most of a GPU idle.
        _ => 1024,
    });
    let grid = Grid { cells, extent: plan.grid.cell_size() * (cells - 1) as f32 };
    let part = Plan { grid, ..plan.clone() };
    let larger = plan.grid.samples() as f64 / grid.samples() as f64;

    let mut fields = Fields::new(gpu, &part)?;
    let mut times = Vec::new();
    for (stage, iterations) in plan.stages() {
        let mut work = Work { processes: terrain::processes(gpu, &part, stage)?, iterations };
        work.warm_up(gpu, &mut fields)?;
        let passes = work.passes() as f64;
        let seconds = work.seconds_of_a_pass(gpu, &mut fields)? * passes * larger;
        times.push((stage, Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)));
    }
    Ok(times)
}

/// For each stage.
const MOMENT: Duration = Duration::from_millis(200);
/// So many passes make a submission long enough to be timed.
const PASSES: usize = 32;

struct Work {
    processes: Vec<Box<dyn Process>>,
    iterations: u32,
}

impl Work {
    /// A CPU device compiles a kernel when it first runs: one pass of every kind that some iterations begin or end with.
    fn warm_up(&mut self, gpu: &Gpu, fields: &mut Fields) -> gpu::Result<()> {
        const ITERATIONS: u32 = 32;
        let mut rec = Recorder::new(gpu);
        for iteration in 1..=self.iterations.min(ITERATIONS) {
            for process in &mut self.processes {
                let passes = process.passes(iteration);
                let ends = [0, passes.saturating_sub(1)];
                for pass in ends.into_iter().take(passes as usize) {
                    process.pass(&mut rec, fields, iteration, pass);
                }
            }
        }
        rec.submit()?.wait()?;
        Ok(())
    }

    /// Runs the first passes of the stage again and again for a moment. They are the same each time, and other work on the
    /// machine can only add: so the shortest time counts.
    fn seconds_of_a_pass(&mut self, gpu: &Gpu, fields: &mut Fields) -> gpu::Result<f64> {
        let passes = self.first_passes();
        let mut shortest = f64::INFINITY;
        let start = Instant::now();
        while shortest.is_infinite() || start.elapsed() < MOMENT {
            let mut rec = Recorder::new(gpu);
            for &(iteration, process, pass) in &passes {
                self.processes[process].pass(&mut rec, fields, iteration, pass);
            }
            let watch = Stopwatch::start();
            rec.submit()?.wait()?;
            let spent = watch.stop();
            let time = match gpu.info().kind {
                DeviceKind::Cpu => spent.work / clock::cores() as u32,
                _ => spent.wall,
            };
            shortest = shortest.min(time.as_secs_f64());
        }
        Ok(shortest / passes.len().max(1) as f64)
    }

    /// Iteration, process and pass of each.
    fn first_passes(&self) -> Vec<(u32, usize, u32)> {
        let of = |iteration| {
            let processes = self.processes.iter().enumerate();
            processes.flat_map(move |(index, process)| {
                (0..process.passes(iteration)).map(move |pass| (iteration, index, pass))
            })
        };
        (1..=self.iterations).flat_map(of).take(PASSES).collect()
    }

    /// Of all iterations together.
    fn passes(&self) -> u64 {
        let of = |iteration| self.processes.iter().map(move |process| u64::from(process.passes(iteration)));
        (1..=self.iterations).flat_map(of).sum()
    }
}
