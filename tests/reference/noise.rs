//! Simplex noise and diamond–square.

use terrane::core::hash::mix;

/// Gradient noise of root mean square ½ (Perlin 2002, in Gustavson's layout), its gradients hashed from `seed`.
pub fn simplex(x: f64, z: f64, seed: u32) -> f64 {
    let skew = (3f64.sqrt() - 1.0) / 2.0;
    let unskew = (3.0 - 3f64.sqrt()) / 6.0;
    let (i, j) = ((x + (x + z) * skew).floor(), (z + (x + z) * skew).floor());
    let x0 = x - (i - (i + j) * unskew);
    let z0 = z - (j - (i + j) * unskew);
    let middle = if x0 > z0 { (1.0, 0.0) } else { (0.0, 1.0) };
    let corners = [(0.0, 0.0), middle, (1.0, 1.0)];
    let total: f64 = corners
        .iter()
        .map(|&(di, dj)| {
            let (x, z) = (x0 - di + (di + dj) * unskew, z0 - dj + (di + dj) * unskew);
            let [gx, gz] = gradient(hash(seed, (i + di) as i32, (j + dj) as i32));
            (0.5 - x * x - z * z).max(0.0).powi(4) * (gx * x + gz * z)
        })
        .sum();
    92.07 * total
}

/// `Σ η(p·2^o/λ)/2^o` (3), each octave shifted and seeded for itself.
pub fn fractal(x: f64, z: f64, seed: u32, wavelength: f64, octaves: u32) -> f64 {
    (0..octaves)
        .map(|octave| {
            let seed = mix(seed.wrapping_add(octave));
            let shift = |salt: u32| f64::from(mix(seed.wrapping_add(salt)) >> 8) / f64::from(1 << 20);
            let scale = f64::from(1u32 << octave) / wavelength;
            simplex(x * scale + shift(0x68bc_21eb), z * scale + shift(0x02e5_be93), seed)
                / f64::from(1u32 << octave)
        })
        .sum()
}

/// [`fractal`] at a point displaced by `warp` metres of its own three octaves.
pub fn warped(x: f64, z: f64, seed: u32, wavelength: f64, octaves: u32, warp: f64) -> f64 {
    let shift = |salt: u32| warp * fractal(x, z, mix(seed ^ salt), wavelength, 3);
    fractal(x + shift(0x9e37_79b9), z + shift(0x85eb_ca6b), seed, wavelength, octaves)
}

/// Diamond–square (Fournier, Fussell & Carpenter 1982) on (2^n + 1)², row by row.
///
/// `corners` are those at (row, column) (0, 0), (0, 2^n), (2^n, 0), (2^n, 2^n); `offset(row, column)` stands for the
/// random number in −1…1.
pub fn diamond_square(
    n: u32,
    corners: [f64; 4],
    mut spread: f64,
    reduction: f64,
    offset: impl Fn(usize, usize) -> f64,
) -> Vec<f64> {
    let last = 1usize << n;
    let width = last + 1;
    let mut h = vec![0.0; width * width];
    for (corner, (row, column)) in corners.into_iter().zip([(0, 0), (0, last), (last, 0), (last, last)]) {
        h[row * width + column] = corner;
    }
    let mut step = last;
    while step > 1 {
        let half = step / 2;
        for row in (half..width).step_by(step) {
            for column in (half..width).step_by(step) {
                let at = |r: usize, c: usize| h[r * width + c];
                let mean = ((at(row - half, column - half) + at(row + half, column + half))
                    + (at(row - half, column + half) + at(row + half, column - half)))
                    / 4.0;
                h[row * width + column] = mean + spread * offset(row, column);
            }
        }
        for row in (0..width).step_by(half) {
            for column in ((row + half) % step..width).step_by(step) {
                let sides = [
                    column.checked_sub(half).map(|c| (row, c)),
                    (column + half < width).then_some((row, column + half)),
                    row.checked_sub(half).map(|r| (r, column)),
                    (row + half < width).then_some((row + half, column)),
                ];
                let inside = sides.iter().flatten().count() as f64;
                let total: f64 = sides.iter().flatten().map(|&(r, c)| h[r * width + c]).sum();
                h[row * width + column] = total / inside + spread * offset(row, column);
            }
        }
        spread *= reduction;
        step = half;
    }
    h
}

/// The random number of a diamond–square point, in −1…1.
pub fn random(seed: u32, row: usize, column: usize) -> f64 {
    f64::from(hash(seed, column as i32, row as i32) >> 8) / f64::from(1 << 23) - 1.0
}

fn hash(seed: u32, i: i32, j: i32) -> u32 {
    mix((i as u32).wrapping_add(mix((j as u32).wrapping_add(seed))))
}

/// One of 16 unit vectors, none of them along an axis or a diagonal.
fn gradient(hash: u32) -> [f64; 2] {
    let angle = (f64::from(hash >> 28) + 0.5) * std::f64::consts::TAU / 16.0;
    [angle.cos(), angle.sin()]
}
