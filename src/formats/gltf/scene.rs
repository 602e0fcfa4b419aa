//! Whole scenes: land and sea, all that stands there, the sun and the camera, as one file.

use super::document::*;
use super::write::{Builder, U16, push, raw};
use super::{add_level, add_model};
use crate::core::camera::Pinhole;
use crate::core::mesh::Mesh;
use crate::formats::Error;
use crate::formats::file::Written;
use crate::scene::{Instance, Level, Model, Population, Sun};
use glam::{Mat3, Quat, Vec3};
use std::path::Path;

/// What goes into the file of a scene.
#[derive(Clone, Copy)]
pub struct Contents<'a> {
    pub population: &'a Population,
    pub land: Option<&'a Land>,
    pub sea: Option<&'a Sea>,
    pub sun: Option<&'a Sun>,
    pub camera: Option<&'a Pinhole>,
}

/// The ground as a mesh with a picture over it.
#[derive(Clone, Debug)]
pub struct Land {
    pub mesh: Mesh,
    /// A PNG: what light the ground scatters back, in sRGB.
    pub picture: Vec<u8>,
}

/// The surface of the sea as a square.
#[derive(Clone, Debug)]
pub struct Sea {
    mesh: Mesh,
    color: [f32; 3],
    roughness: f32,
}

/// How a scene is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    pub places: Places,
    /// Index of the finest level of detail that is written, or the coarsest of models that have not so many.
    pub finest: usize,
}

/// How the places of a model's many instances are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// As lists, by the extension `EXT_mesh_gpu_instancing`.
    Lists,
    /// As a node each, which every program reads: [`MOST_NODES`] at most, of one level of detail.
    Nodes,
}

/// Most nodes for instances.
pub const MOST_NODES: usize = 100_000;

/// How much of what lies under it the sea hides.
const SEA_OPACITY: f32 = 0.8;

/// Nearest that the camera sees, metres.
const NEAR: f32 = 0.1;

/// Writes a scene. Every model is there once, with the places of its instances; those that nothing is an instance of are
/// left out.
///
/// # Errors
/// Those of [`write()`](super::write()), and for too many nodes.
pub fn write_scene(path: &Path, contents: &Contents, options: Options) -> Result<Written, Error> {
    let Contents { population, land, sea, sun, camera } = *contents;
    let Population { models, instances } = population;
    if options.places == Places::Nodes && instances.len() > MOST_NODES {
        let reason = "without EXT_mesh_gpu_instancing every plant is a node, and a file may have 100,000 of them; let it use \
                      the extension, or plant fewer";
        return Err(Error::Target { path: path.into(), reason });
    }
    let groups = groups(population);
    let mut builder = Builder::default();
    let mut roots = Vec::new();
    roots.extend(land.map(|land| add_land(&mut builder, land)));
    roots.extend(sea.map(|sea| add_sea(&mut builder, sea)));
    for (index, (model, group)) in models.iter().zip(&groups).enumerate() {
        if group.is_empty() || model.levels.is_empty() {
            continue;
        }
        let name = name(models, index);
        let levels = &model.levels[options.finest.min(model.levels.len() - 1)..];
        match options.places {
            Places::Lists => {
                builder.required_extension("EXT_mesh_gpu_instancing");
                let places = add_places(&mut builder, group, instances);
                roots.push(add_model(&mut builder, &name, model, levels, Vec::new(), Some(places)));
            }
            Places::Nodes => {
                roots.extend(add_nodes(&mut builder, &name, model, &levels[0], group, instances));
            }
        }
    }
    roots.extend(sun.map(|sun| add_sun(&mut builder, sun)));
    roots.extend(camera.map(|camera| add_camera(&mut builder, camera)));
    builder.write(path, roots)
}

impl Sea {
    /// The sea over land whose side is `extent`, at `level`, both metres.
    pub fn new(extent: f32, level: f32, optics: &crate::scene::Sea) -> Self {
        let half = extent / 2.0;
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0_f32]];
        let mesh = Mesh {
            positions: corners.map(|[u, v]| [u * extent - half, level, v * extent - half]).into(),
            normals: vec![[0.0, 1.0, 0.0]; 4],
            uvs: corners.into(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        // The roughness of the format's surfaces is the root of the slopes' spread (glTF 2.0, appendix B.3.2: α = roughness²,
        // and α² is twice the slopes' variance).
        let roughness = (2.0_f32.sqrt() * optics.roughness).sqrt().min(1.0);
        Sea { mesh, color: optics.deep_colour, roughness }
    }
}

/// Instances of each model, by their indices.
fn groups(population: &Population) -> Vec<Vec<u32>> {
    let mut counts = vec![0; population.models.len()];
    for instance in population.instances.iter() {
        counts[instance.model as usize] += 1;
    }
    let mut groups: Vec<Vec<u32>> = counts.into_iter().map(Vec::with_capacity).collect();
    for (index, instance) in population.instances.iter().enumerate() {
        groups[instance.model as usize].push(index as u32);
    }
    groups
}

/// The name of a model's nodes: its own, with a number behind that of the second and those that follow.
fn name(models: &[std::sync::Arc<Model>], index: usize) -> String {
    let name = &models[index].name;
    match models[..index].iter().filter(|model| model.name == *name).count() {
        0 => name.clone(),
        earlier => format!("{name}_{}", earlier + 1),
    }
}

/// Adds the places of a group of instances as lists.
fn add_places<'a>(
    builder: &mut Builder<'a>,
    group: &'a [u32],
    instances: &'a [Instance],
) -> InstanceAttributes {
    let count = group.len() as u64;
    let each = move || group.iter().map(move |index| &instances[*index as usize]);
    let translation = builder.floats(count, None, move || each().map(|it| it.position.to_array()));
    let rotation = builder.floats(count, None, move || each().map(|it| it.rotation.to_array()));
    let scale = builder.floats(count, None, move || each().map(|it| [it.scale; 3]));
    // The lower half first: as little-endian, these are the four bytes as they are.
    let random = builder.accessor(U16, Kind::Vec2, count, 4, None, move |out| {
        each().try_for_each(|it| out.write_all(&it.random.to_le_bytes()))
    });
    InstanceAttributes {
        translation: Some(translation),
        rotation: Some(rotation),
        scale: Some(scale),
        random: Some(random),
    }
}

/// Adds a node for each of a group of instances, which all show the same mesh.
fn add_nodes<'a>(
    builder: &mut Builder<'a>,
    name: &str,
    model: &'a Model,
    level: &'a Level,
    group: &[u32],
    instances: &[Instance],
) -> Vec<Index> {
    let mesh = add_level(builder, &model.name, model, level);
    let node = |index: &u32| {
        let Instance { position, rotation, scale, random, .. } = instances[*index as usize];
        builder.node(Node {
            name: Some(name.into()),
            mesh,
            translation: Some(position.to_array()),
            rotation: Some(rotation.to_array()),
            scale: Some([scale; 3]),
            extras: raw(&NodeExtras { random: Some(random), ..NodeExtras::default() }),
            ..Node::default()
        })
    };
    group.iter().map(node).collect()
}

fn add_land<'a>(builder: &mut Builder<'a>, land: &'a Land) -> Index {
    let picture = builder.texture(&land.picture);
    let surface = Surface { base_color_texture: Some(picture), metallic_factor: 0.0, ..Surface::default() };
    add_ground(builder, "land", &land.mesh, surface, None)
}

fn add_sea<'a>(builder: &mut Builder<'a>, sea: &'a Sea) -> Index {
    let [red, green, blue] = sea.color;
    let surface = Surface {
        base_color_factor: [red, green, blue, SEA_OPACITY],
        metallic_factor: 0.0,
        roughness_factor: sea.roughness,
        ..Surface::default()
    };
    add_ground(builder, "sea", &sea.mesh, surface, Some("BLEND"))
}

fn add_ground<'a>(
    builder: &mut Builder<'a>,
    name: &str,
    mesh: &'a Mesh,
    surface: Surface,
    alpha_mode: Option<&'static str>,
) -> Index {
    let material = builder.other_material(Material {
        name: Some(name.into()),
        pbr_metallic_roughness: surface,
        alpha_mode,
        ..Material::default()
    });
    let mesh = builder.mesh(name, [(mesh, material)]);
    let extras = raw(&NodeExtras { ground: true, ..NodeExtras::default() });
    builder.node(Node { name: Some(name.into()), mesh, extras, ..Node::default() })
}

/// Light of the sun, which shines along −Z of its node (`KHR_lights_punctual`). Colours there are at most 1: the
/// intensity, in lux, is that of the strongest channel.
fn add_sun(builder: &mut Builder, sun: &Sun) -> Index {
    let intensity = Vec3::from(sun.irradiance).max_element();
    let color = if intensity > 0.0 { sun.irradiance.map(|channel| channel / intensity) } else { [1.0; 3] };
    builder.extension("KHR_lights_punctual");
    let light = Light { name: "sun", kind: "directional", color, intensity };
    builder.document.extensions = Some(DocumentExtensions { lights: Lights { lights: vec![light] } });
    let light = NodeExtensions { light: Some(LightOfNode { light: 0 }), ..NodeExtensions::default() };
    builder.node(Node {
        name: Some("sun".into()),
        rotation: Some(Quat::from_rotation_arc(Vec3::Z, sun.direction).to_array()),
        extensions: Some(Box::new(light)),
        ..Node::default()
    })
}

/// The camera, which looks along −Z of its node.
fn add_camera(builder: &mut Builder, camera: &Pinhole) -> Index {
    let Pinhole { eye, right, up, forward, tangent } = *camera;
    let perspective = Perspective {
        aspect_ratio: tangent[0] / tangent[1],
        yfov: 2.0 * libm::atanf(tangent[1]),
        znear: NEAR,
    };
    let index = push(&mut builder.document.cameras, Camera { kind: "perspective", perspective });
    let rotation = Quat::from_mat3(&Mat3::from_cols(right, up, -forward)).normalize();
    builder.node(Node {
        name: Some("camera".into()),
        camera: Some(index),
        translation: Some(eye.to_array()),
        rotation: Some(rotation.to_array()),
        ..Node::default()
    })
}
