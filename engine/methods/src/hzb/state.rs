//! The state of one view for the pyramid strategy: the leaves that were visible, and counts that
//! are still to be read back.

use cull::{FrameId, Generation, Hierarchy};
use gpu::{
    Access, Buffer, BufferSlice, Commands, Device, MemoryBarrier, MemoryKind, SlotIndex, Tick, vk,
};

use occlusion::{Error, FrameStats, MethodState, Outcomes};

use super::cull::Counters;

/// The GPU state of one view. It is used only if it is from the previous frame.
pub(crate) struct HzbState {
    seen: Buffer,
    leaf_count: usize,
    generation: Generation,
    /// The newest frame that was submitted.
    newest: Option<FrameId>,
    /// The frame being recorded and its slot.
    recording: Option<(FrameId, SlotIndex)>,
    slots: Vec<Slot>,
}

/// The counts of one frame in flight.
struct Slot {
    counters: Buffer,
    in_flight: Option<(Tick, FrameId)>,
}

/// The bytes of the counters of both phases.
pub(crate) const COUNTER_BYTES: u64 = 2 * size_of::<Counters>() as u64;

impl HzbState {
    /// Creates a state with room for the leaves of `hierarchy`; nothing counts as visible.
    pub(crate) fn new(
        device: &Device,
        hierarchy: &Hierarchy,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        let leaf_count = hierarchy.leaf_objects().len();
        let slot = |number| -> Result<Slot, Error> {
            let name = format!("pyramid counts {number}");
            let usage = vk::BufferUsageFlags::TRANSFER_DST;
            let counters = Buffer::new(device, &name, COUNTER_BYTES, usage, MemoryKind::ReadBack)?;
            Ok(Slot { counters, in_flight: None })
        };
        Ok(Self {
            seen: seen_values(device, leaf_count)?,
            leaf_count,
            generation: hierarchy.generation(),
            newest: None,
            recording: None,
            slots: (0..frames_in_flight.max(1)).map(slot).collect::<Result<_, _>>()?,
        })
    }

    /// Returns the buffer with a value per leaf, which is not 0 if the leaf was visible in the last
    /// frame.
    pub(crate) fn seen(&self) -> BufferSlice {
        self.seen.whole()
    }

    /// Begins `frame` in `slot`, about the leaves of `hierarchy`.
    pub(crate) fn begin(
        &mut self,
        device: &Device,
        hierarchy: &Hierarchy,
        frame: FrameId,
        slot: SlotIndex,
    ) -> Result<(), Error> {
        let leaf_count = hierarchy.leaf_objects().len();
        if self.leaf_count != leaf_count {
            self.seen = seen_values(device, leaf_count)?;
            self.leaf_count = leaf_count;
            self.newest = None;
        }
        if self.generation != hierarchy.generation() {
            self.generation = hierarchy.generation();
            self.newest = None;
        }
        self.recording = Some((frame, slot));
        Ok(())
    }

    /// Clears the state unless the previous frame used this strategy, so that no leaf counts as
    /// visible. A barrier from [`Access::CopyWrite`] must follow.
    pub(crate) fn forget_unless_next(&self, commands: &Commands) {
        let frame = self.recording.map(|(frame, _)| frame.0);
        if self.newest.map(|newest| newest.0 + 1) != frame {
            commands.fill(self.seen.whole(), 0);
        }
    }

    /// Records the copy of the frame's counters to mapped memory.
    pub(crate) fn read_back(&self, commands: &Commands, counters: BufferSlice) {
        if let Some((_, slot)) = self.recording
            && let Some(slot) = self.slots.get(slot.0 % self.slots.len())
        {
            commands.copy_buffer(counters, slot.counters.whole());
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
        }
    }
}

impl MethodState for HzbState {
    /// Reads the counts of the frames that are over, from the oldest on.
    fn collect(&mut self, completed: Tick, outcomes: &mut Outcomes) -> Option<FrameId> {
        let mut newest = None;
        loop {
            let over = |slot: &&mut Slot| slot.in_flight.is_some_and(|(tick, _)| tick <= completed);
            let slot = self.slots.iter_mut().filter(over).min_by_key(|slot| slot.in_flight);
            let Some((slot, (_, frame))) =
                slot.and_then(|slot| slot.in_flight.take().map(|of| (slot, of)))
            else {
                return newest;
            };
            let counters = slot.counters.read::<Counters>(0..2);
            let phase = |number: usize| counters.get(number).copied().unwrap_or_default();
            if let Some(outcome) = outcomes.of(frame) {
                count(outcome, phase(0), phase(1));
            }
            newest = newest.max(Some(frame));
        }
    }

    fn submitted(&mut self, tick: Tick, frame: FrameId) -> bool {
        let Some((_, slot)) = self.recording.take().filter(|(recorded, _)| *recorded == frame)
        else {
            return false;
        };
        self.newest = Some(frame);
        let slots = self.slots.len();
        if let Some(slot) = self.slots.get_mut(slot.0 % slots) {
            slot.in_flight = Some((tick, frame));
        }
        true
    }
}

/// Writes the draws of both phases of a frame into its outcome.
fn count(outcome: &mut FrameStats, first: Counters, second: Counters) {
    outcome.draws = u64::from(first.draws) + u64::from(second.draws);
    outcome.triangles = first.triangles() + second.triangles();
    outcome.revealed = second.draws.into();
}

/// Creates a buffer with a value per leaf, without contents.
fn seen_values(device: &Device, leaf_count: usize) -> Result<Buffer, Error> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    Ok(Buffer::new(device, "pyramid seen", leaf_count as u64 * 4, usage, MemoryKind::Device)?)
}
