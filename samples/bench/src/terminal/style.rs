//! The capabilities of a terminal: colours, redrawn lines, width.

use std::io::{self, IsTerminal};

use terminal_size::{Width, terminal_size_of};

/// The columns of text that goes into a file or a pipe.
pub const PLAIN_WIDTH: usize = 120;
/// The columns of a terminal of unknown width.
const UNKNOWN_WIDTH: usize = 80;
/// The least columns that text is wrapped to.
const LEAST_WIDTH: usize = 40;

/// Returns true if a line can be drawn again in its place: on a terminal that is not `TERM=dumb`.
pub fn can_redraw(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && std::env::var_os("TERM").is_some_and(|name| name != "dumb")
}

/// Returns true if colours can be shown and are not refused by `NO_COLOR`.
pub fn has_colour(stream: &impl IsTerminal) -> bool {
    can_redraw(stream) && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Returns the columns of text for standard output.
pub fn width() -> usize {
    let output = io::stdout();
    if !output.is_terminal() {
        return PLAIN_WIDTH;
    }
    let found = terminal_size_of(output).map(|(Width(columns), _)| usize::from(columns));
    found.filter(|columns| *columns > 0).unwrap_or(UNKNOWN_WIDTH).max(LEAST_WIDTH)
}
