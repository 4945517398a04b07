//! Part draws: a copy of a scene's indirect draws per frame slot, in which shaders switch on single
//! draws of a range, and the list of those that they did.
//!
//! All instance counts are zero but those that fragments of boxes set in the frame; who sets one
//! first also notes it in a list, which comes home like the answers of queries. What a frame switched
//! on is switched off when its slot is used again, draw by draw as the list tells, so that nothing
//! is done for all the others.

use ash::vk;

use crate::access::{Access, MemoryBarrier};
use crate::buffer::{Buffer, BufferSlice, Place};
use crate::commands::Commands;
use crate::device::Device;
use crate::error::Error;
use crate::frames::Frame;
use crate::ownership::{OfDevice, OwnerId};
use crate::predicates::{DrawRange, IndirectDraw};
use crate::timeline::Tick;

/// One copy of the draws per frame slot, made when a slot first needs it. Each frame carries a tag
/// `T` that comes back with its list.
pub struct PartDraws<T> {
    device: Device,
    slots: Vec<PartSlot<T>>,
    recording: usize,
    draw_count: u32,
}

struct PartSlot<T> {
    memory: Option<PartMemory>,
    tag: Option<T>,
    /// Ranges that the frame of this slot may have switched on.
    tested: Vec<DrawRange>,
    /// Ranges whose draws have changed since they were written.
    changed: Vec<DrawRange>,
    /// Cleared when the list is collected.
    in_flight: Option<Tick>,
    is_recording: bool,
}

struct PartMemory {
    draws: Buffer,
    list: Buffer,
    readback: Buffer,
}

/// What fragments switched on in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SwitchedOn<'a> {
    /// The numbers of the draws, each once.
    These(&'a [u32]),
    /// So many that the list could not hold them.
    TooMany(u32),
}

/// Draws that a list can hold. Mirrors `leaf_box.frag`.
pub const LISTED_DRAWS: usize = 4095;

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;
const LIST_BYTES: u64 = (LISTED_DRAWS as u64 + 1) * 4;

impl<T> OfDevice for PartDraws<T> {
    const KIND: &'static str = "part draws (`PartDraws`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> PartDraws<T> {
    /// For a scene of `draw_count` draws.
    pub fn new(device: &Device, frames_in_flight: usize, draw_count: u32) -> Self {
        let slot = || PartSlot {
            memory: None,
            tag: None,
            tested: Vec::new(),
            changed: Vec::new(),
            in_flight: None,
            is_recording: false,
        };
        Self {
            device: device.clone(),
            slots: (0..frames_in_flight.max(1)).map(|_| slot()).collect(),
            recording: 0,
            draw_count,
        }
    }

    /// The draws of `range` have changed: every slot writes them anew when it is next used.
    pub fn changed(&mut self, range: DrawRange) {
        // Beyond that, one copy of everything is less work than all these.
        const MOST_RANGES: usize = 1 << 10;
        for slot in self.slots.iter_mut().filter(|slot| slot.memory.is_some()) {
            let is_full = slot.changed.len() == MOST_RANGES;
            match slot.changed.last_mut() {
                Some(last) if last.first.saturating_add(last.count) == range.first => {
                    last.count = last.count.saturating_add(range.count);
                }
                _ if is_full => {
                    slot.changed.clear();
                    slot.changed.push(DrawRange { first: 0, count: self.draw_count });
                }
                _ => slot.changed.push(range),
            }
        }
    }

    /// All draws have changed.
    pub fn all_changed(&mut self) {
        self.changed(DrawRange { first: 0, count: self.draw_count });
    }

    /// Gives `listed` the list of every frame that is home, oldest first. Never waits.
    pub fn collect(&mut self, completed: Tick, mut listed: impl FnMut(T, SwitchedOn<'_>)) {
        let completed = self.device.proven(completed);
        loop {
            let home = |slot: &PartSlot<T>| slot.in_flight.filter(|tick| *tick <= completed);
            let oldest = self.slots.iter_mut().filter(|slot| home(slot).is_some());
            let Some(slot) = oldest.min_by_key(|slot| slot.in_flight) else {
                return;
            };
            slot.in_flight = None;
            if let (Some(tag), Some(memory)) = (slot.tag, &slot.memory) {
                listed(tag, memory.switched_on());
            }
        }
    }

    /// Starts a frame in which fragments may switch on draws of the ranges `tested`; none of them,
    /// and nothing is used. `draw` tells each draw. A barrier from [`Access::CopyWrite`] to the
    /// stores and to the draws must follow.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which fails; no memory.
    pub fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        tag: T,
        tested: impl Iterator<Item = DrawRange>,
        draw: impl Fn(u32) -> IndirectDraw,
    ) -> Result<(), Error> {
        frame.commands().admit(self)?;
        self.recording = frame.slot().0 % self.slots.len();
        let (device, draw_count) = (&self.device, self.draw_count);
        let Some(slot) = self.slots.get_mut(self.recording) else { return Ok(()) };
        if std::mem::take(&mut slot.is_recording) {
            // The last frame here was never submitted: nobody knows what is in the memory.
            slot.memory = None;
        }
        let mut tested = tested.peekable();
        if tested.peek().is_none() {
            return Ok(());
        }
        slot.in_flight = None;
        slot.tag = Some(tag);
        slot.is_recording = true;
        let mut off = |range: DrawRange, draws: &Buffer| -> Result<(), Error> {
            let off = (range.first..range.first.saturating_add(range.count))
                .map(|number| IndirectDraw { instance_count: 0, ..draw(number) });
            let from = frame.uploads().push_iter(off)?;
            let bytes = |draws: u32| u64::from(draws) * DRAW_BYTES;
            let to = draws.whole().part(bytes(range.first), bytes(range.count));
            frame.commands().copy_buffer(from, to);
            Ok(())
        };
        match &slot.memory {
            None => {
                let memory = PartMemory::new(device, draw_count, self.recording)?;
                off(DrawRange { first: 0, count: draw_count }, &memory.draws)?;
                slot.memory = Some(memory);
                slot.changed.clear();
            }
            // The slot's tick is over, so its list is home, collected or not.
            Some(memory) => {
                if !slot.tested.is_empty() {
                    match memory.switched_on() {
                        SwitchedOn::These(numbers) => {
                            let ranges =
                                numbers.iter().map(|first| DrawRange { first: *first, count: 1 });
                            slot.changed.extend(ranges);
                        }
                        SwitchedOn::TooMany(_) => slot.changed.extend(&slot.tested),
                    }
                }
                join(&mut slot.changed);
                for range in slot.changed.drain(..) {
                    off(range, &memory.draws)?;
                }
            }
        }
        slot.tested.clear();
        slot.tested.extend(tested);
        if let Some(memory) = &slot.memory {
            frame.commands().fill(memory.list.whole().part(0, 4), 0);
        }
        Ok(())
    }

    /// The draws and the list of the frame being recorded, if it has ranges to test.
    pub fn parts(&self) -> Option<Parts> {
        let slot = self.slots.get(self.recording).filter(|slot| slot.is_recording)?;
        let memory = slot.memory.as_ref()?;
        Some(Parts { draws: memory.draws.whole(), list: memory.list.whole() })
    }

    /// Copies the list to mapped memory for [`PartDraws::collect`]. The last use in a frame.
    pub fn read_back(&self, commands: &Commands) {
        if commands.admit(self).is_err() {
            return;
        }
        let slot = self.slots.get(self.recording).filter(|slot| slot.is_recording);
        let Some(memory) = slot.and_then(|slot| slot.memory.as_ref()) else {
            return;
        };
        let between = MemoryBarrier::between;
        commands.barrier(between(&[Access::FragmentWrite, Access::CopyWrite], &[Access::CopyRead]));
        commands.copy_buffer(memory.list.whole(), memory.readback.whole());
        commands.barrier(between(&[Access::CopyWrite], &[Access::HostRead]));
    }

    /// Tells that the frame it recorded for is on its way.
    pub fn submitted(&mut self, tick: Tick) {
        let tick = self.device.not_before(tick);
        if let Some(slot) = self.slots.get_mut(self.recording)
            && std::mem::take(&mut slot.is_recording)
        {
            slot.in_flight = Some(tick);
        }
    }
}

/// Sorts ranges and makes one of those that meet: no draw is written twice, which would need a barrier
/// in between.
fn join(ranges: &mut Vec<DrawRange>) {
    let end = |range: &DrawRange| range.first.saturating_add(range.count);
    ranges.sort_unstable_by_key(|range| range.first);
    ranges.dedup_by(|next, kept| {
        let meets = next.first <= end(kept);
        if meets {
            kept.count = end(kept).max(end(next)) - kept.first;
        }
        meets
    });
}

/// What the fragments of boxes write.
#[derive(Debug, Clone, Copy)]
pub struct Parts {
    /// All draws of the scene.
    pub draws: BufferSlice,
    /// How many were switched on, then which.
    pub list: BufferSlice,
}

impl PartMemory {
    fn new(device: &Device, draw_count: u32, slot: usize) -> Result<Self, Error> {
        let draws = vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST;
        let list = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let home = vk::BufferUsageFlags::TRANSFER_DST;
        let draw_bytes = u64::from(draw_count) * DRAW_BYTES;
        let name = |what: &str| format!("{what} {slot}");
        let buffer = |what, size_bytes, usage, place| {
            Buffer::new(device, &name(what), size_bytes, usage, place)
        };
        Ok(Self {
            draws: buffer("part draws", draw_bytes, draws, Place::Device)?,
            list: buffer("part list", LIST_BYTES, list, Place::Device)?,
            readback: buffer("part list read back", LIST_BYTES, home, Place::ReadBack)?,
        })
    }

    /// What the list says. Only once the tick of its frame is over.
    fn switched_on(&self) -> SwitchedOn<'_> {
        let words = self.readback.read::<u32>(0..LISTED_DRAWS + 1);
        let Some((count, numbers)) = words.split_first() else {
            return SwitchedOn::TooMany(u32::MAX);
        };
        match numbers.get(..*count as usize) {
            Some(numbers) => SwitchedOn::These(numbers),
            None => SwitchedOn::TooMany(*count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_that_meet_are_written_once() {
        let range = |first, count| DrawRange { first, count };
        let mut ranges =
            vec![range(9, 2), range(3, 1), range(4, 3), range(5, 1), range(9, 1), range(20, 1)];
        join(&mut ranges);
        assert_eq!(ranges, [range(3, 4), range(9, 2), range(20, 1)]);
        let mut all = vec![range(7, 1), range(0, 30), range(30, 0)];
        join(&mut all);
        assert_eq!(all, [range(0, 30)]);
    }
}
