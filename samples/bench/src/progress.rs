//! Shows the progress of a walk: a bar on a terminal, a line now and then elsewhere.

use std::cell::{Cell, RefCell};
use std::fmt::Write;
use std::io;
use std::time::Duration;

use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

use crate::terminal::{say, style::can_redraw};

/// The observer of a running walk.
pub trait WalkProgress {
    /// Begins a step of the preparations: "building the city".
    fn stage(&self, what: &str);
    /// Begins `frames` frames; `what` is their purpose.
    fn begin_frames(&self, what: &str, frames: u64);
    /// Notes that one frame is done; `how` names its strategy, or is empty.
    fn frame_done(&self, how: &str);
    /// Ends the frames; no more calls follow.
    fn finish(&self);
}

/// Returns the progress that suits standard error, or none.
pub fn for_terminal(quiet: bool) -> Box<dyn WalkProgress> {
    if quiet {
        Box::new(Bar(ProgressBar::hidden()))
    } else if can_redraw(&io::stderr()) {
        Box::new(Bar(ProgressBar::new_spinner()))
    } else {
        Box::new(Lines::default())
    }
}

/// The time after which the remaining time is estimated.
const ESTIMATE_AFTER: Duration = Duration::from_secs(1);
/// The least remaining time that is shown.
const REST_MIN: Duration = Duration::from_secs(1);

/// Returns the remaining time in words; an empty text where it is not known yet.
fn left(elapsed: Duration, rest: Duration) -> String {
    if elapsed < ESTIMATE_AFTER || rest < REST_MIN {
        return String::new();
    }
    format!(", {:#} left", HumanDuration(rest))
}

/// A bar that is redrawn in place on standard error, or hidden.
#[derive(Debug)]
struct Bar(ProgressBar);

impl WalkProgress for Bar {
    fn stage(&self, what: &str) {
        self.0.set_message(what.to_owned());
        self.0.tick();
    }

    fn begin_frames(&self, what: &str, frames: u64) {
        self.0.set_message(what.to_owned());
        let style = "{bar:20} {pos}/{len} frames{left}  {wide_msg}";
        if let Ok(style) = ProgressStyle::with_template(style) {
            self.0.set_style(style.with_key(
                "left",
                |state: &ProgressState, text: &mut dyn Write| {
                    let _text_takes_all = text.write_str(&left(state.elapsed(), state.eta()));
                },
            ));
        }
        self.0.set_length(frames);
        self.0.reset();
    }

    fn frame_done(&self, how: &str) {
        if !how.is_empty() && self.0.message() != how {
            self.0.set_message(how.to_owned());
        }
        self.0.inc(1);
    }

    fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// The progress of loading a file, on standard error where that is a terminal.
#[derive(Debug)]
pub struct LoadingBar(ProgressBar);

impl LoadingBar {
    /// Returns a bar on a terminal, nothing elsewhere.
    pub fn for_terminal() -> Self {
        if !can_redraw(&io::stderr()) {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(1000);
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {elapsed}  {msg}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Shows the current step, and its fraction done, 0 to 1, where it is known.
    pub fn told(&self, what: &str, fraction: Option<f32>) {
        if self.0.message() != what {
            self.0.set_message(what.to_owned());
        }
        let fraction = fraction.unwrap_or_default().clamp(0.0, 1.0);
        self.0.set_position((fraction * 1000.0) as u64);
    }
}

impl Drop for LoadingBar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A line for each stage and each tenth of the frames, for logs.
#[derive(Debug, Default)]
struct Lines {
    what: RefCell<String>,
    done: Cell<u64>,
    frames: Cell<u64>,
}

impl WalkProgress for Lines {
    fn stage(&self, what: &str) {
        say(what);
    }

    fn begin_frames(&self, what: &str, frames: u64) {
        self.what.replace(what.to_owned());
        self.frames.set(frames);
        self.done.set(0);
    }

    fn frame_done(&self, _: &str) {
        let done = self.done.get() + 1;
        let frames = self.frames.get();
        self.done.set(done);
        if completes_tenth(done, frames) {
            say(&format!("{}: {done} of {frames} frames", self.what.borrow()));
        }
    }

    fn finish(&self) {}
}

/// Returns true if this frame completes a tenth of all frames.
fn completes_tenth(done: u64, frames: u64) -> bool {
    let tenths = |done: u64| done.saturating_mul(10).checked_div(frames);
    tenths(done) != tenths(done.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_not_said_before_it_is_known() {
        let seconds = Duration::from_secs;
        assert_eq!(left(Duration::ZERO, Duration::ZERO), "");
        assert_eq!(left(seconds(0), seconds(9)), "");
        assert_eq!(left(seconds(5), Duration::from_millis(400)), "");
        assert_eq!(left(seconds(5), seconds(30)), ", 30s left");
    }

    #[test]
    fn a_line_at_each_tenth() {
        let lines = |frames| (1..=frames).filter(|&done| completes_tenth(done, frames)).count();
        assert_eq!(lines(1000), 10);
        assert_eq!(lines(37), 10);
        assert_eq!(lines(3), 3);
        assert!(completes_tenth(37, 37));
        assert!(!completes_tenth(1, 0));
    }
}
