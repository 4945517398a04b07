//! Plans whose draws have no queries around them: plans of two phases, and plans without queries.

use crate::geom::multi_view::ViewMasks;
use crate::ids::NodeId;
use crate::plan::candidates::{Candidate, Draw, Scratch};
use crate::plan::frame_plan::{PlanStats, QueryKind};
use crate::plan::traverse::Walk;

/// Draws the retests without a query and tests their boxes instead, within the same budget.
pub(crate) fn test_boxes_of_retests(scratch: &mut Scratch, walk: &Walk<'_>, stats: &mut PlanStats) {
    if scratch.retests.is_empty() {
        return;
    }
    for retest in scratch.retests.drain(..) {
        scratch.draws.push(Draw { nearness: retest.nearness, leaf: retest.leaf });
        let bounds = walk.hierarchy.bounds(NodeId(retest.node));
        let (_, masks) = walk.classify(NodeId(retest.node), ViewMasks::ALL);
        // A box that the near plane cuts has no proxy.
        let Some(proxy) = walk.views.proxy(&bounds, masks) else { continue };
        stats.visible_box_queries += 1;
        scratch.tests.push(Candidate {
            nearness: retest.nearness,
            node: retest.node,
            kind: QueryKind::VisibleDrawQuery,
            proxy,
            leaf_count: 1,
            inherited: None,
            hidden_frames: Some(0),
        });
    }
    scratch.sort_draws();
    scratch.sort_tests();
    scratch.keep_all();
}
