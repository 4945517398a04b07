//! What is told at the lower edge of the picture, for a while.

use std::time::Duration;

use pacing::Time;

const FOR: Duration = Duration::from_secs(5);

/// The newest thing to tell.
#[derive(Clone, Debug, Default)]
pub struct Notice {
    text: String,
    /// `None` until something else takes its place.
    until: Option<Time>,
}

impl Notice {
    /// Tells it for some seconds, and on the log.
    pub fn tell(&mut self, now: Time, text: String) {
        tracing::info!("{text}");
        *self = Self { text, until: Some(now.after(FOR)) };
    }

    /// Tells it until something else is told.
    pub fn keep_telling(&mut self, text: String) {
        tracing::warn!("{text}");
        *self = Self { text, until: None };
    }

    /// What there is to tell.
    pub fn at(&self, now: Time) -> Option<&str> {
        let is_over = self.until.is_some_and(|until| now >= until);
        (!is_over && !self.text.is_empty()).then_some(self.text.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_told_for_a_while() {
        let mut notice = Notice::default();
        assert_eq!(notice.at(Time::ZERO), None);
        notice.tell(Time::ZERO, "a".to_owned());
        assert_eq!(notice.at(Time::ZERO), Some("a"));
        assert_eq!(notice.at(Time::ZERO.after(FOR)), None);
        notice.keep_telling("b".to_owned());
        assert_eq!(notice.at(Time::ZERO.after(FOR * 100)), Some("b"));
    }
}
