//! The stamps of a host's frames: each frame writes its number and the number of the frame that ran
//! before to memory that the CPU reads later.

use std::sync::Arc;

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::executions::{FrameStamp, StampMemory};
use crate::core::tick::Tick;
use crate::memory::buffer::{Buffer, MemoryKind};
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::Commands;

/// The memory for the stamps of a ring.
pub(super) struct FrameStamps {
    /// The number of the frame that ran last.
    newest: Buffer,
    slots: Vec<Arc<SlotStamp>>,
}

/// The [`FrameStamp`] of a slot's last frame. The device reads it when this frame is over.
struct SlotStamp(Buffer);

impl StampMemory for SlotStamp {
    fn stamp(&self) -> FrameStamp {
        self.0.read(0..1).first().copied().unwrap_or_default()
    }
}

impl FrameStamps {
    pub(super) fn new(device: &Device, slots: usize) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let newest_bytes = size_of::<u64>() as u64;
        let mut newest =
            Buffer::new(device, "newest frame", newest_bytes, usage, MemoryKind::Upload)?;
        // Written before the first submit, which makes it visible to the GPU.
        newest.bytes_mut().fill(0);
        let slot = |slot| {
            let name = format!("frame stamp {slot}");
            let bytes = size_of::<FrameStamp>() as u64;
            let mut stamp = Buffer::new(device, &name, bytes, usage, MemoryKind::ReadBack)?;
            stamp.bytes_mut().fill(0);
            Ok(Arc::new(SlotStamp(stamp)))
        };
        Ok(Self { newest, slots: (0..slots).map(slot).collect::<Result<_, _>>()? })
    }

    /// Writes the stamp of `frame`, as the last commands of the frame, and registers its memory.
    pub(super) fn record(&self, device: &Device, commands: &Commands, slot: usize, frame: Tick) {
        let Some(slot) = self.slots.get(slot) else { return };
        let memory: Arc<dyn StampMemory> = Arc::clone(slot) as _;
        device.executions().sent(frame, Arc::downgrade(&memory));
        let number_bytes = size_of::<u64>() as u64;
        let [number, predecessor] =
            [0, number_bytes].map(|offset| slot.0.whole().part(offset, number_bytes));
        let copies = [Access::CopyRead, Access::CopyWrite];
        // Waits for the stamps of the frame that ran before this one.
        commands.barrier(MemoryBarrier::between(&copies, &copies));
        commands.copy_buffer(self.newest.whole(), predecessor);
        commands.barrier(MemoryBarrier::between(&[Access::CopyRead], &[Access::CopyWrite]));
        commands.write(self.newest.whole(), &frame.0);
        commands.write(number, &frame.0);
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    }
}
