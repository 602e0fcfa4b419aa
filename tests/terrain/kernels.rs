//! The island on the GPU, each kernel against its f64 reference.

use crate::kit;
use crate::kit::{
    field::{assert_close, check_close},
    land::{barrier, finished, hill, layer, paper, random, slides, texels, valleys, world},
};
use crate::reference;
use crate::reference::{
    base,
    hydraulic::{self as pipes, Cell, Erosion, Flow},
    lattice::Lattice,
    reef as coral, seabed,
};
use std::{sync::Arc, time::Duration};
use terrane::{
    gpu::{Compute, Gpu, Recorder},
    shaders::terrain::{hydraulic_erode, hydraulic_flow, thermal as thermal_kernel},
    terrain::{
        Boundary, Controls, Fields, Layer, Map, Plan, Process, Simulation, Stage,
        hydraulic::{self, Hydraulic, Pipes, Section, Transport},
        layers::{self, Combine, Generator},
        reef,
        thermal::{self, Law, Settle},
    },
};

/// The state of the water as the reference holds it.
fn cells(gpu: &Gpu, fields: &Fields, transport: Transport) -> Vec<Cell> {
    let change = texels(gpu, &fields.change);
    let water = texels(gpu, fields.water.src());
    let sediment = texels(gpu, fields.sediment.src());
    let axis = texels(gpu, fields.axis.src());
    let diagonal = texels(gpu, fields.diagonal.src());
    (0..change.len())
        .map(|at| {
            let [d, y, z, wet] = water[at].map(f64::from);
            let (c, q, velocity) = match transport {
                Transport::Flux => (y, z, [0.0; 2]),
                Transport::SemiLagrangian => (0.0, y.hypot(z) * d, [y, z]),
            };
            let [l, r, t, b] = axis[at].map(f64::from);
            // A texel that a model has not is not there.
            let [tl, tr, bl, br] = diagonal.get(at).copied().unwrap_or_default().map(f64::from);
            Cell {
                e: f64::from(change[at]),
                s: f64::from(sediment[at]),
                c,
                d,
                q,
                wet,
                velocity,
                flux: [l, r, t, b, tl, tr, bl, br],
            }
        })
        .collect()
}

/// Puts a state into the fields, rounded to what they hold; returns it as they hold it.
fn upload(gpu: &Gpu, fields: &Fields, transport: Transport, h0: &[f32], cells: &[Cell]) -> Vec<Cell> {
    let single = |value: f64| value as f32;
    let held: Vec<Cell> = cells
        .iter()
        .map(|cell| {
            let round = |value: f64| f64::from(single(value));
            Cell {
                e: round(cell.e),
                s: round(cell.s),
                c: round(cell.c),
                d: round(cell.d),
                q: round(cell.q),
                wet: round(cell.wet),
                velocity: cell.velocity.map(round),
                flux: cell.flux.map(round),
            }
        })
        .collect();
    let texels =
        |value: &dyn Fn(&Cell) -> f64| -> Vec<f32> { held.iter().map(|cell| single(value(cell))).collect() };
    let change = texels(&|cell| cell.e);
    let height: Vec<f32> = h0.iter().zip(&change).map(|(h0, e)| h0 + e).collect();
    let four = |value: &dyn Fn(&Cell) -> [f64; 4]| -> Vec<[f32; 4]> {
        held.iter().map(|cell| value(cell).map(single)).collect()
    };
    let water = |cell: &Cell| match transport {
        Transport::Flux => [cell.d, cell.c, cell.q, cell.wet],
        Transport::SemiLagrangian => [cell.d, cell.velocity[0], cell.velocity[1], cell.wet],
    };
    let mut rec = Recorder::new(gpu);
    rec.upload(&fields.start, h0);
    rec.upload(&fields.change, &change);
    rec.upload(fields.height.src(), &height);
    rec.upload(fields.water.src(), &four(&water));
    rec.upload(fields.sediment.src(), &texels(&|cell| cell.s));
    rec.upload(fields.axis.src(), &four(&|cell| std::array::from_fn(|k| cell.flux[k])));
    if fields.diagonal.src().size() == fields.axis.src().size() {
        rec.upload(fields.diagonal.src(), &four(&|cell| std::array::from_fn(|k| cell.flux[k + 4])));
    }
    rec.submit().unwrap().wait().unwrap();
    held
}

fn record(gpu: &Gpu, passes: impl FnOnce(&mut Recorder)) {
    let mut rec = Recorder::new(gpu);
    passes(&mut rec);
    rec.submit().unwrap().wait().unwrap();
}

// ---- Base terrain ---------------------------------------------------------------------------------------------------

fn generate(generator: Generator, combine: Combine) -> layers::Layer {
    layers::Layer::Generate { generator, combine }
}

fn simplex(amplitude: f32, warp: f32) -> Generator {
    Generator::Simplex { amplitude, offset: 0.1, wavelength: 1600.0, octaves: 8, warp, seed: 7 }
}

fn fault_blocks() -> Generator {
    Generator::DiamondSquare { n: 6, init_height: 30.0, spread: 20.0, reduction: 0.55, seed: 3 }
}

/// Every generator and every way to combine, chained.
fn chained() -> Vec<layers::Layer> {
    let cone = Generator::Cone { height: 900.0, radius: 2500.0, exponent: 0.8, center: [120.0, -75.0] };
    vec![
        generate(cone.clone(), Combine::Max),
        generate(simplex(0.2, 200.0), Combine::Power { reference: 900.0 }),
        layers::Layer::Crater { level: 700.0 },
        generate(fault_blocks(), Combine::Add),
        generate(simplex(0.3, 0.0), Combine::Multiply),
        generate(Generator::Heightmap { map: uneven() }, Combine::Add),
        generate(cone, Combine::Min),
    ]
}

/// A raster of another shape than the grid.
fn uneven() -> Arc<Map> {
    Arc::new(Map { width: 23, height: 9, values: random("uneven", 23 * 9) })
}

#[test]
fn base_terrain_agrees_with_the_reference() {
    let gpu = kit::gpu();
    let whole = chained();
    for count in 1..=whole.len() {
        let plan = Plan { layers: whole[..count].to_vec(), ..world(97, 6000.0, Vec::new()) };
        let got = layer(&gpu, &finished(&gpu, &plan), Layer::Height);
        let want = base::height(Lattice::new(plan.grid), &plan.layers);
        // Across devices the base terrain agrees to 1e-5 of its range: positions in the noise are rounded to 2⁻¹⁹ of a
        // wavelength, and pow and exp2 to a few units in the last place.
        assert_close(&format!("{count} layers"), &got, &want, 1e-5 * 900.0);
        let mut wrong = want;
        wrong[4000] += 0.02;
        check_close(&got, &wrong, 1e-5 * 900.0).unwrap_err();
    }
}

#[test]
fn a_heightmap_of_the_grids_own_size_is_taken_as_it_is() {
    let gpu = kit::gpu();
    let heights = random("own size", 65 * 65);
    let got = layer(&gpu, &finished(&gpu, &world(65, 640.0, heights.clone())), Layer::Height);
    assert_eq!(got, heights);
}

#[test]
fn controls_are_interpolated() {
    let gpu = kit::gpu();
    let controls = Controls { rain: Some(uneven()), erodibility: None, mask: Some(uneven()) };
    let plan = Plan { controls, ..world(64, 640.0, hill(64, 100.0)) };
    let fields = Fields::new(&gpu, &plan).unwrap();
    let got = texels(&gpu, &fields.controls);
    let want = base::bilinear(Lattice::new(plan.grid), &uneven());
    for channel in [0, 2] {
        let got: Vec<f32> = got.iter().map(|texel| texel[channel]).collect();
        assert_close("control", &got, &want, 1e-6);
    }
    assert!(got.iter().all(|texel| texel[1] == 1.0));
}

// ---- Thermal erosion ------------------------------------------------------------------------------------------------

#[test]
fn thermal_erosion_agrees_with_the_reference() {
    let gpu = kit::gpu();
    let heights = hill(64, 150.0);
    for (law, boundary, masked) in [
        (Law::Excess, Boundary::Sea, false),
        (Law::Excess, Boundary::Closed, true),
        (Law::Drop, Boundary::Sea, false),
        (Law::Drop, Boundary::Sea, true),
    ] {
        let controls = Controls { mask: masked.then(uneven_mask), ..Controls::default() };
        let thermal = thermal::Params { law, duration: 60.0, ..slides() };
        let plan = Plan { boundary, controls, thermal: Some(thermal), ..world(64, 640.0, heights.clone()) };
        let fields = finished(&gpu, &plan);
        let got = texels(&gpu, &fields.fields().change);
        let h0: Vec<f64> = heights.iter().map(|h| f64::from(*h)).collect();
        let want: Vec<f64> = reference::island::erode(&plan, &h0).iter().map(|cell| cell.e).collect();
        assert!(want.iter().any(|e| *e > 0.5), "{law:?}: something slides");
        // 19 passes over heights up to 150 m (half an ulp: 8e-6 m), each of which may round into a share of it.
        assert_close(&format!("{law:?} {boundary:?}"), &got, &want, 2e-4);
    }
}

/// The mask of a plan, sampled.
fn mask_of(plan: &Plan) -> Vec<f64> {
    let lattice = Lattice::new(plan.grid);
    let everywhere = || vec![1.0; lattice.len()];
    plan.controls.mask.as_ref().map_or_else(everywhere, |map| base::bilinear(lattice, map))
}

fn uneven_mask() -> Arc<Map> {
    Arc::new(Map { width: 3, height: 3, values: vec![1.0, 0.5, 1.0, 0.0, 1.0, 0.3, 1.0, 1.0, 0.7] })
}

#[test]
fn settling_comes_before_counting() {
    let gpu = kit::gpu();
    let settle = Settle { repose: 35_f32.to_radians(), length: 30.0 };
    let thermal = thermal::Params { settle: Some(settle), ..slides() };
    let heights = hill(64, 150.0);
    let controls = Controls { mask: Some(uneven_mask()), ..Controls::default() };
    let plan = Plan { controls, thermal: Some(thermal), ..world(64, 640.0, heights.clone()) };
    let mut simulation = Simulation::new(&gpu, &plan).unwrap();
    while simulation.progress().stage != Stage::Thermal {
        simulation.step(Duration::MAX).unwrap();
    }
    let h0 = heights.iter().map(|h| f64::from(*h)).collect();
    let want = reference::island::settled(&plan, h0);
    assert_close("start", &texels(&gpu, &simulation.fields().start), &want, 2e-4);
    assert!(texels(&gpu, &simulation.fields().change).iter().all(|e| *e == 0.0));
}

// ---- Hydraulic erosion ----------------------------------------------------------------------------------------------

/// The models that the kernels can be, each with a name.
fn models() -> Vec<(&'static str, Plan)> {
    let base = |params| Plan { hydraulic: Some(params), ..world(64, 640.0, hill(64, 60.0)) };
    // A cloudburst, so that there is much to compare after a minute.
    let rains = hydraulic::Params { rain: 1e-3, ..valleys(60.0) };
    let controls =
        Controls { rain: Some(uneven_mask()), erodibility: Some(uneven_mask()), mask: Some(uneven_mask()) };
    vec![
        ("eight pipes", base(rains)),
        ("closed", Plan { boundary: Boundary::Closed, ..base(rains) }),
        ("open", Plan { boundary: Boundary::Open, ..base(rains) }),
        ("controls", Plan { controls, ..base(rains) }),
        ("four pipes", base(hydraulic::Params { pipes: Pipes::Four, ..rains })),
        ("fixed section with drag", base(hydraulic::Params { section: Section::Fixed, ..rains })),
        ("no drag", base(hydraulic::Params { drag: 0.0, evaporation: 0.002, ..rains })),
        (
            "a grid that blocks don't divide",
            Plan { hydraulic: Some(rains), ..world(67, 660.0, hill(67, 60.0)) },
        ),
        ("many sweeps", base(hydraulic::Params { sediment_diffusivity: 60.0, ..rains })),
        (
            "paper",
            Plan {
                boundary: Boundary::Closed,
                ..base(hydraulic::Params { rain: 1e-3, capacity: 10.0, ..paper(20.0) })
            },
        ),
    ]
}

fn erosion(plan: &Plan) -> Erosion {
    let lattice = Lattice::new(plan.grid);
    let layers::Layer::Generate { generator: Generator::Heightmap { map }, .. } = &plan.layers[0] else {
        panic!("these worlds are heightmaps")
    };
    let h0 = map.values.iter().map(|h| f64::from(*h)).collect();
    let params = plan.hydraulic.unwrap();
    let mut erosion = Erosion::new(lattice, params, plan.boundary, f64::from(plan.sea_level), h0);
    let control = |map: &Option<Arc<Map>>, values: &mut Vec<f64>| {
        if let Some(map) = map {
            *values = base::bilinear(lattice, map);
        }
    };
    control(&plan.controls.rain, &mut erosion.rain);
    control(&plan.controls.erodibility, &mut erosion.erodibility);
    control(&plan.controls.mask, &mut erosion.mask);
    erosion
}

/// Compares every part of the state, each with `tolerance` of its own largest value, and the last place of an e of a
/// metre: what wears is rounded to that.
fn check_cells(got: &[Cell], want: &[Cell], tolerance: f64) -> Result<(), String> {
    let part = |name: &str, of: &dyn Fn(&Cell) -> f64| {
        let want: Vec<f64> = want.iter().map(of).collect();
        let got: Vec<f32> = got.iter().map(|cell| of(cell) as f32).collect();
        let scale = want.iter().fold(0.0_f64, |scale, value| scale.max(value.abs()));
        check_close(&got, &want, tolerance * scale + 1e-7).map_err(|message| format!("{name}: {message}"))
    };
    part("e", &|cell| cell.e)?;
    part("s", &|cell| cell.s)?;
    part("c", &|cell| cell.c)?;
    part("d", &|cell| cell.d)?;
    part("q", &|cell| cell.q)?;
    part("wet", &|cell| cell.wet)?;
    (0..8).try_for_each(|k| part("flux", &|cell| cell.flux[k]))
}

/// One iteration from a state in the middle of a run, which both sides hold to the same bits.
#[test]
fn one_hydraulic_iteration_agrees_with_the_reference() {
    let gpu = kit::gpu();
    for (name, plan) in models() {
        let erosion = erosion(&plan);
        let h0: Vec<f32> = erosion.h0.iter().map(|h| *h as f32).collect();
        let (mut state, mut flow, mut next) = (erosion.start(), Flow::default(), Vec::new());
        for _ in 0..40 {
            erosion.iterate(&mut state, &mut flow, &mut next);
        }

        let mut fields = Fields::new(&gpu, &plan).unwrap();
        let mut process = Hydraulic::new(&gpu, &plan, &plan.hydraulic.unwrap()).unwrap();
        let mut want = upload(&gpu, &fields, erosion.params.transport, &h0, &state);
        erosion.iterate(&mut want, &mut flow, &mut next);
        record(&gpu, |rec| process.step(rec, &mut fields, 2));
        let got = cells(&gpu, &fields, erosion.params.transport);
        // Heights of up to 100 m are held to 4e-6 m, so the depth of a flow 1 cm deep to 8e-4 of itself, and with it what such
        // a flow carries: less than half of that beside the largest value of the raster.
        check_cells(&got, &want, 3e-4).unwrap_or_else(|message| panic!("{name}: {message}"));
        let mut wrong = want;
        wrong[2000].flux[1] += 0.02;
        check_cells(&got, &wrong, 3e-4).unwrap_err();
    }
}

/// Many iterations: what the rounding of each adds up to.
#[test]
fn a_hydraulic_run_agrees_with_the_reference() {
    let gpu = kit::gpu();
    let run = |erosion: &Erosion| {
        let (mut cells, mut flow, mut next) = (erosion.start(), Flow::default(), Vec::new());
        for _ in 0..pipes::iterations(&erosion.params, erosion.lattice.cell) {
            erosion.iterate(&mut cells, &mut flow, &mut next);
        }
        cells
    };
    for (name, plan) in models() {
        let erosion = erosion(&plan);
        let simulation = finished(&gpu, &plan);
        let got = cells(&gpu, simulation.fields(), erosion.params.transport);
        let errors = |want: &[Cell]| {
            let rms = |of: &dyn Fn(&Cell) -> f64| {
                let error: f64 = got.iter().zip(want).map(|(got, want)| (of(got) - of(want)).powi(2)).sum();
                let size: f64 = want.iter().map(|want| of(want).powi(2)).sum();
                (error / size).sqrt()
            };
            [rms(&|cell| cell.e), rms(&|cell| cell.d), rms(&|cell| cell.s), rms(&|cell| cell.flux[1])]
        };
        // Each iteration adds errors of 1e-6, and the flow makes more of them: the paper's most of all.
        let close = |errors: &[f64; 4]| errors.iter().all(|error| *error < 1e-3);
        let right = errors(&run(&erosion));
        assert!(close(&right), "{name}: e, d, s, flux differ by {right:?}");
        let mut wrong = erosion;
        wrong.params.gravity *= 1.02;
        assert!(!close(&errors(&run(&wrong))), "{name}: too much is accepted");
    }
}

/// A GPU works on blocks of one cell, a CPU device on larger ones: the same bits come out of both.
#[test]
fn blocks_of_any_size_make_the_same_bits() {
    let gpu = kit::gpu();
    // No block of several cells divides 67.
    let plan = Plan { hydraulic: Some(valleys(60.0)), ..world(67, 660.0, hill(67, 60.0)) };
    let erosion = erosion(&plan);
    let (mut state, mut flow, mut next) = (erosion.start(), Flow::default(), Vec::new());
    for _ in 0..20 {
        erosion.iterate(&mut state, &mut flow, &mut next);
    }
    let h0: Vec<f32> = erosion.h0.iter().map(|h| *h as f32).collect();
    let run = |columns: i32, rows: i32| {
        let fields = Fields::new(&gpu, &plan).unwrap();
        upload(&gpu, &fields, Transport::Flux, &h0, &state);
        let invocations = [columns, rows].map(|side| 67_u32.div_ceil(side.cast_unsigned()));
        record(&gpu, |rec| {
            let pass = Compute::<hydraulic_flow::Shader>::new(
                &gpu,
                hydraulic_flow::Constants { columns, rows, ..Default::default() },
            )
            .unwrap();
            let push = hydraulic_flow::Push {
                cell_size: 10.0,
                time_step: 0.7,
                sea_level: 3.0,
                rain: 1e-4,
                gravity: 9.81,
                pipe_depth: 4.0,
                drag: 0.1,
            };
            let bindings = hydraulic_flow::Bindings {
                height: fields.height.src(),
                water: fields.water.src(),
                sediment_in: fields.sediment.src(),
                sediment_out: fields.sediment.dst(),
                axis_in: fields.axis.src(),
                axis_out: fields.axis.dst(),
                diagonal_in: fields.diagonal.src(),
                diagonal_out: fields.diagonal.dst(),
                slope: &fields.slope,
                controls: &fields.controls,
            };
            rec.dispatch(&pass, invocations, push, bindings);
            let pass = Compute::<hydraulic_erode::Shader>::new(
                &gpu,
                hydraulic_erode::Constants { columns, rows, ..Default::default() },
            )
            .unwrap();
            let push = hydraulic_erode::Push {
                cell_size: 10.0,
                time_step: 0.7,
                sea_level: 3.0,
                rain: 1e-4,
                sediment_mixing: 0.1,
                creep_mixing: 0.01,
                bank_mixing: 0.1,
                max_speed: 14.0,
                capacity: 200.0,
                min_slope: 0.01,
                ramp_start: 0.01,
                ramp: 2.0,
                sea_fade: 0.3,
                erosion: 0.01,
                deposition: 0.02,
                max_change: 1.0,
                evaporation: 0.001,
                wet_depth: 0.05,
                wet_memory: 600.0,
            };
            let bindings = hydraulic_erode::Bindings {
                height_in: fields.height.src(),
                height_out: fields.height.dst(),
                start: &fields.start,
                change: &fields.change,
                water_in: fields.water.src(),
                water_out: fields.water.dst(),
                sediment_in: fields.sediment.dst(),
                sediment_out: fields.sediment.src(),
                axis: fields.axis.dst(),
                diagonal: fields.diagonal.dst(),
                slope: &fields.slope,
                controls: &fields.controls,
            };
            rec.dispatch(&pass, invocations, push, bindings);
            let pass = Compute::<thermal_kernel::Shader>::new(
                &gpu,
                thermal_kernel::Constants { columns, rows, ..Default::default() },
            )
            .unwrap();
            let push = thermal_kernel::Push {
                half_rate: 0.1,
                rise_on_land: 1.0,
                rise_under_water: 0.5,
                sea_level: 3.0,
                top: 1e29,
            };
            let bindings = thermal_kernel::Bindings {
                height_in: fields.height.dst(),
                height_out: fields.height.src(),
                change: &fields.change,
                start: &fields.start,
                controls: &fields.controls,
            };
            rec.dispatch(&pass, invocations, push, bindings);
        });
        let bits = |values: Vec<f32>| -> Vec<u32> { values.into_iter().map(f32::to_bits).collect() };
        let four = |values: Vec<[f32; 4]>| bits(values.into_flattened());
        [
            four(texels(&gpu, fields.axis.dst())),
            four(texels(&gpu, fields.diagonal.dst())),
            four(texels(&gpu, fields.water.dst())),
            bits(texels(&gpu, &fields.slope)),
            bits(texels(&gpu, fields.sediment.src())),
            bits(texels(&gpu, fields.height.src())),
            bits(texels(&gpu, &fields.change)),
        ]
    };
    let single = run(1, 1);
    assert!(single.iter().all(|field| field.iter().any(|bits| *bits != field[0])), "a field is uniform");
    for (columns, rows) in [(2, 2), (2, 4), (1, 3)] {
        assert!(run(columns, rows) == single, "{columns} × {rows}");
    }
}

// ---- Sea bed and reef -----------------------------------------------------------------------------------------------

#[test]
fn sea_bed_smoothing_agrees_with_the_reference() {
    let gpu = kit::gpu();
    let heights = hill(64, 60.0);
    for mask in [None, Some(uneven_mask())] {
        let controls = Controls { mask, ..Controls::default() };
        let flat = world(64, 640.0, heights.clone());
        let plan = Plan { controls, seabed_smoothing: 25.0, sea_level: 3.0, ..flat };
        let lattice = Lattice::new(plan.grid);
        let simulation = finished(&gpu, &plan);
        let mut want: Vec<f64> = heights.iter().map(|h| f64::from(*h)).collect();
        seabed::smooth(lattice, &mut want, 3.0, 25.0, &mask_of(&plan));
        // 12 means of heights up to 40 m, each rounded to half an ulp of 2e-6 m.
        assert_close("height", &layer(&gpu, &simulation, Layer::Height), &want, 5e-5);
        let change: Vec<f64> = want.iter().zip(&heights).map(|(h, h0)| h - f64::from(*h0)).collect();
        assert_close("change", &texels(&gpu, &simulation.fields().change), &change, 5e-5);
        assert!(change.iter().any(|change| change.abs() > 0.5));
    }
}

#[test]
fn a_reef_agrees_with_the_reference() {
    let gpu = kit::gpu();
    let heights = hill(64, 60.0);
    let ground: Vec<f64> = heights.iter().map(|h| f64::from(*h)).collect();
    let jump = reef::Stage { duration: 0.0, rise: 4.0 };
    let fall = reef::Stage { duration: 100.0, rise: -2.0 };
    let stages = [vec![jump], barrier().stages, vec![fall]].concat();
    for (name, params, mask) in [
        ("without rubble", reef::Params { rubble: None, ..barrier() }, None),
        ("with rubble", barrier(), None),
        ("masked", barrier(), Some(uneven_mask())),
        ("a sea that jumps and falls", reef::Params { stages, ocean_depth: 30.0, ..barrier() }, None),
    ] {
        let controls = Controls { mask, ..Controls::default() };
        let plan = Plan { controls, reef: Some(params.clone()), ..world(64, 1280.0, heights.clone()) };
        let simulation = finished(&gpu, &plan);
        let mut want = coral::Reef::new(Lattice::new(plan.grid), params, ground.clone(), 0.0);
        want.mask = mask_of(&plan);
        want.run();
        assert!((f64::from(simulation.sea_level()) - want.sea_level).abs() < 1e-6);
        // 30 steps and more, each rounded to half an ulp of heights up to 60 m, 2e-6 m, and 1e-6 of the growth by exp.
        assert_close(name, &texels(&gpu, &simulation.fields().reef), &want.b, 3e-4);
        let height: Vec<f64> = (0..want.b.len()).map(|at| want.height(at)).collect();
        assert_close(name, &layer(&gpu, &simulation, Layer::Height), &height, 3e-4);
        // Land is marked by a negative value.
        let carbon: Vec<f32> =
            texels(&gpu, simulation.fields().carbon.src()).iter().map(|carbon| carbon.max(0.0)).collect();
        assert_close(name, &carbon, &want.carbon, 1e-4);
        assert!(want.b.iter().any(|b| *b > 4.0), "{name}: coral grows");
    }
}

/// The whole island: every stage behind the one before it.
#[test]
fn an_island_agrees_with_the_reference() {
    let gpu = kit::gpu();
    let settle = Settle { repose: 40_f32.to_radians(), length: 20.0 };
    let plan = Plan {
        hydraulic: Some(valleys(60.0)),
        thermal: Some(thermal::Params { settle: Some(settle), ..slides() }),
        seabed_smoothing: 15.0,
        reef: Some(barrier()),
        ..world(64, 640.0, hill(64, 60.0))
    };
    let simulation = finished(&gpu, &plan);
    let want = reference::island::run(&plan);
    let got = layer(&gpu, &simulation, Layer::Height);
    // Coral has a threshold at the surface and rivers meander: some cells differ by millimetres, the land does not.
    assert_close("height", &got, &want.height, 0.05);
    let squares: f64 = got.iter().zip(&want.height).map(|(got, want)| (f64::from(*got) - want).powi(2)).sum();
    let rms = (squares / got.len() as f64).sqrt();
    assert!(rms < 1e-3, "rms {rms:.1e} m");
}
