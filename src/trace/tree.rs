//! What rays are traced through: a tree over all instances, and one over the triangles of each model and of the land.

use super::ground::{self, GRID, Ground};
use super::rays::Traversal;
use super::upload;
use crate::core::grid::Grid;
use crate::core::octahedron::packed_direction;
use crate::gpu::{self, AccelerationStructure, Buffer, Gpu, Stance, Texels};
use crate::scene::{Instance, Material, Model, Scene};
use crate::shaders;
use bytemuck::{Pod, Zeroable};
use glam::{Mat3A, Quat, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh, node::CwBvhNode};
use obvhs::{Boundable, BvhBuildParams, triangle};
use rayon::prelude::*;
use std::time::Duration;

/// The land and the models, each by itself: what stays the same wherever models stand.
pub struct Parts {
    structures: Structures,
    /// Number of each part's first triangle, as hits give it; `None` has no triangles.
    firsts: Vec<Option<u32>>,
    pub triangles: Texels,
    /// Of every triangle, the index into all materials.
    pub coats: Buffer<u32>,
    pub materials: Buffer<shaders::Material>,
}

/// What rays go through to the triangles of each part.
enum Structures {
    /// The device's own. Of every part where its structures are in the list, and each one's first triangle: the land is in strips.
    Query(Vec<AccelerationStructure>, Vec<Vec<(usize, u32)>>),
    Bvh(Vec<Grown>),
}

/// What stands in the scene on the device, as rays need it.
pub struct Tree {
    pub way: Way,
    /// All of the parts'.
    pub triangles: Texels,
    pub placements: Texels,
    /// Of every placement, 1 + the index of its instance; 0 for the land.
    pub objects: Vec<u32>,
}

/// What rays go through to the triangles.
pub enum Way {
    /// Over the placements, in their order.
    Query(AccelerationStructure),
    /// First the tree over what stands on the land, whose root is node 0; then those of the land and the models.
    Bvh(Texels),
}

/// The twin of `Triangle` in `glsl/lib/tree.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub struct Triangle {
    corners: [[f32; 3]; 3],
    normals: [u32; 3],
}

/// The twin of `Placement` in `glsl/lib/tree.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub struct Placement {
    position: [f32; 3],
    scale: f32,
    rotation: [f32; 4],
    root: u32,
    first: u32,
    random: u32,
    object: u32,
}

/// Triangles and their tree, if we make one.
#[derive(Default)]
struct Grown {
    nodes: Vec<CwBvhNode>,
    /// In the order of the tree's leaves.
    triangles: Vec<Triangle>,
    coats: Vec<u32>,
    /// Boxes that hold all of it, closely: those of the root's children.
    boxes: Vec<Aabb>,
}

/// One of the things that stand in the scene.
#[derive(Clone, Copy)]
struct Standing {
    part: usize,
    placement: Placement,
}

/// What stands in a scene: the first part is the land on its grid, the second what the sea covers beyond, and the others are the models.
const LAND: usize = 0;
const SKIRT: usize = 1;
const MODELS: usize = 2;

impl Parts {
    /// Those of a scene; `heights` are its land's.
    ///
    /// # Errors
    /// No memory, or more triangles than the device can bind at once.
    pub fn new(gpu: &Gpu, scene: &Scene, heights: &[f32], traversal: Traversal) -> gpu::Result<Parts> {
        let population = &scene.population;
        let mut first_materials = Vec::new();
        let mut materials: Vec<shaders::Material> = Vec::new();
        for model in &population.models {
            first_materials.push(materials.len() as u32);
            materials.extend(model.materials.iter().map(shaders::Material::from));
        }
        if materials.is_empty() {
            // Nothing has one, but a buffer holds something.
            materials.push((&Material::default()).into());
        }
        let grid = scene.ground.grid;
        let land = || match traversal {
            Traversal::Bvh => Grown::from(Ground::new(grid, heights)),
            Traversal::Query => Grown::default(),
        };
        let skirt = ground::skirt(grid, heights, scene.ground.sea_level);
        let skirt =
            Grown::new(skirt.iter().map(|corners| bare(*corners)).collect(), vec![0; skirt.len()], traversal);
        let models = || -> Vec<Grown> {
            let models = population.models.par_iter().zip(&first_materials);
            models.map(|(model, first)| grown(model, *first, traversal)).collect()
        };
        let (land, models) = rayon::join(land, models);

        let mut parts = vec![land, skirt];
        parts.extend(models);
        let mut triangles: Vec<Triangle> = parts.iter().flat_map(|part| &part.triangles).copied().collect();
        let mut coats: Vec<u32> = parts.iter().flat_map(|part| &part.coats).copied().collect();
        if triangles.is_empty() {
            triangles.push(Triangle::default());
            coats.push(0);
        }
        let firsts = firsts(&parts);
        let structures = match traversal {
            Traversal::Query => query_structures(gpu, grid, heights, &parts, &firsts)?,
            // Triangles are on the device.
            Traversal::Bvh => Structures::Bvh(parts.into_iter().map(Grown::without_triangles).collect()),
        };
        Ok(Parts {
            structures,
            firsts,
            triangles: Texels::new(gpu, "triangles", &triangles)?,
            coats: upload(gpu, "coats", &coats)?,
            materials: upload(gpu, "materials", &materials)?,
        })
    }
}

impl Tree {
    /// The land, and the models where these instances stand.
    ///
    /// # Errors
    /// No memory, or more than the device can bind at once.
    pub fn new(gpu: &Gpu, parts: &Parts, instances: &[Instance]) -> gpu::Result<Tree> {
        let Parts { structures, firsts, triangles, .. } = parts;
        let standing = standing(firsts, instances);
        let (way, placements) = match structures {
            Structures::Query(structures, of) => query(gpu, structures, of, &standing)?,
            Structures::Bvh(parts) => bvh(gpu, parts, firsts, &standing)?,
        };
        Ok(Tree {
            way,
            triangles: triangles.clone(),
            placements: Texels::new(gpu, "placements", &placements)?,
            objects: placements.iter().map(|placement| placement.object).collect(),
        })
    }
}

fn firsts(parts: &[Grown]) -> Vec<Option<u32>> {
    let mut next = 0;
    let mut firsts = vec![Some(GRID)];
    for part in &parts[SKIRT..] {
        firsts.push((!part.triangles.is_empty()).then_some(next));
        next += part.triangles.len() as u32;
    }
    firsts
}

/// Everything where it stands, the land first, but for what has no triangles.
fn standing(firsts: &[Option<u32>], instances: &[Instance]) -> Vec<Standing> {
    let still = |part: usize| {
        let first = firsts[part]?;
        let rotation = [0.0, 0.0, 0.0, 1.0];
        Some(Standing { part, placement: Placement { scale: 1.0, rotation, first, ..Placement::default() } })
    };
    let moved = |(index, instance): (usize, &Instance)| {
        let part = instance.model as usize + MODELS;
        let first = (*firsts.get(part)?)?;
        let placement = Placement {
            position: instance.position.to_array(),
            scale: instance.scale,
            rotation: instance.rotation.to_array(),
            root: 0,
            first,
            random: instance.random,
            object: index as u32 + 1,
        };
        Some(Standing { part, placement })
    };
    let mut standing: Vec<Standing> = [LAND, SKIRT].into_iter().filter_map(still).collect();
    standing.par_extend(instances.par_iter().enumerate().filter_map(moved));
    standing
}

/// Rows of the land that have a structure of their own: what they are built from is not in memory all at once.
const STRIP: u32 = 1 << 20;

/// Structures of the device's own.
fn query_structures(
    gpu: &Gpu,
    grid: Grid,
    heights: &[f32],
    parts: &[Grown],
    firsts: &[Option<u32>],
) -> gpu::Result<Structures> {
    let (mut structures, mut of) = (Vec::new(), vec![Vec::new(); parts.len()]);
    let last = grid.cells - 1;
    let rows = (STRIP / (2 * last)).max(1);
    for top in (0..last).step_by(rows as usize) {
        let corners = ground::triangles(grid, heights, top..(top + rows).min(last));
        let corners: Vec<_> = corners.iter().map(|corners| corners.map(|corner| corner.to_array())).collect();
        of[LAND].push((structures.len(), GRID + 2 * top * last));
        structures.push(AccelerationStructure::over_triangles(gpu, &corners)?);
    }
    for (part, grown) in parts.iter().enumerate().skip(SKIRT) {
        let Some(first) = firsts[part] else { continue };
        let corners: Vec<_> = grown.triangles.iter().map(|triangle| triangle.corners).collect();
        of[part].push((structures.len(), first));
        structures.push(AccelerationStructure::over_triangles(gpu, &corners)?);
    }
    Ok(Structures::Query(structures, of))
}

/// A structure of the device's own over all that stands, and the placements in its order.
fn query(
    gpu: &Gpu,
    structures: &[AccelerationStructure],
    of: &[Vec<(usize, u32)>],
    standing: &[Standing],
) -> gpu::Result<(Way, Vec<Placement>)> {
    let (mut stances, mut placements) = (Vec::new(), Vec::new());
    for Standing { part, placement } in standing {
        for &(structure, first) in &of[*part] {
            stances.push(Stance { structure, transform: transform(placement) });
            placements.push(Placement { first, ..*placement });
        }
    }
    let world = AccelerationStructure::over_instances(gpu, structures, &stances)?;
    Ok((Way::Query(world), placements))
}

/// To the world, by rows.
fn transform(placement: &Placement) -> [[f32; 4]; 3] {
    let turn = Mat3A::from_quat(Quat::from_array(placement.rotation)) * placement.scale;
    let [x, y, z] = placement.position;
    [turn.row(0).extend(x), turn.row(1).extend(y), turn.row(2).extend(z)].map(|row| row.to_array())
}

/// One tree over all that stands on the land, and those of the parts behind it; the placement of the land, and those of the others in
/// the order of the tree's leaves.
fn bvh(
    gpu: &Gpu,
    parts: &[Grown],
    firsts: &[Option<u32>],
    standing: &[Standing],
) -> gpu::Result<(Way, Vec<Placement>)> {
    let bounds = |standing: &Standing| placed(&parts[standing.part].boxes, &standing.placement);
    let (land, standing) = (standing[LAND], &standing[1..]);
    let top = build(&standing.par_iter().map(bounds).collect::<Vec<_>>());
    let mut nodes = top.nodes;
    // The land's placement comes before them.
    nodes.iter_mut().for_each(|node| node.primitive_base_idx += 1);
    if nodes.is_empty() {
        // Without children.
        nodes.push(CwBvhNode::default());
    }
    let mut roots = Vec::new();
    for (grown, first_leaf) in parts.iter().zip(firsts) {
        let first_node = nodes.len() as u32;
        // What names the land's leaves is where they lie.
        let first_leaf = first_leaf.filter(|first| *first != GRID).unwrap_or(0);
        roots.push(first_node);
        nodes.extend(grown.nodes.iter().map(|node| CwBvhNode {
            child_base_idx: node.child_base_idx + first_node,
            primitive_base_idx: node.primitive_base_idx + first_leaf,
            ..*node
        }));
    }
    let placement = |Standing { part, placement }: Standing| Placement { root: roots[part], ..placement };
    let others = top.primitive_indices.iter().map(|index| standing[*index as usize]);
    let placements = std::iter::once(land).chain(others).map(placement).collect();
    Ok((Way::Bvh(Texels::new(gpu, "nodes", &nodes)?), placements))
}

/// The box round boxes that stand somewhere.
fn placed(boxes: &[Aabb], place: &Placement) -> Aabb {
    let turn = Mat3A::from_quat(Quat::from_array(place.rotation)) * place.scale;
    // Half the size of a turned box along each axis (Arvo 1990, "Transforming Axis-Aligned Bounding Boxes").
    let reach = Mat3A::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
    let mut all = Aabb::empty();
    for bounds in boxes {
        let middle = Vec3A::from(place.position) + turn * ((bounds.min + bounds.max) / 2.0);
        let half = reach * ((bounds.max - bounds.min) / 2.0);
        all = all.union(&Aabb::new(middle - half, middle + half));
    }
    // The shader turns the ray instead, and rounds elsewhere.
    let slack = Vec3A::splat(1e-6) * all.min.abs().max(all.max.abs());
    Aabb::new(all.min - slack, all.max + slack)
}

/// The finest level of a model, whose first material is `first` of all.
fn grown(model: &Model, first: u32, traversal: Traversal) -> Grown {
    let mut triangles = Vec::new();
    let mut coats = Vec::new();
    for part in model.levels.first().into_iter().flat_map(|level| &level.parts) {
        for triangle in &part.mesh.triangles {
            triangles.push(Triangle {
                corners: triangle.map(|index| part.mesh.positions[index as usize]),
                normals: triangle.map(|index| packed_direction(part.mesh.normals[index as usize].into())),
            });
            coats.push(first + part.material as u32);
        }
    }
    Grown::new(triangles, coats, traversal)
}

/// A triangle of the land: its shading asks the heights.
fn bare(corners: [Vec3; 3]) -> Triangle {
    Triangle { corners: corners.map(|corner| corner.to_array()), normals: [0; 3] }
}

impl Grown {
    fn new(triangles: Vec<Triangle>, coats: Vec<u32>, traversal: Traversal) -> Grown {
        if traversal == Traversal::Query || triangles.is_empty() {
            return Grown { triangles, coats, ..Grown::default() };
        }
        let solid = |triangle: &Triangle| {
            let [v0, v1, v2] = triangle.corners.map(Vec3A::from);
            triangle::Triangle { v0, v1, v2 }
        };
        let tree = build(&triangles.iter().map(solid).collect::<Vec<_>>());
        let order = || tree.primitive_indices.iter().map(|index| *index as usize);
        Grown {
            triangles: order().map(|index| triangles[index]).collect(),
            coats: order().map(|index| coats[index]).collect(),
            boxes: boxes(&tree),
            nodes: tree.nodes,
        }
    }

    fn without_triangles(self) -> Grown {
        Grown { triangles: Vec::new(), coats: Vec::new(), ..self }
    }
}

impl From<Ground> for Grown {
    fn from(ground: Ground) -> Grown {
        Grown { nodes: ground.nodes, boxes: vec![ground.bounds], ..Grown::default() }
    }
}

/// A tree over anything that has a box.
pub fn build<T: Boundable>(things: &[T]) -> CwBvh {
    build_cwbvh(things, BvhBuildParams::medium_build(), &mut Duration::default())
}

fn boxes(tree: &CwBvh) -> Vec<Aabb> {
    let Some(root) = tree.nodes.first() else { return Vec::new() };
    (0..8).filter(|child| !root.is_child_empty(*child)).map(|child| root.child_aabb(child)).collect()
}
