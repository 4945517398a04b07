//! The comparison as one HTML page that needs no other file: plots, tables, and the conditions of
//! the measurement.

use super::cases::ANTUMBRA;
use super::content::{Content, MethodRow};
use super::exactness::{Book, Setting};
use super::figures::{Figure, Verdict};
use super::palette;
use super::picture::escaped;
use super::plots::Plot;
use super::spread::{Spread, objects, short, thousands};
use super::thumbnails::Thumbnail;

/// Returns the page.
pub fn render(content: &Content) -> String {
    let mut body = head(content);
    body.push_str(&scenes(&content.thumbnails));
    if let Some(plot) = &content.ratios {
        body.push_str(&figure(plot));
    }
    body.push_str(&methods(content));
    body.push_str(&figures(content));
    if !content.plots.is_empty() {
        body.push_str("<h2>Frame by frame, CPU, tests, queries and draws</h2>\n");
    }
    for plot in &content.plots {
        body.push_str(&figure(plot));
    }
    body.push_str(&exactness(&content.books));
    body.push_str(&how_measured(content));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Antumbra: every method side by side</title>\n<style>\n{}{}</style>\n</head>\n\
         <body>\n{body}</body>\n</html>\n",
        include_str!("page.css"),
        swatches(),
    )
}

/// Returns the strategies' colours as the backgrounds of swatches, light and dark.
fn swatches() -> String {
    let rule = |name: &str, hex: String| format!(".s-{name}{{background:{hex}}}");
    let names = || palette::names();
    let light: String = names().map(|n| rule(n, palette::of_strategy(n).light_hex())).collect();
    let dark: String = names().map(|n| rule(n, palette::of_strategy(n).dark_hex())).collect();
    format!("{light}\n@media(prefers-color-scheme:dark){{{dark}}}\n")
}

fn head(content: &Content) -> String {
    let mut text = "<h1>Every method side by side</h1>\n".to_owned();
    if let Some(headline) = content.headline() {
        text.push_str(&format!("<p class=\"lead\">{}</p>\n", escaped(&headline)));
    }
    text.push_str(&format!(
        "<p class=\"faint\">{}; {}; {}</p>\n",
        escaped(&content.device),
        escaped(&content.frames),
        escaped(&content.days)
    ));
    text.push_str(&format!("<p class=\"steadiness\">{}.</p>\n", escaped(&content.steadiness)));
    for warning in &content.warnings {
        text.push_str(&format!("<p class=\"warning\">{}</p>\n", escaped(warning)));
    }
    text.push_str("<div class=\"cards\">\n");
    for (verdict, count) in content.verdicts().into_iter().filter(|(_, count)| *count > 0) {
        let what = match verdict {
            Verdict::Reached => "figures reached",
            Verdict::ReachedInMedian => "reached in the median",
            Verdict::Missed => "not reached",
            Verdict::Impossible => "impossible",
            Verdict::TooNoisy => "not judged: machine too busy",
            _ => "not measured",
        };
        let class = class_of(verdict);
        text.push_str(&format!(
            "<div class=\"card\"><b class=\"{class}\">{count}</b>{what}</div>\n"
        ));
    }
    let exact = |book: &&Book| book.is_exact && book.frames_compared > 0;
    let compared = || content.books.iter().filter(exact);
    let frames: u64 = compared().map(|book| book.frames_compared).sum();
    if frames > 0 {
        let pixels: u64 = compared().map(|book| book.pixels_wrong).sum();
        let class = if pixels == 0 { "reached" } else { "missed" };
        text.push_str(&format!(
            "<div class=\"card\"><b class=\"{class}\">{}</b>wrong pixels of exact strategies<br>\
             in {} compared frames</div>\n",
            thousands(pixels as f64),
            thousands(frames as f64)
        ));
    }
    text + "</div>\n"
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

fn figure(plot: &Plot) -> String {
    let caption = escaped(&plot.caption);
    format!("<figure>\n{}\n<figcaption>{caption}</figcaption>\n</figure>\n", plot.svg.trim())
}

fn swatch(name: &str) -> String {
    let name = escaped(name);
    format!("<span class=\"swatch s-{name}\"></span>{name}")
}

fn number(value: Option<&Spread>, text: impl Fn(&Spread) -> String) -> String {
    let text = value.map_or("-".to_owned(), text);
    format!("<td class=\"number\">{}</td>", escaped(&text))
}

/// Returns the median, and below it the spread.
fn ratio_cell(ratio: Option<&Spread>) -> String {
    let Some(ratio) = ratio.filter(|ratio| ratio.least() < ratio.most()) else {
        return number(ratio, Spread::to_string);
    };
    let [median, least, most] = [ratio.median(), ratio.least(), ratio.most()].map(short);
    format!("<td class=\"number\">{median}<span class=\"faint\">{least} to {most}</span></td>")
}

fn methods(content: &Content) -> String {
    let (Some(detail), false) = (content.detail_size, content.methods.is_empty()) else {
        return String::new();
    };
    let detail = objects(detail as f64);
    let mut text = format!(
        "<h2>The methods</h2>\n<p>Frame time on <i>street</i> in times of {}, by the number of \
         objects; CPU time, draws, boxes tested by all mechanisms and occlusion queries of a frame at \
         {detail} objects.</p>\n\
         <div class=\"scroll\"><table>\n<tr><th>strategy</th>",
        content.yardstick
    );
    for size in &content.sizes {
        text.push_str(&format!("<th class=\"number\">{}</th>", objects(*size as f64)));
    }
    for column in ["CPU ms", "draws", "boxes tested", "queries", "wrong pixels"] {
        text.push_str(&format!("<th class=\"number\">{column}</th>"));
    }
    text.push_str("</tr>\n");
    for row in &content.methods {
        text.push_str(&method(row));
    }
    text.push_str("</table></div>\n");
    if !content.left_out.is_empty() {
        text.push_str(&format!(
            "<p class=\"faint\">{}.</p>\n",
            escaped(&content.left_out.join(". "))
        ));
    }
    text
}

fn method(row: &MethodRow) -> String {
    let class = if row.strategy == ANTUMBRA { " class=\"ours\"" } else { "" };
    let mut text = format!("<tr{class}><td>{}</td>", swatch(&row.strategy));
    for (ratio, is_impossible) in row.ratios.iter().zip(&row.impossible) {
        let cell = ratio_cell(ratio.as_ref());
        let mark =
            if *is_impossible { "<span class=\"missed\">impossible</span></td>" } else { "</td>" };
        text.push_str(&cell.replace("</td>", mark));
    }
    text.push_str(&number(row.cpu_ms.as_ref(), |ms| short(ms.median())));
    text.push_str(&number(row.draws.as_ref(), |count| thousands(count.median())));
    text.push_str(&number(row.tests.as_ref(), |count| thousands(count.median())));
    text.push_str(&number(row.queries.as_ref(), |count| thousands(count.median())));
    let wrong =
        row.pixels_wrong.map_or("not compared".to_owned(), |pixels| thousands(pixels as f64));
    text + &format!("<td class=\"number\">{wrong}</td></tr>\n")
}

fn class_of(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Reached => "reached",
        Verdict::ReachedInMedian => "nearly",
        Verdict::Missed => "missed",
        Verdict::Impossible => "missed",
        Verdict::TooNoisy | Verdict::NotMeasured | Verdict::Shown => "open",
    }
}

fn figures(content: &Content) -> String {
    let mut text = "<h2>Goals and results</h2>\n\
        <p>Found: the median of the repetitions and, in brackets, their spread. Ratios are medians of \
        the ratios frame by frame.</p>\n<div class=\"scroll\"><table>\n\
        <tr><th>case</th><th>figure</th><th>asked</th><th class=\"number\">found</th><th></th></tr>\n"
        .to_owned();
    for figure in &content.figures {
        text.push_str(&figure_row(figure));
    }
    text + "</table></div>\n"
}

fn figure_row(figure: &Figure) -> String {
    let note = if figure.note.is_empty() {
        String::new()
    } else {
        format!("<span class=\"faint\">{}</span>", escaped(&figure.note))
    };
    let verdict = figure.verdict();
    format!(
        "<tr><td>{}</td><td>{}{note}</td><td>{}</td><td class=\"number\">{}</td>\
         <td class=\"mark {}\">{}</td></tr>\n",
        escaped(&figure.case),
        escaped(&figure.what),
        figure.asked_words(),
        figure.found_words(),
        class_of(verdict),
        verdict.words(),
    )
}

fn exactness(books: &[Book]) -> String {
    let mut text =
        "<h2>Wrong pixels</h2>\n<p>Pixels that differ from the picture of plain frustum \
        culling, bit for bit, in all compared frames together.</p>\n<div class=\"scroll\"><table>\n\
        <tr><th>strategy</th><th>promises</th>"
            .to_owned();
    for setting in Setting::ALL {
        text.push_str(&format!("<th class=\"number\">{}</th>", setting.name()));
    }
    text.push_str("</tr>\n");
    for book in books.iter().filter(|book| book.setting == Setting::Still) {
        let promise = if book.is_exact { "exact" } else { "nothing" };
        text.push_str(&format!("<tr><td>{}</td><td>{promise}</td>", swatch(&book.strategy)));
        for setting in Setting::ALL {
            let same = |other: &&Book| other.strategy == book.strategy && other.setting == setting;
            text.push_str(&wrong_pixels(books.iter().find(same)));
        }
        text.push_str("</tr>\n");
    }
    text + "</table></div>\n"
}

fn wrong_pixels(book: Option<&Book>) -> String {
    if book.is_some_and(|book| book.is_refused) {
        return "<td class=\"number open\">refused by design</td>".to_owned();
    }
    let Some(book) = book.filter(|book| book.frames_compared > 0) else {
        return "<td class=\"number open\">not compared</td>".to_owned();
    };
    let class = match (book.pixels_wrong, book.is_exact) {
        (0, _) => "reached",
        (_, true) => "missed",
        (_, false) => "open",
    };
    format!(
        "<td class=\"number\"><b class=\"{class}\">{}</b> \
         <span class=\"faint\">in {} frames</span></td>",
        thousands(book.pixels_wrong as f64),
        thousands(book.frames_compared as f64)
    )
}

fn how_measured(content: &Content) -> String {
    let lines: Vec<String> = content
        .commands
        .iter()
        .map(|(file, command)| {
            let command = if command.is_empty() { "not recorded" } else { command };
            format!("{}: {}", escaped(file), escaped(command))
        })
        .collect();
    format!(
        "<h2>Measurement</h2>\n<p>{}. {}. {}.</p>\n\
         <p>The strategies of a walk take turns in short rounds of consecutive frames, each after \
         some frames that do not count. A case is measured in two walks: plain frustum culling \
         leaves the caches cold for those that follow it, so it has one of its own with the ideal, \
         which ties the two together.</p>\n\
         <details><summary>The {} command lines</summary>\n<pre>{}</pre></details>\n",
        escaped(&content.device),
        escaped(&content.frames),
        escaped(&content.days),
        lines.len(),
        lines.join("\n")
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
        let page = render(&Content::of(&reports).unwrap());
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
}
