//! The record of one node.

use std::num::NonZeroU32;

/// The visibility of a node in a view, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NodeState {
    /// Never tested, or the result is no longer valid.
    #[default]
    Unknown,
    /// A leaf that showed, or an inner node with a visible node below it.
    Visible,
    /// No part of the node showed in its last test.
    Hidden,
}

/// The information that the cost model gets from the answer to a leaf's own draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum RetestReason {
    /// A visible leaf: the answer says if it is still visible.
    #[default]
    None,
    /// An unknown leaf that was drawn without a test: the answer says if it is visible.
    Assumed,
    /// No information: the leaf crosses the edge of the frustum, and its visible part may be
    /// outside.
    Edge,
}

/// A frame in 32 bits, counted from the culler's epoch; 0 stands for never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FrameStamp(u32);

impl FrameStamp {
    pub(crate) const NEVER: Self = Self(0);
    pub(crate) const FIRST: Self = Self(1);

    /// Creates a stamp; `None` for 0 and for numbers above 32 bits.
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

    /// Returns true if it is a node's turn in this frame. Each node has one turn in `spread`
    /// frames, and only in a frame whose number is a multiple of `gate`.
    pub(crate) const fn is_turn_of(self, node: u32, spread: u32, gate: u32) -> bool {
        let gate = if gate > 0 { gate } else { 1 };
        let turns = if spread > gate { spread / gate } else { 1 };
        let mixed = node.wrapping_mul(0x9e37_79b1) >> 8;
        spread > 0
            && self.0.is_multiple_of(gate)
            && mixed.wrapping_add(self.0 / gate).is_multiple_of(turns)
    }

    /// Returns true if it was less than `frames` frames before `now`.
    pub(crate) fn is_within(self, now: Self, frames: u32) -> bool {
        self != Self::NEVER && now.since(self) < frames
    }

    /// Returns the number of frames from `earlier` to this one; 0 if `earlier` is later.
    pub(crate) const fn since(self, earlier: Self) -> u32 {
        self.0.saturating_sub(earlier.0)
    }
}

/// The history of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NodeRecord {
    pub(crate) state: NodeState,
    /// Leaves: the number of own-draw tests in a row that showed. Inner nodes: the number of
    /// pull-up queries that failed.
    pub(crate) stable_queries: u8,
    /// Leaves: the number of times that it showed soon after it did not.
    pub(crate) flicker_count: u8,
    /// Leaves: the meaning of the next answer about an own draw.
    pub(crate) retest_reason: RetestReason,
    /// The frame whose answer led to the state.
    pub(crate) since: FrameStamp,
    /// The newest frame in which the traversal visited the node or the GPU tested it.
    pub(crate) visited: FrameStamp,
    /// The newest frame whose answer was taken.
    pub(crate) answered: FrameStamp,
    /// Visible leaves: the frame of the next own-draw test. Open inner nodes: the frame of the next
    /// pull-up query.
    pub(crate) due: FrameStamp,
}

impl NodeRecord {
    /// Returns true if the last visit was at most `stale_frames` frames ago.
    pub(crate) fn is_fresh(&self, now: FrameStamp, stale_frames: u32) -> bool {
        self.visited != FrameStamp::NEVER && now.since(self.visited) <= stale_frames
    }

    /// Returns true if a test of a visible leaf's own draw is due. Leaves that are overdue, or not
    /// due, by more than `spread` frames take turns over `spread` frames. Tests occur only in
    /// frames whose number is a multiple of `gate`.
    pub(crate) fn is_due(&self, node: u32, now: FrameStamp, spread: u32, gate: u32) -> bool {
        let is_turn = || now.is_turn_of(node, spread, gate);
        if gate > 1 && !now.0.is_multiple_of(gate) {
            false
        } else if spread == 0 {
            self.due <= now
        } else if self.due <= now {
            // All leaves that became due since the last such frame would be too many for one frame.
            is_turn() || (gate <= 1 && now.since(self.due) <= spread)
        } else {
            self.due.since(now) > spread && is_turn()
        }
    }

    /// Returns the number of frames for which it was hidden and visited; time outside of the
    /// frustum does not count.
    pub(crate) fn hidden_frames(&self) -> u32 {
        self.visited.since(self.since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_frame_has_passed_since_what_is_later() {
        let early = FrameStamp::FIRST;
        let late = early.plus(7);
        assert_eq!((late.since(early), early.since(late)), (7, 0));
        // An answer of a newer frame than that of the last visit hid it.
        let record = NodeRecord { since: late, visited: early, ..NodeRecord::default() };
        assert_eq!(record.hidden_frames(), 0);
    }
}
