//! What a hand does to a run while it is under way: brushes, other parameters, processes off and on, undo.

use crate::kit;
use crate::kit::land::{barrier, finished, hill, layer, slides, texels, valleys, world};
use std::f64::consts::PI;
use std::time::Duration;
use terrane::{
    gpu::Gpu,
    terrain::{Brush, BrushKind, Kind, Layer, Plan, Position, Simulation, Stage, hydraulic::Pipes, thermal},
};

const CELLS: u32 = 64;
const EXTENT: f32 = 630.0;
const CELL: f64 = 10.0;

/// An island that every process works on.
fn everything() -> Plan {
    let settle = Some(thermal::Settle { repose: 40_f32.to_radians(), length: 20.0 });
    Plan {
        hydraulic: Some(valleys(30.0)),
        thermal: Some(thermal::Params { settle, ..slides() }),
        seabed_smoothing: 20.0,
        reef: Some(barrier()),
        ..world(CELLS, EXTENT, hill(CELLS, 60.0))
    }
}

/// Level dry ground, 10 m above the sea.
fn level() -> Plan {
    world(CELLS, EXTENT, vec![10.0; (CELLS * CELLS) as usize])
}

/// A run that is in the middle of erosion.
fn eroding(gpu: &Gpu, plan: &Plan) -> Simulation {
    let mut simulation = Simulation::new(gpu, plan).unwrap();
    while simulation.progress().stage != Stage::Hydraulic {
        simulation.step(Duration::ZERO).unwrap();
    }
    simulation.step_iterations(6, Duration::MAX).unwrap();
    simulation
}

/// Every layer of the land, as bits.
fn bits(gpu: &Gpu, simulation: &Simulation) -> Vec<Vec<u32>> {
    let bits = |of| layer(gpu, simulation, of).into_iter().map(f32::to_bits).collect();
    Layer::ALL.into_iter().map(bits).collect()
}

/// Metres from a brush's middle.
fn away(at: [f32; 2], index: usize) -> f64 {
    let place = |cell: usize| cell as f64 * CELL - f64::from(EXTENT) / 2.0;
    let (x, z) = (place(index % CELLS as usize), place(index / CELLS as usize));
    (x - f64::from(at[0])).hypot(z - f64::from(at[1]))
}

#[test]
fn a_brush_raises_as_much_as_its_falloff_says_and_nothing_beyond_it() {
    let gpu = kit::gpu();
    for (kind, sign) in [(BrushKind::Raise, 1.0), (BrushKind::Lower, -1.0)] {
        let mut simulation = finished(&gpu, &level());
        let brush = Brush { kind, at: [37.0, -52.0], radius: 130.0, strength: 5.0 };
        assert!(simulation.brush(brush).unwrap());
        let heights = layer(&gpu, &simulation, Layer::Height);
        let volume: f64 = heights.iter().map(|height| (f64::from(*height) - 10.0) * CELL * CELL).sum();
        // ∫ (1 − (r/R)²)² over the disc is a third of its area.
        let expected = sign * 5.0 * PI * 130.0 * 130.0 / 3.0;
        assert!((volume / expected - 1.0).abs() < 2e-3, "{kind:?}: {volume} m³ in place of {expected} m³");
        for (index, height) in heights.iter().enumerate() {
            let share = (1.0 - (away(brush.at, index) / 130.0).powi(2)).max(0.0).powi(2);
            assert!((f64::from(*height) - 10.0 - sign * 5.0 * share).abs() < 1e-4, "at {index}");
            if away(brush.at, index) > 130.0 {
                assert!(*height == 10.0, "{kind:?}: changed beyond the radius");
            }
        }
        // It is other ground to begin with: nothing has been worn or filled.
        assert!(layer(&gpu, &simulation, Layer::Wear).iter().all(|wear| *wear == 0.0));
        assert!(layer(&gpu, &simulation, Layer::Deposit).iter().all(|deposit| *deposit == 0.0));
        assert!(simulation.touched());
    }
}

#[test]
fn ground_stays_what_it_began_with_and_its_change() {
    let gpu = kit::gpu();
    let mut simulation = eroding(&gpu, &everything());
    simulation.brush(Brush { kind: BrushKind::Raise, at: [0.0, 0.0], radius: 200.0, strength: 7.0 }).unwrap();
    let check = |simulation: &Simulation, reef: bool| {
        let fields = simulation.fields();
        let [height, start] = [fields.height.src(), &fields.start].map(|image| texels(&gpu, image));
        let change = texels(&gpu, if reef { &fields.reef } else { &fields.change });
        assert!(height.iter().zip(start.iter().zip(&change)).all(|(h, (start, e))| *h == start + e));
    };
    check(&simulation, false);
    while simulation.progress().stage != Stage::Reef {
        simulation.step(Duration::MAX).unwrap();
    }
    simulation.step_iterations(3, Duration::MAX).unwrap();
    let before = layer(&gpu, &simulation, Layer::Reef);
    simulation
        .brush(Brush { kind: BrushKind::Lower, at: [100.0, 0.0], radius: 200.0, strength: 3.0 })
        .unwrap();
    check(&simulation, true);
    assert_eq!(layer(&gpu, &simulation, Layer::Reef), before);
    simulation.finish().unwrap();
    assert!(layer(&gpu, &simulation, Layer::Height).iter().all(|height| height.is_finite()));
}

#[test]
fn what_is_raised_out_of_the_sea_is_dry() {
    let gpu = kit::gpu();
    for mut simulation in [eroding(&gpu, &everything()), finished(&gpu, &everything())] {
        let sea = simulation.sea_level_now();
        // A sea that has risen since then covers land that rain ran over.
        let lowest = sea.min(everything().sea_level);
        let before = layer(&gpu, &simulation, Layer::Height);
        for at in [[250.0, 0.0], [-200.0, 150.0], [0.0, -250.0]] {
            let brush = Brush { kind: BrushKind::Raise, at, radius: 250.0, strength: 40.0 };
            simulation.brush(brush).unwrap();
            simulation.brush(brush).unwrap();
        }
        let [after, water] = [Layer::Height, Layer::Water].map(|of| layer(&gpu, &simulation, of));
        let is_land = |index: &usize| before[*index] < lowest && after[*index] >= sea;
        let land: Vec<usize> = (0..before.len()).filter(is_land).collect();
        assert!(land.len() > 50, "{} cells have been raised out of the sea", land.len());
        for index in land {
            assert!(water[index] == 0.0, "{} m of water on land at {index}", water[index]);
        }
    }
}

#[test]
fn a_brush_pours_as_much_water_as_its_falloff_says_but_none_into_the_sea() {
    let gpu = kit::gpu();
    let plan = Plan { hydraulic: Some(valleys(30.0)), ..level() };
    let mut simulation = eroding(&gpu, &plan);
    let water = |simulation: &Simulation| -> f64 {
        let cells = texels(&gpu, simulation.fields().water.src());
        cells.iter().map(|cell| f64::from(cell[0]) * CELL * CELL).sum()
    };
    let before = water(&simulation);
    let brush = Brush { kind: BrushKind::Rain, at: [0.0, 0.0], radius: 150.0, strength: 2.0 };
    assert!(simulation.brush(brush).unwrap());
    let poured = water(&simulation) - before;
    let expected = 2.0 * PI * 150.0 * 150.0 / 3.0;
    assert!((poured / expected - 1.0).abs() < 2e-3, "{poured} m³ in place of {expected} m³");

    let sea = Plan {
        hydraulic: Some(valleys(30.0)),
        ..world(CELLS, EXTENT, vec![-10.0; (CELLS * CELLS) as usize])
    };
    let mut simulation = eroding(&gpu, &sea);
    let before = water(&simulation);
    assert!(simulation.brush(brush).unwrap());
    assert_eq!(water(&simulation), before);
    // Where no rivers run there is nothing to pour into.
    assert!(!finished(&gpu, &level()).brush(brush).unwrap());
}

#[test]
fn where_the_mask_is_0_nothing_changes() {
    let gpu = kit::gpu();
    let plan = Plan { reef: None, seabed_smoothing: 0.0, ..everything() };
    let mut simulation = eroding(&gpu, &plan);
    let brush = Brush { kind: BrushKind::Mask, at: [40.0, 30.0], radius: 160.0, strength: 0.0 };
    assert!(simulation.brush(brush).unwrap());
    let before = layer(&gpu, &simulation, Layer::Height);
    simulation.finish().unwrap();
    let after = layer(&gpu, &simulation, Layer::Height);
    let mut changed = 0;
    for (index, (before, after)) in before.iter().zip(&after).enumerate() {
        if away(brush.at, index) < 80.0 {
            assert!(before.to_bits() == after.to_bits(), "{before} m became {after} m under the mask");
        }
        changed += u32::from(before != after);
    }
    assert!(changed > CELLS * CELLS / 2, "elsewhere the land goes on to change");
}

#[test]
fn brushes_without_size_or_off_the_grid_do_nothing() {
    let gpu = kit::gpu();
    let mut simulation = finished(&gpu, &level());
    let before = bits(&gpu, &simulation);
    for (at, radius, strength) in [
        ([0.0, 0.0], 0.0, 1.0),
        ([0.0, 0.0], -3.0, 1.0),
        ([f32::NAN, 0.0], 10.0, 1.0),
        ([0.0, 0.0], f32::INFINITY, 1.0),
        ([0.0, 0.0], 10.0, f32::NAN),
        ([1e9, -1e9], 10.0, 1.0),
    ] {
        simulation.brush(Brush { kind: BrushKind::Raise, at, radius, strength }).unwrap();
    }
    assert!(bits(&gpu, &simulation) == before);
}

#[test]
fn a_retuned_run_goes_on_as_one_that_had_these_parameters_would() {
    let gpu = kit::gpu();
    let plan = everything();
    let mut other = plan.clone();
    if let (Some(hydraulic), Some(thermal), Some(reef)) =
        (&mut other.hydraulic, &mut other.thermal, &mut other.reef)
    {
        hydraulic.rain *= 2.0;
        hydraulic.duration = 40.0;
        hydraulic.drag = 0.0;
        hydraulic.sediment_diffusivity *= 3.0;
        thermal.every = 3;
        reef.growth *= 1.5;
        reef.rubble = None;
    }
    other.seabed_smoothing = 30.0;
    let mut first = eroding(&gpu, &plan);
    let position = first.position().unwrap();
    assert_eq!((position.process, position.pass), (0, 0));
    let mut second = Simulation::new(&gpu, &other).unwrap();
    for (from, to) in first.parts(position).unwrap().into_iter().zip(second.parts(position).unwrap()) {
        to.upload(&gpu, &from.download(&gpu).unwrap()).unwrap();
    }
    second.resume(position);
    assert!(first.retune(&other).unwrap());
    assert!(first.touched() && first.plan() == &other);
    first.finish().unwrap();
    second.finish().unwrap();
    assert!(bits(&gpu, &first) == bits(&gpu, &second));
    assert!(bits(&gpu, &first) != bits(&gpu, &finished(&gpu, &plan)), "the parameters make a difference");
}

#[test]
fn what_only_a_new_run_can_do_is_refused() {
    let gpu = kit::gpu();
    let plan = everything();
    let mut simulation = eroding(&gpu, &plan);
    assert!(simulation.retune(&plan).unwrap());
    assert!(!simulation.touched(), "the same plan changes nothing");
    type Change = fn(&mut Plan);
    let changes: [Change; 6] = [
        |plan| plan.layers.push(plan.layers[0].clone()),
        |plan| plan.grid.extent *= 2.0,
        |plan| plan.sea_level += 1.0,
        |plan| plan.hydraulic.iter_mut().for_each(|params| params.pipes = Pipes::Four),
        |plan| plan.reef = None,
        // Settling is over.
        |plan| plan.thermal.iter_mut().for_each(|params| params.settle = None),
    ];
    for (index, change) in changes.iter().enumerate() {
        let mut other = plan.clone();
        change(&mut other);
        assert!(!simulation.retune(&other).unwrap(), "change {index}");
    }
    simulation.finish().unwrap();
    assert!(bits(&gpu, &simulation) == bits(&gpu, &finished(&gpu, &plan)));
}

#[test]
fn processes_that_are_off_do_nothing() {
    let gpu = kit::gpu();
    let plan = everything();
    let mut simulation = Simulation::new(&gpu, &plan).unwrap();
    for kind in Kind::ALL {
        simulation.enable(kind, false);
        assert!(!simulation.is_enabled(kind));
    }
    simulation.finish().unwrap();
    // Base terrain and what settles it.
    let bare = Plan { hydraulic: None, seabed_smoothing: 0.0, reef: None, ..plan.clone() };
    let mut settled = Simulation::new(&gpu, &bare).unwrap();
    while settled.progress().stage != Stage::Thermal {
        settled.step(Duration::ZERO).unwrap();
    }
    assert_eq!(layer(&gpu, &simulation, Layer::Height), layer(&gpu, &settled, Layer::Height));
    assert!(layer(&gpu, &simulation, Layer::Reef).iter().all(|reef| *reef == 0.0));

    // Off and on again before anything has happened: as if never touched.
    let mut simulation = Simulation::new(&gpu, &plan).unwrap();
    simulation.enable(Kind::Hydraulic, false);
    simulation.enable(Kind::Hydraulic, true);
    simulation.finish().unwrap();
    assert!(bits(&gpu, &simulation) == bits(&gpu, &finished(&gpu, &plan)));
}

#[test]
fn a_reef_that_is_switched_on_late_grows_on_the_land_that_there_is() {
    let gpu = kit::gpu();
    let mut simulation = Simulation::new(&gpu, &everything()).unwrap();
    while simulation.progress().stage != Stage::Reef {
        simulation.step(Duration::MAX).unwrap();
    }
    let land = layer(&gpu, &simulation, Layer::Height);
    simulation.enable(Kind::Reef, false);
    simulation.step_iterations(4, Duration::MAX).unwrap();
    assert_eq!(layer(&gpu, &simulation, Layer::Height), land);
    simulation.enable(Kind::Reef, true);
    simulation.finish().unwrap();
    let [height, reef] = [Layer::Height, Layer::Reef].map(|of| layer(&gpu, &simulation, of));
    assert!(reef.iter().any(|reef| *reef > 0.1));
    let fields = simulation.fields();
    let grown = texels(&gpu, &fields.reef);
    for ((height, land), grown) in height.iter().zip(&land).zip(&grown) {
        assert!((height - land - grown).abs() < 1e-4);
    }
}

#[test]
fn iterations_are_counted_one_by_one() {
    let gpu = kit::gpu();
    let plan = everything();
    let mut simulation = Simulation::new(&gpu, &plan).unwrap();
    while !simulation.progress().finished {
        let before = simulation.progress();
        let after = simulation.step_iterations(1, Duration::MAX).unwrap();
        let next = after.stage == before.stage && after.iteration == before.iteration + 1;
        let turned = after.stage != before.stage && before.iteration + 1 == before.of;
        assert!(next || turned, "{before:?} became {after:?}");
    }
    assert!(bits(&gpu, &simulation) == bits(&gpu, &finished(&gpu, &plan)));
}

#[test]
fn a_snapshot_brings_all_of_a_run_back() {
    let gpu = kit::gpu();
    let plan = everything();
    let expected = bits(&gpu, &finished(&gpu, &plan));
    let mut simulation = eroding(&gpu, &plan);
    let before = simulation.position();
    let snapshot = simulation.snapshot().unwrap().unwrap();
    // Ground 3, water 4, sediment 1, outflows 8, slope 1.
    assert_eq!(snapshot.bytes(), 17 * 4 * u64::from(CELLS * CELLS));
    for kind in [BrushKind::Raise, BrushKind::Rain, BrushKind::Mask] {
        let brush = Brush { kind, at: [10.0, 20.0], radius: 90.0, strength: 0.5 };
        assert!(simulation.brush(brush).unwrap());
    }
    simulation.step_iterations(3, Duration::MAX).unwrap();
    assert!(simulation.restore(&snapshot).unwrap());
    assert_eq!(simulation.position(), before);
    simulation.finish().unwrap();
    assert!(bits(&gpu, &simulation) == expected, "after brushes");
    // A mask comes back, too.
    let brush = Brush { kind: BrushKind::Mask, at: [10.0, 20.0], radius: 90.0, strength: 0.25 };
    assert!(simulation.restore(&snapshot).unwrap() && simulation.brush(brush).unwrap());
    let masked = simulation.snapshot().unwrap().unwrap();
    assert_eq!(masked.bytes(), (17 + 4) * 4 * u64::from(CELLS * CELLS));
    let mask = texels(&gpu, &simulation.fields().controls);
    assert!(simulation.restore(&snapshot).unwrap() && simulation.restore(&masked).unwrap());
    assert_eq!(texels(&gpu, &simulation.fields().controls), mask);
    // From behind a stage that was not there yet.
    assert!(simulation.restore(&snapshot).unwrap());
    assert_eq!(simulation.position(), before);
    simulation.finish().unwrap();
    assert!(bits(&gpu, &simulation) == expected, "after the end");
    // To the very beginning of erosion, and forth again.
    let last = simulation.snapshot().unwrap().unwrap();
    let mut other = Simulation::new(&gpu, &plan).unwrap();
    assert!(other.restore(&last).unwrap());
    assert!(other.progress().finished && bits(&gpu, &other) == expected);
    assert_eq!(
        last.position(),
        Position { stage: Stage::Reef, iteration: simulation.progress().of, process: 0, pass: 0 }
    );
}

#[test]
fn ground_that_is_updated_is_the_land_as_it_is() {
    let gpu = kit::gpu();
    let mut simulation = eroding(&gpu, &everything());
    let mut ground = simulation.land().unwrap();
    simulation.finish().unwrap();
    simulation.update(&mut ground).unwrap();
    let land = simulation.land().unwrap();
    assert_eq!(ground.sea_level, land.sea_level);
    for (updated, new) in [
        (ground.height, land.height),
        (ground.water, land.water),
        (ground.wetness, land.wetness),
        (ground.reef, land.reef),
    ] {
        assert_eq!(texels(&gpu, &updated), texels(&gpu, &new));
    }
}
