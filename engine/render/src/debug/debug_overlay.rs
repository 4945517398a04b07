//! The debug overlay of running frames: the depth complexity, wires, the boxes of the frontier, a
//! view from above in a corner.

use cull::{CullView, Hierarchy, NodeState, VisibilityTest};
use gpu::{BufferSlice, Device, Frame};
use occlusion::{PlanExecutor, Rect, ShaderSet};

use crate::attachment_schedule::AttachmentSchedule;
use crate::debug::depth_complexity::{DEPTH_COMPLEXITY, record_depth_complexity};
use crate::debug::outline::OUTLINE;
use crate::debug::palette::{BOX_BEHIND, BOX_HIDDEN, BOX_SHOWED, BOX_UNKNOWN};
use crate::debug::top_down::{BACKGROUND, Sketch, VIEW_FROM_ABOVE, above, reach};
use crate::debug::visibility_snapshot::VisibilitySnapshot;
use crate::error::Error;
use crate::frame_passes::FramePasses;
use crate::host_overlay::HOST_OVERLAY;
use crate::passes::OverlayIo;
use crate::passes::pipelines::Pipelines;
use crate::render_view::RenderView;
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
    /// True to show how many surfaces the draws that are taken as visible have at each pixel,
    /// hidden ones included, in place of the image ([`LAYERS`](crate::palette::LAYERS)).
    /// Transparent objects, caps and edges do not count; with several samples per pixel, each
    /// triangle counts that covers one of them. What this very frame finds visible counts
    /// from the next one on.
    pub has_depth_complexity: bool,
    /// The part of the image for the view from above.
    pub top_down: Option<Rect>,
}

const BOXES_AND_WIREFRAME: &str = "boxes and wireframe";
/// The labels of the passes that explain images or lie over them: their time is not the engine's.
pub const OVERLAY_PASSES: [&str; 5] =
    [DEPTH_COMPLEXITY, BOXES_AND_WIREFRAME, VIEW_FROM_ABOVE, OUTLINE, HOST_OVERLAY];

impl DebugOverlay {
    /// Returns true if it explains nothing.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Compiles the passes that it needs.
    pub(crate) fn prepare(
        &self,
        pipelines: &mut Pipelines,
        device: &Device,
        shaders: &ShaderSet,
    ) -> Result<(), Error> {
        if self.has_wireframe {
            pipelines.wireframe.prepare(device, shaders)?;
        }
        if self.has_depth_complexity {
            pipelines.layers.prepare(device, shaders)?;
        }
        if !self.is_empty() {
            pipelines.overlay.prepare(device, shaders)?;
        }
        Ok(())
    }

    /// Draws the overlay over the frame that `state` was just recorded for.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        passes: &mut FramePasses,
        executor: &PlanExecutor,
        hierarchy: &Hierarchy,
        state: &RenderView,
        view: &CullView,
    ) -> Result<(), Error> {
        if self.is_empty() {
            return Ok(());
        }
        let snapshot = VisibilitySnapshot::underway(state, hierarchy, *view);
        let draws = snapshot.upload(frame, &executor.leaves)?;
        let boxes = state.plan().tests.iter().map(|test| {
            let colour = match (test.tester, state.visibility.culler().state(test.tag.node)) {
                (VisibilityTest::SharedProxy(_), _) => BOX_BEHIND,
                (_, NodeState::Hidden) => BOX_HIDDEN,
                (_, NodeState::Unknown) => BOX_UNKNOWN,
                (_, NodeState::Visible) => BOX_SHOWED,
            };
            (hierarchy.bounds(test.tag.node), colour)
        });
        let boxes = self.has_boxes.then(|| Sketch::through(boxes).upload(frame)).transpose()?;
        self.record_depth_complexity(frame, passes, executor, view, draws)?;
        self.record_lines(frame, passes, executor, view, draws, boxes);
        self.record_corner(frame, passes, executor, hierarchy, &snapshot, draws)
    }

    /// Draws the overlay of a frozen moment over its image from another eye: its depth complexity
    /// and its wires. That image has its hidden boxes already.
    pub(crate) fn record_snapshot(
        &self,
        frame: &mut Frame<'_>,
        passes: &mut FramePasses,
        executor: &PlanExecutor,
        view: &CullView,
        draws: Option<BufferSlice>,
    ) -> Result<(), Error> {
        self.record_depth_complexity(frame, passes, executor, view, draws)?;
        self.record_lines(frame, passes, executor, view, draws, None);
        Ok(())
    }

    /// Draws the depth complexity of draws, if that is requested.
    fn record_depth_complexity(
        &self,
        frame: &mut Frame<'_>,
        passes: &mut FramePasses,
        executor: &PlanExecutor,
        view: &CullView,
        draws: Option<BufferSlice>,
    ) -> Result<(), Error> {
        if !self.has_depth_complexity {
            return Ok(());
        }
        record_depth_complexity(passes, frame, executor, view, draws)
    }

    /// Draws the edges of the triangles of `draws`, if they are requested, and boxes.
    fn record_lines(
        &self,
        frame: &mut Frame<'_>,
        passes: &mut FramePasses,
        executor: &PlanExecutor,
        view: &CullView,
        draws: Option<BufferSlice>,
        boxes: Option<OverlayIo>,
    ) {
        let has_wireframe =
            self.has_wireframe && draws.is_some() && passes.pipelines.wireframe.get().is_some();
        let has_boxes = boxes.is_some() && passes.pipelines.overlay.get().is_some();
        if !has_wireframe && !has_boxes {
            return;
        }
        passes.target.prepare(frame.commands());
        let target = passes.target_of(view, None);
        let target = passes.scope_target(frame.commands(), AttachmentSchedule::DebugLines, target);
        let Pipelines { wireframe, overlay, .. } = &passes.pipelines;
        let wireframe = wireframe.get().zip(draws).filter(|_| has_wireframe);
        let boxes = overlay.get().zip(boxes);
        frame.commands().pass(BOXES_AND_WIREFRAME, |commands| {
            commands.rendering(target, |commands| {
                if let Some((wireframe, draws)) = wireframe {
                    wireframe.bind(commands, &passes.opaque_io(), view, &passes.light);
                    executor.leaves.predicates().draw_after_counted(commands, draws);
                }
                if let Some((overlay, boxes)) = &boxes {
                    overlay.record(commands, boxes, view);
                }
            });
        });
    }

    /// Draws a moment from above, if that is requested.
    pub(crate) fn record_corner(
        &self,
        frame: &mut Frame<'_>,
        passes: &mut FramePasses,
        executor: &PlanExecutor,
        hierarchy: &Hierarchy,
        snapshot: &VisibilitySnapshot,
        draws: Option<BufferSlice>,
    ) -> Result<(), Error> {
        let Some(area) = self.top_down else { return Ok(()) };
        let reach = reach(hierarchy, snapshot);
        let io = Sketch::of(snapshot, reach).upload(frame)?;
        let view = view_in(&passes.device, &above(snapshot, reach), area);
        let view = &CullView { section: passes.section.planes, ..view };
        passes.begin_section_view(frame, hierarchy, view)?;
        passes.target.prepare(frame.commands());
        let target = passes.image_target(view, BACKGROUND);
        let target =
            passes.scope_target(frame.commands(), AttachmentSchedule::ViewFromAbove, target);
        frame.commands().pass(VIEW_FROM_ABOVE, |commands| {
            commands.rendering(target, |commands| {
                passes.draw_all(executor, commands, view, draws, Some(BACKGROUND));
                if let Some(overlay) = passes.pipelines.overlay.get() {
                    overlay.record(commands, &io, view);
                }
            });
        });
        Ok(())
    }
}
