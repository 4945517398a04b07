//! Pages as data: written as Markdown for READMEs, or as HTML that needs no other file.

use std::ops::Range;

/// A page, in both forms. In its texts, words between backticks are code.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ResultPage {
    title: String,
    markdown: String,
    html: String,
}

/// The weight of a paragraph; its name is a class of the style sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Normal text.
    Plain,
    /// The result, before all else.
    Lead,
    /// Less prominent conditions.
    Faint,
    /// A reason to doubt the rest.
    Warning,
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The headings of its columns.
    pub columns: Vec<String>,
    /// The columns that are numbers.
    pub numbers: Range<usize>,
    /// Its rows, with a cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cell {
    /// Its text.
    pub text: String,
    /// Details: after the text, in HTML smaller and below it; may be empty.
    pub detail: String,
    /// A class of the style sheet; may be empty.
    pub class: &'static str,
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self { text, ..Self::default() }
    }
}

/// The class of cells with the name of a strategy, which have a swatch of its colour in HTML.
const STRATEGY: &str = "strategy";

impl Cell {
    /// Returns the name of a strategy.
    pub fn strategy(name: &str) -> Self {
        Self { text: format!("`{name}`"), class: STRATEGY, ..Self::default() }
    }

    fn markdown(&self) -> String {
        // A bar would end the cell.
        format!("{} {}", self.text, self.detail).trim_end().replace('|', "\\|")
    }

    fn html(&self, is_number: bool) -> String {
        let number = if is_number { "number " } else { "" };
        let class = self.class;
        let text = match self.text.trim_matches('`') {
            name if class == STRATEGY => {
                let name = escaped(name);
                format!("<span class=\"swatch s-{name}\"></span>{name}")
            }
            _ => inline(&self.text),
        };
        let detail = if self.detail.is_empty() {
            String::new()
        } else {
            format!("<span class=\"faint\">{}</span>", inline(&self.detail))
        };
        format!("<td class=\"{number}{class}\">{text}{detail}</td>")
    }
}

impl Table {
    /// Creates a table of plain cells.
    pub fn of(columns: &[&str], rows: Vec<Vec<String>>) -> Self {
        let columns = columns.iter().map(|&column| column.to_owned()).collect();
        let cells = |row: Vec<String>| row.into_iter().map(Cell::from).collect();
        Self { columns, numbers: 0..0, rows: rows.into_iter().map(cells).collect() }
    }

    fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let rule = vec!["---".to_owned(); self.columns.len()];
        let rows = self.rows.iter().map(|row| line(row.iter().map(Cell::markdown).collect()));
        line(self.columns.clone()) + &line(rule) + &rows.collect::<String>()
    }

    fn html(&self) -> String {
        let is_number = |column: usize| self.numbers.contains(&column);
        let head = |(column, text): (usize, &String)| {
            let class = if is_number(column) { " class=\"number\"" } else { "" };
            format!("<th{class}>{}</th>", escaped(text))
        };
        let row = |row: &Vec<Cell>| {
            let cells = row.iter().enumerate();
            let cells: String = cells.map(|(column, cell)| cell.html(is_number(column))).collect();
            format!("<tr>{cells}</tr>\n")
        };
        let heads: String = self.columns.iter().enumerate().map(head).collect();
        let rows: String = self.rows.iter().map(row).collect();
        format!("<div class=\"scroll\"><table>\n<tr>{heads}</tr>\n{rows}</table></div>\n")
    }
}

impl ResultPage {
    /// Creates a page with nothing below its title.
    pub fn new(title: &str) -> Self {
        let markdown = format!("# {title}\n");
        Self { title: title.to_owned(), markdown, html: String::new() }
    }

    /// Adds the title of a section.
    pub fn heading(&mut self, text: &str) {
        self.markdown += &format!("\n## {text}\n");
        self.html += &format!("<h2>{}</h2>\n", inline(text));
    }

    /// Adds a paragraph; to a page that is written as Markdown alone, any Markdown.
    pub fn text(&mut self, tone: Tone, text: &str) {
        let mark = if tone == Tone::Warning { "**" } else { "" };
        self.markdown += &format!("\n{mark}{text}{mark}\n");
        let class = format!("{tone:?}").to_lowercase();
        self.html += &format!("<p class=\"{class}\">{}</p>\n", inline(text));
    }

    /// Adds a table.
    pub fn table(&mut self, table: &Table) {
        self.markdown += &format!("\n{}", table.markdown());
        self.html += &table.html();
    }

    /// Adds HTML that Markdown leaves out.
    pub fn html_only(&mut self, html: &str) {
        self.html += html;
    }

    /// Returns the page as Markdown.
    pub fn markdown(&self) -> &str {
        &self.markdown
    }

    /// Returns the page as HTML, with `style` added to the style sheet of all pages.
    pub fn html(&self, style: &str) -> String {
        include_str!("result_page/page.html")
            .replace("{title}", &escaped(&self.title))
            .replace("{style}", &format!("{}{style}", include_str!("result_page/page.css")))
            .replace("{body}", &self.html)
    }
}

/// Returns a text as HTML, with code where it was between backticks.
fn inline(text: &str) -> String {
    let pieces = text.split('`').map(escaped).enumerate();
    let tagged = pieces.map(|(place, piece)| match place % 2 {
        0 => piece,
        _ => format!("<code>{piece}</code>"),
    });
    tagged.collect()
}

/// Returns the text escaped for XML and HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_say_the_same_and_escape_what_is_theirs() {
        let mut page = ResultPage::new("A & B");
        page.heading("Some `code`");
        page.text(Tone::Warning, "a <b>");
        let ratio = Cell { text: "x|y".to_owned(), detail: "(1 to 2)".to_owned(), class: "missed" };
        let rows = vec![vec![Cell::strategy("antumbra"), ratio]];
        let columns = ["strategy", "ratio"].map(str::to_owned).to_vec();
        page.table(&Table { columns, numbers: 1..2, rows });
        page.html_only("<svg></svg>\n");
        let markdown = "# A & B\n\n## Some `code`\n\n**a <b>**\n\n| strategy | ratio |\n| --- | --- |\n\
                        | `antumbra` | x\\|y (1 to 2) |\n";
        assert_eq!(page.markdown(), markdown);
        let html = page.html(".s{}");
        for part in [
            "<title>A &amp; B</title>",
            ".s{}</style>",
            "<h1>A &amp; B</h1>",
            "<h2>Some <code>code</code></h2>",
            "<p class=\"warning\">a &lt;b&gt;</p>",
            "<th>strategy</th><th class=\"number\">ratio</th>",
            "<td class=\"strategy\"><span class=\"swatch s-antumbra\"></span>antumbra</td>",
            "<td class=\"number missed\">x|y<span class=\"faint\">(1 to 2)</span></td>",
            "<svg></svg>",
        ] {
            assert!(html.contains(part), "{part} is missing in\n{html}");
        }
    }
}
