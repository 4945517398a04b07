//! Leaf draws: a copy of a scene's indirect draws per frame slot, in which shaders enable the draws
//! of single leaves, and the list of these leaves.
//!
//! All instance counts are zero except for draws that fragments of boxes enabled in the frame. The
//! first fragment of a leaf also adds it to a list, which is read back like query results. When a
//! slot is used again, the draws that its last frame enabled are disabled again: leaf by leaf from
//! the list, without any work for other leaves.

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::core::tick::Tick;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
use crate::query::result_buffer::ResultBuffer;
use crate::query::ring::Ring;
use crate::record::access::Access;
use crate::record::commands::Commands;
use crate::record::frames::Frame;
use crate::record::indirect::{DrawRange, IndirectDraw};

/// A ring with one copy of the draws per frame slot, created when a slot first needs it. Each frame
/// carries a tag `T` that is returned with its list.
pub struct LeafDrawRing<T> {
    device: Device,
    ring: Ring<T, Option<PartMemory>>,
}

/// The draws of a scene, as the ring copies them.
pub trait LeafDraws {
    /// Returns the number of draws, including empty ones.
    fn count(&self) -> u32;

    /// Returns a draw; an empty one if there is none with this index.
    fn draw(&self, number: u32) -> IndirectDraw;

    /// Calls `each` with the index of each draw of a leaf.
    fn draws_of(&self, leaf: u32, each: &mut dyn FnMut(u32));
}

struct PartMemory {
    draws: Buffer,
    draw_count: u32,
    /// The number of enabled leaves, followed by their indices.
    list: ResultBuffer,
    /// Ranges of draws that the frame of this slot may have enabled.
    tested: Vec<DrawRange>,
    /// Ranges of draws that changed since they were written.
    changed: Vec<DrawRange>,
}

/// The leaves whose draws fragments enabled in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EnabledLeaves<'a> {
    /// A complete list: the indices of the leaves, each once.
    These(&'a [u32]),
    /// More leaves than the list can hold, with their number.
    TooMany(u32),
}

/// The number of leaves that a list can hold. Mirrors `leaf_box.frag`.
pub const LISTED_LEAVES: usize = 4095;

impl<T> OfDevice for LeafDrawRing<T> {
    const KIND: &'static str = "leaf draws (`LeafDrawRing`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> LeafDrawRing<T> {
    /// Creates a ring, initially without memory.
    pub fn new(device: &Device, frames_in_flight: usize) -> Self {
        Self { device: device.clone(), ring: Ring::new(frames_in_flight) }
    }

    /// Notes that the draws of `range` have changed: every slot writes them again before its next
    /// use.
    pub fn changed(&mut self, range: DrawRange) {
        for memory in self.ring.slots_mut().filter_map(|slot| slot.memory.as_mut()) {
            memory.changed(range);
        }
    }

    /// Notes that all draws have changed.
    pub fn all_changed(&mut self) {
        self.changed(DrawRange { first: 0, count: u32::MAX });
    }

    /// Passes the list of every frame that is over to `listed`, oldest first. Never waits.
    pub fn collect(&mut self, completed: Tick, mut listed: impl FnMut(T, EnabledLeaves<'_>)) {
        let device = &self.device;
        self.ring.collect(
            device.proven(completed),
            |tick| device.is_lost(tick),
            |slot| {
                if let (Some(tag), Some(memory)) = (slot.tags.first(), &slot.memory) {
                    listed(*tag, memory.enabled());
                }
            },
        );
    }

    /// Begins a frame in which fragments may enable draws of the ranges `tested`. Without ranges,
    /// no memory is used. A barrier from [`Access::CopyWrite`] to the stores and to the draws must
    /// follow.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which then fails; no memory.
    pub fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        tag: T,
        tested: impl Iterator<Item = DrawRange>,
        draws: &impl LeafDraws,
    ) -> Result<(), Error> {
        frame.commands().check_owner(self)?;
        let (slot, was_given_up) =
            self.ring.turn_to(frame.slot(), |tick| self.device.is_lost(tick));
        if was_given_up {
            slot.memory = None;
        }
        let mut tested = tested.peekable();
        if tested.peek().is_none() {
            return Ok(());
        }
        slot.begin(frame.commands().recording(), [tag].into_iter());
        let memory = match slot.memory.take().filter(|memory| memory.draw_count == draws.count()) {
            Some(mut memory) => {
                memory.forget_switched_on(draws);
                memory
            }
            None => PartMemory::new(&self.device, draws.count(), slot.number)?,
        };
        let memory = slot.memory.insert(memory);
        for range in memory.changed.drain(..) {
            let range = range.first..range.first + range.count;
            let off = range
                .clone()
                .map(|number| IndirectDraw { instance_count: 0, ..draws.draw(number) });
            let from = frame.uploads().push_iter(off)?;
            let to = memory.draws.whole().elements::<IndirectDraw>(range);
            frame.commands().copy_buffer(from, to);
        }
        memory.tested.clear();
        memory.tested.extend(tested);
        frame.commands().fill(memory.list.first(1), 0);
        Ok(())
    }

    /// Returns the buffers of the frame being recorded, if it has ranges to test.
    pub fn buffers(&self) -> Option<LeafDrawBuffers> {
        let memory = self.recorded()?;
        Some(LeafDrawBuffers { draws: memory.draws.whole(), list: memory.list.whole() })
    }

    /// Copies the list to mapped memory for [`LeafDrawRing::collect`]. Must be the last use in a
    /// frame.
    pub fn read_back(&self, commands: &Commands) {
        if let (Ok(()), Some(memory)) = (commands.check_owner(self), self.recorded()) {
            memory.list.read_back(commands, LISTED_LEAVES + 1, Access::FragmentWrite);
        }
    }

    /// Notes that the frame of the present recording was submitted as `tick`.
    pub fn submitted(&mut self, tick: Tick) {
        self.ring.submitted(self.device.not_before(tick));
    }

    fn recorded(&self) -> Option<&PartMemory> {
        let slot = self.ring.current();
        slot.memory.as_ref().filter(|_| slot.is_recording())
    }
}

/// Sorts ranges and merges those that touch or overlap, so that no draw is written twice. Writing a
/// draw twice would need a barrier in between.
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

/// The buffers that fragments of boxes write.
#[derive(Debug, Clone, Copy)]
pub struct LeafDrawBuffers {
    /// All draws of the scene.
    pub draws: BufferSlice,
    /// The number of enabled leaves, followed by their indices.
    pub list: BufferSlice,
}

impl PartMemory {
    /// Creates a copy in which all draws must still be written.
    fn new(device: &Device, draw_count: u32, slot: usize) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_DST;
        let name = format!("leaf draws {slot}");
        let size_bytes = u64::from(draw_count) * IndirectDraw::BYTES;
        Ok(Self {
            draws: Buffer::new(device, &name, size_bytes, usage, MemoryKind::Device)?,
            draw_count,
            list: ResultBuffer::new(device, &format!("leaf list {slot}"), LISTED_LEAVES + 1)?,
            tested: Vec::new(),
            changed: vec![DrawRange { first: 0, count: draw_count }],
        })
    }

    fn changed(&mut self, range: DrawRange) {
        // Above this number, one copy of everything is less work than these ranges.
        const MOST_RANGES: usize = 1 << 10;
        let first = range.first.min(self.draw_count);
        let count = range.count.min(self.draw_count - first);
        let is_full = self.changed.len() == MOST_RANGES;
        match self.changed.last_mut() {
            Some(last) if last.first + last.count == first => last.count += count,
            _ if is_full => {
                self.changed.clear();
                self.changed.push(DrawRange { first: 0, count: self.draw_count });
            }
            _ => self.changed.push(DrawRange { first, count }),
        }
    }

    /// Adds the draws that the last frame may have enabled to the draws to write again: the present
    /// draws of the leaves in its list. A draw that no longer belongs to its leaf is among the
    /// changed draws. The slot's tick is over, so the list is complete, collected or not.
    fn forget_switched_on(&mut self, draws: &impl LeafDraws) {
        if !self.tested.is_empty() {
            let Self { list, changed, tested, .. } = self;
            match enabled(list.read(LISTED_LEAVES + 1)) {
                EnabledLeaves::These(leaves) => leaves.iter().for_each(|leaf| {
                    draws.draws_of(*leaf, &mut |first| changed.push(DrawRange { first, count: 1 }));
                }),
                EnabledLeaves::TooMany(_) => changed.extend(tested.iter()),
            }
        }
        join(&mut self.changed);
    }

    /// Returns the list, which may be read only once the tick of its frame is over.
    fn enabled(&self) -> EnabledLeaves<'_> {
        enabled(self.list.read(LISTED_LEAVES + 1))
    }
}

fn enabled(list: &[u32]) -> EnabledLeaves<'_> {
    let Some((count, numbers)) = list.split_first() else {
        return EnabledLeaves::TooMany(u32::MAX);
    };
    match numbers.get(..*count as usize) {
        Some(numbers) => EnabledLeaves::These(numbers),
        None => EnabledLeaves::TooMany(*count),
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
