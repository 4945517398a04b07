//! Continuation on another device, after the loss of the present one.

use antumbra::gpu::{Adapter, Device};
use antumbra::pacing::Time;
use bench::run;
use bench::run_error::{Blame, RunError};
use bench::strategy::Strategy;

use super::super::opened::{Next, Opened};
use super::super::screen::{Screen, ScreenOptions};
use super::super::session::Session;
use super::super::show::ShowOptions;

impl Session {
    /// Logs that the device is lost, and what is known about it.
    pub fn tell_loss(&self, error: &RunError) {
        let report = self.renderer.loss_report();
        tracing::warn!("{error}; {report}; the scene is drawn on another device");
    }

    /// Continues on another device. The scene, its state and the history of the user stay; images
    /// that the lost device was drawing are given up. Visible sets must be searched again.
    ///
    /// # Errors
    /// A device that does not take the scene, or fails. The session is as before then.
    pub fn recover(&mut self, device: &Device) -> Result<(), RunError> {
        let overlay = self.overlay.on(device)?;
        let clocks = device.clocks()?;
        self.renderer.recover(device)?;
        if let Err(error) = self.renderer.supports(self.strategy) {
            self.refuse(error.to_string());
            self.strategy = Strategy::ANTUMBRA;
        }
        self.viewed.clear();
        if let Some(trace) = &mut self.trace {
            trace.follow_device(device, clocks.as_ref());
        }
        self.overlay = overlay;
        self.screenshots.give_up();
        if let Some(comparison) = &mut self.comparison {
            comparison.forget_images();
        }
        self.is_page_stale = true;
        Ok(())
    }
}

impl Opened {
    /// Opens another device for the window after a loss, and continues on it.
    pub(crate) fn recover(&mut self, options: &ShowOptions) -> Result<(), RunError> {
        let wanted = run::wanted(&options.device);
        let adapter = self.instance.pick_adapter_for(&self.surface, wanted.as_deref())?;
        self.go_on(&adapter, options)?;
        self.session.tell(format!("the device was lost; now on {}", adapter.name));
        Ok(())
    }

    /// Continues on the next device that can present to the window, or on the same one opened
    /// again. A device that does not take the scene is refused with a message.
    pub(crate) fn change_device(&mut self, options: &ShowOptions) -> Result<(), RunError> {
        let adapters = self.instance.adapters()?;
        let present = self.session.renderer().device().adapter();
        let at = adapters.iter().position(|adapter| adapter.is_same_as(present));
        let at = at.unwrap_or_default();
        let in_turn = (1..=adapters.len()).map(|step| (at + step) % adapters.len());
        let fits = |index: usize| {
            self.instance.pick_adapter_for(&self.surface, Some(&index.to_string())).ok()
        };
        let Some(adapter) = in_turn.filter_map(fits).next() else { return Ok(()) };
        match self.go_on(&adapter, options) {
            Ok(()) => self.session.tell(format!("now on {}", adapter.name)),
            Err(error) if error.blame == Blame::LostDevice => return Err(error),
            Err(error) => self.session.refuse(format!("not on {}: {error}", adapter.name)),
        }
        Ok(())
    }

    fn go_on(&mut self, adapter: &Adapter, options: &ShowOptions) -> Result<(), RunError> {
        let device = run::open_device(&self.instance, adapter)?;
        // As the user has set it since the window opened.
        let shown = ScreenOptions {
            present_mode: self.screen.wanted_mode(),
            frames_in_flight: self.session.frames_in_flight() as u32,
            ..options.screen()
        };
        let screen = Screen::new(&device, &self.surface, shown, self.refresh)?;
        self.session.recover(&device)?;
        // The window's images follow with the next frame, once the former device is closed.
        self.screen = screen;
        self.fallback = None;
        self.recovery.continued();
        self.next_layout = Time::ZERO;
        self.session.search_again()?;
        let size = self.session.renderer().size();
        self.arrivals.restart(&device, options, size)
    }

    /// Decides when to try to continue after an error, or returns it.
    pub(crate) fn plan_recovery(&mut self, error: RunError) -> Result<Next, RunError> {
        let now = self.clock_now();
        let Some(at) = self.recovery.after(&error, now) else { return Err(error) };
        self.session.tell_loss(&error);
        Ok(Next::At(at))
    }
}
