//! Rules about the links between pages and files.

use crate::files::SourceFile;
use crate::{assert_catches, assert_obeyed, assert_permits};

/// A link of a page to a file or folder of the workspace.
struct Link<'a> {
    page: &'a SourceFile,
    line: usize,
    text: &'a str,
    /// The path from the workspace's root.
    path: String,
}

impl<'a> Link<'a> {
    /// Returns all links of all pages.
    fn all(files: &'a [SourceFile]) -> impl Iterator<Item = Self> {
        let pages = files.iter().filter(|file| file.extension() == "md");
        let lines = pages.flat_map(|page| {
            page.text.lines().enumerate().map(move |(line, text)| (page, line + 1, text))
        });
        lines.flat_map(|(page, line, text)| {
            let ends = text.match_indices("](").filter_map(move |(at, mark)| {
                let link_text = text[..at].rsplit('[').next()?;
                Some((link_text, text[at + mark.len()..].split(')').next()?))
            });
            let local = ends.filter(|(_, to)| !to.contains("://") && !to.starts_with('#'));
            local.map(move |(text, to)| Self { page, line, text, path: resolve(&page.path, to) })
        })
    }

    fn finding(&self, reason: &str) -> String {
        self.page.finding(self.line, reason)
    }
}

/// Returns the path of a link target, relative to its page.
fn resolve(page: &str, target: &str) -> String {
    let path = target.split('#').next().unwrap_or_default();
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in path.split('/').filter(|part| !part.is_empty()) {
        match part {
            ".." => parts.truncate(parts.len().saturating_sub(1)),
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// Finds links to files that do not exist.
pub fn ends(files: &[SourceFile]) -> Vec<String> {
    let exists = |path: &str| {
        let folder = format!("{path}/");
        files.iter().any(|file| file.path == path || file.path.starts_with(&folder))
    };
    let broken = Link::all(files).filter(|link| !exists(&link.path));
    broken.map(|link| link.finding(&format!("{} leads nowhere", link.path))).collect()
}

/// Finds links whose text is a number that is not the number of lines of code of their file, as
/// the pages count them: `grep -cvE '^\s*((//|/\*|\* |\*/).*|\*)?$' FILE`.
pub fn line_counts(files: &[SourceFile]) -> Vec<String> {
    let counted = Link::all(files).filter_map(|link| {
        let claimed: usize = link.text.parse().ok()?;
        let file = files.iter().find(|file| file.path == link.path)?;
        let is_code = |line: &&str| {
            let line = line.trim();
            let is_comment = ["//", "/*", "* ", "*/"].iter().any(|begin| line.starts_with(begin));
            !line.is_empty() && line != "*" && !is_comment
        };
        let count = file.text.lines().filter(is_code).count();
        (count != claimed).then(|| link.finding(&format!("{} has {count} lines", link.path)))
    });
    counted.collect()
}

#[test]
fn links_lead_somewhere() {
    assert_obeyed(ends);
    assert_catches(ends, &[("docs/a.md", "[b](../b.md) "), ("a.md", "see [c](d/e#f).")]);
    let files = [
        SourceFile::new("docs/a.md", "[b](../b/c.rs) and [folder](../b), [x](https://x.org/y)"),
        SourceFile::new("b/c.rs", ""),
    ];
    assert_eq!(ends(&files).len(), 0);
}

#[test]
fn programs_have_as_many_lines_as_the_pages_say() {
    assert_obeyed(line_counts);
    let found = |claim: &str| {
        let page = SourceFile::new("docs/a.md", &format!("| ours | [{claim}](../b.rs) |"));
        let code = "//! What.\n\n/* a\n *\n * b\n */\nfn a() {\n    // c\n    *b = 1;\n}\n";
        line_counts(&[page, SourceFile::new("b.rs", code)]).len()
    };
    assert_eq!([found("3"), found("4"), found("b")], [0, 1, 0]);
    assert_permits(line_counts, &[("a.md", "[12](https://x.org) [13](#c)")]);
}
