//! Plans whose draws a host records itself: lists of the draws, and the tests between them.

use cull::{CullView, DrawPhases};
use gpu::{Commands, Frame, RecordingId, RenderTarget, Target};

use super::io::FrameIo;
use super::recording::Recording;
use super::{check_target, prepare_compute_test};
use crate::culled_scene::CulledScene;
use crate::error::{DrawsAmongTests, Error};
use crate::leaf_table::BucketId;
use crate::object_renderer::{ObjectRenderer, Rendering};
use crate::occlusion_state::OcclusionState;
use crate::passes::ListDrawsIo;

/// The tests of a frame whose draws are listed. They are not recorded yet.
pub(crate) struct ListedTests {
    views: Vec<CullView>,
    io: FrameIo,
    lists: Option<ListDrawsIo>,
    /// The frame that the draws are listed in.
    recording: RecordingId,
}

/// Lists the draws of the newest plan of `state` for the views that it was made for. Records
/// nothing but clears. The host records the draws, and the [tests](ListedTests::record) between
/// them.
pub(crate) fn list_draws(
    frame: &mut Frame<'_>,
    scene: &mut CulledScene,
    state: &mut OcclusionState,
) -> Result<ListedTests, Error> {
    if scene.draw_phases != DrawPhases::Two || !state.plan().has_two_phases() {
        return Err(DrawsAmongTests.into());
    }
    state.planned_views(scene)?;
    let views = state.take_planned_views();
    let io = FrameIo::write(frame, state, &scene.leaves, &views)?;
    let lists = state.list(frame, &scene.leaves, io.visible, scene.passes.quirks())?;
    Ok(ListedTests { views, io, lists, recording: frame.commands().recording() })
}

impl ListedTests {
    /// Records the tests against the depth in `target`, which holds the visible draws, and the
    /// passes that list the revealed draws. Outside of rendering. Colours of the target, if it has
    /// any, are not written.
    pub(crate) fn record(
        self,
        frame: &mut Frame<'_>,
        scene: &mut CulledScene,
        state: &mut OcclusionState,
        target: &mut Target,
    ) -> Result<(), Error> {
        state.check(scene)?;
        let is_of_frame = self.recording == frame.commands().recording();
        let view = self.views.first().filter(|_| is_of_frame).ok_or(Error::NoPlan)?;
        check_target(scene, state, target, &self.views)?;
        prepare_compute_test(scene, state, target.size())?;
        FrameIo::begin_predicates(frame, state, &mut scene.leaves)?;
        let recording = Recording { scene, state, view, io: &self.io };
        recording.record_tests(frame.commands(), &mut TestsAlone { target }, self.lists);
        state.keep_planned_views(self.views);
        Ok(())
    }
}

/// Renderings that contain only tests, since the host draws its objects itself.
struct TestsAlone<'a> {
    target: &'a mut Target,
}

impl ObjectRenderer for TestsAlone<'_> {
    fn target(&mut self) -> &mut Target {
        self.target
    }

    fn rendering(&self, view: &CullView, _rendering: Rendering) -> RenderTarget {
        self.target.render_target(None).within(view.origin, view.size)
    }

    fn bind(&self, _: &Commands, _: &CullView, _: BucketId) {}
}
