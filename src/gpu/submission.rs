//! Work that the device is doing, and what it left when it has finished.

use super::{
    buffer,
    device::Gpu,
    error::{Error, Result, vk_error},
    objects::Objects,
    pipeline::Share,
};
use ash::vk;
use bytemuck::Pod;
use std::{collections::HashMap, marker::PhantomData, sync::Arc, time::Duration};

/// Passes on their way through the device. Dropping it waits for them.
pub struct Submission {
    objects: Objects,
    fence: vk::Fence,
    stamps: Vec<Stamp>,
    last_pass: &'static str,
    // Everything the passes name, alive until they have finished.
    _held: HashMap<usize, Share>,
}

/// A submission that the device has finished.
#[derive(Debug)]
pub struct Finished {
    id: u64,
    /// Time on the device by pass, in the order of recording; empty unless the recorder was timed.
    pub timings: Vec<Timing>,
}

/// Time on the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Timing {
    /// The pass: `room/stem` of its shader.
    pub name: &'static str,
    pub duration: Duration,
}

/// Bytes on their way back from the device.
pub struct Download<T: Pod> {
    /// Of the recorder, and so of the submission, that copies them.
    id: u64,
    /// `None` if the recording has failed: then there is no submission to wait for either.
    staging: Option<Arc<buffer::Raw>>,
    element: PhantomData<T>,
}

/// Two timestamps round a pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamp {
    pub name: &'static str,
    /// Query before the pass; the one behind it follows.
    pub first: u32,
}

/// What a submission waits for before it begins and tells when it has ended, beside its fence.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Signals {
    pub wait: Option<vk::Semaphore>,
    pub signal: Option<vk::Semaphore>,
}

impl Submission {
    pub(super) fn new(
        objects: Objects,
        command: vk::CommandBuffer,
        held: HashMap<usize, Share>,
        stamps: Vec<Stamp>,
        last_pass: &'static str,
        signals: Signals,
    ) -> Result<Submission> {
        let gpu = objects.gpu.clone();
        let device = &gpu.shared().device;
        // SAFETY: the device is alive.
        let fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }
            .map_err(vk_error("vkCreateFence"))?;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(command)];
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let info = |semaphore| vk::SemaphoreSubmitInfo::default().semaphore(semaphore).stage_mask(all);
        let waits: Vec<_> = signals.wait.map(info).into_iter().collect();
        let signals: Vec<_> = signals.signal.map(info).into_iter().collect();
        let submit = [vk::SubmitInfo2::default()
            .wait_semaphore_infos(&waits)
            .command_buffer_infos(&commands)
            .signal_semaphore_infos(&signals)];
        // SAFETY: the command buffer has ended; the queue is locked; what the commands name is in `held`; who gives semaphores
        // keeps them until the fence.
        let result = unsafe { device.queue_submit2(*gpu.queue(), &submit, fence) };
        if let Err(result) = result {
            // SAFETY: the submission failed, so nothing signals the fence.
            unsafe { device.destroy_fence(fence, None) };
            return Err(lost_or(result, last_pass, "vkQueueSubmit2"));
        }
        Ok(Submission { objects, fence, stamps, last_pass, _held: held })
    }

    /// Waits until the device has finished.
    pub fn wait(self) -> Result<Finished> {
        self.wait_for_fence()?;
        Ok(Finished { id: self.objects.id, timings: self.timings()? })
    }

    /// Whether the device has finished.
    ///
    /// # Errors
    /// A lost device.
    pub fn is_finished(&self) -> Result<bool> {
        // SAFETY: the fence was submitted with the commands.
        unsafe { self.gpu().shared().device.get_fence_status(self.fence) }
            .map_err(|result| lost_or(result, self.last_pass, "vkGetFenceStatus"))
    }

    fn gpu(&self) -> &Gpu {
        &self.objects.gpu
    }

    fn wait_for_fence(&self) -> Result<()> {
        // SAFETY: the fence was submitted with the commands.
        unsafe { self.gpu().shared().device.wait_for_fences(&[self.fence], true, u64::MAX) }
            .map_err(|result| lost_or(result, self.last_pass, "vkWaitForFences"))
    }

    fn timings(&self) -> Result<Vec<Timing>> {
        let Some(queries) = self.objects.queries().filter(|_| !self.stamps.is_empty()) else {
            return Ok(Vec::new());
        };
        let mut ticks = vec![0_u64; 2 * self.stamps.len()];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: as many queries were written as the slice has elements.
        unsafe { self.gpu().shared().device.get_query_pool_results(queries, 0, &mut ticks, flags) }
            .map_err(vk_error("vkGetQueryPoolResults"))?;
        let period = f64::from(self.gpu().shared().limits.timestamp_period);
        let timing = |stamp: &Stamp| {
            let first = stamp.first as usize;
            let nanoseconds = ticks[first + 1].saturating_sub(ticks[first]) as f64 * period;
            Timing { name: stamp.name, duration: Duration::from_nanos(nanoseconds as u64) }
        };
        Ok(self.stamps.iter().map(timing).collect())
    }
}

impl Drop for Submission {
    fn drop(&mut self) {
        let device = &self.gpu().shared().device;
        if self.wait_for_fence().is_err() {
            // Either the device is lost, or there was no memory to wait with: this needs none.
            // SAFETY: the queue is locked, so that no other thread uses it meanwhile.
            let _ = unsafe { device.queue_wait_idle(*self.gpu().queue()) };
        }
        // SAFETY: the fence has been waited for, or its device is lost.
        unsafe { device.destroy_fence(self.fence, None) };
    }
}

impl<T: Pod> Download<T> {
    pub(super) fn new(id: u64, staging: Option<Arc<buffer::Raw>>) -> Self {
        Download { id, staging, element: PhantomData }
    }

    /// The elements, row by row and layer by layer.
    ///
    /// # Panics
    /// If `finished` is not the submission of the recorder that made this download.
    pub fn take(self, finished: &Finished) -> Vec<T> {
        assert_eq!(self.id, finished.id, "a download is taken from the submission that copied it");
        let bytes = self.staging.as_ref().and_then(|raw| raw.mapped()).unwrap_or_default();
        bytemuck::pod_collect_to_vec(bytes)
    }
}

fn lost_or(result: vk::Result, last_pass: &'static str, op: &'static str) -> Error {
    match result {
        vk::Result::ERROR_DEVICE_LOST => Error::Lost { after: last_pass.into() },
        result => vk_error(op)(result),
    }
}
