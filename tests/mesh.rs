//! Meshes of the land: how near they are to it, that nothing gapes, and that other programs read what is written.

mod kit;

use kit::island::island;
use kit::land::random;
use proptest::prelude::*;
use std::collections::HashMap;
use terrane::core::grid::Grid;
use terrane::core::mesh::Mesh;
use terrane::core::triangulation::Triangulation;

// The triangulation.

#[test]
fn no_sample_is_farther_than_the_largest_error() {
    for (name, heights, size) in lands() {
        let [least, most] = terrane::formats::extremes(&heights);
        for share in [0.3, 0.03, 0.003, 0.0] {
            let error = (most - least) * share;
            let mesh = Triangulation::within(&heights, size, error);
            check_sound(&mesh).unwrap_or_else(|fault| panic!("{name}, {error} m: {fault}"));
            let found = largest_error(&heights, &mesh);
            assert!(found <= f64::from(error) + 1e-9, "{name}: {found} m where {error} m were asked for");
        }
    }
}

#[test]
fn checkers_see_a_slightly_wrong_mesh() {
    let (_, heights, size) = lands().remove(0);
    let mesh = Triangulation::within(&heights, size, 10.0);
    check_sound(&mesh).unwrap();

    let mut turned = mesh.clone();
    turned.triangles[7].swap(1, 2);
    let mut missing = mesh.clone();
    missing.triangles.pop();
    let mut doubled = mesh.clone();
    doubled.triangles.push(mesh.triangles[0]);
    // A vertex on an edge of one triangle only.
    let mut gaping = mesh.clone();
    let [a, b, c] = mesh.triangles[0];
    let between = [0, 1].map(|axis| {
        let [from, to] = [b, c].map(|corner| mesh.vertices[corner as usize][axis]);
        u16::midpoint(from, to)
    });
    gaping.vertices.push(between);
    let new = gaping.vertices.len() as u32 - 1;
    gaping.triangles[0] = [a, b, new];
    gaping.triangles.push([a, new, c]);
    for wrong in [turned, missing, doubled, gaping] {
        assert!(check_sound(&wrong).is_err());
    }

    let error = largest_error(&heights, &mesh);
    let mut bent = heights.clone();
    bent[40 * size[0] as usize + 40] += 100.0;
    assert!(error <= 10.0 && largest_error(&bent, &mesh) > 80.0);
}

#[test]
fn no_error_at_all_keeps_every_sample() {
    let (width, height) = (23, 17);
    let heights = random("full", width * height);
    let mesh = Triangulation::within(&heights, [width as u32, height as u32], 0.0);
    assert_eq!(mesh.vertices.len(), width * height);
    assert_eq!(mesh.triangles.len(), 2 * (width - 1) * (height - 1));
    // A ridge that runs across the cells is not cut into teeth.
    let ridge: Vec<f32> = (0..25).map(|at| -((at % 5 + at / 5) as f32 - 4.3).abs()).collect();
    let mesh = Triangulation::full(&ridge, [5, 5]);
    assert!(mesh.triangles.contains(&[4, 8, 9]) && mesh.triangles.contains(&[3, 8, 4]), "{mesh:?}");
}

#[test]
fn flat_and_tilted_ground_take_two_triangles() {
    for (east, south) in [(0.0, 0.0), (0.5, -0.25), (3.0, 2.0)] {
        let heights: Vec<f32> =
            (0..100 * 60).map(|at| east * (at % 100) as f32 + south * (at / 100) as f32).collect();
        let mesh = Triangulation::within(&heights, [100, 60], 1e-3);
        assert_eq!(mesh.vertices, [[0, 0], [99, 0], [0, 59], [99, 59]]);
        assert_eq!(mesh.triangles, [[0, 2, 3], [0, 3, 1]]);
    }
}

#[test]
fn a_smaller_error_never_takes_fewer_triangles() {
    for (name, heights, size) in lands() {
        let [least, most] = terrane::formats::extremes(&heights);
        let counts: Vec<usize> = [0.5, 0.1, 0.05, 0.01, 0.005, 0.001, 0.0]
            .iter()
            .map(|share| Triangulation::within(&heights, size, (most - least) * share).triangles.len())
            .collect();
        assert!(counts.is_sorted(), "{name}: {counts:?}");
    }
}

#[test]
fn a_bowl_takes_few_triangles_more_than_it_must() {
    // Of k·r²/2 a triangle with the circumradius R strays by k·R²/2 and covers at most 3√3/4·R².
    let (cells, bend, error) = (301, 0.01, 2.0);
    let heights: Vec<f32> = (0..cells * cells)
        .map(|at| {
            let [x, z] = [at % cells, at / cells].map(f64::from);
            (bend / 2.0 * (x * x + z * z)) as f32
        })
        .collect();
    let least = f64::from(cells - 1).powi(2) / (0.75 * 3_f64.sqrt() * 2.0 * error / bend);
    let mesh = Triangulation::within(&heights, [cells; 2], error as f32);
    let count = mesh.triangles.len() as f64;
    assert!(least <= count && count < 2.0 * least, "{count} triangles where {least} could do");
}

#[test]
fn tiles_have_the_same_vertices_on_their_common_edges() {
    let grid = Grid { cells: 129, extent: 3000.0 };
    let heights = island(grid).height;
    let tile = |column: u32, row: u32| {
        let origin = [column * 64, row * 32];
        let part = part(&heights, grid.cells, origin, [65, 33]);
        Mesh::of_land(&heights, grid, origin, Triangulation::within(&part, [65, 33], 2.0))
    };
    let along = |mesh: &Mesh, axis: usize, at: f32| {
        let mut corners: Vec<_> = (mesh.positions.iter().zip(&mesh.normals))
            .filter(|(position, _)| position[axis] == at)
            .map(|(position, normal)| (position.map(f32::to_bits), normal.map(f32::to_bits)))
            .collect();
        corners.sort_unstable();
        corners
    };
    let [middle, _] = grid.position(64, 64);
    for row in 0..4 {
        let [west, east] = [tile(0, row), tile(1, row)].map(|mesh| along(&mesh, 0, middle));
        assert!(west.len() > 4, "the edge is nearly straight");
        assert_eq!(west, east);
    }
    for column in 0..2 {
        for row in 1..4 {
            let [_, at] = grid.position(0, row * 32);
            let [north, south] = [tile(column, row - 1), tile(column, row)].map(|mesh| along(&mesh, 2, at));
            assert!(north.len() > 4, "the edge is nearly straight");
            assert_eq!(north, south);
        }
    }
}

#[test]
fn two_runs_make_the_same_mesh_however_they_are_cut() {
    let (_, heights, size) = lands().remove(0);
    let whole = Triangulation::within(&heights, size, 3.0);
    let mut refinement = terrane::core::triangulation::Refinement::new(&heights, size, 3.0);
    let mut vertices = Vec::new();
    while !refinement.finished() {
        refinement.insert(17);
        vertices.push(refinement.vertices());
        assert!(refinement.vertices() <= refinement.expected());
    }
    assert_eq!(refinement.expected(), whole.vertices.len() as u64);
    assert_eq!(refinement.into_triangulation(), whole);
    assert!(vertices.is_sorted_by(|before, after| before < after));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Steps and plateaus: many samples are equally far, on one circle or in one line.
    #[test]
    fn any_land_is_covered(
        (width, height) in (2..40_u32, 2..40_u32),
        steps in 1..6_u32,
        seed in any::<u32>(),
        error in 0.01..2.0_f32,
    ) {
        let heights: Vec<f32> = random(&seed.to_string(), (width * height) as usize)
            .iter()
            .map(|value| (value * steps as f32).round())
            .collect();
        let mesh = Triangulation::within(&heights, [width, height], error);
        prop_assert_eq!(check_sound(&mesh), Ok(()));
        prop_assert!(largest_error(&heights, &mesh) <= f64::from(error) + 1e-9);
    }
}

// The mesh.

#[test]
fn corners_lie_on_the_samples_and_pictures_over_all_of_it() {
    let grid = Grid { cells: 33, extent: 640.0 };
    let heights = island(grid).height;
    let mesh = Mesh::of_land(&heights, grid, [0, 0], Triangulation::within(&heights, [33; 2], 1.0));
    assert!(mesh.positions.len() > 20);
    for (position, uv) in mesh.positions.iter().zip(&mesh.uvs) {
        let [column, row] = uv.map(|share| f64::from(share) * 32.0);
        assert!(column.fract() == 0.0 && row.fract() == 0.0);
        assert_eq!([position[0], position[2]], [column, row].map(|at| (at * 20.0 - 320.0) as f32));
        assert_eq!(position[1], heights[(row * 33.0 + column) as usize]);
    }
    // North-west is upper left.
    assert_eq!((mesh.positions[0][0], mesh.positions[0][2]), (-320.0, -320.0));
    assert_eq!(mesh.uvs[0], [0.0, 0.0]);
    let [least, most] = mesh.bounds();
    let [lowest, highest] = terrane::formats::extremes(&heights);
    assert_eq!([least[0], most[0], least[2], most[2]], [-320.0, 320.0, -320.0, 320.0]);
    assert!(lowest <= least[1] && most[1] <= highest);
    // Faces and normals look up.
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize].map(f64::from));
        let [u, v] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
        assert!(u[2] * v[0] - u[0] * v[2] > 0.0);
    }
}

#[test]
fn normals_are_those_of_the_land() {
    // Of a paraboloid central differences are exact.
    let grid = Grid { cells: 65, extent: 1280.0 };
    let land = |x: f64, z: f64| 0.0005 * x * x - 0.0003 * z * z + 0.0002 * x * z + 0.1 * x - 0.2 * z;
    let heights: Vec<f32> = (0..65 * 65)
        .map(|at| {
            let [x, z] = grid.position(at % 65, at / 65).map(f64::from);
            land(x, z) as f32
        })
        .collect();
    let mesh = Mesh::of_land(&heights, grid, [0, 0], Triangulation::full(&heights, [65; 2]));
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        let [x, z] = [f64::from(position[0]), f64::from(position[2])];
        // Half a cell inwards at the rim, where the difference is one-sided.
        let inner = |at: f64| at.clamp(-630.0, 630.0);
        let east = 0.001 * inner(x) + 0.0002 * z + 0.1;
        let south = -0.0006 * inner(z) + 0.0002 * x - 0.2;
        let length = (east * east + 1.0 + south * south).sqrt();
        for (got, want) in normal.iter().zip([-east, 1.0, -south]) {
            assert!((f64::from(*got) - want / length).abs() < 2e-5, "{normal:?} at {x}, {z}");
        }
    }
}

// Checkers.

/// Name, heights and size of lands of many kinds.
fn lands() -> Vec<(&'static str, Vec<f32>, [u32; 2])> {
    let island = |cells| island(Grid { cells, extent: 5000.0 }).height;
    let bowl = |width: u32, height: u32| {
        let at = |at: u32| {
            let [x, z] = [at % width, at / width].map(f64::from);
            ((x - 20.0).powi(2) + (z - 31.0).powi(2)) as f32
        };
        (0..width * height).map(at).collect()
    };
    let cliff = (0..90 * 90).map(|at| if at % 90 + at / 90 < 80 { 500.0 } else { 0.0 }).collect();
    vec![
        ("island", island(128), [128; 2]),
        ("island of an odd size", island(101), [101; 2]),
        ("bowl", bowl(65, 65), [65; 2]),
        ("long bowl", bowl(150, 40), [150, 40]),
        ("cliff", cliff, [90; 2]),
        ("noise", random("noise", 70 * 50), [70, 50]),
        ("one cell", vec![0.0, 1.0, 3.0, 0.0], [2; 2]),
        ("strip", random("strip", 2 * 50), [2, 50]),
    ]
}

/// A rectangle of a square raster.
fn part(values: &[f32], cells: u32, origin: [u32; 2], size: [u32; 2]) -> Vec<f32> {
    let row = |row: u32| {
        let start = ((origin[1] + row) * cells + origin[0]) as usize;
        &values[start..start + size[0] as usize]
    };
    (0..size[1]).flat_map(row).copied().collect()
}

/// Whether triangles cover the grid once: all counter-clockwise, as large together as the grid, edge to edge, and as many
/// as Euler's formula wants.
fn check_sound(mesh: &Triangulation) -> Result<(), String> {
    let [east, south] = mesh.size.map(|side| i64::from(side) - 1);
    let place = |vertex: u32| mesh.vertices[vertex as usize].map(i64::from);
    let mut area = 0;
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    for triangle in &mesh.triangles {
        let [[ax, ay], [bx, by], [cx, cy]] = triangle.map(place);
        // With rows running south, what is counter-clockwise to the eye is clockwise in numbers.
        let twice = (cx - ax) * (by - ay) - (bx - ax) * (cy - ay);
        if twice <= 0 {
            return Err(format!("{triangle:?} is turned over or has no area"));
        }
        area += twice;
        let [a, b, c] = *triangle;
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    if area != 2 * east * south {
        return Err(format!("twice the area is {area} where {} is wanted", 2 * east * south));
    }
    let mut rim = 0;
    for (&(from, to), &count) in &edges {
        if count != 1 {
            return Err(format!("the edge {from}–{to} is there {count} times"));
        }
        if edges.contains_key(&(to, from)) {
            continue;
        }
        rim += 1;
        let ([x0, y0], [x1, y1]) = (place(from), place(to));
        let on_rim = (x0 == x1 && (x0 == 0 || x0 == east)) || (y0 == y1 && (y0 == 0 || y0 == south));
        if !on_rim {
            return Err(format!("the edge {from}–{to} has a triangle on one side only"));
        }
    }
    let (vertices, faces) = (mesh.vertices.len(), mesh.triangles.len());
    let edges = (edges.len() + rim) / 2;
    if vertices + faces != edges + 1 {
        return Err(format!("{vertices} vertices, {edges} edges and {faces} triangles are no disc"));
    }
    let mut places = mesh.vertices.clone();
    places.dedup();
    if places.len() != vertices || !mesh.vertices.is_sorted_by_key(|[column, row]| (*row, *column)) {
        return Err("vertices don't come row by row, once each".into());
    }
    Ok(())
}

/// The farthest that a sample lies above or below the triangles, by looking at every sample in every triangle's bounds
/// with barycentric coordinates.
fn largest_error(heights: &[f32], mesh: &Triangulation) -> f64 {
    let width = mesh.size[0] as usize;
    let mut seen = vec![false; heights.len()];
    let mut largest: f64 = 0.0;
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| mesh.vertices[vertex as usize].map(i64::from));
        let [a, b, c] = corners;
        let rises = corners.map(|[x, y]| f64::from(heights[y as usize * width + x as usize]));
        let cross = |p: [i64; 2], q: [i64; 2], r: [i64; 2]| {
            (r[0] - p[0]) * (q[1] - p[1]) - (q[0] - p[0]) * (r[1] - p[1])
        };
        let bounds = |axis: usize| {
            let of = corners.map(|corner| corner[axis]);
            of.iter().copied().min().unwrap()..=of.iter().copied().max().unwrap()
        };
        for y in bounds(1) {
            for x in bounds(0) {
                let at = [x, y];
                let weights = [cross(b, c, at), cross(c, a, at), cross(a, b, at)];
                if weights.iter().any(|weight| *weight < 0) {
                    continue;
                }
                let sum: i64 = weights.iter().sum();
                let height: f64 =
                    weights.iter().zip(rises).map(|(weight, rise)| *weight as f64 / sum as f64 * rise).sum();
                let sample = y as usize * width + x as usize;
                seen[sample] = true;
                largest = largest.max((height - f64::from(heights[sample])).abs());
            }
        }
    }
    if seen.iter().all(|seen| *seen) { largest } else { f64::INFINITY }
}
