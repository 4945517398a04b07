//! One moment of a view, frozen: what was drawn, and which parts of the frontier stayed hidden.

use cull::{Aabb, Answer, FrameId, Hierarchy, LeafIndex, LeafRange, NodeState, QueryKind, View};
use gpu::{BufferSlice, Frame, IndirectDraw};
use occlusion::LeafTable;

use crate::error::Error;
use crate::renderer::Renderer;
use crate::view_state::{RendererId, ViewState};

/// What a view decided and found out in one frame.
#[derive(Debug, Clone)]
pub struct VisibilitySnapshot {
    /// The frame.
    pub frame: FrameId,
    /// The view it was seen from.
    pub view: View,
    /// The leaves that were drawn, where the CPU is told: not after a frame of
    /// [`Strategy::Pyramid`](cull::Strategy::Pyramid).
    pub drawn: Vec<LeafRange>,
    /// The frontier nodes that stayed hidden: box and level in the hierarchy.
    pub hidden: Vec<(Aabb, u32)>,
    /// The one whose leaves these are.
    pub(crate) renderer: RendererId,
}

impl Renderer {
    /// Freezes the newest frame of `history`, which was seen from `view`. Waits for it.
    ///
    /// # Errors
    /// A view of another renderer, a lost device, or a frame that takes too long.
    pub fn snapshot(
        &mut self,
        history: &mut ViewState,
        view: View,
    ) -> Result<VisibilitySnapshot, Error> {
        self.drain(history)?;
        let plan = history.plan();
        let one = |first| LeafRange { first, count: 1 };
        let taken = plan.draws.iter().copied().map(one);
        let queried = plan.queried_draws.iter().map(|(leaf, _)| one(*leaf));
        let mut snapshot = VisibilitySnapshot {
            frame: plan.frame,
            view,
            drawn: taken.chain(queried).collect(),
            hidden: Vec::new(),
            renderer: self.id,
        };
        let mut showed = Vec::new();
        let of_frame =
            |answer: &&Answer| history.visibility.shows(answer) && answer.tag.frame == plan.frame;
        for answer in history.visibility.newest_answers().iter().filter(of_frame) {
            let node = answer.tag.node;
            match answer.tag.kind {
                QueryKind::Proxy | QueryKind::Part => {
                    snapshot.drawn.push(self.hierarchy.leaves(node));
                    showed.push(node);
                }
                QueryKind::Parts => showed.push(node),
                QueryKind::Probe | QueryKind::OwnBox | QueryKind::OwnDraw => {}
            }
        }
        showed.sort_unstable();
        let tests = plan.tests.iter().filter(|test| test.leaves.count > 0);
        for test in tests.filter(|test| showed.binary_search(&test.tag.node).is_err()) {
            snapshot.hidden.push((self.hierarchy.bounds(test.tag.node), test.level));
        }
        Ok(snapshot)
    }
}

impl VisibilitySnapshot {
    /// The newest frame of `history` as far as it is known while it is under way: what is taken as
    /// visible, and the frontier nodes that were hidden when they were last asked.
    pub(crate) fn underway(history: &ViewState, hierarchy: &Hierarchy, view: View) -> Self {
        let plan = history.plan();
        let one = |first| LeafRange { first, count: 1 };
        let taken = plan.draws.iter().copied().map(one);
        let queried = plan.queried_draws.iter().map(|(leaf, _)| one(*leaf));
        let is_hidden = |node| history.visibility.culler().state(node) == NodeState::Hidden;
        let tests = plan.tests.iter().filter(|test| test.leaves.count > 0);
        let tests = tests.filter(|test| is_hidden(test.tag.node));
        Self {
            frame: plan.frame,
            view,
            drawn: taken.chain(queried).collect(),
            hidden: tests.map(|test| (hierarchy.bounds(test.tag.node), test.level)).collect(),
            renderer: history.renderer,
        }
    }

    /// The draws of what was drawn, of as many leaves as there still are.
    pub(crate) fn upload(
        &self,
        frame: &mut Frame<'_>,
        table: &LeafTable,
    ) -> Result<(BufferSlice, u32), Error> {
        let leaves = self.drawn.iter().flat_map(|range| {
            let first = range.first.0;
            (first..first.saturating_add(range.count)).map(LeafIndex)
        });
        let draws: Vec<IndirectDraw> = leaves.map(|leaf| table.draw(leaf)).collect();
        Ok((frame.uploads().push(&draws)?, draws.len() as u32))
    }
}
