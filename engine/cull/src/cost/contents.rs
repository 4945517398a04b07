//! The contents of a frame, and the time that it should take according to the cost table.

use std::ops::AddAssign;

use crate::cost::table::CostTable;
use crate::plan::frame_plan::{FramePlan, QueryKind, VisibilityTest};

/// The work of a frame, in counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameContents {
    /// Objects drawn.
    pub draws: u64,
    /// Triangles of the drawn objects.
    pub triangles: u64,
    /// Tests by query, including queries on own draws.
    pub queries: u32,
    /// Additional indirect calls due to queries on own draws: two per query, one for the draw and
    /// one for the draws after it.
    pub calls: u32,
    /// Boxes tested by query.
    pub queried_boxes: u32,
    /// Boxes tested by flag.
    pub flagged_boxes: u32,
    /// Boxes tested by compute shader.
    pub computed_boxes: u32,
    /// Rounds with boxes tested by compute shader.
    pub computed_rounds: u32,
    /// Pixels of all rasterised boxes.
    pub proxy_pixels: u64,
    /// Ranges of draws under a predicate.
    pub predicates: u32,
    /// Leaves in these ranges.
    pub predicated_leaves: u64,
    /// Breaks of rendering, in which results are made ready.
    pub breaks: u32,
}

impl FrameContents {
    /// Returns the contents of a plan, without draws and triangles: these are known only after the
    /// results were read back.
    #[must_use]
    pub fn of(plan: &FramePlan) -> Self {
        let mut contents = Self {
            queries: plan.query_count() as u32,
            breaks: plan.rounds.len() as u32,
            calls: 2 * plan.queried_draws.len() as u32,
            ..Self::default()
        };
        for round in &plan.rounds {
            let mut has_computed = false;
            let mut has_leaf_tests = false;
            for test in plan.tests.get(round.clone()).unwrap_or_default() {
                match test.tester {
                    VisibilityTest::Query => contents.queried_boxes += 1,
                    VisibilityTest::Flag => contents.flagged_boxes += 1,
                    VisibilityTest::Compute => contents.computed_boxes += 1,
                    VisibilityTest::SharedProxy(_) => {}
                }
                has_computed |= test.tester == VisibilityTest::Compute;
                has_leaf_tests |= test.tag.kind == QueryKind::PerLeaf;
                contents.predicates += u32::from(!test.leaves.is_empty());
                contents.predicated_leaves += u64::from(test.leaves.count);
            }
            contents.computed_rounds += u32::from(has_computed);
            // The leaf tests of a round share their break with the next round, if there is one.
            let is_last = round.end == plan.tests.len();
            contents.breaks += u32::from(has_leaf_tests && is_last);
        }
        if contents.computed_boxes == 0 {
            contents.proxy_pixels = plan.stats.proxy_pixels;
        }
        contents
    }

    /// Returns the predicted time of the frame.
    pub(crate) fn predicted(&self, table: &CostTable) -> Predicted {
        let each = |count: u32, cost_ns: f32| f64::from(count) * f64::from(cost_ns);
        // The cost of a range includes its first draw.
        let skipped = self.predicated_leaves.saturating_sub(self.predicates.into());
        let draw_ns = self.draws as f64 * f64::from(table.draw_ns)
            + self.triangles as f64 * f64::from(table.triangle_ns);
        let waits = if self.breaks > 0 { table.break_wait_share } else { 0.0 };
        let test_ns = draw_ns * f64::from(waits)
            + each(self.queries, table.query_ns)
            + each(self.calls, table.call_ns)
            + each(self.queried_boxes, table.query_box_ns)
            + each(self.flagged_boxes, table.flag_box_ns)
            + each(self.computed_boxes, table.compute_box_ns)
            + each(self.computed_rounds, table.compute_round_ns)
            + self.proxy_pixels as f64 * f64::from(table.hidden_pixel_ns)
            + each(self.predicates, table.predicate_ns)
            + skipped as f64 * f64::from(table.skipped_draw_ns)
            + each(self.breaks, table.break_ns);
        Predicted { draw_ns, test_ns }
    }
}

impl AddAssign for FrameContents {
    /// Adds the contents of another view that is drawn in the same frame.
    fn add_assign(&mut self, other: Self) {
        self.draws += other.draws;
        self.triangles += other.triangles;
        self.queries += other.queries;
        self.calls += other.calls;
        self.queried_boxes += other.queried_boxes;
        self.flagged_boxes += other.flagged_boxes;
        self.computed_boxes += other.computed_boxes;
        self.computed_rounds += other.computed_rounds;
        self.proxy_pixels += other.proxy_pixels;
        self.predicates += other.predicates;
        self.predicated_leaves += other.predicated_leaves;
        self.breaks += other.breaks;
    }
}

/// The predicted time of a frame, in nanoseconds of GPU time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Predicted {
    /// The time of its draws.
    pub(crate) draw_ns: f64,
    /// The time of its tests, with the breaks of rendering that they need.
    pub(crate) test_ns: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_takes_what_its_parts_take() {
        let table = CostTable::uniform(1.0);
        let mut contents =
            FrameContents { draws: 10, triangles: 40, queries: 3, breaks: 2, ..Default::default() };
        assert_eq!(contents.predicted(&table), Predicted { draw_ns: 50.0, test_ns: 5.0 });
        let slow = CostTable { break_wait_share: 0.5, ..table };
        assert_eq!(contents.predicted(&slow), Predicted { draw_ns: 50.0, test_ns: 30.0 });
        contents += FrameContents { draws: 1, flagged_boxes: 4, proxy_pixels: 100, ..contents };
        let both = Predicted { draw_ns: 10.0 + 40.0 + 1.0 + 40.0, test_ns: 10.0 + 104.0 };
        assert_eq!(contents.predicted(&table), both);
    }
}
