//! The order of a submit relative to other submits: the semaphores that it waits for and signals.

use ash::vk;

use crate::core::error::{Called, Error};
use crate::core::tick::Tick;
use crate::core::timeline::TimelineWait;

/// The semaphores of a submit in addition to its tick: to wait for, and to signal. Binary
/// semaphores belong to a window.
#[derive(Default)]
pub(crate) struct Order<'a> {
    pub(crate) after: Option<TimelineWait<'a>>,
    pub(crate) acquired: Option<vk::Semaphore>,
    pub(crate) presents: Option<vk::Semaphore>,
}

impl Order<'_> {
    /// Submits a command buffer, or only the order, and signals `tick` on `timeline`.
    ///
    /// # Safety
    /// No other thread uses the queue. The commands are complete, and all handles are of one
    /// device.
    pub(crate) unsafe fn submit(
        &self,
        device: &ash::Device,
        queue: vk::Queue,
        commands: Option<vk::CommandBuffer>,
        timeline: vk::Semaphore,
        tick: Tick,
    ) -> Result<(), Error> {
        let commands =
            commands.map(|raw| vk::CommandBufferSubmitInfo::default().command_buffer(raw));
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let semaphore = |raw, value, stages| {
            vk::SemaphoreSubmitInfo::default().semaphore(raw).value(value).stage_mask(stages)
        };
        let after = self.after.map(|after| semaphore(after.timeline.raw, after.tick.0, all));
        // Only copies touch the image of a window, so the work before them need not wait.
        let copies = vk::PipelineStageFlags2::ALL_TRANSFER;
        let acquired = self.acquired.map(|raw| semaphore(raw, 0, copies));
        let (waits, waiting) = both(after, acquired);
        let presents = self.presents.map(|raw| semaphore(raw, 0, all));
        let own = semaphore(timeline, tick.0, all);
        let (signals, signalling) = both(Some(own), presents);
        let info = vk::SubmitInfo2::default()
            .command_buffer_infos(commands.as_slice())
            .wait_semaphore_infos(&waits[..waiting])
            .signal_semaphore_infos(&signals[..signalling]);
        // SAFETY: the caller's promise.
        unsafe { device.queue_submit2(queue, &[info], vk::Fence::null()) }.called("vkQueueSubmit2")
    }
}

/// Returns the values that are present, at the front of the array, and their number.
fn both<T: Copy + Default>(first: Option<T>, second: Option<T>) -> ([T; 2], usize) {
    match (first, second) {
        (Some(first), Some(second)) => ([first, second], 2),
        (first, second) => {
            let only = first.or(second);
            ([only.unwrap_or_default(), T::default()], usize::from(only.is_some()))
        }
    }
}
