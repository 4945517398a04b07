//! The comparison as a page: the tables, and in HTML pictures, plots and the conditions of
//! the measurement.

use super::cases::Place;
use super::comparison::ReportComparison;
use super::exactness::{Book, Setting};
use super::figures::{Figure, Verdict};
use super::noise;
use super::palette;
use super::picture::DrawError;
use super::plots::{self, Plot};
use super::spread::{Spread, objects, short};
use super::thumbnails::Thumbnail;
use crate::report::Report;
use crate::result_page::{Cell, ResultPage, Table, Tone, escaped};
use crate::statistics::thousands;

/// The paths whose frame times are plotted, with their sizes.
const SHOWN_PATHS: [(&str, u64); 4] =
    [("street", 10_000), ("cut", 10_000), ("fly", 10_000), ("street", 40_000)];

/// Returns the comparison as a page.
///
/// # Errors
/// When a plot cannot be drawn.
pub fn page(comparison: &ReportComparison<'_>) -> Result<ResultPage, DrawError> {
    let mut page = ResultPage::new("Every method side by side");
    if let Some(headline) = comparison.headline() {
        page.text(Tone::Lead, &headline);
    }
    let conditions = [comparison.device(), comparison.frames(), comparison.days()];
    page.text(Tone::Faint, &(conditions.join("; ") + "."));
    page.text(Tone::Plain, &(noise::verdict(&comparison.cases) + "."));
    for warning in comparison.warnings() {
        page.text(Tone::Warning, &warning);
    }
    page.html_only(&cards(comparison));
    page.html_only(&scenes(&comparison.thumbnails));
    page.html_only(&plots::ratios(&comparison.cases)?.iter().map(plot).collect::<String>());
    let table = methods(comparison);
    if let Some(detail) = comparison.detail_size.filter(|_| !table.rows.is_empty()) {
        page.heading("The methods");
        page.text(
            Tone::Plain,
            &format!(
                "Frame time on `street` in times of `{}`, by the number of objects; CPU time, \
                 draws, boxes tested by all mechanisms and occlusion queries of a frame at {} \
                 objects.",
                comparison.yardstick,
                objects(detail as f64)
            ),
        );
        page.table(&table);
        if !comparison.left_out.is_empty() {
            page.text(Tone::Faint, &(comparison.left_out.join(". ") + "."));
        }
    }
    page.heading("Goals and results");
    page.text(
        Tone::Plain,
        "Found: the median of the repetitions and, in brackets, their spread. Ratios are medians \
         of the ratios frame by frame.",
    );
    page.table(&figures(&comparison.figures));
    page.html_only(&plots_of_frames(comparison)?);
    page.heading("Wrong pixels");
    page.text(
        Tone::Plain,
        "Pixels that differ from the picture of plain frustum culling, bit for bit, in all \
         compared frames together.",
    );
    page.table(&exactness(&comparison.books));
    page.html_only(&commands(comparison.reports));
    Ok(page)
}

fn plots_of_frames(comparison: &ReportComparison<'_>) -> Result<String, DrawError> {
    let cases = &comparison.cases;
    let mut plots = Vec::new();
    for (path, size) in SHOWN_PATHS {
        plots.extend(plots::frame_times(cases, &Place::still("city", path, size))?);
    }
    plots.extend(plots::cpu_times(cases)?);
    if let Some(size) = comparison.detail_size {
        plots.extend(plots::counts(cases, &Place::street(size))?);
    }
    if plots.is_empty() {
        return Ok(String::new());
    }
    let plots: String = plots.iter().map(plot).collect();
    Ok(format!("<h2>Frame by frame, CPU, tests, queries and draws</h2>\n{plots}"))
}

/// Returns the strategies' colours as the backgrounds of swatches, light and dark.
pub fn swatches() -> String {
    let rule = |name: &str, hex: String| format!(".s-{name}{{background:{hex}}}");
    let names = || palette::names();
    let light: String = names().map(|n| rule(n, palette::of_strategy(n).light_hex())).collect();
    let dark: String = names().map(|n| rule(n, palette::of_strategy(n).dark_hex())).collect();
    format!("{light}\n@media(prefers-color-scheme:dark){{{dark}}}\n")
}

/// Returns cards with the number of figures per verdict and the number of wrong pixels.
fn cards(comparison: &ReportComparison<'_>) -> String {
    let card = |count: &str, class: &str, what: &str| {
        format!("<div class=\"card\"><b class=\"{class}\">{count}</b>{what}</div>\n")
    };
    let mut cards = String::new();
    for (verdict, count) in comparison.verdicts().into_iter().filter(|(_, count)| *count > 0) {
        let what = match verdict {
            Verdict::Reached => "figures reached",
            Verdict::ReachedInMedian => "reached in the median",
            Verdict::Missed => "not reached",
            Verdict::Impossible => "impossible",
            Verdict::TooNoisy => "not judged: machine too busy",
            Verdict::NotMeasured | Verdict::Shown => "not measured",
        };
        cards += &card(&count.to_string(), class_of(verdict), what);
    }
    let exact = comparison.books.iter().filter(|book| book.is_exact && book.frames_compared > 0);
    let [frames, pixels] = exact.fold([0, 0], |[frames, pixels], book| {
        [frames + book.frames_compared, pixels + book.pixels_wrong]
    });
    if frames > 0 {
        let class = if pixels == 0 { "reached" } else { "missed" };
        let frames = thousands(frames as f64);
        let what = format!("wrong pixels of exact strategies<br>in {frames} compared frames");
        cards += &card(&thousands(pixels as f64), class, &what);
    }
    format!("<div class=\"cards\">\n{cards}</div>\n")
}

/// Returns a picture of each scene and path, side by side.
fn scenes(thumbnails: &[Thumbnail]) -> String {
    let figure = |Thumbnail { caption, size: [width, height], uri }: &Thumbnail| {
        let caption = escaped(caption);
        format!(
            "<figure><img alt=\"{caption}\" width=\"{width}\" height=\"{height}\" src=\"{uri}\">\
             <figcaption>{caption}</figcaption></figure>\n"
        )
    };
    let figures: String = thumbnails.iter().map(figure).collect();
    if figures.is_empty() { figures } else { format!("<div class=\"scenes\">\n{figures}</div>\n") }
}

fn plot(plot: &Plot) -> String {
    let caption = escaped(&plot.caption);
    format!("<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>\n", plot.svg.trim())
}

/// Returns the table of every strategy on `street`: over all sizes, and details at one.
pub fn methods(comparison: &ReportComparison<'_>) -> Table {
    let ReportComparison { cases, sizes, detail_size, .. } = comparison;
    let detail = detail_size.map(|size| cases.at(&Place::street(size))).unwrap_or_default();
    let number = |value: Option<Spread>, text: fn(f64) -> String| -> Cell {
        value.map_or("-".to_owned(), |value| text(value.median())).into()
    };
    let row = |name: &str| {
        let mut cells = vec![Cell::strategy(name)];
        cells.extend(sizes.iter().map(|size| ratio(comparison, name, *size)));
        cells.push(number(detail.cpu_ms(name), short));
        cells.push(number(detail.count(name, |run| run.draws), thousands));
        cells.push(number(detail.count(name, |run| run.tests), thousands));
        cells.push(number(detail.count(name, |run| run.queries), thousands));
        let wrong = comparison.pixels_wrong(name).map(|pixels| thousands(pixels as f64));
        cells.push(wrong.unwrap_or_else(|| "not compared".to_owned()).into());
        cells
    };
    let mut columns = vec!["strategy".to_owned()];
    columns.extend(sizes.iter().map(|size| objects(*size as f64)));
    columns
        .extend(["CPU ms", "draws", "boxes tested", "queries", "wrong pixels"].map(str::to_owned));
    let rows = cases.street_strategies(sizes).into_iter().map(row).collect();
    Table { numbers: 1..columns.len(), columns, rows }
}

fn ratio(comparison: &ReportComparison<'_>, strategy: &str, size: u64) -> Cell {
    let Some(ratio) = comparison.ratio(strategy, size) else { return "-".to_owned().into() };
    let mut detail = Vec::new();
    if ratio.count() > 1 {
        detail.push(format!("({} to {})", short(ratio.least()), short(ratio.most())));
    }
    let case = comparison.cases.at(&Place::street(size));
    let is_impossible = noise::is_below_ideal(&case, strategy);
    if is_impossible {
        detail.push("(impossible)".to_owned());
    }
    let class = if is_impossible { "missed" } else { "" };
    Cell { text: short(ratio.median()), detail: detail.join(" "), class }
}

fn class_of(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reached => "reached",
        Verdict::ReachedInMedian => "nearly",
        Verdict::Missed | Verdict::Impossible => "missed",
        Verdict::TooNoisy | Verdict::NotMeasured | Verdict::Shown => "open",
    }
}

fn figures(figures: &[Figure]) -> Table {
    let row = |figure: &Figure| {
        let verdict = figure.verdict();
        let note =
            if figure.note.is_empty() { String::new() } else { format!("({})", figure.note) };
        vec![
            figure.case.clone().into(),
            Cell { text: figure.what.clone(), detail: note, class: "" },
            figure.asked_words().into(),
            figure.found_words().into(),
            Cell { class: class_of(verdict), ..verdict.words().to_owned().into() },
        ]
    };
    let columns = ["case", "figure", "asked", "found", ""].map(str::to_owned).to_vec();
    Table { columns, numbers: 3..4, rows: figures.iter().map(row).collect() }
}

fn exactness(books: &[Book]) -> Table {
    let row = |book: &Book| {
        let promise = if book.is_exact { "exact" } else { "nothing" };
        let at = |setting: Setting| {
            let mut same = books.iter().filter(|other| other.strategy == book.strategy);
            wrong_pixels(same.find(|other| other.setting == setting))
        };
        let named = [Cell::strategy(&book.strategy), promise.to_owned().into()];
        named.into_iter().chain(Setting::ALL.map(at)).collect()
    };
    let still = books.iter().filter(|book| book.setting == Setting::Still);
    let settings = Setting::ALL.map(Setting::name);
    let columns = ["strategy", "promises"].into_iter().chain(settings).map(str::to_owned);
    Table { columns: columns.collect(), numbers: 2..6, rows: still.map(row).collect() }
}

fn wrong_pixels(book: Option<&Book>) -> Cell {
    let open = |text: &str| Cell { class: "open", ..text.to_owned().into() };
    match book {
        Some(book) if book.is_refused => open("refused by design"),
        Some(book) if book.frames_compared > 0 => {
            let class = match (book.pixels_wrong, book.is_exact) {
                (0, _) => "reached",
                (_, true) => "missed",
                (_, false) => "open",
            };
            let text = thousands(book.pixels_wrong as f64);
            let detail = format!("in {} frames", thousands(book.frames_compared as f64));
            Cell { text, detail, class }
        }
        _ => open("not compared"),
    }
}

fn commands(reports: &[Report]) -> String {
    let line = |report: &Report| {
        let command = report.provenance.command.join(" ");
        let command = if command.is_empty() { "not recorded" } else { &command };
        format!("{}: {}\n", escaped(&report.file), escaped(command))
    };
    let lines: String = reports.iter().map(line).collect();
    format!(
        "<h2>Measurement</h2>\n\
         <p>The strategies of a walk take turns in short rounds of consecutive frames, each after \
         some frames that do not count. A case is measured in two walks: plain frustum culling \
         leaves the caches cold for those that follow it, so it has one of its own with the ideal, \
         which ties the two together.</p>\n\
         <details><summary>The {} command lines</summary>\n<pre>{lines}</pre></details>\n",
        reports.len()
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::{measured, verified};
    use super::*;

    #[test]
    fn the_page_is_whole_and_needs_nothing_else() {
        let mut odd = measured("city", "street", 10_000, &[("ideal", 1.0), ("antumbra", 1.25)]);
        odd.device.name = "A <fast> & new GPU".to_owned();
        odd.provenance.command = vec!["walkthrough".to_owned(), "--report=<x>".to_owned()];
        let reports =
            [odd, verified("city", "street", 500, &[("antumbra", 9, 0), ("guess", 9, 5)])];
        let page = page(&ReportComparison::of(&reports)).unwrap();
        let page = page.html(&swatches());
        for text in [
            "A &lt;fast&gt; &amp; new GPU",
            "--report=&lt;x&gt;",
            "prefers-color-scheme:dark",
            "✗ not reached",
            "– not measured",
            "at most 1.22",
            "1.25",
            "moving objects",
            "not compared",
        ] {
            assert!(page.contains(text), "{text} is missing");
        }
        for outside in ["http-equiv", "<script", "<link", "src=\"h", "href=", "@import", "url("] {
            assert!(!page.contains(outside), "{outside} needs something else");
        }
        for tag in ["svg", "table", "figure", "td", "tr", "p", "div", "span", "details", "pre"] {
            let opened = page.matches(&format!("<{tag}>")).count()
                + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }

    #[test]
    fn tables_have_as_many_cells_in_every_row() {
        let reports = [
            measured("city", "street", 10_000, &[("ideal", 1.0), ("antumbra", 1.25)]),
            verified("city", "street", 500, &[("antumbra", 9, 0), ("ideal", 9, 0)]),
        ];
        let page = page(&ReportComparison::of(&reports)).unwrap();
        let text = page.markdown();
        let mut columns = 0;
        for line in text.lines() {
            let cells = line.matches(" |").count();
            if columns > 0 && cells > 0 {
                assert_eq!(cells, columns, "{line}");
            }
            columns = cells;
        }
        for row in [
            "| `antumbra` | 1.25 |",
            "| street 10k | antumbra / ideal | at most 1.22 | 1.25 | ✗ not reached |",
            "| street 40k | antumbra / ideal | at most 1.32 | not measured | – not measured |",
            "| 50 | 300 | 120 | 0 |",
            "| `antumbra` | exact | 0 in 9 frames | not compared | not compared | not compared |",
            "| `ideal` | exact | 0 in 9 frames | refused by design | not compared | refused by design |",
        ] {
            assert!(text.contains(row), "{row} is missing in\n{text}");
        }
    }
}
