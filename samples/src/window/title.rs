//! The window's title: scene, strategy and frames per second.

use std::time::Duration;

use antumbra::pacing::Time;

/// The interval of changes to the title.
const INTERVAL: Duration = Duration::from_millis(500);

/// The words of a title.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TitleWords<'a> {
    /// The name of the scene.
    pub scene: &'a str,
    /// The name of the strategy.
    pub strategy: &'a str,
    /// The unit of the frame rate.
    pub unit: &'a str,
}

/// A counter of the frames between two changes of the title.
#[derive(Clone, Debug, Default)]
pub struct Title {
    /// Scene, strategy and unit of the counted frames.
    subject: [String; 3],
    since: Option<Time>,
    frames: u32,
}

impl Title {
    /// Counts a frame that began at `now`; returns the new title if it is due.
    pub fn count(&mut self, now: Time, words: &TitleWords<'_>) -> Option<String> {
        let TitleWords { scene, strategy, unit } = *words;
        if self.subject != [scene, strategy, unit] {
            // Frames of another scene or strategy do not count.
            let subject = [scene, strategy, unit].map(str::to_owned);
            *self = Self { subject, ..Self::default() };
        }
        let since = *self.since.get_or_insert(now);
        let passed = now.since(since);
        if passed < INTERVAL {
            self.frames += 1;
            return (since == now && self.frames == 1)
                .then(|| text(scene, strategy, String::new()));
        }
        let rate_hz = f64::from(self.frames) / passed.as_secs_f64();
        (self.since, self.frames) = (Some(now), 1);
        let digits = usize::from(rate_hz < 10.0);
        Some(text(scene, strategy, format!(" - {rate_hz:.digits$} {unit}")))
    }
}

fn text(scene: &str, strategy: &str, rate: String) -> String {
    format!("{scene} - {strategy}{rate} - Antumbra")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(scene: &str) -> TitleWords<'_> {
        TitleWords { scene, strategy: "antumbra", unit: "frames/s" }
    }

    #[test]
    fn it_says_how_many_frames_there_were_in_a_second() {
        for (frame_ms, said) in [(20, "50 frames/s"), (400, "2.5 frames/s")] {
            let mut title = Title::default();
            let at = |frame: u64| Time::from_nanos(frame * frame_ms * 1_000_000);
            let words = TitleWords { scene: "city", strategy: "frustum", unit: "frames/s" };
            let first = title.count(at(0), &words);
            assert_eq!(first.as_deref(), Some("city - frustum - Antumbra"));
            let titles = (1..=100).filter_map(|frame| title.count(at(frame), &words));
            let titles: Vec<String> = titles.collect();
            assert_eq!(
                titles.len() as u64,
                100 * frame_ms / if frame_ms == 20 { 500 } else { 800 }
            );
            let expected = format!("city - frustum - {said} - Antumbra");
            assert!(titles.iter().all(|title| *title == expected), "{titles:?}");
        }
    }

    #[test]
    fn another_scene_does_not_take_the_rate_of_the_one_before() {
        let mut title = Title::default();
        let at = |ms: u64| Time::from_nanos(ms * 1_000_000);
        for ms in 0..400 {
            title.count(at(ms), &words("nothing"));
        }
        let mut next = |ms: u64| title.count(at(ms), &words("rooms"));
        assert_eq!(next(400).as_deref(), Some("rooms - antumbra - Antumbra"));
        assert_eq!(next(1400).as_deref(), Some("rooms - antumbra - 1.0 frames/s - Antumbra"));
    }
}
