//! The surface of a zoom in integers without bounds, vertex by vertex from its definition: it shares no code with the engine, and
//! knows no patches, tiles or remainders.

use num_bigint::BigInt;
use std::collections::{BTreeMap, BTreeSet};

/// x and z of a vertex.
pub type Vertex = (BigInt, BigInt);

pub struct Naive {
    pub seed: u32,
    pub bilinear: bool,
}

fn mix(mut h: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^= h >> 16;
    h
}

/// The remainder modulo 2⁶⁴.
pub fn low(number: &BigInt) -> u64 {
    let remainder: BigInt = number & BigInt::from(u64::MAX);
    u64::try_from(remainder).expect("64 bits")
}

/// The vertices east, west, south and north of one.
fn around((x, z): &Vertex) -> [Vertex; 4] {
    [(x + 1, z.clone()), (x - 1, z.clone()), (x.clone(), z + 1), (x.clone(), z - 1)]
}

fn central(vertex: &Vertex, at: impl Fn(&Vertex) -> BigInt) -> [BigInt; 2] {
    let [east, west, south, north] = around(vertex).map(|vertex| at(&vertex));
    [east - west, south - north]
}

fn is_odd(number: &BigInt) -> bool {
    number.bit(0)
}

impl Naive {
    pub fn noise(&self, level: u32, x: &BigInt, z: &BigInt) -> i64 {
        // The outer mix is for the upper word of a level, which is 0.
        let key = mix(mix(self.seed ^ level.wrapping_mul(0x9E37_79B9)));
        let [(x_low, x_high), (z_low, z_high)] =
            [low(x), low(z)].map(|of| ((of & 0xFFFF_FFFF) as u32, (of >> 32) as u32));
        let mut h = mix(key ^ x_low);
        h = mix(h ^ x_high.wrapping_add(0x68bc_21eb));
        h = mix(h ^ z_low);
        h = mix(h ^ z_high.wrapping_add(0x02e5_be93));
        2 * i64::from(h >> 24) - 255
    }

    /// Heights of vertices of a level.
    pub fn heights(&self, level: u32, vertices: &[Vertex]) -> Vec<BigInt> {
        // Which vertices are needed, from the last level to the first.
        let mut needed: Vec<BTreeSet<Vertex>> = vec![vertices.iter().cloned().collect()];
        for _ in 0..level {
            let finer = needed.last().expect("never empty");
            let coarser = finer.iter().flat_map(|vertex| self.parents(vertex)).collect();
            needed.push(coarser);
        }
        // And their heights, from the first level to the last.
        let mut heights: BTreeMap<Vertex, BigInt> = BTreeMap::new();
        for (level, vertices) in needed.iter().rev().enumerate() {
            let height = |(x, z): &Vertex| {
                let noise = self.noise(level as u32, x, z);
                if level == 0 { BigInt::from(noise) } else { self.twice(&heights, x, z) + noise }
            };
            heights = vertices.iter().map(|vertex| (vertex.clone(), height(vertex))).collect();
        }
        vertices.iter().map(|vertex| heights[vertex].clone()).collect()
    }

    /// What vertices of a level are shaded by: rises along x and z over two cells.
    pub fn gradients(&self, level: u32, vertices: &[Vertex]) -> Vec<[BigInt; 2]> {
        // Which gradients are needed, and which heights, from the last level to the first.
        let mut needed = vec![(vertices.iter().cloned().collect::<BTreeSet<Vertex>>(), BTreeSet::new())];
        for _ in 0..level {
            let (shaded, high) = needed.last().expect("never empty");
            let coarser: BTreeSet<Vertex> = shaded.iter().flat_map(|vertex| self.ends(vertex)).collect();
            let around = coarser.iter().flat_map(around);
            let high = high.iter().flat_map(|vertex| self.parents(vertex)).chain(around).collect();
            needed.push((coarser, high));
        }
        let mut heights: BTreeMap<Vertex, BigInt> = BTreeMap::new();
        let mut gradients: BTreeMap<Vertex, [BigInt; 2]> = BTreeMap::new();
        for (level, (shaded, high)) in needed.iter().rev().enumerate() {
            let noise = |(x, z): &Vertex| BigInt::from(self.noise(level as u32, x, z));
            let gradient = |vertex: &Vertex| {
                let own = central(vertex, noise);
                if level == 0 {
                    return own;
                }
                let ends: Vec<[BigInt; 2]> = self
                    .ends(vertex)
                    .iter()
                    .map(|end| {
                        let slope = central(end, |vertex| heights[vertex].clone());
                        let coarse = &gradients[end];
                        // A 16th of what is missing, rounded to the next whole number.
                        [0, 1].map(|axis| &coarse[axis] + ((&slope[axis] - &coarse[axis] + 8) >> 4))
                    })
                    .collect();
                // Shifts of integers without bounds round down.
                [0, 1].map(|axis| ((&ends[0][axis] + &ends[ends.len() - 1][axis]) >> 1) + &own[axis])
            };
            gradients = shaded.iter().map(|vertex| (vertex.clone(), gradient(vertex))).collect();
            let height = |vertex: &Vertex| match level {
                0 => noise(vertex),
                _ => self.twice(&heights, &vertex.0, &vertex.1) + noise(vertex),
            };
            heights = high.iter().map(|vertex| (vertex.clone(), height(vertex))).collect();
        }
        vertices.iter().map(|vertex| gradients[vertex].clone()).collect()
    }

    /// The coarse vertex that a vertex is, or the two that it is in the middle of.
    fn ends(&self, vertex: &Vertex) -> Vec<Vertex> {
        Naive { bilinear: false, ..*self }.parents(vertex)
    }

    /// The coarser vertices that a vertex hangs on.
    fn parents(&self, (x, z): &Vertex) -> Vec<Vertex> {
        let (i, j): Vertex = (x >> 1, z >> 1);
        let (right, down): Vertex = (&i + 1, &j + 1);
        match (is_odd(x), is_odd(z)) {
            (false, false) => vec![(i, j)],
            (true, false) => vec![(i, j.clone()), (right, j)],
            (false, true) => vec![(i.clone(), j), (i, down)],
            (true, true) if self.bilinear => {
                vec![(i.clone(), j.clone()), (right.clone(), j), (i, down.clone()), (right, down)]
            }
            (true, true) if is_odd(&i) == is_odd(&j) => vec![(i, j), (right, down)],
            (true, true) => vec![(right, j), (i, down)],
        }
    }

    fn twice(&self, coarse: &BTreeMap<Vertex, BigInt>, x: &BigInt, z: &BigInt) -> BigInt {
        let parents = self.parents(&(x.clone(), z.clone()));
        let heights: Vec<&BigInt> = parents.iter().map(|parent| &coarse[parent]).collect();
        match heights[..] {
            [a] => a * 2,
            [a, b] => a + b,
            // Shifts of integers without bounds round down.
            [a, b, c, d] => a * 2 + (((b - a) + (c - a) + (d - a)) >> 1),
            _ => unreachable!("one, two or four parents"),
        }
    }
}
