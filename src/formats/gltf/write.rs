//! Building a glTF file piece by piece: objects go into the document at once, numbers are named and flow into the file
//! when it is written.

use super::PROGRAM;
use super::document::*;
use crate::core::mesh;
use crate::formats::Error;
use crate::formats::file::{self, Written};
use crate::scene;
use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use std::io::{self, Write};
use std::path::Path;

/// A glTF file in the making, whose numbers live at least as long as `'a`.
#[derive(Default)]
pub struct Builder<'a> {
    pub document: Document,
    materials: Vec<scene::Material>,
    pieces: Vec<Piece<'a>>,
    /// Of all pieces, each filled up to a multiple of 4.
    bytes: u64,
}

/// Numbers that make up one buffer view.
struct Piece<'a> {
    bytes: u64,
    write: Box<Fill<'a>>,
}

type Fill<'a> = dyn Fn(&mut dyn Write) -> io::Result<()> + 'a;

/// The schema's numbers for what a buffer view is good for.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The schema's numbers for the types of components.
pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

impl<'a> Builder<'a> {
    /// Adds a node; returns its index.
    pub fn node(&mut self, node: Node) -> Index {
        push(&mut self.document.nodes, node)
    }

    /// Notes that an extension is in use.
    pub fn extension(&mut self, name: &str) {
        note(&mut self.document.extensions_used, name);
    }

    /// Notes that the file makes no sense without an extension.
    pub fn required_extension(&mut self, name: &str) {
        self.extension(name);
        note(&mut self.document.extensions_required, name);
    }

    /// Adds a mesh of parts, each with the index of its material, that have triangles; `None` if none has.
    pub fn mesh(
        &mut self,
        name: &str,
        parts: impl IntoIterator<Item = (&'a mesh::Mesh, Index)>,
    ) -> Option<Index> {
        let filled = parts.into_iter().filter(|(mesh, _)| !mesh.triangles.is_empty());
        let primitives: Vec<Primitive> =
            filled.map(|(mesh, material)| self.primitive(mesh, material)).collect();
        if primitives.is_empty() {
            return None;
        }
        Some(push(&mut self.document.meshes, Mesh { name: Some(name.into()), primitives }))
    }

    fn primitive(&mut self, mesh: &'a mesh::Mesh, material: Index) -> Primitive {
        let mesh::Mesh { positions, normals, uvs, triangles } = mesh;
        let vertices = positions.len() as u64;
        let [least, most] = mesh.bounds().map(|corner| corner.map(f64::from));
        let position = self.floats(vertices, Some(VERTICES), || positions.iter().copied());
        let accessor = &mut self.document.accessors[position as usize];
        (accessor.min, accessor.max) = (Some(least), Some(most));
        let normal = self.floats(vertices, Some(VERTICES), || normals.iter().copied());
        let uv = self.floats(vertices, Some(VERTICES), || uvs.iter().copied());
        let count = 3 * triangles.len() as u64;
        let corners = || triangles.iter().flatten();
        let indices = match index_type(vertices) {
            U16 => self.accessor(U16, Kind::Scalar, count, 2, Some(INDICES), move |out| {
                corners().try_for_each(|&index| out.write_all(&(index as u16).to_le_bytes()))
            }),
            component => self.accessor(component, Kind::Scalar, count, 4, Some(INDICES), move |out| {
                corners().try_for_each(|index| out.write_all(&index.to_le_bytes()))
            }),
        };
        Primitive {
            attributes: Attributes {
                position: Some(position),
                normal: Some(normal),
                uv: Some(uv),
                color: None,
            },
            indices: Some(indices),
            material: Some(material),
            mode: None,
            extensions: None,
        }
    }

    /// Adds a material, once however often it is asked for.
    pub fn material(&mut self, material: &scene::Material) -> Index {
        if let Some(index) = self.materials.iter().position(|other| other == material) {
            return index as Index;
        }
        self.materials.push(material.clone());
        let scene::Material { name, roughness, refractive_index, .. } = material;
        let [red, green, blue] = material.mean_reflectance();
        let ior = RefractiveIndex { ior: *refractive_index };
        // What a file doesn't say is that of glass.
        let extensions = (ior.ior != RefractiveIndex::default().ior).then(|| {
            self.extension("KHR_materials_ior");
            Box::new(MaterialExtensions { ior: Some(ior), transmission: None })
        });
        let extras = MaterialExtras {
            reflectance: material.reflectance,
            position_factor: material.position_factor,
            value_factor: material.value_factor,
            transmittance: material.transmittance,
        };
        let material = Material {
            name: Some(name.as_str().into()),
            pbr_metallic_roughness: Surface {
                base_color_factor: [red, green, blue, 1.0],
                metallic_factor: 0.0,
                roughness_factor: *roughness,
                ..Surface::default()
            },
            // Both sides scatter; leaves have no thickness and are seen from either.
            double_sided: true,
            alpha_mode: None,
            extensions,
            extras: raw(&extras),
        };
        push(&mut self.document.materials, material)
    }

    /// Adds the material of land: one colour, rough, seen from above.
    pub fn land_material(&mut self, name: &str, [red, green, blue]: [f32; 3]) -> Index {
        let surface = Surface {
            base_color_factor: [red, green, blue, 1.0],
            metallic_factor: 0.0,
            ..Surface::default()
        };
        self.other_material(Material {
            name: Some(name.into()),
            pbr_metallic_roughness: surface,
            ..Material::default()
        })
    }

    /// Adds a material that nothing else has.
    pub fn other_material(&mut self, material: Material) -> Index {
        // Keeps the places of both lists the same.
        let name = material.name.as_deref().unwrap_or_default().into();
        self.materials.push(scene::Material { name, ..scene::Material::default() });
        push(&mut self.document.materials, material)
    }

    /// Adds a PNG as a texture that ends where the picture does.
    pub fn texture(&mut self, png: &'a [u8]) -> TextureOfMaterial {
        const CLAMP_TO_EDGE: u32 = 33071;

        let view = self.view(png.len() as u64, None, move |out| out.write_all(png));
        let image = Image { mime_type: Some("image/png".into()), buffer_view: Some(view), uri: None };
        let source = Some(push(&mut self.document.images, image));
        let sampler = Sampler { wrap_s: CLAMP_TO_EDGE, wrap_t: CLAMP_TO_EDGE };
        let sampler = Some(push(&mut self.document.samplers, sampler));
        TextureOfMaterial { index: push(&mut self.document.textures, Texture { source, sampler }) }
    }

    /// Adds an accessor over so many vectors of floats that `vectors` yields.
    pub fn floats<const N: usize, I: Iterator<Item = [f32; N]>>(
        &mut self,
        count: u64,
        target: Option<u32>,
        vectors: impl Fn() -> I + 'a,
    ) -> Index {
        let kind = match N {
            2 => Kind::Vec2,
            3 => Kind::Vec3,
            _ => Kind::Vec4,
        };
        self.accessor(F32, kind, count, 4 * N as u64, target, move |out| {
            vectors().try_for_each(|vector| vector.iter().try_for_each(|x| out.write_all(&x.to_le_bytes())))
        })
    }

    /// Adds an accessor over numbers that begin a buffer view of their own; `write` writes `count` elements of `size` bytes
    /// each.
    pub fn accessor(
        &mut self,
        component_type: u32,
        kind: Kind,
        count: u64,
        size: u64,
        target: Option<u32>,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> Index {
        let accessor = Accessor {
            buffer_view: Some(self.view(count * size, target, write)),
            byte_offset: 0,
            component_type,
            normalized: false,
            count,
            kind,
            min: None,
            max: None,
            sparse: None,
        };
        push(&mut self.document.accessors, accessor)
    }

    /// Adds a buffer view over bytes of its own.
    fn view(
        &mut self,
        bytes: u64,
        target: Option<u32>,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> Index {
        let view =
            BufferView { buffer: 0, byte_offset: self.bytes, byte_length: bytes, byte_stride: None, target };
        self.pieces.push(Piece { bytes, write: Box::new(write) });
        self.bytes += bytes.next_multiple_of(4);
        push(&mut self.document.buffer_views, view)
    }

    /// Writes the binary form, with `roots` as the nodes of its scene.
    ///
    /// # Errors
    /// Those of [`file::write()`], and for more than the 4 GiB that a .glb file can have.
    pub fn write(mut self, path: &Path, roots: Vec<Index>) -> Result<Written, Error> {
        self.document.asset = Asset {
            version: "2.0".into(),
            generator: Some(format!("{PROGRAM}{}", env!("CARGO_PKG_VERSION"))),
        };
        self.document.scene = Some(0);
        self.document.scenes = vec![Scene { nodes: roots }];
        if self.bytes > 0 {
            self.document.buffers = vec![Buffer { uri: None, byte_length: self.bytes }];
        }
        // Nothing in it can fail to be written as JSON.
        let mut json = serde_json::to_string(&self.document).unwrap_or_default();
        // Chunks are multiples of 4 bytes long: JSON is filled up with spaces (§4.4.3).
        json.extend(std::iter::repeat_n(' ', json.len().next_multiple_of(4) - json.len()));
        let lengths = (u32::try_from(self.bytes), u32::try_from(file_bytes(json.len() as u64, self.bytes)));
        let (Ok(binary_length), Ok(length)) = lengths else { return Err(super::too_large(path)) };
        file::write(path, |writer| {
            let integer = |writer: &mut dyn Write, value: u32| writer.write_all(&value.to_le_bytes());
            // Header and chunks (§4.4.2, §4.4.3); all numbers are little-endian.
            writer.write_all(b"glTF")?;
            integer(writer, 2)?;
            integer(writer, length)?;
            integer(writer, json.len() as u32)?;
            writer.write_all(b"JSON")?;
            writer.write_all(json.as_bytes())?;
            integer(writer, binary_length)?;
            writer.write_all(b"BIN\0")?;
            for piece in &self.pieces {
                (piece.write)(writer)?;
                let padding = piece.bytes.next_multiple_of(4) - piece.bytes;
                writer.write_all(&[0; 3][..padding as usize])?;
            }
            Ok(())
        })
    }
}

/// Bytes of a mesh in the binary chunk.
pub fn mesh_bytes(vertices: u64, triangles: u64) -> u64 {
    let index = if index_type(vertices) == U16 { 2 } else { 4 };
    32 * vertices + (3 * index * triangles).next_multiple_of(4)
}

/// Bytes of a file: the header, two chunk headers and the chunks.
pub fn file_bytes(json: u64, binary: u64) -> u64 {
    12 + 8 + json + 8 + binary
}

/// What a node or material says in its own words.
pub fn raw(extras: &impl Serialize) -> Option<Box<RawValue>> {
    to_raw_value(extras).ok()
}

/// Type of the indices into so many vertices. The greatest number of a type is no index: it may mean that a primitive
/// starts anew (§3.7.2.1).
fn index_type(vertices: u64) -> u32 {
    if vertices <= u64::from(u16::MAX) { U16 } else { U32 }
}

/// Adds a name to a list that hasn't it.
fn note(names: &mut Vec<String>, name: &str) {
    if !names.iter().any(|other| other == name) {
        names.push(name.into());
    }
}

/// The index of what is added to a list.
pub fn push<T>(list: &mut Vec<T>, element: T) -> Index {
    list.push(element);
    list.len() as Index - 1
}
