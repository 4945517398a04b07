//! Indirect draws as they lie in GPU memory, and ranges of them.

use bytemuck::{Pod, Zeroable};

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

/// Bytes of one draw.
pub(crate) const DRAW_BYTES: u64 = size_of::<IndirectDraw>() as u64;

/// A contiguous range of indirect draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DrawRange {
    /// The first draw.
    pub first: u32,
    /// How many.
    pub count: u32,
}
