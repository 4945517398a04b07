//! The times at which a program tries to go on after its device was lost.

use std::collections::VecDeque;
use std::time::Duration;

use crate::time::Time;

/// The rules of a [`RecoverySchedule`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecoveryRules {
    /// The pause after the second loss within [`RecoveryRules::window`], and after the first
    /// attempt that failed. Each further one doubles it. A driver that restarts needs some time.
    pub first_pause: Duration,
    /// The longest pause.
    pub longest_pause: Duration,
    /// The number of attempts per loss.
    pub attempts: u32,
    /// The number of losses within [`RecoveryRules::window`] that a program goes on after.
    pub losses: usize,
    /// The time for which a loss counts.
    pub window: Duration,
}

impl Default for RecoveryRules {
    /// Returns rules that go on after five losses in a minute, with six attempts each, between
    /// which 0.1 s to 1.6 s pass.
    fn default() -> Self {
        Self {
            first_pause: Duration::from_millis(100),
            longest_pause: Duration::from_secs(5),
            attempts: 6,
            losses: 5,
            window: Duration::from_secs(60),
        }
    }
}

/// The next step of a program whose device is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Retry {
    /// Opens a device at this time, and continues on it.
    At(Time),
    /// Ends with the error.
    GiveUp,
}

/// The decision when to open another device: at once after a first loss, later after losses that
/// repeat and attempts that fail, and in the end never.
#[derive(Clone, Debug, Default)]
pub struct RecoverySchedule {
    rules: RecoveryRules,
    /// The times of the losses that count.
    losses: VecDeque<Time>,
    /// The number of attempts that failed since the newest loss.
    failed: u32,
}

impl RecoverySchedule {
    /// Creates a schedule without losses.
    pub fn new(rules: RecoveryRules) -> Self {
        Self { rules, losses: VecDeque::new(), failed: 0 }
    }

    /// Notes that a device was lost, and returns the next step.
    pub fn lost(&mut self, now: Time) -> Retry {
        let window = self.rules.window;
        self.losses.retain(|loss| now.since(*loss) < window);
        self.losses.push_back(now);
        self.failed = 0;
        if self.losses.len() > self.rules.losses {
            return Retry::GiveUp;
        }
        Retry::At(now.after(self.pause(self.losses.len() - 1)))
    }

    /// Notes that an attempt to go on failed, and returns the next step.
    pub fn failed(&mut self, now: Time) -> Retry {
        self.failed = self.failed.saturating_add(1);
        if self.failed >= self.rules.attempts {
            return Retry::GiveUp;
        }
        Retry::At(now.after(self.pause(self.failed as usize)))
    }

    /// Returns the pause after a number of losses or failures before the newest one.
    fn pause(&self, before: usize) -> Duration {
        let Some(doublings) = before.checked_sub(1) else { return Duration::ZERO };
        let doublings = u32::try_from(doublings).unwrap_or(u32::MAX);
        let factor = 1_u32.checked_shl(doublings).unwrap_or(u32::MAX);
        self.rules.first_pause.saturating_mul(factor).min(self.rules.longest_pause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_ms(ms: u64) -> Time {
        Time::from_origin(Duration::from_millis(ms))
    }

    #[test]
    fn a_first_loss_is_answered_at_once_and_later_ones_later() {
        let mut schedule = RecoverySchedule::default();
        let steps = [0, 1_000, 2_000, 3_000, 4_000].map(|ms| schedule.lost(at_ms(ms)));
        let expected = [0, 1_100, 2_200, 3_400, 4_800].map(|ms| Retry::At(at_ms(ms)));
        assert_eq!(steps, expected);
        assert_eq!(schedule.lost(at_ms(5_000)), Retry::GiveUp);
    }

    #[test]
    fn losses_of_more_than_a_minute_ago_do_not_count() {
        let mut schedule = RecoverySchedule::default();
        for minute in 0..1_000 {
            let now = at_ms(60_000 * minute);
            assert_eq!(schedule.lost(now), Retry::At(now));
        }
        assert_eq!(schedule.losses.len(), 1);
    }

    #[test]
    fn attempts_end_and_begin_again_with_another_loss() {
        let mut schedule = RecoverySchedule::default();
        for loss in 0..3 {
            let now = at_ms(1_000_000 * loss);
            assert_eq!(schedule.lost(now), Retry::At(now));
            let steps = [(); 6].map(|()| schedule.failed(now));
            let expected = [100, 200, 400, 800, 1_600];
            let expected = expected.map(|ms| Retry::At(now.after(Duration::from_millis(ms))));
            assert_eq!(steps[..5], expected);
            assert_eq!(steps[5], Retry::GiveUp);
        }
    }

    #[test]
    fn no_pause_is_longer_than_the_longest() {
        let rules = RecoveryRules { attempts: u32::MAX, losses: 100, ..Default::default() };
        let mut schedule = RecoverySchedule::new(rules);
        let longest = at_ms(0).after(rules.longest_pause);
        for _ in 0..90 {
            schedule.lost(at_ms(0));
        }
        assert_eq!(schedule.lost(at_ms(0)), Retry::At(longest));
        for _ in 0..90 {
            schedule.failed(at_ms(0));
        }
        assert_eq!(schedule.failed(at_ms(0)), Retry::At(longest));
    }
}
