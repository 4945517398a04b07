//! Fits the tests of a traversal into the budget of queries.
//!
//! Tests that decide about draws come first. If there are more of them than queries, the tests with
//! the most leaves stay and the leaves of the others are drawn. Pull-up queries and own-draw tests
//! share the remaining queries: a pull-up query saves tests of later frames, and a leaf without its
//! own-draw test is simply drawn.

use crate::plan::candidates::{Draw, Scratch};
use crate::plan::config::CullConfig;
use crate::plan::frame_plan::{PlanStats, QueryKind};
use crate::plan::traverse::Walk;

/// The number of pull-up queries that a frame may have even if it has few tests. Halving or
/// doubling it changes no count of a walk by more than 1 % (docs/lab/cull_config.md).
const MIN_PULL_UPS: usize = 16;

/// Makes the lists fit into `budget` queries.
pub(crate) fn fit(scratch: &mut Scratch, walk: &Walk<'_>, budget: usize, stats: &mut PlanStats) {
    drop_tests(scratch, walk, budget, stats);
    drop_optional(scratch, walk.config, budget, stats);
    scratch.count(stats);
}

/// Draws the leaves of the smallest tests where there are more tests than queries.
fn drop_tests(scratch: &mut Scratch, walk: &Walk<'_>, budget: usize, stats: &mut PlanStats) {
    let excess = scratch.frontier().count().saturating_sub(budget);
    if excess == 0 {
        return;
    }
    scratch.by_size.clear();
    let frontier = (0_u32..).zip(&scratch.tests).filter(|(_, test)| test.kind == QueryKind::Proxy);
    scratch.by_size.extend(frontier.map(|(position, _)| position));
    // Among equals the nearest are drawn: they are the most likely to be visible.
    let tests = &scratch.tests;
    scratch
        .by_size
        .sort_unstable_by_key(|position| (tests[*position as usize].leaf_count, *position));
    for position in &scratch.by_size[..excess] {
        scratch.is_dropped[*position as usize] = true;
        let node = scratch.tests[*position as usize].node;
        walk.leaves_in_frustum(node, &mut scratch.stack, |leaf| {
            scratch.draws.push(Draw { nearness: leaf.nearness, leaf: leaf.leaf });
            stats.over_budget += 1;
        });
    }
    scratch.discard();
    scratch.sort_draws();
}

/// Leaves out pull-up queries and own-draw tests for which no queries are left.
fn drop_optional(scratch: &mut Scratch, config: &CullConfig, budget: usize, stats: &mut PlanStats) {
    let frontier = scratch.frontier().count();
    let left = budget.saturating_sub(frontier);
    let wished = scratch.tests.iter().filter(|test| test.kind == QueryKind::PullUpQuery).count();
    let share = frontier / (config.tuning.tests_per_pull_up.max(1) as usize);
    let pull_ups = wished
        .min(share.max(MIN_PULL_UPS))
        .min((left / 2).max(left.saturating_sub(scratch.retests.len())));
    let mut remaining = pull_ups;
    for (test, is_dropped) in scratch.tests.iter().zip(&mut scratch.is_dropped) {
        if test.kind == QueryKind::PullUpQuery {
            *is_dropped = remaining == 0;
            remaining = remaining.saturating_sub(1);
        }
    }
    scratch.discard();
    stats.pull_up_queries = pull_ups as u32;
    let retests = left - pull_ups;
    if scratch.retests.len() > retests {
        scratch.draw_unasked(retests);
        scratch.sort_draws();
    }
}
