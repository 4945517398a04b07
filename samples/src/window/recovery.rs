//! The time at which a window continues on another device.

use antumbra::pacing::{RecoverySchedule, Retry, Time};
use bench::run_error::{Blame, RunError};

/// The decision when to open another device for a window, after the loss of the present one.
#[derive(Debug, Default)]
pub struct WindowRecovery {
    schedule: RecoverySchedule,
    due: Option<Time>,
}

impl WindowRecovery {
    /// Returns the time at which another device is opened, while the present one is lost.
    pub fn due(&self) -> Option<Time> {
        self.due
    }

    /// Decides when to try to continue after an error. Returns `None` for errors that end the
    /// program: all but a lost device, unless one is being replaced. What fails meanwhile may pass.
    pub fn after(&mut self, error: &RunError, now: Time) -> Option<Time> {
        let retry = match self.due {
            Some(_) => self.schedule.failed(now),
            None if error.blame == Blame::LostDevice => self.schedule.lost(now),
            None => Retry::GiveUp,
        };
        self.due = match retry {
            Retry::At(at) => Some(at),
            Retry::GiveUp => None,
        };
        self.due
    }

    /// Notes that the window continues on another device.
    pub fn continued(&mut self) {
        self.due = None;
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn at_ms(ms: u64) -> Time {
        Time::from_origin(Duration::from_millis(ms))
    }

    #[test]
    fn only_a_lost_device_begins_a_recovery_and_any_error_repeats_it() {
        let mut recovery = WindowRecovery::default();
        assert_eq!(recovery.after(&RunError::machine("no disk"), at_ms(0)), None);
        let lost = RunError::lost_device("gone");
        assert_eq!(recovery.after(&lost, at_ms(5)), Some(at_ms(5)));
        assert_eq!(recovery.due(), Some(at_ms(5)));
        let later = recovery.after(&RunError::machine("no device"), at_ms(6));
        assert!(later > Some(at_ms(6)), "{later:?}");
        recovery.continued();
        assert_eq!(recovery.due(), None);
        assert_eq!(recovery.after(&RunError::machine("no disk"), at_ms(7)), None);
    }

    #[test]
    fn attempts_that_fail_again_and_again_end() {
        let mut recovery = WindowRecovery::default();
        let lost = RunError::lost_device("gone");
        let mut now = recovery.after(&lost, at_ms(0));
        let mut attempts = 0;
        while let Some(at) = now {
            attempts += 1;
            assert!(attempts < 100);
            now = recovery.after(&lost, at);
        }
        assert!(attempts > 1);
    }
}
