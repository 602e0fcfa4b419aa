//! Buffers: arrays of plain values on the device.

use super::{
    device::Gpu,
    error::{Error, Result, vk_error},
    image::closed,
    memory::{Location, Memory},
    pipeline::{Bindable, Descriptor, Sealed, Share},
    recorder::Recorder,
};
use ash::vk;
use bytemuck::Pod;
use gpu_allocator::vulkan::Allocation;
use std::{marker::PhantomData, sync::Arc};

/// An array of `T`: a uniform or storage block in a shader.
pub struct Buffer<T: Pod>(Arc<Raw>, PhantomData<T>);

pub(super) struct Raw {
    pub buffer: vk::Buffer,
    pub bytes: u64,
    gpu: Gpu,
    name: String,
    reserved: u64,
    allocation: Option<Allocation>,
}

impl<T: Pod> Buffer<T> {
    /// `len` zeroed elements.
    ///
    /// # Errors
    /// More bytes than a binding may have on this device, or no memory.
    pub fn new(gpu: &Gpu, name: &str, len: usize) -> Result<Self> {
        let bytes = (len * size_of::<T>()) as u64;
        let largest = u64::from(gpu.shared().limits.max_storage_buffer_range);
        if bytes == 0 || bytes > largest {
            return Err(Error::Unsupported(format!(
                "`{name}` would have {bytes} bytes; a buffer has 1 to {largest} here"
            )));
        }
        let mut usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        if gpu.shared().acceleration.is_some() {
            usage |= vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
                | vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
        }
        let raw = Arc::new(Raw::new(gpu, name, bytes, usage, Location::Device)?);
        let mut rec = Recorder::new(gpu);
        rec.zero(&raw);
        rec.submit()?.wait()?;
        Ok(Buffer(raw, PhantomData))
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.0.bytes as usize / size_of::<T>()
    }

    /// Never: an empty buffer cannot be made.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn raw(&self) -> &Arc<Raw> {
        &self.0
    }
}

impl<T: Pod> Clone for Buffer<T> {
    fn clone(&self) -> Self {
        Buffer(self.0.clone(), PhantomData)
    }
}

impl<T: Pod> Sealed for Buffer<T> {}

impl<T: Pod> Bindable for Buffer<T> {
    fn descriptor(&self) -> Descriptor {
        Descriptor::Buffer { buffer: self.0.buffer, bytes: self.0.bytes }
    }

    fn bytes(&self) -> u64 {
        self.0.bytes
    }

    fn share(&self) -> Share {
        self.0.clone()
    }
}

/// Of buffers whose addresses are asked for: what builds of acceleration structures want at most (256 for their scratch).
const ADDRESS_ALIGNMENT: u64 = 256;

impl Raw {
    pub fn new(
        gpu: &Gpu,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        location: Location,
    ) -> Result<Raw> {
        let device = &gpu.shared().device;
        let info = vk::BufferCreateInfo::default().size(bytes.next_multiple_of(4)).usage(usage);
        // SAFETY: the size is not zero.
        let buffer = unsafe { device.create_buffer(&info, None) }.map_err(vk_error("vkCreateBuffer"))?;
        // From here on, dropping `raw` frees what there is.
        let mut raw =
            Raw { buffer, bytes, gpu: gpu.clone(), name: name.into(), reserved: 0, allocation: None };
        gpu.name(buffer, name);
        // SAFETY: the buffer was just made from this device.
        let mut requirements = unsafe { device.get_buffer_memory_requirements(buffer) };
        if usage.contains(vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS) {
            requirements.alignment = requirements.alignment.max(ADDRESS_ALIGNMENT);
        }
        let allocate =
            |memory: &mut Memory| memory.allocate(name, requirements, location, vk::ImageTiling::LINEAR);
        let Some(allocation) = gpu.with_memory(allocate) else { return Err(closed()) };
        let allocation = raw.allocation.insert(allocation?);
        raw.reserved = requirements.size;
        // SAFETY: the memory was allocated for this buffer's requirements and is bound once.
        unsafe { device.bind_buffer_memory(buffer, allocation.memory(), allocation.offset()) }
            .map_err(vk_error("vkBindBufferMemory"))?;
        Ok(raw)
    }

    /// Where shaders and builds of acceleration structures find it. Its usage has `SHADER_DEVICE_ADDRESS`.
    pub fn address(&self) -> vk::DeviceAddress {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.buffer);
        // SAFETY: the buffer is alive, bound to memory, and was made with the usage.
        unsafe { self.gpu.shared().device.get_buffer_device_address(&info) }
    }

    /// A buffer the CPU writes now and the device reads later.
    pub fn upload(gpu: &Gpu, bytes: &[u8]) -> Result<Raw> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC;
        let mut raw = Raw::new(gpu, "upload", bytes.len() as u64, usage, Location::Upload)?;
        let mapped = raw.allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        let Some(mapped) = mapped.and_then(|mapped| mapped.get_mut(..bytes.len())) else {
            return Err(Error::Unsupported("memory that the CPU can write".into()));
        };
        mapped.copy_from_slice(bytes);
        Ok(raw)
    }

    /// A buffer the device writes and the CPU reads once that has finished.
    pub fn download(gpu: &Gpu, bytes: u64) -> Result<Raw> {
        Raw::new(gpu, "download", bytes, vk::BufferUsageFlags::TRANSFER_DST, Location::Download)
    }

    /// The bytes, where the CPU can see them.
    pub fn mapped(&self) -> Option<&[u8]> {
        self.allocation.as_ref()?.mapped_slice()?.get(..self.bytes as usize)
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        // SAFETY: submissions that name the buffer hold it until they have finished, so nothing uses it now.
        unsafe { self.gpu.shared().device.destroy_buffer(self.buffer, None) };
        if let Some(allocation) = self.allocation.take() {
            self.gpu.with_memory(|memory| memory.free(&self.name, self.reserved, allocation));
        }
    }
}
