//! The execution of plans.

mod io;
mod listing;
mod recording;

use cull::{CullView, MultiView};
use gpu::{Frame, PredicationMode, Target};

use crate::error::{Error, TargetError, WrongAttachments};
use crate::executor::PlanExecutor;
use crate::object_renderer::ObjectRenderer;
use crate::occlusion_state::OcclusionState;
use crate::passes::{ComputeTest, ListDrawsPass};
use crate::shader_set::ShaderSet;
use io::FrameIo;
pub use listing::{ListedTests, list_draws};
use recording::Recording;

/// Executes the newest plan of `state`, which was made for `views`: one, or several that are drawn
/// at once to the layers of the target. The owner of the objects is called with the first.
///
/// # Errors
/// [`Error::Plan`]; a view of another scene; [`Error::NotUploaded`]; a target with other
/// attachments than the passes were compiled for, or with another number of views; a depth that the
/// plan's tests cannot read; no memory, a failed call.
pub fn execute<'v>(
    frame: &mut Frame<'_>,
    executor: &mut PlanExecutor,
    state: &mut OcclusionState,
    objects: &mut dyn ObjectRenderer,
    shaders: &ShaderSet,
    views: impl Into<MultiView<'v>>,
) -> Result<(), Error> {
    let views: MultiView<'_> = views.into();
    state.check_plan(&executor.leaves, views)?;
    check_target(executor, state, objects.target(), views)?;
    make_compute_test(executor, state, shaders, objects.target().size())?;
    let mut io = FrameIo::write(frame, state, &mut executor.leaves, views)?;
    if executor.leaves.predicates.predication() == PredicationMode::Compacted {
        make_list_pass(executor, state, shaders)?;
        io.lists = state.compact(frame, &executor.leaves)?;
    }
    Recording { executor, state, view: views.first(), io: &io }.record(frame.commands(), objects);
    Ok(())
}

/// Refuses a target that does not fit the passes, the views or the tests of the plan.
fn check_target(
    executor: &PlanExecutor,
    state: &OcclusionState,
    target: &Target,
    views: MultiView<'_>,
) -> Result<(), Error> {
    let passes = executor.passes.attachments();
    let attachments = target.attachments();
    if !passes.fit(&attachments) {
        let passes = Box::new(passes);
        let target = Box::new(attachments);
        return Err(WrongAttachments { passes, target }.into());
    }
    if views.as_slice().len() as u64 != u64::from(attachments.views) {
        let views = views.as_slice().len();
        let target = attachments.views;
        return Err(TargetError::Views { views, target }.into());
    }
    let is_inside = |view: &&CullView| {
        let end = |side: usize| u64::from(view.origin[side]) + u64::from(view.size[side]);
        (0..2).all(|side| end(side) <= u64::from(target.size()[side]))
    };
    if let Some(view) = views.as_slice().iter().find(|view| !is_inside(view)) {
        let size = view.size;
        let origin = view.origin;
        let target = target.size();
        return Err(TargetError::ViewSize { size, origin, target }.into());
    }
    if state.layout.tests_by_compute() && !target.can_copy_depth() {
        return Err(TargetError::CannotCopyDepth.into());
    }
    Ok(())
}

/// Creates the pass that tests boxes by a compute shader, for the first plan with such tests.
fn make_compute_test(
    executor: &mut PlanExecutor,
    state: &OcclusionState,
    shaders: &ShaderSet,
    size: [u32; 2],
) -> Result<(), Error> {
    if executor.passes.compute_test.is_none() && state.layout.tests_by_compute() {
        let test = ComputeTest::new(state.device(), shaders, size)?;
        let samples = executor.passes.attachments().samples;
        executor.passes.compute_test = Some(test.of_samples(samples));
    }
    Ok(())
}

/// Creates the passes that list draws, for the first frame with lists.
fn make_list_pass(
    executor: &mut PlanExecutor,
    state: &OcclusionState,
    shaders: &ShaderSet,
) -> Result<(), Error> {
    if executor.passes.list_draws.is_none() {
        executor.passes.list_draws = Some(ListDrawsPass::new(state.device(), shaders)?);
    }
    Ok(())
}
