//! Passes that move bytes: clears, copies, uploads and downloads.

use super::{
    buffer::{self, Buffer},
    error::Error,
    format::Format,
    image::{self, Image, Layers},
    recorder::Recorder,
    submission::Download,
};
use ash::vk;
use bytemuck::Pod;
use std::sync::Arc;

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

    /// Fills the first elements of a buffer.
    pub fn upload_first<T: Pod>(&mut self, target: &Buffer<T>, data: &[T]) {
        if data.len() > target.len() {
            let error = format!("an upload of {} elements to a place for {}", data.len(), target.len());
            self.error.get_or_insert(Error::Unsupported(error));
        } else if !data.is_empty() {
            self.write(target.raw(), 0, bytemuck::cast_slice(data));
        }
    }

    /// Fills part of a buffer, which has room for it.
    pub(super) fn write(&mut self, target: &Arc<buffer::Raw>, offset: u64, bytes: &[u8]) {
        self.pass("upload", |rec| {
            let staging = Arc::new(buffer::Raw::upload(&rec.gpu, bytes)?);
            let region = vk::BufferCopy::default().dst_offset(offset).size(bytes.len() as u64);
            // SAFETY: both buffers are alive, have the usage, and room for the region.
            unsafe { rec.device().cmd_copy_buffer(rec.command, staging.buffer, target.buffer, &[region]) };
            rec.hold(staging);
            Ok(())
        });
        self.hold(target.clone());
    }

    /// Copies `source` to where the CPU can read it once the submission has finished.
    pub fn download<T: Transfer>(&mut self, source: &T) -> Download<T::Element> {
        let place = source.place();
        let bytes = (place.elements::<T::Element>() * size_of::<T::Element>()) as u64;
        let mut copy = None;
        self.pass("download", |rec| {
            let staging = Arc::new(buffer::Raw::download(&rec.gpu, bytes)?);
            rec.copy_to(&place, &staging);
            rec.hold(staging.clone());
            copy = Some(staging);
            Ok(())
        });
        self.hold_place(place);
        Download::new(self.id(), copy)
    }

    fn hold_place(&mut self, place: Place) {
        match place {
            Place::Image(ImagePlace(raw)) => self.hold(raw),
            Place::Buffer(BufferPlace(raw)) => self.hold(raw),
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
