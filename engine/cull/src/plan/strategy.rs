//! The strategies to decide what to draw, by name.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A strategy to decide what to draw. Strategies can be switched from frame to frame; those called
/// `antumbra` share one traversal and one history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// View-frustum culling only: the baseline and the reference image.
    Frustum,
    /// A query per object, and a wait for each (GPU Gems, 29.2).
    Naive,
    /// A query per object, behind some large occluders, and a wait for all (GPU Gems, 29.3).
    Batched,
    /// A query per object that is read in a later frame and decides about that one (GPU Gems,
    /// 29.4). Never waits, and is not exact: an object that comes into view is missing until its
    /// result is read back.
    NextFrame,
    /// The hierarchy from the root down, with a wait at each node (GPU Gems 2, 6.3).
    StopAndWait,
    /// Coherent hierarchical culling as published, with several submits per frame and results that
    /// are read between them (GPU Gems 2, 6.4 and 6.5).
    Coherent,
    /// Two phases against a depth pyramid, all on the GPU: draws the objects that were visible in
    /// the last frame, then those that turn out to be (as in the engines niagara and Bevy).
    Pyramid,
    /// Coherent hierarchical culling whose results come late, made exact by predicates.
    Antumbra,
    /// The same with occlusion queries for all tests.
    AntumbraQueries,
    /// The same with flags set by fragments for all tests.
    AntumbraFlags,
    /// The same with a compute shader for all tests.
    AntumbraCompute,
    /// Exactly the objects that own a pixel, found beforehand: the lower bound of every strategy
    /// (the optimum of the papers on coherent hierarchical culling). Only for comparison.
    Ideal,
}

/// The error of a name that is no strategy's.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no strategy `{name}`: use one of {known}")]
pub struct UnknownStrategy {
    /// The unknown name.
    pub name: String,
    /// The names of all strategies.
    pub known: String,
}

impl Strategy {
    /// Every strategy, the baseline first.
    pub const ALL: [Self; 12] = [
        Self::Frustum,
        Self::Naive,
        Self::Batched,
        Self::NextFrame,
        Self::StopAndWait,
        Self::Coherent,
        Self::Pyramid,
        Self::Antumbra,
        Self::AntumbraQueries,
        Self::AntumbraFlags,
        Self::AntumbraCompute,
        Self::Ideal,
    ];

    /// Returns the name on command lines and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frustum => "frustum",
            Self::Naive => "naive",
            Self::Batched => "batched",
            Self::NextFrame => "next_frame",
            Self::StopAndWait => "stop_and_wait",
            Self::Coherent => "coherent",
            Self::Pyramid => "pyramid",
            Self::Antumbra => "antumbra",
            Self::AntumbraQueries => "antumbra_queries",
            Self::AntumbraFlags => "antumbra_flags",
            Self::AntumbraCompute => "antumbra_compute",
            Self::Ideal => "ideal",
        }
    }

    /// Returns true if it never misses an object that owns a pixel, and has the image of plain
    /// frustum culling, as long as no option gives that up: a threshold where it [can have
    /// one](Strategy::can_neglect), and [`FirstPass::DepthOnly`](crate::FirstPass::DepthOnly) of
    /// [`Strategy::Coherent`], under which some devices choose another of two faces of equal depth.
    #[must_use]
    pub const fn is_exact(self) -> bool {
        match self {
            Self::NextFrame => false,
            Self::Frustum
            | Self::Naive
            | Self::Batched
            | Self::StopAndWait
            | Self::Coherent
            | Self::Pyramid
            | Self::Antumbra
            | Self::AntumbraQueries
            | Self::AntumbraFlags
            | Self::AntumbraCompute
            | Self::Ideal => true,
        }
    }

    /// Returns true if it has a history, tests in its plans and a [cost
    /// model](crate::Culler::set_costs): those called `antumbra`.
    #[must_use]
    pub const fn uses_cost_model(self) -> bool {
        matches!(
            self,
            Self::Antumbra | Self::AntumbraQueries | Self::AntumbraFlags | Self::AntumbraCompute
        )
    }

    /// Returns true if it can take objects that show few samples as hidden, and is not exact then
    /// ([`Culler::set_sample_threshold`](crate::Culler::set_sample_threshold),
    /// [`CoherentOptions`](crate::CoherentOptions)).
    #[must_use]
    pub const fn can_neglect(self) -> bool {
        matches!(self, Self::Coherent | Self::Antumbra | Self::AntumbraQueries)
    }

    /// Returns true if it draws objects that were found beforehand, in a scene that does not
    /// change.
    #[must_use]
    pub const fn needs_still_scene(self) -> bool {
        matches!(self, Self::Ideal)
    }

    /// Returns true if it needs results before a frame can go on: a
    /// [`BlockingCuller`](crate::BlockingCuller) and no plan.
    #[must_use]
    pub const fn is_blocking(self) -> bool {
        matches!(self, Self::Naive | Self::Batched | Self::StopAndWait | Self::Coherent)
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for Strategy {
    type Err = UnknownStrategy;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|strategy| strategy.name() == name).ok_or_else(|| {
            UnknownStrategy { name: name.to_owned(), known: Self::ALL.map(Self::name).join(", ") }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_parses_and_others_are_refused_by_name() {
        for strategy in Strategy::ALL {
            assert_eq!(strategy.name().parse(), Ok(strategy));
            assert_eq!(strategy.to_string(), strategy.name());
        }
        let refused = "Frustrum".parse::<Strategy>().unwrap_err().to_string();
        assert!(refused.contains("`Frustrum`") && refused.contains("frustum, naive, batched"));
    }
}
