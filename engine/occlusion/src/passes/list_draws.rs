//! The list passes, which write the revealed draws into lists, in order and without gaps.

use bytemuck::{Pod, Zeroable};
use gpu::{
    Access, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, ResultSource,
    StorageLayout,
};

use crate::error::Error;
use crate::shader_set::ShaderSet;

/// The passes that turn the results of tests into lists of draws. The first counts the draws of
/// each range, the second adds up the draws of the ranges before it, and the third writes the
/// draws.
pub struct ListDrawsPass {
    sizes: ComputePipeline,
    places: ComputePipeline,
    draws: ComputePipeline,
    /// The most workgroups of a dispatch.
    groups_max: u32,
}

/// The buffers of the passes. Ranges, draws and results are read; sizes, commands and counts are
/// written.
#[derive(Clone, Copy)]
pub struct ListDrawsIo {
    /// A [`ListedRange`] per range. The ranges of a list are contiguous.
    pub ranges: BufferSlice,
    /// The first range to list, which is the first range of a list.
    pub first: u32,
    /// The end of the ranges to list: one more than the last range of a list.
    pub end: u32,
    /// All draws of the scene.
    pub draws: BufferSlice,
    /// The copy of all draws in which fragments of boxes set instance counts, if there is one.
    pub enabled: Option<BufferSlice>,
    /// The results of each [`ResultSource`], if the source has any.
    pub results: [Option<BufferSlice>; ResultSource::ALL.len()],
    /// The number of samples that a result must exceed.
    pub threshold_samples: u32,
    /// [`RANGE_SIZE_BYTES`] per range: the number of its draws, and of the draws before it.
    pub sizes: BufferSlice,
    /// The commands of all lists.
    pub commands: BufferSlice,
    /// The number of commands of each list.
    pub counts: BufferSlice,
}

/// The bytes of [`ListDrawsIo::sizes`] per range; mirrors `listed.glsl`.
pub const RANGE_SIZE_BYTES: u64 = 8;

/// A range of draws that a result decides about, as the shaders read it; mirrors `listed.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ListedRange {
    /// The first draw among all draws of the scene.
    pub first: u32,
    /// The number of draws, including empty ones.
    pub count: u32,
    /// The number of the [`ResultSource`] that the result comes from.
    pub source: u32,
    /// The index of the result among the results of its source.
    pub result: u32,
    /// 1 for draws that fragments of boxes enable, else 0.
    pub is_enabled: u32,
    /// The number of the list.
    pub list: u32,
    /// The index of the first range of the list.
    pub first_of_list: u32,
    /// The place of the list among the commands of all lists.
    pub first_command: u32,
}

/// Mirrors `list_sizes.comp`, `list_places.comp` and `list_draws.comp`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    first: u32,
    end: u32,
    threshold_samples: u32,
}

impl ListDrawsPass {
    /// Compiles the passes.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let pipeline = |name, buffers| -> Result<ComputePipeline, Error> {
            let storage = StorageLayout::new::<Constants>(buffers);
            Ok(ComputePipeline::new(device, name, shaders.find(name)?, storage)?)
        };
        let groups_max = device.adapter().limits.max_compute_work_group_count[0].max(1);
        Ok(Self {
            sizes: pipeline("list_sizes.comp", 7)?,
            places: pipeline("list_places.comp", 1)?,
            draws: pipeline("list_draws.comp", 6)?,
            groups_max,
        })
    }

    /// Writes the lists, for indirect draws in any later command on the queue. All results must
    /// have been written by earlier commands, which this call waits for. Later tests may write
    /// other results to the same buffers. Outside of rendering.
    pub fn record(&self, commands: &Commands, io: &ListDrawsIo) {
        let between = MemoryBarrier::between;
        // Results and enabled draws; draws whose instances a compute pass decided; cleared lists.
        // Other lists of the same buffers may still be drawn.
        let written =
            [Access::FragmentWrite, Access::ComputeWrite, Access::CopyWrite, Access::IndirectRead];
        commands.barrier(between(&written, &[Access::ComputeRead, Access::ComputeWrite]));
        // Buffers that are missing are not read, since no range refers to them.
        let enabled = io.enabled.unwrap_or(io.draws);
        let [queries, fragments, computed] = io.results.map(|result| result.unwrap_or(io.ranges));
        commands.bind_compute(
            &self.sizes,
            &[io.ranges, io.draws, enabled, queries, fragments, computed, io.sizes],
        );
        self.dispatch(commands, &self.sizes, io);
        commands.barrier(between(
            &[Access::ComputeWrite],
            &[Access::ComputeRead, Access::ComputeWrite],
        ));
        commands.bind_compute(&self.places, &[io.sizes]);
        let ListDrawsIo { first, end, threshold_samples, .. } = *io;
        let constants = Constants { first, end, threshold_samples };
        commands.push_compute_constants(&self.places, &constants);
        commands.dispatch([1, 1, 1]);
        commands.barrier(between(&[Access::ComputeWrite], &[Access::ComputeRead]));
        commands.bind_compute(
            &self.draws,
            &[io.ranges, io.draws, enabled, io.sizes, io.commands, io.counts],
        );
        self.dispatch(commands, &self.draws, io);
        commands.barrier(between(
            &[Access::ComputeWrite, Access::ComputeRead],
            &[Access::IndirectRead, Access::CopyWrite, Access::CopyRead, Access::FragmentWrite],
        ));
    }

    /// Dispatches a workgroup per range.
    fn dispatch(&self, commands: &Commands, pipeline: &ComputePipeline, io: &ListDrawsIo) {
        let ListDrawsIo { end, threshold_samples, .. } = *io;
        for first in (io.first..end).step_by(self.groups_max as usize) {
            commands.push_compute_constants(pipeline, &Constants { first, end, threshold_samples });
            commands.dispatch([(end - first).min(self.groups_max), 1, 1]);
        }
    }
}
