//! The HUD page of a session.

use std::time::Duration;

use antumbra::cull::{Camera, FrameId};
use antumbra::gpu;
use antumbra::pacing::Time;

use crate::hud::{Help, HudAnswer, HudLevel, HudPage, Legend, Sign};
use crate::window::actions::{CAMERA_KEYS, FILE_KEYS, GROUPS, KEYS, STEERING};
use crate::window::comparison::Comparison;
use crate::window::conditions::Conditions;
use crate::window::exactness_claim::ClaimBasis;
use crate::window::legends;
use crate::window::page_text::Known;
use crate::window::screen::ScreenFacts;
use crate::window::session::Session;
use bench::run_error::RunError;
use bench::transparency::TransparencyReport;

/// The interval, in frames, at which passes are timed while the HUD is visible.
const TIMED_INTERVAL_FRAMES: u64 = 8;
/// The time for which the sign of a screenshot is visible.
const FLASH: Duration = Duration::from_millis(800);
/// The most frames that are remembered until their results are read back.
const MOST_VIEWED: usize = 64;

impl Session {
    /// Lays out the HUD; without it, only errors and signs. A point has `scale` pixels.
    ///
    /// # Errors
    /// When the device fails.
    pub fn lay_out(&mut self, screen: Option<&ScreenFacts>, scale: f32) -> Result<(), RunError> {
        let began = self.clock.now();
        self.time_passes()?;
        self.times.follow(self.conditions());
        let page = self.page(screen);
        self.log_selection();
        if let Some(frame) = self.hud.lay_out(&page, self.renderer.size(), scale) {
            self.clicked_row = frame.clicked();
            self.overlay.show(frame)?;
        }
        if self.overlay.shown().is_some() {
            self.times.laid_out(self.clock.now().since(began).as_secs_f32() * 1e3);
        }
        Ok(())
    }

    /// Times passes: of all frames on request, of some frames for the HUD.
    fn time_passes(&mut self) -> Result<(), RunError> {
        let has_timestamps =
            self.renderer.device().capabilities().has(gpu::OptionalFeature::Timestamps);
        let wanted = match (self.is_timing_passes, self.hud_level) {
            (true, _) => Some(1),
            (false, HudLevel::Off) => None,
            (false, _) => has_timestamps.then_some(TIMED_INTERVAL_FRAMES),
        };
        if wanted != self.renderer.timed_interval() {
            match wanted {
                Some(frames) => self.renderer.time_passes_of_one_in(frames)?,
                None => self.renderer.stop_timing_passes(),
            }
        }
        Ok(())
    }

    /// Returns the conditions of the next frame.
    pub fn conditions(&self) -> Conditions {
        Conditions {
            strategy: self.strategy,
            size: self.renderer.size(),
            frames_in_flight: self.renderer.frames_in_flight(),
            present_mode: self.present_mode,
            scene: self.scene,
            is_comparing: self.comparison.is_some(),
        }
    }

    /// Records the costs of the newest frame, and keeps its camera until its results are read back.
    pub(crate) fn measure(&mut self, camera: Camera) {
        self.times.take(&self.report);
        if self.viewed.len() == MOST_VIEWED {
            self.viewed.pop_front();
        }
        self.viewed.push_back((self.history.plan().frame, camera));
    }

    /// Counts the objects in the frustum of a frame.
    fn in_frustum(&self, frame: FrameId) -> Option<u64> {
        let (_, camera) = self.viewed.iter().find(|(viewed, _)| *viewed == frame)?;
        let view = self.renderer.view_of(camera);
        Some(self.renderer.hierarchy().objects_in_frustum(&view).into())
    }

    fn page(&self, screen: Option<&ScreenFacts>) -> HudPage {
        let now = self.clock.now();
        let signs = match (screen, self.hud_level) {
            // Without a window there are no signs, so images are unchanged.
            (None, HudLevel::Off) => Vec::new(),
            _ => self.signs(now),
        };
        let progress =
            self.awaited.as_ref().map(|awaited| (awaited.what.clone(), awaited.fraction));
        let help = self.has_help.then(|| self.help());
        let marks = self.comparison.as_ref().map(|comparison| comparison.marks(now).to_vec());
        let marks = marks.unwrap_or_default();
        if self.hud_level == HudLevel::Off {
            return HudPage {
                asked: screen.and_then(|_| self.asked_for()),
                toast: screen.and_then(|_| self.toast.refused_at(now)),
                progress,
                signs,
                help,
                marks,
                ..HudPage::default()
            };
        }
        let device = self.renderer.device();
        let transparency = TransparencyReport::of(&self.renderer);
        let known = Known {
            frame: self.frame,
            scene: &self.scene_view.name,
            report: &self.report,
            outcome: self.outcome.as_ref(),
            objects: self.renderer.hierarchy().object_count().into(),
            in_frustum: self.outcome.and_then(|outcome| self.in_frustum(outcome.frame)),
            times: &self.times,
            lists_passes: self.is_timing_passes,
            used_bytes: device.memory_use().used_bytes,
            device: &device.adapter().name,
            size: self.renderer.size(),
            strategy: self.strategy,
            is_frozen: self.frozen.is_some(),
            is_recording: self.recording.is_some(),
            predicates: self.renderer.predication().name(),
            tester: self.renderer.cheapest_tester().name(),
            frames_in_flight: self.renderer.frames_in_flight(),
            is_comparing: self.comparison.is_some(),
            claim: &self.claim_basis().claim(),
            screen,
            transparency: transparency.as_ref(),
        };
        let (hint, details) = match self.hud_level {
            HudLevel::Detailed => ("F1 help, H no text", known.details()),
            _ => ("F1 help, H details", Vec::new()),
        };
        // While a list is open, messages about earlier actions are hidden.
        let toast = match self.menu {
            Some(_) => self.toast.refused_at(now),
            None => self.toast.at(now),
        };
        let of_scene = self.scene_view.facts().filter(|_| self.hud_level == HudLevel::Detailed);
        let light = self.light_facts().filter(|_| self.hud_level == HudLevel::Detailed);
        HudPage {
            overview: Some(known.overview(hint)),
            details: of_scene.into_iter().chain(light).chain(details).collect(),
            legends: self.legends(),
            marks,
            signs,
            help,
            asked: self.asked_for(),
            toast,
            progress,
        }
    }

    /// Returns the facts about the newest frame on which the claim about its image rests.
    fn claim_basis(&self) -> ClaimBasis {
        ClaimBasis {
            frames: self.frame,
            objects: self.renderer.hierarchy().object_count().into(),
            is_loading: self.awaited.is_some(),
            is_uploading: self.renderer.is_uploading(),
            is_frozen: self.frozen.is_some(),
            strategy: self.strategy,
            threshold_samples: self.renderer.threshold_samples(),
            samples_below_threshold: self.outcome.map(|outcome| outcome.samples_below_threshold),
            compared: self.comparison.as_ref().map(Comparison::tally),
        }
    }

    /// Returns the answer to a request: the open list or field, or else the results of a comparison
    /// and the card of the selected object.
    fn asked_for(&self) -> Option<HudAnswer> {
        if let Some(menu) = &self.menu {
            return Some(menu.asked());
        }
        let card = self.card().into_iter().map(|(name, value)| format!("{name}: {value}"));
        let lines: Vec<String> = self.comparison_text().into_iter().chain(card).collect();
        (!lines.is_empty()).then(|| HudAnswer::Rows(lines.join("\n")))
    }

    /// Returns the legends for the visible colours.
    fn legends(&self) -> Vec<Legend> {
        let selected = (!self.card().is_empty()).then(legends::of_selection);
        let explained = legends::of(self.renderer.debug_overlay(), self.frozen.is_some());
        selected.into_iter().chain(explained).collect()
    }

    /// Returns the signs that must be understood without reading.
    fn signs(&self, now: Time) -> Vec<Sign> {
        let is_new = |taken: Time| now.since(taken) < FLASH;
        // A screenshot does not show its own sign.
        let photographed = self.photographed.filter(|_| !self.wants_screenshot);
        let signs = [
            (self.frozen.is_some(), Sign::Frozen),
            (self.recording.is_some(), Sign::Recording),
            (photographed.is_some_and(is_new), Sign::Screenshot),
        ];
        signs.into_iter().filter_map(|(is_on, sign)| is_on.then_some(sign)).collect()
    }

    /// Returns the page of all keys.
    fn help(&self) -> Help {
        let own = |(key, action): (&str, &str)| (key.to_owned(), action.to_owned());
        let mut groups = vec![("Camera", STEERING.map(own).to_vec())];
        let mut keys = KEYS.into_iter().map(|(key, action, _)| own((key, action)));
        groups.extend(GROUPS.map(|(title, count)| (title, keys.by_ref().take(count).collect())));
        if self.scene_view.is_alive() {
            let of_file = FILE_KEYS.into_iter().map(|(key, action, _)| (key, action));
            let of_file = of_file.chain([CAMERA_KEYS]).map(own).collect();
            groups.push(("Scene out of a file", of_file));
        }
        Help { groups }
    }
}
