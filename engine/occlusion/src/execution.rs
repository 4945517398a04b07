//! The execution of plans.

mod io;
mod recording;

use cull::MultiView;
use gpu::Frame;

use crate::error::{Error, TargetError, WrongAttachments};
use crate::executor::PlanExecutor;
use crate::object_renderer::ObjectRenderer;
use crate::passes::ComputeTest;
use crate::shader_set::ShaderSet;
use crate::visibility_state::VisibilityState;
use io::FrameIo;
use recording::Recording;

/// Executes the newest plan of `state`, which was made for `views`: one, or several that are drawn
/// at once to the layers of the target. The owner of the objects is called with the first.
///
/// # Errors
/// A view of another scene; a target with other attachments than the passes were compiled for, or
/// with another number of views; a depth that the plan's tests cannot read; no memory, a failed
/// call.
pub fn execute<'v>(
    frame: &mut Frame<'_>,
    executor: &mut PlanExecutor,
    state: &mut VisibilityState,
    objects: &mut dyn ObjectRenderer,
    (shaders, views): (&ShaderSet, impl Into<MultiView<'v>>),
) -> Result<(), Error> {
    state.check(&executor.leaves)?;
    let (passes, target) = (executor.passes.attachments(), objects.target().attachments());
    if !passes.fit(&target) {
        let (passes, target) = (Box::new(passes), Box::new(target));
        return Err(WrongAttachments { passes, target }.into());
    }
    let views: MultiView<'_> = views.into();
    if views.as_slice().len() as u64 != u64::from(target.views) {
        let (views, target) = (views.as_slice().len(), target.views);
        return Err(TargetError::Views { views, target }.into());
    }
    if state.layout.tests_by_compute() && !objects.target().can_copy_depth() {
        return Err(TargetError::CannotCopyDepth.into());
    }
    if executor.passes.compute_test.is_none() && state.layout.tests_by_compute() {
        let size = objects.target().size();
        executor.passes.compute_test = Some(ComputeTest::new(state.device(), shaders, size)?);
    }
    let io = FrameIo::write(frame, state, &mut executor.leaves, views)?;
    Recording { executor, state, view: views.first(), io: &io }.record(frame.commands(), objects);
    Ok(())
}
