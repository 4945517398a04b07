//! Predicated ranges: the source of a result, the draws that it decides, and the executors that
//! skip them.

use crate::core::capabilities::{Capabilities, Optional};
use crate::memory::buffer::BufferSlice;
use crate::record::access::Access;
use crate::record::indirect::DrawRange;

/// The writer of the results that decide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ResultSource {
    /// Copies of query results.
    Queries,
    /// Fragment shaders of proxies.
    Fragments,
    /// A compute shader.
    Compute,
}

impl ResultSource {
    /// All sources; their lists of predicates have this order.
    pub const ALL: [ResultSource; 3] =
        [ResultSource::Queries, ResultSource::Fragments, ResultSource::Compute];

    /// Returns the access that writes the results.
    pub fn access(self) -> Access {
        match self {
            ResultSource::Queries => Access::CopyWrite,
            ResultSource::Fragments => Access::FragmentWrite,
            ResultSource::Compute => Access::ComputeWrite,
        }
    }
}

/// The effect of a result that is not zero on its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reveal {
    /// The whole range is drawn ([`Predicates::draw`](crate::Predicates::draw)).
    #[default]
    Whole,
    /// Its draws are decided one by one: a box for each is drawn first
    /// ([`Predicates::draw_boxes`](crate::Predicates::draw_boxes)), whose fragments enable the
    /// draws ([`Predicates::draw_enabled`](crate::Predicates::draw_enabled)).
    PerLeaf,
}

/// A decision: a range of draws that depends on a result. Several may depend on one result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PredicatedRange {
    /// The number of the result among those of its source.
    pub result: u32,
    /// The draws that depend on the result.
    pub range: DrawRange,
    /// The way in which they are revealed.
    pub reveal: Reveal,
}

/// The result that decides a range of draws, for a compute shader that works for these draws alone:
/// they are drawn if the result is above the threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicate {
    /// The results of the source.
    pub results: BufferSlice,
    /// The number of the result among them.
    pub result: u32,
    /// The number of samples that a result must exceed.
    pub threshold_samples: u32,
    /// The draws that depend on it.
    pub range: DrawRange,
}

/// The executor that keeps the GPU from drawing hidden objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Predication {
    /// `VK_EXT_conditional_rendering`: the device skips the draws by itself, without a compute
    /// pass.
    Conditional,
    /// Draw counts written by a compute pass; needs `drawIndirectCount`.
    Counts,
    /// Instance counts written by a compute pass; every device.
    Instances,
}

impl Predication {
    /// Returns the best executor for a device.
    pub fn best(capabilities: &Capabilities) -> Self {
        if capabilities.has(Optional::ConditionalRendering) {
            Predication::Conditional
        } else if capabilities.has(Optional::DrawIndirectCount) {
            Predication::Counts
        } else {
            Predication::Instances
        }
    }

    /// Returns its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Predication::Conditional => "conditional",
            Predication::Counts => "counts",
            Predication::Instances => "instances",
        }
    }

    pub(super) fn needs(self) -> Option<Optional> {
        match self {
            Predication::Conditional => Some(Optional::ConditionalRendering),
            Predication::Counts => Some(Optional::DrawIndirectCount),
            Predication::Instances => None,
        }
    }
}
