//! The pools that commands are recorded from.

use super::{
    device::{Gpu, lock},
    error::{Result, vk_error},
};
use ash::vk;

/// Vulkan objects that live as long as the commands recorded with them.
pub(super) struct Objects {
    pub gpu: Gpu,
    /// Different for each recorder.
    pub id: u64,
    /// Number of timestamps that fit.
    pub capacity: u32,
    pools: Pools,
}

/// What goes from one recorder to the next, emptied in between.
///
/// That saves drivers the making. And no command buffer is destroyed before the device, which is what the validation layer needs where
/// threads share one: as late as 1.3.239 it forgets the labels of a buffer that is destroyed without the lock that it takes for all else.
#[derive(Default)]
pub(super) struct Pools {
    commands: vk::CommandPool,
    command: vk::CommandBuffer,
    descriptors: Vec<vk::DescriptorPool>,
    /// How many of those sets have been allocated from; the last of them is not full yet.
    used: usize,
    queries: vk::QueryPool,
    /// Number of queries.
    capacity: u32,
}

impl Objects {
    /// For a recorder that takes `capacity` timestamps.
    pub fn new(gpu: &Gpu, id: u64, capacity: u32) -> Objects {
        let pools = lock(&gpu.shared().pools).pop().unwrap_or_default();
        Objects { gpu: gpu.clone(), id, capacity, pools }
    }

    /// Starts a command buffer.
    pub fn begin(&mut self) -> Result<vk::CommandBuffer> {
        let gpu = self.gpu.clone();
        let device = &gpu.shared().device;
        let pools = &mut self.pools;
        if pools.commands == vk::CommandPool::null() {
            let info = vk::CommandPoolCreateInfo::default()
                .flags(vk::CommandPoolCreateFlags::TRANSIENT)
                .queue_family_index(gpu.shared().queue_family);
            // SAFETY: the device is alive.
            pools.commands = unsafe { device.create_command_pool(&info, None) }
                .map_err(vk_error("vkCreateCommandPool"))?;
        }
        if pools.command == vk::CommandBuffer::null() {
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pools.commands)
                .level(vk::CommandBufferLevel::PRIMARY)
                .command_buffer_count(1);
            // SAFETY: the pool is this recorder's alone.
            pools.command = unsafe { device.allocate_command_buffers(&info) }
                .map_err(vk_error("vkAllocateCommandBuffers"))?
                .into_iter()
                .next()
                .unwrap_or_default();
        }
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer is new, or its pool was reset.
        unsafe { device.begin_command_buffer(pools.command, &info) }
            .map_err(vk_error("vkBeginCommandBuffer"))?;
        if self.capacity > 0 {
            pools.make_queries(device, self.capacity)?;
            // SAFETY: the command buffer is recording.
            unsafe { device.cmd_reset_query_pool(pools.command, pools.queries, 0, self.capacity) };
        }
        Ok(pools.command)
    }

    /// Where the timestamps go; none for a recorder that takes none.
    pub fn queries(&self) -> Option<vk::QueryPool> {
        (self.capacity > 0).then_some(self.pools.queries)
    }

    pub fn allocate_set(&mut self, layout: vk::DescriptorSetLayout) -> Result<vk::DescriptorSet> {
        let gpu = self.gpu.clone();
        let device = &gpu.shared().device;
        let pools = &mut self.pools;
        let layouts = [layout];
        let allocate = |pool: vk::DescriptorPool| {
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            // SAFETY: pool and layout are alive.
            unsafe { device.allocate_descriptor_sets(&info) }
                .map(|sets| sets.into_iter().next().unwrap_or_default())
        };
        if let Some(last) = pools.used.checked_sub(1) {
            match allocate(pools.descriptors[last]) {
                Err(vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL) => {}
                result => return result.map_err(vk_error("vkAllocateDescriptorSets")),
            }
        }
        // None yet, or a full one.
        if pools.used == pools.descriptors.len() {
            pools.descriptors.push(make_descriptors(&gpu)?);
        }
        pools.used += 1;
        allocate(pools.descriptors[pools.used - 1]).map_err(vk_error("vkAllocateDescriptorSets"))
    }
}

impl Drop for Objects {
    fn drop(&mut self) {
        let shared = self.gpu.shared();
        let mut pools = std::mem::take(&mut self.pools);
        // SAFETY: a submission waits for its fence before it drops these, and a recorder was never submitted: nothing in the pools
        // is in use.
        if unsafe { pools.empty(&shared.device) }.is_ok() {
            lock(&shared.pools).push(pools);
        } else {
            // SAFETY: as above.
            unsafe { pools.destroy(&shared.device) };
        }
    }
}

impl Pools {
    /// A pool of at least `capacity` timestamps.
    fn make_queries(&mut self, device: &ash::Device, capacity: u32) -> Result<()> {
        if self.capacity >= capacity {
            return Ok(());
        }
        let info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(capacity);
        // SAFETY: the device is alive.
        let queries =
            unsafe { device.create_query_pool(&info, None) }.map_err(vk_error("vkCreateQueryPool"))?;
        // SAFETY: nothing has been recorded with the smaller pool since it was taken.
        unsafe { device.destroy_query_pool(self.queries, None) };
        (self.queries, self.capacity) = (queries, capacity);
        Ok(())
    }

    /// Makes it as good as new.
    ///
    /// # Safety
    /// Nothing of it is in use.
    unsafe fn empty(&mut self, device: &ash::Device) -> std::result::Result<(), vk::Result> {
        if self.commands != vk::CommandPool::null() {
            // SAFETY: the caller's promise.
            unsafe { device.reset_command_pool(self.commands, vk::CommandPoolResetFlags::empty())? };
        }
        for pool in &self.descriptors[..self.used] {
            // SAFETY: the caller's promise.
            unsafe { device.reset_descriptor_pool(*pool, vk::DescriptorPoolResetFlags::empty())? };
        }
        self.used = 0;
        Ok(())
    }

    /// # Safety
    /// Nothing of it is in use, and it is not used again.
    pub unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller's promise; destroying what was never made does nothing.
        unsafe {
            device.destroy_command_pool(self.commands, None);
            for pool in &self.descriptors {
                device.destroy_descriptor_pool(*pool, None);
            }
            device.destroy_query_pool(self.queries, None);
        }
    }
}

/// Room for the descriptor sets of some hundred passes.
fn make_descriptors(gpu: &Gpu) -> Result<vk::DescriptorPool> {
    let mut sizes = vec![
        vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_IMAGE, descriptor_count: 1024 },
        vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_BUFFER, descriptor_count: 128 },
        vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: 256 },
        vk::DescriptorPoolSize { ty: vk::DescriptorType::UNIFORM_TEXEL_BUFFER, descriptor_count: 256 },
    ];
    if gpu.shared().acceleration.is_some() {
        let ty = vk::DescriptorType::ACCELERATION_STRUCTURE_KHR;
        sizes.push(vk::DescriptorPoolSize { ty, descriptor_count: 128 });
    }
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(128).pool_sizes(&sizes);
    // SAFETY: the device is alive.
    unsafe { gpu.shared().device.create_descriptor_pool(&info, None) }
        .map_err(vk_error("vkCreateDescriptorPool"))
}
