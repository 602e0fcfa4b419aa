//! Arrays that shaders read sixteen bytes at a time: texel buffers. They may be larger than a storage buffer, of which some devices bind
//! 128 MiB at most, and a device in software reads four numbers at once from them rather than one.

use super::{
    buffer,
    device::Gpu,
    error::{Error, Result, vk_error},
    memory::Location,
    pipeline::{Bindable, Descriptor, Sealed, Share},
    recorder::Recorder,
};
use ash::vk;
use bytemuck::NoUninit;
use std::sync::Arc;

/// Values of whole texels, that don't change.
#[derive(Clone)]
pub struct Texels(Arc<Raw>);

pub(super) struct Raw {
    view: vk::BufferView,
    buffer: Arc<buffer::Raw>,
    gpu: Gpu,
}

/// Bytes of a texel: four unsigned numbers of 32 bits.
const TEXEL: usize = 16;

/// Bytes on their way to the device at once.
const PIECE: usize = 64 << 20;

impl Texels {
    /// With these values, whose size is a multiple of 16 bytes: at least one.
    ///
    /// # Errors
    /// More than a binding may have on this device, or no memory.
    pub fn new<T: NoUninit>(gpu: &Gpu, name: &str, values: &[T]) -> Result<Texels> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let most = gpu.shared().limits.max_texel_buffer_elements;
        let texels = bytes.len() / TEXEL;
        if !size_of::<T>().is_multiple_of(TEXEL) || texels == 0 || texels > most as usize {
            return Err(Error::Unsupported(format!(
                "`{name}` would have {texels} texels; a buffer has 1 to {most} here"
            )));
        }
        let usage = vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = buffer::Raw::new(gpu, name, bytes.len() as u64, usage, Location::Device)?;
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer.buffer)
            .format(vk::Format::R32G32B32A32_UINT)
            .range(bytes.len() as u64);
        // SAFETY: the buffer is alive and has the usage; every device reads texel buffers of this format.
        let view = unsafe { gpu.shared().device.create_buffer_view(&info, None) }
            .map_err(vk_error("vkCreateBufferView"))?;
        let raw = Arc::new(Raw { view, buffer: Arc::new(buffer), gpu: gpu.clone() });
        gpu.name(view, name);
        for (index, piece) in bytes.chunks(PIECE).enumerate() {
            let mut rec = Recorder::new(gpu);
            rec.write(&raw.buffer, (index * PIECE) as u64, piece);
            rec.submit()?.wait()?;
        }
        Ok(Texels(raw))
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        // SAFETY: submissions that use the view hold it until they have finished.
        unsafe { self.gpu.shared().device.destroy_buffer_view(self.view, None) };
    }
}

impl Sealed for Texels {}

impl Bindable for Texels {
    fn descriptor(&self) -> Descriptor {
        Descriptor::Texels(self.0.view)
    }

    fn bytes(&self) -> u64 {
        self.0.buffer.bytes
    }

    fn share(&self) -> Share {
        self.0.clone()
    }
}
