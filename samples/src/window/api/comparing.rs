//! A session during a comparison: two frames per moment, one of which is shown.

use antumbra::cull::Camera;
use antumbra::gpu::{Readback, Tick};
use antumbra::render::FrameRequest;

use crate::window::comparison::{Comparison, Side};
use crate::window::page_text::in_ms;
use crate::window::session::Session;
use bench::run_error::RunError;
use bench::strategy::Strategy;

impl Session {
    /// Begins to alternate frames with and without culling, or ends that.
    pub(crate) fn toggle_comparison(&mut self) -> Result<(), RunError> {
        if let Some(comparison) = self.comparison.take() {
            self.tell(format!("{}: {}", self.strategy, comparison.tally().text()));
            return Ok(());
        }
        if self.frozen.is_some() {
            self.refuse("the culling is frozen: let it go on to compare".to_owned());
            return Ok(());
        }
        if self.strategy == Strategy::FRUSTUM {
            self.refuse("frustum is the reference of the comparison: choose another".to_owned());
            return Ok(());
        }
        self.comparison = Some(Comparison::new(&self.renderer, self.strategy)?);
        Ok(())
    }

    /// Returns the text about the running comparison.
    pub(crate) fn comparison_text(&self) -> Option<String> {
        let comparison = self.comparison.as_ref()?;
        let shown = match comparison.shown() {
            Side::Culled => format!("with culling ({})", self.strategy),
            Side::Unculled => "without culling".to_owned(),
        };
        let with = self.times.gpu_ms()[0];
        let without = self.times.unculled_gpu_ms();
        let times = with.zip(without).map_or(String::new(), |(with, without)| {
            format!("\nGPU: {} with culling, {} without", in_ms(Some(with)), in_ms(Some(without)))
        });
        Some(format!("{shown}: {}{times}", comparison.tally().text()))
    }

    /// Draws a frame with the current strategy, and during a comparison also one without culling.
    /// The shown frame is drawn last and copied to `image`.
    pub(crate) fn render(
        &mut self,
        camera: Camera,
        seconds: f32,
        image: Option<&Readback>,
    ) -> Result<Tick, RunError> {
        let Some(mut comparison) = self.comparison.take() else {
            let overlay = self.overlay.shown();
            let request = FrameRequest::new(self.strategy, camera);
            let request = FrameRequest { image, overlay, ..request };
            self.report = self.renderer.render(&mut self.history, request)?;
            self.outcome = self.history.drain_stats().next_back().or(self.outcome);
            self.times.sent(Side::Culled, self.renderer.pass_times());
            return Ok(self.report.tick);
        };
        let rendered = self.render_pair(&mut comparison, camera, seconds, image);
        self.comparison = Some(comparison);
        rendered
    }

    fn render_pair(
        &mut self,
        comparison: &mut Comparison,
        camera: Camera,
        seconds: f32,
        image: Option<&Readback>,
    ) -> Result<Tick, RunError> {
        comparison.follow(self.strategy);
        let now = self.clock.now();
        let is_news = comparison.collect(self.renderer.device(), now)?;
        self.is_page_stale |= comparison.advance(seconds) | is_news;
        let pair = comparison.free_pair(&self.renderer)?;
        let shown = comparison.shown();
        let hidden = if shown == Side::Culled { Side::Unculled } else { Side::Culled };
        let mut tick = Tick::default();
        for side in [hidden, shown] {
            // The history with culling needs every frame; frames without culling that are neither
            // shown nor compared are skipped.
            if (side, shown, pair) == (Side::Unculled, Side::Culled, None) {
                continue;
            }
            let (unculled, scene_image) = comparison.split(pair.unwrap_or(usize::MAX), side);
            let image = image.filter(|_| side == shown);
            let overlay = self.overlay.shown();
            tick = match side {
                Side::Culled => {
                    let request = FrameRequest::new(self.strategy, camera);
                    let request = FrameRequest { image, scene_image, overlay, ..request };
                    self.report = self.renderer.render(&mut self.history, request)?;
                    self.outcome = self.history.drain_stats().next_back().or(self.outcome);
                    self.report.tick
                }
                Side::Unculled => {
                    let request = FrameRequest::new(Strategy::FRUSTUM, camera);
                    let request = FrameRequest { image, scene_image, overlay, ..request };
                    self.renderer.render(unculled, request)?.tick
                }
            };
            self.times.sent(side, self.renderer.pass_times());
        }
        if let Some(pair) = pair {
            comparison.sent(pair, tick);
        }
        Ok(tick)
    }

    /// Compares the pending images, and logs the result of the whole comparison.
    pub(crate) fn finish_comparison(&mut self) -> Result<(), RunError> {
        let Some(mut comparison) = self.comparison.take() else { return Ok(()) };
        self.renderer.device().wait_idle()?;
        comparison.collect(self.renderer.device(), self.clock.now())?;
        tracing::info!("{}: {}", self.strategy, comparison.tally().text());
        Ok(())
    }
}
