//! Occlusion queries of a frame that is sent off in pieces: the answers to a piece are read while the
//! frame goes on.
//!
//! Each piece copies its results to mapped memory, and they are believed once its tick is over: the
//! CPU polls or waits for ticks only. Queries are numbered over the whole frame; pages of them are
//! made as a frame asks for more and are kept for the frames that use the slot later.

use std::ops::Range;

use ash::vk;

use crate::access::{Access, MemoryBarrier};
use crate::buffer::{Buffer, Place};
use crate::commands::{Commands, Failure};
use crate::deletion::Garbage;
use crate::device::Device;
use crate::error::{Called, Error};
use crate::frames::SlotIndex;
use crate::ownership::of_device;
use crate::query_ring::{NEVER_RECORDED, QueryIndex, RECORDED_TWICE};
use crate::recorded::Recorded;

/// What an answer says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counting {
    /// Whether some samples passed: any number but 0 for "some".
    Some,
    /// How many, where the device has [`crate::Optional::PreciseQueries`].
    Samples,
}

/// Occlusion queries for frames of several pieces.
pub struct QueryPages {
    device: Device,
    slots: Vec<Vec<Page>>,
    recording: usize,
    /// Queries of the frame being recorded.
    recorded: Recorded,
    name: String,
}

/// A pool, and mapped memory for its results.
struct Page {
    device: Device,
    pool: vk::QueryPool,
    readback: Buffer,
}

/// Queries of one page.
const PAGE: u32 = 256;
const WORD_BYTES: u64 = 4;

of_device!(QueryPages: "query pages (`QueryPages`)");

impl QueryPages {
    /// None yet, for `frames_in_flight` frames.
    pub fn new(device: &Device, frames_in_flight: usize, name: &str) -> Self {
        Self {
            device: device.clone(),
            slots: (0..frames_in_flight.max(1)).map(|_| Vec::new()).collect(),
            recording: 0,
            recorded: Recorded::default(),
            name: name.to_owned(),
        }
    }

    /// Begins a frame in `slot`: its queries are numbered from 0.
    pub fn begin(&mut self, slot: SlotIndex) {
        self.recording = slot.0 % self.slots.len();
        self.recorded.restart(0);
    }

    /// Takes `count` more queries, to be used in this piece. Outside of rendering.
    ///
    /// # Errors
    /// [`Error::Foreign`] for commands of another device, which fail; no memory, or a failed call.
    pub fn take(&mut self, commands: &Commands, count: u32) -> Result<Range<u32>, Error> {
        commands.admit(self)?;
        let used = self.recorded.count();
        let taken = used..used.saturating_add(count);
        let Some(pages) = self.slots.get_mut(self.recording) else { return Ok(taken) };
        // The pages that this frame comes to for the first time.
        for number in used.div_ceil(PAGE)..taken.end.div_ceil(PAGE) {
            if number as usize == pages.len() {
                let name = format!("{} {}, page {number}", self.name, self.recording);
                pages.push(Page::new(&self.device, &name)?);
            }
            let Some(page) = pages.get(number as usize) else { break };
            // SAFETY: the slot's earlier frame is over, so none of the page's queries is in use.
            unsafe {
                self.device.raw().cmd_reset_query_pool(commands.raw(), page.pool, 0, PAGE);
            }
        }
        self.recorded.grow(taken.end);
        Ok(taken)
    }

    /// Records what `record` draws under `query`, which is used once: a second time makes the recording
    /// fail.
    pub fn scope(
        &self,
        commands: &Commands,
        query: QueryIndex,
        counting: Counting,
        record: impl FnOnce(&Commands),
    ) {
        if commands.admit(self).is_err() {
            return;
        }
        match self.page(query.0) {
            Some(_) if !self.recorded.note(query.0) => {
                commands.fail(Failure::Wrong(RECORDED_TWICE));
            }
            Some(page) => {
                commands.query(page.pool, QueryIndex(query.0 % PAGE), counting, record);
            }
            // Not taken for this frame: draw without asking.
            None => record(commands),
        }
    }

    /// Copies the results of `queries`, all of them recorded in this frame, or the recording fails, to
    /// mapped memory. Outside of rendering.
    pub fn read_back(&self, commands: &Commands, queries: Range<u32>) {
        if commands.admit(self).is_err() {
            return;
        }
        if !self.recorded.has_all(queries.clone()) {
            commands.fail(Failure::Wrong(NEVER_RECORDED));
            return;
        }
        let mut first = queries.start;
        while first < queries.end {
            let last = queries.end.min((first / PAGE + 1) * PAGE);
            let Some(page) = self.page(first) else { break };
            let to = page.readback.whole();
            // WAIT is the GPU's own wait for its earlier commands, not the CPU's.
            let flags = vk::QueryResultFlags::WAIT;
            // SAFETY: the queries were begun and ended earlier in this frame; the buffer has a
            // word for each.
            unsafe {
                commands.device().raw().cmd_copy_query_pool_results(
                    commands.raw(),
                    page.pool,
                    first % PAGE,
                    last - first,
                    to.raw,
                    to.offset_bytes + u64::from(first % PAGE) * WORD_BYTES,
                    WORD_BYTES,
                    flags,
                );
            }
            first = last;
        }
        if !queries.is_empty() {
            commands.barrier(MemoryBarrier::between(&[Access::CopyWrite], &[Access::HostRead]));
        }
    }

    /// The answer to `query`, once the tick of its piece is over; 0 for one that was never taken.
    pub fn samples(&self, query: QueryIndex) -> u32 {
        let word = (query.0 % PAGE) as usize;
        let words = self.page(query.0).map_or(&[][..], |page| page.readback.read(word..word + 1));
        words.first().copied().unwrap_or(0)
    }

    fn page(&self, query: u32) -> Option<&Page> {
        let pages = self.slots.get(self.recording)?;
        pages.get((query / PAGE) as usize).filter(|_| query < self.recorded.count())
    }
}

impl Page {
    fn new(device: &Device, name: &str) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let size_bytes = u64::from(PAGE) * WORD_BYTES;
        let readback = Buffer::new(device, name, size_bytes, usage, Place::ReadBack)?;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::OCCLUSION)
            .query_count(PAGE);
        // SAFETY: a plain query pool.
        let pool =
            unsafe { device.raw().create_query_pool(&info, None) }.called("vkCreateQueryPool")?;
        device.name(pool, name);
        Ok(Self { device: device.clone(), pool, readback })
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.device.retire(Garbage::QueryPool(self.pool));
    }
}
