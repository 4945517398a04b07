//! Recording of draws and dispatches.

use std::ops::Range;

use ash::vk;

use crate::core::capabilities::OptionalFeature;
use crate::memory::buffer::BufferSlice;
use crate::record::commands::{Commands, Failure};
use crate::record::indirect::IndirectDraw;

/// The stride of indirect commands without indices, in bytes.
const UNINDEXED_STRIDE: u32 = size_of::<vk::DrawIndirectCommand>() as u32;

impl Commands {
    /// Draws `vertices` vertices of one instance.
    pub fn draw(&self, vertices: u32, instance: u32) {
        if self.is_sound() {
            // SAFETY: a pipeline is bound; its reads are bounded by the shader's own buffers.
            unsafe { self.device().raw().cmd_draw(self.raw(), vertices, 1, 0, instance) };
        }
    }

    /// Draws `vertices` vertices of each of the `instances`.
    pub fn draw_instances(&self, vertices: u32, instances: Range<u32>) {
        let count = instances.end.saturating_sub(instances.start);
        if count > 0 && self.is_sound() {
            // SAFETY: as for a single instance.
            unsafe {
                self.device().raw().cmd_draw(self.raw(), vertices, count, 0, instances.start)
            };
        }
    }

    /// Draws `draw` from the bound geometry.
    pub fn draw_indexed(&self, draw: &IndirectDraw) {
        if self.is_sound() {
            // SAFETY: a pipeline is bound; the caller's indices lie in the bound buffer.
            unsafe {
                self.device().raw().cmd_draw_indexed(
                    self.raw(),
                    draw.index_count,
                    draw.instance_count,
                    draw.first_index,
                    draw.vertex_offset,
                    draw.first_instance,
                );
            }
        }
    }

    /// Draws the indexed indirect commands in `draws`, which must contain only such commands.
    pub fn draw_indirect(&self, draws: BufferSlice) {
        if self.check_owner(&draws).is_err() {
            return;
        }
        let stride = size_of::<vk::DrawIndexedIndirectCommand>() as u32;
        let limit = u64::from(self.device().adapter().limits.max_draw_indirect_count.max(1));
        let mut left = draws.size_bytes / u64::from(stride);
        let mut offset = draws.offset_bytes;
        while left > 0 && self.is_sound() {
            let count = left.min(limit);
            // SAFETY: multiDrawIndirect is required; the slice lies in its buffer.
            unsafe {
                self.device().raw().cmd_draw_indexed_indirect(
                    self.raw(),
                    draws.raw,
                    offset,
                    count as u32,
                    stride,
                );
            }
            left -= count;
            offset += count * u64::from(stride);
        }
    }

    /// Draws the indirect commands without indices in `draws`, which must contain only such
    /// commands (`VkDrawIndirectCommand`).
    pub fn draw_unindexed_indirect(&self, draws: BufferSlice) {
        if self.check_owner(&draws).is_err() {
            return;
        }
        for (offset, count) in self.unindexed_pieces(draws) {
            if self.is_sound() {
                // SAFETY: multiDrawIndirect is required; the slice lies in its buffer.
                unsafe {
                    self.device().raw().cmd_draw_indirect(
                        self.raw(),
                        draws.raw,
                        offset,
                        count,
                        UNINDEXED_STRIDE,
                    );
                }
            }
        }
    }

    /// Draws the first commands without indices in `draws` (`VkDrawIndirectCommand`). Their number
    /// is the value in `count`, which must be at least `maxDrawIndirectCount` if `draws` has more
    /// commands than that.
    pub(crate) fn draw_unindexed_indirect_count(&self, draws: BufferSlice, count: BufferSlice) {
        if !self.check_owners([&draws, &count]) {
            return;
        }
        for (offset, most) in self.unindexed_pieces(draws) {
            if self.is_sound() {
                // SAFETY: drawIndirectCount was checked when the executor was chosen; the slices
                // contain commands and one value.
                unsafe {
                    self.device().raw().cmd_draw_indirect_count(
                        self.raw(),
                        draws.raw,
                        offset,
                        count.raw,
                        count.offset_bytes,
                        most,
                        UNINDEXED_STRIDE,
                    );
                }
            }
        }
    }

    /// Returns the offsets and counts of commands without indices, divided into the largest pieces
    /// that the device accepts.
    fn unindexed_pieces(&self, draws: BufferSlice) -> impl Iterator<Item = (u64, u32)> + use<> {
        let limit = u64::from(self.device().adapter().limits.max_draw_indirect_count.max(1));
        let stride = u64::from(UNINDEXED_STRIDE);
        let all = draws.size_bytes / stride;
        let start = draws.offset_bytes;
        let pieces = (0..all.div_ceil(limit)).map(move |piece| piece * limit);
        pieces.map(move |first| (start + first * stride, (all - first).min(limit) as u32))
    }

    /// Draws the commands without indices in `draws` (`VkDrawIndirectCommand`) like
    /// [`Commands::draw_all_indirect`]. `draws` must contain only such commands.
    pub fn draw_all_unindexed_indirect(&self, draws: BufferSlice, all: BufferSlice) {
        if self.device().capabilities().keeps_draw_counts() {
            self.draw_unindexed_indirect_count(draws, all);
        } else {
            self.draw_unindexed_indirect(draws);
        }
    }

    /// Draws the indexed indirect commands in `draws`, which must contain only such commands. The
    /// function is safe after a counted draw: on drivers that reuse the count of that draw (Mesa's
    /// lavapipe, 22.3 and 25.0) it draws with the count in `all`, which must be
    /// `maxDrawIndirectCount`.
    pub fn draw_all_indirect(&self, draws: BufferSlice, all: BufferSlice) {
        let limit = u64::from(self.device().adapter().limits.max_draw_indirect_count);
        let keeps = self.device().capabilities().keeps_draw_counts();
        if keeps && draws.size_bytes / IndirectDraw::BYTES <= limit {
            self.draw_indirect_count(draws, all);
        } else {
            self.draw_indirect(draws);
        }
    }

    /// Draws the first commands in `draws`; their number is the value in `count`. The recording
    /// fails unless the device has [`OptionalFeature::DrawIndirectCount`] and `draws` has at most
    /// `maxDrawIndirectCount` commands. The value must not be larger than that either.
    pub fn draw_indirect_count(&self, draws: BufferSlice, count: BufferSlice) {
        let stride = size_of::<vk::DrawIndexedIndirectCommand>() as u32;
        let most = u32::try_from(draws.size_bytes / u64::from(stride)).unwrap_or(u32::MAX);
        if !self.device().capabilities().has(OptionalFeature::DrawIndirectCount) {
            let lacking = vk::Result::ERROR_FEATURE_NOT_PRESENT;
            self.fail(Failure::Call("vkCmdDrawIndexedIndirectCount", lacking));
        }
        if most > self.device().adapter().limits.max_draw_indirect_count {
            self.fail(Failure::Wrong("more draws under one count than the device takes"));
        }
        if !self.check_owners([&draws, &count]) || !self.is_sound() {
            return;
        }
        // SAFETY: the device has drawIndirectCount; both slices lie in their buffers.
        unsafe {
            self.device().raw().cmd_draw_indexed_indirect_count(
                self.raw(),
                draws.raw,
                draws.offset_bytes,
                count.raw,
                count.offset_bytes,
                most,
                stride,
            );
        }
    }

    /// Runs a compute shader over `groups` workgroups. The recording fails if they exceed the
    /// device's `maxComputeWorkGroupCount`.
    pub fn dispatch(&self, groups: [u32; 3]) {
        let most = self.device().adapter().limits.max_compute_work_group_count;
        if groups.iter().zip(most).any(|(groups, most)| *groups > most) {
            self.fail(Failure::Wrong("more workgroups than the device takes"));
        }
        if self.is_sound() {
            // SAFETY: a compute pipeline is bound.
            unsafe {
                self.device().raw().cmd_dispatch(self.raw(), groups[0], groups[1], groups[2])
            };
        }
    }
}
