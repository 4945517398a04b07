//! Collects the measurements of each frame of one strategy, and sums them up for the report.

use std::collections::BTreeMap;

use antumbra::render::FrameReport;

use crate::image_difference::{ImageDifference, pixels_that_differ};
use crate::report::{AgeReport, CorrectionsReport, RunReport, kept_times};
use crate::schedule::WalkStep;
use crate::shadow_choice::ShadowChoice;
use crate::statistics::{TimeSummary, median_count};
use crate::strategy::Strategy;
use crate::transparency::FragmentsReport;

/// The measurements of one timed frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameMeasurement {
    /// The time of the whole frame in milliseconds.
    pub frame_ms: f64,
    /// The CPU time of the engine in it, in milliseconds.
    pub cpu_ms: f64,
    /// The engine's report.
    pub report: FrameReport,
    /// Draws of objects that were submitted.
    pub draws: u64,
    /// Triangles of these draws.
    pub triangles: u64,
    /// Waits of the frame loop other than for the frame's own slot.
    pub blocking_waits: u64,
    /// Visible samples that were left out because of a threshold.
    pub samples_below_threshold: u64,
    /// True if the frame is compared with plain frustum culling.
    pub is_compared: bool,
}

/// The counts of frames that are not timed.
#[derive(Clone, Copy, Debug, Default)]
struct WarmUp {
    blocking_waits: u64,
    frames_verified: u64,
    /// Samples below the threshold in compared frames.
    samples_below_threshold: u64,
}

/// The frames of one strategy so far.
#[derive(Clone, Debug)]
pub struct RunMeasurement {
    strategy: Strategy,
    shadows: Option<ShadowChoice>,
    fixed64: ImageDifference,
    frames: Vec<FrameMeasurement>,
    warm_up: WarmUp,
    frames_verified: u64,
    pixels_wrong: u64,
    passes: BTreeMap<&'static str, Vec<f64>>,
    /// Frames whose passes were timed.
    frames_of_passes: usize,
}

impl RunMeasurement {
    /// Creates a run without frames.
    pub fn new(strategy: Strategy) -> Self {
        Self {
            strategy,
            shadows: None,
            fixed64: ImageDifference::default(),
            frames: Vec::new(),
            warm_up: WarmUp::default(),
            frames_verified: 0,
            pixels_wrong: 0,
            passes: BTreeMap::new(),
            frames_of_passes: 0,
        }
    }

    /// Returns the run, marked with its way to draw shadows.
    #[must_use]
    pub fn with_shadows(self, shadows: Option<ShadowChoice>) -> Self {
        Self { shadows, ..self }
    }

    /// Returns true while there is no timed frame.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Adds a timed frame.
    pub fn push(&mut self, frame: FrameMeasurement) {
        self.frames.push(frame);
    }

    /// Adds a frame that is not timed: its waits count all the same, and its samples below the
    /// threshold if it is compared.
    pub fn warmed_up(&mut self, frame: &FrameMeasurement) {
        self.warm_up.blocking_waits += frame.blocking_waits;
        if frame.is_compared {
            self.warm_up.samples_below_threshold += frame.samples_below_threshold;
        }
    }

    /// Adds the result of comparing a frame that is not timed.
    pub fn verified_warm_up(&mut self, pixels_wrong: u64) {
        self.warm_up.frames_verified += 1;
        self.pixels_wrong += pixels_wrong;
    }

    /// Adds the result of comparing a timed frame with plain frustum culling.
    pub fn verified(&mut self, pixels_wrong: u64) {
        self.frames_verified += 1;
        self.pixels_wrong += pixels_wrong;
    }

    /// Adds the comparison of a frame with its images by plain frustum culling and by the filter
    /// `fixed64`. The latter is empty if that filter is not compared.
    pub fn compare(&mut self, step: &WalkStep, image: &[u8], reference: &[u8], fixed64: &[u8]) {
        let pixels_wrong = pixels_that_differ(reference, image);
        if step.timed {
            self.verified(pixels_wrong)
        } else {
            self.verified_warm_up(pixels_wrong)
        }
        self.fixed64.add(image, fixed64);
    }

    /// Adds the GPU times of one frame's passes; the times of passes with the same label are added.
    /// A pass that is missing in this frame counts as 0.
    pub fn timed_passes(&mut self, passes: impl IntoIterator<Item = (&'static str, f64)>) {
        let mut frame = BTreeMap::new();
        for (label, gpu_ms) in passes {
            *frame.entry(label).or_insert(0.0) += gpu_ms;
        }
        for (label, gpu_ms) in frame {
            let times = self.passes.entry(label).or_default();
            times.resize(self.frames_of_passes, 0.0);
            times.push(gpu_ms);
        }
        self.frames_of_passes += 1;
    }

    /// Sums the frames up.
    pub fn report(&self) -> RunReport {
        let times = |of: fn(&FrameMeasurement) -> f64| TimeSummary::of(self.frames.iter().map(of));
        let count = |of: fn(&FrameMeasurement) -> u64| median_count(self.frames.iter().map(of));
        let below_threshold = |of: fn(&FrameMeasurement) -> bool| {
            let frames = self.frames.iter().filter(|frame| of(frame));
            frames.map(|frame| frame.samples_below_threshold).sum::<u64>()
        };
        let ages = || self.frames.iter().filter_map(|frame| frame.report.oldest_answer_frames);
        let is_verified = self.frames_verified + self.warm_up.frames_verified > 0;
        let timed_waits: u64 = self.frames.iter().map(|frame| frame.blocking_waits).sum();
        RunReport {
            strategy: self.strategy.name().to_owned(),
            shadows: self.shadows.map(|shadow| shadow.way.name().to_owned()),
            filter: self.shadows.map(|shadow| shadow.filter.name().to_owned()),
            bias: self.shadows.map(|shadow| shadow.bias.name().to_owned()),
            shadow_faces: self
                .shadows
                .and_then(|_| count(|frame| frame.report.shadows.drawn_faces.into())),
            shadow_casters: self
                .shadows
                .and_then(|_| count(|frame| frame.report.shadows.casters.into())),
            shadow_triangles: self.shadows.and_then(|_| count(shadow_triangles)),
            fixed64_difference_mean: self.fixed64.mean(),
            fixed64_difference_max: self.fixed64.most(),
            frame_ms: times(|frame| frame.frame_ms),
            frame_times_ms: kept_times(self.frames.iter().map(|frame| frame.frame_ms)),
            cpu_ms: times(|frame| frame.cpu_ms),
            draws: count(|frame| frame.draws),
            triangles: count(|frame| frame.triangles),
            tests: count(|frame| frame.report.tests.into()),
            queries: count(|frame| frame.report.queries.into()),
            predicated_draws: count(|frame| frame.report.predicated_draws.into()),
            nodes_visited: count(|frame| frame.report.plan.nodes_visited.into()),
            untested_by_cost: count(|frame| frame.report.plan.untested_by_cost.into()),
            rounds_by_compute: count(|frame| frame.report.plan.rounds_by_compute.into()),
            retest_interval_frames: count(|frame| frame.report.plan.retest_interval_frames.into()),
            expected_saving_ns: count(|frame| frame.report.plan.expected_saving_ns),
            corrections: self
                .frames
                .last()
                .and_then(|frame| frame.report.corrections)
                .filter(|_| self.strategy.uses_cost_model())
                .map(CorrectionsReport::from),
            result_age_frames: AgeReport { median: median_count(ages()), max: ages().max() },
            waits: count(|frame| frame.blocking_waits),
            blocking_waits: timed_waits + self.warm_up.blocking_waits,
            frames_timed: u64::try_from(self.frames.len()).unwrap_or(u64::MAX),
            frames_verified: self.frames_verified,
            passes_ms: self
                .passes
                .iter()
                .map(|(label, times)| {
                    let none = std::iter::repeat_n(0.0, self.frames_of_passes - times.len());
                    ((*label).to_owned(), TimeSummary::of(times.iter().copied().chain(none)))
                })
                .collect(),
            warm_up_frames_verified: self.warm_up.frames_verified,
            pixels_wrong: is_verified.then_some(self.pixels_wrong),
            pixels_wrong_at_most: (is_verified && self.strategy.is_exact()).then(|| {
                below_threshold(|frame| frame.is_compared) + self.warm_up.samples_below_threshold
            }),
            samples_below_threshold: below_threshold(|_| true),
            fragments: FragmentsReport::most(
                self.frames.iter().map(|frame| frame.report.fragments),
            ),
        }
    }
}

/// Returns the triangles of casters that were drawn without a test or revealed by earlier tests.
fn shadow_triangles(frame: &FrameMeasurement) -> u64 {
    frame.report.shadows.triangles + frame.report.shadows.revealed_triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_up_frames() {
        let mut run = RunMeasurement::new(Strategy::ANTUMBRA);
        for (draws, age, waits) in [(5, None, 1), (9, Some(1), 0), (7, Some(3), 0)] {
            run.push(FrameMeasurement {
                draws,
                report: FrameReport { oldest_answer_frames: age, ..FrameReport::default() },
                blocking_waits: waits,
                samples_below_threshold: draws,
                is_compared: draws != 9,
                ..FrameMeasurement::default()
            });
        }
        for is_compared in [true, false] {
            run.warmed_up(&FrameMeasurement {
                blocking_waits: 1,
                samples_below_threshold: 100,
                is_compared,
                ..FrameMeasurement::default()
            });
        }
        run.verified_warm_up(3);
        run.verified(0);
        run.verified(4);
        for visible in [2.0, 4.0, 3.0] {
            run.timed_passes([("visible", visible), ("revealed", 1.0), ("revealed", 0.5)]);
        }
        run.timed_passes([("visible", 9.0), ("seldom", 8.0)]);
        run.timed_passes([("visible", 2.5), ("revealed", 1.5)]);
        let report = run.report();
        assert_eq!(report.draws, Some(7));
        assert_eq!(report.result_age_frames, AgeReport { median: Some(1), max: Some(3) });
        assert_eq!((report.waits, report.blocking_waits), (Some(0), 3));
        assert_eq!((report.frames_timed, report.frames_verified), (3, 2));
        assert_eq!((report.pixels_wrong, report.pixels_wrong_at_most), (Some(7), Some(112)));
        assert_eq!(report.warm_up_frames_verified, 1);
        assert_eq!(report.samples_below_threshold, 21);
        assert_eq!(report.passes_ms["visible"].median, Some(3.0));
        assert_eq!(report.passes_ms["revealed"].median, Some(1.5));
        assert_eq!(report.passes_ms["seldom"].median, Some(0.0), "in most frames it took no time");
        assert_eq!(report.passes_ms["seldom"].max, Some(8.0));
    }
}
