//! The query ring: occlusion queries over N frames in flight, whose results nobody waits for.
//!
//! A slot belongs to one frame until its tick is over. While the frame runs, the GPU itself copies
//! the results: to a buffer for the predicates of the same frame, and from there to mapped memory,
//! where the CPU picks them up in a later frame (GPU Gems, 29.4; GPU Gems 2, 6.4). The results are
//! believed because of the tick, not because of an availability value: SwiftShader may write that
//! value too early.

use std::ops::Range;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::core::capabilities::OptionalFeature;
use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::frames_in_flight::check_frames_in_flight;
use crate::core::ownership::{OfDevice, OwnerId};
use crate::core::tick::Tick;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
use crate::query::occlusion_pool::{Counting, OcclusionPool, QueryIndex, check_recorded};
use crate::query::recorded_queries::RecordedQueries;
use crate::query::result_buffer::{RESULT_BYTES, ResultBuffer};
use crate::query::ring::Ring;
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::Commands;
use crate::record::frames::Frame;
use crate::record::pipeline::{ComputePipeline, StorageLayout};
use crate::record::shader::Spirv;

/// A ring of occlusion queries over the frames in flight. Each carries a tag `T` and returns it
/// with its result; the ring does not look into it.
pub struct QueryRing<T> {
    device: Device,
    ring: Ring<T, Option<Queries>>,
    /// The queries of the frame being recorded.
    recorded: RecordedQueries,
    name: String,
    counting: Counting,
    /// The views of the renderings that the queries are recorded in.
    views: u32,
    /// The pass that adds the results of all views, made when there are several.
    sum: Option<ComputePipeline>,
}

/// The Vulkan side of a slot.
struct Queries {
    pool: OcclusionPool,
    results: ResultBuffer,
    /// One result per query and view, where there are several views.
    of_views: Option<Buffer>,
}

/// The push constants of `sum_queries.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Sum {
    first: u32,
    count: u32,
    views: u32,
}

/// Queries per workgroup of `sum_queries.comp`.
const SUM_GROUP: u32 = 64;

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
        check_frames_in_flight(frames_in_flight)?;
        Ok(Self {
            device: device.clone(),
            ring: Ring::new(frames_in_flight),
            recorded: RecordedQueries::default(),
            name: name.to_owned(),
            counting: Counting::Some,
            views: 1,
            sum: None,
        })
    }

    /// Sets the meaning of the results of queries that are begun from now on.
    pub fn set_counting(&mut self, counting: Counting) {
        self.counting = counting;
    }

    /// Sets the number of views that renderings of later frames draw at once. A query takes a place
    /// per view in the pool, as Vulkan demands; its result is the samples of all views.
    ///
    /// # Errors
    /// A failed call.
    pub fn set_views(&mut self, views: u32) -> Result<(), Error> {
        if views > 1 && self.sum.is_none() {
            let shader = shaders::SUM_QUERIES;
            let spirv = Spirv::from_bytes(shader.name, shader.spirv)?;
            let storage = StorageLayout::new::<Sum>(2);
            self.sum = Some(ComputePipeline::new(&self.device, shader.name, &spirv, storage)?);
        }
        self.views = views.max(1);
        Ok(())
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
        frame.commands().check_owner(self)?;
        let lacking = OptionalFeature::PreciseQueries;
        if self.counting == Counting::Samples && !self.device.capabilities().has(lacking) {
            let device = self.device.adapter().name.clone();
            let wanted = "queries that count samples";
            return Err(Error::Unsupported { device, missing: lacking.name(), wanted });
        }
        let (slot, _) = self.ring.turn_to(frame.slot(), |tick| self.device.is_lost(tick));
        self.recorded.restart(0);
        slot.begin(frame.commands().recording(), tags.iter().copied());
        let views = self.views;
        if slot.memory.as_ref().is_none_or(|queries| !queries.holds(tags.len(), views)) {
            let name = format!("{} {}", self.name, slot.number);
            slot.memory = None; // retired: the slot's own tick is over
            let roomy = ResultBuffer::roomy(tags.len());
            slot.memory = Some(Queries::new(&self.device, roomy, views, &name)?);
        }
        let wanted = u32::try_from(tags.len()).unwrap_or(u32::MAX);
        self.recorded.restart(wanted);
        if let Some(queries) = &slot.memory {
            queries.pool.reset(frame.commands(), wanted.saturating_mul(views));
        }
        Ok(())
    }

    /// Records what `record` draws under `query`. Each query of a frame is recorded exactly once; a
    /// second use makes the recording fail.
    pub fn scope(&self, commands: &Commands, query: QueryIndex, record: impl FnOnce(&Commands)) {
        match self.begun(commands) {
            Some(queries) if query.0 < self.recorded.count() => {
                let place = query.0.saturating_mul(self.views);
                queries.pool.scope(commands, place, self.counting, &self.recorded, query.0, record);
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
        let places = range.start * self.views..range.end * self.views;
        let to = queries.of_views.as_ref().map_or(queries.results.whole(), Buffer::whole);
        let bytes = |results: u32| u64::from(results) * RESULT_BYTES;
        let to = to.part(bytes(places.start), bytes(places.end - places.start));
        queries.pool.copy_results(commands, places, to);
        if let (Some(sum), Some(of_views)) = (&self.sum, &queries.of_views) {
            let between = MemoryBarrier::between;
            commands.barrier(between(&[Access::CopyWrite], &[Access::ComputeRead]));
            commands.bind_compute(sum, &[of_views.whole(), queries.results.whole()]);
            let constants =
                Sum { first: range.start, count: range.end - range.start, views: self.views };
            commands.push_compute_constants(sum, &constants);
            commands.dispatch([constants.count.div_ceil(SUM_GROUP), 1, 1]);
            // Whoever uses the results waits for copies.
            commands.barrier(between(&[Access::ComputeWrite], &[Access::CopyWrite]));
        }
    }

    /// Returns the results that [`QueryRing::resolve`] writes, for predicates.
    pub fn results(&self) -> Option<BufferSlice> {
        let queries = self.ring.current().memory.as_ref()?;
        Some(queries.results.whole())
    }

    /// Copies all results to mapped memory for [`QueryRing::collect`]. The last use in a frame.
    pub fn read_back(&self, commands: &Commands) {
        let slot = self.ring.current();
        if let (Some(queries), Ok(())) = (&slot.memory, commands.check_owner(self)) {
            queries.results.read_back(commands, slot.tags.len(), Access::CopyWrite);
        }
    }

    /// Notes that the frame that the ring recorded for is submitted.
    pub fn submitted(&mut self, tick: Tick) {
        self.ring.submitted(self.device.not_before(tick));
    }

    fn begun(&self, commands: &Commands) -> Option<&Queries> {
        commands.check_owner(self).ok()?;
        let slot = self.ring.current();
        slot.memory.as_ref().filter(|_| slot.is_begun_for(commands.recording()))
    }
}

impl Queries {
    fn new(device: &Device, capacity: usize, views: u32, name: &str) -> Result<Self, Error> {
        let results = ResultBuffer::new(device, &format!("{name} results"), capacity)?;
        let places = u32::try_from(capacity).unwrap_or(u32::MAX).saturating_mul(views);
        let of_views = (views > 1).then(|| {
            let usage = vk::BufferUsageFlags::TRANSFER_DST | vk::BufferUsageFlags::STORAGE_BUFFER;
            let name = format!("{name} of views");
            let bytes = u64::from(places) * RESULT_BYTES;
            Buffer::new(device, &name, bytes, usage, MemoryKind::Device)
        });
        let pool = OcclusionPool::new(device, places, name)?;
        Ok(Self { pool, results, of_views: of_views.transpose()? })
    }

    /// Returns true if there is room for `count` queries in renderings of so many views.
    fn holds(&self, count: usize, views: u32) -> bool {
        let places = count as u64 * u64::from(views);
        self.results.holds(count)
            && self.of_views.is_some() == (views > 1)
            && places <= u64::from(self.pool.capacity())
    }
}
