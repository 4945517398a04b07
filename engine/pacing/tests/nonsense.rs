//! Tests that the pacer returns a bounded step for any input, and does not panic.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::time::Duration;

use antumbra_pacing::{
    Feedback, PacedFrameId, Pacer, PacerOptions, PacingError, PresentReports, Presentation,
    PresentationMode, Refresh, Step, Time,
};
use proptest::prelude::*;

const SECOND: Duration = Duration::from_secs(1);

fn presentation() -> Presentation {
    Presentation {
        mode: PresentationMode::Fifo,
        images: 3,
        refresh: Refresh::Unknown,
        reports: PresentReports::Times,
    }
}

#[derive(Clone, Debug)]
enum Word {
    Next(u64),
    Feedback(u64, Feedback),
    Options(PacerOptions),
    Presentation(Presentation),
}

fn any_time() -> impl Strategy<Value = u64> {
    prop_oneof![
        8 => 0_u64..3_000_000_000,
        1 => any::<u64>(),
        1 => prop_oneof![Just(0), Just(u64::MAX), Just(u64::MAX - 1)],
    ]
}

fn any_feedback() -> impl Strategy<Value = Feedback> {
    let time = || any_time().prop_map(Time::from_nanos);
    prop_oneof![
        (time(), time()).prop_map(|(from, to)| Feedback::Acquired { from, to }),
        time().prop_map(|at| Feedback::Queued { at }),
        time().prop_map(|at| Feedback::Finished { at }),
        time().prop_map(|at| Feedback::FoundFinished { at }),
        any_time().prop_map(|nanos| Feedback::GpuTime(Duration::from_nanos(nanos))),
        Just(Feedback::GpuTime(Duration::from_secs(1 << 62))),
        time().prop_map(|at| Feedback::Shown { at }),
        Just(Feedback::Dropped),
    ]
}

fn any_limit() -> impl Strategy<Value = Option<f64>> {
    prop_oneof![Just(None), any::<f64>().prop_map(Some), (1.0..500.0).prop_map(Some)]
}

fn any_presentation() -> impl Strategy<Value = Presentation> {
    let period = || (0_u64..2_000_000_000).prop_map(Duration::from_nanos);
    let refresh = prop_oneof![
        Just(Refresh::Unknown),
        period().prop_map(Refresh::About),
        (period(), period())
            .prop_map(|(min_period, max_period)| Refresh::Variable { min_period, max_period }),
    ];
    let mode = prop::sample::select(vec![
        PresentationMode::Fifo,
        PresentationMode::FifoRelaxed,
        PresentationMode::Mailbox,
        PresentationMode::Immediate,
    ]);
    let reports = prop::sample::select(vec![PresentReports::Times, PresentReports::Missing]);
    (mode, 0_u32..6, refresh, reports).prop_map(|(mode, images, refresh, reports)| Presentation {
        mode,
        images,
        refresh,
        reports,
    })
}

fn any_word() -> impl Strategy<Value = Word> {
    let options =
        (0_u32..20, any_limit(), 0_u64..20_000).prop_map(|(queue_limit, limit, millis)| {
            PacerOptions {
                queue_limit,
                frame_limit_hz: limit,
                hidden_interval: Duration::from_millis(millis),
            }
        });
    prop_oneof![
        10 => any_time().prop_map(Word::Next),
        12 => (0_u64..40, any_feedback()).prop_map(|(back, what)| Word::Feedback(back, what)),
        1 => options.prop_map(Word::Options),
        1 => any_presentation().prop_map(Word::Presentation),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn any_words_in_any_order(words in prop::collection::vec(any_word(), 1..300)) {
        let mut pacer = Pacer::new(PacerOptions::default(), presentation()).unwrap();
        let mut newest = 0;
        for word in words {
            match word {
                Word::Next(now) => match pacer.next(Time::from_nanos(now)) {
                    Step::Start(plan) => newest = plan.frame.0,
                    Step::Wait(wait) => {
                        // The pacer may have held the clock back by up to 100 ms.
                        let bound = SECOND + Duration::from_millis(101);
                        prop_assert!(wait.until.since(Time::from_nanos(now)) <= bound);
                    }
                },
                Word::Feedback(back, what) => {
                    pacer.feedback(PacedFrameId(newest.wrapping_sub(back)), what);
                }
                Word::Options(options) => drop(pacer.choose(options)),
                Word::Presentation(presentation) => drop(pacer.present_through(presentation)),
            }
            prop_assert!(pacer.queued_frames() <= 64);
            while pacer.completed().is_some() {}
        }
        // The pacer still works: time passes, and frames start.
        let mut now = Time::from_origin(SECOND * 1_000_000);
        let mut started = 0;
        for _ in 0..20_000 {
            match pacer.next(now) {
                Step::Wait(wait) => now = now.max(wait.until),
                Step::Start(plan) => {
                    started += 1;
                    pacer.feedback(plan.frame, Feedback::Queued { at: now });
                    now = now.after(Duration::from_millis(1));
                    pacer.feedback(plan.frame, Feedback::Finished { at: now });
                    now = now.after(Duration::from_millis(1));
                    pacer.feedback(plan.frame, Feedback::Shown { at: now });
                }
            }
            if started == 20 {
                break;
            }
        }
        prop_assert_eq!(started, 20);
    }
}

#[test]
fn a_caller_that_reports_nothing_is_throttled_not_hung() {
    let mut pacer = Pacer::new(PacerOptions::default(), presentation()).unwrap();
    let mut now = Time::from_origin(SECOND);
    let end = now.after(SECOND * 20);
    let mut frames = 0;
    let mut steps = 0;
    while now < end {
        steps += 1;
        match pacer.next(now) {
            Step::Wait(wait) => now = wait.until,
            Step::Start(plan) => {
                frames += 1;
                pacer.feedback(plan.frame, Feedback::Queued { at: now });
            }
        }
    }
    assert!((20..=90).contains(&frames), "{frames} frames in 20 s");
    assert!(steps < 3_000, "{steps} steps");
}

/// Checks that a GPU that never finishes is polled at growing intervals, with any options.
#[test]
fn a_gpu_that_hangs_does_not_make_the_loop_spin() {
    for frame_limit_hz in [None, Some(0.5)] {
        let options = PacerOptions { frame_limit_hz, ..PacerOptions::default() };
        let mut pacer = Pacer::new(options, presentation()).unwrap();
        let mut now = Time::from_origin(SECOND);
        let end = now.after(SECOND * 20);
        let mut steps = 0;
        while now < end {
            steps += 1;
            match pacer.next(now) {
                Step::Wait(wait) => now = wait.until,
                Step::Start(plan) => {
                    pacer.feedback(plan.frame, Feedback::Queued { at: now });
                    if plan.frame.0 < 50 {
                        now = now.after(Duration::from_millis(20));
                        pacer.feedback(plan.frame, Feedback::FoundFinished { at: now });
                        pacer.feedback(plan.frame, Feedback::Shown { at: now });
                    }
                }
            }
        }
        assert!(steps < 3_000, "{steps} steps in 20 s");
    }
}

#[test]
fn frames_that_are_all_dropped_do_not_spin() {
    let mut pacer = Pacer::new(PacerOptions::default(), presentation()).unwrap();
    let mut now = Time::from_origin(SECOND);
    let end = now.after(SECOND * 20);
    let mut frames = 0;
    while now < end {
        match pacer.next(now) {
            Step::Wait(wait) => now = wait.until,
            Step::Start(plan) => {
                frames += 1;
                if frames % 2 == 0 {
                    pacer.feedback(plan.frame, Feedback::Dropped);
                }
            }
        }
    }
    assert!((20..=110).contains(&frames), "{frames} frames in 20 s");
}

#[test]
fn a_clock_that_is_set_back_is_followed() {
    let mut pacer = Pacer::new(PacerOptions::default(), presentation()).unwrap();
    let late = Time::from_nanos(u64::MAX);
    let Step::Start(plan) = pacer.next(late) else { panic!("nothing is queued") };
    pacer.feedback(plan.frame, Feedback::Queued { at: late });
    pacer.feedback(plan.frame, Feedback::Finished { at: late });
    let early = Time::from_origin(SECOND);
    let Step::Start(plan) = pacer.next(early) else { panic!("nothing is queued") };
    assert_eq!(plan.start, early);
}

#[test]
fn choices_that_make_no_sense_are_refused_and_change_nothing() {
    let sane = PacerOptions::default();
    let mut pacer = Pacer::new(sane, presentation()).unwrap();
    for hz in [f64::NAN, f64::INFINITY, 0.0, -60.0, 1e9, 1e-9] {
        let refused = pacer.choose(PacerOptions { frame_limit_hz: Some(hz), ..sane });
        assert!(matches!(refused, Err(PacingError::FrameLimit(_))), "{hz}");
        assert!(refused.unwrap_err().to_string().contains("choose"));
    }
    for queue_limit in [0, 17, u32::MAX] {
        let refused = pacer.choose(PacerOptions { queue_limit, ..sane });
        assert_eq!(refused, Err(PacingError::QueueLimit(queue_limit)));
    }
    let hidden_interval = Duration::ZERO;
    let refused = pacer.choose(PacerOptions { hidden_interval, ..sane });
    assert_eq!(refused, Err(PacingError::HiddenInterval(Duration::ZERO)));
    assert_eq!(*pacer.options(), sane);
    let refused = pacer.present_through(Presentation { images: 0, ..presentation() });
    assert_eq!(refused, Err(PacingError::Images(0)));
    let refresh = Refresh::About(Duration::ZERO);
    let refused = pacer.present_through(Presentation { refresh, ..presentation() });
    assert_eq!(refused, Err(PacingError::RefreshPeriod(Duration::ZERO)));
    let min_period = Duration::from_millis(20);
    let max_period = Duration::from_millis(7);
    let refresh = Refresh::Variable { min_period, max_period };
    let refused = pacer.present_through(Presentation { refresh, ..presentation() });
    assert_eq!(refused, Err(PacingError::RefreshRange { min_period, max_period }));
    assert_eq!(*pacer.presentation(), presentation());
}
