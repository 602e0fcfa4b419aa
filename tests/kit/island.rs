//! A made-up island with ridges, valleys, beaches, a lagoon and a reef ring with passes: something to draw.

use terrane::core::grid::Grid;
use terrane::core::hash::mix;

/// One value a sample of `grid`, row by row.
pub struct Island {
    pub height: Vec<f32>,
    pub wetness: Vec<f32>,
    pub reef: Vec<f32>,
}

/// The sea is at 0; the top is about `0.13 · extent` high.
pub fn island(grid: Grid) -> Island {
    let mut island = Island { height: Vec::new(), wetness: Vec::new(), reef: Vec::new() };
    for row in 0..grid.cells {
        for column in 0..grid.cells {
            let [x, z] = grid.position(column, row).map(|at| at / grid.extent);
            let (height, wetness, reef) = place(x, z);
            island.height.push(height * grid.extent);
            island.wetness.push(wetness);
            island.reef.push(reef * grid.extent);
        }
    }
    island
}

/// Height and coral over the extent, and wetness, at a place within ±½.
fn place(x: f32, z: f32) -> (f32, f32, f32) {
    let x = x + 0.03 * fbm(5.0 * x, 5.0 * z, 1, 4);
    let z = z + 0.03 * fbm(5.0 * x, 5.0 * z, 2, 4);
    let radius = x.hypot(z);
    let around = |frequency: f32| (frequency * x / radius.max(1e-6), frequency * z / radius.max(1e-6));
    let (u, v) = around(0.9);
    let shore = 0.24 + 0.05 * fbm(u, v, 3, 3);
    let inland = (1.0 - radius / shore).clamp(-1.0, 1.0);
    // Valleys run outwards, branch and deepen half-way down.
    let (u, v) = around(3.2);
    let valley = 1.0 - fbm(u + 2.0 * radius, v, 4, 4).abs() * 2.2;
    let valley = valley.clamp(0.0, 1.0).powi(2);
    let (u, v) = around(9.0);
    let gully = (1.0 - fbm(u + 4.0 * radius, v + 3.0 * radius, 5, 3).abs() * 2.0).clamp(0.0, 1.0).powi(2);
    let flank = inland.max(0.0);
    let peak = 0.14 * flank.powf(1.35);
    let cut = 0.035 * valley * (flank * (1.0 - flank) * 4.0) + 0.008 * gully * (flank * 6.0).min(1.0);
    let rough = 0.006 * fbm(16.0 * x, 16.0 * z, 6, 3) * (flank * 8.0).min(1.0);
    let land = peak - cut.min(0.85 * peak) + rough;
    // The sea bed: a lagoon, a reef ring, then the deep.
    let (u, v) = around(1.3);
    let ring = shore + 0.075 + 0.03 * fbm(u, v, 7, 4);
    let out = radius - shore;
    let bed = -0.0016 * (1.0 - (-out / 0.03).exp())
        + 0.0006 * fbm(12.0 * x, 12.0 * z, 8, 5) * (out * 20.0).min(1.0);
    let (u, v) = around(2.2);
    let pass = smoothstep(0.25, 0.4, fbm(u, v, 9, 2));
    let crest = (-((radius - ring) / 0.008).powi(2)).exp() * (1.0 - pass);
    let deep = -0.12 * smoothstep(0.0, 0.12, radius - ring - 0.004).powf(0.7);
    let sea_bed = (bed * (1.0 - crest) - 0.0001 * crest).min(-0.0001) + deep;
    let height = if inland > 0.0 { land + 0.0002 } else { sea_bed };
    let wetness =
        if inland > 0.0 { smoothstep(0.75, 0.98, valley) * smoothstep(0.02, 0.2, flank) } else { 1.0 };
    (height, wetness, 0.004 * crest)
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn fbm(x: f32, z: f32, seed: u32, octaves: u32) -> f32 {
    (0..octaves).map(|octave| noise(x, z, octave, seed) / (1 << octave) as f32).sum()
}

/// Value noise in −1…1.
fn noise(x: f32, z: f32, octave: u32, seed: u32) -> f32 {
    let (x, z) = (x * (1 << octave) as f32 + 17.3 * octave as f32, z * (1 << octave) as f32);
    let (column, row) = (x.floor(), z.floor());
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(x - column), fade(z - row));
    let at = |i: i32, j: i32| {
        let hash = mix(mix(mix(seed) ^ (column as i32 + i) as u32) ^ (row as i32 + j) as u32);
        (hash >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let north = at(0, 0) + u * (at(1, 0) - at(0, 0));
    let south = at(0, 1) + u * (at(1, 1) - at(0, 1));
    north + v * (south - north)
}
