//! Reads the reports of `walkthrough` back: a folder of JSON files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::input_file;
use crate::report::Report;
use crate::run_error::RunError;
use crate::terminal::shown;

/// The largest file that is read: a report of a million frames and a dozen strategies is smaller.
const MOST_BYTES: u64 = 512 << 20;

/// Reads every `.json` file of a folder, in the order of their names.
///
/// # Errors
/// When the folder cannot be read or has no report, or for a file that is not a report, with the
/// reason.
pub fn read_folder(folder: &Path) -> Result<Vec<Report>, RunError> {
    let failed = |reason: io::Error| {
        RunError::user(format!(
            "cannot read the folder '{}': {reason}; name one that holds reports of walkthrough",
            shown(folder)
        ))
    };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden =
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.extension().is_some_and(|extension| extension == "json") && !is_hidden {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() {
        let folder = shown(folder);
        return Err(RunError::user(format!(
            "there is no report in '{folder}': run ci/compare, or write some there with \
             'walkthrough --report {folder}/NAME.json'"
        )));
    }
    files.into_iter().map(read_report).collect()
}

/// Reads the lines of a file of notes, each once; full stops at the ends are removed.
///
/// # Errors
/// When the file cannot be read.
pub fn read_notes(file: &Path) -> Result<Vec<String>, RunError> {
    let text = input_file::read_text(file, MOST_BYTES).map_err(|reason| {
        let file = shown(file);
        RunError::user(format!("cannot read the notes '{file}': {reason}; name a text file"))
    })?;
    let mut notes = Vec::new();
    for line in text.lines().map(|line| line.trim().trim_end_matches('.').to_owned()) {
        if !line.is_empty() && !notes.contains(&line) {
            notes.push(line);
        }
    }
    Ok(notes)
}

fn read_report(file: PathBuf) -> Result<Report, RunError> {
    let text = input_file::read_text(&file, MOST_BYTES).map_err(|error| error.to_string());
    let mut report = text.and_then(|text| Report::parse(&text)).map_err(|reason| {
        let file = shown(&file);
        RunError::user(format!(
            "'{file}' is not a report of walkthrough: {reason}; remove it or measure it again"
        ))
    })?;
    report.file = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(report)
}
