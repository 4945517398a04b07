//! Plans whose draws a host records itself: lists of them, and the tests in between.

use cull::{CullView, MultiView};
use gpu::{Commands, Frame, RenderTarget, Target};

use super::io::FrameIo;
use super::recording::Recording;
use super::{check_target, make_compute_test, make_list_pass};
use crate::error::{DrawsAmongTests, Error};
use crate::executor::PlanExecutor;
use crate::leaf_table::BucketId;
use crate::object_renderer::{ObjectPass, ObjectRenderer, Rendering};
use crate::occlusion_state::OcclusionState;
use crate::passes::ListDrawsIo;
use crate::shader_set::ShaderSet;

/// The tests of a frame whose draws are listed, still to be recorded.
#[must_use = "the lists of revealed draws are undefined until the tests are recorded"]
pub struct ListedTests<'v> {
    views: MultiView<'v>,
    io: FrameIo,
    lists: Option<ListDrawsIo>,
}

/// Lists the draws of the newest plan of `state`, which was made for `views`, for a host that
/// records them itself: it cannot be called back between commands, or knows no conditional
/// rendering. Records nothing but clears.
///
/// The order on the queue is: the draws of [`OcclusionState::visible_lists`], in renderings of the
/// host that clear; the [tests](ListedTests::record), in the command buffer of `frame`; the draws
/// of [`OcclusionState::revealed_lists`], in renderings that keep what is there. All lists are
/// known after this call, and what the GPU writes of them is there behind the tests. The buffers
/// live until the frame is over.
///
/// ```no_run
/// # use antumbra_occlusion as occlusion;
/// use cull::{CullConfig, DrawPhases, CullView};
/// use occlusion::*;
///
/// /// Makes a view whose plans are fit for lists.
/// fn view(scene: &HostScene, target: &gpu::Target) -> Result<OcclusionState, Error> {
///     scene.new_view(target, CullConfig::default(), DrawPhases::Two)
/// }
///
/// /// Records a planned frame between two renderings of the host.
/// fn record(
///     frame: &mut gpu::Frame<'_>,
///     (scene, state): (&mut HostScene, &mut OcclusionState),
///     (target, shaders, view): (&mut gpu::Target, &ShaderSet, &CullView),
///     mut draw: impl FnMut(&DrawList),
/// ) -> Result<(), Error> {
///     let (_, executor) = scene.parts_mut();
///     let tests = list_draws(frame, executor, state, view)?;
///     state.visible_lists().iter().for_each(&mut draw); // in the host's first rendering
///     tests.record(frame, executor, state, target, shaders)?;
///     target.restore(frame.commands());
///     state.revealed_lists().iter().for_each(&mut draw); // in its second
///     Ok(())
/// }
/// ```
///
/// # Errors
/// [`Error::DrawsAmongTests`] for the plan of a culler without
/// [`DrawPhases::Two`](cull::DrawPhases::Two); a view of another scene; [`Error::Plan`],
/// [`Error::NotUploaded`]; no memory, a failed call.
pub fn list_draws<'v>(
    frame: &mut Frame<'_>,
    executor: &mut PlanExecutor,
    state: &mut OcclusionState,
    views: impl Into<MultiView<'v>>,
) -> Result<ListedTests<'v>, Error> {
    let views = views.into();
    state.check_plan(&executor.leaves, views)?;
    if !state.plan().has_two_phases() {
        return Err(DrawsAmongTests.into());
    }
    let io = FrameIo::write(frame, state, &mut executor.leaves, views)?;
    let quirks = executor.passes.quirks();
    let lists = state.list(frame, &executor.leaves, io.visible, quirks)?;
    Ok(ListedTests { views, io, lists })
}

impl ListedTests<'_> {
    /// Records the tests against the depth in `target`, which holds the visible draws, and the
    /// passes that list what they reveal. Outside of rendering. Colours of the target, if it has
    /// any, are not written.
    ///
    /// # Errors
    /// A target with other attachments than the passes were compiled for, or with another number of
    /// views; a depth that the plan's tests cannot read; a failed call.
    pub fn record(
        self,
        frame: &mut Frame<'_>,
        executor: &mut PlanExecutor,
        state: &OcclusionState,
        target: &mut Target,
        shaders: &ShaderSet,
    ) -> Result<(), Error> {
        check_target(executor, state, target, self.views)?;
        make_compute_test(executor, state, shaders, target.size())?;
        make_list_pass(executor, state, shaders)?;
        let Some(pass) = &executor.passes.list_draws else { return Ok(()) };
        let recording = Recording { executor, state, view: self.views.first(), io: &self.io };
        recording.record_tests(frame.commands(), &mut TestsAlone { target }, pass, self.lists);
        Ok(())
    }
}

/// The renderings of tests: the host draws its objects itself.
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

    fn bind(&self, _: &Commands, _: &CullView, _: BucketId, _: ObjectPass) {}
}
