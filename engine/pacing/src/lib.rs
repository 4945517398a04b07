//! When to start a frame.
#![forbid(unsafe_code)]

mod estimate;
mod forecast;
mod frame;
mod frames;
mod margin;
mod options;
mod pacer;
mod refresh_clock;
mod statistics;
mod time;

pub use frame::{Feedback, FrameId, FrameTiming, Plan, Step, Wait, WaitReason};
pub use options::{
    FRAME_LIMIT_HZ, HIDDEN_INTERVAL, MAX_IMAGES, MAX_QUEUE_LIMIT, PacerOptions, PacingError,
    PresentMode, PresentReports, Presentation, REFRESH_PERIOD, Refresh,
};
pub use pacer::Pacer;
pub use statistics::{
    Distribution, FrameStatistics, HISTOGRAM_BINS, HITCH_NEIGHBOURS, Histogram, HitchRule,
    MAX_STATISTICS_FRAMES, Summary,
};
pub use time::Time;
