//! Where plants stand: laws that hold whatever the seed. Counts are compared with their expectation within four standard
//! deviations of a Poisson process, √n each: blue noise varies less.

use glam::{DVec2, Vec2, Vec3, vec2, vec3};
use std::collections::{HashMap, HashSet};
use std::f32::consts::PI;
use std::sync::Arc;
use terrane::core::{camera::Pinhole, grid::Grid, hash::mix, map::Map};
use terrane::plants::planting::{
    self, Cover, Error, Footing, Ground, Kind, Patches, Places, Planter, Ramp, Rivalry, Rule, Scatter, Site,
};
use terrane::scene::{Instance, Level, Model, Part};

// Made-up ground, kinds and rules ------------------------------------------------------------------------------------

fn ground(cells: u32, extent: f32, height: impl Fn(Vec2) -> f32) -> Ground {
    let grid = Grid { cells, extent };
    let places = (0..cells).flat_map(|row| (0..cells).map(move |column| grid.position(column, row)));
    Ground::new(grid, 0.0, places.map(|[x, z]| height(vec2(x, z))).collect())
}

fn level(extent: f32) -> Ground {
    ground(65, extent, |_| 10.0)
}

/// Hills and hollows, half of it under the sea.
fn rough() -> Ground {
    ground(129, 400.0, |at| 20.0 * (at.x / 37.0).sin() * (at.y / 29.0).cos() + 6.0 * (at.x / 11.0).cos())
}

const OAK: usize = 0;
const SHRUB: usize = 1;
const GRASS: usize = 2;

/// Three kinds of three variants each.
fn kinds() -> Vec<Kind> {
    let kind = |first, crown, foot, height| Kind { models: first..first + 3, crown, foot, height };
    // Oak, shrub, grass.
    vec![kind(0, 4.0, 0.4, 12.0), kind(3, 1.0, 0.2, 2.0), kind(6, 0.2, 0.05, 0.4)]
}

fn kind_of(instance: &Instance) -> usize {
    instance.model as usize / 3
}

fn rule(kind: usize, places: Places) -> Rule {
    Rule {
        name: format!("plants.{kind}"),
        seed: 7,
        kinds: vec![(kind, 1.0)],
        scale: [1.0, 1.0],
        lean: 0.0,
        shade: 0.0,
        site: Site::default(),
        places,
    }
}

fn scatter(spacing: f32, density: f32) -> Places {
    Places::Scatter(Scatter { spacing, density, rivalry: Rivalry::None })
}

/// As many as the spacing lets stand.
fn dense(spacing: f32) -> Places {
    scatter(spacing, Scatter::densest(spacing))
}

fn on(site: Site, rule: Rule) -> Rule {
    Rule { site, ..rule }
}

/// On level ground, looking north.
fn camera(eye: Vec2) -> Pinhole {
    Pinhole::look_at(vec3(eye.x, 12.0, eye.y), vec3(eye.x, 10.0, eye.y - 10.0), 1.0, 1.5)
}

fn plant(rules: &[Rule], ground: &Ground) -> Vec<Instance> {
    plant_seen(rules, ground, &camera(Vec2::ZERO))
}

fn plant_seen(rules: &[Rule], ground: &Ground, camera: &Pinhole) -> Vec<Instance> {
    let kinds = kinds();
    let mut planter = Planter::new(rules, &kinds, ground, camera);
    while planter.step().unwrap() {}
    planter.into_instances()
}

fn at(instance: &Instance) -> Vec2 {
    vec2(instance.position.x, instance.position.z)
}

fn nearest_two(plants: &[Instance]) -> f64 {
    let mut places: Vec<DVec2> = plants.iter().map(|plant| at(plant).as_dvec2()).collect();
    places.sort_by(|one, other| one.x.total_cmp(&other.x));
    let mut least = f64::INFINITY;
    for (index, one) in places.iter().enumerate() {
        let reach = one.x + least;
        let near = places[index + 1..].iter().take_while(|other| other.x < reach);
        least = near.map(|other| one.distance(*other)).fold(least, f64::min);
    }
    least
}

#[track_caller]
fn assert_count(count: usize, expected: f64) {
    let most = 4.0 * expected.sqrt();
    assert!((count as f64 - expected).abs() <= most, "{count} where {expected:.1} ± {most:.1} are expected");
}

// Ground -------------------------------------------------------------------------------------------------------------

#[test]
fn distances_are_exact() {
    let side = 37;
    for (share, seed) in [(0, 1), (1, 2), (3, 3), (40, 4), (1000, 5)] {
        let is_target = |index: usize| mix(mix(seed) ^ index as u32) % 1000 < share;
        let targets: Vec<usize> = (0..side * side).filter(|index| is_target(*index)).collect();
        let found = planting::distances(side, 2.5, is_target);
        for (index, distance) in found.iter().enumerate() {
            let square = |target: &usize| {
                let [across, down] = [index % side, index / side].map(|at| at as f64);
                (across - (target % side) as f64).powi(2) + (down - (target / side) as f64).powi(2)
            };
            let want = targets.iter().map(square).reduce(f64::min).map_or(1e9, |square| 2.5 * square.sqrt());
            assert!((f64::from(*distance) - want).abs() <= 1e-5 * want, "{distance} where {want} is right");
        }
    }
}

#[test]
fn heights_pass_through_the_samples_and_follow_quadratics_between() {
    // Catmull–Rom's cubic is exact for quadratics, where its limit does not act.
    let height = |at: Vec2| 3.0 + 1.4 * at.x - 0.9 * at.y + 1e-3 * at.x * at.y + 2e-3 * at.x * at.x;
    let ground = ground(33, 320.0, height);
    for index in 0..400_u32 {
        let share = |salt: u32| mix(index ^ mix(salt)) as f32 / u32::MAX as f32 - 0.5;
        let place = vec2(share(1), share(2)) * 250.0;
        assert!((ground.height_at(place) - height(place)).abs() < 2e-3, "at {place}");
        // The B-spline's slope is that of the quadratic, too.
        let slope = vec2(1.4 + 1e-3 * place.y + 4e-3 * place.x, -0.9 + 1e-3 * place.x);
        assert!(ground.gradient(place).distance(slope) < 1e-3, "at {place}");
    }
    let rough = rough();
    let [x, z] = rough.grid.position(40, 77);
    assert_eq!(rough.height_at(vec2(x, z)), rough.height[77 * 129 + 40]);
}

#[test]
fn a_cliff_is_overshot_by_little() {
    let ground = ground(33, 320.0, |at| if at.x < 0.0 { 0.0 } else { 100.0 });
    let line: Vec<f32> = (-1000..1000).map(|step| ground.height_at(vec2(step as f32 * 0.05, 3.0))).collect();
    let range = line.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], h| [a.min(*h), b.max(*h)]);
    assert!(range[0] >= -15.0 && range[1] <= 115.0, "{range:?}");
}

// Sites --------------------------------------------------------------------------------------------------------------

#[test]
fn ramps_rise_and_fall() {
    /// A ramp's numbers, and its values at some places.
    type Case = (&'static [f32], &'static [(f32, f32)]);
    let cases: &[Case] = &[
        (&[2.0, 6.0], &[(-9.0, 0.0), (2.0, 0.0), (3.0, 0.25), (6.0, 1.0), (1e9, 1.0)]),
        (&[35.0, 25.0], &[(0.0, 1.0), (25.0, 1.0), (30.0, 0.5), (35.0, 0.0), (90.0, 0.0)]),
        (&[1.0, 2.0, 4.0, 8.0], &[(0.5, 0.0), (1.5, 0.5), (3.0, 1.0), (5.0, 0.75), (8.0, 0.0), (9.0, 0.0)]),
        (&[1.0, 1.0, 4.0, 4.0], &[(0.9, 0.0), (1.0, 1.0), (4.0, 1.0), (4.1, 0.0)]),
    ];
    for (values, points) in cases {
        let ramp = Ramp::new(values).unwrap();
        for (value, density) in *points {
            assert_eq!(ramp.at(*value), *density, "{values:?} at {value}");
        }
    }
    for wrong in [&[1.0][..], &[2.0, 2.0], &[1.0, 2.0, 3.0], &[1.0, 3.0, 2.0, 4.0], &[f32::NAN, 1.0]] {
        assert_eq!(Ramp::new(wrong), None, "{wrong:?}");
    }
}

/// Each quantity, by a rule that asks for it, on ground where it is known.
#[test]
fn a_site_asks_for_what_it_says() {
    let ramp = |values: &[f32]| Ramp::new(values);
    let mut ground = ground(101, 1000.0, |at| at.x * 0.1);
    let columns = |value: fn(usize) -> f32| (0..101 * 101).map(|sample| value(sample % 101)).collect();
    ground.wetness = columns(|column| column as f32 / 100.0);
    ground.flow = columns(|column| column as f32);
    // A river from north to south at x = 300.
    ground.water = columns(|column| if column == 80 { 1.0 } else { 0.0 });
    ground.measure(planting::Needs { sea: true, water: true, ..Default::default() });
    let place = vec2(205.0, 33.0);
    let angle = 0.1_f32.atan();
    let anywhere = || Site { footing: Footing::Anywhere, ..Site::default() };
    let cases = [
        ("height", Site { height: ramp(&[0.0, 41.0]), ..anywhere() }, 0.5),
        ("slope", Site { slope: ramp(&[2.0 * angle, 0.0]), ..anywhere() }, 0.5),
        ("sea", Site { sea: ramp(&[0.0, 410.0]), ..anywhere() }, 0.5),
        ("water", Site { water: ramp(&[0.0, 190.0]), ..anywhere() }, 0.5),
        ("wetness", Site { wetness: ramp(&[0.0, 1.41]), ..anywhere() }, 0.5),
        ("flow", Site { flow: ramp(&[0.0, 141.0]), ..anywhere() }, 0.5),
        (
            "height and flow",
            Site { height: ramp(&[0.0, 41.0]), flow: ramp(&[0.0, 141.0]), ..anywhere() },
            0.25,
        ),
        ("nothing", anywhere(), 1.0),
    ];
    for (name, site, want) in cases {
        let density = site.density(&ground, place);
        assert!((density - want).abs() < 1e-3, "{name}: {density} where {want} is right");
    }
    let footing = |footing| Site { footing, ..Site::default() };
    for (site, dry, river, sea) in [
        (footing(Footing::Land), 1.0, 0.0, 0.0),
        (footing(Footing::Water), 0.0, 1.0, 1.0),
        (footing(Footing::Anywhere), 1.0, 1.0, 1.0),
    ] {
        let densities = [place, vec2(300.0, 33.0), vec2(-205.0, 33.0)].map(|at| site.density(&ground, at));
        assert_eq!(densities, [dry, river, sea], "{:?}", site.footing);
        assert_eq!(site.density(&ground, vec2(501.0, 0.0)), 0.0, "outside the terrain");
    }
}

#[test]
fn patches_cover_their_share() {
    for (cover, size, seed) in [(0.2, 15.0, 1), (0.5, 40.0, 2), (0.8, 6.0, 3), (0.0, 5.0, 4), (1.0, 5.0, 5)] {
        let patches = Patches::new(seed, size, cover);
        let places = (0..40_000).map(|index| vec2((index % 200) as f32, (index / 200) as f32) * size * 0.29);
        let mean = places.map(|at| f64::from(patches.at(at))).sum::<f64>() / 40_000.0;
        // Some 3,400 patches: the mean varies by less than 0.02.
        assert!((mean - f64::from(cover)).abs() < 0.04, "{mean} of {cover}");
    }
}

// Scatter ------------------------------------------------------------------------------------------------------------

#[test]
fn none_is_nearer_than_the_spacing() {
    let patches = Site { patches: Some(Patches::new(3, 30.0, 0.5)), ..Site::default() };
    let mixed = Rule { kinds: vec![(OAK, 1.0), (SHRUB, 2.0)], scale: [0.5, 2.0], ..rule(OAK, dense(4.0)) };
    // Dry only in a corner.
    let corner = ground(129, 600.0, |at| if at.min_element() > 220.0 { 10.0 } else { -10.0 });
    let cases = [
        (mixed, level(200.0), 4.0),
        (on(patches, rule(OAK, dense(3.0))), level(200.0), 3.0),
        (rule(OAK, scatter(5.0, 0.005)), level(400.0), 5.0),
        (rule(OAK, dense(6.0)), rough(), 6.0),
        // Far from the origin floats are coarse, for far plants and for near ones.
        (rule(OAK, dense(0.2)), corner, 0.2),
        (rule(OAK, dense(9000.0)), level(1e6), 9000.0),
    ];
    for (rule, ground, spacing) in cases {
        let plants = plant(&[rule], &ground);
        assert!(plants.len() > 300, "{} plants", plants.len());
        let least = nearest_two(&plants);
        assert!(least >= spacing, "{least} m where {spacing} m are the least");
        // They do come near it.
        assert!(least < 1.3 * spacing, "{least} m");
    }
}

#[test]
fn the_spacing_is_filled() {
    let ground = level(900.0);
    let spacing = 5.0;
    let full = plant(&[rule(OAK, dense(spacing))], &ground);
    let inner =
        |plants: &[Instance]| plants.iter().filter(|plant| at(plant).abs().max_element() < 440.0).count();
    assert_count(inner(&full), f64::from(Scatter::densest(spacing)) * 880.0 * 880.0);
    // Half of that is half of that, and so is a hundredth, whose places lie further apart.
    for share in [0.5, 0.01] {
        let fewer = plant(&[rule(OAK, scatter(spacing, share * Scatter::densest(spacing)))], &ground);
        assert_count(inner(&fewer), f64::from(share * Scatter::densest(spacing)) * 880.0 * 880.0);
    }
}

#[test]
fn the_density_follows_the_ramp() {
    // Height 0 … 100 m over 1000 m: none at 20 m, all at 70 m.
    let ground = ground(65, 1000.0, |at| 50.0 + at.x * 0.1);
    let density = 0.02;
    let site = Site { height: Ramp::new(&[20.0, 70.0]), ..Site::default() };
    let rule = on(site, rule(OAK, scatter(3.0, density)));
    let plants = plant(std::slice::from_ref(&rule), &ground);
    let mut expected_in_all = 0.0;
    for strip in 0..10 {
        let west = -500.0 + 100.0 * strip as f32;
        let count = plants.iter().filter(|plant| (west..west + 100.0).contains(&plant.position.x)).count();
        let steps = 1000;
        let mean: f64 = (0..steps)
            .map(|step| {
                let x = west + (step as f32 + 0.5) * 100.0 / steps as f32;
                f64::from(((50.0 + x * 0.1 - 20.0) / 50.0).clamp(0.0, 1.0))
            })
            .sum::<f64>()
            / f64::from(steps);
        let expected = mean * f64::from(density) * 100.0 * 1000.0;
        assert_count(count, expected);
        expected_in_all += expected;
    }
    assert_count(rule.predict(&ground) as usize, expected_in_all);
}

#[test]
fn a_mask_is_obeyed() {
    // White in the north-east, black elsewhere, with a soft line between.
    let values =
        (0..64 * 64).map(|texel| if texel % 64 >= 32 && texel / 64 < 32 { 1.0 } else { 0.0 }).collect();
    let mask = Arc::new(Map { width: 64, height: 64, values });
    let site = Site { mask: Some(mask), ..Site::default() };
    let plants = plant(&[on(site, rule(OAK, dense(6.0)))], &level(600.0));
    let inside = |plant: &&Instance| plant.position.x > -5.0 && plant.position.z < 5.0;
    assert_eq!(plants.iter().filter(inside).count(), plants.len());
    assert_count(plants.len(), f64::from(Scatter::densest(6.0)) * 300.0 * 300.0);
}

#[test]
fn kinds_come_in_their_shares_and_variants_alike() {
    let mixed = Rule { kinds: vec![(GRASS, 3.0), (OAK, 1.0), (SHRUB, 0.0)], ..rule(OAK, dense(3.0)) };
    let plants = plant(&[mixed], &level(500.0));
    let count = |is: &dyn Fn(&Instance) -> bool| plants.iter().filter(|plant| is(plant)).count();
    let all = plants.len() as f64;
    assert_eq!(count(&|plant| kind_of(plant) == SHRUB), 0);
    assert_count(count(&|plant| kind_of(plant) == OAK), all / 4.0);
    for variant in 0..3 {
        assert_count(count(&|plant| plant.model == 6 + variant), all / 4.0);
    }
    // Turned any way: the mean of so many directions is near none.
    let mean: Vec3 = plants.iter().map(|plant| plant.rotation * Vec3::X).sum();
    assert!(mean.length() < 4.0 * all.sqrt() as f32, "{mean}");
}

#[test]
fn sizes_fill_their_range() {
    let plants = plant(&[Rule { scale: [0.5, 1.5], ..rule(OAK, dense(4.0)) }], &level(400.0));
    let sum: f32 = plants.iter().map(|plant| plant.scale).sum();
    assert!(plants.iter().all(|plant| (0.5..=1.5).contains(&plant.scale)));
    // The deviation of a uniform distribution is its width over √12.
    assert!((sum / plants.len() as f32 - 1.0).abs() < 4.0 / (12.0 * plants.len() as f32).sqrt());
}

// Standing -----------------------------------------------------------------------------------------------------------

#[test]
fn nothing_stands_in_water_or_outside() {
    let mut ground = rough();
    // A river along the middle.
    ground.water =
        (0..129 * 129).map(|sample| if (60..66).contains(&(sample / 129)) { 0.4 } else { 0.0 }).collect();
    let cover = Places::Cover(Cover { density: 4.0, near: 40.0, reach: 300.0 });
    let grid = Places::Grid(planting::Grid {
        offset: vec2(3.0, -7.0),
        cells: [90, 90],
        cell_size: 6.0,
        probability: 1.0,
        jitter: 1.0,
    });
    let camera = Pinhole::look_at(vec3(150.0, 30.0, 190.0), vec3(0.0, 0.0, 0.0), 1.0, 1.5);
    for places in [dense(3.0), cover, grid] {
        let plants = plant_seen(&[rule(GRASS, places.clone())], &ground, &camera);
        assert!(plants.len() > 500, "{} by {places:?}", plants.len());
        for plant in &plants {
            assert!(at(plant).abs().max_element() <= 200.0, "{} lies outside", plant.position);
            assert!(ground.height_at(at(plant)) > 0.0, "{} lies in the sea", plant.position);
            assert!(!(-12.0..3.0).contains(&plant.position.z), "{} lies in the river", plant.position);
        }
        let wet = Site { footing: Footing::Water, ..Site::default() };
        for plant in plant_seen(&[on(wet, rule(GRASS, places))], &ground, &camera) {
            let in_river = (-15.7..6.3).contains(&plant.position.z);
            assert!(in_river || ground.height_at(at(&plant)) <= 0.0, "{} is dry", plant.position);
        }
    }
}

/// The rim of every foot is in the ground, and by no more than the slope asks for.
#[test]
fn feet_are_in_the_ground() {
    let ground = rough();
    for (kind, lean) in [(OAK, 0.0), (SHRUB, 0.0), (SHRUB, 1.0), (GRASS, 0.5)] {
        let rule = Rule { lean, scale: [0.7, 1.4], ..rule(kind, dense(8.0)) };
        let plants = plant(&[rule], &ground);
        assert!(plants.len() > 300);
        let Kind { foot, height, .. } = kinds()[kind];
        for plant in plants {
            let (foot, height) = (foot * plant.scale, height * plant.scale);
            let slope = ground.gradient(at(&plant)).length();
            // Ground curves within a foot by centimetres.
            let curve = 0.1 * foot;
            for step in 0..16 {
                let angle = step as f32 * PI / 8.0;
                let rim = plant.position + plant.rotation * (foot * vec3(angle.cos(), 0.0, angle.sin()));
                let above = rim.y - ground.height_at(vec2(rim.x, rim.z));
                assert!(above <= curve, "{above} m above the ground at {rim}, slope {slope}");
            }
            let depth = ground.height_at(at(&plant)) - plant.position.y;
            assert!(depth <= foot * slope + 0.05_f32.min(0.02 * height) + 1e-4, "{depth} m deep");
            assert!(depth > 0.0);
        }
    }
}

#[test]
fn plants_lean_as_far_as_they_are_told() {
    let ground = ground(65, 400.0, |at| 100.0 + 0.5 * at.x);
    let slope = 0.5_f32.atan();
    for (lean, angle) in [(0.0, 0.0), (1.0, slope)] {
        for plant in plant(&[Rule { lean, ..rule(OAK, dense(20.0)) }], &ground) {
            // Away from the ground at the edge, which ends level.
            if at(&plant).abs().max_element() < 180.0 {
                let up = plant.rotation * Vec3::Y;
                assert!((up.angle_between(Vec3::Y) - angle).abs() < 1e-2, "{up}");
                assert!(up.x <= 1e-4, "{up} leans into the slope");
            }
        }
    }
}

#[test]
fn a_kind_is_measured_by_its_models() {
    let model = |positions: &[[f32; 3]]| {
        let mesh = terrane::core::mesh::Mesh { positions: positions.to_vec(), ..Default::default() };
        let level = Level { detail: 0.0, parts: vec![Part { material: 0, mesh }] };
        Arc::new(Model { levels: vec![level], ..Model::default() })
    };
    let models = [
        model(&[[0.3, 0.0, 0.4], [0.0, 9.0, 0.0], [3.0, 5.0, -4.0]]),
        model(&[[0.1, 0.0, 0.0], [0.0, 10.0, 0.0]]),
    ];
    let kind = Kind::of_models(4, &models);
    assert_eq!(kind, Kind { models: 4..6, crown: 5.0, foot: 0.5, height: 10.0 });
}

// Shade --------------------------------------------------------------------------------------------------------------

#[test]
fn what_is_shaded_dies_unless_it_stands_it() {
    let ground = level(400.0);
    let oaks = rule(OAK, dense(14.0));
    let shrubs = |shade| Rule { shade, seed: 9, ..rule(SHRUB, dense(3.0)) };
    let alone = plant(&[shrubs(0.0)], &ground);
    let trees = plant(std::slice::from_ref(&oaks), &ground);
    let distance =
        |shrub: &Instance| trees.iter().map(|oak| at(oak).distance(at(shrub))).fold(f32::INFINITY, f32::min);
    let count = |plants: &[Instance], range: std::ops::Range<f32>| {
        plants.iter().filter(|plant| kind_of(plant) == SHRUB && range.contains(&distance(plant))).count()
    };
    let (under, trunk) = (0.6..4.0, 0.0..0.6);
    let in_shade = count(&alone, under.clone());
    assert!(in_shade > 1000);
    for shade in [0.0, 0.3, 1.0] {
        let plants = plant(&[oaks.clone(), shrubs(shade)], &ground);
        let share = count(&plants, under.clone()) as f64;
        let expected = f64::from(shade) * in_shade as f64;
        // A binomial distribution varies less than Poisson's.
        assert!(
            (share - expected).abs() <= 4.0 * (expected * f64::from(1.0 - shade)).sqrt(),
            "{share} of {expected}"
        );
        assert_eq!(count(&plants, 4.0..1e9), count(&alone, 4.0..1e9), "in the open");
        assert_eq!(count(&plants, trunk.clone()), 0, "in a trunk");
        // Earlier rules don't feel later ones.
        assert_eq!(plants[..trees.len()], trees);
    }
}

#[test]
fn the_smaller_of_a_rule_give_way_to_the_larger() {
    let ground = level(300.0);
    let all = rule(OAK, dense(2.0));
    let all = Rule { scale: [0.2, 1.6], ..all };
    let thinned =
        Places::Scatter(Scatter { rivalry: Rivalry::Size, spacing: 2.0, density: Scatter::densest(2.0) });
    let before = plant(std::slice::from_ref(&all), &ground);
    let after = plant(&[Rule { places: thinned, ..all }], &ground);
    let places: HashMap<[u32; 2], usize> = after
        .iter()
        .enumerate()
        .map(|(index, plant)| (at(plant).to_array().map(f32::to_bits), index))
        .collect();
    assert!(after.len() < before.len() / 2 && after.len() > 300, "{} of {}", after.len(), before.len());
    let shaded = |plant: &Instance| {
        after.iter().any(|other| {
            other.scale > plant.scale && at(other).distance(at(plant)) < kinds()[OAK].crown * other.scale
        })
    };
    for plant in &before {
        let lives = places.contains_key(&at(plant).to_array().map(f32::to_bits));
        assert_eq!(lives, !shaded(plant), "at {}", plant.position);
    }
}

// Cover --------------------------------------------------------------------------------------------------------------

fn cover(density: f32, near: f32, reach: f32) -> Rule {
    Rule { shade: 1.0, ..rule(GRASS, Places::Cover(Cover { density, near, reach })) }
}

#[test]
fn cover_thins_out_with_the_square_of_the_distance() {
    let rule = Rule { scale: [0.5, 1.5], ..cover(20.0, 6.0, 60.0) };
    let ground = level(200.0);
    // From above everything is in the picture.
    let camera = Pinhole {
        eye: vec3(1.0, 10.5, 2.0),
        tangent: [1e4; 2],
        ..Pinhole::look_along(Vec3::ZERO, Vec3::NEG_Y, 1.0, 1.0)
    };
    let plants = plant_seen(&[rule], &ground, &camera);
    let mut last_size = 0.0;
    for (inner, outer) in [(0.0, 6.0), (10.0, 12.0), (20.0, 24.0), (35.0, 45.0)] {
        let ring: Vec<&Instance> = plants
            .iter()
            .filter(|plant| (inner..outer).contains(&plant.position.distance(camera.eye)))
            .collect();
        let share = |distance: f64| if distance < 6.0 { 1.0 } else { 36.0 / (distance * distance) };
        let steps = 1000;
        let expected: f64 = (0..steps)
            .map(|step| {
                let width = f64::from(outer - inner) / f64::from(steps);
                let distance = f64::from(inner) + (f64::from(step) + 0.5) * width;
                20.0 * share(distance) * 2.0 * std::f64::consts::PI * distance * width
            })
            .sum();
        // The eye stands half a metre up: rings on the ground are a little narrower.
        assert_count(ring.len(), expected);
        let size = ring.iter().map(|plant| plant.scale).sum::<f32>() / ring.len() as f32;
        assert!(size > last_size, "plants seen from afar are larger: {size} after {last_size}");
        last_size = size;
    }
    assert!(plants.iter().all(|plant| plant.position.distance(camera.eye) < 60.0));
}

#[test]
fn cover_stands_where_it_stands_whatever_the_camera_does() {
    let ground = ground(65, 200.0, |at| 10.0 + (at.x / 9.0).sin());
    let site = Site { patches: Some(Patches::new(5, 4.0, 0.6)), ..Site::default() };
    let rule = on(site, Rule { scale: [0.5, 1.5], ..cover(12.0, 8.0, 50.0) });
    let key = |plant: &Instance| at(plant).to_array().map(f32::to_bits);
    let cameras = [camera(vec2(0.0, 0.0)), camera(vec2(1.7, -3.0)), camera(vec2(-20.0, 11.0)), {
        Pinhole::look_at(vec3(0.0, 12.0, 0.0), vec3(5.0, 10.0, -9.0), 1.2, 1.0)
    }];
    let seen: Vec<HashMap<[u32; 2], Instance>> = cameras
        .iter()
        .map(|camera| {
            let plants = plant_seen(std::slice::from_ref(&rule), &ground, camera);
            plants.into_iter().map(|plant| (key(&plant), plant)).collect()
        })
        .collect();
    for (one, plants) in cameras.iter().zip(&seen) {
        for (other, others) in cameras.iter().zip(&seen) {
            let mut shared = 0;
            for (key, plant) in plants {
                let distance = plant.position.distance(other.eye);
                let in_picture = other
                    .project(plant.position)
                    .is_some_and(|[x, y]| (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y));
                // What one camera sees, another that sees all at that place sees alike.
                match others.get(key) {
                    Some(same) => assert_eq!(same, plant),
                    None => assert!(
                        distance >= 8.0 || !in_picture,
                        "{} is missing from {}",
                        plant.position,
                        other.eye
                    ),
                }
                shared += usize::from(others.contains_key(key));
            }
            assert!(shared > 100 || one.eye.distance(other.eye) > 10.0, "{shared} shared");
        }
    }
}

/// What the window does: trees stand, and cover is planted for one camera after the other.
#[test]
fn cover_follows_a_camera_round_what_stands() {
    let ground = level(400.0);
    let kinds = kinds();
    let carried = planting::Grid {
        offset: vec2(0.0, -14.0),
        cells: [5, 2],
        cell_size: 5.0,
        probability: 0.7,
        jitter: 0.5,
    };
    let (shrubs, grass) = (rule(SHRUB, Places::Grid(carried)), cover(2.0, 10.0, 60.0));
    let rules = [rule(OAK, dense(9.0)), shrubs, grass, rule(OAK, dense(40.0))];
    let nowhere = camera(vec2(1e4, 0.0));
    let mut planter = Planter::new(&rules, &kinds, &ground, &nowhere);
    while !planter.asks_camera() && planter.step().unwrap() {}
    assert_eq!(planter.progress(), (1, 4));
    let standing = planter.into_standing();
    for eye in [vec2(0.0, 0.0), vec2(30.0, -20.0)] {
        let camera = camera(eye);
        let finish = |mut planter: Planter| {
            while planter.step().unwrap() {}
            planter.into_instances()
        };
        let planter = || Planter::new(&rules, &kinds, &ground, &camera).after(standing.clone());
        let seen = finish(planter());
        assert_eq!(seen, plant_seen(&rules, &ground, &camera), "as if all had been planted for it");
        // On all sides there is more of it, and it is the same where the camera looks.
        let round = finish(planter().all_round());
        let grass = |plants: &[Instance]| -> Vec<Vec3> {
            plants.iter().filter(|plant| kind_of(plant) == GRASS).map(|plant| plant.position).collect()
        };
        let (all, ahead) = (grass(&round), grass(&seen));
        assert!(all.len() > 2 * ahead.len(), "{} all round, {} ahead", all.len(), ahead.len());
        assert!(ahead.iter().all(|plant| all.contains(plant)));
        let behind = all.iter().filter(|plant| (**plant - camera.eye).dot(camera.forward) < -20.0).count();
        assert!(behind > 100, "{behind} behind the camera");
    }
}

#[test]
fn cover_fills_the_picture_to_its_edges() {
    let ground = level(300.0);
    let rule = cover(6.0, 60.0, 100.0);
    let camera = camera(Vec2::ZERO);
    let plants = plant_seen(std::slice::from_ref(&rule), &ground, &camera);
    // Squares of 3 m that lie in the picture hold 54 plants each.
    let mut counts = HashMap::<[i32; 2], usize>::new();
    for plant in &plants {
        *counts.entry((at(plant) / 3.0).floor().to_array().map(|at| at as i32)).or_default() += 1;
    }
    let mut full = 0;
    for column in -14..14 {
        for row in -16..-1 {
            let inside = |east: f32, south: f32| {
                let corner = vec3((column as f32 + east) * 3.0, 10.0, (row as f32 + south) * 3.0);
                corner.length() < 55.0
                    && camera
                        .project(corner)
                        .is_some_and(|[x, y]| (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y))
            };
            if inside(0.0, 0.0) && inside(1.0, 0.0) && inside(0.0, 1.0) && inside(1.0, 1.0) {
                assert_count(counts.get(&[column, row]).copied().unwrap_or(0), 54.0);
                full += 1;
            }
        }
    }
    assert!(full > 100, "{full} squares");
    // Nothing is missing of what is in the picture.
    let all_round = Pinhole { tangent: [1e4; 2], ..camera };
    let places: HashSet<[u32; 2]> =
        plants.iter().map(|plant| at(plant).to_array().map(f32::to_bits)).collect();
    for plant in plant_seen(&[rule], &ground, &all_round) {
        let place = camera.project(plant.position);
        if place.is_some_and(|[x, y]| (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y)) {
            assert!(
                places.contains(&at(&plant).to_array().map(f32::to_bits)),
                "{} is missing",
                plant.position
            );
        }
    }
    // Nothing far behind the eye.
    assert!(plants.iter().all(|plant| plant.position.z < 3.0));
}

// The grid -----------------------------------------------------------------------------------------------------------

#[test]
fn the_grid_goes_with_the_camera() {
    let grid = planting::Grid {
        offset: vec2(10.0, -20.0),
        cells: [4, 3],
        cell_size: 6.0,
        probability: 1.0,
        jitter: 0.5,
    };
    let rule = rule(OAK, Places::Grid(grid));
    let ground = level(400.0);
    let plants = plant_seen(std::slice::from_ref(&rule), &ground, &camera(vec2(50.0, 30.0)));
    assert_eq!(plants.len(), 12);
    let middle = vec2(60.0, 10.0);
    for (index, plant) in plants.iter().enumerate() {
        let cell = vec2((index % 4) as f32 - 1.5, (index / 4) as f32 - 1.0);
        let from_cell = at(plant) - middle - cell * 6.0;
        assert!(
            from_cell.abs().max_element() <= 1.5,
            "{} is {from_cell} from its cell's middle",
            plant.position
        );
    }
    let moved = plant_seen(std::slice::from_ref(&rule), &ground, &camera(vec2(-50.0, 0.0)));
    for (one, other) in plants.iter().zip(&moved) {
        assert!((at(one) - at(other)).distance(vec2(100.0, 30.0)) < 1e-3);
    }
    let half = planting::Grid { cells: [60, 60], cell_size: 3.0, probability: 0.5, ..grid };
    assert_count(plant(&[Rule { places: Places::Grid(half), ..rule }], &ground).len(), 1800.0);
}

/// A grid much larger than the terrain, at a corner of it: cells without ground cost nothing, and the others have the plants
/// that they have anyway.
#[test]
fn the_grid_ends_where_the_terrain_does() {
    let cells = [10_000, 9_999];
    let grid =
        planting::Grid { offset: vec2(81.5, -92.0), cells, cell_size: 1.0, probability: 1.0, jitter: 1.0 };
    let rule = rule(OAK, Places::Grid(grid));
    let ground = level(200.0);
    let found = plant(std::slice::from_ref(&rule), &ground);
    // One a cell, wherever in it.
    assert_count(found.len(), 40_000.0);
    assert!(rule.predict(&ground) < 41_000.0, "{}", rule.predict(&ground));
    // To the edges of the terrain, on all sides of which there is more of the grid.
    for axis in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
        let along = |plant: &Instance| at(plant).dot(axis);
        assert!(found.iter().all(|plant| along(plant) <= 100.0));
        assert_count(found.iter().filter(|plant| along(plant) > 99.5).count(), 100.0);
    }
    // Without a size all cells are one place.
    let none = planting::Grid { offset: Vec2::ZERO, cells: [7, 5], cell_size: 0.0, ..grid };
    assert_eq!(plant(&[Rule { places: Places::Grid(none), ..rule }], &ground).len(), 35);
}

// Sameness and limits ------------------------------------------------------------------------------------------------

fn everything() -> Vec<Rule> {
    let patches = Site { patches: Some(Patches::new(3, 30.0, 0.5)), ..Site::default() };
    let rivals =
        Places::Scatter(Scatter { rivalry: Rivalry::Size, spacing: 4.0, density: Scatter::densest(4.0) });
    let shrubs = Rule { shade: 0.4, scale: [0.4, 1.6], seed: 3, ..rule(SHRUB, rivals) };
    let grid = planting::Grid {
        offset: vec2(9.0, 4.0),
        cells: [40, 30],
        cell_size: 7.0,
        probability: 0.7,
        jitter: 0.8,
    };
    let grid = Rule { shade: 0.5, scale: [0.3, 1.0], ..rule(SHRUB, Places::Grid(grid)) };
    vec![rule(OAK, dense(9.0)), on(patches, shrubs), grid, cover(8.0, 10.0, 80.0)]
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let ground = rough();
    let on_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            plant_seen(&everything(), &ground, &Pinhole::look_at(vec3(0.0, 9.0, 9.0), Vec3::ZERO, 1.0, 1.5))
        })
    };
    let one = on_threads(1);
    assert!(one.len() > 3000, "{}", one.len());
    for threads in [2, 3, 7] {
        assert_eq!(on_threads(threads), one, "{threads} threads");
    }
}

#[test]
fn a_larger_terrain_has_the_same_plants_inside() {
    // Places belong to the world, not to the rectangle that is worked on.
    let rule = rule(OAK, scatter(5.0, 0.01));
    let inner = |plants: Vec<Instance>| -> Vec<[u32; 2]> {
        let inside = plants.into_iter().filter(|plant| at(plant).abs().max_element() < 60.0);
        let mut keys: Vec<[u32; 2]> =
            inside.map(|plant| at(&plant).to_array().map(|x| (x * 100.0).round().to_bits())).collect();
        keys.sort_unstable();
        keys
    };
    let small = inner(plant(std::slice::from_ref(&rule), &level(400.0)));
    let large = inner(plant(&[rule], &level(500.0)));
    assert!(small.len() > 100);
    assert_eq!(small, large);
}

#[test]
fn another_seed_gives_other_plants_and_another_rule_does_not() {
    let ground = level(200.0);
    let oaks = rule(OAK, dense(9.0));
    let first = plant(std::slice::from_ref(&oaks), &ground);
    assert_ne!(plant(&[Rule { seed: 8, ..oaks.clone() }], &ground), first);
    let both = plant(&[oaks, cover(2.0, 5.0, 9.0)], &ground);
    assert_eq!(both[..first.len()], first);
}

#[test]
fn too_many_are_refused_before_they_are_planted() {
    let ground = level(1e5);
    let kinds = kinds();
    let camera = camera(Vec2::ZERO);
    let refused = |places| {
        let rules = [rule(OAK, dense(5000.0)), rule(OAK, places)];
        let mut planter = Planter::new(&rules, &kinds, &ground, &camera);
        assert_eq!(planter.step(), Ok(true));
        let error = planter.step().unwrap_err();
        // What was planted before is kept.
        assert!(planter.into_instances().len() > 200);
        error
    };
    // 10¹⁰ m².
    let Error::TooMany { rule, count, most } = refused(scatter(1.0, 0.5)) else { panic!("another error") };
    assert_eq!((rule.as_str(), most), ("plants.0", 10_000_000));
    assert!((4_990_000_000..5_010_000_000).contains(&count), "{count}");
    let too_many = [
        Places::Cover(Cover { density: 1e4, near: 1e4, reach: 1e5 }),
        Places::Grid(planting::Grid {
            offset: Vec2::ZERO,
            cells: [10_000; 2],
            cell_size: 1.0,
            probability: 1.0,
            jitter: 0.0,
        }),
    ];
    for places in too_many {
        let error = refused(places);
        assert!(matches!(error, Error::TooMany { .. }), "{error}");
    }
    // What stands already counts, too.
    let rules = [rule_of(dense(5000.0))];
    let mut planter = Planter::new(&rules, &kinds, &ground, &camera).beside(10_000_000);
    assert!(matches!(planter.step(), Err(Error::TooMany { count: 10_000_001.., .. })));
    // A narrow site asks for few plants and yet for places everywhere.
    let narrow = Site { patches: Some(Patches::new(1, 1e4, 0.0)), ..Site::default() };
    // So does cover that thins out at once.
    let sparse = Places::Cover(Cover { density: 1e4, near: 0.1, reach: 1e5 });
    for rule in [on(narrow, rule_of(scatter(1.0, 0.1))), rule_of(sparse)] {
        let error = Planter::new(&[rule], &kinds, &ground, &camera).step().unwrap_err();
        assert!(matches!(error, Error::TooFine { cells: 1_000_000_000.., .. }), "{error}");
    }
}

fn rule_of(places: Places) -> Rule {
    rule(OAK, places)
}

/// What is predicted is what comes of it.
#[test]
fn numbers_are_predicted() {
    let ground = rough();
    for rule in [
        rule(OAK, dense(3.0)),
        on(Site { slope: Ramp::new(&[0.8, 0.2]), ..Site::default() }, rule(OAK, scatter(4.0, 0.01))),
    ] {
        let count = plant(std::slice::from_ref(&rule), &ground).len() as f64;
        let predicted = rule.predict(&ground);
        assert!(
            (count - predicted).abs() < 4.0 * predicted.sqrt() + 0.02 * predicted,
            "{count} of {predicted}"
        );
    }
}
