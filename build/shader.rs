//! From GLSL files to programs: compiled (shaderc) and reflected (spirq).
//!
//! The files of one room with one stem are one program: `raster/terrain.{vert,tesc,tese,frag}`. What its stages
//! declare is merged; two stages that disagree about a binding, a constant or the push block are an error here, not
//! a garbled picture later.

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, TargetEnv};
use spirq::{
    ReflectConfig,
    ty::{DescriptorType, Type},
    var::Variable,
};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// A compute shader, or the stages of one raster pipeline.
pub struct Program {
    /// Folder under `glsl/`: `terrain`.
    pub room: String,
    /// File name without its ending: `thermal`.
    pub stem: String,
    pub stages: Vec<Stage>,
    pub interface: Interface,
}

pub struct Stage {
    pub kind: StageKind,
    pub spirv: Vec<u32>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum StageKind {
    Vertex,
    TessellationControl,
    TessellationEvaluation,
    Fragment,
    Compute,
}

/// What a program declares, over all of its stages.
#[derive(Default)]
pub struct Interface {
    pub bindings: BTreeMap<u32, Binding>,
    pub push: Option<Type>,
    pub constants: BTreeMap<u32, Constant>,
    /// What the last stage writes, by location: the colours of a raster pipeline.
    pub outputs: BTreeMap<u32, Type>,
    /// Compute only.
    pub workgroup: Option<[u32; 3]>,
}

#[derive(Clone, PartialEq, Debug)]
pub struct Binding {
    pub name: String,
    pub kind: DescriptorType,
    pub ty: Type,
}

#[derive(Clone, PartialEq, Debug)]
pub struct Constant {
    pub name: String,
    pub ty: Type,
    /// Bits of the value that the GLSL gives it.
    pub default: u32,
}

impl Program {
    /// Name of a stage's SPIR-V file.
    pub fn spirv_file(&self, kind: StageKind) -> String {
        format!("{}.{}.{}.spv", self.room, self.stem, kind.extension())
    }
}

impl StageKind {
    pub fn extension(self) -> &'static str {
        match self {
            StageKind::Vertex => "vert",
            StageKind::TessellationControl => "tesc",
            StageKind::TessellationEvaluation => "tese",
            StageKind::Fragment => "frag",
            StageKind::Compute => "comp",
        }
    }

    fn from_extension(extension: &str) -> Option<StageKind> {
        use StageKind::*;
        [Vertex, TessellationControl, TessellationEvaluation, Fragment, Compute]
            .into_iter()
            .find(|kind| kind.extension() == extension)
    }

    fn shaderc(self) -> shaderc::ShaderKind {
        match self {
            StageKind::Vertex => shaderc::ShaderKind::Vertex,
            StageKind::TessellationControl => shaderc::ShaderKind::TessControl,
            StageKind::TessellationEvaluation => shaderc::ShaderKind::TessEvaluation,
            StageKind::Fragment => shaderc::ShaderKind::Fragment,
            StageKind::Compute => shaderc::ShaderKind::Compute,
        }
    }
}

/// The files of one program.
pub struct Source {
    pub room: String,
    pub stem: String,
    pub files: Vec<(StageKind, PathBuf)>,
}

/// The files of every program under `glsl`, in the order of their names. `glsl/lib` is included only.
pub fn sources(glsl: &Path) -> Result<Vec<Source>, String> {
    let mut sources = BTreeMap::<(String, String), Source>::new();
    for path in shader_files(glsl)? {
        let kind = extension(&path).and_then(StageKind::from_extension).ok_or_else(|| {
            format!("{}: not the name of a shader stage (.comp .vert .tesc .tese .frag)", path.display())
        })?;
        let room = file_stem(path.parent().unwrap_or(glsl));
        let stem = file_stem(&path);
        let source = sources.entry((room.clone(), stem.clone())).or_insert_with(|| Source {
            room,
            stem,
            files: Vec::new(),
        });
        source.files.push((kind, path));
    }
    for source in sources.values_mut() {
        source.files.sort_by_key(|(kind, _)| *kind);
    }
    Ok(sources.into_values().collect())
}

/// Every program under `glsl`, in the order of their names.
pub fn compile_all(glsl: &Path) -> Result<Vec<Program>, String> {
    let compiler = Compiler::new().map_err(|error| error.to_string())?;
    sources(glsl)?.into_iter().map(|source| source.compile(&compiler, glsl)).collect()
}

impl Source {
    pub fn compile(&self, compiler: &Compiler, glsl: &Path) -> Result<Program, String> {
        let Source { room, stem, files } = self;
        let (mut stages, mut interface) = (Vec::new(), Interface::default());
        for (kind, path) in files {
            let spirv = compile(compiler, glsl, path, *kind, OptimizationLevel::Performance)?;
            // Optimization drops what is declared and not used; the promise is what the source declares.
            let declared = compile(compiler, glsl, path, *kind, OptimizationLevel::Zero)?;
            interface
                .add_stage(*kind, &declared)
                .map_err(|error| format!("{}: {error}", label(glsl, path)))?;
            stages.push(Stage { kind: *kind, spirv });
        }
        let computes = stages.iter().any(|stage| stage.kind == StageKind::Compute);
        if computes && stages.len() > 1 {
            return Err(format!("glsl/{room}/{stem}: a compute shader beside raster stages"));
        }
        if computes && interface.workgroup.is_none() {
            return Err(format!("glsl/{room}/{stem}: the workgroup size is not literal"));
        }
        Ok(Program { room: room.clone(), stem: stem.clone(), stages, interface })
    }
}

fn shader_files(glsl: &Path) -> Result<Vec<PathBuf>, String> {
    let list = |folder: &Path| -> Result<Vec<PathBuf>, String> {
        let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let mut paths = entries
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<Vec<_>, _>>()
            .map_err(|error| format!("{}: {error}", folder.display()))?;
        paths.sort();
        Ok(paths)
    };
    let mut files = Vec::new();
    for room in list(glsl)? {
        if room.is_dir() && file_stem(&room) != "lib" {
            // Editors keep files of their own beside what is edited.
            files.extend(list(&room)?.into_iter().filter(|path| !file_stem(path).starts_with('.')));
        }
    }
    Ok(files)
}

fn compile(
    compiler: &Compiler,
    glsl: &Path,
    path: &Path,
    kind: StageKind,
    level: OptimizationLevel,
) -> Result<Vec<u32>, String> {
    let source = fs::read_to_string(path).map_err(|error| format!("{}: {error}", label(glsl, path)))?;
    let mut options = CompileOptions::new().map_err(|error| error.to_string())?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_optimization_level(level);
    options.set_warnings_as_errors();
    options.set_include_callback(|name, _, _, _| {
        let content = fs::read_to_string(glsl.join(name)).map_err(|error| format!("glsl/{name}: {error}"))?;
        Ok(ResolvedInclude { resolved_name: format!("glsl/{name}"), content })
    });
    let name = label(glsl, path);
    let artifact = compiler
        .compile_into_spirv(&source, kind.shaderc(), &name, "main", Some(&options))
        .map_err(|error| error.to_string())?;
    Ok(artifact.as_binary().to_vec())
}

impl Interface {
    fn add_stage(&mut self, kind: StageKind, spirv: &[u32]) -> Result<(), String> {
        let entry_points = ReflectConfig::new()
            .spv(spirv)
            .ref_all_rscs(true)
            .combine_img_samplers(true)
            .reflect()
            .map_err(|error| error.to_string())?;
        let [entry_point] = entry_points.as_slice() else {
            return Err(format!("{} entry points where one is expected", entry_points.len()));
        };
        let defaults = specialization_defaults(spirv);
        let mut outputs = BTreeMap::new();
        for variable in &entry_point.vars {
            match variable {
                Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                    let name = name.clone().filter(|name| !name.is_empty()).or_else(|| block_name(ty));
                    let name = name.ok_or_else(|| format!("the resource at {desc_bind} has no name"))?;
                    if desc_bind.set() != 0 {
                        return Err(format!(
                            "`{name}` is in set {}; everything lives in set 0",
                            desc_bind.set()
                        ));
                    }
                    let binding = Binding { name, kind: desc_ty.clone(), ty: ty.clone() };
                    merge(&mut self.bindings, desc_bind.bind(), binding)?;
                }
                Variable::PushConstant { ty, .. } => match &self.push {
                    Some(other) if other != ty => return Err("another stage has another push block".into()),
                    _ => self.push = Some(ty.clone()),
                },
                Variable::SpecConstant { name, spec_id, ty } => {
                    let name = name.clone().ok_or_else(|| format!("constant {spec_id} has no name"))?;
                    let default = *defaults
                        .get(spec_id)
                        .ok_or_else(|| format!("constant `{name}` has no 32-bit default"))?;
                    merge(&mut self.constants, *spec_id, Constant { name, ty: ty.clone(), default })?;
                }
                Variable::Input { name, location, ty } => {
                    // Those of tessellation are arrays over the vertices of a patch.
                    if kind == StageKind::Fragment && self.outputs.get(&location.loc()) != Some(ty) {
                        let name = name.clone().unwrap_or_default();
                        return Err(format!("the stage before writes no {ty} for `{name}`"));
                    }
                }
                Variable::Output { location, ty, .. } => {
                    outputs.insert(location.loc(), ty.clone());
                }
            }
        }
        self.outputs = outputs;
        self.workgroup = self.workgroup.or(workgroup(spirv));
        Ok(())
    }
}

/// A block without an instance name goes by its own: `buffer Items { … };` is `items`.
fn block_name(ty: &Type) -> Option<String> {
    let Type::Struct(block) = ty else { return None };
    block.name().map(str::to_lowercase)
}

fn merge<T: PartialEq + std::fmt::Debug>(
    map: &mut BTreeMap<u32, T>,
    id: u32,
    value: T,
) -> Result<(), String> {
    match map.get(&id) {
        Some(other) if *other != value => {
            Err(format!("two meanings of {id}:\n  {value:?}\n  {other:?} (an earlier stage)"))
        }
        _ => {
            map.insert(id, value);
            Ok(())
        }
    }
}

// SPIR-V 1.6, sections 3.6, 3.20 and 3.52: the two things that the reflection library leaves out.
const OP_EXECUTION_MODE: u32 = 16;
const OP_EXECUTION_MODE_ID: u32 = 331;
const OP_CONSTANT: u32 = 43;
const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_DECORATE: u32 = 71;
const MODE_LOCAL_SIZE: u32 = 17;
const MODE_LOCAL_SIZE_ID: u32 = 38;
const DECORATION_SPEC_ID: u32 = 1;

/// Literal workgroup size of a compute shader.
fn workgroup(spirv: &[u32]) -> Option<[u32; 3]> {
    let constant = |id: u32| {
        instructions(spirv).find_map(|(op, words)| match words {
            [_, result, value] if op == OP_CONSTANT && *result == id => Some(*value),
            _ => None,
        })
    };
    instructions(spirv).find_map(|(op, words)| match words {
        [_, MODE_LOCAL_SIZE, x, y, z] if op == OP_EXECUTION_MODE => Some([*x, *y, *z]),
        [_, MODE_LOCAL_SIZE_ID, x, y, z] if op == OP_EXECUTION_MODE_ID => {
            Some([constant(*x)?, constant(*y)?, constant(*z)?])
        }
        _ => None,
    })
}

/// Default bits by specialization id.
fn specialization_defaults(spirv: &[u32]) -> BTreeMap<u32, u32> {
    let ids: BTreeMap<u32, u32> = instructions(spirv)
        .filter_map(|(op, words)| match words {
            [target, DECORATION_SPEC_ID, id] if op == OP_DECORATE => Some((*target, *id)),
            _ => None,
        })
        .collect();
    instructions(spirv)
        .filter_map(|(op, words)| {
            let (result, value) = match (op, words) {
                (OP_SPEC_CONSTANT_TRUE, [_, result]) => (result, 1),
                (OP_SPEC_CONSTANT_FALSE, [_, result]) => (result, 0),
                (OP_SPEC_CONSTANT, [_, result, value]) => (result, *value),
                _ => return None,
            };
            Some((*ids.get(result)?, value))
        })
        .collect()
}

/// Opcode and operands of each instruction after the five words of the header.
fn instructions(spirv: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = spirv.get(5..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let length = (first >> 16) as usize;
        let operands = rest.get(1..length)?;
        rest = &rest[length..];
        Some((first & 0xffff, operands))
    })
}

/// What messages call a file, wherever `glsl` is.
pub fn label(glsl: &Path, path: &Path) -> String {
    Path::new("glsl").join(path.strip_prefix(glsl).unwrap_or(path)).display().to_string()
}

fn file_stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn extension(path: &Path) -> Option<&str> {
    path.extension()?.to_str()
}
