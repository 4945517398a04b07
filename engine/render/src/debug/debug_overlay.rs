//! Explanations of running frames: wires, the boxes of the frontier, a view from above in a corner.

use cull::{Hierarchy, NodeState, Tester, View};
use gpu::{BufferSlice, Device, Frame};
use occlusion::{PlanExecutor, Rect, ShaderSet};

use crate::debug::flat_overlay::{GLYPHS, OVERLAY};
use crate::debug::outline::OUTLINE;
use crate::debug::palette::{BOX_BEHIND, BOX_HIDDEN, BOX_SHOWED, BOX_UNKNOWN};
use crate::debug::top_down::{BACKGROUND, Sketch, VIEW_FROM_ABOVE, above, reach};
use crate::debug::visibility_snapshot::VisibilitySnapshot;
use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::passes::{OpaquePass, OverlayPass};
use crate::view_state::ViewState;
use crate::views::view_in;

/// The overlay that explains images; of several views, over the first. It shows the plan of the
/// frame and the history when it is recorded, and waits for nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DebugOverlay {
    /// True to draw the edges of all triangles that are taken as visible.
    pub has_wireframe: bool,
    /// True to draw the boxes of the tested nodes, seen through everything, coloured by their state
    /// ([`BOX_HIDDEN`], [`BOX_BEHIND`],
    /// [`BOX_UNKNOWN`], [`BOX_SHOWED`]).
    pub has_boxes: bool,
    /// The part of the image for the view from above.
    pub top_down: Option<Rect>,
}

const BOXES_AND_WIREFRAME: &str = "boxes and wireframe";
/// The labels of the passes that explain or lie flat over images: their time is not the engine's.
pub const OVERLAY_PASSES: [&str; 5] =
    [BOXES_AND_WIREFRAME, VIEW_FROM_ABOVE, OUTLINE, GLYPHS, OVERLAY];

/// An explanation and its passes.
pub(crate) struct DebugRenderer {
    pub(crate) explanation: DebugOverlay,
    device: Device,
    overlay: OverlayPass,
    wireframe: Option<OpaquePass>,
}

impl DebugRenderer {
    pub(crate) fn new(
        device: &Device,
        shaders: &ShaderSet,
        explanation: DebugOverlay,
    ) -> Result<Self, Error> {
        let wireframe = explanation.has_wireframe.then(|| OpaquePass::wireframe(device, shaders));
        let overlay = OverlayPass::new(device, shaders)?;
        Ok(Self { explanation, device: device.clone(), overlay, wireframe: wireframe.transpose()? })
    }

    /// Draws the explanation over the frame that `history` was just recorded for.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        (passes, executor, hierarchy): (&mut FramePasses, &PlanExecutor, &Hierarchy),
        (history, view): (&ViewState, &View),
    ) -> Result<(), Error> {
        let snapshot = VisibilitySnapshot::underway(history, hierarchy, *view);
        let draws = snapshot.upload(frame, &executor.leaves)?;
        let boxes = history.plan().tests.iter().map(|test| {
            let colour = match (test.tester, history.visibility.culler().state(test.tag.node)) {
                (Tester::SharedProxy(_), _) => BOX_BEHIND,
                (_, NodeState::Hidden) => BOX_HIDDEN,
                (_, NodeState::Unknown) => BOX_UNKNOWN,
                (_, NodeState::Visible) => BOX_SHOWED,
            };
            (hierarchy.bounds(test.tag.node), colour)
        });
        let boxes = self.explanation.has_boxes.then(|| Sketch::through(boxes).upload(frame));
        let boxes = boxes.transpose()?;
        passes.target.prepare(frame.commands());
        frame.commands().pass(BOXES_AND_WIREFRAME, |commands| {
            commands.rendering(passes.target_of(view, None), |commands| {
                if let (Some(wireframe), true) = (&self.wireframe, draws.1 > 0) {
                    wireframe.bind(commands, &passes.opaque_io(), view, &passes.light);
                    executor.leaves.predicates().draw_after_counted(commands, draws.0);
                }
                if let Some(boxes) = &boxes {
                    self.overlay.record(commands, boxes, view);
                }
            });
        });
        self.record_corner(frame, (passes, executor, hierarchy), (&snapshot, draws))
    }

    /// Draws the explanation of a frozen moment over its image from another eye: its wires, and
    /// the view from above. That image has its hidden boxes already.
    pub(crate) fn record_snapshot(
        &self,
        frame: &mut Frame<'_>,
        (passes, executor, hierarchy): (&mut FramePasses, &PlanExecutor, &Hierarchy),
        view: &View,
        (snapshot, draws): (&VisibilitySnapshot, (BufferSlice, u32)),
    ) -> Result<(), Error> {
        if let (Some(wireframe), true) = (&self.wireframe, draws.1 > 0) {
            passes.target.prepare(frame.commands());
            frame.commands().pass(BOXES_AND_WIREFRAME, |commands| {
                commands.rendering(passes.target_of(view, None), |commands| {
                    wireframe.bind(commands, &passes.opaque_io(), view, &passes.light);
                    executor.leaves.predicates().draw_after_counted(commands, draws.0);
                });
            });
        }
        self.record_corner(frame, (passes, executor, hierarchy), (snapshot, draws))
    }

    /// Draws a moment from above, if that is requested.
    fn record_corner(
        &self,
        frame: &mut Frame<'_>,
        (passes, executor, hierarchy): (&mut FramePasses, &PlanExecutor, &Hierarchy),
        (snapshot, draws): (&VisibilitySnapshot, (BufferSlice, u32)),
    ) -> Result<(), Error> {
        let Some(area) = self.explanation.top_down else { return Ok(()) };
        let reach = reach(hierarchy, snapshot);
        let io = Sketch::of(snapshot, reach).upload(frame)?;
        let view = &view_in(&self.device, &above(snapshot, reach), area);
        passes.target.prepare(frame.commands());
        frame.commands().pass(VIEW_FROM_ABOVE, |commands| {
            commands.rendering(passes.image_target(view, BACKGROUND), |commands| {
                passes.draw_all(executor, commands, view, draws, BACKGROUND);
                self.overlay.record(commands, &io, view);
            });
        });
        Ok(())
    }
}
