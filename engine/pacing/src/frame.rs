//! The exchange between the pacer and its caller: ids, plans, waits, feedback, and the timing of
//! frames.

use std::time::Duration;

use crate::Time;

/// The id of a frame that a [`Pacer`](crate::Pacer) let start, counted from 0. Plus one, it is also
/// a good present id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PacedFrameId(pub u64);

/// The next action of the caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "a step is either slept through or recorded"]
pub enum Step {
    /// A wait: sleep, deliver new feedback, ask again.
    Wait(Wait),
    /// A start: take the input, record, acquire, submit and present this frame, now.
    Start(Plan),
}

/// A sleep before the next step, with the latest time to wake and the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wait {
    /// The latest time to wake, never more than a second from now. Waking earlier is always
    /// allowed, and right when there is new feedback.
    pub until: Time,
    /// The reason for the wait.
    pub reason: WaitReason,
}

/// The reason why a frame does not start yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WaitReason {
    /// The deadline: started now, the frame would only wait to be shown.
    Deadline,
    /// A full queue. A caller with present wait may block on this frame, no longer than the wait
    /// lasts.
    QueueFull(PacedFrameId),
    /// The limit on frames per second.
    FrameLimit,
    /// A window that seems hidden, or drops frame after frame.
    Hidden,
    /// The expected end of this frame on the GPU: look, to learn its duration.
    Poll(PacedFrameId),
}

/// A frame that starts now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The frame's id, for feedback.
    pub frame: PacedFrameId,
    /// The time of its start: the one given to [`Pacer::next`](crate::Pacer::next), or the latest
    /// before if that went backwards.
    pub start: Time,
    /// The time at which its image should be shown: animation should be computed for it. Unknown
    /// until the display is known.
    pub expected_present: Option<Time>,
}

/// A fact about a frame. All are optional except `Queued` or `Dropped`; they may come late, twice,
/// or out of order.
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
        /// The time at which the calls had returned.
        at: Time,
    },
    /// The GPU's work ended, as seen by a wait for its tick.
    Finished {
        /// The time at which the wait ended.
        at: Time,
    },
    /// The GPU's work was found finished, as by polling its tick. It ended some time after the last
    /// [`Pacer::next`](crate::Pacer::next) or acquire before, so look before each of them.
    FoundFinished {
        /// The time of the look.
        at: Time,
    },
    /// The GPU time by timestamps. More exact than both others; it may come much later.
    GpuTime(Duration),
    /// The image appeared on the screen.
    Shown {
        /// The time at which it appeared.
        at: Time,
    },
    /// The frame was not presented, or will never be: no image, no surface, an error.
    Dropped,
}

/// The timing of a frame, as far as it is known: unknown is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTiming {
    /// The time from the start of the frame before to the start of this one.
    pub start_interval: Option<Duration>,
    /// The time from the showing of the frame before to the showing of this one.
    pub present_interval: Option<Duration>,
    /// The time from its start to its showing.
    pub latency: Option<Duration>,
    /// The `present_interval` in refreshes, rounded to the nearest.
    pub refreshes: Option<u32>,
    /// The `latency` in refreshes, rounded to the nearest.
    pub latency_refreshes: Option<u32>,
    /// The number of refreshes before this frame that should have shown a new one and did not.
    pub missed: Option<u32>,
}
