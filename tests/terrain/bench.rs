//! What the kernels are measured against computes the same steps.

use crate::kit;
use crate::kit::land::{finished, layer, paper, slides, valleys, world};
use terrane::{
    bench::native::Land,
    gpu::{DeviceKind, Gpu},
    terrain::{
        Boundary, Layer, Plan, Simulation,
        hydraulic::{self, Pipes},
        layers::{self, Combine, Generator},
        reef,
        thermal::{self, Law},
    },
};

/// An island of formulas, 97 cells a side.
fn island() -> Plan {
    let layer = |generator, combine| layers::Layer::Generate { generator, combine };
    let cone = Generator::Cone { height: 300.0, radius: 800.0, exponent: 0.8, center: [40.0, -30.0] };
    let noise = |amplitude, warp| Generator::Simplex {
        amplitude,
        offset: 0.0,
        wavelength: 400.0,
        octaves: 5,
        warp,
        seed: 7,
    };
    let layers = vec![
        layer(cone, Combine::Max),
        layer(noise(0.2, 60.0), Combine::Power { reference: 300.0 }),
        layers::Layer::Crater { level: 250.0 },
        layer(noise(8.0, 0.0), Combine::Add),
    ];
    Plan { layers, sea_level: 40.0, ..world(97, 1920.0, Vec::new()) }
}

/// After the same steps.
fn both(gpu: &Gpu, plan: &Plan, steps: impl Fn(&mut Land)) -> (Simulation, Land) {
    let mut land = Land::new(plan).expect("nothing that is left out");
    land.base();
    steps(&mut land);
    (finished(gpu, plan), land)
}

fn repeat(times: u32, step: impl Fn(&mut Land)) -> impl Fn(&mut Land) {
    move |land| (0..times).for_each(|_| step(land))
}

/// That values agree to `tolerance` times the largest.
#[track_caller]
fn assert_alike(name: &str, got: &[f32], want: &[f32], tolerance: f32) {
    check_alike(got, want, tolerance).unwrap_or_else(|message| panic!("{name}: {message}"));
}

fn check_alike(got: &[f32], want: &[f32], tolerance: f32) -> Result<(), String> {
    assert_eq!(got.len(), want.len());
    let largest = want.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    let errors = got.iter().zip(want).map(|(got, want)| (got - want).abs() / largest);
    let worst = errors.max_by(f32::total_cmp).unwrap_or(f32::NAN);
    // Not a number is not alike.
    if largest > 0.0 && worst <= tolerance {
        return Ok(());
    }
    Err(format!("they differ by {worst:e} of the largest, {largest}"))
}

#[test]
fn base_terrain_is_the_same() {
    let gpu = kit::gpu();
    let (simulation, land) = both(&gpu, &island(), |_| {});
    let height = layer(&gpu, &simulation, Layer::Height);
    assert_alike("height", &land.height(), &height, 1e-5);
    let mut wrong = height.clone();
    wrong[5000] += 0.05;
    check_alike(&land.height(), &wrong, 1e-5).unwrap_err();
}

#[test]
fn hydraulic_erosion_is_the_same() {
    let gpu = kit::gpu();
    // A cloudburst, so that there is much to compare after a minute. Little mixing: one sweep of it.
    let rains = hydraulic::Params { rain: 1e-3, ..valleys(60.0) };
    // Where water parts, differences in the last place grow until they are seen; and graphics cards divide with errors of 2.5
    // units there (Vulkan 1.3, appendix "Precision and Operation of SPIR-V Instructions"), processors with half a one. The
    // kernels themselves are held to their reference on any device, in tests/terrain/kernels.rs.
    if gpu.info().kind != DeviceKind::Cpu {
        return;
    }
    for (name, boundary, params) in [
        ("eight pipes", Boundary::Sea, rains),
        ("eight pipes without drag, closed", Boundary::Closed, hydraulic::Params { drag: 0.0, ..rains }),
        ("four pipes", Boundary::Sea, hydraulic::Params { pipes: Pipes::Four, evaporation: 0.002, ..rains }),
        ("paper", Boundary::Closed, hydraulic::Params { rain: 1e-3, capacity: 2.0, ..paper(60.0) }),
        ("paper with a sea", Boundary::Sea, hydraulic::Params { rain: 1e-3, capacity: 2.0, ..paper(60.0) }),
    ] {
        let plan = Plan { boundary, hydraulic: Some(params), ..island() };
        let count = params.steps(plan.grid).count;
        assert!(count > 15, "{count} steps");
        let (simulation, land) = both(&gpu, &plan, repeat(count, Land::hydraulic));
        let of = |what| layer(&gpu, &simulation, what);
        let change: Vec<f32> =
            of(Layer::Deposit).iter().zip(of(Layer::Wear)).map(|(up, down)| up - down).collect();
        for (what, got, want) in [
            ("change", land.change(), change),
            ("sediment", land.sediment(), of(Layer::Sediment)),
            ("flow", land.flow(), of(Layer::Flow)),
        ] {
            assert_alike(&format!("{name}: {what}"), &got, &want, 1e-3);
        }
    }
}

#[test]
fn thermal_erosion_is_the_same() {
    let gpu = kit::gpu();
    for law in [Law::Excess, Law::Drop] {
        let thermal = thermal::Params { law, duration: 300.0, ..slides() };
        let plan = Plan { thermal: Some(thermal), ..island() };
        let passes = thermal.passes(plan.grid, f64::from(thermal.duration));
        assert!(passes > 10, "{passes} passes");
        let (simulation, land) = both(&gpu, &plan, repeat(passes, Land::thermal));
        let of = |what| layer(&gpu, &simulation, what);
        let change: Vec<f32> =
            of(Layer::Deposit).iter().zip(of(Layer::Wear)).map(|(up, down)| up - down).collect();
        assert_alike(&format!("{law:?}"), &land.change(), &change, 1e-4);
    }
}

#[test]
fn the_reef_is_the_same() {
    let gpu = kit::gpu();
    for diffusivity in [3.0, 8.0, 20.0] {
        let stages = vec![reef::Stage { duration: 1000.0, rise: 0.0 }];
        let reef = reef::Params { stages, diffusivity, rubble: None, ..kit::land::barrier() };
        let plan = Plan { reef: Some(reef), ..island() };
        let steps = plan.reef.as_ref().map_or(0, reef::Params::steps);
        let (simulation, land) = both(&gpu, &plan, repeat(steps, Land::reef));
        let reef = layer(&gpu, &simulation, Layer::Reef);
        assert_alike("thickness", &land.thickness(), &reef, 1e-4);
        assert_alike("height", &land.height(), &layer(&gpu, &simulation, Layer::Height), 1e-5);
    }
}
