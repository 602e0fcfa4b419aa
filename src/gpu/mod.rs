//! The Vulkan layer: ash by hand, and the only room with `unsafe`.
//!
//! - [`Gpu`] is a cheap handle to a device; [`Image`], [`Layers`] and [`Buffer`] are named handles whose last drop frees them.
//! - [`Compute`] and [`Raster`] are pipelines, typed by an [`Interface`] that build.rs writes from the shaders.
//! - An [`AccelerationStructure`] is what a device that traces rays by itself does so through.
//! - A `Swapchain` shows images in a window.
//! - A [`Recorder`] takes passes and becomes a [`Submission`]; what the passes name lives until it has finished.
//!
//! **Barriers.** Every pass waits for all before it: one global memory barrier at each boundary. Our work is chains in
//! which each pass needs the last, so finer tracking would buy nothing. [`Recorder::concurrent`] leaves the barriers
//! out between passes that do not depend on each other.
//!
//! **Layouts.** Images are in `GENERAL` from birth to death.
//!
//! **Birth.** Images and buffers are created zeroed, so that no run depends on what memory held before.

mod acceleration;
mod buffer;
mod device;
mod error;
pub mod format;
mod image;
mod memory;
mod objects;
mod pipeline;
mod recorder;
#[cfg(feature = "reload")]
mod reload;
mod submission;
#[cfg(feature = "viewer")]
mod swapchain;
mod texels;
mod transfer;

#[cfg(feature = "reload")]
pub use self::reload::{Changes, Edited, Sources};
#[cfg(feature = "viewer")]
pub use self::swapchain::{Pacing, Shown, Swapchain, Target, window_extensions};
pub use self::{
    acceleration::{AccelerationStructure, Stance},
    buffer::Buffer,
    device::{DeviceInfo, DeviceKind, Gpu, MessageLog, Options, devices, free_ram},
    error::{Error, Result},
    image::{Attachable, Image, Layers, PingPong},
    memory::Usage,
    pipeline::{
        Access, Bind, Bindable, BindingLayout, Blend, Compute, ComputeInterface, Cull, Depth, Descriptor,
        Interface, Raster, RasterInterface, RasterState, ResourceKind, Specialize, StageKind, Topology,
    },
    recorder::{Draw, Draws, IndexedDraw, Load, Recorder, Targets},
    submission::{Download, Finished, Submission, Timing},
    texels::Texels,
    transfer::Transfer,
};
