//! A slot of the frame ring: the command buffers and the memory that one frame in flight holds.

use std::sync::Arc;

use ash::vk;

use crate::core::deletion::{Recording, Retired};
use crate::core::device::{Device, Order};
use crate::core::error::{Called, Error};
use crate::core::tick::Tick;
use crate::memory::upload::Uploads;
use crate::record::commands::Commands;
use crate::record::pools::{
    allocate_commands, begin_commands, create_command_pool, create_descriptor_pool, end_commands,
};
use crate::record::timing::{FrameTimer, PassTime, PassTimer};

/// The timing of the passes of a frame: on or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SlotTiming {
    Timed,
    Untimed,
}

/// The resources of one frame in flight.
pub(super) struct Slot {
    pub(super) device: Device,
    pub(super) name: String,
    pub(super) pool: vk::CommandPool,
    /// One command buffer per piece of the frame; most frames are one piece.
    pub(super) pieces: Vec<vk::CommandBuffer>,
    pub(super) piece: usize,
    pub(super) descriptors: Vec<vk::DescriptorPool>,
    pub(super) commands: Commands,
    pub(super) uploads: Uploads,
    pub(super) timer: Option<Arc<PassTimer>>,
    pub(super) pass_times: Vec<PassTime>,
    /// True if the timer holds the times of a whole frame: one that was given up leaves none.
    pub(super) is_timed: bool,
    pub(super) timing: SlotTiming,
    pub(super) whole: FrameTimer,
    pub(super) tick: Tick,
}

/// The number of pieces of a frame that share a descriptor pool; the next ones get another.
const PIECES_PER_DESCRIPTOR_POOL: usize = 32;

impl Slot {
    pub(super) fn new(device: &Device, index: usize) -> Result<Self, Error> {
        let name = format!("frame {index}");
        let pool = create_command_pool(device, &name)?;
        let buffer = allocate_commands(device, pool, &name);
        let made = buffer.and_then(|buffer| Ok((buffer, create_descriptor_pool(device, &name)?)));
        let (buffer, descriptors) =
            made.inspect_err(|_| device.retire(Retired::CommandPool(pool)))?;
        Ok(Self {
            device: device.clone(),
            pool,
            pieces: vec![buffer],
            piece: 0,
            descriptors: vec![descriptors],
            commands: Commands::new(device, buffer, Recording::default(), descriptors, None),
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

    /// Restarts the slot for a recording; its tick is over.
    pub(super) fn restart(
        &mut self,
        recording: Recording,
        timing: SlotTiming,
    ) -> Result<(), Error> {
        let raw = self.device.raw();
        // SAFETY: the slot's tick is over, so nothing of it is in use.
        unsafe {
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .called("vkResetCommandPool")?;
            for pool in &self.descriptors {
                raw.reset_descriptor_pool(*pool, vk::DescriptorPoolResetFlags::empty())
                    .called("vkResetDescriptorPool")?;
            }
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
        self.piece = 0;
        let (buffer, descriptors) = self.begin_piece()?;
        let timer = self.timer.clone().filter(|_| self.timing == SlotTiming::Timed);
        self.commands = Commands::new(&self.device, buffer, recording, descriptors, timer.clone());
        if let Some(timer) = &timer {
            timer.reset(self.commands.raw());
        }
        Ok(())
    }

    /// Begins the command buffer of the next piece, which is created when it is first needed.
    pub(super) fn begin_piece(&mut self) -> Result<(vk::CommandBuffer, vk::DescriptorPool), Error> {
        if self.piece == self.pieces.len() {
            let name = format!("{}, piece {}", self.name, self.piece);
            self.pieces.push(allocate_commands(&self.device, self.pool, &name)?);
        }
        let pool = self.piece / PIECES_PER_DESCRIPTOR_POOL;
        if pool == self.descriptors.len() {
            let name = format!("{}, descriptors {pool}", self.name);
            self.descriptors.push(create_descriptor_pool(&self.device, &name)?);
        }
        let (buffer, descriptors) = (self.pieces[self.piece], self.descriptors[pool]);
        begin_commands(&self.device, buffer)?;
        Ok((buffer, descriptors))
    }

    /// Submits the commands recorded so far.
    pub(super) fn submit(&mut self, order: &Order<'_>) -> Result<Tick, Error> {
        self.commands.check()?;
        end_commands(&self.device, self.commands.raw())?;
        self.tick = self.device.submit(Some(self.commands.raw()), order)?;
        self.commands.submitted(self.tick);
        Ok(self.tick)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        for pool in &self.descriptors {
            self.device.retire(Retired::DescriptorPool(*pool));
        }
        self.device.retire(Retired::CommandPool(self.pool));
    }
}
