//! Indirect draws in the layout of GPU memory, and ranges of them.

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
    /// The first instance, which is the instance index in the shader.
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
    /// The first instance, which is the instance index in the shader.
    pub first_instance: u32,
}

impl IndirectDraw {
    /// The size of one draw in bytes.
    pub const BYTES: u64 = size_of::<Self>() as u64;
}

/// A contiguous range of indirect draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DrawRange {
    /// The first draw.
    pub first: u32,
    /// The number of draws.
    pub count: u32,
}

/// The link to the next draw of the same leaf, as the GPU reads it, if leaves have any number of
/// draws. Mirrors `draw_link.glsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct DrawLink {
    /// The index of the next draw plus one, or [`DrawLink::NO_DRAW`].
    pub next: u32,
    /// The instance count of this draw when it is enabled; 0 only if there is no draw.
    pub instance_count: u32,
}

impl DrawLink {
    /// The end of a list. It must be 0 for lavapipe (Mesa 22.3), which follows a list even for
    /// inactive fragments, up to its limit of 65535 steps: inactive fragments load 0.
    pub const NO_DRAW: u32 = 0;

    /// The link of an entry without a draw.
    pub const EMPTY: Self = Self { next: Self::NO_DRAW, instance_count: 0 };
}
