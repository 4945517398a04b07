//! The claim whether an image equals the image without occlusion culling, from the facts about its
//! frame.

use super::comparison::Tally;
use crate::hud::{ExactnessVerdict, grouped};
use bench::strategy::Strategy;

/// The facts about a frame on which the claim about its image rests.
#[derive(Clone, Copy, Debug)]
pub struct ClaimBasis {
    /// The number of drawn frames of the scene.
    pub frames: u32,
    /// The number of objects of the scene.
    pub objects: u64,
    /// True while this or another scene is loading.
    pub is_loading: bool,
    /// True while meshes of the scene are being uploaded.
    pub is_uploading: bool,
    /// True if the image shows the decisions of an earlier frame.
    pub is_frozen: bool,
    /// The strategy that decides about draws.
    pub strategy: Strategy,
    /// The number of samples up to which a test counts as hidden.
    pub threshold_samples: u32,
    /// The samples that were left out by tests of the newest frame that was read back.
    pub samples_below_threshold: Option<u64>,
    /// The results of a running comparison.
    pub compared: Option<Tally>,
}

impl ClaimBasis {
    /// Returns the claim. Counted results take precedence over the properties of the strategy.
    pub fn claim(&self) -> ExactnessVerdict {
        use ExactnessVerdict::{Exact, Inexact, Unclaimed};
        if let Some(reason) = self.reason_for_none() {
            return Unclaimed(reason.to_owned());
        }
        if let Some(tally) = self.compared.filter(|tally| tally.frames > 0) {
            return match tally.differing {
                0 => Exact(tally.text()),
                _ => Inexact(tally.text()),
            };
        }
        if self.strategy == Strategy::FRUSTUM {
            return Exact("exact: the reference image".to_owned());
        }
        if !self.strategy.is_exact() {
            return Inexact("inexact: objects appear late".to_owned());
        }
        match (self.threshold_samples, self.samples_below_threshold) {
            (0, _) => Exact("exact: only hidden objects left out".to_owned()),
            (_, Some(samples)) => Inexact(format!("inexact: {} px at most", grouped(samples))),
            (most, None) => Inexact(format!("inexact: {most} px at most per test")),
        }
    }

    /// Returns the reason why nothing can be claimed, if there is one.
    fn reason_for_none(&self) -> Option<&'static str> {
        match self {
            Self { frames: 0, .. } => Some(""),
            Self { is_frozen: true, .. } => Some("frozen: drawn for an earlier view"),
            Self { objects: 0, is_loading: true, .. } => Some("nothing to draw yet: loading"),
            Self { objects: 0, .. } => Some("nothing to draw: no objects"),
            Self { is_uploading: true, .. } => Some("still uploading: more objects to come"),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the facts of a normal frame of a scene, by a strategy.
    fn drawn(strategy: Strategy) -> ClaimBasis {
        ClaimBasis {
            frames: 3,
            objects: 10,
            is_loading: false,
            is_uploading: false,
            is_frozen: false,
            strategy,
            threshold_samples: 0,
            samples_below_threshold: Some(0),
            compared: None,
        }
    }

    #[test]
    fn a_plain_frame_is_as_exact_as_its_strategy() {
        for strategy in bench::strategy::strategies() {
            let claim = drawn(strategy).claim();
            let is_exact = matches!(claim, ExactnessVerdict::Exact(_));
            assert_eq!(is_exact, strategy.is_exact(), "{strategy}: {claim:?}");
        }
    }

    #[test]
    fn nothing_is_claimed_of_an_image_that_does_not_show_the_scene_as_it_is() {
        let tally = Some(Tally { frames: 1, ..Tally::default() });
        for strategy in bench::strategy::strategies() {
            for compared in [None, tally] {
                let drawn = ClaimBasis { compared, ..drawn(strategy) };
                for (basis, reason) in [
                    (ClaimBasis { frames: 0, ..drawn }, ""),
                    (ClaimBasis { is_frozen: true, ..drawn }, "frozen"),
                    (ClaimBasis { objects: 0, is_loading: true, ..drawn }, "loading"),
                    (ClaimBasis { objects: 0, ..drawn }, "no objects"),
                    (ClaimBasis { is_uploading: true, ..drawn }, "uploading"),
                ] {
                    let ExactnessVerdict::Unclaimed(text) = basis.claim() else {
                        panic!("{basis:?}: {:?}", basis.claim());
                    };
                    assert!(text.contains(reason), "{basis:?}: {text}");
                }
            }
        }
    }

    #[test]
    fn a_scene_stays_exact_while_another_one_is_loading() {
        let drawn = drawn(Strategy::ANTUMBRA);
        assert_eq!(ClaimBasis { is_loading: true, ..drawn }.claim(), drawn.claim());
    }

    #[test]
    fn a_threshold_is_never_exact() {
        let drawn = ClaimBasis { threshold_samples: 5, ..drawn(Strategy::ANTUMBRA) };
        let inexact = |text: &str| ExactnessVerdict::Inexact(text.to_owned());
        for (samples_below_threshold, text) in [
            (None, "inexact: 5 px at most per test"),
            (Some(0), "inexact: 0 px at most"),
            (Some(4_400), "inexact: 4,400 px at most"),
        ] {
            assert_eq!(ClaimBasis { samples_below_threshold, ..drawn }.claim(), inexact(text));
        }
        let reference = ClaimBasis { strategy: Strategy::FRUSTUM, ..drawn }.claim();
        assert!(matches!(reference, ExactnessVerdict::Exact(_)), "nothing is tested");
    }

    #[test]
    fn what_was_counted_is_claimed_whatever_was_expected() {
        let equal = Tally { frames: 2, ..Tally::default() };
        let unequal = Tally { differing: 1, worst_pixels: 7, ..equal };
        for strategy in [Strategy::ANTUMBRA, antumbra::methods::NEXT_FRAME] {
            let of = |tally| ClaimBasis { compared: Some(tally), ..drawn(strategy) }.claim();
            assert_eq!(of(equal), ExactnessVerdict::Exact(equal.text()));
            assert_eq!(of(unequal), ExactnessVerdict::Inexact(unequal.text()));
        }
        let begun = ClaimBasis { compared: Some(Tally::default()), ..drawn(Strategy::ANTUMBRA) };
        assert_eq!(begun.claim(), drawn(Strategy::ANTUMBRA).claim());
    }
}
