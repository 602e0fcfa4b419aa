//! The f64 reference of the island model against closed forms, conserved quantities and symmetries.

use crate::reference::hydraulic::{Cell, Erosion, Flow, volumes};
use crate::reference::lattice::{Lattice, OFFSETS};
use crate::reference::reef::Reef;
use crate::reference::{base, noise, seabed, thermal};
use std::f64::consts::SQRT_2;
use terrane::terrain::layers::{Combine, Generator, Layer};
use terrane::terrain::thermal::Law;
use terrane::terrain::{Boundary, hydraulic, reef};

#[test]
fn diamond_square_agrees_with_two_other_programs() {
    let data: serde_json::Value =
        serde_json::from_str(include_str!("../data/terrain_noise_reference.json")).unwrap();
    for test in data["diamond_square"]["tests"].as_array().unwrap() {
        let number = |key: &str| test[key].as_f64().unwrap();
        let n = test["N"].as_u64().unwrap() as u32;
        let corners: Vec<f64> =
            test["corners_h00_h0n_hn0_hnn"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let offset: fn(usize, usize) -> f64 = match test["offset"].as_str().unwrap() {
            "1" => |_, _| 1.0,
            _ => |i, j| ((7 * i + 13 * j) % 11) as f64 / 5.0 - 1.0,
        };
        let corners = corners.try_into().unwrap();
        let h = noise::diamond_square(n, corners, number("spread"), number("R"), offset);
        let last = 1 << n;
        let at = |i: usize, j: usize| h[i * (last + 1) + j];
        let close = |key: &str, value: f64| {
            assert!(
                (value - number(key)).abs() <= 1e-12 * number("spread").max(20.0),
                "{}: {key}",
                test["name"]
            );
        };
        close("min", h.iter().copied().fold(f64::INFINITY, f64::min));
        close("max", h.iter().copied().fold(f64::NEG_INFINITY, f64::max));
        close("mean", h.iter().sum::<f64>() / h.len() as f64);
        close("center", at(last / 2, last / 2));
        close("h_0_mid", at(0, last / 2));
        close("h_1_1", at(1, 1));
        close("h_nm1_n", at(last - 1, last));
        for (i, row) in test["heights_rows"].as_array().into_iter().flatten().enumerate() {
            for (j, value) in row.as_array().unwrap().iter().enumerate() {
                assert!((at(i, j) - value.as_f64().unwrap()).abs() < 1e-12, "{}: ({i}, {j})", test["name"]);
            }
        }
    }
}

#[test]
fn simplex_noise_is_bounded_centred_smooth_and_isotropic() {
    let samples = 400;
    let step = 1e-4;
    let (mut sum, mut squares, mut largest, mut slopes) = (0.0, 0.0, 0.0f64, [0.0; 4]);
    for i in 0..samples {
        for j in 0..samples {
            let (x, z) = (i as f64 * 0.377 - 60.0, j as f64 * 0.377 - 60.0);
            let value = noise::simplex(x, z, 7);
            sum += value;
            squares += value * value;
            largest = largest.max(value.abs());
            let along = [(1.0, 0.0), (0.0, 1.0), (SQRT_2 / 2.0, SQRT_2 / 2.0), (SQRT_2 / 2.0, -SQRT_2 / 2.0)];
            for (slope, (dx, dz)) in slopes.iter_mut().zip(along) {
                let rise = noise::simplex(x + step * dx, z + step * dz, 7) - value;
                assert!(rise.abs() < 10.0 * step, "a jump at ({x}, {z})");
                *slope += (rise / step).powi(2);
            }
        }
    }
    let count = f64::from(samples * samples);
    assert!((sum / count).abs() < 0.01, "mean {}", sum / count);
    assert!((squares / count - 0.25).abs() < 0.005, "mean square {}", squares / count);
    assert!(largest < 1.0, "largest {largest}");
    for slope in slopes {
        assert!((slope / slopes[0] - 1.0).abs() < 0.05, "slopes along the axes and diagonals: {slopes:?}");
    }
    assert_ne!(noise::simplex(0.3, 0.4, 7), noise::simplex(0.3, 0.4, 8));
}

#[test]
fn layers_have_their_closed_forms() {
    let lattice = Lattice { n: 65, cell: 10.0 };
    let cone = |height| {
        let generator = Generator::Cone { height, radius: 300.0, exponent: 0.5, center: [0.0, 0.0] };
        Layer::Generate { generator, combine: Combine::Add }
    };
    let constant = |offset| Generator::Simplex {
        amplitude: 0.0,
        offset,
        wavelength: 100.0,
        octaves: 1,
        warp: 0.0,
        seed: 1,
    };
    let at = |h: &[f64], i: usize| h[lattice.index(i, 32)];

    let h = base::height(lattice, &[cone(400.0)]);
    assert!((at(&h, 32) - 400.0).abs() < 1e-9);
    assert!((at(&h, 47) - 400.0 * (1.0 - 0.5f64.sqrt())).abs() < 1e-9, "at half the radius");
    assert_eq!(at(&h, 63), 0.0);

    let power = Combine::Power { reference: 400.0 };
    let h =
        base::height(lattice, &[cone(400.0), Layer::Generate { generator: constant(1.0), combine: power }]);
    assert!((at(&h, 47) - 400.0 * (1.0 - 0.5f64.sqrt()).powi(2)).abs() < 1e-9, "(4)");
    assert_eq!(at(&h, 63), 0.0);

    let h = base::height(lattice, &[cone(400.0), Layer::Crater { level: 300.0 }]);
    assert!((at(&h, 32) - 200.0).abs() < 1e-9, "(5)");

    for (combine, expected) in
        [(Combine::Add, 403.0), (Combine::Multiply, 1200.0), (Combine::Max, 400.0), (Combine::Min, 3.0)]
    {
        let h = base::height(lattice, &[cone(400.0), Layer::Generate { generator: constant(3.0), combine }]);
        assert!((at(&h, 32) - expected).abs() < 1e-9, "{combine:?}");
    }
}

#[test]
fn bicubic_sampling_interpolates_and_keeps_straight_lines() {
    let lattice = Lattice { n: 33, cell: 1.0 };
    let plane = base::bicubic(lattice, 9, 9, |i, j| 3.0 * i as f64 - 2.0 * j as f64);
    for (i, j) in [(8, 8), (13, 17), (24, 9)] {
        let expected = (3.0 * i as f64 - 2.0 * j as f64) / 4.0;
        assert!((plane[lattice.index(i, j)] - expected).abs() < 1e-12);
    }
    let rough = base::bicubic(lattice, 9, 9, |i, j| ((7 * i + 13 * j) % 11) as f64);
    assert!((rough[lattice.index(12, 20)] - ((7 * 3 + 13 * 5) % 11) as f64).abs() < 1e-12);
}

#[test]
fn water_in_a_closed_box_follows_the_recurrence() {
    for relief in [0.0, 200.0] {
        let lattice = Lattice { n: 48, cell: 10.0 };
        let params = hydraulic::Params { rain: 1e-4, evaporation: 2e-3, ..params() };
        let erosion = Erosion::new(lattice, params, Boundary::Closed, 0.0, hills(lattice, relief));
        let mut cells = erosion.start();
        let kept = 1.0 - f64::from(params.evaporation) * erosion.step;
        let fallen = f64::from(params.rain) * erosion.step * lattice.len() as f64 * 100.0;
        let mut expected = 0.0;
        for _ in 0..1000 {
            advance(&erosion, &mut cells, 1);
            expected = (expected + fallen) * kept;
            assert!(cells.iter().all(|cell| cell.d >= 0.0));
        }
        let (water, _) = volumes(lattice, &cells);
        assert!((water / expected - 1.0).abs() < 1e-12, "relief {relief}: {}", water / expected - 1.0);
    }
}

#[test]
fn a_lake_stays_at_rest() {
    let lattice = Lattice { n: 32, cell: 10.0 };
    let params = hydraulic::Params { rain: 0.0, creep: 0.0, ..params() };
    let h0 = hills(lattice, 20.0);
    let erosion = Erosion::new(lattice, params, Boundary::Closed, 0.0, h0.clone());
    let start: Vec<Cell> = h0.iter().map(|h| Cell { d: 30.0 - h, ..Cell::default() }).collect();
    let mut cells = start.clone();
    advance(&erosion, &mut cells, 200);
    for (now, then) in cells.iter().zip(&start) {
        assert!((now.d - then.d).abs() < 1e-11 && now.velocity[0].hypot(now.velocity[1]) < 1e-11, "{now:?}");
    }
}

#[test]
fn the_sea_stays_at_its_level_and_takes_no_water_back() {
    let lattice = Lattice { n: 32, cell: 10.0 };
    let erosion = Erosion::new(lattice, params(), Boundary::Sea, 10.0, hills(lattice, 20.0));
    let mut cells = erosion.start();
    advance(&erosion, &mut cells, 200);
    let sea = (0..lattice.len()).filter(|&at| erosion.height(&cells, at) < 10.0);
    let off = sea.map(|at| (erosion.height(&cells, at) + cells[at].d - 10.0).abs()).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off}");
}

#[test]
fn a_tilted_plane_in_steady_rain_drains_what_falls_upslope_at_the_speed_of_its_drag() {
    for pipes in [hydraulic::Pipes::Four, hydraulic::Pipes::Eight] {
        let lattice = Lattice { n: 49, cell: 10.0 };
        let rain = 1e-4;
        let params =
            hydraulic::Params { rain, capacity: 0.0, creep: 0.0, bank_diffusion: 0.0, pipes, ..params() };
        let plane = lattice.map(|_, j| 200.0 - 3.0 * j as f64);
        let erosion = Erosion::new(lattice, params, Boundary::Open, 0.0, plane);
        let mut cells = erosion.start();
        advance(&erosion, &mut cells, 1500);
        // A little leaves over the upper rim, so rows are compared with each other.
        let discharge = |row: usize| cells[lattice.index(24, row)].q;
        let expected = f64::from(rain) * 16.0 * lattice.cell;
        let drained = discharge(24) - discharge(8);
        assert!((drained / expected - 1.0).abs() < 1e-3, "{pipes:?}: {drained} of {expected}");
        // Drag balances gravity: v = sqrt(g·d·S/c_f).
        let cell = &cells[lattice.index(24, 40)];
        let speed = (f64::from(params.gravity) * cell.d * 0.3 / f64::from(params.drag)).sqrt();
        assert!((cell.velocity[1] / speed - 1.0).abs() < 0.02, "{pipes:?}: {} for {speed}", cell.velocity[1]);

        let leaving: f64 = (0..lattice.n).map(|i| off_the_grid(lattice, &cells, i, 48)).sum::<f64>()
            + (0..48)
                .map(|j| off_the_grid(lattice, &cells, 0, j) + off_the_grid(lattice, &cells, 48, j))
                .sum::<f64>()
            + (1..48).map(|i| off_the_grid(lattice, &cells, i, 0)).sum::<f64>();
        let fallen = f64::from(rain) * lattice.len() as f64 * lattice.cell * lattice.cell;
        assert!((leaving / fallen - 1.0).abs() < 1e-3, "{pipes:?}: {leaving} of {fallen}");
    }
}

#[test]
fn pipes_are_stable_up_to_the_bound_and_not_beyond() {
    // A = 20 m², ℓ = 1 m: the bound is 0.0357 s.
    let roughness = |step: f64| {
        let lattice = Lattice { n: 32, cell: 1.0 };
        let params = hydraulic::Params {
            rain: 0.0,
            capacity: 0.0,
            drag: 0.0,
            creep: 0.0,
            bank_diffusion: 0.0,
            pipe_depth: 20.0,
            pipes: hydraulic::Pipes::Four,
            section: hydraulic::Section::Fixed,
            ..params()
        };
        let mut erosion = Erosion::new(lattice, params, Boundary::Closed, 0.0, vec![0.0; lattice.len()]);
        erosion.step = step;
        let mut cells = lattice.map(|i, j| Cell {
            d: 100.0 + 1e-3 * noise::random(3, j, i),
            flux: std::array::from_fn(
                |k| if k < 4 && lattice.neighbour(i, j, k).is_some() { 1.0 } else { 0.0 },
            ),
            ..Cell::default()
        });
        advance(&erosion, &mut cells, 2000);
        cells.iter().map(|cell| (cell.d - 100.0).abs()).fold(0.0, f64::max)
    };
    assert!(roughness(0.035) < 0.02, "{}", roughness(0.035));
    assert!(roughness(0.036) > 1.0, "{}", roughness(0.036));
}

#[test]
fn transport_by_the_pipes_keeps_the_mass_and_tracing_back_does_not() {
    let lattice = Lattice { n: 48, cell: 10.0 };
    let run = |boundary, preset: hydraulic::Params| {
        let erosion = Erosion::new(lattice, preset, boundary, 30.0, hills(lattice, 200.0));
        let mut cells = erosion.start();
        advance(&erosion, &mut cells, 300);
        let moved: f64 = cells.iter().map(|cell| cell.e.abs()).sum();
        let missing: f64 = cells.iter().map(|cell| cell.e + cell.s).sum();
        assert!(moved > 1.0, "something must move");
        missing.abs() / moved
    };
    for boundary in [Boundary::Closed, Boundary::Sea] {
        let lost = run(boundary, params());
        assert!(lost < 1e-12, "{boundary:?}: {lost}");
    }
    let traced = hydraulic::Params { transport: hydraulic::Transport::SemiLagrangian, ..params() };
    let lost = run(Boundary::Closed, traced);
    assert!(lost > 0.01, "{lost}");
}

#[test]
fn water_never_outruns_the_grid() {
    let lattice = Lattice { n: 48, cell: 10.0 };
    for (pipes, drag) in [(hydraulic::Pipes::Four, 0.0), (hydraulic::Pipes::Eight, 0.05)] {
        let params = hydraulic::Params { rain: 1e-3, pipes, drag, ..params() };
        let erosion = Erosion::new(lattice, params, Boundary::Closed, 0.0, hills(lattice, 400.0));
        let mut cells = erosion.start();
        for _ in 0..100 {
            advance(&erosion, &mut cells, 1);
            let fastest =
                cells.iter().map(|cell| cell.velocity[0].hypot(cell.velocity[1])).fold(0.0, f64::max);
            assert!(fastest * erosion.step <= lattice.cell * (1.0 + 1e-12));
        }
    }
}

#[test]
fn no_constants_dig_a_hole_or_pile_a_tower() {
    let lattice = Lattice { n: 40, cell: 10.0 };
    // The paper's model with a capacity far beyond what its speeds can bear.
    let paper = hydraulic::Params {
        pipes: hydraulic::Pipes::Four,
        section: hydraulic::Section::Fixed,
        drag: 0.0,
        slope: hydraulic::Slope::Central,
        transport: hydraulic::Transport::SemiLagrangian,
        ramp_depth: 0.0,
        capacity: 400.0,
        creep: 0.0,
        bank_diffusion: 0.0,
        ..params()
    };
    for (params, boundary) in [(paper, Boundary::Closed), (paper, Boundary::Open), (params(), Boundary::Open)]
    {
        let h0 = hills(lattice, 200.0);
        let lowest = h0.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = h0.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let erosion = Erosion::new(lattice, params, boundary, 0.0, h0);
        let mut cells = erosion.start();
        advance(&erosion, &mut cells, 400);
        for at in 0..lattice.len() {
            let h = erosion.height(&cells, at);
            assert!(h >= lowest - 1e-9 && h <= highest + 1e-9, "{h} outside {lowest}…{highest}");
            assert!(cells[at].s > -1e-9 && cells[at].d >= 0.0);
        }
    }
}

#[test]
fn height_above_the_datum_changes_nothing() {
    let lattice = Lattice { n: 48, cell: 10.0 };
    let run = |datum: f64| {
        let h0 = hills(lattice, 200.0).iter().map(|h| h + datum).collect();
        let erosion = Erosion::new(lattice, params(), Boundary::Closed, 0.0, h0);
        let mut cells = erosion.start();
        advance(&erosion, &mut cells, 200);
        cells
    };
    for (low, high) in run(0.0).iter().zip(run(2000.0)) {
        assert!((low.e - high.e).abs() < 1e-8);
    }
}

#[test]
fn flips_and_quarter_turns_commute_with_erosion() {
    let lattice = Lattice { n: 40, cell: 10.0 };
    for params in [params(), hydraulic::Params { slope: hydraulic::Slope::Central, ..params() }] {
        let run = |h0: Vec<f64>| {
            let erosion = Erosion::new(lattice, params, Boundary::Sea, 40.0, h0);
            let mut cells = erosion.start();
            for _ in 0..20 {
                advance(&erosion, &mut cells, 5);
                let h: Vec<f64> = (0..lattice.len()).map(|at| erosion.height(&cells, at)).collect();
                let change = thermal::pass(lattice, Law::Excess, 0.2, &h, |_| Some(0.5), |_| 1.0);
                cells.iter_mut().zip(change).for_each(|(cell, change)| cell.e += change);
            }
            cells.iter().map(|cell| cell.e).collect::<Vec<_>>()
        };
        let h0 = hills(lattice, 200.0);
        let e = run(h0.clone());
        for turn in [flip, quarter_turn] {
            assert!(run(turn(lattice, &h0)) == turn(lattice, &e), "not the same bits");
        }
    }
}

#[test]
fn the_mask_and_hard_rock_stop_erosion() {
    let lattice = Lattice { n: 40, cell: 10.0 };
    let mut erosion = Erosion::new(lattice, params(), Boundary::Closed, 0.0, hills(lattice, 200.0));
    erosion.mask = lattice.map(|i, _| if i < 20 { 0.0 } else { 1.0 });
    let mut cells = erosion.start();
    advance(&erosion, &mut cells, 100);
    let changed = |cells: &[Cell], columns: std::ops::Range<usize>| {
        columns
            .flat_map(|i| (0..40).map(move |j| (i, j)))
            .map(|(i, j)| cells[lattice.index(i, j)].e.abs())
            .sum::<f64>()
    };
    assert_eq!(changed(&cells, 0..20), 0.0);
    assert!(changed(&cells, 20..40) > 1.0);

    let params = hydraulic::Params { creep: 0.0, bank_diffusion: 0.0, ..params() };
    let mut erosion = Erosion::new(lattice, params, Boundary::Closed, 0.0, hills(lattice, 200.0));
    erosion.erodibility = vec![0.0; lattice.len()];
    let mut cells = erosion.start();
    advance(&erosion, &mut cells, 100);
    assert_eq!(changed(&cells, 0..40), 0.0);
}

#[test]
fn debris_slides_until_no_slope_is_steeper_than_repose() {
    let lattice = Lattice { n: 40, cell: 10.0 };
    let repose = 0.6;
    let mut h = hills(lattice, 400.0);
    let range = |h: &[f64]| {
        (h.iter().copied().fold(f64::INFINITY, f64::min), h.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    };
    let (lowest, highest) = range(&h);
    let mass: f64 = h.iter().sum();
    assert!(steepest(lattice, &h) > 1.0, "it must have something to do");
    for _ in 0..6000 {
        let change =
            thermal::pass(lattice, Law::Excess, thermal::LARGEST_SHARE, &h, |_| Some(repose), |_| 1.0);
        h.iter_mut().zip(change).for_each(|(h, change)| *h += change);
    }
    assert!((h.iter().sum::<f64>() / mass - 1.0).abs() < 1e-12);
    assert!(steepest(lattice, &h) <= repose + 1e-3, "{}", steepest(lattice, &h));
    let (low, high) = range(&h);
    assert!(low >= lowest && high <= highest);
}

#[test]
fn eight_neighbours_fill_a_pit_and_no_more() {
    let lattice = Lattice { n: 3, cell: 1.0 };
    let mut h = vec![10.0; 9];
    h[4] = 0.0;
    let filled = |law, share| {
        let change = thermal::pass(lattice, law, share, &h, |_| Some(0.5), |_| 1.0);
        assert!(change.iter().sum::<f64>().abs() < 1e-12);
        change.iter().zip(&h).map(|(change, h)| h + change).collect::<Vec<_>>()
    };
    let h = filled(Law::Drop, thermal::LARGEST_SHARE);
    assert!(h.iter().all(|&h| (h - 80.0 / 9.0).abs() < 1e-12), "the largest share levels the pit: {h:?}");
    let h = filled(Law::Drop, 0.25);
    assert!(h[4] > h[0], "more overshoots");
    let h = filled(Law::Excess, thermal::LARGEST_SHARE);
    assert!(h[4] < h[1] && h[1] < h[0], "the nearer neighbours exceed repose by more: {h:?}");
}

#[test]
fn smoothing_spreads_a_bump_by_its_length_and_leaves_land_alone() {
    let lattice = Lattice { n: 65, cell: 10.0 };
    let bump = |h: &[f64]| {
        let weigh = |power: i32| -> f64 {
            (0..lattice.len())
                .map(|at| (h[at] + 50.0) * lattice.position(at % 65, at / 65)[0].powi(power))
                .sum()
        };
        (weigh(0), weigh(2) / weigh(0))
    };
    let mut h = lattice.map(|i, j| if (i, j) == (32, 32) { -10.0 } else { -50.0 });
    let (mass, _) = bump(&h);
    seabed::smooth(lattice, &mut h, 0.0, 30.0, &vec![1.0; lattice.len()]);
    let (smoothed, variance) = bump(&h);
    assert!((smoothed - mass).abs() < 1e-9 && (variance - 900.0).abs() < 1e-6, "σ² = {variance}");

    let land = lattice.map(|i, j| 5.0 + (i * j % 7) as f64);
    let mut h = land.clone();
    seabed::smooth(lattice, &mut h, 0.0, 30.0, &vec![1.0; lattice.len()]);
    assert_eq!(h, land);
}

#[test]
fn coral_grows_as_light_allows_and_stops_below_the_surface() {
    let lattice = Lattice { n: 32, cell: 10.0 };
    let coral = reef::Params { uptake: 0.0, rubble: None, ..coral() };
    let mut flat = Reef::new(lattice, coral.clone(), vec![-10.0; lattice.len()], 0.0);
    flat.step(1);
    let expected = 0.014f64 * (-0.06f64 * 10.0).exp() * 25.0;
    assert!(flat.b.iter().all(|b| (b / expected - 1.0).abs() < 1e-6), "(25): {} {expected}", flat.b[0]);

    flat.params.stages = vec![reef::Stage { duration: 10_000.0, rise: 0.0 }];
    flat.run();
    assert!(flat.b.iter().all(|b| (b - 9.4).abs() < 1e-6), "grown to 0.6 m below the surface");

    let mut deep = Reef::new(lattice, coral, vec![-41.0; lattice.len()], 0.0);
    deep.step(1);
    assert!(deep.b.iter().all(|&b| b == 0.0), "deeper than light reaches");
}

#[test]
fn coral_keeps_up_with_a_slow_sea_and_drowns_in_a_fast_one() {
    let lattice = Lattice { n: 32, cell: 10.0 };
    let depth = |rate: f32| {
        let stages = vec![reef::Stage { duration: 10_000.0, rise: 10_000.0 * rate }];
        let coral = reef::Params { uptake: 0.0, rubble: None, stages, ..coral() };
        let mut reef = Reef::new(lattice, coral, vec![-5.0; lattice.len()], 0.0);
        reef.run();
        reef.sea_level - reef.height(lattice.index(16, 16))
    };
    assert!(depth(0.003) < 1.0, "{}", depth(0.003));
    assert!(depth(0.020) > 100.0, "{}", depth(0.020));
}

#[test]
fn carbon_spreads_without_loss_stays_within_bounds_and_starves_a_lagoon() {
    let lattice = Lattice { n: 40, cell: 20.0 };
    // A basin within a ring of land: nothing comes in and nothing goes out.
    let basin = |i: usize, j: usize| (8..32).contains(&i) && (8..32).contains(&j);
    let ground = lattice.map(|i, j| if basin(i, j) { -10.0 } else { 5.0 });
    let mut reef = Reef::new(lattice, coral(), ground, 0.0);
    reef.carbon = lattice.map(|i, j| if basin(i, j) { 0.5 + 0.4 * noise::random(1, j, i) } else { 0.0 });
    let total = |reef: &Reef| reef.carbon.iter().sum::<f64>();
    let before = total(&reef);
    reef.diffuse();
    assert!((total(&reef) / before - 1.0).abs() < 1e-12);

    // A shelf under an open ocean: the rim is fed, the middle starves.
    let ground = lattice.map(|i, j| if basin(i, j) { -10.0 } else { -100.0 });
    let stages = vec![reef::Stage { duration: 500.0, rise: 0.0 }];
    let mut reef =
        Reef::new(lattice, reef::Params { stages, rubble: None, uptake: 1.0, ..coral() }, ground, 0.0);
    reef.run();
    assert!(reef.carbon.iter().all(|carbon| (0.0..=1.0).contains(carbon)));
    let (outer, inner) = (reef.b[lattice.index(8, 20)], reef.b[lattice.index(20, 20)]);
    assert!(outer > 1.2 * inner, "{outer} {inner}");
}

#[test]
fn rubble_slides_under_water_only() {
    let lattice = Lattice { n: 40, cell: 10.0 };
    let cliff = |top: f64| lattice.map(move |i, _| if i < 20 { top } else { -60.0 });
    let shed = |top: f64| {
        let mut reef = Reef::new(lattice, coral(), cliff(top), 0.0);
        for _ in 0..10 {
            reef.shed(reef::Rubble { repose: 0.7, every: 1, passes: 1 });
        }
        (reef.b[lattice.index(19, 20)], reef.b.iter().sum::<f64>())
    };
    let (crest, balance) = shed(-0.6);
    assert!(crest < -1.0 && balance.abs() < 1e-9);
    assert_eq!(shed(1.0), (0.0, 0.0));
}

/// Defaults that erode quickly on small grids.
fn params() -> hydraulic::Params {
    hydraulic::Params {
        duration: 5000.0,
        rain: 1e-4,
        evaporation: 0.0,
        gravity: 9.81,
        pipes: hydraulic::Pipes::Eight,
        section: hydraulic::Section::Depth,
        pipe_depth: 4.0,
        drag: 0.15,
        capacity: 200.0,
        min_slope: 0.01,
        ramp_depth: 0.5,
        ramp_start: 0.0,
        slope: hydraulic::Slope::Outflow,
        erosion_rate: 0.005,
        deposition_rate: 0.015,
        rate_limit: 1.0,
        transport: hydraulic::Transport::Flux,
        sediment_diffusivity: 12.0,
        creep: 0.1,
        bank_diffusion: 3.0,
        sea_fade: 3.0,
        safety: 0.9,
        wet_depth: 0.05,
        wet_memory: 300.0,
    }
}

fn coral() -> reef::Params {
    reef::Params {
        step: 25.0,
        stages: Vec::new(),
        growth: 0.014,
        light_decay: 0.06,
        max_depth: 40.0,
        uptake: 0.15,
        diffusivity: 8.0,
        ocean_carbon: 1.0,
        ocean_depth: 60.0,
        keep: 0.6,
        rubble: Some(reef::Rubble { repose: 0.6, every: 10, passes: 2 }),
    }
}

/// Noise between about 0 and `relief` metres, four features across.
fn hills(lattice: Lattice, relief: f64) -> Vec<f64> {
    let wavelength = lattice.n as f64 * lattice.cell / 4.0;
    lattice.map(|i, j| {
        let [x, z] = lattice.position(i, j);
        relief * (0.5 + 0.3 * noise::fractal(x, z, 5, wavelength, 4))
    })
}

fn advance(erosion: &Erosion, cells: &mut Vec<Cell>, iterations: usize) {
    let (mut flow, mut next) = (Flow::default(), Vec::new());
    for _ in 0..iterations {
        erosion.iterate(cells, &mut flow, &mut next);
    }
}

/// Outflow over the rim, m³/s.
fn off_the_grid(lattice: Lattice, cells: &[Cell], i: usize, j: usize) -> f64 {
    let flux = cells[lattice.index(i, j)].flux;
    (0..8).filter(|&k| lattice.neighbour(i, j, k).is_none()).map(|k| flux[k]).sum()
}

/// The steepest of all slopes between neighbours.
fn steepest(lattice: Lattice, h: &[f64]) -> f64 {
    let slopes = |(i, j): (usize, usize)| {
        let at = lattice.index(i, j);
        (0..OFFSETS.len())
            .filter_map(move |k| Some((h[at] - h[lattice.neighbour(i, j, k)?]) / lattice.distance(k)))
            .fold(0.0, f64::max)
    };
    (0..lattice.n).flat_map(|j| (0..lattice.n).map(move |i| (i, j))).map(slopes).fold(0.0, f64::max)
}

fn flip(lattice: Lattice, raster: &[f64]) -> Vec<f64> {
    lattice.map(|i, j| raster[lattice.index(lattice.n - 1 - i, j)])
}

fn quarter_turn(lattice: Lattice, raster: &[f64]) -> Vec<f64> {
    lattice.map(|i, j| raster[lattice.index(j, lattice.n - 1 - i)])
}
