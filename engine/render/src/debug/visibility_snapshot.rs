//! A frozen moment of a view: the draws, and the parts of the frontier that stayed hidden.

use cull::{Aabb, CullView, FrameId, Hierarchy, LeafIndex, LeafRange, NodeState};
use gpu::{BufferSlice, Frame, IndirectDraw};
use occlusion::LeafTable;

use crate::error::Error;
use crate::render_view::{RenderView, RendererId};

/// The decisions and the results of a view in one frame.
#[derive(Debug, Clone)]
pub struct VisibilitySnapshot {
    /// The number of the frozen frame in its view.
    pub frame: FrameId,
    /// The view that it was seen from.
    pub view: CullView,
    /// The leaves that were drawn; empty after a frame of a [GPU-driven
    /// strategy](cull::Strategy::is_gpu_driven).
    pub drawn: Vec<LeafRange>,
    /// The frontier nodes that stayed hidden: box and level in the hierarchy.
    pub hidden: Vec<(Aabb, u32)>,
    /// The renderer that the leaves belong to.
    pub(crate) renderer: RendererId,
}

impl VisibilitySnapshot {
    /// Returns the newest frame of `state`, as far as it is known while the frame is in flight: the
    /// visible leaves, and the frontier nodes that were hidden in their last test.
    pub(crate) fn underway(state: &RenderView, hierarchy: &Hierarchy, view: CullView) -> Self {
        let plan = state.plan();
        let one = |first| LeafRange { first, count: 1 };
        let taken = plan.draws.iter().copied().map(one);
        let queried = plan.queried_draws.iter().map(|(leaf, _)| one(*leaf));
        let is_hidden = |node| state.visibility.culler().state(node) == NodeState::Hidden;
        let tests = plan.tests.iter().filter(|test| test.leaves.count > 0);
        let tests = tests.filter(|test| is_hidden(test.tag.node));
        Self {
            frame: plan.frame,
            view,
            drawn: taken.chain(queried).collect(),
            hidden: tests.map(|test| (hierarchy.bounds(test.tag.node), test.level)).collect(),
            renderer: state.renderer,
        }
    }

    /// Uploads the draws of the drawn leaves that still exist. Returns `None` if there are none.
    pub(crate) fn upload(
        &self,
        frame: &mut Frame<'_>,
        table: &LeafTable,
    ) -> Result<Option<BufferSlice>, Error> {
        let leaves = self.drawn.iter().flat_map(|range| {
            let first = range.first.0;
            (first..first.saturating_add(range.count)).map(LeafIndex)
        });
        let draws: Vec<IndirectDraw> = leaves.map(|leaf| table.draw(leaf)).collect();
        if draws.is_empty() {
            return Ok(None);
        }
        Ok(Some(frame.uploads().push(&draws)?))
    }
}
