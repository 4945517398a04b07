//! The presentation of images and its timing: a swapchain, and the pacer that decides when frames
//! start.

use std::collections::VecDeque;
use std::time::Duration;

use antumbra::gpu::{
    Device, OptionalFeature, PresentId, PresentMode, PresentResult, Surface, Swapchain,
    SwapchainOptions, Tick,
};
use antumbra::pacing;
use antumbra::pacing::{
    Feedback, PacedFrameId, Pacer, PacerOptions, PresentReports, Presentation, REFRESH_PERIOD,
    Refresh, Step, Summary, Time, Wait, WaitReason,
};
use antumbra::render::Renderer;

use super::clock::Clock;
use super::conditions::Conditions;
use super::frame_pacing_stats::FramePacingStats;
use bench::run_error::RunError;

/// The most frames whose completion is tracked.
const MOST_QUEUED: usize = 64;
/// The assumed number of images before a swapchain is created.
const USUAL_IMAGES: u32 = 3;
/// The longest time that the loop blocks for a present time, since keys have to wait.
const LONGEST_LOOK: Duration = Duration::from_millis(20);

/// The options of showing images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenOptions {
    /// The present mode at the start.
    pub present_mode: PresentMode,
    /// The number of frames in flight at the start.
    pub frames_in_flight: u32,
    /// The most frames per second.
    pub frame_limit_hz: Option<f64>,
}

/// The facts about a window's swapchain.
#[derive(Clone, Copy, Debug)]
pub struct ScreenFacts {
    /// The present mode in use.
    pub mode: PresentMode,
    /// The requested mode, if the window does not support it.
    pub fallback: Option<PresentMode>,
    /// The number of images of the window.
    pub images: u32,
    /// The refresh period, once it is known.
    pub refresh: Option<Duration>,
    /// The frame pacing.
    pub summary: Summary,
}

/// A frame that was presented.
#[derive(Clone, Copy, Debug)]
struct Queued {
    frame: PacedFrameId,
    id: PresentId,
    tick: Tick,
    is_finished: bool,
    is_shown: bool,
}

/// A window's images and their times.
pub struct Screen {
    swapchain: Swapchain,
    device: Device,
    clock: Clock,
    pacer: Pacer,
    evenness: FramePacingStats,
    queued: VecDeque<Queued>,
    reports: PresentReports,
    refresh: Refresh,
    /// The swapchain as known to the pacer: its mode, its images, the number of replacements.
    known: (PresentMode, usize, u64),
    /// The present mode that was requested last: the swapchain changes to it with its next image.
    wanted: PresentMode,
}

impl Screen {
    /// Prepares to show images of `device` in the window of `surface`. `refresh` is the approximate
    /// period of its monitor, if it is known.
    ///
    /// # Errors
    /// A device that does not support it; a failed call.
    pub fn new(
        device: &Device,
        surface: &Surface,
        options: ScreenOptions,
        refresh: Option<Duration>,
    ) -> Result<Self, RunError> {
        let swapchain = Swapchain::new(
            device,
            surface,
            &SwapchainOptions {
                mode: options.present_mode,
                frames_in_flight: options.frames_in_flight as usize,
                ..SwapchainOptions::default()
            },
        )?;
        let has = |optional| device.capabilities().has(optional);
        let reports = if has(OptionalFeature::PresentWait) || has(OptionalFeature::DisplayTiming) {
            PresentReports::Times
        } else {
            PresentReports::Missing
        };
        let [shortest, longest] = REFRESH_PERIOD;
        let sane = refresh.filter(|refresh| (shortest..=longest).contains(refresh));
        let refresh = sane.map_or(Refresh::Unknown, Refresh::About);
        let presentation = Presentation {
            mode: pacers(options.present_mode),
            images: USUAL_IMAGES,
            refresh,
            reports,
        };
        let pacer_options = PacerOptions {
            queue_limit: options.frames_in_flight,
            frame_limit_hz: options.frame_limit_hz,
            ..PacerOptions::default()
        };
        Ok(Self {
            known: (options.present_mode, USUAL_IMAGES as usize, 0),
            swapchain,
            device: device.clone(),
            clock: Clock,
            pacer: Pacer::new(pacer_options, presentation).map_err(RunError::machine)?,
            evenness: FramePacingStats::new().map_err(RunError::machine)?,
            queued: VecDeque::with_capacity(MOST_QUEUED),
            wanted: options.present_mode,
            reports,
            refresh,
        })
    }

    /// Returns the next step: delivers new times to the pacer, then calls it.
    ///
    /// # Errors
    /// A lost device.
    pub fn next_step(&mut self) -> Result<Step, RunError> {
        self.follow_swapchain()?;
        self.look()?;
        while let Some((frame, timing)) = self.pacer.completed() {
            self.evenness.record(frame, timing);
        }
        let step = self.pacer.next(self.clock.now());
        if let Step::Wait(wait) = step {
            self.await_showing(&wait)?;
        }
        Ok(step)
    }

    /// Presents the newest image of `renderer` as the pacer's `frame`.
    ///
    /// # Errors
    /// Errors that are not in [`antumbra::gpu::PresentSkipped`].
    pub fn show(
        &mut self,
        renderer: &Renderer,
        frame: PacedFrameId,
        size: [u32; 2],
    ) -> Result<PresentResult, RunError> {
        // Frames that are finished at this time cannot be why acquiring an image takes long.
        self.look()?;
        let from = self.clock.now();
        let shown = renderer.present(&mut self.swapchain, size);
        let at = self.clock.now();
        let presented = match shown? {
            PresentResult::Presented(presented) => presented,
            PresentResult::Not(reason) => {
                self.pacer.feedback(frame, Feedback::Dropped);
                return Ok(PresentResult::Not(reason));
            }
        };
        self.follow_swapchain()?;
        let from = from.after(presented.slot_wait);
        let to = from.after(presented.acquire_wait);
        self.pacer.feedback(frame, Feedback::Acquired { from, to });
        self.pacer.feedback(frame, Feedback::Queued { at });
        if self.queued.len() == MOST_QUEUED {
            self.queued.pop_front();
        }
        let id = presented.id;
        let tick = presented.tick;
        self.queued.push_back(Queued { frame, id, tick, is_finished: false, is_shown: false });
        Ok(PresentResult::Presented(presented))
    }

    /// Notes that a started frame will not be shown.
    pub fn drop_frame(&mut self, frame: PacedFrameId) {
        self.pacer.feedback(frame, Feedback::Dropped);
    }

    /// Returns true if a frame may begin: not while a hidden window holds the previous frame back.
    ///
    /// # Errors
    /// A failed call.
    pub fn is_ready(&mut self) -> Result<bool, RunError> {
        Ok(self.swapchain.is_ready()?)
    }

    /// Changes the present mode.
    pub fn set_mode(&mut self, mode: PresentMode) {
        self.wanted = mode;
        self.swapchain.set_mode(mode);
    }

    /// Returns the mode that was requested last.
    pub fn wanted_mode(&self) -> PresentMode {
        self.wanted
    }

    /// Changes the number of frames in flight.
    ///
    /// # Errors
    /// A failed call.
    pub fn set_frames_in_flight(&mut self, count: usize) -> Result<(), RunError> {
        self.swapchain.set_frames_in_flight(count)?;
        let queue_limit = u32::try_from(count).unwrap_or(1);
        let options = PacerOptions { queue_limit, ..*self.pacer.options() };
        self.pacer.choose(options).map_err(RunError::machine)
    }

    /// Returns the facts to show.
    pub fn facts(&mut self) -> ScreenFacts {
        ScreenFacts {
            mode: self.swapchain.mode(),
            fallback: self.swapchain.fallback().map(|fallback| fallback.wanted),
            images: self.swapchain.image_count() as u32,
            refresh: self.pacer.refresh_period(),
            summary: self.evenness.summary(),
        }
    }

    /// Notes the conditions of the frame `next`: a change resets the statistics.
    pub fn follow(&mut self, conditions: Conditions, next: PacedFrameId) {
        self.evenness.follow(conditions, next);
    }

    /// Returns the swapchain.
    pub fn swapchain(&self) -> &Swapchain {
        &self.swapchain
    }

    /// Informs the pacer of another swapchain.
    fn follow_swapchain(&mut self) -> Result<(), RunError> {
        let swapchain = &self.swapchain;
        if swapchain.image_count() == 0 {
            return Ok(());
        }
        let now = (swapchain.mode(), swapchain.image_count(), swapchain.replaced());
        if std::mem::replace(&mut self.known, now) == now {
            return Ok(());
        }
        if let Some(period) = swapchain.refresh_duration()?
            && (REFRESH_PERIOD[0]..=REFRESH_PERIOD[1]).contains(&period)
        {
            self.refresh = Refresh::About(period);
        }
        self.queued.clear();
        let presentation = Presentation {
            mode: pacers(now.0),
            images: u32::try_from(now.1).unwrap_or(u32::MAX).min(pacing::MAX_IMAGES),
            refresh: self.refresh,
            reports: self.reports,
        };
        self.pacer.present_through(presentation).map_err(RunError::machine)
    }

    /// Checks the results of the queued frames. Never waits.
    fn look(&mut self) -> Result<(), RunError> {
        let completed = self.device.completed()?;
        let at = self.clock.now();
        let queued = &mut self.queued;
        let pacer = &mut self.pacer;
        for queued in queued.iter_mut().filter(|queued| !queued.is_finished) {
            if queued.tick <= completed {
                queued.is_finished = true;
                pacer.feedback(queued.frame, Feedback::FoundFinished { at });
            }
        }
        // If there are two reports, the display's own times are better.
        self.swapchain.timings(|timing| {
            if let Some(queued) = queued.iter_mut().find(|queued| queued.id == timing.id) {
                let at = Time::from_nanos(timing.shown_ns);
                queued.is_shown = true;
                pacer.feedback(queued.frame, Feedback::Shown { at });
            }
        })?;
        if self.device.capabilities().has(OptionalFeature::PresentWait)
            && !self.device.capabilities().has(OptionalFeature::DisplayTiming)
            && let Some(newest) = self.swapchain.newest_shown()?
        {
            let at = self.clock.now();
            for queued in queued.iter_mut().filter(|queued| !queued.is_shown) {
                if queued.id <= newest {
                    queued.is_shown = true;
                    pacer.feedback(queued.frame, Feedback::Shown { at });
                }
            }
        }
        let is_over = |queued: &Queued| {
            queued.is_finished && (queued.is_shown || self.reports == PresentReports::Missing)
        };
        while queued.front().is_some_and(is_over) {
            queued.pop_front();
        }
        Ok(())
    }

    /// Sleeps in the driver instead of the loop, if the driver reports present times.
    fn await_showing(&mut self, wait: &Wait) -> Result<(), RunError> {
        if !matches!(wait.reason, WaitReason::Deadline | WaitReason::QueueFull(_)) {
            return Ok(());
        }
        let Some(oldest) = self.queued.iter_mut().find(|queued| !queued.is_shown) else {
            return Ok(());
        };
        let bound = wait.until.since(self.clock.now()).min(LONGEST_LOOK);
        if self.swapchain.wait_until_shown(oldest.id, bound)? {
            oldest.is_shown = true;
            let at = self.clock.now();
            self.pacer.feedback(oldest.frame, Feedback::Shown { at });
        }
        Ok(())
    }
}

/// Returns the pacer's equivalent of the mode.
fn pacers(mode: PresentMode) -> pacing::PresentationMode {
    match mode {
        PresentMode::Fifo => pacing::PresentationMode::Fifo,
        PresentMode::FifoRelaxed => pacing::PresentationMode::FifoRelaxed,
        PresentMode::Mailbox => pacing::PresentationMode::Mailbox,
        PresentMode::Immediate => pacing::PresentationMode::Immediate,
    }
}
