//! A pool of occlusion queries, with the commands that use it.

use std::ops::Range;

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::core::deletion::Retired;
use crate::core::device::Device;
use crate::core::error::{Called, Error};
use crate::memory::buffer::BufferSlice;
use crate::query::query_reset::reset_queries;
use crate::query::recorded_queries::RecordedQueries;
use crate::query::result_buffer::RESULT_BYTES;
use crate::record::commands::{Commands, Failure};

/// The index of a query in the frame being recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct QueryIndex(pub u32);

/// The meaning of a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counting {
    /// Visibility: any number but 0 if some samples passed.
    Some,
    /// The number of samples that passed. Needs [`crate::OptionalFeature::PreciseQueries`].
    Samples,
}

/// The occlusion queries of one frame slot.
pub(crate) struct OcclusionPool {
    device: Device,
    raw: vk::QueryPool,
    capacity: u32,
}

impl OcclusionPool {
    pub(crate) fn new(device: &Device, capacity: u32, name: &str) -> Result<Self, Error> {
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::OCCLUSION)
            .query_count(capacity);
        // SAFETY: a plain query pool; capacity is not zero.
        let raw = unsafe { device.raw().create_query_pool(&info, device.callbacks()) }
            .called("vkCreateQueryPool")?;
        device.name(raw, name);
        Ok(Self { device: device.clone(), raw, capacity })
    }

    /// Returns the number of queries in the pool.
    pub(crate) fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Resets the first `count` queries, outside of rendering. The tick of the frame that used them
    /// before must be over.
    pub(crate) fn reset(&self, commands: &Commands, count: u32) {
        reset_queries(&self.device, commands, self.raw, count.min(self.capacity));
    }

    /// Calls `record` and counts its draws under query `query` of this pool, which has the index
    /// `number` in `recorded`. A second use of a query makes the recording fail.
    pub(crate) fn scope(
        &self,
        commands: &Commands,
        query: u32,
        counting: Counting,
        recorded: &RecordedQueries,
        number: u32,
        record: impl FnOnce(&Commands),
    ) {
        if !recorded.note(number) {
            commands.fail(Failure::Wrong("a query is used twice in a frame"));
            return;
        }
        let raw = self.device.raw();
        let is_precise = counting == Counting::Samples
            && self.device.capabilities().has(OptionalFeature::PreciseQueries);
        let flags = if is_precise {
            vk::QueryControlFlags::PRECISE
        } else {
            vk::QueryControlFlags::empty()
        };
        // SAFETY: the query was reset earlier in this frame and is used once in it, as `recorded`
        // proves; precise queries are used only with the feature enabled.
        unsafe { raw.cmd_begin_query(commands.raw(), self.raw, query, flags) };
        record(commands);
        // SAFETY: closes the query opened above.
        unsafe { raw.cmd_end_query(commands.raw(), self.raw, query) };
    }

    /// Copies the results of `queries` to `to` on the GPU, outside of rendering. All of the queries
    /// must have been recorded.
    pub(crate) fn copy_results(&self, commands: &Commands, queries: Range<u32>, to: BufferSlice) {
        // WAIT makes the GPU wait for its earlier commands, not the CPU.
        let flags = vk::QueryResultFlags::WAIT;
        // SAFETY: the queries were begun and ended earlier in this frame; the slice has a result
        // for each.
        unsafe {
            self.device.raw().cmd_copy_query_pool_results(
                commands.raw(),
                self.raw,
                queries.start,
                queries.end - queries.start,
                to.raw,
                to.offset_bytes,
                RESULT_BYTES,
                flags,
            );
        }
    }
}

/// Makes the recording fail unless all of `queries` were recorded: the GPU would wait forever.
pub(crate) fn check_recorded(
    commands: &Commands,
    recorded: &RecordedQueries,
    queries: Range<u32>,
) -> bool {
    let are_recorded = recorded.has_all(queries);
    if !are_recorded {
        commands.fail(Failure::Wrong("the result is wanted of a query that was not recorded"));
    }
    are_recorded
}

impl Drop for OcclusionPool {
    fn drop(&mut self) {
        self.device.retire(Retired::QueryPool(self.raw));
    }
}
