//! Pipelines, typed by what their shaders declare.

use super::{
    device::{Gpu, lock},
    error::{Error, Result, vk_error},
};
use ash::vk;
use bytemuck::Pod;
use std::{
    any::Any,
    collections::HashMap,
    io::Cursor,
    marker::PhantomData,
    sync::{Arc, Weak},
};

/// What a program promises. Only build.rs implements it, from the SPIR-V: renaming a binding in GLSL, or changing
/// its type, is then a compile error at every call.
pub trait Interface: 'static {
    /// `room/stem`: the shader's file, the debug label and the row of a timing.
    const NAME: &'static str;
    /// SPIR-V of each stage.
    const STAGES: &'static [(StageKind, &'static [u8])];
    const BINDINGS: &'static [BindingLayout];
    /// The push-constant block, or `()`.
    type Push: Pod;
    /// Specialization constants, or `()`.
    type Constants: Specialize;
    /// The images and buffers by the names they have in GLSL, or `()`.
    type Bindings<'a>: Bind;
}

/// The interface of a compute shader.
pub trait ComputeInterface: Interface {
    const WORKGROUP: [u32; 3];
}

/// The interface of the stages of a raster pipeline.
pub trait RasterInterface: Interface {}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StageKind {
    Vertex,
    TessellationControl,
    TessellationEvaluation,
    Fragment,
    Compute,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BindingLayout {
    pub binding: u32,
    pub kind: ResourceKind,
    pub access: Access,
}

/// What a shader does with a resource: `readonly`, `writeonly`, or neither of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    Read,
    Write,
    ReadWrite,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResourceKind {
    StorageImage,
    UniformBuffer,
    StorageBuffer,
    TexelBuffer,
    AccelerationStructure,
}

/// Values of specialization constants: id and bits.
pub trait Specialize {
    fn entries(&self) -> Vec<(u32, u32)>;
}

impl Specialize for () {
    fn entries(&self) -> Vec<(u32, u32)> {
        Vec::new()
    }
}

/// Resources in the order of [`Interface::BINDINGS`].
pub trait Bind {
    fn resources(&self) -> Vec<&dyn Bindable>;
}

impl Bind for () {
    fn resources(&self) -> Vec<&dyn Bindable> {
        Vec::new()
    }
}

/// An image or a buffer. Nothing else can be one: the handles that it gives must be alive.
pub trait Bindable: Sealed {
    fn descriptor(&self) -> Descriptor;
    /// Size of what a shader sees.
    fn bytes(&self) -> u64;
    /// A share in its ownership, for the submission to hold.
    fn share(&self) -> Share;
}

/// Keeps [`Bindable`] to this room.
pub trait Sealed {}

/// A share in the ownership of anything that a submission uses.
pub type Share = Arc<dyn Any + Send + Sync>;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Descriptor {
    Image(vk::ImageView),
    Buffer { buffer: vk::Buffer, bytes: u64 },
    Texels(vk::BufferView),
    AccelerationStructure(vk::AccelerationStructureKHR),
}

/// A compute pipeline.
pub struct Compute<S: ComputeInterface> {
    raw: Arc<Raw>,
    interface: PhantomData<S>,
}

/// Compute pipelines that somebody has, by the names and constants of their shaders.
pub(super) type Programs = HashMap<(&'static str, Vec<(u32, u32)>), Weak<Raw>>;

impl<S: ComputeInterface> Compute<S> {
    /// Compiles the shader with `constants` for this device, unless somebody has that pipeline already: then it is shared. What begins
    /// again in place of what is still there, as land does, compiles nothing anew.
    pub fn new(gpu: &Gpu, constants: S::Constants) -> Result<Self> {
        let key = (S::NAME, constants.entries());
        let shared = lock(&gpu.shared().programs).get(&key).and_then(Weak::upgrade);
        if let Some(raw) = shared {
            return Ok(Compute { raw, interface: PhantomData });
        }
        let compiled = Self::compile(gpu, &constants)?;
        let mut programs = lock(&gpu.shared().programs);
        programs.retain(|_, raw| raw.strong_count() > 0);
        programs.insert(key, Arc::downgrade(&compiled.raw));
        Ok(compiled)
    }

    fn compile(gpu: &Gpu, constants: &S::Constants) -> Result<Self> {
        let parts = Parts::new::<S>(gpu, constants)?;
        let stages = parts.stages();
        let info = vk::ComputePipelineCreateInfo::default().stage(stages[0]).layout(parts.raw.layout);
        // SAFETY: module, layout and constants are alive and come from one reflected shader.
        let pipelines = unsafe {
            gpu.shared().device.create_compute_pipelines(gpu.shared().pipeline_cache, &[info], None)
        };
        Ok(Compute {
            raw: parts.finish(pipelines, S::NAME, "vkCreateComputePipelines")?,
            interface: PhantomData,
        })
    }

    pub(super) fn raw(&self) -> &Arc<Raw> {
        &self.raw
    }
}

/// What a raster pipeline draws, and how it joins what is there.
#[derive(Clone, Debug)]
pub struct RasterState<'a> {
    /// Formats of the colour attachments.
    pub color: &'a [vk::Format],
    pub depth: Depth,
    pub topology: Topology,
    pub cull: Cull,
    pub blend: Blend,
}

/// Reversed depth: nearer is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// No depth attachment.
    None,
    /// Hidden by what is nearer.
    Test,
    /// Hidden by what is nearer, and hides what is farther.
    TestWrite,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    Triangles,
    TriangleStrip,
    /// Patches of this many control points, tessellated.
    Patches(u32),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    None,
    /// Leaves out clockwise triangles.
    Back,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Replaces.
    None,
    /// `src·α + dst·(1 − α)`.
    Alpha,
    /// `src + dst·(1 − α)`: colours have been multiplied by their α.
    Premultiplied,
}

/// A raster pipeline.
pub struct Raster<S: RasterInterface> {
    raw: Arc<Raw>,
    interface: PhantomData<S>,
}

impl<S: RasterInterface> Raster<S> {
    /// Compiles the stages with `constants` for this device.
    pub fn new(gpu: &Gpu, constants: S::Constants, state: &RasterState) -> Result<Self> {
        let mut parts = Parts::new::<S>(gpu, &constants)?;
        parts.raw.targets = TargetFormats { color: state.color.to_vec(), depth: state.depth != Depth::None };
        let stages = parts.stages();
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        let (topology, patch_points) = match state.topology {
            Topology::Triangles => (vk::PrimitiveTopology::TRIANGLE_LIST, 0),
            Topology::TriangleStrip => (vk::PrimitiveTopology::TRIANGLE_STRIP, 0),
            Topology::Patches(points) => (vk::PrimitiveTopology::PATCH_LIST, points),
        };
        let input_assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
        let tessellation =
            vk::PipelineTessellationStateCreateInfo::default().patch_control_points(patch_points);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(match state.cull {
                Cull::None => vk::CullModeFlags::NONE,
                Cull::Back => vk::CullModeFlags::BACK,
            })
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let multisample = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(state.depth != Depth::None)
            .depth_write_enable(state.depth == Depth::TestWrite)
            .depth_compare_op(vk::CompareOp::GREATER);
        let attachment = vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA)
            .blend_enable(state.blend != Blend::None)
            .src_color_blend_factor(match state.blend {
                Blend::Premultiplied => vk::BlendFactor::ONE,
                Blend::None | Blend::Alpha => vk::BlendFactor::SRC_ALPHA,
            })
            .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
            .src_alpha_blend_factor(vk::BlendFactor::ONE)
            .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA);
        let attachments = vec![attachment; state.color.len()];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
        let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
        let mut rendering = vk::PipelineRenderingCreateInfo::default().color_attachment_formats(state.color);
        if state.depth != Depth::None {
            rendering = rendering.depth_attachment_format(vk::Format::D32_SFLOAT);
        }
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&input_assembly)
            .tessellation_state(&tessellation)
            .viewport_state(&viewport)
            .rasterization_state(&rasterization)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(parts.raw.layout)
            .push_next(&mut rendering);
        // SAFETY: all that `info` points to lives until the call returns; stages and layout come from one program.
        let pipelines = unsafe {
            gpu.shared().device.create_graphics_pipelines(gpu.shared().pipeline_cache, &[info], None)
        };
        Ok(Raster {
            raw: parts.finish(pipelines, S::NAME, "vkCreateGraphicsPipelines")?,
            interface: PhantomData,
        })
    }

    pub(super) fn raw(&self) -> &Arc<Raw> {
        &self.raw
    }
}

/// The Vulkan objects of a pipeline.
pub(super) struct Raw {
    pub pipeline: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub set_layout: vk::DescriptorSetLayout,
    pub push_stages: vk::ShaderStageFlags,
    pub bindings: &'static [BindingLayout],
    /// What a raster pipeline draws into.
    pub targets: TargetFormats,
    gpu: Gpu,
}

/// Formats of the colour attachments, and whether there is a depth attachment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct TargetFormats {
    pub color: Vec<vk::Format>,
    pub depth: bool,
}

impl Drop for Raw {
    fn drop(&mut self) {
        let device = &self.gpu.shared().device;
        // SAFETY: submissions that use the pipeline hold it until they have finished.
        unsafe {
            device.destroy_pipeline(self.pipeline, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// What both kinds of pipeline are made from; frees the modules when the pipeline is made, and all if it is not.
struct Parts {
    raw: Raw,
    modules: Vec<(vk::ShaderStageFlags, vk::ShaderModule)>,
    map: Vec<vk::SpecializationMapEntry>,
    values: Vec<u8>,
    specialization: vk::SpecializationInfo<'static>,
}

impl Parts {
    fn new<S: Interface>(gpu: &Gpu, constants: &S::Constants) -> Result<Parts> {
        let device = &gpu.shared().device;
        let push_bytes = size_of::<S::Push>() as u32;
        let largest = gpu.shared().limits.max_push_constants_size;
        if push_bytes > largest {
            return Err(Error::Unsupported(format!(
                "{}: {push_bytes} bytes of push constants; there are {largest} here",
                S::NAME
            )));
        }
        if gpu.shared().acceleration.is_none()
            && S::BINDINGS.iter().any(|layout| layout.kind == ResourceKind::AccelerationStructure)
        {
            return Err(Error::Unsupported(format!("{}: rays that the device traces itself", S::NAME)));
        }
        let images = S::BINDINGS.iter().filter(|layout| layout.kind == ResourceKind::StorageImage).count();
        let most = gpu.shared().limits.max_per_stage_descriptor_storage_images;
        if images > most as usize {
            return Err(Error::Unsupported(format!(
                "{}: a shader with {images} storage images; there are {most} here",
                S::NAME
            )));
        }
        let all_stages =
            S::STAGES.iter().fold(vk::ShaderStageFlags::empty(), |all, (kind, _)| all | stage(*kind));
        let mut raw = Raw {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            push_stages: all_stages,
            bindings: S::BINDINGS,
            targets: TargetFormats::default(),
            gpu: gpu.clone(),
        };
        let set_bindings: Vec<_> = S::BINDINGS
            .iter()
            .map(|layout| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(layout.binding)
                    .descriptor_type(descriptor_type(layout.kind))
                    .descriptor_count(1)
                    .stage_flags(all_stages)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&set_bindings);
        // SAFETY: the bindings are distinct, since they come from a map by index.
        raw.set_layout = unsafe { device.create_descriptor_set_layout(&info, None) }
            .map_err(vk_error("vkCreateDescriptorSetLayout"))?;
        let set_layouts = [raw.set_layout];
        let push_ranges = [vk::PushConstantRange::default().stage_flags(all_stages).size(push_bytes)];
        let info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&set_layouts)
            .push_constant_ranges(if push_bytes == 0 { &[] } else { &push_ranges });
        // SAFETY: the set layout is alive; the push range is within the limit.
        raw.layout = unsafe { device.create_pipeline_layout(&info, None) }
            .map_err(vk_error("vkCreatePipelineLayout"))?;
        let entries = constants.entries();
        let map = entries
            .iter()
            .enumerate()
            .map(|(index, (id, _))| vk::SpecializationMapEntry {
                constant_id: *id,
                offset: 4 * index as u32,
                size: 4,
            })
            .collect();
        let values = entries.iter().flat_map(|(_, bits)| bits.to_ne_bytes()).collect();
        let mut parts = Parts {
            raw,
            modules: Vec::new(),
            map,
            values,
            specialization: vk::SpecializationInfo::default(),
        };
        // The pointers stay good when `parts` moves: the vectors' elements do not.
        parts.specialization.map_entry_count = parts.map.len() as u32;
        parts.specialization.p_map_entries = parts.map.as_ptr();
        parts.specialization.data_size = parts.values.len();
        parts.specialization.p_data = parts.values.as_ptr().cast();
        for (kind, spirv) in S::STAGES {
            #[cfg(feature = "reload")]
            let edited = gpu.edited(S::NAME, parts.modules.len());
            #[cfg(not(feature = "reload"))]
            let edited = None;
            let words = match edited {
                Some(words) => words,
                None => ash::util::read_spv(&mut Cursor::new(spirv)).map_err(|error| {
                    Error::Unsupported(format!("{}: the shader is not SPIR-V ({error})", S::NAME))
                })?,
            };
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            // SAFETY: the words were written by the compiler, and promise what `S` does.
            let module = unsafe { device.create_shader_module(&info, None) }
                .map_err(vk_error("vkCreateShaderModule"))?;
            parts.modules.push((stage(*kind), module));
        }
        Ok(parts)
    }

    fn stages(&self) -> Vec<vk::PipelineShaderStageCreateInfo<'_>> {
        self.modules
            .iter()
            .map(|(stage, module)| {
                vk::PipelineShaderStageCreateInfo::default()
                    .stage(*stage)
                    .module(*module)
                    .name(c"main")
                    .specialization_info(&self.specialization)
            })
            .collect()
    }

    /// Takes the pipeline that was made from these parts.
    fn finish(
        mut self,
        pipelines: std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
        name: &str,
        op: &'static str,
    ) -> Result<Arc<Raw>> {
        let pipelines = pipelines.map_err(|(_, result)| vk_error(op)(result))?;
        let gpu = self.raw.gpu.clone();
        let empty = Raw {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            push_stages: vk::ShaderStageFlags::empty(),
            bindings: &[],
            targets: TargetFormats::default(),
            gpu: gpu.clone(),
        };
        let mut raw = std::mem::replace(&mut self.raw, empty);
        raw.pipeline = pipelines.into_iter().next().unwrap_or_default();
        gpu.name(raw.pipeline, name);
        Ok(Arc::new(raw))
    }
}

impl Drop for Parts {
    fn drop(&mut self) {
        for (_, module) in &self.modules {
            // SAFETY: a module is needed only while its pipeline is made.
            unsafe { self.raw.gpu.shared().device.destroy_shader_module(*module, None) };
        }
    }
}

pub(super) fn descriptor_type(kind: ResourceKind) -> vk::DescriptorType {
    match kind {
        ResourceKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        ResourceKind::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
        ResourceKind::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        ResourceKind::TexelBuffer => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        ResourceKind::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
    }
}

fn stage(kind: StageKind) -> vk::ShaderStageFlags {
    match kind {
        StageKind::Vertex => vk::ShaderStageFlags::VERTEX,
        StageKind::TessellationControl => vk::ShaderStageFlags::TESSELLATION_CONTROL,
        StageKind::TessellationEvaluation => vk::ShaderStageFlags::TESSELLATION_EVALUATION,
        StageKind::Fragment => vk::ShaderStageFlags::FRAGMENT,
        StageKind::Compute => vk::ShaderStageFlags::COMPUTE,
    }
}
