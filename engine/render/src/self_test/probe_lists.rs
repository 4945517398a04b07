//! The lists of the probe: its decided ranges, compacted into one list of draws.

use gpu::{
    Buffer, BufferSlice, Device, Frame, IndirectDraw, MemoryKind, PredicatedRange, Predicates,
    ResultSource, vk,
};
use occlusion::{ListDrawsIo, ListDrawsPass, ListedRange, RANGE_SIZE_BYTES, ShaderSet};

use super::probe_scene::PROBES;
use crate::error::Error;

/// The passes that compact the draws of the probe, and the memory of their list.
pub(super) struct ProbeLists {
    pub(super) pass: ListDrawsPass,
    commands: Buffer,
    count: Buffer,
    sizes: Buffer,
}

impl ProbeLists {
    /// Compiles the passes and makes room for all draws.
    pub(super) fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER;
        let buffer = |name, bytes| Buffer::new(device, name, bytes, usage, MemoryKind::Device);
        let draws = PROBES as u64;
        Ok(Self {
            pass: ListDrawsPass::new(device, shaders)?,
            commands: buffer("self-test list", draws * size_of::<IndirectDraw>() as u64)?,
            count: buffer("self-test list count", 4)?,
            sizes: buffer("self-test list sizes", draws * RANGE_SIZE_BYTES)?,
        })
    }

    /// Returns the buffers of the passes, for one list of all ranges that results of `source`
    /// decide about.
    pub(super) fn io(
        &self,
        frame: &mut Frame<'_>,
        decided: &[PredicatedRange],
        source: ResultSource,
        results: Option<BufferSlice>,
        predicates: &Predicates,
    ) -> Result<ListDrawsIo, Error> {
        let listed = |predicated_range: &PredicatedRange| ListedRange {
            first: predicated_range.range.first,
            count: predicated_range.range.count,
            source: source as u32,
            result: predicated_range.result,
            is_enabled: 0,
            list: 0,
            first_of_list: 0,
            first_command: 0,
        };
        let ranges: Vec<ListedRange> = decided.iter().map(listed).collect();
        Ok(ListDrawsIo {
            ranges: frame.uploads().push(&ranges)?,
            first: 0,
            end: ranges.len() as u32,
            draws: predicates.draws(),
            enabled: None,
            results: ResultSource::ALL.map(|wanted| results.filter(|_| wanted == source)),
            threshold_samples: 0,
            sizes: self.sizes.whole(),
            commands: self.commands.whole(),
            counts: self.count.whole(),
        })
    }
}
