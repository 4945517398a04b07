//! The walk: every strategy takes its turns over the frames, is timed, and is compared with plain
//! frustum culling on request.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use antumbra::cull::{FrameId, Strategy};
use antumbra::gpu::{Device, Readback};
use antumbra::methods;
use antumbra::render::{Renderer, VisibleSet};

use crate::Options;
use crate::camera_path::CameraTrack;
use crate::choices::{ProjectionChoice, Verify};
use crate::eyes::Eyes;
use crate::measurement::{FrameMeasurement, RunMeasurement};
use crate::memory::copy_of;
use crate::moving::Moving;
use crate::progress::WalkProgress;
use crate::report::RunReport;
use crate::run_error::RunError;
use crate::schedule::{Schedule, WalkStep};
use crate::shadow_choice::ShadowChoice;
use crate::signals::Signals;
use crate::stopwatch::Stopwatch;

/// A walk over a path: the strategies with a history each.
pub struct Walk<'a> {
    renderer: &'a mut Renderer,
    device: Device,
    path: &'a CameraTrack,
    moving: &'a mut Moving,
    views: u32,
    projection: ProjectionChoice,
    verify: Verify,
    frames_in_flight: usize,
    schedule: Schedule,
    runs: Vec<Run>,
    reference: Eyes,
    /// The reference images, by the number of their shadows and the frame.
    references: BTreeMap<(usize, u32), Vec<u8>>,
    /// The ways to draw shadows of the references.
    reference_shadows: Vec<ShadowChoice>,
    images: Vec<Readback>,
    // The objects that own a pixel in each frame, for `ideal`.
    visible_sets: BTreeMap<u32, Vec<VisibleSet>>,
}

/// One strategy in the walk, with one way to draw shadows.
struct Run {
    strategy: Strategy,
    shadows: ShadowChoice,
    eyes: Eyes,
    measurement: RunMeasurement,
}

/// A frame of the turn: known in part when it was submitted, the rest when its results were read
/// back.
struct Walked {
    frame: FrameId,
    timed: bool,
    measurement: FrameMeasurement,
}

impl<'a> Walk<'a> {
    /// Prepares a walk; every strategy starts with an empty history.
    ///
    /// # Errors
    /// When the device fails.
    pub fn new(
        renderer: &'a mut Renderer,
        path: &'a CameraTrack,
        moving: &'a mut Moving,
        options: &Options,
    ) -> Result<Self, RunError> {
        let run = |(shadows, strategy): (Option<ShadowChoice>, Strategy)| -> Result<Run, RunError> {
            let eyes = Eyes::new(renderer, options.asked.views, options.asked.projection)?;
            let measurement = RunMeasurement::new(strategy).with_shadows(shadows);
            Ok(Run { strategy, shadows: shadows.unwrap_or(ShadowChoice::OFF), eyes, measurement })
        };
        let combinations = combinations(&options.shadows, &options.strategies);
        let runs: Vec<Run> = combinations.into_iter().map(run).collect::<Result<_, _>>()?;
        Ok(Self {
            schedule: Schedule::new(options.asked.frames, runs.len()),
            runs,
            reference: Eyes::new(renderer, options.asked.views, options.asked.projection)?,
            device: renderer.device().clone(),
            renderer,
            path,
            moving,
            views: options.asked.views,
            projection: options.asked.projection,
            verify: options.asked.verify,
            frames_in_flight: usize::try_from(options.asked.frames_in_flight).unwrap_or(usize::MAX),
            references: BTreeMap::new(),
            reference_shadows: Vec::new(),
            images: Vec::new(),
            visible_sets: BTreeMap::new(),
        })
    }

    /// Finds the visible set of every frame if `ideal` is among the strategies. Not timed.
    fn find_visible_sets(
        &mut self,
        progress: &dyn WalkProgress,
        signals: &Signals,
    ) -> Result<(), RunError> {
        if self.runs.iter().all(|run| run.strategy != methods::IDEAL) {
            return Ok(());
        }
        let mut eyes = Eyes::new(self.renderer, self.views, self.projection)?;
        let frames: BTreeSet<u32> = self.schedule.steps().map(|step| step.frame).collect();
        progress.begin_frames("finding the visible sets", frames.len() as u64);
        for frame in frames {
            signals.check()?;
            self.moving.show(self.renderer, frame)?;
            let sets = eyes.visible_sets(self.renderer, &self.path.frame_camera(frame))?;
            self.visible_sets.insert(frame, sets);
            progress.frame_done("");
        }
        Ok(())
    }

    /// Walks all of the path, or as much as possible before a signal.
    ///
    /// # Errors
    /// When the device fails, or a signal came before anything was measured.
    pub fn run(
        mut self,
        progress: &dyn WalkProgress,
        signals: &Signals,
    ) -> Result<Vec<RunReport>, RunError> {
        self.find_visible_sets(progress, signals)?;
        progress.begin_frames("drawing", self.schedule.len());
        let mut steps: VecDeque<WalkStep> = self.schedule.steps().collect();
        while let (Some(turn), None) = (next_turn(&mut steps), signals.received()) {
            self.walk_turn(&turn, progress, signals)?;
        }
        if self.runs.iter().all(|run| run.measurement.is_empty()) {
            signals.check()?;
        }
        Ok(self.runs.iter().map(|run| run.measurement.report()).collect())
    }

    /// Walks one strategy over some consecutive frames; the images are compared at the end, so
    /// that comparing is in no measured time.
    fn walk_turn(
        &mut self,
        turn: &[WalkStep],
        progress: &dyn WalkProgress,
        signals: &Signals,
    ) -> Result<(), RunError> {
        let verify = self.verify;
        // Warm-up frames, too: a history begins with the first of them.
        let compared = || turn.iter().filter(|step| verify.includes(step.frame));
        let own = turn.first().and_then(|step| self.runs.get(step.strategy));
        let shadows = own.map_or(ShadowChoice::OFF, |run| run.shadows);
        let frames = compared().map(|step| step.frame);
        let reference = self.draw_references(shadows.reference(), frames.clone())?;
        let fixed64 = shadows
            .fixed64()
            .filter(|fixed64| self.runs.iter().any(|run| run.shadows.reference() == *fixed64));
        let fixed64 = fixed64.map(|fixed64| self.draw_references(fixed64, frames)).transpose()?;
        self.renderer.set_shadows(shadows.options())?;
        while self.images.len() < compared().count() {
            self.images.push(Readback::new(&self.device, self.renderer.size())?);
        }
        let Some(run) = turn.first().and_then(|step| self.runs.get_mut(step.strategy)) else {
            return Ok(());
        };
        let mut walked = Vec::with_capacity(turn.len());
        let mut images = self.images.iter();
        let mut clock = Stopwatch::start();
        for step in turn.iter().take_while(|_| signals.received().is_none()) {
            let moved = self.moving.show(self.renderer, step.frame)?;
            let image = verify.includes(step.frame).then(|| images.next()).flatten();
            let camera = self.path.frame_camera(step.frame);
            let visible = self.visible_sets.get_mut(&step.frame);
            let visible = visible.map_or(&mut [][..], Vec::as_mut_slice);
            if run.strategy == methods::IDEAL {
                // Every moving object is where it was when the sets of this frame were found.
                visible.iter_mut().try_for_each(|set| self.renderer.visible_again(set))?;
            }
            let waits = self.device.wait_counts().other;
            let report = run.eyes.render(self.renderer, run.strategy, &camera, visible, image)?;
            let measurement = FrameMeasurement {
                // From submit to submit: in a full pipeline, the time a frame takes.
                frame_ms: clock.lap_ms(),
                cpu_ms: (moved + report.cpu).as_secs_f64() * 1e3,
                blocking_waits: self.device.wait_counts().other - waits,
                is_compared: image.is_some(),
                report,
                ..FrameMeasurement::default()
            };
            let frame = run.eyes.frame();
            walked.push(Walked { frame, timed: step.timed, measurement });
            // A slot reports the times of its previous frame, which is of this turn once all slots
            // were used.
            if step.timed && walked.len() > self.frames_in_flight {
                let passes = self.renderer.pass_times();
                run.measurement.timed_passes(passes.iter().map(|pass| (pass.label, pass.gpu_ms)));
            }
            progress.frame_done(run.strategy.name());
        }
        run.eyes.wait_idle(self.renderer)?;
        let drawn = walked.len();
        book(run, walked);
        let compared = turn.iter().take(drawn).filter(|step| verify.includes(step.frame));
        for (image, step) in self.images.iter().zip(compared) {
            let of = |shadows| self.references.get(&(shadows, step.frame));
            let of = |shadows: Option<usize>| shadows.and_then(of).map_or(&[][..], Vec::as_slice);
            run.measurement.compare(step, &image.rgba8()?, of(Some(reference)), of(fixed64));
        }
        Ok(())
    }

    /// Draws the reference images of `frames` with plain frustum culling and these shadows, unless
    /// they exist from another run's turn in the same round. Returns the number of these shadows.
    fn draw_references(
        &mut self,
        shadows: ShadowChoice,
        frames: impl Iterator<Item = u32>,
    ) -> Result<usize, RunError> {
        let number = self.reference_shadows.iter().position(|known| *known == shadows);
        let number = number.unwrap_or_else(|| {
            self.reference_shadows.push(shadows);
            self.reference_shadows.len() - 1
        });
        let frames: BTreeSet<u32> = frames.collect();
        if frames.iter().all(|frame| self.references.contains_key(&(number, *frame))) {
            return Ok(number);
        }
        // References with other shadows stay if their frames are of this round.
        self.references.retain(|(of, frame), _| *of != number && frames.contains(frame));
        self.renderer.set_shadows(shadows.options())?;
        let image = Readback::new(&self.device, self.renderer.size())?;
        for frame in frames {
            self.moving.show(self.renderer, frame)?;
            let camera = self.path.frame_camera(frame);
            let wanted = Some(&image);
            self.reference.render(self.renderer, Strategy::FRUSTUM, &camera, &[], wanted)?;
            self.reference.wait_idle(self.renderer)?;
            self.references.insert((number, frame), copy_of(&image.rgba8()?)?);
        }
        Ok(number)
    }
}

/// Returns each way to draw shadows with each strategy; each strategy alone if there are no ways.
fn combinations(
    shadows: &[ShadowChoice],
    strategies: &[Strategy],
) -> Vec<(Option<ShadowChoice>, Strategy)> {
    let ways: Vec<Option<ShadowChoice>> = match shadows {
        [] => vec![None],
        ways => ways.iter().copied().map(Some).collect(),
    };
    ways.iter().flat_map(|way| strategies.iter().map(|strategy| (*way, *strategy))).collect()
}

/// Adds the results that were read back to the frames of a turn, and the frames to the run.
fn book(run: &mut Run, mut walked: Vec<Walked>) {
    for outcome in run.eyes.drain_stats() {
        if let Some(walked) = walked.iter_mut().find(|walked| walked.frame == outcome.frame) {
            walked.measurement.draws += outcome.draws;
            walked.measurement.triangles += outcome.triangles;
            walked.measurement.samples_below_threshold += outcome.samples_below_threshold;
        }
    }
    for Walked { timed, measurement, .. } in walked {
        if timed {
            run.measurement.push(measurement);
        } else {
            run.measurement.warmed_up(&measurement);
        }
    }
}

/// Takes the steps up to the next change of turns: a turn's warm-up follows another's timed frames.
fn next_turn(steps: &mut VecDeque<WalkStep>) -> Option<Vec<WalkStep>> {
    let mut turn = vec![steps.pop_front()?];
    while let (Some(last), Some(next)) = (turn.last(), steps.front()) {
        if last.strategy != next.strategy || (last.timed && !next.timed) {
            break;
        }
        turn.extend(steps.pop_front());
    }
    Some(turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadow_choice::ShadowWay;

    #[test]
    fn turns_are_cut_where_the_schedule_cuts_them() {
        for strategies in 1..=3 {
            let schedule = Schedule::with_rounds(30, strategies, 10, 2);
            let mut steps: VecDeque<WalkStep> = schedule.steps().collect();
            let mut turns = 0;
            while let Some(turn) = next_turn(&mut steps) {
                assert_eq!(turn.len(), 12);
                assert!(turn.iter().all(|step| step.strategy == turn[0].strategy));
                turns += 1;
            }
            assert_eq!(turns, 3 * strategies);
        }
    }

    #[test]
    fn shadows_are_combined_with_strategies() {
        let strategies = [Strategy::FRUSTUM, Strategy::ANTUMBRA];
        let alone = [(None, Strategy::FRUSTUM), (None, Strategy::ANTUMBRA)];
        assert_eq!(combinations(&[], &strategies), alone);
        let maps = ShadowChoice { way: ShadowWay::Maps, ..ShadowChoice::OFF };
        let combined = combinations(&[ShadowChoice::OFF, maps], &strategies);
        assert_eq!(combined.len(), 4);
        assert_eq!(combined[2], (Some(maps), Strategy::FRUSTUM));
    }
}
