//! Models as files, in the format that the name ends in. Files to read come from anywhere: what they promise is checked
//! against their size and against what models may take before memory is taken.

use super::file::Written;
use super::{Error, extension, gltf, obj, open, ply};
use crate::core::memory::mebibytes;
use crate::core::mesh::Mesh;
use crate::scene::{Instance, Level, Material, Model, Part, Population};
use glam::{Quat, Vec3};
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// What names of models end in.
pub const EXTENSIONS: [&str; 3] = ["glb", "obj", "ply"];

/// Most memory, bytes, that a file and the models in it take together.
const MOST: u64 = 384 << 20;

/// Most materials of a model.
const MOST_MATERIALS: usize = 1 << 10;

/// Most instances in a file.
const MOST_INSTANCES: usize = 1 << 21;

/// Writes a model: a .glb with all its levels and materials, a .obj of the finest level with its .mtl beside, or a .ply of
/// the finest level with colours. Returns the files, the one of that name first.
///
/// # Errors
/// Those of [`file::write()`](super::file::write()), for another ending, and for more than the format can hold.
pub fn write(path: &Path, model: &Model) -> Result<Vec<Written>, Error> {
    match extension(path).as_str() {
        "glb" => Ok(vec![gltf::write_model(path, model)?]),
        "obj" => obj::write_model(path, model),
        "ply" => Ok(vec![ply::write_model(path, model)?]),
        _ => Err(Error::Target { path: path.into(), reason: "its name must end in .glb, .obj or .ply" }),
    }
}

/// What a file of models holds.
#[derive(Clone, Debug, Default)]
pub struct Import {
    /// Each shape once, and where the file's scene has it. One of ours comes back as it was.
    pub population: Population,
    /// What the models lack that the file has, one sentence each.
    pub warnings: Vec<String>,
    /// Whether it is a scene that this program wrote: in the world's coordinates, and no model to place.
    pub is_own_scene: bool,
}

/// Reads models from a .glb, .gltf, .obj or .ply file, along with the files that it names and that lie in its folder.
/// Normals are computed where there are none, and texture coordinates are 0 then.
///
/// # Errors
/// When a file can't be read, is damaged or forged, too large, or needs what is not supported.
pub fn read(path: &Path) -> Result<Import, Error> {
    match extension(path).as_str() {
        "glb" | "gltf" => gltf::read(path),
        "obj" => obj::read(path),
        "ply" => ply::read(path),
        _ => Err(unsuitable(path, "its name must end in .glb, .gltf, .obj or .ply")),
    }
}

impl Import {
    /// Memory that it takes.
    pub fn bytes(&self) -> u64 {
        let Population { models, instances } = &self.population;
        let parts = models.iter().flat_map(|model| &model.levels).flat_map(|level| &level.parts);
        let meshes =
            parts.map(|part| Mesh::bytes(part.mesh.positions.len() as u64, part.mesh.triangles.len() as u64));
        meshes.sum::<u64>() + size_of_val::<[Instance]>(instances) as u64
    }

    /// A single model called `name` that stands at the origin.
    pub(super) fn of_model(model: Model, warnings: Vec<String>) -> Self {
        let instance =
            Instance { model: 0, random: 0, position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };
        Import {
            population: Population { models: vec![Arc::new(model)], instances: [instance].into() },
            warnings,
            is_own_scene: false,
        }
    }

    /// Everything in the file as one model, for whoever places it as a whole: `path` is what messages name. It keeps its
    /// levels if it is a single model that stands upright at the origin, else there is one.
    ///
    /// # Errors
    /// When copies of what the file has many times would take too much memory.
    pub fn merged(&self, path: &Path) -> Result<Arc<Model>, Error> {
        let Population { models, instances } = &self.population;
        if let [only] = &instances[..]
            && only.position == Vec3::ZERO
            && only.rotation == Quat::IDENTITY
            && only.scale == 1.0
        {
            return Ok(models[only.model as usize].clone());
        }
        let mut budget = Budget::new(path);
        budget.take(self.bytes())?;
        let mut materials = Vec::new();
        let mut places: Vec<Vec<usize>> = Vec::new();
        for model in models {
            let of_model =
                model.materials.iter().map(|material| add_material(path, &mut materials, material));
            places.push(of_model.collect::<Result<_, _>>()?);
        }
        let parts = |instance: &Instance| {
            let levels = models[instance.model as usize].levels.first();
            levels.into_iter().flat_map(|level| &level.parts)
        };
        // Vertices and triangles of each material.
        let mut sizes = vec![[0_u64; 2]; materials.len()];
        for (instance, part) in instances.iter().flat_map(|it| parts(it).map(move |part| (it, part))) {
            let [vertices, triangles] = &mut sizes[places[instance.model as usize][part.material]];
            *vertices += part.mesh.positions.len() as u64;
            *triangles += part.mesh.triangles.len() as u64;
        }
        let mut meshes = Vec::new();
        for [vertices, triangles] in sizes {
            meshes.push(budget.mesh(vertices, triangles)?);
        }
        for (instance, part) in instances.iter().flat_map(|it| parts(it).map(move |part| (it, part))) {
            append(&mut meshes[places[instance.model as usize][part.material]], &part.mesh, instance);
        }
        let mut level = Level::default();
        for (material, mesh) in meshes.into_iter().enumerate().filter(|(_, mesh)| !mesh.triangles.is_empty())
        {
            check_finite(path, &mesh.positions)?;
            level.parts.push(Part { material, mesh });
        }
        Ok(Arc::new(Model { name: stem(path), materials, levels: vec![level] }))
    }
}

/// Adds a mesh as it stands somewhere.
fn append(to: &mut Mesh, mesh: &Mesh, place: &Instance) {
    let Instance { position, rotation, scale, .. } = *place;
    let first = to.positions.len() as u32;
    let stand = |point: &[f32; 3]| (position + rotation * (scale * Vec3::from(*point))).to_array();
    to.positions.extend(mesh.positions.iter().map(stand));
    to.normals.extend(mesh.normals.iter().map(|normal| (rotation * Vec3::from(*normal)).to_array()));
    to.uvs.extend(&mesh.uvs);
    to.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
}

/// The index of a material in a list, which gets it if it hasn't it.
///
/// # Errors
/// When there are too many.
pub(super) fn add_material(
    path: &Path,
    materials: &mut Vec<Material>,
    material: &Material,
) -> Result<usize, Error> {
    if let Some(index) = materials.iter().position(|other| other == material) {
        return Ok(index);
    }
    if materials.len() == MOST_MATERIALS {
        return Err(unsuitable(path, format!("a model of it has more than {MOST_MATERIALS} materials")));
    }
    materials.push(material.clone());
    Ok(materials.len() - 1)
}

/// What one file may still take.
pub(super) struct Budget<'a> {
    path: &'a Path,
    left: u64,
    instances: usize,
}

impl<'a> Budget<'a> {
    pub fn new(path: &'a Path) -> Self {
        Budget { path, left: MOST, instances: MOST_INSTANCES }
    }

    /// Room for so many elements.
    pub fn room<T>(&mut self, count: u64) -> Result<Vec<T>, Error> {
        self.take(count.saturating_mul(size_of::<T>() as u64))?;
        let mut room = Vec::new();
        room.try_reserve_exact(count as usize).map_err(|_| too_large(self.path))?;
        Ok(room)
    }

    /// The bytes of a file.
    pub fn bytes(&mut self, path: &Path) -> Result<Vec<u8>, Error> {
        let (file, length) = open(path)?;
        let mut bytes = self.room(length)?;
        // No more than was there before: there is room for that much.
        file.take(length)
            .read_to_end(&mut bytes)
            .map_err(|source| Error::Read { path: path.into(), source })?;
        Ok(bytes)
    }

    /// Counts memory that is taken elsewhere.
    pub fn take(&mut self, bytes: u64) -> Result<(), Error> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| too_large(self.path))?;
        Ok(())
    }

    /// Counts instances that are about to be made.
    pub fn instances(&mut self, count: usize) -> Result<(), Error> {
        self.instances = self.instances.checked_sub(count).ok_or_else(|| {
            unsuitable(self.path, format!("it places more than {MOST_INSTANCES} things, which is the most"))
        })?;
        // While the list grows, and once more when it is shared.
        self.take(3 * (count * size_of::<Instance>()) as u64)
    }

    /// Gives back what was only needed for a while.
    pub fn release<T>(&mut self, elements: Vec<T>) {
        self.left += (elements.capacity() * size_of::<T>()) as u64;
    }

    /// As [`release`](Self::release).
    pub fn release_mesh(&mut self, mesh: Mesh) {
        self.release(mesh.positions);
        self.release(mesh.normals);
        self.release(mesh.uvs);
        self.release(mesh.triangles);
    }

    /// The same mesh once more.
    pub fn copy(&mut self, mesh: &Mesh) -> Result<Mesh, Error> {
        let Mesh { positions, normals, uvs, triangles } = mesh;
        let mut copy = self.mesh(positions.len() as u64, triangles.len() as u64)?;
        copy.positions.extend(positions);
        copy.normals.extend(normals);
        copy.uvs.extend(uvs);
        copy.triangles.extend(triangles);
        Ok(copy)
    }

    /// Those triangles of a mesh, with the vertices that they need.
    pub fn part(&mut self, mesh: &Mesh, mut triangles: Vec<[u32; 3]>) -> Result<Mesh, Error> {
        let mut used = self.room(3 * triangles.len() as u64)?;
        used.extend(triangles.as_flattened());
        used.sort_unstable();
        used.dedup();
        for corner in triangles.as_flattened_mut() {
            *corner = used.binary_search(corner).unwrap_or(0) as u32;
        }
        let mut part = self.mesh(used.len() as u64, 0)?;
        part.positions.extend(used.iter().map(|vertex| mesh.positions[*vertex as usize]));
        part.normals.extend(used.iter().map(|vertex| mesh.normals[*vertex as usize]));
        part.uvs.extend(used.iter().map(|vertex| mesh.uvs[*vertex as usize]));
        part.triangles = triangles;
        self.release(used);
        Ok(part)
    }

    /// Room for a mesh of that size, and for the part that it becomes.
    pub fn mesh(&mut self, vertices: u64, triangles: u64) -> Result<Mesh, Error> {
        /// What an allocation takes beside its bytes, at most.
        const ALLOCATION: usize = 32;

        self.take((2 * size_of::<Part>() + 4 * ALLOCATION) as u64)?;
        Ok(Mesh {
            positions: self.room(vertices)?,
            normals: self.room(vertices)?,
            uvs: self.room(vertices)?,
            triangles: self.room(triangles)?,
        })
    }
}

/// Parts of a level in the making.
#[derive(Default)]
pub(super) struct Parts {
    pub materials: Vec<Material>,
    pub level: Level,
}

impl Parts {
    /// Adds triangles of a material of the file at `path`.
    pub fn add(&mut self, path: &Path, material: &Material, mesh: Mesh) -> Result<(), Error> {
        let material = add_material(path, &mut self.materials, material)?;
        self.level.parts.push(Part { material, mesh });
        Ok(())
    }

    pub fn into_model(self, name: String) -> Model {
        Model { name, materials: self.materials, levels: vec![self.level] }
    }
}

/// Refuses coordinates that are infinite or no numbers.
pub(super) fn check_finite<const N: usize>(path: &Path, vectors: &[[f32; N]]) -> Result<(), Error> {
    if vectors.as_flattened().iter().all(|coordinate| coordinate.is_finite()) {
        return Ok(());
    }
    let reason = "it has coordinates that are infinite or no numbers".into();
    Err(Error::Corrupt { path: path.into(), format: "model", reason })
}

/// What a surface of unknown colour is: grey, without gloss.
pub(super) fn grey() -> Material {
    Material { name: "grey".into(), reflectance: [[0.5; 3]; 2], ..Material::default() }
}

/// Gives every vertex the mean normal of the triangles around it, by their areas; +Y where there are none.
pub(super) fn smooth(mesh: &mut Mesh) {
    mesh.normals.clear();
    mesh.normals.resize(mesh.positions.len(), [0.0; 3]);
    for triangle in &mesh.triangles {
        let normal = Vec3::from(area_normal(&mesh.positions, *triangle));
        for corner in triangle {
            let sum = &mut mesh.normals[*corner as usize];
            *sum = (Vec3::from(*sum) + normal).into();
        }
    }
    mesh.normals.iter_mut().for_each(|normal| *normal = unit(*normal));
}

/// A normal of length 1, as it is if it is one; +Y if it has no direction.
pub(super) fn unit(normal: [f32; 3]) -> [f32; 3] {
    let vector = Vec3::from(normal);
    if vector.is_normalized() { normal } else { vector.try_normalize().unwrap_or(Vec3::Y).into() }
}

/// Twice the area of a triangle along its normal.
pub(super) fn area_normal(positions: &[[f32; 3]], triangle: [u32; 3]) -> [f32; 3] {
    let [a, b, c] = triangle.map(|corner| Vec3::from(positions[corner as usize]));
    (b - a).cross(c - a).into()
}

/// The path of a file that is named in that of `path`, as a relative path with `/`, and lies in the same folder or below;
/// `None` elsewhere.
pub(super) fn beside(path: &Path, name: &str) -> Option<PathBuf> {
    let inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    let plain = !name.is_empty() && !name.contains(':') && Path::new(name).components().all(inside);
    plain.then(|| path.with_file_name("").join(name))
}

pub(super) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

pub(super) fn unsuitable(path: &Path, reason: impl Into<String>) -> Error {
    Error::NoModel { path: path.into(), reason: reason.into() }
}

fn too_large(path: &Path) -> Error {
    let reason = format!(
        "it takes more than {} of memory, which is the most; reduce it, or cut it into several files",
        mebibytes(MOST)
    );
    Error::LargeModel { path: path.into(), reason }
}
