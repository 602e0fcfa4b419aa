//! The JSON of a glTF file, as far as models, what stands where, light and cameras go (glTF 2.0, §5). What is not
//! named here is skipped when a file is read.

use serde::de::{Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::fmt;
use std::marker::PhantomData;

/// Index into one of the lists of [`Document`].
pub type Index = u32;

/// Most elements of a list. `{}` is a node, and takes fifty times the memory of its two letters: files are refused before
/// they take more than can be spared.
pub const MOST_OBJECTS: usize = 1 << 17;

#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Document {
    pub asset: Asset,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub extensions_used: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub extensions_required: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<Index>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub scenes: Vec<Scene>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub nodes: Vec<Node>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub meshes: Vec<Mesh>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub materials: Vec<Material>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub textures: Vec<Texture>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub images: Vec<Image>,
    #[serde(skip_serializing_if = "Vec::is_empty", skip_deserializing)]
    pub samplers: Vec<Sampler>,
    #[serde(skip_serializing_if = "Vec::is_empty", skip_deserializing)]
    pub cameras: Vec<Camera>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub buffers: Vec<Buffer>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "few")]
    pub accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Option::is_none", skip_deserializing)]
    pub extensions: Option<DocumentExtensions>,
}

#[derive(Default, Serialize, Deserialize)]
pub struct Asset {
    pub version: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<String>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Scene {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<Index>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Node {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<Box<str>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Index>,
    #[serde(skip_serializing)]
    pub skin: Option<Index>,
    #[serde(skip_serializing)]
    pub matrix: Option<Box<[f32; 16]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f32; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extensions: Option<Box<NodeExtensions>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Box<RawValue>>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing", skip_serializing_if = "Option::is_none")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "MSFT_lod", skip_serializing_if = "Option::is_none")]
    pub levels: Option<Levels>,
    #[serde(rename = "KHR_lights_punctual", skip_serializing_if = "Option::is_none", skip_deserializing)]
    pub light: Option<LightOfNode>,
}

#[derive(Serialize, Deserialize)]
pub struct Instancing {
    pub attributes: InstanceAttributes,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(default, rename_all = "UPPERCASE")]
pub struct InstanceAttributes {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Index>,
    /// Ours: the two halves of a random number, the lower one first. (Integers of 32 bits are for indices alone.)
    #[serde(rename = "_RANDOM", skip_serializing_if = "Option::is_none")]
    pub random: Option<Index>,
}

/// Nodes that stand for this one where it is seen from afar, the finest first.
#[derive(Serialize, Deserialize)]
pub struct Levels {
    pub ids: Vec<Index>,
}

#[derive(Serialize)]
pub struct LightOfNode {
    pub light: Index,
}

/// What a node says in its `extras`.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct NodeExtras {
    /// Of [`crate::scene::Level`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<f32>,
    /// Of [`crate::scene::Instance`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub random: Option<u32>,
    /// Land or sea: a world that takes the file in has its own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ground: bool,
    /// The least share of the picture's height that the node and its [`Levels`] are good for, in their order.
    #[serde(rename = "MSFT_screencoverage", skip_serializing_if = "Vec::is_empty")]
    pub screen_coverage: Vec<f32>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Mesh {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<Box<str>>,
    #[serde(deserialize_with = "few")]
    pub primitives: Vec<Primitive>,
}

#[derive(Serialize, Deserialize)]
pub struct Primitive {
    pub attributes: Attributes,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub indices: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    #[serde(skip_serializing)]
    pub extensions: Option<PrimitiveExtensions>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Attributes {
    #[serde(rename = "POSITION", skip_serializing_if = "Option::is_none")]
    pub position: Option<Index>,
    #[serde(rename = "NORMAL", skip_serializing_if = "Option::is_none")]
    pub normal: Option<Index>,
    #[serde(rename = "TEXCOORD_0", skip_serializing_if = "Option::is_none")]
    pub uv: Option<Index>,
    #[serde(rename = "COLOR_0", skip_serializing_if = "Option::is_none")]
    pub color: Option<Index>,
}

/// What a primitive may be packed into.
#[derive(Default, Deserialize)]
#[serde(default)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Present>,
}

/// An object that is there, whatever is in it.
#[derive(Deserialize)]
pub struct Present {}

#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Material {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<Box<str>>,
    pub pbr_metallic_roughness: Surface,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub double_sided: bool,
    /// "BLEND" for what is seen through.
    #[serde(skip_serializing_if = "Option::is_none", skip_deserializing)]
    pub alpha_mode: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extensions: Option<Box<MaterialExtensions>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Box<RawValue>>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Surface {
    /// Linear Rec.709 and the share of light that is stopped.
    pub base_color_factor: [f32; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color_texture: Option<TextureOfMaterial>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
}

impl Default for Surface {
    fn default() -> Self {
        Surface {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
        }
    }
}

#[derive(Serialize, Deserialize)]
pub struct TextureOfMaterial {
    pub index: Index,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct MaterialExtensions {
    #[serde(rename = "KHR_materials_ior", skip_serializing_if = "Option::is_none")]
    pub ior: Option<RefractiveIndex>,
    #[serde(rename = "KHR_materials_diffuse_transmission", skip_serializing)]
    pub transmission: Option<DiffuseTransmission>,
}

#[derive(Serialize, Deserialize)]
#[serde(default)]
pub struct RefractiveIndex {
    pub ior: f32,
}

impl Default for RefractiveIndex {
    fn default() -> Self {
        RefractiveIndex { ior: 1.5 }
    }
}

/// Of the light that is not reflected at the surface, a share goes through, and takes on a colour of its own.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct DiffuseTransmission {
    pub diffuse_transmission_factor: f32,
    pub diffuse_transmission_color_factor: [f32; 3],
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        DiffuseTransmission { diffuse_transmission_factor: 0.0, diffuse_transmission_color_factor: [1.0; 3] }
    }
}

/// What a material of ours says in its `extras`: see [`crate::scene::Material`].
#[derive(Serialize, Deserialize)]
pub struct MaterialExtras {
    pub reflectance: [[f32; 3]; 2],
    pub position_factor: f32,
    pub value_factor: f32,
    pub transmittance: [f32; 3],
}

#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Texture {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Index>,
    #[serde(skip_serializing_if = "Option::is_none", skip_deserializing)]
    pub sampler: Option<Index>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Image {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mime_type: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffer_view: Option<Index>,
}

/// How a texture goes on beyond its edges; by the schema's numbers.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Sampler {
    pub wrap_s: u32,
    pub wrap_t: u32,
}

#[derive(Serialize)]
pub struct Camera {
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub perspective: Perspective,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    pub aspect_ratio: f32,
    /// Vertical field of view, radians.
    pub yfov: f32,
    pub znear: f32,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Buffer {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    pub byte_length: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: Index,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_stride: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffer_view: Option<Index>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: Kind,
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub min: Option<[f64; 3]>,
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    pub max: Option<[f64; 3]>,
    #[serde(skip_serializing)]
    pub sparse: Option<Present>,
}

/// How many numbers an element of an accessor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Kind {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    Mat2,
    Mat3,
    Mat4,
}

impl Kind {
    pub fn components(self) -> usize {
        match self {
            Kind::Scalar => 1,
            Kind::Vec2 => 2,
            Kind::Vec3 => 3,
            Kind::Vec4 | Kind::Mat2 => 4,
            Kind::Mat3 => 9,
            Kind::Mat4 => 16,
        }
    }
}

#[derive(Serialize)]
pub struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Lights,
}

#[derive(Serialize)]
pub struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Serialize)]
pub struct Light {
    pub name: &'static str,
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Linear Rec.709.
    pub color: [f32; 3],
    /// Of a directional light: lux.
    pub intensity: f32,
}

/// Reads a list of at most [`MOST_OBJECTS`].
fn few<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct Few<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Few<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "a list of at most {MOST_OBJECTS} elements")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Vec<T>, A::Error> {
            let mut list = Vec::new();
            while let Some(element) = elements.next_element()? {
                if list.len() == MOST_OBJECTS {
                    return Err(serde::de::Error::invalid_length(list.len() + 1, &self));
                }
                list.push(element);
            }
            Ok(list)
        }
    }

    deserializer.deserialize_seq(Few(PhantomData))
}
