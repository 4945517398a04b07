//! What is remembered of one node.

use std::num::NonZeroU32;

/// What is known of a node in a view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeState {
    /// Never asked, or what was known is void.
    #[default]
    Unknown,
    /// A leaf that showed, or an inner node with something below that did.
    Visible,
    /// Nothing of it showed when it was last asked.
    Hidden,
}

/// What an answer to a leaf's own draw says about the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum RetestReason {
    /// Whether what was visible still is.
    #[default]
    None,
    /// Whether what was unknown, and drawn without a test, is visible.
    Assumed,
    /// Nothing: it sticks out of the frustum, and what shows of it may be outside.
    Edge,
}

/// A frame in 32 bits, counted from the culler's epoch; 0 stands for never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FrameStamp(u32);

impl FrameStamp {
    pub(crate) const NEVER: Self = Self(0);
    pub(crate) const FIRST: Self = Self(1);

    /// `None` for 0 and for what does not fit.
    pub(crate) fn new(frames: u64) -> Option<Self> {
        let frames = NonZeroU32::new(u32::try_from(frames).ok()?)?;
        Some(Self(frames.get()))
    }

    /// Returns the frames since the epoch; `None` for never.
    pub(crate) fn frames(self) -> Option<u64> {
        (self != Self::NEVER).then_some(self.0.into())
    }

    pub(crate) const fn plus(self, frames: u32) -> Self {
        Self(self.0.saturating_add(frames))
    }

    /// Returns true if it is a node's turn in this frame, where each has one in `spread` frames.
    /// Turns come in every frame whose number is a multiple of `gate` only.
    pub(crate) const fn is_turn_of(self, node: u32, spread: u32, gate: u32) -> bool {
        let gate = if gate > 0 { gate } else { 1 };
        let turns = if spread > gate { spread / gate } else { 1 };
        let mixed = node.wrapping_mul(0x9e37_79b1) >> 8;
        spread > 0
            && self.0.is_multiple_of(gate)
            && mixed.wrapping_add(self.0 / gate).is_multiple_of(turns)
    }

    /// Returns true if it was less than so many frames before `now`.
    pub(crate) fn is_within(self, now: Self, frames: u32) -> bool {
        self != Self::NEVER && now.since(self) < frames
    }

    /// Frames from `earlier` to here; 0 if it is later.
    pub(crate) const fn since(self, earlier: Self) -> u32 {
        self.0.saturating_sub(earlier.0)
    }
}

/// The history of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NodeRecord {
    pub(crate) state: NodeState,
    /// Leaves: own-draw tests that succeeded one after the other. Inner nodes: probes that failed.
    pub(crate) stable_queries: u8,
    /// Leaves: how often it showed soon after it did not.
    pub(crate) flicker_count: u8,
    /// Leaves: how much the next answer to an own draw says.
    pub(crate) retest_reason: RetestReason,
    /// The frame whose answer brought the state about.
    pub(crate) since: FrameStamp,
    /// The youngest frame in which the traversal is known to have come here, or the GPU to have
    /// looked.
    pub(crate) visited: FrameStamp,
    /// The youngest frame that is known to have answered.
    pub(crate) answered: FrameStamp,
    /// Visible leaves: when to test the own draw. Open inner nodes: when to probe.
    pub(crate) due: FrameStamp,
}

impl NodeRecord {
    /// Returns true if that was lately.
    pub(crate) fn is_fresh(&self, now: FrameStamp, stale_frames: u32) -> bool {
        self.visited != FrameStamp::NEVER && now.since(self.visited) <= stale_frames
    }

    /// Returns true if a visible leaf's own draw is to be tested. Where it should have been long
    /// ago, or is not for long, leaves take turns over `spread` frames. Only in every `gate`th
    /// frame.
    pub(crate) fn is_due(&self, node: u32, now: FrameStamp, spread: u32, gate: u32) -> bool {
        let is_turn = || now.is_turn_of(node, spread, gate);
        if gate > 1 && !now.0.is_multiple_of(gate) {
            false
        } else if spread == 0 {
            self.due <= now
        } else if self.due <= now {
            // All that were due since the last such frame are too many for one.
            is_turn() || (gate <= 1 && now.since(self.due) <= spread)
        } else {
            self.due.since(now) > spread && is_turn()
        }
    }

    /// For how long it has been watched and was hidden; time out of sight does not count.
    pub(crate) fn hidden_frames(&self) -> u32 {
        self.visited.since(self.since)
    }
}
