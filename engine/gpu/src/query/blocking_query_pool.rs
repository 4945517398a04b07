//! Occlusion queries of a frame that is submitted in pieces: the results of a piece are read during
//! the frame.
//!
//! Each piece copies its results to mapped memory, and the CPU reads them once its tick is over. So
//! the CPU polls or waits for ticks only. Queries are numbered over the whole frame. They are
//! created in pages when a frame requests more, and pages are kept for later frames of the slot.

use std::ops::Range;

use ash::vk;

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::ownership::of_device;
use crate::memory::buffer::{Buffer, MemoryKind};
use crate::query::occlusion_pool::{Counting, OcclusionPool, QueryIndex, check_recorded};
use crate::query::recorded_queries::RecordedQueries;
use crate::query::result_buffer::RESULT_BYTES;
use crate::query::ring::Ring;
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::Commands;
use crate::record::frames::SlotIndex;

/// Occlusion queries for frames of several pieces.
pub struct BlockingQueryPool {
    device: Device,
    /// The ring of pages. It collects nothing, because results are read while their frame is still
    /// being recorded.
    ring: Ring<(), Vec<Page>>,
    /// The queries of the frame being recorded.
    recorded: RecordedQueries,
    name: String,
}

/// A query pool, and mapped memory for its results.
struct Page {
    pool: OcclusionPool,
    mapped: Buffer,
}

/// The number of queries of one page.
const PAGE: u32 = 256;

of_device!(BlockingQueryPool: "blocking queries (`BlockingQueryPool`)");

impl BlockingQueryPool {
    /// Creates a pool for `frames_in_flight` frames, initially without queries.
    pub fn new(device: &Device, frames_in_flight: usize, name: &str) -> Self {
        let device = device.clone();
        let ring = Ring::new(frames_in_flight);
        Self { device, ring, recorded: RecordedQueries::default(), name: name.to_owned() }
    }

    /// Begins a frame in `slot`; its queries are numbered from 0.
    pub fn begin(&mut self, slot: SlotIndex) {
        self.ring.turn_to(slot, |_| false);
        self.recorded.restart(0);
    }

    /// Takes `count` more queries for this piece. Must be called outside of rendering.
    ///
    /// # Errors
    /// [`Error::Foreign`] for commands of another device, which fail; no memory, or a failed call.
    pub fn take(&mut self, commands: &Commands, count: u32) -> Result<Range<u32>, Error> {
        commands.check_owner(self)?;
        let used = self.recorded.count();
        let taken = used..used.saturating_add(count);
        let slot = self.ring.current_mut();
        // The pages that this frame uses for the first time.
        for number in used.div_ceil(PAGE)..taken.end.div_ceil(PAGE) {
            if number as usize == slot.memory.len() {
                let name = format!("{} {}, page {number}", self.name, slot.number);
                slot.memory.push(Page::new(&self.device, &name)?);
            }
            let Some(page) = slot.memory.get(number as usize) else { break };
            page.pool.reset(commands, PAGE);
        }
        self.recorded.grow(taken.end);
        Ok(taken)
    }

    /// Calls `record` and counts its draws under `query`. A query may be used once: a second use
    /// makes the recording fail.
    pub fn scope(
        &self,
        commands: &Commands,
        query: QueryIndex,
        counting: Counting,
        record: impl FnOnce(&Commands),
    ) {
        if commands.check_owner(self).is_err() {
            return;
        }
        match self.page(query.0) {
            Some(page) => {
                page.pool.scope(
                    commands,
                    query.0 % PAGE,
                    counting,
                    &self.recorded,
                    query.0,
                    record,
                );
            }
            // The query was not taken for this frame, so the draw is recorded without it.
            None => record(commands),
        }
    }

    /// Copies the results of `queries` to mapped memory. Must be called outside of rendering. The
    /// recording fails unless all of them were recorded in this frame.
    pub fn read_back(&self, commands: &Commands, queries: Range<u32>) {
        if commands.check_owner(self).is_err()
            || !check_recorded(commands, &self.recorded, queries.clone())
        {
            return;
        }
        let mut first = queries.start;
        while first < queries.end {
            let last = queries.end.min((first / PAGE + 1) * PAGE);
            let Some(page) = self.page(first) else { break };
            let start = first % PAGE;
            let count = last - first;
            let bytes = |results: u32| u64::from(results) * RESULT_BYTES;
            let to = page.mapped.whole().part(bytes(start), bytes(count));
            page.pool.copy_results(commands, start..start + count, to);
            first = last;
        }
        if !queries.is_empty() {
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
        }
    }

    /// Returns the result of `query`, which is valid once the tick of its piece is over; 0 for a
    /// query that was never taken.
    pub fn samples(&self, query: QueryIndex) -> u32 {
        let result = (query.0 % PAGE) as usize;
        let results =
            self.page(query.0).map_or(&[][..], |page| page.mapped.read(result..result + 1));
        results.first().copied().unwrap_or(0)
    }

    fn page(&self, query: u32) -> Option<&Page> {
        let pages = &self.ring.current().memory;
        pages.get((query / PAGE) as usize).filter(|_| query < self.recorded.count())
    }
}

impl Page {
    fn new(device: &Device, name: &str) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let size_bytes = u64::from(PAGE) * RESULT_BYTES;
        let mapped = Buffer::new(device, name, size_bytes, usage, MemoryKind::ReadBack)?;
        Ok(Self { pool: OcclusionPool::new(device, PAGE, name)?, mapped })
    }
}
