//! The command buffers of a host: one per frame in flight, each with a fence.

use ash::vk;
use gpu::{Frame, FrameNumbers, FrameRing, Tick};

use crate::host_device::Host;

/// The bound of every wait in nanoseconds.
const BOUND_NS: u64 = 60_000_000_000;

/// Command buffers and fences. Destroyed by [`HostCommands::destroy`].
pub struct HostCommands<'a> {
    host: &'a Host,
    pool: vk::CommandPool,
    slots: Vec<(vk::CommandBuffer, vk::Fence)>,
    /// The number of the frame that begins next.
    next: u64,
}

impl<'a> HostCommands<'a> {
    /// Creates one command buffer and fence per frame in flight. The first frame has the number 1.
    pub fn new(host: &'a Host, frames_in_flight: usize) -> Self {
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(host.needs.queue_family.unwrap())
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: plain objects of the host.
        unsafe {
            let pool = host.device.create_command_pool(&info, None).unwrap();
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .command_buffer_count(frames_in_flight as u32);
            let buffers = host.device.allocate_command_buffers(&info).unwrap();
            let fence = |commands| (commands, host.device.create_fence(&signaled, None).unwrap());
            Self { host, pool, slots: buffers.into_iter().map(fence).collect(), next: 1 }
        }
    }

    /// Waits for the frame that used the next command buffer before, and begins it. Returns it with
    /// the numbers of its frame.
    pub fn begin(&mut self) -> (vk::CommandBuffer, FrameNumbers) {
        let (commands, fence) = self.slot();
        let device = &self.host.device;
        // SAFETY: the fence was created signaled, or submitted; its command buffer is over then.
        unsafe {
            device.wait_for_fences(&[fence], true, BOUND_NS).unwrap();
            device.begin_command_buffer(commands, &Default::default()).unwrap();
        }
        let safe = self.next.saturating_sub(self.slots.len() as u64);
        (commands, FrameNumbers { current: Tick(self.next), safe: Tick(safe) })
    }

    /// Ends the command buffer, and submits it if it `runs`.
    ///
    /// # Errors
    /// The code of a submit that failed.
    pub fn end(&mut self, runs: Runs) -> Result<(), vk::Result> {
        let (commands, fence) = self.slot();
        self.next += 1;
        let device = &self.host.device;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let buffers = if runs == Runs::Once { &buffers[..] } else { &[] };
        let info = [vk::SubmitInfo2::default().command_buffer_infos(buffers)];
        // SAFETY: a complete command buffer, the host's own queue, and a fence that is waited for.
        unsafe {
            device.end_command_buffer(commands).unwrap();
            device.reset_fences(&[fence]).unwrap();
            device.queue_submit2(self.host.queue, &info, fence)
        }
    }

    /// Destroys the command buffers and fences. The GPU must be idle.
    pub fn destroy(self) {
        // SAFETY: nothing is in use.
        unsafe {
            self.slots.iter().for_each(|(_, fence)| self.host.device.destroy_fence(*fence, None));
            self.host.device.destroy_command_pool(self.pool, None);
        }
    }

    fn slot(&self) -> (vk::CommandBuffer, vk::Fence) {
        self.slots[self.next as usize % self.slots.len()]
    }
}

/// Records a frame of a ring into a command buffer that was [begun](HostCommands::begin). Returns
/// the number of the frame, and the other result of `record`.
pub fn record_frame<R>(
    ring: &mut FrameRing,
    commands: vk::CommandBuffer,
    numbers: FrameNumbers,
    record: impl for<'ring> FnOnce(Frame<'ring>) -> (Frame<'ring>, R),
) -> (Tick, R) {
    // SAFETY: the command buffer is being recorded; the frames up to the safe one were waited for.
    let frame = unsafe { ring.begin_in(commands, numbers) }.unwrap();
    let (frame, recorded) = record(frame);
    (frame.end().unwrap(), recorded)
}

/// The submits of a command buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// The command buffer is submitted once.
    Once,
    /// The command buffer is not submitted: the frame is given up.
    Never,
}
