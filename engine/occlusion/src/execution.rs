//! The execution of plans.

mod io;
mod recording;

use cull::View;
use gpu::Frame;

use crate::error::{Error, WrongAttachments};
use crate::executor::PlanExecutor;
use crate::object_renderer::ObjectRenderer;
use crate::passes::ComputeTest;
use crate::shader_set::ShaderSet;
use crate::visibility_state::VisibilityState;
use io::FrameIo;
use recording::Recording;

/// Executes the newest plan of `state`, which was made for `view`.
///
/// # Errors
/// A view of another scene, a target with other attachments than the passes were compiled for; no
/// memory, a failed call.
pub fn execute(
    frame: &mut Frame<'_>,
    executor: &mut PlanExecutor,
    state: &mut VisibilityState,
    objects: &mut dyn ObjectRenderer,
    (shaders, view): (&ShaderSet, &View),
) -> Result<(), Error> {
    state.check(&executor.leaves)?;
    let (passes, target) = (executor.passes.attachments(), objects.target().attachments());
    if !passes.fit(&target) {
        let (passes, target) = (Box::new(passes), Box::new(target));
        return Err(WrongAttachments { passes, target }.into());
    }
    if executor.passes.compute_test.is_none() && state.layout.tests_by_compute() {
        let size = objects.target().size();
        executor.passes.compute_test = Some(ComputeTest::new(state.device(), shaders, size)?);
    }
    let io = FrameIo::write(frame, state, &mut executor.leaves)?;
    Recording { executor, state, view, io: &io }.record(frame.commands(), objects);
    Ok(())
}
