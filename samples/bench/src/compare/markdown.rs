//! The comparison as Markdown: the tables, for READMEs and notes.

use super::content::Content;
use super::exactness::{Book, Setting};
use super::spread::{Spread, objects, short, thousands};

/// Returns the tables, with the device and the frames of the measurement.
pub fn render(content: &Content) -> String {
    let mut text = "# Every method side by side\n\n".to_owned();
    if let Some(headline) = content.headline() {
        text.push_str(&format!("{headline}\n\n"));
    }
    text.push_str(&format!("{}; {}; {}.\n", content.device, content.frames, content.days));
    text.push_str(&format!("\n{}.\n", content.steadiness));
    for warning in &content.warnings {
        text.push_str(&format!("\n**{warning}**\n"));
    }
    text.push_str(&methods(content));
    text.push_str(&figures(content));
    text + &exactness(&content.books)
}

/// Returns a row of a table; bars are escaped, since within cells they would end them.
fn row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

fn head(columns: &[String]) -> String {
    row(columns) + &row(&columns.iter().map(|_| "---".to_owned()).collect::<Vec<_>>())
}

fn methods(content: &Content) -> String {
    let (Some(detail), false) = (content.detail_size, content.methods.is_empty()) else {
        return String::new();
    };
    let mut text = format!(
        "\n## The methods\n\nFrame time on `street` in times of `{}`, by the number of objects; CPU \
         time, draws, boxes tested by all mechanisms and occlusion queries of a frame at {} objects.\n\n",
        content.yardstick,
        objects(detail as f64)
    );
    let mut columns = vec!["strategy".to_owned()];
    columns.extend(content.sizes.iter().map(|size| objects(*size as f64)));
    columns
        .extend(["CPU ms", "draws", "boxes tested", "queries", "wrong pixels"].map(str::to_owned));
    text.push_str(&head(&columns));
    let shown = |value: &Option<Spread>, text: fn(f64) -> String| {
        value.as_ref().map_or("-".to_owned(), |value| text(value.median()))
    };
    for method in &content.methods {
        let mut cells = vec![format!("`{}`", method.strategy)];
        let ratio =
            |ratio: &Option<Spread>| ratio.as_ref().map_or("-".to_owned(), Spread::to_string);
        let marked = |(value, is_impossible): (&Option<Spread>, &bool)| {
            if *is_impossible { ratio(value) + " (impossible)" } else { ratio(value) }
        };
        cells.extend(method.ratios.iter().zip(&method.impossible).map(marked));
        cells.push(shown(&method.cpu_ms, short));
        cells.push(shown(&method.draws, thousands));
        cells.push(shown(&method.tests, thousands));
        cells.push(shown(&method.queries, thousands));
        let wrong = method.pixels_wrong.map(|pixels| thousands(pixels as f64));
        cells.push(wrong.unwrap_or_else(|| "not compared".to_owned()));
        text.push_str(&row(&cells));
    }
    for sentence in &content.left_out {
        text.push_str(&format!("\n{sentence}.\n"));
    }
    text
}

fn figures(content: &Content) -> String {
    let mut text = "\n## Goals and results\n\nFound: the median of the \
        repetitions and, in brackets, their spread.\n\n"
        .to_owned();
    let columns = ["case", "figure", "asked", "found", "", "note"];
    text.push_str(&head(&columns.map(str::to_owned)));
    for figure in &content.figures {
        text.push_str(&row(&[
            figure.case.clone(),
            figure.what.clone(),
            figure.asked_words(),
            figure.found_words(),
            figure.verdict().words().to_owned(),
            figure.note.clone(),
        ]));
    }
    text
}

fn exactness(books: &[Book]) -> String {
    let mut text = "\n## Wrong pixels\n\n".to_owned();
    let mut columns = vec!["strategy".to_owned(), "promises".to_owned()];
    columns.extend(Setting::ALL.map(|setting| setting.name().to_owned()));
    text.push_str(&head(&columns));
    for book in books.iter().filter(|book| book.setting == Setting::Still) {
        let promise = if book.is_exact { "exact" } else { "nothing" };
        let mut cells = vec![format!("`{}`", book.strategy), promise.to_owned()];
        for setting in Setting::ALL {
            let same = |other: &&Book| other.strategy == book.strategy && other.setting == setting;
            cells.push(wrong_pixels(books.iter().find(same)));
        }
        text.push_str(&row(&cells));
    }
    text
}

fn wrong_pixels(book: Option<&Book>) -> String {
    match book {
        Some(book) if book.is_refused => "refused by design".to_owned(),
        Some(book) if book.frames_compared > 0 => {
            let pixels = book.pixels_wrong;
            let frames = book.frames_compared;
            format!("{} in {} frames", thousands(pixels as f64), thousands(frames as f64))
        }
        _ => "not compared".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{measured, verified};
    use super::*;

    #[test]
    fn tables_have_as_many_cells_in_every_row() {
        let reports = [
            measured("city", "street", 10_000, &[("ideal", 1.0), ("antumbra", 1.25)]),
            verified("city", "street", 500, &[("antumbra", 9, 0), ("ideal", 9, 0)]),
        ];
        let text = render(&Content::of(&reports).unwrap());
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
