//! The Esc key: it closes the open page, frees the mouse, and quits when pressed twice.

use std::time::Duration;

use antumbra::pacing::Time;

/// The time within which a second Esc quits.
pub const CONFIRM_WITHIN: Duration = Duration::from_secs(4);

/// The effect of one Esc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Escape {
    /// Closes the list, field or page over the image.
    Close,
    /// Frees the mouse.
    Free,
    /// Asks for a second Esc.
    Ask,
    /// Quits the program.
    Quit,
}

/// The time at which Esc asked for confirmation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Leaving {
    asked: Option<Time>,
}

impl Leaving {
    /// Returns the effect of an Esc at `now`. `open` is the effect for an open page or a captured
    /// mouse.
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
        // An Esc that closes or frees something in between does not confirm.
        assert_eq!(leaving.escape(at(11), Some(Escape::Free)), Escape::Free);
        assert_eq!(leaving.escape(at(11), None), Escape::Ask);
        assert_eq!(leaving.escape(at(12), None), Escape::Quit);
    }
}
