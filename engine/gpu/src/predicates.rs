//! Predicates: ranges of draws that the GPU skips by itself when a query saw nothing.
//!
//! The same plan runs on every device, by one of three executors. The word of a query is zero or
//! not; what is done with it differs:
//!
//! - [`Predication::Conditional`]: the word is the predicate of conditional rendering.
//! - [`Predication::Counts`]: a compute pass turns it into a draw count, 0 or all.
//! - [`Predication::Instances`]: a compute pass writes it into the instance count of every draw of
//!   the range. For devices that have neither (SwiftShader); its cost on the GPU grows with the
//!   range, not only with the number of ranges.

use std::ops::Range;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::access::{Access, MemoryBarrier};
use crate::buffer::{Buffer, BufferSlice, Place};
use crate::capabilities::{Capabilities, Optional};
use crate::commands::Commands;
use crate::device::Device;
use crate::error::Error;
use crate::frames::Frame;
use crate::pipeline::{ComputePipeline, StorageLayout};
use crate::shader::Spirv;

/// One indexed draw as the GPU reads it (`VkDrawIndexedIndirectCommand`, 20 bytes).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct IndirectDraw {
    /// Indices to draw.
    pub index_count: u32,
    /// Instances; 0 draws nothing.
    pub instance_count: u32,
    /// Where the indices start.
    pub first_index: u32,
    /// Added to every index.
    pub vertex_offset: i32,
    /// The shader's instance index.
    pub first_instance: u32,
}

const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

/// A contiguous range of indirect draws.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct DrawRange {
    /// The first draw.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// How the GPU is kept from drawing what is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Predication {
    /// `VK_EXT_conditional_rendering`.
    Conditional,
    /// Draw counts written by a compute pass; needs `drawIndirectCount`.
    Counts,
    /// Instance counts written by a compute pass; every device.
    Instances,
}

impl Predication {
    /// The best one for a device.
    pub fn best(capabilities: &Capabilities) -> Self {
        if capabilities.has(Optional::ConditionalRendering) {
            Predication::Conditional
        } else if capabilities.has(Optional::DrawIndirectCount) {
            Predication::Counts
        } else {
            Predication::Instances
        }
    }

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Predication::Conditional => "conditional",
            Predication::Counts => "counts",
            Predication::Instances => "instances",
        }
    }

    fn needs(self) -> Option<Optional> {
        match self {
            Predication::Conditional => Some(Optional::ConditionalRendering),
            Predication::Counts => Some(Optional::DrawIndirectCount),
            Predication::Instances => None,
        }
    }
}

/// All draws of a scene, in GPU memory, drawn range by range under predicates.
pub struct Predicates {
    device: Device,
    predication: Predication,
    draws: Buffer,
    writer: Option<ComputePipeline>,
    // Counts only: one buffer per frame slot.
    counts: Vec<Option<Buffer>>,
    // Counts only: a word that is as large as a count may be.
    all: Option<Buffer>,
    current: Current,
}

/// What belongs to the frame being recorded.
#[derive(Default)]
struct Current {
    slot: usize,
    words: Option<BufferSlice>,
    ranges_on_gpu: Option<BufferSlice>,
    ranges: Vec<DrawRange>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Words {
    first: u32,
    count: u32,
}

impl Predicates {
    /// Uploads `draws` and prepares `predication` (the device's best if `None`).
    ///
    /// # Errors
    /// [`Error::Unsupported`] when the device lacks what `predication` needs; no memory; a failed
    /// call.
    pub fn new(
        device: &Device,
        predication: Option<Predication>,
        draws: &[IndirectDraw],
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        let predication = predication.unwrap_or_else(|| Predication::best(device.capabilities()));
        if let Some(lacking) = predication.needs().filter(|o| !device.capabilities().has(*o)) {
            return Err(Error::Unsupported {
                device: device.adapter().name.clone(),
                missing: lacking.name(),
                wanted: "this way to skip hidden draws",
            });
        }
        let shader: Option<(&str, &[u8])> = match predication {
            Predication::Conditional => None,
            Predication::Counts => Some((
                "predicate_counts.comp",
                include_bytes!("../../../shaders/predicate_counts.comp.spv"),
            )),
            Predication::Instances => Some((
                "predicate_instances.comp",
                include_bytes!("../../../shaders/predicate_instances.comp.spv"),
            )),
        };
        let storage = StorageLayout { buffers: 3, push_bytes: size_of::<Words>() as u32 };
        let writer = match shader {
            None => None,
            Some((name, bytes)) => {
                let spirv = Spirv::from_bytes(name, bytes)?;
                Some(ComputePipeline::new(device, name, &spirv, storage)?)
            }
        };
        let usage = vk::BufferUsageFlags::INDIRECT_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
        let all = match predication {
            Predication::Counts => {
                let most = [device.adapter().limits.max_draw_indirect_count.max(1)];
                Some(device.upload("all draws", &most, vk::BufferUsageFlags::INDIRECT_BUFFER)?)
            }
            _ => None,
        };
        Ok(Self {
            device: device.clone(),
            predication,
            all,
            draws: device.upload("indirect draws", draws, usage)?,
            writer,
            counts: (0..frames_in_flight.max(1)).map(|_| None).collect(),
            current: Current::default(),
        })
    }

    /// The draws, to be changed between frames.
    pub fn draws(&self) -> BufferSlice {
        self.draws.whole()
    }

    /// The executor in use.
    pub fn predication(&self) -> Predication {
        self.predication
    }

    /// Starts a frame: `words` holds one word per query, `ranges[i]` is what word `i` decides.
    ///
    /// # Errors
    /// No memory.
    pub fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        words: Option<BufferSlice>,
        ranges: impl ExactSizeIterator<Item = DrawRange>,
    ) -> Result<(), Error> {
        self.current.slot = frame.slot().0 % self.counts.len();
        self.current.words = words;
        self.current.ranges.clear();
        self.current.ranges.extend(ranges);
        self.current.ranges_on_gpu = None;
        if self.writer.is_some() {
            self.current.ranges_on_gpu = Some(frame.uploads().push(&self.current.ranges)?);
        }
        if self.predication == Predication::Counts
            && let Some(counts) = self.counts.get_mut(self.current.slot)
        {
            let wanted = self.current.ranges.len().next_power_of_two() as u64 * 4;
            if counts.as_ref().is_none_or(|buffer| buffer.size_bytes() < wanted) {
                let usage =
                    vk::BufferUsageFlags::INDIRECT_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
                *counts =
                    Some(Buffer::new(&self.device, "draw counts", wanted, usage, Place::Device)?);
            }
        }
        Ok(())
    }

    /// Makes words `range`, which a copy has just written, decide. Outside of rendering; between
    /// the copy and [`Predicates::draw`].
    pub fn resolve(&self, commands: &Commands, range: Range<u32>) {
        let between = MemoryBarrier::between;
        let Some(writer) = &self.writer else {
            commands.barrier(between(&[Access::CopyWrite], &[Access::PredicateRead]));
            return;
        };
        let written = match self.predication {
            Predication::Counts => self.counts_of_slot(),
            _ => Some(self.draws.whole()),
        };
        let (Some(words), Some(ranges), Some(written)) =
            (self.current.words, self.current.ranges_on_gpu, written)
        else {
            return;
        };
        // Earlier rounds, and earlier frames of other slots, may still read the draws.
        commands.barrier(between(
            &[Access::CopyWrite, Access::IndirectRead, Access::ComputeWrite],
            &[Access::ComputeRead, Access::ComputeWrite],
        ));
        let count = range.end.saturating_sub(range.start);
        commands.bind_compute(writer, &[words, ranges, written]);
        commands.push_compute_constants(writer, &Words { first: range.start, count });
        let groups = match self.predication {
            Predication::Counts => count.div_ceil(64), // a thread per word
            _ => count,                                // a workgroup per word
        };
        commands.dispatch([groups, 1, 1]);
        // The next round's copy writes other words of the buffer just read.
        commands.barrier(between(
            &[Access::ComputeWrite, Access::ComputeRead],
            &[Access::IndirectRead, Access::CopyWrite, Access::CopyRead],
        ));
    }

    /// Draws the range of `word` if the word is not zero.
    pub fn draw(&self, commands: &Commands, word: u32) {
        let Some(range) = self.current.ranges.get(word as usize) else {
            return;
        };
        let bytes = |draws: u32| u64::from(draws) * DRAW_BYTES;
        let draws = self.draws.whole().part(bytes(range.first), bytes(range.count));
        let at = u64::from(word) * 4;
        match self.predication {
            Predication::Instances => commands.draw_indirect(draws),
            Predication::Counts => {
                if let Some(counts) = self.counts_of_slot() {
                    commands.draw_indirect_count(draws, counts.part(at, 4));
                }
            }
            Predication::Conditional => match (self.device.conditional(), self.current.words) {
                (Some(conditional), Some(words)) => {
                    let info = vk::ConditionalRenderingBeginInfoEXT::default()
                        .buffer(words.raw)
                        .offset(words.offset_bytes + at);
                    // SAFETY: the extension is enabled; ash 0.38 has only the raw pointers. The
                    // words outlive the frame.
                    unsafe {
                        let call = conditional.fp().cmd_begin_conditional_rendering_ext;
                        call(commands.raw(), &raw const info);
                    }
                    commands.draw_indirect(draws);
                    // SAFETY: closes what was opened above.
                    unsafe {
                        (conditional.fp().cmd_end_conditional_rendering_ext)(commands.raw());
                    }
                }
                // No words, no answer: what is unknown is drawn.
                _ => commands.draw_indirect(draws),
            },
        }
    }

    /// Draws all of `draws`, whatever any word says. Where some draws are counted these are, too:
    /// lavapipe (Mesa 22.3) lets a plain indirect draw take the count of the counted one before it in
    /// the command buffer.
    pub fn draw_always(&self, commands: &Commands, draws: BufferSlice) {
        let limit = u64::from(self.device.adapter().limits.max_draw_indirect_count);
        match &self.all {
            Some(all) if draws.size_bytes / DRAW_BYTES <= limit => {
                commands.draw_indirect_count(draws, all.whole());
            }
            _ => commands.draw_indirect(draws),
        }
    }

    fn counts_of_slot(&self) -> Option<BufferSlice> {
        self.counts.get(self.current.slot)?.as_ref().map(Buffer::whole)
    }
}
