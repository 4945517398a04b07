//! The query ring: occlusion queries over N frames in flight, whose results are read without
//! waiting.
//!
//! A slot belongs to one frame until its tick is over. While the frame runs, the GPU copies the
//! results to a buffer for the predicates of the same frame, and from there to mapped memory, where
//! the CPU reads them in a later frame (GPU Gems, 29.4; GPU Gems 2, 6.4). The tick proves that the
//! results are valid, not an availability value: SwiftShader may write that value too early.

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

/// A ring of occlusion queries over the frames in flight. Each query carries a tag `T` of the
/// caller and returns it with its result.
pub struct QueryRing<T> {
    device: Device,
    ring: Ring<T, Option<Queries>>,
    /// The queries of the frame being recorded.
    recorded: RecordedQueries,
    name: String,
    counting: Counting,
    /// The number of views of the renderings that the queries are recorded in.
    views: u32,
    /// The pass that adds the results of all views, created if there are several.
    sum: Option<ComputePipeline>,
}

/// The Vulkan side of a slot.
struct Queries {
    pool: OcclusionPool,
    results: ResultBuffer,
    /// One result per query and view, if there are several views.
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

/// The number of queries per workgroup of `sum_queries.comp`.
const SUM_GROUP: u32 = 64;

impl<T> OfDevice for QueryRing<T> {
    const KIND: &'static str = "a query ring (`QueryRing`)";

    fn device_id(&self) -> OwnerId {
        self.device.id()
    }
}

impl<T: Copy> QueryRing<T> {
    /// Creates a ring for `frames_in_flight` frames. Slots grow as frames request more queries.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for too many frames in flight.
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

    /// Sets the meaning of results for queries that begin from now on.
    pub fn set_counting(&mut self, counting: Counting) {
        self.counting = counting;
    }

    /// Sets the number of views that renderings of later frames draw at once. A query takes one
    /// entry per view in the pool, as Vulkan requires; its result is the number of samples in all
    /// views.
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

    /// Passes every result that has arrived to `answer`: the tag and the number of samples that
    /// passed (only meaningful as zero or not zero, unless samples are
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

    /// Begins the queries of `frame`, one per tag and with its index. Results of this slot that
    /// were not collected are dropped.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame of another device, which then fails; [`Error::Unsupported`]
    /// if samples must be counted and the device cannot; no memory, or a failed call.
    pub fn begin(&mut self, frame: &mut Frame<'_>, tags: &[T]) -> Result<(), Error> {
        frame.commands().check_owner(self)?;
        if self.counting == Counting::Samples {
            let wanted = "queries that count samples";
            self.device.require(OptionalFeature::PreciseQueries, wanted)?;
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

    /// Calls `record` and counts its draws under `query`. Each query of a frame must be recorded
    /// exactly once; a second use makes the recording fail.
    pub fn scope(&self, commands: &Commands, query: QueryIndex, record: impl FnOnce(&Commands)) {
        match self.begun(commands) {
            Some(queries) if query.0 < self.recorded.count() => {
                let place = query.0.saturating_mul(self.views);
                queries.pool.scope(commands, place, self.counting, &self.recorded, query.0, record);
            }
            // The query was not begun for this frame, so the draw is recorded without it.
            _ => record(commands),
        }
    }

    /// Copies the results of the queries `range` to [`QueryRing::results`] on the GPU, one 32-bit
    /// result each. Must be called outside of rendering; the recording fails unless all of the
    /// queries were recorded. A barrier from [`Access::CopyWrite`] to the use must follow.
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
            // Users of the results wait for copies.
            commands.barrier(between(&[Access::ComputeWrite], &[Access::CopyWrite]));
        }
    }

    /// Returns the results that [`QueryRing::resolve`] writes, for predicates.
    pub fn results(&self) -> Option<BufferSlice> {
        let queries = self.ring.current().memory.as_ref()?;
        Some(queries.results.whole())
    }

    /// Copies all results to mapped memory for [`QueryRing::collect`]. Must be the last use in a
    /// frame.
    pub fn read_back(&self, commands: &Commands) {
        let slot = self.ring.current();
        if let (Some(queries), Ok(())) = (&slot.memory, commands.check_owner(self)) {
            queries.results.read_back(commands, slot.tags.len(), Access::CopyWrite);
        }
    }

    /// Notes that the frame of the present recording was submitted as `tick`.
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

    /// Returns true if there is room for `count` queries in renderings of `views` views.
    fn holds(&self, count: usize, views: u32) -> bool {
        let places = count as u64 * u64::from(views);
        self.results.holds(count)
            && self.of_views.is_some() == (views > 1)
            && places <= u64::from(self.pool.capacity())
    }
}
