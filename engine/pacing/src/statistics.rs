//! Statistics of how evenly frames arrived: percentiles, hitches and histograms over the newest
//! frames.
//!
//! All computations use integers in nanoseconds, so that another program computes the same numbers
//! from the same timings. Percentiles are nearest ranks: the n-per-mille percentile is the least
//! sample that at least n thousandths of all samples do not exceed.

use std::time::Duration;

use crate::frame::FrameTiming;
use crate::options::PacingError;

/// The most frames that statistics may hold.
pub const MAX_STATISTICS_FRAMES: usize = 1 << 20;
/// The number of bins of a [`Histogram`].
pub const HISTOGRAM_BINS: usize = 10;
/// The number of frames before and after a frame with which it is compared to detect a hitch.
pub const HITCH_NEIGHBOURS: usize = 4;

/// The rule by which a long frame counts as a hitch: both conditions must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HitchRule {
    /// The duration that a hitch must exceed.
    pub longer_than: Duration,
    /// The percentage of the median of its neighbours that a hitch must exceed. Neighbours are up
    /// to [`HITCH_NEIGHBOURS`] frames before it and up to [`HITCH_NEIGHBOURS`] after it.
    pub percent_of_neighbours: u32,
}

impl Default for HitchRule {
    /// Returns a rule of 12 ms and 180 % of the neighbours' median: a missed refresh at up to 144
    /// Hz.
    fn default() -> Self {
        Self { longer_than: Duration::from_millis(12), percent_of_neighbours: 180 }
    }
}

/// The distribution of the known durations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Distribution {
    /// The number of known durations.
    pub samples: usize,
    /// The mean, rounded down to nanoseconds.
    pub mean: Duration,
    /// The median: half of the durations are at most this long.
    pub median: Duration,
    /// The 95th percentile.
    pub p95: Duration,
    /// The 99th percentile.
    pub p99: Duration,
    /// The 99.9th percentile.
    pub p99_9: Duration,
    /// The longest of the known durations.
    pub worst: Duration,
    /// The mean of the longest hundredth of them (at least one duration), rounded down to
    /// nanoseconds. Its reciprocal is known as "1 % low".
    pub slowest_percent: Duration,
}

impl Distribution {
    /// Returns the frames per second of the slowest hundredth of the frames.
    #[must_use]
    pub fn low_1_percent_hz(&self) -> f64 {
        1.0 / self.slowest_percent.as_secs_f64()
    }
}

/// The numbers of frames that took 0, 1, 2… refreshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Histogram {
    /// The number of frames by refreshes; the last bin counts all higher numbers.
    pub frames: [u32; HISTOGRAM_BINS],
    /// The number of frames with an unknown number of refreshes.
    pub unknown: u32,
}

impl Histogram {
    fn count(&mut self, refreshes: Option<u32>) {
        match refreshes {
            Some(refreshes) => self.frames[(refreshes as usize).min(HISTOGRAM_BINS - 1)] += 1,
            None => self.unknown += 1,
        }
    }
}

/// The summary of the newest frames. Unknown values are `None`, never 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// The number of frames covered.
    pub frames: usize,
    /// The times between present times.
    pub present_intervals: Option<Distribution>,
    /// The times between starts.
    pub start_intervals: Option<Distribution>,
    /// The times from start to present time.
    pub latencies: Option<Distribution>,
    /// The number of refreshes that should have shown a new frame but did not.
    pub missed_refreshes: Option<u64>,
    /// The number of hitches among the intervals between present times.
    pub hitches: Option<u32>,
    /// The number of hitches among the intervals between starts.
    pub start_hitches: Option<u32>,
    /// The intervals between present times, in refreshes.
    pub refreshes: Histogram,
    /// The latencies in refreshes.
    pub latency_refreshes: Histogram,
}

/// The newest frames, up to a fixed number. Allocates only at creation.
#[derive(Clone, Debug)]
pub struct FrameStatistics {
    ring: Box<[FrameTiming]>,
    /// The index of the next frame.
    next: usize,
    count: usize,
    rule: HitchRule,
    sorted: Vec<u64>,
}

type Span = fn(&FrameTiming) -> Option<Duration>;

impl FrameStatistics {
    /// Creates statistics over the newest `frames` frames.
    ///
    /// # Errors
    /// A number outside of 1 to [`MAX_STATISTICS_FRAMES`].
    pub fn new(frames: usize, rule: HitchRule) -> Result<Self, PacingError> {
        if !(1..=MAX_STATISTICS_FRAMES).contains(&frames) {
            return Err(PacingError::StatisticsFrames(frames));
        }
        let ring = vec![FrameTiming::default(); frames].into_boxed_slice();
        Ok(Self { ring, next: 0, count: 0, rule, sorted: Vec::with_capacity(frames) })
    }

    /// Adds a frame, which replaces the oldest one if the statistics are full.
    pub fn record(&mut self, timing: FrameTiming) {
        self.ring[self.next] = timing;
        self.next = (self.next + 1) % self.ring.len();
        self.count = (self.count + 1).min(self.ring.len());
    }

    /// Forgets all frames.
    pub const fn clear(&mut self) {
        (self.next, self.count) = (0, 0);
    }

    /// Returns the stored frames, oldest first, for example for graphs.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &FrameTiming> {
        (0..self.count).map(|age| self.at(age))
    }

    /// Returns the summary of the stored frames. It sorts them, so call it for a report, or a few
    /// times per second for a display.
    pub fn summary(&mut self) -> Summary {
        let mut summary = Summary { frames: self.count, ..Summary::default() };
        for age in 0..self.count {
            let timing = *self.at(age);
            summary.refreshes.count(timing.refreshes);
            summary.latency_refreshes.count(timing.latency_refreshes);
            if let Some(missed) = timing.missed {
                let before = summary.missed_refreshes.unwrap_or(0);
                summary.missed_refreshes = Some(before + u64::from(missed));
            }
        }
        summary.hitches = self.hitches(|timing| timing.present_interval);
        summary.start_hitches = self.hitches(|timing| timing.start_interval);
        summary.present_intervals = self.distribution(|timing| timing.present_interval);
        summary.start_intervals = self.distribution(|timing| timing.start_interval);
        summary.latencies = self.distribution(|timing| timing.latency);
        summary
    }

    /// Returns the frame of this age, which is 0 for the oldest.
    fn at(&self, age: usize) -> &FrameTiming {
        &self.ring[(self.next + self.ring.len() - self.count + age) % self.ring.len()]
    }

    fn distribution(&mut self, span: Span) -> Option<Distribution> {
        let mut sorted = std::mem::take(&mut self.sorted);
        sorted.clear();
        sorted.extend(self.frames().filter_map(span).map(nanos));
        sorted.sort_unstable();
        let distribution = distribution(&sorted);
        self.sorted = sorted;
        distribution
    }

    fn hitches(&self, span: Span) -> Option<u32> {
        let known = |age: usize| span(self.at(age)).map(nanos);
        let mut hitches = None;
        for age in 0..self.count {
            let Some(took) = known(age) else { continue };
            let first = age.saturating_sub(HITCH_NEIGHBOURS);
            let last = (age + HITCH_NEIGHBOURS + 1).min(self.count);
            let mut neighbours = [0; 2 * HITCH_NEIGHBOURS];
            let mut count = 0;
            for near in (first..last).filter(|near| *near != age).filter_map(known) {
                neighbours[count] = near;
                count += 1;
            }
            // A single frame has no neighbours.
            if count == 0 {
                continue;
            }
            neighbours[..count].sort_unstable();
            let usual = u128::from(rank(&neighbours[..count], 500));
            let stands_out =
                u128::from(took) * 100 > usual * u128::from(self.rule.percent_of_neighbours);
            let is_hitch = stands_out && took > nanos(self.rule.longer_than);
            hitches = Some(hitches.unwrap_or(0) + u32::from(is_hitch));
        }
        hitches
    }
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// Returns the least sample that at least this many thousandths of all samples do not exceed.
fn rank(sorted: &[u64], thousandths: usize) -> u64 {
    sorted[(sorted.len() * thousandths).div_ceil(1_000).max(1) - 1]
}

fn mean(of: &[u64]) -> Duration {
    let sum: u128 = of.iter().map(|nanos| u128::from(*nanos)).sum();
    // A mean of 64-bit numbers fits 64 bits.
    Duration::from_nanos((sum / of.len() as u128) as u64)
}

fn distribution(sorted: &[u64]) -> Option<Distribution> {
    let worst = *sorted.last()?;
    let at = |thousandths| Duration::from_nanos(rank(sorted, thousandths));
    Some(Distribution {
        samples: sorted.len(),
        mean: mean(sorted),
        median: at(500),
        p95: at(950),
        p99: at(990),
        p99_9: at(999),
        worst: Duration::from_nanos(worst),
        slowest_percent: mean(&sorted[sorted.len() - sorted.len().div_ceil(100)..]),
    })
}
