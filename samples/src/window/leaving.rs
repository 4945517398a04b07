//! The key Esc: closes what is open, frees the mouse, and quits when it is struck twice.

use std::time::Duration;

use pacing::Time;

/// A second Esc within this time quits.
pub const CONFIRM_WITHIN: Duration = Duration::from_secs(4);

/// What one Esc does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Escape {
    /// Closes the list, field or page over the picture.
    Close,
    /// Frees the mouse.
    Free,
    /// Asks for a second one.
    Ask,
    /// Quits.
    Quit,
}

/// Remembers when Esc asked for confirmation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Leaving {
    asked: Option<Time>,
}

impl Leaving {
    /// Returns what an Esc at `now` does where something may be open, and the mouse captured.
    pub fn escape(&mut self, now: Time, open: Option<Escape>) -> Escape {
        if let Some(first) = open {
            self.asked = None;
            return first;
        }
        let is_confirmed = self.asked.is_some_and(|asked| now.since(asked) <= CONFIRM_WITHIN);
        self.asked = Some(now);
        if is_confirmed { Escape::Quit } else { Escape::Ask }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_second_one_in_time_quits() {
        let mut leaving = Leaving::default();
        let at = |seconds: u64| Time::from_nanos(seconds * 1_000_000_000);
        assert_eq!(leaving.escape(at(1), Some(Escape::Close)), Escape::Close);
        assert_eq!(leaving.escape(at(1), Some(Escape::Free)), Escape::Free);
        assert_eq!(leaving.escape(at(2), None), Escape::Ask);
        assert_eq!(leaving.escape(at(10), None), Escape::Ask, "too late");
        // What closes or frees something in between is no confirmation.
        assert_eq!(leaving.escape(at(11), Some(Escape::Free)), Escape::Free);
        assert_eq!(leaving.escape(at(11), None), Escape::Ask);
        assert_eq!(leaving.escape(at(12), None), Escape::Quit);
    }
}
