//! What hangs on a word: who wrote it, which draws it decides, and how the GPU is kept from
//! drawing.

use crate::core::capabilities::{Capabilities, Optional};
use crate::record::access::Access;
use crate::record::indirect::DrawRange;

/// Who wrote the words that decide.
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
    /// All of them.
    pub const ALL: [ResultSource; 3] =
        [ResultSource::Queries, ResultSource::Fragments, ResultSource::Compute];

    /// Returns how the words are written.
    pub fn access(self) -> Access {
        match self {
            ResultSource::Queries => Access::CopyWrite,
            ResultSource::Fragments => Access::FragmentWrite,
            ResultSource::Compute => Access::ComputeWrite,
        }
    }
}

/// What happens to a range if its word is not zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Reveal {
    /// All of it is drawn ([`Predicates::draw`](crate::Predicates::draw)).
    #[default]
    Whole,
    /// A box for each of its draws is drawn first
    /// ([`Predicates::draw_boxes`](crate::Predicates::draw_boxes)), whose fragments decide draw by
    /// draw ([`Predicates::draw_parts`](crate::Predicates::draw_parts)).
    PerLeaf,
}

/// A decision: what a word decides. Several may hang on one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PredicatedRange {
    /// The number of the word among those of its source.
    pub word: u32,
    /// The draws.
    pub range: DrawRange,
    /// What becomes of them.
    pub reveal: Reveal,
}

/// How the GPU is kept from drawing what is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Predication {
    /// `VK_EXT_conditional_rendering`.
    Conditional,
    /// Draw counts written by a compute pass; needs `drawIndirectCount`.
    Counts,
    /// Instance counts written by a compute pass; every device.
    Instances,
}

impl Predication {
    /// Returns the best one for a device.
    pub fn best(capabilities: &Capabilities) -> Self {
        if capabilities.has(Optional::ConditionalRendering) {
            Predication::Conditional
        } else if capabilities.has(Optional::DrawIndirectCount) {
            Predication::Counts
        } else {
            Predication::Instances
        }
    }

    /// Its name on the command line and in reports.
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
