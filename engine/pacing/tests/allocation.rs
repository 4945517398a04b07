//! Tests that pacing and statistics allocate only at creation, and never in the frame loop.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::time::Duration;

use allocation_counter::measure;
use antumbra_pacing::{
    Feedback, FrameStatistics, HitchRule, Pacer, PacerOptions, PresentReports, Presentation,
    PresentationMode, Refresh, Step, Time,
};

#[test]
fn the_loop_does_not_allocate() {
    let period = Duration::from_micros(16_667);
    let presentation = Presentation {
        mode: PresentationMode::Fifo,
        images: 3,
        refresh: Refresh::About(period),
        reports: PresentReports::Times,
    };
    let mut pacer = Pacer::new(PacerOptions::default(), presentation).unwrap();
    let mut statistics = FrameStatistics::new(500, HitchRule::default()).unwrap();
    let mut now = Time::from_origin(Duration::from_secs(1));
    let mut frames = 0;
    let allocated = measure(|| {
        while frames < 2_000 {
            match pacer.next(now) {
                Step::Wait(wait) => now = wait.until,
                Step::Start(plan) => {
                    frames += 1;
                    now = now.after(Duration::from_millis(3));
                    pacer.feedback(plan.frame, Feedback::Acquired { from: now, to: now });
                    pacer.feedback(plan.frame, Feedback::Queued { at: now });
                    let done = now.after(Duration::from_millis(4));
                    pacer.feedback(plan.frame, Feedback::Finished { at: done });
                    let refreshes = done.as_nanos().div_ceil(period.as_nanos() as u64);
                    let at = Time::from_nanos(refreshes * period.as_nanos() as u64);
                    pacer.feedback(plan.frame, Feedback::Shown { at });
                }
            }
            while let Some((_, timing)) = pacer.completed() {
                statistics.record(timing);
            }
            if frames % 100 == 0 {
                assert!(statistics.summary().frames <= 500);
            }
        }
        pacer.choose(PacerOptions { queue_limit: 3, ..PacerOptions::default() }).unwrap();
        pacer.present_through(presentation).unwrap();
    });
    assert_eq!(allocated.count_total, 0);
    assert_eq!(statistics.summary().frames, 500);
    assert_eq!(statistics.summary().missed_refreshes, Some(0));
}
