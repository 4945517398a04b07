//! Occluders after a cut, when most is unknown: near leaves are drawn first, so that they can hide
//! the others in their tests.

use crate::plan::candidates::Scratch;
use crate::plan::config::CullConfig;
use crate::plan::frame_plan::PlanStats;
use crate::plan::traverse::Walk;

/// Returns true if enough is unknown for a cut of the camera.
pub(crate) fn is_cut(scratch: &Scratch, config: &CullConfig) -> bool {
    let unknown = scratch.frontier().filter(|test| test.is_unknown()).count();
    unknown >= config.tuning.cut_tests as usize
        && unknown.saturating_mul(config.tuning.cut_share as usize) >= scratch.frontier().count()
}

/// Turns the nearest unknown tests into draws, each under its own query, whose result makes it
/// known.
pub(crate) fn draw_occluders(scratch: &mut Scratch, walk: &Walk<'_>, stats: &mut PlanStats) {
    let mut left = walk.config.tuning.occluders;
    for (test, is_dropped) in scratch.tests.iter().zip(&mut scratch.is_dropped) {
        let is_fit = test.is_unknown() && test.leaf_count <= walk.config.unknown_leaves;
        if !is_fit {
            continue;
        }
        if test.leaf_count > left {
            break;
        }
        left -= test.leaf_count;
        *is_dropped = true;
        walk.leaves_in_frustum(test.node, &mut scratch.stack, |leaf| {
            scratch.retests.push(leaf);
            stats.occluders += 1;
        });
    }
    scratch.sort_retests();
    scratch.discard();
}
