//! Recording passes: dispatches, draws and copies, in order, each waiting for those before it.

use super::{
    buffer::{self, Buffer},
    device::Gpu,
    error::{Error, Result, vk_error},
    format::{D32f, Format},
    image::{self, Attachable, Image, Layers},
    pipeline::{
        self, Bind, Bindable, Compute, ComputeInterface, Descriptor, Interface, Raster, RasterInterface,
        Share,
    },
    submission::{Download, Stamp, Submission},
};
use ash::vk;
use bytemuck::Pod;
use std::{collections::HashMap, ffi::CString, sync::Arc};

/// A list of passes being written. Recording cannot fail: the first error surfaces at [`Recorder::submit`].
pub struct Recorder {
    gpu: Gpu,
    objects: Objects,
    command: vk::CommandBuffer,
    error: Option<Error>,
    /// By address, so that what is named a thousand times is held once.
    held: HashMap<usize, Share>,
    sets: HashMap<(vk::DescriptorSetLayout, Vec<Descriptor>), vk::DescriptorSet>,
    concurrency: Concurrency,
    stamps: Vec<Stamp>,
    last_pass: &'static str,
}

/// Vulkan objects that live as long as the commands recorded with them.
pub(super) struct Objects {
    pub gpu: Gpu,
    pub commands: vk::CommandPool,
    pub descriptors: Vec<vk::DescriptorPool>,
    pub queries: Option<vk::QueryPool>,
    /// Number of timestamps that fit.
    pub capacity: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Concurrency {
    /// A barrier before each pass.
    Ordered,
    /// Inside [`Recorder::concurrent`], before its first pass.
    First,
    /// Inside, behind its first pass: no barrier.
    Free,
}

/// What a render pass draws into.
#[derive(Clone, Copy)]
pub struct Targets<'a> {
    /// Colour attachments by location; all of one size.
    pub color: &'a [&'a dyn Attachable],
    pub depth: Option<&'a Image<D32f>>,
    pub load: Load,
}

/// What a render pass does with what its targets hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Fills the colours with this value and the depth with 0 (infinitely far).
    Clear([f32; 4]),
    /// Draws over it.
    Keep,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    pub vertices: u32,
    pub instances: u32,
}

/// Records the draws of one render pass.
pub struct Draws<'a>(&'a mut Recorder);

/// An image or buffer that bytes are copied to and from whole.
pub trait Transfer {
    type Element: Pod;
    #[doc(hidden)]
    fn place(&self) -> Place;
}

#[doc(hidden)]
#[derive(Clone)]
pub enum Place {
    Image(ImagePlace),
    Buffer(BufferPlace),
}

#[doc(hidden)]
#[derive(Clone)]
pub struct ImagePlace(Arc<image::Raw>);

#[doc(hidden)]
#[derive(Clone)]
pub struct BufferPlace(Arc<buffer::Raw>);

impl<F: Format> Transfer for Image<F> {
    type Element = F::Texel;

    fn place(&self) -> Place {
        Place::Image(ImagePlace(self.raw().clone()))
    }
}

impl<F: Format> Transfer for Layers<F> {
    type Element = F::Texel;

    fn place(&self) -> Place {
        Place::Image(ImagePlace(self.raw().clone()))
    }
}

impl<T: Pod> Transfer for Buffer<T> {
    type Element = T;

    fn place(&self) -> Place {
        Place::Buffer(BufferPlace(self.raw().clone()))
    }
}

impl Place {
    fn elements<T: Pod>(&self) -> usize {
        match self {
            Place::Image(ImagePlace(raw)) => raw.texels(),
            Place::Buffer(BufferPlace(raw)) => raw.bytes as usize / size_of::<T>(),
        }
    }
}

impl Recorder {
    pub fn new(gpu: &Gpu) -> Recorder {
        Recorder::with_stamps(gpu, 0)
    }

    /// Also takes the time of each pass on the device, for at most `passes` of them.
    pub fn timed(gpu: &Gpu, passes: u32) -> Recorder {
        Recorder::with_stamps(gpu, 2 * passes)
    }

    /// Runs a compute shader on `[x, y]` invocations, rounded up to whole workgroups.
    pub fn dispatch<S: ComputeInterface>(
        &mut self,
        pass: &Compute<S>,
        size: [u32; 2],
        push: S::Push,
        bindings: S::Bindings<'_>,
    ) {
        let [x, y, _] = S::WORKGROUP;
        let groups = [size[0].div_ceil(x), size[1].div_ceil(y)];
        let raw = pass.raw().clone();
        self.pass(S::NAME, |rec| {
            rec.bind::<S>(vk::PipelineBindPoint::COMPUTE, &raw, &push, &bindings)?;
            // SAFETY: pipeline, set and push constants of this shader are bound.
            unsafe { rec.device().cmd_dispatch(rec.command, groups[0], groups[1], 1) };
            Ok(())
        });
        self.hold(raw);
    }

    /// Draws into `targets`; the draws run in the order they are recorded.
    pub fn render(&mut self, targets: &Targets, draws: impl FnOnce(&mut Draws)) {
        let size = match (targets.color.first(), targets.depth) {
            (Some(color), _) => color.size(),
            (None, Some(depth)) => depth.size(),
            (None, None) => return,
        };
        for color in targets.color {
            self.hold(color.share());
        }
        if let Some(depth) = targets.depth {
            self.hold(depth.raw().clone());
        }
        self.pass("render", |rec| {
            rec.begin_rendering(targets, size);
            draws(&mut Draws(rec));
            // SAFETY: rendering was begun above and draws cannot end it.
            unsafe { rec.device().cmd_end_rendering(rec.command) };
            Ok(())
        });
    }

    /// The passes that `passes` records do not wait for each other (and must not need each other's results).
    pub fn concurrent(&mut self, passes: impl FnOnce(&mut Recorder)) {
        let outer = std::mem::replace(&mut self.concurrency, Concurrency::First);
        passes(self);
        self.concurrency = match (outer, self.concurrency) {
            (Concurrency::First, Concurrency::Free) => Concurrency::Free,
            _ => outer,
        };
    }

    /// Groups what `passes` records under a label for debuggers.
    pub fn scope(&mut self, name: &str, passes: impl FnOnce(&mut Recorder)) {
        let Some(debug) = self.gpu.shared().debug.clone() else { return passes(self) };
        let name = CString::new(name).unwrap_or_default();
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the command buffer is recording.
        unsafe { debug.cmd_begin_debug_utils_label(self.command, &label) };
        passes(self);
        // SAFETY: closes the label opened above.
        unsafe { debug.cmd_end_debug_utils_label(self.command) };
    }

    /// Sets every texel or element to all-zero bytes.
    pub fn clear<T: Transfer>(&mut self, target: &T) {
        match target.place() {
            Place::Image(ImagePlace(raw)) => {
                self.pass("clear", |rec| {
                    rec.clear_image(&raw);
                    Ok(())
                });
                self.hold(raw);
            }
            Place::Buffer(BufferPlace(raw)) => self.zero(&raw),
        }
    }

    /// Copies all of `src` to `dst`, an image of the same size and format.
    pub fn copy<F: Format>(&mut self, src: &Image<F>, dst: &Image<F>) {
        let (src, dst) = (src.raw().clone(), dst.raw().clone());
        self.pass("copy", |rec| {
            if src.size != dst.size {
                return Err(Error::Unsupported("a copy between images of two sizes".into()));
            }
            let region = src.copy_region();
            let copy = vk::ImageCopy::default()
                .src_subresource(region.image_subresource)
                .dst_subresource(region.image_subresource)
                .extent(region.image_extent);
            let general = vk::ImageLayout::GENERAL;
            // SAFETY: both images are in GENERAL and of one size and format.
            unsafe {
                rec.device().cmd_copy_image(rec.command, src.image, general, dst.image, general, &[copy])
            };
            Ok(())
        });
        self.hold(src);
        self.hold(dst);
    }

    /// Fills `target` with `data`: as many elements, row by row and layer by layer.
    pub fn upload<T: Transfer>(&mut self, target: &T, data: &[T::Element]) {
        let place = target.place();
        self.pass("upload", |rec| {
            let expected = place.elements::<T::Element>();
            if data.len() != expected {
                return Err(Error::Unsupported(format!(
                    "an upload of {} elements to a place for {expected}",
                    data.len()
                )));
            }
            let staging = Arc::new(buffer::Raw::upload(&rec.gpu, bytemuck::cast_slice(data))?);
            rec.copy_from(&staging, &place);
            rec.hold(staging);
            Ok(())
        });
        self.hold_place(place);
    }

    /// Copies `source` to where the CPU can read it once the submission has finished.
    pub fn download<T: Transfer>(&mut self, source: &T) -> Download<T::Element> {
        let place = source.place();
        let bytes = (place.elements::<T::Element>() * size_of::<T::Element>()) as u64;
        let mut download = Download::default();
        self.pass("download", |rec| {
            let staging = Arc::new(buffer::Raw::download(&rec.gpu, bytes)?);
            rec.copy_to(&place, &staging);
            rec.hold(staging.clone());
            download = Download::from(staging);
            Ok(())
        });
        self.hold_place(place);
        download
    }

    /// Sends the passes to the device.
    ///
    /// # Errors
    /// The first error of the recording, or of the submission itself.
    pub fn submit(mut self) -> Result<Submission> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        let to_host = vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ);
        self.barrier(to_host);
        // SAFETY: the command buffer is recording.
        unsafe { self.device().end_command_buffer(self.command) }.map_err(vk_error("vkEndCommandBuffer"))?;
        Submission::new(self.objects, self.command, self.held, self.stamps, self.last_pass)
    }

    fn with_stamps(gpu: &Gpu, capacity: u32) -> Recorder {
        let mut objects = Objects {
            gpu: gpu.clone(),
            commands: Default::default(),
            descriptors: Vec::new(),
            queries: None,
            capacity,
        };
        let (command, error) = match objects.begin() {
            Ok(command) => (command, None),
            Err(error) => (vk::CommandBuffer::null(), Some(error)),
        };
        Recorder {
            gpu: gpu.clone(),
            objects,
            command,
            error,
            held: HashMap::new(),
            sets: HashMap::new(),
            concurrency: Concurrency::Ordered,
            stamps: Vec::new(),
            last_pass: "the start",
        }
    }

    fn device(&self) -> &ash::Device {
        &self.gpu.shared().device
    }

    fn hold(&mut self, share: Share) {
        self.held.insert(Arc::as_ptr(&share).cast::<()>() as usize, share);
    }

    fn hold_place(&mut self, place: Place) {
        match place {
            Place::Image(ImagePlace(raw)) => self.hold(raw),
            Place::Buffer(BufferPlace(raw)) => self.hold(raw),
        }
    }

    /// A pass: barrier, label, timestamps, commands.
    fn pass(&mut self, name: &'static str, commands: impl FnOnce(&mut Recorder) -> Result<()>) {
        if self.error.is_some() {
            return;
        }
        if self.concurrency != Concurrency::Free {
            self.barrier(
                vk::MemoryBarrier2::default()
                    .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                    .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
                    .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                    .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE),
            );
        }
        if self.concurrency == Concurrency::First {
            self.concurrency = Concurrency::Free;
        }
        self.last_pass = name;
        let stamped = self.stamps.len() as u32 * 2 + 2 <= self.objects.capacity;
        self.scope(name, |rec| {
            let first = rec.stamps.len() as u32 * 2;
            if stamped {
                rec.stamp(first);
            }
            if let Err(error) = commands(rec) {
                rec.error.get_or_insert(error);
            }
            if stamped {
                rec.stamp(first + 1);
                rec.stamps.push(Stamp { name, first });
            }
        });
    }

    fn stamp(&mut self, query: u32) {
        let Some(queries) = self.objects.queries else { return };
        let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: the query is within the pool and was reset at the start.
        unsafe { self.device().cmd_write_timestamp2(self.command, stage, queries, query) };
    }

    fn barrier(&mut self, barrier: vk::MemoryBarrier2) {
        let barriers = [barrier];
        let info = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: the command buffer is recording, outside of rendering.
        unsafe { self.device().cmd_pipeline_barrier2(self.command, &info) };
    }

    fn bind<S: Interface>(
        &mut self,
        point: vk::PipelineBindPoint,
        pipeline: &pipeline::Raw,
        push: &S::Push,
        bindings: &S::Bindings<'_>,
    ) -> Result<()> {
        // SAFETY: the pipeline is alive and of this bind point.
        unsafe { self.device().cmd_bind_pipeline(self.command, point, pipeline.pipeline) };
        if !pipeline.bindings.is_empty() {
            let set = self.set(pipeline, &bindings.resources())?;
            // SAFETY: the set was allocated for this layout and its resources are held by this recorder.
            unsafe {
                self.device().cmd_bind_descriptor_sets(self.command, point, pipeline.layout, 0, &[set], &[]);
            }
        }
        let bytes = bytemuck::bytes_of(push);
        if !bytes.is_empty() {
            // SAFETY: the layout has a range of exactly the size of this struct.
            unsafe {
                self.device().cmd_push_constants(
                    self.command,
                    pipeline.layout,
                    pipeline.push_stages,
                    0,
                    bytes,
                );
            }
        }
        Ok(())
    }

    /// The descriptor set that names `resources`: a new one only if it has not been asked for before.
    fn set(&mut self, pipeline: &pipeline::Raw, resources: &[&dyn Bindable]) -> Result<vk::DescriptorSet> {
        let descriptors: Vec<Descriptor> = resources.iter().map(|resource| resource.descriptor()).collect();
        let key = (pipeline.set_layout, descriptors);
        if let Some(set) = self.sets.get(&key) {
            return Ok(*set);
        }
        let set = self.objects.allocate_set(pipeline.set_layout)?;
        for (descriptor, layout) in key.1.iter().zip(pipeline.bindings) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(layout.binding)
                .descriptor_type(pipeline::descriptor_type(layout.kind));
            match descriptor {
                Descriptor::Image(view) => {
                    let info = [vk::DescriptorImageInfo::default()
                        .image_view(*view)
                        .image_layout(vk::ImageLayout::GENERAL)];
                    // SAFETY: set and view are alive, and no submission uses the set yet.
                    unsafe { self.device().update_descriptor_sets(&[write.image_info(&info)], &[]) };
                }
                Descriptor::Buffer { buffer, bytes } => {
                    let info = [vk::DescriptorBufferInfo::default().buffer(*buffer).range(*bytes)];
                    // SAFETY: set and buffer are alive, and no submission uses the set yet.
                    unsafe { self.device().update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
                }
            }
        }
        for resource in resources {
            self.hold(resource.share());
        }
        self.sets.insert(key, set);
        Ok(set)
    }

    fn begin_rendering(&mut self, targets: &Targets, size: [u32; 2]) {
        let (load_op, color) = match targets.load {
            Load::Clear(color) => (vk::AttachmentLoadOp::CLEAR, color),
            Load::Keep => (vk::AttachmentLoadOp::LOAD, [0.0; 4]),
        };
        let attachment = |view, clear_value| {
            vk::RenderingAttachmentInfo::default()
                .image_view(view)
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(load_op)
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(clear_value)
        };
        let clear_color = vk::ClearValue { color: vk::ClearColorValue { float32: color } };
        let clear_depth =
            vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 } };
        let colors: Vec<_> = targets.color.iter().map(|it| attachment(it.view(), clear_color)).collect();
        let depth = targets.depth.map(|depth| attachment(depth.raw().view, clear_depth));
        let area = vk::Rect2D {
            offset: vk::Offset2D::default(),
            extent: vk::Extent2D { width: size[0], height: size[1] },
        };
        let mut info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        // The height is negative so that y points up in clip space, as in every book.
        let viewport = vk::Viewport {
            x: 0.0,
            y: size[1] as f32,
            width: size[0] as f32,
            height: -(size[1] as f32),
            min_depth: 0.0,
            max_depth: 1.0,
        };
        // SAFETY: the attachments are alive, in GENERAL and of one size.
        unsafe {
            self.device().cmd_begin_rendering(self.command, &info);
            self.device().cmd_set_viewport(self.command, 0, &[viewport]);
            self.device().cmd_set_scissor(self.command, 0, &[area]);
        }
    }

    /// The first command on an image: into GENERAL, and all texels zero.
    pub(super) fn give_birth(&mut self, raw: &image::Raw) {
        if self.error.is_some() {
            return;
        }
        let barriers = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
            .old_layout(vk::ImageLayout::UNDEFINED)
            .new_layout(vk::ImageLayout::GENERAL)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(raw.image)
            .subresource_range(raw.range())];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: the image is new; nothing else uses it.
        unsafe { self.device().cmd_pipeline_barrier2(self.command, &info) };
        self.clear_image(raw);
    }

    fn clear_image(&mut self, raw: &image::Raw) {
        let (general, ranges) = (vk::ImageLayout::GENERAL, [raw.range()]);
        // SAFETY: the image is in GENERAL and has the transfer usage.
        unsafe {
            if raw.aspect == vk::ImageAspectFlags::DEPTH {
                let depth = vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 };
                self.device().cmd_clear_depth_stencil_image(
                    self.command,
                    raw.image,
                    general,
                    &depth,
                    &ranges,
                );
            } else {
                let zero = vk::ClearColorValue { uint32: [0; 4] };
                self.device().cmd_clear_color_image(self.command, raw.image, general, &zero, &ranges);
            }
        }
    }

    /// Fills a buffer with zeroes.
    pub(super) fn zero(&mut self, raw: &Arc<buffer::Raw>) {
        let buffer = raw.buffer;
        self.pass("clear", |rec| {
            // SAFETY: the buffer is alive and has the transfer usage.
            unsafe { rec.device().cmd_fill_buffer(rec.command, buffer, 0, vk::WHOLE_SIZE, 0) };
            Ok(())
        });
        self.hold(raw.clone());
    }

    fn copy_from(&mut self, staging: &buffer::Raw, place: &Place) {
        // SAFETY: the staging buffer holds exactly the bytes of the place; the image is in GENERAL.
        unsafe {
            match place {
                Place::Image(ImagePlace(raw)) => self.device().cmd_copy_buffer_to_image(
                    self.command,
                    staging.buffer,
                    raw.image,
                    vk::ImageLayout::GENERAL,
                    &[raw.copy_region()],
                ),
                Place::Buffer(BufferPlace(raw)) => {
                    let region = vk::BufferCopy::default().size(raw.bytes);
                    self.device().cmd_copy_buffer(self.command, staging.buffer, raw.buffer, &[region]);
                }
            }
        }
    }

    fn copy_to(&mut self, place: &Place, staging: &buffer::Raw) {
        // SAFETY: the staging buffer has room for exactly the bytes of the place; the image is in GENERAL.
        unsafe {
            match place {
                Place::Image(ImagePlace(raw)) => self.device().cmd_copy_image_to_buffer(
                    self.command,
                    raw.image,
                    vk::ImageLayout::GENERAL,
                    staging.buffer,
                    &[raw.copy_region()],
                ),
                Place::Buffer(BufferPlace(raw)) => {
                    let region = vk::BufferCopy::default().size(raw.bytes);
                    self.device().cmd_copy_buffer(self.command, raw.buffer, staging.buffer, &[region]);
                }
            }
        }
    }
}

impl Draws<'_> {
    /// Draws `draw.vertices` vertices (or control points) `draw.instances` times.
    pub fn draw<S: RasterInterface>(
        &mut self,
        pipeline: &Raster<S>,
        draw: Draw,
        push: S::Push,
        bindings: S::Bindings<'_>,
    ) {
        let rec = &mut *self.0;
        if rec.error.is_some() {
            return;
        }
        let raw = pipeline.raw().clone();
        if let Err(error) = rec.bind::<S>(vk::PipelineBindPoint::GRAPHICS, &raw, &push, &bindings) {
            rec.error.get_or_insert(error);
            return;
        }
        rec.last_pass = S::NAME;
        // SAFETY: pipeline, set and push constants of this program are bound, inside rendering.
        unsafe { rec.device().cmd_draw(rec.command, draw.vertices, draw.instances, 0, 0) };
        rec.hold(raw);
    }
}

impl Objects {
    /// Makes the pools and starts a command buffer.
    fn begin(&mut self) -> Result<vk::CommandBuffer> {
        let gpu = self.gpu.clone();
        let device = &gpu.shared().device;
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(gpu.shared().queue_family);
        // SAFETY: the device is alive.
        self.commands =
            unsafe { device.create_command_pool(&info, None) }.map_err(vk_error("vkCreateCommandPool"))?;
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.commands)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool was just made.
        let command = unsafe { device.allocate_command_buffers(&info) }
            .map_err(vk_error("vkAllocateCommandBuffers"))?
            .into_iter()
            .next()
            .unwrap_or_default();
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer was just allocated.
        unsafe { device.begin_command_buffer(command, &info) }.map_err(vk_error("vkBeginCommandBuffer"))?;
        if self.capacity > 0 {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(self.capacity);
            // SAFETY: the device is alive.
            let queries =
                unsafe { device.create_query_pool(&info, None) }.map_err(vk_error("vkCreateQueryPool"))?;
            self.queries = Some(queries);
            // SAFETY: the command buffer is recording.
            unsafe { device.cmd_reset_query_pool(command, queries, 0, self.capacity) };
        }
        Ok(command)
    }

    fn allocate_set(&mut self, layout: vk::DescriptorSetLayout) -> Result<vk::DescriptorSet> {
        let gpu = self.gpu.clone();
        let device = &gpu.shared().device;
        let layouts = [layout];
        if let Some(pool) = self.descriptors.last() {
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(*pool).set_layouts(&layouts);
            // SAFETY: pool and layout are alive.
            if let Ok(sets) = unsafe { device.allocate_descriptor_sets(&info) } {
                return Ok(sets.into_iter().next().unwrap_or_default());
            }
        }
        // No pool yet, or a full one.
        let sizes = [
            vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_IMAGE, descriptor_count: 1024 },
            vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER, descriptor_count: 128 },
            vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 256 },
        ];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(128).pool_sizes(&sizes);
        // SAFETY: the device is alive.
        let pool = unsafe { device.create_descriptor_pool(&info, None) }
            .map_err(vk_error("vkCreateDescriptorPool"))?;
        self.descriptors.push(pool);
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
        // SAFETY: pool and layout are alive.
        let sets = unsafe { device.allocate_descriptor_sets(&info) }
            .map_err(vk_error("vkAllocateDescriptorSets"))?;
        Ok(sets.into_iter().next().unwrap_or_default())
    }
}

impl Drop for Objects {
    fn drop(&mut self) {
        let device = &self.gpu.shared().device;
        // SAFETY: a submission waits for its fence before it drops these; a recorder was never submitted.
        unsafe {
            device.destroy_command_pool(self.commands, None);
            for pool in &self.descriptors {
                device.destroy_descriptor_pool(*pool, None);
            }
            if let Some(queries) = self.queries {
                device.destroy_query_pool(queries, None);
            }
        }
    }
}
