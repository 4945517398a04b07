//! The assumptions about a driver, as sets of bits.

use occlusion::DriverAssumption;

use crate::error::Failure;

/// Occlusion queries distinguish visible from hidden geometry, and count exactly.
pub const ANTUMBRA_ASSUMPTION_QUERY_COUNTS: u32 = 1 << 0;
/// The results of a frame are in mapped memory when the frame is over.
pub const ANTUMBRA_ASSUMPTION_LATE_RESULTS: u32 = 1 << 1;
/// A proxy covers every sample that its object covers.
pub const ANTUMBRA_ASSUMPTION_PROXY_COVERAGE: u32 = 1 << 2;
/// A fragment of a proxy is never farther away than the object's fragment at the same sample.
pub const ANTUMBRA_ASSUMPTION_PROXY_DEPTH: u32 = 1 << 3;
/// Fragment shaders with early tests write nothing where the depth test fails.
pub const ANTUMBRA_ASSUMPTION_EARLY_TESTS: u32 = 1 << 4;
/// Later commands see the writes of fragment shaders.
pub const ANTUMBRA_ASSUMPTION_FLAG_WRITES: u32 = 1 << 5;
/// Compute shaders read the depth that was drawn.
pub const ANTUMBRA_ASSUMPTION_COMPUTED_DEPTHS: u32 = 1 << 6;
/// Conditional rendering skips draws whose predicate is zero, and no others.
pub const ANTUMBRA_ASSUMPTION_CONDITIONAL_RENDERING: u32 = 1 << 7;
/// Draws obey draw counts in a buffer.
pub const ANTUMBRA_ASSUMPTION_DRAW_COUNTS: u32 = 1 << 8;
/// Draws obey instance counts that a compute shader wrote.
pub const ANTUMBRA_ASSUMPTION_INSTANCE_COUNTS: u32 = 1 << 9;
/// Lists of commands that compute shaders wrote are drawn in their order.
pub const ANTUMBRA_ASSUMPTION_COMPACTED_LISTS: u32 = 1 << 10;
/// Of draws with equal depth the first one wins.
pub const ANTUMBRA_ASSUMPTION_DRAW_ORDER: u32 = 1 << 11;
/// Two passes give the same vertex the same depth.
pub const ANTUMBRA_ASSUMPTION_REPEATED_DEPTH: u32 = 1 << 12;
/// A walk with occlusion queries draws the same images as frustum culling.
pub const ANTUMBRA_ASSUMPTION_QUERIED_WALK: u32 = 1 << 13;
/// A walk with flags draws the same images as frustum culling.
pub const ANTUMBRA_ASSUMPTION_FLAGGED_WALK: u32 = 1 << 14;
/// A walk with the compute tester draws the same images as frustum culling.
pub const ANTUMBRA_ASSUMPTION_COMPUTED_WALK: u32 = 1 << 15;

/// Each bit with its assumption.
pub(crate) const BITS: [(u32, DriverAssumption); DriverAssumption::ALL.len()] = [
    (ANTUMBRA_ASSUMPTION_QUERY_COUNTS, DriverAssumption::QueryCounts),
    (ANTUMBRA_ASSUMPTION_LATE_RESULTS, DriverAssumption::LateResults),
    (ANTUMBRA_ASSUMPTION_PROXY_COVERAGE, DriverAssumption::ProxyCoverage),
    (ANTUMBRA_ASSUMPTION_PROXY_DEPTH, DriverAssumption::ProxyDepth),
    (ANTUMBRA_ASSUMPTION_EARLY_TESTS, DriverAssumption::EarlyTests),
    (ANTUMBRA_ASSUMPTION_FLAG_WRITES, DriverAssumption::FlagWrites),
    (ANTUMBRA_ASSUMPTION_COMPUTED_DEPTHS, DriverAssumption::ComputedDepths),
    (ANTUMBRA_ASSUMPTION_CONDITIONAL_RENDERING, DriverAssumption::ConditionalRendering),
    (ANTUMBRA_ASSUMPTION_DRAW_COUNTS, DriverAssumption::DrawCounts),
    (ANTUMBRA_ASSUMPTION_INSTANCE_COUNTS, DriverAssumption::InstanceCounts),
    (ANTUMBRA_ASSUMPTION_COMPACTED_LISTS, DriverAssumption::CompactedLists),
    (ANTUMBRA_ASSUMPTION_DRAW_ORDER, DriverAssumption::DrawOrder),
    (ANTUMBRA_ASSUMPTION_REPEATED_DEPTH, DriverAssumption::RepeatedDepth),
    (ANTUMBRA_ASSUMPTION_QUERIED_WALK, DriverAssumption::QueriedWalk),
    (ANTUMBRA_ASSUMPTION_FLAGGED_WALK, DriverAssumption::FlaggedWalk),
    (ANTUMBRA_ASSUMPTION_COMPUTED_WALK, DriverAssumption::ComputedWalk),
];

/// Returns the assumptions of a set.
pub(crate) fn assumptions(bits: u32) -> Result<Vec<DriverAssumption>, Failure> {
    let known: u32 = BITS.iter().map(|(bit, _)| bit).sum();
    if bits & !known != 0 {
        return Err(Failure::argument(format_args!(
            "desc.disabled has the bits {:#x}, and there is no ANTUMBRA_ASSUMPTION_.. of that",
            bits & !known
        )));
    }
    Ok(BITS.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, assumption)| *assumption).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_assumption_has_a_bit_in_the_order_of_the_self_test() {
        let of_bits: Vec<DriverAssumption> =
            BITS.iter().map(|(_, assumption)| *assumption).collect();
        assert_eq!(of_bits, DriverAssumption::ALL);
        assert!(BITS.iter().enumerate().all(|(place, (bit, _))| *bit == 1 << place));
        assert_eq!(assumptions(u32::from(u16::MAX)).unwrap(), DriverAssumption::ALL);
        assert!(assumptions(1 << 16).is_err());
    }
}
