//! Tests that statistics equal an independent offline calculation, to the nanosecond.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::time::Duration;

use antumbra_pacing::{
    Distribution, FrameStatistics, FrameTiming, HISTOGRAM_BINS, HITCH_NEIGHBOURS, Histogram,
    HitchRule, PacingError,
};
use proptest::prelude::*;

const RULE: HitchRule =
    HitchRule { longer_than: Duration::from_millis(12), percent_of_neighbours: 180 };

/// Returns a percentile by counting, without sorting.
fn percentile(samples: &[u64], thousandths: u64) -> Duration {
    let enough = |value: u64| {
        let below = samples.iter().filter(|sample| **sample <= value).count() as u64;
        below * 1_000 >= thousandths * samples.len() as u64
    };
    let least = samples.iter().copied().filter(|value| enough(*value)).min().unwrap();
    Duration::from_nanos(least)
}

fn offline(samples: &[u64]) -> Option<Distribution> {
    if samples.is_empty() {
        return None;
    }
    let mut left = samples.to_vec();
    let mut slowest = Vec::new();
    while slowest.len() * 100 < samples.len() {
        let worst = *left.iter().max().unwrap();
        let position = left.iter().position(|sample| *sample == worst).unwrap();
        slowest.push(left.swap_remove(position));
    }
    let mean = |of: &[u64]| Duration::from_nanos(of.iter().sum::<u64>() / of.len() as u64);
    Some(Distribution {
        samples: samples.len(),
        mean: mean(samples),
        median: percentile(samples, 500),
        p95: percentile(samples, 950),
        p99: percentile(samples, 990),
        p99_9: percentile(samples, 999),
        worst: Duration::from_nanos(*samples.iter().max().unwrap()),
        slowest_percent: mean(&slowest),
    })
}

fn offline_hitches(spans: &[Option<u64>]) -> Option<u32> {
    let mut judged = 0;
    let mut hitches = 0;
    for (position, span) in spans.iter().enumerate() {
        let near: Vec<u64> = spans
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != position && other.abs_diff(position) <= HITCH_NEIGHBOURS)
            .filter_map(|(_, span)| *span)
            .collect();
        let Some(span) = span.filter(|_| !near.is_empty()) else { continue };
        judged += 1;
        let usual = percentile(&near, 500).as_nanos() as u64;
        hitches += u32::from(span > 12_000_000 && span * 100 > usual * 180);
    }
    (judged > 0).then_some(hitches)
}

fn offline_histogram(refreshes: &[Option<u32>]) -> Histogram {
    let mut histogram = Histogram::default();
    for bin in 0..HISTOGRAM_BINS as u32 {
        let last = bin as usize == HISTOGRAM_BINS - 1;
        let in_bin = |known: &&Option<u32>| known.is_some_and(|n| n == bin || last && n > bin);
        histogram.frames[bin as usize] = refreshes.iter().filter(in_bin).count() as u32;
    }
    histogram.unknown = refreshes.iter().filter(|known| known.is_none()).count() as u32;
    histogram
}

fn known<T: std::fmt::Debug + Clone + 'static>(
    of: impl Strategy<Value = T> + 'static,
) -> impl Strategy<Value = Option<T>> {
    prop_oneof![1 => Just(None), 6 => of.prop_map(Some)]
}

fn any_timing() -> impl Strategy<Value = FrameTiming> {
    // Many equal values, so that ties occur.
    let span = || {
        let nanos = prop_oneof![0_u64..60_000_000, (0_u64..6).prop_map(|n| n * 8_333_333)];
        known(nanos.prop_map(Duration::from_nanos))
    };
    let count = || known(0_u32..14);
    (span(), span(), span(), count(), count(), count()).prop_map(
        |(start_interval, present_interval, latency, refreshes, latency_refreshes, missed)| {
            FrameTiming {
                start_interval,
                present_interval,
                latency,
                refreshes,
                latency_refreshes,
                missed,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn equal_an_offline_calculation(
        timings in prop::collection::vec(any_timing(), 0..400),
        frames in 1_usize..300,
    ) {
        let mut statistics = FrameStatistics::new(frames, RULE).unwrap();
        timings.iter().for_each(|timing| statistics.record(*timing));
        let kept = &timings[timings.len().saturating_sub(frames)..];
        prop_assert_eq!(statistics.frames().copied().collect::<Vec<_>>(), kept);
        let spans = |of: fn(&FrameTiming) -> Option<Duration>| -> Vec<Option<u64>> {
            kept.iter().map(|t| of(t).map(|span| span.as_nanos() as u64)).collect()
        };
        let present = spans(|timing| timing.present_interval);
        let start = spans(|timing| timing.start_interval);
        let latency = spans(|timing| timing.latency);
        let known = |spans: &[Option<u64>]| spans.iter().flatten().copied().collect::<Vec<_>>();
        let summary = statistics.summary();
        prop_assert_eq!(summary.frames, kept.len());
        prop_assert_eq!(summary.present_intervals, offline(&known(&present)));
        prop_assert_eq!(summary.start_intervals, offline(&known(&start)));
        prop_assert_eq!(summary.latencies, offline(&known(&latency)));
        prop_assert_eq!(summary.hitches, offline_hitches(&present));
        prop_assert_eq!(summary.start_hitches, offline_hitches(&start));
        let missed: Vec<u64> = kept.iter().filter_map(|t| t.missed).map(u64::from).collect();
        let sum = (!missed.is_empty()).then(|| missed.iter().sum::<u64>());
        prop_assert_eq!(summary.missed_refreshes, sum);
        let refreshes: Vec<_> = kept.iter().map(|timing| timing.refreshes).collect();
        prop_assert_eq!(summary.refreshes, offline_histogram(&refreshes));
        let refreshes: Vec<_> = kept.iter().map(|timing| timing.latency_refreshes).collect();
        prop_assert_eq!(summary.latency_refreshes, offline_histogram(&refreshes));
        statistics.clear();
        prop_assert_eq!(statistics.summary(), FrameStatistics::new(1, RULE).unwrap().summary());
    }
}

fn interval(millis: u64) -> FrameTiming {
    FrameTiming { present_interval: Some(Duration::from_millis(millis)), ..FrameTiming::default() }
}

#[test]
fn a_hitch_is_long_and_stands_out() {
    let hitches = |millis: &[u64]| {
        let mut statistics = FrameStatistics::new(100, HitchRule::default()).unwrap();
        millis.iter().for_each(|millis| statistics.record(interval(*millis)));
        statistics.summary().hitches
    };
    assert_eq!(hitches(&[]), None);
    assert_eq!(hitches(&[50]), None);
    assert_eq!(hitches(&[16, 17, 16, 33, 17, 16]), Some(1));
    // A constantly slow rate is not a hitch, and 5 ms among frames of 2 ms are not visible.
    assert_eq!(hitches(&[50; 20]), Some(0));
    assert_eq!(hitches(&[2, 2, 2, 5, 2, 2]), Some(0));
    assert_eq!(hitches(&[7, 7, 7, 14, 7, 7]), Some(1));
}

#[test]
fn known_numbers() {
    let mut statistics = FrameStatistics::new(1_000, HitchRule::default()).unwrap();
    (1..=1_000).rev().for_each(|millis| statistics.record(interval(millis)));
    let summary = statistics.summary();
    let intervals = summary.present_intervals.unwrap();
    let millis = |of: Duration| of.as_millis();
    assert_eq!(millis(intervals.median), 500);
    assert_eq!(millis(intervals.p95), 950);
    assert_eq!(millis(intervals.p99), 990);
    assert_eq!(millis(intervals.p99_9), 999);
    assert_eq!(millis(intervals.worst), 1_000);
    assert_eq!(intervals.slowest_percent, Duration::from_micros(995_500));
    assert!((intervals.low_1_percent_hz() - 1.0 / 0.9955).abs() < 1e-9);
    // A value without a report is unknown, not 0.
    assert_eq!(summary.latencies, None);
    assert_eq!(summary.missed_refreshes, None);
    assert_eq!(summary.refreshes.unknown, 1_000);
}

#[test]
fn sizes_are_checked() {
    for frames in [0, antumbra_pacing::MAX_STATISTICS_FRAMES + 1] {
        let refused = FrameStatistics::new(frames, RULE).unwrap_err();
        assert_eq!(refused, PacingError::StatisticsFrames(frames));
    }
}

#[test]
fn absurd_durations_do_not_overflow() {
    let mut statistics = FrameStatistics::new(8, RULE).unwrap();
    let absurd = Some(Duration::from_secs(1 << 62));
    for _ in 0..8 {
        statistics.record(FrameTiming { latency: absurd, present_interval: absurd, ..interval(1) });
    }
    assert_eq!(statistics.summary().latencies.unwrap().mean, Duration::from_nanos(u64::MAX));
}
