//! The query ring: occlusion queries over N frames in flight whose answers never make anyone wait.
//!
//! A slot belongs to one frame until its tick is over. While the frame runs, the GPU itself copies
//! the results: to a buffer that predicates read in the same frame, and from there to mapped memory,
//! where the CPU picks them up in a later frame (GPU Gems, 29.4; GPU Gems 2, 6.4). The results are
//! believed because of the tick, not because of an availability word: SwiftShader may write that
//! word too early.

use std::ops::Range;

use ash::vk;

use crate::access::{Access, MemoryBarrier};
use crate::buffer::{Buffer, BufferSlice, Place};
use crate::commands::{Commands, Failure};
use crate::deletion::{Garbage, Recording};
use crate::device::Device;
use crate::error::{Called, Error};
use crate::frames::Frame;
use crate::ownership::{OfDevice, OwnerId};
use crate::query_pages::Counting;
use crate::recorded::Recorded;
use crate::timeline::Tick;

/// A query of the frame being recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct QueryIndex(pub u32);

/// Occlusion queries over the frames in flight. Each carries a tag `T` and brings it back with
/// its result; the ring does not look into it.
pub struct QueryRing<T> {
    device: Device,
    slots: Vec<QuerySlot<T>>,
    recording: usize,
    name: String,
    counting: Counting,
}

struct QuerySlot<T> {
    queries: Option<Queries>,
    tags: Vec<T>,
    // The recording that these queries are for, and which of them it has recorded.
    recording: Recording,
    recorded: Recorded,
    // The frame whose answers this slot holds; None while recording or after collecting.
    in_flight: Option<Tick>,
}

/// The Vulkan side of a slot.
struct Queries {
    device: Device,
    pool: vk::QueryPool,
    capacity: u32,
    results: Buffer,
    readback: Buffer,
}

const FIRST_CAPACITY: u32 = 256;
pub(crate) const RECORDED_TWICE: &str = "a query is used twice in a frame";
pub(crate) const NEVER_RECORDED: &str = "the result is wanted of a query that was not recorded";
const WORD_BYTES: u64 = 4;

impl<T> OfDevice for QueryRing<T> {
    const KIND: &'static str = "a query ring (`QueryRing`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> QueryRing<T> {
    /// A ring for `frames_in_flight` frames. Slots grow as frames ask for more queries.
    ///
    /// # Errors
    /// None today; slots are made when they are first used.
    pub fn new(device: &Device, frames_in_flight: usize, name: &str) -> Result<Self, Error> {
        let slot = || QuerySlot {
            queries: None,
            tags: Vec::new(),
            recording: Recording::default(),
            recorded: Recorded::default(),
            in_flight: None,
        };
        Ok(Self {
            device: device.clone(),
            slots: (0..frames_in_flight.max(1)).map(|_| slot()).collect(),
            recording: 0,
            name: name.to_owned(),
            counting: Counting::Some,
        })
    }

    /// The same with queries that count so.
    #[must_use]
    pub fn counting(self, counting: Counting) -> Self {
        Self { counting, ..self }
    }

    /// Gives `answer` every result that is home: the tag and the number of samples that passed
    /// (only zero or not zero means something, unless the ring [counts](QueryRing::counting) them). `completed` is [`Device::completed`]. Never waits.
    pub fn collect(&mut self, completed: Tick, mut answer: impl FnMut(T, u32)) {
        let completed = self.device.proven(completed);
        loop {
            let home = |slot: &QuerySlot<T>| slot.in_flight.filter(|tick| *tick <= completed);
            // Oldest first: the history should see answers in the order of their frames.
            let oldest = self.slots.iter_mut().filter(|slot| home(slot).is_some());
            let Some(slot) = oldest.min_by_key(|slot| slot.in_flight) else {
                return;
            };
            slot.in_flight = None;
            let Some(queries) = &slot.queries else {
                continue;
            };
            let samples = queries.readback.read::<u32>(0..slot.tags.len());
            for (tag, samples) in slot.tags.iter().zip(samples) {
                answer(*tag, *samples);
            }
        }
    }

    /// Starts the queries of `frame`, one per tag; the index of a query is the index of its tag.
    /// Answers of this slot that nobody collected are forgotten.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which fails; no memory, or a failed call.
    pub fn begin(&mut self, frame: &mut Frame<'_>, tags: &[T]) -> Result<(), Error> {
        frame.commands().admit(self)?;
        let slot_index = frame.slot().0 % self.slots.len();
        self.recording = slot_index;
        let Some(slot) = self.slots.get_mut(slot_index) else {
            return Ok(());
        };
        slot.in_flight = None;
        slot.tags.clear();
        slot.tags.extend_from_slice(tags);
        let wanted = u32::try_from(tags.len()).unwrap_or(u32::MAX);
        if slot.queries.as_ref().is_none_or(|queries| queries.capacity < wanted) {
            let capacity = wanted.max(FIRST_CAPACITY).next_power_of_two();
            let name = format!("{} {slot_index}", self.name);
            slot.queries = None; // retired: the slot's own tick is over
            slot.queries = Some(Queries::new(&self.device, capacity, &name)?);
        }
        slot.recording = frame.commands().recording();
        slot.recorded.restart(wanted);
        if let Some(queries) = &slot.queries
            && wanted > 0
        {
            let commands = frame.commands().raw();
            // SAFETY: the slot's tick is over, so none of its queries is in use.
            unsafe { self.device.raw().cmd_reset_query_pool(commands, queries.pool, 0, wanted) };
        }
        Ok(())
    }

    /// Records what `record` draws under `query`. Each query of a frame is recorded exactly once; a
    /// second time makes the recording fail.
    pub fn scope(&self, commands: &Commands, query: QueryIndex, record: impl FnOnce(&Commands)) {
        match self.begun(commands) {
            Some((queries, recorded)) if query.0 < recorded.count() => {
                if recorded.note(query.0) {
                    commands.query(queries.pool, query, self.counting, record);
                } else {
                    commands.fail(Failure::Wrong(RECORDED_TWICE));
                }
            }
            // Not begun for this frame: draw without asking.
            _ => record(commands),
        }
    }

    /// Copies the results of queries `range` on the GPU to [`QueryRing::results`], one 32-bit word
    /// each. All of them have been recorded, or the recording fails; outside of rendering. A barrier
    /// from [`Access::CopyWrite`] to the use must follow.
    pub fn resolve(&self, commands: &Commands, range: Range<u32>) {
        let Some((queries, recorded)) = self.begun(commands) else {
            return;
        };
        let last = range.end.min(recorded.count());
        let count = last.saturating_sub(range.start);
        if count == 0 {
            return;
        }
        if !recorded.has_all(range.start..last) {
            commands.fail(Failure::Wrong(NEVER_RECORDED));
            return;
        }
        let to = queries.results.whole();
        let offset = u64::from(range.start) * WORD_BYTES;
        // WAIT is the GPU's own wait for its earlier commands, not the CPU's.
        let flags = vk::QueryResultFlags::WAIT;
        // SAFETY: the queries were begun and ended earlier in this frame; the buffer has a word
        // for each.
        unsafe {
            commands.device().raw().cmd_copy_query_pool_results(
                commands.raw(),
                queries.pool,
                range.start,
                count,
                to.raw,
                offset,
                WORD_BYTES,
                flags,
            );
        }
    }

    /// The words that [`QueryRing::resolve`] writes, for predicates.
    pub fn results(&self) -> Option<BufferSlice> {
        self.current().map(|(queries, _)| queries.results.whole())
    }

    /// Copies all words to mapped memory for [`QueryRing::collect`]. The last use in a frame.
    pub fn read_back(&self, commands: &Commands) {
        let (Some((queries, tags)), Ok(())) = (self.current(), commands.admit(self)) else {
            return;
        };
        let used_bytes = tags.len() as u64 * WORD_BYTES;
        if used_bytes == 0 {
            return;
        }
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::CopyRead]));
        commands.copy_buffer(queries.results.whole().part(0, used_bytes), queries.readback.whole());
        commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
    }

    /// Tells the ring that the frame it recorded for is on its way.
    pub fn submitted(&mut self, tick: Tick) {
        let tick = self.device.not_before(tick);
        if let Some(slot) = self.slots.get_mut(self.recording) {
            slot.in_flight = Some(tick);
        }
    }

    fn begun(&self, commands: &Commands) -> Option<(&Queries, &Recorded)> {
        commands.admit(self).ok()?;
        let slot = self.slots.get(self.recording)?;
        let is_begun = slot.recording == commands.recording();
        Some((slot.queries.as_ref().filter(|_| is_begun)?, &slot.recorded))
    }

    fn current(&self) -> Option<(&Queries, &[T])> {
        let slot = self.slots.get(self.recording)?;
        Some((slot.queries.as_ref()?, &slot.tags))
    }
}

impl Queries {
    fn new(device: &Device, capacity: u32, name: &str) -> Result<Self, Error> {
        let size_bytes = u64::from(capacity) * WORD_BYTES;
        let mut usage = vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::STORAGE_BUFFER;
        if device.conditional().is_some() {
            usage |= vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT;
        }
        let results =
            Buffer::new(device, &format!("{name} results"), size_bytes, usage, Place::Device)?;
        let readback = Buffer::new(
            device,
            &format!("{name} read back"),
            size_bytes,
            vk::BufferUsageFlags::TRANSFER_DST,
            Place::ReadBack,
        )?;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::OCCLUSION)
            .query_count(capacity);
        // SAFETY: a plain query pool; capacity is not zero.
        let pool =
            unsafe { device.raw().create_query_pool(&info, None) }.called("vkCreateQueryPool")?;
        device.name(pool, name);
        Ok(Self { device: device.clone(), pool, capacity, results, readback })
    }
}

impl Drop for Queries {
    fn drop(&mut self) {
        self.device.retire(Garbage::QueryPool(self.pool));
    }
}
