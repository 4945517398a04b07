//! Scripts: actions before numbered frames, so that a run can be repeated automatically.
//!
//! A line has the number of a frame and an [`Action`]: `60 strategy hzb`. Frames are counted from 0
//! and must not decrease. Empty lines and lines that begin with `#` are ignored.

use std::path::Path;

use super::actions::Action;
use bench::input_file;
use bench::options::UsageError;
use bench::terminal::shown;

/// The largest file that is accepted.
const MOST_BYTES: u64 = 16 << 20;

/// Actions in the order of their frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Script {
    lines: Vec<(u32, Action)>,
    next: usize,
}

impl Script {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, or the number of the first bad line.
    pub fn read(path: &Path) -> Result<Self, UsageError> {
        let shown = shown(path);
        let refuse = |reason: &dyn std::fmt::Display| {
            UsageError(format!("cannot read the script '{shown}': {reason}"))
        };
        let text = input_file::read_text(path, MOST_BYTES).map_err(|error| refuse(&error))?;
        Self::parse(&text).map_err(|(line, reason)| UsageError(format!("{shown}:{line}: {reason}")))
    }

    fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut lines: Vec<(u32, Action)> = Vec::new();
        for (number, line) in (1..).zip(text.lines().map(str::trim)) {
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let wrong = |reason: String| (number, reason);
            let (frame, action) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            let frame = frame.parse().map_err(|_| {
                wrong(format!("a line begins with the number of a frame, not '{frame}'"))
            })?;
            if lines.last().is_some_and(|(last, _)| *last > frame) {
                return Err(wrong(format!("frame {frame} comes before the line above")));
            }
            lines.push((frame, Action::parse(action).map_err(wrong)?));
        }
        Ok(Self { lines, next: 0 })
    }

    /// Returns the next action that is due before `frame`.
    pub fn next_before(&mut self, frame: u32) -> Option<Action> {
        let (due, action) = *self.lines.get(self.next)?;
        if due > frame {
            return None;
        }
        self.next += 1;
        Some(action)
    }
}

#[cfg(test)]
mod tests {
    use antumbra::methods;

    use super::*;

    #[test]
    fn actions_come_in_their_turn() {
        let mut script =
            Script::parse("# first\n2 hud\n2 strategy naive\n\n  5   quit  \n").unwrap();
        assert_eq!(script.next_before(1), None);
        assert_eq!(script.next_before(2), Some(Action::Hud));
        assert_eq!(script.next_before(2), Some(Action::Strategy(methods::NAIVE)));
        assert_eq!(script.next_before(2), None);
        assert_eq!(script.next_before(9), Some(Action::Quit));
        assert_eq!(script.next_before(9), None);
    }

    #[test]
    fn a_broken_line_is_named() {
        for (text, line, reason) in [
            ("1 hud\nhud\n", 2, "number of a frame, not 'hud'"),
            ("1 hud\n\n0 hud\n", 3, "frame 0 comes before"),
            ("7\n", 1, "unknown action ''"),
            ("-1 hud\n", 1, "not '-1'"),
        ] {
            let (at, why) = Script::parse(text).unwrap_err();
            assert!(at == line && why.contains(reason), "{text:?}: {at}: {why}");
        }
        let refused = Script::read(Path::new("/nowhere/script")).unwrap_err().to_string();
        assert!(refused.contains("/nowhere/script"), "{refused}");
    }
}
