//! The execution of plans.

mod io;
mod listing;
mod recording;

use cull::CullView;
use gpu::{Frame, PredicationMode, Target};

use crate::culled_scene::CulledScene;
use crate::error::{Error, TargetError, WrongAttachments};
use crate::occlusion_state::OcclusionState;
use crate::shaded_objects::ShadedObjects;
use io::FrameIo;
pub(crate) use listing::{ListedTests, list_draws};
use recording::Recording;

/// Executes the newest plan of `state` for the views that it was made for. Where several views are
/// drawn at once, the methods of `objects` receive the first of them.
///
/// # Errors
/// [`Error::NoPlan`]; a view of another scene; [`Error::NotUploaded`]; a target with other
/// attachments than the passes were compiled for, or with another number of views; a depth that the
/// plan's tests cannot read; no memory, a failed call.
pub fn execute(
    frame: &mut Frame<'_>,
    scene: &mut CulledScene,
    state: &mut OcclusionState,
    objects: &mut dyn ShadedObjects,
) -> Result<(), Error> {
    check_target(scene, state, objects.target(), state.planned_views(scene)?)?;
    prepare_compute_test(scene, state, objects.target().size())?;
    let planned = state.take_planned_views();
    let view = planned.first().ok_or(Error::NoPlan)?;
    let mut io = FrameIo::write(frame, state, &scene.leaves, &planned)?;
    FrameIo::begin_predicates(frame, state, &mut scene.leaves)?;
    if scene.leaves.predicates.predication() == PredicationMode::Compacted {
        io.lists = state.compact(frame, &scene.leaves)?;
    }
    Recording { scene, state, view, io: &io }.record(frame.commands(), objects);
    state.keep_planned_views(planned);
    Ok(())
}

/// Refuses a target that does not fit the passes, the views or the tests of the plan.
fn check_target(
    scene: &CulledScene,
    state: &OcclusionState,
    target: &Target,
    views: &[CullView],
) -> Result<(), Error> {
    let passes = scene.passes.attachments();
    let attachments = target.attachments();
    if !passes.fit(&attachments) {
        let passes = Box::new(passes);
        let target = Box::new(attachments);
        return Err(WrongAttachments { passes, target }.into());
    }
    if views.len() as u64 != u64::from(attachments.views) {
        let views = views.len();
        let target = attachments.views;
        return Err(TargetError::Views { views, target }.into());
    }
    let is_inside = |view: &&CullView| {
        let end = |side: usize| u64::from(view.origin[side]) + u64::from(view.size[side]);
        (0..2).all(|side| end(side) <= u64::from(target.size()[side]))
    };
    if let Some(view) = views.iter().find(|view| !is_inside(view)) {
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

/// Makes room for the depth that boxes are tested against by a compute shader, in the first frame
/// of a size with such tests.
fn prepare_compute_test(
    scene: &mut CulledScene,
    state: &OcclusionState,
    size: [u32; 2],
) -> Result<(), Error> {
    if state.layout.tests_by_compute() {
        scene.passes.compute_test.resize(&scene.device, size)?;
    }
    Ok(())
}
