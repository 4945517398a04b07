//! The page of the HUD of a session.

use super::deeds::{CAMERA_KEYS, FILE_KEYS, KEYS, STEERING};
use super::page_text::Known;
use super::screen::ScreenFacts;
use super::session::Session;
use crate::hud::HudPage;

impl Session {
    /// Lays the HUD out anew, or without one only what cannot be or went wrong; `scale` pixels are a
    /// point. Where there is nothing to write, nothing is kept for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn lay_out(
        &mut self,
        screen: Option<&ScreenFacts>,
        scale: f32,
    ) -> Result<(), crate::run::RunError> {
        let page = if self.has_hud {
            self.page(screen)
        } else {
            // Without a screen nobody watches, and pictures stay what they are; the log has it.
            let notice = screen.and_then(|_| self.notice.refused_at(self.clock.now()));
            HudPage { notice, progress: self.progress(), ..HudPage::default() }
        };
        if page == HudPage::default() {
            if self.hud.take().is_some() {
                self.renderer.drop_flat_overlay();
            }
            return Ok(());
        }
        let mut hud = self.hud.take().unwrap_or_default();
        let size = self.renderer.size();
        let laid_out = hud.lay_out(&page, size, scale, self.renderer.flat_overlay()?);
        self.hud = Some(hud);
        Ok(laid_out?)
    }

    fn page(&self, screen: Option<&ScreenFacts>) -> HudPage {
        let device = self.renderer.device();
        let known = Known {
            frame: self.frame,
            report: &self.report,
            outcome: self.outcome.as_ref(),
            passes: self.renderer.pass_times(),
            lists_passes: self.is_timing_passes,
            used_bytes: device.memory_bytes().1,
            device: &device.adapter().name,
            size: self.renderer.size(),
            strategy: self.strategy.name(),
            is_frozen: self.frozen.is_some(),
            is_recording: self.recording.is_some(),
            predicates: self.renderer.predication().name(),
            frames_in_flight: self.renderer.frames_in_flight(),
            screen,
        };
        let own = |(key, deed): (&str, &str)| (key.to_owned(), deed.to_owned());
        let of_files = self.world.is_alive().then_some(FILE_KEYS).into_iter().flatten();
        let keys = KEYS.into_iter().chain(of_files).map(|(key, deed, _)| (key, deed));
        let keys = keys.chain(self.world.is_alive().then_some(CAMERA_KEYS)).chain(STEERING);
        let mut facts = known.facts();
        if let Some(of_world) = self.world.facts() {
            facts.insert(1, of_world);
        }
        HudPage {
            frames_ms: self.times.newest_ms().collect(),
            budget_ms: screen.and_then(|screen| screen.refresh).map(|d| d.as_secs_f32() * 1e3),
            facts,
            keys: keys.map(own).collect(),
            notice: self.notice.at(self.clock.now()),
            progress: self.progress(),
        }
    }

    /// What is told of a scene that is on its way.
    fn progress(&self) -> Option<(String, Option<f32>)> {
        self.awaited.as_ref().map(|awaited| (awaited.what.clone(), awaited.fraction))
    }
}
