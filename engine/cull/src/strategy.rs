//! The ways to decide what to draw that share this crate's traversal.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// A way to decide what to draw. All share one traversal and one history, so that they can be
/// switched from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// View-frustum culling only: the baseline and the reference image.
    Frustum,
    /// Two phases against a depth pyramid, all on the GPU: draws what was visible in the last frame,
    /// then what turns out to be (the way of the engines niagara and Bevy).
    Pyramid,
    /// Coherent hierarchical culling whose answers come late, made exact by predicates.
    Antumbra,
    /// The same with occlusion queries for all tests.
    AntumbraQueries,
    /// The same with flags set by fragments for all tests.
    AntumbraFlags,
    /// The same with a compute shader for all tests.
    AntumbraCompute,
    /// Exactly the objects that own a pixel, found beforehand: the yardstick that nobody can beat
    /// (the optimum of the papers on coherent hierarchical culling). Not a product.
    Ideal,
}

/// A name that is no strategy's.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no strategy `{name}`: use one of {known}")]
pub struct UnknownStrategy {
    /// What was asked for.
    pub name: String,
    /// The names that there are.
    pub known: String,
}

impl Strategy {
    /// Every strategy, the baseline first.
    pub const ALL: [Self; 7] = [
        Self::Frustum,
        Self::Pyramid,
        Self::Antumbra,
        Self::AntumbraQueries,
        Self::AntumbraFlags,
        Self::AntumbraCompute,
        Self::Ideal,
    ];

    /// The name on command lines and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frustum => "frustum",
            Self::Pyramid => "pyramid",
            Self::Antumbra => "antumbra",
            Self::AntumbraQueries => "antumbra_queries",
            Self::AntumbraFlags => "antumbra_flags",
            Self::AntumbraCompute => "antumbra_compute",
            Self::Ideal => "ideal",
        }
    }

    /// True if it never misses an object that owns a pixel.
    #[must_use]
    pub const fn is_exact(self) -> bool {
        match self {
            Self::Frustum
            | Self::Pyramid
            | Self::Antumbra
            | Self::AntumbraQueries
            | Self::AntumbraFlags
            | Self::AntumbraCompute
            | Self::Ideal => true,
        }
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
        assert!(refused.contains("`Frustrum`") && refused.contains("frustum, pyramid, antumbra"));
    }
}
