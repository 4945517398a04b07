//! Median, 95th percentile and maximum of a run's samples, and ratios of medians.

use serde::{Deserialize, Serialize};

/// The factor of the digits that reports keep: a tenth of a microsecond where the unit is ms.
const KEPT_DIGITS: f64 = 1e4;

/// Three numbers that describe a set of samples; absent where there was none.
///
/// Samples that are not finite are left out, so a summary never holds one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TimeSummary {
    /// The middle sample; between the two middle ones if their number is even.
    pub median: Option<f64>,
    /// The smallest sample that 95 % of all do not exceed (nearest rank).
    pub p95: Option<f64>,
    /// The largest sample.
    pub max: Option<f64>,
}

impl TimeSummary {
    /// Creates the summary of samples in any order.
    pub fn of(samples: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> =
            samples.into_iter().filter(|sample| sample.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        Self {
            median: median(&sorted).map(kept),
            p95: nearest_rank(&sorted, 95).copied().map(kept),
            max: sorted.last().copied().map(kept),
        }
    }
}

/// Returns the middle one of some counts; the lower of the two middle ones if their number is even.
pub fn median_count(counts: impl IntoIterator<Item = u64>) -> Option<u64> {
    let mut sorted: Vec<u64> = counts.into_iter().collect();
    sorted.sort_unstable();
    nearest_rank(&sorted, 50).copied()
}

/// Returns the ratio of `a` to `b`; absent where it is not finite.
pub fn ratio(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let ratio = a? / b?;
    ratio.is_finite().then(|| kept(ratio))
}

/// Returns the median of the ratios of the values at the same index in both; absent if no pair has
/// a ratio.
pub fn paired_ratio(a: &[Option<f64>], b: &[Option<f64>]) -> Option<f64> {
    let ratios = a.iter().zip(b).filter_map(|(&a, &b)| Some(a? / b?));
    TimeSummary::of(ratios).median
}

fn median(sorted: &[f64]) -> Option<f64> {
    let upper = sorted.len() / 2;
    let high = *sorted.get(upper)?;
    if sorted.len() % 2 == 1 {
        return Some(high);
    }
    // Halved first: the sum of two large samples may not be finite.
    sorted.get(upper.checked_sub(1)?).map(|low| low / 2.0 + high / 2.0)
}

/// Returns the smallest sample that `percent` of all do not exceed.
fn nearest_rank<T>(sorted: &[T], percent: usize) -> Option<&T> {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.checked_sub(1)?)
}

/// Returns the value rounded to the digits that reports keep.
pub fn kept(value: f64) -> f64 {
    let scaled = (value * KEPT_DIGITS).round() / KEPT_DIGITS;
    if scaled.is_finite() { scaled } else { value }
}

/// Returns a whole number with a comma between each three digits.
pub fn thousands(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut text = if value < 0.0 { "-".to_owned() } else { String::new() };
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nothing_is_summarised_as_nothing() {
        assert_eq!(TimeSummary::of([]), TimeSummary::default());
        assert_eq!(TimeSummary::of([f64::NAN, f64::INFINITY]), TimeSummary::default());
        assert_eq!(median_count([]), None);
    }

    #[test]
    fn known_samples() {
        let summary = TimeSummary::of((1..=100).rev().map(f64::from));
        assert_eq!(summary, TimeSummary { median: Some(50.5), p95: Some(95.0), max: Some(100.0) });
        let one = TimeSummary::of([3.0]);
        assert_eq!(one, TimeSummary { median: Some(3.0), p95: Some(3.0), max: Some(3.0) });
        // Of 20 samples the 19th: 95 % do not exceed it. Of 10, only the largest will do.
        assert_eq!(TimeSummary::of((1..=20).map(f64::from)).p95, Some(19.0));
        assert_eq!(TimeSummary::of((1..=10).map(f64::from)).p95, Some(10.0));
        assert_eq!(median_count([9, 1, 5, 3]), Some(3));
        assert_eq!(median_count([9, 1, 5]), Some(5));
    }

    #[test]
    fn samples_that_are_not_finite_do_not_count() {
        assert_eq!(TimeSummary::of([1.0, f64::NAN, 3.0, f64::NEG_INFINITY]).median, Some(2.0));
    }

    #[test]
    fn ratios() {
        assert_eq!(ratio(Some(9.0), Some(3.0)), Some(3.0));
        assert_eq!(ratio(Some(9.0), Some(0.0)), None);
        assert_eq!(ratio(Some(0.0), Some(0.0)), None);
        assert_eq!(ratio(None, Some(1.0)), None);
        assert_eq!(ratio(Some(1.0), None), None);
    }

    #[test]
    fn paired_ratios_are_taken_frame_by_frame() {
        // The ratio of the medians would be 4 / 1.
        let a = [Some(1.0), Some(4.0), Some(9.0)];
        let b = [Some(1.0), Some(2.0), Some(0.5)];
        assert_eq!(paired_ratio(&a, &b), Some(2.0));
        assert_eq!(paired_ratio(&a, &b[..1]), Some(1.0), "what has no partner does not count");
        assert_eq!(
            paired_ratio(&[Some(1.0), None, Some(3.0)], &[Some(0.0), b[1], b[1]]),
            Some(1.5)
        );
        assert_eq!(paired_ratio(&[None], &[Some(1.0)]), None);
        assert_eq!(paired_ratio(&[], &[]), None);
    }

    proptest! {
        #[test]
        fn a_summary_is_ordered_finite_and_blind_to_order(
            samples in prop::collection::vec(prop::num::f64::ANY, 0..50)
        ) {
            let summary = TimeSummary::of(samples.iter().copied());
            let reversed = TimeSummary::of(samples.iter().rev().copied());
            prop_assert_eq!(summary, reversed);
            prop_assert_eq!(summary.median.is_some(), samples.iter().any(|s| s.is_finite()));
            if let TimeSummary { median: Some(median), p95: Some(p95), max: Some(max) } = summary {
                prop_assert!(median.is_finite() && p95.is_finite() && max.is_finite());
                prop_assert!(median <= p95 && p95 <= max);
            }
        }

        #[test]
        fn at_least_95_percent_do_not_exceed_p95(
            samples in prop::collection::vec(0u32..1000, 1..200)
        ) {
            let p95 = TimeSummary::of(samples.iter().map(|&s| f64::from(s))).p95.unwrap();
            let within = samples.iter().filter(|&&s| f64::from(s) <= p95).count();
            let below = samples.iter().filter(|&&s| f64::from(s) < p95).count();
            prop_assert!(within * 100 >= samples.len() * 95);
            prop_assert!(below * 100 < samples.len() * 95);
        }
    }
}
