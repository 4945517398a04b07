//! The command line of `compare`.

use std::path::PathBuf;

use clap::Parser;

/// The arguments of the page, its table and plot, and their inputs.
const ALL_ELSE: [&str; 5] = ["page", "table", "svg", "images", "notes"];

/// Makes one page from many reports of walkthrough: every strategy side by side, and the figures
/// asked for with those that were reached.
///
/// Repetitions of a case (scene, path, number of objects) are found by the reports' contents, not
/// by the names of their files. Missing measurements are named as such.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "compare",
    version,
    args_override_self = true,
    after_help = "\
Examples:
  compare out/compare/reports --page out/compare/index.html
      The page for a person.
  compare out/compare/reports --table comparison.md --svg comparison.svg
      Tables and the plot of ratios for a README.

Exit codes: 0 all was written; 2 a report is none, the folder has none, or a file has no folder; 1 \
a file cannot be written."
)]
pub struct Arguments {
    /// Folder with reports (*.json) that walkthrough --report wrote, all of one device
    #[arg(value_name = "DIR")]
    pub reports: PathBuf,
    /// File for the page: HTML with everything in it
    #[arg(long, value_name = "FILE.html")]
    pub page: Option<PathBuf>,
    /// File for the tables as Markdown
    #[arg(long, value_name = "FILE.md")]
    pub table: Option<PathBuf>,
    /// File for the plot of ratios over scene sizes alone
    #[arg(long, value_name = "FILE.svg")]
    pub svg: Option<PathBuf>,
    /// Folder with images for the page: of the report NAME.json, the first one in its folder NAME
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,
    /// File for tables about lights and shadows as Markdown, instead of all else
    #[arg(long, value_name = "FILE.md", conflicts_with_all = ALL_ELSE)]
    pub shadows: Option<PathBuf>,
    /// Print the names of the walks that must be repeated before they can be judged, and end
    #[arg(long, conflicts_with_all = ALL_ELSE, conflicts_with = "shadows")]
    pub noisy: bool,
    /// File of notes for page and tables: a line for each thing that was left out of the
    /// measurement, with the reason
    #[arg(long, value_name = "FILE.txt")]
    pub notes: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_declaration_is_consistent() {
        Arguments::command().debug_assert();
        let arguments = Arguments::try_parse_from(["compare", "r", "--page=p.html"]).unwrap();
        assert_eq!((arguments.reports, arguments.page), ("r".into(), Some("p.html".into())));
        let twice = ["compare", "r", "--page=p.html", "--page", "q.html"];
        assert_eq!(Arguments::try_parse_from(twice).unwrap().page, Some("q.html".into()));
        assert!(Arguments::try_parse_from(["compare"]).is_err(), "the folder must be named");
        for words in [["--noisy", "--page=p.html"], ["--shadows=s.md", "--svg=x.svg"]] {
            let both = Arguments::try_parse_from([&["compare", "r"], &words[..]].concat());
            let message = both.unwrap_err().to_string();
            assert!(message.contains("cannot be used with"), "{message}");
        }
    }
}
