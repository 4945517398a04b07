//! The programs' side of the terminal: command lines in, text out, and exit codes.
//!
//! [`start()`] reads the command line and starts the log, [`output`] writes to standard output and
//! standard error, [`ending`] collects failures on the way to the exit code. [`style`] finds the
//! terminal's capabilities, and [`names`] escapes file names.

pub mod ending;
pub mod names;
pub mod output;
pub mod start;
pub mod style;

pub use ending::Ending;
pub use names::shown;
pub use output::{print, say};
pub use start::{run_program, start};
