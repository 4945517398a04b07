//! The parts of a frame, added one after the other to the frame of the ideal.

use antumbra::cull::Strategy;

/// A frame that lacks parts of the method's frame, from the ideal to the whole frame. Each adds a
/// part to the one before; all images are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ablation {
    /// The objects that own a pixel, without a test.
    Ideal,
    /// All objects that the method draws: first those that it takes as visible, in its order, then
    /// those that its tests reveal.
    Draws,
    /// With one query around a draw, and so with the copy of results at the end of the frame.
    ReadBack,
    /// With the queries around draws of visible objects.
    Retests,
    /// With the breaks of the rendering, each for one proxy that shows nothing.
    Breaks,
    /// With all proxies of all rounds, without consequences.
    Proxies,
    /// The recorded frame: tests reveal draws, individually or by predicates, after the breaks.
    Replay,
    /// The frame as it is: planned on the CPU.
    Whole,
}

impl Ablation {
    /// All of them, in the order in which parts are added.
    pub const ALL: [Self; 8] = [
        Self::Ideal,
        Self::Draws,
        Self::ReadBack,
        Self::Retests,
        Self::Breaks,
        Self::Proxies,
        Self::Replay,
        Self::Whole,
    ];

    /// Returns the strategy that draws frames with this ablation.
    pub(super) const fn strategy(self) -> Strategy {
        match self {
            Self::Ideal => Strategy::new("budget_ideal", "what owns a pixel"),
            Self::Draws => Strategy::new("budget_draws", "all draws, no test"),
            Self::ReadBack => Strategy::new("budget_read_back", "with one query"),
            Self::Retests => Strategy::new("budget_retests", "with queries around draws"),
            Self::Breaks => Strategy::new("budget_breaks", "with breaks"),
            Self::Proxies => Strategy::new("budget_proxies", "with all proxies"),
            Self::Replay => Strategy::new("budget_replay", "a recorded plan"),
            Self::Whole => Strategy::new("budget_whole", "planned anew, and recorded"),
        }
    }

    /// Returns the ablation of a strategy.
    pub(super) fn of(strategy: Strategy) -> Option<Self> {
        Self::ALL.into_iter().find(|ablation| ablation.strategy() == strategy)
    }

    /// Returns the part that this ablation adds to the one before.
    pub const fn part(self) -> &'static str {
        match self {
            Self::Ideal => "ideal",
            Self::Draws => "objects without a pixel, order",
            Self::ReadBack => "results at the end of the frame",
            Self::Retests => "other queries around draws",
            Self::Breaks => "breaks of the rendering",
            Self::Proxies => "proxies",
            Self::Replay => "predicates, draws after breaks",
            Self::Whole => "planning",
        }
    }
}
