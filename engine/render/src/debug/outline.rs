//! The outline of an object's box.

use cull::{Aabb, CullView};
use gpu::Frame;

use crate::attachment_schedule::AttachmentSchedule;
use crate::debug::palette::SELECTED;
use crate::debug::top_down::Sketch;
use crate::error::Error;
use crate::frame_passes::FramePasses;

/// The pass that outlines an object.
pub(crate) const OUTLINE: &str = "outline";

/// Draws the outline of a box over the image of `view`.
pub(crate) fn record_outline(
    frame: &mut Frame<'_>,
    passes: &mut FramePasses,
    bounds: Aabb,
    view: &CullView,
) -> Result<(), Error> {
    let io = Sketch::through(std::iter::once((bounds, SELECTED))).upload(frame)?;
    passes.target.prepare(frame.commands());
    let target = passes.target_of(view, None);
    let target = passes.scope_target(frame.commands(), AttachmentSchedule::Outline, target);
    frame.commands().pass(OUTLINE, |commands| {
        commands.rendering(target, |commands| {
            if let Some(overlay) = passes.pipelines.overlay.get() {
                overlay.record(commands, &io, view);
            }
        });
    });
    Ok(())
}
