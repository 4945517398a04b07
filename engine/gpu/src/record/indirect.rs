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
    /// The first instance: the number that the shader has of it.
    pub first_instance: u32,
}

/// One draw without indices as the GPU reads it (`VkDrawIndirectCommand`, 16 bytes).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
pub struct UnindexedDraw {
    /// The number of vertices to draw.
    pub vertex_count: u32,
    /// The number of instances; 0 draws nothing.
    pub instance_count: u32,
    /// The first vertex.
    pub first_vertex: u32,
    /// The first instance: the number that the shader has of it.
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

/// The next draw of the same leaf as the GPU reads it, where leaves have any number of draws;
/// mirrors `draw_link.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct DrawLink {
    /// One more than the number of the next draw, or [`DrawLink::NO_DRAW`].
    pub next: u32,
    /// The instances of this one once it is enabled; 0 only where there is no draw.
    pub instance_count: u32,
}

impl DrawLink {
    /// The end of a list. It is 0 for lavapipe (Mesa 22.3), which follows a list also for fragments
    /// that take no part, up to its limit of 65535 steps: what these load is 0.
    pub const NO_DRAW: u32 = 0;

    /// The link of a place without a draw.
    pub const EMPTY: Self = Self { next: Self::NO_DRAW, instance_count: 0 };
}
