//! From the meshes and materials of a document to models.

use super::accessor::{Numbers, numbers, resource, view_bytes};
use super::corrupt;
use super::document::{Document, Index, MaterialExtras, Node, NodeExtras, Primitive};
use super::read::extras;
use crate::core::mesh::Mesh;
use crate::formats::model::{Budget, add_material, area_normal, check_finite, grey, stem, unit, unsuitable};
use crate::formats::{Error, png};
use crate::scene::{Level, Material, Model, Part};
use glam::{Affine3A, Vec3};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The models that nodes have asked for.
pub struct Shapes<'a> {
    path: &'a Path,
    document: &'a Document,
    buffers: &'a [Vec<u8>],
    pub budget: Budget<'a>,
    pub models: Vec<Arc<Model>>,
    pub warnings: Vec<String>,
    /// By the meshes of their levels; `None` has no triangles.
    known: HashMap<Vec<Index>, Option<u32>>,
    /// Mean colours of images, linear Rec.709; `None` is of an image that can't be read.
    colors: HashMap<Index, Option<[f32; 3]>>,
    /// How many pixels may still be looked at.
    pixels: u64,
}

/// Most pixels of all textures of a file together.
const MOST_PIXELS: u64 = 1 << 28;

/// The modes of primitives that are triangles (§5.24.4).
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

impl<'a> Shapes<'a> {
    pub fn new(path: &'a Path, document: &'a Document, buffers: &'a [Vec<u8>], budget: Budget<'a>) -> Self {
        Shapes {
            path,
            document,
            buffers,
            budget,
            models: Vec::new(),
            warnings: Vec::new(),
            known: HashMap::new(),
            colors: HashMap::new(),
            pixels: MOST_PIXELS,
        }
    }

    /// The index of the model that a node shows; `None` if it has no triangles.
    pub fn of_node(&mut self, node: &Node) -> Result<Option<u32>, Error> {
        let Some(mesh) = node.mesh else { return Ok(None) };
        if node.skin.is_some() {
            self.warn("it has skeletons, which are left out");
        }
        let detail =
            |node: &Node| extras::<NodeExtras>(node.extras.as_deref()).and_then(|extras| extras.detail);
        let mut levels = vec![(mesh, detail(node).unwrap_or(0.0))];
        let others = node.extensions.as_ref().and_then(|extensions| extensions.levels.as_ref());
        for id in others.into_iter().flat_map(|levels| &levels.ids) {
            // Only files of ours say from how far away a level serves.
            let node = self.document.nodes.get(*id as usize);
            levels.extend(node.and_then(|node| node.mesh.zip(detail(node))));
        }
        let key: Vec<Index> = levels.iter().map(|(mesh, _)| *mesh).collect();
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let mut model = Model { name: self.name(node, mesh), ..Model::default() };
        for (mesh, detail) in levels {
            let parts = self.parts(mesh, &mut model.materials)?;
            if !parts.is_empty() {
                model.levels.push(Level { detail, parts });
            }
        }
        let index = (!model.levels.is_empty()).then_some(self.models.len() as u32);
        if index.is_some() {
            self.models.push(Arc::new(model));
        }
        self.known.insert(key, index);
        Ok(index)
    }

    /// A copy of a model under a transform.
    pub fn stretched(&mut self, model: u32, transform: Affine3A) -> Result<u32, Error> {
        let from = self.models[model as usize].clone();
        let matrix = transform.matrix3;
        let normals = matrix.inverse().transpose();
        let mirrored = matrix.determinant() < 0.0;
        let longest = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length());
        let longest = longest.into_iter().fold(0.0, f32::max);
        let mut copy =
            Model { name: from.name.clone(), materials: from.materials.clone(), levels: Vec::new() };
        for level in &from.levels {
            let mut parts = Vec::new();
            for part in &level.parts {
                let mut mesh = self.budget.copy(&part.mesh)?;
                for position in &mut mesh.positions {
                    *position = transform.transform_point3((*position).into()).into();
                }
                check_finite(self.path, &mesh.positions)?;
                for normal in &mut mesh.normals {
                    *normal = unit((normals * Vec3::from(*normal)).into());
                }
                if mirrored {
                    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
                }
                parts.push(Part { material: part.material, mesh });
            }
            copy.levels.push(Level { detail: level.detail * longest, parts });
        }
        self.models.push(Arc::new(copy));
        Ok(self.models.len() as u32 - 1)
    }

    fn name(&self, node: &Node, mesh: Index) -> String {
        let of_mesh = self.document.meshes.get(mesh as usize).and_then(|mesh| mesh.name.as_deref());
        of_mesh.or(node.name.as_deref()).map_or_else(|| stem(self.path), String::from)
    }

    /// The parts of a mesh, whose materials are found in or added to `materials`.
    fn parts(&mut self, mesh: Index, materials: &mut Vec<Material>) -> Result<Vec<Part>, Error> {
        let Some(mesh) = self.document.meshes.get(mesh as usize) else {
            return Err(corrupt(self.path, format!("mesh {mesh} is missing")));
        };
        let mut parts = Vec::new();
        for primitive in &mesh.primitives {
            let Some((mesh, tint)) = self.primitive(primitive)? else { continue };
            let mut material = self.material(primitive.material)?;
            for color in &mut material.reflectance {
                *color = std::array::from_fn(|channel| color[channel] * tint[channel]);
            }
            parts.push(Part { material: add_material(self.path, materials, &material)?, mesh });
        }
        Ok(parts)
    }

    /// The triangles of a primitive and the mean colour of its vertices; `None` if it has none.
    fn primitive(&mut self, primitive: &Primitive) -> Result<Option<(Mesh, [f32; 3])>, Error> {
        if primitive.extensions.as_ref().is_some_and(|extensions| extensions.draco.is_some()) {
            let reason = "its meshes are compressed with Draco; write it again without compression";
            return Err(unsuitable(self.path, reason));
        }
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        if !matches!(mode, TRIANGLES | STRIP | FAN) {
            self.warn("it has points and lines, which are left out");
            return Ok(None);
        }
        let attributes = &primitive.attributes;
        let Some(positions) = self.numbers(attributes.position, Numbers::vectors::<3>)? else {
            return Ok(None);
        };
        let normals = self.numbers(attributes.normal, Numbers::vectors::<3>)?;
        let uvs = self.numbers(attributes.uv, Numbers::vectors::<2>)?;
        let colors = self.numbers(attributes.color, Ok)?;
        let indices = self.numbers(primitive.indices, Numbers::wholes::<1>)?;
        let of_vertices = [&normals, &uvs, &colors];
        if of_vertices.into_iter().flatten().any(|other| other.count != positions.count) {
            return Err(corrupt(self.path, "a mesh has more of one attribute than of another"));
        }

        let mut triangles = self.triangles(mode, indices.as_ref(), positions.count)?;
        if triangles.is_empty() {
            return Ok(None);
        }
        // Many primitives may share one list of vertices: each takes its own. Fewer corners than vertices leave some out.
        let corners = triangles.as_flattened();
        let used = if corners.len() < positions.count { Some(self.used(corners)?) } else { None };
        if let Some(used) = &used {
            for corner in triangles.as_flattened_mut() {
                *corner = used.binary_search(corner).unwrap_or(0) as u32;
            }
        }
        let count = used.as_ref().map_or(positions.count, Vec::len);
        let vertex = |index: usize| used.as_ref().map_or(index, |used| used[index] as usize);
        let mut mesh = self.budget.mesh(count as u64, 0)?;
        mesh.triangles = triangles;
        mesh.positions.extend((0..count).map(|index| positions.vector::<3>(vertex(index))));
        match &normals {
            Some(normals) => {
                mesh.normals.extend((0..count).map(|index| unit(normals.vector(vertex(index)))));
            }
            None => mesh.normals.resize(count, [0.0, 1.0, 0.0]),
        }
        match &uvs {
            Some(uvs) => mesh.uvs.extend((0..count).map(|index| uvs.vector::<2>(vertex(index)))),
            None => mesh.uvs.resize(count, [0.0; 2]),
        }
        check_finite(self.path, &mesh.positions)?;
        check_finite(self.path, &mesh.uvs)?;
        let tint = match &colors {
            Some(colors) => mean((0..count).map(|index| colors.vector::<3>(vertex(index)))),
            None => [1.0; 3],
        };
        if let Some(used) = used {
            self.budget.release(used);
        }
        let mesh = if normals.is_some() { mesh } else { self.faceted(mesh)? };
        Ok(Some((mesh, tint)))
    }

    /// The numbers of an accessor, if there is one, of the kind that `check` wants.
    fn numbers(
        &self,
        index: Option<Index>,
        check: fn(Numbers<'a>) -> Result<Numbers<'a>, String>,
    ) -> Result<Option<Numbers<'a>>, Error> {
        let of = |index| numbers(self.document, self.buffers, index).and_then(check);
        index.map(of).transpose().map_err(|reason| corrupt(self.path, reason))
    }

    /// Triangles out of the corners of a list, strip or fan (§3.7.2.1).
    fn triangles(
        &mut self,
        mode: u32,
        indices: Option<&Numbers>,
        vertices: usize,
    ) -> Result<Vec<[u32; 3]>, Error> {
        let corners = indices.map_or(vertices, |indices| indices.count);
        let count = if mode == TRIANGLES { corners / 3 } else { corners.saturating_sub(2) };
        let mut triangles = self.budget.room(count as u64)?;
        for index in 0..count {
            let corners = match mode {
                TRIANGLES => [3 * index, 3 * index + 1, 3 * index + 2],
                STRIP => [index, index + 1 + index % 2, index + 2 - index % 2],
                _ => [index + 1, index + 2, 0],
            };
            let triangle = corners.map(|corner| match indices {
                Some(indices) => indices.whole::<1>(corner)[0],
                None => corner as u32,
            });
            if triangle.iter().any(|corner| *corner as usize >= vertices) {
                let reason = format!("triangle {index} of a mesh has corners that are missing");
                return Err(corrupt(self.path, reason));
            }
            let [a, b, c] = triangle;
            // Strips turn round on triangles that are none.
            if mode == TRIANGLES || (a != b && b != c && c != a) {
                triangles.push(triangle);
            }
        }
        Ok(triangles)
    }

    /// The vertices that are a corner of something, in order, once each.
    fn used(&mut self, corners: &[u32]) -> Result<Vec<u32>, Error> {
        let mut used = self.budget.room(corners.len() as u64)?;
        used.extend(corners);
        used.sort_unstable();
        used.dedup();
        Ok(used)
    }

    /// The same triangles with corners of their own and the normals of their planes, as the format wants it where there are
    /// none (§3.7.2.1).
    fn faceted(&mut self, from: Mesh) -> Result<Mesh, Error> {
        let count = from.triangles.len() as u64;
        let mut mesh = self.budget.mesh(3 * count, count)?;
        for triangle in &from.triangles {
            let normal = unit(area_normal(&from.positions, *triangle));
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(triangle.map(|corner| from.positions[corner as usize]));
            mesh.uvs.extend(triangle.map(|corner| from.uvs[corner as usize]));
            mesh.normals.extend([normal; 3]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        self.budget.release_mesh(from);
        Ok(mesh)
    }

    /// A material as the two-sided diffuse surface that it is nearest to.
    fn material(&mut self, index: Option<Index>) -> Result<Material, Error> {
        let Some(index) = index else { return Ok(grey()) };
        let Some(from) = self.document.materials.get(index as usize) else {
            return Err(corrupt(self.path, format!("material {index} is missing")));
        };
        let surface = &from.pbr_metallic_roughness;
        let [red, green, blue, _] = surface.base_color_factor;
        let mut color = [red, green, blue].map(share);
        let mut transmittance = [0.0; 3];
        let mut refractive_index = super::document::RefractiveIndex::default().ior;
        if let Some(extensions) = &from.extensions {
            if let Some(ior) = &extensions.ior {
                refractive_index = if ior.ior.is_finite() { ior.ior.max(1.0) } else { refractive_index };
            }
            if let Some(transmission) = &extensions.transmission {
                let through = share(transmission.diffuse_transmission_factor);
                transmittance =
                    transmission.diffuse_transmission_color_factor.map(|channel| share(channel) * through);
                color = color.map(|channel| channel * (1.0 - through));
            }
        }
        if let Some(texture) = &surface.base_color_texture {
            let mean = self.texture(texture.index)?;
            color = std::array::from_fn(|channel| color[channel] * mean[channel]);
        }
        let mut material = Material {
            name: from.name.as_deref().unwrap_or_default().into(),
            reflectance: [color; 2],
            transmittance,
            refractive_index,
            roughness: share(surface.roughness_factor),
            ..Material::default()
        };
        if let Some(extras) = extras::<MaterialExtras>(from.extras.as_deref()) {
            let MaterialExtras { reflectance, position_factor, value_factor, transmittance } = extras;
            material.reflectance = reflectance.map(|color| color.map(share));
            // Both sides together send out no more than arrives.
            material.transmittance = std::array::from_fn(|channel| {
                let most = material.reflectance.map(|color| color[channel]);
                share(transmittance[channel]).min(1.0 - most[0].max(most[1]))
            });
            material.position_factor = if position_factor.is_finite() { position_factor } else { 1.0 };
            material.value_factor = if value_factor.is_finite() { value_factor } else { 1.0 };
        }
        Ok(material)
    }

    /// The mean colour of a texture; white, with a warning, where it can't be known.
    fn texture(&mut self, index: Index) -> Result<[f32; 3], Error> {
        let source = self.document.textures.get(index as usize).and_then(|texture| texture.source);
        let color = match source {
            Some(image) => match self.colors.get(&image) {
                Some(color) => *color,
                None => {
                    let color = self.image(image)?;
                    self.colors.insert(image, color);
                    color
                }
            },
            None => None,
        };
        self.warn(match color {
            Some(_) => "its textures are not drawn: surfaces have their mean colours",
            None => {
                "it has textures that are not PNG: surfaces have the colours that its materials give beside"
            }
        });
        Ok(color.unwrap_or([1.0; 3]))
    }

    /// The mean colour of an image; `None` if it can't be read.
    fn image(&mut self, index: Index) -> Result<Option<[f32; 3]>, Error> {
        let Some(image) = self.document.images.get(index as usize) else { return Ok(None) };
        match (image.buffer_view, &image.uri) {
            (Some(view), _) => {
                let view = view_bytes(self.document, self.buffers, view);
                let (bytes, _) = view.map_err(|reason| corrupt(self.path, reason))?;
                Ok(png::mean_color(bytes, &mut self.pixels))
            }
            (None, Some(uri)) => {
                // What a picture can't tell is no reason to do without the model.
                let Ok(bytes) = resource(self.path, uri, &mut self.budget) else { return Ok(None) };
                let color = png::mean_color(&bytes, &mut self.pixels);
                self.budget.release(bytes);
                Ok(color)
            }
            (None, None) => Ok(None),
        }
    }

    pub fn warn(&mut self, warning: &str) {
        let warning = format!("{}: {warning}", self.path.display());
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}

/// From 0 to 1; 0 for what is no number.
fn share(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}

/// The mean of colours, each from 0 to 1.
fn mean(colors: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0_f64);
    for color in colors {
        sum = std::array::from_fn(|channel| sum[channel] + f64::from(share(color[channel])));
        count += 1.0;
    }
    sum.map(|sum| (sum / count.max(1.0)) as f32)
}
