//! Tests that the pacer does not run ahead of the GPU, whatever the number of images.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::time::Duration;

use antumbra_pacing::{
    Feedback, PacedFrameId, Pacer, PacerOptions, PresentReports, Presentation, PresentationMode,
    Refresh, Step, Time,
};

/// Checks that the queue is filled beyond the limit only for the display. If acquires must reveal
/// refreshes, the queue is filled up to the number of images, but at most the limit waits for the
/// GPU.
#[test]
fn no_more_than_the_limit_wait_for_the_gpu() {
    for queue_limit in 1..4 {
        let options = PacerOptions { queue_limit, ..PacerOptions::default() };
        let presentation = Presentation {
            mode: PresentationMode::Fifo,
            images: 6,
            refresh: Refresh::Unknown,
            reports: PresentReports::Missing,
        };
        let mut pacer = Pacer::new(options, presentation).unwrap();
        let mut now = Time::from_origin(Duration::from_secs(1));
        let first = start(&mut pacer, now).unwrap();
        now = now.after(Duration::from_millis(4));
        pacer.feedback(first, Feedback::Finished { at: now });
        for _ in 0..queue_limit {
            start(&mut pacer, now).expect("the GPU has less to do than allowed");
        }
        // The GPU is at work for another second.
        let end = now.after(Duration::from_secs(1));
        while now < end {
            now = start(&mut pacer, now).expect_err("it runs ahead of the GPU");
        }
        pacer.feedback(PacedFrameId(1), Feedback::Finished { at: now });
        start(&mut pacer, now).expect("one is finished, so another may start");
        start(&mut pacer, now).expect_err("only one is finished");
    }
}

/// Starts and presents a frame, or returns the end of the sleep.
fn start(pacer: &mut Pacer, now: Time) -> Result<PacedFrameId, Time> {
    match pacer.next(now) {
        Step::Start(plan) => {
            pacer.feedback(plan.frame, Feedback::Acquired { from: now, to: now });
            pacer.feedback(plan.frame, Feedback::Queued { at: now });
            Ok(plan.frame)
        }
        Step::Wait(wait) => Err(wait.until),
    }
}
