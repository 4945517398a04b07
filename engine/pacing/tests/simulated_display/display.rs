//! A presentation engine without events: the present time of a frame is computed from the frame and
//! the end of its GPU work. All times are true times, in nanoseconds.

use std::collections::VecDeque;
use std::ops::Range;

use antumbra_pacing::PresentationMode;

/// The refreshes of a display: at fixed times, whenever a frame is ready, or none.
#[derive(Clone, Copy, Debug)]
pub enum Panel {
    Fixed {
        period: f64,
        phase: f64,
    },
    Variable {
        min_period: f64,
        max_period: f64,
    },
    /// A window system without a screen, which copies finished frames one after the other. A copy
    /// takes about this long.
    Unthrottled {
        copy: f64,
        waits_for: Work,
    },
}

/// The GPU work that an acquire waits for without a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// The work of the frame that frees the image.
    Replacing,
    /// All submitted work, including the frame's own.
    All,
}

#[derive(Clone, Copy, Debug)]
struct Presented {
    frame: usize,
    /// The present time; `None` if it was replaced before.
    shown: Option<f64>,
    /// The time at which its image can be acquired again.
    released: f64,
}

#[derive(Clone, Debug)]
pub struct Display {
    pub panel: Panel,
    pub mode: PresentationMode,
    pub images: usize,
    /// The time before a refresh by which an image must be finished.
    pub latch: f64,
    /// The span of time in which nothing is shown.
    pub hidden: Range<f64>,
    held: VecDeque<Presented>,
    last_shown: f64,
}

impl Display {
    pub fn new(panel: Panel, mode: PresentationMode, images: usize) -> Self {
        let held = VecDeque::new();
        Self { panel, mode, images, latch: 0.0, hidden: 0.0..0.0, held, last_shown: -1e9 }
    }

    /// Returns the time at which an image is available if it is requested at `now`; infinite if
    /// none becomes free without another present.
    pub fn image_free(&mut self, now: f64) -> f64 {
        self.held.retain(|held| held.released > now);
        let mut released: Vec<f64> = self.held.iter().map(|held| held.released).collect();
        released.sort_by(f64::total_cmp);
        let excess = (released.len() + 1).saturating_sub(self.images);
        if excess == 0 { now } else { released[excess - 1] }
    }

    /// Presents a frame whose GPU work ends at `finish`. Returns its present time, and the frame
    /// that will never be shown because of it.
    pub fn present(&mut self, frame: usize, finish: f64) -> (f64, Option<usize>) {
        let (shown, replaces) = match self.panel {
            Panel::Unthrottled { copy, .. } => (self.copied(frame, finish, copy), false),
            _ => self.shown(finish),
        };
        let mut replaced = None;
        if let Some(last) = self.held.back_mut() {
            if replaces {
                replaced = Some(last.frame);
                last.shown = None;
                last.released = finish;
            }
            // The frame on the screen stays there until this one is shown.
            let on_screen = self.held.iter_mut().rev().find(|held| held.shown.is_some());
            if let Some(on_screen) = on_screen {
                on_screen.released = shown;
            }
        }
        self.last_shown = shown;
        let released = f64::INFINITY;
        self.held.push_back(Presented { frame, shown: Some(shown), released });
        (shown, replaced)
    }

    /// Changes to a new swapchain. Returns the frames that will never be shown.
    pub fn recreate(&mut self, mode: PresentationMode, images: usize, now: f64) -> Vec<usize> {
        let unseen = self.held.iter().filter(|held| held.shown.is_some_and(|shown| shown > now));
        let lost = unseen.map(|held| held.frame).collect();
        let shown = self.held.iter().filter_map(|held| held.shown).filter(|shown| *shown <= now);
        self.last_shown = shown.fold(-1e9, f64::max);
        self.held.clear();
        self.mode = mode;
        self.images = images;
        lost
    }

    fn shown(&self, finish: f64) -> (f64, bool) {
        let ready = finish + self.latch;
        match (self.mode, self.panel) {
            (PresentationMode::Immediate, _) => (self.visible(ready.max(self.last_shown)), false),
            (_, Panel::Variable { .. } | Panel::Unthrottled { .. }) => {
                (self.variable(ready), false)
            }
            (PresentationMode::Fifo, Panel::Fixed { period, .. }) => {
                (self.refresh(ready.max(self.last_shown + 0.5 * period)), false)
            }
            (PresentationMode::FifoRelaxed, Panel::Fixed { period, .. }) => {
                let next = self.refresh(self.last_shown + 0.5 * period);
                let late = ready > next;
                (if late { self.visible(ready) } else { next }, false)
            }
            (PresentationMode::Mailbox, Panel::Fixed { .. }) => {
                let shown = self.refresh(ready);
                let pending = self.held.back().is_some_and(|held| held.shown == Some(shown));
                (shown, pending)
            }
        }
    }

    /// Returns the first visible refresh at or after a time.
    pub fn refresh(&self, time: f64) -> f64 {
        let Panel::Fixed { period, phase } = self.panel else { return self.visible(time) };
        let next = |time: f64| phase + ((time - phase) / period - 1e-9).ceil() * period;
        let at = next(time);
        if self.hidden.contains(&at) { next(self.hidden.end) } else { at }
    }

    /// Returns the end of a copy; the durations of copies vary.
    fn copied(&self, frame: usize, finish: f64, copy: f64) -> f64 {
        let unevenness = 0.8 + 0.4 * (frame as f64 * 0.618).fract();
        finish.max(self.last_shown) + copy * unevenness
    }

    fn visible(&self, time: f64) -> f64 {
        if self.hidden.contains(&time) { self.hidden.end } else { time }
    }

    /// Returns the time at which a panel with a variable rate shows a ready frame. The panel
    /// repeats its image if none arrives for too long, and is then busy for the shortest period.
    fn variable(&self, ready: f64) -> f64 {
        let Panel::Variable { min_period, max_period } = self.panel else { return ready };
        let waited = ready - self.last_shown;
        let repeats = (waited / max_period).floor().max(0.0);
        let last_scan = self.last_shown + repeats * max_period;
        self.visible(ready.max(last_scan + min_period))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 10.0;

    fn fixed(mode: PresentationMode, images: usize) -> Display {
        Display::new(Panel::Fixed { period: PERIOD, phase: 0.0 }, mode, images)
    }

    #[test]
    fn fifo_shows_one_a_refresh_in_order_and_blocks_when_full() {
        let mut display = fixed(PresentationMode::Fifo, 3);
        let shown: Vec<f64> = (0..3).map(|n| display.present(n, 1.0 + n as f64).0).collect();
        assert_eq!(shown, [10.0, 20.0, 30.0]);
        // All three images are held: the first becomes free when the second replaces it.
        assert_eq!(display.image_free(4.0), 20.0);
        assert_eq!(display.image_free(20.0), 20.0);
        // A late frame waits for the next refresh.
        assert_eq!(display.present(3, 40.5).0, 50.0);
        display.latch = 2.0;
        assert_eq!(display.present(4, 59.0).0, 70.0);
        assert_eq!(display.present(5, 78.0).0, 80.0);
    }

    #[test]
    fn two_images_wait_for_each_refresh() {
        let mut display = fixed(PresentationMode::Fifo, 2);
        display.present(0, 1.0);
        assert_eq!(display.image_free(2.0), 2.0);
        display.present(1, 3.0);
        assert_eq!(display.image_free(4.0), 20.0);
    }

    #[test]
    fn mailbox_shows_the_newest_and_replaces_the_others() {
        let mut display = fixed(PresentationMode::Mailbox, 3);
        assert_eq!(display.present(0, 1.0), (10.0, None));
        assert_eq!(display.present(1, 4.0), (10.0, Some(0)));
        assert_eq!(display.present(2, 12.0), (20.0, None));
        assert_eq!(display.image_free(12.0), 12.0);
    }

    #[test]
    fn relaxed_tears_only_when_late() {
        let mut display = fixed(PresentationMode::FifoRelaxed, 3);
        assert_eq!(display.present(0, 1.0).0, 1.0);
        assert_eq!(display.present(1, 4.0).0, 10.0);
        assert_eq!(display.present(2, 23.0).0, 23.0);
    }

    #[test]
    fn variable_panels_wait_within_their_range() {
        let panel = Panel::Variable { min_period: 7.0, max_period: 20.0 };
        let mut display = Display::new(panel, PresentationMode::Fifo, 3);
        display.last_shown = 0.0;
        assert_eq!(display.present(0, 3.0).0, 7.0);
        assert_eq!(display.present(1, 17.0).0, 17.0);
        // Nothing arrived until 37, so the image was repeated, and the panel was busy until 44.
        assert_eq!(display.present(2, 38.0).0, 44.0);
    }

    #[test]
    fn a_hidden_window_shows_nothing_until_it_is_seen_again() {
        let mut display = fixed(PresentationMode::Fifo, 3);
        display.hidden = 15.0..995.0;
        assert_eq!(display.present(0, 1.0).0, 10.0);
        assert_eq!(display.present(1, 11.0).0, 1000.0);
        assert_eq!(display.present(2, 12.0).0, 1010.0);
        assert_eq!(display.image_free(13.0), 1000.0);
        assert_eq!(display.recreate(PresentationMode::Immediate, 3, 20.0), [1, 2]);
        assert_eq!(display.present(3, 1_001.0).0, 1_001.0);
    }
}
