//! Named accesses, and the barriers between them: one table without state.

use ash::vk;

/// The access of a command to memory. Every barrier of the engine is given by two lists of
/// accesses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Access {
    /// No access yet: new memory, or contents that are no longer needed.
    Nothing,
    /// Source of a copy.
    CopyRead,
    /// Destination of a copy, including copies of query results.
    CopyWrite,
    /// Read by indirect draws: commands and counts.
    IndirectRead,
    /// Read as the predicate of conditional rendering.
    PredicateRead,
    /// Vertex buffer whose vertices are drawn.
    AttributeRead,
    /// Storage buffer read by a vertex shader.
    VertexRead,
    /// Storage buffer read by a fragment shader.
    FragmentRead,
    /// Storage buffer read by a compute shader.
    ComputeRead,
    /// Storage buffer written by a compute shader.
    ComputeWrite,
    /// Storage buffer written by a fragment shader.
    FragmentWrite,
    /// Buffer that captures tessellated triangles
    /// ([`Commands::capture`](crate::Commands::capture)).
    CaptureWrite,
    /// Image sampled by a fragment shader.
    FragmentSample,
    /// Image sampled by a compute shader.
    ComputeSample,
    /// Colour attachment: blended, cleared, loaded, stored.
    Colour,
    /// Depth attachment: tested and written, cleared, loaded, stored.
    Depth,
    /// Read by the CPU after the tick.
    HostRead,
    /// Read by the presentation engine; a semaphore orders it, not a barrier.
    Present,
    /// Any access, for data that is loaded once and used in many ways.
    Any,
}

impl Access {
    /// All accesses, for tests.
    pub const ALL: [Access; 19] = [
        Access::Nothing,
        Access::CopyRead,
        Access::CopyWrite,
        Access::IndirectRead,
        Access::PredicateRead,
        Access::AttributeRead,
        Access::VertexRead,
        Access::FragmentRead,
        Access::ComputeRead,
        Access::ComputeWrite,
        Access::FragmentWrite,
        Access::CaptureWrite,
        Access::FragmentSample,
        Access::ComputeSample,
        Access::Colour,
        Access::Depth,
        Access::HostRead,
        Access::Present,
        Access::Any,
    ];

    /// Returns the row of the table: stages, reads, writes, and the layout that an image must have.
    fn row(self) -> Row {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        let none = A::NONE;
        let (stages, reads, writes, layout) = match self {
            Access::Nothing => (S::NONE, none, none, L::UNDEFINED),
            // ALL_TRANSFER and not COPY, because the validation layer at 1.3.239 requires it for
            // query copies.
            Access::CopyRead => (S::ALL_TRANSFER, A::TRANSFER_READ, none, L::TRANSFER_SRC_OPTIMAL),
            Access::CopyWrite => {
                (S::ALL_TRANSFER, none, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL)
            }
            Access::IndirectRead => {
                (S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, none, L::UNDEFINED)
            }
            Access::PredicateRead => (
                S::CONDITIONAL_RENDERING_EXT,
                A::CONDITIONAL_RENDERING_READ_EXT,
                none,
                L::UNDEFINED,
            ),
            Access::AttributeRead => {
                (S::VERTEX_ATTRIBUTE_INPUT, A::VERTEX_ATTRIBUTE_READ, none, L::UNDEFINED)
            }
            Access::VertexRead => (S::VERTEX_SHADER, A::SHADER_STORAGE_READ, none, L::UNDEFINED),
            Access::FragmentRead => {
                (S::FRAGMENT_SHADER, A::SHADER_STORAGE_READ, none, L::UNDEFINED)
            }
            Access::ComputeRead => (S::COMPUTE_SHADER, A::SHADER_STORAGE_READ, none, L::GENERAL),
            Access::ComputeWrite => {
                (S::COMPUTE_SHADER, A::SHADER_STORAGE_READ, A::SHADER_STORAGE_WRITE, L::GENERAL)
            }
            Access::FragmentWrite => {
                (S::FRAGMENT_SHADER, A::SHADER_STORAGE_READ, A::SHADER_STORAGE_WRITE, L::GENERAL)
            }
            Access::CaptureWrite => {
                (S::TRANSFORM_FEEDBACK_EXT, none, A::TRANSFORM_FEEDBACK_WRITE_EXT, L::UNDEFINED)
            }
            Access::FragmentSample => {
                (S::FRAGMENT_SHADER, A::SHADER_SAMPLED_READ, none, L::SHADER_READ_ONLY_OPTIMAL)
            }
            Access::ComputeSample => {
                (S::COMPUTE_SHADER, A::SHADER_SAMPLED_READ, none, L::SHADER_READ_ONLY_OPTIMAL)
            }
            Access::Colour => (
                S::COLOR_ATTACHMENT_OUTPUT,
                A::COLOR_ATTACHMENT_READ,
                A::COLOR_ATTACHMENT_WRITE,
                L::COLOR_ATTACHMENT_OPTIMAL,
            ),
            Access::Depth => (
                S::from_raw(S::EARLY_FRAGMENT_TESTS.as_raw() | S::LATE_FRAGMENT_TESTS.as_raw()),
                A::DEPTH_STENCIL_ATTACHMENT_READ,
                A::DEPTH_STENCIL_ATTACHMENT_WRITE,
                // Not DEPTH_ATTACHMENT_OPTIMAL, which needs separateDepthStencilLayouts.
                L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
            ),
            Access::HostRead => (S::HOST, A::HOST_READ, none, L::GENERAL),
            Access::Present => (S::NONE, none, none, L::PRESENT_SRC_KHR),
            Access::Any => (S::ALL_COMMANDS, A::MEMORY_READ, A::MEMORY_WRITE, L::GENERAL),
        };
        Row { stages, reads, writes, layout }
    }

    /// Returns the layout of an image during this access.
    pub fn layout(self) -> vk::ImageLayout {
        self.row().layout
    }
}

struct Row {
    stages: vk::PipelineStageFlags2,
    reads: vk::AccessFlags2,
    writes: vk::AccessFlags2,
    layout: vk::ImageLayout,
}

/// A memory barrier: all of `from` is over and visible before any of `to` begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryBarrier {
    /// The stages that must be over.
    pub from_stages: vk::PipelineStageFlags2,
    /// The writes of these stages that are made available.
    pub from_access: vk::AccessFlags2,
    /// The stages that wait.
    pub to_stages: vk::PipelineStageFlags2,
    /// The accesses to which these writes become visible.
    pub to_access: vk::AccessFlags2,
}

impl MemoryBarrier {
    /// Returns the barrier between two lists of accesses. Reads need no flush, so a read before a
    /// write costs only an execution dependency (Vulkan specification, "Access Types").
    pub fn between(from: &[Access], to: &[Access]) -> Self {
        let mut barrier = Self {
            from_stages: vk::PipelineStageFlags2::NONE,
            from_access: vk::AccessFlags2::NONE,
            to_stages: vk::PipelineStageFlags2::NONE,
            to_access: vk::AccessFlags2::NONE,
        };
        for row in from.iter().map(|access| access.row()) {
            barrier.from_stages |= row.stages;
            barrier.from_access |= row.writes;
        }
        for row in to.iter().map(|access| access.row()) {
            barrier.to_stages |= row.stages;
            barrier.to_access |= row.reads | row.writes;
        }
        barrier
    }
}

/// An image barrier that also changes the layout from one access to another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LayoutChange {
    pub(crate) image: vk::Image,
    pub(crate) part: vk::ImageSubresourceRange,
    pub(crate) barrier: MemoryBarrier,
    pub(crate) old_layout: vk::ImageLayout,
    pub(crate) new_layout: vk::ImageLayout,
}

impl LayoutChange {
    pub(crate) fn new(
        image: vk::Image,
        aspect: vk::ImageAspectFlags,
        from: Access,
        to: Access,
    ) -> Self {
        Self::of_part(image, first_level_of(aspect), from, to)
    }

    /// Returns the change of a part of an image that has more than one level or layer.
    pub(crate) fn of_part(
        image: vk::Image,
        part: vk::ImageSubresourceRange,
        from: Access,
        to: Access,
    ) -> Self {
        Self {
            image,
            part,
            barrier: MemoryBarrier::between(&[from], &[to]),
            old_layout: from.layout(),
            new_layout: to.layout(),
        }
    }

    /// Returns a change that discards the contents, ordered after all accesses in `from`.
    pub(crate) fn forgetting(
        image: vk::Image,
        aspect: vk::ImageAspectFlags,
        from: &[Access],
        to: Access,
    ) -> Self {
        let barrier = MemoryBarrier::between(from, &[to]);
        Self { barrier, ..Self::new(image, aspect, Access::Nothing, to) }
    }

    /// Returns the same change for the first `layers` layers.
    pub(crate) fn of_layers(mut self, layers: u32) -> Self {
        self.part.layer_count = layers;
        self
    }
}

fn first_level_of(aspect: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange {
        aspect_mask: aspect,
        level_count: 1,
        layer_count: 1,
        ..Default::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_read_before_a_write_flushes_nothing() {
        let barrier = MemoryBarrier::between(&[Access::IndirectRead], &[Access::ComputeWrite]);
        assert_eq!(barrier.from_access, vk::AccessFlags2::NONE);
        assert_eq!(barrier.from_stages, vk::PipelineStageFlags2::DRAW_INDIRECT);
        assert_eq!(barrier.to_stages, vk::PipelineStageFlags2::COMPUTE_SHADER);
    }

    #[test]
    fn query_results_reach_the_predicate() {
        let barrier = MemoryBarrier::between(&[Access::CopyWrite], &[Access::PredicateRead]);
        assert_eq!(barrier.from_access, vk::AccessFlags2::TRANSFER_WRITE);
        assert_eq!(barrier.to_access, vk::AccessFlags2::CONDITIONAL_RENDERING_READ_EXT);
    }

    #[test]
    fn every_access_of_a_command_has_a_stage_and_an_effect() {
        for access in Access::ALL {
            let row = access.row();
            let nothing = [Access::Nothing, Access::Present].contains(&access);
            assert_eq!(row.stages.is_empty(), nothing, "{access:?}");
            assert_eq!((row.reads | row.writes).is_empty(), nothing, "{access:?}");
        }
    }

    #[test]
    fn lists_are_unions() {
        let both = MemoryBarrier::between(
            &[Access::CopyWrite, Access::ComputeWrite],
            &[Access::CopyRead, Access::HostRead],
        );
        assert!(both.from_stages.contains(vk::PipelineStageFlags2::ALL_TRANSFER));
        assert!(both.from_stages.contains(vk::PipelineStageFlags2::COMPUTE_SHADER));
        assert!(both.to_access.contains(vk::AccessFlags2::HOST_READ));
        assert!(both.to_access.contains(vk::AccessFlags2::TRANSFER_READ));
    }
}
