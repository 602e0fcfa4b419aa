//! Recording passes: dispatches, draws and copies, in order, each waiting for those before it.

use super::{
    buffer::Buffer,
    device::Gpu,
    error::{Error, Result, vk_error},
    format::D32f,
    image::{Attachable, Image},
    objects::Objects,
    pipeline::{
        self, Access, Bind, Bindable, BindingLayout, Compute, ComputeInterface, Descriptor, Interface,
        Raster, RasterInterface, Share, TargetFormats,
    },
    submission::{Signals, Stamp, Submission},
};
use ash::vk;
use bytemuck::Pod;
use std::{
    collections::HashMap,
    ffi::CString,
    ops::Range,
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
};

/// A list of passes being written. Recording cannot fail: the first error surfaces at [`Recorder::submit`].
pub struct Recorder {
    pub(super) gpu: Gpu,
    objects: Objects,
    pub(super) command: vk::CommandBuffer,
    pub(super) error: Option<Error>,
    /// By address, so that what is named a thousand times is held once.
    held: HashMap<usize, Share>,
    sets: HashMap<(vk::DescriptorSetLayout, Vec<Descriptor>), vk::DescriptorSet>,
    concurrency: Concurrency,
    stamps: Vec<Stamp>,
    traffic: u64,
    last_pass: &'static str,
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

/// Part of an index buffer, drawn several times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IndexedDraw {
    /// Of the index buffer.
    pub indices: Range<u32>,
    /// Added to every index: `gl_VertexIndex` is their sum.
    pub first_vertex: u32,
    /// Values of `gl_InstanceIndex`.
    pub instances: Range<u32>,
}

/// Records the draws of one render pass.
pub struct Draws<'a> {
    rec: &'a mut Recorder,
    targets: TargetFormats,
}

impl Recorder {
    pub fn new(gpu: &Gpu) -> Recorder {
        Recorder::with_stamps(gpu, 0)
    }

    /// Also takes the time of each pass on the device, for at most `passes` of them.
    /// Without a device that can take the time there are no timings.
    pub fn timed(gpu: &Gpu, passes: u32) -> Recorder {
        Recorder::with_stamps(gpu, if gpu.shared().timestamps { 2 * passes } else { 0 })
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
        self.compute(pass, &push, &bindings, |rec| {
            // SAFETY: pipeline, set and push constants of this shader are bound.
            unsafe { rec.device().cmd_dispatch(rec.command, groups[0], groups[1], 1) };
            Ok(())
        });
    }

    /// Runs a compute shader on as many workgroups as three numbers in `counts` say by then: passes before it write them. They begin at
    /// byte `offset`, a multiple of 4.
    pub fn dispatch_indirect<S: ComputeInterface, T: Pod>(
        &mut self,
        pass: &Compute<S>,
        (counts, offset): (&Buffer<T>, usize),
        push: S::Push,
        bindings: S::Bindings<'_>,
    ) {
        let (counts, offset) = (counts.raw().clone(), offset as u64);
        let end = offset + size_of::<vk::DispatchIndirectCommand>() as u64;
        self.compute(pass, &push, &bindings, |rec| {
            if offset % 4 != 0 || end > counts.bytes {
                return Err(Error::Unsupported(format!("counts at {offset} of {} bytes", counts.bytes)));
            }
            // SAFETY: pipeline, set and push constants of this shader are bound; the counts lie within their buffer, which
            // the recorder holds, and the barrier before the pass makes them visible.
            unsafe { rec.device().cmd_dispatch_indirect(rec.command, counts.buffer, offset) };
            rec.hold(counts);
            Ok(())
        });
    }

    /// A pass that runs a compute shader: all that it needs is bound when `dispatch` is called.
    fn compute<S: ComputeInterface>(
        &mut self,
        pass: &Compute<S>,
        push: &S::Push,
        bindings: &S::Bindings<'_>,
        dispatch: impl FnOnce(&mut Recorder) -> Result<()>,
    ) {
        let raw = pass.raw().clone();
        self.traffic += traffic(S::BINDINGS, &bindings.resources());
        self.pass(S::NAME, |rec| {
            rec.bind::<S>(vk::PipelineBindPoint::COMPUTE, &raw, push, bindings)?;
            dispatch(rec)
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
            if targets.color.iter().any(|color| color.size() != size)
                || targets.depth.is_some_and(|depth| depth.size() != size)
            {
                return Err(Error::Unsupported("drawing into images of two sizes".into()));
            }
            rec.begin_rendering(targets, size);
            let formats = TargetFormats {
                color: targets.color.iter().map(|color| color.format()).collect(),
                depth: targets.depth.is_some(),
            };
            draws(&mut Draws { rec, targets: formats });
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
        let Some(debug) = self.gpu.shared().debug.clone().filter(|_| self.error.is_none()) else {
            return passes(self);
        };
        let name = CString::new(name).unwrap_or_default();
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the command buffer is recording.
        unsafe { debug.cmd_begin_debug_utils_label(self.command, &label) };
        passes(self);
        // SAFETY: closes the label opened above.
        unsafe { debug.cmd_end_debug_utils_label(self.command) };
    }

    /// Bytes that the dispatches so far must move at least: every image and buffer that one reads or writes, once.
    pub fn traffic(&self) -> u64 {
        self.traffic
    }

    /// Sends the passes to the device.
    ///
    /// # Errors
    /// The first error of the recording, or of the submission itself.
    pub fn submit(self) -> Result<Submission> {
        self.submit_between(Signals::default())
    }

    /// The same, waiting for one semaphore and signalling another.
    pub(super) fn submit_between(mut self, signals: Signals) -> Result<Submission> {
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
        Submission::new(self.objects, self.command, self.held, self.stamps, self.last_pass, signals)
    }

    fn with_stamps(gpu: &Gpu, capacity: u32) -> Recorder {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let mut objects = Objects::new(gpu, NEXT.fetch_add(1, Ordering::Relaxed), capacity);
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
            traffic: 0,
            last_pass: "the start",
        }
    }

    pub(super) fn id(&self) -> u64 {
        self.objects.id
    }

    pub(super) fn device(&self) -> &ash::Device {
        &self.gpu.shared().device
    }

    pub(super) fn hold(&mut self, share: Share) {
        self.held.insert(Arc::as_ptr(&share).cast::<()>() as usize, share);
    }

    /// A pass: barrier, label, timestamps, commands.
    pub(super) fn pass(&mut self, name: &'static str, commands: impl FnOnce(&mut Recorder) -> Result<()>) {
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
        let Some(queries) = self.objects.queries() else { return };
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
                Descriptor::Texels(view) => {
                    let views = [*view];
                    // SAFETY: set and view are alive, and no submission uses the set yet.
                    unsafe { self.device().update_descriptor_sets(&[write.texel_buffer_view(&views)], &[]) };
                }
                Descriptor::AccelerationStructure(structure) => {
                    let structures = [*structure];
                    let mut info = vk::WriteDescriptorSetAccelerationStructureKHR::default()
                        .acceleration_structures(&structures);
                    let write = write.descriptor_count(1).push_next(&mut info);
                    // SAFETY: set and structure are alive, and no submission uses the set yet.
                    unsafe { self.device().update_descriptor_sets(&[write], &[]) };
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
}

impl Draws<'_> {
    /// From now on only what lies in the rectangle from `least` to before `end` is drawn, texels.
    pub fn clip(&mut self, least: [u32; 2], end: [u32; 2]) {
        let [width, height] = [0, 1].map(|axis| end[axis].saturating_sub(least[axis]));
        let offset = vk::Offset2D { x: least[0].min(1 << 20) as i32, y: least[1].min(1 << 20) as i32 };
        let area = vk::Rect2D { offset, extent: vk::Extent2D { width, height } };
        if self.rec.error.is_none() {
            // SAFETY: the command buffer is recording, and the rectangle ends before a signed number does.
            unsafe { self.rec.device().cmd_set_scissor(self.rec.command, 0, &[area]) };
        }
    }

    /// Draws `draw.vertices` vertices (or control points) `draw.instances` times.
    pub fn draw<S: RasterInterface>(
        &mut self,
        pipeline: &Raster<S>,
        draw: Draw,
        push: S::Push,
        bindings: S::Bindings<'_>,
    ) {
        self.draw_some(pipeline, draw.vertices, 0..draw.instances, push, bindings);
    }

    /// Draws those instances only.
    pub fn draw_some<S: RasterInterface>(
        &mut self,
        pipeline: &Raster<S>,
        vertices: u32,
        instances: Range<u32>,
        push: S::Push,
        bindings: S::Bindings<'_>,
    ) {
        let Some(rec) = self.bind(pipeline, &push, &bindings) else { return };
        let count = instances.len() as u32;
        // SAFETY: pipeline, set and push constants of this program are bound, inside rendering.
        unsafe { rec.device().cmd_draw(rec.command, vertices, count, 0, instances.start) };
    }

    /// Draws the vertices that `indices` names.
    pub fn draw_indexed<S: RasterInterface>(
        &mut self,
        pipeline: &Raster<S>,
        indices: &Buffer<u32>,
        draw: &IndexedDraw,
        push: S::Push,
        bindings: S::Bindings<'_>,
    ) {
        let Some(rec) = self.bind(pipeline, &push, &bindings) else { return };
        if draw.indices.end as usize > indices.len() {
            let error = format!("indices {:?} of {}", draw.indices, indices.len());
            rec.error = Some(Error::Unsupported(error));
            return;
        }
        let raw = indices.raw();
        // SAFETY: pipeline, set and push constants of this program are bound, inside rendering; the range lies in the
        // index buffer, which the recorder holds. The device checks what indices make a shader read.
        unsafe {
            rec.device().cmd_bind_index_buffer(rec.command, raw.buffer, 0, vk::IndexType::UINT32);
            rec.device().cmd_draw_indexed(
                rec.command,
                draw.indices.len() as u32,
                draw.instances.len() as u32,
                draw.indices.start,
                draw.first_vertex.cast_signed(),
                draw.instances.start,
            );
        }
        rec.hold(raw.clone());
    }

    /// Binds what a draw needs; `None` if the recording has failed.
    fn bind<S: RasterInterface>(
        &mut self,
        pipeline: &Raster<S>,
        push: &S::Push,
        bindings: &S::Bindings<'_>,
    ) -> Option<&mut Recorder> {
        let Draws { rec, targets } = self;
        if rec.error.is_some() {
            return None;
        }
        let raw = pipeline.raw().clone();
        if raw.targets != *targets {
            let error = format!("{} draws into {:?}, not {targets:?}", S::NAME, raw.targets);
            rec.error = Some(Error::Unsupported(error));
            return None;
        }
        if let Err(error) = rec.bind::<S>(vk::PipelineBindPoint::GRAPHICS, &raw, push, bindings) {
            rec.error.get_or_insert(error);
            return None;
        }
        rec.last_pass = S::NAME;
        rec.hold(raw);
        Some(rec)
    }
}

/// Bytes of the resources that a pass reads, and of those that it writes.
fn traffic(layouts: &[BindingLayout], resources: &[&dyn Bindable]) -> u64 {
    let moved = |(layout, resource): (&BindingLayout, &&dyn Bindable)| match layout.access {
        Access::Read | Access::Write => resource.bytes(),
        Access::ReadWrite => 2 * resource.bytes(),
    };
    layouts.iter().zip(resources).map(moved).sum()
}
