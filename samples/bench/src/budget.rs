//! The budget of a frame: the time that each part of the method adds to the ideal, by ablations.
//!
//! A walk is drawn and recorded once. Then frames that lack parts of the recorded ones are drawn in
//! turns, over the same walk: each ablation adds one part to the one before, so the differences add
//! up to the time over the ideal. The images of some frames are compared.

mod ablation;
mod args;
mod frame_record;
mod replay_method;

use std::sync::{Arc, Mutex, PoisonError};

use antumbra::cull::{Hierarchy, Strategy};
use antumbra::gpu::{Device, DeviceOptions, Readback};
use antumbra::occlusion::Rect;
use antumbra::render::{FrameRequest, RenderView, Renderer, object_bounds};

use crate::Options;
use crate::camera_path::CameraTrack;
use crate::progress::WalkProgress;
use crate::run;
use crate::run_error::RunError;
use crate::signals::Signals;
use crate::statistics::TimeSummary;
use crate::stopwatch::Stopwatch;
use crate::walk_scene::WalkScene;

pub use ablation::Ablation;
pub use args::BudgetArguments;
use frame_record::FrameRecord;
use replay_method::{WalkRecord, method};

/// The frames drawn before each timed walk of an ablation.
const WARM_UP_FRAMES: u32 = 4;
/// The interval of the frames whose images are compared.
const VERIFIED_INTERVAL_FRAMES: usize = 8;

/// The times of one ablation over all rounds.
#[derive(Clone, Debug, Default)]
pub struct AblationTimes {
    /// The mean time of a frame in each round, in milliseconds.
    pub frame_ms: Vec<f64>,
    /// The mean CPU time of a frame in each round, in milliseconds.
    pub cpu_ms: Vec<f64>,
}

/// The budget of a walk: the times of each ablation, in the order of [`Ablation::ALL`].
#[derive(Clone, Debug, Default)]
pub struct Budget {
    /// The times.
    pub times: [AblationTimes; Ablation::ALL.len()],
    /// The mean number of objects that own a pixel.
    pub visible: f64,
    /// The mean number of drawn objects.
    pub drawn: f64,
    /// The mean number of tests with a proxy of their own.
    pub proxies: f64,
    /// The mean number of rounds.
    pub rounds: f64,
}

/// The walk of a budget.
struct BudgetWalk<'a> {
    renderer: &'a mut Renderer,
    path: &'a CameraTrack,
    record: Arc<Mutex<WalkRecord>>,
    frames: u32,
}

/// Measures the budget of the walk that `options` describe, in `rounds` rounds.
///
/// # Errors
/// As [`run::run`].
pub fn measure(
    options: &Options,
    rounds: u32,
    progress: &dyn WalkProgress,
    signals: &Signals,
) -> Result<Budget, RunError> {
    let instance = run::open_instance(options.asked.device.validation, None)?;
    let adapter = run::pick_adapter(&instance, &options.asked.device.choice())?;
    let device = Device::new(&instance, &adapter, &DeviceOptions::default())?;
    let record = Arc::new(Mutex::new(WalkRecord::default()));
    let mut renderer_options = run::checked_options(&device, options, signals)?;
    renderer_options.methods.push(method(&record));
    let WalkScene { scene, path, .. } = WalkScene::build(options, progress, signals)?;
    let hierarchy = Hierarchy::build(&object_bounds(&scene)?).map_err(RunError::machine)?;
    let mut renderer = run::upload(&device, &scene, hierarchy, options, renderer_options)?;
    let frames = options.asked.frames;
    let mut walk = BudgetWalk { renderer: &mut renderer, path: &path, record, frames };
    walk.record()?;
    walk.verify()?;
    let mut budget = Budget::default();
    walk.count(&mut budget);
    progress.begin_frames("measuring", u64::from(rounds) * Ablation::ALL.len() as u64);
    for round in 0..rounds as usize {
        for turn in 0..Ablation::ALL.len() {
            signals.check()?;
            let place = (turn + round) % Ablation::ALL.len();
            walk.time(Ablation::ALL[place], &mut budget.times[place])?;
            progress.frame_done(Ablation::ALL[place].part());
        }
    }
    Ok(budget)
}

impl BudgetWalk<'_> {
    /// Records the plans of the walk, their results, and the objects that own a pixel.
    fn record(&mut self) -> Result<(), RunError> {
        self.edit(|record| {
            record.frames = vec![FrameRecord::default(); self.frames as usize];
            record.is_planning = true;
        });
        self.time(Ablation::Whole, &mut AblationTimes::default())?;
        self.edit(|record| record.is_planning = false);
        let mut view = self.renderer.new_view()?;
        let area = Rect { origin: [0, 0], size: self.renderer.size() };
        let mut eye = self.renderer.new_view()?;
        for frame in 0..self.frames {
            self.draw(&mut view, Ablation::Replay, frame)?;
            self.renderer.wait_idle(&mut view)?;
            self.edit(|record| record.observed = Some(frame as usize));
            // The results of a frame are read when the next one is planned.
            self.draw(&mut view, Ablation::Replay, frame)?;
            let visible = self.renderer.visible_set(&mut eye, self.path.camera(frame), area)?;
            self.edit(|record| record.frames[frame as usize].see(visible.leaves()));
        }
        self.renderer.wait_idle(&mut view)?;
        Ok(())
    }

    /// Compares the images of some frames with plain frustum culling, for each ablation.
    fn verify(&mut self) -> Result<(), RunError> {
        let mut view = self.renderer.new_view()?;
        let size = self.renderer.size();
        let expected = Readback::new(self.renderer.device(), size)?;
        let found = Readback::new(self.renderer.device(), size)?;
        for frame in (0..self.frames).step_by(VERIFIED_INTERVAL_FRAMES) {
            let camera = self.path.camera(frame);
            let request = FrameRequest::new(Strategy::FRUSTUM, camera);
            self.renderer.render(&mut view, FrameRequest { image: Some(&expected), ..request })?;
            for ablation in Ablation::ALL {
                self.edit(|record| record.next = frame as usize);
                let request = FrameRequest::new(ablation.strategy(), camera);
                self.renderer.render(&mut view, FrameRequest { image: Some(&found), ..request })?;
                self.renderer.wait_idle(&mut view)?;
                if *expected.rgba8()? != *found.rgba8()? {
                    let part = ablation.part();
                    let text = format!("frame {frame} differs with the part \"{part}\"");
                    return Err(RunError::machine(text));
                }
            }
        }
        Ok(())
    }

    /// Walks all frames with an ablation, and adds their mean times.
    fn time(&mut self, ablation: Ablation, times: &mut AblationTimes) -> Result<(), RunError> {
        let mut view = self.renderer.new_view()?;
        for _ in 0..WARM_UP_FRAMES {
            self.draw(&mut view, ablation, 0)?;
        }
        let mut clock = Stopwatch::start();
        let mut cpu_ms = 0.0;
        for frame in 0..self.frames {
            cpu_ms += self.draw(&mut view, ablation, frame)?;
        }
        // In a full pipeline, the time from submit to submit is the time of a frame.
        times.frame_ms.push(clock.lap_ms() / f64::from(self.frames));
        times.cpu_ms.push(cpu_ms / f64::from(self.frames));
        self.renderer.wait_idle(&mut view)?;
        Ok(())
    }

    /// Draws a frame. Returns its CPU time in milliseconds.
    fn draw(
        &mut self,
        view: &mut RenderView,
        ablation: Ablation,
        frame: u32,
    ) -> Result<f64, RunError> {
        self.edit(|record| record.next = frame as usize);
        let request = FrameRequest::new(ablation.strategy(), self.path.camera(frame));
        let report = self.renderer.render(view, request)?;
        Ok(report.cpu.as_secs_f64() * 1e3)
    }

    fn edit(&self, change: impl FnOnce(&mut WalkRecord)) {
        change(&mut self.record.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Counts what the recorded frames draw and test.
    fn count(&self, budget: &mut Budget) {
        let record = self.record.lock().unwrap_or_else(PoisonError::into_inner);
        let mean = |count: &dyn Fn(&FrameRecord) -> usize| {
            record.frames.iter().map(count).sum::<usize>() as f64
                / record.frames.len().max(1) as f64
        };
        budget.visible = mean(&|frame| frame.visible.len());
        budget.drawn = mean(&|frame| {
            frame.plan.draws.len() + frame.plan.queried_draws.len() + frame.revealed.len()
        });
        budget.proxies =
            mean(&|frame| frame.plan.tests.len() - frame.plan.stats.shared_proxies as usize);
        budget.rounds = mean(&|frame| frame.plan.rounds.len());
    }
}

impl Budget {
    /// Returns the budget as a table in Markdown: medians over the rounds, and the median of what
    /// each part adds in the same round.
    pub fn table(&self) -> String {
        let median =
            |samples: &[f64]| TimeSummary::of(samples.iter().copied()).median.unwrap_or(0.0);
        let ideal = median(&self.times[0].frame_ms);
        let mut lines = format!(
            "{:.0} objects own a pixel, {:.0} are drawn; {:.0} proxies in {:.1} rounds\n\n\
             | with | frame ms | CPU ms | adds ms | adds, of the ideal |\n|---|---|---|---|---|\n",
            self.visible, self.drawn, self.proxies, self.rounds
        );
        let added_ms = |times: &AblationTimes, before: &AblationTimes| {
            let pairs = times.frame_ms.iter().zip(&before.frame_ms);
            median(&pairs.map(|(with, without)| with - without).collect::<Vec<f64>>())
        };
        let mut before = &self.times[0];
        for (ablation, times) in Ablation::ALL.iter().zip(&self.times) {
            let cpu = median(&times.cpu_ms);
            let frame = median(&times.frame_ms);
            let added = added_ms(times, before);
            lines += &format!(
                "| {} | {frame:.2} | {cpu:.2} | {added:.2} | {:.3} |\n",
                ablation.part(),
                added / ideal
            );
            before = times;
        }
        let over = added_ms(before, &self.times[0]);
        lines + &format!("| over the ideal | | | {over:.2} | {:.3} |\n", over / ideal)
    }
}
