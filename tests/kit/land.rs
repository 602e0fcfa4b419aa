//! Small worlds to test with, and what the device makes of them.

use std::sync::Arc;
use terrane::{
    core::{grid::Grid, hash::derive_seed},
    gpu::{Gpu, Image, Recorder, Transfer, format::R32f},
    terrain::{
        Boundary, Controls, Layer, Map, Plan, Simulation,
        hydraulic::{self, Pipes, Section, Slope, Transport},
        layers::{self, Combine, Generator},
        reef::{self, Rubble, Stage},
        thermal::{self, Law},
    },
};

/// The default of erosion: the model that makes valleys.
pub fn valleys(duration: f32) -> hydraulic::Params {
    hydraulic::Params {
        duration,
        rain: 100.0 / 3.6e6,
        evaporation: 0.0,
        gravity: 9.81,
        pipes: Pipes::Eight,
        section: Section::Depth,
        pipe_depth: 4.0,
        drag: 0.15,
        capacity: 200.0,
        min_slope: 0.01,
        ramp_depth: 0.5,
        ramp_start: 0.01,
        slope: Slope::Outflow,
        erosion_rate: 0.005,
        deposition_rate: 0.015,
        rate_limit: 1.0,
        transport: Transport::Flux,
        sediment_diffusivity: 12.3,
        creep: 0.1,
        bank_diffusion: 3.0,
        sea_fade: 3.0,
        safety: 0.9,
        wet_depth: 0.02,
        wet_memory: 100.0,
    }
}

/// The model of Korošec & Lebar Bajec: a special case.
pub fn paper(duration: f32) -> hydraulic::Params {
    hydraulic::Params {
        pipes: Pipes::Four,
        section: Section::Fixed,
        drag: 0.0,
        ramp_depth: 0.0,
        ramp_start: 0.0,
        slope: Slope::Central,
        transport: Transport::SemiLagrangian,
        creep: 0.0,
        bank_diffusion: 0.0,
        evaporation: 0.001,
        ..valleys(duration)
    }
}

/// The same water on ground that nothing wears.
pub fn erode_nothing(params: hydraulic::Params) -> hydraulic::Params {
    hydraulic::Params { capacity: 0.0, creep: 0.0, bank_diffusion: 0.0, ..params }
}

pub fn slides() -> thermal::Params {
    thermal::Params {
        law: Law::Excess,
        repose: 38_f32.to_radians(),
        repose_under_water: 30_f32.to_radians(),
        diffusivity: 1.7,
        every: 4,
        duration: 0.0,
        settle: None,
    }
}

pub fn barrier() -> reef::Params {
    reef::Params {
        step: 25.0,
        stages: vec![Stage { duration: 500.0, rise: 1.5 }, Stage { duration: 250.0, rise: 0.0 }],
        growth: 0.014,
        light_decay: 0.06,
        max_depth: 37.0,
        uptake: 0.15,
        diffusivity: 8.0,
        ocean_carbon: 1.0,
        ocean_depth: 60.0,
        keep: 0.6,
        rubble: Some(Rubble { repose: 40_f32.to_radians(), every: 10, passes: 2 }),
    }
}

pub fn world(cells: u32, extent: f32, heights: Vec<f32>) -> Plan {
    Plan {
        grid: Grid { cells, extent },
        layers: vec![heightmap(cells, heights)],
        sea_level: 0.0,
        boundary: Boundary::Sea,
        controls: Controls::default(),
        hydraulic: None,
        thermal: None,
        seabed_smoothing: 0.0,
        reef: None,
    }
}

pub fn heightmap(cells: u32, values: Vec<f32>) -> layers::Layer {
    let map = Arc::new(Map { width: cells, height: cells, values });
    layers::Layer::Generate { generator: Generator::Heightmap { map }, combine: Combine::Add }
}

/// Uniform numbers in −1…1, the same in every run.
pub fn random(name: &str, len: usize) -> Vec<f32> {
    (0..len).map(|at| derive_seed(at as u32, name) as f32 / u32::MAX as f32 * 2.0 - 1.0).collect()
}

/// A cone with gullies whose foot lies under water: heights −40…`peak` m.
pub fn hill(cells: u32, peak: f32) -> Vec<f32> {
    let noise = random("hill", (cells * cells) as usize);
    let half = (cells - 1) as f32 / 2.0;
    (0..cells * cells)
        .map(|at| {
            let (x, z) = ((at % cells) as f32 / half - 1.0, (at / cells) as f32 / half - 1.0);
            let share = (x * x + z * z).sqrt();
            let gullies = (13.0 * x + 5.0 * z).sin() * (4.0 * x - 11.0 * z).cos() + 0.05 * noise[at as usize];
            (peak + 40.0) * (1.0 - share.powf(0.8)) - 40.0 + 0.05 * peak * gullies
        })
        .map(|height| height.max(-40.0))
        .collect()
}

pub fn texels<T: Transfer>(gpu: &Gpu, image: &T) -> Vec<T::Element> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let done = rec.submit().unwrap().wait().unwrap();
    download.take(&done)
}

pub fn finished(gpu: &Gpu, plan: &Plan) -> Simulation {
    let mut simulation = Simulation::new(gpu, plan).unwrap();
    simulation.finish().unwrap();
    simulation
}

pub fn layer(gpu: &Gpu, simulation: &Simulation, layer: Layer) -> Vec<f32> {
    let image: Image<R32f> = simulation.layer(layer).unwrap();
    texels(gpu, &image)
}
