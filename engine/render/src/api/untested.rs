//! Frames for whose tests there is no memory.

use cull::Strategy;
use gpu::Readback;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::views::{FrameReport, ViewRequest, ViewsRequest};

impl Renderer {
    /// Renders like [`Renderer::render_views`], and copies the image of the scene alone to
    /// `scene_image`. A frame that needs more memory for its tests than there is, is drawn without
    /// them: its image is the same. The first such frame is logged.
    pub(crate) fn render_targets(
        &mut self,
        targets: &mut [ViewRequest<'_>],
        request: &ViewsRequest<'_>,
        scene_image: Option<&Readback>,
    ) -> Result<FrameReport, Error> {
        match self.render_tested(targets, request, scene_image) {
            Err(Error::Gpu(error))
                if error.is_out_of_memory() && request.strategy != Strategy::FRUSTUM =>
            {
                if !self.has_untested_frames {
                    self.has_untested_frames = true;
                    tracing::warn!(
                        "no memory for the tests of a frame: such frames draw all that is in their \
                         frustum, which takes longer ({error})"
                    );
                }
                let untested = ViewsRequest { strategy: Strategy::FRUSTUM, ..*request };
                self.render_tested(targets, &untested, scene_image)
            }
            rendered => rendered,
        }
    }
}
