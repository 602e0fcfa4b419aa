//! Showing images in a window.
//!
//! Pictures are drawn into images of ours and copied to those of the window at the end. So nothing else in the program knows that a
//! window's images come and go, have formats of their own and other layouts than `GENERAL`.

use super::{
    Gpu,
    error::{Error, Result, vk_error},
    format::Rgba8,
    image::Image,
    recorder::Recorder,
    submission::{Signals, Submission, Timing},
};
use ash::{khr, vk};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use std::{
    collections::{HashMap, VecDeque},
    ffi::CStr,
    sync::Arc,
};

/// What can be drawn to: a window of any toolkit.
pub trait Target: HasDisplayHandle + HasWindowHandle + Send + Sync {}

impl<T: HasDisplayHandle + HasWindowHandle + Send + Sync> Target for T {}

/// The instance extensions that windows of a display take, for [`super::Options`].
///
/// # Errors
/// A display that Vulkan has no windows on.
pub fn window_extensions(display: &dyn HasDisplayHandle) -> Result<Vec<&'static CStr>> {
    let unsupported = |why: &dyn std::fmt::Display| Error::Unsupported(format!("windows here: {why}"));
    let handle = display.display_handle().map_err(|error| unsupported(&error))?;
    let names =
        ash_window::enumerate_required_extensions(handle.as_raw()).map_err(|error| unsupported(&error))?;
    // SAFETY: these are C strings of the program itself.
    Ok(names.iter().map(|name| unsafe { CStr::from_ptr(*name) }).collect())
}

/// When a picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pacing {
    /// With the display, one after the other.
    #[default]
    Fifo,
    /// With the display, and only the newest.
    Mailbox,
    /// At once, though it may tear.
    Immediate,
}

impl Pacing {
    pub const ALL: [Pacing; 3] = [Pacing::Fifo, Pacing::Mailbox, Pacing::Immediate];

    /// What it is called in files.
    pub fn name(self) -> &'static str {
        match self {
            Pacing::Fifo => "fifo",
            Pacing::Mailbox => "mailbox",
            Pacing::Immediate => "immediate",
        }
    }

    fn mode(self) -> vk::PresentModeKHR {
        match self {
            Pacing::Fifo => vk::PresentModeKHR::FIFO,
            Pacing::Mailbox => vk::PresentModeKHR::MAILBOX,
            Pacing::Immediate => vk::PresentModeKHR::IMMEDIATE,
        }
    }
}

/// What became of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shown {
    /// It is on its way. Timings are those of an earlier picture, the last that has been drawn.
    Yes(Vec<Timing>),
    /// The window has no place for it now: it has no size, or did not give an image in time. Ask again later.
    No,
    /// The window had changed; all is ready for the next try.
    Again,
}

/// A window's surface, and the images that are shown on it.
pub struct Swapchain {
    gpu: Gpu,
    // Before the window: it is dropped by hand.
    surface: vk::SurfaceKHR,
    surfaces: khr::surface::Instance,
    functions: khr::swapchain::Device,
    chain: Option<Chain>,
    /// Pictures on their way, the oldest first, with the semaphore that each waits for.
    frames: VecDeque<(Submission, vk::Semaphore)>,
    /// Semaphores that nothing waits for.
    spare: Vec<vk::Semaphore>,
    pacing: Pacing,
    size: [u32; 2],
    /// The window has changed.
    stale: bool,
    failures: Failures,
    window: Arc<dyn Target>,
}

/// The images of one size.
struct Chain {
    raw: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    /// By image: drawn.
    drawn: Vec<vk::Semaphore>,
    size: [u32; 2],
}

/// Pictures that may be on their way at a time.
const FRAMES: usize = 2;

/// How long a window may take to give an image, nanoseconds.
const PATIENCE: u64 = 200_000_000;

impl Swapchain {
    /// For a window of this size, pixels. The device must have been opened with the [`window_extensions`] of its display.
    ///
    /// # Errors
    /// A device that can't show pictures in this window.
    pub fn new(gpu: &Gpu, window: Arc<dyn Target>, size: [u32; 2], pacing: Pacing) -> Result<Swapchain> {
        let (entry, instance, _) = gpu.instance();
        let mut swapchain = Swapchain {
            surface: vk::SurfaceKHR::null(),
            surfaces: khr::surface::Instance::new(entry, instance),
            functions: khr::swapchain::Device::new(instance, &gpu.shared().device),
            chain: None,
            frames: VecDeque::new(),
            spare: Vec::new(),
            pacing,
            size,
            stale: true,
            failures: Failures::from_environment(),
            gpu: gpu.clone(),
            window,
        };
        swapchain.make_surface()?;
        Ok(swapchain)
    }

    /// The window has this size now, pixels; no side if it can't be seen.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.stale |= size != self.size;
        self.size = size;
    }

    /// Those that this window can have.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn pacings(&self) -> Result<Vec<Pacing>> {
        let modes = self.present_modes()?;
        Ok(Pacing::ALL.into_iter().filter(|pacing| modes.contains(&pacing.mode())).collect())
    }

    fn present_modes(&self) -> Result<Vec<vk::PresentModeKHR>> {
        let (_, _, physical) = self.gpu.instance();
        // SAFETY: device and surface are alive.
        unsafe { self.surfaces.get_physical_device_surface_present_modes(physical, self.surface) }
            .map_err(vk_error("vkGetPhysicalDeviceSurfacePresentModesKHR"))
    }

    /// From the next picture on; what the window can't have is as with [`Pacing::Fifo`].
    pub fn pace(&mut self, pacing: Pacing) {
        self.stale |= pacing != self.pacing;
        self.pacing = pacing;
    }

    /// Whether the device has drawn all pictures that it was given.
    ///
    /// # Errors
    /// A lost device.
    pub fn is_idle(&self) -> Result<bool> {
        self.frames.iter().try_fold(true, |idle, (submission, _)| Ok(idle && submission.is_finished()?))
    }

    /// Submits what draws `image` and shows it, scaled if it has not the window's size.
    ///
    /// # Errors
    /// A lost device, or no memory. What happens to windows is none: they are waited for, or made ready again.
    pub fn show(&mut self, mut rec: Recorder, image: &Image<Rgba8>) -> Result<Shown> {
        if self.size.contains(&0) {
            return Ok(Shown::No);
        }
        let timings = self.make_room()?;
        if self.stale || self.chain.is_none() {
            let made = match self.failures.at("create") {
                Some(result) => Err(vk_error("vkCreateSwapchainKHR")(result)),
                None => self.make_chain(),
            };
            match made {
                Ok(()) => {}
                Err(Error::Vk { op, result }) => return self.stumble(result, op),
                Err(error) => return Err(error),
            }
        }
        let acquired = self.semaphore()?;
        let Some(chain) = &self.chain else {
            self.spare.push(acquired);
            return Ok(Shown::No);
        };
        let next = self.failures.at("acquire").map_or_else(
            || {
                // SAFETY: the swapchain is alive and used by this thread alone; nothing waits for the semaphore.
                unsafe { self.functions.acquire_next_image(chain.raw, PATIENCE, acquired, vk::Fence::null()) }
            },
            Err,
        );
        let index = match next {
            Ok((index, suboptimal)) => {
                self.stale |= suboptimal;
                index
            }
            Err(result) => {
                self.spare.push(acquired);
                return self.stumble(result, "vkAcquireNextImageKHR");
            }
        };
        let (to, drawn, size) = (chain.images[index as usize], chain.drawn[index as usize], chain.size);
        copy(&mut rec, image, to, size);
        let submitted = match self.failures.at("submit") {
            Some(result) => Err(vk_error("vkQueueSubmit2")(result)),
            None => rec.submit_between(Signals { wait: Some(acquired), signal: Some(drawn) }),
        };
        match submitted {
            Ok(submission) => self.frames.push_back((submission, acquired)),
            Err(error) => {
                // An image is ours, and nothing will give it back but a new swapchain.
                self.retire(acquired);
                return Err(error);
            }
        }
        let presented = self.failures.at("present").map_or_else(|| self.present(index, drawn), Err);
        match presented {
            Ok(suboptimal) => self.stale |= suboptimal,
            Err(result) => return self.stumble(result, "vkQueuePresentKHR"),
        }
        Ok(Shown::Yes(timings))
    }

    fn present(&self, index: u32, drawn: vk::Semaphore) -> std::result::Result<bool, vk::Result> {
        let Some(chain) = &self.chain else { return Ok(true) };
        let (chains, indices, waits) = ([chain.raw], [index], [drawn]);
        let info =
            vk::PresentInfoKHR::default().wait_semaphores(&waits).swapchains(&chains).image_indices(&indices);
        let queue = self.gpu.queue();
        // SAFETY: the image was acquired, and the submission that draws it signals the semaphore; the queue is locked.
        unsafe { self.functions.queue_present(*queue, &info) }
    }

    /// What a failure of the window means.
    fn stumble(&mut self, result: vk::Result, op: &'static str) -> Result<Shown> {
        match result {
            vk::Result::TIMEOUT | vk::Result::NOT_READY => Ok(Shown::No),
            vk::Result::ERROR_OUT_OF_DATE_KHR => {
                self.stale = true;
                Ok(Shown::Again)
            }
            vk::Result::ERROR_SURFACE_LOST_KHR => {
                self.free_chain();
                // SAFETY: its swapchain is gone.
                unsafe { self.surfaces.destroy_surface(self.surface, None) };
                self.surface = vk::SurfaceKHR::null();
                self.make_surface()?;
                Ok(Shown::Again)
            }
            result => Err(vk_error(op)(result)),
        }
    }

    /// Waits until another picture may be on its way.
    fn make_room(&mut self) -> Result<Vec<Timing>> {
        let mut timings = Vec::new();
        while self.frames.len() >= FRAMES {
            let Some((submission, semaphore)) = self.frames.pop_front() else { break };
            let finished = submission.wait();
            self.spare.push(semaphore);
            timings = finished?.timings;
        }
        Ok(timings)
    }

    /// A semaphore that nothing waits for.
    fn semaphore(&mut self) -> Result<vk::Semaphore> {
        match self.spare.pop() {
            Some(semaphore) => Ok(semaphore),
            None => make_semaphore(&self.gpu),
        }
    }

    fn make_surface(&mut self) -> Result<()> {
        let (entry, instance, physical) = self.gpu.instance();
        let unsupported = |error| Error::Unsupported(format!("this window: {error}"));
        let display = self.window.display_handle().map_err(unsupported)?.as_raw();
        let window = self.window.window_handle().map_err(unsupported)?.as_raw();
        // SAFETY: the window lives as long as the swapchain, which holds it, and the instance as long as the device.
        self.surface = unsafe { ash_window::create_surface(entry, instance, display, window, None) }
            .map_err(vk_error("vkCreateSurfaceKHR"))?;
        self.stale = true;
        let family = self.gpu.shared().queue_family;
        // SAFETY: the surface was just made from this instance.
        let supported =
            unsafe { self.surfaces.get_physical_device_surface_support(physical, family, self.surface) };
        match supported.map_err(vk_error("vkGetPhysicalDeviceSurfaceSupportKHR"))? {
            true => Ok(()),
            false => Err(Error::Unsupported("showing pictures in this window; try another --device".into())),
        }
    }

    /// Images of the window's size; none if it has none.
    fn make_chain(&mut self) -> Result<()> {
        self.settle()?;
        let (_, _, physical) = self.gpu.instance();
        // SAFETY: device and surface are alive.
        let capabilities =
            unsafe { self.surfaces.get_physical_device_surface_capabilities(physical, self.surface) }
                .map_err(vk_error("vkGetPhysicalDeviceSurfaceCapabilitiesKHR"))?;
        // Windows that take their size from the images say so by the greatest number.
        let size = match capabilities.current_extent {
            vk::Extent2D { width: u32::MAX, height: u32::MAX } => {
                let (least, most) = (capabilities.min_image_extent, capabilities.max_image_extent);
                [
                    self.size[0].clamp(least.width, most.width.max(least.width)),
                    self.size[1].clamp(least.height, most.height.max(least.height)),
                ]
            }
            vk::Extent2D { width, height } => [width, height],
        };
        if size.contains(&0) {
            self.drop_chain();
            return Ok(());
        }
        let format = self.format(physical)?;
        let modes = self.present_modes()?;
        let mode = Some(self.pacing.mode()).filter(|mode| modes.contains(mode));
        if !capabilities.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return Err(Error::Unsupported("copies to this window".into()));
        }
        let most = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT]
            .into_iter()
            .find(|alpha| capabilities.supported_composite_alpha.contains(*alpha))
            .unwrap_or(vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED);
        let old = self.chain.as_ref().map(|chain| chain.raw);
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.surface)
            .min_image_count((capabilities.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(vk::Extent2D { width: size[0], height: size[1] })
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(alpha)
            .present_mode(mode.unwrap_or(vk::PresentModeKHR::FIFO))
            .clipped(true)
            .old_swapchain(old.unwrap_or_default());
        // SAFETY: all of it was asked of the surface; the old swapchain is of the same one, and its pictures are done.
        let raw = unsafe { self.functions.create_swapchain(&info, None) };
        self.drop_chain();
        let raw = raw.map_err(vk_error("vkCreateSwapchainKHR"))?;
        let chain = self.chain.insert(Chain { raw, images: Vec::new(), drawn: Vec::new(), size });
        // SAFETY: the swapchain was just made.
        chain.images = unsafe { self.functions.get_swapchain_images(raw) }
            .map_err(vk_error("vkGetSwapchainImagesKHR"))?;
        for _ in 0..chain.images.len() {
            chain.drawn.push(make_semaphore(&self.gpu)?);
        }
        self.stale = false;
        Ok(())
    }

    /// One whose values are shown as they are: pictures are sRGB already.
    fn format(&self, physical: vk::PhysicalDevice) -> Result<vk::SurfaceFormatKHR> {
        // SAFETY: device and surface are alive.
        let formats = unsafe { self.surfaces.get_physical_device_surface_formats(physical, self.surface) }
            .map_err(vk_error("vkGetPhysicalDeviceSurfaceFormatsKHR"))?;
        let wanted =
            [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM, vk::Format::A8B8G8R8_UNORM_PACK32];
        let srgb = vk::ColorSpaceKHR::SRGB_NONLINEAR;
        let found = wanted.iter().find_map(|wanted| {
            formats.iter().find(|format| format.format == *wanted && format.color_space == srgb)
        });
        found.copied().ok_or_else(|| Error::Unsupported("8-bit sRGB in this window".into()))
    }

    /// Waits until nothing that was submitted for the window is under way. Who draws the world waits for each of its submissions before the
    /// next, so that this waits for no more than one of them.
    fn settle(&mut self) -> Result<()> {
        let mut result = Ok(());
        while let Some((submission, semaphore)) = self.frames.pop_front() {
            result = result.and(submission.wait().map(drop));
            self.spare.push(semaphore);
        }
        let queue = self.gpu.queue();
        // Presenting has no fence of its own.
        // SAFETY: the queue is locked.
        let idle = unsafe { self.gpu.shared().device.queue_wait_idle(*queue) };
        result.and(idle.map_err(vk_error("vkQueueWaitIdle")))
    }

    /// Lets go of an image that was acquired and can't be shown, with the semaphore that it came with.
    fn retire(&mut self, acquired: vk::Semaphore) {
        self.free_chain();
        // SAFETY: the queue is idle and the swapchain gone: nothing signals it any more.
        unsafe { self.gpu.shared().device.destroy_semaphore(acquired, None) };
    }

    fn free_chain(&mut self) {
        // A lost device has nothing under way.
        let _ = self.settle();
        self.drop_chain();
    }

    /// The same once all is settled.
    fn drop_chain(&mut self) {
        let Some(chain) = self.chain.take() else { return };
        // SAFETY: nothing is under way that uses them.
        unsafe {
            for semaphore in chain.drawn {
                self.gpu.shared().device.destroy_semaphore(semaphore, None);
            }
            self.functions.destroy_swapchain(chain.raw, None);
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        self.free_chain();
        // SAFETY: nothing is under way that uses them; the surface's swapchain is gone, and its window is still there.
        unsafe {
            for semaphore in self.spare.drain(..) {
                self.gpu.shared().device.destroy_semaphore(semaphore, None);
            }
            self.surfaces.destroy_surface(self.surface, None);
        }
    }
}

fn make_semaphore(gpu: &Gpu) -> Result<vk::Semaphore> {
    // SAFETY: the device is alive.
    unsafe { gpu.shared().device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
        .map_err(vk_error("vkCreateSemaphore"))
}

/// Copies `image` to one of the window's, which it leaves ready to be shown.
fn copy(rec: &mut Recorder, image: &Image<Rgba8>, to: vk::Image, size: [u32; 2]) {
    let from = image.raw().clone();
    rec.pass("show", |rec| {
        let range = from.range();
        let turn = |old, new, source: vk::AccessFlags2, target: vk::AccessFlags2| {
            [vk::ImageMemoryBarrier2::default()
                .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                .src_access_mask(source)
                .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
                .dst_access_mask(target)
                .old_layout(old)
                .new_layout(new)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(to)
                .subresource_range(range)]
        };
        let destination = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let (none, write) = (vk::AccessFlags2::NONE, vk::AccessFlags2::TRANSFER_WRITE);
        let before = turn(vk::ImageLayout::UNDEFINED, destination, none, write);
        let after = turn(destination, vk::ImageLayout::PRESENT_SRC_KHR, write, none);
        let corner =
            |size: [u32; 2]| vk::Offset3D { x: size[0].cast_signed(), y: size[1].cast_signed(), z: 1 };
        let layers = from.copy_region().image_subresource;
        let blit = vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets([vk::Offset3D::default(), corner(from.size)])
            .dst_subresource(layers)
            .dst_offsets([vk::Offset3D::default(), corner(size)]);
        // SAFETY: ours is in GENERAL; the window's was acquired, and the submission waits until it may be written.
        unsafe {
            let device = rec.device();
            let info = vk::DependencyInfo::default().image_memory_barriers(&before);
            device.cmd_pipeline_barrier2(rec.command, &info);
            let general = vk::ImageLayout::GENERAL;
            let filter = vk::Filter::NEAREST;
            device.cmd_blit_image(rec.command, from.image, general, to, destination, &[blit], filter);
            let info = vk::DependencyInfo::default().image_memory_barriers(&after);
            device.cmd_pipeline_barrier2(rec.command, &info);
        }
        rec.hold(from.clone());
        Ok(())
    });
}

/// Nobody can make a window fail when it should: tests say in `TERRANE_LOSE_WINDOW` at which calls it seems to, as
/// `acquire:3:out_of_date,present:5:surface_lost,submit:9:device_lost` for example. Calls are counted from 1.
#[derive(Default)]
struct Failures {
    wanted: Vec<(String, u64, vk::Result)>,
    calls: HashMap<&'static str, u64>,
}

impl Failures {
    fn from_environment() -> Failures {
        let text = std::env::var("TERRANE_LOSE_WINDOW").unwrap_or_default();
        let one = |text: &str| {
            let mut parts = text.split(':');
            let (at, call) = (parts.next()?.trim().to_owned(), parts.next()?.parse().ok()?);
            let result = match parts.next()? {
                "out_of_date" => vk::Result::ERROR_OUT_OF_DATE_KHR,
                "surface_lost" => vk::Result::ERROR_SURFACE_LOST_KHR,
                "device_lost" => vk::Result::ERROR_DEVICE_LOST,
                _ => return None,
            };
            Some((at, call, result))
        };
        Failures { wanted: text.split(',').filter_map(one).collect(), calls: HashMap::new() }
    }

    /// What the next call at a point seems to come to.
    fn at(&mut self, point: &'static str) -> Option<vk::Result> {
        if self.wanted.is_empty() {
            return None;
        }
        let call = self.calls.entry(point).or_default();
        *call += 1;
        self.wanted.iter().find(|(at, wanted, _)| at == point && wanted == call).map(|(.., result)| *result)
    }
}
