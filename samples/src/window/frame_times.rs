//! The CPU and GPU times of the newest frames.

use std::collections::VecDeque;

use antumbra::gpu::PassTime;
use antumbra::pacing::Time;
use antumbra::render::{FrameReport, OVERLAY_PASSES};

use super::comparison::Side;
use super::conditions::Conditions;

/// The number of frames in the graph.
const KEPT: usize = 130;
/// The number of frames in the CPU's median; the GPU's median uses `GPU_FRAMES`.
const CPU_FRAMES: usize = 32;
const GPU_FRAMES: usize = 5;
/// The time over which the frame rate is measured, if there are enough frames (milliseconds).
const RATE_MS: f32 = 1000.0;

/// The newest numbers of one kind. Does not allocate.
#[derive(Clone, Debug)]
struct Recent<const COUNT: usize> {
    ring: [f32; COUNT],
    count: usize,
}

impl<const COUNT: usize> Default for Recent<COUNT> {
    fn default() -> Self {
        Self { ring: [0.0; COUNT], count: 0 }
    }
}

impl<const COUNT: usize> Recent<COUNT> {
    fn push(&mut self, number: f32) {
        self.ring[self.count % COUNT] = number;
        self.count += 1;
    }

    /// Returns the numbers, oldest first.
    fn iter(&self) -> impl DoubleEndedIterator<Item = f32> {
        let first = self.count.saturating_sub(COUNT);
        (first..self.count).map(|place| self.ring[place % COUNT])
    }

    /// Returns the median, which single outliers do not affect.
    fn median(&self) -> Option<f32> {
        let mut sorted = self.ring;
        let sorted = &mut sorted[..self.count.min(COUNT)];
        sorted.sort_unstable_by(f32::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }

    fn mean(&self) -> Option<f32> {
        let count = self.count.min(COUNT);
        (count > 0).then(|| self.iter().sum::<f32>() / count as f32)
    }
}

/// The times of the newest frames under the same conditions.
#[derive(Clone, Debug, Default)]
pub struct FrameTimeSeries {
    conditions: Option<Conditions>,
    intervals: Recent<KEPT>,
    last: Option<Time>,
    cpu: Recent<CPU_FRAMES>,
    overlay_cpu: Recent<CPU_FRAMES>,
    /// The times with and without culling.
    gpu: [Recent<GPU_FRAMES>; 2],
    overlay_gpu: Recent<GPU_FRAMES>,
    /// The layout time since the newest frame.
    layout_ms: f32,
    passes: Vec<PassTime>,
    /// The pending frames under these conditions, oldest first.
    sent: VecDeque<Side>,
}

impl FrameTimeSeries {
    /// Removes everything if `conditions` differ from the previous frames' conditions.
    pub fn follow(&mut self, conditions: Conditions) {
        if self.conditions != Some(conditions) {
            *self = Self { conditions: Some(conditions), ..Self::default() };
        }
    }

    /// Records that a frame started.
    pub fn push(&mut self, started: Time) {
        if let Some(last) = self.last.replace(started) {
            self.intervals.push(started.since(last).as_secs_f32() * 1e3);
        }
    }

    /// Records that laying out the overlay took `ms` on the CPU.
    pub fn laid_out(&mut self, ms: f32) {
        self.layout_ms += ms;
    }

    /// Records the CPU times of a frame.
    pub fn take(&mut self, report: &FrameReport) {
        let overlay_ms = std::mem::take(&mut self.layout_ms);
        self.cpu.push(report.cpu.as_secs_f32() * 1e3);
        self.overlay_cpu.push(report.overlay_cpu.as_secs_f32() * 1e3 + overlay_ms);
    }

    /// Records that a frame with or without culling was submitted. `passes` are the timed passes of
    /// the frame that used the same slot before.
    pub fn sent(&mut self, side: Side, passes: &[PassTime]) {
        self.sent.push_back(side);
        let in_flight = self.conditions.map_or(0, |conditions| conditions.frames_in_flight);
        // Until then, the passes belong to frames under other conditions.
        let finished = if self.sent.len() > in_flight { self.sent.pop_front() } else { None };
        let Some(side) = finished.filter(|_| !passes.is_empty()) else { return };
        let (overlay, engine): (Vec<_>, Vec<_>) = passes.iter().partition(is_overlay);
        let sum = |passes: Vec<&PassTime>| passes.iter().map(|pass| pass.gpu_ms).sum::<f64>();
        self.gpu[side as usize].push(sum(engine) as f32);
        self.overlay_gpu.push(sum(overlay) as f32);
        if side == Side::Culled {
            self.passes.clear();
            self.passes.extend_from_slice(passes);
        }
    }

    /// Returns the times from frame to frame in milliseconds, oldest first.
    pub fn newest_ms(&self) -> impl Iterator<Item = f32> {
        self.intervals.iter()
    }

    /// Returns the mean time from frame to frame over the last second, in milliseconds.
    pub fn mean_ms(&self) -> Option<f32> {
        let mut sum_ms = 0.0;
        let mut count = 0_u32;
        for interval in self.intervals.iter().rev() {
            if sum_ms >= RATE_MS {
                break;
            }
            sum_ms += interval;
            count += 1;
        }
        (count > 0).then(|| sum_ms / count as f32)
    }

    /// Returns the CPU times in milliseconds: the median of the engine, and the mean of the
    /// overlay, which is laid out only in some frames.
    pub fn cpu_ms(&self) -> [Option<f32>; 2] {
        [self.cpu.median(), self.overlay_cpu.mean()]
    }

    /// Returns the median GPU times of the engine and of the overlay, in milliseconds.
    pub fn gpu_ms(&self) -> [Option<f32>; 2] {
        [self.gpu[Side::Culled as usize].median(), self.overlay_gpu.median()]
    }

    /// Returns the median GPU time of frames without culling, during a comparison.
    pub fn unculled_gpu_ms(&self) -> Option<f32> {
        self.gpu[Side::Unculled as usize].median()
    }

    /// Returns the passes of the newest timed frame.
    pub fn passes(&self) -> &[PassTime] {
        &self.passes
    }
}

/// Returns true if a pass draws an overlay over the image.
pub fn is_overlay(pass: &&PassTime) -> bool {
    OVERLAY_PASSES.contains(&pass.label)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use antumbra::gpu::PresentMode;

    use super::*;
    use bench::strategy::Strategy;

    fn conditions() -> Conditions {
        Conditions {
            strategy: Strategy::ANTUMBRA,
            size: [640, 360],
            frames_in_flight: 2,
            present_mode: Some(PresentMode::Fifo),
            scene: 0,
            is_comparing: false,
        }
    }

    fn pass(label: &'static str, gpu_ms: f64) -> PassTime {
        PassTime { label, gpu_ms, began_ns: 0 }
    }

    #[test]
    fn the_newest_are_kept_in_their_order() {
        let mut times = FrameTimeSeries::default();
        let mut now = 0;
        for frame in 0..300_u64 {
            now += frame * 1_000_000;
            times.push(Time::from_nanos(now));
        }
        let kept: Vec<f32> = times.newest_ms().collect();
        assert_eq!((kept.len(), kept[0], kept[KEPT - 1]), (KEPT, 170.0, 299.0));
        // 299 + 298 + 297 + 296 is more than a second.
        assert_eq!(times.mean_ms(), Some(297.5));
    }

    #[test]
    fn the_overlay_costs_apart_from_the_engine() {
        let mut times = FrameTimeSeries::default();
        times.follow(Conditions { frames_in_flight: 0, ..conditions() });
        let report = FrameReport {
            cpu: Duration::from_millis(3),
            overlay_cpu: Duration::from_millis(1),
            ..FrameReport::default()
        };
        let passes =
            [pass("draw visible", 4.0), pass("host overlay", 0.5), pass("view from above", 1.5)];
        for passes in [&passes[..], &[]] {
            times.laid_out(0.5);
            times.take(&report);
            times.sent(Side::Culled, passes);
        }
        assert_eq!(times.cpu_ms(), [Some(3.0), Some(1.5)]);
        assert_eq!(times.gpu_ms(), [Some(4.0), Some(2.0)]);
        assert_eq!(times.passes(), passes);
    }

    #[test]
    fn other_conditions_begin_with_nothing() {
        let old = conditions();
        for new in [
            Conditions { strategy: Strategy::FRUSTUM, ..old },
            Conditions { size: [640, 361], ..old },
            Conditions { frames_in_flight: 3, ..old },
            Conditions { present_mode: Some(PresentMode::Immediate), ..old },
            Conditions { scene: 1, ..old },
            Conditions { is_comparing: true, ..old },
        ] {
            let mut times = FrameTimeSeries::default();
            let take = |times: &mut FrameTimeSeries, conditions, frame: u64| {
                times.follow(conditions);
                times.push(Time::from_nanos(frame * 10_000_000));
                times.sent(Side::Culled, &[pass("draw visible", frame as f64)]);
            };
            (0..9).for_each(|frame| take(&mut times, old, frame));
            assert_eq!(times.newest_ms().count(), 8);
            take(&mut times, new, 9);
            assert_eq!((times.newest_ms().count(), times.mean_ms()), (0, None), "{new:?}");
            let first = 9 + new.frames_in_flight as u64;
            (10..first).for_each(|frame| take(&mut times, new, frame));
            assert_eq!(times.gpu_ms(), [None; 2], "these passes are of frames before");
            take(&mut times, new, first);
            let found = (times.newest_ms().count(), times.gpu_ms()[0]);
            assert_eq!(found, (new.frames_in_flight, Some(first as f32)));
        }
    }

    /// Checks that frames with and without culling are timed separately: one in eight frames is
    /// timed, and the first one of each pair.
    #[test]
    fn frames_with_and_without_culling_are_timed_apart() {
        let mut times = FrameTimeSeries::default();
        times.follow(Conditions { is_comparing: true, ..conditions() });
        let mut slots = [None; 2];
        let mut frame = 0;
        for snapshot in 0..40 {
            let mut sides = [Side::Culled, Side::Unculled];
            if snapshot / 10 % 2 == 1 {
                sides.reverse();
            }
            for side in sides {
                let finished: Option<Side> = slots[frame % 2].take();
                let ms = |side| if side == Side::Culled { 4.0 } else { 90.0 };
                let passes: Vec<PassTime> =
                    finished.map(|side| pass("draw visible", ms(side))).into_iter().collect();
                slots[frame % 2] = (frame % 8 == 0).then_some(side);
                times.sent(side, &passes);
                frame += 1;
            }
        }
        assert_eq!((times.gpu_ms()[0], times.unculled_gpu_ms()), (Some(4.0), Some(90.0)));
    }
}
