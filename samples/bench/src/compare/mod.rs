//! The comparison of all strategies: reads a folder of reports, writes a page, a table and a
//! picture.
//!
//! [`input`] reads the reports back, [`cases`] puts repetitions and parts together, [`figures`] and
//! [`exactness`] compare them with the goals, [`plots`] draws, and [`content`] gathers it all for
//! [`page`] and [`markdown`]. [`noise`] decides if the machine was steady enough to judge.

pub mod args;
pub mod bar_chart;
pub mod cases;
pub mod content;
pub mod exactness;
pub mod figures;
pub mod input;
pub mod line_chart;
pub mod markdown;
pub mod noise;
pub mod page;
pub mod palette;
pub mod picture;
pub mod plots;
pub mod shadows;
pub mod spread;
#[cfg(test)]
pub(crate) mod testing;
pub mod thumbnails;

use std::path::Path;

use thiserror::Error;

use self::args::Arguments;
use self::cases::Cases;
use self::content::Content;
use self::input::{InputError, Measured, read_folder, read_notes};
use self::picture::DrawError;
use crate::options::UsageError;
use crate::outputs::{OutputFile, Outputs, write_file};
use crate::terminal::{Ending, output::say_wrote, print};

/// The reasons why there is no comparison: one sentence that names the error and the remedy.
#[derive(Debug, Error)]
pub enum CompareError {
    /// Input that cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] UsageError),
    /// Reports of different devices.
    #[error("the reports stem from {0}: put those of each device into a folder of its own")]
    Devices(String),
    /// Reports none of which has shadows.
    #[error("no report has lights: --shadows has nothing to show; see ci/compare --shadows")]
    NoShadows,
    /// A picture that cannot be drawn, since there is nothing in it.
    #[error("no report of the city on path street compares strategies: --svg has nothing to show")]
    NoPicture,
    /// A plot that failed.
    #[error(transparent)]
    Draw(#[from] DrawError),
}

impl CompareError {
    /// Returns the exit code: 2 for errors that the user can correct, 1 for failures of the
    /// machine.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_)
            | Self::Output(_)
            | Self::Devices(_)
            | Self::NoShadows
            | Self::NoPicture => 2,
            Self::Draw(_) => 1,
        }
    }
}

/// Runs the comparison: prints the result, then writes each file that can be written.
///
/// # Errors
/// A place where no file can be; when there is nothing to compare.
pub fn run(arguments: &Arguments) -> Result<Ending, CompareError> {
    let files = [
        OutputFile::of("--page", arguments.page.as_deref()),
        OutputFile::of("--table", arguments.table.as_deref()),
        OutputFile::of("--svg", arguments.svg.as_deref()),
        OutputFile::of("--shadows", arguments.shadows.as_deref()),
    ];
    let _outputs = Outputs::prepare(None, files.into_iter().flatten())?;
    let reports = read_folder(&arguments.reports)?;
    one_device(&reports)?;
    let mut ending = Ending::default();
    if let Some(file) = &arguments.shadows {
        let tables = shadows::tables(&reports).ok_or(CompareError::NoShadows)?;
        ending.attempt(print(&tables));
        if ending.attempt(write_file(file, tables.as_bytes())).is_some() {
            say_wrote(file);
        }
        return Ok(ending);
    }
    let cases = Cases::of(&reports);
    if arguments.noisy {
        let names = noise::to_repeat(&cases).into_iter().map(|name| name + "\n");
        ending.attempt(print(&names.collect::<String>()));
        return Ok(ending);
    }
    let mut content = Content::of(&reports)?;
    if let Some(folder) = &arguments.images {
        let (shown, missing) = thumbnails::thumbnails(folder, &cases);
        content.thumbnails = shown;
        content.left_out.extend(missing);
    }
    if let Some(file) = &arguments.notes {
        content.left_out.extend(read_notes(file)?);
    }
    let mut files: Vec<(&Path, String)> = Vec::new();
    if let Some(file) = &arguments.page {
        files.push((file, page::render(&content)));
    }
    if let Some(file) = &arguments.table {
        files.push((file, markdown::render(&content)));
    }
    if let Some(file) = &arguments.svg {
        let plot = content.ratios.as_ref().ok_or(CompareError::NoPicture)?;
        files.push((file, plot.svg.clone()));
    }
    let mut told: String = content.headline().map(|headline| headline + "\n").unwrap_or_default();
    for (verdict, count) in content.verdicts() {
        told.push_str(&format!("{count:>3} {}\n", verdict.words()));
    }
    told.push_str(&format!("{}.\n", content.steadiness));
    ending.attempt(print(&told));
    for (file, text) in &files {
        if ending.attempt(write_file(file, text.as_bytes())).is_some() {
            say_wrote(file);
        }
    }
    Ok(ending)
}

fn one_device(reports: &[Measured]) -> Result<(), CompareError> {
    let mut names: Vec<&str> = Vec::new();
    for report in reports {
        if !names.contains(&report.device.name.as_str()) {
            names.push(&report.device.name);
        }
    }
    if names.len() > 1 { Err(CompareError::Devices(names.join(" and "))) } else { Ok(()) }
}
