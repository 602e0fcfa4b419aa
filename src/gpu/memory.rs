//! Device memory: a budget, and a ledger of what is allocated under which name.

use super::error::{Error, Result};
use ash::vk;
use gpu_allocator::{
    AllocationSizes, MemoryLocation,
    vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc},
};
use std::collections::BTreeMap;

/// Device memory in use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Bytes by the name of the image or buffer; the same name is summed.
    pub by_name: BTreeMap<String, u64>,
    /// Bytes in all.
    pub used: u64,
    /// Most bytes there have been at once.
    pub peak: u64,
    /// Most bytes there may be.
    pub limit: u64,
}

pub(super) struct Memory {
    allocator: Allocator,
    usage: Usage,
}

/// Where memory lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Location {
    Device,
    Upload,
    Download,
}

impl Memory {
    pub fn new(
        instance: &ash::Instance,
        device: &ash::Device,
        physical_device: vk::PhysicalDevice,
        limit: u64,
    ) -> Result<Memory> {
        const MIB: u64 = 1 << 20;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: true,
            allocation_sizes: AllocationSizes::new(16 * MIB, 16 * MIB)
                .with_max_device_memblock_size(128 * MIB)
                .with_max_host_memblock_size(64 * MIB),
        })
        .map_err(|error| Error::Unsupported(format!("memory allocation: {error}")))?;
        Ok(Memory { allocator, usage: Usage { limit, ..Usage::default() } })
    }

    pub fn usage(&self) -> Usage {
        self.usage.clone()
    }

    /// Memory for an image (`OPTIMAL`) or a buffer (`LINEAR`).
    pub fn allocate(
        &mut self,
        name: &str,
        requirements: vk::MemoryRequirements,
        location: Location,
        tiling: vk::ImageTiling,
    ) -> Result<Allocation> {
        let bytes = requirements.size;
        let Usage { used, limit, .. } = self.usage;
        if used.saturating_add(bytes) > limit {
            return Err(Error::MemoryLimit { name: name.into(), bytes, used, limit });
        }
        let allocation = self
            .allocator
            .allocate(&AllocationCreateDesc {
                name,
                requirements,
                location: match location {
                    Location::Device => MemoryLocation::GpuOnly,
                    Location::Upload => MemoryLocation::CpuToGpu,
                    Location::Download => MemoryLocation::GpuToCpu,
                },
                linear: tiling == vk::ImageTiling::LINEAR,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|_| Error::OutOfMemory { name: name.into(), bytes })?;
        self.usage.used += bytes;
        self.usage.peak = self.usage.peak.max(self.usage.used);
        *self.usage.by_name.entry(name.into()).or_default() += bytes;
        Ok(allocation)
    }

    /// Gives back what [`Memory::allocate`] returned for `name` and `bytes`.
    pub fn free(&mut self, name: &str, bytes: u64, allocation: Allocation) {
        // The allocator fails only for memory that is not its own.
        let _ = self.allocator.free(allocation);
        self.usage.used = self.usage.used.saturating_sub(bytes);
        if let Some(entry) = self.usage.by_name.get_mut(name) {
            *entry = entry.saturating_sub(bytes);
            if *entry == 0 {
                self.usage.by_name.remove(name);
            }
        }
    }
}
