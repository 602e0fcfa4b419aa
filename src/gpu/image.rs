//! Images: rasters of texels on the device.

use super::{
    device::Gpu,
    error::{Error, Result, vk_error},
    format::{Color, Format},
    memory::Location,
    pipeline::{Bindable, Descriptor, Sealed, Share},
    recorder::Recorder,
};
use ash::vk;
use gpu_allocator::vulkan::Allocation;
use std::{marker::PhantomData, sync::Arc};

/// A 2D image: `image2D` in a shader.
pub struct Image<F: Format>(Arc<Raw>, PhantomData<F>);

/// A stack of 2D images of one size: `image2DArray` in a shader.
pub struct Layers<F: Format>(Arc<Raw>, PhantomData<F>);

pub(super) struct Raw {
    pub image: vk::Image,
    pub view: vk::ImageView,
    pub size: [u32; 2],
    pub layers: u32,
    pub aspect: vk::ImageAspectFlags,
    gpu: Gpu,
    name: String,
    bytes: u64,
    allocation: Option<Allocation>,
}

impl<F: Format> Image<F> {
    /// A zeroed image of `[width, height]` texels; a depth image is cleared to 0, which is infinitely far.
    ///
    /// # Errors
    /// A size beyond the device's limits, a format it cannot use, or no memory.
    pub fn new(gpu: &Gpu, name: &str, size: [u32; 2]) -> Result<Self> {
        let raw = Raw::new::<F>(gpu, name, size, 1, vk::ImageViewType::TYPE_2D)?;
        Ok(Image(Arc::new(raw), PhantomData))
    }

    /// Width and height, texels.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Whether another handle, or a submission under way, has it too.
    pub fn is_shared(&self) -> bool {
        Arc::strong_count(&self.0) > 1
    }

    pub(super) fn raw(&self) -> &Arc<Raw> {
        &self.0
    }
}

impl<F: Format> Layers<F> {
    /// `layers` zeroed images of `[width, height]` texels.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn new(gpu: &Gpu, name: &str, size: [u32; 2], layers: u32) -> Result<Self> {
        let raw = Raw::new::<F>(gpu, name, size, layers, vk::ImageViewType::TYPE_2D_ARRAY)?;
        Ok(Layers(Arc::new(raw), PhantomData))
    }

    /// Width and height of a layer, texels.
    pub fn size(&self) -> [u32; 2] {
        self.0.size
    }

    /// Number of layers.
    pub fn layers(&self) -> u32 {
        self.0.layers
    }

    pub(super) fn raw(&self) -> &Arc<Raw> {
        &self.0
    }
}

// By hand: a derive would ask for `F: Clone`.
impl<F: Format> Clone for Image<F> {
    fn clone(&self) -> Self {
        Image(self.0.clone(), PhantomData)
    }
}

impl<F: Format> Clone for Layers<F> {
    fn clone(&self) -> Self {
        Layers(self.0.clone(), PhantomData)
    }
}

impl<F: Format> std::fmt::Debug for Image<F> {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        let [width, height] = self.size();
        write!(out, "Image({}, {width}×{height})", self.0.name)
    }
}

impl<F: Format> Sealed for Image<F> {}
impl<F: Format> Sealed for Layers<F> {}

impl<F: Format> Bindable for Image<F> {
    fn descriptor(&self) -> Descriptor {
        Descriptor::Image(self.0.view)
    }

    fn bytes(&self) -> u64 {
        self.0.texels() as u64 * size_of::<F::Texel>() as u64
    }

    fn share(&self) -> Share {
        self.0.clone()
    }
}

impl<F: Format> Bindable for Layers<F> {
    fn descriptor(&self) -> Descriptor {
        Descriptor::Image(self.0.view)
    }

    fn bytes(&self) -> u64 {
        self.0.texels() as u64 * size_of::<F::Texel>() as u64
    }

    fn share(&self) -> Share {
        self.0.clone()
    }
}

/// A colour image that can be drawn into, whatever its format.
pub trait Attachable: Bindable {
    fn size(&self) -> [u32; 2];
    fn view(&self) -> vk::ImageView;
    fn format(&self) -> vk::Format;
}

impl<F: Color> Attachable for Image<F> {
    fn size(&self) -> [u32; 2] {
        self.0.size
    }

    fn view(&self) -> vk::ImageView {
        self.0.view
    }

    fn format(&self) -> vk::Format {
        F::VK
    }
}

/// Two of a kind that take turns: kernels read `src` and write `dst`, then the two swap.
#[derive(Clone, Debug)]
pub struct PingPong<T> {
    src: T,
    dst: T,
}

impl<T> PingPong<T> {
    pub fn new(src: T, dst: T) -> Self {
        PingPong { src, dst }
    }

    /// What was written last.
    pub fn src(&self) -> &T {
        &self.src
    }

    /// What is written next.
    pub fn dst(&self) -> &T {
        &self.dst
    }

    pub fn swap(&mut self) {
        std::mem::swap(&mut self.src, &mut self.dst);
    }
}

impl<F: Format> PingPong<Image<F>> {
    /// Two zeroed images under one name.
    pub fn images(gpu: &Gpu, name: &str, size: [u32; 2]) -> Result<Self> {
        Ok(PingPong::new(Image::new(gpu, name, size)?, Image::new(gpu, name, size)?))
    }
}

impl<F: Format> PingPong<Layers<F>> {
    /// Two zeroed stacks under one name.
    pub fn layers(gpu: &Gpu, name: &str, size: [u32; 2], layers: u32) -> Result<Self> {
        Ok(PingPong::new(Layers::new(gpu, name, size, layers)?, Layers::new(gpu, name, size, layers)?))
    }
}

impl Raw {
    fn new<F: Format>(
        gpu: &Gpu,
        name: &str,
        size: [u32; 2],
        layers: u32,
        view_type: vk::ImageViewType,
    ) -> Result<Raw> {
        let limits = &gpu.shared().limits;
        let largest = limits.max_image_dimension2_d;
        if size.iter().any(|side| *side == 0 || *side > largest) {
            let [width, height] = size;
            return Err(Error::Unsupported(format!(
                "`{name}` would be {width}×{height} texels; an image has 1 to {largest} a side here"
            )));
        }
        if layers == 0 || layers > limits.max_image_array_layers {
            return Err(Error::Unsupported(format!(
                "`{name}` would have {layers} layers; an image has 1 to {} here",
                limits.max_image_array_layers
            )));
        }
        gpu.check_format(F::VK, F::USAGE)?;
        let device = &gpu.shared().device;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(F::VK)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(F::USAGE | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: size, layers and format were checked against the device's limits.
        let image = unsafe { device.create_image(&info, None) }.map_err(vk_error("vkCreateImage"))?;
        // From here on, dropping `raw` frees what there is.
        let mut raw = Raw {
            image,
            view: vk::ImageView::null(),
            size,
            layers,
            aspect: F::ASPECT,
            gpu: gpu.clone(),
            name: name.into(),
            bytes: 0,
            allocation: None,
        };
        gpu.name(image, name);
        // SAFETY: the image was just made from this device.
        let requirements = unsafe { device.get_image_memory_requirements(image) };
        let allocate = |memory: &mut super::memory::Memory| {
            memory.allocate(name, requirements, Location::Device, vk::ImageTiling::OPTIMAL)
        };
        let Some(allocation) = gpu.with_memory(allocate) else { return Err(closed()) };
        let allocation = raw.allocation.insert(allocation?);
        raw.bytes = requirements.size;
        // SAFETY: the memory was allocated for this image's requirements and is bound once.
        unsafe { device.bind_image_memory(image, allocation.memory(), allocation.offset()) }
            .map_err(vk_error("vkBindImageMemory"))?;
        let view = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(view_type)
            .format(F::VK)
            .subresource_range(raw.range());
        // SAFETY: the image is bound to memory; the view covers its only level and all its layers.
        raw.view = unsafe { device.create_image_view(&view, None) }.map_err(vk_error("vkCreateImageView"))?;
        gpu.name(raw.view, name);
        let mut rec = Recorder::new(gpu);
        rec.give_birth(&raw);
        rec.submit()?.wait()?;
        Ok(raw)
    }

    /// All of the image.
    pub fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: self.aspect,
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: self.layers,
        }
    }

    /// All of the image, for copies to and from buffers.
    pub fn copy_region(&self) -> vk::BufferImageCopy {
        vk::BufferImageCopy::default()
            .image_subresource(vk::ImageSubresourceLayers {
                aspect_mask: self.aspect,
                mip_level: 0,
                base_array_layer: 0,
                layer_count: self.layers,
            })
            .image_extent(vk::Extent3D { width: self.size[0], height: self.size[1], depth: 1 })
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize * self.layers as usize
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        let device = &self.gpu.shared().device;
        // SAFETY: submissions that name the image hold it until they have finished, so nothing uses it now.
        unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.image, None);
        }
        if let Some(allocation) = self.allocation.take() {
            self.gpu.with_memory(|memory| memory.free(&self.name, self.bytes, allocation));
        }
    }
}

/// The device is being destroyed; no handle should be left to ask.
pub(super) fn closed() -> Error {
    Error::Unsupported("allocation on a device that is closed".into())
}
