//! Recording of captures: tessellates patches and stores the triangles in a buffer.

use ash::vk;

use crate::core::capabilities::LEAST_CAPTURE;
use crate::memory::buffer::BufferSlice;
use crate::record::api::binding::SampledArrays;
use crate::record::capture_pipeline::{CapturePipeline, PATCH_POINTS};
use crate::record::commands::{Commands, Failure};

impl Commands {
    /// Tessellates `patches` patches with the storage buffers of the shaders, and captures their
    /// triangles in `results` with [`Access::CaptureWrite`](crate::Access::CaptureWrite). `results`
    /// must come from a [`FlagRing`](crate::FlagRing) and have at most 128 MiB. Triangles that do
    /// not fit are left out. Must be called outside of renderings.
    pub fn capture(
        &self,
        pipeline: &CapturePipeline,
        storage: &[BufferSlice],
        patches: u32,
        results: BufferSlice,
    ) {
        let Some(vertices) = patches.checked_mul(PATCH_POINTS) else {
            self.fail(Failure::Wrong("more control points of patches than 32 bits count"));
            return;
        };
        if results.size_bytes > LEAST_CAPTURE.buffer_bytes {
            self.fail(Failure::Wrong("a captured buffer larger than every device takes"));
            return;
        }
        if self.check_owner(&results).is_err() {
            return;
        }
        let point = vk::PipelineBindPoint::GRAPHICS;
        self.bind_kind(&pipeline.0, point, storage, &[], SampledArrays::NONE);
        let Some(feedback) = self.device().capture() else { return };
        if !self.is_sound() {
            return;
        }
        let raw = self.device().raw();
        let extent = vk::Extent2D { width: 1, height: 1 };
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent };
        let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1);
        let buffers = [results.raw];
        let offsets = [results.offset_bytes];
        let sizes = [results.size_bytes];
        // SAFETY: the bound pipeline discards all fragments, so it needs no attachment. The slice
        // lies in its buffer, begins at a multiple of 4, and its buffer has the usage for captures,
        // which results of rings have on devices with transform feedback. There are no counter
        // buffers.
        unsafe {
            let feedback = feedback.fp();
            (feedback.cmd_bind_transform_feedback_buffers_ext)(
                self.raw(),
                0,
                1,
                buffers.as_ptr(),
                offsets.as_ptr(),
                sizes.as_ptr(),
            );
            let none = std::ptr::null();
            let no_offsets = std::ptr::null();
            raw.cmd_begin_rendering(self.raw(), &rendering);
            (feedback.cmd_begin_transform_feedback_ext)(self.raw(), 0, 0, none, no_offsets);
            raw.cmd_draw(self.raw(), vertices, 1, 0, 0);
            (feedback.cmd_end_transform_feedback_ext)(self.raw(), 0, 0, none, no_offsets);
            raw.cmd_end_rendering(self.raw());
        }
    }
}
