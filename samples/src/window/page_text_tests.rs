//! The whole text of pages whose every value is known, and of one of which nothing is.

use std::time::Duration;

use cull::FrameId;
use gpu::PresentMode;
use pacing::Summary;

use super::*;

/// A distribution whose numbers all differ, in hundredths of a millisecond from `first` on.
fn times(first: u64) -> Distribution {
    let at = |step: u64| Duration::from_micros((first + step) * 10);
    Distribution {
        samples: 5,
        mean: at(0),
        median: at(1),
        p95: at(2),
        p99: at(3),
        p99_9: at(4),
        worst: at(5),
        slowest_percent: at(6),
    }
}

fn pass(label: &'static str, gpu_ms: f64) -> PassTime {
    PassTime { label, gpu_ms, began_ns: 0 }
}

/// One line a fact, an empty line between groups.
fn text(known: &Known<'_>) -> String {
    let line = |(name, value): &(String, String)| format!("{name}: {value}\n");
    let groups = known.facts();
    let groups = groups.iter().map(|facts| facts.iter().map(line).collect::<String>());
    groups.collect::<Vec<_>>().join("\n")
}

fn outcome() -> FrameOutcome {
    FrameOutcome {
        frame: FrameId(3),
        draws: 1_001,
        triangles: 2_002_002,
        revealed: 33,
        neglected_samples: 44,
    }
}

fn report() -> FrameReport {
    FrameReport {
        cpu: Duration::from_micros(1_250),
        tests: 55,
        queries: 66,
        waits: 7,
        predicated_draws: 88,
        youngest_answer_frames: Some(2),
        oldest_answer_frames: Some(4),
        ..FrameReport::default()
    }
}

fn screen() -> ScreenFacts {
    ScreenFacts {
        mode: PresentMode::Fifo,
        fallback: None,
        images: 3,
        refresh: Some(Duration::from_micros(16_670)),
        summary: Summary {
            frames: 9,
            present_intervals: Some(times(1_000)),
            start_intervals: Some(times(2_000)),
            latencies: Some(times(3_000)),
            missed_refreshes: Some(4_004),
            hitches: Some(5_005),
            start_hitches: Some(6_006),
            ..Summary::default()
        },
    }
}

fn known<'a>(report: &'a FrameReport, screen: &'a ScreenFacts) -> Known<'a> {
    Known {
        frame: 0,
        report,
        outcome: None,
        passes: &[],
        lists_passes: true,
        used_bytes: 5 << 20,
        device: "a GPU",
        size: [640, 360],
        strategy: "antumbra",
        is_frozen: false,
        is_recording: false,
        predicates: "flags",
        frames_in_flight: 2,
        screen: Some(screen),
    }
}

#[test]
fn everything_known_is_said_where_it_belongs() {
    let (report, screen, outcome) = (report(), screen(), outcome());
    let passes = [
        pass("visible", 1.5),
        pass("answers", 0.25),
        pass("revealed", 0.5),
        pass("answers", 0.125),
        pass("revealed", 4.0),
    ];
    let known = Known {
        frame: 12,
        outcome: Some(&outcome),
        passes: &passes,
        is_frozen: true,
        is_recording: true,
        ..known(&report, &screen)
    };
    let expected = "\
CPU: 1.25 ms
GPU: 6.38 ms
GPU memory: 5 MiB

device: a GPU
picture: 640 x 360
strategy: antumbra, frozen, recording
predicates: flags
frames in flight: 2

frame: 12
draws: 1,001
triangles: 2,002,002
revealed: 33
tests: 55
queries: 66
waits: 7
age of results: 2 to 4 frames

present mode: fifo
images: 3
refresh: 16.67 ms
frame, median: 10.01 ms
95 %, 99 %: 10.02 ms, 10.03 ms
99.9 %: 10.04 ms
slowest 1 %: 10.06 ms
latency: 30.01 ms
missed refreshes: 4,004
hitches: 5,005

visible: 1.50 ms
answers: 0.38 ms
revealed: 4.50 ms
";
    assert_eq!(text(&known), expected);
}

#[test]
fn of_a_screen_that_tells_nothing_the_starts_of_frames_are_said() {
    let report = report();
    let told = screen();
    let screen = ScreenFacts {
        fallback: Some(PresentMode::Mailbox),
        refresh: None,
        summary: Summary { present_intervals: None, hitches: None, ..told.summary },
        ..told
    };
    let said = text(&known(&report, &screen));
    for line in [
        "present mode: fifo (no mailbox)",
        "refresh: -",
        "frame, median: 20.01 ms",
        "95 %, 99 %: 20.02 ms, 20.03 ms",
        "hitches: 6,006",
    ] {
        assert!(said.lines().any(|said| said == line), "{line}: {said}");
    }
}

#[test]
fn nothing_known_is_no_number() {
    let report = FrameReport::default();
    let screen = ScreenFacts {
        mode: PresentMode::Immediate,
        fallback: None,
        images: 0,
        refresh: None,
        summary: Summary::default(),
    };
    let expected = "\
CPU: -
GPU: -
GPU memory: 5 MiB

device: a GPU
picture: 640 x 360
strategy: antumbra
predicates: flags
frames in flight: 2

frame: 0
draws: -
triangles: -
revealed: -
tests: -
queries: -
waits: -
age of results: -

present mode: immediate
images: 0
refresh: -
frame, median: -
95 %, 99 %: -, -
99.9 %: -
slowest 1 %: -
latency: -
missed refreshes: -
hitches: -

";
    assert_eq!(text(&known(&report, &screen)), expected);
}

#[test]
fn passes_beyond_the_eighth_are_summed_up() {
    let labels = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
    let passes: Vec<PassTime> =
        labels.iter().zip(1..).map(|(label, ms)| pass(label, f64::from(ms))).collect();
    let (report, screen) = (report(), screen());
    let known = Known { passes: &passes, ..known(&report, &screen) };
    let rows = known.facts().pop().unwrap();
    assert_eq!(rows.len(), 9);
    assert_eq!(rows[7], ("h".to_owned(), "8.00 ms".to_owned()));
    assert_eq!(rows[8], ("others".to_owned(), "19.00 ms".to_owned()));
}

#[test]
fn numbers_are_readable() {
    let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")];
    for (number, text) in cases {
        assert_eq!(grouped(number), text);
    }
    assert_eq!((ms(None), ms(Some(1.234))), ("-".to_owned(), "1.23 ms".to_owned()));
}
