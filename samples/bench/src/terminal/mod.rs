//! Where the programs meet the terminal: command lines in, text out, and how they end.
//!
//! [`start()`] reads the command line and starts the log, [`output`] writes to standard output and
//! standard error, [`ending`] collects what went wrong on the way to the exit code. [`style`] says
//! what the terminal can show, and [`names`] how file names are shown.

pub mod ending;
pub mod names;
pub mod output;
pub mod start;
pub mod style;

pub use ending::Ending;
pub use names::shown;
pub use output::{print, say};
pub use start::start;
