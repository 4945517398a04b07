//! Messages at the lower edge of the image, shown for a while.

use std::time::Duration;

use antumbra::pacing::Time;

const FOR: Duration = Duration::from_secs(5);

/// The current messages: the newest one, and the error of shaders until they compile.
#[derive(Clone, Debug, Default)]
pub struct Toast {
    newest: String,
    /// The end of the message's time; `None` if it stays until another message replaces it.
    until: Option<Time>,
    weight: Weight,
    broken_shaders: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Weight {
    /// A request that was carried out.
    #[default]
    Done,
    /// A request that cannot be carried out, or an error: shown even without the HUD.
    Refused,
}

impl Toast {
    /// Shows a completed action for some seconds, and logs it.
    pub fn tell(&mut self, now: Time, text: String) {
        tracing::info!("{text}");
        self.put(text, Some(now.after(FOR)), Weight::Done);
    }

    /// Shows for some seconds that a request cannot be carried out, and logs it.
    pub fn refuse(&mut self, now: Time, text: String) {
        tracing::warn!("{text}");
        self.put(text, Some(now.after(FOR)), Weight::Refused);
    }

    /// Shows an error until another message replaces it.
    pub fn keep_telling(&mut self, text: String) {
        tracing::warn!("{text}");
        self.put(text, None, Weight::Refused);
    }

    /// Shows the error of shaders below other messages until they compile.
    pub fn shaders_are_broken(&mut self, text: String) {
        tracing::warn!("{text}");
        self.broken_shaders = Some(text);
    }

    /// Removes the error of shaders.
    pub fn shaders_work(&mut self) {
        self.broken_shaders = None;
    }

    /// Returns the current messages.
    pub fn at(&self, now: Time) -> Option<String> {
        let is_over = self.until.is_some_and(|until| now >= until);
        let newest = (!is_over && !self.newest.is_empty()).then_some(self.newest.as_str());
        join(newest, self.broken_shaders.as_deref())
    }

    /// Returns the current messages without the HUD: refusals and errors.
    pub fn refused_at(&self, now: Time) -> Option<String> {
        match self.weight {
            Weight::Refused => self.at(now),
            Weight::Done => self.broken_shaders.clone(),
        }
    }

    fn put(&mut self, newest: String, until: Option<Time>, weight: Weight) {
        (self.newest, self.until, self.weight) = (newest, until, weight);
    }
}

fn join(above: Option<&str>, below: Option<&str>) -> Option<String> {
    let lines: Vec<&str> = above.into_iter().chain(below).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: Option<String>) -> String {
        text.unwrap_or_default()
    }

    #[test]
    fn it_is_told_for_a_while() {
        let mut toast = Toast::default();
        assert_eq!(toast.at(Time::ZERO), None);
        toast.tell(Time::ZERO, "a".to_owned());
        assert_eq!(said(toast.at(Time::ZERO)), "a");
        assert_eq!(toast.at(Time::ZERO.after(FOR)), None);
        toast.keep_telling("b".to_owned());
        assert_eq!(said(toast.at(Time::ZERO.after(FOR * 100))), "b");
    }

    #[test]
    fn who_wants_no_text_is_told_what_cannot_be() {
        let mut toast = Toast::default();
        toast.tell(Time::ZERO, "done".to_owned());
        assert_eq!(toast.refused_at(Time::ZERO), None);
        toast.refuse(Time::ZERO, "cannot be".to_owned());
        assert_eq!(said(toast.refused_at(Time::ZERO)), "cannot be");
        assert_eq!(toast.refused_at(Time::ZERO.after(FOR)), None);
        toast.keep_telling("went wrong".to_owned());
        assert_eq!(said(toast.refused_at(Time::ZERO.after(FOR))), "went wrong");
    }

    #[test]
    fn broken_shaders_are_told_until_they_compile() {
        let mut toast = Toast::default();
        toast.shaders_are_broken("a.frag:1: no".to_owned());
        toast.tell(Time::ZERO, "done".to_owned());
        assert_eq!(said(toast.at(Time::ZERO)), "done\na.frag:1: no");
        assert_eq!(said(toast.refused_at(Time::ZERO)), "a.frag:1: no");
        assert_eq!(said(toast.at(Time::ZERO.after(FOR))), "a.frag:1: no");
        toast.shaders_are_broken("a.frag:2: no".to_owned());
        assert_eq!(said(toast.at(Time::ZERO.after(FOR))), "a.frag:2: no");
        toast.shaders_work();
        assert_eq!(toast.at(Time::ZERO.after(FOR)), None);
    }
}
