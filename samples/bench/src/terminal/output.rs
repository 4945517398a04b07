//! Text for standard output and standard error.

use std::io::{self, Write};
use std::path::Path;

use super::names::harmless;
use crate::outputs::WriteError;

/// Writes text to standard output. A closed reader is not an error.
///
/// # Errors
/// When the text cannot be written, as on a full disk.
pub fn print(text: &str) -> Result<(), WriteError> {
    let mut output = io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(WriteError::StandardOutput(error.to_string()))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error. Where that is full or closed, the line is lost.
pub fn say(text: &str) {
    let _nobody_reads = writeln!(io::stderr().lock(), "{}", harmless(text));
}

/// Reports a file that was written.
pub fn say_wrote(path: &Path) {
    say(&format!("wrote {}", super::shown(path)));
}
