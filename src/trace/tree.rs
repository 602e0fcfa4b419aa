//! What rays are traced through: a tree over all instances, and one over the triangles of each model.

use super::rays::Traversal;
use super::{ground, upload};
use crate::core::octahedron::packed_direction;
use crate::gpu::{self, AccelerationStructure, Buffer, Gpu, Stance};
use crate::scene::{Instance, Material, Model, Scene};
use crate::shaders::{self, Facet, Node, Placement, Triangle};
use glam::{Mat3A, Quat, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::{Boundable, BvhBuildParams, triangle};
use rayon::prelude::*;
use std::ops::Range;
use std::time::Duration;

/// The scene on the device, as rays need it.
pub struct Tree {
    pub way: Way,
    pub triangles: Buffer<Triangle>,
    pub facets: Buffer<Facet>,
    pub placements: Buffer<Placement>,
    pub materials: Buffer<shaders::Material>,
}

/// What rays go through to the triangles.
pub enum Way {
    /// Over the placements, in their order.
    Query(AccelerationStructure),
    /// First the tree over the placements, whose root is node 0; then those of the land and the models.
    Bvh(Buffer<Node>),
}

/// The twin of `GROUND` in `glsl/lib/tree.glsl`.
const GROUND: u32 = u32::MAX;

/// Triangles and their tree, if we make one.
struct Grown {
    nodes: Vec<Node>,
    /// In the order of the tree's leaves.
    triangles: Vec<Triangle>,
    facets: Vec<Facet>,
    bounds: Aabb,
    /// Boxes that hold all of it, closer than `bounds`: those of the root's children.
    boxes: Vec<Aabb>,
}

impl Tree {
    /// # Errors
    /// No memory, or more triangles than the device can bind at once.
    pub fn new(gpu: &Gpu, scene: &Scene, heights: &[f32], traversal: Traversal) -> gpu::Result<Tree> {
        let population = &scene.population;
        let mut firsts = Vec::new();
        let mut materials: Vec<shaders::Material> = Vec::new();
        for model in &population.models {
            firsts.push(materials.len() as u32);
            materials.extend(model.materials.iter().map(shaders::Material::from));
        }
        if materials.is_empty() {
            // Nothing has one, but a buffer holds something.
            materials.push((&Material::default()).into());
        }
        let land = ground::triangles(scene.ground.grid, heights, scene.ground.sea_level);
        let land =
            || Grown::new(&land, &vec![Facet { normals: [0; 3], material: GROUND }; land.len()], traversal);
        let models = || -> Vec<Grown> {
            let models = population.models.par_iter().zip(&firsts);
            models.map(|(model, first)| grown(model, *first, traversal)).collect()
        };
        let (land, models) = rayon::join(land, models);

        let all: Vec<&Grown> = std::iter::once(&land).chain(&models).collect();
        let standing = standing(&all, &population.instances);
        let firsts: Vec<u32> = firsts_of(all.iter().map(|grown| grown.triangles.len()));
        let triangles: Vec<Triangle> = all.iter().flat_map(|grown| &grown.triangles).copied().collect();
        let facets: Vec<Facet> = all.iter().flat_map(|grown| &grown.facets).copied().collect();
        let triangles = upload(gpu, "triangles", &triangles)?;
        let (way, placements) = match traversal {
            Traversal::Query => query(gpu, &all, &firsts, &triangles, &standing)?,
            Traversal::Bvh => bvh(gpu, &all, &firsts, &standing)?,
        };
        Ok(Tree {
            way,
            triangles,
            facets: upload(gpu, "facets", &facets)?,
            placements: upload(gpu, "placements", &placements)?,
            materials: upload(gpu, "materials", &materials)?,
        })
    }
}

/// Where each part begins if they lie one behind the other.
fn firsts_of(lengths: impl Iterator<Item = usize>) -> Vec<u32> {
    let mut sum = 0;
    let first = |length: usize| {
        let first = sum;
        sum += length as u32;
        first
    };
    lengths.map(first).collect()
}

/// Structures of the device's own, and the placements in their order.
fn query(
    gpu: &Gpu,
    all: &[&Grown],
    firsts: &[u32],
    triangles: &Buffer<Triangle>,
    standing: &[Standing],
) -> gpu::Result<(Way, Vec<Placement>)> {
    // An empty model has no structure, and stands nowhere.
    let full: Vec<usize> = (0..all.len()).filter(|model| !all[*model].triangles.is_empty()).collect();
    let range = |model: &usize| firsts[*model]..firsts[*model] + all[*model].triangles.len() as u32;
    let ranges: Vec<Range<u32>> = full.iter().map(range).collect();
    let structures = AccelerationStructure::over_triangles(gpu, triangles, &ranges)?;
    let stance = |standing: &Standing| Stance {
        structure: full.partition_point(|model| *model < standing.model),
        transform: transform(&standing.placement),
    };
    let stances: Vec<Stance> = standing.iter().map(stance).collect();
    let world = AccelerationStructure::over_instances(gpu, &structures, &stances)?;
    let placements =
        standing.iter().map(|it| Placement { first: firsts[it.model], ..it.placement }).collect();
    Ok((Way::Query(world), placements))
}

/// To the world, by rows.
fn transform(placement: &Placement) -> [[f32; 4]; 3] {
    let turn = Mat3A::from_quat(Quat::from_array(placement.rotation)) * placement.scale;
    let [x, y, z] = placement.position;
    [turn.row(0).extend(x), turn.row(1).extend(y), turn.row(2).extend(z)].map(|row| row.to_array())
}

/// One tree over all and those of the models behind it, and the placements in the order of its leaves.
fn bvh(
    gpu: &Gpu,
    all: &[&Grown],
    firsts: &[u32],
    standing: &[Standing],
) -> gpu::Result<(Way, Vec<Placement>)> {
    let boxes: Vec<Aabb> = standing.iter().map(|standing| standing.bounds).collect();
    let top = build(&boxes);
    let mut nodes = plain(&top, 0, 0);
    let mut roots = Vec::new();
    for (grown, first_leaf) in all.iter().zip(firsts) {
        let first_node = nodes.len() as u32;
        roots.push(first_node);
        nodes.extend(grown.nodes.iter().map(|node| shifted(*node, first_node, *first_leaf)));
    }
    let placement = |index: &u32| {
        let Standing { model, placement, .. } = standing[*index as usize];
        Placement { root: roots[model], first: firsts[model], ..placement }
    };
    let placements = top.primitive_indices.iter().map(placement).collect();
    Ok((Way::Bvh(upload(gpu, "nodes", &nodes)?), placements))
}

/// One of the models, 0 for the land, where it stands.
#[derive(Clone, Copy)]
struct Standing {
    model: usize,
    placement: Placement,
    bounds: Aabb,
}

fn standing(all: &[&Grown], instances: &[Instance]) -> Vec<Standing> {
    let land = Standing {
        model: 0,
        placement: Placement { scale: 1.0, rotation: [0.0, 0.0, 0.0, 1.0], ..Placement::default() },
        bounds: all[0].bounds,
    };
    let others = instances.par_iter().enumerate().filter_map(|(index, instance)| {
        let model = instance.model as usize + 1;
        let grown = all.get(model).filter(|grown| !grown.triangles.is_empty())?;
        let placement = Placement {
            position: instance.position.to_array(),
            scale: instance.scale,
            rotation: instance.rotation.to_array(),
            random: instance.random,
            root: 0,
            first: 0,
            object: index as u32 + 1,
        };
        Some(Standing { model, placement, bounds: placed(&grown.boxes, instance) })
    });
    let others: Vec<Standing> = others.collect();
    std::iter::once(land).chain(others).collect()
}

/// The box round boxes that an instance has turned.
fn placed(boxes: &[Aabb], instance: &Instance) -> Aabb {
    let turn = Mat3A::from_quat(instance.rotation) * instance.scale;
    // Half the size of a turned box along each axis (Arvo 1990, "Transforming Axis-Aligned Bounding Boxes").
    let reach = Mat3A::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
    let mut all = Aabb::empty();
    for bounds in boxes {
        let middle = Vec3A::from(instance.position) + turn * ((bounds.min + bounds.max) / 2.0);
        let half = reach * ((bounds.max - bounds.min) / 2.0);
        all = all.union(&Aabb::new(middle - half, middle + half));
    }
    // The shader turns the ray instead, and rounds elsewhere.
    let slack = Vec3A::splat(1e-6) * all.min.abs().max(all.max.abs());
    Aabb::new(all.min - slack, all.max + slack)
}

/// The finest level of a model, whose first material is `first` of all.
fn grown(model: &Model, first: u32, traversal: Traversal) -> Grown {
    let mut corners = Vec::new();
    let mut facets = Vec::new();
    for part in model.levels.first().into_iter().flat_map(|level| &level.parts) {
        let material = first + part.material as u32;
        for triangle in &part.mesh.triangles {
            corners.push(triangle.map(|index| Vec3::from(part.mesh.positions[index as usize])));
            let normals = triangle.map(|index| packed_direction(part.mesh.normals[index as usize].into()));
            facets.push(Facet { normals, material });
        }
    }
    Grown::new(&corners, &facets, traversal)
}

impl Grown {
    fn new(corners: &[[Vec3; 3]], facets: &[Facet], traversal: Traversal) -> Grown {
        let triangle = |corners: &[Vec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner.to_array());
            Triangle { a, b, c }
        };
        if traversal == Traversal::Query {
            return Grown {
                nodes: Vec::new(),
                triangles: corners.iter().map(triangle).collect(),
                facets: facets.to_vec(),
                bounds: Aabb::empty(),
                boxes: Vec::new(),
            };
        }
        let solid =
            |[a, b, c]: &[Vec3; 3]| triangle::Triangle { v0: (*a).into(), v1: (*b).into(), v2: (*c).into() };
        let solids: Vec<_> = corners.iter().map(solid).collect();
        let tree = build(&solids);
        let order = || tree.primitive_indices.iter().map(|index| *index as usize);
        Grown {
            nodes: plain(&tree, 0, 0),
            triangles: order().map(|index| triangle(&corners[index])).collect(),
            facets: order().map(|index| facets[index]).collect(),
            bounds: tree.total_aabb,
            boxes: boxes(&tree),
        }
    }
}

/// A tree over anything that has a box.
pub fn build<T: Boundable>(things: &[T]) -> CwBvh {
    build_cwbvh(things, BvhBuildParams::medium_build(), &mut Duration::default())
}

/// The nodes as shaders have them.
fn plain(tree: &CwBvh, first_node: u32, first_leaf: u32) -> Vec<Node> {
    tree.nodes.iter().map(|node| shifted(bytemuck::cast(*node), first_node, first_leaf)).collect()
}

fn shifted(node: Node, first_node: u32, first_leaf: u32) -> Node {
    Node { first_child: node.first_child + first_node, first_leaf: node.first_leaf + first_leaf, ..node }
}

fn boxes(tree: &CwBvh) -> Vec<Aabb> {
    let Some(root) = tree.nodes.first() else { return Vec::new() };
    (0..8).filter(|child| !root.is_child_empty(*child)).map(|child| root.child_aabb(child)).collect()
}
