//! The pools that commands are recorded from.

use super::{
    device::Gpu,
    error::{Result, vk_error},
};
use ash::vk;

/// Vulkan objects that live as long as the commands recorded with them.
pub(super) struct Objects {
    pub gpu: Gpu,
    /// Different for each recorder.
    pub id: u64,
    pub commands: vk::CommandPool,
    pub descriptors: Vec<vk::DescriptorPool>,
    pub queries: Option<vk::QueryPool>,
    /// Number of timestamps that fit.
    pub capacity: u32,
}

impl Objects {
    /// Makes the pools and starts a command buffer.
    pub fn begin(&mut self) -> Result<vk::CommandBuffer> {
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

    pub fn allocate_set(&mut self, layout: vk::DescriptorSetLayout) -> Result<vk::DescriptorSet> {
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
