//! Predicates: ranges of draws that the GPU skips if a test found nothing visible.
//!
//! A test writes a result that is zero or not zero; there are several writers ([`ResultSource`]).
//! The same plan runs on every device, with one of four executors. They differ in how they use the
//! result:
//!
//! - [`PredicationMode::Conditional`]: the result is the predicate of conditional rendering.
//! - [`PredicationMode::Counts`]: a compute pass converts it to a draw count, 0 or all.
//!   [`PredicationMode::Compacted`] does the same, and its user draws lists of ranges.
//! - [`PredicationMode::Instances`]: a compute pass writes it to the instance count of every draw
//!   of the range. For devices with neither extension nor draw counts (SwiftShader). Its cost on
//!   the GPU grows with the size of the ranges, not only with their number.

mod decisions;
mod predicate_list;

use std::ops::Range;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::core::device::Device;
use crate::core::error::Error;
use crate::core::frames_in_flight::check_frames_in_flight;
use crate::core::ownership::of_device;
use crate::memory::buffer::{Buffer, BufferSlice, MemoryKind};
use crate::record::access::{Access, MemoryBarrier};
use crate::record::commands::{Commands, Failure};
use crate::record::frames::Frame;
use crate::record::indirect::{DrawLink, DrawRange, IndirectDraw};
use crate::record::pipeline::{ComputePipeline, StorageLayout};
use crate::record::shader::{SpecializationConstant, Spirv};
pub use decisions::{Predicate, PredicatedRange, PredicationMode, ResultSource, Reveal};
pub use predicate_list::BOX_VERTICES;
use predicate_list::PredicateList;

/// The usage of the buffer of all draws. Tests read the decisions back.
const DRAW_USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::INDIRECT_BUFFER.as_raw()
        | vk::BufferUsageFlags::STORAGE_BUFFER.as_raw()
        | vk::BufferUsageFlags::TRANSFER_SRC.as_raw()
        | vk::BufferUsageFlags::TRANSFER_DST.as_raw(),
);

/// The specialisation constant of shaders for linked draws; mirrors `draw_link.glsl`.
pub const LINKED: u32 = 14;

/// All draws of a scene, in GPU memory, drawn range by range under predicates.
pub struct Predicates {
    device: Device,
    predication: PredicationMode,
    /// True if no other predicates draw by counts before these in the same commands.
    is_alone: bool,
    draws: Buffer,
    links: Option<Buffer>,
    writer: Option<ComputePipeline>,
    // A result that enables all draws, as a predicate and for `Commands::draw_all_indirect`.
    all: Buffer,
    lists: [PredicateList; ResultSource::ALL.len()],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Decisions {
    first: u32,
    count: u32,
    threshold: u32,
}

of_device!(Predicates: "predicates (`Predicates`)");

impl Predicates {
    /// Uploads `draws`, one per leaf with one instance each, and prepares `predication` (if `None`,
    /// the device's best for this number of draws).
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device lacks a feature of `predication`; [`Error::TooLarge`]
    /// for more draws than a draw count can hold; no memory; a failed call.
    pub fn new(
        device: &Device,
        predication: Option<PredicationMode>,
        draws: &[IndirectDraw],
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        let predication = PredicationMode::choose(device, predication, draws.len() as u64, 0)?;
        let draws = device.upload("indirect draws", draws, DRAW_USAGE)?;
        Self::over(device, predication, draws, None, frames_in_flight)
    }

    /// Prepares `predication` (if `None`, the device's best for this number of draws) for `count`
    /// linked draws: any number per leaf, with any number of instances. The draws and their
    /// [links](Predicates::links) are undefined until they are written.
    ///
    /// # Errors
    /// The errors of [`Predicates::new`].
    pub fn linked(
        device: &Device,
        predication: Option<PredicationMode>,
        count: u32,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        let predication = PredicationMode::choose(device, predication, count.into(), 0)?;
        let [draws, links] = linked_buffers(device, count)?;
        Self::over(device, predication, draws, Some(links), frames_in_flight)
    }

    /// Prepares `predication` (if `None`, the device's best) for `count` draws of one instance,
    /// which are undefined until they are written. Other predicates may draw before these.
    ///
    /// # Errors
    /// The errors of [`Predicates::new`].
    pub fn unlinked(
        device: &Device,
        predication: Option<PredicationMode>,
        count: u32,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        let predication = PredicationMode::choose(device, predication, count.into(), 0)?;
        let draw_commands = draw_buffer(device, count)?;
        Ok(Self {
            is_alone: false,
            ..Self::over(device, predication, draw_commands, None, frames_in_flight)?
        })
    }

    fn over(
        device: &Device,
        predication: PredicationMode,
        draws: Buffer,
        links: Option<Buffer>,
        frames_in_flight: usize,
    ) -> Result<Self, Error> {
        check_frames_in_flight(frames_in_flight)?;
        let shader = match predication {
            PredicationMode::Conditional => None,
            PredicationMode::Instances => Some(shaders::PREDICATE_INSTANCES),
            _ => Some(shaders::PREDICATE_COUNTS),
        };
        let buffers = writer_buffers(predication) as u32;
        let storage = StorageLayout::new::<Decisions>(buffers);
        let writer = match shader {
            None => None,
            Some(shader) => {
                let spirv = Spirv::from_bytes(shader.name, shader.spirv)?;
                let value = u32::from(links.is_some());
                let spirv = spirv.specialised(&[SpecializationConstant { id: LINKED, value }]);
                Some(ComputePipeline::new(device, shader.name, &spirv, storage)?)
            }
        };
        let most = [device.adapter().limits.max_draw_indirect_count.max(1)];
        let mut all_usage =
            vk::BufferUsageFlags::INDIRECT_BUFFER | vk::BufferUsageFlags::STORAGE_BUFFER;
        if device.conditional().is_some() {
            all_usage |= vk::BufferUsageFlags::CONDITIONAL_RENDERING_EXT;
        }
        Ok(Self {
            device: device.clone(),
            predication,
            is_alone: true,
            all: device.upload("all draws", &most, all_usage)?,
            draws,
            links,
            writer,
            lists: std::array::from_fn(|_| PredicateList::new(frames_in_flight)),
        })
    }

    /// Makes room for `count` draws, which stay linked or unlinked. All of them are then undefined.
    /// Does not wait.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more draws than a draw count can hold; no memory; a failed call.
    pub fn grow(&mut self, count: u32) -> Result<(), Error> {
        PredicationMode::choose(&self.device, Some(self.predication), count.into(), 0)?;
        if self.links.is_some() {
            let [draws, links] = linked_buffers(&self.device, count)?;
            (self.draws, self.links) = (draws, Some(links));
        } else {
            self.draws = draw_buffer(&self.device, count)?;
        }
        Ok(())
    }

    /// Changes the number of frames in flight.
    pub fn set_frames_in_flight(&mut self, frames_in_flight: usize) {
        self.lists = std::array::from_fn(|_| PredicateList::new(frames_in_flight));
    }

    /// Returns all draws in GPU memory, which may be changed between frames.
    /// [`PredicationMode::Instances`] changes their instance counts.
    pub fn draws(&self) -> BufferSlice {
        self.draws.whole()
    }

    /// Returns the [`DrawLink`] of each draw in GPU memory, if draws are linked. The links may be
    /// changed between frames.
    pub fn links(&self) -> Option<BufferSlice> {
        self.links.as_ref().map(Buffer::whole)
    }

    /// Returns the executor in use.
    pub fn predication(&self) -> PredicationMode {
        self.predication
    }

    /// Begins a frame with the decisions that depend on the results of `source`. Must be called
    /// once per frame and source. Without `results` all ranges are drawn.
    ///
    /// # Errors
    /// [`Error::Foreign`] for a frame or results of another device, which then fails; no memory.
    pub fn begin(
        &mut self,
        frame: &mut Frame<'_>,
        source: ResultSource,
        results: Option<BufferSlice>,
        decided: impl ExactSizeIterator<Item = PredicatedRange>,
    ) -> Result<(), Error> {
        frame.commands().check_owner(self)?;
        results.map_or(Ok(()), |results| frame.commands().check_owner(&results))?;
        let counts = self.predication.is_counted();
        let device = &self.device;
        let Some(list) = self.lists.get_mut(source as usize) else { return Ok(()) };
        let has_results = results.is_some();
        let decided = decided.map(|decided| PredicatedRange {
            result: decided.result * u32::from(has_results),
            ..decided
        });
        list.begin(frame, results.unwrap_or(self.all.whole()), decided);
        if self.writer.is_some() {
            list.upload(frame, self.predication)?;
        }
        if counts { list.make_counts(device) } else { Ok(()) }
    }

    /// Converts results to predicates; `written` gives a range of the decisions of each source.
    /// Must be called outside of rendering, after the results are written and before the draws that
    /// depend on them.
    ///
    /// Query results up to `threshold_samples` count as zero. Above 0 the queries must
    /// [count](crate::Counting::Samples). The recording fails with
    /// [`PredicationMode::Conditional`], which cannot compare.
    pub fn resolve(
        &self,
        commands: &Commands,
        written: &[(ResultSource, Range<u32>)],
        threshold_samples: u32,
    ) {
        if commands.check_owner(self).is_err() {
            return;
        }
        let between = MemoryBarrier::between;
        // Sources that wrote nothing get an access without effect. An array, because a list on the
        // heap would be allocated in every frame.
        let is_written =
            |source| written.iter().any(|(own, list)| *own == source && !list.is_empty());
        let writes = ResultSource::ALL
            .map(|source| if is_written(source) { source.access() } else { Access::Nothing });
        let Some(writer) = &self.writer else {
            if threshold_samples > 0 {
                commands.fail(Failure::Wrong(
                    "conditional rendering cannot compare samples with a threshold",
                ));
            }
            commands.barrier(between(&writes, &[Access::PredicateRead, Access::ComputeRead]));
            return;
        };
        // Earlier rounds, and earlier frames of other slots, may still read the draws.
        let [queries, fragments, compute] = writes;
        let from = [queries, fragments, compute, Access::IndirectRead, Access::ComputeWrite];
        commands.barrier(between(&from, &[Access::ComputeRead, Access::ComputeWrite]));
        for (source, range) in written.iter().filter(|(_, range)| !range.is_empty()) {
            let list = self.list(*source);
            let output = match self.predication {
                PredicationMode::Instances => Some(self.draws.whole()),
                _ => list.counts(),
            };
            let (Some(on_gpu), Some(results), Some(output)) = (list.on_gpu, list.results, output)
            else {
                continue;
            };
            // The links are only read if draws have them.
            let links = self.links().unwrap_or(on_gpu.decided);
            let lists = [results, on_gpu.decided, output, on_gpu.box_draws, links];
            commands.bind_compute(
                writer,
                lists.get(..writer_buffers(self.predication)).unwrap_or(&lists),
            );
            let threshold = self.threshold_of(*source, results, threshold_samples);
            let per_group = match self.predication {
                PredicationMode::Instances => 1, // a workgroup per decision
                _ => 64,                         // a thread per decision
            };
            let limits = &self.device.adapter().limits;
            let most = limits.max_compute_work_group_count[0].max(1).saturating_mul(per_group);
            let end = range.end.min(list.decided.len() as u32);
            for first in (range.start..end).step_by(most as usize) {
                let count = most.min(end - first);
                commands.push_compute_constants(writer, &Decisions { first, count, threshold });
                commands.dispatch([count.div_ceil(per_group), 1, 1]);
            }
        }
        // The next round writes other results to the buffers just read.
        commands.barrier(between(
            &[Access::ComputeWrite, Access::ComputeRead],
            &[Access::IndirectRead, Access::CopyWrite, Access::CopyRead, Access::FragmentWrite],
        ));
    }

    /// Returns the result of a decision about `leaves`, with the threshold that it was resolved
    /// with. Shaders may read it after [`resolve`](Predicates::resolve) and before results are
    /// written again, with a barrier before these writes.
    pub fn predicate(
        &self,
        source: ResultSource,
        decision: u32,
        leaves: DrawRange,
        threshold_samples: u32,
    ) -> Option<Predicate> {
        let list = self.list(source);
        let PredicatedRange { result, .. } = *list.decided.get(decision as usize)?;
        let results = list.results?;
        let threshold_samples = self.threshold_of(source, results, threshold_samples);
        Some(Predicate { results, result, threshold_samples, leaves })
    }

    /// Returns the threshold for results: 0 for flags, which do not count samples, and for ranges
    /// without a result, which are drawn.
    fn threshold_of(
        &self,
        source: ResultSource,
        results: BufferSlice,
        threshold_samples: u32,
    ) -> u32 {
        let is_counted = source == ResultSource::Queries && results != self.all.whole();
        if is_counted { threshold_samples } else { 0 }
    }

    /// Draws all of `draws` unconditionally. If the executor uses draw counts, these draws also get
    /// a count, because lavapipe (Mesa 22.3, 25.0) reuses the count of the counted draw before a
    /// plain indirect draw in the command buffer.
    pub fn draw_always(&self, commands: &Commands, draws: BufferSlice) {
        if commands.check_owner(self).is_err() {
            return;
        }
        if self.predication.is_counted() {
            self.draw_after_counted(commands, draws)
        } else {
            self.draw_uncounted(commands, draws)
        }
    }

    fn draw_uncounted(&self, commands: &Commands, draws: BufferSlice) {
        if self.is_alone {
            commands.draw_indirect(draws)
        } else {
            self.draw_after_counted(commands, draws)
        }
    }

    /// Draws all of `draws` unconditionally if earlier draws may have had a count, with any
    /// executor.
    pub fn draw_after_counted(&self, commands: &Commands, draws: BufferSlice) {
        if commands.check_owner(self).is_err() {
            return;
        }
        commands.draw_all_indirect(draws, self.all.whole());
    }

    /// Draws the range of a decision if its result is not zero.
    pub fn draw(&self, commands: &Commands, source: ResultSource, decision: u32) {
        self.draw_enabled(commands, source, decision, self.draws.whole());
    }

    /// Draws the range of a decision from `draws` if the result is not zero. `draws` has a copy of
    /// every draw, with an instance count of 0 if the box of its leaf was not visible.
    pub fn draw_enabled(
        &self,
        commands: &Commands,
        source: ResultSource,
        decision: u32,
        draws: BufferSlice,
    ) {
        if commands.check_owner(self).is_err() {
            return;
        }
        let list = self.list(source);
        let Some(&PredicatedRange { result, range, .. }) = list.decided.get(decision as usize)
        else {
            return;
        };
        let draws = draws.elements::<IndirectDraw>(range.first..range.first + range.count);
        match self.predication {
            PredicationMode::Instances => self.draw_uncounted(commands, draws),
            PredicationMode::Counts | PredicationMode::Compacted => {
                if let Some(count) = list.count(decision) {
                    commands.draw_indirect_count(draws, count);
                }
            }
            PredicationMode::Conditional => {
                self.conditionally(commands, list, result, |commands| {
                    self.draw_uncounted(commands, draws);
                });
            }
        }
    }

    /// Draws [`BOX_VERTICES`] vertices per leaf in the range of a decision if the result is not
    /// zero. The instance index is the index of the leaf.
    pub fn draw_boxes(&self, commands: &Commands, source: ResultSource, decision: u32) {
        if commands.check_owner(self).is_err() {
            return;
        }
        let list = self.list(source);
        let Some(&PredicatedRange { result, range, .. }) = list.decided.get(decision as usize)
        else {
            return;
        };
        match (list.on_gpu, self.predication.is_counted()) {
            (Some(on_gpu), true) => {
                // Not a plain indirect draw, because Mesa 22.3's lavapipe reuses the count of the
                // last counted draw.
                if let Some(count) = list.count(decision) {
                    commands.draw_unindexed_indirect_count(
                        predicate_list::box_draw(on_gpu, decision),
                        count,
                    );
                }
            }
            (Some(on_gpu), _) => {
                commands.draw_unindexed_indirect(predicate_list::box_draw(on_gpu, decision))
            }
            (None, _) => self.conditionally(commands, list, result, |commands| {
                commands.draw_instances(BOX_VERTICES, range.first..range.first + range.count);
            }),
        }
    }

    /// Records `record` so that the GPU skips it if the result is zero.
    fn conditionally(
        &self,
        commands: &Commands,
        list: &PredicateList,
        result: u32,
        record: impl FnOnce(&Commands),
    ) {
        let (Some(conditional), Some(results)) = (self.device.conditional(), list.results) else {
            record(commands);
            return;
        };
        let info = vk::ConditionalRenderingBeginInfoEXT::default()
            .buffer(results.raw)
            .offset(results.offset_bytes + u64::from(result) * 4);
        // SAFETY: the extension is enabled; ash 0.38 has only the raw pointers. The results outlive
        // the frame.
        unsafe {
            (conditional.fp().cmd_begin_conditional_rendering_ext)(commands.raw(), &raw const info);
        }
        record(commands);
        // SAFETY: closes the block opened above.
        unsafe {
            (conditional.fp().cmd_end_conditional_rendering_ext)(commands.raw());
        }
    }

    fn list(&self, source: ResultSource) -> &PredicateList {
        &self.lists[source as usize]
    }
}

fn linked_buffers(device: &Device, count: u32) -> Result<[Buffer; 2], Error> {
    let links = u64::from(count) * size_of::<DrawLink>() as u64;
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
    Ok([
        draw_buffer(device, count)?,
        Buffer::new(device, "draw links", links, usage, MemoryKind::Device)?,
    ])
}

fn draw_buffer(device: &Device, count: u32) -> Result<Buffer, Error> {
    let wanted = u64::from(count) * IndirectDraw::BYTES;
    let limit = device.adapter().limits;
    let limit = u64::from(limit.max_storage_buffer_range);
    if wanted > limit {
        let what = "the bytes of all draws".to_owned();
        return Err(Error::TooLarge { what, wanted, limit });
    }
    Buffer::new(device, "indirect draws", wanted, DRAW_USAGE, MemoryKind::Device)
}

/// Returns the number of storage buffers of the compute shader: results, decisions, counts or
/// draws, and, if it writes instance counts, box draws and links.
fn writer_buffers(predication: PredicationMode) -> usize {
    match predication {
        PredicationMode::Instances => 5,
        _ => 3,
    }
}
