//! Tests of the time at which a frame's timing is complete, and of frames without a report.
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

const STEP: Duration = Duration::from_millis(20);

fn pacer(mode: PresentationMode, images: u32, reports: PresentReports) -> Pacer {
    let options = PacerOptions { queue_limit: 8, ..PacerOptions::default() };
    let presentation = Presentation { mode, images, refresh: Refresh::Unknown, reports };
    Pacer::new(options, presentation).unwrap()
}

/// Returns the start of a frame, one every `STEP`.
fn at(frame: u64) -> Time {
    Time::from_origin(Duration::from_secs(1) + STEP * frame as u32)
}

fn present(pacer: &mut Pacer, number: u64) -> PacedFrameId {
    let Step::Start(plan) = pacer.next(at(number)) else { panic!("frame {number} must wait") };
    assert_eq!(plan.frame, PacedFrameId(number));
    pacer.feedback(plan.frame, Feedback::Queued { at: at(number) });
    plan.frame
}

fn known(pacer: &mut Pacer) -> Vec<u64> {
    std::iter::from_fn(|| pacer.completed()).map(|(frame, _)| frame.0).collect()
}

/// Checks that with images in order, an image without a report replaced the previous one at an
/// unknown time, so that the duration of both is unknown. The newest image of a mailbox may have
/// been replaced before it was ever shown.
#[test]
fn a_frame_of_unknown_time_did_show_unless_it_was_replaced() {
    for mode in [PresentationMode::Fifo, PresentationMode::FifoRelaxed, PresentationMode::Mailbox] {
        let mut pacer = pacer(mode, 3, PresentReports::Times);
        for number in 0..4 {
            let frame = present(&mut pacer, number);
            let done = at(number).after(STEP / 4);
            pacer.feedback(frame, Feedback::Finished { at: done });
            if number != 1 {
                pacer.feedback(frame, Feedback::Shown { at: done });
            }
        }
        let timings = std::iter::from_fn(|| pacer.completed()).map(|(_, timing)| timing);
        let intervals: Vec<_> = timings.map(|timing| timing.present_interval).collect();
        let across = (mode == PresentationMode::Mailbox).then_some(2 * STEP);
        assert_eq!(intervals, [None, None, across, Some(STEP)], "{mode:?}");
    }
}

/// Checks that, with n images, a frame's report is awaited until the acquire of the frame n - 1
/// later, which is the last that can reveal that the frame was shown.
#[test]
fn without_reports_a_frame_is_known_after_the_last_acquire_that_can_tell() {
    for images in 1..5 {
        let mut pacer = pacer(PresentationMode::Fifo, images, PresentReports::Missing);
        for number in 0..20 {
            let frame = present(&mut pacer, number);
            let expected: Vec<u64> = number.checked_sub(u64::from(images)).into_iter().collect();
            assert_eq!(known(&mut pacer), expected, "{images} images, frame {number}");
            let done = at(number).after(STEP / 4);
            pacer.feedback(frame, Feedback::Finished { at: done });
        }
    }
}

/// Checks that a queued frame has no timing yet, since it may be dropped, and has none if it is.
#[test]
fn without_reports_a_frame_that_is_still_queued_is_not_known() {
    let mut pacer = pacer(PresentationMode::Immediate, 1, PresentReports::Missing);
    let first = present(&mut pacer, 0);
    pacer.feedback(first, Feedback::Finished { at: at(0) });
    for number in 1..5 {
        present(&mut pacer, number);
    }
    assert_eq!(known(&mut pacer), [0], "the GPU is not done with the others");
    pacer.feedback(PacedFrameId(1), Feedback::Dropped);
    pacer.feedback(PacedFrameId(2), Feedback::Finished { at: at(4) });
    let _ = pacer.next(at(5));
    assert_eq!(known(&mut pacer), [2]);
}
