//! The debug overlay of running frames: depth complexity, wireframe, boxes of the frontier, and a
//! view from above in a corner.

use crate::view_pass::ViewPass;
use cull::{CullView, NodeState, VisibilityTest};
use gpu::{BufferSlice, Device};
use occlusion::{Rect, ShaderSet};

use crate::attachment_schedule::AttachmentSchedule;
use crate::debug::depth_complexity::{DEPTH_COMPLEXITY, record_depth_complexity};
use crate::debug::outline::OUTLINE;
use crate::debug::palette::{BOX_BEHIND, BOX_HIDDEN, BOX_SHOWED, BOX_UNKNOWN};
use crate::debug::top_down::{BACKGROUND, Sketch, SketchBox, VIEW_FROM_ABOVE, above, reach};
use crate::debug::visibility_snapshot::VisibilitySnapshot;
use crate::error::Error;
use crate::host_overlay::HOST_OVERLAY;
use crate::passes::OverlayIo;
use crate::passes::pipelines::Pipelines;
use crate::render_view::RenderView;
use crate::views::view_in;

/// The overlay that explains images. It lies over the first view of a frame, shows the plan of the
/// frame and the present history, and waits for nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DebugOverlay {
    /// True to draw the edges of all triangles of visible leaves.
    pub has_wireframe: bool,
    /// True to draw the boxes of the tested nodes over everything, coloured by their state
    /// ([`BOX_HIDDEN`], [`BOX_BEHIND`], [`BOX_UNKNOWN`], [`BOX_SHOWED`]).
    pub has_boxes: bool,
    /// True to show, in place of the image, the number of surfaces of visible leaves at each pixel,
    /// including hidden surfaces ([`LAYERS`](crate::palette::LAYERS)). Transparent objects,
    /// caps and edges do not count. With several samples per pixel, a triangle counts if it covers
    /// one of them. Objects that this very frame reveals count from the next frame on.
    pub has_depth_complexity: bool,
    /// The part of the image for the view from above.
    pub top_down: Option<Rect>,
}

const BOXES_AND_WIREFRAME: &str = "boxes and wireframe";
/// The labels of the passes that explain images or lie over them. Their time is not the engine's.
pub const OVERLAY_PASSES: [&str; 5] =
    [DEPTH_COMPLEXITY, BOXES_AND_WIREFRAME, VIEW_FROM_ABOVE, OUTLINE, HOST_OVERLAY];

impl DebugOverlay {
    /// Returns true if the overlay shows nothing.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Compiles the passes that the overlay needs.
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

    /// Draws the overlay over the frame of `state` that was just recorded.
    pub(crate) fn record(
        &self,
        view_pass: &mut ViewPass<'_, '_>,
        state: &RenderView,
    ) -> Result<(), Error> {
        if self.is_empty() {
            return Ok(());
        }
        let hierarchy = view_pass.scene.hierarchy();
        let snapshot = VisibilitySnapshot::underway(state, hierarchy, *view_pass.view);
        let draws = snapshot.upload(view_pass.frame, view_pass.scene.leaves())?;
        let boxes = state.plan().tests.iter().map(|test| {
            let colour = match (test.tester, state.visibility.culler().state(test.tag.node)) {
                (VisibilityTest::SharedProxy(_), _) => BOX_BEHIND,
                (_, NodeState::Hidden) => BOX_HIDDEN,
                (_, NodeState::Unknown) => BOX_UNKNOWN,
                (_, NodeState::Visible) => BOX_SHOWED,
            };
            SketchBox { bounds: hierarchy.bounds(test.tag.node), colour }
        });
        let boxes =
            self.has_boxes.then(|| Sketch::through(boxes).upload(view_pass.frame)).transpose()?;
        self.record_depth_complexity(view_pass, draws)?;
        self.record_lines(view_pass, draws, boxes);
        self.record_corner(view_pass, &snapshot, draws)
    }

    /// Draws the depth complexity and the wireframe of a snapshot over its image. That image
    /// already shows the hidden boxes.
    pub(crate) fn record_snapshot(
        &self,
        view_pass: &mut ViewPass<'_, '_>,
        draws: Option<BufferSlice>,
    ) -> Result<(), Error> {
        self.record_depth_complexity(view_pass, draws)?;
        self.record_lines(view_pass, draws, None);
        Ok(())
    }

    /// Draws the depth complexity of draws, if requested.
    fn record_depth_complexity(
        &self,
        view_pass: &mut ViewPass<'_, '_>,
        draws: Option<BufferSlice>,
    ) -> Result<(), Error> {
        if !self.has_depth_complexity {
            return Ok(());
        }
        record_depth_complexity(view_pass, draws)
    }

    /// Draws the wireframe of `draws` and boxes, if requested.
    fn record_lines(
        &self,
        view_pass: &mut ViewPass<'_, '_>,
        draws: Option<BufferSlice>,
        boxes: Option<OverlayIo>,
    ) {
        let pipelines = &view_pass.passes.pipelines;
        let has_wireframe =
            self.has_wireframe && draws.is_some() && pipelines.wireframe.get().is_some();
        let has_boxes = boxes.is_some() && pipelines.overlay.get().is_some();
        if !has_wireframe && !has_boxes {
            return;
        }
        let target = view_pass.prepare(AttachmentSchedule::DebugLines);
        let ViewPass { passes, frame, scene, view } = view_pass;
        let Pipelines { wireframe, overlay, .. } = &passes.pipelines;
        let wireframe = wireframe.get().zip(draws).filter(|_| has_wireframe);
        let boxes = overlay.get().zip(boxes);
        frame.commands().pass(BOXES_AND_WIREFRAME, |commands| {
            commands.rendering(target, |commands| {
                if let Some((wireframe, draws)) = wireframe {
                    wireframe.bind(commands, &passes.opaque_io(), view, &passes.gpu_scene.light);
                    scene.leaves().predicates().draw_after_counted(commands, draws);
                }
                if let Some((overlay, boxes)) = &boxes {
                    overlay.record(commands, boxes, view);
                }
            });
        });
    }

    /// Draws a snapshot from above, if requested.
    pub(crate) fn record_corner(
        &self,
        view_pass: &mut ViewPass<'_, '_>,
        snapshot: &VisibilitySnapshot,
        draws: Option<BufferSlice>,
    ) -> Result<(), Error> {
        let Some(area) = self.top_down else { return Ok(()) };
        let ViewPass { passes, frame, scene, .. } = view_pass;
        let reach = reach(scene.hierarchy(), snapshot);
        let io = Sketch::of(snapshot, reach).upload(frame)?;
        let view = view_in(&passes.device, &above(snapshot, reach), area);
        let view = &CullView { section: passes.section.planes, ..view };
        passes.begin_section_view(frame, scene.hierarchy(), view)?;
        passes.target.prepare(frame.commands());
        let target = passes.image_target(view, BACKGROUND);
        let target =
            passes.scope_target(frame.commands(), AttachmentSchedule::ViewFromAbove, target);
        frame.commands().pass(VIEW_FROM_ABOVE, |commands| {
            commands.rendering(target, |commands| {
                passes.draw_all(scene, commands, view, draws, Some(BACKGROUND));
                if let Some(overlay) = passes.pipelines.overlay.get() {
                    overlay.record(commands, &io, view);
                }
            });
        });
        Ok(())
    }
}
