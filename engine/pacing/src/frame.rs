//! The exchange between the pacer and its caller: ids, plans, waits, feedback, and the timing of
//! frames.

use std::time::Duration;

use crate::Time;

/// The id of a frame that a [`Pacer`](crate::Pacer) started, counted from 0. The id plus 1 can also
/// be used as present id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PacedFrameId(pub u64);

/// The next action of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "a step is either slept through or recorded"]
pub enum Step {
    /// Wait: sleep, deliver new feedback, call [`Pacer::next`](crate::Pacer::next) again.
    Wait(Wait),
    /// Start this frame now: read the input, record, acquire, submit and present.
    Start(Plan),
}

/// A sleep before the next step: the latest time to wake, and the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wait {
    /// The latest time to wake, at most a second from now. Waking earlier is always allowed, and
    /// best when there is new feedback.
    pub until: Time,
    /// The reason for the wait.
    pub reason: WaitReason,
}

/// The reason why no frame starts yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WaitReason {
    /// The deadline is still far: a frame started now would only wait to be shown.
    Deadline,
    /// The queue is full. With present wait, a caller may block on this frame, but no longer than
    /// the wait lasts.
    QueueFull(PacedFrameId),
    /// The limit on frames per second.
    FrameLimit,
    /// The window seems to be hidden, or frame after frame is dropped.
    Hidden,
    /// The expected end of this frame on the GPU: poll its tick, so that the pacer learns its
    /// duration.
    Poll(PacedFrameId),
}

/// A frame that starts now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The frame's id, for feedback.
    pub frame: PacedFrameId,
    /// The start time: the time given to [`Pacer::next`](crate::Pacer::next), or the latest earlier
    /// one if time went backwards.
    pub start: Time,
    /// The time at which its image should be shown: compute the animation for this time. `None`
    /// until the refreshes of the display are known.
    pub expected_present: Option<Time>,
}

/// A fact about a frame. All facts are optional except `Queued` or `Dropped`. They may arrive late,
/// twice, or out of order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedback {
    /// The call that acquired the image has returned.
    Acquired {
        /// The time of the call.
        from: Time,
        /// The time of its return.
        to: Time,
    },
    /// The work was submitted and the image handed to the presentation engine.
    Queued {
        /// The time at which these calls had returned.
        at: Time,
    },
    /// The GPU's work ended, as seen by a wait for its tick.
    Finished {
        /// The time at which the wait ended.
        at: Time,
    },
    /// The GPU's work was found finished, for example by polling its tick. It ended some time after
    /// the last [`Pacer::next`](crate::Pacer::next) or acquire, so poll before each of these calls.
    FoundFinished {
        /// The time of the poll.
        at: Time,
    },
    /// The GPU time from timestamps. It is more exact than `Finished` and `FoundFinished`, and may
    /// arrive much later.
    GpuTime(Duration),
    /// The image appeared on the screen.
    Shown {
        /// The time at which it appeared.
        at: Time,
    },
    /// The frame was not presented, or will never be: no image, no surface, or an error.
    Dropped,
}

/// The timing of a frame; unknown values are `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTiming {
    /// The time from the start of the previous frame to the start of this frame.
    pub start_interval: Option<Duration>,
    /// The time from the present time of the previous frame to the present time of this frame.
    pub present_interval: Option<Duration>,
    /// The time from the start of the frame to its present time.
    pub latency: Option<Duration>,
    /// The `present_interval` in refreshes, rounded to the nearest.
    pub refreshes: Option<u32>,
    /// The `latency` in refreshes, rounded to the nearest.
    pub latency_refreshes: Option<u32>,
    /// The number of refreshes before this frame that should have shown a new frame but did not.
    pub missed: Option<u32>,
}
