//! Acceleration structures: what a device that traces rays by itself (`VK_KHR_ray_query`) does so through.

use super::{
    buffer::{self, Buffer},
    device::{Acceleration, Gpu},
    error::{Error, Result, vk_error},
    memory::Location,
    pipeline::{Bindable, Descriptor, Sealed, Share},
    recorder::Recorder,
};
use ash::vk;
use std::sync::Arc;

/// Triangles, or instances of structures over triangles.
#[derive(Clone)]
pub struct AccelerationStructure(Arc<Raw>);

/// One of the structures over triangles, where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Index into the structures over triangles.
    pub structure: usize,
    /// To the world, by rows: three of the rotation and scale and one of the translation in each.
    pub transform: [[f32; 4]; 3],
}

struct Raw {
    structure: vk::AccelerationStructureKHR,
    storage: Arc<buffer::Raw>,
    /// What an instance points to.
    _behind: Vec<Arc<Raw>>,
    gpu: Gpu,
}

/// As Vulkan lays an instance out (`VkAccelerationStructureInstanceKHR`): the transform, index and mask, flags, the address.
const INSTANCE: usize = 16;

impl AccelerationStructure {
    /// Over triangles, at least one, each of three corners.
    ///
    /// # Errors
    /// A device that does not trace rays by itself, more triangles than it takes, or no memory.
    pub fn over_triangles(gpu: &Gpu, triangles: &[[[f32; 3]; 3]]) -> Result<AccelerationStructure> {
        let (count, most) = (triangles.len() as u64, acceleration(gpu)?.limits.most_triangles);
        if count > most {
            return Err(Error::Unsupported(format!(
                "a ray tracing structure over {count} triangles; {most} can be here"
            )));
        }
        let buffer = Buffer::new(gpu, "triangles to build from", triangles.len())?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&buffer, triangles);
        rec.submit()?.wait()?;
        let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: buffer.raw().address() })
            .vertex_stride(size_of::<[f32; 3]>() as u64)
            .max_vertex(3 * count as u32 - 1)
            .index_type(vk::IndexType::NONE_KHR);
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data })
            .flags(vk::GeometryFlagsKHR::OPAQUE);
        let part = vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count as u32);
        let kind = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
        let raw = Raw::build(gpu, kind, geometry, part, buffer.raw().clone(), Vec::new())?;
        Ok(AccelerationStructure(Arc::new(raw.compacted()?)))
    }

    /// One over instances, at least one; shaders know them by their place in this list.
    ///
    /// # Errors
    /// A device that does not trace rays by itself, more instances than it takes, or no memory.
    pub fn over_instances(
        gpu: &Gpu,
        structures: &[AccelerationStructure],
        stances: &[Stance],
    ) -> Result<AccelerationStructure> {
        let Acceleration { functions, limits } = acceleration(gpu)?;
        if stances.len() as u64 > limits.most_instances {
            return Err(Error::Unsupported(format!(
                "a ray tracing structure over {} instances; {} can be here",
                stances.len(),
                limits.most_instances
            )));
        }
        let address = |structure: &AccelerationStructure| {
            let info = vk::AccelerationStructureDeviceAddressInfoKHR::default()
                .acceleration_structure(structure.0.structure);
            // SAFETY: the structure is alive, and of this device.
            unsafe { functions.get_acceleration_structure_device_address(&info) }
        };
        let addresses: Vec<u64> = structures.iter().map(address).collect();
        let instance = |stance: &Stance| {
            let address = addresses.get(stance.structure).copied();
            let address = address.ok_or_else(|| Error::Unsupported("an instance of nothing".into()))?;
            Ok(packed(stance, address))
        };
        let instances = stances.iter().map(instance).collect::<Result<Vec<[u32; INSTANCE]>>>()?;
        let buffer = Buffer::new(gpu, "instances to trace", instances.len())?;
        let mut rec = Recorder::new(gpu);
        rec.upload(&buffer, &instances);
        rec.submit()?.wait()?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default()
            .data(vk::DeviceOrHostAddressConstKHR { device_address: buffer.raw().address() });
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data })
            .flags(vk::GeometryFlagsKHR::OPAQUE);
        let part =
            vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(instances.len() as u32);
        let kind = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
        let behind = structures.iter().map(|structure| structure.0.clone()).collect();
        let raw = Raw::build(gpu, kind, geometry, part, buffer.raw().clone(), behind)?;
        Ok(AccelerationStructure(Arc::new(raw)))
    }
}

fn acceleration(gpu: &Gpu) -> Result<&Acceleration> {
    let missing = || Error::Unsupported("rays that the device traces itself (VK_KHR_ray_query)".into());
    gpu.shared().acceleration.as_ref().ok_or_else(missing)
}

/// Seen by every ray, from both sides.
fn packed(stance: &Stance, address: u64) -> [u32; INSTANCE] {
    const MASK: u32 = 0xff << 24;
    let flags = vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE.as_raw() << 24;
    let mut words = [0; INSTANCE];
    for (word, value) in words.iter_mut().zip(stance.transform.as_flattened()) {
        *word = value.to_bits();
    }
    (words[12], words[13]) = (MASK, flags);
    (words[14], words[15]) = (address as u32, (address >> 32) as u32);
    words
}

impl Raw {
    /// Builds a structure from a buffer that `geometry` gives the address of.
    fn build(
        gpu: &Gpu,
        kind: vk::AccelerationStructureTypeKHR,
        geometry: vk::AccelerationStructureGeometryKHR,
        part: vk::AccelerationStructureBuildRangeInfoKHR,
        input: Arc<buffer::Raw>,
        behind: Vec<Arc<Raw>>,
    ) -> Result<Raw> {
        let Acceleration { functions, limits } = acceleration(gpu)?;
        let geometries = [geometry];
        let mut flags = vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE;
        if kind == vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL {
            flags |= vk::BuildAccelerationStructureFlagsKHR::ALLOW_COMPACTION;
        }
        let info = vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(kind)
            .flags(flags)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(&geometries);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: the geometry is of this kind; for sizes alone its addresses are not followed.
        unsafe {
            functions.get_acceleration_structure_build_sizes(
                vk::AccelerationStructureBuildTypeKHR::DEVICE,
                &info,
                &[part.primitive_count],
                &mut sizes,
            );
        }
        let raw = Raw::new(gpu, kind, sizes.acceleration_structure_size, behind)?;
        let alignment = limits.scratch_alignment;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let bytes = sizes.build_scratch_size.max(1) + alignment;
        let scratch = Arc::new(buffer::Raw::new(gpu, "scratch", bytes, usage, Location::Device)?);
        let device_address = scratch.address().next_multiple_of(alignment);
        let info = info
            .dst_acceleration_structure(raw.structure)
            .scratch_data(vk::DeviceOrHostAddressKHR { device_address });
        let mut rec = Recorder::new(gpu);
        rec.pass("acceleration", |rec| {
            // SAFETY: structure and scratch have the sizes that the device asked for, the scratch its alignment too; the input
            // holds what the geometry says, and all of it lives until the submission below has been waited for.
            unsafe { functions.cmd_build_acceleration_structures(rec.command, &[info], &[&[part]]) };
            Ok(())
        });
        rec.hold(scratch);
        rec.hold(input);
        rec.hold(raw.storage.clone());
        rec.submit()?.wait()?;
        Ok(raw)
    }

    fn new(
        gpu: &Gpu,
        kind: vk::AccelerationStructureTypeKHR,
        bytes: u64,
        behind: Vec<Arc<Raw>>,
    ) -> Result<Raw> {
        let functions = &acceleration(gpu)?.functions;
        let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR
            | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        let storage = Arc::new(buffer::Raw::new(gpu, "acceleration", bytes, usage, Location::Device)?);
        let info =
            vk::AccelerationStructureCreateInfoKHR::default().buffer(storage.buffer).size(bytes).ty(kind);
        // SAFETY: the buffer has the usage and the size, and starts at an aligned offset: 0.
        let structure = unsafe { functions.create_acceleration_structure(&info, None) }
            .map_err(vk_error("vkCreateAccelerationStructureKHR"))?;
        gpu.name(structure, "acceleration");
        Ok(Raw { structure, storage, _behind: behind, gpu: gpu.clone() })
    }

    /// The same structure in as little memory as it needs; it was built with the flag for that.
    fn compacted(self) -> Result<Raw> {
        let gpu = self.gpu.clone();
        let functions = &acceleration(&gpu)?.functions;
        let queries = Query::new(&gpu)?;
        let mut rec = Recorder::new(&gpu);
        rec.pass("compacted size", |rec| {
            // SAFETY: pool and structure are alive until the submission has been waited for; the structure has been built.
            unsafe {
                rec.device().cmd_reset_query_pool(rec.command, queries.0, 0, 1);
                functions.cmd_write_acceleration_structures_properties(
                    rec.command,
                    &[self.structure],
                    vk::QueryType::ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                    queries.0,
                    0,
                );
            }
            Ok(())
        });
        rec.submit()?.wait()?;
        let bytes = queries.result()?;
        if bytes == 0 || bytes >= self.storage.bytes {
            return Ok(self);
        }
        let small = Raw::new(&gpu, vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, bytes, Vec::new())?;
        let info = vk::CopyAccelerationStructureInfoKHR::default()
            .src(self.structure)
            .dst(small.structure)
            .mode(vk::CopyAccelerationStructureModeKHR::COMPACT);
        let mut rec = Recorder::new(&gpu);
        rec.pass("compaction", |rec| {
            // SAFETY: both live until the submission has been waited for; the new one has the size that the device said.
            unsafe { functions.cmd_copy_acceleration_structure(rec.command, &info) };
            Ok(())
        });
        rec.submit()?.wait()?;
        Ok(small)
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        if let Some(Acceleration { functions, .. }) = &self.gpu.shared().acceleration {
            // SAFETY: submissions that name the structure hold it until they have finished, and so does what points to it.
            unsafe { functions.destroy_acceleration_structure(self.structure, None) };
        }
    }
}

/// A question about one structure.
struct Query(vk::QueryPool, Gpu);

impl Query {
    fn new(gpu: &Gpu) -> Result<Query> {
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR)
            .query_count(1);
        // SAFETY: the device is alive, and has the extension of this kind of query.
        let pool = unsafe { gpu.shared().device.create_query_pool(&info, None) };
        Ok(Query(pool.map_err(vk_error("vkCreateQueryPool"))?, gpu.clone()))
    }

    fn result(&self) -> Result<u64> {
        let mut bytes = [0_u64];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the query has been written by a submission that has finished.
        unsafe { self.1.shared().device.get_query_pool_results(self.0, 0, &mut bytes, flags) }
            .map_err(vk_error("vkGetQueryPoolResults"))?;
        Ok(bytes[0])
    }
}

impl Drop for Query {
    fn drop(&mut self) {
        // SAFETY: submissions that use the pool have been waited for.
        unsafe { self.1.shared().device.destroy_query_pool(self.0, None) };
    }
}

impl Sealed for AccelerationStructure {}

impl Bindable for AccelerationStructure {
    fn descriptor(&self) -> Descriptor {
        Descriptor::AccelerationStructure(self.0.structure)
    }

    fn bytes(&self) -> u64 {
        self.0.storage.bytes
    }

    fn share(&self) -> Share {
        self.0.clone()
    }
}
