//! The scale of the graph of frame times, which does not depend on single frames.

/// The share of frames that determines the graph's height; slower frames are cut and marked.
const DECISIVE_SHARE: f32 = 0.9;
/// The ratio of the scale to the slowest of these frames.
const HEADROOM: f32 = 1.25;
/// The possible ends of scales, times a power of ten.
const STEPS: [f32; 7] = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.5];

/// The range of the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphScale {
    /// The upper end (milliseconds).
    pub top_ms: f32,
    /// The slowest frame (milliseconds).
    pub slowest_ms: f32,
    /// The number of frames beyond the upper end.
    pub cut: usize,
}

impl GraphScale {
    /// Returns the scale for frames that took `frames_ms`, with the budget `budget_ms`; `None`
    /// without frames.
    pub fn of(frames_ms: &[f32], budget_ms: Option<f32>) -> Option<Self> {
        let mut sorted: Vec<f32> = frames_ms.iter().copied().filter(|ms| ms.is_finite()).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let slowest_ms = *sorted.last()?;
        let decisive = ((sorted.len() - 1) as f32 * DECISIVE_SHARE) as usize;
        let needed = (sorted[decisive] * HEADROOM).max(budget_ms.unwrap_or_default() * HEADROOM);
        let top_ms = ceiling(needed);
        let cut = sorted.iter().filter(|ms| **ms > top_ms).count();
        Some(Self { top_ms, slowest_ms, cut })
    }

    /// Returns the height of a frame's bar, from 0 to 1.
    pub fn height(&self, ms: f32) -> f32 {
        (ms / self.top_ms).clamp(0.0, 1.0)
    }
}

/// Returns the least round number of at least `ms`.
fn ceiling(ms: f32) -> f32 {
    let ms = if ms.is_finite() { ms.clamp(0.1, 1e7) } else { 1.0 };
    let power = 10.0_f32.powf(ms.log10().floor());
    let steps = STEPS.map(|step| step * power);
    steps.into_iter().find(|step| *step >= ms * 0.999).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_spike_flattens_nothing_and_is_counted() {
        let steady = [16.0; 100];
        let calm = GraphScale::of(&steady, Some(16.7)).unwrap();
        assert_eq!((calm.top_ms, calm.cut), (30.0, 0));
        let mut spiked = steady;
        spiked[40] = 900.0;
        let scale = GraphScale::of(&spiked, Some(16.7)).unwrap();
        assert_eq!(scale, GraphScale { slowest_ms: 900.0, cut: 1, ..calm });
        assert!(scale.height(16.0) > 0.5 && scale.height(900.0) <= 1.0);
    }

    #[test]
    fn a_scale_is_round_and_holds_nearly_all() {
        for (ms, top) in [(0.1, 0.15), (0.9, 1.5), (7.0, 10.0), (90.0, 150.0), (151.0, 200.0)] {
            let scale = GraphScale::of(&[ms; 10], None).unwrap();
            assert!((scale.top_ms - top).abs() < 1e-3 * top, "{ms}: {scale:?}");
        }
        let fast = GraphScale::of(&[2.0; 50], Some(16.7)).unwrap();
        assert!(fast.top_ms > 16.7, "the budget is in the graph: {fast:?}");
        assert_eq!(GraphScale::of(&[], Some(16.7)), None);
        assert_eq!(GraphScale::of(&[f32::NAN], None), None);
    }
}
