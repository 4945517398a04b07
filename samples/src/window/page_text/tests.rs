//! Tests of the whole text of pages, with all values known and with none.

use std::time::Duration;

use antumbra::cull::FrameId;
use antumbra::gpu::PresentMode;
use antumbra::pacing::{Summary, Time};

use super::*;
use crate::window::comparison::Side;
use crate::window::conditions::Conditions;

/// Returns a distribution of distinct numbers, in hundredths of a millisecond from `first` on.
fn distribution(first: u64) -> Distribution {
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

/// Returns one line per fact, and an empty line between groups.
fn text(known: &Known<'_>) -> String {
    let line = |(name, value): &(String, String)| format!("{name}: {value}\n");
    let groups = known.details();
    let groups = groups.iter().map(|facts| facts.iter().map(line).collect::<String>());
    groups.collect::<Vec<_>>().join("\n")
}

fn outcome() -> FrameStats {
    FrameStats {
        frame: FrameId(3),
        draws: 1_001,
        triangles: 2_002_002,
        revealed: 33,
        samples_below_threshold: 44,
    }
}

fn report() -> FrameReport {
    FrameReport {
        cpu: Duration::from_micros(1_250),
        overlay_cpu: Duration::from_micros(500),
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
            present_intervals: Some(distribution(1_000)),
            start_intervals: Some(distribution(2_000)),
            latencies: Some(distribution(3_000)),
            missed_refreshes: Some(4_004),
            hitches: Some(5_005),
            start_hitches: Some(6_006),
            ..Summary::default()
        },
    }
}

fn times(report: &FrameReport, passes: &[PassTime]) -> FrameTimeSeries {
    let mut times = FrameTimeSeries::default();
    times.follow(Conditions {
        strategy: Strategy::ANTUMBRA,
        size: [640, 360],
        frames_in_flight: 0,
        present_mode: None,
        scene: 0,
        is_comparing: false,
    });
    for frame in 0..5 {
        times.push(Time::from_nanos(frame * 16_000_000));
    }
    times.laid_out(0.25);
    times.take(report);
    times.sent(Side::Culled, passes);
    times
}

fn known<'a>(
    report: &'a FrameReport,
    screen: &'a ScreenFacts,
    times: &'a FrameTimeSeries,
) -> Known<'a> {
    Known {
        frame: 0,
        scene: "city",
        report,
        outcome: None,
        objects: 10_000,
        in_frustum: None,
        times,
        lists_passes: true,
        used_bytes: 5 << 20,
        device: "a GPU",
        size: [640, 360],
        strategy: Strategy::ANTUMBRA,
        is_frozen: false,
        is_recording: false,
        predicates: "flags",
        tester: "queries",
        frames_in_flight: 2,
        is_comparing: false,
        claim: &CLAIM,
        screen: Some(screen),
        transparency: None,
    }
}

/// A claim without contents.
static CLAIM: ExactnessVerdict = ExactnessVerdict::Unclaimed(String::new());

const PASSES: [(&str, f64); 7] = [
    ("draw visible", 1.5),
    ("resolve tests", 0.25),
    ("draw revealed", 0.5),
    ("resolve tests", 0.125),
    ("draw revealed", 4.0),
    ("host overlay", 0.75),
    ("view from above", 0.25),
];

#[test]
fn what_a_person_looks_for_is_said_first() {
    let report = report();
    let screen = screen();
    let outcome = outcome();
    let times = times(&report, &PASSES.map(|(label, ms)| pass(label, ms)));
    let known = Known {
        frame: 12,
        outcome: Some(&outcome),
        in_frustum: Some(2_055),
        is_frozen: true,
        is_recording: true,
        ..known(&report, &screen, &times)
    };
    let figure = |value: &str, name| HudFigure { value: value.to_owned(), name };
    let overview = known.overview("keys");
    assert_eq!(overview.strategy, "antumbra, frozen, recording");
    assert_eq!(overview.rate, figure("62", "frames/s"));
    assert_eq!(overview.frame_time, figure("16.0", "ms/frame"));
    let compared = Known { is_comparing: true, ..known }.overview("keys");
    assert_eq!(compared.rate, figure("62", "pairs/s"));
    assert_eq!(compared.frame_time, figure("16.0", "ms/pair"));
    assert_eq!(
        overview.objects,
        [figure("10,000", "objects"), figure("2,055", "in frustum"), figure("1,001", "drawn")]
    );
    assert_eq!(overview.split, Some(Split { drawn: 1_001, culled: 1_054 }));
    // The overlay's times are not included in the engine's.
    assert_eq!(overview.times, [figure("6.38 ms", "GPU"), figure("1.25 ms", "CPU")]);
    assert_eq!(overview.verdict, CLAIM);
}

#[test]
fn everything_known_is_said_where_it_belongs() {
    let report = report();
    let screen = screen();
    let outcome = outcome();
    let times = times(&report, &PASSES.map(|(label, ms)| pass(label, ms)));
    let known = Known { frame: 12, outcome: Some(&outcome), ..known(&report, &screen, &times) };
    let expected = "\
frame: 12
triangles drawn: 2,002,002
revealed in this frame: 33
proxy tests: 55
queries: 66
waits for the GPU: 7
latency of results: 2 to 4 frames

draw visible: 1.50 ms
resolve tests: 0.38 ms
draw revealed: 4.50 ms

device: a GPU
size: 640 x 360
predicates: flags
cheapest tester: queries
frames in flight: 2
GPU memory: 5 MiB

this overlay, CPU: 0.75 ms
this overlay, GPU: 1.00 ms

present mode: fifo
images: 3
refresh: 16.67 ms
frame, median: 10.01 ms
frame, 95 %: 10.02 ms
frame, 99 %: 10.03 ms
frame, 99.9 %: 10.04 ms
slowest 1 %, mean: 10.06 ms
latency to the screen: 30.01 ms
missed refreshes: 4,004
hitches: 5,005
";
    assert_eq!(text(&known), expected);
}

#[test]
fn of_a_screen_that_tells_nothing_the_starts_of_frames_are_said() {
    let report = report();
    let known_screen = screen();
    let times = FrameTimeSeries::default();
    let screen = ScreenFacts {
        fallback: Some(PresentMode::Mailbox),
        refresh: None,
        summary: Summary { present_intervals: None, hitches: None, ..known_screen.summary },
        ..known_screen
    };
    let said = text(&known(&report, &screen, &times));
    for line in [
        "present mode: fifo (no mailbox)",
        "refresh: -",
        "frame, median: 20.01 ms",
        "frame, 95 %: 20.02 ms",
        "hitches: 6,006",
    ] {
        assert!(said.lines().any(|said| said == line), "{line}: {said}");
    }
}

#[test]
fn nothing_known_is_no_number() {
    let report = FrameReport::default();
    let times = FrameTimeSeries::default();
    let screen = ScreenFacts {
        mode: PresentMode::Immediate,
        fallback: None,
        images: 0,
        refresh: None,
        summary: Summary::default(),
    };
    let known = known(&report, &screen, &times);
    let unknown = known.details().concat().into_iter().filter(|(_, value)| value == "-").count();
    assert_eq!(unknown, 6 + 2 + 9, "{:?}", known.details());
    let overview = known.overview("");
    let values = [&overview.rate, &overview.frame_time, &overview.times[0], &overview.times[1]];
    assert!(values.iter().all(|figure| figure.value == "-"), "{overview:?}");
    assert_eq!(overview.objects.map(|figure| figure.value), ["10,000", "-", "-"]);
    assert_eq!((overview.split, overview.verdict), (None, ExactnessVerdict::default()));
}

#[test]
fn passes_beyond_the_eighth_are_summed_up() {
    let labels = ["a", "b", "c", "d", "e", "f", "g", "h", "i", "j"];
    let passes: Vec<PassTime> =
        labels.iter().zip(1..).map(|(label, ms)| pass(label, f64::from(ms))).collect();
    let report = report();
    let screen = screen();
    let times = times(&report, &passes);
    let rows = known(&report, &screen, &times).pass_rows();
    assert_eq!(rows.len(), 9);
    assert_eq!(rows[7], ("h".to_owned(), "8.00 ms".to_owned()));
    assert_eq!(rows[8], ("others".to_owned(), "19.00 ms".to_owned()));
}

#[test]
fn numbers_fit_their_columns() {
    for (number, text) in
        [(0, "0"), (999_999, "999,999"), (2_000_000, "2.00 M"), (45_678_901, "45.7 M")]
    {
        assert_eq!(short(number), text);
    }
    for (time, text) in [(0.123, "0.12"), (9.999, "10.0"), (45.67, "45.7"), (151.4, "151")] {
        assert_eq!(digits(time), text);
    }
    assert_eq!(in_ms(Some(9_999.0)), "9999 ms");
    assert_eq!(in_ms(Some(18_858.0)), "18.9 s");
    assert_eq!((ms(None), ms(Some(1.234))), ("-".to_owned(), "1.23 ms".to_owned()));
}

#[test]
fn fragments_that_were_not_blended_are_counted() {
    let mut report = report();
    let screen = screen();
    let times = times(&report, &[]);
    let order = TransparencyReport {
        method: "sorted fragments".to_owned(),
        fallback: Some("no reason".to_owned()),
    };
    let of = |report: &FrameReport| {
        let known = Known { transparency: Some(&order), ..known(report, &screen, &times) };
        known.details().concat()
    };
    assert!(of(&report).contains(&fact("transparent objects", "sorted fragments")));
    assert!(of(&report).contains(&fact("since", "no reason")));
    report.fragments.visible = 7_000;
    assert!(of(&report).contains(&fact("their fragments", "7,000")));
    report.fragments.left_out = 3;
    assert!(of(&report).contains(&fact("fragments not blended", "0 without room, 3 left out")));
}
