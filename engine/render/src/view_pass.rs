//! One view of a frame being recorded.

use cull::CullView;
use gpu::{Frame, RenderTarget};
use occlusion::CulledScene;

use crate::attachment_schedule::AttachmentSchedule;
use crate::scene_renderer::SceneRenderer;

/// One view of a frame being recorded: the owner of the objects, the frame, the scene as the frame
/// draws it, and the view.
pub(crate) struct ViewPass<'a, 'ring> {
    pub(crate) passes: &'a mut SceneRenderer,
    pub(crate) frame: &'a mut Frame<'ring>,
    pub(crate) scene: &'a CulledScene,
    pub(crate) view: &'a CullView,
}

impl ViewPass<'_, '_> {
    /// Prepares the target for draws over the image of the view. Returns the attachments of the
    /// rendering, with as few loads and stores as possible.
    pub(crate) fn prepare(&mut self, schedule: AttachmentSchedule) -> RenderTarget {
        self.passes.target.prepare(self.frame.commands());
        self.attachments(schedule)
    }

    /// Prepares the target for tests against the finished depth of the view. Returns the
    /// attachments of the rendering, with as few loads and stores as possible.
    pub(crate) fn prepare_tests(&mut self, schedule: AttachmentSchedule) -> RenderTarget {
        self.passes.target.prepare_tests(self.frame.commands());
        self.attachments(schedule)
    }

    fn attachments(&mut self, schedule: AttachmentSchedule) -> RenderTarget {
        let target = self.passes.target_of(self.view, None);
        self.passes.scope_target(self.frame.commands(), schedule, target)
    }
}
