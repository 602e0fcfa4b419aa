//! What a correct simulation of an island keeps, whatever its numbers: mass, rest, stability, symmetry, sameness.

use crate::kit;
use crate::kit::land::{
    barrier, erode_nothing, finished, hill, layer, paper, random, slides, texels, valleys, world,
};
use crate::reference::lattice::Lattice;
use proptest::{
    prelude::*,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use std::{ops::Range, path::Path, sync::Arc, time::Duration};
use terrane::{
    gpu::{self, Gpu, Options, Recorder},
    terrain::{
        Boundary, Controls, Fields, Layer, Map, Plan, Process, Simulation,
        hydraulic::{self, Hydraulic, Pipes, Section, Slope, Transport},
        layers::{self, Combine, Generator},
        reef,
        thermal::{self, Settle},
    },
    world::Overrides,
};

/// Steps of `dt` model seconds each, nearly: a duration is cut into whole steps.
fn steps_of(params: &hydraulic::Params, plan: &Plan, count: u32) -> hydraulic::Params {
    let one = hydraulic::Params { duration: 1e-6, safety: 1.0, ..*params };
    let longest = one.safety * 0.5 * plan.grid.cell_size() / (one.gravity * one.pipe_depth).sqrt();
    hydraulic::Params { duration: (count as f32 - 0.01) * params.safety * longest, ..*params }
}

fn total(values: &[f32]) -> f64 {
    values.iter().map(|value| f64::from(*value)).sum()
}

/// Runs iterations of hydraulic erosion alone, from water of the given depths.
fn run_water(gpu: &Gpu, plan: &Plan, depths: &[f32], iterations: u32) -> Fields {
    let mut fields = Fields::new(gpu, plan).unwrap();
    let mut process = Hydraulic::new(gpu, plan, &plan.hydraulic.unwrap()).unwrap();
    let layers::Layer::Generate { generator: Generator::Heightmap { map }, .. } = &plan.layers[0] else {
        panic!("these worlds are heightmaps")
    };
    let water: Vec<[f32; 4]> = depths.iter().map(|depth| [*depth, 0.0, 0.0, 0.0]).collect();
    let mut rec = Recorder::new(gpu);
    rec.upload(fields.height.src(), &map.values);
    rec.upload(&fields.start, &map.values);
    rec.upload(fields.water.src(), &water);
    // The first iteration would fill the sea.
    (2..2 + iterations).for_each(|iteration| process.step(&mut rec, &mut fields, iteration));
    rec.submit().unwrap().wait().unwrap();
    fields
}

fn depths(gpu: &Gpu, fields: &Fields) -> Vec<f32> {
    texels(gpu, fields.water.src()).iter().map(|water| water[0]).collect()
}

#[test]
fn water_in_a_closed_box_follows_the_recurrence() {
    let gpu = kit::gpu();
    for (name, heights, tolerance) in [("flat", vec![0.0; 64 * 64], 3e-5), ("terrain", hill(64, 60.0), 1e-5)]
    {
        let plan = Plan { boundary: Boundary::Closed, ..world(64, 640.0, heights) };
        let params = hydraulic::Params { evaporation: 1e-3, ..erode_nothing(valleys(0.0)) };
        let params = steps_of(&params, &plan, 1000);
        let plan = Plan { hydraulic: Some(params), ..plan };
        assert_eq!(params.steps(plan.grid).count, 1000);
        let simulation = finished(&gpu, &plan);
        let got = layer(&gpu, &simulation, Layer::Water);
        let got = if name == "terrain" { depths(&gpu, simulation.fields()) } else { got };

        let step = params.steps(plan.grid).step;
        let want = (0..1000).fold(0.0, |mean: f64, _| {
            (mean + f64::from(params.rain) * step) * (1.0 - f64::from(params.evaporation) * step)
        });
        let mean = total(&got) / got.len() as f64;
        let error = (mean / want - 1.0).abs();
        assert!(error <= tolerance, "{name}: mean depth {mean} where {want} is expected");
        assert!(got.iter().all(|depth| *depth >= 0.0), "{name}: a negative depth");
    }
}

#[test]
fn a_lake_stays_at_rest() {
    let gpu = kit::gpu();
    // Whole 64ths of a metre, so that ground + depth is the level to the last bit.
    let heights: Vec<f32> = random("lake", 64 * 64).iter().map(|h| (h * 640.0).round() / 64.0).collect();
    let lake: Vec<f32> = heights.iter().map(|h| (2.0 - h).max(0.0)).collect();
    for params in [valleys(60.0), paper(60.0)] {
        let params = hydraulic::Params { rain: 0.0, evaporation: 0.0, creep: 0.0, ..params };
        let plan =
            Plan { boundary: Boundary::Closed, hydraulic: Some(params), ..world(64, 640.0, heights.clone()) };
        let fields = run_water(&gpu, &plan, &lake, 100);
        assert_eq!(depths(&gpu, &fields), lake);
        assert!(texels(&gpu, fields.axis.src()).iter().all(|flux| *flux == [0.0; 4]));
        assert!(texels(&gpu, &fields.change).iter().all(|e| *e == 0.0));
    }
}

/// Steady rain on a plane: what falls upslope passes.
#[test]
fn a_tilted_plane_drains_its_rain() {
    const CELLS: usize = 64;
    let gpu = kit::gpu();
    let heights = (0..CELLS * CELLS).map(|at| -2.0 * (at % CELLS) as f32).collect();
    let plan = Plan {
        boundary: Boundary::Open,
        hydraulic: Some(erode_nothing(valleys(2500.0))),
        ..world(CELLS as u32, 10.0 * (CELLS - 1) as f32, heights)
    };
    let simulation = finished(&gpu, &plan);
    let axis = texels(&gpu, simulation.fields().axis.src());
    let diagonal = texels(&gpu, simulation.fields().diagonal.src());
    let row = CELLS / 2 * CELLS;
    let east = |column: usize| axis[row + column][1] + diagonal[row + column][1] + diagonal[row + column][3];
    // The open rim upslope takes a little.
    let west = axis[row][0] + diagonal[row][0] + diagonal[row][2];
    for column in [15, 31, 47] {
        let want = plan.hydraulic.unwrap().rain * 100.0 * (column + 1) as f32;
        let got = east(column) + west;
        assert!((got / want - 1.0).abs() <= 1e-3, "column {column}: {got} m³/s where {want} fell");
    }
}

/// τ ≤ ½·√(ℓ³/(A·g)) is the bound: just below it waves die, just above they grow.
#[test]
fn pipes_are_stable_up_to_the_bound_and_not_beyond() {
    let gpu = kit::gpu();
    let waves: Vec<f32> =
        (0..64 * 64).map(|at| 100.0 + if (at % 64 + at / 64) % 2 == 0 { 0.01 } else { -0.01 }).collect();
    let largest = |step: f64| {
        let params = hydraulic::Params { pipe_depth: 20.0, rain: 0.0, evaporation: 0.0, ..paper(0.0) };
        let bound = 0.5 / (9.81_f64 * 20.0).sqrt();
        let safety = (step / bound) as f32;
        let plan = Plan { boundary: Boundary::Closed, ..world(64, 63.0, vec![0.0; 64 * 64]) };
        let params = steps_of(&hydraulic::Params { safety, ..erode_nothing(params) }, &plan, 400);
        let plan = Plan { hydraulic: Some(params), ..plan };
        let fields = run_water(&gpu, &plan, &waves, 400);
        depths(&gpu, &fields).iter().map(|depth| (depth - 100.0).abs()).fold(0.0, f32::max)
    };
    let (below, above) = (largest(0.035), largest(0.036));
    assert!(below <= 0.011, "at 0.035 s waves of 1 cm become {below} m");
    assert!(above >= 1.0, "at 0.036 s waves of 1 cm become {above} m");
}

#[test]
fn transport_by_the_pipes_keeps_the_mass_and_tracing_back_does_not() {
    let gpu = kit::gpu();
    let lost = |transport| {
        let params = match transport {
            Transport::Flux => hydraulic::Params { rain: 1e-3, ..valleys(0.0) },
            Transport::SemiLagrangian => hydraulic::Params { rain: 1e-3, ..paper(0.0) },
        };
        let plan = Plan { boundary: Boundary::Closed, ..world(64, 640.0, hill(64, 60.0)) };
        let params = steps_of(&params, &plan, 160);
        let plan = Plan { hydraulic: Some(params), ..plan };
        let simulation = finished(&gpu, &plan);
        let eroded = total(&layer(&gpu, &simulation, Layer::Wear));
        let left = total(&texels(&gpu, &simulation.fields().change))
            + total(&layer(&gpu, &simulation, Layer::Sediment));
        let ground: f64 = hill(64, 60.0).iter().map(|h| f64::from(h.abs())).sum();
        (-left / eroded, left.abs() / ground)
    };
    let (share, beside_all) = lost(Transport::Flux);
    assert!(share.abs() <= 1e-6 && beside_all <= 1e-6);
    let (share, _) = lost(Transport::SemiLagrangian);
    // Measured: 1 % to 2 % of what the water took, in these 160 steps, by the device; a thousand times more than by the pipes.
    assert!(share.abs() >= 1e-3, "tracing back keeps too much: {share} is lost");
}

/// A state of h instead of e would erode less the higher the land: one step's change is below the last place of h.
#[test]
fn height_above_the_datum_changes_nothing() {
    let gpu = kit::gpu();
    let worn = |lift: f32| {
        let heights = hill(64, 60.0).iter().map(|h| h + lift).collect();
        let hydraulic = Some(hydraulic::Params { rain: 3e-4, ..valleys(120.0) });
        let plan = Plan { boundary: Boundary::Closed, hydraulic, ..world(64, 640.0, heights) };
        total(&layer(&gpu, &finished(&gpu, &plan), Layer::Wear))
    };
    let (low, high) = (worn(0.0), worn(2000.0));
    assert!((high / low - 1.0).abs() <= 5e-3, "worn at 0 m: {low} m, at 2,000 m: {high} m");
}

/// Four pipes: since no cell gives more than it has, water never outruns the grid. (With eight, speed is clamped.)
#[test]
fn water_never_outruns_the_grid() {
    const CELLS: usize = 64;
    let gpu = kit::gpu();
    let heights: Vec<f32> = random("rough", CELLS * CELLS).iter().map(|h| 50.0 * h).collect();
    let water: Vec<f32> = random("puddles", CELLS * CELLS).iter().map(|d| (2.0 * d).max(0.0)).collect();
    let params = hydraulic::Params { rain: 0.0, evaporation: 0.0, ..erode_nothing(paper(60.0)) };
    let plan =
        Plan { boundary: Boundary::Closed, hydraulic: Some(params), ..world(CELLS as u32, 640.0, heights) };
    let lattice = Lattice::new(plan.grid);
    let step = params.steps(plan.grid).step;
    let mut fastest = 0.0_f64;
    for iterations in [1, 2, 5, 20, 100] {
        let before = depths(&gpu, &run_water(&gpu, &plan, &water, iterations - 1));
        let fields = run_water(&gpu, &plan, &water, iterations);
        let (after, flux) = (depths(&gpu, &fields), texels(&gpu, fields.axis.src()));
        for at in 0..CELLS * CELLS {
            let net = |k: usize| {
                let back = [1, 0, 3, 2][k];
                let inflow = lattice.neighbour(at % CELLS, at / CELLS, k).map_or(0.0, |n| flux[n][back]);
                f64::from(flux[at][k]) - f64::from(inflow)
            };
            let depth = f64::from(before[at]) + f64::from(after[at]);
            if depth > 2e-6 {
                fastest = fastest.max((net(1) - net(0)).hypot(net(3) - net(2)) / (lattice.cell * depth));
            }
        }
    }
    let limit = lattice.cell / step;
    assert!(fastest <= limit * (1.0 + 1e-5), "{fastest} m/s on a grid of {limit} m/s");
    assert!(fastest > 0.5 * limit, "the test does not come near: {fastest} m/s of {limit}");
}

#[test]
fn slopes_end_at_the_angle_of_repose_and_nothing_is_lost() {
    let gpu = kit::gpu();
    let heights = hill(64, 150.0);
    let repose = 33_f32.to_radians();
    let thermal = thermal::Params { repose, repose_under_water: repose, duration: 4000.0, ..slides() };
    let plan =
        Plan { boundary: Boundary::Closed, thermal: Some(thermal), ..world(64, 640.0, heights.clone()) };
    let simulation = finished(&gpu, &plan);
    let got = layer(&gpu, &simulation, Layer::Height);

    let lattice = Lattice::new(plan.grid);
    let steepest = (0..64 * 64)
        .flat_map(|at| (0..8).map(move |k| (at, k)))
        .filter_map(|(at, k)| {
            let n = lattice.neighbour(at % 64, at / 64, k)?;
            Some((f64::from(got[at]) - f64::from(got[n])) / lattice.distance(k))
        })
        .fold(0.0, f64::max);
    assert!(steepest <= f64::from(repose).tan() + 1e-3, "steepest slope {steepest}");
    let total = |heights: &[f32]| heights.iter().map(|h| f64::from(*h)).sum::<f64>();
    let scale: f64 = heights.iter().map(|h| f64::from(h.abs())).sum();
    assert!((total(&got) - total(&heights)).abs() <= 1e-6 * scale, "{} → {}", total(&heights), total(&got));
    let range =
        |heights: &[f32]| heights.iter().fold((f32::MAX, f32::MIN), |(lo, hi), h| (lo.min(*h), hi.max(*h)));
    assert!(range(&got).0 >= range(&heights).0 && range(&got).1 <= range(&heights).1, "no new extremum");
}

// ---- Symmetry, sameness, resolution ---------------------------------------------------------------------------------

/// Every process, on given ground.
fn everything(heights: Vec<f32>) -> Plan {
    let settle = Settle { repose: 40_f32.to_radians(), length: 20.0 };
    Plan {
        hydraulic: Some(hydraulic::Params { rain: 1e-3, ..valleys(60.0) }),
        thermal: Some(thermal::Params { settle: Some(settle), ..slides() }),
        seabed_smoothing: 15.0,
        reef: Some(barrier()),
        ..world(64, 640.0, heights)
    }
}

fn all_layers(gpu: &Gpu, simulation: &Simulation) -> Vec<Vec<f32>> {
    Layer::ALL.into_iter().map(|of| layer(gpu, simulation, of)).collect()
}

#[test]
fn flips_and_quarter_turns_change_no_bit() {
    const CELLS: usize = 64;
    let gpu = kit::gpu();
    let flip = |raster: &[f32]| -> Vec<f32> {
        (0..CELLS * CELLS).map(|at| raster[at / CELLS * CELLS + (CELLS - 1 - at % CELLS)]).collect()
    };
    let transpose = |raster: &[f32]| -> Vec<f32> {
        (0..CELLS * CELLS).map(|at| raster[at % CELLS * CELLS + at / CELLS]).collect()
    };
    let heights = hill(CELLS as u32, 60.0);
    let straight = all_layers(&gpu, &finished(&gpu, &everything(heights.clone())));
    for (name, there, back) in [
        ("flip", flip(&heights), Box::new(flip) as Box<dyn Fn(&[f32]) -> Vec<f32>>),
        ("quarter turn", flip(&transpose(&heights)), Box::new(move |raster| transpose(&flip(raster)))),
    ] {
        let turned = all_layers(&gpu, &finished(&gpu, &everything(there)));
        for (layer, (straight, turned)) in Layer::ALL.into_iter().zip(straight.iter().zip(&turned)) {
            let differ = back(turned).iter().zip(straight).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{name}: {} differs in so many cells", layer.name());
        }
    }
}

/// Depth and counter of the sea that stood there must not show where coral, or a fall of the sea, has made land.
#[test]
fn land_that_rose_from_the_sea_is_dry() {
    let gpu = kit::gpu();
    let mut plan = everything(hill(64, 60.0));
    if let Some(reef) = &mut plan.reef {
        reef.stages.push(reef::Stage { duration: 0.0, rise: -3.0 });
    }
    let simulation = finished(&gpu, &plan);
    let read = |what| layer(&gpu, &simulation, what);
    let (height, water, wetness) = (read(Layer::Height), read(Layer::Water), read(Layer::Wetness));
    let coral = texels(&gpu, &simulation.fields().reef);
    let risen: Vec<usize> = (0..height.len())
        .filter(|at| height[*at] >= simulation.sea_level() && height[*at] - coral[*at] < plan.sea_level)
        .collect();
    assert!(risen.len() > 20, "only {} cells rose", risen.len());
    for at in risen {
        assert_eq!([water[at], wetness[at]], [0.0; 2], "cell {at}");
    }
    // Rivers on land that was always land keep theirs.
    assert!((0..height.len()).any(|at| water[at] > 0.0 && wetness[at] > 0.0));
}

#[test]
fn the_land_does_not_depend_on_how_a_run_is_cut() {
    let gpu = kit::gpu();
    let plan = everything(hill(64, 60.0));
    let whole = all_layers(&gpu, &finished(&gpu, &plan));
    assert_eq!(whole, all_layers(&gpu, &finished(&gpu, &plan)), "twice");
    for budgets in [[0, 0], [0, 3], [20, 1]] {
        let mut simulation = Simulation::new(&gpu, &plan).unwrap();
        let mut slices = 0;
        while !simulation.progress().finished {
            simulation.step(Duration::from_millis(budgets[slices % 2])).unwrap();
            slices += 1;
        }
        assert!(slices > 10);
        assert_eq!(whole, all_layers(&gpu, &simulation), "cut into {slices}");
    }
}

/// A submission starts with one pass and grows by the factor 4 at most: an iteration of 2000 sweeps takes several.
#[test]
fn an_iteration_of_many_sweeps_is_cut() {
    let gpu = kit::gpu();
    let stages = vec![reef::Stage { duration: 25.0, rise: 0.0 }];
    let reef = reef::Params { stages, diffusivity: 1858.0, ..barrier() };
    let plan = Plan { reef: Some(reef), ..world(64, 640.0, hill(64, 60.0)) };
    assert!(plan.reef.as_ref().is_some_and(|reef| reef.steps() == 1 && reef.sweeps(plan.grid) > 1700));
    let mut simulation = Simulation::new(&gpu, &plan).unwrap();
    let mut cuts = 0;
    while !simulation.progress().finished {
        simulation.step(Duration::MAX).unwrap();
        cuts += 1;
    }
    // The base, then 1 + 4 + 16 + 64 + 256 + 1024 passes and the rest.
    assert!(cuts >= 8, "cut into {cuts}");
}

/// The west is masked, with half tones between.
#[test]
fn where_the_mask_is_black_no_process_changes_the_ground() {
    let gpu = kit::gpu();
    let heights = hill(64, 60.0);
    let mask = Map { width: 4, height: 1, values: vec![0.0, 0.0, 1.0, 1.0] };
    let controls = Controls { mask: Some(Arc::new(mask)), ..Controls::default() };
    let got = layer(&gpu, &finished(&gpu, &Plan { controls, ..everything(heights.clone()) }), Layer::Height);
    let changed = |columns: Range<usize>| {
        (0..64 * 64).filter(|at| columns.contains(&(at % 64)) && got[*at] != heights[*at]).count()
    };
    assert_eq!(changed(0..22), 0);
    assert!(changed(22..64) > 2000, "only {} cells change elsewhere", changed(22..64));
}

#[test]
fn a_plan_knows_its_steps_and_its_memory() {
    let gpu = kit::own_gpu(Options::default());
    let plan = everything(hill(64, 60.0));
    let mut simulation = Simulation::new(&gpu, &plan).unwrap();
    // What is copied at the beginning and at the end is there for a moment only.
    let planned: u64 = plan.memory().iter().filter(|part| part.name != "copies").map(|part| part.bytes).sum();
    let used = gpu.memory().used;
    assert!(used >= planned && used < planned + planned / 4, "{planned} bytes planned, {used} used");
    let mut stages = Vec::new();
    while !simulation.progress().finished {
        let before = simulation.progress();
        simulation.step(Duration::MAX).unwrap();
        if stages.last() != Some(&(before.stage, before.of)) {
            stages.push((before.stage, before.of));
        }
    }
    assert_eq!(stages, plan.stages());
}

#[test]
fn a_world_that_does_not_fit_is_refused_with_its_figures() {
    let gpu = kit::own_gpu(Options { memory_limit: Some(4 << 20), ..Options::default() });
    let plan = Plan { hydraulic: Some(valleys(60.0)), ..world(512, 6000.0, hill(512, 60.0)) };
    let Err(error) = Simulation::new(&gpu, &plan) else { panic!("34 MiB fit into 4") };
    assert!(
        matches!(&error, gpu::Error::MemoryLimit { bytes, limit, .. } if *bytes > 0 && *limit == 4 << 20),
        "{error}"
    );
}

/// Depth-dependent pipes with drag carry the same water at the same speed whatever the grid; the paper's do not.
#[test]
fn water_does_not_see_the_grid() {
    let gpu = kit::gpu();
    let flow = |params: hydraulic::Params, cells: u32| {
        let cone = Generator::Cone { height: 1150.0, radius: 2850.0, exponent: 0.8, center: [0.0; 2] };
        let layers = vec![layers::Layer::Generate { generator: cone, combine: Combine::Add }];
        let hydraulic = Some(erode_nothing(hydraulic::Params { duration: 1800.0, ..params }));
        let plan = Plan { layers, sea_level: 200.0, hydraulic, ..world(cells, 6000.0, Vec::new()) };
        let simulation = finished(&gpu, &plan);
        let height = layer(&gpu, &simulation, Layer::Height);
        let water = texels(&gpu, simulation.fields().water.src());
        let land =
            || height.iter().zip(&water).filter(|(h, _)| **h > 200.0).map(|(_, water)| water.map(f64::from));
        let volume: f64 = land().map(|[d, ..]| d).sum();
        let speed: f64 = land().map(|[_, _, q, _]| q).sum::<f64>() / volume;
        (volume * f64::from(plan.grid.cell_size()).powi(2), speed)
    };
    let drift = |params, coarse: u32| {
        let ((volume, speed), (finer_volume, finer_speed)) = (flow(params, coarse), flow(params, 2 * coarse));
        (finer_volume / volume - 1.0, finer_speed / speed - 1.0)
    };
    let (volume, speed) = drift(valleys(0.0), 128);
    assert!(
        volume.abs() <= 0.04 && speed.abs() <= 0.04,
        "volume and speed drift by {volume:.3} and {speed:.3}"
    );
    let (_, speed) = drift(hydraulic::Params { section: Section::Fixed, ..valleys(0.0) }, 64);
    assert!(speed.abs() > 0.1, "a fixed section would do: speed drifts by {speed:.3} only");
}

/// Features of the land keep their size in metres: slides, sea bed and coral on a grid twice as fine, compared at the
/// samples that both have. Shores, the feet of slopes and the rim of the reef are known to a cell only, so the grids
/// differ by a twentieth of what the processes change. Processes that counted in cells would differ by half of it.
#[test]
fn land_does_not_see_the_grid() {
    const COARSE: usize = 65;
    let gpu = kit::gpu();
    let bare = |cells: u32| {
        let cone = Generator::Cone { height: 600.0, radius: 850.0, exponent: 0.8, center: [0.0; 2] };
        let (amplitude, wavelength) = (40.0, 500.0);
        let hills = Generator::Simplex { amplitude, offset: 0.0, wavelength, octaves: 2, warp: 0.0, seed: 3 };
        let layers =
            [cone, hills].map(|generator| layers::Layer::Generate { generator, combine: Combine::Add });
        Plan { layers: layers.to_vec(), sea_level: 60.0, ..world(cells, 2000.0, Vec::new()) }
    };
    // `length` is that of a cell where one counts in cells.
    let shaped = |cells: u32, length: f32| Plan {
        thermal: Some(thermal::Params { duration: 1000.0 * length * length, ..slides() }),
        seabed_smoothing: 60.0 * length,
        reef: Some(reef::Params { rubble: None, diffusivity: 8.0 * length * length, ..barrier() }),
        ..bare(cells)
    };
    let heights = |plan: Plan| layer(&gpu, &finished(&gpu, &plan), Layer::Height);
    let difference = |one: &[f32], other: &[f32]| {
        let step = if other.len() == one.len() { 1 } else { 2 };
        let width = step * (COARSE - 1) + 1;
        let squares = (0..one.len())
            .map(|at| (one[at] - other[step * (at / COARSE * width + at % COARSE)]).powi(2))
            .map(f64::from);
        (squares.sum::<f64>() / one.len() as f64).sqrt()
    };
    let coarse = heights(shaped(65, 1.0));
    let changed = difference(&coarse, &heights(bare(65)));
    let fine = difference(&coarse, &heights(shaped(129, 1.0)));
    assert!(fine <= 0.08 * changed, "grids differ by {fine} m where {changed} m change");
    let in_cells = difference(&coarse, &heights(shaped(129, 0.5)));
    assert!(in_cells > 0.3 * changed, "counting in cells would do: {in_cells} m of {changed} m");
}

// ---- Any world ------------------------------------------------------------------------------------------------------

prop_compose! {
    fn water()(
        (pipe_depth, drag, rain, capacity) in (1.0..8.0_f32, 0.05..0.3_f32, 50.0..300.0_f32, 50.0..400.0_f32),
        (erosion_rate, deposition_rate) in (0.001..0.01_f32, 0.005..0.05_f32),
        (ramp_depth, ramp_start, min_slope) in (0.3..2.0_f32, 0.0..0.03_f32, 0.005..0.05_f32),
        (creep, bank_diffusion, duration) in (0.02..0.3_f32, 0.5..6.0_f32, 500.0..8000.0_f32),
        pipes in prop_oneof![Just(Pipes::Four), Just(Pipes::Eight)],
        section in prop_oneof![Just(Section::Fixed), Just(Section::Depth)],
        slope in prop_oneof![Just(Slope::Central), Just(Slope::Outflow)],
        transport in prop_oneof![Just(Transport::Flux), Just(Transport::SemiLagrangian)],
        printed in prop::bool::weighted(0.2),
    ) -> hydraulic::Params {
        let rain = rain / 3.6e6;
        if printed {
            let paper = preset("paper");
            return hydraulic::Params {
                duration, capacity, rain, pipe_depth, erosion_rate, deposition_rate, min_slope, ..paper
            };
        }
        hydraulic::Params {
            pipes, section, slope, transport, pipe_depth, drag, rain, capacity, erosion_rate, deposition_rate,
            ramp_depth, ramp_start, min_slope, creep, bank_diffusion, duration, ..preset("island")
        }
    }
}

/// Water as world files have it.
fn preset(name: &str) -> hydraulic::Params {
    let text = format!("format = 1\n[erosion.hydraulic]\npreset = \"{name}\"");
    let world = terrane::world::parse(name, text.as_bytes(), Path::new(""), &Overrides::default()).unwrap();
    world.plan.hydraulic.unwrap()
}

prop_compose! {
    fn coral()(
        (growth, uptake, diffusivity) in (0.008..0.02_f32, 0.02..0.3_f32, 2.0..40.0_f32),
        (light_decay, max_depth, rise) in (0.03..0.12_f32, 30.0..50.0_f32, 0.0..0.004_f32),
        repose in 30.0..45.0_f32,
    ) -> reef::Params {
        reef::Params {
            growth, uptake, diffusivity, light_decay, max_depth,
            stages: vec![reef::Stage { duration: 5000.0, rise: 5000.0 * rise }],
            rubble: Some(reef::Rubble { repose: repose.to_radians(), every: 10, passes: 2 }),
            ..barrier()
        }
    }
}

prop_compose! {
    fn any_world()(
        hydraulic in water(),
        reef in coral(),
        (exponent, share, seed) in (0.6..1.0_f32, 0.05..0.25_f32, any::<u32>()),
        (height, sea, extent) in (300.0..1500.0_f32, 0.0..0.3_f32, 3000.0..9000.0_f32),
        repose in 30.0..42.0_f32,
        boundary in prop_oneof![Just(Boundary::Sea), Just(Boundary::Closed), Just(Boundary::Open)],
    ) -> Plan {
        let cone = Generator::Cone { height, radius: 0.47 * extent, exponent, center: [0.0; 2] };
        let noise =
            Generator::Simplex { amplitude: share, offset: 0.0, wavelength: extent / 4.0, octaves: 8, warp: 200.0, seed };
        Plan {
            layers: vec![
                layers::Layer::Generate { generator: cone, combine: Combine::Add },
                layers::Layer::Generate { generator: noise, combine: Combine::Power { reference: height } },
            ],
            sea_level: sea * height,
            boundary,
            hydraulic: Some(hydraulic),
            thermal: Some(thermal::Params { repose: repose.to_radians(), ..slides() }),
            seabed_smoothing: 30.0,
            reef: Some(reef),
            ..world(64, extent, Vec::new())
        }
    }
}

/// Unstable would be: not a number, a negative depth, or ground outside the initial range by more than the relief.
fn unstable(gpu: &Gpu, plan: &Plan) -> Option<String> {
    let mut simulation = Simulation::new(gpu, plan).unwrap();
    simulation.step(Duration::ZERO).unwrap();
    simulation.step(Duration::ZERO).unwrap();
    let range =
        |values: &[f32]| values.iter().fold((f32::MAX, f32::MIN), |(lo, hi), h| (lo.min(*h), hi.max(*h)));
    let (lowest, highest) = range(&layer(gpu, &simulation, Layer::Height));
    simulation.finish().unwrap();
    for of in Layer::ALL {
        if !layer(gpu, &simulation, of).iter().all(|value| value.is_finite()) {
            return Some(format!("{} is not finite everywhere", of.name()));
        }
    }
    let (shallowest, _) = range(&depths(gpu, simulation.fields()));
    if shallowest < 0.0 {
        return Some(format!("a depth of {shallowest} m"));
    }
    let (low, high) = range(&layer(gpu, &simulation, Layer::Height));
    let relief = highest - lowest;
    (low < lowest - relief || high > highest + relief)
        .then(|| format!("ground from {low} to {high} m that began from {lowest} to {highest} m"))
}

/// Without a ramp, water a centimetre deep carries as much as a river: only the bounds keep such ground in its range.
#[test]
fn the_printed_model_stays_in_its_range_at_any_capacity() {
    let gpu = kit::gpu();
    let set = [
        "erosion.hydraulic.preset=paper",
        "erosion.hydraulic.capacity=50",
        "erosion.boundary=closed",
        "reef=none",
    ];
    let overrides = Overrides { set: set.map(String::from).to_vec(), seed: None };
    let plan = terrane::world::load(Path::new("configs/island/tiny.toml"), &overrides).unwrap().plan;
    let bare = Plan { hydraulic: None, thermal: None, seabed_smoothing: 0.0, ..plan.clone() };
    let [lowest, highest] = finished(&gpu, &bare).ground_range().unwrap();
    let [low, high] = finished(&gpu, &plan).ground_range().unwrap();
    // Heights of 700 m have 6e-5 m for their last place.
    let tolerance = 1e-3;
    assert!(
        low >= lowest - tolerance && high <= highest + tolerance,
        "{low}…{high} m from {lowest}…{highest} m"
    );
}

#[test]
fn no_world_in_the_documented_ranges_is_unstable() {
    let gpu = kit::gpu();
    let config = Config { cases: 40, failure_persistence: None, max_shrink_iters: 20, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let result = runner.run(&any_world(), |plan| match unstable(&gpu, &plan) {
        None => Ok(()),
        Some(reason) => Err(TestCaseError::fail(reason)),
    });
    if let Err(error) = result {
        panic!("{error}");
    }
}
