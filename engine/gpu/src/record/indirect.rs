//! Indirect draws as they lie in GPU memory, and ranges of them.

use bytemuck::{Pod, Zeroable};

/// One indexed draw as the GPU reads it (`VkDrawIndexedIndirectCommand`, 20 bytes).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct IndirectDraw {
    /// The number of indices to draw.
    pub index_count: u32,
    /// The number of instances; 0 draws nothing.
    pub instance_count: u32,
    /// The first index.
    pub first_index: u32,
    /// The number added to every index.
    pub vertex_offset: i32,
    /// The shader's instance index.
    pub first_instance: u32,
}

/// The size of one draw in bytes.
pub(crate) const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

/// A contiguous range of indirect draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DrawRange {
    /// The first draw.
    pub first: u32,
    /// The number of draws.
    pub count: u32,
}
