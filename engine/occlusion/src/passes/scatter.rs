//! The scatter pass: updates per-leaf arrays on the GPU where leaves changed, at a cost in
//! proportion to the changes.

use bytemuck::{Pod, Zeroable};
use gpu::{Access, BufferSlice, Commands, ComputePipeline, Device, MemoryBarrier, StorageLayout};

use crate::error::Error;
use crate::shader_set::ShaderSet;

/// The pass that writes elements of arrays with one element per leaf.
pub struct ScatterPass {
    pipeline: ComputePipeline,
}

/// The buffers of the pass. Leaves and elements are read; the array is written.
#[derive(Clone, Copy)]
pub struct ScatterIo {
    /// The leaf of each new element, 32 bits per leaf.
    pub leaves: BufferSlice,
    /// The new elements, in the order of `leaves`.
    pub elements: BufferSlice,
    /// All elements, by leaf.
    pub array: BufferSlice,
    /// The size of an element in bytes, a multiple of 4.
    pub element_bytes: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    element_values: u32,
    value_count: u32,
}

const GROUP_THREADS: u32 = 64;

/// The highest number of workgroups. More are not faster, and every device allows 65535.
const GROUPS_MAX: u32 = 4096;

/// The accesses that may read a per-leaf array.
const USES: [Access; 5] = [
    Access::VertexRead,
    Access::FragmentRead,
    Access::IndirectRead,
    Access::ComputeRead,
    Access::ComputeWrite,
];

impl ScatterPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A failed call.
    pub fn new(device: &Device, shaders: &ShaderSet) -> Result<Self, Error> {
        let storage = StorageLayout::new::<Constants>(3);
        let name = "scatter.comp";
        Ok(Self { pipeline: ComputePipeline::new(device, name, shaders.find(name)?, storage)? })
    }

    /// Writes `count` new elements into each array. Commands that were recorded earlier, in this
    /// frame or another, still read the old elements: all run on one queue, so an execution barrier
    /// is enough.
    pub fn record(
        &self,
        commands: &Commands,
        count: u32,
        arrays: impl IntoIterator<Item = ScatterIo>,
    ) {
        commands.pass("upload changes", |commands| {
            commands.barrier(MemoryBarrier::between(&USES, &[Access::ComputeWrite]));
            for io in arrays {
                let element_values = (io.element_bytes / size_of::<u32>()) as u32;
                let value_count = count.saturating_mul(element_values);
                commands.bind_compute(&self.pipeline, &[io.leaves, io.elements, io.array]);
                let constants = Constants { element_values, value_count };
                commands.push_compute_constants(&self.pipeline, &constants);
                let groups = value_count.div_ceil(GROUP_THREADS).clamp(1, GROUPS_MAX);
                commands.dispatch([groups, 1, 1]);
            }
            commands.barrier(MemoryBarrier::between(&[Access::ComputeWrite], &USES));
        });
    }
}
