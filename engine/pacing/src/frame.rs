//! What goes between the pacer and its caller: ids, plans, waits, feedback, and what became of a
//! frame.

use std::time::Duration;

use crate::Time;

/// A frame that a [`Pacer`](crate::Pacer) let start, counted from 0. Also a good present id, plus
/// one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PacedFrameId(pub u64);

/// What to do now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "a step is either slept through or recorded"]
pub enum Step {
    /// Sleep, deliver what became known, ask again.
    Wait(Wait),
    /// Take the input, record, acquire, submit and present this frame, now.
    Start(Plan),
}

/// A sleep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wait {
    /// Until when at the latest, never more than a second from now. Waking earlier is always
    /// allowed, and right when something became known.
    pub until: Time,
    /// What is waited for.
    pub reason: WaitReason,
}

/// Why a frame does not start yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WaitReason {
    /// Started now it would only wait to be shown.
    Deadline,
    /// So many frames are queued as may be. A caller with present wait may block on this one,
    /// no longer than the wait says.
    QueueFull(PacedFrameId),
    /// The limit on frames per second.
    FrameLimit,
    /// Nobody seems to see the window, or its frames are dropped one after the other.
    Hidden,
    /// The GPU should be done with this frame about then: look, to learn how long it took.
    Poll(PacedFrameId),
}

/// A frame that starts now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// To name it in feedback.
    pub frame: PacedFrameId,
    /// When it starts: the time that was given to [`Pacer::next`](crate::Pacer::next), or the
    /// latest before if that went backwards.
    pub start: Time,
    /// When its picture should show; animation is right for that time. Unknown until the display is
    /// known.
    pub expected_present: Option<Time>,
}

/// What became known of a frame. All of it is optional but `Queued` or `Dropped`; it may come late,
/// twice, or out of order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedback {
    /// The call that acquired the image took from then until then.
    Acquired {
        /// When it was called.
        from: Time,
        /// When it returned.
        to: Time,
    },
    /// Work was submitted and the image handed to the presentation engine.
    Queued {
        /// When the calls had returned.
        at: Time,
    },
    /// The GPU's work ended: somebody waited for its tick, and this is when the wait ended.
    Finished {
        /// When it ended.
        at: Time,
    },
    /// The GPU's work was found finished, as by polling its tick. It ended some time after the last
    /// [`Pacer::next`](crate::Pacer::next) or acquire before, so look each time before either.
    FoundFinished {
        /// When somebody looked.
        at: Time,
    },
    /// How long the GPU took, by its timestamps. Better than both; may come long after.
    GpuTime(Duration),
    /// The image began to show.
    Shown {
        /// When it did.
        at: Time,
    },
    /// It was not presented, or will never be: no image, no surface, an error.
    Dropped,
}

/// What became of a frame, as far as anyone knows: unknown is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTiming {
    /// From the start of the frame before to the start of this one.
    pub start_interval: Option<Duration>,
    /// From the showing of the frame before to the showing of this one.
    pub present_interval: Option<Duration>,
    /// From its start to its showing.
    pub latency: Option<Duration>,
    /// `present_interval` in refreshes, to the nearest.
    pub refreshes: Option<u32>,
    /// `latency` in refreshes, to the nearest.
    pub latency_refreshes: Option<u32>,
    /// Refreshes before this frame that should have shown a new one and did not.
    pub missed: Option<u32>,
}
