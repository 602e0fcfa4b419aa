//! Choosing a device and opening it.

use super::{
    error::{Error, Result, vk_error},
    memory::{Memory, Usage},
    objects::Pools,
    pipeline,
};
use crate::core::hash::hexadecimal;
use ash::{ext, khr, vk};
use std::{
    ffi::{CStr, CString, c_char, c_void},
    fmt,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Index or part of the name, as `terrane devices` lists them; `None` takes the fastest kind.
    pub device: Option<String>,
    /// Most bytes of device memory that may be allocated; `None` is 80 % of the device-local heap, and of free RAM
    /// on a CPU device.
    pub memory_limit: Option<u64>,
    /// Switches the validation layer on (core and synchronization); its messages are collected here.
    pub validation: Option<MessageLog>,
    /// Instance extensions that showing pictures in a window takes; none if there is no window.
    pub window_extensions: Vec<&'static CStr>,
}

/// Messages of the validation layer. Clones share one list.
#[derive(Clone, Debug, Default)]
pub struct MessageLog(Arc<Mutex<Vec<String>>>);

impl MessageLog {
    /// The messages so far; the list is emptied.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *lock(&self.0))
    }
}

/// What a device is, in the order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    Discrete,
    Integrated,
    Virtual,
    Cpu,
    Other,
}

impl fmt::Display for DeviceKind {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(match self {
            DeviceKind::Discrete => "discrete GPU",
            DeviceKind::Integrated => "integrated GPU",
            DeviceKind::Virtual => "virtual GPU",
            DeviceKind::Cpu => "CPU",
            DeviceKind::Other => "other",
        })
    }
}

/// A Vulkan device of this machine.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    pub index: usize,
    pub name: String,
    pub kind: DeviceKind,
    /// Name and version of the driver.
    pub driver: String,
    /// Vendor, device, driver and the exact build of it, in hexadecimal: where it is the same, so are the bits of results.
    pub identity: String,
    /// Version of Vulkan: major, minor, patch.
    pub vulkan: [u32; 3],
    /// Bytes of the largest device-local heap.
    pub memory: u64,
    /// Largest width and height of an image.
    pub max_image: u32,
    /// Bytes of the largest single allocation.
    pub max_allocation: u64,
    /// Bytes of the largest buffer that a program reads.
    pub max_buffer: u64,
    /// Whether it traces rays by itself (`VK_KHR_ray_query`).
    pub ray_query: bool,
    /// What terrane needs and the device lacks; empty if it can be used.
    pub missing: Vec<&'static str>,
}

/// Every Vulkan device of this machine, usable or not.
pub fn devices() -> Result<Vec<DeviceInfo>> {
    let instance = Instance::new(None, &[])?;
    Ok(instance.candidates()?.into_iter().map(|candidate| candidate.info).collect())
}

/// A device that has been opened. Clones are cheap and share it.
#[derive(Clone)]
pub struct Gpu(Arc<Shared>);

pub(super) struct Shared {
    pub device: ash::Device,
    pub debug: Option<ext::debug_utils::Device>,
    pub limits: vk::PhysicalDeviceLimits,
    pub queue_family: u32,
    /// Whether the queue can take the time.
    pub timestamps: bool,
    pub pipeline_cache: vk::PipelineCache,
    /// Of devices that trace rays by themselves.
    pub acceleration: Option<Acceleration>,
    /// Programs in place of those of the build.
    #[cfg(feature = "reload")]
    pub edited: Mutex<Vec<super::Edited>>,
    pub programs: Mutex<pipeline::Programs>,
    /// What recorders are done with.
    pub pools: Mutex<Vec<Pools>>,
    queue: Mutex<vk::Queue>,
    memory: Mutex<Option<Memory>>,
    physical: vk::PhysicalDevice,
    info: DeviceInfo,
    // Dropped last: the instance outlives everything made from it.
    instance: Instance,
}

/// What acceleration structures are made with, and their limits.
pub(super) struct Acceleration {
    pub functions: khr::acceleration_structure::Device,
    pub limits: AccelerationLimits,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct AccelerationLimits {
    pub scratch_alignment: u64,
    pub most_triangles: u64,
    pub most_instances: u64,
}

impl Gpu {
    /// Opens the device that `options` name.
    pub fn new(options: &Options) -> Result<Gpu> {
        let instance = Instance::new(options.validation.clone(), &options.window_extensions)?;
        let candidate = choose(instance.candidates()?, options.device.as_deref())?;
        open(instance, candidate, options.memory_limit, !options.window_extensions.is_empty())
    }

    pub fn info(&self) -> &DeviceInfo {
        &self.0.info
    }

    /// Device memory in use, by name.
    pub fn memory(&self) -> Usage {
        lock(&self.0.memory).as_ref().map(Memory::usage).unwrap_or_default()
    }

    /// What a window's surface is made with.
    #[cfg(feature = "viewer")]
    pub(super) fn instance(&self) -> (&ash::Entry, &ash::Instance, vk::PhysicalDevice) {
        (&self.0.instance.entry, &self.0.instance.raw, self.0.physical)
    }

    pub(super) fn shared(&self) -> &Shared {
        &self.0
    }

    /// The queue, for as long as one thread uses it.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        lock(&self.0.queue)
    }

    pub(super) fn with_memory<T>(&self, work: impl FnOnce(&mut Memory) -> T) -> Option<T> {
        lock(&self.0.memory).as_mut().map(work)
    }

    /// Whether images of `format` can be used as `usage` says.
    pub(super) fn check_format(&self, format: vk::Format, usage: vk::ImageUsageFlags) -> Result<()> {
        // SAFETY: the physical device belongs to this instance, which is alive.
        let properties =
            unsafe { self.0.instance.raw.get_physical_device_format_properties(self.0.physical, format) };
        let needed = [
            (vk::ImageUsageFlags::STORAGE, vk::FormatFeatureFlags::STORAGE_IMAGE),
            (vk::ImageUsageFlags::COLOR_ATTACHMENT, vk::FormatFeatureFlags::COLOR_ATTACHMENT),
            (vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT, vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT),
        ];
        for (use_, feature) in needed {
            if usage.contains(use_) && !properties.optimal_tiling_features.contains(feature) {
                return Err(Error::Unsupported(format!("{format:?} images as {use_:?}")));
            }
        }
        Ok(())
    }

    /// Gives a Vulkan object the name that validation messages and debuggers show.
    pub(super) fn name<T: vk::Handle>(&self, handle: T, name: &str) {
        let Some(debug) = &self.0.debug else { return };
        let Ok(name) = CString::new(name) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle belongs to this device and is not in use by another thread: it is being created.
        // A name that cannot be set is no loss.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }
}

impl fmt::Debug for Gpu {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        write!(out, "Gpu({})", self.0.info.name)
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // Frees the memory blocks while the device is alive.
        lock(&self.memory).take();
        // SAFETY: every object made from the device holds a `Gpu`, so all of them are gone, and submissions wait
        // for their fence before they go.
        unsafe {
            for pools in lock(&self.pools).drain(..) {
                pools.destroy(&self.device);
            }
            self.device.destroy_pipeline_cache(self.pipeline_cache, None);
            self.device.destroy_device(None);
        }
    }
}

/// The lock, also after a panic elsewhere: what it guards stays consistent between calls.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The loader's side: an instance, and a messenger if validation is on.
struct Instance {
    raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    has_debug_utils: bool,
    // The messenger writes here until the instance is gone.
    _log: Option<MessageLog>,
    // The loader's library stays mapped as long as the functions in it may be called.
    #[cfg_attr(not(feature = "viewer"), allow(dead_code, reason = "kept alive"))]
    entry: ash::Entry,
}

impl Instance {
    fn new(log: Option<MessageLog>, window_extensions: &[&'static CStr]) -> Result<Instance> {
        // SAFETY: loading the Vulkan loader runs its initializers, which are sound in any loader that conforms.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|error| Error::Loader { reason: format!("the Vulkan loader is missing ({error})") })?;
        // SAFETY: a global function of a loader that is loaded.
        let version = unsafe { entry.try_enumerate_instance_version() }.ok().flatten();
        if version.unwrap_or(vk::API_VERSION_1_0) < vk::API_VERSION_1_3 {
            return Err(Error::Loader { reason: "the Vulkan loader is older than 1.3".into() });
        }
        let has_debug_utils = has_debug_utils(&entry, log.is_some())?;
        check_extensions(&entry, window_extensions)?;
        let debug_utils = has_debug_utils.then_some(ext::debug_utils::NAME);
        let extensions = debug_utils.into_iter().chain(window_extensions.iter().copied());
        let extensions: Vec<*const c_char> = extensions.map(CStr::as_ptr).collect();
        let layers: Vec<*const c_char> =
            log.is_some().then_some(VALIDATION_LAYER.as_ptr()).into_iter().collect();
        if log.is_some() && !has_layer(&entry, VALIDATION_LAYER)? {
            return Err(Error::Unsupported(
                "the validation layer is not installed (Debian and Ubuntu: apt install vulkan-validationlayers)"
                    .into(),
            ));
        }

        let application = vk::ApplicationInfo::default()
            .application_name(c"terrane")
            .engine_name(c"terrane")
            .api_version(vk::API_VERSION_1_3);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut messenger_info = messenger_info(log.as_ref());
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_extension_names(&extensions)
            .enabled_layer_names(&layers);
        if log.is_some() {
            info = info.push_next(&mut features).push_next(&mut messenger_info);
        }
        // SAFETY: `info` and all it points to live until the call returns; the log outlives the instance in `_log`.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => {
                Error::Loader { reason: "the Vulkan loader finds no driver".into() }
            }
            result => Error::Vk { op: "vkCreateInstance", result },
        })?;
        let mut instance = Instance { raw, messenger: None, has_debug_utils, _log: log, entry };
        if instance._log.is_some() {
            let debug = ext::debug_utils::Instance::new(&instance.entry, &instance.raw);
            let info = self::messenger_info(instance._log.as_ref());
            // SAFETY: the extension is enabled; the log that the callback writes to lives as long as the instance.
            let messenger = unsafe { debug.create_debug_utils_messenger(&info, None) }
                .map_err(vk_error("vkCreateDebugUtilsMessengerEXT"))?;
            instance.messenger = Some((debug, messenger));
        }
        Ok(instance)
    }

    fn candidates(&self) -> Result<Vec<Candidate>> {
        // SAFETY: the instance is alive.
        let physical = unsafe { self.raw.enumerate_physical_devices() }.map_err(|result| match result {
            vk::Result::ERROR_INITIALIZATION_FAILED => {
                Error::Loader { reason: "the Vulkan drivers do not start".into() }
            }
            result => Error::Vk { op: "vkEnumeratePhysicalDevices", result },
        })?;
        Ok(physical
            .into_iter()
            .enumerate()
            .map(|(index, physical)| self.candidate(index, physical))
            .collect())
    }

    fn candidate(&self, index: usize, physical: vk::PhysicalDevice) -> Candidate {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut ids = vk::PhysicalDeviceIDProperties::default();
        let mut allocation = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut driver)
            .push_next(&mut ids)
            .push_next(&mut allocation);
        // SAFETY: the physical device belongs to this instance; the chain is made of live structs that Vulkan 1.2
        // knows, and a device below that version leaves the ones it does not know untouched.
        unsafe { self.raw.get_physical_device_properties2(physical, &mut properties) };
        let properties = properties.properties;
        // SAFETY: as above.
        let memory = unsafe { self.raw.get_physical_device_memory_properties(physical) };
        // SAFETY: as above.
        let queues = unsafe { self.raw.get_physical_device_queue_family_properties(physical) };
        let queue_family = queues.iter().position(|family| {
            family.queue_flags.contains(vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE)
        });
        let mut missing = Vec::new();
        if properties.api_version < vk::API_VERSION_1_3 {
            missing.push("Vulkan 1.3");
        } else {
            missing.extend(self.missing_features(physical));
        }
        if queue_family.is_none() {
            missing.push("a queue for graphics and compute");
        }
        let version = properties.api_version;
        let info = DeviceInfo {
            index,
            name: text(&properties.device_name),
            kind: match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
                vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
                vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
                vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
                _ => DeviceKind::Other,
            },
            driver: format!("{} {}", text(&driver.driver_name), text(&driver.driver_info)).trim().to_owned(),
            identity: identity(&properties, &ids),
            vulkan: [
                vk::api_version_major(version),
                vk::api_version_minor(version),
                vk::api_version_patch(version),
            ],
            memory: memory
                .memory_heaps_as_slice()
                .iter()
                .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
                .map(|heap| heap.size)
                .max()
                .unwrap_or(0),
            max_image: properties.limits.max_image_dimension2_d,
            max_allocation: allocation.max_memory_allocation_size,
            max_buffer: properties.limits.max_storage_buffer_range.into(),
            ray_query: missing.is_empty() && self.has_ray_query(physical),
            missing,
        };
        Candidate {
            physical,
            queue_family: queue_family.unwrap_or(0) as u32,
            timestamps: queue_family.is_some_and(|family| queues[family].timestamp_valid_bits > 0),
            limits: properties.limits,
            info,
        }
    }

    fn missing_features(&self, physical: vk::PhysicalDevice) -> Vec<&'static str> {
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12).push_next(&mut v13);
        // SAFETY: the physical device belongs to this instance and supports 1.3, so it knows the structs.
        unsafe { self.raw.get_physical_device_features2(physical, &mut features) };
        let tessellation = features.features.tessellation_shader;
        let extended_formats = features.features.shader_storage_image_extended_formats;
        [
            (tessellation, "tessellation shaders"),
            (extended_formats, "storage images of extended formats"),
            (features.features.shader_int64, "64-bit integers in shaders"),
            (v12.scalar_block_layout, "scalar block layout"),
            (v12.buffer_device_address, "addresses of buffers"),
            (v13.dynamic_rendering, "dynamic rendering"),
            (v13.synchronization2, "synchronization2"),
            (v13.maintenance4, "maintenance4"),
        ]
        .into_iter()
        .filter(|(present, _)| *present == vk::FALSE)
        .map(|(_, name)| name)
        .collect()
    }
}

impl Instance {
    fn has_extensions(&self, physical: vk::PhysicalDevice, names: &[&CStr]) -> bool {
        // SAFETY: the physical device belongs to this instance.
        let extensions =
            unsafe { self.raw.enumerate_device_extension_properties(physical) }.unwrap_or_default();
        names.iter().all(|name| extensions.iter().any(|it| it.extension_name_as_c_str() == Ok(*name)))
    }

    fn check_presents(&self, physical: vk::PhysicalDevice, info: &DeviceInfo) -> Result<()> {
        match self.has_extensions(physical, &[khr::swapchain::NAME]) {
            true => Ok(()),
            false => Err(Error::NoDevice(format!("{} can't show pictures in a window", info.name))),
        }
    }

    /// Whether rays can be traced by compute shaders, through structures that the device builds.
    fn has_ray_query(&self, physical: vk::PhysicalDevice) -> bool {
        if !self.has_extensions(physical, &RAY_QUERY_EXTENSIONS) {
            return false;
        }
        let mut acceleration = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
        let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
        let mut features =
            vk::PhysicalDeviceFeatures2::default().push_next(&mut acceleration).push_next(&mut query);
        // SAFETY: as above; the device has the extensions that the structs belong to.
        unsafe { self.raw.get_physical_device_features2(physical, &mut features) };
        acceleration.acceleration_structure == vk::TRUE && query.ray_query == vk::TRUE
    }

    fn acceleration_limits(&self, physical: vk::PhysicalDevice) -> AccelerationLimits {
        let mut acceleration = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut acceleration);
        // SAFETY: the physical device belongs to this instance and has the extension of the struct.
        unsafe { self.raw.get_physical_device_properties2(physical, &mut properties) };
        AccelerationLimits {
            scratch_alignment: acceleration.min_acceleration_structure_scratch_offset_alignment.max(1).into(),
            most_triangles: acceleration.max_primitive_count,
            most_instances: acceleration.max_instance_count,
        }
    }
}

const RAY_QUERY_EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::deferred_host_operations::NAME, khr::ray_query::NAME];

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: the device was destroyed before (it is a field above in `Shared`, or never made).
        unsafe {
            if let Some((debug, messenger)) = self.messenger.take() {
                debug.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

struct Candidate {
    physical: vk::PhysicalDevice,
    queue_family: u32,
    timestamps: bool,
    limits: vk::PhysicalDeviceLimits,
    info: DeviceInfo,
}

/// The candidate that `wanted` names, or the best usable one.
fn choose(mut candidates: Vec<Candidate>, wanted: Option<&str>) -> Result<Candidate> {
    let infos: Vec<&DeviceInfo> = candidates.iter().map(|candidate| &candidate.info).collect();
    let index = choose_index(&infos, wanted)?;
    Ok(candidates.swap_remove(index))
}

/// A whole number is an index, and anything else a part of a name.
fn choose_index(infos: &[&DeviceInfo], wanted: Option<&str>) -> Result<usize> {
    let list =
        infos.iter().map(|info| format!("{}: {}", info.index, info.name)).collect::<Vec<_>>().join("; ");
    if infos.is_empty() {
        return Err(Error::Loader { reason: "the Vulkan drivers find no device".into() });
    }
    let Some(wanted) = wanted else {
        let usable = infos.iter().enumerate().filter(|(_, info)| info.missing.is_empty());
        let best = usable.min_by_key(|(index, info)| (info.kind, *index));
        return best.map(|(index, _)| index).ok_or_else(|| {
            Error::NoDevice(format!("no device can run terrane; `terrane devices` says why; there is {list}"))
        });
    };
    let found = match wanted.parse::<usize>() {
        Ok(number) => infos.iter().position(|info| info.index == number),
        Err(_) if wanted.is_empty() => None,
        Err(_) => infos.iter().position(|info| info.name.to_lowercase().contains(&wanted.to_lowercase())),
    };
    let index =
        found.ok_or_else(|| Error::NoDevice(format!("no device matches `{wanted}`; there is {list}")))?;
    if !infos[index].missing.is_empty() {
        let missing = infos[index].missing.join(", ");
        return Err(Error::NoDevice(format!("{} lacks {missing}; there is {list}", infos[index].name)));
    }
    Ok(index)
}

fn open(
    instance: Instance,
    candidate: Candidate,
    memory_limit: Option<u64>,
    for_windows: bool,
) -> Result<Gpu> {
    let Candidate { physical, queue_family, timestamps, limits, info } = candidate;
    let priorities = [1.0];
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&priorities)];
    let features = vk::PhysicalDeviceFeatures::default()
        // Every device has it. An index beyond a buffer's end then reads zero, or what else the buffer holds.
        .robust_buffer_access(true)
        .tessellation_shader(true)
        .shader_int64(true)
        .shader_storage_image_extended_formats(true);
    let mut v12 =
        vk::PhysicalDeviceVulkan12Features::default().scalar_block_layout(true).buffer_device_address(true);
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .synchronization2(true)
        // What `discard` is compiled to; every device with 1.3 has it.
        .shader_demote_to_helper_invocation(true)
        .maintenance4(true);
    let mut acceleration =
        vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
    let mut query = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
    let mut extensions = Vec::new();
    if for_windows {
        instance.check_presents(physical, &info)?;
        extensions.push(khr::swapchain::NAME.as_ptr());
    }
    if info.ray_query {
        extensions.extend(RAY_QUERY_EXTENSIONS.map(CStr::as_ptr));
    }
    let mut create = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .enabled_extension_names(&extensions)
        .push_next(&mut v12)
        .push_next(&mut v13);
    if info.ray_query {
        create = create.push_next(&mut acceleration).push_next(&mut query);
    }
    // SAFETY: all features were seen to be supported; the structs live until the call returns.
    let device =
        unsafe { instance.raw.create_device(physical, &create, None) }.map_err(vk_error("vkCreateDevice"))?;
    // SAFETY: the family was asked for one queue.
    let queue = unsafe { device.get_device_queue(queue_family, 0) };
    let debug = instance.has_debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &device));
    let memory =
        Memory::new(&instance.raw, &device, physical, memory_limit.unwrap_or_else(|| default_limit(&info)));
    // SAFETY: the device is alive.
    let pipeline_cache =
        unsafe { device.create_pipeline_cache(&vk::PipelineCacheCreateInfo::default(), None) };
    let (memory, pipeline_cache) = match (memory, pipeline_cache) {
        (Ok(memory), Ok(cache)) => (memory, cache),
        (memory, cache) => {
            let error = memory.as_ref().err().cloned();
            // The allocator goes before its device.
            drop(memory);
            // SAFETY: nothing else has been made from the device; destroying no cache is allowed.
            unsafe {
                device.destroy_pipeline_cache(cache.unwrap_or_default(), None);
                device.destroy_device(None);
            }
            let cache_error = cache.err().map(vk_error("vkCreatePipelineCache"));
            return Err(error.or(cache_error).unwrap_or_else(|| Error::Unsupported("this device".into())));
        }
    };
    let acceleration = info.ray_query.then(|| Acceleration {
        functions: khr::acceleration_structure::Device::new(&instance.raw, &device),
        limits: instance.acceleration_limits(physical),
    });
    Ok(Gpu(Arc::new(Shared {
        device,
        acceleration,
        debug,
        limits,
        queue_family,
        timestamps,
        pipeline_cache,
        #[cfg(feature = "reload")]
        edited: Mutex::default(),
        programs: Mutex::default(),
        pools: Mutex::default(),
        queue: Mutex::new(queue),
        memory: Mutex::new(Some(memory)),
        physical,
        info,
        instance,
    })))
}

/// 80 % of the device's heap, and of free RAM where the device is the CPU.
fn default_limit(info: &DeviceInfo) -> u64 {
    let available = match info.kind {
        DeviceKind::Cpu => free_ram().map_or(info.memory, |free| free.min(info.memory)),
        _ => info.memory,
    };
    available / 5 * 4
}

/// Free memory of this machine, bytes, where the system tells it.
pub fn free_ram() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

fn has_debug_utils(entry: &ash::Entry, with_validation: bool) -> Result<bool> {
    let layers = [None, with_validation.then_some(VALIDATION_LAYER)];
    for layer in layers.into_iter().take(1 + usize::from(with_validation)) {
        // SAFETY: a global function of a loader that is loaded; the name is a C string.
        let extensions = match unsafe { entry.enumerate_instance_extension_properties(layer) } {
            Err(vk::Result::ERROR_LAYER_NOT_PRESENT) => continue,
            other => other.map_err(vk_error("vkEnumerateInstanceExtensionProperties"))?,
        };
        if extensions.iter().any(|it| it.extension_name_as_c_str() == Ok(ext::debug_utils::NAME)) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Of the instance, for windows.
fn check_extensions(entry: &ash::Entry, names: &[&'static CStr]) -> Result<()> {
    if names.is_empty() {
        return Ok(());
    }
    // SAFETY: a global function of a loader that is loaded.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }
        .map_err(vk_error("vkEnumerateInstanceExtensionProperties"))?;
    let has = |name: &CStr| extensions.iter().any(|it| it.extension_name_as_c_str() == Ok(name));
    match names.iter().find(|name| !has(name)) {
        Some(name) => Err(Error::Unsupported(format!("windows, for want of {}", name.to_string_lossy()))),
        None => Ok(()),
    }
}

fn has_layer(entry: &ash::Entry, name: &CStr) -> Result<bool> {
    // SAFETY: a global function of a loader that is loaded.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .map_err(vk_error("vkEnumerateInstanceLayerProperties"))?;
    Ok(layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(name)))
}

fn messenger_info(log: Option<&MessageLog>) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    let user_data = log.map_or(std::ptr::null_mut(), |log| Arc::as_ptr(&log.0).cast_mut().cast::<c_void>());
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        // Not PERFORMANCE: that is advice, and it advises against images in GENERAL, which is our policy.
        .message_type(
            vk::DebugUtilsMessageTypeFlagsEXT::GENERAL | vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION,
        )
        .pfn_user_callback(Some(on_message))
        .user_data(user_data)
}

unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data with a C string, and `user_data` is the list inside the instance's log.
    let (data, log) = unsafe { (data.as_ref(), user_data.cast::<Mutex<Vec<String>>>().as_ref()) };
    // SAFETY: as above.
    let message = data.and_then(|data| unsafe { data.message_as_c_str() });
    if let (Some(message), Some(log)) = (message, log) {
        lock(log).push(message.to_string_lossy().into_owned());
    }
    vk::FALSE
}

/// Drivers derive the UUIDs of pipeline cache and driver from their build: these change when generated code may.
fn identity(properties: &vk::PhysicalDeviceProperties, ids: &vk::PhysicalDeviceIDProperties) -> String {
    let numbers = [properties.vendor_id, properties.device_id, properties.driver_version];
    let numbers = numbers.iter().flat_map(|number| number.to_be_bytes());
    let uuids = properties.pipeline_cache_uuid.into_iter().chain(ids.driver_uuid).chain(ids.device_uuid);
    hexadecimal(&numbers.chain(uuids).collect::<Vec<u8>>())
}

fn text(characters: &[c_char]) -> String {
    let bytes: Vec<u8> = characters.iter().take_while(|it| **it != 0).map(|it| *it as u8).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(index: usize, name: &str, kind: DeviceKind, missing: &[&'static str]) -> DeviceInfo {
        DeviceInfo {
            index,
            name: name.into(),
            kind,
            driver: String::new(),
            identity: String::new(),
            vulkan: [1, 3, 0],
            memory: 0,
            max_image: 0,
            max_allocation: 0,
            max_buffer: 0,
            ray_query: false,
            missing: missing.to_vec(),
        }
    }

    #[test]
    fn numbers_are_indices_and_words_are_parts_of_names() {
        let all = [
            info(0, "llvmpipe (LLVM 15.0.6, 256 bits)", DeviceKind::Cpu, &[]),
            info(1, "Radeon 15", DeviceKind::Discrete, &["Vulkan 1.3"]),
            info(2, "GeForce", DeviceKind::Integrated, &[]),
        ];
        let all: Vec<&DeviceInfo> = all.iter().collect();
        let chosen = |wanted| choose_index(&all, wanted).ok();
        for (wanted, index) in [
            (None, Some(2)),
            (Some("0"), Some(0)),
            (Some("2"), Some(2)),
            (Some("FORCE"), Some(2)),
            (Some("LLVM 15"), Some(0)),
            // A digit in a name is no index, and an index out of the list no device.
            (Some("15"), None),
            (Some("3"), None),
            (Some(""), None),
            // It is there, and cannot do it.
            (Some("1"), None),
            (Some("radeon"), None),
        ] {
            assert_eq!(chosen(wanted), index, "{wanted:?}");
        }
        assert!(matches!(choose_index(&[], None), Err(Error::Loader { .. })));
    }
}
