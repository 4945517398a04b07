//! A slot of the frame ring: the command buffers and the memory that one frame in flight holds.

use std::sync::Arc;

use ash::vk;

use crate::core::deletion::{RecordingId, Retired};
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::core::order::Order;
use crate::core::tick::Tick;
use crate::memory::upload::Uploads;
use crate::record::commands::Commands;
use crate::record::descriptor_pools::DescriptorPools;
use crate::record::pools::{allocate_commands, begin_commands, create_command_pool, end_commands};
use crate::record::resubmission::Resubmission;
use crate::record::timing::{FrameTimer, PassTime, PassTimer};

/// The timing of the passes of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SlotTiming {
    Timed,
    Untimed,
}

/// The resources of one frame in flight.
pub(super) struct Slot {
    pub(super) device: Device,
    pub(super) name: String,
    /// The command buffers; `None` if a host provides its own.
    pub(super) own: Option<OwnCommands>,
    pub(super) commands: Commands,
    pub(super) uploads: Uploads,
    pub(super) timer: Option<Arc<PassTimer>>,
    pub(super) pass_times: Vec<PassTime>,
    /// True if the timer has the times of a whole frame; an abandoned frame has none.
    pub(super) is_timed: bool,
    pub(super) timing: SlotTiming,
    pub(super) whole: FrameTimer,
    pub(super) tick: Tick,
}

/// The command buffers of a slot, one per piece of the frame; most frames have one piece.
pub(super) struct OwnCommands {
    pool: vk::CommandPool,
    pieces: Vec<vk::CommandBuffer>,
    piece: usize,
}

impl OwnCommands {
    fn new(device: &Device, name: &str) -> Result<Self, Error> {
        let pool = create_command_pool(device, name)?;
        match allocate_commands(device, pool, name) {
            Ok(buffer) => Ok(Self { pool, pieces: vec![buffer], piece: 0 }),
            Err(error) => {
                device.retire(Retired::CommandPool(pool));
                Err(error)
            }
        }
    }
}

/// The error of a submit or a wait for a frame in the command buffer of a host.
pub(super) const NO_QUEUE: Error = Error::NoQueue { what: "the submit of a frame" };

impl Slot {
    pub(super) fn new(device: &Device, index: usize) -> Result<Self, Error> {
        let name = format!("frame {index}");
        let own = if device.has_queue() { Some(OwnCommands::new(device, &name)?) } else { None };
        let descriptors = DescriptorPools::new(device, &name).inspect_err(|_| {
            own.iter().for_each(|own| device.retire(Retired::CommandPool(own.pool)));
        })?;
        let buffer = vk::CommandBuffer::null();
        Ok(Self {
            device: device.clone(),
            own,
            commands: Commands::new(device, buffer, RecordingId::default(), descriptors),
            uploads: Uploads::new(device, &name),
            name,
            timer: None,
            pass_times: Vec::new(),
            is_timed: false,
            timing: SlotTiming::Timed,
            whole: FrameTimer::default(),
            tick: Tick::ZERO,
        })
    }

    /// Restarts the slot for a recording, in the command buffer of a host if one is given. The
    /// slot's tick must be over.
    pub(super) fn restart(
        &mut self,
        recording: RecordingId,
        timing: SlotTiming,
        resubmission: Resubmission,
        hosts: Option<vk::CommandBuffer>,
    ) -> Result<(), Error> {
        let raw = self.device.raw();
        if let Some(own) = &mut self.own {
            own.piece = 0;
            // SAFETY: the slot's tick is over, so its commands are not in use.
            unsafe { raw.reset_command_pool(own.pool, vk::CommandPoolResetFlags::empty()) }
                .called("vkResetCommandPool")?;
        }
        if let Some(timer) = &self.timer
            && std::mem::take(&mut self.is_timed)
        {
            timer.read(&mut self.pass_times);
        } else if self.timing == SlotTiming::Untimed {
            self.pass_times.clear();
        }
        self.timing = timing;
        self.whole.read(self.tick);
        self.uploads.reset()?;
        let buffer = match hosts {
            Some(buffer) => buffer,
            None => self.begin_piece()?,
        };
        let timer = self.timer.clone().filter(|_| self.timing == SlotTiming::Timed);
        self.commands.restart(buffer, recording, timer.clone(), resubmission)?;
        if let Some(timer) = &timer {
            timer.reset(&self.commands);
        }
        Ok(())
    }

    /// Begins the command buffer of the next piece, which is created when it is first needed.
    fn begin_piece(&mut self) -> Result<vk::CommandBuffer, Error> {
        let Some(own) = &mut self.own else { return Err(NO_QUEUE) };
        if own.piece == own.pieces.len() {
            let name = format!("{}, piece {}", self.name, own.piece);
            own.pieces.push(allocate_commands(&self.device, own.pool, &name)?);
        }
        let buffer = own.pieces[own.piece];
        begin_commands(&self.device, buffer)?;
        Ok(buffer)
    }

    /// Continues the recording in another piece after a submit.
    pub(super) fn next_piece(&mut self) -> Result<(), Error> {
        if let Some(own) = &mut self.own {
            own.piece += 1;
        }
        let buffer = self.begin_piece()?;
        self.commands.next_piece(buffer);
        Ok(())
    }

    /// Submits the commands recorded so far.
    pub(super) fn submit(&mut self, order: &Order<'_>) -> Result<Tick, Error> {
        self.commands.check()?;
        if self.own.is_none() {
            return Err(NO_QUEUE);
        }
        end_commands(&self.device, self.commands.raw())?;
        self.tick = self.device.submit(Some(self.commands.raw()), order)?;
        self.commands.submitted(self.tick);
        Ok(self.tick)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        if let Some(own) = &self.own {
            self.device.retire(Retired::CommandPool(own.pool));
        }
    }
}
