//! The comparison of all strategies: reads a folder of reports, writes a page, a table and a
//! picture.
//!
//! [`input`] reads the reports back, [`cases`] puts repetitions and parts together, [`figures`] and
//! [`exactness`] compare them with the goals, [`plots`] draws, and [`comparison`] gathers it all
//! for [`page`]. [`noise`] decides if the machine was steady enough to judge.

pub mod args;
pub mod bar_chart;
pub mod cases;
pub mod comparison;
pub mod exactness;
pub mod figures;
pub mod input;
pub mod line_chart;
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

use self::args::Arguments;
use self::cases::{Cases, distinct};
use self::comparison::ReportComparison;
use self::input::{read_folder, read_notes};
use crate::outputs::{OutputFile, Outputs, write_file};
use crate::report::Report;
use crate::run_error::RunError;
use crate::terminal::{Ending, output::say_wrote, print};

/// Runs the comparison: prints the result, then writes each file that can be written.
///
/// # Errors
/// A file that cannot be written; reports that cannot be read or compared.
pub fn run(arguments: &Arguments) -> Result<Ending, RunError> {
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
        let tables = shadows::tables(&reports).ok_or_else(|| {
            RunError::user(
                "no report has lights: --shadows has nothing to show; see ci/compare --shadows",
            )
        })?;
        let tables = tables.markdown();
        ending.attempt(print(tables));
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
    let mut comparison = ReportComparison::of(&reports);
    if let Some(folder) = &arguments.images {
        let (shown, missing) = thumbnails::thumbnails(folder, &cases);
        comparison.thumbnails = shown;
        comparison.left_out.extend(missing);
    }
    if let Some(file) = &arguments.notes {
        comparison.left_out.extend(read_notes(file)?);
    }
    let page = page::page(&comparison)?;
    let mut files: Vec<(&Path, String)> = Vec::new();
    if let Some(file) = &arguments.page {
        files.push((file, page.html(&page::swatches())));
    }
    if let Some(file) = &arguments.table {
        files.push((file, page.markdown().to_owned()));
    }
    if let Some(file) = &arguments.svg {
        files.push((file, plots::ratios(&cases)?.ok_or_else(no_picture)?.svg));
    }
    let mut told = comparison.headline().map(|headline| headline + "\n").unwrap_or_default();
    for (verdict, count) in comparison.verdicts() {
        told.push_str(&format!("{count:>3} {}\n", verdict.words()));
    }
    told.push_str(&format!("{}.\n", noise::verdict(&cases)));
    ending.attempt(print(&told));
    for (file, text) in &files {
        if ending.attempt(write_file(file, text.as_bytes())).is_some() {
            say_wrote(file);
        }
    }
    Ok(ending)
}

/// Returns the error of an empty picture.
fn no_picture() -> RunError {
    RunError::user(
        "no report of the city on path street compares strategies: --svg has nothing to show",
    )
}

fn one_device(reports: &[Report]) -> Result<(), RunError> {
    let names = distinct(reports.iter().map(|report| report.device.name.as_str()));
    if names.len() < 2 {
        return Ok(());
    }
    Err(RunError::user(format!(
        "the reports stem from {}: put those of each device into a folder of its own",
        names.join(" and ")
    )))
}
