//! Writes the Rust side of every program's interface: `shaders::<room>::<stem>::{Shader, Push, Constants, Bindings}`.
//!
//! Structs of uniform and storage blocks are written once, by name, at the top of `shaders`; two shaders that give one
//! name two layouts are an error. Offsets and sizes are asserted at compile time.

use super::shader::{Binding, Constant, Program};
use spirq::{
    spirv::{Dim, ImageFormat},
    ty::AccessType,
    ty::{DescriptorType, ScalarType, SpirvType, StructType, Type},
};
use std::{collections::BTreeMap, fmt::Write};

/// The text of `shaders.rs`.
pub fn rust(programs: &[Program]) -> Result<String, String> {
    let mut shared = Structs::default();
    let mut rooms = BTreeMap::<&str, String>::new();
    for program in programs {
        let module = program_module(program, &mut shared)
            .map_err(|error| format!("glsl/{}/{}: {error}", program.room, program.stem))?;
        rooms.entry(&program.room).or_default().push_str(&module);
    }
    let mut text = String::from("// Written by build.rs from the SPIR-V of glsl/. Do not edit.\n\n");
    for definition in shared.definitions() {
        text += definition;
    }
    for (room, modules) in rooms {
        write!(text, "/// Programs of `glsl/{room}`.\npub mod {room} {{\n{modules}}}\n").expect(INFALLIBLE);
    }
    Ok(text)
}

const INFALLIBLE: &str = "writing to a string cannot fail";

/// Definitions of the structs that blocks are made of, by name.
#[derive(Default)]
pub struct Structs(BTreeMap<String, String>);

impl Structs {
    pub fn definitions(&self) -> impl Iterator<Item = &String> {
        self.0.values()
    }

    /// Adds `block` and the structs inside it; returns its path from inside a program's module.
    fn add(&mut self, block: &StructType) -> Result<String, String> {
        let name = block.name().ok_or("a struct has no name")?.to_owned();
        let definition = struct_definition(&name, block, self)?;
        match self.0.get(&name) {
            Some(other) if *other != definition => {
                Err(format!("struct `{name}` has another layout elsewhere:\n{definition}\n{other}"))
            }
            _ => {
                self.0.insert(name.clone(), definition);
                Ok(format!("crate::shaders::{name}"))
            }
        }
    }
}

/// The module of one program. The structs that it needs are added to `shared`.
pub fn program_module(program: &Program, shared: &mut Structs) -> Result<String, String> {
    let Program { room, stem, interface, .. } = program;
    let push = match &interface.push {
        Some(Type::Struct(block)) => struct_definition("Push", block, shared)?,
        Some(_) => return Err("the push constants are not a block".into()),
        None => "pub type Push = ();\n".into(),
    };
    let constants = constants(interface.constants.values(), interface.constants.keys())?;
    let bindings = bindings(&interface.bindings, shared)?;
    let mut stages = String::new();
    for stage in &program.stages {
        let file = program.spirv_file(stage.kind);
        write!(
            stages,
            "(StageKind::{:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\")) as &[u8]), ",
            stage.kind
        )
        .expect(INFALLIBLE);
    }
    let outputs: String =
        interface.outputs.iter().map(|(location, ty)| format!("/// - Writes {location}: `{ty}`\n")).collect();
    let kind = match interface.workgroup {
        Some(size) => {
            format!("impl ComputeInterface for Shader {{ const WORKGROUP: [u32; 3] = {size:?}; }}")
        }
        None => "impl RasterInterface for Shader {}".into(),
    };
    Ok(format!(
        "/// `glsl/{room}/{stem}`
pub mod {stem} {{
#[allow(unused_imports)] // One list for every program; each uses its share.
use crate::gpu::{{format, AccelerationStructure, Access, Bind, Bindable, BindingLayout, Buffer, ComputeInterface, Image, Interface, Layers, RasterInterface, ResourceKind, Specialize, StageKind, Texels}};
{outputs}#[derive(Clone, Copy, Debug)]
pub enum Shader {{}}
{push}{constants}{bindings}
impl Interface for Shader {{
    const NAME: &'static str = \"{room}/{stem}\";
    const STAGES: &'static [(StageKind, &'static [u8])] = &[{stages}];
    const BINDINGS: &'static [BindingLayout] = BINDINGS;
    type Push = Push;
    type Constants = Constants;
    type Bindings<'a> = Bindings<'a>;
}}
{kind}
}}
"
    ))
}

fn struct_definition(name: &str, block: &StructType, shared: &mut Structs) -> Result<String, String> {
    let mut fields = String::new();
    let mut checks = String::new();
    for member in &block.members {
        let field = member.name.as_deref().ok_or("a member has no name")?;
        let ty = value_type(&member.ty, shared).map_err(|error| format!("`{name}.{field}`: {error}"))?;
        let offset = member.offset.ok_or("a member has no offset")?;
        writeln!(fields, "    pub {field}: {ty},").expect(INFALLIBLE);
        writeln!(checks, "    assert!(core::mem::offset_of!({name}, {field}) == {offset});")
            .expect(INFALLIBLE);
    }
    let size = block.nbyte().ok_or("the block has no size")?;
    Ok(format!(
        "#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct {name} {{
{fields}}}
impl Default for {name} {{
    /// All zero.
    fn default() -> Self {{
        bytemuck::Zeroable::zeroed()
    }}
}}
const _: () = {{
{checks}    assert!(core::mem::size_of::<{name}>() == {size});
}};
"
    ))
}

/// The Rust type with the same bytes as `ty` in a block of scalar layout.
fn value_type(ty: &Type, shared: &mut Structs) -> Result<String, String> {
    Ok(match ty {
        Type::Scalar(scalar) => scalar_type(scalar)?.into(),
        Type::Vector(vector) => format!("[{}; {}]", scalar_type(&vector.scalar_ty)?, vector.nscalar),
        Type::Matrix(matrix) => {
            let column = &matrix.vector_ty;
            if matrix.stride != column.nbyte() {
                return Err("the columns of the matrix are padded; declare the block `scalar`".into());
            }
            format!("[[{}; {}]; {}]", scalar_type(&column.scalar_ty)?, column.nscalar, matrix.nvector)
        }
        Type::Array(array) => {
            let count = array.nelement.ok_or("an array without a length inside a struct")?;
            if array.stride != array.element_ty.nbyte() {
                return Err("the elements of the array are padded; declare the block `scalar`".into());
            }
            format!("[{}; {count}]", value_type(&array.element_ty, shared)?)
        }
        Type::Struct(block) => shared.add(block)?,
        other => return Err(format!("no Rust type for {other}")),
    })
}

fn scalar_type(scalar: &ScalarType) -> Result<&'static str, String> {
    Ok(match scalar {
        ScalarType::Float { bits: 32 } => "f32",
        ScalarType::Float { bits: 64 } => "f64",
        ScalarType::Integer { bits: 32, is_signed: false } => "u32",
        ScalarType::Integer { bits: 32, is_signed: true } => "i32",
        ScalarType::Integer { bits: 64, is_signed: false } => "u64",
        ScalarType::Integer { bits: 64, is_signed: true } => "i64",
        other => return Err(format!("no Rust type for {other}")),
    })
}

fn constants<'a>(
    constants: impl ExactSizeIterator<Item = &'a Constant>,
    ids: impl Iterator<Item = &'a u32>,
) -> Result<String, String> {
    if constants.len() == 0 {
        return Ok("pub type Constants = ();\n".into());
    }
    let (mut fields, mut defaults, mut entries) = (String::new(), String::new(), String::new());
    for (Constant { name, ty, default }, id) in constants.zip(ids) {
        let field = name.to_lowercase();
        let (ty, value, bits) = match ty {
            Type::Scalar(ScalarType::Boolean) => ("bool", (*default != 0).to_string(), "u32::from"),
            Type::Scalar(ScalarType::Float { bits: 32 }) => {
                ("f32", format!("f32::from_bits({default:#x})"), "f32::to_bits")
            }
            Type::Scalar(ScalarType::Integer { bits: 32, is_signed: false }) => {
                ("u32", default.to_string(), "u32::from")
            }
            Type::Scalar(ScalarType::Integer { bits: 32, is_signed: true }) => {
                ("i32", (*default as i32).to_string(), "i32::cast_unsigned")
            }
            other => return Err(format!("constant `{name}`: no Rust type for {other}")),
        };
        writeln!(fields, "    pub {field}: {ty},").expect(INFALLIBLE);
        writeln!(defaults, "            {field}: {value},").expect(INFALLIBLE);
        write!(entries, "({id}, {bits}(self.{field})), ").expect(INFALLIBLE);
    }
    Ok(format!(
        "#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {{
{fields}}}
impl Default for Constants {{
    fn default() -> Self {{
        Constants {{
{defaults}        }}
    }}
}}
impl Specialize for Constants {{
    fn entries(&self) -> Vec<(u32, u32)> {{
        vec![{entries}]
    }}
}}
"
    ))
}

fn bindings(bindings: &BTreeMap<u32, Binding>, shared: &mut Structs) -> Result<String, String> {
    if bindings.is_empty() {
        return Ok("pub type Bindings<'a> = ();\nconst BINDINGS: &[BindingLayout] = &[];\n".into());
    }
    let (mut fields, mut resources, mut layouts) = (String::new(), String::new(), String::new());
    for (index, Binding { name, kind: descriptor, ty }) in bindings {
        let (resource, kind) =
            resource_type(descriptor, ty, shared).map_err(|error| format!("binding `{name}`: {error}"))?;
        writeln!(fields, "    pub {name}: &'a {resource},").expect(INFALLIBLE);
        write!(resources, "self.{name} as &dyn Bindable, ").expect(INFALLIBLE);
        let access = access(descriptor);
        write!(
            layouts,
            "BindingLayout {{ binding: {index}, kind: ResourceKind::{kind}, access: Access::{access} }}, "
        )
        .expect(INFALLIBLE);
    }
    Ok(format!(
        "#[derive(Clone, Copy)]
pub struct Bindings<'a> {{
{fields}}}
impl Bind for Bindings<'_> {{
    fn resources(&self) -> Vec<&dyn Bindable> {{
        vec![{resources}]
    }}
}}
const BINDINGS: &[BindingLayout] = &[{layouts}];
"
    ))
}

/// The Rust type of a binding and the kind of its descriptor.
fn resource_type(
    kind: &DescriptorType,
    ty: &Type,
    shared: &mut Structs,
) -> Result<(String, &'static str), String> {
    match (kind, ty) {
        (DescriptorType::StorageImage(_), Type::StorageImage(image)) => {
            let shape = match (image.dim, image.is_array) {
                (Dim::Dim2D, false) => "Image",
                (Dim::Dim2D, true) => "Layers",
                _ => return Err(format!("images are 2D or 2D arrays, not {:?}", image.dim)),
            };
            Ok((format!("{shape}<format::{}>", image_format(&image.fmt)?), "StorageImage"))
        }
        (DescriptorType::UniformBuffer(), Type::Struct(block)) => {
            Ok((format!("Buffer<{}>", shared.add(block)?), "UniformBuffer"))
        }
        (DescriptorType::StorageBuffer(_), Type::Struct(block)) => {
            let element = match block.members.as_slice() {
                [member] => match &member.ty {
                    Type::Array(array) if array.nelement.is_none() => {
                        if array.stride != array.element_ty.nbyte() {
                            return Err("the elements are padded; declare the block `scalar`".into());
                        }
                        value_type(&array.element_ty, shared)?
                    }
                    _ => shared.add(block)?,
                },
                _ => shared.add(block)?,
            };
            Ok((format!("Buffer<{element}>"), "StorageBuffer"))
        }
        (DescriptorType::UniformTexelBuffer(), _) => Ok(("Texels".into(), "TexelBuffer")),
        (DescriptorType::AccelStruct(), _) => Ok(("AccelerationStructure".into(), "AccelerationStructure")),
        (kind, _) => Err(format!("{kind:?} is not bound by this engine")),
    }
}

/// What the shader does with the resource, as its qualifiers say.
fn access(kind: &DescriptorType) -> &'static str {
    match kind {
        DescriptorType::StorageImage(access) | DescriptorType::StorageBuffer(access) => match access {
            AccessType::ReadOnly => "Read",
            AccessType::WriteOnly => "Write",
            AccessType::ReadWrite => "ReadWrite",
        },
        _ => "Read",
    }
}

fn image_format(format: &ImageFormat) -> Result<&'static str, String> {
    Ok(match format {
        ImageFormat::R32f => "R32f",
        ImageFormat::Rg32f => "Rg32f",
        ImageFormat::Rgba32f => "Rgba32f",
        ImageFormat::Rgba16f => "Rgba16f",
        ImageFormat::Rgba8 => "Rgba8",
        ImageFormat::R32ui => "R32ui",
        ImageFormat::Rgba32ui => "Rgba32ui",
        other => {
            return Err(format!(
                "format {other:?} has no marker in gpu::format; add it, or declare the format"
            ));
        }
    })
}
