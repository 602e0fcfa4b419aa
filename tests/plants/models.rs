//! Triangles of plants: branches and leaves against closed forms, and levels of detail against what they must keep.

use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use terrane::core::mesh::Mesh;
use terrane::plants::derive::Limits;
use terrane::plants::mesh::{Blade, Body, Cylinder, Leaf, Shape, Stem, levels, triangulate};
use terrane::plants::species::Species;
use terrane::plants::turtle::Node;
use terrane::plants::turtle::vector_area;
use terrane::plants::watch::Watch;
use terrane::scene::{Level, Model};

// Measures of meshes -------------------------------------------------------------------------------------------------

fn at(mesh: &Mesh, corner: u32) -> DVec3 {
    DVec3::from(mesh.positions[corner as usize].map(f64::from))
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    mesh.triangles.iter().map(|triangle| triangle.map(|corner| at(mesh, corner)))
}

fn area(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

/// Of a mesh that is open only in a plane through the origin (Gauss's theorem).
fn volume(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Edges that only one triangle has, corners at one place counting as one; none may be run through twice the same way.
fn rim(mesh: &Mesh) -> Vec<[DVec3; 2]> {
    let key = |corner: u32| mesh.positions[corner as usize].map(f32::to_bits);
    let mut edges = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let edge = (key(*from), key(*to));
            assert!(edge.0 != edge.1, "an edge without length");
            assert!(edges.insert(edge, [at(mesh, *from), at(mesh, *to)]).is_none(), "run through twice");
        }
    }
    let alone = edges.iter().filter(|((from, to), _)| !edges.contains_key(&(*to, *from)));
    alone.map(|(_, ends)| *ends).collect()
}

#[track_caller]
fn assert_close(found: f64, expected: f64, tolerance: f64) {
    let difference = (found - expected).abs();
    assert!(difference <= tolerance * expected.abs(), "{found}, expected {expected}");
}

// Branches -----------------------------------------------------------------------------------------------------------

fn node(position: DVec3, width: f64) -> Node {
    Node { position, width }
}

fn draw(axis: &[Node], tolerance: f64) -> Mesh {
    let mut mesh = Mesh::default();
    Cylinder::whole(axis, tolerance).expect("a cylinder").draw(1.0, &mut mesh);
    mesh
}

/// Of a ring with as many sides as it deserves: their number, and area by π r². Rings are as long around as the circle.
fn ring(radius: f64, tolerance: f64) -> (f64, f64) {
    let sides = [3.0, 4.0, 6.0, 8.0, 12.0, 16.0];
    let deserved = sides.into_iter().find(|sides| radius * (1.0 - (PI / sides).cos()) <= tolerance);
    let sides = deserved.unwrap_or(16.0);
    (sides, PI / sides / (PI / sides).tan())
}

#[test]
fn a_straight_branch_is_a_prism_with_a_blunt_end() {
    for (radius, length, tolerance) in [(0.2, 3.0, 0.0), (0.03, 0.5, 1e-3), (0.004, 0.2, 0.01)] {
        let direction = DVec3::new(0.3, 0.8, -0.5).normalize();
        let axis = [node(DVec3::ZERO, 2.0 * radius), node(length * direction, 2.0 * radius)];
        let mesh = draw(&axis, tolerance);
        let (sides, fullness) = ring(radius, tolerance);
        // The end bulges by 0.4 widths: a pyramid.
        let bulge = 0.8 * radius;
        let apothem = radius * (PI / sides) / (PI / sides).tan();
        let lateral = TAU * radius * length;
        assert_close(area(&mesh), lateral + PI * radius * (apothem * apothem + bulge * bulge).sqrt(), 1e-5);
        let section = PI * radius * radius * fullness;
        assert_close(volume(&mesh), section * (length + bulge / 3.0), 1e-5);
        assert_eq!(rim(&mesh).len(), sides as usize, "open where it begins only");
    }
}

#[test]
fn a_tapered_branch_is_a_cone() {
    let (radius, length) = (0.04, 1.5);
    let axis = [node(DVec3::ZERO, 2.0 * radius), node(DVec3::new(0.0, length, 0.0), 0.001)];
    let mesh = draw(&axis, 0.0);
    let apothem = radius * (PI / 16.0) / (PI / 16.0).tan();
    assert_close(area(&mesh), PI * radius * (apothem * apothem + length * length).sqrt(), 1e-5);
    assert_close(volume(&mesh), PI * radius * apothem * length / 3.0, 1e-5);
    assert_eq!(mesh.triangles.len(), 16);
}

#[test]
fn a_frustum_has_its_volume() {
    let (wide, narrow, length) = (0.045, 0.03, 0.8);
    let axis = [node(DVec3::ZERO, 2.0 * wide), node(DVec3::new(length, 0.0, 0.0), 2.0 * narrow)];
    let (_, fullness) = ring(wide, 0.0);
    let frustum = length / 3.0 * (wide * wide + wide * narrow + narrow * narrow);
    let pyramid = 0.8 * narrow * narrow * narrow / 3.0;
    assert_close(volume(&draw(&axis, 0.0)), PI * fullness * (frustum + pyramid), 1e-5);
}

/// An arc of a circle in the plane of `east` and `north`, beginning at the origin along `north`.
fn arc(bend: f64, angle: f64, pieces: usize, east: DVec3, north: DVec3, width: f64) -> Vec<Node> {
    let place = |index: usize| {
        let turn = angle * index as f64 / pieces as f64;
        bend * ((1.0 - turn.cos()) * east + turn.sin() * north)
    };
    (0..=pieces).map(|index| node(place(index), width)).collect()
}

#[test]
fn a_bend_has_the_volume_that_pappus_gives() {
    // A prism that is cut obliquely at both ends has its section times the length of its axis; together they have what
    // Pappus's theorem gives for the ring of a torus whose axis is as long.
    let (bend, angle, pieces, radius) = (0.5f64, 2.5f64, 25, 0.03);
    let axis = arc(bend, angle, pieces, DVec3::X, DVec3::Y, 2.0 * radius);
    let step = angle / pieces as f64;
    let length = 2.0 * bend * (step / 2.0).sin() * pieces as f64;
    // The first ring halves no bend: it stands across the first chord. Seen from the origin, in its plane, it adds nothing.
    let (_, fullness) = ring(radius, 0.0);
    let expected = PI * radius * radius * fullness * (length + 0.8 * radius / 3.0);
    assert_close(volume(&draw(&axis, 0.0)), expected, 1e-5);
    assert_close(length, bend * angle, 1e-3);
}

#[test]
fn thick_bends_are_rounded() {
    // A quarter of a circle from few nodes: the curve through them stays near it, where chords are 4 cm away.
    let (bend, radius) = (2.0, 0.1);
    let axis = arc(bend, PI / 2.0, 4, DVec3::X, DVec3::Y, 2.0 * radius);
    let mesh = draw(&axis, 1e-3);
    let centre = bend * DVec3::X;
    for (position, uv) in mesh.positions.iter().zip(&mesh.uvs) {
        let from_centre = DVec3::from(position.map(f64::from)) - centre;
        let out = DVec2::new(from_centre.truncate().length() - bend, from_centre.z).length();
        // Not of the end's bulge. A tenth of the chord's error is left.
        if f64::from(uv[1]) < bend * PI / 2.0 - 0.02 {
            assert!((out - radius).abs() < 0.004, "{out} m from the axis at {uv:?}");
        }
    }
}

/// Where the first corner of every ring lies, seen from the axis' node.
fn sides(mesh: &Mesh, axis: &[Node]) -> Vec<DVec3> {
    let seams = mesh.uvs.iter().zip(&mesh.positions).filter(|(uv, _)| uv[0] == 0.0);
    let mut sides: Vec<DVec3> = Vec::new();
    for ((_, position), node) in seams.zip(axis) {
        sides.push((DVec3::from(position.map(f64::from)) - node.position).normalize());
    }
    sides
}

#[test]
fn frames_are_carried_without_a_twist() {
    // In a plane: the angle to the plane's normal stays.
    let normal = DVec3::new(0.2, -0.4, 0.9).normalize();
    let east = normal.any_orthonormal_vector();
    let axis = arc(1.0, 5.0, 40, east, normal.cross(east), 0.02);
    let sides_of_arc = sides(&draw(&axis, 0.0), &axis);
    assert_eq!(sides_of_arc.len(), axis.len());
    // The first ring stands across the first chord, the others on planes that halve bends: these stretch it by little.
    for side in &sides_of_arc {
        assert!((side.dot(normal) - sides_of_arc[0].dot(normal)).abs() < 2e-3, "twisted in a plane");
    }

    // Along a helix the frame of Frenet turns about the tangent by its torsion; what is carried in parallel does not.
    let (radius, pitch, turns, pieces) = (0.5, 0.3, 2.0, 800);
    let place = |t: f64| DVec3::new(radius * t.cos(), radius * t.sin(), pitch * t);
    let parameter = |index: usize| TAU * turns * index as f64 / pieces as f64;
    let axis: Vec<Node> = (0..=pieces).map(|index| node(place(parameter(index)), 0.01)).collect();
    let sides_of_helix = sides(&draw(&axis, 0.0), &axis);
    let speed = (radius * radius + pitch * pitch).sqrt();
    let torsion = pitch / (speed * speed);
    let angle = |index: usize| {
        let t = parameter(index);
        let tangent = DVec3::new(-radius * t.sin(), radius * t.cos(), pitch) / speed;
        let inward = DVec3::new(-t.cos(), -t.sin(), 0.0);
        let side = sides_of_helix[index];
        side.dot(tangent.cross(inward)).atan2(side.dot(inward))
    };
    let (from, to) = (40, 760);
    let length = speed * (parameter(to) - parameter(from));
    let expected = -torsion * length;
    let difference = (angle(to) - angle(from) - expected).rem_euclid(TAU);
    assert!(difference.min(TAU - difference) < 0.01, "{difference} rad off after {expected} rad");
}

#[test]
fn normals_are_unit_and_point_outwards() {
    let mut kinked = arc(0.4, 2.0, 6, DVec3::X, DVec3::Y, 0.05);
    for (index, node) in kinked.iter_mut().enumerate() {
        node.width = 0.09 - 0.013 * index as f64;
    }
    let there_and_back = [DVec3::ZERO, DVec3::Y, DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.9, 0.2, 0.4)];
    let there_and_back: Vec<Node> = there_and_back.map(|position| node(position, 0.06)).into();
    for axis in [kinked, there_and_back] {
        for tolerance in [0.0, 1e-3, 1e-2] {
            let mesh = draw(&axis, tolerance);
            for normal in &mesh.normals {
                assert!((DVec3::from(normal.map(f64::from)).length() - 1.0).abs() < 1e-5);
            }
            let mut wrong = 0.0;
            for (triangle, [a, b, c]) in mesh.triangles.iter().zip(corners(&mesh)) {
                let face = (b - a).cross(c - a);
                let normals =
                    triangle.map(|corner| DVec3::from(mesh.normals[corner as usize].map(f64::from)));
                if face.dot(normals[0] + normals[1] + normals[2]) <= 0.0 {
                    wrong += face.length() / 2.0;
                }
            }
            // In the fold of a branch that turns back some triangles lie the other way around.
            assert!(wrong <= 0.02 * area(&mesh), "{wrong} m² of {} face inwards", area(&mesh));
        }
    }
}

#[test]
fn branches_are_watertight_whatever_their_width() {
    // From 16 sides down to a point, round bends of all angles.
    let mut axis = Vec::new();
    let mut place = DVec3::ZERO;
    for index in 0..24 {
        axis.push(node(place, 0.4 * 0.7f64.powi(index)));
        let angle = 1.9 * f64::from(index);
        place += 0.3 * DVec3::new(angle.sin(), 0.5, angle.cos()).normalize();
    }
    for tolerance in [0.0, 1e-3, 5e-3, 0.02] {
        let mesh = draw(&axis, tolerance);
        let (sides, _) = ring(0.2, tolerance);
        let rim = rim(&mesh);
        assert_eq!(rim.len(), sides as usize, "open where it begins only");
        // All of the rim lies round the foot.
        assert!(rim.iter().flatten().all(|end| end.length() < 0.23));
    }
}

// Leaves -------------------------------------------------------------------------------------------------------------

/// A simple polygon, seldom convex, from its corners' distances from the middle, turned into space.
fn star(radii: &[f64], axis: [f64; 3]) -> Vec<DVec3> {
    let normal = DVec3::from(axis).try_normalize().unwrap_or(DVec3::Z);
    let east = normal.any_orthonormal_vector();
    let north = normal.cross(east);
    let corner = |(index, radius): (usize, &f64)| {
        let angle = TAU * index as f64 / radii.len() as f64;
        *radius * (angle.cos() * east + angle.sin() * north)
    };
    radii.iter().enumerate().map(corner).collect()
}

/// The area by the shoelace formula, in the plane across `normal`.
fn shoelace(outline: &[DVec3], normal: DVec3) -> f64 {
    let east = normal.any_orthonormal_vector();
    let north = normal.cross(east);
    let flat: Vec<DVec2> = outline.iter().map(|at| DVec2::new(at.dot(east), at.dot(north))).collect();
    let next = flat.iter().cycle().skip(1);
    flat.iter().zip(next).map(|(from, to)| from.perp_dot(*to)).sum::<f64>() / 2.0
}

/// As many triangles as there must be, none turned over, and together as large as the polygon: then they don't overlap, and
/// leave nothing out.
#[track_caller]
fn check_triangulation(outline: &[DVec3]) {
    let normal = vector_area(outline).normalize();
    let triangles = triangulate(outline);
    assert_eq!(triangles.len(), outline.len() - 2);
    let mut sum = 0.0;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| outline[corner as usize]);
        let signed = (b - a).cross(c - a).dot(normal) / 2.0;
        assert!(signed >= -1e-12, "turned over: {signed}");
        sum += signed;
    }
    assert_close(sum, shoelace(outline, normal), 1e-9);
    assert_close(sum, vector_area(outline).length(), 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

    #[test]
    fn concave_polygons_are_cut_into_what_they_enclose(
        radii in prop::collection::vec(0.05..1.0f64, 3..40),
        axis in prop::array::uniform3(-1.0..1.0f64),
        backwards in any::<bool>(),
    ) {
        let mut outline = star(&radii, axis);
        if backwards {
            outline.reverse();
        }
        prop_assume!(vector_area(&outline).length() > 1e-3);
        check_triangulation(&outline);
    }
}

#[test]
fn combs_and_spirals_are_cut_right() {
    let comb = |teeth: usize| {
        let mut outline = vec![DVec3::new(teeth as f64, -1.0, 0.0), DVec3::new(teeth as f64, 0.0, 0.0)];
        for tooth in (0..teeth).rev() {
            outline.push(DVec3::new(tooth as f64 + 0.5, 3.0, 0.0));
            outline.push(DVec3::new(tooth as f64, 0.0, 0.0));
        }
        outline.push(DVec3::new(0.0, -1.0, 0.0));
        outline
    };
    check_triangulation(&comb(2));
    check_triangulation(&comb(30));
    let arm = |radius: f64, turn: f64| radius * DVec3::new(turn.cos(), 0.0, turn.sin());
    let outward = (0..60).map(|step| arm(1.0 + 0.1 * f64::from(step), 0.25 * f64::from(step)));
    let inward = (0..60).rev().map(|step| arm(0.8 + 0.1 * f64::from(step), 0.25 * f64::from(step)));
    check_triangulation(&outward.chain(inward).collect::<Vec<_>>());
}

#[test]
fn leaves_keep_their_area_in_every_shape() {
    let oak = [[0.0, 0.0, 0.0], [0.095, 0.047, 0.014], [0.165, 0.0, -0.014], [0.095, -0.047, 0.014]];
    let lobed = [
        [0.0, 0.0, 0.0],
        [0.03, 0.013, 0.0],
        [0.05, 0.032, 0.0],
        [0.064, 0.02, 0.0],
        [0.098, 0.045, 0.0],
        [0.11, 0.024, 0.0],
        [0.138, 0.026, 0.0],
        [0.152, 0.0, 0.0],
        [0.05, -0.02, 0.0],
    ];
    for outline in [&oak[..], &lobed[..]] {
        let outline = outline.iter().map(|at| DVec3::from(*at)).collect();
        let blade = Blade::new(0, outline, DVec3::Z).expect("few vertices").expect("it encloses something");
        for shape in [Shape::Whole, Shape::Kite, Shape::Triangle] {
            let area = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).length() / 2.0;
            let whole: f64 = blade.triangles(shape).iter().map(area).sum();
            // A kite is widened from the line of base and tip: where it is folded, its two halves are not alike.
            assert_close(whole, blade.area, if shape == Shape::Kite { 0.03 } else { 1e-9 });
        }
    }
}

// Levels of detail ---------------------------------------------------------------------------------------------------

fn species(name: &str) -> Species {
    let path = format!("{}/configs/species/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    terrane::world::species::load(path.as_ref()).expect("a species").species
}

const PLANTS: [&str; 8] = ["oak", "spruce", "palm", "shrub", "grass", "daisy", "fern", "dead"];

fn grow(name: &str) -> (Species, Body, Model) {
    let species = species(name);
    let body = species.body(1, 0, &Limits::default()).expect("a plant");
    let model = species.model(&body, Watch::NONE).unwrap();
    (species, body, model)
}

/// Between which coordinates all but this share of the area lies on each side.
fn bulk(level: &Level, share: f64) -> [DVec3; 2] {
    let mut pieces: Vec<(DVec3, f64)> = Vec::new();
    for part in &level.parts {
        for [a, b, c] in corners(&part.mesh) {
            // A long triangle is in many places.
            for step in 0..8 {
                let along = (f64::from(step) + 0.5) / 8.0;
                let middle = (a.lerp(b, along) + a.lerp(c, along)) / 2.0;
                pieces.push((middle, (b - a).cross(c - a).length() * along));
            }
        }
    }
    let all: f64 = pieces.iter().map(|(_, area)| area).sum();
    let at = |axis: usize, share: f64| {
        let mut sorted: Vec<_> = pieces.iter().map(|(place, area)| (place[axis], *area)).collect();
        sorted.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut sum = 0.0;
        let found = sorted.iter().find(|(_, area)| {
            sum += area;
            sum >= share * all
        });
        found.map_or(0.0, |(place, _)| *place)
    };
    [share, 1.0 - share].map(|share| DVec3::new(at(0, share), at(1, share), at(2, share)))
}

/// Area of each material, m²: one-sided of leaves, all round of branches.
fn areas(level: &Level, materials: usize) -> Vec<f64> {
    let mut areas = vec![0.0; materials];
    for part in &level.parts {
        areas[part.material] += area(&part.mesh);
    }
    areas
}

#[test]
fn levels_keep_what_they_are_made_of() {
    for name in PLANTS {
        let (_, _, model) = grow(name);
        assert!(model.levels.len() >= 3, "{name}");
        let finest = areas(&model.levels[0], model.materials.len());
        let triangles: Vec<usize> = model.levels.iter().map(Level::triangles).collect();
        assert!(triangles.windows(2).all(|pair| pair[1] * 2 < pair[0]), "{name}: {triangles:?}");
        // A fifth from level to level, and up to twice of that: the longest of twigs stand for the others and have the most
        // triangles. The trunk, and one element of each material, stay in any case.
        for (index, found) in triangles.iter().enumerate() {
            let share = triangles[0] as f64 / 5f64.powi(index as i32);
            assert!(*found as f64 <= 2.0 * share + 24.0, "{name}, level {index}: {triangles:?}");
        }
        let details = model.levels.windows(2);
        assert!(details.into_iter().all(|pair| pair[0].detail < pair[1].detail), "{name}");
        assert_eq!(model.levels[0].detail, 0.0);

        let [least, greatest] = model.bounds();
        for (index, level) in model.levels.iter().enumerate().skip(1) {
            let all: f64 = finest.iter().sum();
            for (material, (found, expected)) in areas(level, finest.len()).iter().zip(&finest).enumerate() {
                // What is a small part of a plant may be a triangle more or less.
                let tolerance = 0.12 * expected + 0.01 * all;
                assert!(
                    (found - expected).abs() <= tolerance,
                    "{name}, level {index}, material {material}: {found} m² of {expected}"
                );
            }
            let coarse = Model { levels: vec![level.clone()], ..model.clone() }.bounds();
            let reach = 2.0 * level.detail;
            let grown = (least - coarse[0]).max(coarse[1] - greatest).max_element();
            assert!(grown <= reach, "{name}, level {index}: {grown} m more");
            // Twigs at the rim are thinner than a detail, and some are left out. What lies farther out than all but a hundredth
            // of the area covers next to nothing, and so does what has less of it than one element of some eight triangles.
            let share = (8.0 / level.triangles() as f64).clamp(0.01, 0.25);
            let ([low, high], [coarse_low, coarse_high]) =
                (bulk(&model.levels[0], share), bulk(level, share));
            let lost = (coarse_low - low).max(high - coarse_high).max_element();
            // A triangle stands for a square of two details' side. A twig with its bends has up to 32 of them, and so stands for what
            // is 2 √32 details across; it may itself lie half as far from its edge.
            let across = 2.0 * f64::from(level.detail) * 32f64.sqrt();
            assert!(lost <= across / 2.0, "{name}, level {index}: {lost} m less");
        }
    }
}

#[test]
fn blades_of_grass_stay_thin() {
    let (_, _, model) = grow("grass");
    for level in &model.levels {
        // Width of a blade: twice its area by its longest side.
        let mut widths = Vec::new();
        for part in &level.parts {
            for [a, b, c] in corners(&part.mesh) {
                let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
                widths.push((b - a).cross(c - a).length() / longest);
            }
        }
        widths.sort_by(f64::total_cmp);
        let most = 0.011f64.max(2.0 * f64::from(level.detail));
        assert!(widths[widths.len() / 2] <= most, "half of them wider than {most} m");
    }
}

#[test]
fn models_are_the_same_on_any_number_of_threads() {
    let pool = |threads| rayon_pool(threads, || grow("shrub").2);
    assert_eq!(pool(1), pool(3));
}

fn rayon_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool").install(work)
}

#[test]
fn branches_begin_within_others() {
    for name in ["oak", "dead", "spruce", "shrub", "fern"] {
        let (_, body, _) = grow(name);
        let [least, greatest] = body.bounds().expect("something");
        let ground = least.y + 0.02 * (greatest.y - least.y);
        let mut loose = 0;
        for stem in &body.stems {
            let foot = stem.nodes[0];
            let within = |other: &Stem| {
                !std::ptr::eq(other, stem)
                    && other.nodes.windows(2).any(|pair| {
                        let along = pair[1].position - pair[0].position;
                        let t = (foot.position - pair[0].position).dot(along)
                            / along.length_squared().max(f64::MIN_POSITIVE);
                        let t = t.clamp(0.0, 1.0);
                        let width = pair[0].width + t * (pair[1].width - pair[0].width);
                        foot.position.distance(pair[0].position + t * along) <= 0.5 * width.max(0.004)
                    })
            };
            if foot.position.y > ground && !body.stems.iter().any(within) {
                loose += 1;
            }
        }
        assert_eq!(loose, 0, "{name}: of {} branches", body.stems.len());
    }
}

#[test]
fn nothing_is_no_plant() {
    let empty = levels(&Body::default(), Watch::NONE).unwrap();
    assert!(empty.len() == 1 && empty[0].triangles() == 0);
    assert!(Cylinder::whole(&[node(DVec3::ZERO, 1.0)], 0.0).is_none());
    assert!(Cylinder::whole(&[node(DVec3::ZERO, 1.0), node(DVec3::ZERO, 1.0)], 0.0).is_none());
    assert!(Cylinder::whole(&[node(DVec3::ZERO, 0.0), node(DVec3::Y, 0.0)], 0.0).is_none());
    let line = vec![DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
    assert!(Blade::new(0, line, DVec3::Z).expect("few vertices").is_none());
    let body = Body { leaves: Vec::<Leaf>::new(), ..Body::default() };
    assert!(body.bounds().is_none());
}
