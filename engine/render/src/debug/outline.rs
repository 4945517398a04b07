//! The outline of an object's box.

use crate::view_pass::ViewPass;
use cull::Aabb;

use crate::attachment_schedule::AttachmentSchedule;
use crate::debug::palette::SELECTED;
use crate::debug::top_down::{Sketch, SketchBox};
use crate::error::Error;

/// The pass that outlines an object.
pub(crate) const OUTLINE: &str = "outline";

/// Draws the outline of a box over the image of a view.
pub(crate) fn record_outline(view_pass: &mut ViewPass<'_, '_>, bounds: Aabb) -> Result<(), Error> {
    let outlined = SketchBox { bounds, colour: SELECTED };
    let io = Sketch::through(std::iter::once(outlined)).upload(view_pass.frame)?;
    let target = view_pass.prepare(AttachmentSchedule::Outline);
    let ViewPass { passes, frame, view, .. } = view_pass;
    frame.commands().pass(OUTLINE, |commands| {
        commands.rendering(target, |commands| {
            if let Some(overlay) = passes.pipelines.overlay.get() {
                overlay.record(commands, &io, view);
            }
        });
    });
    Ok(())
}
