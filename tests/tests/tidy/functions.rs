//! The rule that a function can be read as one: its length.

use crate::files::SourceFile;
use crate::modules::product_code;

/// The most lines of a function.
const MAX_LINES: usize = 70;

/// The file of the frame, and the most lines of a function there: the frame is read first.
const FRAME: (&str, usize) = ("engine/render/src/api/render.rs", 60);

/// Finds functions that are too long. The formatter puts a function's last brace below the
/// beginning of its first line.
pub fn long_functions(files: &[SourceFile]) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, code) in product_code(files) {
        let most = if path == FRAME.0 { FRAME.1 } else { MAX_LINES };
        let lines: Vec<&str> = code.lines().collect();
        for (first, line) in lines.iter().enumerate().filter(|(_, line)| begins_function(line)) {
            let indent = &line[..line.len() - line.trim_start().len()];
            let is_last = |line: &&str| line.strip_prefix(indent) == Some("}");
            let count = lines[first..].iter().position(is_last).map_or(1, |last| last + 1);
            let has_body = lines[first..].iter().take(count).any(|line| line.ends_with('{'));
            if has_body && count > most {
                let what = format!("{count} lines of function, at most {most} may be");
                findings.push(format!("{path}:{}: {what}", first + 1));
            }
        }
    }
    findings
}

/// Returns true for the first line of a function that does not end on it.
fn begins_function(line: &str) -> bool {
    let is_qualifier = |word: &&str| {
        matches!(*word, "const" | "unsafe" | "async" | "extern") || word.starts_with("pub")
    };
    let first = line.split_whitespace().find(|word| !is_qualifier(word));
    first == Some("fn") && !line.ends_with([';', '}'])
}
