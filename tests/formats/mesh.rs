//! Meshes of the land: how near they are to it, that nothing gapes, and that other programs read what is written.

use crate::kit;
use crate::kit::island::island;
use crate::kit::land::random;
use ply_rs_bw::ply::Property;
use proptest::prelude::*;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;
use terrane::core::grid::Grid;
use terrane::core::mesh::Mesh;
use terrane::core::triangulation::{Refinement, Triangulation};
use terrane::formats::{gltf, obj, ply};

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
    let mut refinement = Refinement::new(&heights, size, 3.0);
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
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

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

// Files.

#[test]
fn other_readers_find_the_mesh_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let grid = Grid { cells: 257, extent: 3000.0 };
    let heights = island(grid).height;
    // Indices of 16 and of 32 bits, an even and an odd number of them.
    for (error, bits) in [(0.0, 32), (1.0, 16), (1.1, 16), (40.0, 16)] {
        let mesh = Mesh::of_land(&heights, grid, [0, 0], Triangulation::within(&heights, [257; 2], error));
        gltf::write(&at("land.glb"), "land", &mesh, [0.25, 0.5, 0.75]).unwrap();
        ply::write(&at("land.ply"), &mesh).unwrap();
        obj::write(&at("land.obj"), "land", &mesh).unwrap();
        assert_same(&read_glb(&at("land.glb"), bits), &mesh);
        assert_same(&read_ply(&at("land.ply")), &mesh);
        assert_same(&read_obj(&at("land.obj")), &mesh);
    }
}

#[test]
fn a_glb_says_what_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("land.glb");
    let grid = Grid { cells: 33, extent: 640.0 };
    let heights = island(grid).height;
    let mesh = Mesh::of_land(&heights, grid, [0, 0], Triangulation::full(&heights, [33; 2]));
    let written = gltf::write(&path, "land", &mesh, [0.25, 0.5, 0.75]).unwrap();
    let bytes = fs::read(&path).unwrap();
    assert_eq!(written.bytes, bytes.len() as u64);
    assert_eq!((&bytes[..4], &bytes[8..12]), (&b"glTF"[..], &(bytes.len() as u32).to_le_bytes()[..]));

    let gltf = ::gltf::Gltf::from_slice(&bytes).unwrap();
    let scene = gltf.default_scene().unwrap();
    let nodes: Vec<_> = scene.nodes().collect();
    assert_eq!((nodes.len(), nodes[0].name()), (1, Some("land")));
    let primitive = nodes[0].mesh().unwrap().primitives().next().unwrap();
    let material = primitive.material();
    assert_eq!(material.pbr_metallic_roughness().base_color_factor(), [0.25, 0.5, 0.75, 1.0]);
    assert!(!material.double_sided());
    let bounds = primitive.bounding_box();
    assert_eq!([bounds.min, bounds.max], mesh.bounds());

    let again = folder.path().join("again.glb");
    assert_eq!(gltf::write(&again, "land", &mesh, [0.25, 0.5, 0.75]).unwrap().sha256, written.sha256);
}

#[test]
fn what_a_glb_cannot_hold_is_known_beforehand() {
    // 8193 × 8193 samples fit, twice as many don't.
    assert!(gltf::fits(8193 * 8193, 2 * 8192 * 8192));
    assert!(!gltf::fits(2 * 8193 * 8193, 4 * 8192 * 8192));
}

#[test]
fn an_exported_mesh_is_the_height_that_was_simulated() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    export(&folder, &["-o", "height.exr"]);
    let heights = read_exr(&at("height.exr"));
    let [least, most] = terrane::formats::extremes(&heights);
    for error in ["0", "2"] {
        for (name, read) in [
            ("land.glb", read_small_glb as fn(&Path) -> Mesh),
            ("land.ply", read_ply),
            ("land.obj", read_obj),
        ] {
            export(&folder, &["--layer", "mesh", "-o", name, "--mesh-error", error]);
            let mesh = read(&at(name));
            let triangulation = on_grid(std::slice::from_ref(&mesh), &heights);
            check_sound(&triangulation).unwrap();
            let error: f64 = error.parse().unwrap();
            assert!(largest_error(&heights, &triangulation) <= error + 1e-9);

            let said = sidecar(&at(name));
            assert_eq!(said["vertices"], mesh.positions.len());
            assert_eq!(said["triangles"], mesh.triangles.len());
            assert_eq!(said["largest_error"], error);
            assert_eq!(said["unit"], "m");
            assert_eq!([&said["min"], &said["max"]].map(|end| end.as_f64().unwrap() as f32), [least, most]);
            assert_eq!(said["extent"], 2000.0);
            assert_eq!(said["samples"], serde_json::json!([65, 65]));
            let height = sidecar(&at("height.exr"));
            for key in ["cell_size", "sea_level", "seed", "world", "world_sha256", "set"] {
                assert_eq!(said[key], height[key], "{key}");
            }
        }
    }
    let all = fs::read(at("land.obj")).unwrap();
    fs::remove_file(at("land.obj")).unwrap();
    export(&folder, &["-o", "land.obj", "--mesh-error", "2"]);
    assert!(all == fs::read(at("land.obj")).unwrap(), "two runs differ");
}

#[test]
fn tiles_of_a_mesh_joined_are_one_mesh() {
    let folder = folder();
    export(&folder, &["--cells", "97", "-o", "height.exr"]);
    let heights = read_exr(&folder.path().join("height.exr"));
    export(
        &folder,
        &["--layer", "mesh", "--cells", "97", "--tiles", "3x2", "--mesh-error", "3", "-o", "tiles/"],
    );
    let names =
        (0..2).flat_map(|row| (0..3).map(move |column| format!("tiles/terrain_x{column}_y{row}.glb")));
    let tiles: Vec<Mesh> = names.map(|name| read_small_glb(&folder.path().join(name))).collect();
    // Each has pictures of its own.
    assert!(tiles.iter().all(|tile| tile.uvs.contains(&[0.0, 0.0]) && tile.uvs.contains(&[1.0, 1.0])));
    let joined = on_grid(&tiles, &heights);
    check_sound(&joined).unwrap();
    assert!(largest_error(&heights, &joined) <= 3.0 + 1e-9);
    assert!(joined.triangles.len() < 96 * 96);
    let said = sidecar(&folder.path().join("tiles/terrain_x2_y1.glb"));
    assert_eq!(said["tile"], serde_json::json!({ "column": 2, "row": 1, "of": [3, 2] }));
}

#[test]
fn a_folder_gets_layers_and_mesh_and_the_default_error_is_a_tenth_of_a_cell() {
    let folder = folder();
    export(&folder, &["--layer", "height,mesh", "--format", "r16", "-o", "all/"]);
    let mut names: Vec<_> =
        fs::read_dir(folder.path().join("all")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["height.r16", "height.r16.json", "terrain.glb", "terrain.glb.json"]);
    let said = sidecar(&folder.path().join("all/terrain.glb"));
    assert_eq!(said["largest_error"].as_f64().unwrap() as f32, 2000.0_f32 / 64.0 / 10.0);
}

#[test]
fn meshes_that_make_no_sense_are_refused() {
    let folder = folder();
    for (arguments, part) in [
        (&["--layer", "mesh", "-o", "land.exr"][..], ".glb, .ply, .obj"),
        (&["--layer", "height", "-o", "land.glb"], "--layer mesh"),
        (&["--layer", "height,mesh", "-o", "land.glb"], "--layer mesh"),
        (&["--layer", "mesh", "--format", "r16", "-o", "land/"], "--format"),
        (&["--mesh-error", "1", "-o", "height.exr"], "--mesh-error"),
        (&["--mesh-error", "-1", "-o", "land.glb"], "--mesh-error"),
        (&["--mesh-error", "NaN", "-o", "land.glb"], "0 or more"),
        (&["--flip", "-o", "land.glb"], "--flip"),
    ] {
        let output = terrane(&folder, &[&["export", "world.toml"], arguments].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
    // Every sample of so large a land is refused before anything is simulated.
    let arguments = ["export", "world.toml", "--cells", "16385", "--mesh-error", "0", "-o", "land.ply"];
    let output = terrane(&folder, &arguments);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(6), "{message}");
    assert!(message.contains("4096.0 MiB") && !message.contains("erosion"), "{message}");
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

/// The same triangles, corner by corner, whatever the order of vertices: to the bit, but for texture coordinates, which some
/// formats count the other way.
#[track_caller]
fn assert_same(got: &Mesh, want: &Mesh) {
    assert_eq!(got.positions.len(), want.positions.len());
    assert_eq!(got.triangles.len(), want.triangles.len());
    let corners = got.triangles.as_flattened().iter().zip(want.triangles.as_flattened());
    for (got_corner, want_corner) in corners.map(|(got, want)| (*got as usize, *want as usize)) {
        assert_eq!(got.positions[got_corner], want.positions[want_corner]);
        assert_eq!(got.normals[got_corner], want.normals[want_corner]);
        let [got, want] = [got.uvs[got_corner], want.uvs[want_corner]];
        assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() <= 1e-7), "{got:?} {want:?}");
    }
}

/// Meshes over parts of a land of 2000 m as one triangulation of its samples; corners at the same place are the same.
fn on_grid(meshes: &[Mesh], heights: &[f32]) -> Triangulation {
    let cells = heights.len().isqrt();
    let sample = |[x, y, z]: [f32; 3]| {
        let [column, row] = [x, z].map(|at| f64::from(at + 1000.0) / 2000.0 * (cells - 1) as f64);
        let [column, row] = [column, row].map(|at| {
            assert!((at - at.round()).abs() < 1e-3, "{at} is no sample");
            at.round() as u16
        });
        assert_eq!(y, heights[usize::from(row) * cells + usize::from(column)]);
        (row, column)
    };
    let mut vertices: BTreeMap<(u16, u16), u32> =
        meshes.iter().flat_map(|mesh| &mesh.positions).map(|position| (sample(*position), 0)).collect();
    vertices.values_mut().zip(0..).for_each(|(index, next)| *index = next);
    let triangles = meshes
        .iter()
        .flat_map(|mesh| {
            mesh.triangles
                .iter()
                .map(|triangle| triangle.map(|corner| vertices[&sample(mesh.positions[corner as usize])]))
        })
        .collect();
    let places = vertices.keys().map(|(row, column)| [*column, *row]).collect();
    Triangulation { size: [cells as u32; 2], vertices: places, triangles }
}

fn read_small_glb(path: &Path) -> Mesh {
    read_glb(path, 16)
}

/// A .glb with indices of so many bits.
fn read_glb(path: &Path, bits: usize) -> Mesh {
    use ::gltf::accessor::DataType;

    let gltf = ::gltf::Gltf::from_slice(&fs::read(path).unwrap()).unwrap();
    let blob = gltf.blob.as_deref().unwrap();
    let primitive = gltf.meshes().next().unwrap().primitives().next().unwrap();
    let index = if bits == 16 { DataType::U16 } else { DataType::U32 };
    assert_eq!(primitive.indices().unwrap().data_type(), index);
    let reader = primitive.reader(|_| Some(blob));
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    Mesh {
        positions: reader.read_positions().unwrap().collect(),
        normals: reader.read_normals().unwrap().collect(),
        uvs: reader.read_tex_coords(0).unwrap().into_f32().collect(),
        triangles: indices.as_chunks().0.to_vec(),
    }
}

fn read_ply(path: &Path) -> Mesh {
    let parser = ply_rs_bw::parser::Parser::<ply_rs_bw::ply::DefaultElement>::new();
    let mut file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let ply = parser.read_ply(&mut file).unwrap();
    let mut mesh = Mesh::default();
    for vertex in &ply.payload["vertex"] {
        let float = |name: &str| match vertex[name] {
            Property::Float(value) => value,
            ref other => panic!("{name} is {other:?}"),
        };
        mesh.positions.push(["x", "y", "z"].map(float));
        mesh.normals.push(["nx", "ny", "nz"].map(float));
        mesh.uvs.push([float("s"), 1.0 - float("t")]);
    }
    for face in &ply.payload["face"] {
        let Property::ListInt(corners) = &face["vertex_indices"] else { panic!("{face:?}") };
        let corners: [i32; 3] = corners.as_slice().try_into().unwrap();
        mesh.triangles.push(corners.map(|corner| corner.try_into().unwrap()));
    }
    mesh
}

fn read_obj(path: &Path) -> Mesh {
    let options = tobj::LoadOptions::default();
    let (models, materials) = tobj::load_obj(path, &options).unwrap();
    let [model] = models.as_slice() else { panic!("{} objects", models.len()) };
    assert!(materials.unwrap().is_empty());
    let mesh = &model.mesh;
    assert_eq!(mesh.indices, mesh.normal_indices);
    assert_eq!(mesh.indices, mesh.texcoord_indices);
    Mesh {
        positions: mesh.positions.as_chunks().0.to_vec(),
        normals: mesh.normals.as_chunks().0.to_vec(),
        uvs: mesh.texcoords.as_chunks().0.iter().map(|[u, v]| [*u, 1.0 - v]).collect(),
        triangles: mesh.indices.as_chunks().0.to_vec(),
    }
}

fn read_exr(path: &Path) -> Vec<f32> {
    let (width, height, values) = terrane::formats::exr::read_channel(path).unwrap();
    assert_eq!(width, height);
    values
}

fn sidecar(path: &Path) -> Value {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    serde_json::from_slice(&fs::read(name).unwrap()).unwrap()
}

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.toml"), kit::program::EVERY_LAYER).unwrap();
    folder
}

fn terrane(folder: &TempDir, arguments: &[&str]) -> Output {
    let _turn = kit::turn();
    kit::program::terrane(folder.path(), arguments)
}

#[track_caller]
fn export(folder: &TempDir, arguments: &[&str]) {
    let output = terrane(folder, &[&["export", "world.toml"], arguments].concat());
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
}
