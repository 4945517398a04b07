//! Explains the decision to draw an object or not, from the plan and from the history.

use crate::geom::bounds::Aabb;
use crate::geom::frustum::Containment;
use crate::geom::multi_view::{MultiView, ViewMasks};
use crate::geom::view::CullView;
use crate::hierarchy::Hierarchy;
use crate::history::record::NodeState;
use crate::ids::{FrameId, LeafIndex, NodeId, ObjectId};
use crate::plan::frame_plan::{Answer, FramePlan, QueryKind, VisibilityTest};

/// The state of a node, and the frame since which it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeHistory {
    /// The state of the node: hidden, visible or unknown.
    pub state: NodeState,
    /// The frame of the answer that led to the state, or the frame of the assumption.
    pub since: Option<FrameId>,
    /// The newest frame with an answer about the node.
    pub answered: Option<FrameId>,
    /// The frame from which on a visible leaf's own draw is tested again.
    pub next_test: Option<FrameId>,
}

/// The decision of a plan about one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Not drawn: its box is outside of the view's frustum, and no tested group contains it.
    Outside,
    /// Not drawn: section planes remove all of its box, and no tested group contains it.
    CutAway,
    /// Taken as visible and drawn, without a test.
    Drawn,
    /// Drawn, and the draw itself is tested for the frames to come.
    DrawnAndTested,
    /// Drawn, and its box is tested for the frames to come.
    DrawnAndBoxTested {
        /// The mechanism of the test.
        tester: VisibilityTest,
    },
    /// Drawn in this frame only if the box of a node shows.
    Tested {
        /// The node: the object's own leaf, or a group that contains it.
        node: NodeId,
        /// The number of objects under the node.
        leaves: u32,
        /// The depth of the node in the hierarchy.
        level: u32,
        /// The kind; [`QueryKind::PerLeaf`] if each leaf is tested individually where the node
        /// shows.
        kind: QueryKind,
        /// The mechanism of the test.
        tester: VisibilityTest,
        /// The history of the node.
        history: NodeHistory,
    },
    /// In the frustum but not in the plan: the strategy decides outside of the plan, or does not
    /// draw an object that was hidden.
    Unplanned,
}

/// The result of a frame's tests for one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// A box showed, so the object was drawn in the same frame.
    Revealed,
    /// Not drawn: the box of its node did not show, or the node showed but the object's own box did
    /// not.
    Hidden,
}

/// The explanation of the decision to draw one object in a frame or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafExplanation {
    /// The object that is explained.
    pub object: ObjectId,
    /// The box of the object in metres.
    pub bounds: Aabb,
    /// The depth of its leaf in the hierarchy.
    pub level: u32,
    /// The frame that was planned.
    pub frame: FrameId,
    /// The history of its leaf.
    pub history: NodeHistory,
    /// The decision of the plan.
    pub decision: Decision,
    leaf: LeafIndex,
    node: NodeId,
}

/// Explains the decision of `plan` about an object. The plan must be made for `views` over the
/// hierarchy in its present state; `known` returns the history of a node. Returns `None` if there
/// is no such object.
pub(crate) fn explain(
    hierarchy: &Hierarchy,
    views: MultiView<'_>,
    plan: &FramePlan,
    object: ObjectId,
    known: impl Fn(NodeId) -> NodeHistory,
) -> Option<LeafExplanation> {
    if !hierarchy.contains(object) {
        return None;
    }
    let node = hierarchy.node_of(object)?;
    let leaf = hierarchy.leaf_of(object)?;
    let bounds = hierarchy.bounds(node);
    Some(LeafExplanation {
        object,
        bounds,
        level: hierarchy.level(node),
        frame: plan.frame,
        history: known(node),
        decision: decision(hierarchy, views, plan, leaf, node, known),
        leaf,
        node,
    })
}

fn decision(
    hierarchy: &Hierarchy,
    views: MultiView<'_>,
    plan: &FramePlan,
    leaf: LeafIndex,
    node: NodeId,
    known: impl Fn(NodeId) -> NodeHistory,
) -> Decision {
    if plan.queried_draws.iter().any(|(queried, _)| *queried == leaf) {
        return Decision::DrawnAndTested;
    }
    if plan.draws.contains(&leaf) {
        let is_own = |kind| kind == QueryKind::VisibleBoxQuery;
        let own = plan.tests.iter().find(|test| test.tag.node == node && is_own(test.tag.kind));
        return own
            .map_or(Decision::Drawn, |test| Decision::DrawnAndBoxTested { tester: test.tester });
    }
    let is_outside = |is_cut_away: &dyn Fn(&CullView) -> bool| {
        let (place, _) = views.classify(&hierarchy.bounds(node), ViewMasks::ALL, is_cut_away);
        place == Containment::Outside
    };
    match plan.tests.iter().find(|test| test.leaves.contains(leaf)) {
        Some(test) => Decision::Tested {
            node: test.tag.node,
            leaves: test.leaves.count,
            level: test.level,
            kind: test.tag.kind,
            tester: test.tester,
            history: known(test.tag.node),
        },
        None if is_outside(&|_| false) => Decision::Outside,
        None if is_outside(&|view| hierarchy.is_cut_away(node, view)) => Decision::CutAway,
        None => Decision::Unplanned,
    }
}

impl LeafExplanation {
    /// Returns the outcome for the object. `answers` must hold all answers of one frame. Returns
    /// `None` if the object was not tested in that frame.
    pub fn outcome<'a>(
        &self,
        hierarchy: &Hierarchy,
        answers: impl IntoIterator<Item = &'a Answer>,
    ) -> Option<Outcome> {
        let mut outcome = None;
        for answer in answers {
            let decides = match answer.tag.kind {
                QueryKind::Leaf => answer.tag.node == self.node,
                QueryKind::Proxy | QueryKind::PerLeaf => {
                    hierarchy.leaves(answer.tag.node).contains(self.leaf)
                }
                QueryKind::PullUpQuery
                | QueryKind::VisibleBoxQuery
                | QueryKind::VisibleDrawQuery => false,
            };
            if !decides {
                continue;
            }
            // Below a node whose leaves are tested individually, the leaf itself must show.
            let is_revealed = answer.tag.kind != QueryKind::PerLeaf && answer.shows();
            if is_revealed {
                return Some(Outcome::Revealed);
            }
            outcome = Some(Outcome::Hidden);
        }
        outcome
    }
}
