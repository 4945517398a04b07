//! The assumptions about a driver that exactness rests on.

use std::fmt;

use cull::VisibilityTest;
use gpu::PredicationMode;

/// An assumption about the driver of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DriverAssumption {
    /// Occlusion queries distinguish visible from hidden, and give exact numbers where they must
    /// count.
    QueryCounts,
    /// The results of a frame are in mapped memory when its tick is over.
    LateResults,
    /// A proxy covers every sample that its object covers: vertices are snapped as finely as the
    /// device reports.
    ProxyCoverage,
    /// No fragment of a proxy is farther than the fragment of its object at the same sample.
    ProxyDepth,
    /// Fragment shaders with early tests write nothing where the depth test fails.
    EarlyTests,
    /// Later commands see the writes of fragment shaders.
    FlagWrites,
    /// Compute shaders read the depth that was drawn.
    ComputedDepths,
    /// Conditional rendering skips draws whose predicate is zero, and no others.
    ConditionalRendering,
    /// Draw counts from a buffer are obeyed.
    DrawCounts,
    /// Instance counts that a compute shader wrote are obeyed.
    InstanceCounts,
    /// Lists of commands that compute shaders wrote, with their counts, are drawn in their order.
    CompactedLists,
    /// If only nearer fragments pass, the first of several draws with equal depth wins, within one
    /// call and between calls.
    DrawOrder,
    /// Two passes compute the same depth for the same vertex.
    RepeatedDepth,
    /// A walk with occlusion queries gives the same images as frustum culling.
    QueriedWalk,
    /// A walk with flags gives the same images as frustum culling.
    FlaggedWalk,
    /// A walk with the compute tester gives the same images as frustum culling.
    ComputedWalk,
}

/// The part of the engine that depends on an assumption.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Support {
    /// These testers.
    Testers(&'static [VisibilityTest]),
    /// These executors of predicates.
    Executors(&'static [PredicationMode]),
    /// Only speed: late results steer what is tested, but images are correct with any results.
    Speed,
    /// Every strategy, including plain frustum culling.
    Everything,
}

impl DriverAssumption {
    /// All assumptions, in the order in which they are checked.
    pub const ALL: [Self; 16] = [
        Self::QueryCounts,
        Self::LateResults,
        Self::ProxyCoverage,
        Self::ProxyDepth,
        Self::EarlyTests,
        Self::FlagWrites,
        Self::ComputedDepths,
        Self::ConditionalRendering,
        Self::DrawCounts,
        Self::InstanceCounts,
        Self::CompactedLists,
        Self::DrawOrder,
        Self::RepeatedDepth,
        Self::QueriedWalk,
        Self::FlaggedWalk,
        Self::ComputedWalk,
    ];

    /// Returns the name of the assumption in tables and warnings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::QueryCounts => "query counts",
            Self::LateResults => "late results",
            Self::ProxyCoverage => "proxy coverage",
            Self::ProxyDepth => "proxy depth",
            Self::EarlyTests => "early tests",
            Self::FlagWrites => "flag writes",
            Self::ComputedDepths => "computed depths",
            Self::ConditionalRendering => "conditional rendering",
            Self::DrawCounts => "draw counts",
            Self::InstanceCounts => "instance counts",
            Self::CompactedLists => "compacted lists",
            Self::DrawOrder => "draw order",
            Self::RepeatedDepth => "repeated depth",
            Self::QueriedWalk => "walk with queries",
            Self::FlaggedWalk => "walk with flags",
            Self::ComputedWalk => "walk with the compute tester",
        }
    }

    /// Returns the engine's reaction to a broken assumption, as a part of a sentence.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self.support() {
            Support::Testers([_]) => "another tester is used",
            Support::Testers(_) => "no test draws boxes",
            Support::Executors(_) => "draws are skipped in another way",
            Support::Speed => "images stay right, frames are slower",
            Support::Everything => "nothing can replace it",
        }
    }

    /// Returns the part of the engine that depends on the assumption.
    pub(super) const fn support(self) -> Support {
        const QUERY: &[VisibilityTest] = &[VisibilityTest::Query];
        const FLAG: &[VisibilityTest] = &[VisibilityTest::Flag];
        const COMPUTE: &[VisibilityTest] = &[VisibilityTest::Compute];
        match self {
            Self::QueryCounts | Self::QueriedWalk => Support::Testers(QUERY),
            Self::ProxyCoverage | Self::ProxyDepth => {
                Support::Testers(&[VisibilityTest::Query, VisibilityTest::Flag])
            }
            Self::EarlyTests | Self::FlagWrites | Self::FlaggedWalk => Support::Testers(FLAG),
            Self::ComputedDepths | Self::ComputedWalk => Support::Testers(COMPUTE),
            Self::ConditionalRendering => Support::Executors(&[PredicationMode::Conditional]),
            Self::DrawCounts => {
                Support::Executors(&[PredicationMode::Counts, PredicationMode::Compacted])
            }
            Self::InstanceCounts => Support::Executors(&[PredicationMode::Instances]),
            Self::CompactedLists => Support::Executors(&[PredicationMode::Compacted]),
            Self::LateResults => Support::Speed,
            Self::DrawOrder | Self::RepeatedDepth => Support::Everything,
        }
    }
}

impl fmt::Display for DriverAssumption {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}
