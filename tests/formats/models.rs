//! Models and scenes that leave as files and come back, and files of other makes.

use crate::kit;
use crate::kit::forest::{self, Random};
use glam::{EulerRot, Quat, Vec3};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;
use std::sync::Arc;
use tempfile::TempDir;
use terrane::core::camera::Pinhole;
use terrane::core::mesh::Mesh;
use terrane::formats::gltf::{Contents, Land, MOST_NODES, Options, Places, Sea, write_scene};
use terrane::formats::model::{self, Import};
use terrane::formats::png;
use terrane::scene::{self, Instance, Level, Material, Model, Part, Population, Sun};

// A model, out and in.

#[test]
fn a_model_comes_back_from_gltf_exactly_as_it_was() {
    let folder = folder();
    let path = folder.path().join("tree.glb");
    let tree = tree();
    let written = model::write(&path, &tree).unwrap();
    let import = model::read(&path).unwrap();
    assert_eq!(import.warnings, [""; 0]);
    assert_eq!(*import.population.models, [Arc::new(tree.clone())]);
    assert_eq!(import.merged(&path).unwrap(), import.population.models[0]);
    let [only] = &import.population.instances[..] else { panic!() };
    assert_eq!((only.model, only.position, only.rotation, only.scale), (0, Vec3::ZERO, Quat::IDENTITY, 1.0));

    let again = model::write(&folder.path().join("again.glb"), &tree).unwrap();
    assert_eq!(written[0].sha256, again[0].sha256);
}

#[test]
fn a_model_comes_back_from_obj_and_ply_as_its_finest_level() {
    let folder = folder();
    let tree = tree();
    let finest = &tree.levels[0];
    for name in ["tree.obj", "tree.ply"] {
        let path = folder.path().join(name);
        model::write(&path, &tree).unwrap();
        let Import { population, warnings, .. } = model::read(&path).unwrap();
        assert_eq!(warnings, [""; 0]);
        let [back] = &population.models[..] else { panic!() };
        assert_eq!((back.levels.len(), &*back.name), (1, "tree"));
        let parts = &back.levels[0].parts;
        assert_eq!(parts.len(), finest.parts.len());
        for (part, from) in parts.iter().zip(&finest.parts) {
            assert_same(&part.mesh, &from.mesh);
            let [got, want] = [(back, part), (&Arc::new(tree.clone()), from)]
                .map(|(model, part)| model.materials[part.material].mean_reflectance());
            // Colours of PLY have 8 bits.
            let within = if name == "tree.ply" { 0.005 } else { 1e-6 };
            assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() < within), "{got:?} {want:?}");
        }
    }
}

/// The same triangles, corner by corner.
#[track_caller]
/// For whoever places all of a file as one model: what stands in it stands as before.
#[test]
fn a_scene_as_one_model_has_everything_where_it_stands() {
    let folder = folder();
    let path = folder.path().join("wood.glb");
    let wood = wood(9);
    write(&path, &wood, Places::Nodes, 0);
    let import = model::read(&path).unwrap();
    let merged = import.merged(&path).unwrap();
    let bits = |point: Vec3| point.to_array().map(|along| (along * 1000.0).round() as i64);
    let mut got: Vec<[i64; 3]> = merged.levels[0]
        .parts
        .iter()
        .flat_map(|part| part.mesh.positions.iter().map(|point| bits(Vec3::from(*point))))
        .collect();
    let mut want = Vec::new();
    for Instance { model, position, rotation, scale, .. } in wood.instances.iter() {
        for part in &wood.models[*model as usize].levels[0].parts {
            let stand = |point: &[f32; 3]| bits(*position + *rotation * (*scale * Vec3::from(*point)));
            want.extend(part.mesh.positions.iter().map(stand));
        }
    }
    got.sort_unstable();
    want.sort_unstable();
    assert_eq!(got.len(), want.len());
    let far = |(one, other): (&[i64; 3], &[i64; 3])| one.iter().zip(other).any(|(a, b)| (a - b).abs() > 1);
    assert!(!got.iter().zip(&want).any(far));
}

/// What is up in a file may be its z.
#[test]
fn a_model_that_lies_is_stood_up() {
    let folder = folder();
    fs::write(folder.path().join("tip.obj"), "v 0 0 0\nv 2 0 0\nv 0 3 7\nvn 0 -1 0\nf 1//1 2//1 3//1\n")
        .unwrap();
    let text = "format = 1\nmodels = [{ file = \"tip.obj\", up = \"z\", at = [[0, 0]] }]\n";
    let overrides = terrane::world::Overrides::default();
    let world = terrane::world::parse("world.toml", text.as_bytes(), folder.path(), &overrides).unwrap();
    let mesh = &world.plants.models[0].levels[0].parts[0].mesh;
    // A plan's north, its y, is the world's: −z.
    assert_eq!(mesh.positions, [[0.0, 0.0, -0.0], [2.0, 0.0, -0.0], [0.0, 7.0, -3.0]]);
    assert_eq!(mesh.normals[0], [0.0, 0.0, 1.0]);
}

/// A `\` at the end of a line joins the next to it; lines are counted all the same. Comments end with their line.
#[test]
fn lines_of_obj_files_may_go_on() {
    let folder = folder();
    let path = folder.path().join("quad.obj");
    let read = |text: &str| {
        fs::write(&path, text).unwrap();
        model::read(&path)
    };
    let plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 3 4\n";
    let want = read(plain).unwrap().population.models;
    for text in [
        "v 0 0 \\\n0\nv 1\\\n 0 0\n# in C:\\\nv 1 1 0\nv 0 1 0\nf 1 2 \\\n3 \\\n4\nf 1 3 4",
        "v 0 0 \\\r\n0\r\nv 1\\ \r\n 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 3 4\\\r\n\r\nf 1 3 4\\",
    ] {
        let got = read(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(got.population.models, want, "{text}");
    }
    let error = read("v 0 0 \\\n0\nv 1\\\n0 0\nf 1 2 \\\n3\n").unwrap_err().to_string();
    assert!(error.contains("in line 5"), "{error}");
}

fn assert_same(got: &Mesh, want: &Mesh) {
    assert_eq!(got.triangles.len(), want.triangles.len());
    let corners = got.triangles.as_flattened().iter().zip(want.triangles.as_flattened());
    for (got_corner, want_corner) in corners.map(|(got, want)| (*got as usize, *want as usize)) {
        assert_eq!(got.positions[got_corner], want.positions[want_corner]);
        assert_eq!(got.normals[got_corner], want.normals[want_corner]);
        let [got, want] = [got.uvs[got_corner], want.uvs[want_corner]];
        assert!(got.iter().zip(want).all(|(got, want)| (got - want).abs() <= 1e-6), "{got:?} {want:?}");
    }
}

// A scene, out and in.

#[test]
fn a_scene_comes_back_as_it_was() {
    let folder = folder();
    let path = folder.path().join("scene.glb");
    let population = wood(2000);
    write(&path, &population, Places::Lists, 0);
    let Import { population: back, warnings, .. } = model::read(&path).unwrap();
    assert_eq!(warnings, [""; 0]);
    assert_eq!(back.models[..], population.models[..]);
    // In the order of their models.
    let mut expected = population.instances.to_vec();
    expected.sort_by_key(|instance| instance.model);
    assert!(back.instances[..] == expected[..]);

    // A node each: the same places, of one level.
    let path = folder.path().join("nodes.glb");
    write(&path, &population, Places::Nodes, 1);
    let Import { population: back, warnings, .. } = model::read(&path).unwrap();
    assert_eq!(warnings, [""; 0]);
    assert!(back.instances[..] == expected[..]);
    for (back, from) in back.models.iter().zip(&population.models) {
        // The coarsest of a model that has only one.
        let level = &from.levels[1.min(from.levels.len() - 1)];
        assert_eq!((&back.name, back.levels.len()), (&from.name, 1));
        assert_eq!(back.levels[0].parts.len(), level.parts.len());
        for (got, want) in back.levels[0].parts.iter().zip(&level.parts) {
            assert_eq!(got.mesh, want.mesh);
            assert_eq!(back.materials[got.material], from.materials[want.material]);
        }
    }
}

#[test]
fn a_program_of_another_make_finds_every_instance_sun_camera_land_and_sea() {
    let folder = folder();
    let (lists, nodes) = (folder.path().join("lists.glb"), folder.path().join("nodes.glb"));
    let population = wood(300);
    let irradiance = [90_000.0, 82_000.0, 70_000.0];
    let direction = Vec3::new(0.4, 0.6, -0.3).normalize();
    let sun = Sun { direction, irradiance, diameter: 0.009 };
    let camera = Pinhole::look_at(Vec3::new(10.0, 20.0, 30.0), Vec3::new(-5.0, 3.0, 2.0), 0.8, 1.5);
    let picture = png::encode_picture([2, 1], &[200, 100, 50, 0, 0, 0]).unwrap();
    let land = Land { mesh: quad(Vec3::ZERO, 200.0), picture: picture.clone() };
    let optics = scene::Sea {
        level: 2.0,
        attenuation: [0.3, 0.1, 0.05],
        deep_colour: [0.01, 0.04, 0.08],
        roughness: 0.1,
    };
    let sea = Sea::new(200.0, 2.0, &optics);
    let contents = Contents {
        population: &population,
        land: Some(&land),
        sea: Some(&sea),
        sun: Some(&sun),
        camera: Some(&camera),
    };
    for (path, places) in [(&lists, Places::Lists), (&nodes, Places::Nodes)] {
        write_scene(path, &contents, Options { places, finest: 0 }).unwrap();
    }
    // What is ours alone comes back, and what a world has itself does not.
    let Import { population: back, warnings, .. } = model::read(&lists).unwrap();
    assert_eq!(back.instances.len(), population.instances.len());
    assert!(matches!(&warnings[..], [warning] if warning.contains("land and sea")), "{warnings:?}");

    // The crate checks the whole file against the schema, but for extensions that it doesn't know.
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&fs::read(&nodes).unwrap()).unwrap();
    let scene = document.default_scene().unwrap();
    let count = scene.nodes().filter(|node| node.extras().is_some() && node.mesh().is_some()).count();
    assert_eq!(count, population.instances.len() + 2);
    let find = |name: &str| scene.nodes().find(|node| node.name() == Some(name)).unwrap();
    let turned = |node: &gltf::Node, vector: Vec3| {
        let (_, rotation, _) = node.transform().decomposed();
        Quat::from_array(rotation) * vector
    };
    let near = |got: Vec3, want: Vec3| assert!(got.distance(want) < 1e-5, "{got} {want}");
    let node = find("sun");
    near(turned(&node, Vec3::NEG_Z), -direction);
    let light = node.light().unwrap();
    let strength = Vec3::from(light.color()) * light.intensity();
    assert!(strength.distance(irradiance.into()) < 0.1, "{strength}");
    assert!(light.color().iter().all(|channel| (0.0..=1.0).contains(channel)));
    let node = find("camera");
    near(turned(&node, Vec3::NEG_Z), camera.forward);
    near(turned(&node, Vec3::Y), camera.up);
    let (eye, _, _) = node.transform().decomposed();
    assert_eq!(Vec3::from(eye), camera.eye);
    let lens = node.camera().unwrap();
    let gltf::camera::Projection::Perspective(lens) = lens.projection() else { panic!() };
    assert!((lens.yfov() - 0.8).abs() < 1e-5 && (lens.aspect_ratio().unwrap() - 1.5).abs() < 1e-5);
    let material = find("land").mesh().unwrap().primitives().next().unwrap().material();
    let texture = material.pbr_metallic_roughness().base_color_texture().unwrap().texture();
    let gltf::image::Source::View { view, mime_type } = texture.source().source() else { panic!() };
    assert_eq!(mime_type, "image/png");
    assert_eq!(blob.unwrap()[view.offset()..][..view.length()], picture);
    let surface = find("sea").mesh().unwrap();
    let bounds = surface.primitives().next().unwrap().bounding_box();
    assert_eq!((bounds.min, bounds.max), ([-100.0, 2.0, -100.0], [100.0, 2.0, 100.0]));

    // The lists, by the words of the extension's schema.
    let bytes = fs::read(&lists).unwrap();
    let file = gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
    let json: Value = serde_json::from_slice(&bytes[20..][..u32_at(&bytes, 12) as usize]).unwrap();
    assert_eq!(json["extensionsRequired"], serde_json::json!(["EXT_mesh_gpu_instancing"]));
    let floats = |index: &Value, count: usize| -> Vec<f32> {
        let accessor = file.accessors().nth(index.as_u64().unwrap() as usize).unwrap();
        assert_eq!(accessor.data_type(), gltf::accessor::DataType::F32);
        assert_eq!(accessor.dimensions().multiplicity(), count);
        let view = accessor.view().unwrap();
        let bytes = &file.blob.as_ref().unwrap()[view.offset()..][..accessor.count() * 4 * count];
        bytes.chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
    };
    let roots = json["scenes"][0]["nodes"].as_array().unwrap();
    let mut found = 0;
    for (model, of_model) in population.models.iter().enumerate() {
        let node = roots.iter().map(|root| &json["nodes"][root.as_u64().unwrap() as usize]);
        let node = node.clone().find(|node| node["name"] == *of_model.name).unwrap();
        let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        let [places, turns, scales] = [("TRANSLATION", 3), ("ROTATION", 4), ("SCALE", 3)]
            .map(|(name, count)| floats(&attributes[name], count));
        let own: Vec<&Instance> =
            population.instances.iter().filter(|instance| instance.model as usize == model).collect();
        assert_eq!(places.len(), 3 * own.len());
        for (index, instance) in own.iter().enumerate() {
            assert_eq!(places[3 * index..][..3], instance.position.to_array());
            assert_eq!(turns[4 * index..][..4], instance.rotation.to_array());
            assert_eq!(scales[3 * index..][..3], [instance.scale; 3]);
        }
        found += own.len();
        // Coarser levels stand outside of the scene, at the same places.
        for (number, id) in (1..).zip(node["extensions"]["MSFT_lod"]["ids"].as_array().unwrap_or(&vec![])) {
            let level = &json["nodes"][id.as_u64().unwrap() as usize];
            assert_eq!(level["name"], format!("{}_lod{number}", of_model.name));
            assert_eq!(level["extensions"]["EXT_mesh_gpu_instancing"]["attributes"], *attributes);
            assert!(!roots.contains(id));
        }
    }
    assert_eq!(found, population.instances.len());
}

/// A program without the extension is not given a file that it can't hold.
#[test]
fn too_many_nodes_are_refused() {
    let folder = folder();
    let path = folder.path().join("nodes.glb");
    let quad = Level { detail: 0.0, parts: vec![Part { material: 0, mesh: quad(Vec3::ZERO, 1.0) }] };
    let model = Model { name: "leaf".into(), materials: vec![forest::leaf()], levels: vec![quad] };
    let places = |count: usize| (0..count).map(|index| Vec3::X * index as f32);
    let most = forest::standing(model.clone(), places(MOST_NODES));
    write(&path, &most, Places::Nodes, 0);
    assert_eq!(model::read(&path).unwrap().population.instances.len(), MOST_NODES);
    let more = forest::standing(model, places(MOST_NODES + 1));
    let contents = Contents { population: &more, land: None, sea: None, sun: None, camera: None };
    let error = write_scene(&path, &contents, Options { places: Places::Nodes, finest: 0 }).unwrap_err();
    assert!(error.to_string().contains("100,000"), "{error}");
    write(&path, &more, Places::Lists, 0);
}

/// The acceptance of the whole way: a world is drawn, what stands on it is exported, and another world that takes that file
/// in draws the same picture.
#[test]
fn an_exported_world_that_comes_back_is_the_same_picture() {
    let folder = folder();
    fs::write(folder.path().join("quad.obj"), "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3 4\n").unwrap();
    fs::write(folder.path().join("planted.toml"), format!("{LAND}{PLANTED}")).unwrap();
    let file = |name: &str| format!("{LAND}\n[[models]]\nfile = \"{name}\"\nat = \"file\"\n");
    fs::write(folder.path().join("plants_back.toml"), file("plants.glb")).unwrap();
    fs::write(folder.path().join("scene_back.toml"), file("scene.glb")).unwrap();
    fs::write(folder.path().join("bare.toml"), LAND).unwrap();
    run(folder.path(), "export planted.toml --layer plants -o plants.glb");
    run(folder.path(), "export planted.toml --layer scene -o scene.glb");
    let [planted, plants, scene, bare] = ["planted", "plants_back", "scene_back", "bare"].map(|world| {
        run(folder.path(), &format!("render {world}.toml --size 160x100 -o {world}.png"));
        image::open(folder.path().join(format!("{world}.png"))).unwrap().into_rgb8()
    });
    assert!(differing(&planted, &bare) > 1000, "nothing is seen of the plants");
    // Samples where two surfaces lie equally far off depend on the order of instances.
    assert!(differing(&planted, &plants) < 20, "{}", differing(&planted, &plants));
    assert!(differing(&planted, &scene) < 20, "{}", differing(&planted, &scene));

    let sidecar: Value =
        serde_json::from_slice(&fs::read(folder.path().join("scene.glb.json")).unwrap()).unwrap();
    let import = model::read(&folder.path().join("scene.glb")).unwrap().population;
    assert_eq!(sidecar["plants"], import.instances.len());
    assert_eq!(sidecar["models"], import.models.len());
}

const LAND: &str = r#"
format = 1
seed = 4
erosion = "none"
reef = "none"
sea.level = 0
[terrain]
cells = 65
extent = 200
layers = [{ simplex = { amplitude = 12, wavelength = 90, octaves = 3, offset = 3 } }]
[camera]
fov = 50
view = { look_at = { position = [0, 40, 110], target = [0, 0, 0] } }
"#;

const PLANTED: &str = r##"
[[models]]
file = "quad.obj"
name = "wall"
reflectance = "#c03020"
at = [[10, 5], [-20, 8, 90, 1.5]]

[species.stick]
grammar = """
axiom A
A -> F[&(50)F~L(1)][&(50)/(180)F~L(1)]F~L(1)
"""
steps = 1
width = 0.3
height = 9
variants = 2
[species.stick.organs.L]
polygons = [{ vertices = [[0, 0, 0], [0.5, 0.4, 0], [1, 0, 0], [0.5, -0.4, 0]] }]

[[plants]]
scatter = { species = ["stick", "wall"], shares = [20, 1], spacing = 4, scale = [0.5, 1.5] }
"##;

/// How many pixels are not the same.
fn differing(one: &image::RgbImage, other: &image::RgbImage) -> usize {
    one.pixels().zip(other.pixels()).filter(|(one, other)| one != other).count()
}

// Models of a world.

/// One that is given no place is one model, which is hardly meant.
#[test]
fn an_exported_scene_without_a_place_is_answered_with_how_to_put_it_back() {
    let folder = folder();
    let check = |models: &str| {
        fs::write(folder.path().join("world.toml"), format!("{LAND}\n[[models]]\n{models}\n")).unwrap();
        let output = program(folder.path(), "check world.toml --no-time");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    write(&folder.path().join("scene.glb"), &wood(3), Places::Lists, 0);
    let hint = "`at = \"file\"` puts all that `terrane export` wrote back where it stood";
    let (code, told) = check("file = \"scene.glb\"");
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains(&format!("`models.0`: \"scene.glb\" is a whole scene; {hint}")), "{told}");
    for meant in ["file = \"scene.glb\"\nat = \"file\"", "file = \"scene.glb\"\nat = [[0, 0]]"] {
        let (code, told) = check(meant);
        assert_eq!(code, Some(0), "{told}");
        assert!(!told.contains(hint), "{told}");
    }
    // A scene of another program may well be a model.
    let mut strange = fs::read(folder.path().join("scene.glb")).unwrap();
    let at = strange.windows(8).position(|word| word == b"terrane ").unwrap();
    strange[at..at + 8].copy_from_slice(b"another ");
    fs::write(folder.path().join("strange.glb"), strange).unwrap();
    let (code, told) = check("file = \"strange.glb\"");
    assert_eq!(code, Some(0), "{told}");
    assert!(!told.contains(hint), "{told}");
    // A plant of ours is a model.
    model::write(&folder.path().join("tree.glb"), &tree()).unwrap();
    let (_, told) = check("file = \"tree.glb\"");
    assert!(told.contains("stands nowhere") && !told.contains(hint), "{told}");
    // As one model it would be too large.
    write(&folder.path().join("scene.glb"), &wood(200_000), Places::Lists, 0);
    let (code, told) = check("file = \"scene.glb\"");
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("takes more than") && told.contains(&format!("help: {hint}")), "{told}");
}

#[test]
fn models_stand_on_the_ground_where_the_world_says() {
    let folder = folder();
    // A block of 2 × 4 × 2 whose middle is the origin.
    let block = "v -1 -2 -1\nv 1 -2 -1\nv 1 -2 1\nv -1 -2 1\nv -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\n\
                 f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    fs::write(folder.path().join("block.obj"), block).unwrap();
    let land = "format = 1\nerosion = \"none\"\nreef = \"none\"\nsea.level = -50\nterrain = { cells = 65, extent = 640, layers = [{ cone = { height \
                = 100, radius = 300, exponent = 1 } }] }\n";
    let models = r#"
        [[models]]
        file = "block.obj"
        height = 8
        origin = "base"
        at = [[0, 100], [50, 0, 90, 2]]
        [[models]]
        file = "block.obj"
        name = "as_it_is"
        up = "z"
        scale = 0.5
        at = [[-200, 10, -30]]
    "#;
    fs::write(folder.path().join("world.toml"), format!("{land}{models}")).unwrap();
    run(folder.path(), "export world.toml --layer plants -o plants.glb");
    let Population { models, instances } = model::read(&folder.path().join("plants.glb")).unwrap().population;
    assert_eq!(models.iter().map(|model| &*model.name).collect::<Vec<_>>(), ["block", "as_it_is"]);
    // Twice as large, its base at the origin; lying down and half as large.
    assert_eq!(models[0].bounds(), [Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 8.0, 2.0)]);
    assert_eq!(models[1].bounds(), [Vec3::new(-0.5, -0.5, -1.0), Vec3::new(0.5, 0.5, 1.0)]);
    // A straight cone falls by a third of a metre a metre: the foot's lower rim is in the ground, and a little more.
    let slope: f32 = 100.0 / 300.0;
    for (instance, (x, z, turn, scale, foot)) in instances.iter().zip([
        (0.0, 100.0, 0.0, 1.0, 8_f32.sqrt()),
        (50.0, 0.0, 90.0, 2.0, 2.0 * 8_f32.sqrt()),
        (-200.0, 10.0, -30.0, 1.0, 0.0),
    ]) {
        let Instance { position, rotation, scale: got, .. } = *instance;
        assert_eq!((position.x, position.z, got), (x, z, scale));
        let ground = 100.0 - slope * f32::hypot(x, z);
        let depth = ground - position.y;
        if foot > 0.0 {
            assert!((depth - slope * foot).abs() < 0.6, "{depth} {}", slope * foot);
        }
        // Clockwise from above: north turns to the east.
        let north = rotation * Vec3::NEG_Z;
        let (sin, cos) = f32::to_radians(turn).sin_cos();
        assert!(north.distance(Vec3::new(sin, 0.0, -cos)) < 1e-5, "{north}");
    }
}

#[test]
fn what_is_wrong_with_models_is_said_with_its_place() {
    let folder = folder();
    fs::write(folder.path().join("rock.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("a rock.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("rock.stl"), "solid").unwrap();
    fs::write(folder.path().join("points.ply"), PLY_OF_POINTS).unwrap();
    let wrong = |text: &str, code: i32, parts: &[&str]| {
        fs::write(folder.path().join("world.toml"), format!("format = 1\n{text}\n")).unwrap();
        let output = program(folder.path(), "check world.toml --no-time");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{text}: {message}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{text}: {message}"));
    };
    wrong("models = [{ name = \"x\" }]", 3, &["models.0.file", "is missing"]);
    wrong("models = [{ file = \"none.glb\" }]", 7, &["models.0.file", "none.glb", "check the spelling"]);
    wrong("models = [{ file = \"rock.stl\" }]", 3, &[".glb, .gltf, .obj or .ply"]);
    wrong("models = [{ file = \"points.ply\" }]", 3, &["no faces"]);
    wrong("models = [{ file = \"a rock.obj\" }]", 3, &["a rock", "letters, digits"]);
    wrong(
        "models = [{ file = \"rock.obj\" }, { file = \"rock.obj\" }]",
        3,
        &["models.1", "name of two things"],
    );
    wrong(
        "models = [{ file = \"rock.obj\", scale = 2, height = 3 }]",
        3,
        &["models.0.scale", "beside `height`"],
    );
    wrong(
        "models = [{ file = \"rock.obj\", at = [[1e5, 0]] }]",
        3,
        &["models.0.at.0", "outside the terrain"],
    );
    wrong("models = [{ file = \"rock.obj\", at = [[1]] }]", 3, &["models.0.at.0"]);
    wrong("models = [{ file = \"rock.obj\", at = [[1, 2, 3, 0]] }]", 3, &["has no size"]);
    wrong(
        "models = [{ file = \"rock.obj\", at = \"file\", name = \"x\" }]",
        3,
        &["models.0.name", "no use here"],
    );
    let planted = |name: &str| {
        format!(
            "models = [{{ file = \"rock.obj\" }}]\nplants = [{{ scatter = {{ species = [\"{name}\"], spacing = 500 }} }}]"
        )
    };
    wrong(&planted("rokc"), 3, &["did you mean `rock`?"]);
    wrong(&planted("rock"), 0, &[]);
    wrong("models = [{ file = \"rock.obj\" }]", 0, &["stands nowhere"]);
}

const PLY_OF_POINTS: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";

// Running and writing.

fn write(path: &Path, population: &Population, places: Places, finest: usize) {
    let contents = Contents { population, land: None, sea: None, sun: None, camera: None };
    write_scene(path, &contents, Options { places, finest }).unwrap();
}

#[track_caller]
fn run(folder: &Path, arguments: &str) {
    let output = program(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
}

fn program(folder: &Path, arguments: &str) -> Output {
    let _turn = kit::turn();
    kit::program::terrane(folder, &arguments.split(' ').collect::<Vec<_>>())
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

// Made-up models.

/// Trees and tufts that stand all ways.
fn wood(count: usize) -> Population {
    let models = [forest::tree(1, 9.0, 60), forest::tuft(2, 0.4, 9), tree()].map(Arc::new).to_vec();
    let mut random = Random(5);
    let instance = |index| Instance {
        model: (random.unit() * 3.0) as u32,
        random: 0x8000_0000_u32.wrapping_mul(index).wrapping_add(index),
        position: 300.0 * random.direction(),
        rotation: Quat::from_euler(EulerRot::XYZ, random.unit(), 6.0 * random.unit(), random.unit())
            .normalize(),
        scale: random.between(0.2, 4.0),
    };
    Population { models, instances: (0..count as u32).map(instance).collect() }
}

/// A trunk with leaves, in two levels.
fn tree() -> Model {
    let bark = Material {
        name: "bark".into(),
        reflectance: [[0.12, 0.08, 0.05], [0.31, 0.22, 0.17]],
        position_factor: 7.5,
        value_factor: 0.8,
        roughness: 0.9,
        ..Material::default()
    };
    let leaf = Material {
        name: "leaf".into(),
        reflectance: [[0.05, 0.1, 0.02]; 2],
        transmittance: [0.04, 0.09, 0.01],
        refractive_index: 1.4,
        roughness: 0.35,
        ..Material::default()
    };
    let level = |detail, sides: u32| {
        let trunk = cylinder(sides, 0.2, 3.0);
        let leaves = quad(Vec3::new(0.0, 3.0, 0.0), 1.5);
        let parts = vec![Part { material: 0, mesh: trunk }, Part { material: 1, mesh: leaves }];
        Level { detail, parts }
    };
    Model { name: "tree".into(), materials: vec![bark, leaf], levels: vec![level(0.0, 9), level(0.3, 4)] }
}

/// An upright tube without ends.
fn cylinder(sides: u32, radius: f32, height: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for side in 0..=sides {
        let share = side as f32 / sides as f32;
        let (sin, cos) = (share * std::f32::consts::TAU).sin_cos();
        for (row, v) in [(0.0, 1.0), (height, 0.0)] {
            mesh.positions.push([radius * cos, row, -radius * sin]);
            mesh.normals.push([cos, 0.0, -sin]);
            mesh.uvs.push([share, v]);
        }
    }
    for side in 0..sides {
        let at = 2 * side;
        mesh.triangles.extend([[at, at + 2, at + 1], [at + 1, at + 2, at + 3]]);
    }
    mesh
}

/// A level square that looks up.
fn quad(middle: Vec3, size: f32) -> Mesh {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let place = |[u, v]: [f32; 2]| (middle + size * Vec3::new(u - 0.5, 0.0, v - 0.5)).into();
    Mesh {
        positions: corners.map(place).into(),
        normals: vec![[0.0, 1.0, 0.0]; 4],
        uvs: corners.into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}
