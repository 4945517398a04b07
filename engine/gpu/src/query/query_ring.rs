//! The query ring: occlusion queries over N frames in flight, whose results nobody waits for.
//!
//! A slot belongs to one frame until its tick is over. While the frame runs, the GPU itself copies
//! the results: to a buffer for the predicates of the same frame, and from there to mapped memory,
//! where the CPU picks them up in a later frame (GPU Gems, 29.4; GPU Gems 2, 6.4). The results are
//! believed because of the tick, not because of an availability value: SwiftShader may write that
//! value too early.

use std::ops::Range;

use crate::core::capabilities::Optional;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::core::tick::Tick;
use crate::memory::buffer::BufferSlice;
use crate::query::occlusion_pool::{Counting, OcclusionPool, QueryIndex, check_recorded};
use crate::query::recorded_queries::RecordedQueries;
use crate::query::result_buffer::{RESULT_BYTES, ResultBuffer};
use crate::query::ring::Ring;
use crate::record::access::Access;
use crate::record::commands::Commands;
use crate::record::frames::Frame;

/// A ring of occlusion queries over the frames in flight. Each carries a tag `T` and returns it
/// with its result; the ring does not look into it.
pub struct QueryRing<T> {
    device: Device,
    ring: Ring<T, Option<Queries>>,
    /// The queries of the frame being recorded.
    recorded: RecordedQueries,
    name: String,
    counting: Counting,
}

/// The Vulkan side of a slot.
struct Queries {
    pool: OcclusionPool,
    results: ResultBuffer,
}

impl<T> OfDevice for QueryRing<T> {
    const KIND: &'static str = "a query ring (`QueryRing`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> QueryRing<T> {
    /// Creates a ring for `frames_in_flight` frames. Slots grow as frames ask for more queries.
    ///
    /// # Errors
    /// None today; slots are made when they are first used.
    pub fn new(device: &Device, frames_in_flight: usize, name: &str) -> Result<Self, Error> {
        Ok(Self {
            device: device.clone(),
            ring: Ring::new(frames_in_flight),
            recorded: RecordedQueries::default(),
            name: name.to_owned(),
            counting: Counting::Some,
        })
    }

    /// Sets the meaning of the results of queries that are begun from now on.
    pub fn set_counting(&mut self, counting: Counting) {
        self.counting = counting;
    }

    /// Gives `answer` every result that has arrived: the tag and the number of samples that passed
    /// (only zero or not zero means something, unless they were
    /// [counted](QueryRing::set_counting)). `completed` is [`Device::completed`]. Never waits.
    pub fn collect(&mut self, completed: Tick, mut answer: impl FnMut(T, u32)) {
        let device = &self.device;
        self.ring.collect(
            device.proven(completed),
            |tick| device.is_lost(tick),
            |slot| {
                let Some(queries) = &slot.memory else { return };
                for (tag, samples) in slot.tags.iter().zip(queries.results.read(slot.tags.len())) {
                    answer(*tag, *samples);
                }
            },
        );
    }

    /// Starts the queries of `frame`, one per tag; the index of a query is the index of its tag.
    /// Results of this slot that nobody collected are dropped.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which fails; [`Error::Unsupported`] where
    /// the queries of the device cannot count as they are to; no memory, or a failed call.
    pub fn begin(&mut self, frame: &mut Frame<'_>, tags: &[T]) -> Result<(), Error> {
        frame.commands().admit(self)?;
        let lacking = Optional::PreciseQueries;
        if self.counting == Counting::Samples && !self.device.capabilities().has(lacking) {
            let device = self.device.adapter().name.clone();
            let wanted = "queries that count samples";
            return Err(Error::Unsupported { device, missing: lacking.name(), wanted });
        }
        let (slot, _) = self.ring.turn_to(frame.slot(), |tick| self.device.is_lost(tick));
        self.recorded.restart(0);
        slot.begin(frame.commands().recording(), tags.iter().copied());
        if slot.memory.as_ref().is_none_or(|queries| !queries.results.holds(tags.len())) {
            let name = format!("{} {}", self.name, slot.number);
            slot.memory = None; // retired: the slot's own tick is over
            slot.memory = Some(Queries::new(&self.device, ResultBuffer::roomy(tags.len()), &name)?);
        }
        let wanted = u32::try_from(tags.len()).unwrap_or(u32::MAX);
        self.recorded.restart(wanted);
        if let Some(queries) = &slot.memory {
            queries.pool.reset(frame.commands(), wanted);
        }
        Ok(())
    }

    /// Records what `record` draws under `query`. Each query of a frame is recorded exactly once; a
    /// second use makes the recording fail.
    pub fn scope(&self, commands: &Commands, query: QueryIndex, record: impl FnOnce(&Commands)) {
        match self.begun(commands) {
            Some(queries) if query.0 < self.recorded.count() => {
                let number = (&self.recorded, query.0);
                queries.pool.scope(commands, query.0, self.counting, number, record);
            }
            // Not begun for this frame: draw without a query.
            _ => record(commands),
        }
    }

    /// Copies the results of queries `range` on the GPU to [`QueryRing::results`], one 32-bit
    /// result each. Outside of rendering; the recording fails unless all of them were recorded. A
    /// barrier from [`Access::CopyWrite`] to the use must follow.
    pub fn resolve(&self, commands: &Commands, range: Range<u32>) {
        let Some(queries) = self.begun(commands) else {
            return;
        };
        let range = range.start..range.end.min(self.recorded.count());
        if range.is_empty() || !check_recorded(commands, &self.recorded, range.clone()) {
            return;
        }
        let (offset, size) = (u64::from(range.start), u64::from(range.end - range.start));
        let to = queries.results.whole().part(offset * RESULT_BYTES, size * RESULT_BYTES);
        queries.pool.copy_results(commands, range, to);
    }

    /// Returns the results that [`QueryRing::resolve`] writes, for predicates.
    pub fn results(&self) -> Option<BufferSlice> {
        let queries = self.ring.current().memory.as_ref()?;
        Some(queries.results.whole())
    }

    /// Copies all results to mapped memory for [`QueryRing::collect`]. The last use in a frame.
    pub fn read_back(&self, commands: &Commands) {
        let slot = self.ring.current();
        if let (Some(queries), Ok(())) = (&slot.memory, commands.admit(self)) {
            queries.results.read_back(commands, slot.tags.len(), &[Access::CopyWrite]);
        }
    }

    /// Notes that the frame that the ring recorded for is submitted.
    pub fn submitted(&mut self, tick: Tick) {
        self.ring.submitted(self.device.not_before(tick));
    }

    fn begun(&self, commands: &Commands) -> Option<&Queries> {
        commands.admit(self).ok()?;
        let slot = self.ring.current();
        slot.memory.as_ref().filter(|_| slot.is_begun_for(commands.recording()))
    }
}

impl Queries {
    fn new(device: &Device, capacity: usize, name: &str) -> Result<Self, Error> {
        let results = ResultBuffer::new(device, &format!("{name} results"), capacity)?;
        let capacity = u32::try_from(capacity).unwrap_or(u32::MAX);
        Ok(Self { pool: OcclusionPool::new(device, capacity, name)?, results })
    }
}
