//! The four shipped islands at their full size, as means over five seeds, against figures that were measured with an
//! independent program (a native implementation of the same model with other noise, one seed an island).
//!
//! `make test-long` runs them and prints the table in docs/islands.md: some twenty minutes on two cores with lavapipe.

use crate::kit;
use crate::kit::land::{layer, texels};
use crate::reference::{
    island::Land,
    lattice::Lattice,
    statistics::{Statistics, measure},
};
use std::{path::Path, time::Duration};
use terrane::{
    gpu::Gpu,
    terrain::{Layer, Simulation, Stage},
    world::{self, Overrides},
};

/// One line of the table: what it is, how to take it, and what it should be.
type Row = (&'static str, fn(&Statistics) -> f64, f64);

const LAND: (&str, fn(&Statistics) -> f64) = ("land, km²", |it| it.land_area);
const PEAK: (&str, fn(&Statistics) -> f64) = ("peak above sea, m", |it| it.peak);
const HYPSOMETRY: (&str, fn(&Statistics) -> f64) = ("hypsometric integral", |it| it.hypsometric_integral);
const MEDIAN: (&str, fn(&Statistics) -> f64) = ("slope, median, °", |it| it.slope_median);
const P99: (&str, fn(&Statistics) -> f64) = ("slope, 99th percentile, °", |it| it.slope_p99);
const LOWERED: (&str, fn(&Statistics) -> f64) = ("lowered by erosion, 10⁶ m³", |it| it.lowered);
const RAISED: (&str, fn(&Statistics) -> f64) = ("raised by erosion, 10⁶ m³", |it| it.raised);
const REEF: (&str, fn(&Statistics) -> f64) = ("raised by the reef, 10⁶ m³", |it| it.reef_volume);
const THICKNESS: (&str, fn(&Statistics) -> f64) = ("reef thickness, m", |it| it.reef_thickness);

/// Shares of the measured value that a mean of five seeds may be away from it: islands of other seeds, and of other
/// noise, differ by about that much.
const TOLERANCE: f64 = 1.0 / 3.0;

#[test]
#[ignore = "minutes: make test-long"]
fn dendritic_has_the_measured_figures() {
    check(
        "dendritic",
        [15.9, 906.0, 0.31, 33.0, 47.0],
        &[row(LOWERED, 104.0), row(RAISED, 93.0), row(THICKNESS, 12.0)],
    );
}

#[test]
#[ignore = "minutes: make test-long"]
fn old_barrier_has_the_measured_figures() {
    check(
        "old_barrier",
        [9.6, 519.0, 0.37, 27.0, 37.0],
        &[row(LOWERED, 156.0), row(RAISED, 143.0), row(THICKNESS, 121.0)],
    );
}

#[test]
#[ignore = "minutes: make test-long"]
fn atoll_has_the_measured_figures() {
    check("atoll", [0.82, 7.5, 0.18, 2.0, 28.0], &[row(REEF, 75.0), row(THICKNESS, 35.0)]);
}

#[test]
#[ignore = "minutes: make test-long"]
fn young_cone_has_the_measured_figures() {
    check(
        "young_cone",
        [14.3, 978.0, 0.31, 29.0, 46.0],
        &[row(LOWERED, 35.0), row(RAISED, 18.0), row(THICKNESS, 21.0)],
    );
}

#[test]
fn figures_a_third_away_are_refused() {
    let mean = Statistics { land_area: 10.0, ..Statistics::default() };
    assert_eq!(refused(&mean, &[row(LAND, 12.0), row(LAND, 8.0)]), Vec::<String>::new());
    assert_eq!(refused(&mean, &[row(LAND, 15.1), row(LAND, 7.4)]).len(), 2);
    assert_eq!(refused(&Statistics { land_area: f64::NAN, ..mean }, &[row(LAND, 10.0)]).len(), 1);
}

fn row((name, take): (&'static str, fn(&Statistics) -> f64), want: f64) -> Row {
    (name, take, want)
}

/// Grows `configs/island/<name>.toml` with five seeds and compares the means of their figures: `shape` is land, peak,
/// hypsometric integral, median and 99th-percentile slope.
fn check(name: &str, shape: [f64; 5], more: &[Row]) {
    let gpu = kit::gpu();
    let mut rows: Vec<Row> = [LAND, PEAK, HYPSOMETRY, MEDIAN, P99]
        .into_iter()
        .zip(shape)
        .map(|(what, want)| row(what, want))
        .collect();
    rows.extend(more);
    let lands: Vec<Statistics> = (1..=5).map(|seed| measure(&grow(&gpu, name, seed))).collect();
    let mean = mean(&lands);
    println!("{name}: mean of five seeds, and what was measured");
    for (what, take, want) in &rows {
        let single: Vec<String> = lands.iter().map(|it| format!("{:.2}", take(it))).collect();
        println!("  {what}: {:.2} ({want}; {})", take(&mean), single.join(" "));
    }
    println!(
        "  also: slope–area exponent {:.2}, steepest slope {:.0}°, deepest cut {:.0} m, pits {:.3} % of the land, reef flat {:.2} km², lagoon {:.2} km² with a median depth of {:.1} m",
        mean.slope_area_exponent,
        mean.slope_max,
        mean.deepest_cut,
        mean.pits,
        mean.reef_flat,
        mean.lagoon_area,
        mean.lagoon_depth,
    );
    let refused = refused(&mean, &rows);
    assert!(refused.is_empty(), "{name}: {}", refused.join("; "));
}

fn grow(gpu: &Gpu, name: &str, seed: u32) -> Land {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/island/{name}.toml"));
    let overrides = Overrides { seed: Some(seed), ..Overrides::default() };
    let plan = world::load(&path, &overrides).unwrap().plan;
    let mut simulation = Simulation::new(gpu, &plan).unwrap();
    // Erosion's share of the change, before the sea bed is smoothed.
    while !matches!(simulation.progress().stage, Stage::Seabed | Stage::Reef) {
        simulation.step(Duration::MAX).unwrap();
    }
    let wide = |values: Vec<f32>| values.into_iter().map(f64::from).collect::<Vec<f64>>();
    let e = wide(texels(gpu, &simulation.fields().change));
    let h0 = wide(texels(gpu, &simulation.fields().start));
    simulation.finish().unwrap();
    Land {
        lattice: Lattice::new(plan.grid),
        h0,
        e,
        b: wide(texels(gpu, &simulation.fields().reef)),
        height: wide(layer(gpu, &simulation, Layer::Height)),
        sea_level_at_erosion: f64::from(plan.sea_level),
        sea_level: f64::from(simulation.sea_level()),
        cells: Vec::new(),
    }
}

/// The rows whose figure is not within the tolerance.
fn refused(mean: &Statistics, rows: &[Row]) -> Vec<String> {
    rows.iter()
        .filter(|(_, take, want)| {
            let away = (take(mean) / want - 1.0).abs();
            away.is_nan() || away > TOLERANCE
        })
        .map(|(what, take, want)| format!("{what}: {} where {want} was measured", take(mean)))
        .collect()
}

fn mean(all: &[Statistics]) -> Statistics {
    let of = |take: fn(&Statistics) -> f64| all.iter().map(take).sum::<f64>() / all.len() as f64;
    Statistics {
        land_area: of(|it| it.land_area),
        peak: of(|it| it.peak),
        hypsometric_integral: of(|it| it.hypsometric_integral),
        slope_median: of(|it| it.slope_median),
        slope_p99: of(|it| it.slope_p99),
        slope_max: of(|it| it.slope_max),
        lowered: of(|it| it.lowered),
        raised: of(|it| it.raised),
        deepest_cut: of(|it| it.deepest_cut),
        slope_area_exponent: of(|it| it.slope_area_exponent),
        pits: of(|it| it.pits),
        reef_volume: of(|it| it.reef_volume),
        reef_thickness: of(|it| it.reef_thickness),
        reef_flat: of(|it| it.reef_flat),
        lagoon_area: of(|it| it.lagoon_area),
        lagoon_depth: of(|it| it.lagoon_depth),
    }
}
