//! Frame pacing: the time at which to start each frame, and statistics of how evenly frames
//! arrived.
//!
//! A frame that starts too early waits to be shown, so its input is outdated. A frame that starts
//! too late misses its refresh. A [`Pacer`] learns the refreshes of the display and the durations
//! of CPU and GPU work. It schedules each frame to be ready for the next refresh that the frame can
//! reach, and hardly sooner. The method is common in frame pacers of engines and compositors:
//! predicted times plus a margin, a short queue, and feedback from the presentation engine where
//! available.
//!
//! The crate is independent of Vulkan. It does not read a clock, sleep, start a thread, or allocate
//! after creation, and equal calls give equal answers.
//!
//! - [`Pacer::next`]: the next action, [`Step::Wait`] or [`Step::Start`].
//! - [`Pacer::feedback`]: a fact about a frame; only the fact that it was queued or dropped is
//!   required.
//! - [`Pacer::present_through`]: a new swapchain. [`Pacer::choose`]: new options of the user.
//! - [`Pacer::completed`]: the timing of each frame, for [`FrameStatistics`].
//!
//! # Guarantees
//!
//! At loads of up to 80 %, tested with a simulated presentation engine in
//! `tests/simulated_display`: at most one refresh in a thousand is missed, the queue never exceeds
//! its limit, latency is within a refresh of the optimum, and five frames after a stall the pacing
//! is regular again. For stalls of the GPU this requires [`Feedback::Finished`], or
//! [`Feedback::GpuTime`] together with [`PresentReports::Times`]. A stall that is only found by
//! polling may be taken for slower work for a while.
//!
//! With [`PresentReports::Missing`], refreshes are learnt only from acquires that had to wait, once
//! the pacer knows that they wait for the display. If acquires wait only for the GPU, refreshes
//! stay unknown. During a search for the phase, the queue may hold as many frames as there are
//! images. So create the swapchain with no more images than the queue limit.
//!
//! # The loop
//!
//! In this example the display refreshes every 10 ms, and the clock is a variable.
//!
//! ```
//! use std::time::Duration;
//!
//! use antumbra_pacing::{
//!     Feedback, FrameStatistics, HitchRule, Pacer, PacerOptions, PresentReports, Presentation,
//!     PresentationMode, Refresh, Step, Time,
//! };
//!
//! let mut pacer = Pacer::new(
//!     PacerOptions::default(),
//!     Presentation {
//!         mode: PresentationMode::Fifo,
//!         images: 3,
//!         refresh: Refresh::Unknown,
//!         reports: PresentReports::Times,
//!     },
//! )?;
//! let mut statistics = FrameStatistics::new(100, HitchRule::default())?;
//! let millis = Duration::from_millis;
//! let mut now = Time::from_origin(millis(5_000));
//! let mut reports = Vec::new();
//! let mut shown = now;
//!
//! for _ in 0..2_000 {
//!     // 1. New feedback: ticks, present waits, errors.
//!     reports.retain(|&(frame, at): &(_, Time)| {
//!         if at <= now {
//!             pacer.feedback(frame, Feedback::Shown { at });
//!         }
//!         at > now
//!     });
//!     while let Some((_, timing)) = pacer.completed() {
//!         statistics.record(timing);
//!     }
//!     // 2. The next action.
//!     match pacer.next(now) {
//!         // 3. Sleep until then, or until more is known, and ask again.
//!         Step::Wait(wait) => now = wait.until,
//!         // 4. At once: take the input, record, acquire, submit, present.
//!         Step::Start(plan) => {
//!             now = now.after(millis(2));
//!             pacer.feedback(plan.frame, Feedback::Acquired { from: now, to: now });
//!             pacer.feedback(plan.frame, Feedback::Queued { at: now });
//!             let finished = now.after(millis(3));
//!             pacer.feedback(plan.frame, Feedback::Finished { at: finished });
//!             // The display shows it at its next refresh.
//!             let ready = finished.max(shown.after(millis(1))).as_nanos();
//!             shown = Time::from_nanos(ready.next_multiple_of(10_000_000));
//!             reports.push((plan.frame, shown));
//!         }
//!     }
//! }
//!
//! let summary = statistics.summary();
//! let period = pacer.refresh_period().ok_or("unknown")?;
//! assert_eq!(period.as_micros(), 10_000);
//! assert_eq!(summary.missed_refreshes, Some(0));
//! // 5 ms of work, a little margin, and no waiting in line.
//! let latency = summary.latencies.ok_or("unknown")?.median;
//! assert!(latency < millis(7), "{latency:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(clippy::print_stderr, clippy::print_stdout, reason = "the host has the log")]
#![forbid(unsafe_code)]

mod estimate;
mod forecast;
mod frame;
mod frames;
mod margin;
mod options;
mod pacer;
mod recovery_schedule;
mod refresh_clock;
mod statistics;
mod time;

pub use frame::{Feedback, FrameTiming, PacedFrameId, Plan, Step, Wait, WaitReason};
pub use options::{
    FRAME_LIMIT_HZ, HIDDEN_INTERVAL, MAX_IMAGES, MAX_QUEUE_LIMIT, PacerOptions, PacingError,
    PresentReports, Presentation, PresentationMode, REFRESH_PERIOD, Refresh,
};
pub use pacer::Pacer;
pub use recovery_schedule::{RecoveryRules, RecoverySchedule, Retry};
pub use statistics::{
    Distribution, FrameStatistics, HISTOGRAM_BINS, HITCH_NEIGHBOURS, Histogram, HitchRule,
    MAX_STATISTICS_FRAMES, Summary,
};
pub use time::Time;
