//! The decisions that depend on one source of results in one frame, and the buffers of the
//! executors for them.

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::decisions::{PredicatedRange, PredicationMode};
use crate::core::device::Device;
use crate::core::error::Error;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
use crate::record::frames::Frame;

/// The results of one source, and the ranges that depend on them.
pub(super) struct PredicateList {
    pub(super) results: Option<BufferSlice>,
    pub(super) decided: Vec<PredicatedRange>,
    /// The lists for executors that turn results into counts.
    pub(super) on_gpu: Option<OnGpu>,
    slot: usize,
    /// Draw counts: one buffer per frame slot.
    counts: Vec<Option<Buffer>>,
}

/// The lists of a frame for executors with a compute pass.
#[derive(Clone, Copy)]
pub(super) struct OnGpu {
    /// One [`DecidedOnGpu`] per decision.
    pub(super) decided: BufferSlice,
    /// One [`BoxDraw`] per decision.
    pub(super) box_draws: BufferSlice,
}

/// The decision of `predicate.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct DecidedOnGpu {
    first: u32,
    count: u32,
    reveal: u32,
    result: u32,
}

/// The layout of `VkDrawIndirectCommand`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct BoxDraw {
    vertex_count: u32,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
}

const _: () = assert!(size_of::<BoxDraw>() == size_of::<vk::DrawIndirectCommand>());

/// The vertices of the front of a box: three faces of two triangles.
pub const BOX_VERTICES: u32 = 18;

/// Returns the indirect command that draws the boxes of a decision.
pub(super) fn box_draw(on_gpu: OnGpu, decision: u32) -> BufferSlice {
    on_gpu.box_draws.elements::<BoxDraw>(decision..decision + 1)
}

impl PredicateList {
    pub(super) fn new(frames_in_flight: usize) -> Self {
        Self {
            results: None,
            decided: Vec::new(),
            on_gpu: None,
            slot: 0,
            counts: (0..frames_in_flight.max(1)).map(|_| None).collect(),
        }
    }

    pub(super) fn begin(
        &mut self,
        frame: &Frame<'_>,
        results: BufferSlice,
        decided: impl ExactSizeIterator<Item = PredicatedRange>,
    ) {
        self.slot = frame.slot().0 % self.counts.len();
        self.results = Some(results);
        self.decided.clear();
        self.decided.extend(decided);
        self.on_gpu = None;
    }

    /// Uploads the lists. With draw counts, box draws have all their instances; otherwise they have
    /// none until a shader sets the instance count.
    pub(super) fn upload(
        &mut self,
        frame: &mut Frame<'_>,
        predication: PredicationMode,
    ) -> Result<(), Error> {
        let are_counted = predication.is_counted();
        let decided = self.decided.iter().map(|decided| DecidedOnGpu {
            first: decided.range.first,
            count: decided.range.count,
            reveal: decided.reveal as u32,
            result: decided.result,
        });
        let box_draws = self.decided.iter().map(|decided| BoxDraw {
            vertex_count: BOX_VERTICES,
            instance_count: if are_counted { decided.range.count } else { 0 },
            first_vertex: 0,
            first_instance: decided.range.first,
        });
        self.on_gpu = Some(OnGpu {
            decided: frame.uploads().push_iter(decided)?,
            box_draws: frame.uploads().push_iter(box_draws)?,
        });
        Ok(())
    }

    /// Creates the counts unless there is already one per decision.
    pub(super) fn make_counts(&mut self, device: &Device) -> Result<(), Error> {
        let wanted = self.decided.len().next_power_of_two() as u64 * size_of::<u32>() as u64;
        let Some(counts) = self.counts.get_mut(self.slot) else { return Ok(()) };
        if counts.as_ref().is_none_or(|buffer| buffer.size_bytes() < wanted) {
            let usage =
                vk::BufferUsageFlags::INDIRECT_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
            *counts = Some(Buffer::new(device, "draw counts", wanted, usage, MemoryKind::Device)?);
        }
        Ok(())
    }

    pub(super) fn counts(&self) -> Option<BufferSlice> {
        self.counts.get(self.slot)?.as_ref().map(Buffer::whole)
    }

    /// Returns the draw count of a decision: for its range, or for the command that draws its
    /// boxes.
    pub(super) fn count(&self, decision: u32) -> Option<BufferSlice> {
        Some(self.counts()?.elements::<u32>(decision..decision + 1))
    }
}
